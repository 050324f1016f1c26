//! Frames of several rays a pixel, and of all moments that a shutter is open.
//!
//! ```text
//! frame at its own time, n × n rays a pixel ──▶ how far the screen moves while the shutter is open ──▶ number of moments
//! light = mean over the moments, spread evenly about that time, of their filtered rays
//! ```
//!
//! Light adds up linearly, so that a moving edge is as bright as it is for its share of the time (Potmesil and Chakravarty 1983, *Modeling Motion Blur*).

use glam::DVec3;

use super::account::{Account, Rendered, StageTimes};
use super::overlays::Overlays;
use super::renderer::Renderer;
use crate::frame::finish::{develop, gather, thin};
use crate::frame::{Aov, Frame, Picture};
use crate::objects::Body;
use crate::scene::{Finish, Scenery};
use crate::space::{Camera, Screen};
use crate::subimage::Farm;
use hedgehop_base::error::{Error, Result};

/// Moments of a frame at most: what moves farther than so many pixels while the shutter is open shows steps.
pub const MOST_MOMENTS: usize = 31;

/// Rays of a frame at most: its planes take ten gigabytes then.
const MOST_RAYS: u64 = 1 << 28;

/// Pixels across and down at which the screen's motion is looked at.
const LOOKS: [u32; 2] = [24, 14];

/// Part of the shutter's time within which the speed of turning parts is looked at: what turns less than half a round in it is not taken for slower.
const GLANCE: f64 = 1.0 / 64.0;

/// Metres at which the sky is taken to be.
const SKY: f64 = 1.0e8;

/// State of the scene at one time.
#[derive(Debug, Clone)]
pub struct Moment {
    /// The camera; at all moments of a frame of the same screen and size.
    pub camera: Camera,
    /// Overlays of the ground; at all moments of a frame the same bodies in the same order.
    pub scenery: Scenery,
    /// Since the flight's first fix, seconds.
    pub seconds: f64,
}

/// Exposure of one frame: shutter, interval, samples, and the scene over time.
pub struct Exposure<'m> {
    /// Rays per pixel, the shutter, and what is made of light.
    pub finish: &'m Finish,
    /// Time from frame to frame, seconds, > 0.
    pub interval: f64,
    /// Scene so many seconds before (less than 0) or after the frame's own time.
    pub moment: &'m dyn Fn(f64) -> Moment,
}

impl Renderer<'_> {
    /// Renders the light seen while the shutter is open: colour is the mean of all rays and moments; ranges, normals, levels and ids are
    /// those of one ray of each pixel at the frame's own time. Nothing is exposed or toned. The same bits for any number of workers.
    ///
    /// The number of moments is odd and, up to [`MOST_MOMENTS`], as large as the number of pixels that the screen moves by while the shutter is open,
    /// where it moves fastest.
    ///
    /// # Errors
    /// As of [`Self::frame`]; [`Error::Configuration`] for what [`Finish::check`] refuses, and for pictures too large to have so many rays.
    pub fn exposed(&self, exposure: &Exposure<'_>, farm: &Farm) -> Result<Rendered> {
        self.gathered(exposure, true, farm)
    }

    /// [`Self::exposed`]; unless it `describes` surfaces, only colour and range mean something.
    fn gathered(&self, exposure: &Exposure<'_>, describes: bool, farm: &Farm) -> Result<Rendered> {
        let Exposure { finish, interval, moment } = exposure;
        finish.check()?;
        let own = moment(0.0);
        let [width, height] = [own.camera.width, own.camera.height];
        let side = finish.antialias;
        if side > 1 && u64::from(width) * u64::from(height) * u64::from(side * side) > MOST_RAYS {
            return Err(Error::Configuration(format!(
                "a picture of {width}×{height} pixels is too large for {side} × {side} rays a pixel (--antialias): {MOST_RAYS} rays are the most"
            )));
        }

        let render = |moment: &Moment, describes: bool| {
            let camera = moment.camera.enlarged(side);
            let trails: Vec<_> = moment.scenery.trails.iter().map(|trail| trail.enlarged(side)).collect();
            let overlays = Overlays { trails: &trails, ..(&moment.scenery).into() };
            self.at(moment.seconds).seen_with(&camera, overlays, describes, farm)
        };
        let Rendered { frame, mut account } = render(&own, describes)?;
        if !finish.gathers() {
            return Ok(Rendered { frame, account });
        }

        let open = interval * finish.shutter / 360.0;
        let count = if open > 0.0 {
            let moved = motion(&own, [&moment(-0.5 * open), &moment(0.5 * open)], &frame.range, side);
            let glance = 0.5 * GLANCE * open;
            let has_parts = own.scenery.parts > 0;
            let turned = || turning([&moment(-glance), &moment(glance)]) / GLANCE;
            moments(if has_parts { moved.max(turned()) } else { moved })
        } else {
            1
        };

        let (side, columns) = (side as usize, width as usize);
        let mut light = vec![[0.0; 3]; columns * height as usize];
        let weight = 1.0 / count as f32;
        gather(&frame.colour, side, weight, &mut light, columns, farm);

        for index in (0..count).filter(|index| *index != count / 2) {
            let offset = ((index as f64 + 0.5) / count as f64 - 0.5) * open;
            let rendered = render(&moment(offset), false)?;
            gather(&rendered.frame.colour, side, weight, &mut light, columns, farm);
            account += rendered.account;
        }

        // Shares of bodies and of what is made up are those of pixels at the frame's own time.
        let aov = if (self.options.matte || self.options.tells_synthesis) && describes {
            self.at(own.seconds).seen_with(&own.camera, (&own.scenery).into(), true, farm)?.frame.aov
        } else {
            Aov::default()
        };

        let frame = Frame {
            aov,
            camera: own.camera,
            colour: light,
            range: thin(&frame.range, side, columns),
            normal: thin(&frame.normal, side, columns),
            level: thin(&frame.level, side, columns),
            id: thin(&frame.id, side, columns),
        };

        Ok(Rendered { frame, account })
    }

    /// [`Self::exposed`], and what [`develop`] makes of that light.
    ///
    /// # Errors
    /// As of [`Self::exposed`].
    pub fn developed(&self, exposure: &Exposure<'_>, farm: &Farm) -> Result<(Picture, Account)> {
        let Rendered { frame, account } = self.gathered(exposure, false, farm)?;
        let size = [frame.camera.width, frame.camera.height];
        Ok((develop(&frame.colour, size, exposure.finish, farm), account))
    }
}

impl std::ops::AddAssign for Account {
    fn add_assign(&mut self, other: Self) {
        let StageTimes { march, shade, image } = other.times;
        let times = &mut self.times;
        (times.march, times.shade, times.image) =
            (times.march + march, times.shade + shade, times.image + image);
        self.rays += other.rays;
    }
}

/// Moments for a screen that moves by so many pixels.
fn moments(moved: f64) -> usize {
    let count = moved.ceil().clamp(1.0, MOST_MOMENTS as f64) as usize;
    count | 1
}

/// Returns how far the screen moves between two moments, pixels, where it moves fastest: points seen at the frame's own time, whose rays are `side` × `side` a
/// pixel and have the ranges `range` (metres), and the middles of bodies in sight.
fn motion(own: &Moment, ends: [&Moment; 2], range: &[f32], side: u32) -> f64 {
    let camera = &own.camera;
    let width = (camera.width * side) as usize;
    let places = (0..LOOKS[0] * LOOKS[1]).map(|look| {
        let at =
            |index: u32, count: u32, size: u32| (2 * index + 1) as f64 / (2 * count) as f64 * f64::from(size);
        [at(look % LOOKS[0], LOOKS[0], camera.width), at(look / LOOKS[0], LOOKS[1], camera.height)]
    });

    let seen = places.filter_map(|[column, row]| {
        let ray = camera.ray(column, row)?;
        let pixel = (row * f64::from(side)) as usize * width + (column * f64::from(side)) as usize;
        let range = f64::from(*range.get(pixel)?);
        let point = ray.origin + ray.direction * if range.is_finite() { range } else { SKY };
        shift(ends.map(|end| &end.camera), [point; 2])
    });

    let bodies = own.scenery.bodies.iter().zip(ends[0].scenery.bodies.iter().zip(&ends[1].scenery.bodies));
    let bodies = bodies
        .filter(|(body, _)| is_in_sight(camera, body.position))
        .filter_map(|(_, (one, other))| shift(ends.map(|end| &end.camera), [one.position, other.position]));

    seen.chain(bodies).fold(0.0, f64::max)
}

/// Returns how far corners of the boxes around parts move on the screen between two moments, pixels, where they move fastest: middles of rotors stand still.
fn turning(ends: [&Moment; 2]) -> f64 {
    let parts = ends.map(|end| {
        let Scenery { bodies, parts, .. } = &end.scenery;
        &bodies[bodies.len() - parts..]
    });
    let corners = |body: &Body| {
        let (axes, corners) = (body.world_from_body(), body.form.corners());
        let of = move |corner: usize, axis: usize| corners[corner >> axis & 1][axis];
        let position = body.position;
        (0..8).map(move |corner| position + axes * DVec3::from_array([0, 1, 2].map(|axis| of(corner, axis))))
    };
    let cameras = ends.map(|end| &end.camera);
    let moved = parts[0].iter().zip(parts[1]).filter(|(one, other)| one.id == other.id);
    let moved = moved.flat_map(|(one, other)| corners(one).zip(corners(other)));
    let in_sight = moved.filter(|(corner, _)| is_in_sight(cameras[0], *corner));
    in_sight.filter_map(|(one, other)| shift(cameras, [one, other])).fold(0.0, f64::max)
}

/// Whether a point is on the screen, where that tells.
fn is_in_sight(camera: &Camera, point: DVec3) -> bool {
    camera.screen_from_world(point).is_some_and(|at| {
        at.x >= 0.0 && at.y >= 0.0 && at.x <= f64::from(camera.width) && at.y <= f64::from(camera.height)
    }) || matches!(camera.screen(), Screen::Table(_))
}

/// Pixels between where two cameras see two points; `None` where one of them is at the eye.
fn shift(cameras: [&Camera; 2], points: [DVec3; 2]) -> Option<f64> {
    if let Screen::Orthographic { .. } = cameras[0].screen() {
        let at = |index: usize| cameras[index].screen_from_world(points[index]);
        return Some((at(0)? - at(1)?).length());
    }
    let toward = |index: usize| {
        let camera: &Camera = cameras[index];
        (camera.world_from_view().transpose() * (points[index] - camera.pose.eye)).try_normalize()
    };
    let (one, other) = (toward(0)?, toward(1)?);
    Some(one.cross(other).length().atan2(one.dot(other)) / cameras[0].pixel_angle())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Attitude, Pose};

    fn moment(eye: DVec3, yaw: f64) -> Moment {
        let attitude = Attitude { yaw, pitch: 0.0, roll: 0.0 };
        let camera = Camera::new(Pose { eye, attitude, hfov: 60.0 }, 240, 140);
        Moment { camera, scenery: Scenery::default(), seconds: 0.0 }
    }

    #[test]
    fn motion_is_that_of_the_fastest_place() {
        let still = moment(DVec3::ZERO, 0.0);
        let sky = vec![f32::INFINITY; 240 * 140];
        assert_eq!(motion(&still, [&still, &still], &sky, 1), 0.0);
        // A turn moves all directions near the axis's height alike.
        let turned = [&moment(DVec3::ZERO, -0.5), &moment(DVec3::ZERO, 0.5)];
        let moved = motion(&still, turned, &sky, 1);
        let expected = 1.0_f64.to_radians() / still.camera.pixel_angle();
        assert!((moved / expected - 1.0).abs() < 0.02, "{moved} {expected}");
        // Sideways past a wall 100 m away, that is two metres wide on the screen's pixels.
        let wall = vec![100.0; 240 * 140];
        let passed = [&moment(DVec3::new(-1.0, 0.0, 0.0), 0.0), &moment(DVec3::new(1.0, 0.0, 0.0), 0.0)];
        let moved = motion(&still, passed, &wall, 1);
        let expected = 0.02 / still.camera.pixel_angle();
        assert!((moved / expected - 1.0).abs() < 0.05, "{moved} {expected}");
        // The sky does not move with the eye.
        assert!(motion(&still, passed, &sky, 1) < 1e-3);
    }

    #[test]
    fn there_are_as_many_moments_as_pixels_but_not_more_than_the_bound() {
        for (moved, count) in
            [(0.0, 1), (0.9, 1), (1.1, 3), (3.0, 3), (7.5, 9), (30.5, 31), (500.0, 31), (f64::INFINITY, 31)]
        {
            assert_eq!(moments(moved), count, "{moved}");
        }
    }
}
