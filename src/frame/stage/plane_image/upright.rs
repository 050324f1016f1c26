//! Reading of the planes along a planar screen: light and inverse depth between planes and rows.

use std::ops::Range;

use super::super::cell::{Cell, add};
use super::columns::{Crossings, RolledColumns};
use super::plane_rows::PlaneRows;
use super::{AT_EYE, AlongRow, Among, Depths, LookUp, along_surface, cubic};
use crate::raymarch::scan::{LevelRow, Upright};
use crate::simd::{Each, Floats, Ints, Simd};

/// Sixteen pixels of a row from a column on.
pub struct UprightPlace {
    column: usize,
    row: usize,
}

/// Directions of sixteen pixels.
struct Directions<V: Simd> {
    /// Places among planes and rows, fractional.
    plane: V::F,
    row: V::F,
    /// 1 + a² + t².
    square: V::F,
}

/// A row of the screen.
enum ScreenRow {
    /// Row of the plane image, and the planes along it.
    Level(LevelRow, AlongRow),
    /// Row across those of the plane image, and its places among them.
    Rolled(AlongRow),
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
    /// Light.
    plane_rows: PlaneRows<'a, V>,
    /// Distances, `[group][row]`.
    depths: Depths<'a>,
    /// Rows of the screen, from this one on.
    first: usize,
    rows: Vec<ScreenRow>,
    /// Where columns cross rows of the plane image, if they are read down.
    crossings: Option<Crossings>,
}

impl ScreenRow {
    /// Places a row, whose middle is so far from the screen's upper edge.
    fn new(upright: &Upright, row: f64) -> Self {
        let width = upright.width();
        match upright.level_row(row) {
            Some(level) => Self::Level(level, AlongRow::new(level.planes, width)),
            None => Self::Rolled(AlongRow::new(upright.slant(row), width)),
        }
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
        let rows: Vec<_> = rows.map(|row| ScreenRow::new(upright, row as f64 + 0.5)).collect();
        let slants = rows.iter().filter_map(|row| match row {
            ScreenRow::Rolled(along) => Some(along),
            ScreenRow::Level(..) => None,
        });
        let crossings = upright.is_read_by_columns().then(|| Crossings::new(upright, slants));
        let plane_rows = PlaneRows::new(simd, upright, cells);
        Self { simd, upright, plane_rows, depths, first, rows, crossings }
    }

    /// Codes of pixels: cubic between planes and rows.
    #[inline(always)]
    fn cubic(&self, place: &Directions<V>) -> [V::F; 3] {
        let simd = self.simd;
        let (left, below) = (place.plane.floor(), place.row.floor());
        let (across, rise) = (cubic(simd, place.plane - left), cubic(simd, place.row - below));
        let (left, below) = (left.to_int(), below.to_int());
        let mut seen = [simd.splat(0.0); 3];
        for (row, &up) in rise.iter().enumerate() {
            let row = below + simd.splat_int(row as i32 - 1);
            for (plane, &weight) in across.iter().enumerate() {
                let codes = self.plane_rows.codes(left + simd.splat_int(plane as i32 - 1), row);
                add(simd, &mut seen, codes, weight * up);
            }
        }
        seen
    }

    /// Directions of pixels.
    #[inline(always)]
    fn directions(&self, place: &UprightPlace) -> Directions<V> {
        let (simd, one) = (self.simd, self.simd.splat(1.0));
        let columns = self.plane_rows.columns(place.column);
        match &self.rows[place.row - self.first] {
            ScreenRow::Level(level, planes) => {
                let across = columns * simd.splat(level.across);
                let square = across.mul_add(across, simd.splat(level.tangent * level.tangent + 1.0));
                let plane = planes.values(simd, columns);
                Directions { plane, row: simd.splat(level.row as f32), square }
            }
            ScreenRow::Rolled(_) => {
                let look = self.upright.look(simd, columns, place.row as f32 + 0.5);
                let square = look.across.mul_add(look.across, look.tangent.mul_add(look.tangent, one));
                Directions { plane: look.plane, row: look.row, square }
            }
        }
    }

    /// Returns the index of a word so many planes and rows away from the first of four. No closure: one that is not inlined
    /// has none of the set's instructions.
    #[inline(always)]
    fn word_from(&self, first: &FirstWord<V>, planes: i32, rows: i32) -> V::I {
        let simd = self.simd;
        self.plane_rows
            .index(first.plane + simd.splat_int(planes), first.row + simd.splat_int(rows * first.rows_apart))
    }
}

impl<V: Simd> LookUp<V> for UprightImage<'_, V> {
    type Place = UprightPlace;
    type Strip = RolledColumns;

    #[inline(always)]
    fn strip(&self) -> RolledColumns {
        RolledColumns::new()
    }

    #[inline(always)]
    fn begin(&self, strip: &mut RolledColumns, column: usize) {
        strip.begin(column);
    }

    #[inline(always)]
    fn place(&self, column: usize, row: usize) -> UprightPlace {
        UprightPlace { column, row }
    }

    /// Linear between the planes; between rows of a rolled screen cubic, and between planes, too, if they are not read down its columns.
    #[inline(always)]
    fn roots(&self, strip: &mut RolledColumns, place: &UprightPlace) -> [V::F; 3] {
        let mut roots = match (&self.rows[place.row - self.first], &self.crossings) {
            (ScreenRow::Level(level, planes), _) => {
                return self.plane_rows.linear(planes, place.column, level.row);
            }
            (ScreenRow::Rolled(rows), Some(crossings)) => strip.codes(&self.plane_rows, crossings, rows),
            (ScreenRow::Rolled(_), None) => self.cubic(&self.directions(place)),
        };

        let zero = self.simd.splat(0.0);
        for root in &mut roots {
            *root = root.max(zero);
        }

        roots
    }

    #[inline(always)]
    fn range(&self, place: &UprightPlace) -> (V::F, V::M) {
        let place = &self.directions(place);
        let simd = self.simd;
        let (left, below) = (place.plane.floor(), place.row.floor());
        let (share, rise) = (place.plane - left, place.row - below);
        let (left, below) = (left.to_int(), below.to_int());

        // Rows of an unrolled screen are those of the plane image.
        let rows_apart = i32::from(!self.upright.is_level());
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
