//! Classes of points, by ASPRS (LAS Specification 1.4 R15, table 17).

use super::super::features::Paint;
use hedgehop::voxel::Material;

/// Kind of matter that a point tells of. The numbers are those of records in temporary files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum PointKind {
    /// Bare ground, water, surfaces of roads.
    Ground = 0,
    /// The highest surface, whatever it is: points of a file that knows no ground.
    Surface = 1,
    /// Leaves and branches.
    Vegetation = 2,
    /// Roofs and walls.
    Building = 3,
    /// Overhead wires.
    Wire = 4,
    /// Carriers of wires.
    Tower = 5,
    /// Decks of bridges.
    Deck = 6,
    /// Not said.
    Unknown = 7,
}

/// The kind of a class; `None`: noise.
pub(super) fn kind(class: u8) -> Option<PointKind> {
    Some(match class {
        // Ground, key points of models, water, rails, roads.
        2 | 8..=11 => PointKind::Ground,
        3..=5 => PointKind::Vegetation,
        6 => PointKind::Building,
        7 | 18 => return None,
        13 | 14 => PointKind::Wire,
        15 => PointKind::Tower,
        17 => PointKind::Deck,
        _ => PointKind::Unknown,
    })
}

impl PointKind {
    const ALL: [Self; 8] = [
        Self::Ground,
        Self::Surface,
        Self::Vegetation,
        Self::Building,
        Self::Wire,
        Self::Tower,
        Self::Deck,
        Self::Unknown,
    ];

    /// Finds a kind by its number.
    pub fn of(number: u8) -> Self {
        Self::ALL.get(usize::from(number)).copied().unwrap_or(Self::Unknown)
    }

    /// Returns the paint where points have no colour.
    pub fn paint(self) -> Paint {
        let (colour, material) = match self {
            Self::Ground | Self::Surface => ([140, 132, 112], Material::Soil),
            Self::Vegetation => ([82, 106, 56], Material::Broadleaf),
            Self::Building => ([152, 122, 108], Material::Unknown),
            Self::Wire => ([64, 66, 70], Material::Metal),
            Self::Tower => ([128, 132, 136], Material::Metal),
            Self::Deck => ([150, 148, 142], Material::Concrete),
            Self::Unknown => ([104, 112, 78], Material::Unknown),
        };
        Paint { colour, material }
    }
}
