//! Motion vectors: how far what a pixel shows moves on the screen until another moment.
//!
//! ```text
//! pixel ──ray · range──▶ point of the world ──with its body──▶ that point at the other moment ──other camera──▶ position
//! vector = position − pixel; where the other moment is earlier, its negative
//! ```
//!
//! The Earth's curvature lowers ground by its distance from an eye, so that it is lowered otherwise at the other moment. The sky is infinitely far:
//! it moves as the view turns.

use glam::{DMat3, DVec2, DVec3};

use super::Frame;
use crate::earth::Curvature;
use crate::objects::Body;
use crate::space::{Camera, Ray, Screen};
use crate::subimage::Farm;
use hedgehop_base::error::{Error, Result};

/// Pixels of the longest vector that is told, as far as halves reach: what passes the eye goes beyond all bounds.
const LONGEST: f64 = 65_504.0;

/// Step from one moment to another.
#[derive(Debug, Clone, Copy)]
pub struct MotionStep<'s> {
    /// Camera of the other moment, with the same screen.
    pub camera: &'s Camera,
    /// Bodies of the frame, and the same at the other moment, in any order.
    pub bodies: [&'s [Body]; 2],
    /// Curvature of the ground.
    pub curvature: Curvature,
    /// Whether the other moment is the earlier one.
    pub is_backward: bool,
}

/// Movement of a body from one moment to another, as an eye sees it: `turn · point + shift`.
struct Moved {
    id: u32,
    turn: DMat3,
    shift: DVec3,
}

/// Computes how many pixels what `frame` shows moves to the right and up until the other moment of `step` (from then on, if that is the earlier one): of a
/// flight from one frame to the next, per frame. `[height][width]`, each component at most 65504 either way; 0 where the screen has no picture and
/// where it has none of the point at the other moment, as behind the eye.
///
/// # Errors
/// [`Error::Configuration`] on screens that are tables of rays: they do not tell where a point is.
pub fn motion(frame: &Frame, step: &MotionStep<'_>, farm: &Farm) -> Result<Vec<[f32; 2]>> {
    if let Screen::Table(_) = frame.camera.screen() {
        let what =
            "motion vectors need a screen with a formula, and a table of rays has none; leave out motion";
        return Err(Error::Configuration(what.to_owned()));
    }
    let moved = moved(frame, step);
    let width = frame.camera.width as usize;
    let mut vectors = vec![[0.0; 2]; frame.range.len()];
    farm.rows(&mut vectors, width, |row, line| {
        for (column, vector) in line.iter_mut().enumerate() {
            let pixel = row * width + column;
            let place = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            if let Some(to) = position(frame, step, &moved, pixel, place) {
                *vector = told(frame.camera.screen(), width, to - place, step.is_backward);
            }
        }
    });
    Ok(vectors)
}

/// Finds a pixel's point on the screen at the other moment.
fn position(
    frame: &Frame,
    step: &MotionStep<'_>,
    moved: &[Moved],
    pixel: usize,
    place: DVec2,
) -> Option<DVec2> {
    let ray = frame.camera.ray(place.x, place.y)?;
    let (range, eye) = (f64::from(frame.range[pixel]), step.camera.pose.eye);
    if range.is_infinite() {
        // Parallel rays see no point of the sky: it is the same wherever they start.
        let is_parallel = matches!(frame.camera.screen(), Screen::Orthographic { .. });
        return if is_parallel { None } else { step.camera.screen_from_world(eye + ray.direction) };
    }
    let point = ray.origin + ray.direction * range;
    let own = (frame.level[pixel] == Frame::BODY_LEVEL)
        .then(|| moved.binary_search_by_key(&frame.id[pixel], |moved| Frame::body_id(moved.id)).ok())
        .flatten();
    let then = match own {
        Some(index) => moved[index].turn * point + moved[index].shift,
        None => lowered(raised(point, &ray, step.curvature), eye, step.curvature),
    };
    step.camera.screen_from_world(then)
}

/// Raises a point of the ground to its height in the database.
pub(super) fn raised(point: DVec3, ray: &Ray, curvature: Curvature) -> DVec3 {
    point + DVec3::Z * curvature.drop_at((point - ray.origin).truncate().length())
}

/// Lowers a point of the database to where an eye finds it.
fn lowered(point: DVec3, eye: DVec3, curvature: Curvature) -> DVec3 {
    point - DVec3::Z * curvature.drop_at((point - eye).truncate().length())
}

/// Lists the movement of each body, by id. One that is not there at the other moment stays.
fn moved(frame: &Frame, step: &MotionStep<'_>) -> Vec<Moved> {
    let [now, then] = step.bodies;
    let mut by_id: Vec<&Body> = then.iter().collect();
    by_id.sort_unstable_by_key(|body| body.id);
    let mut moved: Vec<Moved> = now
        .iter()
        .map(|body| {
            let found = by_id.binary_search_by_key(&body.id, |other| other.id);
            let other = found.map_or(body, |index| by_id[index]);
            let turn = other.world_from_body() * body.world_from_body().transpose();
            let place =
                |body: &Body, camera: &Camera| lowered(body.position, camera.pose.eye, step.curvature);
            let shift = place(other, step.camera) - turn * place(body, &frame.camera);
            Moved { id: body.id, turn, shift }
        })
        .collect();
    moved.sort_unstable_by_key(|moved| moved.id);
    moved
}

/// A difference of positions as files hold it.
fn told(screen: &Screen, width: usize, mut offset: DVec2, is_backward: bool) -> [f32; 2] {
    if let Screen::Cylindrical { hfov } | Screen::Equirectangular { hfov, .. } = *screen {
        // The shorter way around.
        let turn = 360.0 * width as f64 / hfov;
        offset.x -= turn * (offset.x / turn).round();
    }
    let sign = if is_backward { -1.0 } else { 1.0 };
    [offset.x * sign, -offset.y * sign].map(|pixels| pixels.clamp(-LONGEST, LONGEST) as f32)
}

#[cfg(test)]
mod tests;
