//! Channels of each pixel's surface besides its light: normal, level, id; and the range along its own ray.
//!
//! Planes and rows lie up to half a pixel beside a pixel's own ray. Of what stands there is an outline in every second pixel of a wood; the surface ends at ridges,
//! and at buildings and trees that are part of it further away. There the own ray is followed:
//!
//! ```text
//! the planes and rows about the pixel see different things, or something that stands
//! something stands before where the ray meets what planes found
//! the ray passes what planes found by more than a pixel
//! ```
//!
//! Elsewhere the range that planes found is moved along the ray to where that meets the surface, of sixteen pixels at once
//! ([`GroundLanes`]); then each looks for what stands before that. Rays that are followed begin where bounds about the eye let them meet something
//! ([`SectorHorizons`]).

use glam::{DVec3, Vec3};

use super::limits::level_bands;
use super::reference;
use super::renderer::Renderer;
use crate::detail::Displacement;
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

/// Multiple of the range that planes found beside a pixel within which its own ray ends, as a rule.
const NEIGHBOURS_REACH: f64 = 1.25;

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
    let displacement = renderer.displacement(&camera)?;
    let horizons =
        SectorHorizons::new(source.header().grid, bands.clone(), renderer.options.curvature, &camera)
            .map(|horizons| horizons.displaced(displacement.as_ref()));

    let displaced_until =
        displacement.as_ref().map_or(0.0, Displacement::until) * source.header().grid.spacing;

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
        let marcher = reference::marcher(source, &camera, &renderer.options)
            .displaced(displacement.as_ref())
            .beyond(horizons.as_ref());
        let eye = marcher.ray(camera.pose.eye, DVec3::Z).eye;
        let curvature = renderer.options.curvature;
        SurfaceProbe {
            marcher,
            filter: SurfaceFilter::new(source, camera.footprint()),
            ground: GroundLanes::new(source, bands.clone(), curvature, eye, camera.pixel_angle()),
            bands: bands.clone(),
            displaced_until,
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

impl ScreenPart {
    /// Returns the rays of its pixels in the coordinates of a marcher's grid; `None` where the screen has no picture.
    fn rays(&self, camera: &Camera, marcher: &Marcher<'_>) -> [Option<GridRay>; LANES] {
        // On a planar screen all have a direction, which are found together.
        if let Some(direction) = camera.planar_directions(self.column as u32, self.row as u32) {
            return std::array::from_fn(|lane| {
                (lane < self.count).then(|| marcher.ray(camera.pose.eye, direction(lane as u32)))
            });
        }
        std::array::from_fn(|lane| {
            let column = (self.column + lane) as f64 + 0.5;
            let ray = if lane < self.count { camera.ray(column, self.row as f64 + 0.5) } else { None };
            ray.map(|ray| marcher.ray(ray.origin, ray.direction))
        })
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
        let rays = part.rays(camera, &probe.marcher);
        let rays = || rays.iter().enumerate().filter_map(|(lane, ray)| Some((lane, ray.as_ref()?)));

        // Ground where planes found it is met by all of them at once.
        let mut sixteen = RayLanes::default();
        let mut outlines = [false; LANES];
        for (lane, ray) in rays() {
            let range = self.range[first + lane];
            outlines[lane] = self.outlines[first + lane] || probe.is_displaced(ray, range);
            if !outlines[lane] && range > 0.0 && range.is_finite() {
                sixteen.put(lane, ray, range);
            }
        }
        let mut met = MetGround::default();
        probe.ground.meet(isa, &sixteen, &mut met)?;

        // The others are followed, and those before whose ground something stands.
        for (lane, ray) in rays() {
            let pixel = first + lane;
            let is_met = met.lanes >> lane & 1 != 0;
            if is_met && !probe.hides(ray, met.range.0[lane])? {
                self.put(pixel, &SeenSurface::of(&met, lane));
                continue;
            }
            match probe.look(ray, self.range[pixel], is_met || outlines[lane])? {
                Some(seen) => self.put(pixel, &seen),
                None => self.range[pixel] = f32::INFINITY,
            }
        }

        Ok(())
    }

    /// Has a pixel see a surface.
    fn put(&mut self, pixel: usize, seen: &SeenSurface) {
        (self.range[pixel], self.level[pixel]) = (seen.range, seen.level);
        (self.normal[pixel], self.id[pixel]) = (seen.normal.to_array(), Frame::pixel_id(seen.attributes));
    }
}

/// Looks along rays of pixels.
struct SurfaceProbe<'a> {
    marcher: Marcher<'a>,
    filter: SurfaceFilter<'a>,
    ground: GroundLanes<'a>,
    bands: LevelBands,
    /// Ground distance up to which ground is displaced, metres.
    displaced_until: f64,
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

impl SeenSurface {
    /// Takes what a lane met.
    fn of(met: &MetGround, lane: usize) -> Self {
        Self {
            range: met.range.0[lane],
            normal: Vec3::from_array(std::array::from_fn(|axis| met.normal[axis].0[lane])),
            level: met.level[lane] as u8,
            attributes: met.attributes[lane],
        }
    }
}

impl SurfaceProbe<'_> {
    /// Whether displaced ground lies about a range on a ray, metres: it is followed as an outline is.
    fn is_displaced(&self, ray: &GridRay, range: f32) -> bool {
        f64::from(range) * ray.ground_cosine < self.displaced_until
    }

    /// Whether something stands before the ground that a ray met at a range, metres.
    fn hides(&mut self, ray: &GridRay, range: f32) -> Result<bool> {
        let range = f64::from(range);
        Ok(!self.marcher.is_free_of_standing(ray, range)?
            && self.marcher.half_hidden(ray, range, &mut self.hits)?.is_some())
    }

    /// Looks along a ray for which planes found a range (metres; infinite: the sky), which is in doubt at outlines; `None`: the sky.
    fn look(&mut self, ray: &GridRay, range: f32, is_outline: bool) -> Result<Option<SeenSurface>> {
        if !is_outline {
            let found = if range.is_finite() { self.met(ray, f64::from(range))? } else { None };
            let until = found.map_or(f64::INFINITY, |contact| contact.range);
            let is_met = found.is_some() || range.is_infinite();
            if is_met && self.marcher.half_hidden(ray, until, &mut self.hits)?.is_none() {
                return found.map(|contact| self.ground(ray, &contact)).transpose();
            }
        }

        // As a rule a ray ends hardly farther than its neighbours, and nothing is looked for behind that.
        let near = f64::from(range) * NEIGHBOURS_REACH;
        if near.is_finite()
            && let Some(seen) = self.follow(ray, near)?
        {
            return Ok(Some(seen));
        }
        self.follow(ray, f64::INFINITY)
    }

    /// Finds what a ray meets up to a range in metres.
    fn follow(&mut self, ray: &GridRay, until: f64) -> Result<Option<SeenSurface>> {
        let mut hit = self.marcher.half_hidden(ray, until, &mut self.hits)?;
        // As a rule what hides the ground is much nearer, and the ground is looked for no further.
        let ends = self.hits.iter().map(|hit| hit.end).fold(0.0, f64::max);
        let contact = self.marcher.contact_before(ray, if hit.is_some() { ends } else { until })?;
        if let Some(contact) = contact
            && hit.is_some()
        {
            hit = self.marcher.half_hidden(ray, contact.range, &mut self.hits)?;
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
