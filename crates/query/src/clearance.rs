//! Clearance of a line of sight above what lies below it, and the height that its far end lacks.
//!
//! ```text
//! for each piece of the way that leaves no half of a voxel, wherein ground is one patch and what stands has its planes:
//!     the ground below the line is a parabola there, ends of what stands are straight lines
//!     rises of the far end with which the line meets one of them: (its height − the line's) / share of the way, between the extremes of that
//! the least rise with which the line meets nothing that is opaque, and less of the rest than takes half of the light
//! ```
//!
//! Extremes are exact, so that what stands right before the eye counts in full. What lets light through is looked at in parts of an eighth of a voxel's side.

use std::f64::consts::LN_2;

use glam::DVec2;

use super::Ground;
use super::slabs::{Slab, Slabs, clip};
use hedgehop::raymarch::{CellStep, CellWalk, Extent, GridRay, Lattice, PageCursor};
use hedgehop::voxel::PageSource;
use hedgehop_base::error::Result;

/// Points so near a surface are on it, and so near the eye at it, metres.
pub(super) const TOUCH: f64 = 1.0e-6;

/// Parts of what lets light through that are looked at, per side of a voxel, and of one piece at most: lines that are all but vertical have long ones.
const PER_VOXEL: f64 = 8.0;
const MOST_PARTS: f64 = 4096.0;

/// Clearance of a line.
#[derive(Debug, Default)]
pub(super) struct Clearance {
    /// Point nearest to what lies below the line: share of the way, height of that, and how far the line is above it, metres.
    pub nearest: Option<(f64, f64, f64)>,
    /// Height that the far end lacks, metres; ∞: no height would do.
    pub missing: f64,
}

/// Finds the clearance along a ray as far as `length` metres, which is not vertical.
pub(super) fn clearance(source: &dyn PageSource, ray: &GridRay, length: f64) -> Result<Clearance> {
    let grid = source.header().grid;
    let (mut cursor, mut slabs) = (Ground::Bare.cursor(source), Slabs::new(source));
    let mut barriers = Barriers::default();
    let mut nearest = None;
    let size = DVec2::new(f64::from(grid.nx), f64::from(grid.ny));
    let Some((start, end)) = ray.clip(size, ray.height_at(0.0).max(ray.height_at(length))) else {
        return Ok(Clearance::default());
    };

    let spans = [grid.nx, grid.ny].map(|count| Extent::once(0, 2 * i64::from(count) - 1, 0.0));
    let halves = Lattice { side: 0.5, shift: 0.0, spans };

    // Ends aside, which are as near as they were asked for.
    let aside = (0.5 * ray.range_per_unit.abs().min_element() / length).min(0.25);
    for step in CellWalk::new(ray, halves, start, end.min(length)).filter(|step| step.enter < step.leave) {
        let piece = Piece::new(ray, &step, length);
        let inner = [aside, 1.0 - aside].map(|part| piece.share_of(part).clamp(0.0, 1.0));
        let mut below = |found: Option<(f64, f64, f64)>| {
            if let Some(found) = found
                && nearest.is_none_or(|(_, _, least)| found.2 < least)
            {
                nearest = Some(found);
            }
        };

        if let Some(ground) = ground_along(&mut cursor, ray, &step)? {
            let above = piece.over(ground);
            barriers.ground = barriers.ground.max(piece.most(&above));
            below(piece.nearest_ground(&above, inner));
        }

        let sides = (step.leave - step.enter) / grid.spacing;
        for slab in slabs.along([step.enter, step.leave].map(|range| ray.at(range).truncate()))? {
            barriers.add(&piece, slab, sides);
            below(piece.nearest_slab(slab, inner));
        }
    }

    Ok(Clearance { nearest, missing: barriers.first_gap() })
}

/// Returns how far one can see straight down from `eye`: the height where half of the light is gone, metres above the datum; ∞: the eye is below ground or within
/// something opaque.
pub(super) fn floor(source: &dyn PageSource, place: DVec2, eye: f64) -> Result<f64> {
    let spacing = source.header().grid.spacing;
    let units = (place - source.header().grid.origin) / spacing;
    let ground = Ground::Bare.height_at(source, place)?.unwrap_or(f64::NEG_INFINITY);
    let mut slabs = Slabs::new(source);
    let mut standing = slabs.along([units; 2])?.to_vec();
    standing.sort_by(|a, b| b.high[0].total_cmp(&a.high[0]));
    let (mut floor, mut depth) = (ground, 0.0);
    if eye < ground - TOUCH || standing.iter().any(|slab| slab.hides_in(eye)) {
        return Ok(f64::INFINITY);
    }

    for slab in standing.iter().filter(|slab| slab.low[0] < eye) {
        let (low, high) = (slab.low[0].max(ground), slab.high[0].min(eye));
        // Infinite of what is opaque.
        let rate = -(1.0 - slab.opacity).ln() / spacing;
        let room = (LN_2 - depth) / rate;
        if high - low >= room {
            floor = floor.max(high - room.max(0.0));
        }
        if rate.is_finite() {
            depth += rate * (high - low).max(0.0);
        }
    }

    Ok(floor)
}

impl Slab {
    /// Whether a height over the way's beginning lies within it, and it is opaque.
    pub fn hides_in(&self, height: f64) -> bool {
        self.opacity >= 1.0 && self.low[0] + TOUCH < height && height < self.high[0] - TOUCH
    }
}

/// The ground along a step as a polynomial of the share of the way, constant term first; it is one patch there. `None`: there is none.
fn ground_along(cursor: &mut PageCursor<'_>, ray: &GridRay, step: &CellStep) -> Result<Option<[f64; 3]>> {
    let mut heights = [0.0; 3];
    // Not at the ends, where a neighbour may be stored more coarsely.
    for (height, share) in heights.iter_mut().zip([0.25, 0.5, 0.75]) {
        let range = step.enter + share * (step.leave - step.enter);
        let Some(found) = cursor.finest_height(ray.at(range).truncate())? else { return Ok(None) };
        *height = found;
    }
    let [first, middle, last] = heights;
    let square = 8.0 * (first - 2.0 * middle + last);
    let linear = 2.0 * (last - first) - square;
    Ok(Some([middle - 0.5 * linear - 0.25 * square, linear, square]))
}

/// The polynomial's value at a share.
fn value([constant, linear, square]: [f64; 3], share: f64) -> f64 {
    constant + share * (linear + share * square)
}

/// A piece of the line, on which the Earth's curvature does not matter.
struct Piece {
    /// Begin, share of the whole way, and length.
    begin: f64,
    extent: f64,
    /// Heights of the line at its ends.
    heights: [f64; 2],
}

impl Piece {
    fn new(ray: &GridRay, step: &CellStep, length: f64) -> Self {
        let begin = if step.enter < TOUCH { 0.0 } else { step.enter / length };
        let heights = [step.enter, step.leave].map(|range| ray.height_at(range));
        Self { begin, extent: step.leave / length - begin, heights }
    }

    /// Share of the whole way at a share of the piece.
    fn part(&self, share: f64) -> f64 {
        self.begin + share * self.extent
    }

    /// The share of the piece that a share of the whole way is, also beside it.
    fn share_of(&self, part: f64) -> f64 {
        (part - self.begin) / self.extent
    }

    fn height(&self, share: f64) -> f64 {
        self.heights[0] + share * (self.heights[1] - self.heights[0])
    }

    /// Returns the height of a surface above the line.
    fn over(&self, [constant, linear, square]: [f64; 3]) -> [f64; 3] {
        [constant - self.heights[0], linear - (self.heights[1] - self.heights[0]), square]
    }

    /// Returns the height of something straight above the line, given at the piece's ends.
    fn over_line(&self, ends: [f64; 2]) -> [f64; 3] {
        self.over([ends[0], ends[1] - ends[0], 0.0])
    }

    /// The rise of the far end that brings the line up by `above` at a share of the piece.
    fn rise(&self, above: [f64; 3], share: f64) -> f64 {
        let part = self.part(share);
        if part > 0.0 {
            return value(above, share) / part;
        }
        // At the eye itself: nothing helps against what is above it, and what touches it counts as it goes on.
        match above[0] {
            above if above > TOUCH => f64::INFINITY,
            above if above < -TOUCH => f64::NEG_INFINITY,
            _ => above[1] / self.extent,
        }
    }

    /// The greatest rise that a surface asks for.
    fn most(&self, above: &[f64; 3]) -> f64 {
        let [constant, linear, square] = *above;
        let ends = self.rise(*above, 0.0).max(self.rise(*above, 1.0));
        // Where the derivative of rise is zero.
        let before = self.begin / self.extent;
        let product = (linear * before - constant) / square;
        let share = -product / (before + (before * before - product).sqrt());
        if share > 0.0 && share < 1.0 { ends.max(self.rise(*above, share)) } else { ends }
    }

    /// Finds where the line is nearest to ground, between two shares.
    fn nearest_ground(&self, above: &[f64; 3], [begin, end]: [f64; 2]) -> Option<(f64, f64, f64)> {
        let vertex = -0.5 * above[1] / above[2];
        let inside = (vertex > begin && vertex < end).then_some(vertex);
        let shares = [Some(begin), inside, Some(end)].into_iter().flatten().filter(|_| begin < end);
        let highest = shares.max_by(|a, b| value(*above, *a).total_cmp(&value(*above, *b)))?;
        let above = value(*above, highest);
        Some((self.part(highest), self.height(highest) + above, -above))
    }

    /// Finds where it is nearest to what stands below it, between two shares; leaves do not lie below what goes through them, but end at it.
    fn nearest_slab(&self, slab: &Slab, [begin, end]: [f64; 2]) -> Option<(f64, f64, f64)> {
        let mut part = [slab.part[0].max(begin), slab.part[1].min(end)];
        if part[0] >= part[1] {
            return None;
        }
        if slab.low[0].is_finite() {
            part = clip(part, [slab.low[0] - self.heights[0], slab.low[1] - self.heights[1]])?;
        }
        let found = part.map(|share| {
            let height = self.height(share);
            let high = slab.high[0] + share * (slab.high[1] - slab.high[0]);
            let top = if slab.opacity < 1.0 { high.min(height) } else { high };
            (self.part(share), top, height - top)
        });
        found.into_iter().min_by(|a, b| a.2.total_cmp(&b.2))
    }
}

/// Obstacles that the line would meet if its far end were higher.
#[derive(Debug)]
struct Barriers {
    /// The rise that clears all ground.
    ground: f64,
    /// Optical depth that comes with a rise, or goes with it if it is negative.
    changes: Vec<(f64, f64)>,
}

impl Default for Barriers {
    fn default() -> Self {
        Self { ground: f64::NEG_INFINITY, changes: Vec::new() }
    }
}

impl Barriers {
    /// Adds what stands over a piece that is `sides` of a voxel long.
    fn add(&mut self, piece: &Piece, slab: &Slab, sides: f64) {
        let high = piece.over_line(slab.high);
        let rise_low = |share: f64| match slab.low[0].is_finite() {
            true => piece.rise(piece.over_line(slab.low), share),
            false => f64::NEG_INFINITY,
        };
        let [begin, end] = slab.part;
        let upper = piece.rise(high, begin).max(piece.rise(high, end));
        if upper <= 0.0 {
            return;
        }
        if slab.opacity >= 1.0 {
            // All rises in between are those of a place in between.
            return self.change([rise_low(begin).min(rise_low(end)), upper], 1.0);
        }

        let sides = sides * (end - begin);
        let count = (sides * PER_VOXEL).ceil().clamp(1.0, MOST_PARTS);

        // Depth 1 hides, whatever else there is; a greater one would cost the sum its precision.
        let depth = (-(1.0 - slab.opacity).ln() * sides / count).min(1.0);
        for part in 0..count as u32 {
            let share = begin + (f64::from(part) + 0.5) / count * (end - begin);
            self.change([rise_low(share), piece.rise(high, share)], depth);
        }
    }

    fn change(&mut self, [low, high]: [f64; 2], depth: f64) {
        if high > 0.0 {
            self.changes.extend([(low, depth), (high, -depth)]);
        }
    }

    /// The least rise ≥ 0 with less depth than takes half of the light.
    fn first_gap(mut self) -> f64 {
        self.changes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let (mut rise, mut depth) = (self.ground.max(0.0), 0.0);
        for (at, change) in self.changes {
            if at > rise && depth < LN_2 {
                break;
            }
            rise = rise.max(at);
            depth += change;
        }
        rise
    }
}
