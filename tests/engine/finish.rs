//! The image stage in whole frames: rays per pixel, shutter, lens, and what is made of their light.

use glam::{DVec2, DVec3, Vec3};

use crate::scene::{Terrain, View, clear_air};
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Shape};
use hedgehop::render::{Engine, Exposure, Moment, RenderOptions, Renderer};
use hedgehop::scene::{Dither, Finish, Scenery, Tone};
use hedgehop::space::{Attitude, Camera, Screen};
use hedgehop::subimage::Farm;
use hedgehop::voxel::MemPages;

const SIZE: [u32; 2] = [160, 90];

fn hills() -> MemPages {
    let height = |post: DVec2| 150.0 + 60.0 * (post.x / 300.0).sin() * (post.y / 240.0).cos();
    let colour = |post: DVec2| [90, 120 + (post.x / 50.0) as u8 % 40, 60];
    Terrain::new([256, 256], 10.0, height, colour).in_memory()
}

fn camera(ypr: [f64; 3]) -> Camera {
    View { eye: DVec3::new(1300.0, 400.0, 260.0), ypr, hfov: 60.0, size: SIZE }.camera()
}

/// A black ball before the sky, so many metres east of the way ahead.
fn ball(east: f64) -> Body {
    let position = camera([0.0; 3]).pose.eye + DVec3::new(east, 500.0, 40.0);
    Body {
        id: 0,
        form: Shape::Ellipsoid { radii: DVec3::splat(20.0) }.into(),
        position,
        attitude: Attitude::default(),
        albedo: Vec3::ZERO,
        priority: 0,
    }
}

/// A flight that turns to the right while a ball flies before it, metres and degrees a second.
fn turning(yaw: f64, speed: f64) -> impl Fn(f64) -> Moment {
    move |seconds| Moment {
        camera: camera([yaw * seconds, -5.0, 0.0]),
        scenery: Scenery { bodies: vec![ball(speed * seconds)], ..Scenery::default() },
        seconds: 1.0 + seconds,
    }
}

fn exposed(options: &RenderOptions, finish: Finish, moment: &dyn Fn(f64) -> Moment, farm: &Farm) -> Frame {
    let source = hills();
    let exposure = Exposure { finish: &finish, interval: 0.1, moment };
    Renderer::new(&source, options).exposed(&exposure, farm).unwrap().frame
}

#[test]
fn nothing_asked_for_leaves_frames_and_pictures_as_they_are() {
    let (source, farm) = (hills(), Farm::new(2).unwrap());
    let renderer = Renderer::new(&source, &clear_air());
    let moment = turning(20.0, 100.0);
    let exposure = Exposure { finish: &Finish::default(), interval: 0.1, moment: &moment };
    let own = moment(0.0);
    let frame = renderer.exposed(&exposure, &farm).unwrap().frame;
    let plain = renderer.at(1.0).frame_with(&own.camera, &own.scenery, &farm).unwrap().frame;
    assert!(frame.colour == plain.colour && frame.range == plain.range && frame.id == plain.id);
    let (developed, _) = renderer.developed(&exposure, &farm).unwrap();
    let (picture, _) = renderer.at(1.0).picture_with(&own.camera, &own.scenery, &farm).unwrap();
    let far = developed.rgb.iter().zip(&picture.rgb).map(|(one, other)| one.abs_diff(*other)).max();
    assert!(far <= Some(1), "{far:?}");
}

#[test]
fn whoever_works_makes_the_same_picture() {
    let finish = Finish {
        exposure: 0.5,
        tone: Tone::Filmic,
        gamma: Some(2.4),
        dither: Dither::Ordered,
        vignette: 0.3,
        antialias: 2,
        shutter: 180.0,
        ..Finish::default()
    };

    let source = hills();
    let moment = turning(20.0, 100.0);
    let exposure = Exposure { finish: &finish, interval: 0.1, moment: &moment };
    let pictures = [1, 3].map(|workers| {
        let farm = Farm::new(workers).unwrap();
        let renderer = Renderer::new(&source, &clear_air());
        (renderer.developed(&exposure, &farm).unwrap().0, renderer.exposed(&exposure, &farm).unwrap().frame)
    });
    assert!(pictures[0].0 == pictures[1].0);
    assert!(pictures[0].1.colour == pictures[1].1.colour && pictures[0].1.id == pictures[1].1.id);
}

#[test]
fn more_rays_keep_the_light_and_one_of_their_ranges() {
    let farm = Farm::new(2).unwrap();
    let still = turning(0.0, 0.0);
    let one = exposed(&clear_air(), Finish::default(), &still, &farm);
    let four = exposed(&clear_air(), Finish { antialias: 4, ..Finish::default() }, &still, &farm);
    let mean = |frame: &Frame| {
        frame.colour.iter().flatten().map(|light| f64::from(*light)).sum::<f64>() / frame.colour.len() as f64
    };
    assert!((mean(&four) / mean(&one) - 1.0).abs() < 5e-3, "{} {}", mean(&one), mean(&four));
    assert_eq!([four.colour.len(), four.range.len(), four.normal.len()], [160 * 90; 3]);
    let source = hills();
    let fine = Renderer::new(&source, &clear_air())
        .frame_with(&still(0.0).camera.enlarged(4), &still(0.0).scenery, &farm)
        .unwrap()
        .frame;

    for (row, column) in [(0, 0), (40, 80), (89, 159), (44, 79)] {
        let ray = (4 * row + 2) * 640 + 4 * column + 2;
        assert_eq!(four.range[row * 160 + column], fine.range[ray]);
        assert_eq!(four.id[row * 160 + column], fine.id[ray]);
    }
}

#[test]
fn a_moving_body_is_drawn_out_by_as_much_as_it_moves() {
    let farm = Farm::new(2).unwrap();
    // 10 pixels of 1.2 m at a distance of 500 m while the shutter is open: half of a tenth of a second.
    let pixel = 500.0 * camera([0.0; 3]).pixel_angle();
    let moving = turning(0.0, 10.0 * pixel / 0.05);
    let open = Finish { shutter: 180.0, ..Finish::default() };
    let [sharp, blurred] =
        [Finish::default(), open].map(|finish| exposed(&clear_air(), finish, &moving, &farm));

    let bare = exposed(
        &clear_air(),
        Finish::default(),
        &|_| Moment { scenery: Scenery::default(), ..moving(0.0) },
        &farm,
    );

    // How much the ball changes each column, and that as a share of all of it.
    let changed = |frame: &Frame| {
        let mut columns = vec![0.0_f64; 160];
        for (pixel, (light, bare)) in frame.colour.iter().zip(&bare.colour).enumerate() {
            columns[pixel % 160] += f64::from(light[0] - bare[0]);
        }
        columns
    };

    let extent = |columns: &[f64]| {
        let all: f64 = columns.iter().sum();
        let most = columns.iter().fold(0.0_f64, |most, light| most.max(light.abs()));
        let is_changed = |light: &f64| light.abs() > 1e-3 * most;
        let first = columns.iter().position(is_changed).unwrap();
        let last = columns.iter().rposition(is_changed).unwrap();
        (all, (last - first) as f64, 0.5 * (first + last) as f64)
    };

    let ((all, width, middle), (drawn, wider, later)) =
        (extent(&changed(&sharp)), extent(&changed(&blurred)));
    assert!((drawn / all - 1.0).abs() < 0.03, "light: {all} {drawn}");

    // Eleven moments are ten elevenths of the way apart.
    assert!((wider - width - 9.1).abs() <= 1.5, "width: {width} {wider}");
    assert!((middle - later).abs() <= 1.0, "the middle of the time: {middle} {later}");

    // What is no light is of the frame's own time.
    assert!(sharp.range == blurred.range && sharp.id == blurred.id);
}

#[test]
fn a_lens_sees_the_same_world_bent() {
    let (source, farm) = (hills(), Farm::new(2).unwrap());
    let plane = camera([20.0, -8.0, 6.0]);
    let screen = Screen::Lens { hfov: 60.0, k: [-0.2, 0.02] };
    let lens = Camera::with_screen(plane.pose, screen.clone(), 160, 90);

    // Round trips of positions, and corners that are filled from beyond the plane's.
    for at in [DVec2::new(0.5, 0.5), DVec2::new(80.0, 45.0), DVec2::new(159.5, 3.0)] {
        let ray = lens.ray(at.x, at.y).unwrap();
        let back = lens.screen_from_world(ray.origin + ray.direction * 700.0).unwrap();
        assert!((back - at).length() < 1e-9, "{at} {back}");
    }

    let corner = lens.ray(0.0, 0.0).unwrap();
    assert!(plane.screen_from_world(corner.origin + corner.direction).unwrap().x < -3.0);
    assert_eq!(screen.to_string(), "lens hfov_deg=60 k1=-0.2 k2=0.02");

    // Both engines see it alike, and depth is along the axis.
    let frame = |engine| {
        let options = RenderOptions { engine, ..clear_air() };
        Renderer::new(&source, &options).frame(&lens, &farm).unwrap().frame
    };
    let (planes, exact) = (frame(Engine::Planes), frame(Engine::Reference));
    let far =
        |(one, other): (&f32, &f32)| one.is_finite() != other.is_finite() || (one / other - 1.0).abs() > 0.02;
    let wrong = planes.range.iter().zip(&exact.range).filter(|pair| far(*pair)).count();
    assert!(wrong < 160 * 90 / 50, "{wrong} ranges differ");
}

#[test]
fn what_is_out_of_range_is_refused() {
    let (source, farm) = (hills(), Farm::new(1).unwrap());
    let still = turning(0.0, 0.0);
    for (finish, part) in [
        (Finish { antialias: 3, ..Finish::default() }, "--antialias"),
        (Finish { shutter: -1.0, ..Finish::default() }, "--shutter"),
        (Finish { exposure: f64::NAN, ..Finish::default() }, "--exposure"),
    ] {
        let exposure = Exposure { finish: &finish, interval: 0.1, moment: &still };
        let said = Renderer::new(&source, &clear_air()).developed(&exposure, &farm).unwrap_err().to_string();
        assert!(said.contains(part), "{said}");
    }

    let huge = |_: f64| Moment {
        camera: Camera::new(camera([0.0; 3]).pose, 1 << 20, 1 << 10),
        scenery: Scenery::default(),
        seconds: 0.0,
    };
    let finish = Finish { antialias: 4, ..Finish::default() };
    let exposure = Exposure { finish: &finish, interval: 0.1, moment: &huge };
    let said = Renderer::new(&source, &clear_air()).exposed(&exposure, &farm).unwrap_err().to_string();
    assert!(said.contains("too large for 4 × 4 rays"), "{said}");
}
