//! Classes of land cover, by the numbers of the *National Land Cover Database class legend* (Multi-Resolution Land
//! Characteristics Consortium, 2021).

use crate::grid::SIZE;
use crate::palette::Material;

/// Class of land cover; single crowns do not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Class {
    Water = 11,
    Snow = 12,
    Gardens = 21,
    /// Gravelled ways and yards.
    Roads = 22,
    /// Asphalt.
    Streets = 23,
    Buildings = 24,
    /// Rock, scree, gravel.
    Rock = 31,
    Broadleaved = 41,
    Coniferous = 42,
    MixedWood = 43,
    /// Heath and hedges.
    Heath = 52,
    Alp = 71,
    Pasture = 81,
    Crops = 82,
}

impl Class {
    /// Returns the class of a wood with a share of conifers.
    pub fn wood(conifers: f64) -> Self {
        match conifers {
            c if c > 0.55 => Self::Coniferous,
            c if c > 0.4 => Self::MixedWood,
            _ => Self::Broadleaved,
        }
    }
}

/// The class of ground that looks so, where nothing else is known of it.
pub fn class(material: Material) -> Class {
    use Material as M;

    match material {
        M::Pasture | M::PastureDry | M::PastureLush | M::Meadow | M::Hay => Class::Pasture,
        M::Wheat | M::Barley | M::Rape | M::Maize | M::Beet | M::Soil | M::Stubble => Class::Crops,
        M::Hedge | M::Heath => Class::Heath,
        M::BroadLight | M::BroadMid | M::BroadDark => Class::Broadleaved,
        M::Conifer | M::ConiferBlue => Class::Coniferous,
        M::ForestFloor => Class::MixedWood,
        M::RockPale | M::RockMid | M::RockDark | M::Scree | M::Gravel => Class::Rock,
        M::AlpGreen | M::AlpBrown => Class::Alp,
        M::Snow | M::SnowShade => Class::Snow,
        M::WaterDeep | M::WaterShallow => Class::Water,
        M::Asphalt => Class::Streets,
        M::Track => Class::Roads,
        M::RoofTile | M::RoofTileDark | M::RoofSlate | M::RoofWood | M::RoofMetal | M::Wall => {
            Class::Buildings
        }
        M::Yard | M::Garden => Class::Gardens,
    }
}

/// Classes of unfarmed ground.
const WILD: [Class; 7] = [
    Class::Snow,
    Class::Rock,
    Class::Heath,
    Class::Alp,
    Class::Broadleaved,
    Class::Coniferous,
    Class::MixedWood,
];

/// Gives unfarmed ground the class that most of it has within three pixels, so that patches are whole: the drawing mixes
/// materials grain by grain. Single pixels join those beside them.
pub fn settle(classes: &mut [Class], wild: &[bool]) {
    const REACH: usize = 3;

    let before = classes.to_vec();
    for (pixel, class) in classes.iter_mut().enumerate().filter(|(pixel, _)| wild[*pixel]) {
        let (row, column) = (pixel / SIZE, pixel % SIZE);
        let mut counts = [0u8; 256];
        for row in row.saturating_sub(REACH)..(row + REACH + 1).min(SIZE) {
            for column in column.saturating_sub(REACH)..(column + REACH + 1).min(SIZE) {
                let other = row * SIZE + column;
                counts[before[other] as usize] += u8::from(wild[other]);
            }
        }

        let most = WILD.into_iter().fold(*class, |best, other| {
            if counts[other as usize] > counts[best as usize] { other } else { best }
        });
        *class = most;
    }

    let before = classes.to_vec();
    for row in 1..SIZE - 1 {
        for column in 1..SIZE - 1 {
            let pixel = row * SIZE + column;
            let [a, b, c, d] = [pixel - 1, pixel + 1, pixel - SIZE, pixel + SIZE].map(|other| before[other]);
            let made = (Class::Roads..=Class::Buildings).contains(&before[pixel]);
            if !made && [a, b, c, d].iter().all(|&other| other != before[pixel]) {
                classes[pixel] = if c == d { c } else { a };
            }
        }
    }
}
