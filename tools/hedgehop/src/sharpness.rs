//! Height above the ground from which an area looks sharp.
//!
//! ```text
//! detail   the side of the finest voxels, or of imagery's pixels where these are wider, metres
//! sharp    while a detail is no wider than so many pixels on ground that lies 30° below the horizon,
//!          twice as far away as it lies below the eye
//! ```

use glam::DVec2;

use crate::reference::metres;
use hedgehop::Result;
use hedgehop::space::{Camera, Pose};
use hedgehop::voxel::Header;

/// Pixels that a detail may be wide.
const PIXELS: f64 = 8.0;
/// Ratio of the distance of the ground in a picture's lower half to the eye's height.
const FARTHER: f64 = 2.0;
/// Pictures from lower than the sharp height by more than this look blurred to anybody.
const MUCH_LOWER: f64 = 4.0;
/// Poses of a flight that are looked at.
const MOST_POSES: usize = 64;

/// The picture that an area is told for: pixels across, and degrees.
const USUAL_WIDTH: f64 = 1280.0;
const USUAL_HFOV: f64 = 60.0;

/// Least detail of an area, metres.
fn detail(header: &Header) -> f64 {
    header.metadata.imagery_pixel.unwrap_or(0.0).max(header.grid.spacing)
}

/// Metres above the ground from which a detail looks sharp, where a pixel is so many radians wide.
fn sharp_height(detail: f64, pixel: f64) -> f64 {
    detail / (PIXELS * FARTHER * pixel)
}

/// The height from which usual pictures are sharp, metres above the ground.
pub fn usual_height(header: &Header) -> f64 {
    let pixel = 2.0 * (0.5 * USUAL_HFOV.to_radians()).tan() / USUAL_WIDTH;
    sharp_height(detail(header), pixel)
}

/// Says from which height on an area looks sharp, and why not from lower.
pub fn sentence(header: &Header) -> String {
    let spacing = header.grid.spacing;
    let what = match header.metadata.imagery_pixel {
        Some(pixel) if pixel > spacing => format!("the image's pixels of {} m", rounded(pixel)),
        _ => format!("voxels of {} m", metres(spacing)),
    };
    format!(
        "from about {} m above the ground (in pictures {USUAL_WIDTH} pixels and {USUAL_HFOV}° wide), because of {what}",
        rounded(usual_height(header))
    )
}

/// Picks poses of a flight, evenly spread over it.
pub fn some(poses: impl ExactSizeIterator<Item = Pose>) -> impl Iterator<Item = Pose> {
    let step = poses.len().div_ceil(MOST_POSES).max(1);
    poses.step_by(step)
}

/// Warns of a flight that is much too low for what an area shows.
pub fn warning(
    header: &Header,
    cameras: &[Camera],
    ground: impl Fn(DVec2) -> Result<Option<f64>>,
) -> Result<Option<String>> {
    let mut heights = Vec::new();
    for camera in cameras {
        let eye = camera.pose.eye;
        heights.extend(ground(eye.truncate())?.map(|ground| (eye.z - ground, camera.pixel_angle())));
    }

    heights.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(height, pixel)) = heights.get(heights.len() / 2) else { return Ok(None) };

    let detail = detail(header);
    let sharp = sharp_height(detail, pixel);

    // Below the ground nothing is sharp, for other reasons.
    if height <= 0.0 || height * MUCH_LOWER >= sharp {
        return Ok(None);
    }

    let wide = detail / (FARTHER * height * pixel);
    Ok(Some(format!(
        "from {} m above the ground this area shows more than it knows: its details of {} m are {} pixels wide there, and what is finer is made up. Fly at {} m or more, or build it from finer data",
        rounded(height),
        rounded(detail),
        rounded(wide),
        rounded(sharp)
    )))
}

/// Two significant digits.
fn rounded(number: f64) -> String {
    let step = 10_f64.powf(number.abs().max(1e-3).log10().floor() - 1.0);
    metres((number / step).round() * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sharpness_follows_from_detail_and_pixels() {
        // A voxel of 25 m spans 8 pixels of 0.9 mrad at 3464 m.
        let pixel = 2.0 * 30_f64.to_radians().tan() / 1280.0;
        assert!((sharp_height(25.0, pixel) - 1732.0).abs() < 1.0);
        assert!((sharp_height(25.0, pixel) * FARTHER * pixel * PIXELS - 25.0).abs() < 1e-9);
    }

    #[test]
    fn numbers_are_rounded_for_people() {
        assert_eq!([1732.05, 208.3, 17.3, 0.6928, 234.0].map(rounded), ["1700", "210", "17", "0.69", "230"]);
    }
}
