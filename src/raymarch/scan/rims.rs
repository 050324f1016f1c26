//! Rims: where a surface ends at a void, or begins behind one.
//!
//! ```text
//! a cell has a surface if its four posts have
//! from one line to the next a plane runs through one cell, or through two: up to where it crosses a column of
//! posts, and from there
//!     there:     as high as the cell before says, then as the cell behind; none has no height
//!     the line:  a surface if the cell before it or the one behind it has
//! ```
//!
//! Heights where planes cross lines do not tell: between two lines with a surface, or a line with and one without,
//! there may be a part of a cell or none, and a saw-tooth along the rim is what is lost otherwise.
//!
//! Between two lines of a longer stride the surface is looked at if any of the planes has it at either line: a corner of it may
//! stand into the way of a plane that is over a void at both. Where all planes are over a void at both nothing is looked for.

use super::ground::Crease;
use super::lines::Lines;
use super::march::Planes;
use super::profile::{NO_SLOPE, Post, SampleLine};
use crate::simd::{Floats, Kernel, LANES, Mask, Simd, Sixteen};
use crate::voxel::Grid;

/// Lengths of a cell that a plane may run through at once: more are not one cell.
const ONE_CELL: f32 = 1.001;

/// Slopes below this are no surface's.
const LEAST_SLOPE: f32 = 0.5 * NO_SLOPE;

/// A post that is reached past a rim.
struct RimCrossing<'r, 'a> {
    lines: &'r Lines<'a>,
    slope: &'r Sixteen,
    line: SampleLine,
}

/// The way of planes there, as a function of its own: few come by.
struct RimPassage<'p, 'f, 'a, V: Simd> {
    planes: &'p mut Planes<'f, 'a, V>,
    crossing: RimCrossing<'p, 'a>,
}

impl<V: Simd> Kernel for RimPassage<'_, '_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.planes.cross(&self.crossing);
    }
}

impl<'a, V: Simd> Planes<'_, 'a, V> {
    /// Whether, at the last post and the next one, some plane has a surface and some has none: there may be a rim between.
    #[inline(always)]
    pub(super) fn is_at_rim(&self, slope: V::F) -> bool {
        let (before, behind) = (self.is_nothing(self.last), self.is_nothing(slope));
        (before | behind).any() && !(before & behind).all()
    }

    /// Planes that have no surface where their slope is this.
    #[inline(always)]
    pub(super) fn is_nothing(&self, slope: V::F) -> V::M {
        slope.lt(self.simd.splat(LEAST_SLOPE))
    }

    /// Takes in the surface from where the march is to a post; on the way there may be a `rim`.
    #[inline(always)]
    pub(super) fn pass(&mut self, lines: &Lines<'a>, post: Post<V>, rim: bool) {
        if rim {
            // What a cold function is given lies in memory: a copy, so that all other posts need not.
            let mut slope = Sixteen::default();
            post.slope.store(&mut slope.0);
            self.pass_rim(RimCrossing { lines, slope: &slope, line: post.line });
            return;
        }
        self.reach(post);
    }

    #[cold]
    fn pass_rim(&mut self, crossing: RimCrossing<'_, 'a>) {
        self.simd.call(RimPassage { planes: self, crossing });
    }

    /// Takes in the surface up to where planes cross a column of posts, what begins there, and the line if a cell before or behind it
    /// has a surface.
    #[inline(always)]
    fn cross(&mut self, crossing: &RimCrossing<'_, 'a>) {
        let &RimCrossing { lines, slope, line: mark } = crossing;
        let slope = self.simd.load(&slope.0);
        let inverse = self.ground.per_depth * self.simd.splat(1.0 / mark.distance);
        let mut post = Post { slope, inverse, line: mark };
        let side = Grid::side_units(mark.level) as f32;
        if self.is_at_rim(slope)
            && mark.distance - self.reached < ONE_CELL * side
            && !self.is_at_edge(mark.distance)
        {
            post.slope = self.cross_cells(lines, &post);
        }
        self.reach(post);
    }

    /// Slope of a post where one of the cells that it borders on has a surface, after what lies before it.
    #[inline(always)]
    fn cross_cells(&mut self, lines: &Lines<'a>, post: &Post<V>) -> V::F {
        let simd = self.simd;
        let SampleLine { line, level, distance, share: until, .. } = post.line;
        let ahead = self.ground.forward;
        let side = Grid::side_units(level) as f32;
        let (from, to) = (simd.splat(self.reached), simd.splat(distance));
        let Crease { ends: [_, b], cells, crosses, column, share } =
            self.ground.crease(lines, level, [from, to]);
        let (column, share) = (column.select(crosses, b), share.select(crosses, simd.splat(1.0)));
        let at = (to - from).mul_add(share, from);
        let along = (at - to).mul_add(simd.splat(1.0 / side), simd.splat(until));
        let inverse = (self.ground.depth * at).recip();
        let mark = self.crossing(post.line, crosses, share);
        let mut slopes = cells;
        for (side, slope) in slopes.iter_mut().enumerate() {
            let cell = cells[side];
            let codes = self.ground.cell(lines, line, [cell, column - cell], along);
            let z = self.displaced(level, self.ground.height(codes, at), at);
            *slope = self.ground.slope(z, inverse);
        }

        let [ends, begins] = slopes;
        self.join(Post { slope: ends, inverse, line: mark });
        self.join(Post { slope: begins, inverse, line: mark });
        let nothing = simd.splat(LEAST_SLOPE);
        let next = self.ground.cell(lines, line + ahead, [cells[1], b - cells[1]], simd.splat(0.0));
        let is_rim = self.ground.is_nothing(next) & begins.lt(nothing);

        simd.splat(NO_SLOPE).select(is_rim, post.slope)
    }

    /// Returns the place at which planes cross on their way to a line, on average: colour is taken from there.
    #[inline(always)]
    fn crossing(&self, mark: SampleLine, crosses: V::M, share: V::F) -> SampleLine {
        let mut shares = Sixteen::default();
        share.store(&mut shares.0);
        let bits = crosses.bits();
        let (mut sum, mut count) = (0.0, 0.0_f32);
        for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
            sum += shares.0[lane];
            count += 1.0;
        }
        let back = (mark.distance - self.reached) * (1.0 - sum / count.max(1.0));
        let side = Grid::side_units(mark.level) as f32;
        if count == 0.0 {
            return mark;
        }
        SampleLine { distance: mark.distance - back, share: mark.share - back / side, ..mark }
    }
}
