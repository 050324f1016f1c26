//! Schemes of land cover: which class of a map is which material.
//!
//! - ESA WorldCover, *Product User Manual* v2.0 (2022), table 2.
//! - CORINE Land Cover, *CLC nomenclature guidelines* (European Environment Agency, 2019): codes of level 3, and their numbers in 100 m grids.
//! - NLCD, *National Land Cover Database class legend* (Multi-Resolution Land Characteristics Consortium, 2021).

use std::collections::BTreeMap;

use Material::{
    Asphalt, Broadleaf, BuiltUp, Crops, Grass, Gravel, Heath, Ice, MixedForest, Moss, Mud, Needleleaf,
    Orchard, Rock, Sand, Shrub, Snow, Soil, Water, Wetland,
};

use hedgehop::voxel::Material;

/// Scheme: meaning of the numbers of a map of land cover.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scheme {
    /// ESA WorldCover, 10…100.
    WorldCover,
    /// CORINE Land Cover: codes of level 3 (111…523), or the numbers 1…44 of grids.
    Corine,
    /// National Land Cover Database of the United States, 11…95.
    Nlcd,
    /// Numbers and materials as a recipe says them.
    Own(BTreeMap<u16, Material>),
}

/// Schemes by the names that recipes and flags have.
const NAMES: [(&str, Scheme); 3] =
    [("worldcover", Scheme::WorldCover), ("corine", Scheme::Corine), ("nlcd", Scheme::Nlcd)];

const WORLD_COVER: [(u16, Material); 11] = [
    (10, MixedForest),
    (20, Shrub),
    (30, Grass),
    (40, Crops),
    (50, BuiltUp),
    (60, Soil),
    (70, Snow),
    (80, Water),
    (90, Wetland),
    (95, Broadleaf),
    (100, Moss),
];

const NLCD: [(u16, Material); 20] = [
    (11, Water),
    (12, Ice),
    (21, Grass),
    (22, BuiltUp),
    (23, BuiltUp),
    (24, BuiltUp),
    (31, Soil),
    (41, Broadleaf),
    (42, Needleleaf),
    (43, MixedForest),
    (51, Shrub),
    (52, Shrub),
    (71, Grass),
    (72, Grass),
    (73, Moss),
    (74, Moss),
    (81, Grass),
    (82, Crops),
    (90, Wetland),
    (95, Wetland),
];

/// Materials in the order of the numbers of grids, from 1 on.
const CORINE: [(u16, Material); 44] = [
    (111, BuiltUp),
    (112, BuiltUp),
    (121, BuiltUp),
    (122, Asphalt),
    (123, BuiltUp),
    (124, Asphalt),
    (131, Gravel),
    (132, Soil),
    (133, Soil),
    (141, Grass),
    (142, Grass),
    (211, Crops),
    (212, Crops),
    (213, Crops),
    (221, Orchard),
    (222, Orchard),
    (223, Orchard),
    (231, Grass),
    (241, Crops),
    (242, Crops),
    (243, Crops),
    (244, Orchard),
    (311, Broadleaf),
    (312, Needleleaf),
    (313, MixedForest),
    (321, Grass),
    (322, Heath),
    (323, Shrub),
    (324, Shrub),
    (331, Sand),
    (332, Rock),
    (333, Gravel),
    (334, Soil),
    (335, Ice),
    (411, Wetland),
    (412, Wetland),
    (421, Wetland),
    (422, Wetland),
    (423, Mud),
    (511, Water),
    (512, Water),
    (521, Water),
    (522, Water),
    (523, Water),
];

impl Scheme {
    /// Finds a scheme by its name; an error tells all names.
    pub fn named(name: &str) -> Result<Self, String> {
        let known = NAMES.into_iter().find(|(known, _)| *known == name).map(|(_, scheme)| scheme);
        known.ok_or_else(|| {
            let names = NAMES.map(|(name, _)| name).join(", ");
            format!("scheme is one of {names}, not {name:?}; classes = {{ 1 = \"water\" }} says another")
        })
    }

    /// Returns the name.
    pub fn name(&self) -> &'static str {
        NAMES.iter().find(|(_, scheme)| scheme == self).map_or("classes of the recipe", |(name, _)| name)
    }

    /// The material of a number; `None`: it has none.
    pub fn material(&self, number: u16) -> Option<Material> {
        let of =
            |table: &[(u16, Material)]| table.iter().find(|(known, _)| *known == number).map(|known| known.1);
        match self {
            Self::WorldCover => of(&WORLD_COVER),
            Self::Nlcd => of(&NLCD),
            Self::Corine => {
                let of_grid = || CORINE.get(usize::from(number.checked_sub(1)?)).map(|class| class.1);
                of(&CORINE).or_else(of_grid)
            }
            Self::Own(classes) => classes.get(&number).copied(),
        }
    }

    /// Whether a number says by itself that nothing is known.
    pub fn is_void(&self, number: u16) -> bool {
        match self {
            Self::WorldCover => number == 0,
            // Of level 3, of grids, and as 16-bit grids without a sign have −32768.
            Self::Corine => [0, 48, 128, 255, 990, 995, 999, 32_768].contains(&number),
            Self::Nlcd => [0, 127, 250, 255].contains(&number),
            Self::Own(_) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemes_have_their_codes() {
        let corine = |number| Scheme::Corine.material(number);
        assert_eq!(
            (corine(312), corine(24), corine(523), corine(44)),
            (Some(Needleleaf), Some(Needleleaf), Some(Water), Some(Water))
        );
        assert_eq!((corine(45), corine(0), corine(113)), (None, None, None));
        assert!(CORINE.is_sorted_by_key(|class| class.0) && NLCD.is_sorted_by_key(|class| class.0));
        assert_eq!(Scheme::WorldCover.material(80), Some(Water));
        assert_eq!(Scheme::Nlcd.material(42), Some(Needleleaf));
        assert_eq!(Scheme::named("nlcd"), Ok(Scheme::Nlcd));
        assert!(Scheme::named("clc").unwrap_err().contains("worldcover, corine, nlcd"));
        // What is void has no material.
        for scheme in [Scheme::WorldCover, Scheme::Corine, Scheme::Nlcd] {
            let both =
                (0..=u16::MAX).filter(|number| scheme.is_void(*number) && scheme.material(*number).is_some());
            assert_eq!(both.count(), 0, "{}", scheme.name());
        }
    }
}
