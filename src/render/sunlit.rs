//! What sun the ground leaves to bodies.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use glam::DVec3;

use super::Renderer;
use crate::error::{Error, Result};
use crate::objects::Body;
use crate::raymarch::{LevelBands, Marcher, ground_height};
use crate::space::Footprint;
use crate::sunlight::{SUN_SEMIDIAMETER, ShadeSampler, Shades, Sun};
use crate::voxel::PageSource;

/// Radii above the ground up to which a body sees the sun as the ground below it does.
const GROUNDED: f64 = 2.0;

/// Where rays of a flying body start: radii above its middle.
const STARTS: [f64; 3] = [-0.7, 0.0, 0.7];

/// Side of a lattice's cells at least, in voxels of the finest level and in pixels, and in parts of a body's radius.
const VOXELS: f64 = 2.0;
const PIXELS: f64 = 8.0;
const PARTS: f64 = 32.0;

/// Cells in a body's radius from which on it has a lattice.
const LARGE: f64 = 2.0;

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

/// What places about a body see of the sun.
struct Lattice {
    /// Side of its cells, metres.
    side: f64,
    /// The first corner, in sides from the world's origin, and corners along each axis.
    first: [i64; 3],
    dims: [usize; 3],
    corners: Vec<OnceLock<f32>>,
}

impl Lattice {
    fn new(middle: DVec3, radius: f64, side: f64) -> Self {
        let corner = |at: DVec3| (at / side).floor().to_array().map(|corner| corner as i64);
        let [first, last] = [corner(middle - radius), corner(middle + radius)];
        // A body's rim may lie a little beyond its radius.
        let first = first.map(|corner| corner - 1);
        let dims = std::array::from_fn(|axis| (last[axis] - first[axis] + 3) as usize);
        let corners = std::iter::repeat_with(OnceLock::new).take(dims.iter().product()).collect();
        Self { side, first, dims, corners }
    }

    /// Its cell with a point in it, by its first corner, and how far the point lies from that, in sides.
    fn cell(&self, point: DVec3) -> ([usize; 3], [f32; 3]) {
        let (mut cell, mut part) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let at = point.to_array()[axis] / self.side - self.first[axis] as f64;
            let last = self.dims[axis] - 2;
            let index = (at.max(0.0) as usize).min(last);
            (cell[axis], part[axis]) = (index, ((at - index as f64) as f32).clamp(0.0, 1.0));
        }
        (cell, part)
    }
}

/// The corners of a lattice's cell, eastward first, then northward and upward.
#[derive(Clone, Copy)]
pub struct Corners {
    first: [usize; 3],
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
            let lattice = (radius > LARGE * side).then(|| Lattice::new(middle, radius, side));
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
        let (first, part) = lattice.cell(point);
        let corners = latest.filter(|corners| corners.first == first);
        let corners = corners.unwrap_or_else(|| Corners { first, shares: self.corners(lattice, first) });
        *latest = Some(corners);
        corners.at(part)
    }

    /// Shares of the sun at the corners of a cell.
    fn corners(&self, lattice: &Lattice, first: [usize; 3]) -> [f32; 8] {
        let mut look = None;
        std::array::from_fn(|number| {
            let [x, y, z] = std::array::from_fn(|axis| first[axis] + (number >> axis & 1));
            let known = &lattice.corners[x + lattice.dims[0] * (y + lattice.dims[1] * z)];
            *known.get_or_init(|| {
                let place = [x, y, z].map(|corner| corner as f64);
                let origin = lattice.first.map(|corner| corner as f64);
                let place = (DVec3::from_array(origin) + DVec3::from_array(place)) * lattice.side;
                let shades = self.renderer.shared.radiance.shades();
                let look = look.get_or_insert_with(|| {
                    shades.map(|shades| Look::new(self.renderer, shades, lattice.side))
                });
                let found = look.as_mut().map_or(Ok(None), |look| look.share(place)).transpose();
                self.sound(found.unwrap_or_else(|| self.rays(&[place], lattice.side)))
            })
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

/// Looks where light that passes a place comes to the ground: what that sees of the sun the place sees, since nothing is between them.
struct Look<'a, S: PageSource> {
    source: &'a S,
    marcher: Marcher<'a, S>,
    /// What tells the ground's shadows, and the level of posts that is asked.
    shades: ShadeSampler<'a>,
    level: u8,
    from_sun: DVec3,
}

impl<'a, S: PageSource> Look<'a, S> {
    /// At voxels half as wide as `width`, metres.
    fn new(renderer: &Renderer<'a, S>, shades: &'a Shades, width: f64) -> Self {
        let Renderer { source, options, .. } = renderer;
        let header = source.header();
        let bands = LevelBands::uniform(&header.grid, header.level_count, width, VOXELS);
        let level = bands.level_at(0.0);
        let from_sun = -options.sun.direction().as_dvec3().normalize();
        let marcher = Marcher::new(*source, bands, options.surface);
        Self { source, marcher, shades: ShadeSampler::new(shades), level, from_sun }
    }

    /// Share of the sun, 0…1; `None`: the light leaves the area.
    fn share(&mut self, place: DVec3) -> Result<Option<f32>> {
        let ray = self.marcher.ray(place, self.from_sun);
        let Some(contact) = self.marcher.first_contact(&ray, 0.0)? else { return Ok(None) };
        let grid = self.marcher.grid();
        let ground = place + self.from_sun * contact.range;
        let units = (ground.truncate() - grid.origin) / grid.spacing;
        self.shades.share(self.source, self.level, units).map(Some)
    }
}
