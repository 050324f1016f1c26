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
//! Elsewhere the range that planes found is moved along the ray to where that meets the surface.

use glam::Vec3;

use super::limits::level_bands;
use super::reference;
use super::renderer::Renderer;
use crate::frame::Frame;
use crate::raymarch::{Contact, GridRay, LevelBands, Marcher, SolidHit, SurfaceFilter};
use crate::subimage::{Farm, Stage};
use crate::voxel::Attributes;
use hedgehop_base::error::Result;

/// Height above the surface at which a ray has met it, metres: so much, and so much for each metre of range.
const NEAR_ENOUGH: f64 = 2.0e-4;
const NEAR_ENOUGH_PER_METRE: f64 = 2.0e-5;

/// Most secants from where planes met the surface to where a ray does.
const MOST_SECANTS: usize = 5;

/// Farthest way from there to here, pixels wide: rays that graze more are followed.
const MOST_PIXELS_ALONG: f64 = 16.0;

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

    let tasks: Vec<_> = frame
        .normal
        .chunks_mut(width * rows)
        .zip(frame.level.chunks_mut(width * rows))
        .zip(frame.id.chunks_mut(width * rows))
        .zip(ranges.chunks_mut(width * rows))
        .zip(outlines.chunks(width * rows))
        .collect();

    farm.each(Stage::Image, tasks, |task, ((((normal, level), id), range), outlines)| {
        let mut segment = SurfaceProbe {
            marcher: reference::marcher(source, &camera, &renderer.options),
            filter: SurfaceFilter::new(source, camera.footprint()),
            bands: level_bands(source.header(), &camera, &renderer.options),
            hits: Vec::new(),
        };

        for (pixel, range) in range.iter_mut().enumerate() {
            let (column, row) = (pixel % width, task * rows + pixel / width);
            let Some(ray) = camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            let ray = segment.marcher.ray(ray.origin, ray.direction);
            let Some(seen) = segment.look(&ray, *range, outlines[pixel])? else {
                *range = f32::INFINITY;
                continue;
            };
            (*range, normal[pixel], level[pixel]) = (seen.range, seen.normal.to_array(), seen.level);
            id[pixel] = Frame::pixel_id(seen.attributes);
        }

        Ok(())
    })?;

    Ok(ranges)
}

/// Looks along rays of pixels.
struct SurfaceProbe<'a> {
    marcher: Marcher<'a>,
    filter: SurfaceFilter<'a>,
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
