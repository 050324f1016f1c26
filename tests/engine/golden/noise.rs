//! Numbers that look like land, from sums, products and whole numbers alone: the same bits on every machine.

use glam::DVec2;
use hedgehop_testing::Random;

/// From octave to octave land is turned by this, so that no axis shows.
const TURN: DVec2 = DVec2::new(0.8, 0.6);

/// Draws the number of a cell, 0…1.
pub fn chance(x: i64, y: i64, seed: u64) -> f64 {
    let mix = |value: i64, factor: u64| (value as u64).wrapping_mul(factor);
    Random(mix(x, 0x9E6C_63D0_876A_9A99) ^ mix(y, 0xC2B2_AE3D_27D4_EB4F) ^ seed << 48).share()
}

/// Goes smoothly from 0 to 1 as `at` goes from one end to the other.
pub fn smooth(at: f64, [from, to]: [f64; 2]) -> f64 {
    let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Interpolates the numbers of cells of side 1, 0…1.
pub fn noise(at: DVec2, seed: u64) -> f64 {
    let cell = at.floor();
    let (x, y) = (cell.x as i64, cell.y as i64);
    let [east, north] = (at - cell).to_array().map(|share| smooth(share, [0.0, 1.0]));
    let [south_side, north_side] = [y, y + 1].map(|y| {
        let [west, east_end] = [x, x + 1].map(|x| chance(x, y, seed));
        west + (east_end - west) * east
    });
    south_side + (north_side - south_side) * north
}

/// Sums noise of ever shorter waves, 0…1.
pub fn fractal(at: DVec2, octaves: u32, seed: u64) -> f64 {
    let (mut at, mut share, mut sum, mut all) = (at, 1.0, 0.0, 0.0);
    for octave in 0..octaves {
        sum += share * noise(at, seed + u64::from(octave));
        all += share;
        share *= 0.5;
        at = TURN.rotate(at) * 2.0;
    }
    sum / all
}

/// Sums sharp crests, finer ones upon the high ones, 0…1.
pub fn crests(at: DVec2, octaves: u32, seed: u64) -> f64 {
    let (mut at, mut share, mut sum, mut above) = (at, 0.5, 0.0, 1.0);
    for octave in 0..octaves {
        let crest = 1.0 - (2.0 * noise(at, seed + u64::from(octave)) - 1.0).abs();
        above *= crest * crest;
        sum += share * above;
        above = crest;
        share *= 0.5;
        at = TURN.rotate(at) * 2.0;
    }
    sum
}
