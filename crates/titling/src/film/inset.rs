//! The inset map: shaded relief around the path, the way flown so far, and what flies.

use glam::DVec2;

use super::page::{AHEAD, Area, PASSED, Page, WHITE};
use super::scale_bar::ScaleBar;
use crate::layer::{Ink, Layer, polygon, polyline, rectangle};
use crate::readings::Readings;
use crate::relief::{Relief, Window};
use crate::text::Typesetter;
use crate::track_point::{TrackPoint, passed};
use hedgehop::scene::Units;

/// Length of the map's longer side, units, and the share of the page that it may take.
const SIDE: f64 = 300.0;
const MOST: f64 = 0.42;

/// A map in the upper right corner.
#[derive(Debug)]
pub struct InsetMap {
    /// Place on the picture, with the scale bar below the map.
    pub area: Area,
    /// Map in the picture.
    map: Area,
    window: Window,
    track: Vec<TrackPoint>,
    /// Relief with the whole path, and the scale bar.
    still: Vec<Layer>,
    /// Width of a line, pixels.
    line: f64,
}

impl InsetMap {
    /// Draws what does not change; with a scale bar below it, if it is to have one of some units.
    pub fn new(
        relief: Relief,
        track: Vec<TrackPoint>,
        scale: Option<Units>,
        page: &Page,
        typesetter: &Typesetter<'_>,
    ) -> Option<Self> {
        let extent = relief.window.extent;
        let side = page.px(SIDE).min(MOST * page.safe().size.min_element());
        let size = (side * extent / extent.max_element()).max(DVec2::ONE);
        let corner = DVec2::new(page.safe().far().x - size.x, page.safe().corner.y);
        let map = Area { corner, size };

        let line = page.px(3.0).max(1.2);
        let mut layer = Layer::new(corner, size)?;
        layer.shade(|place| {
            let share = (place - corner) / size;
            (share.cmpge(DVec2::ZERO) & share.cmple(DVec2::ONE)).all().then(|| relief.between(share))
        });
        let ways = relief.window.parts(track.iter().map(|point| point.place.truncate()));
        for way in ways {
            if let Some(path) = polyline(way.iter().map(|share| corner + *share * size)) {
                layer.stroke(&path, line + page.px(3.0), Ink::solid([0; 3]).faint(0.6));
                layer.stroke(&path, line, AHEAD.faint(0.9));
            }
        }
        if let Some(border) = rectangle(corner, size) {
            layer.stroke(&border, 2.0 * page.px(2.0).max(1.0), WHITE.faint(0.8));
        }

        let (mut still, mut area) = (vec![layer], map);
        let bar = scale.and_then(|units| {
            let bar = ScaleBar { metres_per_pixel: extent.x / size.x, units, longest: 0.55 * size.x };
            bar.layer(corner + DVec2::new(0.0, size.y + page.px(8.0)), page, typesetter)
        });
        if let Some((below, layer)) = bar {
            area.size = (below.far() - corner).max(size);
            still.push(layer);
        }
        Some(Self { area, map, window: relief.window, track, still, line })
    }

    /// Returns the layers of a picture: the map, and over it the way flown and what flies.
    pub fn layers(&self, readings: &Readings) -> Vec<Layer> {
        let mut layers = self.still.clone();
        let Some(mut layer) = Layer::new(self.map.corner, self.map.size) else { return layers };
        let place = |at: DVec2| self.map.corner + self.window.share(at) * self.map.size;
        let own = place(readings.place);
        let (before, _) = passed(&self.track, readings.seconds);
        let flown = before.iter().map(|point| point.place.truncate()).chain([readings.place]);
        for way in self.window.parts(flown) {
            let path = polyline(way.iter().map(|share| self.map.corner + *share * self.map.size));
            path.iter().for_each(|path| layer.stroke(path, self.line, PASSED));
        }

        let (sine, cosine) = readings.heading.to_radians().sin_cos();
        let (ahead, aside) = (DVec2::new(sine, -cosine), DVec2::new(cosine, sine));
        let long = 3.5 * self.line;
        let body = [
            own + 1.3 * long * ahead,
            own - long * (ahead - 0.8 * aside),
            own - 0.4 * long * ahead,
            own - long * (ahead + 0.8 * aside),
        ];
        if let Some(body) = polygon(body) {
            layer.stroke(&body, 0.6 * self.line, Ink::solid([0; 3]).faint(0.6));
            layer.fill(&body, WHITE);
        }
        layers.push(layer);
        layers
    }
}
