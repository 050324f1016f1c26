//! `--scene` and `scene check` from outside.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

const SCENE: &str = r##"
[sun]
azimuth_deg = 200
elevation_deg = 30

[[object]]
name = "mast"
shape = "cylinder"
radius_m = 8
height_m = 70
at = [800, 900, 0]
colour = "#ff0000"

[[object]]
name = "car"
shape = "box"
size_m = [20, 40, 15]
track = "car.csv"
"##;

/// A folder with a database of hills, paths of an eye and a car, and a scene.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let grid = Grid { nx: 160, ny: 160, spacing: 10.0, origin: glam::DVec2::ZERO };
    let heights: Vec<f64> =
        (0..160 * 160).map(|post| 100.0 + 10.0 * (0.1 * f64::from(post % 160)).sin()).collect();
    let colours = vec![[90, 140, 60]; heights.len()];
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
    write_arrays(&folder.path().join("area.hop"), &arrays, &metadata, false).expect("a database");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    write("path.csv", "t_s,x_m,y_m,alt_agl_m,yaw_deg\n0,700,500,60,0\n1,720,520,60,0\n");
    write("car.csv", "t_s,x_m,y_m,alt_agl_m\n0,600,800,0\n1,900,800,0\n");
    write("scene.toml", SCENE);
    folder
}

const FLY: &str = "render area.hop --path path.csv --fps 10 --size 160x90 --scene scene.toml";

#[test]
fn check_says_what_is_where() {
    let site = site();
    let text = ends(&run(&site, "scene check scene.toml area.hop"), 0);
    for part in
        ["scene of 2 objects", "mast: cylinder of radius 8 m, 70 m high, stands", "car: box", "car.csv"]
    {
        assert!(text.contains(part), "{text}");
    }
    assert!(text.contains("mast begins at x 800.0, y 900.0, "), "{text}");
}

#[test]
fn pictures_and_frames_show_objects_whoever_renders() {
    let site = site();
    let frames = |args: &str, name: &str| {
        ends(&run(&site, &format!("{FLY} {args}")), 0);
        (1..=11).map(|n| fs::read(site.path().join(format!("{name}/{n:04}.png"))).expect("a frame")).collect()
    };
    let one: Vec<Vec<u8>> = frames("-j 1 -o one/####.png", "one");
    let four: Vec<Vec<u8>> = frames("-j 4 --in-flight 3 -o four/####.png", "four");
    let pixels = |png: &[u8]| image::load_from_memory(png).expect("a picture").into_rgb8().into_raw();
    for (one, four) in one.iter().zip(&four) {
        assert!(pixels(one) == pixels(four));
    }
    let is_red = |rgb: &[u8]| rgb[0] > 120 && rgb[1] < 80 && rgb[2] < 80;
    let red = pixels(&one[0]).chunks_exact(3).filter(|rgb| is_red(rgb)).count();
    assert!(red > 100, "{red} pixels of the mast");
    assert!(pixels(&one[0]) != pixels(&one[10]));
}

#[test]
fn frames_are_kept_while_the_scene_is_the_same() {
    let site = site();
    let again = format!("{FLY} --skip-existing -o frames/####.exr --frames 1-3");
    ends(&run(&site, &again), 0);
    assert!(ends(&run(&site, &again), 0).contains("kept 3"));
    let manifest = fs::read_to_string(site.path().join("frames/manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["settings"]["scene"]["objects"], serde_json::json!(["car", "mast"]));
    let car = "t_s,x_m,y_m,alt_agl_m\n0,600,800,0\n1,900,810,0\n";
    fs::write(site.path().join("car.csv"), car).expect("a track");
    assert!(ends(&run(&site, &again), 0).contains("rendered 3 frames"));
}

#[test]
fn parts_are_listed_and_their_tables_looked_after() {
    let site = site();
    let write = |name: &str, text: &str| fs::write(site.path().join(name), text).expect("a file");
    let parts = "[[object.part]]\nname = \"lid\"\nshape = \"disc\"\nradius_m = 9\nangles = \"lid.csv\"\n\
                 [[object.part]]\nname = \"knob\"\nparent = \"lid\"\nshape = \"point\"\nradius_m = 1\nturn_rpm = 30\n";
    write("scene.toml", &format!("{SCENE}slope = true\n{parts}"));
    write("lid.csv", "time_s,pitch_deg\n0,10\n1,60\n");
    let text = ends(&run(&site, "scene check scene.toml area.hop"), 0);

    for part in [
        "(CSV), leans with the ground\n",
        "    lid: disc of radius 9 m, moves as lid.csv says\n",
        "    knob: point of radius 1 m, on lid, turns 30 times a minute\n",
        "  car begins at x 600.0, y 800.0, ",
    ] {
        assert!(text.contains(part), "{part:?}: {text}");
    }

    assert!(!text.contains("lid begins"), "{text}");
    let again = format!("{FLY} --skip-existing --aov cryptomatte -o parts/####.exr --frames 1-2");
    ends(&run(&site, &again), 0);
    let manifest = fs::read_to_string(site.path().join("parts/manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    let names = serde_json::json!(["car", "mast", "car/lid", "car/knob"]);
    assert_eq!(manifest["settings"]["scene"]["objects"], names);
    let frame = fs::read(site.path().join("parts/0001.exr")).expect("a frame");
    let has = |text: &str| frame.windows(text.len()).any(|bytes| bytes == text.as_bytes());
    assert!(has("\"car\":") && !has("car/lid"), "a part is its object in mattes");
    write("lid.csv", "time_s,pitch_deg\n0,10\n1,70\n");
    assert!(ends(&run(&site, &again), 0).contains("rendered 2 frames"));
}

#[test]
fn flags_go_before_what_a_scene_says() {
    let site = site();
    let picture = |args: &str| {
        ends(&run(&site, &format!("{FLY} {args} --frames 1 --overwrite -o x/####.png")), 0);
        fs::read(site.path().join("x/0001.png")).expect("a frame")
    };
    let as_said = picture("");
    assert!(picture("--sun 200,30") == as_said);
    assert!(picture("--sun 100,30") != as_said);
}

#[test]
fn mistakes_end_with_a_sentence_and_a_code() {
    let site = site();
    fs::write(site.path().join("wrong.toml"), SCENE.replace("radius_m = 8", "radius_m = -8"))
        .expect("a scene");
    for command in ["scene check wrong.toml", &FLY.replace("scene.toml", "wrong.toml")] {
        let args =
            if command.starts_with("scene") { command.to_owned() } else { format!("{command} -o y.png") };
        let text = ends(&run(&site, &args), 3);
        assert!(text.contains("wrong.toml: line 9: radius_m must be more than 0 m"), "{text}");
    }
    assert!(ends(&run(&site, "scene check none.toml"), 5).contains("none.toml"));
    fs::write(site.path().join("off.toml"), SCENE.replace("at = [800,", "at = [80000,")).expect("a scene");
    let text = ends(&run(&site, "scene check off.toml area.hop"), 3);
    assert!(text.contains("mast") && text.contains("80000"), "{text}");
    // What would be written over is read by the scene.
    fs::rename(site.path().join("car.csv"), site.path().join("poses.csv")).expect("a track");
    fs::write(site.path().join("scene.toml"), SCENE.replace("car.csv", "poses.csv")).expect("a scene");
    assert!(ends(&run(&site, &format!("{FLY} -o ####.png")), 2).contains("input"));
}

#[test]
fn bench_measures_frames_with_their_objects() {
    let site = site();
    fs::write(site.path().join("empty.toml"), "").expect("a scene");
    let ranges = |scene: &str| {
        let bench =
            "bench area.hop --path path.csv --fps 10 --frames 1 --size 160x90 --workers 1,2 --repeats 1";
        ends(&run(&site, &format!("{bench} --scene {scene} --dump-ranges {scene}.ranges")), 0);
        fs::read(site.path().join(format!("{scene}.ranges/range_1.f32"))).expect("ranges")
    };
    let [with, without] = ["scene.toml", "empty.toml"].map(ranges);
    let nearer = with.chunks_exact(4).zip(without.chunks_exact(4)).filter(|(with, without)| {
        let [with, without] =
            [with, without].map(|bytes| f32::from_le_bytes(*bytes.first_chunk().expect("four bytes")));
        with < without
    });
    let nearer = nearer.count();
    assert!(nearer > 100, "{nearer} pixels are nearer");
}

#[test]
fn further_channels_are_for_exr_and_made_when_asked_for() {
    let site = site();
    let fly = |args: &str| run(&site, &format!("{FLY} --frames 10-11 {args}"));
    ends(&fly("-o plain/####.exr"), 0);
    ends(&fly("--aov cryptomatte,motion,position -o aov/####.exr"), 0);
    ends(&fly("--aov cryptomatte,motion,position -j 1 -o one/####.exr"), 0);

    for number in ["0010", "0011"] {
        let file =
            |folder: &str| fs::read(site.path().join(format!("{folder}/{number}.exr"))).expect("a frame");
        let has = |bytes: &[u8], text: &str| bytes.windows(text.len()).any(|part| part == text.as_bytes());
        let (plain, aov) = (file("plain"), file("aov"));
        for text in [
            "forward.u",
            "P.Z",
            "hedgehop.position_offset_m",
            "CryptoObject02.A",
            "\"car\":\"",
            "\"ground\":\"",
            "MurmurHash3_32",
        ] {
            assert!(has(&aov, text) && !has(&plain, text), "{number}: {text}");
        }
        assert!(aov == file("one"), "{number} differs with one worker");
    }

    let manifest = fs::read_to_string(site.path().join("aov/manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["settings"]["aov"], serde_json::json!(["cryptomatte", "motion", "position"]));
    assert_eq!(manifest["settings"]["position_offset_m"], serde_json::json!([0.0, 0.0, 0.0]));
    assert!(ends(&fly("--aov motion --skip-existing -o aov/####.exr"), 0).contains("rendered 2 frames"));

    // Frames whose next ones are elsewhere move otherwise.
    assert!(ends(&fly("--aov motion --skip-existing -o aov/####.exr"), 0).contains("kept 2"));
    let path = "t_s,x_m,y_m,alt_agl_m,yaw_deg\n0,700,500,60,0\n1,720,520,60,0\n2,720,550,60,0\n";
    fs::write(site.path().join("path.csv"), path).expect("a path");
    assert!(ends(&fly("--aov motion --skip-existing -o aov/####.exr"), 0).contains("rendered 2 frames"));
    assert!(ends(&fly("--aov motion -o frames/####.png"), 2).contains("--aov"));
}

#[test]
fn models_that_cannot_be_read_end_with_the_code_of_their_kind() {
    let site = site();
    let check = |model: &str| {
        let scene = format!("[[object]]\nname = \"m\"\nmodel = \"{model}\"\nat = [800, 900, 0]\n");
        fs::write(site.path().join("model.toml"), scene).expect("a scene");
        run(&site, "scene check model.toml")
    };
    fs::write(site.path().join("a.ply"), "ply\n").expect("a model");
    let draco = r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]}"#;
    fs::write(site.path().join("draco.gltf"), draco).expect("a model");
    fs::write(site.path().join("cut.glb"), b"glTF").expect("a model");
    for (model, code) in [("a.ply", 4), ("draco.gltf", 4), ("cut.glb", 3), ("none.glb", 5)] {
        let text = ends(&check(model), code);
        assert!(text.contains("model.toml") && text.contains("line 3") && text.contains(model), "{text}");
    }
}

#[test]
fn shadows_that_are_there_already_are_refused_in_words_of_the_scene() {
    let site = site();
    ends(&run(&site, "bake area.hop --sun 200,30 -o baked.hop"), 0);
    let scene = SCENE.replace("elevation_deg = 30", "elevation_deg = 30\nshadows = true");
    fs::write(site.path().join("shadows.toml"), scene).expect("a scene");
    let fly = |more: &str| {
        let args = "render baked.hop --path path.csv --frames 1 --size 64x36 -o x/####.png --scene";
        run(&site, &format!("{args} {more}"))
    };
    let text = ends(&fly("shadows.toml"), 3);
    assert!(
        text.contains("shadows.toml: line 5: shadows = true") && !text.contains("--shadows on"),
        "{text}"
    );
    assert!(ends(&fly("scene.toml --shadows on"), 2).contains("--shadows on"));
    ends(&fly("shadows.toml --shadows off"), 0);
}

#[test]
fn pictures_are_finished_as_the_scene_and_the_flags_say() {
    let site = site();
    let finished = "[picture]\nexposure_ev = 1\ntone = \"filmic\"\nantialias = 2\nshutter_deg = 90\ndistortion = [-0.1, 0]\n[hud]\n";
    fs::write(site.path().join("finished.toml"), finished).expect("a file");

    let render = |args: &str, name: &str| {
        let args = format!(
            "render area.hop --path path.csv --fps 10 --size 160x90 --frames 4 --progress none {args} -o {name}-####.png"
        );
        ends(&run(&site, &args), 0);
        fs::read(site.path().join(format!("{name}-0004.png"))).expect("a picture")
    };

    let by_scene = render("--scene finished.toml -j 1", "scene");
    assert!(by_scene == render("--scene finished.toml -j 3", "again"));

    // What a picture says of its settings holds the scene's digest, too: pixels are compared.
    let pixels = |name: &str| {
        let path = site.path().join(format!("{name}-0004.png"));
        hedgehop::encode::read_picture(&path).expect("a picture").rgb
    };
    let flags = "--exposure 1 --tone filmic --antialias 2 --shutter 90 --distortion=-0.1,0 --hud";
    render(flags, "flags");
    assert!(pixels("scene") == pixels("flags"));
    render("", "plain");
    let off = "--exposure 0 --tone none --antialias 1 --shutter 0 --distortion 0,0 --hud=none";
    render(&format!("--scene finished.toml {off}"), "off");
    assert!(pixels("off") == pixels("plain") && pixels("plain") != pixels("flags"));
    render("--hud=altitude", "altitude");
    assert!(pixels("altitude") != pixels("plain"));

    // Linear light knows nothing of exposure and instruments.
    let linear = |args: &str, name: &str| {
        let args = format!(
            "render area.hop --path path.csv --frames 4 --size 80x45 --progress none {args} -o {name}-####.exr"
        );
        ends(&run(&site, &args), 0);
        fs::read(site.path().join(format!("{name}-0004.exr"))).expect("a frame")
    };

    assert!(linear("", "linear") == linear("--exposure 2 --hud --dither ordered --gamma 2", "exposed"));
}

#[test]
fn pictures_that_cannot_be_finished_so_are_refused() {
    let site = site();
    for (args, part) in [
        ("--exposure 20", "(--exposure) must be -16 to 16 stops"),
        ("--antialias 3", "1, 2 or 4"),
        ("--tone dark", "none or filmic"),
        ("--hud=clock", "horizon, heading"),
        ("--distortion=-3,0", "before its corners"),
        ("--screen fisheye --distortion=-0.1,0", "a screen of kind fisheye"),
    ] {
        let args = format!("render area.hop --path path.csv --frames 1 --size 160x90 {args} -o no-####.png");
        let said = ends(&run(&site, &args), 2);
        assert!(said.contains(part), "{args}: {said}");
    }
}
