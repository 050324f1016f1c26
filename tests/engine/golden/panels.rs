//! The ten views that golden pictures are of.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use hedgehop::earth::Curvature;
use hedgehop::objects::{
    Beam, Below, Body, Fixture, Form, Material, Mesh, MeshPart, Model, PointLight, Shape,
};
use hedgehop::render::RenderOptions;
use hedgehop::scene::Scenery;
use hedgehop::space::{Attitude, Camera, Screen};
use hedgehop::sunlight::{Firmament, Night, Sun};
use hedgehop::weather::{Clouds, Fog, GroundCover, Precipitation, PrecipitationKind, Puff, Weather};

use super::noise::chance;
use super::worlds::{
    AIRFIELD, AIRFIELD_WORLD, CORRIDOR, GoldenWorld, MOUNTAINS, RUNWAY_EAST, RUNWAY_HALF, RUNWAY_NORTH,
    VILLAGE,
};
use crate::scene::{ORIGIN, View};

/// Width and height of a golden picture on a planar screen, pixels.
const SIZE: [u32; 2] = [240, 135];

/// A view of a world, and all that decides its picture.
pub struct Panel {
    /// Ground and what stands on it.
    pub world: &'static GoldenWorld,
    /// Eye and screen.
    pub camera: Camera,
    /// Light, air and weather.
    pub options: RenderOptions,
    /// Bodies, lamps and smoke.
    pub scenery: Scenery,
    /// Seconds since the flight's first fix.
    pub seconds: f64,
    /// Velocity of the eye, metres per second (x east, y north, z up).
    pub velocity: DVec3,
}

impl Panel {
    /// A view from an eye (metres from the world's south-west corner) with yaw, pitch and roll in degrees.
    fn new(
        world: &'static GoldenWorld,
        eye: [f64; 3],
        ypr: [f64; 3],
        hfov: f64,
        options: RenderOptions,
    ) -> Self {
        let view = View { eye: eye.into(), ypr, hfov, size: SIZE };
        Self {
            world,
            camera: view.camera(),
            options,
            scenery: Scenery::default(),
            seconds: 0.0,
            velocity: DVec3::ZERO,
        }
    }
}

/// A day with shadows under a sun in that direction, degrees.
fn day(azimuth: f64, elevation: f64, visibility: f64) -> RenderOptions {
    RenderOptions {
        sun: Sun { azimuth, elevation },
        shadows: true,
        visibility,
        weather: Weather { glow: 0.6, ..Weather::default() },
        ..RenderOptions::default()
    }
}

/// Up a valley in the evening, over a curved Earth: ridge behind ridge in haze, shadows of ground, a lake, several levels.
pub fn ridges() -> Panel {
    let options = RenderOptions { curvature: Curvature::standard(), ..day(265.0, 17.0, 35_000.0) };
    Panel::new(&MOUNTAINS, [5100.0, 900.0, 760.0], [4.0, -7.0, 0.0], 70.0, options)
}

/// Low over a street: walls, gables, crowns, a wire, a bridge that is seen through, all with shadows.
pub fn village() -> Panel {
    Panel::new(&VILLAGE, [434.0, 580.0, 10.0], [67.0, -4.0, 0.0], 72.0, day(245.0, 32.0, 6000.0))
}

/// The village straight from above, turned: roofs, shadows, and planes about the nadir.
pub fn down() -> Panel {
    Panel::new(&VILLAGE, [505.0, 520.0, 260.0], [25.0, -90.0, 0.0], 55.0, day(130.0, 40.0, 20_000.0))
}

/// Fog in a valley before sunrise's glow, peaks above it.
pub fn fog() -> Panel {
    let fog = Fog { top: 430.0, visibility: 500.0, soft: 110.0 };
    let weather = Weather { glow: 1.0, fog: Some(fog), ..Weather::default() };
    let options = RenderOptions { weather, ..day(28.0, 7.0, 18_000.0) };
    Panel::new(&MOUNTAINS, [5500.0, 2300.0, 560.0], [18.0, 2.0, 0.0], 65.0, options)
}

/// A steep turn under broken clouds: the horizon aslant, clouds before the sky and peaks, their shadows on the ground.
pub fn banked() -> Panel {
    let clouds = Clouds {
        base: 1350.0,
        top: 1900.0,
        coverage: 0.45,
        visibility: 160.0,
        scale: 1700.0,
        seed: 4,
        wind: [8.0, 3.0],
    };
    let weather = Weather { glow: 0.6, clouds: Some(clouds), ..Weather::default() };
    let options = RenderOptions { weather, ..day(150.0, 42.0, 30_000.0) };
    let panel = Panel::new(&MOUNTAINS, [4800.0, 800.0, 980.0], [12.0, -4.0, 52.0], 75.0, options);
    Panel { seconds: 40.0, ..panel }
}

/// Snow that falls and lies, from a moving eye.
pub fn snow() -> Panel {
    let weather = Weather {
        precipitation: Some(Precipitation { kind: PrecipitationKind::Snow, rate: 1.3, wind: [4.0, -2.0] }),
        ground: GroundCover { wet: 0.2, snow: 0.75 },
        ..Weather::default()
    };
    let options = RenderOptions { weather, ..day(160.0, 24.0, 20_000.0) };
    let panel = Panel::new(&VILLAGE, [515.0, 330.0, 24.0], [0.0, -7.0, 3.0], 66.0, options);
    Panel { velocity: DVec3::new(3.0, 25.0, 0.0), seconds: 7.0, ..panel }
}

/// A dome of 200° that looks down a slope: the horizon all around, seen by planes of every direction.
pub fn fisheye() -> Panel {
    let panel = Panel::new(
        &MOUNTAINS,
        [4700.0, 4300.0, 1150.0],
        [30.0, -38.0, 0.0],
        60.0,
        day(220.0, 28.0, 25_000.0),
    );
    let camera = Camera::with_screen(panel.camera.pose, Screen::Fisheye { fov: 200.0 }, 180, 180);
    Panel { camera, ..panel }
}

/// Coarse ground west of a corridor of fine ground, and voids in it: the sky begins at their edges.
pub fn corridor() -> Panel {
    Panel::new(&CORRIDOR, [2560.0, 500.0, 950.0], [0.0, -17.0, 0.0], 70.0, day(250.0, 35.0, 25_000.0))
}

/// A place on the airfield, metres from its corner, in the world.
fn airfield(east: f64, north: f64, up: f64) -> DVec3 {
    ORIGIN.extend(AIRFIELD) + DVec3::new(east, north, up)
}

fn body(form: impl Into<Form>, position: DVec3, yaw: f64, albedo: [f32; 3]) -> Body {
    let attitude = Attitude { yaw, ..Attitude::default() };
    Body { id: 0, form: form.into(), position, attitude, albedo: Vec3::from(albedo), priority: 0 }
}

fn cuboid(size: [f64; 3]) -> Shape {
    Shape::Box { size: size.into() }
}

/// A hangar with a gabled roof as a model of triangles.
fn hangar() -> Arc<Model> {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(16.0 * x, 14.0 * y, z);
    let ends = [-1.0, 1.0].map(|y| {
        [
            corner(-1.0, y, 0.0),
            corner(1.0, y, 0.0),
            corner(1.0, y, 8.0),
            corner(0.0, y, 13.0),
            corner(-1.0, y, 8.0),
        ]
    });
    let walls = (0..5).filter(|at| *at != 0).flat_map(|at| {
        let next = (at + 1) % 5;
        [[at, at + 5, next + 5], [at, next + 5, next]]
    });
    let gables = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [5, 7, 6], [5, 8, 7], [5, 9, 8]];
    let part = MeshPart {
        positions: ends.into_iter().flatten().collect(),
        normals: Vec::new(),
        places: Vec::new(),
        colours: Vec::new(),
        triangles: walls.chain(gables).collect(),
        material: Material::of(None),
    };
    Arc::new(Model::new(Arc::new(Mesh::new(vec![part]).unwrap()), []))
}

/// An aircraft of simple shapes, its nose to `yaw`.
fn aircraft(position: DVec3, yaw: f64, paint: [f32; 3]) -> Vec<Body> {
    let turn = Attitude { yaw, ..Attitude::default() }.world_from_view();
    let at = |ahead: f64, up: f64| position + turn.z_axis * ahead + DVec3::Z * up;
    let white = [0.75, 0.75, 0.76];
    vec![
        body(Shape::Ellipsoid { radii: DVec3::new(2.0, 15.0, 2.1) }, at(0.0, 3.2), yaw, white),
        body(cuboid([30.0, 4.0, 0.5]), at(1.0, 2.6), yaw, white),
        body(cuboid([11.0, 2.4, 0.4]), at(-12.5, 3.8), yaw, white),
        body(cuboid([0.5, 4.0, 6.0]), at(-12.5, 3.8), yaw, paint),
        body(Shape::Cylinder { radius: 0.5, height: 2.0 }, at(2.0, 0.0), yaw, [0.1; 3]),
    ]
}

/// Bodies on an apron: models, shapes, a thin mast and wires, a balloon and smoke, with shadows on ground and each other.
pub fn objects() -> Panel {
    let place = |east: f64, north: f64| airfield(RUNWAY_EAST + east, north, 0.0);
    let hangar = hangar();
    let mut bodies = Vec::new();
    for (step, paint) in [[0.55, 0.25, 0.15], [0.25, 0.35, 0.5], [0.45, 0.45, 0.42]].into_iter().enumerate() {
        bodies.push(body(hangar.clone(), place(278.0, 880.0 + 52.0 * step as f64), 90.0, paint));
    }
    for (step, paint) in [[0.7, 0.05, 0.05], [0.05, 0.2, 0.6], [0.8, 0.5, 0.05]].into_iter().enumerate() {
        bodies.extend(aircraft(place(185.0, 870.0 + 48.0 * step as f64), 250.0, paint));
    }

    let tower = place(236.0, 1060.0);
    bodies.push(body(Shape::Cylinder { radius: 5.0, height: 26.0 }, tower, 0.0, [0.62, 0.6, 0.55]));
    bodies.push(body(cuboid([15.0, 15.0, 5.0]), tower + DVec3::Z * 26.0, 30.0, [0.1, 0.16, 0.18]));
    bodies.push(body(
        Shape::Cone { radius: 9.0, height: 6.0 },
        tower + DVec3::Z * 31.0,
        0.0,
        [0.5, 0.12, 0.08],
    ));
    for step in 0..3 {
        let tank = Shape::Cylinder { radius: 7.0, height: 9.0 };
        bodies.push(body(tank, place(150.0 + 20.0 * f64::from(step), 1100.0), 0.0, [0.7; 3]));
    }

    let balloon = place(120.0, 1010.0) + DVec3::Z * 62.0;
    bodies.push(body(
        Shape::Ellipsoid { radii: DVec3::new(13.0, 13.0, 16.0) },
        balloon,
        0.0,
        [0.75, 0.3, 0.04],
    ));
    bodies.push(body(cuboid([3.0, 3.0, 2.5]), balloon - DVec3::Z * 27.0, 0.0, [0.2, 0.12, 0.06]));
    let mast = Form::Line { length: 60.0, width: 0.4, pixels: 1.0 };
    let upright = Attitude { pitch: 90.0, ..Attitude::default() };
    for step in 0..3 {
        let foot = place(60.0, 830.0 + 110.0 * f64::from(step));
        bodies.push(Body { attitude: upright, ..body(mast.clone(), foot, 0.0, [0.7, 0.1, 0.06]) });
    }
    let wire = Form::Line { length: 220.0, width: 0.05, pixels: 0.7 };
    bodies.push(body(wire, place(60.0, 830.0) + DVec3::Z * 58.0, 0.0, [0.04; 3]));
    for (id, body) in (0..).zip(&mut bodies) {
        body.id = id;
    }

    let smoke = (0..9).map(f64::from).map(|step| Puff {
        centre: place(168.0 + 9.0 * step, 1145.0 + 2.0 * step) + DVec3::Z * (12.0 + 7.0 * step),
        radius: 4.0 + 1.3 * step,
        depth: (1.6 - 0.13 * step) as f32,
        albedo: Vec3::splat(0.16),
    });
    let scenery = Scenery { bodies, puffs: smoke.collect(), ..Scenery::default() };
    let eye = [RUNWAY_EAST + 20.0, 770.0, AIRFIELD + 48.0];
    let panel = Panel::new(&AIRFIELD_WORLD, eye, [36.0, -7.0, 0.0], 62.0, day(210.0, 30.0, 15_000.0));
    Panel { scenery, ..panel }
}

/// A colour of luminance 1, linear Rec. 709.
fn tinted(colour: [f32; 3]) -> Vec3 {
    let colour = Vec3::from(colour);
    colour / colour.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// A lamp that shines all around, on the airfield.
fn lamp(place: DVec3, candela: f64, colour: Vec3) -> PointLight {
    let beams = vec![Beam { candela, colour, cone: None, below: None }];
    PointLight {
        position: place,
        attitude: Attitude::default(),
        fixture: Arc::new(Fixture { radius: 0.1, beams }),
        level: 1.0,
    }
}

/// Down the glide path by night: edge lamps, thresholds, a PAPI of two white and two red, lamps of houses on hills, stars.
pub fn night() -> Panel {
    let [white, red, green] = [[1.0, 0.86, 0.62], [1.0, 0.03, 0.0], [0.02, 1.0, 0.25]].map(tinted);
    let [south, north] = RUNWAY_NORTH;
    let mut lights = Vec::new();
    for side in [-1.0, 1.0] {
        let edge = RUNWAY_EAST + side * (RUNWAY_HALF + 3.0);
        lights.extend(
            (0..=20).map(|step| lamp(airfield(edge, south + 60.0 * f64::from(step), 0.5), 9.0, white)),
        );
    }
    for step in 0..=10 {
        let across = RUNWAY_EAST + RUNWAY_HALF * (f64::from(step) / 5.0 - 1.0);
        lights.push(lamp(airfield(across, south - 4.0, 0.5), 7.0, green));
        lights.push(lamp(airfield(across, north + 4.0, 0.5), 20.0, red));
    }
    for step in 1..=6 {
        let row = airfield(RUNWAY_EAST, south - 4.0 - 40.0 * f64::from(step), 0.5);
        lights.extend([-3.0, 0.0, 3.0].map(|aside| lamp(row + DVec3::X * aside, 6.0, white)));
    }

    // Red from below 2.5 to 3.5 degrees.
    for step in 0..4 {
        let below = Below { elevation: 3.6 - 0.4 * f64::from(step), over: 0.05, colour: red, share: 0.5 };
        let beams = vec![Beam { candela: 25.0, colour: Vec3::ONE, cone: None, below: Some(below) }];
        lights.push(PointLight {
            fixture: Arc::new(Fixture { radius: 0.1, beams }),
            ..lamp(airfield(RUNWAY_EAST - 40.0 - 9.0 * f64::from(step), south + 250.0, 0.6), 0.0, white)
        });
    }
    lights.extend((0..90).map(|index| {
        let [east, up] = [1, 2].map(|seed| chance(index, 0, 110 + seed));
        let place = DVec2::new(250.0 + 1550.0 * east, 1650.0 + 340.0 * chance(index, 0, 113));
        lamp(airfield(place.x, place.y, 20.0 + 90.0 * up), 4.0 + 25.0 * up, white)
    }));

    let options = RenderOptions {
        sun: Sun { azimuth: 300.0, elevation: -18.0 },
        night: Night { lux: 0.02, stars: Some(Firmament::default()) },
        shadows: false,
        ..day(300.0, 0.0, 14_000.0)
    };
    let eye = [RUNWAY_EAST + 6.0, south - 250.0, AIRFIELD + 26.8];
    let panel = Panel::new(&AIRFIELD_WORLD, eye, [0.0, 2.0, 4.0], 50.0, options);
    Panel { scenery: Scenery { lights, ..Scenery::default() }, ..panel }
}
