//! The compass: an arrow that points to grid north.

use glam::DVec2;

use super::page::{Area, PANEL, PASSED, Page, WHITE};
use crate::layer::{Layer, disc, polygon};
use crate::text::{TextStyle, Typesetter};

/// Radius of its panel, units.
const RADIUS: f64 = 46.0;

/// An arrow on a round panel.
pub struct Compass {
    /// Square around the panel.
    pub area: Area,
    /// Direction up in the picture, or ahead of it, degrees clockwise from grid north.
    heading: f64,
}

impl Compass {
    /// Returns the row below it.
    pub fn bottom(page: &Page) -> f64 {
        page.safe().corner.y + page.px(2.0 * RADIUS)
    }

    /// Places it at the upper edge of the page, its right side at a column.
    pub fn new(right: f64, heading: f64, page: &Page) -> Self {
        let side = 2.0 * page.px(RADIUS);
        let corner = DVec2::new(right - side, page.safe().corner.y);
        Self { area: Area { corner, size: DVec2::splat(side) }, heading }
    }

    /// Draws it.
    pub fn layers(&self, page: &Page, typesetter: &Typesetter<'_>) -> Vec<Layer> {
        let Area { corner, size } = self.area;
        let Some(mut layer) = Layer::new(corner, size) else { return Vec::new() };
        let middle = corner + 0.5 * size;
        if let Some(panel) = disc(middle, 0.5 * size.x) {
            layer.fill(&panel, PANEL);
        }

        let radius = 0.5 * size.x;
        let (sine, cosine) = (-self.heading).to_radians().sin_cos();
        let (north, east) = (DVec2::new(sine, -cosine), DVec2::new(cosine, sine));
        for (tip, ink) in [(north, PASSED), (-north, WHITE.faint(0.8))] {
            let side = 0.18 * radius * east;
            let needle = polygon([middle + 0.5 * radius * tip, middle + side, middle - side]);
            needle.iter().for_each(|needle| layer.fill(needle, ink));
        }

        let letter = typesetter.set("N", &TextStyle::line(page.letters(20.0)));
        let half = 0.5 * DVec2::new(f64::from(letter.extent[0]), f64::from(letter.extent[1]));
        layer.text(&letter, middle + 0.73 * radius * north - half, WHITE);
        vec![layer]
    }
}
