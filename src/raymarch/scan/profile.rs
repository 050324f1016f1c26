//! Visible profile of sixteen planes: the posts at which the surface rises above everything before.

use crate::simd::{Each, Floats, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::voxel::Grid;

/// Tangent of the elevation of what is no surface: below any ray.
pub const NO_SLOPE: f32 = -1.0e18;

/// A line that the planes saw, and the stretch of surface that ends in it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VisibleSegment {
    /// Tangent of each plane's elevation to the surface, times depth per ground distance as rows have it.
    pub slope: Sixteen,
    /// Inverse depth, 1/metres.
    pub inverse: Sixteen,
    /// Line of the post.
    pub line: SampleLine,
}

/// A line: where a segment's surface and its colour come from.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SampleLine {
    /// Index of the line at its level.
    pub line: i64,
    /// Major distance, units.
    pub distance: f32,
    /// Share of the way from the line before it; 1 on the line itself.
    pub share: f32,
    /// Level index.
    pub level: u8,
    /// Lines from one that was read to the next, 1, 2 or 4: what a colour stands for.
    pub span: u8,
    /// Nothing of the surface before it is in sight.
    pub begins: bool,
    /// The level stands in for a finer one, of which a page is absent.
    pub stands_in: bool,
}

/// Sights of one group of planes, nearest first: the surface goes straight from each to the next, unless that one
/// [begins](SampleLine::begins).
///
/// Every row's range and light follow from it: a plane's ray ends where the first stretch rises above it.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    /// The segments, then the march's last post if it is none of them, then what is left of longer profiles.
    segments: Vec<VisibleSegment>,
    count: usize,
    /// Whether the march's last post is the last segment.
    is_joined: bool,
}

/// A post of each plane on its way into the profile.
#[derive(Clone, Copy)]
pub struct Post<V: Simd> {
    /// Tangent of its elevation.
    pub slope: V::F,
    /// Inverse depth, 1/metres.
    pub inverse: V::F,
    /// Line of the posts.
    pub line: SampleLine,
}

impl Profile {
    /// Sights, nearest first.
    pub fn segments(&self) -> &[VisibleSegment] {
        &self.segments[..self.count]
    }

    /// Rows of all planes together whose middles see a level that stands in for an absent finer one; `centres`: their tangents, rising.
    pub fn rows_stood_in(&self, centres: &[f32]) -> u64 {
        let segments = self.segments();
        // Where all is stored this is all there is to do.
        if !segments.iter().any(|segment| segment.line.stands_in) {
            return 0;
        }

        let below = |horizon: &Sixteen| -> u64 {
            horizon.0.iter().map(|horizon| centres.partition_point(|centre| centre < horizon) as u64).sum()
        };
        let mut horizon = Sixteen([NO_SLOPE; LANES]);

        // Rows below the horizon at the beginning of a run of stretches that stand in.
        let mut run: Option<u64> = None;
        let mut rows = 0;
        for segment in segments.iter().filter(|segment| !segment.line.begins) {
            match run {
                None if segment.line.stands_in => run = Some(below(&horizon)),
                Some(first) if !segment.line.stands_in => {
                    rows += below(&horizon) - first;
                    run = None;
                }
                _ => {}
            }
            horizon
                .0
                .iter_mut()
                .zip(segment.slope.0)
                .for_each(|(horizon, slope)| *horizon = horizon.max(slope));
        }

        rows + run.map_or(0, |first| below(&horizon) - first)
    }

    /// A copy without room for more.
    #[must_use]
    pub fn compact(&self) -> Self {
        let end = self.segments.len().min(self.count + 1);
        Self { segments: self.segments[..end].to_vec(), count: self.count, is_joined: self.is_joined }
    }

    /// Cuts stretches so that none rises by more than `step` metres where it passes through heights `low` to `high` metres above the eye: what is linear on each
    /// then follows what is not, such as the upper edge of fog on a cliff. Nothing can be added afterwards.
    pub fn refine(&mut self, isa: Isa, [low, high]: [f32; 2], step: f32) {
        let cuts = isa.run(Passing { segments: self.segments(), heights: [low, high], step });
        if cuts.is_empty() {
            return;
        }
        let mut segments =
            Vec::with_capacity(self.count + cuts.iter().map(|(_, parts)| parts - 1).sum::<usize>());
        let mut done = 0;
        for (index, parts) in cuts {
            segments.extend_from_slice(&self.segments[done..index]);
            let ends = &self.segments[index - 1..=index];
            segments.extend((1..parts).map(|part| between(ends, part as f32 / parts as f32)));
            done = index;
        }
        segments.extend_from_slice(&self.segments[done..self.count]);
        self.count = segments.len();
        self.segments = segments;
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.count = 0;
        self.is_joined = false;
    }

    /// The march goes on from a post; what is before it is not in sight.
    #[inline(always)]
    pub fn begin<V: Simd>(&mut self, post: &Post<V>) {
        self.is_joined = false;
        self.put(self.count, post, true);
    }

    /// The march goes from its last post to this one, in sight or not. Which one is hard to foretell, so that nothing branches on it.
    #[inline(always)]
    pub fn add<V: Simd>(&mut self, post: &Post<V>, in_sight: bool) {
        let index = self.count + usize::from(in_sight & !self.is_joined);
        self.put(index, post, !in_sight);
        self.count = index + usize::from(in_sight);
        self.is_joined = in_sight;
    }

    /// Returns the profile's end, with room for some posts more.
    #[inline(always)]
    pub fn end(&mut self, posts: usize) -> ProfileEnd<'_> {
        if self.count + posts >= self.segments.len() {
            self.grow(posts);
        }
        ProfileEnd {
            segments: &mut self.segments,
            count: self.count,
            is_joined: self.is_joined,
            kept: (&mut self.count, &mut self.is_joined),
        }
    }

    /// Slopes and inverse depths of the march's last post.
    #[inline(always)]
    pub fn last<V: Simd>(&self, simd: V) -> [V::F; 2] {
        let segment = &self.segments[self.count - usize::from(self.is_joined)];
        [simd.load(&segment.slope.0), simd.load(&segment.inverse.0)]
    }

    /// Returns the mark of the march's last post.
    pub fn last_line(&self) -> SampleLine {
        self.segments[self.count - usize::from(self.is_joined)].line
    }

    #[inline(always)]
    fn put<V: Simd>(&mut self, index: usize, post: &Post<V>, begins: bool) {
        if index >= self.segments.len() {
            self.grow(1);
        }
        let segment = &mut self.segments[index];
        post.slope.store(&mut segment.slope.0);
        post.inverse.store(&mut segment.inverse.0);
        segment.line = SampleLine { begins, ..post.line };
    }

    #[cold]
    fn grow(&mut self, posts: usize) {
        self.segments.resize(2 * self.segments.len() + posts + 64, VisibleSegment::default());
    }
}

/// End of a profile while posts are added one after the other.
pub struct ProfileEnd<'p> {
    segments: &'p mut [VisibleSegment],
    count: usize,
    is_joined: bool,
    /// The same two in the profile.
    kept: (&'p mut usize, &'p mut bool),
}

impl ProfileEnd<'_> {
    /// Adds a post, as [`Profile::add`] does.
    #[inline(always)]
    pub fn add<V: Simd>(&mut self, post: &Post<V>, in_sight: bool) {
        let index = self.count + usize::from(in_sight & !self.is_joined);
        debug_assert!(index < self.segments.len(), "more posts than there is room for");
        if let Some(segment) = self.segments.get_mut(index) {
            post.slope.store(&mut segment.slope.0);
            post.inverse.store(&mut segment.inverse.0);
            segment.line = SampleLine { begins: !in_sight, ..post.line };
        }
        self.count = index + usize::from(in_sight);
        self.is_joined = in_sight;
    }

    /// Leaves them in the profile.
    #[inline(always)]
    pub fn finish(self) {
        (*self.kept.0, *self.kept.1) = (self.count, self.is_joined);
    }
}

/// Parts of a stretch at most.
const MOST_PARTS: f32 = 24.0;

/// A segment that lies a share of the stretch between two: inverse depth is linear in the tangent there.
fn between(ends: &[VisibleSegment], share: f32) -> VisibleSegment {
    let [from, to] = [&ends[0], &ends[1]];
    let mut segment = *to;
    for lane in 0..LANES {
        let start = from.slope.0[lane];
        // Walls, which begin at no finite tangent, stay whole.
        let share = if start < 0.5 * NO_SLOPE { 0.0 } else { share };
        segment.slope.0[lane] = (to.slope.0[lane] - start).mul_add(share, start);
        let start = from.inverse.0[lane];
        segment.inverse.0[lane] = (to.inverse.0[lane] - start).mul_add(share, start);
    }
    let own = share * to.line.share;
    let side = Grid::side_units(to.line.level) as f32;
    segment.line.distance -= (to.line.share - own) * side;
    segment.line.share = own;
    segment
}

/// Finds stretches that pass through some heights.
struct Passing<'s> {
    segments: &'s [VisibleSegment],
    /// Metres above the eye.
    heights: [f32; 2],
    step: f32,
}

impl Kernel for Passing<'_> {
    /// The segments that they end in, and the parts that each is to have.
    type Output = Vec<(usize, usize)>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let [low, high] = self.heights.each(|height| simd.splat(height));
        let mut cuts = Vec::new();
        let mut last = None;
        for (index, segment) in self.segments.iter().enumerate() {
            let (slope, inverse) = (simd.load(&segment.slope.0), simd.load(&segment.inverse.0));
            // Its height over that of the eye is slope over inverse depth.
            let (above, below) = ((low * inverse).lt(slope), slope.lt(high * inverse));
            if let Some((was_above, was_below)) = last
                && !segment.line.begins
                && ((above | was_above) & (below | was_below)).any()
            {
                let rise = rise(&self.segments[index - 1..=index], self.heights);
                let parts = (rise / self.step).min(MOST_PARTS).ceil();
                if parts > 1.0 {
                    cuts.push((index, parts as usize));
                }
            }

            last = Some((above, below));
        }

        cuts
    }
}

/// Returns the rise of the steepest segment of a plane that passes through some heights, metres.
fn rise(ends: &[VisibleSegment], [low, high]: [f32; 2]) -> f32 {
    let lanes = (0..LANES).map(|lane| {
        let [from, to] = [&ends[0], &ends[1]].each(|segment| segment.slope.0[lane] / segment.inverse.0[lane]);
        let passes = ends[0].slope.0[lane] > 0.5 * NO_SLOPE && from.max(to) > low && from.min(to) < high;
        if passes { (to - from).abs() } else { 0.0 }
    });
    lanes.fold(0.0, f32::max)
}
