//! What a frame says of each pixel's surface besides its light: normal, level, id.

use crate::error::Result;
use crate::frame::Frame;
use crate::raymarch::{Contact, Marcher, SolidHit, SurfaceFilter};
use crate::subimage::Stage;
use crate::voxel::PageSource;

use super::{Renderer, level_bands};
use crate::subimage::Farm;

/// Fills normal, level and id of the pixels that have a range.
pub fn describe<S: PageSource>(renderer: &Renderer<'_, S>, frame: &mut Frame, farm: &Farm) -> Result<()> {
    let camera = frame.camera.clone();
    let (width, rows) = (camera.width as usize, farm.task_size().rows.max(1) as usize);
    let source = renderer.source;
    let bands = level_bands(source.header(), &camera, &renderer.options);
    let tasks: Vec<_> = frame
        .normal
        .chunks_mut(width * rows)
        .zip(frame.level.chunks_mut(width * rows))
        .zip(frame.id.chunks_mut(width * rows))
        .zip(frame.range.chunks(width * rows))
        .collect();
    farm.each(Stage::Image, tasks, |task, (((normal, level), id), range)| {
        let mut marcher =
            Marcher::new(source, bands.clone(), renderer.options.surface).curved(renderer.options.curvature);
        let mut filter = SurfaceFilter::new(source, camera.footprint());
        let mut hits = Vec::new();
        for (pixel, &range) in range.iter().enumerate() {
            let (column, row) = (pixel % width, task * rows + pixel / width);
            let Some(ray) = camera.ray(column as f64 + 0.5, row as f64 + 0.5) else { continue };
            if !range.is_finite() {
                continue;
            }
            let ray = marcher.ray(ray.origin, ray.direction);
            let range = f64::from(range);
            marcher.solids(&ray, None, &mut hits)?;
            if let Some(hit) = half_hidden(&hits).filter(|hit| (hit.range - range).abs() <= SAME * range) {
                let sample = filter.sample_solid(&ray, hit)?;
                normal[pixel] = sample.normal.to_array();
                level[pixel] = 0;
                id[pixel] = Frame::pixel_id(sample.attributes);
                continue;
            }
            let seen = bands.level_at(range * ray.ground_cosine);
            let mut sample = filter.sample(
                &ray,
                &Contact {
                    range,
                    level: seen,
                    wanted: seen,
                    face: None,
                    bare: bands.is_bare_at(range * ray.ground_cosine),
                },
            )?;
            sample.attributes.flags |= filter.stand_in(&ray, range, seen)?;
            normal[pixel] = sample.normal.to_array();
            level[pixel] = seen;
            id[pixel] = Frame::pixel_id(sample.attributes);
        }
        Ok(())
    })
}

/// How far ranges of one thing may be apart, by planes and ray by ray.
const SAME: f64 = 0.02;

/// Of what a ray meets, nearest first, that behind which less than half of the light is left.
fn half_hidden(hits: &[SolidHit]) -> Option<&SolidHit> {
    let mut left = 1.0;
    hits.iter().find(|hit| {
        left *= 1.0 - hit.opacity;
        left <= 0.5
    })
}
