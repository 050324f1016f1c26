//! Straight lines of steps.
//!
//! ```text
//! between two columns, over 32 rows:
//!     E = mean of |step across − mean of the steps before and behind it|
//! a seam: E > k · max(E of the lines 2 to 4 columns aside, 1/100 of a voxel's side, 2 steps of height)
//!         and E ≥ 1.3 times E of the two lines next to it   (a step has twice, a wall or ditch of one column as much)
//!         and both of these ≥ 0.3 E                         (a step has half; where a slope ends, there is nothing beyond)
//! at least 2 such pieces in a row are joined; the same between rows
//! ```
//!
//! Only columns and rows of voxels are looked along: seams of sources in another reference system run slantwise, and are not found.

use std::collections::BTreeMap;

use glam::DVec2;

use crate::continuity::found::{Found, Patch};
use crate::continuity::{Fault, Finding};
use hedgehop::voxel::{Header, PAGE_SIDE};

/// Voxels of a piece.
const PIECE: i64 = 32;
/// Pieces of a seam, at least.
const LEAST_PIECES: usize = 2;
/// Least step that is compared with, in sides of a voxel and in steps of height.
const LEAST_SIDES: f64 = 0.01;
const LEAST_STEPS: f64 = 2.0;
/// Ratio by which it exceeds the lines next to it.
const SHARP: f64 = 1.3;
/// Share of it that the lines next to it have.
const SHARED: f64 = 0.3;
/// Lines aside that are looked at, at most.
const ASIDE: i64 = 4;

/// A piece of a line: whether it is a row, its number, and which piece of it.
type Piece = (bool, i64, i64);

/// Pieces that were found: mean step, and the height in the middle.
#[derive(Default)]
pub(super) struct Seams(BTreeMap<Piece, (f64, f64)>);

impl Seams {
    pub fn find(&mut self, patch: &Patch, factor: f64) {
        for is_row in [false, true] {
            let (across, along) = if is_row { (1, 0) } else { (0, 1) };
            for piece in 0..patch.size[along].div_euclid(PIECE) {
                self.piece(patch, factor, is_row, across, piece);
            }
        }
    }

    fn piece(&mut self, patch: &Patch, factor: f64, is_row: bool, across: usize, piece: i64) {
        let along = 1 - across;
        let least = (LEAST_SIDES * patch.side).max(LEAST_STEPS * patch.code.scale);
        let height = |line: i64, at: i64| {
            let (x, y) = if is_row { (at, line) } else { (line, at) };
            patch.height(x, y)
        };

        // Line n lies before column n.
        let excess = |line: i64| {
            let rows = piece * PIECE..(piece + 1) * PIECE;
            let of_row = |at: i64| {
                let [a, b, c, d] = [-2, -1, 0, 1].map(|offset| height(line + offset, at));
                ((c - b) - 0.5 * ((b - a) + (d - c))).abs()
            };
            let known = rows.map(of_row).filter(|excess| !excess.is_nan());
            let (sum, count) =
                known.fold((0.0, 0), |(sum, count), excess| (sum + f64::from(excess), count + 1));
            if 2 * count > PIECE { sum / count as f64 } else { f64::NAN }
        };

        let lines = patch.size[across];
        let all: Vec<f64> = (-ASIDE..lines + ASIDE).map(excess).collect();
        for line in 0..lines {
            let at = |offset: i64| all[(line + ASIDE + offset) as usize];
            let greatest = |offsets: std::ops::RangeInclusive<i64>| {
                offsets.flat_map(|offset| [at(-offset), at(offset)]).fold(0.0, f64::max)
            };
            let own = at(0);
            let is_sharp = own >= SHARP * greatest(1..=1) && at(-1).min(at(1)) >= SHARED * own;
            if own > factor * greatest(2..=ASIDE).max(least) && is_sharp {
                let middle = height(line, piece * PIECE + PIECE / 2);
                let number = patch.first[across] + line;
                self.0.insert((is_row, number, patch.first[along] / PIECE + piece), (own, f64::from(middle)));
            }
        }
    }

    /// Joins pieces that follow each other.
    pub fn join(self, header: &Header, found: &mut Found) {
        debug_assert_eq!(i64::from(PAGE_SIDE) % PIECE, 0);
        let all: Vec<(Piece, (f64, f64))> = self.0.into_iter().collect();
        let follows = |a: &(Piece, (f64, f64)), b: &(Piece, (f64, f64))| (a.0.0, a.0.1, a.0.2 + 1) == b.0;
        for run in all.chunk_by(follows).filter(|run| run.len() >= LEAST_PIECES) {
            let (is_row, line, first) = run[0].0;
            let size = run.iter().map(|(_, (step, _))| step).sum::<f64>() / run.len() as f64;
            let worst = run.iter().max_by(|a, b| a.1.0.total_cmp(&b.1.0)).unwrap_or(&run[0]);

            let place = |line: i64, along: i64| {
                let units = if is_row {
                    DVec2::new(along as f64, line as f64)
                } else {
                    DVec2::new(line as f64, along as f64)
                };
                header.grid.origin + units * header.grid.spacing
            };

            let end = first + run.len() as i64;
            found.add(Finding {
                fault: Fault::Seam,
                place: place(line, worst.0.2 * PIECE + PIECE / 2),
                extent: [place(line, first * PIECE), place(line, end * PIECE)],
                height: worst.1.1 + header.height_range.low,
                size,
                voxels: run.len() as u64 * PIECE as u64,
                is_at_edge: false,
            });
        }
    }
}
