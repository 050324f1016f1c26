//! Ranges up to which each level, and ground at all, is seen.

use super::options::RenderOptions;
use crate::raymarch::LevelBands;
use crate::space::{Camera, Footprint};
use crate::voxel::Header;

/// The bands of distance in which `camera` sees each level.
pub fn level_bands(header: &Header, camera: &Camera, options: &RenderOptions) -> LevelBands {
    let clearance = camera.pose.eye.z - header.height_range.high;
    let (grid, count) = (&header.grid, header.level_count);
    match camera.footprint() {
        Footprint::Angle(angle) => {
            let bands = LevelBands::new(grid, count, angle, clearance, options.detail)
                .with_span_pixels(options.far_spans);
            let has_spans = header.has_spans;
            if has_spans { bands.with_bare_ground(grid, angle, clearance, options.detail) } else { bands }
        }
        Footprint::Width(width) => LevelBands::uniform(grid, count, width, options.detail),
    }
}

/// Ground distance beyond which an area without end ([`RenderOptions::tile_world`]) is sky, metres: haze leaves less than
/// a thousandth of any ground there. In clear air it is infinite; the marcher then sets an end of its own.
pub fn far_limit(header: &Header, camera: &Camera, options: &RenderOptions) -> f64 {
    options.atmosphere(header).reach(camera.pose.eye.z, header.height_range.high)
}
