//! The two surfaces of a level, cell by cell: bilinear between posts, and the voxels' own tops.

use glam::{DVec2, DVec3};

use super::{CellRect, CellStep, GridRay, PageCursor};
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Kind of surface that is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Surface {
    /// Bilinear between the posts.
    #[default]
    Smooth,
    /// Each voxel a column with a flat top and vertical walls.
    Blocks,
}

/// A bilinear patch over one cell: `h(u, v) = base + east·u + north·v + twist·u·v`, metres, for
/// u, v in 0…1 from the cell's south-west post.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Patch {
    base: f64,
    east: f64,
    north: f64,
    twist: f64,
}

impl Patch {
    /// Builds the patch from heights south-west, south-east, north-west, north-east, metres.
    pub fn new([sw, se, nw, ne]: [f64; 4]) -> Self {
        Self { base: sw, east: se - sw, north: nw - sw, twist: ne - se - nw + sw }
    }

    /// Height at (u, v), metres.
    pub fn height(&self, u: f64, v: f64) -> f64 {
        self.base + self.east * u + self.north * v + self.twist * u * v
    }

    /// Range at which a ray first is on or under the patch within a step through its cell, metres.
    ///
    /// Along a ray u and v are linear in range, and z is quadratic, so the ray's height above the patch is a
    /// quadratic: its first root is exact, and no root between two borders can be missed.
    pub fn first_contact(&self, ray: &GridRay, step: &CellStep, cell: CellRect) -> Option<f64> {
        let CellRect { corner, extent } = cell;
        let enter = ray.at(step.enter);
        let at = (enter.truncate() - corner) / extent;
        let (u, v) = (at.x, at.y);
        let (du, dv) = (ray.slope.x / extent.x, ray.slope.y / extent.y);
        let above = enter.z - self.height(u, v);
        if above <= 0.0 {
            return Some(step.enter);
        }
        let rise = ray.rise_at(step.enter);
        let linear = rise - self.east * du - self.north * dv - self.twist * (u * dv + v * du);
        let quadratic = ray.bend - self.twist * du * dv;
        let length = step.leave - step.enter;
        first_root(quadratic, linear, above).filter(|&root| root <= length).map(|root| step.enter + root)
    }
}

/// Smallest positive root of `a·s² + b·s + c` for `c > 0`, without cancellation
/// (Press et al., *Numerical Recipes*, §5.6).
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (one, other) = (q / a, c / q);
    let positive = |root: f64| if root > 0.0 { root } else { f64::INFINITY };
    let root = positive(one).min(positive(other));
    root.is_finite().then_some(root)
}

/// Range and face normal where a ray first is on or in a column of height `top` metres that stands on `cell`.
pub(super) fn block_contact(
    ray: &GridRay,
    step: &CellStep,
    top: f64,
    cell: CellRect,
) -> Option<(f64, DVec3)> {
    if ray.height_at(step.enter) <= top {
        return Some((step.enter, entered_face(ray, step, cell)));
    }
    // A ray falls through a height once at most. One that has, and was over a hole then, rises here.
    let (down, _) = ray.under(top)?;
    (ray.rise_at(step.enter) < 0.0 && down <= step.leave).then_some((down, DVec3::Z))
}

/// Normal of the vertical face through which the ray entered the cell; up, if it began inside.
fn entered_face(ray: &GridRay, step: &CellStep, cell: CellRect) -> DVec3 {
    if step.enter == 0.0 {
        return DVec3::Z;
    }
    let enter = ray.at(step.enter);
    let CellRect { corner, extent } = cell;
    let near = |axis: usize| {
        let slope = ray.slope[axis];
        let border = corner[axis] + if slope < 0.0 { extent[axis] } else { 0.0 };
        if slope == 0.0 { f64::INFINITY } else { (enter[axis] - border).abs() }
    };
    if near(0) <= near(1) {
        DVec3::new(-ray.slope.x.signum(), 0.0, 0.0)
    } else {
        DVec3::new(0.0, -ray.slope.y.signum(), 0.0)
    }
}

/// Height of the finest smooth surface that is stored at a world position (metres), metres above the datum;
/// `None` outside the area and where there is no surface.
pub fn ground_height(source: &dyn PageSource, position: DVec2) -> Result<Option<f64>> {
    let grid = source.header().grid;
    if !grid.contains(position) {
        return Ok(None);
    }
    let units = (position - grid.origin) / grid.spacing;
    PageCursor::new(source).finest_height(units)
}

/// The same over the area repeated without end: `None` only where there is no surface.
pub fn endless_ground_height(source: &dyn PageSource, position: DVec2) -> Result<Option<f64>> {
    let grid = source.header().grid;
    let units = (position - grid.origin) / grid.spacing;
    PageCursor::new(source).endless().finest_height(units)
}

impl PageCursor<'_> {
    /// Height of the smooth surface of the finest level whose page is stored there, at a position in units, metres; `None` where there
    /// is no surface.
    pub fn finest_height(&mut self, units: DVec2) -> Result<Option<f64>> {
        self.height_from(0, units)
    }

    /// The same of `level` and coarser ones.
    pub fn height_from(&mut self, level: u8, units: DVec2) -> Result<Option<f64>> {
        let levels = self.source().header().level_count;
        for level in level..levels {
            let (cell, _) = self.cells(level).cell_at(units);
            if self.corners(level, cell)?.is_some() {
                return self.smooth_height(level, units);
            }
        }
        Ok(None)
    }

    /// Height of a level's smooth surface at a position in units, metres; `None` where there is no
    /// surface or its page is absent.
    pub fn smooth_height(&mut self, level: u8, units: DVec2) -> Result<Option<f64>> {
        let (cell, fraction) = self.cells(level).cell_at(units);
        let Some(corners) = self.corners(level, cell)? else { return Ok(None) };
        let height = Patch::new(corners).height(fraction.x, fraction.y);
        Ok((!height.is_nan()).then_some(height))
    }
}
