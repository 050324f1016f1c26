//! Materials of surfaces: the one table, from which every sensor takes its quantities.
//!
//! A voxel and a span hold the number of a class. Numbers are never given anew: a database keeps its meaning. What a place adds of its own
//! has numbers that this table leaves free, and stands in the database's [metadata](super::Metadata::materials).

macro_rules! materials {
    ($($(#[$says:meta])+ $class:ident = $number:literal, $name:literal, $colour:expr;)+) => {
        /// A class of material, from which infrared, radar and low light follow.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
        pub enum Material {
            /// Not known.
            #[default]
            Unknown,
            $($(#[$says])+ $class,)+
            /// One of a place's own, by its number.
            Own(u8),
        }

        impl Material {
            /// All of the table, by rising number.
            pub const ALL: &[Self] = &[$(Self::$class,)+];

            /// Its number in pages and spans.
            pub fn code(self) -> u8 {
                match self {
                    Self::Unknown => 0,
                    $(Self::$class => $number,)+
                    Self::Own(number) => number,
                }
            }

            /// By its number.
            pub fn of_code(number: u8) -> Self {
                match number {
                    0 => Self::Unknown,
                    $($number => Self::$class,)+
                    own => Self::Own(own),
                }
            }

            /// Its name in recipes and reports; `None`: one of a place's own, which the place names.
            pub fn name(self) -> Option<&'static str> {
                match self {
                    Self::Unknown => Some("unknown"),
                    $(Self::$class => Some($name),)+
                    Self::Own(_) => None,
                }
            }

            /// The colour that it has where nothing else says one, sRGB.
            pub fn colour(self) -> [u8; 3] {
                match self {
                    Self::Unknown | Self::Own(_) => [128, 128, 128],
                    $(Self::$class => $colour,)+
                }
            }
        }
    };
}

materials! {
    /// Open water.
    Water = 1, "water", [44, 62, 74];
    /// Asphalt.
    Asphalt = 2, "asphalt", [92, 92, 94];
    /// Concrete.
    Concrete = 3, "concrete", [158, 156, 150];
    /// Brick.
    Brick = 4, "brick", [150, 84, 66];
    /// Plaster, render.
    Plaster = 5, "plaster", [216, 206, 188];
    /// Dressed stone, cobbles.
    Stone = 6, "stone", [176, 166, 146];
    /// Bare or painted metal.
    Metal = 7, "metal", [150, 156, 160];
    /// Glass.
    Glass = 8, "glass", [96, 116, 132];
    /// Roof tiles, slate.
    RoofTiles = 9, "roof-tile", [148, 78, 58];
    /// Roofing felt, bitumen, gravelled roofs.
    RoofFelt = 10, "roof-felt", [124, 120, 114];
    /// Wood, thatch.
    Wood = 11, "wood", [126, 98, 68];
    /// Broad leaves.
    Broadleaf = 12, "broadleaf", [78, 98, 48];
    /// Needles.
    Needleleaf = 13, "conifer", [52, 72, 46];
    /// Grass.
    Grass = 14, "grass", [98, 118, 62];
    /// Crops.
    Crops = 15, "crop", [140, 136, 76];
    /// Soil.
    Soil = 16, "bare-soil", [142, 122, 94];
    /// Sand.
    Sand = 17, "sand", [206, 188, 146];
    /// Gravel, ballast, scree.
    Gravel = 18, "gravel", [158, 150, 134];
    /// Rock.
    Rock = 19, "rock", [124, 116, 108];
    /// Snow.
    Snow = 20, "snow", [240, 242, 246];
    /// Ice.
    Ice = 21, "ice", [210, 224, 232];
    /// Plastic, fabric.
    Plastic = 22, "plastic", [190, 190, 190];
    /// Bushes.
    Shrub = 23, "shrub", [104, 108, 62];
    /// Reeds, bogs, marshes.
    Wetland = 24, "wetland", [88, 98, 70];
    /// Houses, roads and gardens that no map tells apart.
    BuiltUp = 25, "built-up", [138, 130, 122];
    /// Broad leaves and needles side by side.
    MixedForest = 26, "mixed-forest", [64, 84, 48];
    /// Moss and lichen.
    Moss = 27, "moss", [126, 124, 92];
    /// Heath and moor.
    Heath = 28, "heath", [112, 100, 72];
    /// Vines, fruit trees.
    Orchard = 29, "orchard", [108, 116, 64];
    /// Mud, tidal flats.
    Mud = 30, "mud", [112, 100, 84];
}

impl Material {
    /// Finds a material by the name that the table gives it.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|material| material.name() == Some(name))
    }

    /// A colour that tells it from others in pictures of materials, sRGB; black if it is not known. Numbers that follow each other have hues a golden
    /// section of the circle apart.
    pub fn mark(self) -> [u8; 3] {
        const GOLDEN: f32 = 0.618_034;
        let code = self.code();
        if code == 0 {
            return [0; 3];
        }
        let hue = 6.0 * (f32::from(code) * GOLDEN).fract();
        let lightness = [1.0, 0.72, 0.86][usize::from(code % 3)];
        let channel = |shift: f32| {
            let away = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
            let pure = away.clamp(0.0, 1.0);
            (255.0 * lightness * (0.25 + 0.75 * pure)).round() as u8
        };
        [channel(0.0), channel(4.0), channel(2.0)]
    }

    /// Returns the group that it belongs to in reports on what stands and lies there.
    pub fn group(self) -> Group {
        match self {
            Self::Water | Self::Wetland | Self::Snow | Self::Ice => Group::Water,
            Self::Broadleaf | Self::Needleleaf | Self::MixedForest | Self::Shrub | Self::Orchard => {
                Group::Woods
            }
            Self::Grass | Self::Crops | Self::Heath | Self::Moss => Group::Low,
            Self::Soil | Self::Sand | Self::Gravel | Self::Rock | Self::Mud => Group::Bare,
            Self::Asphalt
            | Self::Concrete
            | Self::Brick
            | Self::Plaster
            | Self::Stone
            | Self::Metal
            | Self::Glass
            | Self::RoofTiles
            | Self::RoofFelt
            | Self::Wood
            | Self::Plastic
            | Self::BuiltUp => Group::Built,
            Self::Unknown | Self::Own(_) => Group::Other,
        }
    }
}

/// Group of materials that have something in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// Water, wet ground, snow and ice.
    Water,
    /// Trees and bushes.
    Woods,
    /// Low plants.
    Low,
    /// Bare ground.
    Bare,
    /// Made by people.
    Built,
    /// Not known here.
    Other,
}

impl Group {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Water, Self::Woods, Self::Low, Self::Bare, Self::Built, Self::Other];

    /// Returns the group's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Water => "water, snow and ice",
            Self::Woods => "trees and bushes",
            Self::Low => "low vegetation",
            Self::Bare => "bare ground",
            Self::Built => "buildings and pavement",
            Self::Other => "other",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_are_one_for_each() {
        let codes: Vec<u8> = Material::ALL.iter().map(|material| material.code()).collect();
        assert!(codes.windows(2).all(|pair| pair[0] < pair[1]) && codes[0] == 1, "{codes:?}");
        for material in Material::ALL {
            let name = material.name().unwrap();
            assert_eq!(
                (Material::of_code(material.code()), Material::named(name)),
                (*material, Some(*material))
            );
            assert!(name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-'), "{name}");
            assert_ne!(material.group(), Group::Other);
        }
        let marks: std::collections::HashSet<_> =
            (0..=255).map(|code| Material::of_code(code).mark()).collect();
        assert!(marks.len() > 240, "{}", marks.len());
        assert_eq!((Material::of_code(0), Material::of_code(200)), (Material::Unknown, Material::Own(200)));
        assert_eq!((Material::Own(200).code(), Material::named("lava")), (200, None));
    }
}
