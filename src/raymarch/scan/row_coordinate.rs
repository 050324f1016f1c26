//! Rows of a plane image as a function of the tangent of elevation.

use crate::simd::math::atan2;
use crate::simd::{Floats, Simd};

/// Places among the rows of a plane image, by tangents: 0 at the lower edge of the lowest row, 1 from row to row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowCoordinate {
    form: RowForm,
    /// Tangents between which the rows lie.
    tangents: [f32; 2],
    /// Number of rows.
    rows: f32,
}

/// Form of the rows' dependence on the tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum RowForm {
    /// `(above[0]·t + above[1]) / (below[0]·t + below[1])`.
    Projective { above: [f32; 2], below: [f32; 2] },
    /// `per_radian` rows for each radian of elevation, and the place of the horizon.
    Angular { per_radian: f32, horizon: f32 },
}

impl RowCoordinate {
    /// Rows of an upright planar screen between `edges`, of sine and cosine of its pitch: its `y` in focal lengths, of which a row takes `1/focal`, is 0 at
    /// the centre and `lowest` at the lowest edge.
    pub fn projective([sin, cos]: [f64; 2], focal: f64, lowest: f64, edges: &[f32]) -> Self {
        // t = (y cos p + sin p) / (cos p − y sin p), solved for y.
        let above = [cos - lowest * sin, -sin - lowest * cos].map(|factor| (focal * factor) as f32);
        let below = [sin, cos].map(|factor| factor as f32);
        Self::new(RowForm::Projective { above, below }, edges)
    }

    /// Rows at equal steps of elevation between `edges`, so many to a radian; the horizon lies at a place.
    pub fn angular(per_radian: f64, horizon: f64, edges: &[f32]) -> Self {
        let form = RowForm::Angular { per_radian: per_radian as f32, horizon: horizon as f32 };
        Self::new(form, edges)
    }

    fn new(form: RowForm, edges: &[f32]) -> Self {
        let ends = [edges.first(), edges.last()].map(|edge| edge.copied().unwrap_or_default());
        Self { form, tangents: ends, rows: edges.len().saturating_sub(1) as f32 }
    }

    /// Whether rows are those of a planar screen.
    pub fn is_projective(&self) -> bool {
        matches!(self.form, RowForm::Projective { .. })
    }

    /// Returns the number of rows below tangents, the part of the one that each lies in included: 0 to their number.
    #[inline(always)]
    pub fn rows_below<V: Simd>(&self, simd: V, tangents: V::F) -> V::F {
        let [lowest, highest] = [simd.splat(self.tangents[0]), simd.splat(self.tangents[1])];
        let (zero, all) = (simd.splat(0.0), simd.splat(self.rows));

        // Beyond the outermost rows a plane that is projected comes back from the other side.
        let within = tangents.max(lowest).min(highest);
        let place = match self.form {
            RowForm::Projective { above, below } => {
                let above = within.mul_add(simd.splat(above[0]), simd.splat(above[1]));
                above * within.mul_add(simd.splat(below[0]), simd.splat(below[1])).recip()
            }
            RowForm::Angular { per_radian, horizon } => {
                let elevation = atan2(simd, within, simd.splat(1.0));
                elevation.mul_add(simd.splat(per_radian), simd.splat(horizon))
            }
        };

        // The outermost rows may be cut at nadir and zenith.
        let place = zero.select(tangents.le(lowest), place.max(zero).min(all));
        all.select(highest.le(tangents), place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel, LANES};

    struct Places<'c>(&'c RowCoordinate, [f32; LANES]);

    impl Kernel for Places<'_> {
        type Output = [f32; LANES];

        #[inline(always)]
        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let mut places = [0.0; LANES];
            self.0.rows_below(simd, simd.load(&self.1)).store(&mut places);
            places
        }
    }

    /// Edges are whole numbers of rows, what lies between them lies between their numbers, and what lies beyond is none or all.
    fn holds(coordinate: &RowCoordinate, edges: &[f32]) {
        let rows = edges.len() - 1;
        for isa in Isa::available() {
            for (row, pair) in edges.windows(2).enumerate() {
                let middle = 0.5 * (pair[0] + pair[1]);
                let mut tangents = [middle; LANES];
                tangents[..6].copy_from_slice(&[pair[0], pair[1], -1.0e30, 1.0e30, edges[0], edges[rows]]);
                let places = isa.run(Places(coordinate, tangents));
                let is_near = |place: f32, row: usize| (place - row as f32).abs() < 2.0e-3;
                assert!(is_near(places[0], row) && is_near(places[1], row + 1), "{isa}: {row} {places:?}");
                let ends = [0, rows, 0, rows].map(|row| row as f32);
                assert_eq!(places[2..6], ends, "{isa}");
                assert!((places[7] - row as f32 - 0.5).abs() < 0.4, "{isa}: {row} {places:?}");
            }
        }
    }

    #[test]
    fn rows_of_planar_screens_are_found_at_any_pitch() {
        for pitch in [-50.0_f64, -20.0, 0.0, 3.0, 45.0] {
            let (sin, cos) = pitch.to_radians().sin_cos();
            let (focal, lowest) = (900.0, -540.0);
            let edge = |row: usize| {
                let y = (lowest + row as f64) / focal;
                ((y * cos + sin) / (cos - y * sin)) as f32
            };
            let edges: Vec<f32> = (0..=760).map(edge).collect();
            assert!(edges.is_sorted(), "{pitch}: all rows are before the eye");
            holds(&RowCoordinate::projective([sin, cos], focal, lowest / focal, &edges), &edges);
        }
    }

    #[test]
    fn rows_of_panoramas_are_found_from_nadir_to_zenith() {
        let (rows, step) = (1400, std::f64::consts::PI / 1400.0);
        let edge = |row: usize| {
            let elevation = (row as f64 - 0.5 * rows as f64) * step;
            let most = std::f64::consts::FRAC_PI_2 - 0.25 * step;
            elevation.clamp(-most, most).tan() as f32
        };
        let edges: Vec<f32> = (0..=rows).map(edge).collect();
        holds(&RowCoordinate::angular(1.0 / step, 0.5 * rows as f64, &edges), &edges);
    }
}
