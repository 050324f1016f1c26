//! The rows of a plane image: which tangents they span, and which rows a tangent is near.

use std::ops::Range;

use super::RowCoordinate;
use crate::simd::{Floats, Simd};

/// Cells of the index per row.
const CELLS: usize = 2;

/// Rows that nadir and zenith may cut.
const OUTERMOST: usize = 2;

/// Allowance for rounding in the index's coordinate.
const ROUNDING: f32 = 1.0e-6;

/// Rows from the lowest to the highest.
#[derive(Debug, Clone)]
pub struct RowTable {
    /// Tangents of elevation of the rows' lower edges, rising, and of the last one's upper edge.
    pub edges: Vec<f32>,
    /// Tangents of the rows' middles.
    pub centres: Vec<f32>,
    /// Places among the rows by tangents.
    pub coordinate: RowCoordinate,
    /// 1 / (upper edge − lower edge).
    pub per_row: Vec<f32>,
    /// Least height of a row, as tangent, and as angle, radians; a few outermost ones, which are cut where they touch nadir or
    /// zenith, may be less.
    pub least_row: [f32; 2],
    /// Number of edges in the cells before each one.
    before: Vec<u32>,
    /// Begin of the cells, and their number per unit.
    start: f32,
    per_unit: f32,
}

impl RowTable {
    /// Builds the table of rows between edges, of which there is one more than `centres`.
    pub fn new(edges: Vec<f32>, centres: Vec<f32>, coordinate: RowCoordinate) -> Self {
        let per_row: Vec<f32> = edges.windows(2).map(|edge| 1.0 / (edge[1] - edge[0])).collect();
        let ends = [edges.first(), edges.last()].map(|edge| evenly(edge.copied().unwrap_or(0.0)));
        let cells = CELLS * edges.len();
        let per_unit = cells as f32 / (ends[1] - ends[0]).max(f32::MIN_POSITIVE);
        let least_row = least_row(&per_row, &centres);
        let mut row_table = Self {
            edges,
            centres,
            coordinate,
            per_row,
            least_row,
            before: Vec::new(),
            start: ends[0],
            per_unit,
        };
        let mut before = vec![0; cells + 2];
        for &edge in &row_table.edges {
            before[(row_table.cell(evenly(edge)) + 1).min(cells + 1)] += 1;
        }
        let mut sum = 0;
        for count in &mut before {
            sum += *count;
            *count = sum;
        }
        row_table.before = before;
        row_table
    }

    /// Cells between which all edges are that lie above tangents `low` and not above `high`, and few others.
    #[inline(always)]
    pub fn cells<V: Simd>(&self, simd: V, low: V::F, high: V::F) -> [V::I; 2] {
        [self.vector_cell(simd, low, -ROUNDING), self.vector_cell(simd, high, ROUNDING)]
    }

    #[inline(always)]
    fn vector_cell<V: Simd>(&self, simd: V, tangent: V::F, rounding: f32) -> V::I {
        let last = simd.splat((self.before.len() - 2) as f32);
        let at = tangent * (tangent.abs() + simd.splat(1.0)).recip();
        let cell = (at + simd.splat(rounding - self.start)) * simd.splat(self.per_unit);
        cell.max(simd.splat(0.0)).min(last).to_int()
    }

    /// Edges in a range of cells, the last one included.
    #[inline(always)]
    pub fn between(&self, first: i32, last: i32) -> Range<usize> {
        let before = |cell: usize| self.before.get(cell).copied().unwrap_or_default() as usize;
        before(first as usize)..before(last as usize + 1)
    }

    #[inline(always)]
    fn cell(&self, at: f32) -> usize {
        ((at - self.start) * self.per_unit) as usize
    }
}

fn least_row(per_row: &[f32], centres: &[f32]) -> [f32; 2] {
    let rows = per_row.iter().zip(centres);
    let rows = rows.take(per_row.len().saturating_sub(OUTERMOST)).skip(OUTERMOST);
    let most = rows.fold([0.0_f32; 2], |most, (&per_row, &centre)| {
        let per_angle = per_row * centre.mul_add(centre, 1.0);
        [most[0].max(per_row), most[1].max(per_angle)]
    });
    most.map(|per_row| 1.0 / per_row.max(f32::MIN_POSITIVE))
}

/// A coordinate from −1 to 1 in which rows of any plane image are about equally far apart.
#[inline(always)]
fn evenly(tangent: f32) -> f32 {
    tangent / (1.0 + tangent.abs())
}
