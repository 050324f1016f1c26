//! Voxels along lines: which, how far along, how far to the side.
//!
//! ```text
//! along a segment        off = distance from its line
//! outside of a bend      off = the greater of the distances from both lines: their edges meet in a mitre;
//!                        of bends by more than a right angle the tip is cut off: a bevel through the edges' own ends
//! beyond the ends        off = distance from the end (round), or nothing (butt)
//! ```
//! An edge at half the width w is where off = w, whatever w is. Where several hold, the least counts.

use glam::DVec2;

use super::super::layer::bounds;
use super::footprint::share_of;
use super::solid::Square;

/// A line of segments that have a length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    places: Vec<DVec2>,
    /// Distance of each place along the line, metres.
    along: Vec<f64>,
}

/// End of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ends {
    Round,
    Butt,
}

/// A voxel beside a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cross {
    pub column: usize,
    pub row: usize,
    /// Distance of its centre from the line, metres, ≥ 0.
    pub off: f64,
    /// Distance along the line, metres.
    pub along: f64,
    /// Direction away from the line.
    pub outward: DVec2,
    /// Direction along the line.
    pub tangent: DVec2,
}

/// Ratio by which a mitre reaches farther than its edges: at a right angle.
const MITRE: f64 = std::f64::consts::SQRT_2;

impl Line {
    /// Through these places; `None` if it has no length.
    pub fn of(places: &[DVec2]) -> Option<Self> {
        /// Places closer than this to the one before say nothing, metres.
        const CLOSE: f64 = 0.05;
        let (mut places, mut last) = (places.to_vec(), None);
        places.retain(|place| {
            let is_far = last.is_none_or(|last: DVec2| place.distance(last) > CLOSE);
            last = if is_far { Some(*place) } else { last };
            is_far
        });
        let mut length = 0.0;
        let steps = places.windows(2).map(|pair| pair[0].distance(pair[1]));
        let along: Vec<f64> = std::iter::once(0.0)
            .chain(steps.map(|step| {
                length += step;
                length
            }))
            .collect();
        (places.len() > 1 && length.is_finite()).then_some(Self { places, along })
    }

    /// Length, metres.
    pub fn length(&self) -> f64 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// Place at a distance along it, and the direction there.
    pub fn at(&self, along: f64) -> (DVec2, DVec2) {
        let segment = self.along.partition_point(|start| *start <= along).clamp(1, self.places.len() - 1) - 1;
        let (a, b) = (self.places[segment], self.places[segment + 1]);
        let tangent = (b - a).normalize_or_zero();
        let within = (along - self.along[segment]).clamp(0.0, self.along[segment + 1] - self.along[segment]);
        (a + tangent * within, tangent)
    }

    /// Distance along it of one of its places; `None` where it has none.
    pub fn along_of(&self, place: DVec2) -> Option<f64> {
        /// A place that was dropped for being close to another may be that one, metres.
        const NEAR: f64 = 0.1;
        let index = self.places.iter().position(|known| known.distance(place) < NEAR)?;
        self.along.get(index).copied()
    }

    /// Returns the distance of each place along the line, metres.
    pub fn distances(&self) -> &[f64] {
        &self.along
    }

    /// Returns the places of the line.
    pub fn places(&self) -> &[DVec2] {
        &self.places
    }

    /// Voxels no farther than `reach` (metres) off the line, each once, in the square's order.
    pub fn crosses(&self, square: &Square, reach: f64, ends: Ends) -> Vec<Cross> {
        let far = DVec2::splat(reach * MITRE);
        let around = |low: DVec2, high: DVec2| {
            let (low, high) = (low - far, high + far);
            [low.x, low.y, high.x, high.y]
        };
        let Some([west, south, east, north]) = bounds(self.places.iter().copied()) else { return Vec::new() };
        let (columns, rows) = square.touched(around(DVec2::new(west, south), DVec2::new(east, north)));
        let mut found: Vec<Option<Cross>> = vec![None; columns.len() * rows.len()];

        for (segment, ends_of) in self.places.windows(2).enumerate() {
            let (a, b) = (ends_of[0], ends_of[1]);
            for (column, row) in square.voxels(around(a.min(b), a.max(b))) {
                let cross = self.cross(segment, square.centre(column, row), ends);
                let Some(cross) = cross.filter(|cross| cross.off <= reach) else { continue };
                let slot = &mut found[(row - rows.start) * columns.len() + column - columns.start];
                if slot.is_none_or(|known| cross.off < known.off) {
                    *slot = Some(Cross { column, row, ..cross });
                }
            }
        }

        found.into_iter().flatten().collect()
    }

    /// A place beside a segment, or in the wedge behind it.
    fn cross(&self, segment: usize, place: DVec2, ends: Ends) -> Option<Cross> {
        let (a, b) = (self.places[segment], self.places[segment + 1]);
        let tangent = (b - a).try_normalize()?;
        let right = DVec2::new(tangent.y, -tangent.x);
        let (along, across) = ((place - a).dot(tangent), (place - a).dot(right));
        let start = self.along[segment];
        let side = |across: f64| if across < 0.0 { -1.0 } else { 1.0 };
        let cross = |off: f64, along: f64, outward: DVec2, tangent: DVec2| {
            Some(Cross { column: 0, row: 0, off, along, outward, tangent })
        };
        let length = self.along[segment + 1] - start;
        if (0.0..=length).contains(&along) {
            return cross(across.abs(), start + along, right * side(across), tangent);
        }

        let round = |end: DVec2, along: f64| {
            let away = place - end;
            let outward = away.try_normalize().unwrap_or(right);
            (ends == Ends::Round).then(|| cross(away.length(), along, outward, tangent)).flatten()
        };
        if along < 0.0 {
            return if segment == 0 { round(a, start) } else { None };
        }

        let Some(next) = self.places.get(segment + 2) else { return round(b, start + length) };
        let after = (*next - b).try_normalize()?;
        let from = place - b;
        if from.dot(after) > 0.0 {
            return None;
        }

        let right_after = DVec2::new(after.y, -after.x);
        let second = from.dot(right_after);

        // Back the way that it came, there is no outside of the bend.
        let Some(middle) = (right + right_after).try_normalize() else { return round(b, start + length) };
        // The outside of the bend, which is to the right where it turns left.
        let outer = if tangent.perp_dot(after) >= 0.0 { 1.0 } else { -1.0 };
        let (first, second) = (across * outer, second * outer);

        // The edge that is nearest is that of the segment which is farther off.
        let (mut off, mut outward) =
            if first >= second { (first, right * outer) } else { (second, right_after * outer) };
        let tip = middle * outer;
        let bevelled = from.dot(tip) / right.dot(middle).max(1e-3);
        if tangent.dot(after) < 0.0 && bevelled > off {
            (off, outward) = (bevelled, tip);
        }

        let tangent = (tangent + after).try_normalize().unwrap_or(tangent);
        cross(off.max(0.0), start + length, outward, tangent)
    }
}

impl Cross {
    /// Share of the voxel that a ribbon of half this width covers, 0…1.
    pub fn share(&self, half: f64, spacing: f64) -> f64 {
        let corner = std::f64::consts::FRAC_1_SQRT_2 * spacing;
        if self.off + corner <= half {
            return 1.0;
        }
        if self.off - corner >= half {
            return 0.0;
        }
        let within = |distance: f64| share_of(self.outward, distance / spacing);
        (within(half - self.off) - within(-half - self.off)).clamp(0.0, 1.0)
    }
}
