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

/// Slices of the exact tone that others are judged by.
const REFERENCE: Averaging = Averaging::Exact(256);

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
    /// Sums up errors of pixels; all zero if there are none.
    pub fn of(errors: &[f64]) -> Self {
        let count = errors.len().max(1) as f64;
        Self {
            rms: (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt(),
            worst: errors.iter().fold(0.0, |worst, error| worst.max(error.abs())),
            counted: errors.iter().filter(|error| error.abs() >= COUNTED_ERROR).count() as f64 / count,
        }
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

    /// Errors of each pixel of a frame against its exact tone, in greys of 256, not rounded.
    pub fn residuals(&self, tones: &PixelTones, averaging: Averaging, frame: u32) -> Vec<f64> {
        let footprints = self.footprints(frame);
        footprints.iter().map(|it| tones.tone(it, averaging) - tones.tone(it, REFERENCE)).collect()
    }

    /// Errors of each pixel of a frame as shown, in shades: both tones are rounded, then reduced.
    pub fn shade_errors(
        &self,
        tones: &PixelTones,
        averaging: Averaging,
        shades: Shades,
        frame: u32,
    ) -> Vec<f64> {
        let shown = |footprint: &Footprint, averaging| {
            f64::from(shades.shade(tones.tone(footprint, averaging).round() as u8))
        };
        self.footprints(frame).iter().map(|it| shown(it, averaging) - shown(it, REFERENCE)).collect()
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

    #[test]
    fn exact_tones_are_within_a_shade_and_estimates_are_as_in_the_study() {
        let tones = tones();
        for (count, centre, most) in [(256, 128, 1.0), (32, 101, 1.0)] {
            let shades = Shades::new(count, centre).unwrap();
            let errors = |averaging| {
                let frames = [0, 90, 179].map(|frame| WINDOW.shade_errors(&tones, averaging, shades, frame));
                ToneErrors::of(&frames.concat())
            };
            let exact = errors(Averaging::Exact(32));
            assert!(exact.worst <= most && exact.rms < 0.2, "{count} shades: {exact:?}");

            let [linear, stepped] = [Averaging::Linear, Averaging::Stepped].map(errors);
            assert!(linear.rms < stepped.rms && linear.rms > exact.rms, "{linear:?} {stepped:?}");
            if count == 32 {
                assert!(linear.counted < 0.04, "{linear:?}");
            }
        }
    }

    #[test]
    fn rectangles_have_no_error_at_all() {
        // In the middle of the window footprints lie along the axes.
        let (tones, shades) = (tones(), Shades::new(256, 128).unwrap());
        let window = Window { columns: 1, ..WINDOW };
        for frame in 0..20 {
            let errors = window.shade_errors(&tones, Averaging::Exact(1), shades, frame);
            assert!(errors.iter().all(|&error| error == 0.0), "{errors:?}");
        }
    }

    #[test]
    fn exact_tones_do_not_scintillate() {
        let tones = tones();
        let window = Window { columns: 10, lines: 8, ..WINDOW };
        for frame in (0..180).step_by(20) {
            let of = |averaging| ToneErrors::of(&window.residuals(&tones, averaging, frame)).rms;
            let [exact, linear] = [Averaging::Exact(32), Averaging::Linear].map(of);
            let samples = of(Averaging::Samples(64));
            assert!(exact <= samples.min(0.5) && linear > 2.0, "frame {frame}: {exact} {samples} {linear}");
        }
    }
}
