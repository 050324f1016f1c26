//! Films of a flight: which part of it, how fast, and where they look.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};

/// Level ground, and a flight over it: from two in the afternoon on, for 100 s, at 12 m/s to the north, which climbs by half as much.
pub fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let rows = vec![vec!["50"; 160].join(" "); 160].join("\n");
    let head = "ncols 160\nnrows 160\nxllcorner 0\nyllcorner 0\ncellsize 10";
    fs::write(folder.path().join("dem.asc"), format!("{head}\n{rows}\n")).expect("the grid is written");
    let fixes: String = (0..=10)
        .map(|fix| {
            let (minute, second) = (fix / 6, fix % 6 * 10);
            format!("2026-05-01T14:0{minute}:{second:02}Z,800,{},{}\n", 200 + 120 * fix, 100 + 60 * fix)
        })
        .collect();
    fs::write(folder.path().join("climb.csv"), format!("time,x_m,y_m,alt_msl_m\n{fixes}")).expect("a path");
    ends(&run(&folder, "build --local --elevation dem.asc -o area.hop"), 0);
    folder
}

/// A column of the poses of a film in `folder`.
fn column(site: &TempDir, folder: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(site.path().join(folder).join("poses.csv")).expect("poses");
    let mut rows = text.lines();
    let index =
        rows.next().and_then(|head| head.split(',').position(|column| column == name)).expect("a column");
    rows.map(|row| row.split(',').nth(index).expect("a cell").parse().expect("a number")).collect()
}

fn render(site: &TempDir, flags: &str, folder: &str) {
    let flight = "render area.hop --path climb.csv --size 16x9 --fps 1";
    ends(&run(site, &format!("{flight} {flags} -o {folder}/####.png")), 0);
}

#[test]
fn parts_of_a_flight_are_shown_as_fast_as_they_are_asked_for() {
    let site = site();
    for (folder, flags, expected) in [
        ("quick", "--speed 25x", [0.0, 25.0, 50.0, 75.0, 100.0].as_slice()),
        ("short", "--duration 4s", &[0.0, 25.0, 50.0, 75.0]),
        ("part", "--from 14:00:30 --to 0m50s --speed 10x", &[30.0, 40.0, 50.0]),
        ("slow", "--from 16:01:38+02:00 --speed 0.5", &[98.0, 98.5, 99.0, 99.5, 100.0]),
    ] {
        render(&site, flags, folder);
        assert_eq!(column(&site, folder, "t_s"), expected, "{flags}");
    }

    // Frames of another length of film show other moments, and are not kept.
    let other = "render area.hop --path climb.csv --size 16x9 --fps 1 --duration 5s -o short/####.png";
    assert!(ends(&run(&site, &format!("{other} --skip-existing")), 0).contains("rendered again"));
}

#[test]
fn a_climb_is_seen_with_the_ground_in_view() {
    let site = site();
    for (folder, flags, pitch) in [
        ("nose", "", 26.6),
        ("pitched", "--pitch -10", -10.0),
        ("down", "--look down", -90.0),
        ("led", "--look 20s", -9.0),
    ] {
        render(&site, &format!("{flags} --speed 25x"), folder);
        for found in column(&site, folder, "pitch_deg") {
            assert!((found - pitch).abs() < 0.5, "{flags}: {found}");
        }
    }
}

/// Level ground on Earth, and a climb over it of 6 m/s at 11 m/s over the ground, for a time of which a second tells how far it is.
fn site_on_earth(progress: impl Fn(u32) -> Option<f64>) -> TempDir {
    let site = TempDir::new().expect("a temporary folder");
    let rows = vec![vec!["50"; 80].join(" "); 80].join("\n");
    let head = "ncols 80\nnrows 80\nxllcorner 500000\nyllcorner 5000000\ncellsize 20";
    fs::write(site.path().join("earth.asc"), format!("{head}\n{rows}\n")).expect("the grid is written");
    ends(&run(&site, "build --elevation-crs EPSG:32632 --elevation earth.asc -o earth.hop"), 0);
    let fix = |second: u32| {
        let far = progress(second)?;
        let (latitude, height) = (45.1545 + 0.0001 * far, 100.0 + 6.0 * far);
        Some(format!("{second},9.01,{latitude:.6},{height}\n"))
    };
    let fixes: String = (0..).map_while(fix).collect();
    fs::write(site.path().join("climb.csv"), format!("t,lon_deg,lat_deg,alt_msl_m\n{fixes}"))
        .expect("a path");
    site
}

#[test]
fn minutes_on_the_ground_are_no_part_of_a_film_that_has_a_length() {
    let site = site_on_earth(|second| (second <= 400).then(|| f64::from(second.clamp(200, 260)) - 200.0));
    let film = |flags: &str, folder: &str| {
        let flight = "render earth.hop --path climb.csv --size 16x9 --fps 1 --progress none";
        let said = ends(&run(&site, &format!("{flight} {flags} -o {folder}/####.png")), 0);
        (said, column(&site, folder, "t_s"))
    };

    let (said, times) = film("--duration 6s", "short");
    assert!(
        said.contains("for its first 200 s and its last 140 s; the film leaves that out, --from 0 --to 400s")
    );
    assert!(times[0] == 200.0 && (times[5] - 250.0).abs() < 1e-6, "{times:?}");
    let (said, times) = film("--duration 4s --from 0 --to 400s", "whole");
    assert!(!said.contains("hardly moves") && times == [0.0, 100.0, 200.0, 300.0], "{times:?}");

    // At a pace of its own it is told, and left out by name.
    let (said, times) = film("--speed 20x --frames 1", "first");
    assert!(said.contains("--from departure --to arrival leave that out") && times == [0.0]);
    let (said, times) = film("--speed 20x --from departure --to arrival", "named");
    assert!(!said.contains("hardly moves") && times == [200.0, 220.0, 240.0, 260.0], "{times:?}");
}

#[test]
fn what_flies_is_seen_from_outside_with_a_body_or_without() {
    let site = site();
    let middle = |flags: &str, folder: &str| {
        let flight = "render area.hop --path climb.csv --size 160x90 --fps 1 --frames 51 --progress none";
        let said = ends(&run(&site, &format!("{flight} {flags} -o {folder}/####.png")), 0);
        let frame = fs::read(site.path().join(folder).join("0051.png")).expect("a frame");
        let picture = image::load_from_memory(&frame).expect("a picture").to_rgb8();
        let [red, green, blue] = picture.get_pixel(80, 44).0.map(u32::from);
        (said.contains("stands for what flies"), (red > 2 * blue && red > 2 * green, blue > 2 * red))
    };
    let (orange, blue, ground) = ((true, false), (false, true), (false, false));
    assert_eq!(middle("--chase 50,15", "behind"), (true, orange));
    assert_eq!(middle("--orbit 50,15", "around"), (true, orange));
    assert_eq!(middle("--chase 0,900 --look down", "above"), (true, orange));
    assert_eq!(middle("--look-at 800,800 --orbit 300,100", "place"), (false, ground));

    // One of the scene goes before it, and is raised as the flight is.
    let body = "[[object]]\nname = \"it\"\nshape = \"sphere\"\nradius_m = 9\ntrack = \"climb.csv\"\ncolour = \"#0010ff\"\n";
    fs::write(site.path().join("blue.toml"), body).expect("a scene");
    assert_eq!(middle("--scene blue.toml --chase 50,15", "own"), (false, blue));
    assert_eq!(middle("--scene blue.toml --chase 50,15 --clearance 900", "raised"), (false, blue));

    // A path file's cameras need it, too.
    let climb = fs::read_to_string(site.path().join("climb.csv")).expect("the path");
    let rows = climb.lines().skip(1).map(|row| format!("{row},50,15\n"));
    let head = "time,x_m,y_m,alt_msl_m,chase_back_m,chase_up_m\n".to_owned();
    fs::write(site.path().join("climb.csv"), rows.fold(head, |text, row| text + &row)).expect("a path");
    assert_eq!(middle("", "columns"), (true, orange));
}

#[test]
fn recordings_without_a_pitch_are_seen_with_the_ground_in_view() {
    let site = site_on_earth(|second| (second <= 60).then_some(second.into()));
    let pitch = |flags: &str, folder: &str| {
        let flight = "render earth.hop --path climb.csv --size 16x9 --fps 1 --duration 4s --progress none";
        let said = ends(&run(&site, &format!("{flight} {flags} -o {folder}/####.png")), 0);
        (said.contains("low enough to show the ground"), column(&site, folder, "pitch_deg")[2].round())
    };
    assert_eq!(pitch("", "held"), (true, -9.0));
    assert_eq!(pitch("--look ahead", "nose"), (false, 28.0));
    assert_eq!(pitch("--pitch 3", "own"), (false, 3.0));
    // Other screens see the ground anyway, and are held by who looks around.
    assert_eq!(pitch("--screen cylindrical", "round"), (false, 28.0));
}

/// Largest difference between a column of the poses and what it should be.
fn differs(site: &TempDir, folder: &str, name: &str, expected: &[f64]) -> f64 {
    let found = column(site, folder, name);
    assert_eq!(found.len(), expected.len(), "{folder}");
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn cameras_follow_go_around_and_look_at_places_and_objects() {
    let site = site();
    let scene = "[[object]]\nname = \"mast\"\nshape = \"box\"\nsize_m = [4, 4, 40]\nat = [1000, 800, 0]\n";
    fs::write(site.path().join("mast.toml"), scene).expect("a scene");
    let flown = [0.0, 25.0, 50.0, 75.0, 100.0].map(|time| 200.0 + 12.0 * time);

    render(&site, "--chase 60,15,20 --speed 25x", "chase");
    assert!(differs(&site, "chase", "x_m", &[820.0; 5]) < 0.01);
    assert!(differs(&site, "chase", "y_m", &flown.map(|y| y - 60.0)) < 0.01);
    assert!(differs(&site, "chase", "z_m", &flown.map(|y| y / 2.0 + 15.0)) < 0.01);
    let pitch = (-15.0_f64).atan2(60.0_f64.hypot(20.0)).to_degrees();
    assert!(differs(&site, "chase", "pitch_deg", &[pitch; 5]) < 0.01);

    // Half a turn in four seconds of the film, from behind by the west.
    render(&site, "--orbit 100,50,8 --speed 25x", "orbit");
    let bearings = [180.0, 225.0, 270.0, 315.0, 360.0].map(f64::to_radians);
    assert!(differs(&site, "orbit", "x_m", &bearings.map(|bearing| 800.0 + 100.0 * bearing.sin())) < 0.1);

    for (folder, looked) in
        [("place", "--look-at 1000,800,70"), ("object", "--look-at mast --scene mast.toml")]
    {
        render(&site, &format!("{looked} --speed 25x"), folder);
        let yaws = flown.map(|y| 200.0_f64.atan2(800.0 - y).to_degrees());
        assert!(differs(&site, folder, "yaw_deg", &yaws) < 0.01, "{:?}", column(&site, folder, "yaw_deg"));
    }
}

#[test]
fn scenes_cut_from_camera_to_camera() {
    let site = site();
    let scene = "[[camera]]\nchase_m = [60, 15]\nhfov_deg = [60, 30]\n\
        [[camera]]\nfrom_s = 50\nat = [900, 800, 30]\nlook_at = [900, 900, 30]\n\
        [[camera]]\nease = \"in-out\"\n\
        key = [{ t_s = 70, at = [500, 500, 90], yaw_deg = 10 }, { t_s = 90, at = [600, 500, 90], yaw_deg = 30 }]\n";
    fs::write(site.path().join("film.toml"), scene).expect("a scene");
    render(&site, "--scene film.toml --speed 10x", "film");
    let xs = [800.0, 800.0, 800.0, 800.0, 800.0, 900.0, 900.0, 500.0, 550.0, 600.0, 600.0];
    assert!(differs(&site, "film", "x_m", &xs) < 0.01, "{:?}", column(&site, "film", "x_m"));
    let yaws = column(&site, "film", "yaw_deg");
    assert!((yaws[6]).abs() < 1e-6 && (yaws[8] - 20.0).abs() < 1e-6, "{yaws:?}");
    let fields = column(&site, "film", "hfov_deg");
    assert!((fields[0] - 60.0).abs() < 1e-9 && fields[4] < 36.0 && fields[6] == 60.0, "{fields:?}");

    // Whoever is within a body sees it, unless cameras aboard are not to.
    let seen = |folder: &str| fs::read(site.path().join(folder).join("0001.png")).expect("a frame");
    for (folder, key) in [("within", "true"), ("without", "false")] {
        let body = format!(
            "[[object]]\nname = \"it\"\nshape = \"sphere\"\nradius_m = 9\ntrack = \"climb.csv\"\nfrom_aboard = {key}\n"
        );
        fs::write(site.path().join("body.toml"), body).expect("a scene");
        render(&site, "--scene body.toml --speed 100x", folder);
        render(&site, "--scene body.toml --speed 100x --chase 60,15", &format!("behind-{folder}"));
    }
    render(&site, "--speed 100x", "alone");
    let pixels =
        |folder: &str| image::load_from_memory(&seen(folder)).expect("a picture").to_rgb8().into_raw();
    assert!(pixels("without") == pixels("alone") && pixels("within") != pixels("alone"));
    assert_eq!(pixels("behind-without"), pixels("behind-within"));

    // Flags go before what the scene says.
    render(&site, "--scene film.toml --speed 10x --pitch -5", "flag");
    assert!(differs(&site, "flag", "x_m", &[800.0; 11]) < 1e-6);
}

#[test]
fn cameras_that_see_nothing_are_refused_with_their_line() {
    let site = site();

    // Each is refused at its line, with a word of what is wrong.
    for (table, word) in [
        ("chase_m = [1]", "[back, up]"),
        ("chase_m = [0, 0]", "not all 0"),
        ("chase_m = [1e7, 0]", "a million"),
        ("orbit_m = [0, 5]", "radius above 0"),
        ("orbit_m = [9, 5]\nturn_s = 0", "1 or more"),
        ("turn_s = 9", "turn_s says nothing"),
        ("chase_m = [9, 9]\norbit_m = [9, 5]", "one of chase_m"),
        ("at = [1, 2, 3]", "looks nowhere"),
        ("at = [1, 2, 3]\nlook = \"ahead\"", "looks nowhere"),
        ("at = [1, 2]\nyaw_deg = 0", "at must be"),
        ("at_lonlat = [500, 91, 0]\nyaw_deg = 0", "longitude, latitude"),
        ("key = [{ t_s = 1, at = [1, 2, 3] }]", "looks nowhere"),
        ("key = [{ t_s = -1, at = [1, 2, 3], yaw_deg = 0 }]", "0 or more"),
        (
            "key = [{ t_s = 9, at = [1, 2, 3], yaw_deg = 0 }, { t_s = 9, at = [1, 2, 3], yaw_deg = 0 }]",
            "order of their times",
        ),
        ("key = [{ t_s = 9, yaw_deg = 0 }]", "needs at or at_lonlat"),
        ("key = []", "one pose or more"),
        ("at = [1, 2, 3]\nyaw_deg = 9\nlook_at = [4, 5, 6]", "yaw_deg says nothing"),
        ("look_at = [4, 5, 6]\nkey = [{ t_s = 9, at = [1, 2, 3], roll_deg = 0 }]", "roll_deg says nothing"),
        (
            "hfov_deg = 40\nkey = [{ t_s = 9, at = [1, 2, 3], yaw_deg = 0, hfov_deg = 50 }]",
            "hfov_deg says nothing",
        ),
        ("look = \"up\"", "ahead"),
        ("look = \"down\"\nlook_at = [1, 2, 3]", "looks one way"),
        ("look_at_object = \"nobody\"", "no object `nobody`"),
        ("look = \"down\"\npitch_deg = 3", "leave one"),
        ("hfov_deg = 176", "between 0.01 and 175"),
        ("hfov_deg = [60, 0]", "between 0.01 and 175"),
        ("hfov_deg = [60, 30, 10]", "two of them"),
        ("ease = \"in-out\"", "ease says nothing"),
        ("yaw_deg = 3", "yaw_deg says nothing"),
        ("from_s = -1", "0 or more"),
        ("from_s = nan", "from_s"),
        ("[[camera]]\nfrom_s = 0", "begin after"),
        ("zoom = 3", "zoom"),
    ] {
        fs::write(site.path().join("bad.toml"), format!("# A film.\n[[camera]]\n{table}\n"))
            .expect("a scene");
        let said = ends(&run(&site, "scene check bad.toml"), 3);
        let line = (2..=4).any(|line| said.contains(&format!("line {line}")));
        assert!(said.contains(word) && line && said.contains("bad.toml"), "{table}: {said}");
    }
}

#[test]
fn what_is_no_film_is_told_in_a_sentence() {
    let site = site();
    for (flags, word) in [
        ("--speed 0x", "30x"),
        ("--speed 2x --duration 9s", "cannot be used"),
        ("--duration 0", "above 0"),
        ("--from 200", "lasts 100.0 s, from 14:00:00 to 14:01:40 UTC"),
        ("--from 50 --to 20s", "before --from"),
        ("--to 13:00", "--to lies outside"),
        ("--pitch 91", "-90"),
        ("--look up", "want ahead"),
        ("--look down --pitch 3", "cannot be used"),
        ("--look-at nobody", "no --scene"),
        ("--look-at 1,2,3,4", "want a place"),
        ("--look-at 7", "want a place"),
        ("--look-at-lonlat", "--look-at"),
        ("--look-at 7.5,46.2 --look-at-lonlat", "local metres"),
        ("--look-at 1,1000000", "altitude above sea level"),
        ("--chase 60", "60,15"),
        ("--chase 600,15", "nearer"),
        ("--chase 60,15 --orbit 60,15", "cannot be used"),
        ("--orbit 0,15", "radius above 0"),
        ("--chase 60,15 --screen orthographic --ground-width 100", "a map is seen"),
    ] {
        let said = ends(&run(&site, &format!("render area.hop --path climb.csv {flags} -o f/####.png")), 2);
        assert!(said.contains(word), "{flags}: {said}");
    }
    let wide = "time_s,x_m,y_m,alt_msl_m,yaw_deg,hfov_deg\n0,800,800,200,0,60\n9,800,900,200,0,178\n";
    fs::write(site.path().join("wide.csv"), wide).expect("a path");
    let said = ends(&run(&site, "render area.hop --path wide.csv --fps 1 -o f/####.png"), 2);
    assert!(said.contains("frame 10") && said.contains("175"), "{said}");
    let single = run(&site, "render area.hop --eye 800,800,300 --speed 2x -o view.png");
    assert!(ends(&single, 2).contains("cannot be used"));
}

/// Writes a flight of ten fixes to the north at 12 m/s, with further columns.
fn write_flight(site: &TempDir, name: &str, columns: &str, cells: impl Fn(u32) -> String) {
    let row = |fix: u32| format!("{},800,{},120{}\n", 10 * fix, 200 + 120 * fix, cells(fix));
    let rows: String = (0..=10).map(row).collect();
    fs::write(site.path().join(name), format!("t,x_m,y_m,alt_msl_m{columns}\n{rows}")).expect("a path");
}

#[test]
fn columns_of_a_path_say_what_flags_say() {
    let site = site();
    write_flight(&site, "plain.csv", "", |_| String::new());
    for (number, (columns, cells, flags)) in [
        (",look_pitch_deg", ",-20", "--pitch -20"),
        (",look_ahead_s", ",5", "--look 5s"),
        (",chase_back_m,chase_up_m,chase_side_m", ",60,15,20", "--chase 60,15,20"),
        (",Chase_Back_M,chase_up_m", ",60,15", "--chase 60,15"),
        (",orbit_radius_m,orbit_up_m,orbit_turn_s", ",150,40,20", "--orbit 150,40,20"),
        (",look_at_x_m,look_at_y_m,look_at_z_m", ",1000,800,60", "--look-at 1000,800,60"),
        (",look_at_x_m,look_at_y_m", ",1000,800", "--look-at 1000,800"),
    ]
    .into_iter()
    .enumerate()
    {
        write_flight(&site, "columns.csv", columns, |_| cells.to_owned());
        let render = |path: &str, flags: &str, folder: &str| {
            let flight = format!("render area.hop --path {path} --size 32x18 --fps 1 --speed 10x {flags}");
            ends(&run(&site, &format!("{flight} -o {folder}/####.png")), 0);
            (1..=11u32)
                .map(|frame| {
                    let path = site.path().join(format!("{folder}/{frame:04}.png"));
                    hedgehop::encode::read_picture(&path).expect("a picture").rgb
                })
                .collect::<Vec<_>>()
        };
        let by_columns = render("columns.csv", "", &format!("columns{number}"));
        assert!(by_columns == render("plain.csv", flags, &format!("flags{number}")), "{columns}");
        // Flags go before columns.
        let flagged = render("columns.csv", "--pitch -50", &format!("pitched{number}"));
        assert!(flagged == render("plain.csv", "--pitch -50", &format!("plain{number}")), "{columns}");
    }
}

#[test]
fn columns_cut_where_they_change_and_move_what_is_looked_at() {
    let site = site();
    // Aboard at a pitch; then from behind; then aboard, looking at what goes to the west at 10 m/s.
    write_flight(
        &site,
        "shots.csv",
        ",look_pitch_deg,chase_back_m,chase_up_m,look_at_x_m,look_at_y_m",
        |fix| match fix {
            0..=2 => ",-30,,,,".into(),
            3..=5 => ",,50,10,,".into(),
            _ => format!(",,,,{},1000", 1600 - 100 * (fix - 6)),
        },
    );
    let flight = "render area.hop --path shots.csv --size 16x9 --fps 1 --speed 5x -o shots/####.png";
    ends(&run(&site, flight), 0);
    let (y, pitch, yaw) = (
        column(&site, "shots", "y_m"),
        column(&site, "shots", "pitch_deg"),
        column(&site, "shots", "yaw_deg"),
    );
    assert!(
        (0..6).all(|frame| pitch[frame] == -30.0 && (y[frame] - 200.0 - 60.0 * frame as f64).abs() < 0.01)
    );
    assert!((6..12).all(|frame| (y[frame] - 150.0 - 60.0 * frame as f64).abs() < 0.01), "{y:?}");
    for (frame, yaw) in yaw.iter().enumerate().skip(12) {
        let subject = 1600.0 - 50.0 * (frame - 12) as f64;
        let expected = (subject - 800.0).atan2(1000.0 - 200.0 - 60.0 * frame as f64).to_degrees();
        assert!((yaw - expected).abs() < 0.1, "{frame}: {yaw} {expected}");
    }
}

#[test]
fn columns_of_cameras_that_say_nothing_sound_are_refused() {
    let site = site();
    for (columns, cells, part) in [
        (",look_at_x_m", ",5", "line 2: look_at_x_m needs look_at_y_m beside it"),
        (",look_at_x_m,look_at_y_m", ",5,", "look_at_x_m needs look_at_y_m"),
        (",look_at_z_m", ",5", "look_at_z_m needs look_at_x_m"),
        (",look_at_x_m,look_at_y_m", ",5,x", "line 2: column look_at_y_m: \"x\" is no number"),
        (",look_at_x_m,look_at_y_m", ",5,nan", "is no number"),
        (",look_at_x_m,look_at_y_m", ",5,1e30", "too far away"),
        (",look_at_lon_deg,look_at_lat_deg", ",5,95", "must lie on the Earth"),
        (",look_ahead_s", ",-1", "0 to 3600 seconds"),
        (",look_pitch_deg", ",91", "-90 to 90 degrees"),
        (",look_pitch_deg,look_ahead_s", ",1,1", "both say where the view goes"),
        (",chase_back_m", ",50", "chase_back_m needs chase_up_m"),
        (",chase_back_m,chase_up_m", ",0,0", "not all 0"),
        (",orbit_radius_m,orbit_up_m", ",0,5", "orbit_radius_m must be metres above 0"),
        (",orbit_radius_m,orbit_up_m,orbit_turn_s", ",50,5,0.5", "1 or more either way"),
        (",chase_back_m,chase_up_m,orbit_radius_m,orbit_up_m", ",50,5,50,5", "both say where the eye is"),
    ] {
        write_flight(&site, "wrong.csv", columns, |_| cells.to_owned());
        let said =
            run(&site, "render area.hop --path wrong.csv --size 16x9 --fps 1 --frames 1 -o no/####.png");
        let said = ends(&said, 3);
        assert!(said.contains("wrong.csv") && said.contains(part), "{columns}: {said}");
    }
}
