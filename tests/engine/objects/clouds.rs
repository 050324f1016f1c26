//! Clouds made of spheres that intersect, and a prism: which hides which.
//!
//! After Bunker and Ferris, AFHRL-TR-77-66 (1977), §2.5: a prism hides the cloud from below, the cloud hides the ground from above.

use glam::DVec3;

use super::{PLAIN, black, frame};
use crate::scene::View;
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Shape};
use hedgehop::render::Engine;

/// Middles and radii of the cloud's spheres, metres.
const CLOUD: [(DVec3, f64); 5] = [
    (DVec3::new(500.0, 400.0, 120.0), 22.0),
    (DVec3::new(522.0, 405.0, 118.0), 18.0),
    (DVec3::new(478.0, 398.0, 119.0), 17.0),
    (DVec3::new(505.0, 425.0, 121.0), 20.0),
    (DVec3::new(508.0, 382.0, 117.0), 15.0),
];

const PRISM: [DVec3; 2] = [DVec3::new(490.0, 318.0, 0.0), DVec3::new(514.0, 332.0, 90.0)];

/// Surface that a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Met {
    Nothing,
    Ground,
    Prism,
    Cloud(usize),
}

/// Ranges of all that a ray meets.
fn meetings(eye: DVec3, direction: DVec3) -> Vec<(f64, Met)> {
    let mut all = Vec::new();
    if direction.z < 0.0 {
        all.push((eye.z / -direction.z, Met::Ground));
    }
    let ends = PRISM.map(|corner| (corner - eye) / direction);
    let (enter, leave) = (ends[0].min(ends[1]).max_element(), ends[0].max(ends[1]).min_element());
    if enter < leave && enter > 0.0 {
        all.push((enter, Met::Prism));
    }
    for (index, (centre, radius)) in CLOUD.into_iter().enumerate() {
        let middle = (centre - eye).dot(direction);
        let square = radius * radius - (centre - eye - direction * middle).length_squared();
        if square > 0.0 && middle > 0.0 {
            all.push((middle - square.sqrt(), Met::Cloud(index)));
        }
    }
    all
}

fn bodies() -> Vec<Body> {
    let size = PRISM[1] - PRISM[0];
    let foot = (PRISM[0] + PRISM[1]).truncate() * 0.5;
    let prism = Body { id: 1, ..black(Shape::Box { size }, foot.extend(0.0).to_array()) };
    let spheres = CLOUD.into_iter().enumerate().map(|(index, (centre, radius))| Body {
        id: 10 + index as u32,
        ..black(Shape::Ellipsoid { radii: DVec3::splat(radius) }, centre.to_array())
    });
    std::iter::once(prism).chain(spheres).collect()
}

/// Looks at all, and counts pixels where a kind hides another.
fn hidden(view: &View, hides: impl Fn(Met) -> bool, is_hidden: impl Fn(Met) -> bool) -> u32 {
    let camera = view.camera();
    let corner = super::PLAIN_ORIGIN.extend(0.0);
    let mut hidden = 0;
    for engine in [Engine::Planes, Engine::Reference] {
        let seen = frame(engine, &PLAIN, &camera, &bodies());
        // Clouds do not depend on the order of spheres.
        let turned: Vec<_> = bodies().into_iter().rev().collect();
        assert_eq!(frame(engine, &PLAIN, &camera, &turned).id, seen.id, "{engine:?}");

        for (pixel, id) in (0..).zip(&seen.id) {
            let (column, row) = (pixel % view.size[0], pixel / view.size[0]);
            let met =
                [[0.5, 0.5], [-0.2, -0.2], [1.2, -0.2], [-0.2, 1.2], [1.2, 1.2]].map(|[right, down]| {
                    let ray = camera.ray(f64::from(column) + right, f64::from(row) + down).unwrap();
                    let mut all = meetings(ray.origin - corner, ray.direction.normalize());
                    all.sort_by(|a, b| a.0.total_cmp(&b.0));
                    all.into_iter().map(|(_, met)| met).collect::<Vec<_>>()
                });
            let first = |all: &Vec<Met>| all.first().copied().unwrap_or(Met::Nothing);
            let nearest = first(&met[0]);
            // Silhouettes and where spheres intersect belong to more than one.
            if met.iter().any(|all| first(all) != nearest) {
                continue;
            }
            let own = match nearest {
                Met::Prism => Some(1),
                Met::Cloud(index) => Some(10 + index as u32),
                Met::Nothing | Met::Ground => None,
            };
            let is_body = bodies().iter().any(|body| Frame::body_id(body.id) == *id);
            let is_right = own.map_or(!is_body, |own| Frame::body_id(own) == *id);
            assert!(is_right, "{engine:?}: pixel {pixel} shows {id}, not {nearest:?}");
            hidden += u32::from(hides(nearest) && met[0].iter().any(|met| is_hidden(*met)));
        }
    }
    hidden
}

fn is_cloud(met: Met) -> bool {
    matches!(met, Met::Cloud(_))
}

#[test]
fn from_below_a_prism_hides_the_cloud() {
    let view =
        View { eye: DVec3::new(500.0, 260.0, 4.0), ypr: [1.0, 38.0, 0.0], hfov: 60.0, size: [120, 96] };
    let count = hidden(&view, |met| met == Met::Prism, is_cloud);
    assert!(count > 200, "{count}");
}

#[test]
fn from_above_the_cloud_hides_prism_and_ground() {
    let view =
        View { eye: DVec3::new(500.0, 560.0, 330.0), ypr: [180.0, -52.0, 0.0], hfov: 60.0, size: [120, 96] };
    let ground = hidden(&view, is_cloud, |met| met == Met::Ground);
    assert!(ground > 500, "{ground}");
    let low = View { eye: DVec3::new(500.0, 560.0, 230.0), ypr: [180.0, -32.0, 0.0], ..view };
    let prism = hidden(&low, is_cloud, |met| met == Met::Prism);
    assert!(prism > 50, "{prism}");
}
