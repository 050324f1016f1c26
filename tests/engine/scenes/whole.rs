//! Scenes as a whole: objects, tracks, sun and air.

use std::fs;

use glam::DVec2;

use super::{CAR, read_beside, slope};
use hedgehop::Result;
use hedgehop::geo::Crs;
use hedgehop::objects::{Form, Shape};
use hedgehop::scene::*;
use hedgehop::sunlight::{FilmSun, Sun, SunSetting};
use hedgehop::weather::{Fog, Weather};

/// Reads a scene from text, with a track and a model beside it.
fn read(text: &str) -> Result<Scene> {
    read_beside(text, &[CAR, ("roof.obj", b"v 0 0 0\nv 4 0 0\nv 0 2 0\nf 1 2 3\n")])
}

const WHOLE: &str = r##"
[sun]
azimuth_deg = 200
elevation_deg = 12.5

[air]
visibility_m = 8000

[[object]]
name = "tower"
shape = "cylinder"
radius_m = 3
height_m = 40
at = [500, 600, 0]
colour = "#ff8000"

[[object]]
name = "car"
shape = "box"
size_m = [2, 4.5, 1.5]
track = "car.csv"
start_s = 5
"##;

#[test]
fn scenes_say_what_stands_where_and_when() {
    let scene = read(WHOLE).unwrap();
    assert_eq!(
        (scene.sun, scene.visibility),
        (Some(FilmSun::Still(SunSetting::At(Sun { azimuth: 200.0, elevation: 12.5 }))), Some(8000.0))
    );
    let cast = scene.bind(&Crs::local(), &slope).unwrap();
    assert_eq!(cast.names().collect::<Vec<_>>(), ["car", "tower"]);
    let [car, tower] = &cast.bodies_at(10.0)[..] else { panic!("two bodies") };
    assert_eq!(tower.position, glam::DVec3::new(500.0, 600.0, 150.0));
    assert!(tower.albedo.x == 1.0 && tower.albedo.z == 0.0);
    // Five seconds after it set out, on the ground that rises by a tenth.
    assert!((car.position.truncate() - DVec2::new(60.0, 20.0)).length() < 0.1, "{}", car.position);
    assert!((car.position.z - 100.0 - 0.1 * car.position.x).abs() < 0.2);
    let [before, behind] = [0.0, 1000.0].map(|time| cast.bodies_at(time)[0].position.truncate());
    assert_eq!([before, behind], [DVec2::new(10.0, 20.0), DVec2::new(210.0, 20.0)]);
}

#[test]
fn weather_is_as_the_scene_says() {
    assert_eq!(read("").unwrap().weather, Weather::default());
    let fog = |text: &str| read(text).unwrap().weather.fog.unwrap();
    let plain = fog("[fog]\ntop_m = 420\nvisibility_m = 150");
    assert_eq!(plain, Fog { top: 420.0, visibility: 150.0, soft: 20.0 });
    assert_eq!(fog("[fog]\ntop_m = 420\nvisibility_m = 150\nsoft_m = 5").soft, 5.0);
    let clouds = read("[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 0.5\nwind_mps = [5, -3]").unwrap();
    let clouds = clouds.weather.clouds.unwrap();
    assert_eq!((clouds.base, clouds.top, clouds.coverage, clouds.wind), (900.0, 1800.0, 0.5, [5.0, -3.0]));
    // Air glows where the scene says where the sun stands, unless it says otherwise.
    let glow = |text: &str| read(text).unwrap().weather.glow;
    let sun = "[sun]\nazimuth_deg = 1\nelevation_deg = 2\n";
    assert_eq!([glow(sun), glow(&format!("{sun}[air]\nglow = 0.5"))], [1.0, 0.5]);
}

#[test]
fn the_digest_follows_the_file_and_its_tracks() {
    let digest = |text: &str| read(text).unwrap().digest;
    assert_eq!(digest(WHOLE), digest(WHOLE));
    assert_ne!(digest(WHOLE), digest(&WHOLE.replace("40", "41")));
}

#[test]
fn mistakes_name_line_and_key() {
    let tower = |lines: &str| format!("[[object]]\nname = \"t\"\nshape = \"cylinder\"\n{lines}");
    let whole = "radius_m = 3\nheight_m = 9\nat = [1, 2, 3]\n";
    assert!(read(&tower(whole)).is_ok());
    let roof = |line: &str| format!("[[object]]\nname = \"r\"\nmodel = \"roof.obj\"\nat = [1, 2, 3]\n{line}");
    assert!(read(&roof("levels = [{ model = \"roof.obj\", below_px = 9 }]")).is_ok());

    let cases = [
        ("sun = 3", "line 1", "sun"),
        ("[sun]\nazimuth_deg = 10", "line 2", "elevation_deg"),
        ("[sun]\nazimuth_deg = 10\nelevation_deg = -93", "line 3", "elevation_deg"),
        ("[sun]\nazimuth_deg = nan\nelevation_deg = 3", "line 2", "azimuth_deg"),
        ("[sun]\nazimuth_deg = 1e300\nelevation_deg = 3", "line 2", "azimuth_deg"),
        ("[sun]\ntime = 2026-06-21", "line 2", "offset"),
        ("[sun]\ntime = 3", "line 2", "time"),
        ("[sun]\nazimuth_deg = 3\ntime = 2026-06-21T09:00:00Z", "line 3", "not both"),
        ("[air]\nvisibility_m = 0", "line 2", "visibility_m"),
        ("[air]\nvisibilty_m = 3", "line 2", "visibilty_m"),
        ("[air]\nglow = 1.5", "line 2", "glow"),
        ("[clouds]\nbase_m = 3", "line 1", "top_m"),
        ("[clouds]\nbase_m = 900\ntop_m = 800\ncoverage = 1", "line 3", "top_m"),
        ("[clouds]\nbase_m = 900\ntop_m = inf\ncoverage = 1", "line 3", "top_m"),
        ("[clouds]\nbase_m = -1e9\ntop_m = 800\ncoverage = 1", "line 2", "base_m"),
        ("[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 2", "line 4", "coverage"),
        ("[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 1\nscale_m = 1", "line 5", "scale_m"),
        ("[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 1\nvisibility_m = 0", "line 5", "visibility_m"),
        ("[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 1\nwind_mps = [nan, 0]", "line 5", "wind_mps"),
        (
            "[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 1\nwind_mps = [5, 0, 1]",
            "line 5",
            "wind_mps must be 2",
        ),
        ("[clouds]\nbase_m = 900\ntop_m = 1800\ncoverage = 1\nseed = -1", "line 5", "-1"),
        ("[fog]\nvisibility_m = 200", "line 1", "top_m"),
        ("[fog]\ntop_m = nan\nvisibility_m = 200", "line 2", "top_m"),
        ("[fog]\ntop_m = 1e7\nvisibility_m = 200", "line 2", "top_m"),
        ("[fog]\ntop_m = 300\nvisibility_m = -1", "line 3", "visibility_m"),
        ("[fog]\ntop_m = 300\nvisibility_m = 200\nsoft_m = 0", "line 4", "soft_m"),
        ("[fog]\ntop_m = 300\nvisibility_m = 200\ndepth = 3", "line 4", "depth"),
        ("[[object]]\nshape = \"sphere\"", "line 1", "name"),
        ("[[object]]\nname = \" \"\nshape = \"sphere\"", "line 1", "name"),
        ("[[object]]\nname = \"a\"\nshape = \"cube\"", "line 3", "cube"),
        (&tower("radius_m = 3\nheight_m = 9\nat = [1, 2, 1e300]"), "line 6", "10⁹"),
        (&tower("radius_m = 3\nheight_m = 9\ntrack = \"a\\u0007\""), "line 6", "track"),
        (&tower("radius_m = 3\nat = [1, 2, 3]"), "line 3", "height_m"),
        (&tower("radius_m = -3\nheight_m = 9\nat = [1, 2, 3]"), "line 4", "radius_m"),
        (&tower("radius_m = \"3\"\nheight_m = 9\nat = [1, 2, 3]"), "line 4", "string"),
        (&tower("radius_m = 3\nheight_m = 1e9\nat = [1, 2, 3]"), "line 5", "height_m"),
        (&tower("radius_m = 3\nheight_m = 9\nsize_m = [1, 2, 3]\nat = [1, 2, 3]"), "line 6", "size_m"),
        (&tower("radius_m = 3\nheight_m = 9\n"), "line 1", "track"),
        (&tower("radius_m = 3\nheight_m = 9\nat = [1, 2]"), "line 6", "3"),
        (&tower("radius_m = 3\nheight_m = 9\nat = [1, 2, 3, 4]"), "line 6", "at must be 3 numbers, not 4"),
        (&tower("radius_m = 3\nheight_m = 9\nat_lonlat = [1, 2, 3, 4]"), "line 6", "at_lonlat must be 3"),
        (
            "[[object]]\nname = \"b\"\nshape = \"box\"\nsize_m = [1, 2, 3, 4]\nat = [1, 2, 3]",
            "line 4",
            "size_m must be 3",
        ),
        (
            "[[object]]\nname = \"b\"\nshape = \"ellipsoid\"\nradii_m = [1, 2]\nat = [1, 2, 3]",
            "line 4",
            "radii_m must be 3",
        ),
        (
            "[[object]]\nname = \"b\"\nshape = \"ellipse\"\nradii_m = [1, 2, 3]\nat = [1, 2, 3]",
            "line 4",
            "radii_m must be 2 numbers",
        ),
        (
            "[[object]]\nname = \"b\"\nshape = \"ellipse\"\nradii_m = [1, -2]\nat = [1, 2, 3]",
            "line 4",
            "2 lengths of more than 0 m",
        ),
        (
            "[[object]]\nname = \"b\"\nshape = \"ellipse\"\nradius_m = 3\nat = [1, 2, 3]",
            "line 4",
            "its size is radii_m",
        ),
        (&tower(&format!("{whole}priority = 1001")), "line 7", "−1000 to 1000"),
        (&tower(&format!("{whole}priority = -9223372036854775808")), "line 7", "−1000 to 1000"),
        (&tower(&format!("{whole}priority = 1.5")), "line 7", "float"),
        (&tower("radius_m = 3\nheight_m = 9\nat = [1, inf, 2]"), "line 6", "at"),
        (&tower("radius_m = 3\nheight_m = 9\nat_lonlat = [1, 95, 2]"), "line 6", "at_lonlat"),
        (&tower(&format!("{whole}at_lonlat = [1, 5, 2]")), "line 7", "not both"),
        (&tower(&format!("{whole}colour = \"red\"")), "line 7", "#rrggbb"),
        (&tower(&format!("{whole}colour = \"#+fffff\"")), "line 7", "#rrggbb"),
        (&tower(&format!("{whole}yaw_deg = 1000")), "line 7", "yaw_deg"),
        (&tower(&format!("{whole}altitude = \"high\"")), "line 7", "high"),
        (&tower(&format!("{whole}start_s = 3")), "line 1", "start_s"),
        (&tower(&format!("{whole}bank = true")), "line 7", "bank"),
        (&tower(&format!("{whole}track = \"car.csv\"")), "line 6", "track"),
        (&tower(&format!("{whole}{}", tower(whole))), "line 7", "already"),
        ("[[object]]\nname = \"a\"\nat = [1, 2, 3]", "line 1", "shape or model"),
        (&tower(&format!("{whole}model = \"roof.obj\"")), "line 7", "not both"),
        (&tower(&format!("{whole}scale = 2")), "line 7", "scale"),
        (&tower(&format!("{whole}levels = [{{ model = \"roof.obj\", below_px = 9 }}]")), "line 7", "levels"),
        (&roof("radius_m = 3"), "line 5", "radius_m"),
        (&roof("scale = 0"), "line 5", "scale"),
        (&roof("scale = 2\nlength_m = 3"), "line 6", "not both"),
        (&roof("length_m = 1e9"), "line 5", "length_m"),
        (&roof("turn_deg = [0, nan, 0]"), "line 5", "turn_deg"),
        (&roof("turn_deg = [0, 0, 0, 0]"), "line 5", "turn_deg must be 3"),
        (&roof("up = \"x\""), "line 5", "`x`"),
        (&roof("origin = \"top\""), "line 5", "`top`"),
        (&roof("levels = [{ model = \"roof.obj\" }]"), "line 5", "below_px"),
        (&roof("levels = [{ model = \"car.csv\", below_px = 9 }]"), "line 5", ".glb"),
        (
            &roof(
                "levels = [{ model = \"roof.obj\", below_px = 9 }, { model = \"roof.obj\", below_px = 9 }]",
            ),
            "line 5",
            "below_px",
        ),
        (&roof("scale = 1e6"), "line 3", "roof.obj"),
        ("[[object", "line 1", ""),
        ("\u{0}", "line 1", ""),
    ];

    for (text, line, key) in cases {
        let message = read(text).unwrap_err().to_string();
        assert!(message.contains("scene.toml: "), "{text:?}: {message}");
        assert!(message.contains(&format!("{line}: ")) && message.contains(key), "{text:?}: {message}");
        assert!(!message.contains('\n'), "{message:?}");
    }
}

#[test]
fn tracks_that_are_not_there_are_named() {
    let error =
        read("[[object]]\nname = \"t\"\nshape = \"disc\"\nradius_m = 1\ntrack = \"none.csv\"").unwrap_err();
    assert!(matches!(&error, hedgehop_base::Error::Io { path, .. } if path.ends_with("none.csv")), "{error}");
    let message = error.to_string();
    assert!(
        message.contains("the track of object `t` (line 5 of ") && message.contains("scene.toml)"),
        "{message}"
    );
}

#[test]
fn models_have_the_size_that_is_asked_for() {
    let text =
        "[[object]]\nname = \"r\"\nmodel = \"roof.obj\"\nat = [1, 2, 3]\nlength_m = 8\norigin = \"base\"";
    let scene = read(text).unwrap();
    let [low, high] = scene.objects[0].form.corners();
    assert!((low - glam::DVec3::new(-4.0, 0.0, 0.0)).length() < 1e-3, "{low}");
    assert!((high - glam::DVec3::new(4.0, 0.0, 4.0)).length() < 1e-3, "{high}");
    assert!(scene.objects[0].files.iter().all(|file| file.ends_with("roof.obj")));
    let missing = read(&text.replace("roof", "none")).unwrap_err();
    assert!(
        matches!(&missing, hedgehop_base::Error::Io { path, .. } if path.ends_with("none.obj")),
        "{missing}"
    );
    assert!(missing.to_string().contains("the model of object `r` (line 3 of "), "{missing}");
    let unknown = read(&text.replace("roof.obj", "car.csv")).unwrap_err();
    assert!(matches!(unknown, hedgehop_base::Error::Unsupported { .. }), "{unknown}");
    assert!(unknown.to_string().contains("scene.toml: line 3: the model of object `r`: "), "{unknown}");
}

#[test]
fn what_is_wrong_with_the_suns_time_names_its_line() {
    let over = |time: &str| {
        let scene = read(&format!("\n[sun]\ntime = {time}\nshadows = true")).unwrap();
        assert_eq!(scene.lines, SunLines { time: Some(3), shadows: Some(4) });
        scene.sky_over(&Crs::wgs84(), DVec2::new(10.0, 47.0))
    };
    assert!(over("2026-06-21T12:00:00Z").unwrap().unwrap().sun.elevation > 60.0);
    let message = over("9999-06-21T12:00:00Z").unwrap_err().to_string();
    assert!(message.contains("scene.toml: line 3: ") && message.contains("the year 9999"), "{message}");
    let placed = read("[sun]\nazimuth_deg = 3\nelevation_deg = 5").unwrap();
    let sky = placed.sky_over(&Crs::local(), DVec2::ZERO).unwrap().unwrap();
    assert_eq!(sky.sun, Sun { azimuth: 3.0, elevation: 5.0 });
}

#[test]
fn objects_without_ground_are_named() {
    let scene = read(WHOLE).unwrap();
    let message = scene.bind(&Crs::local(), &|_| None).unwrap_err().to_string();
    assert!(message.contains("scene.toml: line 17: object `car`: "), "{message}");
    let degrees = WHOLE.replace("at = [500, 600, 0]", "at_lonlat = [8, 47, 0]");
    let message = read(&degrees).unwrap().bind(&Crs::local(), &slope).unwrap_err().to_string();
    assert!(message.contains("`tower`"), "{message}");
}

/// A thing of a shape, at line 1 of a scene.
fn thing(shape: &str, rest: &str) -> String {
    format!("[[object]]\nname = \"t\"\nshape = \"{shape}\"\n{rest}")
}

#[test]
fn lines_go_from_one_place_to_another() {
    let body = |shape: &str, rest: &str| {
        let cast = read(&thing(shape, rest)).unwrap().bind(&Crs::local(), &slope).unwrap();
        cast.bodies_at(3.0).remove(0)
    };
    let wire = body("line", "width_m = 0.03\nwidth_px = 0.8\nat = [100, 200, 10]\nto = [130, 240, 10]");
    let Form::Line { length, width, pixels } = wire.form else { panic!("a line") };
    // The ground is 3 m higher at its end.
    assert!((length - 2509.0_f64.sqrt()).abs() < 1e-9 && width == 0.03 && pixels == 0.8, "{length}");
    assert_eq!(wire.position, glam::DVec3::new(100.0, 200.0, 120.0));
    let end = wire.position + length * (wire.attitude.world_from_view() * glam::DVec3::Z);
    assert!((end - glam::DVec3::new(130.0, 240.0, 123.0)).length() < 1e-9, "{end}");
    let mast = body("line", "width_m = 0.1\nlength_m = 7\nat = [1, 2, 0]\npitch_deg = 90");
    assert!(matches!(mast.form, Form::Line { length: 7.0, width: 0.1, pixels: 0.0 }));
    let dot = body("point", "radius_m = 0.2\nsize_px = 3\nat = [1, 2, 0]");
    assert!(matches!(dot.form, Form::Point { width: 0.4, pixels: 3.0 }));
}

#[test]
fn mistakes_of_lines_and_points_name_the_key() {
    for (shape, rest, line, word) in [
        ("line", "at = [1, 2, 3]\nto = [2, 2, 3]", 3, "width_m"),
        ("line", "at = [1, 2, 3]\nwidth_m = 1", 3, "length_m"),
        ("line", "at = [1, 2, 3]\nwidth_m = 1\nto = [2, 2, 3]\nlength_m = 3", 7, "not both"),
        ("line", "at = [1, 2, 3]\nwidth_m = 1\nto = [2, 2, 3]\nyaw_deg = 3", 7, "angles"),
        ("line", "at = [1, 2, 3]\nwidth_m = 1\nto = [2, 2, inf]", 6, "to must"),
        ("line", "at_lonlat = [1, 2, 3]\nwidth_m = 1\nto = [2, 200, 3]", 6, "latitude"),
        ("line", "at = [1, 2, 3]\nwidth_m = 1\nto = [2, 2, 3]\nwidth_px = -1", 7, "width_px"),
        ("line", "track = \"car.csv\"\nwidth_m = 1\nto = [2, 2, 3]", 6, "length_m"),
        ("line", "at = [1, 2, 3]\nradius_m = 1", 5, "radius_m"),
        ("point", "at = [1, 2, 3]\nradius_m = 1\nsize_px = 200", 6, "size_px"),
        ("point", "at = [1, 2, 3]\nradius_m = 1\nwidth_px = 2", 6, "width_px"),
        ("box", "at = [1, 2, 3]\nsize_m = [1, 1, 1]\nto = [1, 2, 3]", 6, "to"),
        ("box", "at = [1, 2, 3]\nsize_m = [1, 1, 1]\nlength_m = 3", 6, "length_m"),
    ] {
        let error = read(&thing(shape, rest)).unwrap_err().to_string();
        assert!(error.contains(&format!("line {line}:")) && error.contains(word), "{rest}: {error}");
    }

    let same = read(&thing("line", "at = [1, 2, 3]\nwidth_m = 1\nto = [1, 2, 3]")).unwrap();
    let error = same.bind(&Crs::local(), &slope).unwrap_err().to_string();
    assert!(error.contains("line 1") && error.contains("more than 0 m"), "{error}");
}

#[test]
fn beyond_their_tracks_objects_do_as_they_are_told() {
    let car = |beyond: &str| {
        let text = thing("box", &format!("size_m = [2, 4, 2]\ntrack = \"car.csv\"\nstart_s = 5\n{beyond}"));
        read(&text).unwrap().bind(&Crs::local(), &slope).unwrap()
    };
    let gone = car("beyond = \"hide\"");
    assert_eq!([4.9, 5.0, 25.0, 25.1].map(|time| gone.bodies_at(time).len()), [0, 1, 1, 0]);
    // 10 m/s eastward, up a slope of a tenth.
    let on = car("beyond = \"dead-reckoning\"");
    for (time, x) in [(-5.0, -90.0), (15.0, 110.0), (25.0, 210.0), (40.0, 360.0)] {
        let body = on.bodies_at(time).remove(0);
        let expected = glam::DVec3::new(x, 20.0, 100.0 + 0.1 * x);
        assert!((body.position - expected).length() < 0.5, "{time} s: {}", body.position);
        assert!((body.attitude.yaw - 90.0).abs() < 1.0);
    }
    let held = car("beyond = \"hold\"").bodies_at(40.0).remove(0).position;
    assert_eq!(held, car("").bodies_at(40.0).remove(0).position);
    let error = read(&thing("box", "size_m = [2, 4, 2]\nat = [1, 2, 3]\nbeyond = \"hide\"")).unwrap_err();
    assert!(error.to_string().contains("line 6: beyond"), "{error}");
}

#[test]
fn what_goes_on_above_the_ground_keeps_its_height_there() {
    let hill = |x: f64| 10.0 * (0.05 * x).sin();
    let over = |heights: &str, more: &str| {
        let folder = tempfile::tempdir().unwrap();
        let fixes = (0..=40).map(|fix| 0.25 * f64::from(fix));
        let fixes: Vec<_> = fixes.map(|time| format!("{time},{},20,3\n", 10.0 + 10.0 * time)).collect();
        let track = format!("time_s,x_m,y_m,{heights}\n{}", fixes.concat());
        fs::write(folder.path().join("hop.csv"), track).unwrap();
        let rest = format!("size_m = [2, 4, 2]\ntrack = \"hop.csv\"\nbeyond = \"dead-reckoning\"\n{more}");
        let path = folder.path().join("scene.toml");
        fs::write(&path, thing("box", &rest)).unwrap();
        // The ground ends 500 m to the east.
        let ground = |place: DVec2| (place.x < 500.0).then(|| hill(place.x));
        Scene::read(&path).unwrap().bind(&Crs::local(), &ground).unwrap()
    };

    let all = [over("alt_agl_m", ""), over("alt_agl_m", "slope = true"), over("alt_msl_m", "")];
    for time in (-80..60).filter(|time| !(0..=10).contains(time)).map(|time| 0.5 + f64::from(time)) {
        let [agl, leaning, msl] = all.each_ref().map(|cast| cast.bodies_at(time).remove(0));
        let x = 10.0 + 10.0 * time;
        let ends = x >= 498.0;
        assert!((agl.position.truncate() - DVec2::new(x, 20.0)).length() < 0.5, "{time} s: {agl:?}");
        assert!((msl.position.z - 3.0).abs() < 1e-9, "{time} s: {msl:?}");
        for body in [&agl, &leaning] {
            let height = body.position.z - 3.0;
            assert!((height - hill(body.position.x)).abs() < 0.3 || ends, "{time} s: {body:?}");
        }

        let pitch = (0.5 * (0.05 * leaning.position.x).cos()).atan().to_degrees();
        assert!((leaning.attitude.pitch - pitch).abs() < 1.0 || ends, "{time} s: {leaning:?}, not {pitch}");
        assert!(!ends || (agl.position.z - 3.0 - hill(498.0)).abs() < 0.5, "{time} s: {agl:?}");
    }
}

#[test]
fn ellipses_and_priorities_reach_bodies() {
    let text = "[[object]]\nname = \"mark\"\nshape = \"ellipse\"\nradii_m = [3, 8]\nat = [1, 2, 3]\npriority = 4\n\
                [[object.part]]\nname = \"rim\"\nshape = \"disc\"\nradius_m = 2\n\
                [[object.part]]\nname = \"top\"\nshape = \"disc\"\nradius_m = 1\npriority = -6\n\
                [[object]]\nname = \"plain\"\nshape = \"disc\"\nradius_m = 2\nat = [1, 2, 3]\n";
    let cast = read_beside(text, &[]).unwrap().bind(&Crs::local(), &slope).unwrap();
    let names: Vec<String> = cast.names().map(str::to_owned).collect();
    let bodies = cast.bodies_at(0.0);
    let of = |name: &str| {
        let id = names.iter().position(|known| known == name).unwrap();
        bodies.iter().find(|body| body.id as usize == id).unwrap()
    };
    assert_eq!(["mark", "mark/rim", "mark/top", "plain"].map(|name| of(name).priority), [4, 4, -6, 0]);
    let wanted = Shape::Ellipse { radii: DVec2::new(3.0, 8.0) };
    assert!(matches!(of("mark").form, Form::Shape(shape) if shape == wanted));
}
