//! Meaning of tags: from rows to things.
//!
//! ```text
//! what is under ground or gone: hidden, and counted
//! else the first that is known of  building:part, building, man_made, power, aeroway, highway, railway, waterway, natural, landuse, barrier
//! sizes: what the row says (metres unless a unit is said) | levels × 3 m | what is usual for its kind
//! ```
//! Keys and their meaning: OpenStreetMap's wiki, *Map features* (2024). Values out of sense are doubts, and count as not said.

mod building;
mod colours;
mod ground;
mod material;
mod plants;
mod quantity;
mod road_lines;
mod tags;
#[cfg(test)]
mod tests;
mod upright;
mod ways;

use super::kinds::{FeatureClass, Meaning, Paint};
use super::layer::{Layer, LayerOptions, LeftOut, Row};
pub use colours::colour;
pub(super) use colours::{hash, varied};
pub(crate) use colours::{mix, share};
use hedgehop::voxel::Material;
pub(super) use plants::crown;
pub(in super::super) use quantity::length;
use tags::Tags;

/// Meaning of a row, and faults of its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpreted {
    /// Meaning of the row.
    pub meaning: Meaning,
    /// Values that were passed over, a sentence each without file and row.
    pub doubts: Vec<String>,
}

/// The surface of water.
pub const WATER: Paint = Paint { colour: [44, 62, 74], material: Material::Water };
const DECK: Paint = Paint { colour: [150, 146, 138], material: Material::Concrete };

/// Interprets a row.
pub fn interpret(row: &Row, options: &LayerOptions) -> Interpreted {
    let mut tags = Tags::of(row, options);
    let meaning = match (hidden(&tags), options.kind) {
        (Some(why), _) => Meaning::Hidden(why),
        (None, Some(class)) => of_class(&mut tags, class),
        (None, None) => of_tags(&mut tags),
    };
    Interpreted { meaning, doubts: tags.doubts }
}

/// Sentences about rows of a layer that are told one by one; of more, the number is told.
const MOST_DOUBTS: usize = 20;

/// A sentence for each attribute that is said to hold something, and which no row has.
pub fn unknown_columns(layer: &Layer, options: &LayerOptions) -> Vec<String> {
    let file = crate::naming::file_name(&layer.path);
    let is_unknown = |name: &&str| !layer.rows.iter().any(|row| row.attributes.get(name).is_some());
    let unknown = options.columns.names().filter(is_unknown);
    unknown
        .map(|name| format!("{file}: no row has the attribute {name}, which is said to hold something"))
        .collect()
}

/// Interprets the rows of a layer: meanings by their places in it, and notes on what was passed over or left out.
pub fn interpret_all(layer: &Layer, options: &LayerOptions) -> (Vec<(usize, Meaning)>, Vec<String>) {
    let file = crate::naming::file_name(&layer.path);
    let (mut meanings, mut notes, mut doubtful, mut left_out) =
        (Vec::new(), Vec::new(), 0, LeftOut::default());
    notes.extend(unknown_columns(layer, options));

    for (index, row) in layer.rows.iter().enumerate() {
        let Interpreted { meaning, doubts } = interpret(row, options);
        for doubt in doubts {
            doubtful += 1;
            if doubtful <= MOST_DOUBTS {
                notes.push(format!("{file}: {}: {doubt}", row.place));
            }
        }

        match meaning {
            Meaning::Unknown => left_out.add(&row.place, "no tag says what it is that is known here"),
            Meaning::Hidden(why) => left_out.add(&row.place, why),
            meaning => meanings.push((index, meaning)),
        }
    }

    if doubtful > MOST_DOUBTS {
        notes.push(format!("{file}: {} more values are passed over", doubtful - MOST_DOUBTS));
    }
    notes.extend(left_out.into_notes(&file));

    (meanings, notes)
}

/// Why a row is not to be seen, if it is not.
fn hidden(tags: &Tags<'_>) -> Option<&'static str> {
    // Shapefiles of extracts say T and F.
    let tunnel = tags
        .yes("tunnel")
        .is_some_and(|tunnel| tunnel != "building_passage" && tunnel != "avalanche_protector");
    let below = tags.is("location", &["underground", "underwater", "indoor"]) || tags.yes("indoor").is_some();
    if tunnel || below {
        return Some("it is under ground or indoors");
    }
    let gone = tags.is("highway", &["proposed", "construction", "razed", "abandoned"])
        || tags.is("railway", &["proposed", "construction", "razed", "dismantled"])
        || tags.yes("demolished:building").is_some();
    gone.then_some("it is planned or gone")
}

fn of_class(tags: &mut Tags<'_>, class: FeatureClass) -> Meaning {
    let found = match class {
        FeatureClass::Building => {
            let kind = tags.kind("building");
            Some(building::building(tags, &kind, false))
        }
        FeatureClass::Road => {
            let kind = tags.kind("highway");
            // A layer of roads has nothing but roads, whatever it calls them.
            ways::road(tags, &kind).or_else(|| ways::road(tags, ""))
        }
        FeatureClass::Railway => ways::railway(tags, "rail"),
        FeatureClass::Runway => {
            let kind = tags.kind("aeroway");
            ways::aeroway(tags, &kind).or_else(|| ways::aeroway(tags, ""))
        }
        FeatureClass::Pavement => {
            Some(Meaning::Pavement(tags.paint([None, None], &["colour"], &["surface"], DECK)))
        }
        FeatureClass::River if tags.has_area() => Some(Meaning::River(0.0)),
        FeatureClass::River => {
            let kind = tags.kind("waterway");
            ways::waterway(tags, &kind).or_else(|| ways::waterway(tags, ""))
        }
        FeatureClass::Lake => Some(Meaning::Lake),
        FeatureClass::Wall => upright::barrier(tags, "wall"),
        FeatureClass::Fence => upright::barrier(tags, "fence"),
        FeatureClass::Hedge => upright::barrier(tags, "hedge"),
        FeatureClass::Mast => {
            let kind = tags.kind("man_made");
            upright::man_made(tags, &kind).or_else(|| upright::man_made(tags, "mast"))
        }
        FeatureClass::Tank => upright::man_made(tags, "tank"),
        FeatureClass::Silo => upright::man_made(tags, "silo"),
        FeatureClass::PowerLine => upright::power(tags, "line"),
        FeatureClass::Pylon => upright::power(tags, "tower"),
        FeatureClass::Tree => Some(plants::trees(tags)),
        FeatureClass::Wood => {
            let kind = tags.kind("natural");
            plants::wood(tags, &kind).or_else(|| plants::wood(tags, ""))
        }
        FeatureClass::Bridge => Some(Meaning::Bridge(DECK)),
        FeatureClass::Ground => {
            let kind = tags.kind("natural");
            ground::ground(tags, &kind).or_else(|| ground::ground(tags, "earth"))
        }
    };

    found.unwrap_or(Meaning::Unknown)
}

/// Function that makes a meaning of a row with a key's word.
type Read = fn(&mut Tags<'_>, &str) -> Option<Meaning>;

fn of_tags(tags: &mut Tags<'_>) -> Meaning {
    let by_key: [(&str, Read); 10] = [
        ("building:part", |tags, kind| Some(building::building(tags, kind, true))),
        ("man_made", man_made),
        ("building", |tags, kind| Some(building::building(tags, kind, false))),
        ("power", upright::power),
        ("aeroway", ways::aeroway),
        ("highway", |tags, class| if class.is_empty() { None } else { ways::road(tags, class) }),
        ("railway", ways::railway),
        ("waterway", ways::waterway),
        ("natural", natural),
        ("barrier", upright::barrier),
    ];
    for (key, read) in by_key {
        if let Some(meaning) = tags.yes(key).and_then(|word| read(tags, &word)) {
            return meaning;
        }
    }
    landuse(tags)
}

fn man_made(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    if kind == "bridge" && tags.has_area() {
        return Some(Meaning::Bridge(tags.paint([None, None], &["colour"], &["material", "surface"], DECK)));
    }
    upright::man_made(tags, kind)
}

fn natural(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    match kind {
        "tree" | "tree_row" => Some(plants::trees(tags)),
        "water" if tags.has_area() => Some(water(tags)),
        "" => None,
        _ => plants::wood(tags, kind).or_else(|| ground::ground(tags, kind)),
    }
}

/// An area of water: rivers slope, and others do not.
fn water(tags: &Tags<'_>) -> Meaning {
    let flows = tags.is("water", &["river", "canal", "stream", "rapids", "ditch", "lock"]);
    if flows { Meaning::River(0.0) } else { Meaning::Lake }
}

fn landuse(tags: &mut Tags<'_>) -> Meaning {
    let area = tags.has_area();
    let found = match tags.word("landuse").as_deref() {
        Some("reservoir" | "basin" | "pond") if area => Some(Meaning::Lake),
        Some(kind @ ("forest" | "orchard" | "vineyard" | "plant_nursery")) if area => {
            plants::wood(tags, kind)
        }
        Some(kind) => ground::ground(tags, kind),
        None => None,
    };

    let parking =
        tags.is("amenity", &["parking"]) && !tags.is("parking", &["underground", "multi-storey", "rooftop"]);
    match found {
        Some(meaning) => meaning,
        None if parking && area => {
            let asphalt = Paint { colour: [104, 104, 104], material: Material::Asphalt };
            Meaning::Pavement(tags.paint([None, None], &["colour"], &["surface"], asphalt))
        }
        None => Meaning::Unknown,
    }
}
