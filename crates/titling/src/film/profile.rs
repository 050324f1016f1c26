//! The profile: ground and altitude along the path, and what flies.

use glam::DVec2;

use super::measure;
use super::page::{AHEAD, Area, PANEL, PASSED, Page, WHITE};
use crate::layer::{Ink, Layer, disc, polygon, polyline, rectangle};
use crate::readings::Readings;
use crate::text::{TextStyle, Typesetter};
use crate::track_point::{TrackPoint, passed};
use hedgehop::scene::Units;

/// Width and height of the chart, units, and the share of the page that it may take.
const SIZE: DVec2 = DVec2::new(460.0, 130.0);
const MOST: DVec2 = DVec2::new(0.5, 0.3);

/// Least range of heights, metres: a level flight is no zigzag.
const LEAST_RANGE: f64 = 40.0;

/// Shortest way that is drawn by its length, metres; shorter ones are drawn by time.
const LEAST_WAY: f64 = 10.0;

/// A chart in the lower right corner.
#[derive(Debug)]
pub struct Profile {
    /// Place on the picture.
    pub area: Area,
    track: Vec<TrackPoint>,
    /// Places of the track's points, pixels.
    line: Vec<DVec2>,
    /// Panel, ground, the whole line and the texts.
    still: Layer,
    /// Width of a line, pixels.
    width: f64,
}

impl Profile {
    /// Draws what does not change; `None`: the path is a single point.
    pub fn new(track: &[TrackPoint], units: Units, page: &Page, typesetter: &Typesetter<'_>) -> Option<Self> {
        let size = (SIZE * page.px(1.0)).min(MOST * page.safe().size);
        let area = Area { corner: page.safe().far() - size, size };
        let along = along(track)?;
        let heights = || track.iter().flat_map(|point| [Some(point.place.z), point.ground]).flatten();
        let (low, high) =
            (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let range = (high - low).max(LEAST_RANGE);

        // The letters have the upper part of the panel, and the chart the rest.
        let letters = TextStyle::line(page.letters(18.0));
        let chart_top = area.corner.y + 1.25 * f64::from(letters.size);
        let chart_height = area.far().y - chart_top;
        let place = |share: f64, height: f64| {
            let up = (height - low) / range;
            DVec2::new(area.corner.x + share * size.x, area.far().y - (0.06 + 0.88 * up) * chart_height)
        };
        let line: Vec<DVec2> =
            track.iter().zip(&along).map(|(point, share)| place(*share, point.place.z)).collect();

        let width = page.px(3.0).max(1.2);
        let mut still = Layer::new(area.corner, size)?;
        still.fill(&rectangle(area.corner, size)?, PANEL);
        let ground = |(point, share): (&TrackPoint, &f64)| place(*share, point.ground.unwrap_or(low));
        let base = [area.far(), DVec2::new(area.corner.x, area.far().y)];
        if let Some(ground) = polygon(track.iter().zip(&along).map(ground).chain(base)) {
            still.fill(&ground, Ink::solid([190, 180, 160]).faint(0.75));
        }
        if let Some(path) = polyline(line.iter().copied()) {
            still.stroke(&path, width, AHEAD);
        }

        let tops = track.iter().map(|point| point.place.z).fold(f64::NEG_INFINITY, f64::max);
        let way: f64 = track.windows(2).map(|pair| (pair[1].place - pair[0].place).truncate().length()).sum();
        let top = typesetter.set(&format!("up to {}", measure::height(tops, units)), &letters);
        let length = typesetter.set(&measure::distance(way, units), &letters);
        let inside = page.px(8.0);
        still.text(&top, area.corner + DVec2::new(inside, 0.0), WHITE);
        let right = area.far().x - inside - f64::from(length.extent[0]);
        // On a narrow chart the length makes way.
        if right > area.corner.x + 2.0 * inside + f64::from(top.extent[0]) {
            still.text(&length, DVec2::new(right, area.corner.y), WHITE);
        }
        Some(Self { area, track: track.to_vec(), line, still, width })
    }

    /// Returns the layers of a picture: the chart, and over it the way flown and what flies.
    pub fn layers(&self, readings: &Readings) -> Vec<Layer> {
        let mut layers = vec![self.still.clone()];
        let (before, share) = passed(&self.track, readings.seconds);
        let Some(last) = before.len().checked_sub(1) else { return layers };
        let own = match self.line.get(last + 1) {
            Some(next) => self.line[last].lerp(*next, share),
            None => self.line[last],
        };

        let Some(mut layer) = Layer::new(self.area.corner, self.area.size) else { return layers };
        if let Some(path) = polyline(self.line[..=last].iter().copied().chain([own])) {
            layer.stroke(&path, self.width, PASSED);
        }
        for (radius, ink) in [(2.4, Ink::solid([0; 3]).faint(0.6)), (1.8, WHITE)] {
            let dot = disc(own, radius * self.width);
            dot.iter().for_each(|dot| layer.fill(dot, ink));
        }
        layers.push(layer);
        layers
    }
}

/// Returns how far along the path its points lie, 0…1: by the way over ground, or by time where there is next to none.
fn along(track: &[TrackPoint]) -> Option<Vec<f64>> {
    let mut way = vec![0.0];
    for pair in track.windows(2) {
        way.push(way[way.len() - 1] + (pair[1].place - pair[0].place).truncate().length());
    }
    let (first, last) = (track.first()?, track.last()?);
    if way[way.len() - 1] < LEAST_WAY {
        way = track.iter().map(|point| point.seconds - first.seconds).collect();
    }
    let whole = way[way.len() - 1];
    (whole > 0.0 && last.seconds > first.seconds).then(|| way.iter().map(|part| part / whole).collect())
}
