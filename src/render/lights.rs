//! Lamps and stars, put into what was rendered: as bright as their light is at the eye.

use glam::{DVec2, DVec3, Vec3};

use super::Renderer;
use super::merge::Shown;
use crate::error::Result;
use crate::frame::Atmosphere;
use crate::frame::stage::Pixels;
use crate::objects::{Glint, PointLight, SQUARE};
use crate::space::{Camera, Screen};
use crate::subimage::{Farm, Stage};
use crate::sunlight::{Firmament, Star, starlight_through, stars};
use crate::voxel::PageSource;

/// Lamps of a task.
const CHUNK: usize = 256;

/// How far above its place a lamp is asked for, metres and pixels: the ground it stands on is seen more coarsely than it was built, and lies a little higher
/// or lower.
const LIFT: f64 = 0.3;
const LIFT_PIXELS: f64 = 1.0;

/// How much farther than what is in sight a lamp may be and still be seen, as a share of its range.
const BEHIND: f64 = 0.01;

/// Range under which a lamp grows no brighter, metres: the eye is inside of it.
const CLOSEST: f64 = 0.5;

/// Angle that eyes resolve at night, radians. Stars are as bright as pixels of this size would show them, or a picture would lose in its coarser ones what eyes see.
const EYE_ANGLE: f64 = 4.0e-4;

/// Range at which stars are seen through haze, metres.
const BEYOND: f32 = 1.0e6;

/// Who looks, and through what.
struct Eye<'c> {
    camera: &'c Camera,
    atmosphere: Atmosphere,
    /// Linear light of 1 cd/m².
    per_luminance: f64,
    shown: Shown<'c>,
    finder: Finder<'c>,
}

/// Points of light of a view, in an order of their own, and those of each square of the screen.
pub struct Glints {
    glints: Vec<Glint>,
    /// Indices, by square, row by row of [`SQUARE`] rows.
    squares: Vec<Vec<u32>>,
    size: [usize; 2],
}

/// Whether a renderer's view holds any light of lamps or stars.
pub fn any<S>(renderer: &Renderer<'_, S>, lights: &[PointLight]) -> bool {
    !lights.is_empty() || (renderer.options.night.stars.is_some() && !renderer.options.sun.is_up())
}

impl Glints {
    /// What `camera` sees of `lights` and of the stars, where `range` tells how far is what else it sees.
    pub fn find<S: PageSource>(
        renderer: &Renderer<'_, S>,
        camera: &Camera,
        lights: &[PointLight],
        range: &[f32],
        farm: &Farm,
    ) -> Result<Self> {
        let size = [camera.width as usize, camera.height as usize];
        let mut glints = Vec::new();
        // Without an eye nothing tells how bright a lamp is.
        if any(renderer, lights) && !matches!(camera.screen(), Screen::Orthographic { .. }) {
            let options = &renderer.options;
            let eye = Eye {
                camera,
                atmosphere: options.atmosphere(renderer.source.header()),
                per_luminance: f64::from(options.brightness().per_luminance()),
                shown: Shown { range, width: size[0] },
                finder: Finder::new(camera),
            };
            let drop = |at: DVec3| options.curvature.drop_at((at - camera.pose.eye).truncate().length());
            eye.each(lights, farm, &mut glints, |eye, light| {
                eye.lamp(light, light.position - DVec3::Z * drop(light.position))
            })?;
            if let Some(firmament) = options.night.stars.filter(|_| !options.sun.is_up()) {
                eye.each(stars(), farm, &mut glints, |eye, star| eye.star(star, &firmament))?;
            }
        }
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
        Ok(Self { glints, squares, size })
    }

    /// Adds them to pixels, which come by [`SQUARE`] rows.
    pub fn add(&self, pixels: Vec<Pixels<'_>>, farm: &Farm) -> Result<()> {
        if self.glints.is_empty() {
            return Ok(());
        }
        let across = self.size[0].div_ceil(SQUARE);
        let tasks: Vec<_> = pixels.into_iter().zip(self.squares.chunks(across)).collect();
        farm.each(Stage::Image, tasks, |index, (mut pixels, squares)| {
            let mut sums = vec![Vec3::ZERO; SQUARE * SQUARE];
            for (square, indices) in squares.iter().enumerate().filter(|(_, indices)| !indices.is_empty()) {
                let corner = [square * SQUARE, index * SQUARE];
                for &glint in indices {
                    self.glints[glint as usize].add(corner, self.size, &mut sums);
                }
                for (at, sum) in sums.iter_mut().enumerate() {
                    if *sum != Vec3::ZERO {
                        // Only what lies on the screen was added to.
                        let pixel = at / SQUARE * self.size[0] + corner[0] + at % SQUARE;
                        pixels.add(pixel, *sum);
                        *sum = Vec3::ZERO;
                    }
                }
            }
            Ok(())
        })
    }
}

impl Eye<'_> {
    /// Appends what is seen of each of many, in their order.
    fn each<T: Sync>(
        &self,
        all: &[T],
        farm: &Farm,
        glints: &mut Vec<Glint>,
        look: impl Fn(&Self, &T) -> Option<Glint> + Sync,
    ) -> Result<()> {
        let mut found: Vec<_> = all.chunks(CHUNK).map(|chunk| (chunk, Vec::new())).collect();
        farm.each(Stage::Image, found.iter_mut().collect(), |_, (chunk, glints)| {
            glints.extend(chunk.iter().filter_map(|one| look(self, one)));
            Ok(())
        })?;
        glints.extend(found.into_iter().flat_map(|(_, glints)| glints));
        Ok(())
    }

    fn lamp(&self, light: &PointLight, at: DVec3) -> Option<Glint> {
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
        let glint = |share: f64| {
            let glint = Glint::new(position, intensity * (scale * share) as f32, radius, angle)?;
            let [columns, rows] =
                glint.extent([self.camera.width, self.camera.height].map(|size| size as usize));
            (!columns.is_empty() && !rows.is_empty()).then_some(glint)
        };
        // What is too faint or beside the screen needs no closer look.
        glint(1.0)?;
        let lifted = self.finder.position(at + DVec3::Z * (LIFT + LIFT_PIXELS * angle * range));
        let share = self.share(lifted.unwrap_or(position), |inverse| inverse <= (1.0 + BEHIND) / range);
        let direction = (way / range).as_vec3();
        glint(share * f64::from(self.atmosphere.through(eye.z, direction, range as f32)))
    }

    fn star(&self, star: &Star, firmament: &Firmament) -> Option<Glint> {
        let direction = firmament.world(star.direction);
        let position = self.finder.position(self.camera.pose.eye + direction)?;
        let angle = self.angle(position)?;
        let lux = star.lux * starlight_through(direction.z) * self.share(position, |inverse| inverse <= 0.0);
        let through = self.atmosphere.through(self.camera.pose.eye.z, direction.as_vec3(), BEYOND);
        let light = self.per_luminance * lux * f64::from(through) / angle.min(EYE_ANGLE).powi(2);
        Glint::new(position, star.colour * light as f32, 0.0, angle)
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

    /// Share of four pixels about a position, by how near they are, in which the inverse range of what is seen there `passes`.
    fn share(&self, position: DVec2, passes: impl Fn(f64) -> bool) -> f64 {
        let Shown { range, width } = self.shown;
        let last = DVec2::new(width as f64 - 1.0, (range.len() / width) as f64 - 1.0);
        let place = (position - 0.5).clamp(DVec2::ZERO, last);
        let corner = place.floor();
        let part = place - corner;
        let mut share = 0.0;
        for (right, down) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let offset = DVec2::new(right, down);
            let weight = (1.0 - (part - offset).abs()).element_product();
            let pixel = (corner + offset).min(last);
            if weight > 0.0 {
                let ground = self.shown.ground(pixel.x as usize, pixel.y as usize);
                let beside = (position - 0.5 - pixel).clamp(DVec2::splat(-1.0), DVec2::ONE);
                share += if passes(ground.at(beside)) { weight } else { 0.0 };
            }
        }
        share
    }
}

/// Finds where a screen shows points of the world.
struct Finder<'c> {
    camera: &'c Camera,
    /// Of a table, which has no inverse: directions of every [`STRIDE`]th position.
    samples: Vec<(DVec3, DVec2)>,
}

/// Pixels from one known position of a table to the next.
const STRIDE: usize = 8;

/// Steps of Newton's method from there to where a point is.
const STEPS: usize = 4;

impl<'c> Finder<'c> {
    fn new(camera: &'c Camera) -> Self {
        let mut samples = Vec::new();
        if let Screen::Table(_) = camera.screen() {
            for row in (0..=camera.height as usize).step_by(STRIDE) {
                for column in (0..=camera.width as usize).step_by(STRIDE) {
                    let at = DVec2::new(column as f64, row as f64);
                    samples.extend(camera.ray(at.x, at.y).map(|ray| (ray.direction, at)));
                }
            }
        }
        Self { camera, samples }
    }

    /// Position of a world point, pixels; `None` where the screen does not show it.
    fn position(&self, point: DVec3) -> Option<DVec2> {
        let Screen::Table(_) = self.camera.screen() else { return self.camera.screen_from_world(point) };
        let towards = (point - self.camera.pose.eye).normalize();
        let nearest = self.samples.iter().max_by(|a, b| a.0.dot(towards).total_cmp(&b.0.dot(towards)));
        let mut at = nearest?.1;
        let ray = |at: DVec2| self.camera.ray(at.x, at.y).map(|ray| ray.direction);
        for _ in 0..STEPS {
            let here = ray(at)?;
            let across = ray(at + DVec2::new(0.5, 0.0))? - ray(at - DVec2::new(0.5, 0.0))?;
            let along = ray(at + DVec2::new(0.0, 0.5))? - ray(at - DVec2::new(0.0, 0.5))?;
            // Least squares in the plane of both.
            let (aa, ab, bb) = (across.length_squared(), across.dot(along), along.length_squared());
            let (a, b) = (across.dot(towards - here), along.dot(towards - here));
            let scale = aa * bb - ab * ab;
            let step = DVec2::new(a * bb - b * ab, b * aa - a * ab) / scale;
            let step = step.clamp(DVec2::splat(-(STRIDE as f64)), DVec2::splat(STRIDE as f64));
            if !step.is_finite() {
                return None;
            }
            at += step;
        }
        let off = ray(at)?.dot(towards);
        (off > self.camera.pixel_angle().cos()).then_some(at)
    }
}
