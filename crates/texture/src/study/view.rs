//! Flat ground as an eye sees it on a screen, both ways.
//!
//! ```text
//! ray of (I, J)     D = d·u + J·v + I·w
//! ground            altitude·(D_x, D_y)/D_down ahead of the eye          where D_down > 0
//! back              I = d·w/u, J = d·v/u
//! edges of the footprint of a pixel = changes of its ground for one column, and for one line
//! ```
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), which prints `x = z·w/u`; x = z·u/w is
//! what its geometry needs.

use super::eye::Eye;
use super::pixel_share::{HalfPlane, ScreenPoint};
use crate::footprint::Footprint;
use crate::projection::Projection;

/// Raster of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// Pixels of a line, and the angle that they fill.
    pub projection: Projection,
    /// Lines.
    pub lines: u32,
}

/// View of flat ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundView {
    eye: Eye,
    /// u, v and w, each along x, y and down.
    axes: [[f64; 3]; 3],
    screen: Screen,
    /// Distance of the screen, pixels.
    distance: f64,
}

impl Screen {
    /// Middle of a pixel by its number, line by line from the upper left corner.
    pub fn pixel(self, number: u32) -> ScreenPoint {
        let from_middle = |place: u32, count: u32| f64::from(place) + 0.5 - 0.5 * f64::from(count);
        let pixels = self.projection.pixels;
        ScreenPoint {
            line: from_middle(number / pixels, self.lines),
            column: from_middle(number % pixels, pixels),
        }
    }

    /// Number of pixels.
    pub fn size(self) -> u32 {
        self.projection.pixels * self.lines
    }
}

impl GroundView {
    /// Looks from an eye at a screen.
    pub fn new(eye: Eye, screen: Screen) -> Self {
        Self { eye, axes: eye.attitude.axes(), screen, distance: screen.projection.distance() }
    }

    /// The screen.
    pub fn screen(&self) -> Screen {
        self.screen
    }

    /// Half sides of the screen at unit distance: tangents of half the fields of view, down and to the right.
    pub fn half_tangents(&self) -> [f64; 2] {
        [self.screen.lines, self.screen.projection.pixels].map(|count| 0.5 * f64::from(count) / self.distance)
    }

    /// Part of the screen that shows ground, below the horizon.
    pub fn below_horizon(&self) -> HalfPlane {
        let [u, v, w] = self.axes.map(|axis| axis[2]);
        HalfPlane { by_line: w, by_column: v, middle: u * self.distance }
    }

    /// Ground at a place of the screen, feet; `None` from the horizon on upward.
    pub fn ground(&self, at: ScreenPoint) -> Option<[f64; 2]> {
        let ray = self.ray(at);
        (ray[2] > 0.0)
            .then(|| [0, 1].map(|axis| self.eye.place[axis] + self.eye.altitude * ray[axis] / ray[2]))
    }

    /// Place on the ground in the axes u, v and w of the eye, feet.
    pub fn seen(&self, ground: [f64; 2]) -> [f64; 3] {
        let offset = [ground[0] - self.eye.place[0], ground[1] - self.eye.place[1], self.eye.altitude];
        self.axes.map(|axis| axis.iter().zip(offset).map(|(axis, offset)| axis * offset).sum())
    }

    /// Place on the screen of what lies ahead in the eye's axes.
    pub fn projected(&self, [u, v, w]: [f64; 3]) -> ScreenPoint {
        ScreenPoint { line: self.distance * w / u, column: self.distance * v / u }
    }

    /// Footprint of the pixel about a place of the screen, in cells of a side in feet; `None` from the
    /// horizon on upward.
    pub fn footprint(&self, at: ScreenPoint, cell: f64) -> Option<Footprint> {
        let (ground, ray) = (self.ground(at)?, self.ray(at));
        let [_, v, w] = self.axes;
        let change = |along: [f64; 3]| {
            [0, 1].map(|axis| {
                let turned = along[axis] * ray[2] - ray[axis] * along[2];
                self.eye.altitude * turned / (ray[2] * ray[2] * cell)
            })
        };
        Some(Footprint { centre: ground.map(|feet| feet / cell), edges: [change(v), change(w)] })
    }

    /// Direction of what a place of the screen shows, along x, y and down.
    fn ray(&self, at: ScreenPoint) -> [f64; 3] {
        let [u, v, w] = self.axes;
        std::array::from_fn(|axis| self.distance * u[axis] + at.column * v[axis] + at.line * w[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::super::eye::EyeAttitude;
    use super::*;

    const SCREEN: Screen = Screen { projection: Projection::OF_THE_STUDY, lines: 480 };

    fn view(heading_deg: f64, pitch_deg: f64, roll_deg: f64) -> GroundView {
        let attitude = EyeAttitude { heading_deg, pitch_deg, roll_deg };
        GroundView::new(Eye { place: [700.0, -90.0], altitude: 1000.0, attitude }, SCREEN)
    }

    fn turned(at: ScreenPoint, degrees: f64) -> ScreenPoint {
        let (sin, cos) = degrees.to_radians().sin_cos();
        ScreenPoint { line: cos * at.line - sin * at.column, column: sin * at.line + cos * at.column }
    }

    #[test]
    fn ground_and_screen_are_inverse() {
        let view = view(20.0, -8.0, 30.0);
        for number in (0..SCREEN.size()).step_by(997) {
            let at = SCREEN.pixel(number);
            let Some(ground) = view.ground(at) else { continue };
            let back = view.projected(view.seen(ground));
            assert!((back.line - at.line).abs() < 1e-6 && (back.column - at.column).abs() < 1e-6);
        }
    }

    #[test]
    fn rolling_turns_the_ground_about_the_middle_of_the_screen() {
        let level = view(20.0, -15.0, 0.0);
        for roll in [-45.0, 30.0, 45.0, 90.0, 170.0] {
            let rolled = view(20.0, -15.0, roll);
            for number in (0..SCREEN.size()).step_by(1009) {
                let at = SCREEN.pixel(number);
                let (Some(a), Some(b)) = (level.ground(at), rolled.ground(turned(at, roll))) else {
                    continue;
                };
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn headings_turn_the_ground_about_the_eye_and_pitch_lifts_the_horizon() {
        let (ahead, right) = (view(0.0, -10.0, 0.0), view(90.0, -10.0, 0.0));
        let at = ScreenPoint { line: 30.0, column: 50.0 };
        let [a, b] = [ahead, right].map(|view| view.ground(at).unwrap());
        // Ground that was ahead lies to the right.
        let [a, b] = [a, b].map(|place| [place[0] - 700.0, place[1] + 90.0]);
        assert!((b[0] + a[1]).abs() < 1e-9 && (b[1] - a[0]).abs() < 1e-9);

        let horizon = |pitch: f64| -pitch.to_radians().tan() * -Projection::OF_THE_STUDY.distance();
        for pitch in [-6.0, -2.0, 0.0, 3.0] {
            let half = view(0.0, pitch, 0.0).below_horizon();
            assert!(half.at(ScreenPoint { line: horizon(pitch), column: 9.0 }).abs() < 1e-9);
        }
    }

    #[test]
    fn footprints_are_changes_of_the_ground() {
        let view = view(20.0, -9.0, 25.0);
        let at = ScreenPoint { line: 40.0, column: -70.0 };
        let footprint = view.footprint(at, 6.0).unwrap();
        for (edge, (line, column)) in footprint.edges.iter().zip([(0.0, 1e-4), (1e-4, 0.0)]) {
            let place = |sign: f64| {
                view.ground(ScreenPoint { line: at.line + sign * line, column: at.column + sign * column })
            };
            let (Some(a), Some(b)) = (place(-0.5), place(0.5)) else { panic!("below the horizon") };
            for axis in 0..2 {
                assert!(((b[axis] - a[axis]) / 6e-4 - edge[axis]).abs() < 1e-4 * (1.0 + edge[axis].abs()));
            }
        }
        assert_eq!(view.footprint(ScreenPoint { line: -4000.0, column: 0.0 }, 6.0), None);
    }
}
