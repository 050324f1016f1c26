//! Rows on farmed ground: tracks of wheels in fields, tilled ground under vines and fruit trees.

use glam::DVec2;

use super::super::kinds::FieldRows;
use super::footprint::{Footprint, clip};
use super::round::chance;
use super::strips::Strips;

/// Rows of one field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RowLattice {
    /// Direction of the rows: that of the longest edge of the outline.
    pub along: DVec2,
    /// Distance of a row from the origin, to the left of the direction, metres.
    pub first: f64,
    /// Distance between rows, metres.
    pub step: f64,
}

/// Most rows of one field: what is wider has none beyond.
const MOST_ROWS: i64 = 20_000;
/// Tracks of a tractor's wheels: their width, and from the middle of one to the middle of the other, metres.
const TRACK: f64 = 0.4;
const GAUGE: f64 = 1.8;
/// Widths of tilled ground under vines and under fruit trees, metres.
const UNDER_VINES: f64 = 0.6;
const UNDER_FRUIT: f64 = 1.0;
/// Widths of sprayers, metres: tractors drive where the one before ended.
const SPRAYERS: [f64; 5] = [18.0, 21.0, 24.0, 27.0, 36.0];

impl RowLattice {
    /// Rows of a kind over an outline; `hash` tells it from others.
    pub fn of(rows: FieldRows, footprint: &Footprint, hash: u64) -> Self {
        let edges = footprint.rings[0].iter().zip(footprint.rings[0].iter().cycle().skip(1));
        let longest = edges.max_by(|(a, b), (c, d)| a.distance(**b).total_cmp(&c.distance(**d)));
        let along = longest.and_then(|(a, b)| (*b - *a).try_normalize()).unwrap_or(DVec2::X);
        let step = match rows {
            FieldRows::Tramlines => SPRAYERS[(chance(hash, 11) * SPRAYERS.len() as f64) as usize],
            FieldRows::Vines => 2.0 + chance(hash, 12),
            FieldRows::Fruit => 3.5 + 1.5 * chance(hash, 13),
        };

        // Half a width from the longest edge, where the first sprayer drives.
        let edge = longest.map_or(0.0, |(a, _)| along.perp().dot(*a));
        Self { along, first: edge + 0.5 * step, step }
    }

    /// Distances of the middles of rows that may lie in an extent across, metres to the left of the origin.
    pub fn rows(&self, low: f64, high: f64) -> impl Iterator<Item = f64> + use<> {
        let Self { first, step, .. } = *self;
        let from = ((low - first) / step).floor() as i64;
        let to = (((high - first) / step).ceil() as i64).min(from.saturating_add(MOST_ROWS));
        (from..=to).map(move |index| first + step * index as f64)
    }

    /// Place in the nearest row, beside a place.
    pub fn nearest(&self, place: DVec2) -> DVec2 {
        let left = self.along.perp();
        let off = left.dot(place) - self.first;
        place - left * (off - (off / self.step).round() * self.step)
    }

    /// Strips of a field.
    pub fn strips(&self, rows: FieldRows, footprint: &Footprint) -> Strips {
        let tracks: &[(f64, f64)] = match rows {
            FieldRows::Tramlines => &[(-0.5 * GAUGE, TRACK), (0.5 * GAUGE, TRACK)],
            FieldRows::Vines => &[(0.0, UNDER_VINES)],
            FieldRows::Fruit => &[(0.0, UNDER_FRUIT)],
        };
        let left = self.along.perp();
        let across = footprint.rings[0].iter().map(|place| left.dot(*place));
        let (low, high) =
            across.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let mut strips = Strips::default();

        for row in self.rows(low, high) {
            for (off, width) in tracks {
                let (near, far) = (row + off - 0.5 * width, row + off + 0.5 * width);
                let within = |ring: &Vec<DVec2>| {
                    let ring = clip(ring, |place| left.dot(place) - near);
                    clip(&ring, |place| far - left.dot(place))
                };
                let rings = footprint.rings.iter().map(within).filter(|ring| ring.len() > 2);
                strips.push(rings.collect());
            }
        }

        strips
    }
}
