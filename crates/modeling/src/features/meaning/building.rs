//! Buildings and their parts: OpenStreetMap's *Simple 3D Buildings* (wiki, 2024).

use super::super::kinds::{Building, Cap, FacadeKind, Meaning, Paint, Rise, Roof, RoofShape, Top, Upright};
use super::colours::{mix, share};
use super::quantity;
use super::tags::{LENGTHS, Tags};
use hedgehop::voxel::{FacadeStyle, Material};

/// Height of a level, metres.
const LEVEL: f64 = 3.0;
/// Most levels.
const LEVELS: std::ops::RangeInclusive<f64> = 0.0..=300.0;
/// Angle of roofs that do not say theirs, degrees.
const USUAL_ANGLE: f64 = 35.0;
/// Largest dome's share of the building, where nothing is said.
const DOME: f64 = 0.4;

/// Levels, whether its roof is pitched, and façade of a kind of building.
fn usual(kind: &str) -> (f64, bool, Material, [u8; 3]) {
    match kind {
        "house" | "detached" | "semidetached_house" | "terrace" | "bungalow" | "farm" | "residential" => {
            (2.0, true, Material::Plaster, [214, 204, 186])
        }
        "apartments" | "dormitory" | "hotel" => (4.0, false, Material::Plaster, [204, 196, 182]),
        "garage" | "garages" | "carport" | "shed" | "hut" | "roof" | "kiosk" => {
            (0.9, false, Material::Concrete, [170, 164, 154])
        }
        "barn" | "farm_auxiliary" | "stable" | "cowshed" | "cabin" => {
            (1.7, true, Material::Wood, [128, 104, 78])
        }
        "church" | "chapel" | "cathedral" | "monastery" => (4.0, true, Material::Stone, [196, 186, 166]),
        "industrial" | "warehouse" | "hangar" | "manufacture" | "supermarket" | "retail" => {
            (2.5, false, Material::Metal, [176, 178, 178])
        }
        "commercial" | "office" | "hospital" | "university" | "government" => {
            (4.0, false, Material::Concrete, [184, 182, 176])
        }
        "greenhouse" => (1.2, true, Material::Glass, [168, 186, 186]),
        "school" | "kindergarten" | "civic" | "public" | "train_station" => {
            (2.5, true, Material::Brick, [182, 132, 106])
        }
        _ => (2.0, true, Material::Plaster, [204, 194, 178]),
    }
}

/// Finds the façades of a kind of building by its levels and material; `None`: walls are plain.
fn style(kind: &str, levels: Option<f64>, material: Material) -> Option<FacadeStyle> {
    /// Levels from which on a house is one of many flats.
    const FLATS: f64 = 4.0;

    let is_high = levels.is_some_and(|levels| levels >= FLATS);
    Some(match kind {
        "house" | "detached" | "semidetached_house" | "terrace" | "bungalow" | "farm" | "cabin" => {
            FacadeStyle::House
        }
        "apartments" | "dormitory" | "hotel" | "hospital" => FacadeStyle::Apartments,
        "commercial" | "office" | "university" | "government" | "public" => FacadeStyle::Office,
        "retail" | "supermarket" | "shop" => FacadeStyle::Shop,
        "industrial" | "warehouse" | "hangar" | "manufacture" | "factory" => FacadeStyle::Hall,
        "barn" | "farm_auxiliary" | "stable" | "cowshed" | "shed" | "hut" => FacadeStyle::Barn,
        "church" | "chapel" | "cathedral" | "monastery" | "mosque" | "synagogue" | "temple" => {
            FacadeStyle::Church
        }
        "garage" | "garages" => FacadeStyle::Garage,
        "roof" | "carport" | "greenhouse" | "ruins" | "bunker" | "kiosk" | "stadium" | "grandstand"
        | "storage_tank" | "silo" | "tower" | "water_tower" | "transformer_tower" | "bridge" | "tent" => {
            return None;
        }
        _ => match material {
            Material::Glass => FacadeStyle::Office,
            Material::Metal => FacadeStyle::Hall,
            Material::Wood if !is_high => FacadeStyle::Barn,
            _ if is_high => FacadeStyle::Apartments,
            _ => FacadeStyle::House,
        },
    })
}

/// A building of which a row says nothing.
struct Usual {
    /// Eaves are above its lower end.
    top: Top,
    roof: RoofShape,
    walls: Paint,
    /// The roof's surface; `None`: as roofs of its shape have it.
    cover: Option<Paint>,
}

/// The building that a row is; `kind` of `building` or `building:part`.
pub(super) fn building(tags: &mut Tags<'_>, kind: &str, is_part: bool) -> Meaning {
    let (levels, pitched, material, colour) = usual(kind);
    // Streets are not uniform: half a level more or less.
    let eaves = LEVEL * levels * (0.85 + 0.3 * share(mix(tags.hash ^ 1)));
    // Pitched roofs are known where a country's houses have them; large footprints are told apart when they are bound.
    let roof = if pitched && !is_part { RoofShape::Gabled } else { RoofShape::Flat };
    let usual = Usual { top: Top::Eaves(eaves), roof, walls: Paint { colour, material }, cover: None };
    Meaning::Building(stated(tags, kind, is_part, &usual))
}

/// The tower, tank or silo that a row is, with the walls of its outline.
pub(super) fn structure(tags: &mut Tags<'_>, round: &Upright) -> Building {
    let roof = match round.cap {
        Cap::Flat | Cap::Waisted => RoofShape::Flat,
        Cap::Dome => RoofShape::Dome,
        Cap::Cone => RoofShape::Pyramidal,
    };
    let (walls, cover) = (round.paint, Some(round.paint));
    let kind = tags.kind("building");
    // What is wrong with a value is told once, as of what is round.
    let told = tags.doubts.clone();
    let usual = Usual { top: Top::Ridge(round.height_m), roof, walls, cover };
    let building = Building { facade: None, ..stated(tags, &kind, false, &usual) };
    let mut further = tags.doubts.split_off(told.len());
    further.retain(|doubt| !told.contains(doubt));
    tags.doubts.extend(further);
    building
}

/// A building with what the row says of it.
fn stated(tags: &mut Tags<'_>, kind: &str, is_part: bool, usual: &Usual) -> Building {
    let columns = &tags.options.columns;
    let roof = roof(tags, usual.roof);
    let said = tags.length(columns.height.as_ref(), &["height", "building:height", "est_height"]);
    let counted = tags.count(columns.levels.as_ref(), &["building:levels", "levels"], &LEVELS);
    let roof_levels = tags.count(None, &["roof:levels"], &LEVELS).unwrap_or(0.0);
    let min_levels = tags.count(None, &["building:min_level", "min_level"], &LEVELS);
    let zero = 0.0..=*LENGTHS.end();
    let min_height_m = tags.measured(columns.min_height.as_ref(), &["min_height"], quantity::length, &zero);
    let min_height_m = min_height_m.or_else(|| min_levels.map(|levels| levels * LEVEL)).unwrap_or(0.0);
    let hover = matches!(kind, "roof" | "carport") && min_height_m == 0.0;
    let roof = match (roof_levels > 0.0, roof) {
        (true, (roof, false)) => Roof { rise: Rise::Height(roof_levels * LEVEL), ..roof },
        (_, (roof, _)) => roof,
    };

    let mut top = match (said, counted, usual.top) {
        (Some(height), ..) => Top::Ridge(height),
        (None, Some(levels), _) => Top::Eaves(levels * LEVEL),
        (None, None, Top::Eaves(height)) => Top::Eaves(min_height_m + height),
        (None, None, ridge) => ridge,
    };
    // A roof without levels below it begins at its lower end.
    let (height, is_above) = match top {
        Top::Ridge(height) => (height, height > min_height_m),
        Top::Eaves(height) => (height, height > min_height_m || height == min_height_m && roof.rises()),
    };
    if !is_above {
        tags.doubts.push(format!("its lower end, {min_height_m} m, is not below its top, {height} m"));
        top = Top::Ridge(min_height_m + LEVEL);
    }

    let walls = tags.paint(
        [columns.colour.as_ref(), columns.material.as_ref()],
        &["building:colour", "building:color", "colour", "color"],
        &["building:material", "material", "building:facade:material"],
        usual.walls,
    );
    let cover = usual.cover.unwrap_or(match roof.shape {
        RoofShape::Flat => Paint { colour: [124, 120, 114], material: Material::RoofFelt },
        RoofShape::Dome => Paint { colour: [112, 150, 134], material: Material::Metal },
        _ => Paint { colour: [138, 78, 60], material: Material::RoofTiles },
    });

    let cover = tags.paint(
        [columns.roof_colour.as_ref(), None],
        &["roof:colour", "roof:color", "building:roof:colour"],
        &["roof:material", "building:roof:material"],
        cover,
    );
    let min_height_m = if hover { (height.min(2.0 * LEVEL) - 0.4).max(0.0) } else { min_height_m };

    // Low levels below a stated lower end are not its own.
    let levels = counted.map(|levels| levels - min_levels.unwrap_or(0.0));
    let high = levels.or(said.map(|height| (height - min_height_m) / LEVEL));
    let style = if tags.options.plain_walls { None } else { style(kind, high, walls.material) };
    let facade = style.map(|style| FacadeKind { style, levels });

    Building { top, min_height_m, roof, walls, cover, is_part, facade }
}

/// Reads the roof, and whether its height is said.
fn roof(tags: &mut Tags<'_>, usual: RoofShape) -> (Roof, bool) {
    let column = tags.options.columns.roof_shape.clone();
    let word = match &column {
        Some(column) => tags.word(column),
        None => tags
            .word("roof:shape")
            .or_else(|| tags.word("building:roof:shape"))
            .or_else(|| tags.word("roof_shape")),
    };

    let shape = match word.as_deref() {
        None => usual,
        Some("flat" | "no" | "terrace") => RoofShape::Flat,
        Some(
            "gabled" | "gable" | "pitched" | "saltbox" | "gambrel" | "round" | "double_saltbox" | "sawtooth"
            | "gabled_row" | "many",
        ) => RoofShape::Gabled,
        Some(
            "hipped" | "hip" | "half-hipped" | "side_hipped" | "mansard" | "hipped-and-gabled"
            | "quadruple_saltbox",
        ) => RoofShape::Hipped,
        Some("pyramidal" | "cone" | "conical" | "spire" | "tented" | "pyramid") => RoofShape::Pyramidal,
        Some("skillion" | "lean_to" | "side_half-hipped" | "monopitch" | "shed") => RoofShape::Skillion,
        Some("dome" | "onion" | "half_dome" | "round_dome") => RoofShape::Dome,
        Some(other) => {
            let shown: String = other.chars().take(40).collect();
            tags.doubts.push(format!("roof shape \"{shown}\" is passed over: it is none that is known here"));
            RoofShape::Flat
        }
    };

    let zero = 0.0..=*LENGTHS.end();
    let column = tags.options.columns.roof_height.clone();
    let height =
        tags.measured(column.as_ref(), &["roof:height", "building:roof:height"], quantity::length, &zero);
    let angle = tags.measured(None, &["roof:angle", "building:roof:angle"], quantity::degrees, &(0.0..=75.0));
    let direction = tags.text("roof:direction").and_then(|text| quantity::direction(&text));
    let across = tags.is("roof:orientation", &["across"]);
    let is_said = height.is_some() || angle.is_some();

    let rise = match (height, angle, shape) {
        (Some(height), ..) => Rise::Height(height),
        (None, Some(angle), _) => Rise::Angle(angle),
        (None, None, RoofShape::Flat) => Rise::Height(0.0),
        (None, None, RoofShape::Skillion) => Rise::Angle(12.0),
        (None, None, RoofShape::Dome) => Rise::Angle(DOME.atan().to_degrees() * 2.0),
        (None, None, _) => Rise::Angle(USUAL_ANGLE + 10.0 * (share(mix(tags.hash ^ 2)) - 0.5)),
    };

    (Roof { shape, rise, direction, across, is_guess: word.is_none() }, is_said)
}
