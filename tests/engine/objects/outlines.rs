//! Silhouettes, ranges, and curves in which bodies enter the ground.

use glam::{DVec2, DVec3};

use super::exact::{compare, meets_box, meets_disc, meets_sphere, shares as exact_shares};
use super::{PLAIN, black, frame, shares};
use crate::scene::{Terrain, View};
use hedgehop::objects::Shape;
use hedgehop::render::Engine;

const ENGINES: [Engine; 2] = [Engine::Planes, Engine::Reference];

/// Banked and pitched, over the plain.
const VIEW: View =
    View { eye: DVec3::new(500.0, 200.0, 60.0), ypr: [8.0, -9.0, 20.0], hfov: 40.0, size: [200, 160] };

const SPHERE: ([f64; 3], f64) = ([530.0, 400.0, 35.0], 20.0);
const DISC: ([f64; 3], f64) = ([530.0, 400.0, 12.0], 40.0);
const BOX: ([f64; 3], [f64; 3]) = ([530.0, 400.0, 0.01], [30.0, 24.0, 45.0]);

/// Corners of the cube about a sphere.
fn cube((centre, radius): (DVec3, f64)) -> [DVec3; 2] {
    [centre - radius, centre + radius]
}

/// Holds outlines against what other formulae say that rays hit, within the box of two corners.
fn check_outline(shape: Shape, place: [f64; 3], corners: [DVec3; 2], hits: impl Fn(DVec3, DVec3) -> bool) {
    let exact = exact_shares(&VIEW, &[corners], hits);
    for engine in ENGINES {
        let seen = shares(engine, &PLAIN, &VIEW, &[black(shape, place)]);
        let (mean, apart) = compare(&VIEW, &seen, &exact);
        assert!(mean <= 1.0 / 128.0, "{shape:?}, {engine:?}: the mean error of shares is {mean}");
        assert!(apart <= 0.1, "{shape:?}, {engine:?}: outlines are {apart} px apart");
    }
}

#[test]
fn spheres_have_round_outlines() {
    let sphere = Shape::Ellipsoid { radii: DVec3::splat(SPHERE.1) };
    let (centre, radius) = (DVec3::from(SPHERE.0), SPHERE.1);
    check_outline(sphere, SPHERE.0, cube((centre, radius)), |eye, direction| {
        meets_sphere(eye, direction, centre, radius)
    });
}

#[test]
fn discs_have_elliptic_outlines() {
    let disc = Shape::disc(DISC.1);
    let (centre, radius) = (DVec3::from(DISC.0), DISC.1);
    check_outline(disc, DISC.0, cube((centre, radius)), |eye, direction| {
        meets_disc(eye, direction, centre, radius)
    });
}

#[test]
fn boxes_have_straight_outlines() {
    let (place, size) = (DVec3::from(BOX.0), DVec3::from(BOX.1));
    let low = place - size.with_z(0.0) / 2.0;
    let high = low + size;
    check_outline(Shape::Box { size }, BOX.0, [low, high], |eye, direction| {
        meets_box(eye, direction, low, high)
    });
}

#[test]
fn small_and_thin_bodies_keep_their_area() {
    // Both less than a pixel across, and between the corners and the middles of pixels.
    let view =
        View { eye: DVec3::new(500.0, 100.0, 40.0), ypr: [0.0, 0.0, 0.0], hfov: 30.0, size: [160, 120] };
    let ball = (DVec3::new(510.3, 400.0, 60.34), 0.3);
    let wire = (DVec3::new(470.0, 350.0, 45.1), DVec3::new(60.0, 0.5, 0.25));
    let low = wire.0 - wire.1.with_z(0.0) / 2.0;
    let high = low + wire.1;
    let exact = exact_shares(&view, &[cube(ball), [low, high]], |eye, direction| {
        meets_sphere(eye, direction, ball.0, ball.1) || meets_box(eye, direction, low, high)
    });
    let sphere = black(Shape::Ellipsoid { radii: DVec3::splat(ball.1) }, ball.0.to_array());
    let beam = hedgehop::objects::Body { id: 2, ..black(Shape::Box { size: wire.1 }, wire.0.to_array()) };
    let seen = shares(Engine::Planes, &PLAIN, &view, &[sphere, beam]);
    let [seen, exact] = [seen, exact].map(|shares| shares.iter().sum::<f64>());
    // The wire is 0.3 pixels high, which 26 or 27 of 89 rows of rays tell.
    assert!((seen / exact - 1.0).abs() < 0.04, "{seen} pixels instead of {exact}");
}

#[test]
fn ranges_are_exact() {
    let bodies = [
        (Shape::Ellipsoid { radii: DVec3::splat(SPHERE.1) }, SPHERE.0),
        (Shape::disc(DISC.1), DISC.0),
        (Shape::Ellipse { radii: DVec2::new(25.0, 40.0) }, DISC.0),
        (Shape::Box { size: BOX.1.into() }, BOX.0),
        (Shape::Cylinder { radius: 15.0, height: 50.0 }, BOX.0),
        (Shape::Cone { radius: 25.0, height: 50.0 }, BOX.0),
        (Shape::Ellipsoid { radii: DVec3::new(30.0, 10.0, 15.0) }, SPHERE.0),
    ];

    let camera = VIEW.camera();
    for (shape, place) in bodies {
        let frame = frame(Engine::Planes, &PLAIN, &camera, &[black(shape, place)]);
        let (mut count, mut misses) = (0, 0);
        for pixel in
            (0..frame.id.len()).filter(|pixel| frame.id[*pixel] == hedgehop::frame::Frame::body_id(1))
        {
            let (column, row) = (pixel % 200, pixel / 200);
            let ray = camera.ray(column as f64 + 0.5, row as f64 + 0.5).unwrap();
            let range = f64::from(frame.range[pixel]);
            let on = |range: f64| {
                let point = ray.origin + ray.direction * range - super::PLAIN_ORIGIN.extend(0.0);
                depth(&shape, point - DVec3::from(place))
            };

            // At outlines, and at the ground, the middle's ray may miss what most of the pixel sees.
            let is_at_ground = (ray.origin.z + ray.direction.z * range).abs() < 0.1;
            if is_at_ground || (0..200).all(|step| on(range * (0.99 + 1e-4 * f64::from(step))) < 0.0) {
                misses += 1;
                continue;
            }

            let (before, behind) = (on(range * (1.0 - 1e-4)), on(range * (1.0 + 1e-4)));
            assert!(
                before <= 0.0 && behind >= 0.0,
                "{shape:?} at {column}, {row}: {before} and {behind} m deep"
            );
            count += 1;
        }

        assert!(count > 200 && misses < 20, "{shape:?}: {count} pixels, {misses} missed");
    }
}

/// How far a point lies inside, metres or a share; negative outside.
fn depth(shape: &Shape, point: DVec3) -> f64 {
    let flat = point.truncate().length();
    match *shape {
        Shape::Ellipsoid { radii } => 1.0 - (point / radii).length(),
        Shape::Box { size } => (0.5 * size - (point - DVec3::Z * 0.5 * size.z).abs()).min_element(),
        Shape::Cylinder { radius, height } => (radius - flat).min(point.z).min(height - point.z),
        Shape::Cone { radius, height } => (radius * (1.0 - point.z / height) - flat).min(point.z),
        // Behind its plane counts as inside.
        Shape::Ellipse { radii } => {
            if (point.truncate() / radii).length() <= 1.0 {
                -point.z
            } else {
                f64::NEG_INFINITY
            }
        }
    }
}

#[test]
fn bodies_enter_slopes_along_the_right_curve() {
    // A ball half sunk into a slope that rises to the north-east.
    let rise = DVec2::new(0.15, 0.25);
    let ground = move |place: DVec2| place.dot(rise);
    let slope = Terrain::new([500, 500], 2.0, ground, |_| [120; 3]).in_memory();
    let centre = DVec2::new(530.0, 400.0);
    let place = centre.extend(ground(centre));
    let radius = 25.0;
    let view = View { eye: DVec3::new(500.0, 200.0, 290.0), ypr: [8.0, -28.0, 12.0], ..VIEW };

    let exact = exact_shares(&view, &[cube((place, radius))], |eye, direction| {
        let offset = eye - place;
        let along = offset.dot(direction);
        let discriminant = along * along - offset.length_squared() + radius * radius;
        let ball = -along - discriminant.max(0.0).sqrt();
        let flat = (eye.truncate().dot(rise) - eye.z) / (direction.z - direction.truncate().dot(rise));
        discriminant > 0.0 && (flat < 0.0 || ball < flat)
    });

    let body = black(Shape::Ellipsoid { radii: DVec3::splat(radius) }, place.to_array());
    for engine in ENGINES {
        let seen = shares(engine, &slope, &view, std::slice::from_ref(&body));
        let (mean, apart) = compare(&view, &seen, &exact);
        assert!(apart <= 0.5, "{engine:?}: {apart} px apart");
        assert!(mean < 0.05, "{engine:?}: {mean}");
    }
}
