//! The finishing stage: from linear light to an 8-bit picture.
//!
//! ```text
//! rays, n × n a pixel, of each moment that the shutter is open ──filter──▶ light of pixels, mean of the moments
//! light · 2^exposure · vignette ──tone──▶ 0…1 ──gamma──▶ codes, rounded by the thresholds of the dither
//! ```
//!
//! Frames in linear light (EXR) take part in the first line alone: they are what a scene sends, which others expose.

mod curve;
mod filter;
#[cfg(test)]
mod tests;

pub use filter::{gather, thin};

use super::Picture;
use crate::scene::{Dither, Finish};
use crate::subimage::Farm;
use curve::Curve;

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// Sides of the squares that thresholds repeat in, pixels.
const SQUARE: usize = 8;

/// Makes an 8-bit picture of `width` × `height` pixels, `[row][column]`, of linear light in which 1 is display white. The result does not depend on the number of workers.
///
/// Light in the corners is 1 − [`Finish::vignette`] of what it was, and between the centre and there it falls as cos⁴ of the angle behind a simple lens:
/// `1/(1 + a·ρ²)²` at the share ρ of the half diagonal, `a = 1/√(1 − vignette) − 1`.
pub fn develop(light: &[[f32; 3]], [width, height]: [u32; 2], finish: &Finish, farm: &Farm) -> Picture {
    let (columns, rows) = (width as usize, height as usize);
    let mut rgb = vec![0; RGB * columns * rows];
    let curve = Curve::new(finish.tone, finish.gamma);
    let gain = finish.exposure.exp2();
    let falls = 1.0 / (1.0 - finish.vignette).sqrt() - 1.0;
    let (middle, corner) =
        ([0.5 * f64::from(width), 0.5 * f64::from(height)], f64::from(width).hypot(f64::from(height)));

    farm.rows(&mut rgb, RGB * columns, |row, codes| {
        let down = row as f64 + 0.5 - middle[1];
        let light = &light[row * columns..][..columns];
        for (column, (codes, light)) in codes.chunks_exact_mut(RGB).zip(light).enumerate() {
            let across = column as f64 + 0.5 - middle[0];
            let reach = 1.0 + falls * 4.0 * (across * across + down * down) / (corner * corner);
            let gain = (gain / (reach * reach)) as f32;
            let threshold = match finish.dither {
                Dither::None => 0.5,
                Dither::Ordered => threshold(column, row),
            };
            for (code, light) in codes.iter_mut().zip(light) {
                *code = curve.code(light * gain, threshold);
            }
        }
    });

    Picture { width, height, rgb }
}

/// Returns the threshold added to a code before it is cut off, 0…1: each of 64 values once in every square of 8 × 8 pixels, neighbours far apart (Bayer 1973).
fn threshold(column: usize, row: usize) -> f32 {
    let (mut differ, mut down, mut rank) = (column ^ row, row, 0);
    for _ in 0..SQUARE.ilog2() {
        rank = rank << 2 | (differ & 1) << 1 | down & 1;
        (differ, down) = (differ >> 1, down >> 1);
    }
    (rank as f32 + 0.5) / (SQUARE * SQUARE) as f32
}
