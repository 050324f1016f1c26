//! What sun the ground leaves to bodies.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use glam::DVec3;

use super::Renderer;
use crate::error::{Error, Result};
use crate::objects::Body;
use crate::raymarch::{LevelBands, Marcher, ground_height};
use crate::sunlight::{SUN_SEMIDIAMETER, ShadeSampler, Sun};
use crate::voxel::PageSource;

/// Radii above the ground up to which a body sees the sun as the ground below it does.
const GROUNDED: f64 = 2.0;

/// Where rays of a flying body start: radii above its middle.
const STARTS: [f64; 3] = [-0.7, 0.0, 0.7];

/// Bodies, and what of the sun they see.
pub struct Sunlit<'r, 'a, S> {
    renderer: &'r Renderer<'a, S>,
    bodies: HashMap<u32, Place>,
    failed: Mutex<Option<Error>>,
}

/// Where a body is, and what it sees of the sun once that was asked.
struct Place {
    middle: DVec3,
    radius: f64,
    share: OnceLock<f32>,
}

impl<'r, 'a, S: PageSource> Sunlit<'r, 'a, S> {
    /// Nothing is known yet of `bodies`.
    pub fn new(renderer: &'r Renderer<'a, S>, bodies: &[Body]) -> Self {
        let place = |body: &Body| {
            let (middle, radius) = body.sphere();
            (body.id, Place { middle, radius, share: OnceLock::new() })
        };
        Self { renderer, bodies: bodies.iter().map(place).collect(), failed: Mutex::default() }
    }

    /// Share of the sun, 0…1, that the ground leaves to a body: near the ground what that sees, else of a few rays.
    pub fn share(&self, id: u32) -> f32 {
        let Some(place) = self.bodies.get(&id) else { return 1.0 };
        *place.share.get_or_init(|| {
            self.find(place).unwrap_or_else(|error| {
                self.failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                1.0
            })
        })
    }

    /// What went wrong so far.
    pub fn check(self) -> Result<()> {
        self.failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    fn find(&self, place: &Place) -> Result<f32> {
        let Renderer { source, options, shared, .. } = self.renderer;
        let header = source.header();
        let ground = ground_height(*source, place.middle.truncate())?;
        if let (Some(ground), Some(shades)) = (ground, shared.radiance.shades())
            && place.middle.z - ground < GROUNDED * place.radius
        {
            let units = (place.middle.truncate() - header.grid.origin) / header.grid.spacing;
            return ShadeSampler::new(shades).share(*source, 0, units);
        }
        let bands = LevelBands::uniform(&header.grid, header.level_count, place.radius, 1.0);
        let mut marcher = Marcher::new(*source, bands, options.surface);
        let (mut free, mut all) = (0.0, 0.0);
        for rim in [-1.0, 0.0, 1.0] {
            let elevation = (options.sun.elevation + rim * SUN_SEMIDIAMETER).clamp(0.0, 90.0);
            let direction = Sun { elevation, ..options.sun }.direction().as_dvec3().normalize();
            for start in STARTS {
                let ray = marcher.ray(place.middle + DVec3::Z * (start * place.radius), direction);
                let is_free = marcher.first_contact(&ray, 0.0)?.is_none();
                (free, all) = (free + f32::from(u8::from(is_free)), all + 1.0);
            }
        }
        Ok(free / all)
    }
}
