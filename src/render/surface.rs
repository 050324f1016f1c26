//! Channels of each pixel's surface besides its light: normal, level, id; and the range along its own ray.
//!
//! Planes and rows lie up to half a pixel beside a pixel's own ray. Of what stands there is an outline in every second pixel of a wood; the surface ends at ridges,
//! and at buildings and trees that are part of it further away. There the own ray is followed:
//!
//! ```text
//! the planes and rows about the pixel see different things, or something that stands
//! something stands before what planes found
//! the ray passes what planes found by more than a pixel
//! ```
//!
//! Elsewhere the range that planes found is moved along the ray to where that meets the surface, of sixteen pixels at once
//! ([`GroundLanes`]). Rays that are followed begin where bounds about the eye let them meet something ([`SectorHorizons`]).

use glam::{DVec3, Vec3};

use super::limits::level_bands;
use super::reference;
use super::renderer::Renderer;
use crate::frame::Frame;
use crate::raymarch::{
    Contact, GridRay, GroundLanes, LevelBands, MOST_PIXELS_ALONG, MOST_SECANTS, Marcher, MetGround,
    NEAR_ENOUGH, NEAR_ENOUGH_PER_METRE, RayLanes, SectorHorizons, SolidHit, SurfaceFilter,
};
use crate::simd::{Isa, LANES};
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::voxel::Attributes;
use hedgehop_base::error::Result;

/// Fills normal, level and id of the pixels that see something, and returns ranges along the pixels' own rays.
///
/// Both `outlines`, where rays are followed, and ranges (metres, infinite: sky) are `[height][width]`. The frame keeps its own ranges, by which things
/// are merged into it as they are into pictures.
pub fn describe(
    renderer: &Renderer<'_>,
    frame: &mut Frame,
    outlines: &[bool],
    farm: &Farm,
) -> Result<Vec<f32>> {
    let mut ranges = frame.range.clone();
    let camera = frame.camera.clone();
    let (width, rows) = (camera.width as usize, farm.task_size().rows.max(1) as usize);
    let source = renderer.source;
    let bands = level_bands(source.header(), &camera, &renderer.options);
    let horizons =
        SectorHorizons::new(source.header().grid, bands.clone(), renderer.options.curvature, &camera);

    let tasks: Vec<_> = frame
        .normal
        .chunks_mut(width * rows)
        .zip(frame.level.chunks_mut(width * rows))
        .zip(frame.id.chunks_mut(width * rows))
        .zip(ranges.chunks_mut(width * rows))
        .zip(outlines.chunks(width * rows))
        .map(|((((normal, level), id), range), outlines)| SurfaceRows { normal, level, id, range, outlines })
        .collect();

    // Pages and blocks that a worker looked up serve all of its tasks.
    let probe = || {
        let marcher = reference::marcher(source, &camera, &renderer.options).beyond(horizons.as_ref());
        let eye = marcher.ray(camera.pose.eye, DVec3::Z).eye;
        let curvature = renderer.options.curvature;
        SurfaceProbe {
            marcher,
            filter: SurfaceFilter::new(source, camera.footprint()),
            ground: GroundLanes::new(source, bands.clone(), curvature, eye, camera.pixel_angle()),
            bands: bands.clone(),
            hits: Vec::new(),
        }
    };
    farm.each_with(Stage::Image, tasks, probe, |probe, task, mut pixels| {
        // Down the rows, so that what one ray looked up serves the next one.
        for column in (0..width).step_by(LANES) {
            for row in 0..pixels.range.len() / width {
                let part = ScreenPart { column, row: task * rows + row, count: LANES.min(width - column) };
                pixels.describe(renderer.isa, &camera, probe, part, row * width + column)?;
            }
        }
        Ok(())
    })?;

    Ok(ranges)
}

/// Channels of some rows of the screen.
struct SurfaceRows<'f> {
    normal: &'f mut [[f32; 3]],
    level: &'f mut [u8],
    id: &'f mut [u32],
    range: &'f mut [f32],
    outlines: &'f [bool],
}

/// Pixels beside each other, no more than lanes.
#[derive(Clone, Copy)]
struct ScreenPart {
    column: usize,
    row: usize,
    count: usize,
}

/// Rays of the pixels of a part of the screen.
struct PartRays<'c> {
    camera: &'c Camera,
    part: ScreenPart,
    /// Directions on a planar screen, where all have one.
    planar: Option<[DVec3; LANES]>,
}

impl<'c> PartRays<'c> {
    fn new(camera: &'c Camera, part: ScreenPart) -> Self {
        let directions = camera.planar_directions(part.column as u32, part.row as u32);
        let planar = directions.map(|direction| std::array::from_fn(|lane| direction(lane as u32)));
        Self { camera, part, planar }
    }

    /// The ray of a lane in the coordinates of a marcher's grid; `None` where the screen has no picture.
    fn get(&self, lane: usize, marcher: &Marcher<'_>) -> Option<GridRay> {
        if let Some(planar) = &self.planar {
            return Some(marcher.ray(self.camera.pose.eye, planar[lane]));
        }
        let column = (self.part.column + lane) as f64 + 0.5;
        let ray = self.camera.ray(column, self.part.row as f64 + 0.5)?;
        Some(marcher.ray(ray.origin, ray.direction))
    }
}

impl SurfaceRows<'_> {
    /// Describes what the pixels of a part of the screen see, of which the first one has the index `first` here.
    fn describe(
        &mut self,
        isa: Isa,
        camera: &Camera,
        probe: &mut SurfaceProbe<'_>,
        part: ScreenPart,
        first: usize,
    ) -> Result<()> {
        let rays = PartRays::new(camera, part);
        let mut sixteen = RayLanes::default();

        // Plain ground, with nothing before it, is met by all of them at once.
        for lane in 0..part.count {
            let range = self.range[first + lane];
            if self.outlines[first + lane] || range <= 0.0 || range.is_infinite() {
                continue;
            }
            if let Some(ray) = rays.get(lane, &probe.marcher)
                && probe.marcher.is_free_of_standing(&ray, range.into())?
            {
                sixteen.lanes |= 1 << lane;
                sixteen.range.0[lane] = range;
                for axis in 0..3 {
                    sixteen.slope[axis].0[lane] = ray.slope[axis] as f32;
                }
            }
        }
        let mut met = MetGround::default();
        if sixteen.lanes != 0 {
            probe.ground.meet(isa, &sixteen, &mut met)?;
        }

        for (lane, pixel) in (first..first + part.count).enumerate() {
            let seen = if met.lanes >> lane & 1 != 0 {
                Some(SeenSurface {
                    range: met.range.0[lane],
                    normal: Vec3::from_array(std::array::from_fn(|axis| met.normal[axis].0[lane])),
                    level: met.level[lane] as u8,
                    attributes: met.attributes[lane],
                })
            } else {
                let Some(ray) = rays.get(lane, &probe.marcher) else { continue };
                probe.look(&ray, self.range[pixel], self.outlines[pixel])?
            };
            let Some(seen) = seen else {
                self.range[pixel] = f32::INFINITY;
                continue;
            };
            (self.range[pixel], self.level[pixel]) = (seen.range, seen.level);
            (self.normal[pixel], self.id[pixel]) = (seen.normal.to_array(), Frame::pixel_id(seen.attributes));
        }

        Ok(())
    }
}

/// Looks along rays of pixels.
struct SurfaceProbe<'a> {
    marcher: Marcher<'a>,
    filter: SurfaceFilter<'a>,
    ground: GroundLanes<'a>,
    bands: LevelBands,
    hits: Vec<SolidHit>,
}

/// Surface that a pixel sees.
struct SeenSurface {
    /// Metres.
    range: f32,
    /// Unit, world space (x east, y north, z up).
    normal: Vec3,
    /// Index.
    level: u8,
    attributes: Attributes,
}

impl SurfaceProbe<'_> {
    /// Looks along a ray for which planes found a range (metres; infinite: the sky), which is in doubt at outlines; `None`: the sky.
    fn look(&mut self, ray: &GridRay, range: f32, is_outline: bool) -> Result<Option<SeenSurface>> {
        if !is_outline {
            let found = if range.is_finite() { self.met(ray, f64::from(range))? } else { None };
            let is_met = found.is_some() || range.is_infinite();
            if is_met && self.marcher.half_hidden(ray, found.as_ref(), &mut self.hits)?.is_none() {
                return found.map(|contact| self.ground(ray, &contact)).transpose();
            }
        }

        let mut hit = self.marcher.half_hidden(ray, None, &mut self.hits)?;
        // As a rule what hides the ground is much nearer, and the ground is looked for no further.
        let until = self.hits.iter().map(|hit| hit.end).fold(0.0, f64::max);
        let until = if hit.is_some() { until } else { f64::INFINITY };
        let contact = self.marcher.contact_before(ray, until)?;
        if hit.is_some() && contact.is_some() {
            hit = self.marcher.half_hidden(ray, contact.as_ref(), &mut self.hits)?;
        }
        if let Some(hit) = hit {
            let sample = self.filter.sample_solid(ray, &hit)?;
            let (range, attributes) = (hit.range as f32, sample.attributes);
            return Ok(Some(SeenSurface { range, normal: sample.normal, level: 0, attributes }));
        }

        contact.map(|contact| self.ground(ray, &contact)).transpose()
    }

    /// Finds where a ray meets the surface for which planes found a range, metres; `None` where it passes by.
    fn met(&mut self, ray: &GridRay, range: f64) -> Result<Option<Contact>> {
        let mut contact = self.contact(ray, range)?;
        // Beside the area nothing is known of the surface.
        let Some(mut above) = self.filter.clearance(ray, &contact)? else { return Ok(Some(contact)) };
        let pixel = self.filter.pixel_at(contact.range);
        if above.abs() > pixel {
            return Ok(None);
        }

        // Secants, the first one a pixel long: on a facet the way down is nearly straight.
        let mut step = pixel.copysign(above);
        for _ in 0..MOST_SECANTS {
            if above.abs() <= NEAR_ENOUGH + NEAR_ENOUGH_PER_METRE * contact.range {
                // A wall may stand where the way crossed into another band of levels, or left the area.
                let same = self.contact(ray, contact.range)? == contact;
                let stays = contact.range == range || same && self.marcher.is_within(ray, contact.range);
                return Ok(stays.then_some(contact));
            }
            let next = Contact { range: contact.range + step, ..contact };
            let Some(next_above) = self.filter.clearance(ray, &next)? else { break };
            step *= next_above / (above - next_above);
            (contact, above) = (next, next_above);
            if (contact.range + step - range).abs() > MOST_PIXELS_ALONG * pixel {
                break;
            }
        }

        Ok(None)
    }

    /// Finds where a ray meets the surface that is to be seen at a range.
    fn contact(&mut self, ray: &GridRay, range: f64) -> Result<Contact> {
        let distance = range * ray.ground_cosine;
        let (level, bare) = (self.bands.level_at(distance), self.bands.is_bare_at(distance));
        self.filter.standing_in(ray, Contact { range, level, wanted: level, face: None, bare })
    }

    fn ground(&mut self, ray: &GridRay, contact: &Contact) -> Result<SeenSurface> {
        let (normal, mut attributes) = self.filter.surface(ray, contact)?;
        attributes.flags |= self.filter.stand_in(ray, contact)?;
        Ok(SeenSurface { range: contact.range as f32, normal, level: contact.level, attributes })
    }
}
