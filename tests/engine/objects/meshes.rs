//! Models against shapes of the same form, and what only models have: edges between triangles, textures, normals.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use super::exact::compare;
use super::{FARM, PLAIN, PLAIN_ORIGIN, black, frame, options, shares};
use crate::scene::View;
use hedgehop::objects::{Body, Level, Material, Mesh, MeshPart, Model, Shape, Texture, Wrap};
use hedgehop::render::{Engine, Renderer};
use hedgehop::simd::Isa;
use hedgehop::space::{Attitude, Camera, Pose, Screen};

/// Banked and pitched, over the plain.
const VIEW: View =
    View { eye: DVec3::new(500.0, 200.0, 60.0), ypr: [8.0, -9.0, 20.0], hfov: 40.0, size: [200, 160] };

pub fn model(part: MeshPart) -> Arc<Model> {
    Arc::new(Model::new(Arc::new(Mesh::new(vec![part]).unwrap()), []))
}

fn part(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> MeshPart {
    let material = Material { both_sides: false, ..Material::of(None) };
    MeshPart { positions, normals: Vec::new(), places: Vec::new(), colours: Vec::new(), triangles, material }
}

/// A box that stands on the origin: twelve triangles, counterclockwise from outside.
pub fn cuboid(size: DVec3) -> MeshPart {
    let half = 0.5 * size.as_vec3();
    let corner = |index: u32| {
        let sign = |bit: u32| if index >> bit & 1 == 1 { 1.0 } else { -1.0 };
        Vec3::new(half.x * sign(0), half.y * sign(1), half.z * (1.0 + sign(2)))
    };
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    part((0..8).map(corner).collect(), triangles)
}

/// A sphere around the origin of so many rings, with its normals.
pub fn globe(radius: f32, rings: u32) -> MeshPart {
    let around = 2 * rings;
    let normal = |ring: u32, step: u32| {
        let (low, angle) = (ring as f32 / rings as f32, (step % around) as f32 / around as f32);
        let ((sin, cos), (east, north)) =
            ((std::f32::consts::PI * low).sin_cos(), (std::f32::consts::TAU * angle).sin_cos());
        if ring == 0 || ring == rings {
            Vec3::Z * cos.signum()
        } else {
            Vec3::new(sin * east, sin * north, cos)
        }
    };

    let normals: Vec<_> =
        (0..=rings).flat_map(|ring| (0..around).map(move |step| normal(ring, step))).collect();
    let at = |ring: u32, step: u32| ring * around + step % around;

    let triangles = (0..rings).flat_map(|ring| {
        (0..around).flat_map(move |step| {
            let [a, b, c, d] =
                [at(ring, step), at(ring, step + 1), at(ring + 1, step + 1), at(ring + 1, step)];
            [[a, b, c], [a, c, d]]
        })
    });

    let positions = normals.iter().map(|normal| *normal * radius).collect();
    MeshPart { normals, ..part(positions, triangles.collect()) }
}

const SIZE: DVec3 = DVec3::new(30.0, 24.0, 45.0);
const PLACE: [f64; 3] = [530.0, 400.0, 0.01];
const TURNED: Attitude = Attitude { yaw: 20.0, pitch: 5.0, roll: -8.0 };

fn turned(body: Body) -> Body {
    Body { attitude: TURNED, albedo: Vec3::new(0.3, 0.6, 0.2), ..body }
}

/// Cameras of several kinds around the same place.
fn cameras() -> Vec<Camera> {
    let corner = PLAIN_ORIGIN.extend(0.0);
    let pose = |place: DVec3, ypr: [f64; 3]| {
        let [yaw, pitch, roll] = ypr;
        Pose { eye: corner + place, attitude: Attitude { yaw, pitch, roll }, hfov: 60.0 }
    };
    let south = pose(DVec3::new(500.0, 300.0, 60.0), [8.0, -9.0, 20.0]);
    let inside = pose(DVec3::new(530.0, 405.0, 20.0), [40.0, -20.0, 0.0]);
    let near = pose(DVec3::new(525.0, 385.5, 20.0), [40.0, 10.0, 0.0]);
    let screens = [
        Screen::Equirectangular { hfov: 120.0, vfov: 90.0 },
        Screen::Fisheye { fov: 160.0 },
        Screen::Orthographic { width: 120.0 },
    ];
    let planar = [south, near, inside].map(|pose| Camera::new(pose, 160, 120));
    planar
        .into_iter()
        .chain(screens.into_iter().map(|screen| Camera::with_screen(south, screen, 160, 120)))
        .collect()
}

#[test]
fn a_box_of_triangles_is_a_box() {
    let both = Material::of(None);
    let cube = model(MeshPart { material: both, ..cuboid(SIZE) });
    for camera in cameras() {
        let [shape, mesh] = [black(Shape::Box { size: SIZE }, PLACE), black(cube.clone(), PLACE)]
            .map(|body| frame(Engine::Planes, &PLAIN, &camera, &[turned(body)]));
        let (mut seen, mut worst) = (0, 0.0_f32);
        for pixel in 0..shape.id.len() {
            let [one, other] = [&shape, &mesh].map(|frame| Vec3::from_array(frame.colour[pixel]));
            worst = worst.max((one - other).abs().max_element());
            if shape.id[pixel] != mesh.id[pixel] || shape.id[pixel] != hedgehop::frame::Frame::body_id(1) {
                continue;
            }
            seen += 1;
            let [one, other] = [&shape, &mesh].map(|frame| Vec3::from_array(frame.normal[pixel]));
            if one.dot(other) > 0.999 {
                let ranges = [&shape, &mesh].map(|frame| frame.range[pixel]);
                assert!((ranges[0] / ranges[1] - 1.0).abs() < 1e-3, "{ranges:?}");
            }
        }

        let differ = (0..shape.id.len()).filter(|pixel| shape.id[*pixel] != mesh.id[*pixel]).count();
        let screen = camera.screen();
        assert!(seen > 200 && differ <= seen / 500 + 1, "{screen:?}: {seen} pixels, {differ} differ");

        // Two rays of 96, of the brightest there is; a mesh tells more faces of a corner apart than two.
        assert!(worst < 0.03, "{screen:?}: {worst}");
    }
}

/// Corners of boxes, each `[low, high]` in a model's axes, on the screen of a view, pixels.
fn corners_on_screen(view: &View, body: &Body, [low, high]: [DVec3; 2]) -> Vec<[f64; 2]> {
    let focal = 0.5 * f64::from(view.size[0]) / (0.5 * view.hfov.to_radians()).tan();
    let turned = |angle: f64, place: DVec3| {
        let (sin, cos) = angle.to_radians().sin_cos();
        DVec3::new(cos * place.x + sin * place.y, cos * place.y - sin * place.x, place.z)
    };
    let corner = |index: u32| {
        let part = |axis: usize| if index >> axis & 1 == 1 { high[axis] } else { low[axis] };
        let place = turned(body.attitude.yaw, DVec3::new(part(0), part(1), part(2)));
        let seen = turned(-view.ypr[0], body.position + place - PLAIN_ORIGIN.extend(0.0) - view.eye);
        assert!(seen.y > 0.1, "a corner beside the eye");
        let [width, height] = view.size.map(|size| 0.5 * f64::from(size));
        [width + focal * seen.x / seen.y, height - focal * seen.z / seen.y]
    };
    (0..8).map(corner).collect()
}

/// The convex outline of places, counterclockwise (Andrew's monotone chain).
fn hull(mut places: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let turn =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    places.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let half = |places: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for place in places {
            while chain.len() > 1 && turn(chain[chain.len() - 2], chain[chain.len() - 1], place) <= 0.0 {
                chain.pop();
            }
            chain.push(place);
        }
        chain.pop();
        chain
    };
    let (mut below, above) = (half(&mut places.iter().copied()), half(&mut places.iter().rev().copied()));
    below.extend(above);
    below
}

/// Area of the part of a convex outline that lies in a pixel (Sutherland and Hodgman's clipping).
fn area_in_pixel(outline: &[[f64; 2]], column: usize, row: usize) -> f64 {
    let sides = [
        (0, column as f64, 1.0),
        (0, column as f64 + 1.0, -1.0),
        (1, row as f64, 1.0),
        (1, row as f64 + 1.0, -1.0),
    ];
    // Most pixels lie beside the outline.
    let is_beside =
        |&(axis, end, sign): &(usize, f64, f64)| outline.iter().all(|place| sign * (place[axis] - end) < 0.0);
    if sides.iter().any(is_beside) {
        return 0.0;
    }

    let mut part = outline.to_vec();
    for (axis, end, sign) in sides {
        let inside = |place: [f64; 2]| sign * (place[axis] - end);
        let whole = std::mem::take(&mut part);
        for (index, &to) in whole.iter().enumerate() {
            let from = whole[(index + whole.len() - 1) % whole.len()];
            let (before, after) = (inside(from), inside(to));
            if before * after < 0.0 {
                let share = before / (before - after);
                part.push([0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis])));
            }
            if after >= 0.0 {
                part.push(to);
            }
        }
    }

    let next = |index: usize| part[(index + 1) % part.len()];
    (0..part.len()).map(|at| 0.5 * (part[at][0] * next(at)[1] - next(at)[0] * part[at][1])).sum::<f64>().abs()
}

/// Walls, a box and slabs one behind the other, at all yaws, from eyes that look exactly along and across their faces: all pixels within are full, all
/// outside are empty, and edges hold what the outline of the corners says.
#[test]
fn faces_parallel_to_the_screen_are_whole() {
    let slab = |y: f64| [DVec3::new(-5.0, y, -5.0), DVec3::new(5.0, y + 1.0, 5.0)];
    let across = |size: DVec3| vec![[-0.5 * size, 0.5 * size]];
    let models = [
        (0..4).map(|step| slab(6.0 * f64::from(step))).collect(),
        across(DVec3::new(12.0, 0.2, 8.0)),
        across(DVec3::new(0.3, 14.0, 6.0)),
        across(DVec3::new(7.0, 9.0, 11.0)),
    ];
    let size = [192_u32, 108];
    let (mut edges, mut within, mut worst) = (0, 0, 0.0_f64);

    for (boxes, turn) in models.iter().flat_map(|boxes| (0..24).map(move |turn| (boxes, turn))) {
        let parts = boxes.iter().map(|[low, high]| {
            let mut part = cuboid(*high - *low);
            let foot = (0.5 * (*low + *high)).with_z(low.z).as_vec3();
            part.positions.iter_mut().for_each(|corner| *corner += foot);
            part
        });
        let model = Arc::new(Model::new(Arc::new(Mesh::new(parts.collect()).unwrap()), []));

        // Yaws of 15° have sines and cosines that are rounded; the eye is turned as far, or by a right angle more.
        let yaw = 15.0 * f64::from(turn);
        let attitude = Attitude { yaw, ..Attitude::default() };
        let body = Body { attitude, ..black(model, [480.0, 510.0, 90.0]) };

        for (aside, away) in [(0.0, 31.0), (11.3, 37.7), (-17.0, 44.0)] {
            let view_yaw = yaw + 90.0 * f64::from(turn % 4);
            let (sin, cos) = view_yaw.to_radians().sin_cos();
            let back = DVec3::new(-sin * away + cos * aside, -cos * away - sin * aside, 1.7 * aside * 0.1);
            let eye = body.position - PLAIN_ORIGIN.extend(0.0) + back;
            let view = View { eye, ypr: [view_yaw, 0.0, 0.0], hfov: 80.0, size };
            let seen = shares(Engine::Planes, &PLAIN, &view, std::slice::from_ref(&body));

            let outlines: Vec<_> =
                boxes.iter().map(|corners| hull(corners_on_screen(&view, &body, *corners))).collect();
            for (pixel, seen) in seen.iter().enumerate() {
                let (column, row) = (pixel % size[0] as usize, pixel / size[0] as usize);
                let areas = outlines.iter().map(|outline| area_in_pixel(outline, column, row));
                let (least, most) =
                    areas.fold((0.0_f64, 0.0), |(most, sum), area| (most.max(area), sum + area));

                // Of slabs that overlap in a pixel any part may be the other's.
                let off = (least - seen).max(seen - most.min(1.0));
                worst = worst.max(off);
                assert!(
                    off < 0.06,
                    "yaw {yaw}, {aside} m aside: {column} {row} has {seen}, not {least} to {most}"
                );
                within += usize::from(least > 0.999_999);
                edges += usize::from(most > 0.0 && least < 0.999_999);
                assert!(least <= 0.999_999 || *seen > 0.999_9, "yaw {yaw}: {column} {row} holds {seen}");
            }
        }
    }

    assert!(within > 100_000 && edges > 10_000, "{within} pixels within, {edges} with edges, {worst}");
}

#[test]
fn fine_spheres_are_round() {
    let place = [530.0, 400.0, 35.0];
    let ball = black(model(globe(20.0, 200)), place);
    let seen = shares(Engine::Planes, &PLAIN, &VIEW, &[ball]);
    let corners = [-20.0, 20.0].map(|radius| DVec3::from(place) + radius);
    let exact = super::exact::shares(&VIEW, &[corners], |eye, direction| {
        super::exact::meets_sphere(eye, direction, place.into(), 20.0)
    });
    let (mean, apart) = compare(&VIEW, &seen, &exact);
    assert!(mean <= 1.0 / 128.0 && apart <= 0.1, "{mean} {apart}");
}

#[test]
fn no_ray_passes_between_triangles() {
    // Both ways of casting, towards edges and corners above all.
    let part = globe(20.0, 30);
    let body = Body { attitude: TURNED, ..black(model(part.clone()), [530.0, 400.0, 50.0]) };
    let corner = PLAIN_ORIGIN.extend(0.0);
    let view = TURNED.world_from_view();
    let turn = glam::DMat3::from_cols(view.x_axis, view.z_axis, view.y_axis);

    for eye in
        [DVec3::new(400.0, 300.0, 90.0), DVec3::new(531.0, 401.0, 52.0), DVec3::new(3000.0, 9000.0, 4000.0)]
    {
        let eye = corner + eye;
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|corner| part.positions[corner as usize].as_dvec3());
            for target in [a, 0.5 * (a + b), 0.3 * b + 0.7 * c, (a + b + c) / 3.0] {
                // A little inward, or the outline would be met by half of the rays.
                let target = body.position + turn * (0.97 * target);
                let direction = (target - eye).normalize();
                assert!(body.blocks(eye, direction, f64::INFINITY), "{eye} to {target}");
                let is_before = body.blocks(eye, direction, 0.9 * ((body.position - eye).length() - 20.0));
                assert!(!is_before, "{eye} to {target}");
            }
        }
    }

    let near =
        View { eye: DVec3::new(500.0, 330.0, 50.0), ypr: [23.0, 0.0, 5.0], hfov: 40.0, size: [256, 256] };
    let seen = shares(Engine::Planes, &PLAIN, &near, &[body]);
    let mut inside = 0;

    for row in 1..255 {
        for column in 1..255 {
            let around =
                [0, 1, 256, 257, 2, 512, 514, 258, 513].map(|step| seen[(row - 1) * 256 + column - 1 + step]);
            if around.iter().all(|share| *share > 0.5) {
                inside += 1;
                assert!(
                    around[4].is_finite() && seen[row * 256 + column] > 0.999_99,
                    "{column} {row}: {}",
                    seen[row * 256 + column]
                );
            }
        }
    }

    assert!(inside > 5000, "{inside}");
}

#[test]
fn textures_go_right_and_down() {
    // Red, green; blue, white: seen from the south, upright.
    let texels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    let texture = Arc::new(Texture::new(2, 2, texels, [Wrap::Clamp; 2]).unwrap());
    let positions = [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let places = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    let wall = MeshPart {
        places,
        material: Material { texture: Some(texture), both_sides: false, ..Material::of(Some(Vec3::ONE)) },
        ..part(positions.map(|place| 20.0 * Vec3::from_array(place)).into(), vec![[0, 2, 1], [0, 3, 2]])
    };
    let body = black(model(wall.clone()), [500.0, 400.0, 20.0]);
    let view = View { eye: DVec3::new(500.0, 320.0, 40.0), ypr: [0.0; 3], hfov: 40.0, size: [90, 60] };
    let frame = frame(Engine::Planes, &PLAIN, &view.camera(), &[body]);
    let at = |column: usize, row: usize| Vec3::from_array(frame.colour[row * 90 + column]);

    for (place, channel) in [((30, 15), 0), ((60, 15), 1), ((30, 45), 2)] {
        let colour = at(place.0, place.1);
        let others = [(channel + 1) % 3, (channel + 2) % 3].map(|other| colour[other]);
        assert!(others.iter().all(|other| *other < 0.3 * colour[channel]), "{place:?}: {colour}");
    }

    let white = at(60, 45);
    assert!(white.min_element() > 0.6 * white.max_element(), "{white}");

    // From behind it is not there.
    let back = View { eye: DVec3::new(500.0, 480.0, 40.0), ypr: [180.0, 0.0, 0.0], ..view };
    let seen = shares(Engine::Planes, &PLAIN, &back, &[black(model(wall), [500.0, 400.0, 20.0])]);
    assert!(seen.iter().all(|share| *share == 0.0));
}

#[test]
fn holes_of_a_texture_are_seen_through() {
    let texels: Vec<_> = (0..16).map(|texel| [0, 0, 0, if texel % 4 < 2 { 255 } else { 0 }]).collect();
    let texture = Arc::new(Texture::new(4, 4, texels, [Wrap::Clamp; 2]).unwrap());
    let positions = vec![Vec3::ZERO, 40.0 * Vec3::X, 40.0 * (Vec3::X + Vec3::Z), 40.0 * Vec3::Z];
    let fence = MeshPart {
        places: vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
        material: Material { texture: Some(texture), cutoff: Some(0.5), ..Material::of(Some(Vec3::ONE)) },
        ..part(positions, vec![[0, 1, 2], [0, 2, 3]])
    };
    let body = black(model(fence), [480.0, 400.0, 10.0]);
    let view = View { eye: DVec3::new(500.0, 300.0, 30.0), ypr: [0.0; 3], hfov: 40.0, size: [120, 90] };
    let seen = shares(Engine::Planes, &PLAIN, &view, std::slice::from_ref(&body));
    let all: f64 = seen.iter().sum();
    // 40 m at 100 m, of 72.8 m in 120 pixels: half of it is there.
    let pixels = (40.0_f64 / 72.8 * 120.0).powi(2);
    assert!((all / (0.5 * pixels) - 1.0).abs() < 0.03, "{all} of {pixels}");
    let eye = PLAIN_ORIGIN.extend(0.0) + view.eye;
    let towards = |east: f64| (body.position + DVec3::new(east, 0.0, 20.0) - eye).normalize();
    assert!(body.blocks(eye, towards(10.0), 1000.0) && !body.blocks(eye, towards(30.0), 1000.0));
}

#[test]
fn normals_of_corners_make_it_smooth() {
    let place = [530.0, 400.0, 35.0];
    let light = |body: Body| Body { albedo: Vec3::ONE, ..body };
    let ball = frame(
        Engine::Planes,
        &PLAIN,
        &VIEW.camera(),
        &[light(black(Shape::Ellipsoid { radii: DVec3::splat(20.0) }, place))],
    );

    let apart = |part: MeshPart| {
        let seen = frame(Engine::Planes, &PLAIN, &VIEW.camera(), &[light(black(model(part), place))]);
        let own = hedgehop::frame::Frame::body_id(1);
        let inside =
            (0..ball.id.len()).filter(|pixel| [&ball, &seen].iter().all(|frame| frame.id[*pixel] == own));
        inside.map(|pixel| (ball.colour[pixel][1] - seen.colour[pixel][1]).abs()).sum::<f32>()
    };

    let rough = globe(20.0, 24);
    let flat = MeshPart { normals: Vec::new(), ..rough.clone() };
    let (smooth, flat) = (apart(rough), apart(flat));
    assert!(smooth < 0.4 * flat, "{smooth} {flat}");
}

#[test]
fn instructions_differ_by_rounding_only() {
    let body = turned(black(model(globe(20.0, 40)), [530.0, 400.0, 30.0]));
    let frames: Vec<_> = Isa::available()
        .into_iter()
        .map(|isa| {
            let renderer = Renderer::new(&*PLAIN, &options(Engine::Planes)).with_isa(isa);
            renderer.frame_with(&VIEW.camera(), std::slice::from_ref(&body), &FARM).unwrap().frame
        })
        .collect();
    for other in &frames[1..] {
        let pairs = frames[0].colour.iter().zip(&other.colour);
        let differ = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 2e-3)).count();
        // A ray on an edge may fall to either side.
        assert!(differ < frames[0].colour.len() / 200, "{differ} pixels");
    }
}

#[test]
fn far_away_the_coarser_model_is_seen() {
    let (cube, ball) = (Mesh::new(vec![cuboid(DVec3::splat(20.0))]), Mesh::new(vec![globe(2.0, 8)]));
    let (cube, ball) = (Arc::new(cube.unwrap()), Arc::new(ball.unwrap()));
    let model = Arc::new(Model::new(cube, [Level { mesh: ball, below: 30.0 }]));
    let count = |distance: f64| {
        let body = black(model.clone(), [500.0, 100.0 + distance, 10.0]);
        let view = View { eye: DVec3::new(500.0, 100.0, 20.0), ypr: [0.0; 3], hfov: 40.0, size: [120, 90] };
        let seen: f64 = shares(Engine::Planes, &PLAIN, &view, &[body]).iter().sum();
        seen * distance * distance
    };
    // Diameter 34.6 m, 165 pixels per radian: 30 pixels at 190 m.
    assert!(count(150.0) > 20.0 * count(250.0));
}
