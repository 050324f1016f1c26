//! The surface between two lines, and the rows that it fills.

use super::Rows;
use crate::simd::{Floats, Ints, LANES, Mask, Simd, Sixteen};

/// Least height above a ray of what is on it, metres: keeps quotients finite.
const TOUCH: f32 = 1.0e-30;

/// Inverse depth of what touches the eye, 1/metres.
const AT_EYE: f32 = 1.0e30;

/// Where each plane's surface is at a line.
#[derive(Clone, Copy)]
pub struct Post<V: Simd> {
    /// Height above the eye, metres.
    pub z: V::F,
    /// Depth, metres.
    pub depth: V::F,
    /// Tangent of its elevation angle: z / depth.
    pub slope: V::F,
}

/// The surface between two lines, in the planes that are `inside` the area.
#[derive(Clone, Copy)]
pub struct Segment<V: Simd> {
    /// At the nearer line.
    pub last: Post<V>,
    /// At the farther one.
    pub post: Post<V>,
    /// Planes that count.
    pub inside: V::M,
}

/// The rows that are still open.
pub struct Open<'r, V: Simd> {
    simd: V,
    rows: Rows<'r>,
    depth: V::F,
    /// First open row of each plane.
    next: V::I,
    /// Tangent of its elevation angle.
    pub tangent: V::F,
    /// Height of its ray per unit of major distance, metres.
    slope: V::F,
    /// Greatest slope of the surface so far: the crest behind which it is hidden.
    crest: V::F,
}

impl<'r, V: Simd> Open<'r, V> {
    /// All rows are open. `depth`: metres per unit of major distance.
    #[inline(always)]
    pub fn new(simd: V, rows: Rows<'r>, depth: V::F) -> Self {
        let tangent = simd.splat(rows.tangents[0]);
        let crest = simd.splat(f32::NEG_INFINITY);
        Self { simd, rows, depth, next: simd.splat_int(0), tangent, slope: tangent * depth, crest }
    }

    /// Planes whose next ray is above the height `z` (metres above the eye) at a major distance.
    #[inline(always)]
    pub fn clears(&self, distance: V::F, z: V::F) -> V::M {
        self.slope.neg_mul_add(distance, z).lt(self.simd.splat(0.0))
    }

    /// The first row that a segment fills in any plane.
    #[inline(always)]
    pub fn first_risen(&self, segment: &Segment<V>) -> Option<usize> {
        let height = self.tangent.neg_mul_add(segment.post.depth, segment.post.z);
        let risen = self.simd.splat(0.0).le(height) & segment.inside;
        risen.any().then(|| self.next.least(risen) as usize)
    }

    /// Everything is at the eye.
    #[cold]
    pub fn flood(&mut self) {
        self.rows.inverse.fill(Sixteen([AT_EYE; LANES]));
        self.next = self.simd.splat_int(self.rows.inverse.len() as i32);
        self.tangent = self.simd.splat(f32::INFINITY);
        self.slope = self.tangent;
    }

    /// Raises the crest to a post.
    #[inline(always)]
    pub fn raise(&mut self, post: &Post<V>) {
        self.crest = self.crest.max(post.slope);
    }

    /// Fills the rows from `first` on that a segment hides. `refine(inverse depth, tangent, heights above the ray at
    /// both ends)` has the last word on each.
    #[inline(always)]
    pub fn fill(
        &mut self,
        segment: &Segment<V>,
        first: usize,
        refine: impl Fn(V::F, V::F, [V::F; 2]) -> V::F,
    ) {
        let Segment { last, post, inside } = *segment;
        let (zero, touch) = (self.simd.splat(0.0), self.simd.splat(TOUCH));
        // Where the segment begins behind a crest, its first row is cut by it.
        let start = self.next;
        let cut = last.slope.lt(self.crest);
        let any_cut = cut.any();
        for row in first..self.rows.inverse.len() {
            let tangent = self.simd.splat(self.rows.tangents[row]);
            let after = tangent.neg_mul_add(post.depth, post.z);
            let covered = zero.le(after) & inside;
            if !covered.any() {
                break;
            }
            let index = self.simd.splat_int(row as i32);
            let new = covered & self.next.eq(index);
            // A ray that is under the surface already ended at the nearer line.
            let before = tangent.neg_mul_add(last.depth, last.z).min(zero);
            let after = after.max(touch);
            let inverse = (after - before) * (after * last.depth - before * post.depth).recip();
            let mut edge = self.simd.splat_int(0);
            if any_cut {
                edge = self.edge(row).select(cut & start.eq(index), edge);
            }
            // Without an edge, too: the last bits of a quotient would tell of edges that are not there.
            let inverse = with_edge(self.simd, refine(inverse, tangent, [before, after]), edge);
            inverse.store_masked(new, &mut self.rows.inverse[row].0);
            let above = self.simd.splat(self.rows.tangents[row + 1]);
            self.next = self.simd.splat_int(row as i32 + 1).select(new, self.next);
            self.tangent = above.select(new, self.tangent);
        }
        self.slope = self.tangent * self.depth;
    }

    /// Leaves the rest to the sky.
    #[inline(always)]
    pub fn finish(self) {
        let zero = self.simd.splat(0.0);
        let first = self.next.least(self.simd.mask(u16::MAX)).max(0) as usize;
        for row in first..self.rows.inverse.len() {
            let index = self.simd.splat_int(row as i32);
            let begins = self.next.eq(index);
            let mut sky = zero;
            if begins.any() {
                let edge = self.edge(row).select(begins, self.simd.splat_int(0));
                sky = with_edge(self.simd, zero, edge);
            }
            let open = !self.next.gt(index);
            sky.store_masked(open, &mut self.rows.inverse[row].0);
        }
    }

    /// How far the crests reach from the row below to this one, in sixteenths; 0 where they do not.
    #[inline(always)]
    fn edge(&self, row: usize) -> V::I {
        let Some(below) = row.checked_sub(1).map(|below| self.rows.tangents[below]) else {
            return self.simd.splat_int(0);
        };
        let per_row = EDGE_STEPS as f32 / (self.rows.tangents[row] - below);
        let reach = (self.crest - self.simd.splat(below)) * self.simd.splat(per_row);
        let last = self.simd.splat((EDGE_STEPS - 1) as f32);
        reach.max(self.simd.splat(0.0)).min(last).to_int()
    }
}

/// Steps in which the share of a row that a crest covers is told.
pub const EDGE_STEPS: i32 = 16;

/// Inverse depth whose last bits tell where in the row an edge lies: finer than its own precision matters.
#[inline(always)]
fn with_edge<V: Simd>(simd: V, inverse: V::F, edge: V::I) -> V::F {
    ((inverse.to_bits() & simd.splat_int(!(EDGE_STEPS - 1))) | edge).as_floats()
}
