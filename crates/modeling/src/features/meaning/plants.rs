//! Trees, rows of them, and woods.

use std::ops::RangeInclusive;

use super::super::kinds::{FieldRows, Leaf, Meaning, Paint, Tree, Wood};
use super::colours::{mix, share};
use super::quantity;
use super::tags::Tags;
use hedgehop::voxel::Material;

/// Heights that trees on Earth have, metres.
const HEIGHTS: RangeInclusive<f64> = 0.01..=130.0;
/// Widths of their crowns, metres.
const CROWNS: RangeInclusive<f64> = 0.01..=60.0;
/// Metres between the trees of a row.
const ROW_STEP: f64 = 9.0;

fn leaf(tags: &Tags<'_>) -> Option<Leaf> {
    let word = tags.word("leaf_type").or_else(|| tags.word("wood"));
    match word.as_deref() {
        Some("needleleaved" | "coniferous" | "needle") => Some(Leaf::Needle),
        Some("broadleaved" | "deciduous" | "palm" | "broad") => Some(Leaf::Broad),
        Some("mixed") => Some(Leaf::Mixed),
        _ => None,
    }
}

/// The colour of a crown.
pub(in super::super) fn crown(leaf: Leaf) -> Paint {
    match leaf {
        Leaf::Needle => Paint { colour: [52, 72, 46], material: Material::Needleleaf },
        Leaf::Broad | Leaf::Mixed => Paint { colour: [78, 98, 48], material: Material::Broadleaf },
    }
}

/// A tree, or a row of trees.
pub(super) fn trees(tags: &mut Tags<'_>) -> Meaning {
    let columns = &tags.options.columns;
    let leaf = match leaf(tags).unwrap_or(Leaf::Broad) {
        Leaf::Mixed if tags.hash.is_multiple_of(2) => Leaf::Needle,
        Leaf::Mixed => Leaf::Broad,
        one => one,
    };
    let said = tags.measured(columns.height.as_ref(), &["height", "est_height"], quantity::length, &HEIGHTS);
    let height_m = said.unwrap_or_else(|| 8.0 + 9.0 * share(mix(tags.hash ^ 3)));
    let names = ["diameter_crown", "crown_diameter"];
    let crown_m = tags.measured(columns.diameter.as_ref(), &names, quantity::length, &CROWNS);
    let slender = if leaf == Leaf::Needle { 0.35 } else { 0.6 };
    let crown_m = crown_m.unwrap_or(slender * height_m);
    let paint = tags.paint([columns.colour.as_ref(), None], &["colour"], &[], crown(leaf));
    Meaning::Trees(Tree { height_m, crown_m, leaf, paint }, ROW_STEP)
}

/// An area of trees or bushes, by its word.
pub(super) fn wood(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let (height, density, usual) = match kind {
        "wood" | "forest" | "" => (20.0, 180.0, Leaf::Mixed),
        "scrub" | "heath_scrub" => (2.5, 700.0, Leaf::Broad),
        "orchard" | "plant_nursery" => (4.5, 250.0, Leaf::Broad),
        "vineyard" => (1.8, 1500.0, Leaf::Broad),
        _ => return None,
    };
    let columns = &tags.options.columns;
    let said = tags.measured(columns.height.as_ref(), &["height", "est_height"], quantity::length, &HEIGHTS);
    let leaf = leaf(tags).unwrap_or(usual);
    let rows = match kind {
        _ if tags.options.plain_ground => None,
        "orchard" => Some(FieldRows::Fruit),
        "vineyard" => Some(FieldRows::Vines),
        _ => None,
    };
    Some(Meaning::Wood(Wood { height_m: said.unwrap_or(height), density, leaf, rows }))
}
