//! Shadows of bodies: how long they are, what they fall upon, and what they must not depend on.

use glam::{DVec2, DVec3, Vec3};

use hedgehop_conic::Ball;

use super::{FARM, PLAIN, black, options};
use crate::scene::{Terrain, View};
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Shape};
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::subimage::{Farm, TaskSize};
use hedgehop::sunlight::{Daylight, Sun};

/// Under a sun that throws shadows.
fn under(engine: Engine, azimuth: f64, elevation: f64) -> RenderOptions {
    RenderOptions { sun: Sun { azimuth, elevation }, shadows: true, ..options(engine) }
}

/// Straight down from 700 m, north up; about a metre a pixel, 400 m to the east and the west.
fn map() -> View {
    View { eye: DVec3::new(500.0, 500.0, 700.0), ypr: [0.0, -90.0, 0.0], hfov: 60.0, size: [801, 81] }
}

fn see(options: &RenderOptions, view: &View, bodies: &[Body]) -> Frame {
    Renderer::new(&*PLAIN, options).frame_with(&view.camera(), bodies, &FARM).unwrap().frame
}

/// Light at a place of the plain, metres from the map's middle, against that without bodies.
fn light(found: &Frame, bare: &Frame, [east, north]: [f64; 2]) -> f32 {
    let camera = map().camera();
    let place = camera.pose.eye.with_z(0.0) + DVec3::new(east, north, 0.0);
    let position = camera.screen_from_world(place).unwrap();
    let pixel = position.y as usize * camera.width as usize + position.x as usize;
    found.colour[pixel][1] / bare.colour[pixel][1]
}

#[test]
fn a_towers_shadow_is_as_long_as_its_height_over_the_suns_tangent() {
    let tower = |size: f64| black(Shape::Box { size: DVec3::new(size, size, 30.0) }, [500.0, 500.0, 0.0]);
    let elevations = [6.0, 8.0, 10.0, 13.0, 17.0, 22.0, 30.0, 40.0, 50.0, 65.0];
    for (engine, each) in [(Engine::Planes, 1), (Engine::Reference, 4)] {
        for elevation in elevations.into_iter().step_by(each) {
            let under = under(engine, 90.0, elevation);
            let [found, bare] = [&[tower(12.0)][..], &[]].map(|bodies| see(&under, &map(), bodies));

            // Westward from the tower, whose roof ends 6 m from its middle.
            let wanted = 6.0 + 30.0 / f64::from(elevation as f32).to_radians().tan();
            let steps = (0..8000).map(|step| 7.5 + 0.05 * f64::from(step));

            // Of all light so much is the sky's, and the middle of an edge has half of the rest.
            let daylight = Daylight::new(under.sun);
            let sky = daylight.on(Vec3::Z, 0.0).y / daylight.on(Vec3::Z, 1.0).y;
            let dark = |west: &f64| light(&found, &bare, [-*west, 0.0]) < 0.5 + 0.5 * sky;
            let length = steps.filter(dark).fold(0.0, f64::max);

            // A voxel is 2 m wide.
            assert!((length - wanted).abs() < 1.2, "{engine:?} {elevation}: {length}, not {wanted}");
            let [inside, beside] = [[-20.0, 0.0], [-20.0, 9.0]].map(|place| light(&found, &bare, place));
            assert!(elevation > 50.0 || (inside - sky).abs() < 0.01, "{inside}, not {sky}");
            assert!((beside - 1.0).abs() < 0.01, "{beside}");
        }
    }
}

#[test]
fn a_balls_shadow_lies_where_its_ellipse_does() {
    let (centre, radius) = (DVec3::new(500.0, 500.0, 40.0), 9.0);
    let ball = black(Shape::Ellipsoid { radii: DVec3::splat(radius) }, centre.to_array());
    for (azimuth, elevation) in [(90.0, 25.0), (240.0, 40.0), (15.0, 60.0)] {
        let under = under(Engine::Planes, azimuth, elevation);
        let [found, bare] = [&[ball.clone()][..], &[]].map(|bodies| see(&under, &map(), bodies));
        let [azimuth, up] = [azimuth, elevation].map(f64::to_radians);
        let beam = -DVec3::new(azimuth.sin() * up.cos(), azimuth.cos() * up.cos(), up.sin());
        let ellipse = Ball { centre, radius }.shadow(beam, 0.0).unwrap();

        // Of what is missing on the ground about the ellipse, beside the ball itself.
        let (mut sum, mut all) = (DVec2::ZERO, 0.0);
        for number in 0..160 * 160 {
            let offset = DVec2::new(f64::from(number % 160), f64::from(number / 160)) * 0.5 - 39.75;
            let place = ellipse.centre.truncate() + offset - 500.0;
            if place.y.abs() < 38.0 && place.length() > 10.5 {
                let missing = 1.0 - f64::from(light(&found, &bare, place.to_array()));
                (sum, all) = (sum + offset * missing, all + missing);
            }
        }
        assert!(all > 50.0);
        // A voxel is 2 m wide.
        assert!((sum / all).length() < 1.0, "{azimuth} {elevation}: {}", sum / all);
    }
}

#[test]
fn bodies_lie_in_the_shadow_of_others_and_of_the_ground() {
    let ball = |id, up| {
        let shape = Shape::Ellipsoid { radii: DVec3::splat(8.0) };
        Body { id, albedo: Vec3::splat(0.5), ..black(shape, [500.0, 500.0, up]) }
    };
    let roof =
        Body { id: 9, ..black(Shape::Box { size: DVec3::new(60.0, 60.0, 1.0) }, [500.0, 500.0, 60.0]) };

    // From the south and a little above, where the roof hides nothing.
    let view =
        View { eye: DVec3::new(500.0, 400.0, 40.0), ypr: [0.0, -10.0, 0.0], hfov: 30.0, size: [200, 160] };
    let under = under(Engine::Planes, 180.0, 89.0);

    let brightness = |bodies: &[Body]| {
        let frame = see(&under, &view, bodies);
        let own = frame.id.iter().zip(&frame.colour).filter(|(id, _)| **id == Frame::body_id(1));
        let light: Vec<_> = own.map(|(_, colour)| colour[1]).collect();
        assert!(light.len() > 500);
        light.iter().copied().fold(0.0, f32::max)
    };

    let [free, below] = [brightness(&[ball(1, 20.0)]), brightness(&[ball(1, 20.0), roof])];
    assert!((free - 0.5).abs() < 0.03, "{free}");
    assert!((below - 0.5 * 0.35).abs() < 0.03, "{below}");
}

#[test]
fn bodies_lie_in_the_shadow_of_the_ground() {
    // A wall of 100 m; the sun behind it stands 30° high, so that its shadow reaches 173 m.
    let world =
        Terrain::new([300, 300], 2.0, |place| if place.y > 400.0 { 100.0 } else { 0.0 }, |_| [120; 3]);
    let world = world.in_memory();

    let light = |north: f64, up: f64| {
        let shape = Shape::Ellipsoid { radii: DVec3::splat(4.0) };
        let body = Body { albedo: Vec3::splat(0.5), ..black(shape, [300.0, north, up]) };

        // From above, where the sun shines upon it.
        let view = View {
            eye: DVec3::new(300.0, north, up + 60.0),
            ypr: [0.0, -90.0, 0.0],
            hfov: 20.0,
            size: [64, 64],
        };
        let under = under(Engine::Planes, 0.0, 30.0);
        let renderer = Renderer::new(&world, &under);
        let frame = renderer.frame_with(&view.camera(), &[body], &FARM).unwrap().frame;
        assert_eq!(frame.id[32 * 64 + 32], Frame::body_id(1));

        frame.colour[32 * 64 + 32][1]
    };

    // On the ground and above it, before the shadow's end and behind it.
    let found = [light(350.0, 3.0), light(200.0, 3.0), light(350.0, 30.0), light(350.0, 110.0)];
    let wanted = [0.175, 0.5, 0.175, 0.5];

    // The pixel beside the middle sees the ball 2.4° aslant.
    assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 0.03), "{found:?}");
}

#[test]
fn the_grounds_shadow_ends_across_a_body() {
    // The same wall and sun; towers of 120 m, on which the shadow ends 30° below the wall's top.
    let world =
        Terrain::new([300, 300], 2.0, |place| if place.y > 400.0 { 100.0 } else { 0.0 }, |_| [120; 3]);
    let world = world.in_memory();

    for (engine, north) in [Engine::Planes, Engine::Reference].into_iter().zip([330.0, 300.0]) {
        let renderer = Renderer::new(&world, &under(engine, 0.0, 30.0));
        let shape = Shape::Box { size: DVec3::new(40.0, 2.0, 120.0) };
        let tower = Body { albedo: Vec3::splat(0.5), ..black(shape, [300.0, north, 0.0]) };

        // From between the two, where its sunny side is.
        let view = View {
            eye: DVec3::new(300.0, north + 60.0, 60.0),
            ypr: [180.0, 0.0, 0.0],
            hfov: 90.0,
            size: [160, 160],
        };
        let frame = renderer.frame_with(&view.camera(), &[tower], &FARM).unwrap().frame;

        // A pixel in the middle is 59 m / 80 high.
        let column = |row: usize| frame.colour[row * 160 + 80][1];
        let height = |row: usize| 60.0 - (row as f64 - 79.5) * 59.0 / 80.0;
        let (bright, dark) = (column(10), column(150));
        assert!(bright > 1.8 * dark, "{engine:?}: {bright} {dark}");
        let lit = (0..160).filter(|row| column(*row) > 0.5 * (bright + dark)).max().unwrap();
        let wanted = 100.0 - (400.0 - north - 1.0) * 30.0_f64.to_radians().tan();

        // A cell of the lattice is 8 m high, and its shadow's edge may lie anywhere in it.
        assert!((height(lit) - wanted).abs() < 4.0, "{engine:?}: lit from {} m, not {wanted}", height(lit));
    }
}

#[test]
fn what_stands_above_all_ground_is_in_free_sun() {
    // Steep teeth, whose far sides lie in shadow, and a plain without any.
    let worlds = [30.0, 0.0].map(|high| {
        let teeth = |place: DVec2| high * ((0.11 * place.x).sin() * (0.13 * place.y).sin()).max(0.0);
        Terrain::new([300, 300], 2.0, teeth, |_| [120; 3])
    });
    let worlds = worlds.each_ref().map(Terrain::in_memory);
    let shape = Shape::Ellipsoid { radii: DVec3::splat(60.0) };
    let ball = Body { albedo: Vec3::splat(0.5), ..black(shape, [300.0, 300.0, 110.0]) };
    let view =
        View { eye: DVec3::new(300.0, 60.0, 130.0), ypr: [0.0, -5.0, 0.0], hfov: 50.0, size: [160, 120] };

    for (engine, elevation) in [(Engine::Planes, 30.0), (Engine::Reference, 30.0), (Engine::Planes, 12.0)] {
        let options = under(engine, 200.0, elevation);
        let [found, free] = worlds.each_ref().map(|world| {
            let renderer = Renderer::new(world, &options);
            renderer.frame_with(&view.camera(), std::slice::from_ref(&ball), &FARM).unwrap().frame
        });
        let all = found.id.iter().zip(&free.id).zip(found.colour.iter().zip(&free.colour));
        let own = all.filter(|((found, free), _)| [**found, **free] == [Frame::body_id(1); 2]);
        let apart: Vec<f32> = own.map(|(_, (found, free))| (found[1] - free[1]).abs()).collect();
        let most = apart.iter().copied().fold(0.0, f32::max);

        // At its outline it shares pixels with the ground.
        let many = apart.iter().filter(|apart| **apart > 1e-6).count();
        assert!(apart.len() > 3000 && many * 20 < apart.len(), "{engine:?} {elevation}: {many}, {most}");
    }
}

#[test]
fn neither_order_nor_tasks_nor_what_is_out_of_sight_change_a_shadow() {
    let bodies: Vec<_> = (0..40)
        .map(|id| {
            let part = |step: f64| (f64::from(id) * step).fract();
            let place = [400.0 + 200.0 * part(0.618), 300.0 + 200.0 * part(0.414), 5.0 + 30.0 * part(0.3)];
            Body { id, ..black(Shape::Cone { radius: 6.0, height: 9.0 }, place) }
        })
        .collect();

    let view =
        View { eye: DVec3::new(500.0, 200.0, 60.0), ypr: [5.0, -20.0, 9.0], hfov: 60.0, size: [251, 173] };
    let renderer = Renderer::new(&*PLAIN, &under(Engine::Planes, 140.0, 25.0));
    let picture =
        |bodies: &[Body], farm: &Farm| renderer.picture_with(&view.camera(), bodies, farm).unwrap().0.rgb;
    let first = picture(&bodies, &FARM);
    let turned: Vec<_> = bodies.iter().rev().cloned().collect();
    assert!(first == picture(&turned, &Farm::new(1).unwrap()));
    assert!(
        first == picture(&bodies, &Farm::new(3).unwrap().with_task_size(TaskSize { lines: 8, rows: 16 }))
    );

    // Behind the eye, with the sun behind it, too.
    let behind = Body { id: 50, ..black(Shape::Box { size: DVec3::splat(40.0) }, [600.0, 120.0, 60.0]) };
    let with_behind: Vec<_> = bodies.iter().cloned().chain([behind]).collect();
    assert!(first != picture(&with_behind, &FARM));
    let frame = renderer.frame_with(&view.camera(), &bodies, &FARM).unwrap().frame;
    let from_light = hedgehop::colour::srgb8_picture(&frame.colour);
    let far = from_light.iter().zip(&first).filter(|(a, b)| a.abs_diff(**b) > 3).count();
    assert!(far * 500 < first.len(), "{far} of {}", first.len());
}
