//! The range images of a path as plain numbers, for comparison with other renderers.
//!
//! `range_N.f32` for frame N: one little-endian float32 a pixel, row by row from the top: metres from the
//! eye along the ray through the centre of the pixel (slant range), +∞ for the sky.

use std::path::Path;

use hedgehop::Result;
use hedgehop::encode::atomic::write_bytes;
use hedgehop::frame::Frame;

/// Writes the ranges of frame `number` into `folder`, which is made if need be.
pub(super) fn dump(folder: &Path, number: u64, frame: &Frame) -> Result<()> {
    write_bytes(&folder.join(format!("range_{number}.f32")), &bytes(&frame.range))
}

fn bytes(ranges: &[f32]) -> Vec<u8> {
    ranges.iter().flat_map(|range| range.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn sky_is_infinity_and_numbers_are_little_endian() {
        assert_eq!(bytes(&[1.5, f32::INFINITY]), [0, 0, 0xc0, 0x3f, 0, 0, 0x80, 0x7f]);
    }
}
