//! Sunlight that terrain leaves to bodies.

use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};

use glam::DVec3;

use super::renderer::Renderer;
use crate::objects::Body;
use crate::raymarch::{LevelBands, Marcher, ground_height};
use crate::space::Footprint;
use crate::sunlight::{SUN_SEMIDIAMETER, ShadeSampler, Sun};
use hedgehop_base::error::{Error, Result};

/// Radii above the ground up to which a body sees the sun as the ground below it does.
const GROUNDED: f64 = 2.0;

/// Starts of a flying body's rays: radii above its middle.
const STARTS: [f64; 3] = [-0.7, 0.0, 0.7];

/// Side of a lattice's cells at least, in voxels of the finest level and in pixels, and in parts of a body's radius.
const VOXELS: f64 = 2.0;
const PIXELS: f64 = 8.0;
const PARTS: f64 = 32.0;

/// Cells in a body's radius from which on it begins to have a lattice, and from which on that alone counts.
const LARGE: [f64; 2] = [2.0, 4.0];

/// Height above the ground, in its finest voxels, from which rays of a lattice start at least.
const RAISED: f64 = 0.5;

/// Bodies, and what of the sun they see.
pub struct Sunlit<'r, 'a> {
    renderer: &'r Renderer<'a>,
    bodies: HashMap<u32, SunlitBody>,
    failed: Mutex<Option<Error>>,
}

/// Position of a body, and its sunlight once that was asked for.
pub struct SunlitBody {
    middle: DVec3,
    radius: f64,
    /// Share of the whole body in the sun.
    share: OnceLock<f32>,
    /// Shares at places of the body, if one value is not enough for all of it.
    lattice: Option<SunLattice>,
}

/// Sunlight at places of the world, on lattices whose sides are the finest voxel's times powers of two.
struct SunLattice {
    /// Power of the finer of two lattices, of which it is blended.
    fine: i32,
    /// Share of the coarser one, 0…1: as the eye comes near nothing jumps.
    coarse: f32,
    /// Weight against one value for all of the body, 0…1.
    weight: f32,
    /// Sunlight of corners that were asked for, by power and place, in sides.
    corners: Mutex<HashMap<(i32, [i64; 3]), f32>>,
}

impl SunLattice {
    /// Builds the lattice of a body with this radius, whose cells are to be about `side` wide, both in voxels; `None`: it is too small.
    fn new(radius: f64, side: f64) -> Option<Self> {
        let weight = (radius / side - LARGE[0]) / (LARGE[1] - LARGE[0]);
        let power = side.log2();
        (weight > 0.0).then(|| Self {
            fine: power.floor() as i32,
            coarse: power.fract() as f32,
            weight: weight.min(1.0) as f32,
            corners: Mutex::default(),
        })
    }
}

/// Shares at the corners of a lattice's cell: eastward first, then northward and upward.
#[derive(Debug, Clone, Copy)]
struct Corners {
    first: [i64; 3],
    shares: [f32; 8],
}

impl Corners {
    /// Share between them, so far from the first one in parts of the side.
    fn at(&self, [x, y, z]: [f32; 3]) -> f32 {
        let mix = |from: f32, to: f32, part: f32| from + part * (to - from);
        let along = |corner: usize| mix(self.shares[corner], self.shares[corner + 1], x);
        let across = |corner: usize| mix(along(corner), along(corner + 2), y);
        mix(across(0), across(4), z)
    }
}

/// The cells of a body that were looked at last, of the finer and the coarser lattice.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cells([Option<Corners>; 2]);

impl<'r, 'a> Sunlit<'r, 'a> {
    /// Nothing is known yet of `bodies`, which an eye sees whose pixels are as wide as `footprint` says.
    pub fn new(renderer: &'r Renderer<'a>, bodies: &[Body], eye: DVec3, footprint: Footprint) -> Self {
        let spacing = renderer.source.header().grid.spacing;
        let place = |body: &Body| {
            let (middle, radius) = body.sphere();
            let pixel = footprint.at(((middle - eye).length() - radius).max(0.0));
            let side = (VOXELS * spacing).max(PIXELS * pixel).max(radius / PARTS);
            let lattice = SunLattice::new(radius / spacing, side / spacing);
            (body.id, SunlitBody { middle, radius, share: OnceLock::new(), lattice })
        };
        Self { renderer, bodies: bodies.iter().map(place).collect(), failed: Mutex::default() }
    }

    /// The body of that number.
    pub fn place(&self, id: u32) -> Option<&SunlitBody> {
        self.bodies.get(&id)
    }

    /// Share of the sun, 0…1, that the ground leaves to a point of a body; `latest` are the cells of it that were looked at last.
    pub fn share(&self, place: &SunlitBody, point: DVec3, latest: &mut Cells) -> f32 {
        let whole = || *place.share.get_or_init(|| self.sound(self.find(place)));
        let Some(lattice) = &place.lattice else { return whole() };
        let mut within = |power: i32, index: usize| self.within(lattice, power, point, &mut latest.0[index]);
        let mut share = within(lattice.fine, 0);
        if lattice.coarse > 0.0 {
            share += lattice.coarse * (within(lattice.fine + 1, 1) - share);
        }
        if lattice.weight < 1.0 { share + (1.0 - lattice.weight) * (whole() - share) } else { share }
    }

    /// Share of the sun at a point, between the corners of its cell of one lattice.
    fn within(&self, lattice: &SunLattice, power: i32, point: DVec3, latest: &mut Option<Corners>) -> f32 {
        let side = self.renderer.source.header().grid.spacing * f64::from(power).exp2();
        let cell = point / side;
        let first = cell.floor().to_array().map(|corner| corner as i64);

        let corners = latest.filter(|corners| corners.first == first).unwrap_or_else(|| {
            let at = |number: usize| {
                let corner = std::array::from_fn(|axis| first[axis] + (number >> axis & 1) as i64);
                let lock = || lattice.corners.lock().unwrap_or_else(PoisonError::into_inner);
                let known = lock().get(&(power, corner)).copied();
                known.unwrap_or_else(|| {
                    let place = DVec3::from_array(corner.map(|corner| corner as f64)) * side;
                    let share = self.sound(self.free(place, side));
                    lock().insert((power, corner), share);
                    share
                })
            };

            Corners { first, shares: std::array::from_fn(at) }
        });

        *latest = Some(corners);
        corners.at((cell - cell.floor()).as_vec3().to_array())
    }

    /// Returns the first error so far.
    pub fn check(&self) -> Result<()> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }

    /// A share that was found; all of the sun where that failed, which is kept.
    fn sound(&self, share: Result<f32>) -> f32 {
        share.unwrap_or_else(|error| {
            self.failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            1.0
        })
    }

    /// A marcher over ground `width` metres wide.
    fn marcher(&self, width: f64) -> Marcher<'a> {
        let Renderer { source, options, .. } = self.renderer;
        let header = source.header();
        let bands = LevelBands::uniform(&header.grid, header.level_count, width, 1.0);
        Marcher::new(*source, bands, options.surface)
    }

    /// Unit vector to the sun's lower rim (-1), its middle (0), or its upper rim (1).
    fn to_sun(&self, rim: f64) -> DVec3 {
        let sun = self.renderer.options.sun;
        let elevation = (sun.elevation + rim * SUN_SEMIDIAMETER).clamp(0.0, 90.0);
        Sun { elevation, ..sun }.direction().as_dvec3().normalize()
    }

    /// Share of the sun's disc at a place, free of ground `width` metres wide; of one below the ground what that sees.
    fn free(&self, mut place: DVec3, width: f64) -> Result<f32> {
        let source = self.renderer.source;
        let mut marcher = self.marcher(width);
        if let Some(ground) = ground_height(source, place.truncate())? {
            place.z = place.z.max(ground + RAISED * source.header().grid.spacing);
        }
        // Who sees the lower rim sees all, and who does not see the upper one nothing.
        for (rim, free, hidden) in
            [(-1.0, Some(1.0), None), (1.0, None, Some(0.0)), (0.0, Some(0.75), Some(0.25))]
        {
            let is_free = marcher.first_contact(&marcher.ray(place, self.to_sun(rim)), 0.0)?.is_none();
            if let Some(share) = if is_free { free } else { hidden } {
                return Ok(share);
            }
        }
        Ok(0.5)
    }

    fn find(&self, place: &SunlitBody) -> Result<f32> {
        let Renderer { source, lit, .. } = self.renderer;
        let header = source.header();
        let ground = ground_height(*source, place.middle.truncate())?;
        if let (Some(ground), Some(shades)) = (ground, lit.radiance.shades())
            && place.middle.z - ground < GROUNDED * place.radius
        {
            let units = (place.middle.truncate() - header.grid.origin) / header.grid.spacing;
            return ShadeSampler::new(shades).share(*source, 0, units);
        }

        let mut marcher = self.marcher(place.radius);
        let (mut free, mut all) = (0.0, 0.0);
        for rim in [-1.0, 0.0, 1.0] {
            for start in STARTS {
                let ray = marcher.ray(place.middle + DVec3::Z * (start * place.radius), self.to_sun(rim));
                let is_free = marcher.first_contact(&ray, 0.0)?.is_none();
                (free, all) = (free + f32::from(u8::from(is_free)), all + 1.0);
            }
        }

        Ok(free / all)
    }
}
