//! Bodies merged into what was rendered of the ground, by range.

use std::cell::Cell;

use glam::Vec3;

use super::Renderer;
use super::shadows::{LatestShade, Shadows};
use crate::frame::stage::Pixels;
use crate::frame::{Atmosphere, Frame, Picture, Veil};
use crate::objects::{BodyLight, BodyView, Hit, PixelGround, SQUARE, Square};
use crate::sensor::VisualSensor;
use crate::simd::Isa;
use crate::space::Ray;
use crate::subimage::{Farm, Stage};
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Inverse ranges of neighbouring pixels that differ by more than this share belong to two surfaces.
const EDGE: f32 = 0.06;

/// Distance between hits of a body that have the same air before them: a part of their range, at which transmittance differs by 0.2 % at most whatever the haze,
/// and an angle, radians.
const ALONG: f64 = 0.005;
const ASIDE: f32 = 0.004;

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// Squares of the screen that bodies are in, by [`SQUARE`] rows of it.
pub struct Bodies<'v> {
    pub(super) rows: Vec<Vec<Square<'v>>>,
}

/// Shading of bodies: light, haze and shadows.
struct BodyShading<'s, 'r, 'a, S> {
    isa: Isa,
    sensor: VisualSensor,
    atmosphere: Atmosphere,
    /// Factor on light, by channel.
    tint: Vec3,
    has_fog: bool,
    /// `None`: all of the sun reaches them.
    shadows: Option<&'s Shadows<'r, 'a, S>>,
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

/// The ground that a frame shows.
pub(super) struct Shown<'r> {
    pub range: &'r [f32],
    pub width: usize,
}

impl<'v> Bodies<'v> {
    /// Finds what `view` holds on its screen.
    pub fn find(view: &'v BodyView<'_>, height: u32, farm: &Farm) -> Result<Self> {
        if view.is_empty() {
            return Ok(Self { rows: Vec::new() });
        }
        let mut rows: Vec<_> = (0..(height as usize).div_ceil(SQUARE)).map(|_| Vec::new()).collect();
        farm.each(Stage::Image, rows.iter_mut().collect(), |index, squares| {
            squares.extend(view.squares(index * SQUARE));
            Ok(())
        })?;
        Ok(Self { rows })
    }

    /// Whether the screen shows none.
    pub fn is_empty(&self) -> bool {
        self.rows.iter().all(Vec::is_empty)
    }

    /// Puts them into a picture, of which `range` tells how far the ground is, and then, if that `counts`, what is seen.
    pub fn into_picture<S: PageSource>(
        self,
        renderer: &Renderer<'_, S>,
        shadows: Option<&Shadows<'_, '_, S>>,
        picture: &mut Picture,
        (range, counts): (&mut [f32], bool),
        farm: &Farm,
    ) -> Result<()> {
        let (look, width) = (BodyShading::of(renderer, shadows), picture.width as usize);
        // Pixels look at their neighbours' ground, which other tasks may have covered.
        let mut covered = if counts { range.to_vec() } else { Vec::new() };
        let ranges = covered.chunks_mut(width * SQUARE).chain(std::iter::repeat_with(Default::default));
        let shown = Shown { range, width };
        let tasks: Vec<_> = self.rows.into_iter().zip(rows_of(picture).zip(ranges)).collect();

        farm.each(Stage::Image, tasks, |index, (squares, (mut pixels, range))| {
            each_pixel(&look, &shown, &squares, |row, column, seen| {
                let pixel = (row - index * SQUARE) * width + column;
                if let Some(range) = range.get_mut(pixel).filter(|_| seen.share >= 0.5) {
                    *range = seen.hit.range as f32;
                }
                let light = over(seen, || pixels.light(pixel));
                pixels.put(pixel, light);
            });
            Ok(())
        })?;

        if !covered.is_empty() {
            range.copy_from_slice(&covered);
        }

        Ok(())
    }

    /// Puts them into a frame.
    pub fn into_frame<S: PageSource>(
        self,
        renderer: &Renderer<'_, S>,
        shadows: Option<&Shadows<'_, '_, S>>,
        frame: &mut Frame,
        farm: &Farm,
    ) -> Result<()> {
        let (look, width) = (BodyShading::of(renderer, shadows), frame.camera.width as usize);
        // Pixels look at their neighbours' ground, which other tasks may have covered.
        let ground = frame.range.clone();
        if let Some(mut matte) = frame.aov.matte.take() {
            self.complete_matte(renderer.isa, frame, &mut matte, farm)?;
            frame.aov.matte = Some(matte);
        }

        let shown = Shown { range: &ground, width };
        let rows = width * SQUARE;
        let planes = frame
            .colour
            .chunks_mut(rows)
            .zip(frame.range.chunks_mut(rows))
            .zip(frame.normal.chunks_mut(rows))
            .zip(frame.level.chunks_mut(rows).zip(frame.id.chunks_mut(rows)));
        let tasks: Vec<_> = self.rows.into_iter().zip(planes).collect();

        farm.each(Stage::Image, tasks, |index, (squares, (((colour, range), normal), (level, id)))| {
            each_pixel(&look, &shown, &squares, |row, column, seen| {
                let pixel = (row - index * SQUARE) * width + column;
                colour[pixel] = over(seen, || Vec3::from_array(colour[pixel])).to_array();
                if seen.share >= 0.5 {
                    range[pixel] = seen.hit.range as f32;
                    normal[pixel] = seen.hit.normal.to_array();
                    level[pixel] = Frame::BODY_LEVEL;
                    id[pixel] = Frame::body_id(seen.hit.id);
                }
            });
            Ok(())
        })
    }
}

/// A picture's pixels, by [`SQUARE`] rows.
pub(super) fn rows_of(picture: &mut Picture) -> impl Iterator<Item = Pixels<'_>> {
    let width = picture.width as usize;
    picture.rgb.chunks_mut(RGB * width * SQUARE).map(Pixels::Srgb8)
}

/// Light of a pixel that bodies cover a share of.
fn over(seen: &BodyLight, ground: impl FnOnce() -> Vec3) -> Vec3 {
    if seen.share < 1.0 { ground() * (1.0 - seen.share) + seen.colour } else { seen.colour }
}

/// Tells `put` row and column of every pixel with a body in it, and what is seen of that.
fn each_pixel<'s, S: PageSource>(
    look: &BodyShading<'s, '_, '_, S>,
    shown: &Shown<'_>,
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

impl<'s, 'r, 'a, S: PageSource> BodyShading<'s, 'r, 'a, S> {
    fn of(renderer: &Renderer<'_, S>, shadows: Option<&'s Shadows<'r, 'a, S>>) -> Self {
        let options = &renderer.options;
        Self {
            isa: renderer.isa,
            sensor: VisualSensor::new(options.sun),
            atmosphere: options.atmosphere(renderer.source.header()),
            tint: options.brightness().tint(),
            has_fog: options.weather.fog.is_some(),
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
        // Fog may end anywhere.
        if !self.has_fog {
            latest_air.set(Some(before));
        }
        self.tint * before.veil.over(radiance)
    }
}

impl Shown<'_> {
    /// The ground in a pixel: its slope is that to neighbours that show the same surface.
    pub fn ground(&self, column: usize, row: usize) -> PixelGround {
        let (at, width, height) = (row * self.width + column, self.width, self.range.len() / self.width);
        let own = 1.0 / self.range[at];
        // No neighbour is of no surface.
        let inverse = |exists: bool, at: usize| if exists { 1.0 / self.range[at] } else { f32::NAN };
        let slope = |before: f32, after: f32| {
            let same = |step: f32| if step.abs() <= EDGE * own { (step, 1.0) } else { (0.0, 0.0_f32) };
            let (before, after) = (same(own - before), same(after - own));
            (before.0 + after.0) / (before.1 + after.1).max(1.0)
        };
        let across = slope(inverse(column > 0, at.wrapping_sub(1)), inverse(column + 1 < width, at + 1));
        let along = slope(inverse(row > 0, at.wrapping_sub(width)), inverse(row + 1 < height, at + width));
        PixelGround { inverse: own, slope: [across, along] }
    }
}
