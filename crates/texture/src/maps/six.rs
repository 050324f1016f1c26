//! Six maps along axes at steps of 30°, added up.
//!
//! ```text
//! tone(x, y, level) = √(1/6) · Σ strength_k · map_k(x·cos 30°k + y·sin 30°k, level)      k = 0 … 5
//! ```
//!
//! Pairs of maps are square to each other. As sin 60° is irrational, the sum never repeats exactly, and no
//! axis stands out.
//!
//! Source: Bunker and Ferris 1977 (AFHRL-TR-77-66).

use super::axis::ZoneTable;
use super::material::MapMaterial;
use super::wave::Sinusoid;

/// Maps that are added up.
const MAPS: usize = 6;

/// Strength of the map that carries waves.
const WAVE_BOOST: f64 = 4.0;

/// Strength of other maps beside waves.
const BESIDE_WAVES: f64 = 0.25;

/// Tables along six axes, and a sinusoid in place of the first if the ground has waves.
#[derive(Debug, Clone, PartialEq)]
pub struct SixMaps {
    tables: [ZoneTable; MAPS],
    wave: Option<Sinusoid>,
}

impl SixMaps {
    /// Tables by chance of 2^`exponent` zones, so wide at level 1 in the unit of the ground.
    pub fn new(width: f64, exponent: u32, seed: u64) -> Self {
        let table = |number| {
            ZoneTable::random(width, exponent, seed.wrapping_mul(MAPS as u64).wrapping_add(number as u64))
        };
        Self { tables: std::array::from_fn(table), wave: None }
    }

    /// Makes waves of these maps: crests along y, a wavelength apart along x, boosted; the other maps are
    /// reduced.
    #[must_use]
    pub fn with_waves(self, wavelength: f64) -> Self {
        let zone_width = self.tables[0].zone_width(1);
        Self { wave: Some(Sinusoid { wavelength, phase: 0.0, zone_width }), ..self }
    }

    /// Levels, at least one.
    pub fn levels(&self) -> u32 {
        self.tables[0].levels()
    }

    /// Width of zones at a level from 1, in the unit of the ground.
    pub fn zone_width(&self, level: u32) -> f64 {
        self.tables[0].zone_width(level)
    }

    /// Level for a view in which a unit of ground covers so many pixels; the shorter way of two counts.
    pub fn level_for(&self, pixels_per_unit: f64) -> u32 {
        self.tables[0].level_for(pixels_per_unit)
    }

    /// Tone at a place, at a level from 1: of zero mean and unit deviation at level 1.
    pub fn tone(&self, x: f64, y: f64, level: u32) -> f64 {
        self.weighted(&MapMaterial::PLAIN, x, y, level)
    }

    /// Tones of the primaries on a material, where the view asks for a level from 1.
    pub fn tones(&self, material: &MapMaterial, x: f64, y: f64, level: u32) -> [f64; 3] {
        if material.is_inhibited {
            return [0.0; 3];
        }
        let tone = self.weighted(material, x, y, material.level(level));
        material.primaries.map(|strength| strength * tone)
    }

    fn weighted(&self, material: &MapMaterial, x: f64, y: f64, level: u32) -> f64 {
        let map = |number: usize| {
            let (sin, cos) = (number as f64 * 30.0).to_radians().sin_cos();
            let along = x * cos + y * sin;
            let tone = match self.wave {
                Some(wave) if number == 0 => WAVE_BOOST * wave.tone(along, level),
                Some(_) => BESIDE_WAVES * self.tables[number].tone(along, level),
                None => self.tables[number].tone(along, level),
            };
            material.strengths[number] * tone
        };
        (0..MAPS).map(map).sum::<f64>() / (MAPS as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::chance::Random;

    /// Mean product of tones a shift apart, over places by chance.
    fn correlation(maps: &SixMaps, shift: [f64; 2], samples: u32) -> f64 {
        let mut random = Random(22);
        let mut sum = 0.0;
        for _ in 0..samples {
            let [x, y] = [random.unit() * 3e5, random.unit() * 3e5];
            sum += maps.tone(x, y, 1) * maps.tone(x + shift[0], y + shift[1], 1);
        }
        sum / f64::from(samples)
    }

    fn shifted(length: f64, degrees: f64) -> [f64; 2] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [length * cos, length * sin]
    }

    #[test]
    fn no_correlation_far_off_exceeds_a_fifth() {
        let maps = SixMaps::new(8.0, 10, 3);
        assert!((correlation(&maps, [0.0, 0.0], 20_000) - 1.0).abs() < 0.03);

        // Square to an axis, its map is constant: a sixth. Elsewhere, and along lengths that repeat in a
        // table, less.
        for length in [40.0, 64.0, 300.0, 1024.0, 8192.0, 20_000.0] {
            for degrees in [0.0, 7.5, 15.0, 30.0, 90.0, 101.0, 120.0, 165.0] {
                let got = correlation(&maps, shifted(length, degrees), 20_000);
                assert!(got.abs() < 0.2, "{got} at {length} ft, {degrees}°");
            }
        }
    }

    #[test]
    fn contrast_differs_by_less_than_a_tenth_among_directions() {
        let maps = SixMaps::new(8.0, 10, 4);
        for step in [2.0, 4.0, 8.0] {
            let differences: Vec<f64> = (0..24)
                .map(|number| 1.0 - correlation(&maps, shifted(step, f64::from(number) * 7.5), 40_000))
                .collect();
            let most = differences.iter().copied().fold(0.0, f64::max);
            let least = differences.iter().copied().fold(f64::INFINITY, f64::min);
            let mean = differences.iter().sum::<f64>() / 24.0;
            assert!((most - least) / mean < 0.1, "{step} ft: {least} to {most}");
        }
    }

    #[test]
    fn contrast_of_the_sum_falls_with_levels() {
        let maps = SixMaps::new(8.0, 10, 5);
        let deviation = |level: u32| {
            let mut random = Random(5);
            let tones: Vec<f64> =
                (0..20_000).map(|_| maps.tone(random.unit() * 1e5, random.unit() * 1e5, level)).collect();
            (tones.iter().map(|tone| tone * tone).sum::<f64>() / tones.len() as f64).sqrt()
        };
        let measured: Vec<f64> = (1..=7).map(deviation).collect();
        assert!(measured.windows(2).all(|pair| pair[1] < 0.85 * pair[0]), "{measured:?}");
    }

    #[test]
    fn materials_choose_maps_primaries_and_levels() {
        let maps = SixMaps::new(8.0, 7, 6);
        for place in 0..200 {
            let (x, y) = (f64::from(place) * 13.7, f64::from(place) * -5.1);
            assert_eq!(maps.tones(&MapMaterial::RIVER, x, y, 1), [0.0; 3]);
            assert_eq!(maps.tones(&MapMaterial::PLAIN, x, y, 3), [maps.tone(x, y, 3); 3]);

            // Six maps alone add up to all.
            let alone = |number: usize| {
                let mut strengths = [0.0; 6];
                strengths[number] = 1.0;
                maps.tones(&MapMaterial { strengths, ..MapMaterial::PLAIN }, x, y, 1)[0]
            };
            let sum: f64 = (0..6).map(alone).sum();
            assert!((sum - maps.tone(x, y, 1)).abs() < 1e-12);
            let ploughed = maps.tones(&MapMaterial::PLOUGHED, x, y, 1)[2];
            assert!((ploughed - alone(0) - 0.25 * alone(3)).abs() < 1e-12);

            let red = MapMaterial { primaries: [1.0, 0.0, 0.0], ..MapMaterial::PLAIN };
            assert_eq!(maps.tones(&red, x, y, 1), [maps.tone(x, y, 1), 0.0, 0.0]);
            let biased = |level_bias| MapMaterial { level_bias, ..MapMaterial::PLAIN };
            assert_eq!(maps.tones(&biased(1), x, y, 2)[0], maps.tone(x, y, 3));
            assert_eq!(maps.tones(&biased(-9), x, y, 2)[0], maps.tone(x, y, 1));
        }
    }

    #[test]
    fn waves_peak_at_their_wavelength() {
        let maps = SixMaps::new(8.0, 7, 7).with_waves(64.0);
        // Power along x at whole numbers of waves over 6400 feet, over several lines.
        let power = |waves: u32| {
            let line = |y: f64| {
                let (mut re, mut im) = (0.0, 0.0);
                for sample in 0..1600 {
                    let x = f64::from(sample) * 4.0;
                    let angle = x / 6400.0 * f64::from(waves) * std::f64::consts::TAU;
                    let tone = maps.tone(x, y, 1);
                    (re, im) = (re + tone * angle.cos(), im + tone * angle.sin());
                }
                re * re + im * im
            };
            (0..6).map(|number| line(f64::from(number) * 777.0)).sum::<f64>()
        };
        let powers: Vec<f64> = (1..400).map(power).collect();
        let peak = (1..400).max_by(|&a, &b| powers[a - 1].total_cmp(&powers[b - 1])).unwrap();
        assert_eq!(6400 / peak, 64);
        let others = powers.iter().enumerate().filter(|&(number, _)| (number + 1).abs_diff(peak) > 2);
        assert!(others.fold(0.0_f64, |most, (_, &power)| most.max(power)) < 0.1 * powers[peak - 1]);
    }
}
