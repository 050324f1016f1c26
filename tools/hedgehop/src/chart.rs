//! Chart drawn on a map: a path with its ends, the visible ground of frames, a scale, and where north is.

use glam::DVec2;
use image::{Rgb, RgbImage};

use crate::drawing::Mask;
use crate::lettering;
use hedgehop::frame::Frame;
use hedgehop::space::Camera;

const WHITE: Rgb<u8> = Rgb([255; 3]);
const DARK: Rgb<u8> = Rgb([20, 20, 24]);
const PATH: Rgb<u8> = Rgb([226, 60, 30]);
const START: Rgb<u8> = Rgb([40, 150, 70]);
const VISIBLE: Rgb<u8> = Rgb([120, 225, 255]);

/// Visible ground of a frame.
#[derive(Debug, Clone)]
pub struct Footprint {
    /// Place of the eye.
    eye: DVec2,
    /// Around what is seen: the near edge from left to right, the far one back.
    outline: Vec<DVec2>,
    /// Ends of the near edge.
    near: Vec<DVec2>,
}

/// A map.
#[derive(Debug, Clone, Copy)]
pub struct Chart<'c> {
    /// Camera that looks down.
    pub camera: &'c Camera,
    pub path: &'c [DVec2],
    pub footprints: &'c [Footprint],
}

impl Footprint {
    /// Finds the ground that a frame shows.
    pub fn of(frame: &Frame) -> Self {
        let (width, eye) = (frame.camera.width as usize, frame.camera.pose.eye);
        let (mut near, mut far) = (Vec::new(), Vec::new());
        for column in 0..width {
            let place = |row: usize| {
                let range = f64::from(frame.range[row * width + column]);
                let ray = frame.camera.ray(column as f64 + 0.5, row as f64 + 0.5)?;
                let point = ray.origin + ray.direction * range;
                range.is_finite().then(|| point.truncate())
            };
            let distance = |place: &DVec2| (*place - eye.truncate()).length();
            let places = || (0..frame.camera.height as usize).filter_map(place);
            near.extend(places().min_by(|a, b| distance(a).total_cmp(&distance(b))));
            far.extend(places().max_by(|a, b| distance(a).total_cmp(&distance(b))));
        }
        far.reverse();
        let ends = near.first().into_iter().chain(near.last()).copied().collect();
        Self { eye: eye.truncate(), outline: [near, far].concat(), near: ends }
    }
}

impl Chart<'_> {
    /// Draws it on what the camera sees.
    pub fn draw(&self, mut picture: RgbImage) -> RgbImage {
        let unit = (f64::from(picture.width().max(picture.height())) / 1200.0).max(0.5);
        let at = |place: &DVec2| {
            let point = place.extend(self.camera.pose.eye.z - 1.0);
            self.camera.screen_from_world(point).unwrap_or(DVec2::NEG_INFINITY)
        };

        for footprint in self.footprints {
            let mut outline: Vec<DVec2> = footprint.outline.iter().map(at).collect();
            let mut inside = Mask::new(&picture);
            inside.polygon(&outline);
            inside.paint(&mut picture, VISIBLE, 0.09);
            outline.extend(outline.first().copied());
            let mut edge = Mask::new(&picture);
            edge.lines(&outline, 1.2 * unit);
            let eye = at(&footprint.eye);
            for corner in footprint.near.iter().map(at) {
                edge.lines(&[eye, corner], 1.2 * unit);
            }

            edge.paint(&mut picture, VISIBLE, 0.75);
        }

        let path: Vec<DVec2> = self.path.iter().map(at).collect();
        for (width, colour, opacity) in [(5.0, WHITE, 0.85), (2.6, PATH, 1.0)] {
            let mut line = Mask::new(&picture);
            line.lines(&path, width * unit);
            line.paint(&mut picture, colour, opacity);
        }

        for (size, colour) in [(5.5, DARK), (4.0, VISIBLE)] {
            let mut eyes = Mask::new(&picture);
            self.footprints.iter().for_each(|footprint| eyes.disc(at(&footprint.eye), size * unit));
            eyes.paint(&mut picture, colour, 1.0);
        }

        for (size, colours) in [(8.0, [WHITE; 2]), (6.0, [START, PATH])] {
            let mut ends = [Mask::new(&picture), Mask::new(&picture)];
            if let [first, .., last] = path.as_slice() {
                ends[1].square(*last, 0.9 * size * unit);
                ends[0].disc(*first, size * unit);
            }
            // The start is on top, as of a round trip both are in one place.
            for (end, colour) in ends.iter().zip(colours).rev() {
                end.paint(&mut picture, colour, 1.0);
            }
        }

        scale(&mut picture, self.camera.focal_px(), "", unit);
        picture
    }
}

/// A bar of a round length, and an arrow to the north, in the lower left corner of a picture with so many pixels to the metre; above them a line of text,
/// unless that is empty. `unit` is the size of what is drawn, pixels.
pub fn scale(picture: &mut RgbImage, pixels_per_metre: f64, above: &str, unit: f64) {
    let (width, height) = picture.dimensions();
    let letters = (2.0 * unit).round().max(1.0) as u32;
    let margin = 14.0 * unit;

    let metres = round_length(0.22 * f64::from(width) / pixels_per_metre);
    let length = metres * pixels_per_metre;
    let text = length_text(metres);

    // The box holds the bar, the arrow beside it, and the line above.
    let tall = f64::from(lettering::height(letters));
    let arrow = 2.4 * tall;
    let wide = length.max(f64::from(lettering::width(&text, letters))) + arrow + 2.0 * margin;
    let wide = wide.max(f64::from(lettering::width(above, letters)) + margin);
    let line = if above.is_empty() { 0.0 } else { tall + 0.8 * margin };
    let high = tall + 3.0 * margin + line;
    let low = DVec2::new(margin, f64::from(height) - margin - high);

    let mut box_behind = Mask::new(picture);
    let corner = |x: f64, y: f64| low + DVec2::new(x * (wide + margin), y * high);
    box_behind.polygon(&[corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
    box_behind.paint(picture, DARK, 0.62);

    let base = low + DVec2::new(margin, high - margin);
    let mut bar = Mask::new(picture);
    let tick = DVec2::new(0.0, -0.5 * margin);
    bar.lines(
        &[base + tick, base, base + DVec2::new(length, 0.0), base + DVec2::new(length, 0.0) + tick],
        2.0 * unit,
    );

    let tip = DVec2::new(base.x + wide - margin - 0.5 * arrow, low.y + line + 0.7 * margin);
    let foot = DVec2::new(tip.x, base.y - tall - 0.4 * margin);
    let barb = 0.45 * (foot.y - tip.y);
    bar.lines(&[foot, tip, tip + DVec2::new(-0.6 * barb, barb)], 2.0 * unit);
    bar.lines(&[tip, tip + DVec2::new(0.6 * barb, barb)], 2.0 * unit);
    bar.paint(picture, WHITE, 1.0);

    let [left, top] = [base.x, base.y - 0.8 * margin - tall].map(|place| place.round() as i64);
    lettering::write(picture, &text, [left, top], letters, WHITE);
    let half = 0.5 * f64::from(lettering::width("N", letters));
    let [left, top] = [tip.x - half, base.y - tall].map(|place| place.round() as i64);
    lettering::write(picture, "N", [left, top], letters, WHITE);
    let [left, top] = [low.x + margin, low.y + 0.7 * margin].map(|place| place.round() as i64);
    lettering::write(picture, above, [left, top], letters, WHITE);
}

/// The largest of 1, 2, 5, 10, … metres, or of their parts, that is no longer than this.
fn round_length(metres: f64) -> f64 {
    let power = 10.0_f64.powf(metres.max(f64::MIN_POSITIVE).log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|step| step * power)
        .find(|length| *length <= metres * (1.0 + 1e-9))
        .unwrap_or(power)
}

fn length_text(metres: f64) -> String {
    if metres >= 1000.0 { format!("{} km", metres / 1000.0) } else { format!("{metres} m") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round() {
        for (metres, text) in [
            (1234.0, "1 km"),
            (999.9, "500 m"),
            (2000.0, "2 km"),
            (4999.0, "2 km"),
            (57.0, "50 m"),
            (0.3, "0.2 m"),
            (123_456.0, "100 km"),
        ] {
            assert_eq!(length_text(round_length(metres)), text, "{metres}");
        }
    }
}
