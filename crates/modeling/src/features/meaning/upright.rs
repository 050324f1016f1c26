//! Upright things: masts, towers, tanks, pylons; wires; walls, fences, hedges.

use super::super::kinds::{Barrier, Cap, Meaning, Paint, PowerLine, Structure, Upright, Wire};
use super::tags::Tags;
use super::{building, quantity};
use hedgehop::voxel::Material;

const STEEL: Paint = Paint { colour: [142, 148, 152], material: Material::Metal };
const CONCRETE: Paint = Paint { colour: [172, 170, 164], material: Material::Concrete };
const TANK: Paint = Paint { colour: [222, 222, 216], material: Material::Metal };

/// Share that a lattice hides of what is behind it.
const LATTICE: f64 = 0.35;

fn paint(tags: &mut Tags<'_>, otherwise: Paint) -> Paint {
    let columns = &tags.options.columns;
    tags.paint(
        [columns.colour.as_ref(), columns.material.as_ref()],
        &["colour", "color"],
        &["material"],
        otherwise,
    )
}

/// Interprets a row of `man_made`; `None` for what does not stand upright.
pub(super) fn man_made(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let lattice = tags.is("tower:construction", &["lattice", "guyed_lattice"]);
    let cooling = tags.is("tower:type", &["cooling"]);

    // Height, diameter, taper, cap, opacity, paint.
    let (height, diameter, taper, cap, opacity, usual) = match kind {
        "mast" | "communications_tower" | "antenna" => {
            (40.0, 1.5, 0.5, Cap::Flat, if lattice { LATTICE } else { 1.0 }, STEEL)
        }
        "tower" | "cooling_tower" if cooling || kind == "cooling_tower" => {
            (100.0, 80.0, 0.65, Cap::Waisted, 1.0, CONCRETE)
        }
        "tower" if lattice => (40.0, 6.0, 0.3, Cap::Flat, LATTICE, STEEL),
        "tower" | "water_tower" | "lighthouse" => (25.0, 6.0, 0.85, Cap::Flat, 1.0, CONCRETE),
        "chimney" => {
            (50.0, 4.0, 0.6, Cap::Flat, 1.0, Paint { colour: [164, 120, 104], material: Material::Brick })
        }
        "storage_tank" | "tank" => (12.0, 15.0, 1.0, Cap::Flat, 1.0, TANK),
        "gasometer" => (30.0, 30.0, 1.0, Cap::Dome, 1.0, TANK),
        "silo" => (15.0, 5.0, 1.0, Cap::Cone, 1.0, TANK),
        "flagpole" | "street_cabinet_mast" => (10.0, 0.2, 0.6, Cap::Flat, 1.0, STEEL),
        _ => return None,
    };

    let usual = Upright { height_m: height, diameter_m: Some(diameter), taper, cap, opacity, paint: usual };
    let round = upright(tags, usual);

    // What lets light through, or is waisted, has no straight walls to draw.
    if !tags.has_area() || opacity < 1.0 || cap == Cap::Waisted {
        return Some(Meaning::Upright(round));
    }

    Some(Meaning::Structure(Structure { round, walled: building::structure(tags, &usual) }))
}

/// One as usual, with what the row says of itself.
fn upright(tags: &mut Tags<'_>, usual: Upright) -> Upright {
    let columns = &tags.options.columns;
    let height_m = tags.length(columns.height.as_ref(), &["height", "est_height"]).unwrap_or(usual.height_m);
    let said = tags.length(columns.diameter.as_ref(), &["diameter", "width"]);
    let diameter_m = if tags.has_area() { said } else { said.or(usual.diameter_m) };
    let cap = match tags.word("roof:shape").as_deref() {
        Some("flat") => Cap::Flat,
        Some("dome" | "round") => Cap::Dome,
        Some("cone" | "conical" | "pyramidal") => Cap::Cone,
        _ => usual.cap,
    };
    Upright { height_m, diameter_m, cap, paint: paint(tags, usual.paint), ..usual }
}

/// Height of pylons, length of their arms, number of wires and sag per square of the span, by volts.
fn usual_line(volts: f64) -> (f64, f64, usize, f64) {
    match volts {
        300_000.0.. => (50.0, 12.0, 6, 8.5e-5),
        200_000.0.. => (40.0, 9.0, 6, 9e-5),
        60_000.0.. => (28.0, 5.0, 3, 1e-4),
        10_000.0.. => (12.0, 1.2, 3, 1.6e-4),
        _ => (8.5, 0.7, 3, 2.5e-4),
    }
}

/// Places the wires of a line: up to three on one level, six on two, each side alike; high lines have one more on top, against
/// lightning.
fn wires(count: usize, height_m: f64, arm_m: f64, volts: f64) -> Vec<Wire> {
    let mut wires = Vec::new();
    let level = |wires: &mut Vec<Wire>, count: usize, height_m: f64, reach: f64| {
        let step = if count > 1 { 2.0 * reach / (count - 1) as f64 } else { 0.0 };
        let first = if count > 1 { -reach } else { 0.0 };
        wires.extend((0..count).map(|index| Wire { offset_m: first + step * index as f64, height_m }));
    };

    // Insulators hang from the arms.
    let (lower, upper) = (0.72 * height_m, 0.88 * height_m);
    if volts < 60_000.0 {
        level(&mut wires, count, height_m, arm_m);
    } else if count <= 4 {
        level(&mut wires, count, upper, arm_m);
    } else {
        let below = count.div_ceil(6) * 4 - if count % 2 == 1 { 1 } else { 0 };
        let below = below.min(count);
        level(&mut wires, below, lower, arm_m);
        level(&mut wires, count - below, upper, 0.7 * arm_m);
    }

    if volts >= 60_000.0 {
        wires.push(Wire { offset_m: 0.0, height_m });
    }

    wires
}

/// A line or pylon of `power`; `None` for other things of it.
pub(super) fn power(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let volts = tags.text("voltage").and_then(|text| quantity::voltage(&text));
    let columns = &tags.options.columns;
    let (volts, is_line) = match kind {
        "line" => (volts.unwrap_or(110_000.0), true),
        "minor_line" => (volts.unwrap_or(1000.0), true),
        "tower" | "" => (volts.unwrap_or(110_000.0), false),
        "pole" | "portal" => (volts.unwrap_or(1000.0), false),
        _ => return None,
    };

    let (usual_height, arm_m, usual_count, sag_per_m) = usual_line(volts);
    let stated = tags.length(columns.height.as_ref(), &["height"]);
    let height_m = stated.unwrap_or(usual_height);
    let is_tall = volts >= 60_000.0;

    let pylon = if is_tall {
        Upright {
            height_m,
            diameter_m: Some(0.16 * height_m),
            taper: 0.15,
            cap: Cap::Flat,
            opacity: LATTICE,
            paint: STEEL,
        }
    } else {
        let wood = Paint { colour: [112, 92, 70], material: Material::Wood };
        Upright { height_m, diameter_m: Some(0.3), taper: 0.7, cap: Cap::Flat, opacity: 1.0, paint: wood }
    };

    if !is_line {
        let pylon = Upright { paint: paint(tags, pylon.paint), ..pylon };
        return Some(Meaning::Pylon(pylon, stated.is_some()));
    }

    let count = tags.count(None, &["cables"], &(1.0..=36.0)).unwrap_or(usual_count as f64) as usize;
    let wires = wires(count, height_m, arm_m, volts);
    Some(Meaning::PowerLine(PowerLine { wires, sag_per_m, pylon, stated: Vec::new() }))
}

/// A wall, fence or hedge; `None` for other barriers.
pub(super) fn barrier(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let (height, thickness, opacity, usual) = match kind {
        "wall" | "retaining_wall" => {
            (2.0, 0.4, 1.0, Paint { colour: [158, 150, 136], material: Material::Stone })
        }
        "city_wall" => (8.0, 2.0, 1.0, Paint { colour: [156, 146, 128], material: Material::Stone }),
        "jersey_barrier" | "block" => (0.9, 0.5, 1.0, CONCRETE),
        "guard_rail" => (0.75, 0.2, 0.6, STEEL),
        "fence" => (1.5, 0.1, 0.3, Paint { colour: [128, 118, 102], material: Material::Wood }),
        "hedge" => (1.8, 1.2, 1.0, Paint { colour: [74, 92, 48], material: Material::Broadleaf }),
        _ => return None,
    };
    let columns = &tags.options.columns;
    let height_m = tags.length(columns.height.as_ref(), &["height", "est_height"]).unwrap_or(height);
    let thickness_m = tags.length(columns.width.as_ref(), &["width", "thickness"]).unwrap_or(thickness);
    // What light passes stands along an outline all the same.
    let is_filled = tags.has_area() && opacity >= 1.0 && tags.yes("area").is_some();
    Some(Meaning::Barrier(Barrier { height_m, thickness_m, opacity, paint: paint(tags, usual), is_filled }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wires_hang_alike_on_both_sides() {
        for count in 1..=36 {
            for volts in [400.0, 110_000.0] {
                let wires = wires(count, 30.0, 6.0, volts);
                assert_eq!(wires.len(), count + usize::from(volts > 60_000.0));
                assert!(
                    wires.iter().map(|wire| wire.offset_m).sum::<f64>().abs() < 1e-9,
                    "{count}: {wires:?}"
                );
                assert!(wires.iter().all(|wire| wire.height_m > 20.0 && wire.offset_m.abs() <= 6.0));
            }
        }
    }
}
