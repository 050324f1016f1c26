//! Elevations in which planes lie equally far apart.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use crate::simd::{Floats, Ints, LANES, Simd};

/// Least elevation of the second annulus above or below the horizon, and of the third, degrees. From there on each
/// takes half of what is left to the pole.
const FIRST: [f64; 2] = [45.0, 60.0];

/// Fewest planes: sixteen span an eighth of a right angle or so, that they may have one major axis.
const FEWEST: usize = 256;

/// An annulus.
#[derive(Debug, Clone, PartialEq)]
pub struct Annulus {
    /// Rows at or above which pixels look this annulus up, up to the next row.
    pub rows: Range<usize>,
    /// Planes around the whole circle, the first to the north.
    planes: usize,
    /// Plane of the azimuth from which pixels count theirs: whole and fraction.
    ahead: (i32, f32),
    /// Rows of each group of planes that pixels need; none: no group has been marked.
    marks: Vec<Range<usize>>,
    /// Place of each group's row 0 in the plane image's memory, in words, modulo 2³².
    bases: Vec<u32>,
}

/// Two planes that pixels lie between.
pub struct Between<V: Simd> {
    /// Index of the word of row 0, left and right.
    pub words: [V::I; 2],
    /// Share of the way from the left one to the right.
    pub share: V::F,
}

impl Annulus {
    /// All annuli of `rows` rows `step` radians apart, from nadir to zenith. `ahead`: azimuth from which pixels count theirs,
    /// radians.
    pub fn all(rows: usize, step: f64, ahead: f64) -> Vec<Self> {
        let half = rows / 2;
        // Elevations (radians) at which annuli begin, and rows above the horizon.
        let mut begins = vec![0.0];
        begins.extend(FIRST.map(f64::to_radians));
        let cap = FEWEST as f64 / TAU * step;
        while FRAC_PI_2 - begins[begins.len() - 1] > cap {
            begins.push(0.5 * (begins[begins.len() - 1] + FRAC_PI_2));
        }

        let row = |elevation: f64| ((elevation / step) as usize).min(half - 1);
        let mut upper: Vec<Self> = Vec::new();
        for (index, &begin) in begins.iter().enumerate() {
            let first = row(begin);
            let end = begins.get(index + 1).map_or(half - 1, |&next| row(next));
            if end <= first && index > 0 {
                continue;
            }
            let radius = (first as f64 * step).cos();
            let planes = ((TAU * radius / step).ceil() as usize).max(FEWEST).next_multiple_of(LANES);
            let at = ahead.rem_euclid(TAU) * planes as f64 / TAU;
            let ahead = (at.floor() as i32, at.fract() as f32);
            upper.push(Self { rows: first..end, planes, ahead, marks: Vec::new(), bases: Vec::new() });
        }

        // The mirror image, and the gap between the two rows beside the horizon, which is the upper one's.
        let lower: Vec<_> = upper
            .iter()
            .rev()
            .map(|one| Self { rows: half - 1 - one.rows.end..half - 1 - one.rows.start, ..one.clone() })
            .collect();
        for one in &mut upper {
            one.rows = half + one.rows.start..half + one.rows.end;
        }

        upper[0].rows.start = half - 1;
        lower.into_iter().chain(upper).collect()
    }

    /// Rows that interpolation for these pixels may touch, of `rows` in all.
    pub fn looked_up(&self, rows: usize) -> Range<usize> {
        self.rows.start.saturating_sub(1)..(self.rows.end + 2).min(rows)
    }

    /// Planes around the circle.
    pub fn planes(&self) -> usize {
        self.planes
    }

    /// Marks `rows` of the planes up to `spread` beside an azimuth, radians; of all of them if there is none.
    pub fn mark(&mut self, rows: Range<usize>, azimuth: f64, spread: Option<f64>) {
        let groups = self.planes / LANES;
        if self.marks.is_empty() {
            self.marks = vec![0..0; groups];
        }

        let plane = |azimuth: f64| azimuth * self.planes as f64 / TAU;
        let [first, last] = match spread {
            Some(spread) => [plane(azimuth - spread) - MARGIN, plane(azimuth + spread) + MARGIN]
                .map(|it| it.floor() as i64),
            None => [0, self.planes as i64 - 1],
        };
        let lanes = LANES as i64;
        let (first, last) = (first.div_euclid(lanes), last.div_euclid(lanes));

        for group in first..=last.min(first + groups as i64 - 1) {
            let mark = &mut self.marks[group.rem_euclid(groups as i64) as usize];
            *mark = if mark.start >= mark.end {
                rows.clone()
            } else {
                mark.start.min(rows.start)..mark.end.max(rows.end)
            };
        }
    }

    /// Gives the marked groups places from row `next` of the plane image's memory on: they and their rows.
    pub fn place(&mut self, next: &mut usize) -> Vec<(usize, Range<usize>)> {
        self.bases = vec![0; self.marks.len().max(1)];
        let marked = self.marks.iter().enumerate().filter(|(_, rows)| !rows.is_empty());
        let mut placed = Vec::new();
        for (group, rows) in marked {
            self.bases[group] = (*next as u32).wrapping_sub(rows.start as u32).wrapping_mul(LANES as u32);
            *next += rows.len();
            placed.push((group, rows.clone()));
        }
        placed
    }

    /// The planes beside an azimuth (from that ahead on, radians, less than a turn).
    #[inline(always)]
    pub fn between<V: Simd>(&self, simd: V, azimuth: V::F) -> Between<V> {
        let per_radian = simd.splat((self.planes as f64 / TAU) as f32);
        let plane = azimuth.mul_add(per_radian, simd.splat(self.ahead.1));
        let whole = plane.floor();
        let share = plane - whole;
        let left = whole.to_int() + simd.splat_int(self.ahead.0);
        let mut words = [left; 2];
        for (index, word) in words.iter_mut().enumerate() {
            *word = self.word(simd, self.around(simd, left + simd.splat_int(index as i32)));
        }
        Between { words, share }
    }

    /// The same plane, within the circle.
    #[inline(always)]
    fn around<V: Simd>(&self, simd: V, plane: V::I) -> V::I {
        let turn = simd.splat_int(self.planes as i32);
        let plane = (plane - turn).select(plane.gt(simd.splat_int(self.planes as i32 - 1)), plane);
        (plane + turn).select(simd.splat_int(0).gt(plane), plane)
    }

    #[inline(always)]
    fn word<V: Simd>(&self, simd: V, plane: V::I) -> V::I {
        let base = simd.gather_words(&self.bases, plane.shr::<4>());
        base + (plane & simd.splat_int(LANES as i32 - 1))
    }
}

/// Rows and planes around a cone that interpolation and rounding may touch.
pub(super) const MARGIN: f64 = 2.5;
