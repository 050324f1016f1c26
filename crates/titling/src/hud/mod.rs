//! The pilot's style: horizon, heading, altitudes, speed, time, a small map.
//!
//! ```text
//! readings of the flight ──▶ texts, a tape ─┐
//! directions of the horizon ──camera──▶ line ├──▶ over the picture's codes
//! relief, path, own position ──▶ map ────────┘
//! ```
//!
//! Letters and lines are as many pixels wide as the picture has rows by 360, so that they are read as well on any screen.

mod canvas;
mod map;
#[cfg(test)]
mod tests;

pub use map::MiniMap;

use glam::{DVec2, DVec3};

use crate::dot_font as font;
use crate::readings::Readings;
use canvas::{Canvas, Ink};
use hedgehop::frame::Picture;
use hedgehop::scene::Hud;
use hedgehop::space::Camera;

/// Ink of the instruments.
const INK: Ink = Ink { colour: [120, 255, 150], halo: 0.4 };

/// Rows of a picture for each pixel of a line's width.
const ROWS_PER_DOT: u32 = 360;

/// Degrees that the heading's tape covers, between its marks, and between its numbers.
const TAPE: [i32; 3] = [60, 5, 10];

/// Degrees from point to point of the horizon.
const HORIZON_STEP: f64 = 1.0;

impl Readings {
    /// Lists the lines written at the left, from the top.
    fn left(&self, hud: &Hud) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some([level, up]) = self.speed.filter(|_| hud.speed) {
            lines.push(format!("SPD {level:5.1} M/S"));
            lines.push(format!("VS  {up:+5.1} M/S"));
        }
        if hud.time {
            lines.push(format!("FRAME {}", self.frame));
            lines.push(format!("T {:.2} S", self.seconds));
        }
        lines
    }

    /// Lists the lines written at the right, from the top.
    fn right(&self, hud: &Hud) -> Vec<String> {
        let mut lines = Vec::new();
        if hud.altitude {
            lines.push(format!("MSL {:6.0} M", self.altitude));
            lines.push(match self.above_ground {
                Some(metres) => format!("AGL {metres:6.0} M"),
                None => "AGL    --- M".to_owned(),
            });
        }
        lines
    }

    /// The heading's number: 001 to 360.
    fn heading_text(&self) -> String {
        let whole = self.heading.rem_euclid(360.0).round() as i32;
        format!("{:03}", if whole == 0 { 360 } else { whole })
    }
}

/// Draws what `hud` shows over a picture of what `camera` saw; a map, where there is one, in the lower right corner. Nothing is drawn beside the picture.
///
/// The horizon is where directions rise by 0°, not where the ground ends: it lies a little higher than that. Screens that are tables of rays show none, since no place of
/// theirs belongs to a direction.
pub fn draw(picture: &mut Picture, camera: &Camera, hud: &Hud, readings: &Readings, map: Option<&MiniMap>) {
    if hud.is_empty() {
        return;
    }

    let dot = picture.height.div_ceil(ROWS_PER_DOT).max(1) as usize;
    let mut canvas = Canvas::new(picture, dot);
    let margin = 10.0 * dot as f64;
    if hud.horizon {
        horizon(&mut canvas, camera);
    }
    if hud.heading {
        heading(&mut canvas, readings, margin);
    }

    let size = canvas.size();
    let line = (font::HEIGHT + 4) as i64 * dot as i64;

    // Below the tape, which is as high as three lines.
    let top = margin as i64 + 3 * line;
    for (index, text) in readings.left(hud).iter().enumerate() {
        canvas.text(text, [margin as i64, top + index as i64 * line], INK);
    }
    for (index, text) in readings.right(hud).iter().enumerate() {
        let left = (size.x - margin) as i64 - canvas.width_of(text);
        canvas.text(text, [left, top + index as i64 * line], INK);
    }

    if let Some(map) = map.filter(|_| hud.map) {
        let &Readings { place, heading, .. } = readings;
        map.draw(&mut canvas, size - margin, 0.3 * size.min_element(), place, heading, INK);
    }
}

/// The line of all level directions, and a mark where the view's axis points.
fn horizon(canvas: &mut Canvas<'_>, camera: &Camera) {
    let size = canvas.size();
    let eye = camera.pose.eye;
    let at = |index: i32| {
        let (sine, cosine) = (f64::from(index) * HORIZON_STEP).to_radians().sin_cos();
        camera.screen_from_world(eye + DVec3::new(sine, cosine, 0.0))
    };
    let count = (360.0 / HORIZON_STEP) as i32;
    let part = |index: i32| Some([at(index)?, at(index + 1)?]);

    // Where a screen ends the line does not go back to its other end.
    let is_part = |[from, to]: &[DVec2; 2]| (*to - *from).length() < 0.5 * size.max_element();
    let parts: Vec<_> = (0..count).filter_map(part).filter(is_part).collect();
    canvas.lines(&parts, INK);

    if let Some(axis) = camera.screen_from_world(eye + camera.world_from_view().z_axis) {
        let arm = 6.0 * canvas.dot as f64;
        for side in [-1.0, 1.0] {
            canvas.line([axis + DVec2::new(side * arm, 0.0), axis + DVec2::new(2.5 * side * arm, 0.0)], INK);
        }
        canvas.line([axis, axis], INK);
    }
}

/// The heading as a number above a tape that moves below it.
fn heading(canvas: &mut Canvas<'_>, readings: &Readings, margin: f64) {
    let (size, dot) = (canvas.size(), canvas.dot as f64);
    let middle = 0.5 * size.x;
    let [covered, mark, number] = TAPE;
    let per_degree = 0.4 * size.x / f64::from(covered);
    let line = (font::HEIGHT + 4) as f64 * dot;
    let text = readings.heading_text();
    canvas.text(&text, [(middle - 0.5 * canvas.width_of(&text) as f64) as i64, margin as i64], INK);
    let base = margin + line;
    canvas.line([DVec2::new(middle, base - 2.0 * dot), DVec2::new(middle, base + 4.0 * dot)], INK);
    let first = ((readings.heading - 0.5 * f64::from(covered)) / f64::from(mark)).ceil() as i32;
    let last = ((readings.heading + 0.5 * f64::from(covered)) / f64::from(mark)).floor() as i32;

    for degrees in (first..=last).map(|index| index * mark) {
        let across = middle + (f64::from(degrees) - readings.heading) * per_degree;
        let is_numbered = degrees % number == 0;
        let long = if is_numbered { 5.0 } else { 3.0 };
        let low = base + 5.0 * dot;
        canvas.line([DVec2::new(across, low), DVec2::new(across, low + long * dot)], INK);
        if is_numbered {
            let text = mark_text(degrees);
            let left = across - 0.5 * canvas.width_of(&text) as f64;
            canvas.text(&text, [left as i64, (low + 7.0 * dot) as i64], INK);
        }
    }
}

/// Labels a mark of the tape: the quarter of the wind, or tens of degrees.
fn mark_text(degrees: i32) -> String {
    match degrees.rem_euclid(360) {
        0 => "N".to_owned(),
        90 => "E".to_owned(),
        180 => "S".to_owned(),
        270 => "W".to_owned(),
        other => format!("{:02}", other / 10),
    }
}
