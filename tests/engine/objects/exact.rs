//! What a pixel holds of a body, by many rays and other formulae than the library's.

use glam::{DVec2, DVec3};

use crate::scene::View;

/// Rays each way of a pixel: their shares are exact to a five-hundredth or better.
const FINE: u32 = 48;

/// Share of each pixel whose rays (from the area's south-west corner, metres) hit something, all of which lies before the eye
/// within one of some boxes (by two opposite corners).
pub fn shares(view: &View, boxes: &[[DVec3; 2]], hits: impl Fn(DVec3, DVec3) -> bool) -> Vec<f64> {
    let axes = axes(view);
    let [width, height] = view.size;
    let (half_width, half_height) = (0.5 * f64::from(width), 0.5 * f64::from(height));
    let focal = half_width / (0.5 * view.hfov.to_radians()).tan();

    // Nothing of a box is seen beyond its corners.
    let seen = boxes.iter().map(|corners| {
        (0..8).fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(first, last), corner| {
            let corner = DVec3::from_array([0, 1, 2].map(|axis| corners[corner >> axis & 1][axis]));
            let to = axes.transpose() * (corner - view.eye);
            assert!(to.y > 0.0, "{corner} is behind the eye");
            let at = DVec2::new(half_width + focal * to.x / to.y, half_height - focal * to.z / to.y);
            (first.min(at), last.max(at))
        })
    });
    let seen: Vec<_> = seen.collect();

    let within = |first: u32, part: u32| f64::from(first) + (f64::from(part) + 0.5) / f64::from(FINE);
    let share = |column: u32, row: u32| {
        let pixel = DVec2::new(column.into(), row.into());
        let holds =
            |(first, last): &(DVec2, DVec2)| (pixel + 1.0).cmpge(*first).all() && pixel.cmple(*last).all();
        if !seen.iter().any(holds) {
            return 0.0;
        }
        let rays = (0..FINE * FINE).map(|part| {
            let (right, down) = (within(column, part % FINE), within(row, part / FINE));
            (axes * DVec3::new(right - half_width, focal, half_height - down)).normalize()
        });
        rays.filter(|direction| hits(view.eye, *direction)).count() as f64 / f64::from(FINE * FINE)
    };
    (0..height)
        .flat_map(|row| (0..width).map(move |column| (column, row)))
        .map(|(x, y)| share(x, y))
        .collect()
}

/// Right, forward, up in the world.
fn axes(view: &View) -> glam::DMat3 {
    let [yaw, pitch, roll] = view.ypr.map(f64::to_radians);
    let turn = glam::DQuat::from_rotation_z(-yaw)
        * glam::DQuat::from_rotation_x(pitch)
        * glam::DQuat::from_rotation_y(roll);
    glam::DMat3::from_quat(turn)
}

/// Whether a direction lies in the cone around a sphere.
pub fn meets_sphere(eye: DVec3, direction: DVec3, centre: DVec3, radius: f64) -> bool {
    let offset = centre - eye;
    let angle = offset.angle_between(direction);
    angle < (radius / offset.length()).asin()
}

/// Whether a ray passes through a level disc.
pub fn meets_disc(eye: DVec3, direction: DVec3, centre: DVec3, radius: f64) -> bool {
    let at = (centre.z - eye.z) / direction.z;
    at > 0.0 && (eye + direction * at - centre).truncate().length() < radius
}

/// Whether a ray meets a box with these corners: a side of it where it crosses one of the six planes.
pub fn meets_box(eye: DVec3, direction: DVec3, low: DVec3, high: DVec3) -> bool {
    (0..3).any(|axis| {
        [low, high].into_iter().any(|corner| {
            let at = (corner[axis] - eye[axis]) / direction[axis];
            let point = eye + direction * at;
            let others = [(axis + 1) % 3, (axis + 2) % 3];
            at > 0.0
                && others.into_iter().all(|other| point[other] > low[other] && point[other] < high[other])
        })
    })
}

/// Mean absolute difference over the pixels in which an edge lies, and the largest of sums over rows and over columns: how far outlines lie apart,
/// pixels, for both sides together.
pub fn compare(view: &View, seen: &[f64], exact: &[f64]) -> (f64, f64) {
    let width = view.size[0] as usize;
    let edges: Vec<f64> = seen
        .iter()
        .zip(exact)
        .filter(|(_, exact)| **exact > 0.0 && **exact < 1.0)
        .map(|(seen, exact)| (seen - exact).abs())
        .collect();
    assert!(edges.len() > 50, "only {} pixels with an edge", edges.len());
    let mut sums = vec![0.0; width + view.size[1] as usize];
    for (pixel, (seen, exact)) in seen.iter().zip(exact).enumerate() {
        sums[pixel % width] += seen - exact;
        sums[width + pixel / width] += seen - exact;
    }
    let apart = sums.into_iter().map(f64::abs).fold(0.0, f64::max);
    (edges.iter().sum::<f64>() / edges.len() as f64, apart)
}
