//! A pattern quilted from patches of a picture.
//!
//! ```text
//! 5 × 5 patches of 4 or 5 voxels, each a voxel over its neighbours and the last over the first
//! for each patch, row by row:
//!     some places of the picture by chance    → the one that differs least from what lies there already
//!     in each lap: the seam of least difference between both                     by dynamic programming
//! ```
//!
//! Source: Efros and Freeman 2001 (*Image quilting for texture synthesis and transfer*); laps all round, so that the
//! pattern repeats, and places that keep to voxels are ours.

use hedgehop_base::chance::Random;

use crate::cells::{Cells, SIDE};
use crate::tile::CELLS_PER_VOXEL;

/// Voxels from each patch to the next, along either axis: 17 in all.
const STRIDES: [usize; 5] = [4, 3, 4, 3, 3];

/// Voxels along the greatest patch.
pub const PATCH_VOXELS: usize = 5;

/// Cells of a lap.
const LAP: usize = CELLS_PER_VOXEL;

/// Places that are looked at for each patch.
const LOOKS: usize = 64;

/// Picture of whole voxels whose cells patches are cut from.
#[derive(Debug, Clone)]
pub struct Swatch {
    /// Cells along a row.
    width: usize,
    /// Values, row by row.
    values: Vec<f32>,
}

/// Place of a patch: its first voxel in one of several swatches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PatchPlace {
    /// Index of the swatch.
    pub swatch: usize,
    /// First voxel, along columns and rows.
    pub voxel: [usize; 2],
}

impl Swatch {
    /// Takes values of so many voxels along a row, row by row.
    ///
    /// `None` where they do not fill rows of whole voxels.
    pub fn new(voxels: usize, values: Vec<f32>) -> Option<Self> {
        let width = voxels * CELLS_PER_VOXEL;
        let is_whole = width > 0 && values.len().is_multiple_of(width * CELLS_PER_VOXEL);
        is_whole.then_some(Self { width, values })
    }

    /// Voxels along columns and rows.
    pub fn voxels(&self) -> [usize; 2] {
        [self.width / CELLS_PER_VOXEL, self.values.len() / self.width / CELLS_PER_VOXEL]
    }

    /// Value of a cell.
    pub fn at(&self, [column, row]: [usize; 2]) -> f32 {
        self.values[row * self.width + column]
    }
}

/// Quilts a pattern from places of swatches, of which each holds [`PATCH_VOXELS`] voxels along either axis; `None` without any place.
pub fn quilted(swatches: &[Swatch], places: &[PatchPlace], seed: u64) -> Option<Cells> {
    if places.is_empty() {
        return None;
    }
    let mut random = Random::stream(seed, 3);
    let mut quilt = Quilt { values: vec![0.0; SIDE * SIDE], is_laid: vec![false; SIDE * SIDE] };
    let spans = spans();

    for rows in &spans {
        for columns in &spans {
            let field = PatchField { columns: *columns, rows: *rows };
            let mut best: Option<(f64, Cut<'_>)> = None;
            for _ in 0..LOOKS.min(2 * places.len()) {
                let place = places[((random.unit() * places.len() as f64) as usize).min(places.len() - 1)];
                let cut = Cut::new(&swatches[place.swatch], place);
                let differs = quilt.difference(&field, &cut);
                if best.as_ref().is_none_or(|(least, _)| differs < *least) {
                    best = Some((differs, cut));
                }
            }
            if let Some((_, cut)) = best {
                quilt.lay(&field, &cut);
            }
        }
    }

    Some(Cells::of(|column, row| f64::from(quilt.values[row as usize * SIDE + column as usize])))
}

/// Cells of a pattern that a patch takes along one axis.
#[derive(Debug, Clone, Copy)]
struct PatchSpan {
    first: usize,
    count: usize,
}

/// Returns the spans of patches along an axis.
fn spans() -> [PatchSpan; STRIDES.len()] {
    let mut first = 0;
    STRIDES.map(|stride| {
        let span = PatchSpan { first, count: (stride + 1) * CELLS_PER_VOXEL };
        first += stride * CELLS_PER_VOXEL;
        span
    })
}

/// Cells of a pattern that a patch takes.
struct PatchField {
    columns: PatchSpan,
    rows: PatchSpan,
}

impl PatchField {
    /// Index in the pattern of a cell of the patch.
    fn index(&self, [column, row]: [usize; 2]) -> usize {
        (self.rows.first + row) % SIDE * SIDE + (self.columns.first + column) % SIDE
    }
}

/// Patch of a swatch.
struct Cut<'s> {
    swatch: &'s Swatch,
    /// First cell.
    first: [usize; 2],
}

impl<'s> Cut<'s> {
    fn new(swatch: &'s Swatch, place: PatchPlace) -> Self {
        Self { swatch, first: place.voxel.map(|voxel| voxel * CELLS_PER_VOXEL) }
    }

    fn at(&self, [column, row]: [usize; 2]) -> f32 {
        self.swatch.at([self.first[0] + column, self.first[1] + row])
    }
}

/// Edges of a patch.
#[derive(Debug, Clone, Copy)]
enum PatchEdge {
    West,
    East,
    South,
    North,
}

impl PatchEdge {
    const ALL: [Self; 4] = [Self::West, Self::East, Self::South, Self::North];

    /// Cells along the edge.
    fn length(self, field: &PatchField) -> usize {
        match self {
            Self::West | Self::East => field.rows.count,
            Self::South | Self::North => field.columns.count,
        }
    }

    /// Cell of the patch so far along the edge, and so far from it.
    fn cell(self, field: &PatchField, along: usize, depth: usize) -> [usize; 2] {
        match self {
            Self::West => [depth, along],
            Self::East => [field.columns.count - 1 - depth, along],
            Self::South => [along, depth],
            Self::North => [along, field.rows.count - 1 - depth],
        }
    }
}

/// Pattern that is being laid.
struct Quilt {
    values: Vec<f32>,
    is_laid: Vec<bool>,
}

impl Quilt {
    /// Sum of squared differences between a patch and what lies in its field already.
    fn difference(&self, field: &PatchField, cut: &Cut<'_>) -> f64 {
        let mut sum = 0.0;
        for row in 0..field.rows.count {
            for column in 0..field.columns.count {
                let at = field.index([column, row]);
                if self.is_laid[at] {
                    sum += f64::from(self.values[at] - cut.at([column, row])).powi(2);
                }
            }
        }
        sum
    }

    /// Lays a patch, up to the seams of its laps.
    fn lay(&mut self, field: &PatchField, cut: &Cut<'_>) {
        let width = field.columns.count;
        let mut is_kept = vec![false; width * field.rows.count];
        for edge in PatchEdge::ALL {
            let length = edge.length(field);
            // Neighbours cover a lap as a whole, or not at all.
            if !self.is_laid[field.index(edge.cell(field, length / 2, 0))] {
                continue;
            }
            for (along, depth) in self.seam(field, cut, edge).into_iter().enumerate() {
                for depth in 0..depth {
                    let [column, row] = edge.cell(field, along, depth);
                    is_kept[row * width + column] = true;
                }
            }
        }

        for (index, is_kept) in is_kept.into_iter().enumerate() {
            let cell = [index % width, index / width];
            let at = field.index(cell);
            if !(is_kept && self.is_laid[at]) {
                (self.values[at], self.is_laid[at]) = (cut.at(cell), true);
            }
        }
    }

    /// Depth from an edge up to which what lies there is kept, along the edge: the way of least difference.
    fn seam(&self, field: &PatchField, cut: &Cut<'_>, edge: PatchEdge) -> Vec<usize> {
        let length = edge.length(field);
        let reached = |depth: usize| depth.saturating_sub(1)..(depth + 2).min(LAP);

        // Least sums of differences from the edge's begin to each cell of the lap.
        let mut sums = vec![[0.0_f64; LAP]; length];
        for along in 0..length {
            let before = if along > 0 { sums[along - 1] } else { [0.0; LAP] };
            for (depth, sum) in sums[along].iter_mut().enumerate() {
                let cell = edge.cell(field, along, depth);
                let at = field.index(cell);
                let own =
                    if self.is_laid[at] { f64::from(self.values[at] - cut.at(cell)).powi(2) } else { 0.0 };
                *sum = own + reached(depth).map(|depth| before[depth]).fold(f64::INFINITY, f64::min);
            }
        }

        // Back along them.
        let least_of = |sums: &[f64; LAP], range: std::ops::Range<usize>| {
            range.min_by(|&a, &b| sums[a].total_cmp(&sums[b])).unwrap_or(0)
        };
        let mut depths = vec![0; length];
        let mut range = 0..LAP;
        for along in (0..length).rev() {
            let depth = least_of(&sums[along], range);
            depths[along] = depth;
            range = reached(depth);
        }
        depths
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Swatch of a function of columns and rows, of so many voxels along either axis.
    fn swatch(voxels: usize, value: impl Fn(usize, usize) -> f32) -> Swatch {
        let side = voxels * CELLS_PER_VOXEL;
        let values = (0..side * side).map(|index| value(index % side, index / side)).collect();
        Swatch::new(voxels, values).unwrap()
    }

    fn places(voxels: usize) -> Vec<PatchPlace> {
        let last = voxels - PATCH_VOXELS;
        (0..=last).flat_map(|y| (0..=last).map(move |x| PatchPlace { swatch: 0, voxel: [x, y] })).collect()
    }

    #[test]
    fn patches_cover_a_pattern_that_repeats() {
        let cells: usize = spans().iter().map(|span| span.count - LAP).sum();
        assert_eq!(cells, SIDE);
        assert_eq!(spans().map(|span| span.count).into_iter().max(), Some(PATCH_VOXELS * CELLS_PER_VOXEL));

        // No cell is left as it was.
        let bright = swatch(8, |column, row| 1.0 + ((column * 7 + row * 13) % 5) as f32);
        let cells = quilted(&[bright], &places(8), 1).unwrap();
        assert!(cells.values().iter().all(|&value| value >= 1.0));
        assert!(quilted(&[], &[], 1).is_none());
    }

    #[test]
    fn seams_are_as_smooth_as_the_picture() {
        // A pattern of voxels that fits everywhere: what is quilted has no seam at all.
        let wave =
            |column: usize, row: usize| ((column % CELLS_PER_VOXEL) * 3 + (row % CELLS_PER_VOXEL)) as f32;
        let cells = quilted(&[swatch(9, wave)], &places(9), 5).unwrap();
        let expected = Cells::of(|column, row| f64::from(wave(column as usize, row as usize)));
        assert_eq!(cells, expected);

        // Slow waves: steps between neighbours stay near those of the picture, across the pattern's own edge, too.
        let slow = |column: usize, row: usize| (column as f32 / 11.0).sin() + (row as f32 / 7.0).cos();
        let cells = quilted(&[swatch(20, slow)], &places(20), 5).unwrap();
        let steps = |across: &dyn Fn(i64) -> [i64; 2]| -> f64 {
            let squares = (0..SIDE as i64).map(|along| {
                let [column, row] = across(along);
                (cells.at(column, row) - cells.at(column - 1, row)).powi(2)
            });
            (squares.sum::<f64>() / SIDE as f64).sqrt()
        };
        let typical = 1.0 / 11.0 / std::f64::consts::SQRT_2;
        assert!(steps(&|row| [0, row]) < 6.0 * typical, "{}", steps(&|row| [0, row]));
    }

    #[test]
    fn seeds_give_other_patterns_of_the_same_deviation() {
        let noise = |column: usize, row: usize| {
            let mixed = (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
                ^ (row as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
            let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            ((mixed >> 40) as f32 / (1 << 24) as f32 - 0.5) * 12.0_f32.sqrt()
        };
        let picture = [swatch(16, noise)];
        let [one, other] = [1, 2].map(|seed| quilted(&picture, &places(16), seed).unwrap());
        assert_ne!(one, other);
        assert_eq!(one, quilted(&picture, &places(16), 1).unwrap());
        for cells in [one, other] {
            assert!((cells.deviation() - 1.0).abs() < 0.03, "{}", cells.deviation());
        }
    }
}
