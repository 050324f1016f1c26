//! Plumes of smoke and dust.

use glam::{DVec2, Vec3};

use super::canvas::Canvas;
use super::overlays::Pass;
use super::renderer::Renderer;
use crate::objects::{Lens, SQUARE};
use crate::space::{Camera, Screen};
use crate::subimage::{Farm, Stage};
use crate::weather::{Puff, SeenPuff};
use hedgehop_base::error::Result;

/// Share of what is behind puffs below which nothing of it is seen.
const OPAQUE: f32 = 1.0e-3;

/// Puffs of plumes, before what is seen.
pub(super) struct PlumePass<'r, 'a> {
    pub renderer: &'r Renderer<'a>,
    pub camera: &'r Camera,
    pub puffs: &'r [Puff],
}

impl Pass for PlumePass<'_, '_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        let Self { renderer, camera, puffs } = self;
        // Parallel rays have no eye from which anything could be nearer.
        if puffs.is_empty() || matches!(camera.screen(), Screen::Orthographic { .. }) {
            return Ok(());
        }

        let options = &renderer.options;
        let lens = Lens::new(camera);
        let mut seen: Vec<_> =
            puffs.iter().filter_map(|puff| SeenPuff::new(*puff, &lens, options.curvature)).collect();

        // Front to back, whatever order they come in.
        seen.sort_by_cached_key(SeenPuff::rank);
        let (atmosphere, tint) = (options.atmosphere(renderer.source.header()), options.brightness().tint());
        let light = |puff: &SeenPuff| {
            let direction = puff.direction().as_vec3();
            tint * atmosphere.haze(puff.albedo(), camera.pose.eye.z, direction, puff.range() as f32)
        };
        let lit: Vec<_> = seen.iter().map(|puff| (puff, light(puff))).collect();
        let width = camera.width as usize;

        let (pixels, range) = canvas.light_and_range(SQUARE);
        farm.each(Stage::Image, pixels, |index, mut pixels| {
            let first = index * SQUARE;
            let rows = first..(first + SQUARE).min(camera.height as usize);
            for column in (0..width).step_by(SQUARE) {
                let columns = column..(column + SQUARE).min(width);
                let among: Vec<_> = lit.iter().filter(|(puff, _)| puff.is_in(&columns, &rows)).collect();
                if among.is_empty() {
                    continue;
                }

                for row in rows.clone() {
                    for column in columns.clone() {
                        let middle = DVec2::new(column as f64, row as f64) + 0.5;
                        let Some(ray) = lens.ray_at(middle) else { continue };
                        let end = f64::from(range[row * width + column]);
                        let (mut through, mut light) = (1.0, Vec3::ZERO);

                        for (puff, own) in &among {
                            let depth = puff.depth(ray.direction, end);
                            if depth > 0.0 {
                                let left = (-depth).exp();
                                light += *own * (through * (1.0 - left));
                                through *= left;
                                if through < OPAQUE {
                                    break;
                                }
                            }
                        }

                        if through < 1.0 {
                            let pixel = (row - first) * width + column;
                            pixels.put(pixel, light + pixels.light(pixel) * through);
                        }
                    }
                }
            }

            Ok(())
        })
    }
}
