//! Views of a data set: eyes that follow no path, each with a place and a direction of its own.
//!
//! ```text
//! random: a place in a rectangle, a height above what stands there, a heading and a pitch, each uniform in its range;
//!         drawn again where there is no ground
//! grid:   places in rows from west to east, southern rows first; at each all heights × pitches × headings
//! orbit:  a circle around a place at each height, from north on, clockwise
//! ```
//! A view is a function of its number, the flags and the ground below it: any part of a set is the same as in the whole.

use glam::{DVec2, DVec3};

use super::aim::towards;
use super::site::{CLEARANCE, FilmSite, place};
use super::timeline::Timeline;
use super::track::Track;
use crate::space::{Attitude, Pose};
use hedgehop_base::chance::Random;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::GridNorth;

/// Places that a random view looks for ground at.
const TRIES: u32 = 1000;

/// Share of a spacing by which a grid may be wider than its rectangle, for rounding.
const ROUNDING: f64 = 1.0e-9;

/// Views of a data set.
#[derive(Debug, Clone)]
pub struct Views {
    /// Arrangement of the eyes.
    pub layout: ViewLayout,
    /// South-western and north-eastern corner of the rectangle that random and gridded eyes lie in, metres of the database's system.
    pub area: [DVec2; 2],
    /// Place that all look at and orbits go around; `None`: each view has a heading and a pitch.
    pub target: Option<Track>,
    /// Horizontal field of view, degrees.
    pub hfov: f64,
}

/// Arrangement of the eyes of views.
#[derive(Debug, Clone, PartialEq)]
pub enum ViewLayout {
    /// Places by chance.
    Random(RandomViews),
    /// Places side by side.
    Grid(GridViews),
    /// Circles around the target.
    Orbit(OrbitViews),
}

/// Views by chance: `[low, high]` of each range.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomViews {
    /// Number of views.
    pub count: u64,
    /// Seed of the choice.
    pub seed: u64,
    /// Heights above the ground and what stands there, metres.
    pub heights: [f64; 2],
    /// Pitches, degrees, up positive.
    pub pitches: [f64; 2],
    /// Headings, degrees clockwise from true north.
    pub headings: [f64; 2],
}

/// Views from a grid of places: at each of them all combinations.
#[derive(Debug, Clone, PartialEq)]
pub struct GridViews {
    /// Distance of places, metres, above 0.
    pub spacing: f64,
    /// Heights above the ground and what stands there, metres.
    pub heights: Vec<f64>,
    /// Pitches, degrees, up positive.
    pub pitches: Vec<f64>,
    /// Headings, degrees clockwise from true north.
    pub headings: Vec<f64>,
}

/// Views from circles around a place.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitViews {
    /// Number of views on each circle.
    pub count: u64,
    /// Radius of the circles, metres, above 0.
    pub radius: f64,
    /// Heights of the circles above the place, metres.
    pub heights: Vec<f64>,
}

/// Poses of views, in the order that was asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct ViewPoses {
    pub poses: Vec<MomentPose>,
    /// Height by which views were raised over the ground at most, metres.
    pub raised: f64,
}

/// Pose of a view, and the moment that it shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct MomentPose {
    /// Moment, seconds.
    pub seconds: f64,
    pub pose: Pose,
}

/// An eye before it is held against the ground.
struct Eye {
    place: DVec3,
    heading: f64,
    pitch: f64,
}

/// Views over a database.
struct BoundViews<'a> {
    views: &'a Views,
    site: &'a FilmSite<'a>,
    north: GridNorth,
    target: Option<DVec3>,
}

impl Views {
    /// Returns the number of views.
    pub fn count(&self) -> u64 {
        match &self.layout {
            ViewLayout::Random(random) => random.count,
            ViewLayout::Grid(grid) => {
                let [columns, rows] = grid.places(self.area);
                columns.saturating_mul(rows).saturating_mul(grid.each())
            }
            ViewLayout::Orbit(orbit) => orbit.count * orbit.heights.len() as u64,
        }
    }

    /// Returns the poses of views by their numbers, 1…
    ///
    /// # Errors
    /// [`Error::Configuration`] for a view or a target that has no ground below it.
    pub(super) fn poses(
        &self,
        numbers: impl Iterator<Item = u64>,
        timeline: &Timeline,
        site: &FilmSite<'_>,
    ) -> Result<ViewPoses> {
        let target = self.target.as_ref().map(|target| place(target, site)).transpose()?;
        let bound = BoundViews { views: self, site, north: GridNorth::new(site.crs)?, target };

        let mut all = ViewPoses::default();
        for number in numbers {
            let eye = bound.eye(number)?;
            let raised = bound.lift(eye.place);
            all.raised = all.raised.max(raised.z - eye.place.z);
            let pose = Pose { eye: raised, attitude: bound.attitude(raised, &eye), hfov: self.hfov };
            all.poses.push(MomentPose { seconds: timeline.seconds_at(number), pose });
        }

        Ok(all)
    }
}

impl BoundViews<'_> {
    fn eye(&self, number: u64) -> Result<Eye> {
        match &self.views.layout {
            ViewLayout::Random(random) => self.random(random, number),
            ViewLayout::Grid(grid) => self.gridded(grid, number),
            ViewLayout::Orbit(orbit) => self.on_orbit(orbit, number),
        }
    }

    fn random(&self, random: &RandomViews, number: u64) -> Result<Eye> {
        let [low, high] = self.views.area;
        let mut chance = Random::stream(random.seed, number);
        let mut draw = |[low, high]: [f64; 2]| low + (high - low) * chance.unit();

        for _ in 0..TRIES {
            let at = DVec2::new(draw([low.x, high.x]), draw([low.y, high.y]));
            let [height, heading, pitch] = [random.heights, random.headings, random.pitches].map(&mut draw);
            if let Some(ground) = (self.site.ground)(at) {
                return Ok(Eye { place: at.extend(ground + height), heading, pitch });
            }
        }

        Err(Error::Configuration(format!(
            "--views random found no ground for view {number} at any of {TRIES} places between x {:.1}, y {:.1} and x {:.1}, y {:.1}; \
             give it a --bbox W,S,E,N where there is some",
            low.x, low.y, high.x, high.y
        )))
    }

    fn gridded(&self, grid: &GridViews, number: u64) -> Result<Eye> {
        let [columns, rows] = grid.places(self.views.area);
        let [low, high] = self.views.area;
        let mut rest = number.saturating_sub(1);
        let mut digit = |base: u64| {
            let digit = rest % base;
            rest /= base;
            digit
        };
        let mut choice = |values: &[f64]| values[digit(values.len() as u64) as usize];
        let heading = choice(&grid.headings);
        let pitch = choice(&grid.pitches);
        let height = choice(&grid.heights);
        let cell = DVec2::new(digit(columns) as f64, digit(rows) as f64);

        // The grid lies in the middle of the area: half of what is left over is on either side.
        let span = DVec2::new((columns - 1) as f64, (rows - 1) as f64) * grid.spacing;
        let at = low + 0.5 * (high - low - span) + cell * grid.spacing;
        let ground = (self.site.ground)(at).ok_or_else(|| {
            Error::Configuration(format!(
                "view {number} of --views grid has no ground below it, at x {:.1}, y {:.1}; give a --bbox W,S,E,N where there is some, \
                 or leave that view out with --frames",
                at.x, at.y
            ))
        })?;
        Ok(Eye { place: at.extend(ground + height), heading, pitch })
    }

    fn on_orbit(&self, orbit: &OrbitViews, number: u64) -> Result<Eye> {
        let centre = self.target.ok_or_else(|| {
            Error::Configuration("--views orbit goes around a place; give --look-at X,Y[,Z]".into())
        })?;
        let index = number.saturating_sub(1);
        let azimuth = 360.0 * (index % orbit.count) as f64 / orbit.count as f64;
        let height = orbit.heights[((index / orbit.count) as usize).min(orbit.heights.len() - 1)];
        let (east, north) = azimuth.to_radians().sin_cos();
        let place = centre + DVec3::new(orbit.radius * east, orbit.radius * north, height);
        Ok(Eye { place, heading: azimuth + 180.0, pitch: 0.0 })
    }

    /// Raises an eye over the ground: one on a circle always, others, which stand above theirs, as far as the user says.
    fn lift(&self, eye: DVec3) -> DVec3 {
        let least = match self.views.layout {
            ViewLayout::Orbit(_) => Some(self.site.clearance.unwrap_or(CLEARANCE)),
            _ => self.site.clearance,
        };
        let ground = least.and_then(|least| Some(least + (self.site.ground)(eye.truncate())?));
        eye.with_z(ground.map_or(eye.z, |ground| eye.z.max(ground)))
    }

    fn attitude(&self, place: DVec3, &Eye { heading, pitch, .. }: &Eye) -> Attitude {
        match self.target {
            Some(target) => towards(target - place, heading),
            None => {
                let yaw = (heading + self.north.convergence(place.x, place.y)).rem_euclid(360.0);
                Attitude { yaw, pitch, roll: 0.0 }
            }
        }
    }
}

impl GridViews {
    /// Columns and rows of places in a rectangle, at least 1 each.
    fn places(&self, [low, high]: [DVec2; 2]) -> [u64; 2] {
        // A float converts saturating.
        (high - low)
            .to_array()
            .map(|side| ((side / self.spacing + ROUNDING) as u64).clamp(1, u64::from(u32::MAX)))
    }

    /// Views from each place.
    fn each(&self) -> u64 {
        [&self.heights, &self.pitches, &self.headings].into_iter().map(|values| values.len() as u64).product()
    }
}

#[cfg(test)]
#[path = "views_tests.rs"]
mod tests;
