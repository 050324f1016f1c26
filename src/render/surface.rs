//! Channels of each pixel's surface besides its light: normal, level, id; and its range at outlines.
//!
//! Planes and rows lie up to half a pixel beside a pixel's own ray. Of what stands there is an outline in every second pixel of a wood; the surface ends at ridges,
//! and at buildings and trees that are part of it further away. There the own ray is followed:
//!
//! ```text
//! the planes and rows about the pixel see different things, or something that stands
//! something stands before what planes found
//! the ray passes what planes found by more than a pixel
//! ```

use glam::Vec3;

use super::limits::level_bands;
use super::reference;
use super::renderer::Renderer;
use crate::frame::Frame;
use crate::raymarch::{Contact, GridRay, LevelBands, Marcher, SolidHit, SurfaceFilter};
use crate::subimage::{Farm, Stage};
use crate::voxel::Attributes;
use hedgehop_base::error::Result;

/// Fills normal, level and id of the pixels that see something. Returns ranges, `[height][width]`, that are right where there may be `outlines`; the frame keeps those
/// by which things are merged into it as they are into pictures.
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
            let found = if range.is_finite() { Some(self.contact(ray, f64::from(range))?) } else { None };
            if self.is_met(ray, found.as_ref())? {
                let seen = found.map(|contact| self.ground(ray, &contact)).transpose()?;
                return Ok(seen.map(|seen| SeenSurface { range, ..seen }));
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

    /// Whether a ray meets what was found, the sky or a surface, to a pixel, and nothing that stands before.
    fn is_met(&mut self, ray: &GridRay, found: Option<&Contact>) -> Result<bool> {
        if let Some(contact) = found
            && let Some(above) = self.filter.clearance(ray, contact)?
            && above.abs() > self.filter.pixel_at(contact.range)
        {
            return Ok(false);
        }
        Ok(self.marcher.half_hidden(ray, found, &mut self.hits)?.is_none())
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
