//! The table `[[patch]]`: paint on the ground, made of ellipses.

use glam::DVec2;
use hedgehop::voxel::Material;
use hedgehop_base::document::Reading;
use toml::Spanned;

use super::fields::Fields;
use super::values::{AZIMUTH, HALF, KindWord, LENGTH, NumberRange, SHARE};
use crate::Materials;
use crate::features::WATER;
use crate::synthetic::{EllipsePiece, GroundPatch, PaintCoat, Sector, TouchdownZone, bomb_circle, lake};

/// Rings of a bomb circle, where its table does not say.
const RINGS: u32 = 4;

/// Most rings, and most marks.
const MOST_RINGS: u32 = 100;
const MOST_MARKS: u32 = 10_000;

/// Colour of rubber on a runway, sRGB, and how much of it is seen.
const RUBBER: [u8; 3] = [38, 37, 36];
const RUBBED: f64 = 0.6;

/// Priorities go so far either way.
const MOST_PRIORITY: i64 = 1000;

const SWEEP: NumberRange = NumberRange::new(
    |degrees| degrees > 0.0 && degrees <= 360.0,
    "must be more than 0 and at most 360 degrees",
);

#[derive(Clone, Copy)]
enum PatchKind {
    Ellipse,
    BombCircle,
    TyreMarks,
    Lake,
}

const KINDS: [KindWord<PatchKind>; 4] = [
    KindWord { word: "ellipse", kind: PatchKind::Ellipse },
    KindWord { word: "bomb_circle", kind: PatchKind::BombCircle },
    KindWord { word: "tyre_marks", kind: PatchKind::TyreMarks },
    KindWord { word: "lake", kind: PatchKind::Lake },
];

/// Paint of one kind: its coats, what it is made of, and how much of it is seen where its table does not say.
struct PatchPaint {
    coats: Vec<PaintCoat>,
    material: Option<Material>,
    strength: f64,
}

/// Reads a patch; `None`: something is wrong with it.
pub(super) fn patch(mut table: Fields<'_, '_, '_>, known: &Materials) -> Option<GroundPatch> {
    // Without its kind nobody knows which keys it has.
    let kind = if table.has("kind") { table.kind(KINDS, "\"ellipse\"")? } else { PatchKind::Ellipse };
    table.known("kind");
    let material = table.material(known);
    let priority = priority(&mut table);
    let paint = match kind {
        PatchKind::Ellipse => ellipse(&mut table, material),
        PatchKind::BombCircle => rings(&mut table),
        PatchKind::TyreMarks => marks(&mut table),
        PatchKind::Lake => water(&mut table),
    };

    let usual = paint.as_ref().map_or(1.0, |paint| paint.strength);
    let strength = table.number_or("strength", usual, SHARE) as f32;
    table.finish();
    let PatchPaint { coats, material: own, .. } = paint?;
    Some(GroundPatch { coats, material: material.or(own), strength, priority: priority? })
}

fn priority(table: &mut Fields<'_, '_, '_>) -> Option<i32> {
    let Some(priority) = table.take::<i64>("priority") else { return Some(0) };
    let number = *priority.get_ref();
    let holds = number.unsigned_abs() <= MOST_PRIORITY.unsigned_abs();
    let wanted = || format!("priority must be −{MOST_PRIORITY} to {MOST_PRIORITY}, not {number}");
    table.mistakes.check(&priority.span(), if holds { Ok(number as i32) } else { Err(wanted()) })
}

/// Reads an ellipse, a ring or an arc. Its colour may be that of its material.
fn ellipse(table: &mut Fields<'_, '_, '_>, material: Option<Material>) -> Option<PatchPaint> {
    let centre = centre(table);
    let radii = radii(table, ["radius_m", "radii_m"]);
    let has_radii = table.has("inner_radius_m") || table.has("inner_radii_m");
    let span = table.span_of("inner_radii_m").or(table.span_of("inner_radius_m"));
    let inner = if has_radii {
        radii_if(table, ["inner_radius_m", "inner_radii_m"]).map(Some)
    } else {
        ["inner_radius_m", "inner_radii_m"].into_iter().for_each(|key| table.known(key));
        Some(None)
    };
    let azimuth_deg = table.number_or("azimuth_deg", 0.0, AZIMUTH);

    let sector = match (table.has("from_deg"), table.has("sweep_deg")) {
        (false, false) => {
            ["from_deg", "sweep_deg"].into_iter().for_each(|key| table.known(key));
            Some(None)
        }
        _ => {
            let from = table.needed("from_deg", "90", AZIMUTH);
            let sweep = table.needed("sweep_deg", "45", SWEEP);
            from.zip(sweep)
                .map(|(from_deg, width_deg)| (width_deg < 360.0).then_some(Sector { from_deg, width_deg }))
        }
    };

    let fade = table.take::<f64>("fade_m");
    let colour = table.take::<String>("colour");
    if colour.is_none() && material.is_none() {
        let what = "a patch needs colour or material, as in colour = \"#f2f2ee\"";
        table.mistakes.add(&table.span(), what);
        return None;
    }
    let colour = match colour {
        Some(text) => Some(table.colour(&text)?),
        None => None,
    };

    let (radii, inner) = (radii?, inner?);
    if let (Some(inner), Some(span)) = (inner, span)
        && !inner.cmplt(radii).all()
    {
        table
            .mistakes
            .add(&span, "what is left out in the middle must be smaller than the patch, either way");
        return None;
    }
    let fade_m = fade.as_ref().map_or(0.0, |fade| *fade.get_ref());
    let widest = (radii - inner.unwrap_or_default()).min_element();
    if let Some(fade) = fade.filter(|fade| !(0.0..widest).contains(fade.get_ref())) {
        let what =
            format!("fade_m must be 0 to less than {widest} m, from rim to rim of the patch, not {fade_m}");
        table.mistakes.add(&fade.span(), what);
        return None;
    }
    let piece = EllipsePiece { centre: centre?, radii, azimuth_deg, inner, sector: sector?, fade_m };
    Some(PatchPaint { coats: vec![PaintCoat { pieces: vec![piece], colour }], material: None, strength: 1.0 })
}

fn centre(table: &mut Fields<'_, '_, '_>) -> Option<DVec2> {
    let centre = table.need::<Vec<f64>>("centre", "[4000, 4000]")?;
    table.place("centre", &centre)
}

/// Half axes: one key for a circle, the other for both.
fn radii(table: &mut Fields<'_, '_, '_>, [circle, both]: [&'static str; 2]) -> Option<DVec2> {
    if !table.has(both) && !table.has(circle) {
        let what = format!("a patch needs {circle}, or {both} = [right, forward]");
        table.mistakes.add(&table.span(), what);
        [circle, both].into_iter().for_each(|key| table.known(key));
        return None;
    }
    radii_if(table, [circle, both])
}

/// Half axes of which one of both keys is there.
fn radii_if(table: &mut Fields<'_, '_, '_>, [circle, both]: [&'static str; 2]) -> Option<DVec2> {
    if table.has(circle) && table.has(both) {
        table.refuse(both, format!("give {circle} or {both}, not both"));
        [circle, both].into_iter().for_each(|key| drop(table.value(key)));
        return None;
    }
    if !table.has(both) {
        table.known(both);
        return table.needed(circle, "30", LENGTH).map(DVec2::splat);
    }
    table.known(circle);
    let lengths = table.take::<Vec<f64>>(both)?;
    let read = match lengths.get_ref().as_slice() {
        [right, forward] => {
            let checked = |metres| Reading::checked(both, metres, LENGTH.holds, LENGTH.want);
            checked(*right).and_then(|right| Ok(DVec2::new(right, checked(*forward)?)))
        }
        _ => Err(format!("{both} are two half axes, [right, forward] in metres")),
    };
    table.mistakes.check(&lengths.span(), read)
}

fn rings(table: &mut Fields<'_, '_, '_>) -> Option<PatchPaint> {
    let circle = table.circle();
    let rings = count(table, "rings", MOST_RINGS).unwrap_or(Some(RINGS));
    let texts = table.need::<Vec<Spanned<String>>>("colours", "[\"#f2f2ee\", \"#b03028\"]")?;
    let colours = texts.get_ref().iter().map(|text| table.colour(text)).collect::<Option<Vec<_>>>()?;
    if colours.is_empty() {
        table.mistakes.add(&texts.span(), "colours are one at least, from the outermost ring inward");
        return None;
    }
    Some(PatchPaint { coats: bomb_circle(circle?, rings?, &colours), material: None, strength: 1.0 })
}

fn marks(table: &mut Fields<'_, '_, '_>) -> Option<PatchPaint> {
    let centre = centre(table);
    let azimuth_deg = table.number_or("azimuth_deg", 0.0, AZIMUTH);
    let [length, width] =
        [("length_m", "500"), ("width_m", "20")].map(|(key, example)| table.needed(key, example, LENGTH));
    let count = count(table, "count", MOST_MARKS).unwrap_or(Some(60));
    let seed = table.seed();
    let colour = table.take::<String>("colour");
    let colour = colour.map_or(Some(RUBBER), |text| table.colour(&text));
    let zone = TouchdownZone {
        centre: centre?,
        azimuth_deg,
        length_m: length?,
        width_m: width?,
        count: count?,
        seed,
    };
    let coat = PaintCoat { pieces: zone.marks(), colour: Some(colour?) };
    Some(PatchPaint { coats: vec![coat], material: None, strength: RUBBED })
}

fn water(table: &mut Fields<'_, '_, '_>) -> Option<PatchPaint> {
    let circle = table.circle();
    let ragged = table.number_or("ragged", 0.3, HALF);
    let seed = table.seed();
    let colour = table.take::<String>("colour");
    let colour = colour.map_or(Some(WATER.colour), |text| table.colour(&text));
    let coat = PaintCoat { pieces: lake(circle?, ragged, seed), colour: Some(colour?) };
    Some(PatchPaint { coats: vec![coat], material: Some(Material::Water), strength: 1.0 })
}

/// Reads how many there are, from 1; the outer `None`: the table does not say.
fn count(table: &mut Fields<'_, '_, '_>, key: &'static str, most: u32) -> Option<Option<u32>> {
    let number = table.take::<u32>(key)?;
    let holds = (1..=most).contains(number.get_ref());
    let wanted = format!("{key} must be 1 to {most}, not {}", number.get_ref());
    Some(table.mistakes.check(&number.span(), if holds { Ok(*number.get_ref()) } else { Err(wanted) }))
}
