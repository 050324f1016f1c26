//! Table of tones along an axis on the ground, with coarser levels.
//!
//! ```text
//! address(s, level) = ⌊s / (width·2^(level − 1))⌋ mod (entries / 2^(level − 1))
//! table of a level  = means of pairs of the level below
//! by chance: address XOR mask(number of the repetition)/2^(level − 1), so that no repetition is as another
//! level for a view  = least n from 1 with width·2^(n − 1)·pixels per unit ≥ 8
//! ```
//!
//! Masks keep pairs together, at all levels. Without them an axis and the one square to it would agree where
//! the table repeats.
//!
//! Source: Bunker and Ferris 1977 (AFHRL-TR-77-66); masks are ours. Its worked table prints 5 for the mean of
//! 3 and 9; here it is 6.

use hedgehop_base::chance::Random;
use hedgehop_base::error::{Error, Result};

/// Fewest pixels that a zone shall cover.
pub(super) const MIN_ZONE_PIXELS: f64 = 8.0;

/// Tones of zones along an axis, which repeat, at all levels.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneTable {
    width: f64,
    /// Tones by level, from 1.
    levels: Vec<Vec<f64>>,
    /// Seed of the masks of repetitions; none if all are alike.
    masks: Option<u64>,
}

impl ZoneTable {
    /// Takes tones of zones that are so wide at level 1, in the unit of the ground.
    ///
    /// # Errors
    ///
    /// The number of tones is no power of two, or the width is not above zero.
    pub fn new(width: f64, tones: Vec<f64>) -> Result<Self> {
        if !tones.len().is_power_of_two() {
            return Err(Error::Configuration(format!(
                "a table of {} zones cannot be halved from level to level; want a power of two, such as 64",
                tones.len()
            )));
        }
        if !(width > 0.0 && width.is_finite()) {
            return Err(Error::Configuration(format!("zones are {width} wide; want a width above 0")));
        }
        Ok(Self::of(width, tones, None))
    }

    /// Tones by chance for 2^`exponent` zones, up to 2^20, of zero mean and unit deviation; each repetition
    /// is in another order.
    pub fn random(width: f64, exponent: u32, seed: u64) -> Self {
        let mut random = Random::stream(seed, u64::from(exponent));
        let drawn: Vec<f64> = (0..1_usize << exponent.min(20)).map(|_| random.unit() - 0.5).collect();
        let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
        let squares: f64 = drawn.iter().map(|tone| (tone - mean).powi(2)).sum();
        let deviation = (squares / drawn.len() as f64).sqrt().max(f64::MIN_POSITIVE);
        Self::of(width, drawn.iter().map(|tone| (tone - mean) / deviation).collect(), Some(seed))
    }

    fn of(width: f64, tones: Vec<f64>, masks: Option<u64>) -> Self {
        let halved = |tones: &Vec<f64>| {
            let pairs = tones.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            (tones.len() > 1).then(|| pairs.collect())
        };
        Self { width, levels: std::iter::successors(Some(tones), halved).collect(), masks }
    }

    /// Levels, at least one; the coarsest is one zone.
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }

    /// Width of zones at a level from 1, in the unit of the ground.
    pub fn zone_width(&self, level: u32) -> f64 {
        self.width * f64::from(2_u32.pow(self.clamped(level) - 1))
    }

    /// Tone at a place along the axis, at a level from 1; beyond the coarsest level it is that one's.
    pub fn tone(&self, along: f64, level: u32) -> f64 {
        let halvings = self.clamped(level) as usize - 1;
        let tones = &self.levels[halvings];
        let (zone, count) = ((along / self.zone_width(level)).floor() as i64, tones.len() as i64);

        let repetition = zone.div_euclid(count) as u64;
        let mask = self.masks.map_or(0, |seed| {
            (Random::stream(seed, repetition).unit() * self.levels[0].len() as f64) as usize >> halvings
        });
        tones[zone.rem_euclid(count) as usize ^ mask]
    }

    /// Least level whose zones cover eight pixels, where a unit of ground covers so many; the shorter way of
    /// two counts.
    pub fn level_for(&self, pixels_per_unit: f64) -> u32 {
        let wide = |level: &u32| self.zone_width(*level) * pixels_per_unit >= MIN_ZONE_PIXELS;
        (1..=self.levels()).find(wide).unwrap_or(self.levels())
    }

    /// Standard deviation of the tones of a level.
    pub fn contrast(&self, level: u32) -> f64 {
        let tones = &self.levels[self.clamped(level) as usize - 1];
        let mean = tones.iter().sum::<f64>() / tones.len() as f64;
        (tones.iter().map(|tone| (tone - mean).powi(2)).sum::<f64>() / tones.len() as f64).sqrt()
    }

    fn clamped(&self, level: u32) -> u32 {
        level.clamp(1, self.levels())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worked() -> [ZoneTable; 2] {
        [vec![1.0, 7.0, 6.0, 3.0], vec![3.0, 9.0, 2.0, 4.0]].map(|tones| ZoneTable::new(32.0, tones).unwrap())
    }

    #[test]
    fn worked_sums_are_exact() {
        let [x, y] = worked();
        let sums =
            |row: f64| [0.0, 32.0, 64.0, 96.0].map(|column| x.tone(column + 5.0, 1) + y.tone(row + 31.0, 1));
        assert_eq!(sums(96.0), [5.0, 11.0, 10.0, 7.0]);
        assert_eq!(sums(0.0), [4.0, 10.0, 9.0, 6.0]);
        // Sixteen cells, then all repeats.
        assert_eq!(sums(96.0 + 128.0), sums(96.0));
        assert_eq!(x.tone(-1.0, 1), 3.0);
    }

    #[test]
    fn levels_are_means_of_pairs() {
        let [x, y] = worked();
        assert_eq!([0.0, 64.0].map(|at| y.tone(at, 2)), [6.0, 3.0]);
        assert_eq!([0.0, 64.0].map(|at| x.tone(at, 2)), [4.0, 4.5]);
        assert_eq!((y.tone(1e6, 3), y.tone(0.0, 99), y.levels()), (4.5, 4.5, 3));
    }

    #[test]
    fn zones_widen_from_8_to_512_feet_over_seven_levels() {
        let table = ZoneTable::random(8.0, 10, 1);
        let widths: Vec<f64> = (1..=7).map(|level| table.zone_width(level)).collect();
        assert_eq!(widths, [8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0]);

        // A level changes where its zones shrink below eight pixels.
        assert_eq!((table.level_for(1.0), table.level_for(0.999), table.level_for(0.5)), (1, 2, 2));
        assert_eq!((table.level_for(1.0 / 64.0), table.level_for(1e-9)), (7, 11));
    }

    #[test]
    fn contrast_falls_from_level_to_level() {
        for seed in 0..20 {
            let table = ZoneTable::random(8.0, 10, seed);
            assert!((table.contrast(1) - 1.0).abs() < 1e-12);
            for level in 1..7 {
                let share = table.contrast(level + 1) / table.contrast(level);
                assert!(share < 1.0, "seed {seed}, level {level}: {share}");
            }
            assert!(table.contrast(5) < 0.45, "{}", table.contrast(5));
        }
    }

    #[test]
    fn repetitions_differ_and_keep_their_levels() {
        let table = ZoneTable::random(8.0, 6, 9);
        let line =
            |from: i64| (0..64).map(|zone| table.tone((from + zone) as f64 * 8.0, 1)).collect::<Vec<f64>>();
        assert_ne!(line(0), line(64));
        assert_ne!(line(-64), line(0));
        for zone in -200..200 {
            let pair = [0.0, 8.0].map(|step| table.tone(f64::from(zone) * 16.0 + step, 1));
            assert_eq!(table.tone(f64::from(zone) * 16.0, 2), 0.5 * (pair[0] + pair[1]));
        }
    }

    #[test]
    fn tables_that_cannot_be_halved_are_refused() {
        assert!(ZoneTable::new(8.0, vec![1.0; 3]).unwrap_err().to_string().contains("power of two"));
        assert!(ZoneTable::new(8.0, vec![]).is_err());
        assert!(ZoneTable::new(0.0, vec![1.0; 4]).unwrap_err().to_string().contains("above 0"));
    }
}
