//! Contact of a ray with a displaced cell, in steps finer than its bumps.

use super::surface::Patch;
use super::{CellRect, CellStep, GridRay};
use crate::detail::Displacement;
use hedgehop_texture::CELLS_PER_VOXEL;

/// Steps across a bump of the finest kind.
const STEPS_PER_BUMP: f64 = 6.0;

/// Halvings of the step in which a ray dives under the surface.
const HALVINGS: u32 = 40;

/// A bilinear patch of the finest level with its displacement.
pub(super) struct DisplacedPatch<'d> {
    pub ground: Patch,
    /// Reach of displacements, metres.
    pub reach: Patch,
    /// Height below which the surface does not lie, metres above the datum.
    pub lowest: f64,
    pub displacement: &'d Displacement,
}

impl DisplacedPatch<'_> {
    /// Range at which a ray first is on or under the surface within a step through its cell, metres.
    pub fn first_contact(&self, ray: &GridRay, step: &CellStep, cell: CellRect) -> Option<f64> {
        if self.above(ray, step.enter, cell)? <= 0.0 {
            return Some(step.enter);
        }
        // A ray straight down never leaves its cell, but falls below it.
        let under = ray.under(self.lowest).map(|(under, _)| under).filter(|under| *under > step.enter);
        let leave = under.map_or(step.leave, |under| under.min(step.leave));

        // Steps lie at multiples of their length, wherever the search begins.
        let length = (ray.slope.truncate().length() * CELLS_PER_VOXEL as f64 * STEPS_PER_BUMP).recip();
        let mut before = step.enter;
        let mut index = (step.enter / length).floor() + 1.0;
        while before < leave {
            let behind = (index * length).min(leave);
            if self.above(ray, behind, cell)? <= 0.0 {
                return self.between(ray, [before, behind], cell);
            }
            (before, index) = (behind, index + 1.0);
        }
        None
    }

    /// Narrows down where a ray dives under the surface between two ranges.
    fn between(&self, ray: &GridRay, [mut before, mut behind]: [f64; 2], cell: CellRect) -> Option<f64> {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + behind);
            let ends = if self.above(ray, middle, cell)? <= 0.0 { &mut behind } else { &mut before };
            *ends = middle;
        }
        Some(behind)
    }

    /// Height of a ray above the surface at a range, metres; `None`: there is no surface.
    fn above(&self, ray: &GridRay, range: f64, cell: CellRect) -> Option<f64> {
        let at = ray.at(range);
        let place = at.truncate();
        let share = (place - cell.corner) / cell.extent;
        let reach = self.reach.height(share.x, share.y);
        let ground = self.ground.height(share.x, share.y);
        let height = at.z - ground - self.displacement.height(place, reach);
        (!height.is_nan()).then_some(height)
    }
}
