//! Generators of tiles, by the names that recipes give.

use hedgehop_base::chance::Random;
use hedgehop_base::error::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::cell_box::CellBox;
use crate::cells::{Cells, SIDE};
use crate::code::CyclicCode;
use crate::maps::{QuantityMode, tiled_maps, tiled_quantity, tiled_waves};
use crate::octaves::broad_band;
use crate::pattern::XorPattern;
use crate::polynomial::primitive_polynomials;
use crate::sea::Sea;
use crate::subterrain::{Subterrain, SubterrainCode};
use crate::superimposed::Superimposed;
use crate::tile::Tile;

/// Most octaves, of which the last has wavelengths up to 128 cells.
const MAX_OCTAVES: u32 = 6;

/// Most codes on top of each other.
const MAX_CODES: u32 = Superimposed::MAX_CODES as u32;

/// Wavelengths of waves in a tile, cells.
const WAVELENGTHS: std::ops::RangeInclusive<f64> = 3.0..=30.0;

/// Pattern of which a tile is made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "pattern", rename_all = "kebab-case")]
pub enum Generator {
    /// Three codes joined by exclusive or: white, without direction.
    White,
    /// Octaves of such patterns, equally strong, as in real ground.
    Broad {
        /// Octaves from wavelengths of 2 cells on, 1 to 6.
        octaves: u32,
    },
    /// One code, as in the study: ramps and jumps in lines.
    Codes,
    /// Several codes on top of each other.
    Superimposed {
        /// Codes, 1 to 8.
        codes: u32,
    },
    /// One code whose lines slip by chance.
    Mosaic {
        /// Lines that do not slip among each other, 1 to 255.
        lines: u32,
    },
    /// Six maps along axes some 30° apart.
    Maps,
    /// Sawteeth, stripes and checks of linear functions.
    Quantity {
        /// Use of the functions.
        mode: QuantityMode,
    },
    /// Waves with a little of the maps.
    Waves {
        /// Length of a wave, 3 to 30 cells.
        wavelength: f64,
    },
    /// Codes that drift over each other, at a time.
    Sea {
        /// Codes, 1 to 8.
        codes: u32,
        /// Steps of the codes, of which 255 are a period.
        time: f64,
    },
}

impl Generator {
    /// All generators as they are by name alone.
    pub const ALL: [Self; 9] = [
        Self::White,
        Self::Broad { octaves: 4 },
        Self::Codes,
        Self::Superimposed { codes: 8 },
        Self::Mosaic { lines: 8 },
        Self::Maps,
        Self::Quantity { mode: QuantityMode::StripesXor },
        Self::Waves { wavelength: 6.0 },
        Self::Sea { codes: 4, time: 0.0 },
    ];

    /// The name in recipes.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Broad { .. } => "broad",
            Self::Codes => "codes",
            Self::Superimposed { .. } => "superimposed",
            Self::Mosaic { .. } => "mosaic",
            Self::Maps => "maps",
            Self::Quantity { .. } => "quantity",
            Self::Waves { .. } => "waves",
            Self::Sea { .. } => "sea",
        }
    }

    /// Finds a generator by its name, with its usual parameters.
    ///
    /// # Errors
    ///
    /// None has this name; the sentence lists those there are.
    pub fn named(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|generator| generator.name() == name).ok_or_else(|| {
            let names: Vec<String> =
                Self::ALL.iter().map(|generator| format!("\"{}\"", generator.name())).collect();
            Error::Configuration(format!("no texture is called \"{name}\"; want one of {}", names.join(", ")))
        })
    }

    /// Refuses a parameter that is out of its range.
    ///
    /// # Errors
    ///
    /// One is.
    pub fn check(self) -> Result<()> {
        match self {
            Self::Broad { octaves } => self.check_number("octaves", octaves, MAX_OCTAVES),
            Self::Superimposed { codes } => self.check_number("codes", codes, MAX_CODES),
            Self::Mosaic { lines } => self.check_number("lines", lines, SIDE as u32),
            Self::Waves { wavelength } if !WAVELENGTHS.contains(&wavelength) => {
                Err(Error::Configuration(format!(
                    "waves of {wavelength} cells are no texture of a tile; want {} to {}",
                    WAVELENGTHS.start(),
                    WAVELENGTHS.end()
                )))
            }
            Self::Sea { codes, time } => {
                self.check_number("codes", codes, MAX_CODES)?;
                let refused =
                    || Error::Configuration(format!("the time of a sea, {time}, is no finite number"));
                time.is_finite().then_some(()).ok_or_else(refused)
            }
            Self::White | Self::Codes | Self::Maps | Self::Quantity { .. } | Self::Waves { .. } => Ok(()),
        }
    }

    /// The pattern; a seed says which of all that are alike.
    ///
    /// # Errors
    ///
    /// A parameter is out of its range.
    pub fn cells(self, seed: u64) -> Result<Cells> {
        self.check()?;
        Ok(match self {
            Self::White => XorPattern::seeded(seed).cells(),
            Self::Broad { octaves } => broad(octaves, seed),
            Self::Codes => mosaic(SIDE, seed)?,
            Self::Superimposed { codes } => superimposed(codes, seed),
            Self::Mosaic { lines } => mosaic(lines as usize, seed)?,
            Self::Maps => tiled_maps(seed),
            Self::Quantity { mode } => tiled_quantity(mode, seed),
            Self::Waves { wavelength } => tiled_waves(wavelength, seed),
            Self::Sea { codes, time } => sea(codes, time, seed),
        })
    }

    /// The pattern as a tile, of zero mean over every voxel.
    ///
    /// # Errors
    ///
    /// A parameter is out of its range, or the pattern has no detail within voxels.
    pub fn tile(self, seed: u64) -> Result<Tile> {
        Tile::new(&self.cells(seed)?)
    }

    fn check_number(self, what: &str, number: u32, most: u32) -> Result<()> {
        if (1..=most).contains(&number) {
            return Ok(());
        }
        Err(Error::Configuration(format!(
            "the texture \"{}\" has {number} {what}; want 1 to {most}",
            self.name()
        )))
    }
}

fn broad(octaves: u32, seed: u64) -> Cells {
    let pattern = |octave| XorPattern::seeded(seed.wrapping_add(octave)).cells();
    broad_band(&(0..u64::from(octaves)).map(pattern).collect::<Vec<Cells>>())
}

fn superimposed(codes: u32, seed: u64) -> Cells {
    let codes = Superimposed::new(codes as usize);
    let [x, y] = drawn(seed);
    Cells::of(|column, row| codes.tone(column + x, row + y))
}

/// One code of a polynomial by a seed, whose lines slip by chance after so many.
fn mosaic(lines: usize, seed: u64) -> Result<Cells> {
    let polynomials: Vec<u64> = primitive_polynomials(8).collect();
    let code = CyclicCode::new(polynomials[(seed % polynomials.len() as u64) as usize])?;

    let mut random = Random::stream(seed, 2);
    let mut subterrain =
        |line: usize| Subterrain { first_line: line as i64, start: (random.unit() * SIDE as f64) as i64 };
    let laid = SubterrainCode::new(code, (0..SIDE).step_by(lines).map(&mut subterrain).collect())?;
    Ok(Cells::of(|column, row| f64::from(laid.tone(column, row))))
}

fn sea(codes: u32, time: f64, seed: u64) -> Cells {
    let sea = Sea::new(codes as usize);
    let [x, y] = drawn(seed);
    Cells::of(|column, row| {
        let (x0, y0) = ((column + x) as f64, (row + y) as f64);
        sea.mean(CellBox { x0, x1: x0 + 1.0, y0, y1: y0 + 1.0 }, time)
    })
}

/// Cell at which a pattern begins.
fn drawn(seed: u64) -> [i64; 2] {
    let mut random = Random::stream(seed, 1);
    [random.unit(), random.unit()].map(|unit| (unit * SIDE as f64) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_generator_makes_tiles_of_zero_mean_over_voxels() {
        let modes = QuantityMode::ALL.into_iter().skip(1).map(|mode| Generator::Quantity { mode });
        for generator in Generator::ALL.into_iter().chain(modes) {
            let [cells, other] = [0, 7].map(|seed| generator.cells(seed).unwrap());
            assert_ne!(cells, other, "{generator:?}");
            assert_eq!(cells, generator.cells(0).unwrap(), "{generator:?}");

            let tile = Tile::new(&cells).unwrap();
            assert_eq!(tile.largest_voxel_mean(), 0.0, "{generator:?}");
            assert!(tile.contrast_kept() > 0.93, "{generator:?} keeps {}", tile.contrast_kept());
        }
    }

    #[test]
    fn names_lead_to_generators() {
        for generator in Generator::ALL {
            assert_eq!(Generator::named(generator.name()).unwrap(), generator);
        }
        let error = Generator::named("grass").unwrap_err().to_string();
        assert!(error.contains("\"grass\"") && error.contains("\"superimposed\", \"mosaic\""), "{error}");
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        for (generator, words) in [
            (Generator::Broad { octaves: 0 }, "0 octaves; want 1 to 6"),
            (Generator::Superimposed { codes: 9 }, "9 codes; want 1 to 8"),
            (Generator::Mosaic { lines: 256 }, "256 lines"),
            (Generator::Waves { wavelength: 1.0 }, "want 3 to 30"),
            (Generator::Waves { wavelength: f64::NAN }, "want 3 to 30"),
            (Generator::Sea { codes: 1, time: f64::NAN }, "no finite number"),
            (Generator::Quantity { mode: QuantityMode::Inhibited }, "nothing is left"),
        ] {
            let error = generator.tile(0).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn a_tile_of_the_sea_repeats_after_a_period() {
        let sea = |time| Generator::Sea { codes: 4, time }.tile(3).unwrap();
        assert_eq!(sea(1.5), sea(256.5));
        assert_ne!(sea(1.5), sea(2.5));
    }
}
