//! A bar of a round length, with its length beside it.

use glam::DVec2;

use super::measure;
use super::page::{Area, PANEL, Page, WHITE};
use crate::layer::{Layer, polyline, rectangle};
use crate::text::{TextStyle, Typesetter};
use hedgehop::scene::Units;

/// Size of the letters, height of the bar's ends, and space to the panel's border, units.
const LETTERS: f64 = 20.0;
const END: f64 = 10.0;
const BORDER: f64 = 6.0;

/// A bar of a round length.
#[derive(Debug, Clone, Copy)]
pub struct ScaleBar {
    /// Metres on the ground of a pixel.
    pub metres_per_pixel: f64,
    /// Units of its length.
    pub units: Units,
    /// Greatest length, pixels.
    pub longest: f64,
}

impl ScaleBar {
    /// Draws it on a panel, whose upper left corner is at a place.
    pub fn layer(&self, corner: DVec2, page: &Page, typesetter: &Typesetter<'_>) -> Option<(Area, Layer)> {
        let metres = measure::round_length(self.longest * self.metres_per_pixel, self.units);
        let length = metres / self.metres_per_pixel;
        let text =
            typesetter.set(&measure::distance(metres, self.units), &TextStyle::line(page.letters(LETTERS)));
        let (gap, end) = (page.px(12.0), page.px(END));
        let tall = f64::from(text.extent[1]).max(end);
        let border = DVec2::splat(page.px(BORDER));
        let size = DVec2::new(length + gap + f64::from(text.extent[0]), tall) + 2.0 * border;

        let mut layer = Layer::new(corner, size)?;
        layer.fill(&rectangle(corner, size)?, PANEL);
        let (left, middle) = (corner.x + border.x, corner.y + 0.5 * size.y);
        let bar = polyline([
            DVec2::new(left, middle - 0.5 * end),
            DVec2::new(left, middle + 0.5 * end),
            DVec2::new(left + length, middle + 0.5 * end),
            DVec2::new(left + length, middle - 0.5 * end),
        ])?;
        let width = page.px(3.0).max(1.0);
        layer.stroke(&bar, width, WHITE);
        layer.text(&text, DVec2::new(left + length + gap, middle - 0.5 * f64::from(text.extent[1])), WHITE);
        Some((Area { corner, size }, layer))
    }
}
