//! Depth of every pixel, as files hold it.

use crate::frame::Frame;
use crate::space::{Ray, Screen};

/// The ray of every pixel, row by row.
pub(super) fn rays(frame: &Frame) -> impl Iterator<Item = Option<Ray>> + '_ {
    let camera = &frame.camera;
    let pixels = (0..camera.height).flat_map(|row| (0..camera.width).map(move |column| (column, row)));
    pixels.map(|(column, row)| camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5))
}

/// Metres along the optical axis of every pixel, `Z = range · cos`, where all of the picture lies before the eye; else the
/// range, since depth along an axis says nothing of what is beside or behind it.
pub(super) fn depth(frame: &Frame) -> Vec<f32> {
    let camera = &frame.camera;
    if !matches!(camera.screen(), Screen::Planar { .. } | Screen::Lens { .. } | Screen::Orthographic { .. }) {
        return frame.range.clone();
    }
    let planar = |(ray, &range): (Option<Ray>, &f32)| match ray {
        Some(ray) => (f64::from(range) * camera.axis_cosine(ray.direction)) as f32,
        None => f32::INFINITY,
    };
    rays(frame).zip(&frame.range).map(planar).collect()
}
