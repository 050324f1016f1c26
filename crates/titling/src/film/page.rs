//! The page: what part of a picture figures have, how large they are, and their colours.

use glam::DVec2;

use crate::layer::Ink;
use hedgehop_base::Size;

/// Colour of text.
pub const WHITE: Ink = Ink::solid([255, 255, 255]);
/// Colour of the way to come.
pub const AHEAD: Ink = Ink { colour: [255, 255, 255], opacity: 0.55 };
/// Colour of the way passed.
pub const PASSED: Ink = Ink::solid([255, 140, 0]);

/// Colour of panels, behind what needs one.
pub const PANEL: Ink = Ink { colour: [0, 0, 0], opacity: 0.45 };

/// Power of a small picture's size by which figures are smaller: letters stay large enough to be read.
const SMALLER: f64 = 0.8;

/// Rectangle of a picture, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Upper left corner.
    pub corner: DVec2,
    /// Width and height.
    pub size: DVec2,
}

impl Area {
    /// Returns its lower right corner.
    pub fn far(&self) -> DVec2 {
        self.corner + self.size
    }

    /// Whether it has a point in common with another.
    pub fn meets(&self, other: &Self) -> bool {
        self.corner.cmplt(other.far()).all() && other.corner.cmplt(self.far()).all()
    }

    /// Whether another lies within it.
    pub fn holds(&self, other: &Self) -> bool {
        const ROUNDING: f64 = 1.0e-6;
        self.corner.cmple(other.corner + ROUNDING).all() && other.far().cmple(self.far() + ROUNDING).all()
    }
}

/// Sizes of a picture's figures.
#[derive(Debug, Clone, Copy)]
pub struct Page {
    /// Pixels of a unit: a pixel of a picture of 1920 × 1080.
    unit: f64,
    /// The part of the picture that is drawn on.
    safe: Area,
}

impl Page {
    /// Lays a page over a picture, `margin` (a share of its sides) from its border.
    pub fn new(size: Size, margin: f64) -> Self {
        let size = DVec2::new(f64::from(size.width), f64::from(size.height));
        let unit = (size.x / 1920.0).min(size.y / 1080.0).max(0.5 * size.max_element() / 1920.0);
        let unit = if unit < 1.0 { unit.powf(SMALLER) } else { unit };
        Self { unit, safe: Area { corner: margin * size, size: (1.0 - 2.0 * margin) * size } }
    }

    /// Returns the part of the picture that is drawn on.
    pub fn safe(&self) -> &Area {
        &self.safe
    }

    /// Returns the row that ends the part that is drawn on.
    pub fn bottom(&self) -> f64 {
        self.safe.far().y
    }

    /// Returns a length in pixels.
    pub fn px(&self, units: f64) -> f64 {
        self.unit * units
    }

    /// Returns a size of letters that can still be read, pixels an em.
    pub fn letters(&self, units: f64) -> f32 {
        const LEAST: f64 = 11.0;
        self.px(units).max(LEAST.min(0.05 * self.safe.size.y)) as f32
    }
}
