//! Window of a picture in flight over flat ground, and how true its tones are.
//!
//! ```text
//! pixel i lines below the horizon, j columns beside the course:   ground at h·d/i ahead, h·j/i beside
//! edges of its footprint: changes of that place from one column to the next, and from one line to the next
//! error of a pixel  = tone shown − exact tone
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), whose accuracy test has 40 pixels on
//! up to 30 lines at an altitude of 2400 feet and a range of 6 miles, at 200 knots.

use crate::footprint::Footprint;
use crate::pixel_tone::{Averaging, PixelTones};
use crate::projection::Projection;
use crate::shades::Shades;

/// Error, in shades, from which on the study counts pixels.
const COUNTED_ERROR: f64 = 3.0;

/// Window of pixels, and the flight that it looks out of. Lengths are in feet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Pixels along each line, about the course.
    pub columns: u32,
    /// Lines of it.
    pub lines: u32,
    /// Screen, whose horizon is level.
    pub projection: Projection,
    /// Altitude over the ground.
    pub altitude: f64,
    /// Distance on the ground of the window's middle.
    pub range: f64,
    /// Course, degrees from the x axis of cells toward y.
    pub course_deg: f64,
    /// Side of a cell.
    pub cell: f64,
    /// Way from one frame to the next.
    pub step: f64,
}

/// Errors of tones, in shades.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ToneErrors {
    /// Root mean square.
    pub rms: f64,
    /// Greatest.
    pub worst: f64,
    /// Share of pixels that are off by three shades or more.
    pub counted: f64,
}

impl ToneErrors {
    /// Sums up what pixels show beyond their exact tones, not rounded; all zero if there are none.
    pub fn of_tones(shown: &[f64], exact: &[f64]) -> Self {
        Self::of(shown.iter().zip(exact).map(|(shown, exact)| shown - exact))
    }

    /// Sums up errors of shades: both tones are rounded, then reduced.
    pub fn of_shades(shown: &[f64], exact: &[f64], shades: Shades) -> Self {
        let shade = |tone: &f64| f64::from(shades.shade(tone.round() as u8));
        Self::of(shown.iter().zip(exact).map(|(shown, exact)| shade(shown) - shade(exact)))
    }

    fn of(errors: impl Iterator<Item = f64>) -> Self {
        let (mut squares, mut worst, mut counted, mut count) = (0.0, 0.0_f64, 0.0, 0.0_f64);
        for error in errors {
            squares += error * error;
            worst = worst.max(error.abs());
            counted += f64::from(u8::from(error.abs() >= COUNTED_ERROR));
            count += 1.0;
        }
        let count = count.max(1.0);
        Self { rms: (squares / count).sqrt(), worst, counted: counted / count }
    }
}

impl Window {
    /// Window of the study's accuracy test, with cells of 6 feet at 30 frames a second.
    pub const OF_THE_STUDY: Self = Self {
        columns: 40,
        lines: 30,
        projection: Projection::OF_THE_STUDY,
        altitude: 2400.0,
        range: 6.0 * 6076.1,
        course_deg: 0.0,
        cell: 6.0,
        step: 200.0 * 6076.1 / 3600.0 / 30.0,
    };

    /// Footprints of all pixels in a frame, line by line, in cells.
    pub fn footprints(&self, frame: u32) -> Vec<Footprint> {
        let (distance, altitude) = (self.projection.distance(), self.altitude);
        let middle = altitude * distance / self.range;
        let (sin, cos) = self.course_deg.to_radians().sin_cos();
        let turned = |ahead: f64, beside: f64| {
            [ahead * cos - beside * sin, ahead * sin + beside * cos].map(|feet| feet / self.cell)
        };

        let footprint = |number: u32| {
            let below = middle + f64::from(number / self.columns) - 0.5 * f64::from(self.lines - 1);
            let beside = f64::from(number % self.columns) - 0.5 * f64::from(self.columns - 1);
            let flown = f64::from(frame) * self.step;
            Footprint {
                centre: turned(flown + altitude * distance / below, altitude * beside / below),
                edges: [
                    turned(0.0, altitude / below),
                    turned(-altitude * distance / below.powi(2), -altitude * beside / below.powi(2)),
                ],
            }
        };
        (0..self.columns * self.lines).map(footprint).collect()
    }

    /// Tones of all pixels of a frame, greys of 256, not rounded.
    pub fn tones(&self, tones: &PixelTones, averaging: Averaging, frame: u32) -> Vec<f64> {
        self.footprints(frame).iter().map(|footprint| tones.tone(footprint, averaging)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::CyclicCode;

    const WINDOW: Window = Window::OF_THE_STUDY;

    fn tones() -> PixelTones {
        PixelTones::new(CyclicCode::default()).unwrap()
    }

    #[test]
    fn footprints_tile_the_ground_and_move_with_the_flight() {
        let footprints = WINDOW.footprints(0);
        assert_eq!(footprints.len(), 1200);

        // A pixel's neighbours are an edge away, as nearly as edges are straight.
        let (here, beside, below) = (footprints[605], footprints[606], footprints[645]);
        for axis in [0, 1] {
            assert!((here.centre[axis] + here.edges[0][axis] - beside.centre[axis]).abs() < 1e-6);
            assert!((here.centre[axis] + here.edges[1][axis] - below.centre[axis]).abs() < 1.0);
        }
        let later = WINDOW.footprints(6)[605];
        assert!((later.centre[0] - here.centre[0] - 6.0 * WINDOW.step / WINDOW.cell).abs() < 1e-9);
        assert!((WINDOW.step - 11.25).abs() < 0.01, "{} feet", WINDOW.step);
    }

    /// Tones of several frames.
    fn shown(tones: &PixelTones, averaging: Averaging) -> Vec<f64> {
        [0, 90, 179].map(|frame| WINDOW.tones(tones, averaging, frame)).concat()
    }

    #[test]
    fn exact_tones_are_within_a_shade_and_estimates_are_as_in_the_study() {
        let tones = tones();
        let [reference, exact, linear, stepped] =
            [Averaging::Exact(256), Averaging::Exact(32), Averaging::Linear, Averaging::Stepped]
                .map(|averaging| shown(&tones, averaging));
        for (count, centre) in [(256, 128), (32, 101)] {
            let shades = Shades::new(count, centre).unwrap();
            let [exact, linear, stepped] =
                [&exact, &linear, &stepped].map(|shown| ToneErrors::of_shades(shown, &reference, shades));
            assert!(exact.worst <= 1.0 && exact.rms < 0.1, "{count} shades: {exact:?}");
            assert!(linear.rms < stepped.rms && linear.rms > exact.rms, "{linear:?} {stepped:?}");
            // The study counts fewer than 4 % of pixels, of 32 shades.
            assert!(count == 256 || linear.counted < 0.04, "{linear:?}");
        }
    }

    #[test]
    fn rectangles_have_no_error_at_all() {
        // In the middle of the window footprints lie along the axes.
        let (tones, shades) = (tones(), Shades::new(256, 128).unwrap());
        let window = Window { columns: 1, ..WINDOW };
        for frame in 0..20 {
            let [one, many] = [1, 256].map(|slices| window.tones(&tones, Averaging::Exact(slices), frame));
            let errors = ToneErrors::of_shades(&one, &many, shades);
            assert_eq!(errors, ToneErrors::default(), "frame {frame}");
        }
    }

    #[test]
    fn exact_tones_do_not_scintillate() {
        let tones = tones();
        let window = Window { columns: 10, lines: 8, ..WINDOW };
        for frame in (0..180).step_by(20) {
            let reference = window.tones(&tones, Averaging::Exact(256), frame);
            let [exact, samples, linear] = [Averaging::Exact(32), Averaging::Samples(64), Averaging::Linear]
                .map(|averaging| {
                    ToneErrors::of_tones(&window.tones(&tones, averaging, frame), &reference).rms
                });
            assert!(exact <= samples.min(0.5) && linear > 2.0, "frame {frame}: {exact} {samples} {linear}");
        }
    }
}
