//! Materials by OpenStreetMap's words.

use hedgehop::voxel::Material;

/// Looks a material up by OpenStreetMap's word for it or for a surface, with the colour that it has by itself (sRGB).
pub(super) fn material_of_word(word: &str) -> Option<(Material, [u8; 3])> {
    Some(match word {
        "asphalt" | "paved" | "chipseal" => (Material::Asphalt, [86, 86, 88]),
        "tar_paper" | "roofing_felt" | "bitumen" => (Material::RoofFelt, [82, 82, 84]),
        "gravel_roof" => (Material::RoofFelt, [132, 128, 120]),
        "concrete" | "cement_block" | "concrete:plates" | "concrete:lanes" => {
            (Material::Concrete, [158, 156, 150])
        }
        "brick" | "bricks" => (Material::Brick, [150, 84, 66]),
        "plaster" | "render" | "stucco" => (Material::Plaster, [216, 206, 188]),
        "stone" | "sandstone" | "limestone" | "marble" | "masonry" => (Material::Stone, [176, 166, 146]),
        "cobblestone" | "sett" | "paving_stones" | "unhewn_cobblestone" => (Material::Stone, [136, 130, 122]),
        "metal" | "steel" | "metal_sheet" | "aluminium" | "zinc" | "tin" => {
            (Material::Metal, [150, 156, 160])
        }
        "copper" => (Material::Metal, [110, 154, 136]),
        "glass" | "mirror" | "solar_panels" => (Material::Glass, [96, 116, 132]),
        "roof_tiles" | "tile" | "tiles" | "clay" => (Material::RoofTiles, [148, 78, 58]),
        "slate" => (Material::RoofTiles, [84, 88, 96]),
        "eternit" => (Material::RoofTiles, [128, 128, 126]),
        "wood" | "timber" | "timber_framing" => (Material::Wood, [126, 98, 68]),
        "thatch" | "reed" => (Material::Wood, [142, 122, 84]),
        "grass" | "green" | "grass_paver" => (Material::Grass, [98, 118, 62]),
        "gravel" | "fine_gravel" | "compacted" | "pebblestone" | "unpaved" | "rock" => {
            (Material::Gravel, [164, 154, 134])
        }
        "ground" | "dirt" | "earth" | "mud" => (Material::Soil, [134, 112, 84]),
        "sand" => (Material::Sand, [206, 188, 146]),
        "snow" => (Material::Snow, [240, 242, 246]),
        "ice" => (Material::Ice, [210, 224, 232]),
        "plastic" | "artificial_turf" | "tartan" | "fabric" => (Material::Plastic, [190, 190, 190]),
        _ => return None,
    })
}
