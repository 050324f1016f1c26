//! Heights from shadows, end to end and in parts.

mod acceptance;
mod refusals;
mod rows;
mod stated;
mod synthetic;

use glam::{DVec2, dvec2};

use super::super::warp::RasterPlacement;
use super::patch::PlacedRaster;
use super::sunward::Sunward;
use hedgehop::Size;
use hedgehop_geo::{Crs, Transform};
use synthetic::{Prism, Random, World, hills};

/// Elevation as files have it: posts of 5 m, straight between.
fn dem(place: DVec2) -> Option<f64> {
    const POSTS: f64 = 5.0;
    let first = (place / POSTS).floor();
    let share = place / POSTS - first;
    let post = |x: f64, y: f64| hills((first + dvec2(x, y)) * POSTS);
    let row = |y: f64| post(0.0, y) + share.x * (post(1.0, y) - post(0.0, y));
    Some(row(0.0) + share.y * (row(1.0) - row(0.0)))
}

/// The lowest of a ground along a ring.
fn foot(ring: &[DVec2], ground: impl Fn(DVec2) -> f64) -> f64 {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let places = edges.flat_map(|(a, b)| (0..50).map(|part| a.lerp(*b, f64::from(part) / 50.0)));
    places.map(ground).fold(f64::INFINITY, f64::min)
}

/// A rectangle or an L at any angle, 10 to 50 m long.
fn ring(random: &mut Random, middle: DVec2) -> Vec<DVec2> {
    let turn = DVec2::from_angle(random.between(0.0, std::f64::consts::TAU));
    let (a, b) = (random.between(6.0, 25.0), random.between(5.0, 15.0));
    let corners = if random.share() < 0.5 {
        vec![dvec2(-a, -b), dvec2(a, -b), dvec2(a, b), dvec2(-a, b)]
    } else {
        let (p, q) = (a * random.between(-0.3, 0.3), b * random.between(-0.3, 0.3));
        vec![dvec2(-a, -b), dvec2(a, -b), dvec2(a, q), dvec2(p, q), dvec2(p, b), dvec2(-a, b)]
    };
    corners.into_iter().map(|corner| middle + turn.rotate(corner)).collect()
}

/// A world of 1000 m by 1000 m with one prism under a sun.
fn world(prisms: Vec<Prism>, (azimuth, elevation): (f64, f64), seed: u64) -> World {
    World {
        prisms,
        azimuth,
        elevation,
        side: 1.0,
        size: Size { width: 1000, height: 1000 },
        seed,
        texture: 0.35,
        direct: 0.8,
    }
}

/// The world's picture where it lies.
fn placed(world: World) -> PlacedRaster<[u8; 4]> {
    let (side, size) = (world.side, world.size);
    let same = Transform::new(&Crs::local(), &Crs::local()).unwrap();
    let geo = [0.0, side, 0.0, f64::from(size.height) * side, 0.0, -side];
    PlacedRaster { placement: RasterPlacement::new(same, &geo, size).unwrap(), samples: Box::new(world) }
}

fn turned(ring: &[DVec2], sun: &Sunward) -> Vec<DVec2> {
    ring.iter().map(|place| sun.turned(*place)).collect()
}
