//! What sun the ground leaves to bodies.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use glam::DVec3;

use super::Renderer;
use crate::error::{Error, Result};
use crate::objects::Body;
use crate::raymarch::{LevelBands, Marcher, ground_height};
use crate::space::Footprint;
use crate::sunlight::{SUN_SEMIDIAMETER, ShadeSampler, Sun};
use crate::voxel::PageSource;

/// Radii above the ground up to which a body sees the sun as the ground below it does.
const GROUNDED: f64 = 2.0;

/// Where rays of a flying body start: radii above its middle.
const STARTS: [f64; 3] = [-0.7, 0.0, 0.7];

/// Side of a lattice's cells at least, in voxels of the finest level and in pixels, and parts of a body's radius at most: its shadow's edge is as soft as a cell.
const VOXELS: f64 = 2.0;
const PIXELS: f64 = 8.0;
const PARTS: f64 = 64.0;

/// Height above the ground, in its finest voxels, from which a lattice's rays start at least.
const RAISED: f64 = 0.5;

/// Bodies, and what of the sun they see.
pub struct Sunlit<'r, 'a, S> {
    renderer: &'r Renderer<'a, S>,
    bodies: HashMap<u32, Place>,
    failed: Mutex<Option<Error>>,
}

/// Where a body is, and what it sees of the sun once that was asked.
pub struct Place {
    middle: DVec3,
    radius: f64,
    /// Of all of it.
    share: OnceLock<f32>,
    /// Of its places, if one value is not enough for all of it.
    lattice: Option<Lattice>,
}

/// What places of the world see of the sun.
struct Lattice {
    /// Side of its cells, metres.
    side: f64,
    corners: Mutex<HashMap<[i64; 3], f32>>,
}

/// The corners of a lattice's cell, eastward first, then northward and upward.
#[derive(Clone, Copy)]
pub struct Corners {
    first: [i64; 3],
    shares: [f32; 8],
}

impl Corners {
    /// Share between them, so far from the first one in parts of the side.
    fn at(&self, part: [f32; 3]) -> f32 {
        let [x, y, z] = part;
        let mix = |from: f32, to: f32, part: f32| from + part * (to - from);
        let along = |corner: usize| mix(self.shares[corner], self.shares[corner + 1], x);
        let across = |corner: usize| mix(along(corner), along(corner + 2), y);
        mix(across(0), across(4), z)
    }
}

impl<'r, 'a, S: PageSource> Sunlit<'r, 'a, S> {
    /// Nothing is known yet of `bodies`, which an eye sees whose pixels are as wide as `footprint` says.
    pub fn new(renderer: &'r Renderer<'a, S>, bodies: &[Body], eye: DVec3, footprint: Footprint) -> Self {
        let spacing = renderer.source.header().grid.spacing;
        let place = |body: &Body| {
            let (middle, radius) = body.sphere();
            let pixel = footprint.at(((middle - eye).length() - radius).max(0.0));
            let wanted = (VOXELS * spacing).max(PIXELS * pixel).max(radius / PARTS);
            // In steps, so that an edge does not creep as the eye comes near.
            let side = spacing * (wanted / spacing).log2().ceil().exp2();
            let lattice = (radius > side).then(|| Lattice { side, corners: Mutex::default() });
            (body.id, Place { middle, radius, share: OnceLock::new(), lattice })
        };
        Self { renderer, bodies: bodies.iter().map(place).collect(), failed: Mutex::default() }
    }

    /// The body of that number.
    pub fn place(&self, id: u32) -> Option<&Place> {
        self.bodies.get(&id)
    }

    /// Share of the sun, 0…1, that the ground leaves to a point of a body; `latest` is the cell that was looked at last, of the same body.
    pub fn share(&self, place: &Place, point: DVec3, latest: &mut Option<Corners>) -> f32 {
        let Some(lattice) = &place.lattice else {
            return *place.share.get_or_init(|| self.sound(self.find(place)));
        };
        let cell = point / lattice.side;
        let first = cell.floor().to_array().map(|corner| corner as i64);
        let corners = match latest {
            Some(corners) if corners.first == first => *corners,
            _ => {
                let corner = |number: usize| {
                    let [x, y, z] = first;
                    let at =
                        [x + (number & 1) as i64, y + (number >> 1 & 1) as i64, z + (number >> 2) as i64];
                    self.corner(lattice, at)
                };
                Corners { first, shares: std::array::from_fn(corner) }
            }
        };
        *latest = Some(corners);
        corners.at((cell - cell.floor()).as_vec3().to_array())
    }

    /// Share of the sun at a corner of a lattice.
    fn corner(&self, lattice: &Lattice, at: [i64; 3]) -> f32 {
        let lock = || lattice.corners.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().get(&at).copied();
        known.unwrap_or_else(|| {
            let point = DVec3::from_array(at.map(|corner| corner as f64)) * lattice.side;
            let share = self.sound(self.free(point, lattice.side));
            lock().insert(at, share);
            share
        })
    }

    /// What went wrong so far.
    pub fn check(self) -> Result<()> {
        self.failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    /// A share that was found; all of the sun where that failed, which is kept.
    fn sound(&self, share: Result<f32>) -> f32 {
        share.unwrap_or_else(|error| {
            self.failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            1.0
        })
    }

    /// Share of the sun at a place; of one below the ground what the ground sees.
    fn free(&self, mut place: DVec3, width: f64) -> Result<f32> {
        let source = self.renderer.source;
        if let Some(ground) = ground_height(source, place.truncate())? {
            place.z = place.z.max(ground + RAISED * source.header().grid.spacing);
        }
        self.rays(&[place], width)
    }

    /// Share of the sun's disc that is free of ground `width` metres wide, in the mean of some places.
    fn rays(&self, places: &[DVec3], width: f64) -> Result<f32> {
        let Renderer { source, options, .. } = self.renderer;
        let header = source.header();
        let bands = LevelBands::uniform(&header.grid, header.level_count, width, 1.0);
        let mut marcher = Marcher::new(*source, bands, options.surface);
        let (mut free, mut all) = (0.0, 0.0);
        for rim in [-1.0, 0.0, 1.0] {
            let elevation = (options.sun.elevation + rim * SUN_SEMIDIAMETER).clamp(0.0, 90.0);
            let direction = Sun { elevation, ..options.sun }.direction().as_dvec3().normalize();
            for place in places {
                let is_free = marcher.first_contact(&marcher.ray(*place, direction), 0.0)?.is_none();
                (free, all) = (free + f32::from(u8::from(is_free)), all + 1.0);
            }
        }
        Ok(free / all)
    }

    fn find(&self, place: &Place) -> Result<f32> {
        let Renderer { source, shared, .. } = self.renderer;
        let header = source.header();
        let ground = ground_height(*source, place.middle.truncate())?;
        if let (Some(ground), Some(shades)) = (ground, shared.radiance.shades())
            && place.middle.z - ground < GROUNDED * place.radius
        {
            let units = (place.middle.truncate() - header.grid.origin) / header.grid.spacing;
            return ShadeSampler::new(shades).share(*source, 0, units);
        }
        self.rays(&STARTS.map(|start| place.middle + DVec3::Z * (start * place.radius)), place.radius)
    }
}
