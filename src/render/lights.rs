//! Lamps and stars, put into what was rendered: as bright as their light is at the eye.

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};

use super::canvas::Canvas;
use super::finder::Finder;
use super::overlays::Pass;
use super::reference;
use super::renderer::Renderer;
use super::shown_ground::ShownGround;
use crate::objects::{Body, Glint, GlowSums, PARTS, PointLight, SQUARE, Surroundings};
use crate::pixels::Pixels;
use crate::simd::{Floats, Isa, Kernel, LANES, Simd, Sixteen};
use crate::space::{Camera, Ray, Screen};
use crate::subimage::{Farm, Stage};
use crate::sunlight::{Firmament, Star, starlight_through, stars};
use crate::weather::Atmosphere;
use hedgehop_base::error::Result;

/// Lamps of a task.
const CHUNK: usize = 256;

/// Height above its place at which a lamp is tested for occlusion, metres and pixels: the ground it stands on is seen more coarsely than it was built, and lies a little higher
/// or lower.
const LIFT: f64 = 0.3;
const LIFT_PIXELS: f64 = 1.0;

/// Share of a lamp's range by which it may lie behind the visible surface and still be seen.
const BEHIND: f64 = 0.01;

/// Range under which a lamp grows no brighter, metres: the eye is inside of it.
const CLOSEST: f64 = 0.5;

/// Angle that eyes resolve at night, radians. Stars are as bright as pixels of this size would show them, or a picture would lose in its coarser ones what eyes see.
const EYE_ANGLE: f64 = 4.0e-4;

/// Range at which stars are seen through haze, metres.
const BEYOND: f32 = 1.0e6;

/// Observer of the lights: the renderer and its camera.
struct Eye<'c, 'r, 'a> {
    renderer: &'r Renderer<'a>,
    camera: &'c Camera,
    bodies: Surroundings,
    atmosphere: Atmosphere,
    /// Linear light of 1 cd/m².
    per_luminance: f64,
    finder: Finder<'c>,
}

/// Lamps and stars that a view shows where nothing hides them.
pub struct LightPass<'c> {
    isa: Isa,
    camera: &'c Camera,
    points: Vec<SoughtLight>,
}

/// One of them.
struct SoughtLight {
    /// Position on the screen, pixels.
    position: DVec2,
    /// Screen position whose range decides whether the light is hidden; `None`: nothing hides it.
    asked: Option<DVec2>,
    /// Inverse range of the nearest that does not hide it, 1/metres.
    inverse: f64,
    /// Light of all its pixels, its radius in pixels, and how large they are, radians.
    light: Vec3,
    radius: f64,
    angle: f64,
}

/// Points of light of a view, in an order of their own, and those of each square of the screen.
struct Glints<'c> {
    camera: &'c Camera,
    glints: Vec<Glint>,
    /// Indices, by square, row by row of [`SQUARE`] rows.
    squares: Vec<Vec<u32>>,
    size: [usize; 2],
}

impl<'c> LightPass<'c> {
    /// Finds the lights of `lights` and the stars that `camera` may see.
    pub fn find(
        renderer: &Renderer<'_>,
        camera: &'c Camera,
        lights: &[PointLight],
        bodies: &[Body],
        farm: &Farm,
    ) -> Result<Self> {
        let options = &renderer.options;
        let firmament = options.night.stars.filter(|_| !options.sun.is_up());
        let mut points = Vec::new();

        // Without an eye nothing tells how bright a lamp is.
        let has_eye = !matches!(camera.screen(), Screen::Orthographic { .. });
        if has_eye && (!lights.is_empty() || firmament.is_some()) {
            let eye = Eye {
                renderer,
                camera,
                bodies: Surroundings::new(camera, bodies, options.curvature),
                atmosphere: options.atmosphere(renderer.source.header()),
                per_luminance: f64::from(options.brightness().per_luminance()),
                finder: Finder::new(camera),
            };

            let drop = |at: DVec3| options.curvature.drop_at((at - camera.pose.eye).truncate().length());
            each(lights, farm, &mut points, |light| {
                eye.lamp(light, light.position - DVec3::Z * drop(light.position))
            })?;
            if let Some(firmament) = firmament {
                each(stars(), farm, &mut points, |star| eye.star(star, &firmament))?;
            }
        }

        Ok(Self { isa: renderer.isa, camera, points })
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Adds the parts of rows, [`LANES`] pixels wide, whose range tells whether they are hidden, to those of which it is known that they are asked for, `[rows][parts of a
    /// row]`; empty: none is.
    pub fn mark(&self, parts: &mut Vec<bool>) {
        let [width, height] = [self.camera.width as usize, self.camera.height as usize];
        let count = width.div_ceil(LANES);
        parts.resize(if self.is_empty() { parts.len() } else { count * height }, false);
        for asked in self.points.iter().filter_map(|point| point.asked) {
            let [columns, rows] = [(asked.x, width), (asked.y, height)].map(|(at, size)| {
                // Four pixels about it, and their neighbours, which tell how the ground in them lies. A float converts saturating.
                let first = (at - 0.5).max(0.0) as usize;
                first.saturating_sub(1).min(size - 1)..(first + 3).min(size)
            });
            for row in rows {
                parts[row * count + columns.start / LANES..row * count + columns.end.div_ceil(LANES)]
                    .fill(true);
            }
        }
    }

    /// Returns the lights that are visible where `range` (metres) is the range of the rest of the picture.
    fn seen(&self, range: &[f32], farm: &Farm) -> Result<Glints<'c>> {
        let size = [self.camera.width as usize, self.camera.height as usize];
        let shown = ShownGround { range, width: size[0] };
        let mut glints = Vec::new();
        each(&self.points, farm, &mut glints, |point| {
            Ok(Glint::new(point.position, point.light * point.share(&shown), point.radius, point.angle))
        })?;

        // Sums depend on the order of their terms; that of the lamps is not to count.
        glints.sort_unstable_by_key(Glint::rank);
        let across = size[0].div_ceil(SQUARE);
        let mut squares = vec![Vec::new(); across * size[1].div_ceil(SQUARE)];

        for (index, glint) in (0..).zip(&glints) {
            let [columns, rows] = glint.extent(size);
            for row in rows.start / SQUARE..rows.end.div_ceil(SQUARE) {
                for column in columns.start / SQUARE..columns.end.div_ceil(SQUARE) {
                    squares[row * across + column].push(index);
                }
            }
        }

        Ok(Glints { camera: self.camera, glints, squares, size })
    }
}

/// Appends what is found of each of many, in their order.
fn each<T: Sync, U: Send>(
    all: &[T],
    farm: &Farm,
    found: &mut Vec<U>,
    find: impl Fn(&T) -> Result<Option<U>> + Sync,
) -> Result<()> {
    let mut chunks: Vec<_> = all.chunks(CHUNK).map(|chunk| (chunk, Vec::new())).collect();
    farm.each(Stage::Image, chunks.iter_mut().collect(), |_, (chunk, found)| {
        for one in *chunk {
            found.extend(find(one)?);
        }
        Ok(())
    })?;
    found.extend(chunks.into_iter().flat_map(|(_, found)| found));
    Ok(())
}

impl SoughtLight {
    /// Share of four pixels about where it is asked for, by how near they are, in which nothing hides it.
    fn share(&self, shown: &ShownGround<'_>) -> f32 {
        let Some(asked) = self.asked else { return 1.0 };
        let ShownGround { range, width } = *shown;
        let last = DVec2::new(width as f64 - 1.0, (range.len() / width) as f64 - 1.0);
        let place = (asked - 0.5).clamp(DVec2::ZERO, last);
        let corner = place.floor();
        let part = place - corner;
        let mut share = 0.0;
        for (right, down) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let offset = DVec2::new(right, down);
            let weight = (1.0 - (part - offset).abs()).element_product();
            let pixel = (corner + offset).min(last);
            if weight > 0.0 {
                let ground = shown.ground(pixel.x as usize, pixel.y as usize);
                let beside = (asked - 0.5 - pixel).clamp(DVec2::splat(-1.0), DVec2::ONE);
                share += if ground.at(beside) <= self.inverse { weight } else { 0.0 };
            }
        }
        share as f32
    }
}

impl Pass for LightPass<'_> {
    fn draw(&self, canvas: &mut Canvas, farm: &Farm) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        let (pixels, range) = canvas.light_and_range(SQUARE);
        self.seen(range, farm)?.add(self.isa, pixels, farm)
    }
}

impl Glints<'_> {
    /// Adds them to pixels, which come by [`SQUARE`] rows.
    fn add(&self, isa: Isa, pixels: Vec<Pixels<'_>>, farm: &Farm) -> Result<()> {
        if self.glints.is_empty() {
            return Ok(());
        }
        let across = self.size[0].div_ceil(SQUARE);
        let tasks: Vec<_> = pixels.into_iter().zip(self.squares.chunks(across)).collect();
        farm.each(Stage::Image, tasks, |index, (pixels, squares)| {
            isa.run(Adding { glints: self, row: index * SQUARE, squares, pixels });
            Ok(())
        })
    }
}

/// Adds points of light to [`SQUARE`] rows of pixels.
struct Adding<'g, 'p> {
    glints: &'g Glints<'g>,
    /// The first one of the screen.
    row: usize,
    squares: &'g [Vec<u32>],
    pixels: Pixels<'p>,
}

impl Kernel for Adding<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { glints: Glints { camera, glints, size: [width, _], .. }, row: first, squares, mut pixels } =
            self;
        let has_blind = matches!(camera.screen(), Screen::Fisheye { .. } | Screen::Table(_));
        let rows = pixels.count() / width;
        let mut glow = GlowSums::none([0, first]);

        for (square, indices) in squares.iter().enumerate().filter(|(_, indices)| !indices.is_empty()) {
            glow.begin([square * SQUARE, first]);
            for &glint in indices {
                glints[glint as usize].add(simd, &mut glow);
            }

            for row in glow.rows() {
                for part in 0..PARTS {
                    let (mut light, column) = (glow.take(row, part), square * SQUARE + part * LANES);
                    if has_blind {
                        darken(camera, [column, first + row], &mut light);
                    }
                    if light != <[Sixteen; 3]>::default() && row < rows && column < *width {
                        let start = row * width + column;
                        add(simd, &mut pixels, start..start + LANES.min(width - column), &light);
                    }
                }
            }
        }
    }
}

/// Leaves no light to pixels without a ray among those that begin at some column and row.
fn darken(camera: &Camera, [column, row]: [usize; 2], light: &mut [Sixteen; 3]) {
    for lane in 0..LANES {
        if camera.ray((column + lane) as f64 + 0.5, row as f64 + 0.5).is_none() {
            light.iter_mut().for_each(|channel| channel.0[lane] = 0.0);
        }
    }
}

/// Adds light to up to [`LANES`] pixels. What is brighter than display white keeps its hue in a picture: a red lamp stays red.
#[inline(always)]
fn add<V: Simd>(simd: V, pixels: &mut Pixels<'_>, at: Range<usize>, light: &[Sixteen; 3]) {
    let mut sum = pixels.load(simd, at.clone());
    for (sum, light) in sum.iter_mut().zip(light) {
        *sum = *sum + simd.load(&light.0);
    }
    if let Pixels::Srgb8(_) = pixels {
        let [red, green, blue] = sum;
        let fits = simd.splat(1.0) / red.max(green).max(blue).max(simd.splat(1.0));
        for sum in &mut sum {
            *sum = *sum * fits;
        }
    }
    pixels.store(simd, at, sum);
}

impl Eye<'_, '_, '_> {
    fn lamp(&self, light: &PointLight, at: DVec3) -> Result<Option<SoughtLight>> {
        let Some((point, towards)) = self.lit(light, at) else { return Ok(None) };
        self.open(point, towards)
    }

    /// A lamp if nothing hides it, and where to look for what does.
    fn lit(&self, light: &PointLight, at: DVec3) -> Option<(SoughtLight, DVec3)> {
        let eye = self.camera.pose.eye;
        let intensity = light.towards(eye + (light.position - at));
        if intensity == Vec3::ZERO {
            return None;
        }

        let way = at - eye;
        let range = way.length().max(CLOSEST);
        let position = self.finder.position(at)?;
        let angle = self.angle(position)?;
        let scale = self.per_luminance / (range * range * angle * angle);
        let radius = light.fixture.radius / (range * angle);
        let light = intensity * scale as f32;
        let size = [self.camera.width, self.camera.height].map(|size| size as usize);

        // What is too faint or beside the screen needs no closer look.
        let [columns, rows] = Glint::new(position, light, radius, angle)?.extent(size);
        if columns.is_empty() || rows.is_empty() {
            return None;
        }

        let lifted_at = at + DVec3::Z * (LIFT + LIFT_PIXELS * angle * range);
        let lifted = self.finder.position(lifted_at);
        let through = self.atmosphere.veil(eye.z, (way / range).as_vec3(), range as f32).through;
        let (asked, inverse) = (Some(lifted.unwrap_or(position)), (1.0 + BEHIND) / range);

        Some((
            SoughtLight { position, asked, inverse, light: light * through, radius, angle },
            lifted_at - eye,
        ))
    }

    /// A point that the screen is to be asked about: where it does not show it, a ray `towards` it tells whether it is hidden.
    fn open(&self, point: SoughtLight, towards: DVec3) -> Result<Option<SoughtLight>> {
        let size = DVec2::new(f64::from(self.camera.width), f64::from(self.camera.height));
        let is_beside = |at: DVec2| at.cmplt(DVec2::ZERO).any() || at.cmpgt(size).any();
        if !point.asked.is_some_and(is_beside) {
            return Ok(Some(point));
        }
        let Renderer { source, options, .. } = self.renderer;
        let ray = Ray { origin: self.camera.pose.eye, direction: towards.normalize() };
        let mut marcher = reference::marcher(*source, self.camera, options);
        let over_ground = marcher.ray(ray.origin, ray.direction);
        let ground = marcher.first_contact(&over_ground, 0.0)?.map(|contact| contact.range);
        let hides = |range: f64| range * point.inverse < 1.0;
        let is_hidden = ground.into_iter().chain(self.bodies.range(&ray)).any(hides);
        Ok((!is_hidden).then_some(SoughtLight { asked: None, ..point }))
    }

    fn star(&self, star: &Star, firmament: &Firmament) -> Result<Option<SoughtLight>> {
        let direction = firmament.world(star.direction);
        self.seen(star, direction).map_or(Ok(None), |point| self.open(point, direction))
    }

    /// A star in some direction, if nothing hides it.
    fn seen(&self, star: &Star, direction: DVec3) -> Option<SoughtLight> {
        let position = self.finder.position(self.camera.pose.eye + direction)?;
        let angle = self.angle(position)?;
        let lux = star.lux * starlight_through(direction.z);
        let through = self.atmosphere.veil(self.camera.pose.eye.z, direction.as_vec3(), BEYOND).through;
        let light = self.per_luminance * lux * f64::from(through) / angle.min(EYE_ANGLE).powi(2);
        let light = star.colour * light as f32;
        // The sky alone does not hide it.
        Some(SoughtLight { position, asked: Some(position), inverse: 0.0, light, radius: 0.0, angle })
    }

    /// Angle between neighbouring pixels about a position, radians: the root of a pixel's solid angle.
    fn angle(&self, position: DVec2) -> Option<f64> {
        let ray = |right: f64, down: f64| {
            self.camera.ray(position.x + right, position.y + down).map(|ray| ray.direction)
        };
        if let Screen::Planar { .. } = self.camera.screen() {
            let cosine = self.camera.axis_cosine(ray(0.0, 0.0)?);
            return (cosine > 0.0).then(|| cosine.powf(1.5) / self.camera.focal_px());
        }
        let across = ray(0.5, 0.0)? - ray(-0.5, 0.0)?;
        let along = ray(0.0, 0.5)? - ray(0.0, -0.5)?;
        Some(across.cross(along).length().sqrt()).filter(|angle| *angle > 0.0)
    }
}
