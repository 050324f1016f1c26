//! Rows of the plane image before a planar screen: light of planes that follow each other in one.

use super::super::cell::{Cell, Codes, add, between};
use super::{AlongRow, cubic};
use crate::raymarch::scan::Upright;
use crate::simd::{Each, Floats, Ints, LANES, Simd};

/// Returns lanes `index` (0…30) of 32 lanes of codes, and the next ones.
#[inline(always)]
fn neighbours<V: Simd>(simd: V, [low, high]: &[Codes<V>; 2], index: V::I) -> [Codes<V>; 2] {
    let [red_green, to_red_green] =
        simd.permute_neighbours(low.red_green.as_floats(), high.red_green.as_floats(), index);
    let [blue, to_blue] = simd.permute_neighbours(low.blue.as_floats(), high.blue.as_floats(), index);
    [
        Codes { red_green: red_green.to_bits(), blue: blue.to_bits() },
        Codes { red_green: to_red_green.to_bits(), blue: to_blue.to_bits() },
    ]
}

/// Light of planes by rows.
pub struct PlaneRows<'a, V: Simd> {
    simd: V,
    /// Planes, a multiple of the lanes, and rows.
    size: [usize; 2],
    /// Width of the screen, columns.
    width: usize,
    /// Light, `[group][row]`.
    cells: &'a [Cell],
    /// Numbers of the lanes, and columns' middles from the first one on.
    lanes: V::I,
    columns: V::F,
}

/// Codes of 32 planes that follow each other, in one row.
struct Neighbours<V: Simd> {
    /// The first plane.
    first: i32,
    codes: [Codes<V>; 2],
}

impl<V: Simd> Neighbours<V> {
    /// Returns the codes of some of these planes, and of the next ones.
    #[inline(always)]
    fn pair(&self, simd: V, planes: V::I) -> [Codes<V>; 2] {
        neighbours(simd, &self.codes, planes - simd.splat_int(self.first))
    }
}

impl<'a, V: Simd> PlaneRows<'a, V> {
    /// Reads what was seen before a screen.
    #[inline(always)]
    pub fn new(simd: V, upright: &Upright, cells: &'a [Cell]) -> Self {
        let mut lanes = [0; LANES];
        lanes.iter_mut().zip(0..).for_each(|(lane, index)| *lane = index);
        let lanes = simd.load_ints(&lanes);
        let columns = lanes.to_float() + simd.splat(0.5);
        Self { simd, size: upright.size, width: upright.width(), cells, lanes, columns }
    }

    /// Lanes.
    #[inline(always)]
    pub fn simd(&self) -> V {
        self.simd
    }

    /// Sixteen columns from `first` on, counted from the screen's middle.
    #[inline(always)]
    pub fn columns(&self, first: usize) -> V::F {
        self.columns + self.simd.splat(first as f32 - 0.5 * self.width as f32)
    }

    /// Codes of sixteen columns from `first` on where they meet `planes` of a row: cubic between planes.
    #[inline(always)]
    pub fn cubic(&self, planes: &AlongRow, first: usize, row: usize) -> [V::F; 3] {
        let simd = self.simd;
        let plane = planes.values(simd, self.columns(first));
        let left = plane.floor();
        let weights = cubic(simd, plane - left);
        let [beyond, one] = [2, 1].each(|planes| simd.splat_int(planes));
        let left = left.to_int();
        let [lowest, highest] = planes.reach(first);

        let taps = match self.neighbours([lowest - 1, highest + 2], row) {
            Some(neighbours) => {
                let [under, lower] = neighbours.pair(simd, left - one);
                let [upper, over] = neighbours.pair(simd, left + one);
                [under, lower, upper, over]
            }
            None => {
                let row = simd.splat_int(row as i32);
                [
                    self.codes(left - one, row),
                    self.codes(left, row),
                    self.codes(left + one, row),
                    self.codes(left + beyond, row),
                ]
            }
        };

        let mut seen = [simd.splat(0.0); 3];
        for (codes, weight) in taps.into_iter().zip(weights) {
            add(simd, &mut seen, codes, weight);
        }
        seen
    }

    /// Codes of sixteen columns from `first` on where they meet `planes` of a row: linear between planes.
    #[inline(always)]
    pub fn linear(&self, planes: &AlongRow, first: usize, row: usize) -> [V::F; 3] {
        let simd = self.simd;
        let plane = planes.values(simd, self.columns(first));
        let left = plane.floor();
        let (share, left) = (plane - left, left.to_int());
        let [lowest, highest] = planes.reach(first);

        let [from, to] = match self.neighbours([lowest, highest + 1], row) {
            Some(neighbours) => neighbours.pair(simd, left),
            None => {
                let (row, right) = (simd.splat_int(row as i32), left + simd.splat_int(1));
                [self.codes(left, row), self.codes(right, row)]
            }
        };
        between(simd, from, to, share)
    }

    /// Loads codes of planes that follow each other; `None` where they are too many or go beyond the plane image.
    #[inline(always)]
    fn neighbours(&self, [lowest, highest]: [i32; 2], row: usize) -> Option<Neighbours<V>> {
        let (simd, [planes, rows], lanes) = (self.simd, self.size, LANES as i32);
        let group = lowest.div_euclid(lanes);
        let fits = lowest >= 0 && highest < planes as i32 && highest < lowest + 2 * lanes;
        if !fits || (group + 1) * lanes >= planes as i32 {
            return None;
        }

        // The next sixteen pixels of the row are asked for after those below these. Cells begin and end within lines of the cache.
        let at = group as usize * rows + row;
        let later = at + 2 * rows;
        let bytes: &[u8] = bytemuck::cast_slice(self.cells);
        simd.prefetch(bytes, later * size_of::<Cell>());
        simd.prefetch(bytes, later * size_of::<Cell>() + size_of::<Cell>() - 1);
        let (low, middle) = (self.cells[at].load(simd), self.cells[at + rows].load(simd));
        if highest < (group + 2) * lanes {
            return Some(Neighbours { first: group * lanes, codes: [low, middle] });
        }

        // Planes of three groups, shifted into two registers.
        let high = self.cells[later].load(simd);
        let shifted = self.lanes + simd.splat_int(lowest % lanes);
        let [low, _] = neighbours(simd, &[low, middle], shifted);
        let [high, _] = neighbours(simd, &[middle, high], shifted);
        Some(Neighbours { first: lowest, codes: [low, high] })
    }

    /// Codes of what a plane saw in a row; both are taken into the plane image.
    #[inline(always)]
    pub fn codes(&self, plane: V::I, row: V::I) -> Codes<V> {
        Cell::gather(self.simd, self.cells, self.index(plane, row))
    }

    /// Returns the index of a plane's row among lanes.
    #[inline(always)]
    pub fn index(&self, plane: V::I, row: V::I) -> V::I {
        let simd = self.simd;
        let [planes, rows] = self.size;
        let plane = plane.max(simd.splat_int(0)).min(simd.splat_int(planes as i32 - 1));
        let row = row.max(simd.splat_int(0)).min(simd.splat_int(rows as i32 - 1));
        let cell = plane.shr::<4>().mul(simd.splat_int(rows as i32)) + row;
        cell.shl::<4>() + (plane & simd.splat_int(LANES as i32 - 1))
    }
}
