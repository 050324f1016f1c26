//! Poses that a seed decides, over the ground of a database.

use glam::{DVec2, DVec3};
use hedgehop::raymarch::ground_height;
use hedgehop::space::{Attitude, Pose};
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};

use crate::random::Random;

/// Most attempts to find ground under an eye.
const ATTEMPTS: u32 = 1000;

/// Low flight: 20 to 150 units above the ground, in small areas no more than a fortieth to an eighth of their lesser side
/// (uniform in the logarithm), inside the middle four fifths of the area, looking within 60° of its centre; pitch −10…0°,
/// roll −20…20° in every other pose and 0 in the rest; field of view 60°.
pub fn low_flight(source: &dyn PageSource, count: usize, seed: u64) -> Result<Vec<Pose>> {
    let mut random = Random::new(seed);
    let grid = source.header().grid;
    let centre = 0.5 * (grid.origin + grid.far_corner());
    let lesser_side = f64::from(grid.nx.min(grid.ny));
    let (low, high) = (f64::min(20.0, lesser_side / 40.0), f64::min(150.0, lesser_side / 8.0));
    (0..count)
        .map(|index| {
            let (place, ground) = somewhere(source, &mut random, 0.1)?;
            let height = random.log_within(low, high) * grid.spacing;
            let inward = (centre - place).to_angle();
            let yaw = 90.0 - inward.to_degrees() + random.within(-60.0, 60.0);
            let pitch = random.within(-10.0, 0.0);
            let roll = random.within(-20.0, 20.0);
            let roll = if index % 2 == 1 { roll } else { 0.0 };
            let attitude = Attitude { yaw: yaw.rem_euclid(360.0), pitch, roll };
            Ok(Pose { eye: place.extend(ground + height), attitude, hfov: 60.0 })
        })
        .collect()
}

/// Any flight: 0.5 to 2000 units above the ground (uniform in the logarithm), anywhere in the area, any yaw, pitch
/// −90…30°, any roll, field of view 20…110°; every fifth pose has pitch and roll 0.
pub fn any_flight(source: &dyn PageSource, count: usize, seed: u64) -> Result<Vec<Pose>> {
    let mut random = Random::new(seed);
    let spacing = source.header().grid.spacing;
    (0..count)
        .map(|index| {
            let (place, ground) = somewhere(source, &mut random, 0.0)?;
            let height = random.log_within(0.5, 2000.0) * spacing;
            let yaw = random.within(0.0, 360.0);
            let pitch = random.within(-90.0, 30.0);
            let roll = random.within(-180.0, 180.0);
            let (pitch, roll) = if index % 5 == 4 { (0.0, 0.0) } else { (pitch, roll) };
            let hfov = random.within(20.0, 110.0);
            let eye: DVec3 = place.extend(ground + height);
            Ok(Pose { eye, attitude: Attitude { yaw, pitch, roll }, hfov })
        })
        .collect()
}

/// A place with ground, at least `margin` (a share of each side) from the area's edges, and the ground's height in metres.
fn somewhere(source: &dyn PageSource, random: &mut Random, margin: f64) -> Result<(DVec2, f64)> {
    let grid = source.header().grid;
    for _ in 0..ATTEMPTS {
        let share = DVec2::new(random.within(margin, 1.0 - margin), random.within(margin, 1.0 - margin));
        let place = grid.origin + share * (grid.far_corner() - grid.origin);
        if let Some(ground) = ground_height(source, place)? {
            return Ok((place, ground));
        }
    }
    Err(Error::Configuration(format!(
        "no ground was found at {ATTEMPTS} places of the database; choose one with a surface"
    )))
}
