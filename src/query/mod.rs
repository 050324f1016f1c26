//! Questions about the ground: what lies along a line, what is seen from where, and what maps of it show.
//!
//! ```text
//! places ──▶ samples along straight lines of the database's system ──▶ ground below each
//! two points ──▶ the ray between them, over a curved Earth ──▶ where it first meets the ground, and how near it comes
//! a box ──▶ the posts of a level in it ──▶ pixels of a map, light on them, contour lines
//! an area ──▶ its finest voxels ──▶ spikes, seams, voids and other faults of terrain
//! ```
//!
//! Line of sight is that of the reference marcher on the finest level (design of the data base analysis system, Hughes 1994): what a picture would show.

mod classes;
mod continuity;
mod contours;
mod hillshade;
mod map;
mod posts;

pub use continuity::{ContinuityLimits, ContinuityReport, Fault, Finding, continuity};
pub use contours::{Contour, contours, fitting_interval};
pub use hillshade::Hillshade;
pub use map::{GroundMap, MapExtent};
pub use posts::{PostReader, Posts, Sheet};

use glam::{DVec2, DVec3};

use crate::earth::Curvature;
use crate::error::{Error, Result};
use crate::raymarch::{GridRay, LevelBands, Marcher, Surface, ground_height};
use crate::voxel::PageSource;

pub use classes::{ClassTally, LevelTally, Tally, attributes_at, tally};

/// Samples of a line at most; a longer one has them farther apart.
const MOST_SAMPLES: f64 = 1.0e6;

/// Samples a voxel along a line of sight.
const PER_VOXEL: f64 = 2.0;

/// A place along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// From the line's beginning, along it, metres ≥ 0.
    pub distance: f64,
    /// Metres of the database's reference system.
    pub place: DVec2,
    /// Height of the ground, metres above the database's datum; `None`: there is none.
    pub ground: Option<f64>,
}

/// The ground along straight lines from place to place (metres of the database's system): at each of them, and between at equal steps of at most `step` metres.
///
/// # Errors
/// [`Error::Configuration`]: a step that is not positive, or places that are not finite; a page that is damaged.
pub fn profile<S: PageSource>(source: &S, places: &[DVec2], step: f64) -> Result<Vec<Sample>> {
    if !(step > 0.0 && places.iter().all(|place| place.is_finite())) {
        return Err(Error::Configuration(format!(
            "a profile needs finite places and a step of more than 0 m, not {step}"
        )));
    }
    let total: f64 = places.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
    let step = step.max(total / MOST_SAMPLES);
    let mut samples = Vec::new();
    let mut add = |distance, place| -> Result<()> {
        samples.push(Sample { distance, place, ground: ground_height(source, place)? });
        Ok(())
    };
    let mut distance = 0.0;
    for ends in places.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        let length = from.distance(to);
        let parts = (length / step).ceil().max(1.0) as u32;
        for part in 0..parts {
            let part = f64::from(part) / f64::from(parts);
            add(distance + part * length, from.lerp(to, part))?;
        }
        distance += length;
    }
    if let Some(last) = places.last() {
        add(distance, *last)?;
    }
    Ok(samples)
}

/// What two points see of each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Horizontal distance between them, metres.
    pub distance: f64,
    /// Where the ground first hides the far one; `None`: they see each other. Its height is that of the ray.
    pub blocked: Option<Sample>,
    /// Where the straight line between them comes nearest to the ground, or lies deepest in it, ends aside, and how far it is above it there, metres; `None`: there is no ground between them.
    pub nearest: Option<(Sample, f64)>,
    /// How much higher the far point would have to be to be seen, metres ≥ 0, as far as samples twice a voxel tell.
    pub missing: f64,
}

/// Whether `from` sees `to` (metres of the database's system, heights above its datum) over an Earth of that curvature, which light bends after.
///
/// # Errors
/// [`Error::Configuration`]: points that are the same, or not finite; a page that is damaged.
pub fn sight<S: PageSource>(source: &S, from: DVec3, to: DVec3, curvature: Curvature) -> Result<Sight> {
    let (near, far) = (from.truncate(), to.truncate());
    let distance = near.distance(far);
    if !(from.is_finite() && to.is_finite()) || from == to {
        return Err(Error::Configuration("a line of sight needs two points that are not the same".into()));
    }
    let grid = source.header().grid;
    // Where the far point appears over a plane.
    let seen = to.with_z(to.z - curvature.drop_at(distance));
    let (way, length) = (seen - from, (seen - from).length());
    let ray = GridRay::new(&grid, from, way / length).over(curvature);
    let mut marcher = Marcher::new(source, LevelBands::finest_only(), Surface::Smooth);
    let contact = marcher.first_contact(&ray, 0.0)?.filter(|contact| contact.range < length);
    let blocked = contact.map(|contact| {
        let (part, range) = (contact.range / length, contact.range);
        Sample { distance: part * distance, place: near.lerp(far, part), ground: Some(ray.height_at(range)) }
    });
    let (mut nearest, mut missing): (Option<(Sample, f64)>, f64) = (None, 0.0);
    let samples = profile(source, &[near, far], grid.spacing / PER_VOXEL)?;
    for sample in samples.iter().filter(|sample| sample.distance > 0.0 && sample.distance < distance) {
        let Some(ground) = sample.ground else { continue };
        let part = sample.distance / distance;
        let line = from.z + part * way.z + curvature.drop_at(sample.distance);
        let above = line - ground;
        missing = missing.max(-above / part);
        if nearest.is_none_or(|(_, least)| above < least) {
            nearest = Some((*sample, above));
        }
    }
    Ok(Sight { distance, blocked, nearest, missing })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::{Grid, MemPages, Metadata, build_in_memory};

    /// Level ground of 100 m with a ridge of `ridge` m more across x = 500 m, and a slope up to it from 400 m on.
    fn area(ridge: f64) -> MemPages {
        let grid = Grid { nx: 500, ny: 50, spacing: 2.0, origin: DVec2::new(1000.0, 2000.0) };
        let rise = |x: f64| ridge * (1.0 - (x - 500.0).abs() / 100.0).max(0.0);
        let heights: Vec<f64> =
            (0..50).flat_map(|_| (0..500).map(move |x| 100.0 + rise(2.0 * f64::from(x) + 1.0))).collect();
        let colours = vec![[90; 3]; heights.len()];
        build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
    }

    fn point(x: f64, z: f64) -> DVec3 {
        DVec3::new(1000.0 + x, 2050.0, z)
    }

    #[test]
    fn profiles_have_their_corners_and_the_ground_below() {
        let area = area(20.0);
        let places = [450.0, 500.0, 470.0].map(|x| point(x, 0.0).truncate());
        let samples = profile(&area, &places, 9.0).unwrap();
        assert_eq!(samples.len(), 6 + 4 + 1);
        assert_eq!(samples[6].place, places[1]);
        assert!((samples.last().unwrap().distance - 80.0).abs() < 1e-9);
        for sample in &samples {
            let wanted = 100.0 + 20.0 * (1.0 - (sample.place.x - 1500.0).abs() / 100.0);
            assert!((sample.ground.unwrap() - wanted).abs() < 0.3, "{sample:?}");
        }
        assert!(profile(&area, &places, 0.0).is_err());
        // Beside the area there is no ground.
        assert_eq!(profile(&area, &[DVec2::ZERO; 2], 1.0).unwrap()[0].ground, None);
    }

    #[test]
    fn a_ridge_hides_what_stands_behind_it_until_that_is_high_enough() {
        let area = area(20.0);
        let see =
            |from: f64, to: f64| sight(&area, point(100.0, from), point(900.0, to), Curvature::FLAT).unwrap();
        let clear = see(130.0, 130.0);
        assert_eq!((clear.blocked, clear.missing, clear.distance), (None, 0.0, 800.0));
        let (nearest, above) = clear.nearest.unwrap();
        assert!((above - 10.2).abs() < 0.1 && (nearest.distance - 400.0).abs() < 2.0, "{above} {nearest:?}");
        // From 110 m both ways the ray meets the ridge half way up.
        let hidden = see(110.0, 110.0);
        let contact = hidden.blocked.unwrap();
        assert!(
            (contact.distance - 350.0).abs() < 1.0 && (contact.ground.unwrap() - 110.0).abs() < 1e-6,
            "{contact:?}"
        );
        // The line has to rise by 10 m in the middle.
        assert!((hidden.missing - 20.0).abs() < 0.4, "{hidden:?}");
        assert!(see(110.0, 110.0 + hidden.missing + 0.5).blocked.is_none());
        assert!(see(110.0, 110.0 + hidden.missing - 1.0).blocked.is_some());
    }

    #[test]
    fn the_earth_bends_between_far_points() {
        let grid = Grid { nx: 400, ny: 4, spacing: 100.0, origin: DVec2::ZERO };
        let (heights, colours) = (vec![0.0; 1600], vec![[90; 3]; 1600]);
        let area = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
        let see = |height: f64, curvature| {
            let [from, to] = [1000.0, 39_000.0].map(|x| DVec3::new(x, 200.0, height));
            sight(&area, from, to, curvature).unwrap()
        };
        // Over 38 km two eyes need 24 m each to see each other over the sea: (19 km)² / 2R′.
        let wanted = 19_000.0_f64.powi(2) * Curvature::standard().inverse_diameter;
        assert!((wanted - 24.3).abs() < 0.1, "{wanted}");
        assert!(see(wanted + 0.5, Curvature::standard()).blocked.is_none());
        assert!(see(wanted - 0.5, Curvature::standard()).blocked.is_some());
        assert!(see(0.5, Curvature::FLAT).blocked.is_none());
    }
}
