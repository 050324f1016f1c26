//! Height of an eye above the ground about it.

use glam::DVec3;

use crate::raymarch::PageCursor;
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Level whose surface the height above ground is counted from.
const COARSE_LEVEL: u8 = 3;

/// Height of the eye (units, units, metres) above the ground about it, metres: of a coarse level, since it is not to change with every stone, or of what stands in
/// for it; above the lowest ground beside the area.
pub(super) fn height_above_ground(source: &dyn PageSource, eye: DVec3) -> Result<f64> {
    let header = source.header();
    let level = COARSE_LEVEL.min(header.level_count - 1);
    let is_over = eye.x >= 0.0
        && eye.y >= 0.0
        && eye.x <= f64::from(header.grid.nx)
        && eye.y <= f64::from(header.grid.ny);
    let ground = if is_over { PageCursor::new(source).height_from(level, eye.truncate())? } else { None };
    Ok((eye.z - ground.unwrap_or(header.height_range.low)).max(0.0))
}
