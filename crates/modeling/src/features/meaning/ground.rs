//! Natural and farmed ground.

use super::super::kinds::{FieldRows, Meaning, Paint};
use super::tags::Tags;
use hedgehop::voxel::Material;

/// An area of ground by its word, or by the material that the row states.
pub(super) fn ground(tags: &mut Tags<'_>, kind: &str) -> Option<Meaning> {
    let material = match kind {
        "sand" | "beach" | "dune" => Material::Sand,
        "scree" | "shingle" | "gravel" => Material::Gravel,
        "bare_rock" | "rock" => Material::Rock,
        "grassland" | "grass" | "meadow" | "village_green" | "recreation_ground" | "pasture" => {
            Material::Grass
        }
        "farmland" | "farm" => Material::Crops,
        "wetland" | "marsh" => Material::Wetland,
        "heath" | "moor" | "fell" => Material::Heath,
        "tundra" => Material::Moss,
        "mud" => Material::Mud,
        "glacier" => Material::Ice,
        "snow" => Material::Snow,
        "bare_soil" | "earth" | "brownfield" | "landfill" => Material::Soil,
        _ => return None,
    };

    if !tags.has_area() {
        return None;
    }

    let usual = Paint { colour: material.colour(), material };
    let columns = &tags.options.columns;
    let columns = [columns.colour.as_ref(), columns.material.as_ref()];

    let paint = tags.paint(columns, &["colour"], &["material", "surface"], usual);
    let rows = match paint.material {
        _ if tags.options.plain_ground => None,
        Material::Crops => Some(FieldRows::Tramlines),
        Material::Orchard => Some(FieldRows::Fruit),
        _ => None,
    };

    Some(rows.map_or(Meaning::Ground(paint), |rows| Meaning::Field(paint, rows)))
}
