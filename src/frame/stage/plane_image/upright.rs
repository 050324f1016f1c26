//! Reading of the planes along a planar screen: light and inverse depth between planes and rows.

use std::ops::Range;

use super::super::cell::{Cell, add, between};
use super::{AT_EYE, Among, Depths, LookUp, along_surface, cubic};
use crate::raymarch::scan::{LevelRow, Upright};
use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd};

/// Place of sixteen pixels among planes and rows.
pub struct UprightPlace<V: Simd> {
    plane: V::F,
    row: V::F,
    /// 1 + a² + t² of their directions.
    square: V::F,
    /// The first of two neighbouring groups that hold all planes of theirs, and the row, of an unrolled screen.
    level: Option<(usize, V::I)>,
}

/// Sixteen columns of a rolled screen on their way down: light of the four rows of the plane image about each pixel, where its column crosses them.
pub struct RolledColumns<V: Simd> {
    /// Columns from the screen's centre.
    x: V::F,
    /// The row that each pixel is above, once there is one.
    row: Option<V::F>,
    /// Light of the rows from the one below that upward, in units of the cells.
    rows: [[V::F; 3]; 4],
}

/// The first of the four words that a pixel lies among.
struct FirstWord<V: Simd> {
    plane: V::I,
    row: V::I,
    /// Rows to the next one; 0 where rows are the plane image's own.
    rows_apart: i32,
}

/// Looks planes up for rows of a screen.
pub struct UprightImage<'a, V: Simd> {
    simd: V,
    /// Layout of the screen in them.
    upright: &'a Upright,
    /// Light, `[group][row]`.
    cells: &'a [Cell],
    /// Distances, `[group][row]`.
    depths: Depths<'a>,
    columns: V::F,
    /// First row of `levels`.
    first: usize,
    /// Rows of an unrolled screen; none of a rolled one.
    levels: Vec<LevelRow>,
}

impl<V: Simd> RolledColumns<V> {
    /// Goes down to pixels above these rows.
    #[inline(always)]
    fn sink(&mut self, simd: V, plane_image: &UprightImage<'_, V>, below: V::F) {
        let one = simd.splat(1.0);
        let mut row = self.row.unwrap_or(below + simd.splat(self.rows.len() as f32));
        loop {
            let sinks = below.lt(row);
            if !sinks.any() {
                break;
            }
            row = (row - one).select(sinks, row);
            // Each row goes one up where a column sinks.
            let mut arriving = plane_image.across(self.x, row - one);
            for row in &mut self.rows {
                for (kept, arriving) in row.iter_mut().zip(&mut arriving) {
                    let leaving = *kept;
                    *kept = arriving.select(sinks, leaving);
                    *arriving = leaving;
                }
            }
        }
        self.row = Some(row);
    }
}

impl<'a, V: Simd> UprightImage<'a, V> {
    /// Reads for some rows of the screen.
    #[inline(always)]
    pub fn new(
        simd: V,
        upright: &'a Upright,
        cells: &'a [Cell],
        depths: Depths<'a>,
        rows: Range<usize>,
    ) -> Self {
        let first = rows.start;
        let levels = rows.map_while(|row| upright.level_row(row as f32 + 0.5)).collect();
        let mut columns = [0.0; LANES];
        columns.iter_mut().enumerate().for_each(|(lane, column)| *column = lane as f32 + 0.5);
        Self { simd, upright, cells, depths, columns: simd.load(&columns), first, levels }
    }

    /// Light where columns of a rolled screen, so far from its centre, cross rows: cubic between planes.
    #[inline(always)]
    fn across(&self, x: V::F, row: V::F) -> [V::F; 3] {
        let simd = self.simd;
        let plane = self.upright.plane_of(simd, x, row);
        let left = plane.floor();
        let weights = cubic(simd, plane - left);
        let (left, row) = (left.to_int(), row.to_int());
        let mut light = [simd.splat(0.0); 3];
        for (plane, &weight) in weights.iter().enumerate() {
            add(simd, &mut light, self.words(left + simd.splat_int(plane as i32 - 1), row), weight);
        }
        light
    }

    /// Light that a plane saw in a row; both are taken into the plane image.
    #[inline(always)]
    fn words(&self, plane: V::I, row: V::I) -> V::I {
        self.simd.gather_words(bytemuck::cast_slice(self.cells), self.index(plane, row))
    }

    /// Returns the index of a word so many planes and rows away from the first of four. No closure: one that is not inlined
    /// has none of the set's instructions.
    #[inline(always)]
    fn word_from(&self, first: &FirstWord<V>, planes: i32, rows: i32) -> V::I {
        let simd = self.simd;
        self.index(first.plane + simd.splat_int(planes), first.row + simd.splat_int(rows * first.rows_apart))
    }

    /// Returns the index of a plane's row among words.
    #[inline(always)]
    fn index(&self, plane: V::I, row: V::I) -> V::I {
        let simd = self.simd;
        let [planes, rows] = self.upright.size;
        let plane = plane.max(simd.splat_int(0)).min(simd.splat_int(planes as i32 - 1));
        let row = row.max(simd.splat_int(0)).min(simd.splat_int(rows as i32 - 1));
        let cell = plane.shr::<4>().mul(simd.splat_int(rows as i32)) + row;
        cell.shl::<4>() + (plane & simd.splat_int(LANES as i32 - 1))
    }
}

impl<V: Simd> LookUp<V> for UprightImage<'_, V> {
    type Place = UprightPlace<V>;
    type Strip = RolledColumns<V>;

    #[inline(always)]
    fn strip(&self, column: usize) -> RolledColumns<V> {
        let simd = self.simd;
        let x = self.columns + simd.splat(column as f32 - self.upright.middle());
        RolledColumns { x, row: None, rows: [[simd.splat(0.0); 3]; 4] }
    }

    #[inline(always)]
    fn place(&self, column: usize, row: usize) -> UprightPlace<V> {
        let simd = self.simd;
        let columns = self.columns + simd.splat(column as f32);
        let one = simd.splat(1.0);
        let Some(level) = self.levels.get(row - self.first) else {
            let look = self.upright.look(simd, columns, row as f32 + 0.5);
            let square = look.across.mul_add(look.across, look.tangent.mul_add(look.tangent, one));
            return UprightPlace { plane: look.plane, row: look.row, square, level: None };
        };

        let across = columns.mul_add(simd.splat(level.across[0]), simd.splat(level.across[1]));
        let square = across.mul_add(across, simd.splat(level.tangent * level.tangent + 1.0));
        let plane = columns.mul_add(simd.splat(level.plane[0]), simd.splat(level.plane[1]));
        let [planes, rows] = self.upright.size;
        let row = level.row.clamp(0, rows as i32 - 1);

        // Two groups hold all sixteen, unless planes are much closer than pixels.
        let (first, last) =
            (level.plane_at(column as f32 + 0.5), level.plane_at((column + LANES) as f32 - 0.5) + 2);
        let group = first.div_euclid(LANES as i32);
        let is_held = group >= 0 && last < (group + 2) * LANES as i32 && last < planes as i32;
        let level = is_held.then(|| {
            let index = plane.floor().to_int() - simd.splat_int(group * LANES as i32);
            (group as usize * rows + row as usize, index)
        });

        UprightPlace { plane, row: simd.splat(row as f32), square, level }
    }

    /// Linear between the planes, or cubic between planes and rows of a rolled screen.
    #[inline(always)]
    fn light(&self, strip: &mut RolledColumns<V>, place: &UprightPlace<V>) -> [V::F; 3] {
        let simd = self.simd;
        let left = place.plane.floor();
        let share = place.plane - left;
        if let Some((at, index)) = place.level {
            let [low, high] = [&self.cells[at], &self.cells[at + self.upright.size[1]]];
            // The next sixteen pixels of the row, which are asked for after those below these.
            let later = at + 2 * self.upright.size[1];
            simd.prefetch(self.cells, later);
            let (low, high) = (simd.load(&low.0), simd.load(&high.0));
            let [from, to] = simd.permute_neighbours(low, high, index);
            return between(simd, from.to_bits(), to.to_bits(), share);
        }

        let below = place.row.floor();
        if !self.levels.is_empty() {
            let (left, row) = (left.to_int(), below.to_int());
            return between(simd, self.words(left, row), self.words(left + simd.splat_int(1), row), share);
        }

        let rise = cubic(simd, place.row - below);
        let mut light = [simd.splat(0.0); 3];
        if self.upright.is_read_by_columns() {
            strip.sink(simd, self, below);
            for (row, &up) in strip.rows.iter().zip(&rise) {
                light[0] = row[0].mul_add(up, light[0]);
                light[1] = row[1].mul_add(up, light[1]);
                light[2] = row[2].mul_add(up, light[2]);
            }
        } else {
            let (left, below) = (left.to_int(), below.to_int());
            let across = cubic(simd, share);
            for (row, &up) in rise.iter().enumerate() {
                let row = below + simd.splat_int(row as i32 - 1);
                for (plane, &weight) in across.iter().enumerate() {
                    let words = self.words(left + simd.splat_int(plane as i32 - 1), row);
                    add(simd, &mut light, words, weight * up);
                }
            }
        }

        for light in &mut light {
            *light = light.max(simd.splat(0.0));
        }

        light
    }

    #[inline(always)]
    fn range(&self, place: &UprightPlace<V>) -> (V::F, V::M) {
        let simd = self.simd;
        let (left, below) = (place.plane.floor(), place.row.floor());
        let (share, rise) = (place.plane - left, place.row - below);
        let (left, below) = (left.to_int(), below.to_int());

        // Rows of an unrolled screen are those of the plane image.
        let rows_apart = i32::from(self.levels.is_empty());
        let first_word = FirstWord { plane: left, row: below, rows_apart };

        // Inverse depth along the optical axis is what is linear from row to row.
        let [first, per_row] = self.upright.horizontal().each(|depth| simd.splat(depth));
        let per_depth = place.row.mul_add(per_row, first).recip();
        let one = simd.splat(1.0);
        let (ground, is_edge) = along_surface(
            simd,
            #[inline(always)]
            |plane, row| {
                let at = below.to_float() + simd.splat((row * rows_apart) as f32);
                self.depths.inverse(simd, self.word_from(&first_word, plane, row))
                    * (at.mul_add(per_row, first) * per_depth)
            },
            true,
            [[one - share, share], [one - rise, rise]],
        );
        let words = [
            [self.word_from(&first_word, 0, 0), self.word_from(&first_word, 1, 0)],
            [self.word_from(&first_word, 0, 1), self.word_from(&first_word, 1, 1)],
        ];
        let (inverse, stands) = self.depths.standing(simd, ground, &Among { words, shares: [share, rise] });
        let zero = simd.splat(0.0);
        let range = place.square.sqrt() * inverse.recip();
        let range = zero.select(simd.splat(AT_EYE).lt(inverse), range);

        (range.select(zero.lt(inverse), simd.splat(f32::INFINITY)), stands | is_edge)
    }
}
