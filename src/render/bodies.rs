//! Bodies merged into what was rendered of the ground, by range.

use std::cell::Cell;

use glam::Vec3;

use super::canvas::{BodyRows, Canvas, SurfaceRows};
use super::matte;
use super::overlays::Pass;
use super::renderer::Renderer;
use super::shadows::{LatestShade, Shadows};
use super::shown_ground::ShownGround;
use crate::frame::Frame;
use crate::objects::{BodyLight, BodyView, Hit, SQUARE, Square};
use crate::sensor::VisualSensor;
use crate::simd::Isa;
use crate::space::Ray;
use crate::subimage::{Farm, Stage};
use crate::weather::{Atmosphere, Veil};
use hedgehop_base::error::Result;

/// Distance between hits of a body that have the same air before them: a part of their range, at which transmittance differs by 0.2 % at most whatever the haze,
/// and an angle, radians.
const ALONG: f64 = 0.005;
const ASIDE: f32 = 0.004;

/// Bodies on the screen, merged into the ground by range.
pub struct BodyPass<'r, 'v, 'a> {
    shading: BodyShading<'r, 'r, 'a>,
    shadows: Option<&'r Shadows<'r, 'a>>,
    /// Squares of the screen that bodies are in, by [`SQUARE`] rows of it.
    rows: Vec<Vec<Square<'v>>>,
}

/// Shading of bodies: light, haze and shadows.
struct BodyShading<'s, 'r, 'a> {
    isa: Isa,
    sensor: VisualSensor,
    atmosphere: Atmosphere,
    /// Factor on light, by channel.
    tint: Vec3,
    /// `None`: all of the sun reaches them.
    shadows: Option<&'s Shadows<'r, 'a>>,
}

/// The air before a hit of a body.
#[derive(Clone, Copy)]
struct Before {
    id: u32,
    /// Metres.
    range: f64,
    /// Direction of the ray, of unit length.
    direction: Vec3,
    veil: Veil,
}

impl Before {
    /// Whether it is that before another hit, too, or nearly so.
    fn is_of(&self, hit: &Hit, direction: Vec3) -> bool {
        self.id == hit.id
            && (self.range - hit.range).abs() <= ALONG * self.range
            && (self.direction - direction).length_squared() <= ASIDE * ASIDE
    }
}

impl<'r, 'v, 'a> BodyPass<'r, 'v, 'a> {
    /// Finds what `view` holds on its screen, which has so many rows.
    pub fn find(
        renderer: &'r Renderer<'a>,
        shadows: Option<&'r Shadows<'r, 'a>>,
        view: &'v BodyView<'_>,
        height: u32,
        farm: &Farm,
    ) -> Result<Self> {
        let shading = BodyShading::of(renderer, shadows);
        if view.is_empty() {
            return Ok(Self { shading, shadows, rows: Vec::new() });
        }
        let mut rows: Vec<_> = (0..(height as usize).div_ceil(SQUARE)).map(|_| Vec::new()).collect();
        farm.each(Stage::Image, rows.iter_mut().collect(), |index, squares| {
            squares.extend(view.squares(index * SQUARE));
            Ok(())
        })?;
        Ok(Self { shading, shadows, rows })
    }

    /// Whether the screen shows none.
    pub fn is_empty(&self) -> bool {
        self.rows.iter().all(Vec::is_empty)
    }
}

impl Pass for BodyPass<'_, '_, '_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        if !self.is_empty() {
            if let Some((frame, mut matte)) = canvas.take_matte() {
                matte::add_bodies(&self.rows, self.shading.isa, frame, &mut matte, farm)?;
                frame.aov.matte = Some(matte);
            }

            let width = canvas.width();
            let (rows, ground) = canvas.body_rows();
            let shown = ShownGround { range: &ground, width };
            farm.each(Stage::Image, self.rows.iter().zip(rows).collect(), |index, (squares, mut rows)| {
                each_pixel(&self.shading, &shown, squares, |row, column, seen| {
                    rows.put((row - index * SQUARE) * width + column, seen);
                });
                Ok(())
            })?;
        }
        self.shadows.map_or(Ok(()), Shadows::check)
    }
}

impl BodyRows<'_> {
    /// Has a pixel show a body.
    fn put(&mut self, pixel: usize, seen: &BodyLight) {
        let light = over(seen, || self.pixels.light(pixel));
        self.pixels.put(pixel, light);
        if seen.share >= 0.5 {
            if let Some(range) = self.range.get_mut(pixel) {
                *range = seen.hit.range as f32;
            }
            if let Some(SurfaceRows { normal, level, id }) = &mut self.surface {
                normal[pixel] = seen.hit.normal.to_array();
                level[pixel] = Frame::BODY_LEVEL;
                id[pixel] = Frame::body_id(seen.hit.id);
            }
        }
    }
}

/// Light of a pixel that bodies cover a share of.
fn over(seen: &BodyLight, ground: impl FnOnce() -> Vec3) -> Vec3 {
    if seen.share < 1.0 { ground() * (1.0 - seen.share) + seen.colour } else { seen.colour }
}

/// Tells `put` row and column of every pixel with a body in it, and what is seen of that.
fn each_pixel<'s>(
    look: &BodyShading<'s, '_, '_>,
    shown: &ShownGround<'_>,
    squares: &[Square<'_>],
    mut put: impl FnMut(usize, usize, &BodyLight),
) {
    let latest = LatestShade::default();
    for square in squares {
        let air = Cell::new(None);
        square.look(
            look.isa,
            |column, row| shown.ground(column, row),
            |hit, ray| look.shade(hit, ray, &latest, &air),
            &mut put,
        );
    }
}

impl<'s, 'r, 'a> BodyShading<'s, 'r, 'a> {
    fn of(renderer: &Renderer<'_>, shadows: Option<&'s Shadows<'r, 'a>>) -> Self {
        let options = &renderer.options;
        Self {
            isa: renderer.isa,
            sensor: VisualSensor::new(options.sun),
            atmosphere: options.atmosphere(renderer.source.header()),
            tint: options.brightness().tint(),
            shadows,
        }
    }

    /// Radiance that reaches the eye from a hit.
    fn shade(
        &self,
        hit: &Hit,
        ray: &Ray,
        latest: &LatestShade<'s>,
        latest_air: &Cell<Option<Before>>,
    ) -> Vec3 {
        let sun = self.shadows.map_or(1.0, |shadows| shadows.on_body(hit, ray, latest));
        let radiance = hit.albedo * self.sensor.daylight().on_body(hit.normal, sun);
        let direction = ray.direction.as_vec3();
        let before = latest_air.get().filter(|before| before.is_of(hit, direction)).unwrap_or_else(|| {
            let veil = self.atmosphere.veil(ray.origin.z, direction, hit.range as f32);
            Before { id: hit.id, range: hit.range, direction, veil }
        });
        if !self.atmosphere.has_edge() {
            latest_air.set(Some(before));
        }
        self.tint * before.veil.over(radiance)
    }
}
