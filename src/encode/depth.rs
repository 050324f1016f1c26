//! Depth of every pixel, as files hold it.

use crate::frame::Frame;
use crate::space::Screen;
use crate::subimage::Farm;

/// Metres along the optical axis of every pixel, `Z = range · cos`, where all of the picture lies before the eye; else the
/// range, since depth along an axis says nothing of what is beside or behind it.
pub(super) fn depth(frame: &Frame, farm: &Farm) -> Vec<f32> {
    let camera = &frame.camera;
    let mut depth = frame.range.clone();
    if !matches!(camera.screen(), Screen::Planar { .. } | Screen::Lens { .. } | Screen::Orthographic { .. }) {
        return depth;
    }
    farm.rows(&mut depth, camera.width as usize, |row, line| {
        if let Some(direction) = camera.planar_directions(0, row as u32) {
            for (column, depth) in (0_u32..).zip(line) {
                *depth = (f64::from(*depth) * camera.axis_cosine(direction(column))) as f32;
            }
            return;
        }
        for (column, depth) in (0_u32..).zip(line) {
            *depth = match camera.ray(f64::from(column) + 0.5, row as f64 + 0.5) {
                Some(ray) => (f64::from(*depth) * camera.axis_cosine(ray.direction)) as f32,
                None => f32::INFINITY,
            };
        }
    });
    depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::testing;
    use crate::space::Camera;

    #[test]
    fn depth_is_that_of_each_ray_bit_by_bit() {
        for (width, height) in [(1, 1), (2, 3), (37, 20), (640, 5)] {
            let mut frame = testing::frame(width, height);
            let pose = frame.camera.pose;
            for screen in [
                Screen::Planar { hfov: 60.0 },
                Screen::Planar { hfov: 133.7 },
                Screen::Orthographic { width: 90.0 },
            ] {
                frame.camera = Camera::with_screen(pose, screen.clone(), width, height);
                let depth = depth(&frame, &Farm::new(2).unwrap());
                for (at, depth) in (0_u32..).zip(depth) {
                    let (column, row) = (at % width, at / width);
                    let ray = frame.camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5).unwrap();
                    let cosine = frame.camera.axis_cosine(ray.direction);
                    let wanted = (f64::from(frame.range[at as usize]) * cosine) as f32;
                    assert!(depth.to_bits() == wanted.to_bits(), "{screen:?}: {column}, {row}");
                }
            }
        }
    }
}
