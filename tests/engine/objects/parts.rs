//! Parts that move on objects, in whole frames: what turns, blurs and is moved on the screen as it should be.

use std::fs;

use glam::{DMat3, DVec3};

use super::*;
use hedgehop::earth::Curvature;
use hedgehop::frame::{MotionStep, motion};
use hedgehop::geo::Crs;
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Exposure, Moment};
use hedgehop::scene::{Cast, Finish, Scene};
use hedgehop::sunlight::Sun;

const HELICOPTER: &str = r##"
[[object]]
name = "heli"
shape = "ellipsoid"
radii_m = [1, 3, 1.2]
at = [500500, 4000420, 12]
yaw_deg = 60
colour = "#405060"

[[object.part]]
name = "blades"
shape = "box"
size_m = [12, 0.5, 0.1]
offset_m = [0, 0, 1.6]
turn_rpm = 120

[[object.part]]
name = "tail"
shape = "box"
size_m = [0.3, 7, 0.4]
offset_m = [0, -5, 0.4]

[[object.part]]
name = "tail rotor"
parent = "tail"
shape = "box"
size_m = [0.1, 2.4, 0.3]
offset_m = [0.3, -3.3, 0.2]
axis = [1, 0, 0]
turn_rpm = 240
"##;

fn cast(text: &str, world: &MemPages) -> Cast {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let ground = |place: DVec2| ground_height(world, place).unwrap();
    Scene::read(&path).unwrap().bind(&Crs::local(), &ground).unwrap()
}

const VIEW: View =
    View { eye: DVec3::new(500.0, 385.0, 14.0), ypr: [3.0, -2.0, 0.0], hfov: 40.0, size: [320, 180] };

#[test]
fn a_whole_turn_leaves_the_picture_as_it_was() {
    let cast = cast(HELICOPTER, &PLAIN);
    let options = RenderOptions {
        shadows: true,
        sun: Sun { azimuth: 200.0, elevation: 50.0 },
        ..options(Engine::Planes)
    };
    let renderer = Renderer::new(&*PLAIN, &options);
    let picture = |seconds: f64| renderer.picture_with(&VIEW.camera(), &cast.at(seconds), &FARM).unwrap().0;
    for seconds in [0.0, 0.04, 0.28] {
        // One round of the blades, two of the tail rotor.
        assert!(picture(seconds) == picture(seconds + 0.5), "{seconds}");
    }
    assert!(picture(0.0) != picture(0.125));
}

#[test]
fn engines_and_workers_see_parts_alike() {
    let cast = cast(HELICOPTER, &PLAIN);
    let bodies = cast.bodies_at(0.3);
    assert_eq!(bodies.len(), 4);
    let [planes, exact] =
        [Engine::Planes, Engine::Reference].map(|engine| frame(engine, &PLAIN, &VIEW.camera(), &bodies));

    for body in &bodies {
        let of = |frame: &Frame| frame.id.iter().filter(|id| **id == Frame::body_id(body.id)).count();
        assert!(
            of(&planes) > 20 && of(&planes).abs_diff(of(&exact)) <= 2,
            "{}: {} {}",
            body.id,
            of(&planes),
            of(&exact)
        );
    }

    let one = Farm::new(1).unwrap();
    let alone = Renderer::new(&*PLAIN, &options(Engine::Planes))
        .frame_with(&VIEW.camera(), &bodies, &one)
        .unwrap()
        .frame;
    assert!(alone.colour == planes.colour && alone.id == planes.id);
}

#[test]
fn a_rotor_moves_on_the_screen_as_it_turns() {
    // It looks at the eye: the axis is that to the front.
    let text = r#"
[[object]]
name = "mill"
shape = "sphere"
radius_m = 0.5
at = [500500, 4000400, 20]
yaw_deg = 180
[[object.part]]
name = "wheel"
shape = "box"
size_m = [8, 1, 8]
offset_m = [0, 1, -4]
[[object.part]]
name = "sail"
shape = "box"
size_m = [8, 0.5, 2]
offset_m = [0, 3, 0]
axis = [0, 1, 0]
turn_rpm = 60
"#;

    let cast = cast(text, &PLAIN);
    let view = View { eye: DVec3::new(500.0, 370.0, 20.0), ypr: [0.0; 3], hfov: 40.0, size: [160, 90] };
    let camera = view.camera();
    let [now, then] = [0.0, 0.04].map(|seconds| cast.bodies_at(seconds));
    let seen = frame(Engine::Planes, &PLAIN, &camera, &now);
    let step =
        MotionStep { camera: &camera, bodies: [&now, &then], curvature: Curvature::FLAT, is_backward: false };
    let vectors = motion(&seen, &step, &FARM).unwrap();
    let (sail, pivot) = (&now[1], DVec3::new(500.0, 397.0, 20.0) + PLAIN_ORIGIN.extend(0.0));

    // Clockwise as seen from the tip of its axis, which is where the eye is.
    let turn = DMat3::from_axis_angle(DVec3::Y, 0.04 * std::f64::consts::TAU);
    let mut count = 0;
    for (pixel, vector) in
        vectors.iter().enumerate().filter(|(pixel, _)| seen.id[*pixel] == Frame::body_id(sail.id))
    {
        let place = DVec2::new((pixel % 160) as f64 + 0.5, (pixel / 160) as f64 + 0.5);
        let ray = camera.ray(place.x, place.y).unwrap();
        let point = ray.origin + ray.direction * f64::from(seen.range[pixel]);
        let expected = camera.screen_from_world(pivot + turn * (point - pivot)).unwrap() - place;
        let found = DVec2::new(f64::from(vector[0]), -f64::from(vector[1]));
        assert!((found - expected).length() < 0.02, "{place}: {found} {expected}");
        // Its right end goes down.
        assert!(place.x < 90.0 || place.y > 60.0 || found.y > 0.0, "{place}: {found}");
        count += 1;
    }

    assert!(count > 300, "{count}");
}

#[test]
fn a_rotor_is_blurred_though_its_middle_stands_still() {
    let cast = cast(HELICOPTER, &PLAIN);
    let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes));
    let camera = VIEW.camera();
    let moment = |seconds: f64| Moment { camera: camera.clone(), scenery: cast.at(1.0 + seconds), seconds };
    let exposed = |shutter: f64| {
        let finish = Finish { shutter, ..Finish::default() };
        renderer.exposed(&Exposure { finish: &finish, interval: 0.1, moment: &moment }, &FARM).unwrap().frame
    };
    let bare = frame(Engine::Planes, &PLAIN, &camera, &[]);

    // Pixels in which something is seen, and how much all of it changes.
    let changed = |frame: &Frame| {
        let change = frame.colour.iter().zip(&bare.colour).map(|(light, bare)| f64::from(light[1] - bare[1]));
        let change: Vec<f64> = change.collect();
        (change.iter().filter(|change| change.abs() > 1e-3).count(), change.iter().sum::<f64>())
    };
    let [sharp, open, still] = [exposed(0.0), exposed(180.0), exposed(1e-4)].map(|frame| changed(&frame));

    // The blades sweep 36 degrees.
    assert!(open.0 as f64 > 1.1 * sharp.0 as f64, "{sharp:?} {open:?}");
    assert!((open.1 / sharp.1 - 1.0).abs() < 0.25, "{sharp:?} {open:?}");
    assert!(still.0.abs_diff(sharp.0) < 5, "{sharp:?} {still:?}");
}
