//! Image of an ellipse: a conic of lines and elements.

use glam::{DVec2, DVec3};

use crate::quadratic::roots;
use crate::{FlatEllipse, Raster};

/// Conic R1·I² + R2·J² + R3·I·J + R4·I + R5·J + R6 = 0 of lines I and elements J (§2.4.3.5); negative inside of an ellipse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageConic {
    /// R1 to R6.
    pub terms: [f64; 6],
}

/// A place on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagePoint {
    /// Scan lines from the upper side.
    pub line: f64,
    /// Elements from the left side.
    pub element: f64,
}

/// The determinant of (a b; c d).
fn minor(a: f64, b: f64, c: f64, d: f64) -> f64 {
    a * d - b * c
}

impl ImageConic {
    /// Finds the image of an ellipse in an eye's axes as a conic of the tangents w/u and v/u.
    pub fn of_tangents(ellipse: &FlatEllipse) -> Self {
        let (centre, [first, second]) = (ellipse.centre, ellipse.axes);
        let with_centre = |axis: DVec3| {
            DVec3::new(
                minor(axis.y, axis.x, centre.y, centre.x),
                minor(axis.x, axis.z, centre.x, centre.z),
                minor(axis.z, axis.y, centre.z, centre.y),
            )
        };
        // Q1 to Q3, Q4 to Q6 with the other sign, which their products do not show, and Q7 to Q9.
        let (a, b) = (with_centre(first), with_centre(second));
        let c = DVec3::new(
            minor(first.x, first.y, second.x, second.y),
            minor(first.z, first.x, second.z, second.x),
            minor(first.y, first.z, second.y, second.z),
        );

        let square = a * a + b * b - c * c;
        let product = |i: usize, j: usize| 2.0 * (a[i] * a[j] + b[i] * b[j] - c[i] * c[j]);
        Self { terms: [square.x, square.y, product(0, 1), product(0, 2), product(1, 2), square.z] }
    }

    /// Finds the image of an ellipse in an eye's axes.
    pub fn of(ellipse: &FlatEllipse, raster: &Raster) -> Self {
        let [h1, h2, h3, h4, h5, h6] = Self::of_tangents(ellipse).terms;
        let (scale, start) = (raster.scale(), raster.centre());
        let (ci, cj, i0, j0) = (scale.x, scale.y, start.x, start.y);
        let [r1, r2, r3] = [h1 / (ci * ci), h2 / (cj * cj), h3 / (ci * cj)];
        let r4 = h4 / ci - 2.0 * r1 * i0 - r3 * j0;
        let r5 = h5 / cj - 2.0 * r2 * j0 - r3 * i0;
        let r6 = r1 * i0 * i0 + r2 * j0 * j0 + r3 * i0 * j0 - h4 * i0 / ci - h5 * j0 / cj + h6;
        Self { terms: [r1, r2, r3, r4, r5, r6] }
    }

    /// The ellipse on the screen with a centre and two conjugate half axes, lines and elements.
    pub fn of_image(centre: DVec2, axes: [DVec2; 2]) -> Self {
        let [first, second] = axes;
        let area = first.perp_dot(second).powi(2);
        // |inverse · (p − centre)|² − 1, times the square of the area.
        let r1 = first.y.powi(2) + second.y.powi(2);
        let r2 = first.x.powi(2) + second.x.powi(2);
        let r3 = -2.0 * (first.x * first.y + second.x * second.y);
        let (i, j) = (centre.x, centre.y);
        let r4 = -2.0 * r1 * i - r3 * j;
        let r5 = -2.0 * r2 * j - r3 * i;
        let r6 = r1 * i * i + r2 * j * j + r3 * i * j - area;
        Self { terms: [r1, r2, r3, r4, r5, r6] }
    }

    /// The terms at a place: their sum is 0 on the outline, and negative inside of an ellipse.
    pub fn terms_at(&self, at: ImagePoint) -> [f64; 6] {
        let ([r1, r2, r3, r4, r5, r6], i, j) = (self.terms, at.line, at.element);
        [r1 * i * i, r2 * j * j, r3 * i * j, r4 * i, r5 * j, r6]
    }

    /// Returns the sum of the terms at a place.
    pub fn value(&self, at: ImagePoint) -> f64 {
        self.terms_at(at).iter().sum()
    }

    /// Finds the topmost and the bottommost point; `None`: there are none.
    pub fn vertical_extrema(&self) -> Option<[ImagePoint; 2]> {
        let [r1, r2, r3, r4, r5, r6] = self.terms;
        let a = r3 * r3 - 4.0 * r1 * r2;
        let lines = roots(a, 2.0 * r3 * r5 - 4.0 * r2 * r4, r5 * r5 - 4.0 * r2 * r6)?;
        Some(lines.map(|line| ImagePoint { line, element: -(r3 * line + r5) / (2.0 * r2) }))
    }

    /// Finds the leftmost and the rightmost point; `None`: there are none.
    pub fn horizontal_extrema(&self) -> Option<[ImagePoint; 2]> {
        let [r1, r2, r3, r4, r5, r6] = self.terms;
        let a = r3 * r3 - 4.0 * r1 * r2;
        let elements = roots(a, 2.0 * r3 * r4 - 4.0 * r1 * r5, r4 * r4 - 4.0 * r1 * r6)?;
        Some(elements.map(|element| ImagePoint { line: -(r3 * element + r4) / (2.0 * r1), element }))
    }

    /// Finds the elements at which a line crosses the outline, the left one first; `None`: it does not.
    pub fn crossings(&self, line: f64) -> Option<[f64; 2]> {
        let [r1, r2, r3, r4, r5, r6] = self.terms;
        roots(r2, r3 * line + r5, (r1 * line + r4) * line + r6)
    }

    /// Finds the centre of an ellipse, and two conjugate half axes, lines and elements; `None`: the conic is none.
    pub fn ellipse(&self) -> Option<(DVec2, [DVec2; 2])> {
        let [top, bottom] = self.vertical_extrema()?;
        let [r1, r2, r3, ..] = self.terms;
        if 4.0 * r1 * r2 - r3 * r3 <= 0.0 {
            return None;
        }
        let [top, bottom] = [top, bottom].map(|at| DVec2::new(at.line, at.element));
        let centre = 0.5 * (top + bottom);
        // The half axis that is conjugate to the one from top to bottom lies along a scan line.
        let [left, right] = self.crossings(centre.x)?;
        Some((centre, [0.5 * (bottom - top), DVec2::new(0.0, 0.5 * (right - left))]))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::{Ball, Cull, ViewFrame};

    const RASTER: Raster = Raster { lines: 480.0, elements: 640.0, vertical_fov: 0.8, horizontal_fov: 1.1 };

    /// Numbers that look random, −1…1.
    fn noise(index: u32) -> f64 {
        2.0 * (f64::from(index) * 0.618_033_988_75 + f64::from(index % 97) * 0.414_213_562).fract() - 1.0
    }

    fn ellipses() -> impl Iterator<Item = FlatEllipse> {
        (0..2000).map(|index| {
            let of = |part: u32| noise(index * 13 + part);
            let axis = |part: u32| DVec3::new(of(part), of(part + 1), of(part + 2)) * 2.0;
            FlatEllipse {
                centre: DVec3::new(15.0 + 5.0 * of(0), 5.0 * of(1), 5.0 * of(2)),
                axes: [axis(3), axis(6)],
            }
        })
    }

    fn residual(conic: &ImageConic, at: DVec2) -> f64 {
        let terms = conic.terms_at(ImagePoint { line: at.x, element: at.y });
        let most = terms.iter().fold(0.0, |most: f64, term| most.max(term.abs()));
        terms.iter().sum::<f64>().abs() / most
    }

    #[test]
    fn all_points_of_an_ellipse_lie_on_its_conic() {
        let mut worst: f64 = 0.0;
        for ellipse in ellipses() {
            let conic = ImageConic::of(&ellipse, &RASTER);
            for step in 0..12 {
                worst = worst.max(residual(&conic, RASTER.project(ellipse.point(f64::from(step)))));
            }
            let centre = RASTER.project(ellipse.centre);
            assert!(conic.value(ImagePoint { line: centre.x, element: centre.y }) < 0.0);
        }
        assert!(worst <= 1e-12, "{worst}");
    }

    #[test]
    fn a_sphere_has_the_conic_of_its_cone() {
        for index in 0..500 {
            let of = |part: u32| noise(index * 7 + part);
            let centre = DVec3::new(20.0 + 9.0 * of(0), 8.0 * of(1), 8.0 * of(2));
            let ball = Ball { centre, radius: 3.0 + 2.0 * of(3) };
            let conic = ImageConic::of_tangents(&ball.disc().unwrap());
            // (d·C)² = (d·d)(D² − R²), d = (1, J, I).
            let m = centre.length_squared() - ball.radius.powi(2);
            let DVec3 { x, y, z } = centre;
            let cone = [z * z - m, y * y - m, 2.0 * y * z, 2.0 * x * z, 2.0 * x * y, x * x - m];
            let ratio = conic.terms[5] / cone[5];
            for (term, wanted) in conic.terms.into_iter().zip(cone) {
                assert!((term - ratio * wanted).abs() < 1e-9 * (ratio * m).abs(), "{conic:?} {cone:?}");
            }
        }
    }

    #[test]
    fn extrema_are_those_of_the_sampled_outline() {
        for ellipse in ellipses().step_by(40) {
            let conic = ImageConic::of(&ellipse, &RASTER);
            let samples = 40_000;
            let outline = (0..samples)
                .map(|step| RASTER.project(ellipse.point(TAU * f64::from(step) / f64::from(samples))));
            let ends = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            let (low, high) = outline.fold(ends, |(low, high), at| (low.min(at), high.max(at)));
            let [top, bottom] = conic.vertical_extrema().unwrap();
            let [left, right] = conic.horizontal_extrema().unwrap();
            let errors =
                [top.line - low.x, bottom.line - high.x, left.element - low.y, right.element - high.y];
            assert!(errors.into_iter().all(|error| error.abs() < 0.01), "{errors:?}");
            for at in [top, bottom, left, right] {
                assert!(residual(&conic, DVec2::new(at.line, at.element)) < 1e-10);
            }
        }
    }

    #[test]
    fn crossings_lie_on_the_outline_and_only_between_top_and_bottom() {
        for ellipse in ellipses().step_by(10) {
            let conic = ImageConic::of(&ellipse, &RASTER);
            let [top, bottom] = conic.vertical_extrema().unwrap();
            for part in [0.01, 0.3, 0.77, 0.99] {
                let line = top.line + part * (bottom.line - top.line);
                let [left, right] = conic.crossings(line).unwrap();
                assert!(left < right);
                for element in [left, right] {
                    assert!(residual(&conic, DVec2::new(line, element)) < 1e-12);
                }
            }
            assert_eq!(conic.crossings(top.line - 0.01), None);
            assert_eq!(conic.crossings(bottom.line + 0.01), None);
        }
    }

    #[test]
    fn image_ellipses_come_back_from_their_conics() {
        let (centre, axes) = (DVec2::new(200.3, 120.8), [DVec2::new(30.0, 4.0), DVec2::new(-6.0, 11.0)]);
        let conic = ImageConic::of_image(centre, axes);
        for step in 0..40 {
            let (sin, cos) = f64::from(step).sin_cos();
            assert!(residual(&conic, centre + axes[0] * cos + axes[1] * sin) < 1e-12);
        }
        let (found, [first, second]) = conic.ellipse().unwrap();
        assert!((found - centre).length() < 1e-9);
        let area = axes[0].perp_dot(axes[1]).abs();
        assert!((first.perp_dot(second).abs() / area - 1.0).abs() < 1e-9);
    }

    /// Eye at (0, 0, 1000), boresight (0, 1000, 0), 512 lines and elements. The report prints no ellipse: one whose ends before and behind
    /// the eye lie on lines 297.5 and 86.5 gives its figures.
    #[test]
    fn an_ellipse_across_the_view_plane_has_false_extrema() {
        let raster = Raster { lines: 512.0, elements: 512.0, vertical_fov: 1.0, horizontal_fov: 1.0 };
        let frame = ViewFrame::looking(DVec3::Z * 1000.0, DVec3::new(0.0, 1000.0, -1000.0));
        let end = |line: f64, ahead: f64| {
            let tangent = (line - raster.centre().x) / raster.scale().x;
            DVec3::new(ahead, 0.0, ahead * tangent)
        };
        let (before, behind) = (end(297.5, 1500.0), end(86.5, -400.0));
        let ellipse = FlatEllipse {
            centre: 0.5 * (before + behind),
            axes: [0.5 * (before - behind), DVec3::Y * 300.0],
        };
        assert_eq!(ellipse.cull(), Some(Cull::CrossesViewPlane));
        // The middle of the ellipse lies before this eye all the same.
        let world = |point: DVec3| {
            let (ahead, up) = (DVec3::new(0.0, 1.0, -1.0), DVec3::new(0.0, 1.0, 1.0));
            frame.eye + (ahead * point.x + up * point.z) / 2_f64.sqrt()
        };
        assert!((frame.point(world(before)) - before).length() < 1e-9);

        let conic = ImageConic::of(&ellipse, &raster);
        let [top, bottom] = conic.vertical_extrema().unwrap();
        assert!((top.line - 86.5).abs() < 1e-6 && (bottom.line - 297.5).abs() < 1e-6, "{top:?} {bottom:?}");
        assert!((top.element - 256.0).abs() < 1e-6 && (bottom.element - 256.0).abs() < 1e-6);
        assert_eq!(conic.horizontal_extrema(), None);
        assert_eq!(conic.ellipse(), None);
        // The point called the bottom is the top of what is before the eye.
        let seen = (0..10_000).map(|step| ellipse.point(f64::from(step) * TAU / 1e4)).filter(|at| at.x > 0.0);
        assert!(seen.map(|at| raster.project(at).x).all(|line| line > 297.5 - 1e-9));
    }
}
