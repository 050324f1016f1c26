//! Materials by OpenStreetMap's words.

pub use crate::voxel::Material;

impl Material {
    /// By OpenStreetMap's words for materials and surfaces, with the colour that it has by itself (sRGB).
    pub(in super::super) fn of(word: &str) -> Option<(Self, [u8; 3])> {
        Some(match word {
            "asphalt" | "paved" | "chipseal" => (Self::Asphalt, [86, 86, 88]),
            "tar_paper" | "roofing_felt" | "bitumen" => (Self::RoofFelt, [82, 82, 84]),
            "gravel_roof" => (Self::RoofFelt, [132, 128, 120]),
            "concrete" | "cement_block" | "concrete:plates" | "concrete:lanes" => {
                (Self::Concrete, [158, 156, 150])
            }
            "brick" | "bricks" => (Self::Brick, [150, 84, 66]),
            "plaster" | "render" | "stucco" => (Self::Plaster, [216, 206, 188]),
            "stone" | "sandstone" | "limestone" | "marble" | "masonry" => (Self::Stone, [176, 166, 146]),
            "cobblestone" | "sett" | "paving_stones" | "unhewn_cobblestone" => (Self::Stone, [136, 130, 122]),
            "metal" | "steel" | "metal_sheet" | "aluminium" | "zinc" | "tin" => {
                (Self::Metal, [150, 156, 160])
            }
            "copper" => (Self::Metal, [110, 154, 136]),
            "glass" | "mirror" | "solar_panels" => (Self::Glass, [96, 116, 132]),
            "roof_tiles" | "tile" | "tiles" | "clay" => (Self::RoofTiles, [148, 78, 58]),
            "slate" => (Self::RoofTiles, [84, 88, 96]),
            "eternit" => (Self::RoofTiles, [128, 128, 126]),
            "wood" | "timber" | "timber_framing" => (Self::Wood, [126, 98, 68]),
            "thatch" | "reed" => (Self::Wood, [142, 122, 84]),
            "grass" | "green" | "grass_paver" => (Self::Grass, [98, 118, 62]),
            "gravel" | "fine_gravel" | "compacted" | "pebblestone" | "unpaved" | "rock" => {
                (Self::Gravel, [164, 154, 134])
            }
            "ground" | "dirt" | "earth" | "mud" => (Self::Soil, [134, 112, 84]),
            "sand" => (Self::Sand, [206, 188, 146]),
            "snow" => (Self::Snow, [240, 242, 246]),
            "ice" => (Self::Ice, [210, 224, 232]),
            "plastic" | "artificial_turf" | "tartan" | "fabric" => (Self::Plastic, [190, 190, 190]),
            _ => return None,
        })
    }
}
