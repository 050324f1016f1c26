//! Parts of objects: joints, models of several nodes, and how they lean.

use glam::{DMat3, DVec2, DVec3};

use super::{read_beside, slope};
use hedgehop::Result;
use hedgehop::geo::Crs;
use hedgehop::objects::{Body, Form, Model};
use hedgehop::scene::*;
use hedgehop_testing::Random;

/// Reads a scene from text, with tables of angles, tracks and models beside it.
fn read(text: &str) -> Result<Scene> {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0];
    let (whole, coarse) = (tank(true), tank(false));
    let corners = corners.map(f32::to_le_bytes).concat();
    let files: [(&str, &[u8]); 8] = [
        ("turret.csv", b"time_s,yaw_deg,up_m\n0,350,0\n4,30,1\n"),
        ("bad.csv", b"time_s,heading\n0,1\n"),
        ("car.csv", b"time_s,x_m,y_m,alt_agl_m\n0,100,200,0\n10,200,275,0\n20,260,355,0\n"),
        ("gps.csv", b"time_s,x_m,y_m,alt_msl_m\n0,100,200,3\n10,200,275,900\n"),
        ("tank.gltf", whole.as_bytes()),
        ("far.gltf", coarse.as_bytes()),
        ("wing.obj", b"v 0 0 0\nv 4 0 0\nv 0 2 0\nf 1 2 3\n"),
        ("three.bin", &corners),
    ];
    read_beside(text, &files)
}

/// A model of a hull, on it a turret that is turned and 3 units up, and on that a gun; of a coarse level a turret without a gun.
fn tank(has_gun: bool) -> String {
    let gun = if has_gun { r#""gun""# } else { r#""stub""# };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[
{{"name":"hull","mesh":0,"scale":[2,2,2],"children":[1]}},
{{"name":"turret","mesh":0,"translation":[0,1.5,0.5],"rotation":[0,0.70710678,0,0.70710678],"children":[2,3]}},
{{"name":{gun},"mesh":0,"translation":[0,0.5,1],"scale":[0.5,0.5,-1.5]}},{{"name":"empty"}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
"buffers":[{{"uri":"three.bin","byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,0,2]}}]}}"#
    )
}

fn bind(text: &str) -> Cast {
    read(text).unwrap().bind(&Crs::local(), &slope).unwrap()
}

/// The body of a name at a time.
fn body(cast: &Cast, name: &str, seconds: f64) -> Body {
    let id = cast.names().position(|known| known == name).unwrap();
    cast.bodies_at(seconds).into_iter().find(|body| body.id as usize == id).unwrap()
}

fn close(found: DVec3, expected: [f64; 3]) {
    assert!((found - DVec3::from_array(expected)).length() < 1e-9, "{found} {expected:?}");
}

const HULL: &str = r##"
[[object]]
name = "tank"
shape = "box"
size_m = [3, 7, 2]
at = [500, 600, 150]
altitude = "msl"
yaw_deg = 90
colour = "#204020"
"##;

const TURRET: &str = r#"
[[object.part]]
name = "turret"
shape = "cylinder"
radius_m = 1
height_m = 0.8
offset_m = [0, 1, 2]
yaw_deg = 90
"#;

const GUN: &str = r##"
[[object.part]]
name = "gun"
parent = "turret"
shape = "line"
width_m = 0.2
length_m = 4
offset_m = [0, 1, 0.5]
pitch_deg = 30
colour = "#ffffff"
"##;

#[test]
fn a_gun_lifts_on_a_turret_that_turns_on_a_hull() {
    let cast = bind(&[HULL, TURRET, GUN].concat());
    assert_eq!(cast.names().collect::<Vec<_>>(), ["tank", "tank/turret", "tank/gun"]);
    assert_eq!(cast.owners().collect::<Vec<_>>(), ["tank"; 3]);
    // The hull looks east, the turret right of it, south.
    let [hull, turret, gun] = ["tank", "tank/turret", "tank/gun"].map(|name| body(&cast, name, 3.0));
    close(turret.position, [501.0, 600.0, 152.0]);
    close(turret.world_from_body().y_axis, [0.0, -1.0, 0.0]);
    close(gun.position, [501.0, 599.0, 152.5]);
    close(gun.world_from_body().y_axis, [0.0, -(0.75_f64.sqrt()), 0.5]);
    // A part is as its object, unless it says otherwise.
    assert!(turret.albedo == hull.albedo && gun.albedo == glam::Vec3::ONE);
    assert_eq!(cast.at(3.0).parts, 2);
}

#[test]
fn the_order_of_a_file_means_nothing() {
    let other = "[[object]]\nname = \"ant\"\nshape = \"disc\"\nradius_m = 1\nat = [1, 2, 3]\n\
                 [[object.part]]\nname = \"leg\"\nshape = \"disc\"\nradius_m = 1\n";
    let hatch = TURRET.replace("turret", "hatch").replace("yaw_deg = 90", "yaw_deg = 20");
    let one = bind(&[other, HULL, &hatch, TURRET, GUN].concat());
    let two = bind(&[HULL, GUN, TURRET, &hatch, other].concat());
    let names = ["ant", "tank", "ant/leg", "tank/hatch", "tank/turret", "tank/gun"];
    assert!(one.names().eq(names) && two.names().eq(names));
    assert!(one.owners().eq(["ant", "tank", "ant", "tank", "tank", "tank"]));
    for (one, two) in one.bodies_at(1.0).iter().zip(two.bodies_at(1.0)) {
        assert!(one.id == two.id && one.position == two.position && one.attitude == two.attitude);
    }
}

#[test]
fn a_rotor_stands_after_a_whole_turn_as_it_stood() {
    let rotor = |rpm: f64, rest: &str| {
        bind(&format!(
            "{HULL}\n[[object.part]]\nname = \"r\"\nshape = \"box\"\nsize_m = [8, 0.3, 0.1]\nturn_rpm = {rpm}\n{rest}"
        ))
    };
    let attitude = |cast: &Cast, seconds: f64| body(cast, "tank/r", seconds).attitude;
    let fast = rotor(60.0, "");
    for frame in 0..50 {
        let seconds = f64::from(frame) / 25.0;
        assert_eq!(attitude(&fast, seconds), attitude(&fast, seconds + 1.0), "{seconds}");
    }

    // A quarter of a turn, clockwise from above: it began eastward.
    close(body(&fast, "tank/r", 0.25).world_from_body().y_axis, [0.0, -1.0, 0.0]);
    close(body(&fast, "tank/r", -0.25).world_from_body().y_axis, [0.0, 1.0, 0.0]);

    // As a tail rotor turns: clockwise as seen from its right, where it looks southward.
    let tail = rotor(60.0, "axis = [2, 0, 0]\nangle_deg = 30");
    let expected = DMat3::from_axis_angle(DVec3::NEG_Y, -(30.0 + 90.0_f64).to_radians()) * DVec3::X;
    close(body(&tail, "tank/r", 0.25).world_from_body().y_axis, expected.to_array());
    close(body(&tail, "tank/r", 0.25).world_from_body().x_axis, [0.0, -1.0, 0.0]);

    // One that waits.
    let late = rotor(-30.0, "start_s = 5");
    assert_eq!(attitude(&late, 2.0), attitude(&late, 5.0));
    close(body(&late, "tank/r", 5.5).world_from_body().y_axis, [0.0, 1.0, 0.0]);
}

#[test]
fn tables_say_angles_and_shifts() {
    let turret = TURRET.replace("yaw_deg = 90", "angles = \"turret.csv\"\nstart_s = 2");
    let cast = bind(&format!("{HULL}{turret}"));
    // From 350 to 30 degrees by way of 0, on a hull that looks east.
    for (seconds, yaw, up) in [(0.0, 80.0, 0.0), (3.0, 90.0, 0.25), (4.0, 100.0, 0.5), (60.0, 120.0, 1.0)] {
        let found = body(&cast, "tank/turret", seconds);
        assert!((found.attitude.yaw - yaw).abs() < 1e-9, "{seconds}: {:?}", found.attitude);
        close(found.position, [501.0, 600.0, 152.0 + up]);
    }
}

#[test]
fn lamps_and_plumes_go_with_parts() {
    let more = "[[light]]\nobject = \"tank/gun\"\noffset_m = [0, 4, 0]\n\
                [[plume]]\nkind = \"smoke\"\nobject = \"tank/gun\"\noffset_m = [0, 4, 0]\nsize_m = 0.1\nlife_s = 0.1\nper_s = 100\n";
    let cast = bind(&[HULL, TURRET, GUN, more].concat());
    let muzzle = [501.0, 599.0 - 4.0 * 0.75_f64.sqrt(), 154.5];
    close(cast.lights_at(0.0)[0].position, muzzle);
    assert!((cast.puffs_at(0.0)[0].centre - DVec3::from_array(muzzle)).length() < 0.4);
}

/// Corners of the box around a body's mesh of a level, in the world.
fn bounds(body: &Body, level: usize) -> [DVec3; 2] {
    let Form::Model(model) = &body.form else { panic!("a model") };
    let [low, high] = model.levels()[level].mesh.corners().map(glam::Vec3::as_dvec3);
    [low, high].map(|corner| body.position + body.world_from_body() * corner)
}

const MODEL: &str =
    "[[object]]\nname = \"t\"\nmodel = \"tank.gltf\"\nat = [0, 0, 50]\naltitude = \"msl\"\nscale = 2\n";

/// A part that is a node of its own name.
fn node(name: &str, rest: &str) -> String {
    format!("[[object.part]]\nname = \"{name}\"\nnode = \"{name}\"\n{rest}\n")
}

#[test]
fn nodes_turn_about_their_own_origins_and_with_the_nodes_above() {
    // Metres: the turret is 6 up and 2 ahead of the hull and looks left, the gun 2 up and 4 ahead of it, that is left.
    let still = bind(&format!("{MODEL}{}{}", node("gun", ""), node("turret", "")));
    assert_eq!(still.names().collect::<Vec<_>>(), ["t", "t/turret", "t/gun"]);
    let place = |cast: &Cast, name: &str| body(cast, name, 0.0);
    let near = |found: DVec3, expected: [f64; 3]| {
        assert!((found - DVec3::from_array(expected)).length() < 1e-5, "{found} {expected:?}");
    };
    near(place(&still, "t/turret").position, [0.0, 2.0, 56.0]);
    near(place(&still, "t/turret").world_from_body().y_axis, [-1.0, 0.0, 0.0]);
    near(place(&still, "t/gun").position, [-4.0, 2.0, 58.0]);

    // A whole model shows them where they are at rest: three triangles, the gun's backward.
    let whole = |cast: &Cast| {
        let all = cast.bodies_at(0.0);
        all.iter()
            .map(|body| bounds(body, 0))
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], [a, b]| {
                [low.min(a).min(b), high.max(a).max(b)]
            })
    };

    let [at_rest, uncut] = [whole(&still), whole(&bind(MODEL))];
    assert!(
        (at_rest[0] - uncut[0]).length() < 1e-4 && (at_rest[1] - uncut[1]).length() < 1e-4,
        "{at_rest:?} {uncut:?}"
    );

    // The turret turns to the right, so that it looks ahead, and takes the gun with it, which lifts.
    let turned = bind(&format!("{MODEL}{}{}", node("gun", "pitch_deg = 90"), node("turret", "yaw_deg = 90")));
    near(place(&turned, "t/turret").position, [0.0, 2.0, 56.0]);
    near(place(&turned, "t/turret").world_from_body().y_axis, [0.0, 1.0, 0.0]);
    near(place(&turned, "t/gun").position, [0.0, 6.0, 58.0]);
    near(place(&turned, "t/gun").world_from_body().y_axis.abs(), [0.0, 0.0, 1.0]);

    // Without the turret being a part, the gun turns on the hull; what has no part stays.
    let alone = bind(&format!("{MODEL}{}", node("gun", "yaw_deg = 90")));
    near(place(&alone, "t/gun").position, [-4.0, 2.0, 58.0]);
}

#[test]
fn levels_without_a_node_show_it_at_rest() {
    let levels = "levels = [{ model = \"tank.gltf\", below_px = 300 }, { model = \"far.gltf\", below_px = 100 }, { model = \"tank.gltf\", below_px = 10 }]\n";
    let cast = bind(&format!("{MODEL}{levels}{}{}", node("turret", ""), node("gun", "")));
    let model = |name: &str| match body(&cast, name, 0.0).form {
        Form::Model(model) => model,
        _ => panic!("a model"),
    };
    let seen = |model: &Model, pixels: f64| model.at(pixels).map(|mesh| mesh.triangle_count());
    let [hull, turret, gun] = ["t", "t/turret", "t/gun"].map(model);

    for (pixels, counts) in [
        (1000.0, [Some(1), Some(1), Some(1)]),
        (200.0, [Some(1), Some(1), Some(1)]),
        // The turret has what is left of the gun.
        (50.0, [Some(1), Some(2), None]),
        // Coarser levels do not move it again.
        (5.0, [Some(1), Some(2), None]),
    ] {
        let found = [&hull, &turret, &gun].map(|model| seen(model, pixels));
        assert_eq!(found, counts, "{pixels}");
    }

    // All of them change at once.
    assert!(hull.size() == gun.size() && hull.size() == turret.size() && hull.size() > 10.0);
}

#[test]
fn mistakes_of_parts_name_line_and_key() {
    let part = |rest: &str| format!("{}{TURRET}{rest}", &HULL[1..]);
    let of_model = |rest: &str| format!("{MODEL}{}", node("turret", rest));
    let gun = format!("{}{TURRET}{GUN}", &HULL[1..]);
    let line = |text: &str, word: &str| {
        1 + text.lines().collect::<Vec<_>>().iter().rposition(|line| line.contains(word)).unwrap()
    };

    for (text, key, words) in [
        (part("radius = 3"), "radius =", "unknown field `radius`"),
        (part("at = [1, 2, 3]"), "at = [1,", "at is for objects"),
        (part("slope = true"), "slope", "slope is for objects"),
        (part("track = \"car.csv\""), "track", "track is for objects"),
        (part("to = [1, 2, 3]"), "to =", "to is for objects"),
        (part("[[object.part.part]]\nname = \"x\""), "part.part", "part is for objects"),
        (part("axis = [0, 0, 0]"), "axis", "some length"),
        (part("axis = [0, 0, nan]"), "axis", "some length"),
        (part("axis = [0, 1]"), "axis", "axis must be 3"),
        (part("turn_rpm = 1e9"), "turn_rpm", "100000"),
        (part("angle_deg = inf"), "angle_deg", "-360 and 360"),
        (part("pitch_deg = 361"), "pitch_deg", "between -360"),
        (part("start_s = 3"), "start_s", "turn_rpm or angles"),
        (part("angles = \"none.csv\""), "none.csv", "none.csv"),
        (part("angles = \"bad.csv\""), "bad.csv", "\"heading\""),
        (part("angles = \"turret.csv\""), "yaw_deg", "says yaw_deg, too"),
        (part("node = \"turret\""), "node", "has a shape"),
        (part("parent = \"hull\""), "parent", "there is none"),
        (part("parent = \"turret\""), "parent", "with itself"),
        (gun.replace("yaw_deg = 90\n\n", "parent = \"gun\"\n\n"), "parent = \"gun\"", "ring"),
        (part(&TURRET.replace("radius", "#")), "", "already"),
        (part("colour = \"red\""), "\"red\"", "#rrggbb"),
        (format!("{}turn_rpm = 3", &HULL[1..]), "turn_rpm", "for parts of objects"),
        (format!("{}node = \"turret\"", &HULL[1..]), "node", "for parts of objects"),
        (of_model("").replace("node = \"turret\"", "node = \"wheel\""), "wheel", "there are \"hull\""),
        (of_model("").replace("node = \"turret\"", "node = \"empty\""), "empty", "shows nothing"),
        (of_model("shape = \"disc\""), "disc", "leave out shape"),
        (of_model("offset_m = [1, 2, 3]"), "offset_m", "leave out offset_m"),
        (of_model("").replace("tank.gltf", "wing.obj"), "node", "only glTF"),
        (of_model("").replace("node = \"turret\"", "node = \"hull\""), "tank.gltf", "nothing of it is left"),
        (
            of_model(&node("x", "").replace("node = \"x\"", "node = \"turret\"  ")),
            "\"turret\"  ",
            "is the node \"turret\" already",
        ),
    ] {
        let message = read(&text).unwrap_err().to_string();
        assert!(message.contains("scene.toml") && message.contains(words), "{text}: {message}");
        let place = format!("line {}", line(&text, key));
        assert!(key.is_empty() || message.contains(&place), "{text}: {message}, not {place}");
        assert!(!message.contains('\n'), "{message:?}");
    }

    let many: String = (0..101).map(|part| TURRET.replace("\"turret\"", &format!("\"{part}\""))).collect();
    assert!(read(&format!("{HULL}{many}")).unwrap_err().to_string().contains("at most 100 parts"));
    let twin = "[[object]]\nname = \"tank/turret\"\nshape = \"disc\"\nradius_m = 1\nat = [1, 2, 3]\n";

    assert!(
        read(&format!("{twin}{HULL}{TURRET}"))
            .unwrap_err()
            .to_string()
            .contains("an object `tank/turret`, too")
    );
    let slash = TURRET.replace("turret", "tur/ret");
    assert!(read(&format!("{HULL}{slash}")).unwrap_err().to_string().contains("has no `/`"));
}

fn car(rest: &str) -> String {
    format!("[[object]]\nname = \"car\"\nshape = \"box\"\nsize_m = [2, 4, 1]\nslope = true\n{rest}")
}

#[test]
fn what_leans_stands_on_an_inclined_plane_at_any_time() {
    let plane = |place: DVec2| Some(100.0 + 0.1 * place.x - 0.25 * place.y);
    let up = DVec3::new(-0.1, 0.25, 1.0).normalize();
    for (rest, above) in [
        ("track = \"car.csv\"", 0.0),
        ("at = [100, 200, 2]\nyaw_deg = 30", 2.0),
        ("track = \"gps.csv\"", 0.0),
    ] {
        let cast = read(&car(rest)).unwrap().bind(&Crs::local(), &plane).unwrap();
        for tenth in 0..=200 {
            let car = cast.bodies_at(f64::from(tenth) / 10.0).remove(0);
            let height = car.position.z - plane(car.position.truncate()).unwrap();
            assert!((height - above).abs() < 1e-9, "{rest}, {tenth}: {height}");
            assert!(
                (car.world_from_body().z_axis - up).length() < 1e-9,
                "{rest}, {tenth}: {:?}",
                car.attitude
            );
        }
    }

    // Its front stays where it was on a map.
    let cast = read(&car("at = [100, 200, 0]\nyaw_deg = 30")).unwrap().bind(&Crs::local(), &plane).unwrap();
    assert!((cast.bodies_at(0.0)[0].attitude.yaw - 30.0).abs() < 1e-9);
}

#[test]
fn what_leans_does_not_jump_where_the_ground_is_rough() {
    // Posts 1 m apart whose heights have no pattern, half a metre up and down, on a slope: bilinear between.
    let post = |x: f64, y: f64| 0.2 * x + 0.5 * Random((x * 7919.0 + y * 104_729.0).abs() as u64).share();
    let rough = |place: DVec2| {
        let (low, part) = (place.floor(), place - place.floor());
        let row = |y: f64| post(low.x, y) * (1.0 - part.x) + post(low.x + 1.0, y) * part.x;
        Some(row(low.y) * (1.0 - part.y) + row(low.y + 1.0) * part.y)
    };
    let cast = read(&car("track = \"car.csv\"")).unwrap().bind(&Crs::local(), &rough).unwrap();
    let cast_at = |step: i32| cast.bodies_at(f64::from(step) / 1000.0).remove(0);
    let bodies: Vec<Body> = (0..5000).map(cast_at).collect();
    let turned = |one: &Body, other: &Body| {
        let [one, other] = [one, other].map(|body| body.world_from_body().z_axis);
        one.angle_between(other).to_degrees()
    };

    // It drives 12.5 mm from one to the next, over ground as steep as 45 degrees.
    for pair in bodies.windows(2) {
        let found = turned(&pair[0], &pair[1]);
        assert!(found < 0.4, "{found}");
        assert!((pair[1].position.z - pair[0].position.z).abs() < 0.01);
    }

    // Nor does it where its track ends and it goes on.
    let cast = read(&car("track = \"car.csv\"\nbeyond = \"dead-reckoning\""))
        .unwrap()
        .bind(&Crs::local(), &rough)
        .unwrap();

    for end in [0.0, 20.0] {
        let [inside, outside] = [-1.0e-6, 1.0e-6].map(|step| cast.bodies_at(end + step).remove(0));
        assert!((inside.position - outside.position).length() < 1e-3, "{end} s: {inside:?} {outside:?}");
        assert!(turned(&inside, &outside) < 0.1, "{end} s: {inside:?} {outside:?}");
    }

    // In steps of a quarter of a metre, as planes are apart, it would have jumped.
    let most = bodies.windows(21).map(|some| turned(&some[0], &some[20])).fold(0.0, f64::max);
    assert!(most > 1.0, "{most}");
}

#[test]
fn mistakes_of_slopes_name_the_key() {
    for (rest, words) in [
        ("at = [1, 2, 3]\npitch_deg = 3", "line 7: with slope"),
        ("at = [1, 2, 3]\naltitude = \"msl\"", "line 7: with slope"),
        ("track = \"car.csv\"\nbank = true", "line 7: with slope"),
        ("at = [1, 2, 3]\nslope = 3", "line"),
    ] {
        let message = read(&car(rest)).unwrap_err().to_string();
        assert!(message.contains(words), "{rest}: {message}");
    }
    let noted = read(&car("track = \"gps.csv\"")).unwrap();
    assert!(noted.objects[0].track.notes.iter().any(|note| note.contains("left out")));
}
