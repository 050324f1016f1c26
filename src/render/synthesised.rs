//! Share of each pixel's light that is made up below the finest voxel.

use super::reference;
use super::renderer::Renderer;
use crate::detail::FADING;
use crate::frame::Frame;
use crate::raymarch::SurfaceFilter;
use crate::subimage::{Farm, Stage};
use hedgehop_base::error::Result;

/// Multiple of a pixel's range within which its own ray meets the ground.
const REACH: f64 = 1.25;

/// Finds by how much detail changes the light of each pixel of a frame, relative to what it is without; 0 where the ground is not seen near enough, or not at all.
///
/// Each pixel's own ray is followed, as the reference marcher does.
pub(super) fn of_frame(renderer: &Renderer<'_>, frame: &Frame, farm: &Farm) -> Result<Vec<f32>> {
    let (camera, source) = (&frame.camera, renderer.source);
    let width = camera.width as usize;
    let mut changes = vec![0.0; frame.range.len()];
    let Some(synthesis) = renderer.synthesis()? else { return Ok(changes) };
    let displacement = renderer.displacement(camera)?;
    let widest = FADING[1].sqrt() * source.header().grid.spacing;

    let rows = changes.chunks_mut(width).collect();
    farm.each(Stage::Image, rows, |row, changes: &mut [f32]| {
        let mut marcher =
            reference::marcher(source, camera, &renderer.options).displaced(displacement.as_ref());
        let mut filter = SurfaceFilter::new(source, camera.footprint()).detailed(Some(synthesis));
        let mut hits = Vec::new();
        for (column, change) in changes.iter_mut().enumerate() {
            let pixel = row * width + column;
            let range = f64::from(frame.range[pixel]);
            if frame.level[pixel] != 0 || !range.is_finite() || filter.pixel_at(range) > widest {
                continue;
            }
            let Some(ray) = camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            let ray = marcher.ray(ray.origin, ray.direction);
            let Some(contact) = marcher.contact_before(&ray, range * REACH)? else { continue };
            if marcher.half_hidden(&ray, contact.range, &mut hits)?.is_none() {
                *change = filter.below_finest(&ray, &contact)? - 1.0;
            }
        }
        Ok(())
    })?;

    source.intact()?;
    Ok(changes)
}
