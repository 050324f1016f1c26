//! Which lines planes may see, beside the pages that they lie on.

use glam::DVec3;

use super::wedge::Wedge;
use super::{AROUND, BEFORE, COARSER, Footprint, Ring};
use crate::raymarch::scan::Stretch;
use crate::voxel::Grid;

impl Footprint<'_> {
    /// Notes which lines of a ring's part of a level planes may see, if somebody asks; its lowest surface is at `low`, metres above the datum,
    /// and `horizon` hides what is below it.
    pub(super) fn stretch(
        &mut self,
        eye: DVec3,
        wedge: &Wedge,
        own: &Ring,
        level: u8,
        (low, horizon): (f64, f64),
    ) {
        if self.stretches.is_none() {
            return;
        }
        let side = f64::from(Grid::side_units(level));
        let mut spans = [false; 3];
        let mut is_first = false;
        for (index, (stride, until)) in self.strides.of_level(level).enumerate() {
            let begin = stride.from / wedge.ground[1];
            let end = until / wedge.ground[0] + stride.block_units();
            if begin <= own.to && own.from <= end {
                spans[stride.lines.trailing_zeros() as usize] = true;
                // From another level to this one ground rises as it likes.
                let is_change = index == 0 && stride.from > 0.0;
                is_first |= is_change && own.from <= stride.from / wedge.ground[0] + stride.block_units();
            }
        }
        let margins = [BEFORE, AROUND].map(|voxels| voxels * side);
        let voxels = self.voxels(eye, wedge, own, level, margins);
        let before = own.from - margins[0];
        let mut stretch = Stretch {
            groups: wedge.groups,
            level,
            voxels,
            distances: [before.max(0.0), own.to + margins[1]],
            spans,
            flat: f32::NEG_INFINITY,
            seen: f32::NEG_INFINITY,
            minor: wedge.minor.map(|minor| minor as f32),
        };
        if !is_first && before > 0.0 {
            // What lies below the eye rises in the picture as it lies farther away.
            let depth = (eye.z - low + wedge.drop[1] * own.to * own.to).max(0.0);
            let length = f64::from(stretch.widest()) * side;
            // A surface that is followed rises above the crest by as much as is steep.
            let [near, far] = stretch.distances;
            let tangent = horizon + wedge.steep;
            let above = (tangent * near).min(tangent * far) + wedge.drop[0] * near * near;
            stretch.seen = ((eye.z + above - self.heights.offset) / self.heights.scale) as f32 - 1.0;
            stretch.flat = ((wedge.steep * before - depth * length / before) / self.heights.scale) as f32;
        }
        let last = self.sides[usize::from(level)].last[wedge.major];
        let [nearest, farthest] = voxels[wedge.major];
        // The area's last line is read whatever the stride, and stands for as many as the one before it, which may be another level's.
        let is_whole = stretch.pages().all(|page| self.source.has(page));
        if nearest == 0 || farthest == last || !is_whole {
            stretch.spans = [true; 3];
        }
        self.stretches.iter_mut().for_each(|all| all.push(stretch));
        if !is_whole && level + 1 < self.level_count {
            let margin = COARSER * f64::from(Grid::side_units(level + 1));
            let voxels = self.voxels(eye, wedge, own, level + 1, [margin; 2]);
            let distances = [(own.from - margin).max(0.0), own.to + margin];
            let coarser = Stretch { level: level + 1, voxels, distances, ..stretch };
            self.stretches.iter_mut().for_each(|all| all.push(coarser));
        }
    }
}
