//! A bar of a round length, with its length beside it.

use glam::DVec2;

use super::measure;
use super::page::{Area, Page, WHITE};
use crate::layer::{Ink, Layer, polyline};
use crate::text::{TextStyle, Typesetter};
use hedgehop::scene::Units;

/// Size of the letters, and height of the bar's ends, units.
const LETTERS: f64 = 20.0;
const END: f64 = 10.0;

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
    /// Draws it, its upper left corner at a place.
    pub fn layer(&self, corner: DVec2, page: &Page, typesetter: &Typesetter<'_>) -> Option<(Area, Layer)> {
        let metres = measure::round_length(self.longest * self.metres_per_pixel, self.units);
        let length = metres / self.metres_per_pixel;
        let text =
            typesetter.set(&measure::distance(metres, self.units), &TextStyle::line(page.letters(LETTERS)));
        let (gap, end) = (page.px(12.0), page.px(END));
        let tall = f64::from(text.extent[1]).max(end);
        let size = DVec2::new(length + gap + f64::from(text.extent[0]), tall);

        let halo = DVec2::splat(page.px(6.0));
        let mut layer = Layer::new(corner - halo, size + 2.0 * halo)?;
        let (left, middle) = (corner.x, corner.y + 0.5 * tall);
        let bar = polyline([
            DVec2::new(left, middle - 0.5 * end),
            DVec2::new(left, middle + 0.5 * end),
            DVec2::new(left + length, middle + 0.5 * end),
            DVec2::new(left + length, middle - 0.5 * end),
        ])?;
        let width = page.px(3.0).max(1.0);
        layer.stroke(&bar, width + page.px(4.0), Ink::solid([0; 3]).faint(0.4));
        layer.stroke(&bar, width, WHITE);
        layer.text(&text, DVec2::new(left + length + gap, middle - 0.5 * f64::from(text.extent[1])), WHITE);
        Some((Area { corner, size }, layer))
    }
}
