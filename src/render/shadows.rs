//! Shadows of bodies on the ground, put into what was rendered of it, and what sun reaches bodies.

use std::cell::Cell;
use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use super::canvas::Canvas;
use super::overlays::Pass;
use super::renderer::Renderer;
use super::shown_ground::ShownGround;
use super::sunlit::{Cells, Sunlit, SunlitBody};
use crate::objects::{Body, Bounds, Caster, Casters, Hit, Lens, LitPatch, SQUARE};
use crate::pixels::Pixels;
use crate::raymarch::{Contact, GridRay, SurfaceFilter};
use crate::space::{Camera, Footprint, Ray};
use crate::subimage::{Farm, Stage};
use crate::sunlight::Daylight;
use crate::weather::Atmosphere;
use hedgehop_base::error::Result;

/// Pixels each way of the blocks of a square whose bodies are found together.
const BLOCK: usize = 8;

/// Sides of a block from its middle to its corners, and a little more.
const RADIUS: f64 = 0.75;

/// Part of the way from the nearest to the farthest ground of a block by which patches of its pixels may lie before and behind that.
const BESIDE: f64 = 0.125;

/// Pixels each way of the cells of a block; those of a square share the light of the ground if they show the same surface.
const CELL: usize = 4;

/// Ranges that differ by more than this share belong to two surfaces.
const EDGE: f64 = 0.06;

/// The ground of a picture, and its rays.
struct LitGround<'s> {
    shown: ShownGround<'s>,
    lens: Lens<'s>,
}

/// Difference between a ray and one half a pixel beside it, about a part of the screen.
#[derive(Clone, Copy)]
struct Aside {
    /// Offset from the part's middle, pixels.
    offset: DVec2,
    /// Metres; nothing but for parallel rays.
    origin: DVec3,
    direction: DVec3,
}

/// A few pixels, and what holds their ground.
struct ShadowBlock {
    columns: Range<usize>,
    rows: Range<usize>,
    bounds: Bounds,
}

/// Sunlight on the ground of a cell.
#[derive(Clone, Copy)]
struct CellLight {
    /// Range of the pixel that asked, metres.
    range: f64,
    normal: Vec3,
    sun: f32,
    /// Light of the air before it.
    air: Vec3,
}

impl CellLight {
    /// Whether a pixel whose ground is `range` metres away shows the same surface.
    fn is_of(&self, range: f64) -> bool {
        (self.range - range).abs() <= EDGE * range
    }
}

/// Corners of the cells of a square each way.
const CORNERS: usize = SQUARE / CELL + 1;

/// Light of the ground at the corners of a square's cells, as far as it was asked for; `None` of it: there is sky.
struct Lights {
    /// Direction to the sun, of unit length.
    to_sun: Vec3,
    /// First column and row of the square, last ones of the picture.
    first: [usize; 2],
    last: [usize; 2],
    known: [Option<Option<CellLight>>; CORNERS * CORNERS],
    /// Between which ranges pixels show the surface of all four corners of a cell, metres, if no sun reaches any of those; by the upper left one.
    dark: [[f64; 2]; CORNERS * CORNERS],
}

/// No range lies between these.
const NONE: [f64; 2] = [f64::INFINITY, 0.0];

impl Lights {
    /// None is known yet.
    fn of(first: [usize; 2], shown: &ShownGround<'_>, to_sun: Vec3) -> Self {
        let last = [shown.width - 1, shown.range.len() / shown.width - 1];
        Self { to_sun, first, last, known: [None; CORNERS * CORNERS], dark: [NONE; CORNERS * CORNERS] }
    }

    /// Cells' corner above and left of a pixel, by its number among them.
    fn corner(&self, pixel: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|axis| (pixel[axis] - self.first[axis]) / CELL)
    }

    /// Whether no sun reaches the ground around a pixel, so that nothing can hide it, as far as that is known.
    fn are_dark(&self, pixel: [usize; 2], range: f64) -> bool {
        let [column, row] = self.corner(pixel);
        let [nearest, farthest] = self.dark[row * CORNERS + column];
        nearest <= range && range <= farthest
    }

    /// Between the four corners around a pixel, of which `light` tells those that are not known; `None`: not all of them show the surface of the pixel.
    fn between(
        &mut self,
        pixel: [usize; 2],
        range: f64,
        mut light: impl FnMut([usize; 2]) -> Result<Option<CellLight>>,
    ) -> Result<Option<CellLight>> {
        let first = self.corner(pixel);
        let share = [0, 1].map(|axis| ((pixel[axis] - self.first[axis]) % CELL) as f32 / CELL as f32);
        let mut mean = CellLight { range, normal: Vec3::ZERO, sun: 0.0, air: Vec3::ZERO };
        let (mut dark, mut is_lit, mut faces_it) = ([0.0, f64::INFINITY], false, false);

        for [right, down] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let corner = [first[0] + right, first[1] + down];
            let known = &mut self.known[corner[1] * CORNERS + corner[0]];
            let own = match *known {
                Some(own) => own,
                None => {
                    let at = [0, 1].map(|axis| (self.first[axis] + CELL * corner[axis]).min(self.last[axis]));
                    *known.insert(light(at)?)
                }
            };

            let Some(own) = own.filter(|own| own.is_of(range)) else {
                return Ok(None);
            };

            let of = |share: f32, step: usize| if step == 1 { share } else { 1.0 - share };
            let weight = of(share[0], right) * of(share[1], down);
            mean.normal += own.normal * weight;
            mean.sun += own.sun * weight;
            mean.air += own.air * weight;
            dark = [dark[0].max(own.range / (1.0 + EDGE)), dark[1].min(own.range / (1.0 - EDGE))];
            is_lit |= own.sun > 0.0;
            faces_it |= own.normal.dot(self.to_sun) > 0.0;
        }

        if !is_lit || !faces_it {
            self.dark[first[1] * CORNERS + first[0]] = dark;
        }
        mean.normal = mean.normal.normalize_or(Vec3::Z);

        Ok(Some(mean))
    }
}

impl LitGround<'_> {
    /// Rays half a pixel to the right, and down, of one in the middle of a part of the screen; of no size where that has no picture.
    fn asides(&self, part: &ShadowBlock) -> [Aside; 2] {
        let middle = |range: &Range<usize>| 0.5 * (range.start + range.end) as f64;
        let at = DVec2::new(middle(&part.columns), middle(&part.rows));
        let own = self.lens.ray_at(at);
        [DVec2::new(0.5, 0.0), DVec2::new(0.0, 0.5)].map(|offset| {
            match (own, self.lens.ray_at(at + offset)) {
                (Some(own), Some(ray)) => Aside {
                    offset,
                    origin: ray.origin - own.origin,
                    direction: ray.direction - own.direction,
                },
                _ => Aside { offset: DVec2::ZERO, origin: DVec3::ZERO, direction: DVec3::ZERO },
            }
        })
    }
}

impl ShadowBlock {
    /// Bodies `among` some that may hide the sun from it.
    fn among<'c>(&self, among: &[&'c Caster]) -> Vec<&'c Caster> {
        among.iter().copied().filter(|caster| caster.is_over(&self.bounds)).collect()
    }

    fn pixels(&self) -> impl Iterator<Item = [usize; 2]> {
        pixels(&self.columns, &self.rows)
    }
}

/// Column and row of all pixels of some columns and rows.
fn pixels(columns: &Range<usize>, rows: &Range<usize>) -> impl Iterator<Item = [usize; 2]> {
    let columns = columns.clone();
    rows.clone().flat_map(move |row| columns.clone().map(move |column| [column, row]))
}

/// The body that was asked for last.
#[derive(Default)]
pub struct LatestShade<'s>(Cell<Option<BodyCache<'s>>>);

/// State kept for one body.
#[derive(Clone, Copy)]
struct BodyCache<'s> {
    id: u32,
    place: Option<&'s SunlitBody>,
    /// Cells in which the ground's shadow was last computed.
    cells: Cells,
    /// Terrain that hides the body from the sun.
    caster: Option<&'s Caster>,
}

/// Bodies and ground under a sun.
pub struct Shadows<'r, 'a> {
    renderer: &'r Renderer<'a>,
    casters: Casters,
    sunlit: Sunlit<'r, 'a>,
    footprint: Footprint,
    daylight: Daylight,
    to_sun: Vec3,
    atmosphere: Atmosphere,
}

/// Shadows that bodies cast on the ground.
pub(super) struct ShadowPass<'s, 'r, 'a> {
    /// `None`: nothing casts any.
    pub shadows: Option<&'s Shadows<'r, 'a>>,
    pub camera: &'s Camera,
}

impl Pass for ShadowPass<'_, '_, '_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        let Some(shadows) = self.shadows else { return Ok(()) };
        let (pixels, range) = canvas.light_and_range(SQUARE);
        shadows.cast(self.camera, pixels, range, farm)
    }
}

impl<'r, 'a> Shadows<'r, 'a> {
    /// Finds the shadows of `bodies` that `camera` may see; `None` without shadows.
    pub fn of(renderer: &'r Renderer<'a>, camera: &Camera, bodies: &[Body]) -> Option<Self> {
        let options = &renderer.options;
        if !options.has_shadows() || bodies.is_empty() {
            return None;
        }
        let to_sun = options.sun.direction().as_dvec3().normalize();
        let casters = Casters::new(bodies, to_sun, camera.pose.eye, options.curvature, renderer.isa);
        let atmosphere = options.atmosphere(renderer.source.header());
        let footprint = camera.footprint();
        let (sunlit, daylight) =
            (Sunlit::new(renderer, bodies, camera.pose.eye, footprint), Daylight::new(options.sun));
        Some(Self { renderer, casters, sunlit, footprint, daylight, to_sun: to_sun.as_vec3(), atmosphere })
    }

    /// Builds the filter that samples the ground.
    fn filter(&self, camera: &Camera) -> SurfaceFilter<'r> {
        let Renderer { source, options, lit, .. } = self.renderer;
        let filter = SurfaceFilter::new(*source, camera.footprint()).shaded(lit.radiance.shades());
        if options.tile_world { filter.endless() } else { filter }
    }

    /// Darkens the ground that lies in the shadow of bodies; `range` tells how far it is.
    fn cast(&self, camera: &Camera, pixels: Vec<Pixels<'_>>, range: &[f32], farm: &Farm) -> Result<()> {
        let width = camera.width as usize;
        let ground = LitGround { shown: ShownGround { range, width }, lens: Lens::new(camera) };
        farm.each(Stage::Image, pixels, |index, mut pixels| {
            let mut filter = None;
            let first = index * SQUARE;
            let rows = first..(first + SQUARE).min(camera.height as usize);
            for column in (0..width).step_by(SQUARE) {
                let columns = column..(column + SQUARE).min(width);
                let blocks = self.parts(&ground, [&columns, &rows], BLOCK);
                let Some(all) = blocks.iter().map(|block| block.bounds).reduce(|all, own| all.with(&own))
                else {
                    continue;
                };
                let of_square = self.casters.over(&all);
                let mut lights = Lights::of([column, first], &ground.shown, self.to_sun);

                for block in blocks {
                    let of_block = block.among(&of_square);
                    if of_block.is_empty() {
                        continue;
                    }

                    let filter = filter.get_or_insert_with(|| self.filter(camera));
                    for cell in self.parts(&ground, [&block.columns, &block.rows], CELL) {
                        let among = cell.among(&of_block);
                        if among.is_empty() {
                            continue;
                        }

                        let asides = ground.asides(&cell);
                        for [column, row] in cell.pixels() {
                            let left =
                                self.left(&ground, filter, &mut lights, &among, &asides, [column, row])?;
                            if let Some((left, air)) = left {
                                let pixel = (row - first) * width + column;
                                let seen = pixels.light(pixel);
                                pixels.put(pixel, air + (seen - air) * left);
                            }
                        }
                    }
                }
            }

            Ok(())
        })
    }

    /// Parts of some columns and rows, so many pixels each way, in which there is ground.
    fn parts(
        &self,
        ground: &LitGround<'_>,
        [columns, rows]: [&Range<usize>; 2],
        size: usize,
    ) -> Vec<ShadowBlock> {
        let starts = |range: &Range<usize>| {
            let end = range.end;
            range.clone().step_by(size).map(move |start| start..(start + size).min(end))
        };
        let parts = starts(rows).flat_map(|rows| starts(columns).map(move |columns| (columns, rows.clone())));
        parts.filter_map(|(columns, rows)| self.block(ground, columns, rows)).collect()
    }

    /// Returns the extent of a block's ground; `None`: it is all sky.
    fn block(
        &self,
        ground: &LitGround<'_>,
        columns: Range<usize>,
        rows: Range<usize>,
    ) -> Option<ShadowBlock> {
        let ShownGround { range, width } = ground.shown;
        let (mut near, mut far) = (f32::INFINITY, 0.0_f32);
        for row in rows.clone() {
            for range in &range[row * width + columns.start..row * width + columns.end] {
                // Not `min` and `max`, which ask for NaN, too.
                near = if *range < near { *range } else { near };
                far = if far < *range && *range < f32::INFINITY { *range } else { far };
            }
        }

        if near > far {
            return None;
        }

        let beside = BESIDE * f64::from(far - near);
        let ends = [(f64::from(near) - beside).max(0.0), f64::from(far) + beside];
        let middle = |range: &Range<usize>| 0.5 * (range.start + range.end) as f64;
        let ray = ground.lens.ray_at(DVec2::new(middle(&columns), middle(&rows)));

        // At the rim of a round picture any pixel will do.
        let radius = RADIUS * columns.len().max(rows.len()) as f64;
        let ray = ray.map(|ray| (ray, radius)).or_else(|| {
            let ray =
                |[column, row]: [usize; 2]| ground.lens.ray_at(DVec2::new(column as f64, row as f64) + 0.5);
            pixels(&columns, &rows).find_map(ray).map(|ray| (ray, 2.0 * radius))
        });
        let (ray, radius) = ray?;
        let points = ends.into_iter().map(|range| ray.origin + ray.direction * range);
        let bounds = self.casters.bounds(points, radius * self.footprint.at(ends[1]))?;

        Some(ShadowBlock { columns, rows, bounds })
    }

    /// Returns the share of a pixel's light that is left, by channel, where bodies `among` some hide the sun, and the light of the air before it; `None`: all is. `asides` tell how
    /// rays change about it.
    fn left(
        &self,
        ground: &LitGround<'_>,
        filter: &mut SurfaceFilter<'_>,
        lights: &mut Lights,
        among: &[&Caster],
        asides: &[Aside; 2],
        [column, row]: [usize; 2],
    ) -> Result<Option<(Vec3, Vec3)>> {
        let LitGround { shown, lens } = ground;
        let plane = shown.ground(column, row);
        let range = 1.0 / f64::from(plane.inverse);
        if plane.inverse <= 0.0 || lights.are_dark([column, row], range) {
            return Ok(None);
        }

        let Some(ray) = lens.ray_at(DVec2::new(column as f64, row as f64) + 0.5) else { return Ok(None) };
        let middle = ray.origin + ray.direction * range;
        let [across, along] = plane.slope.map(|slope| f64::from(slope).abs() * range * range);

        // As far as half of the pixel reaches each way.
        if !self.casters.is_near(among, middle, self.footprint.at(range) + 0.5 * (across + along)) {
            return Ok(None);
        }

        let [right, down] = asides.map(|aside| {
            let inverse = plane.at(aside.offset);
            let way = (ray.direction + aside.direction) / inverse - ray.direction * range;
            if inverse > 0.0 { aside.origin + way } else { DVec3::ZERO }
        });
        let share = self.casters.share(among, &LitPatch { middle, right, down });
        if share == 1.0 {
            return Ok(None);
        }

        let between = lights.between([column, row], range, |pixel| self.light(ground, filter, pixel))?;
        let light = match between {
            Some(light) => Some(light),
            None => self.light(ground, filter, [column, row])?,
        };
        let Some(CellLight { normal, sun, air, .. }) = light else { return Ok(None) };
        let left = self.daylight.on(normal, sun * share) / self.daylight.on(normal, sun);

        Ok(Some((left, air)))
    }

    /// Returns the sunlight on a pixel's ground; `None`: it is sky.
    fn light(
        &self,
        LitGround { shown, lens }: &LitGround<'_>,
        filter: &mut SurfaceFilter<'_>,
        [column, row]: [usize; 2],
    ) -> Result<Option<CellLight>> {
        let range = f64::from(shown.range[row * shown.width + column]);
        let ray = lens.ray_at(DVec2::new(column as f64, row as f64) + 0.5);
        let Some(ray) = ray.filter(|_| range.is_finite()) else { return Ok(None) };
        let Renderer { source, options, .. } = self.renderer;
        let contact = Contact { range, level: 0, wanted: 0, face: None, bare: false };
        let over_ground =
            GridRay::new(&source.header().grid, ray.origin, ray.direction).over(options.curvature);
        let (normal, sun) = filter.light(&over_ground, &contact)?;
        let veil = self.atmosphere.veil(ray.origin.z, ray.direction.as_vec3(), range as f32);
        Ok(Some(CellLight { range, normal, sun, air: veil.light }))
    }

    /// Returns the first error of what was computed.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn check(&self) -> Result<()> {
        self.sunlit.check()
    }

    /// Share of the sun, 0…1, that the ground, other bodies, or other parts of the same, leave to a hit on a ray.
    pub fn on_body<'s>(&'s self, hit: &Hit, ray: &Ray, latest: &LatestShade<'s>) -> f32 {
        let mut known = latest.0.get().filter(|known| known.id == hit.id).unwrap_or_else(|| BodyCache {
            id: hit.id,
            place: self.sunlit.place(hit.id),
            cells: Cells::default(),
            caster: self.casters.of_body(hit.id),
        });
        let point = ray.origin + ray.direction * hit.range;
        let share = known.place.map_or(1.0, |place| self.sunlit.share(place, point, &mut known.cells));
        latest.0.set(Some(known));
        let Some(own) = known.caster.filter(|_| share > 0.0) else { return share };
        let patch = LitPatch::above(point, hit.normal.as_dvec3(), self.footprint.at(hit.range));
        share * self.casters.share_of_body(own, &patch)
    }
}
