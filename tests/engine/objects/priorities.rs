//! Co-planar bodies: which of them is seen, by their priorities.

use glam::{DVec2, DVec3, Vec3};

use super::meshes::{cuboid, model};
use super::{FARM, PLAIN, black, frame, options};
use crate::scene::View;
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Form, Shape};
use hedgehop::render::{Engine, Renderer};
use hedgehop::space::Attitude;

const VIEW: View =
    View { eye: DVec3::new(505.0, 330.0, 75.0), ypr: [19.0, -38.0, 7.0], hfov: 40.0, size: [200, 160] };

const MIDDLE: DVec3 = DVec3::new(530.0, 400.0, 12.3);

/// All orders of four things.
fn permutations() -> impl Iterator<Item = [usize; 4]> {
    let all = (0..256).map(|code: usize| [code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6]);
    all.filter(|order| (0..4).all(|index| order.contains(&index)))
}

/// Four bodies with numbers 10 to 13 in one tilted plane, with these priorities, each about a place of its own.
fn coplanar(forms: [Form; 4], attitude: Attitude, priorities: [i32; 4]) -> [Body; 4] {
    let axes = attitude.world_from_body();
    let places = [[0.0, 0.0], [17.3, 6.1], [-9.7, 13.9], [8.3, -11.1]];
    let mut bodies = (0..4).map(|index| {
        let [right, forward] = places[index];
        let place = MIDDLE + axes.x_axis * right + axes.y_axis * forward;
        Body {
            id: 10 + index as u32,
            attitude,
            priority: priorities[index],
            albedo: Vec3::new(0.2 * index as f32, 0.9 - 0.2 * index as f32, 0.4),
            ..black(forms[index].clone(), place.to_array())
        }
    });
    std::array::from_fn(|_| bodies.next().unwrap())
}

fn bits(frame: &Frame) -> Vec<u32> {
    let light = frame.colour.iter().chain(&frame.normal).flatten().map(|value| value.to_bits());
    light.chain(frame.range.iter().map(|range| range.to_bits())).chain(frame.id.iter().copied()).collect()
}

/// Whether a body holds a place of its plane, `margin` metres from its rim.
fn holds(body: &Body, place: DVec3, margin: f64) -> bool {
    let own = body.attitude.world_from_body().transpose() * (place - body.position);
    match &body.form {
        Form::Shape(Shape::Ellipse { radii }) => (own.truncate() / (*radii - margin)).length() < 1.0,
        form => {
            let half = form.corners()[1].truncate() - margin;
            own.truncate().abs().cmplt(half).all()
        }
    }
}

/// Counts pixels that see the body of the highest priority that holds what they see, and those of several bodies among them.
fn check(bodies: &[Body; 4], seen: &Frame, what: &str) -> [u32; 2] {
    let camera = VIEW.camera();
    let normal = bodies[0].world_from_body().z_axis;
    let (mut right, mut several) = (0, 0);
    for (pixel, id) in (0..).zip(&seen.id) {
        let ray = camera.ray(f64::from(pixel % 200) + 0.5, f64::from(pixel / 200) + 0.5).unwrap();
        let at = normal.dot(bodies[0].position - ray.origin) / normal.dot(ray.direction);
        let place = ray.origin + ray.direction * at;
        // A body whose rim is near leaves the pixel to more than one.
        if at < 0.0 || bodies.iter().any(|body| holds(body, place, -1.5) && !holds(body, place, 1.5)) {
            continue;
        }
        let held: Vec<&Body> = bodies.iter().filter(|body| holds(body, place, 0.0)).collect();
        let Some(highest) = held.iter().max_by_key(|body| body.priority) else { continue };
        assert_eq!(*id, Frame::body_id(highest.id), "{what}: pixel {pixel} of {} bodies", held.len());
        (right, several) = (right + 1, several + u32::from(held.len() > 1));
    }
    [right, several]
}

fn check_all(forms: &[Form; 4], attitude: Attitude) {
    for engine in [Engine::Planes, Engine::Reference] {
        for priorities in [[3, 1, 2, 0], [-4, 7, 0, 900]] {
            let bodies = coplanar(forms.clone(), attitude, priorities);
            let first = frame(engine, &PLAIN, &VIEW.camera(), &bodies);
            let [right, several] = check(&bodies, &first, &format!("{engine:?}, {priorities:?}"));
            assert!(right > 1500 && several > 500, "{right} {several}");
            let mut orders = 0;
            for order in permutations() {
                let turned = order.map(|index| bodies[index].clone());
                let seen = Renderer::new(&*PLAIN, &options(engine))
                    .frame_with(&VIEW.camera(), &turned, &FARM)
                    .unwrap()
                    .frame;
                assert!(bits(&seen) == bits(&first), "{engine:?}, {order:?}");
                orders += 1;
            }
            assert_eq!(orders, 24);
        }
    }
}

#[test]
fn the_highest_of_coplanar_shapes_is_seen_in_any_order() {
    let forms = [
        Shape::disc(21.0).into(),
        Shape::Ellipse { radii: DVec2::new(24.0, 9.0) }.into(),
        Shape::disc(13.0).into(),
        Shape::Ellipse { radii: DVec2::new(8.0, 19.0) }.into(),
    ];
    check_all(&forms, Attitude { yaw: 33.0, pitch: -7.0, roll: 4.0 });
    check_all(&forms, Attitude::default());
}

#[test]
fn models_have_priorities_as_shapes_do() {
    let plate = |right: f64, forward: f64| model(cuboid(DVec3::new(right, forward, 1e-4))).into();
    let forms = [
        plate(40.0, 30.0),
        Shape::Ellipse { radii: DVec2::new(24.0, 9.0) }.into(),
        plate(14.0, 34.0),
        Shape::disc(13.0).into(),
    ];
    check_all(&forms, Attitude { yaw: 33.0, pitch: -7.0, roll: 4.0 });
}

#[test]
fn what_is_clearly_nearer_hides_any_priority() {
    let disc = |up: f64, id: u32, priority: i32| Body {
        id,
        priority,
        ..black(Shape::disc(30.0), [530.0, 400.0, up])
    };
    let camera = VIEW.camera();
    for up in [12.5, 14.0] {
        let upper = disc(up, 2, 0);
        let seen = frame(Engine::Planes, &PLAIN, &camera, &[disc(12.0, 1, 5), upper.clone()]);
        let mut count = 0;
        for (pixel, id) in (0..).zip(&seen.id) {
            let ray = camera.ray(f64::from(pixel % 200) + 0.5, f64::from(pixel / 200) + 0.5).unwrap();
            let at = (upper.position.z - ray.origin.z) / ray.direction.z;
            if holds(&upper, ray.origin + ray.direction * at, 1.0) {
                assert_eq!(*id, Frame::body_id(2), "{up}: pixel {pixel}");
                count += 1;
            }
        }
        assert!(count > 5000, "{count}");
    }
}
