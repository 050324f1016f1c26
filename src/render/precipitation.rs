//! Rain and snow close to the eye, before all else.

use super::canvas::Canvas;
use super::overlays::Pass;
use super::renderer::Renderer;
use crate::objects::SQUARE;
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::weather::PrecipitationStage;
use hedgehop_base::error::Result;

/// Precipitation of the weather, before what is seen.
pub(super) struct PrecipitationPass<'r, 'a> {
    pub renderer: &'r Renderer<'a>,
    pub camera: &'r Camera,
}

impl Pass for PrecipitationPass<'_, '_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        let Self { renderer, camera } = self;
        let options = &renderer.options;
        let Some(falls) = &options.weather.precipitation else { return Ok(()) };

        // Drops and flakes gather the light of all of the sky: that of the horizon.
        let air = options.atmosphere(renderer.source.header());
        let forward = camera.world_from_view().z_axis.with_z(0.0).normalize_or(glam::DVec3::Y);
        let light = options.brightness().tint() * air.sky(camera.pose.eye.z, forward.as_vec3());
        let Some(stage) = PrecipitationStage::new(falls, camera, renderer.velocity, renderer.seconds, light)
        else {
            return Ok(());
        };

        let (light, range) = canvas.light_and_range(SQUARE);
        let tasks = light.into_iter().zip(range.chunks(camera.width as usize * SQUARE)).collect();
        farm.each(Stage::Image, tasks, |index, (pixels, range)| {
            stage.add(index * SQUARE, pixels, range);
            Ok(())
        })
    }
}
