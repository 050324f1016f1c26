//! What a frame says of each pixel's surface besides its light: normal, level, id; and its range where something stands.
//!
//! Planes and rows lie up to half a pixel beside a pixel's own ray. Ground seldom ends in between; of what stands there is an outline in every second pixel
//! of a wood. So there the own ray is followed.

use glam::Vec3;

use super::{Renderer, level_bands, reference};
use crate::error::Result;
use crate::frame::Frame;
use crate::raymarch::{Contact, GridRay, LevelBands, Marcher, SolidHit, SurfaceFilter};
use crate::subimage::{Farm, Stage};
use crate::voxel::{Attributes, PageSource};

/// Fills normal, level and id of the pixels that see something, and sets right the ranges of those about which something `stands` (`[height][width]`; empty: about
/// none), or before which something does.
pub fn describe<S: PageSource>(
    renderer: &Renderer<'_, S>,
    frame: &mut Frame,
    stands: &[bool],
    farm: &Farm,
) -> Result<()> {
    let camera = frame.camera.clone();
    let (width, rows) = (camera.width as usize, farm.task_size().rows.max(1) as usize);
    let source = renderer.source;
    let tasks: Vec<_> = frame
        .normal
        .chunks_mut(width * rows)
        .zip(frame.level.chunks_mut(width * rows))
        .zip(frame.id.chunks_mut(width * rows))
        .zip(frame.range.chunks_mut(width * rows))
        .zip(stands.chunks(width * rows).chain(std::iter::repeat(Default::default())))
        .collect();
    farm.each(Stage::Image, tasks, |task, ((((normal, level), id), range), stands)| {
        let mut sight = Sight {
            marcher: reference::marcher(source, &camera, &renderer.options),
            filter: SurfaceFilter::new(source, camera.footprint()),
            bands: level_bands(source.header(), &camera, &renderer.options),
            hits: Vec::new(),
        };
        for (pixel, range) in range.iter_mut().enumerate() {
            let (column, row) = (pixel % width, task * rows + pixel / width);
            let Some(ray) = camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            let ray = sight.marcher.ray(ray.origin, ray.direction);
            let Some(seen) = sight.look(&ray, *range, stands.get(pixel) == Some(&true))? else {
                *range = f32::INFINITY;
                continue;
            };
            (*range, normal[pixel], level[pixel]) = (seen.range, seen.normal.to_array(), seen.level);
            id[pixel] = Frame::pixel_id(seen.attributes);
        }
        Ok(())
    })
}

/// Looks along rays of pixels.
struct Sight<'a, S: PageSource> {
    marcher: Marcher<'a, S>,
    filter: SurfaceFilter<'a, S>,
    bands: LevelBands,
    hits: Vec<SolidHit>,
}

/// What a pixel sees.
struct Seen {
    range: f32,
    normal: Vec3,
    level: u8,
    attributes: Attributes,
}

impl<S: PageSource> Sight<'_, S> {
    /// What a ray sees, of which planes found a range (metres; infinite: the sky), and whether something stands about it; `None`: the sky.
    fn look(&mut self, ray: &GridRay, range: f32, stands: bool) -> Result<Option<Seen>> {
        let found = range.is_finite().then(|| self.contact(ray, f64::from(range)));
        let is_clear = !stands && self.marcher.half_hidden(ray, found.as_ref(), &mut self.hits)?.is_none();
        if is_clear {
            let seen = found.map(|contact| self.ground(ray, &contact)).transpose()?;
            return Ok(seen.map(|seen| Seen { range, ..seen }));
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
            return Ok(Some(Seen { range, normal: sample.normal, level: 0, attributes }));
        }
        contact.map(|contact| self.ground(ray, &contact)).transpose()
    }

    /// Where a ray meets the surface that is to be seen at a range.
    fn contact(&self, ray: &GridRay, range: f64) -> Contact {
        let distance = range * ray.ground_cosine;
        let (level, bare) = (self.bands.level_at(distance), self.bands.is_bare_at(distance));
        Contact { range, level, wanted: level, face: None, bare }
    }

    fn ground(&mut self, ray: &GridRay, contact: &Contact) -> Result<Seen> {
        let (normal, mut attributes) = self.filter.surface(ray, contact)?;
        attributes.flags |= self.filter.stand_in(ray, contact.range, contact.wanted)?;
        Ok(Seen { range: contact.range as f32, normal, level: contact.level, attributes })
    }
}
