//! Clouds over ground and bodies.

use super::canvas::Canvas;
use super::overlays::Pass;
use super::renderer::Renderer;
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::weather::clouds::{AirOverGround, CloudDensities, CloudLattice, CloudStage};
use hedgehop_base::error::Result;

/// Clouds of the weather, before what is behind them; ranges stay those of that.
pub(super) struct CloudPass<'r, 'a> {
    pub renderer: &'r Renderer<'a>,
    pub camera: &'r Camera,
}

impl Pass for CloudPass<'_, '_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        let Self { renderer, camera } = self;
        let Some(clouds) = &renderer.options.weather.clouds else { return Ok(()) };
        let (sun, header) = (renderer.options.sun, renderer.source.header());
        let densities = || renderer.shared.clouds.get_or_init(|| CloudDensities::new(clouds));
        let field = renderer.lit.clouds.get_or_init(|| densities().lit(clouds, sun));
        let atmosphere = renderer.options.atmosphere(header);
        let air = AirOverGround { atmosphere: &atmosphere, highest: header.height_range.high };
        let stage = CloudStage::new(renderer.isa, camera, field, clouds, sun, air, renderer.seconds);
        let Some(stage) = stage else {
            return Ok(());
        };
        let stage = stage.tinted(renderer.options.brightness().tint());

        let rows = stage.band_rows();
        let (light, range) = canvas.light_and_range(rows);
        let bands = light.into_iter().zip(range.chunks(rows * camera.width as usize)).collect();
        farm.each_with(Stage::Image, bands, CloudLattice::default, |lattice, index, (light, range)| {
            stage.fill(lattice, index * rows, light, range);
            Ok(())
        })
    }
}
