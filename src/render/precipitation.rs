//! Rain and snow close to the eye, put before all else.

use super::Renderer;
use crate::frame::PrecipitationPass;
use crate::frame::stage::Pixels;
use crate::objects::SQUARE;
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Puts what falls into pixels, which come by [`SQUARE`] rows, before what is `range` metres away there.
pub fn add<S: PageSource>(
    renderer: &Renderer<'_, S>,
    camera: &Camera,
    pixels: Vec<Pixels<'_>>,
    range: &[f32],
    farm: &Farm,
) -> Result<()> {
    let options = &renderer.options;
    let Some(falls) = &options.weather.precipitation else { return Ok(()) };
    // Drops and flakes gather the light of all of the sky: that of the horizon.
    let air = options.atmosphere(renderer.source.header());
    let forward = camera.world_from_view().z_axis.with_z(0.0).normalize_or(glam::DVec3::Y);
    let light = options.brightness().tint() * air.sky(camera.pose.eye.z, forward.as_vec3());
    let Some(fall) = PrecipitationPass::new(falls, camera, renderer.velocity, renderer.seconds, light) else {
        return Ok(());
    };
    let rows = camera.width as usize * SQUARE;
    let tasks: Vec<_> = pixels.into_iter().zip(range.chunks(rows)).collect();
    farm.each(Stage::Image, tasks, |index, (pixels, range)| {
        fall.add(index * SQUARE, pixels, range);
        Ok(())
    })
}
