//! The film's style: figures and cards for an audience.
//!
//! ```text
//! ┌────────────────────────────────────┐
//! │                      compass   map │
//! │               title          scale │
//! │               credits              │
//! │               caption              │
//! │ figures, place             profile │
//! └────────────────────────────────────┘
//! ```
//!
//! Sizes are given for pictures of 1920 × 1080 and grow with the picture. A part that has no room beside those before it is left out.

mod cards;
mod compass;
mod inset;
mod measure;
mod page;
mod profile;
mod readouts;
mod scale_bar;
#[cfg(test)]
mod tests;

use glam::{DMat3, DVec2};

use crate::fonts::Fonts;
use crate::layer::Layer;
use crate::readings::Readings;
use crate::relief::Relief;
use crate::text::Typesetter;
use crate::track_point::TrackPoint;
use hedgehop::scene::{Figures, Units};
use hedgehop::space::{Camera, Footprint};

pub use cards::{Card, CardPlace, CardText};
use inset::InsetMap;
use page::Area;
pub use page::Page;
use profile::Profile;
use scale_bar::ScaleBar;

/// Data of a film that its figures need.
pub struct FilmSubject {
    /// Path of what flies over the film, rising in time.
    pub track: Vec<TrackPoint>,
    /// Relief around the path, if a map is drawn.
    pub relief: Option<Relief>,
}

/// Figures of the film's style, ready to be drawn.
#[derive(Debug)]
pub struct FilmFigures {
    figures: Figures,
    units: Units,
    utc_offset: f64,
    page: Page,
    inset: Option<InsetMap>,
    profile: Option<Profile>,
}

impl FilmFigures {
    /// Draws what is the same in all pictures.
    pub fn new(
        figures: Figures,
        units: Units,
        utc_offset: f64,
        page: Page,
        subject: FilmSubject,
        fonts: &Fonts,
    ) -> Self {
        let typesetter = Typesetter::new(fonts.faces());
        let FilmSubject { track, relief } = subject;
        let scale = figures.scale.then_some(units);
        let profile = figures.profile.then(|| Profile::new(&track, units, &page, &typesetter)).flatten();
        let inset = relief.and_then(|relief| InsetMap::new(relief, track, scale, &page, &typesetter));
        Self { figures, units, utc_offset, page, inset, profile }
    }

    /// Returns the width that a title in the middle may have, clear of the map, pixels.
    pub fn title_width(&self) -> f64 {
        let safe = self.page.safe();
        let middle = safe.corner.x + 0.5 * safe.size.x;
        let right =
            self.inset.as_ref().map_or(safe.far().x, |inset| inset.area.corner.x - self.page.px(40.0));
        2.0 * (right - middle)
    }

    /// Returns the layers of a picture, and the height that is free for captions, pixels from the top.
    pub fn layers(&self, camera: &Camera, readings: &Readings, fonts: &Fonts) -> (Vec<Layer>, f64) {
        let typesetter = Typesetter::new(fonts.faces());
        let mut board = Board { safe: *self.page.safe(), taken: Vec::new(), layers: Vec::new() };
        let bottom = self.page.safe().far().y;

        if let Some(profile) = &self.profile {
            board.add(profile.area, || profile.layers(readings));
        }
        let beside = self
            .profile
            .as_ref()
            .map_or(self.page.safe().far().x, |profile| profile.area.corner.x - self.page.px(40.0));
        let figures = readouts::Readouts {
            figures: self.figures,
            units: self.units,
            utc_offset: self.utc_offset,
            width: beside - self.page.safe().corner.x,
        };
        if let Some((area, layer)) = figures.layer(readings, &self.page, &typesetter) {
            board.add(area, || vec![layer]);
        }
        let free = board.taken.iter().map(|area| area.corner.y).fold(bottom, f64::min);

        if let Some(inset) = &self.inset {
            board.add(inset.area, || inset.layers(readings));
        }
        if self.figures.north {
            let right = board.taken.iter().find(|area| area.corner.y < self.page.safe().corner.y + 1.0);
            let right = right.map_or(self.page.safe().far().x, |area| area.corner.x - self.page.px(28.0));
            let compass = compass::Compass::new(right, heading(camera), &self.page);
            board.add(compass.area, || compass.layers(&self.page, &typesetter));
        }
        if let (true, Footprint::Width(metres)) = (self.figures.scale, camera.footprint()) {
            let bar = ScaleBar { metres_per_pixel: metres, units: self.units, longest: self.page.px(400.0) };
            let corner = DVec2::new(self.page.safe().corner.x, free - self.page.px(70.0));
            let drawn = bar.layer(corner, &self.page, &typesetter);
            drawn.into_iter().for_each(|(area, layer)| board.add(area, || vec![layer]));
        }
        (board.layers, free)
    }
}

/// Layers that do not lie over each other.
struct Board {
    safe: Area,
    taken: Vec<Area>,
    layers: Vec<Layer>,
}

impl Board {
    /// Adds layers of an area, unless something lies there or the picture is too small for it.
    fn add(&mut self, area: Area, layers: impl FnOnce() -> Vec<Layer>) {
        let is_free = self.safe.holds(&area) && !self.taken.iter().any(|taken| taken.meets(&area));
        if is_free {
            self.taken.push(area);
            self.layers.extend(layers());
        }
    }
}

/// Returns the direction that is up in a picture, or ahead of it, degrees clockwise from grid north.
fn heading(camera: &Camera) -> f64 {
    // The right of a view is level in any pitch, straight down as well.
    let view: DMat3 = camera.world_from_view();
    let right = view.x_axis;
    (-right.y).atan2(right.x).to_degrees()
}
