//! Strips painted on the ground: lines of roads, tracks of wheels, rows of plants.
//!
//! ```text
//! share of a voxel = sum of the areas of the strips, each clipped to the voxel (Sutherland and Hodgman 1974) / area of the voxel
//! ```
//! No strip lies on another of the same feature, so the sum is exact however wide the voxels are, and no pattern appears that is none.

use std::collections::BTreeMap;

use glam::{DVec2, dvec2};

use super::super::layer::bounds;
use super::super::read::rings::doubled_area;
use super::footprint::clip_all;
use super::solid::Square;

/// Steps of shares: far above what rounding takes, which depends on where places are counted from.
const STEPS: f64 = (1 << 20) as f64;

/// Outlines that are painted in one colour, metres in the database's system.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Strips(Vec<Strip>);

/// One outline: rings that run counter-clockwise, and holes that run clockwise.
#[derive(Debug, Clone, PartialEq)]
struct Strip {
    rings: Vec<Vec<DVec2>>,
    bounds: [f64; 4],
}

impl Strips {
    /// Adds an outline; one that encloses nothing, or turns back on itself, is left out.
    pub fn push(&mut self, rings: Vec<Vec<DVec2>>) {
        let area: f64 = rings.iter().map(|ring| doubled_area(ring)).sum();
        if let (true, Some(bounds)) = (area > 0.0, bounds(rings.iter().flatten().copied())) {
            self.0.push(Strip { rings, bounds });
        }
    }

    /// Whether nothing is painted.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Row-major index and share, above 0…1, of each voxel of a square that they touch, in the square's order.
    pub fn shares(&self, square: &Square) -> Vec<(usize, f64)> {
        let [west, south, east, north] = square.bounds();
        let mut shares: BTreeMap<usize, f64> = BTreeMap::new();
        let meets = |strip: &&Strip| {
            let [left, bottom, right, top] = strip.bounds;
            left <= east && right >= west && bottom <= north && top >= south
        };
        self.0.iter().filter(meets).for_each(|strip| strip.add(square, &mut shares));

        // Whichever page asks.
        let rounded = shares.into_iter().map(|(index, share)| (index, (share * STEPS).round() / STEPS));
        rounded.filter(|(_, share)| *share > 0.0).map(|(index, share)| (index, share.min(1.0))).collect()
    }
}

impl Strip {
    /// Adds its share of each voxel.
    fn add(&self, square: &Square, shares: &mut BTreeMap<usize, f64>) {
        let (columns, rows) = square.touched(self.bounds);
        let (left, right) = (columns.start as f64, columns.end as f64);
        let local: Vec<Vec<DVec2>> =
            self.rings.iter().map(|ring| ring.iter().map(|place| square.local(*place)).collect()).collect();

        for row in rows {
            let (bottom, top) = (row as f64, row as f64 + 1.0);
            let band = clip_all(&local, dvec2(left, bottom), dvec2(right, top));
            let Some([west, _, east, _]) = bounds(band.iter().flatten().copied()) else { continue };
            for column in west.floor() as usize..(east.ceil() as usize).min(columns.end) {
                let west = column as f64;
                let part = clip_all(&band, dvec2(west, bottom), dvec2(west + 1.0, top));
                let share: f64 = part.iter().map(|ring| 0.5 * doubled_area(ring)).sum();
                if share > 0.0 {
                    *shares.entry(square.index(column, row)).or_default() += share;
                }
            }
        }
    }
}
