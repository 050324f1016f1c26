//! Detail as engines ask for it: tiles under one sun, and a factor on amplitudes.
//!
//! ```text
//! pattern, seed ──► micro-relief ──► lit by the sun ──► tile over the ground
//!                                └─► lit from above ──► tile over walls
//! ```
//!
//! Relief takes a share φ of the light, tan φ = relief · cot(elevation): nothing under a sun at the zenith, nearly all under one on the horizon. How strong detail is stays
//! the imagery's to say. A sun below the horizon lights no relief. Patterns matched from fine imagery lie over the ground alone; walls have the generator's.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, Mutex, PoisonError};

use hedgehop_texture::{Cells, Generator, MatchedPattern, MicroRelief};

use super::ground_tile::{GroundTile, RoughPattern};
use crate::voxel::{DetailRecord, Header};
use hedgehop_base::error::Result;

/// Steps of the sun's direction and of relief's share, degrees: a sun that moves changes tiles seldom, and by less than is seen.
const SUN_STEP: f64 = 1.0;

/// Tiles that a process keeps.
const KEPT: usize = 8;

/// Detail below the finest voxel under one sun.
#[derive(Debug, Clone)]
pub struct Synthesis {
    /// Tiles of the pattern.
    pub tiles: Arc<DetailTiles>,
    /// Factor on the amplitudes that imagery asks for, > 0.
    pub strength: f64,
}

/// Place of the sun in the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunAngles {
    /// Clockwise from grid north, degrees.
    pub azimuth: f64,
    /// Above the horizon, degrees.
    pub elevation: f64,
}

/// Tiles over the ground and over walls.
#[derive(Debug)]
pub struct DetailTiles {
    /// Tile over the ground, eastward and northward, lit by the sun.
    pub ground: GroundTile,
    /// Tile over walls, along them and upward, lit from above.
    pub walls: GroundTile,
}

/// Tiles' own key: all that they depend on.
#[derive(Debug, Clone, PartialEq)]
struct TileKey {
    pattern: Generator,
    seed: u64,
    matched: Option<MatchedPattern>,
    ground: ReliefLight,
    walls: ReliefLight,
}

/// Light on micro-relief.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ReliefLight {
    /// Direction that it comes from, clockwise from the tile's north, degrees.
    azimuth: f64,
    /// Relief's share φ, degrees, 0…90.
    share: f64,
}

/// Tiles that were asked for last, the latest one at the end.
static TILES: Mutex<Vec<(TileKey, Arc<DetailTiles>)>> = Mutex::new(Vec::new());

impl Synthesis {
    /// Finds the detail of a database under a sun, `factor` times as strong; `None`: there is none.
    ///
    /// # Errors
    /// The pattern that the database asks for has nothing below the voxel.
    pub fn of(header: &Header, factor: f64, sun: SunAngles) -> Result<Option<Self>> {
        let usual = DetailRecord::default();
        let record = header.metadata.detail.as_ref().unwrap_or(&usual);
        let strength = factor * record.strength;
        if strength <= 0.0 {
            return Ok(None);
        }
        Ok(Some(Self { tiles: DetailTiles::of(record, sun)?, strength }))
    }
}

impl DetailTiles {
    /// Finds the tiles of a record under a sun: made, or kept from before.
    ///
    /// # Errors
    /// The pattern has nothing below the voxel, or a parameter that is out of its range.
    pub fn of(record: &DetailRecord, sun: SunAngles) -> Result<Arc<Self>> {
        let key = TileKey {
            pattern: record.pattern,
            seed: record.seed,
            matched: record.matched.clone(),
            ground: ReliefLight::of_sun(record.relief, sun),
            walls: ReliefLight::of_sun(record.relief, SunAngles { azimuth: 0.0, elevation: 45.0 }),
        };

        // Whoever asks meanwhile waits for these.
        let mut tiles = TILES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = tiles.iter().position(|(kept, _)| *kept == key) {
            let found = tiles.remove(at);
            let wanted = found.1.clone();
            tiles.push(found);
            return Ok(wanted);
        }
        let made = Arc::new(Self::new(&key)?);
        if tiles.len() >= KEPT {
            tiles.remove(0);
        }
        tiles.push((key, made.clone()));
        Ok(made)
    }

    fn new(key: &TileKey) -> Result<Self> {
        let made = MicroRelief::new(key.pattern.cells(key.seed)?);
        let walls = GroundTile::new(&key.walls.on(&made))?;
        let Some(matched) = &key.matched else {
            return Ok(Self { ground: GroundTile::new(&key.ground.on(&made))?, walls });
        };

        let lit = |cells: Cells| match key.ground.share > 0.0 {
            true => key.ground.on(&MicroRelief::new(cells)),
            false => cells,
        };
        let classes = matched.classes().iter();
        let patterns: Vec<RoughPattern> =
            classes.map(|class| RoughPattern { least: class.least, light: lit(class.cells()) }).collect();
        Ok(Self { ground: GroundTile::by_roughness(&patterns)?, walls })
    }
}

impl ReliefLight {
    /// Lights relief.
    fn on(self, relief: &MicroRelief) -> Cells {
        let toward = self.azimuth.to_radians();
        relief.lit([toward.sin(), toward.cos()], self.share.to_radians())
    }

    fn of_sun(relief: f64, sun: SunAngles) -> Self {
        let elevation = sun.elevation.to_radians();
        let share = match sun.elevation > 0.0 {
            true => (relief * elevation.cos()).atan2(elevation.sin()).clamp(0.0, FRAC_PI_2),
            false => 0.0,
        };
        let stepped = |degrees: f64| (degrees / SUN_STEP).round() * SUN_STEP;
        let share = stepped(share.to_degrees());
        let azimuth = if share > 0.0 { stepped(sun.azimuth.rem_euclid(360.0)) % 360.0 } else { 0.0 };
        Self { azimuth, share }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn sun(azimuth: f64, elevation: f64) -> SunAngles {
        SunAngles { azimuth, elevation }
    }

    #[test]
    fn low_suns_show_more_relief() {
        let share = |elevation| ReliefLight::of_sun(0.5, sun(90.0, elevation)).share;
        assert_eq!((share(90.0), share(45.0), share(0.001), share(-5.0)), (0.0, 27.0, 90.0, 0.0));
        assert!(share(10.0) > share(20.0) && share(20.0) > share(60.0));
        assert_eq!(ReliefLight::of_sun(0.0, sun(90.0, 10.0)), ReliefLight { azimuth: 0.0, share: 0.0 });
        assert_eq!(ReliefLight::of_sun(0.5, sun(359.9, 10.0)).azimuth, 0.0);
    }

    #[test]
    fn tiles_are_made_once_and_turn_with_the_sun() {
        let record = DetailRecord::default();
        let [one, same, other] = [sun(120.0, 30.0), sun(120.2, 30.1), sun(300.0, 30.0)]
            .map(|sun| DetailTiles::of(&record, sun).unwrap());
        assert!(Arc::ptr_eq(&one, &same));

        // Under the opposite sun what the pattern has stays, and what relief has is the other way: their difference is relief alone.
        let (mut alike, mut squares) = (0.0, 0.0);
        for (x, y) in (0..255).flat_map(|x| (0..255).map(move |y| (x, y))) {
            let place = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / 15.0;
            let [a, b] = [&one, &other].map(|tiles| tiles.ground.mean(0.0, place, DVec2::splat(1e-6)));
            alike += a * b;
            squares += a * a;
        }
        // tan φ = 0.5 cot 30°: cos 2φ = 1/7; skewness and steps of the tile change that by little.
        let correlation = alike / squares;
        assert!((correlation - 1.0 / 7.0).abs() < 0.05, "{correlation}");
    }
}
