//! The two surfaces of a level, cell by cell: bilinear between posts, and the voxels' own tops.

use glam::{DVec2, DVec3};

use super::{CellStep, GridRay, PageCursor};
use crate::error::Result;
use crate::voxel::PageSource;

/// Which surface is seen.
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
    /// From heights south-west, south-east, north-west, north-east, metres.
    pub fn new([sw, se, nw, ne]: [f64; 4]) -> Self {
        Self { base: sw, east: se - sw, north: nw - sw, twist: ne - se - nw + sw }
    }

    /// Height at (u, v), metres.
    pub fn height(&self, u: f64, v: f64) -> f64 {
        self.base + self.east * u + self.north * v + self.twist * u * v
    }

    /// Range at which a ray first is on or under the patch within a step through its cell, metres.
    ///
    /// Along a ray u, v and z are linear in range, so the ray's height above the patch is a
    /// quadratic: its first root is exact, and no root between two borders can be missed.
    pub fn first_contact(&self, ray: &GridRay, step: &CellStep, side: f64) -> Option<f64> {
        let enter = ray.at(step.enter);
        let (u, v) =
            (enter.x / side - (step.cell[0] as f64 + 0.5), enter.y / side - (step.cell[1] as f64 + 0.5));
        let (du, dv) = (ray.slope.x / side, ray.slope.y / side);
        let above = enter.z - self.height(u, v);
        if above <= 0.0 {
            return Some(step.enter);
        }
        let linear = ray.slope.z - self.east * du - self.north * dv - self.twist * (u * dv + v * du);
        let quadratic = -self.twist * du * dv;
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

/// Range and face normal where a ray first is on or in a column of height `top` metres.
pub(super) fn block_contact(ray: &GridRay, step: &CellStep, top: f64, side: f64) -> Option<(f64, DVec3)> {
    if ray.height_at(step.enter) <= top {
        return Some((step.enter, entered_face(ray, step, side)));
    }
    let down = (top - ray.eye.z) / ray.slope.z;
    (ray.slope.z < 0.0 && down <= step.leave).then_some((down, DVec3::Z))
}

/// Normal of the vertical face through which the ray entered the cell; up, if it began inside.
fn entered_face(ray: &GridRay, step: &CellStep, side: f64) -> DVec3 {
    if step.enter == 0.0 {
        return DVec3::Z;
    }
    let enter = ray.at(step.enter);
    let near = |position: f64, slope: f64, cell: i64| {
        let border = (cell + i64::from(slope < 0.0)) as f64 * side;
        if slope == 0.0 { f64::INFINITY } else { (position - border).abs() }
    };
    if near(enter.x, ray.slope.x, step.cell[0]) <= near(enter.y, ray.slope.y, step.cell[1]) {
        DVec3::new(-ray.slope.x.signum(), 0.0, 0.0)
    } else {
        DVec3::new(0.0, -ray.slope.y.signum(), 0.0)
    }
}

/// Height of the level-1 smooth surface at a world position (metres), metres above the datum;
/// `None` outside the area and where there is no surface.
pub fn ground_height<S: PageSource>(source: &S, position: DVec2) -> Result<Option<f64>> {
    let grid = source.header().grid;
    if !grid.contains(position) {
        return Ok(None);
    }
    let units = (position - grid.origin) / grid.spacing;
    PageCursor::new(source).smooth_height(0, units)
}

impl<S: PageSource> PageCursor<'_, S> {
    /// Height of a level's smooth surface at a position in units, metres; `None` where there is no
    /// surface or its page is absent.
    pub fn smooth_height(&mut self, level: u8, units: DVec2) -> Result<Option<f64>> {
        let (cell, fraction) = self.cell_at(level, units);
        let Some(corners) = self.corners(level, cell)? else { return Ok(None) };
        let height = Patch::new(corners).height(fraction.x, fraction.y);
        Ok((!height.is_nan()).then_some(height))
    }

    /// The smooth surface's cell that holds a position in units (clamped into the area), and the
    /// position within it, 0…1.
    pub(super) fn cell_at(&self, level: u8, units: DVec2) -> ([i64; 2], DVec2) {
        let side = f64::from(crate::voxel::Grid::side_units(level));
        let dims = self.dims(level);
        let lattice = units / side - 0.5;
        let cell = [
            (lattice.x.floor() as i64).clamp(-1, dims[0] - 1),
            (lattice.y.floor() as i64).clamp(-1, dims[1] - 1),
        ];
        let within = lattice - DVec2::new(cell[0] as f64, cell[1] as f64);
        (cell, within.clamp(DVec2::ZERO, DVec2::ONE))
    }
}
