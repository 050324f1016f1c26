//! `overview`, `contact-sheet`, `compare` and folders of frames from outside.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use image::{Rgb, RgbImage};
use serde_json::Value;
use tempfile::TempDir;

use crate::common::{ends, run};
use hedgehop::voxel::{Arrays, Grid, Metadata, write_arrays};

struct Site(TempDir);

impl Site {
    /// A folder with a database, 1.6 km by 0.8 km, of a slope that is lit from the west, and a path over it.
    fn new() -> Self {
        let site = Self(TempDir::new().expect("a temporary folder"));
        let grid = Grid { nx: 160, ny: 80, spacing: 10.0, origin: glam::DVec2::ZERO };
        let heights: Vec<f64> = (0..160 * 80)
            .map(|post| f64::from(post % 160 / 40 % 2) * 3.0 * (40.0 - f64::from(post % 40)))
            .collect();
        let colours = vec![[90, 140, 60]; heights.len()];
        let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
        let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
        write_arrays(&site.path("area.hop"), &arrays, &metadata, false).expect("a database");
        let path = "t_s,x_m,y_m,alt_agl_m\n0,300,400,60\n10,700,420,60\n";
        fs::write(site.path("path.csv"), path).expect("a path");
        site
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, args: &str) -> Output {
        run(&self.0, args)
    }

    #[track_caller]
    fn ends(&self, args: &str, code: i32) -> String {
        ends(&self.run(args), code)
    }

    fn picture(&self, name: &str) -> RgbImage {
        image::open(self.path(name)).expect("a picture").into_rgb8()
    }

    /// A folder of so many grey frames.
    fn frames(&self, folder: &str, shades: &[u8]) {
        fs::create_dir(self.path(folder)).expect("a folder");
        for (number, shade) in (1..).zip(shades) {
            let picture = RgbImage::from_pixel(64, 36, Rgb([*shade; 3]));
            picture.save(self.path(&format!("{folder}/{number}.png"))).expect("a frame");
        }
    }
}

/// How many pixels are nearly of a colour.
fn count(picture: &RgbImage, colour: [u8; 3]) -> usize {
    let is_near = |pixel: &&Rgb<u8>| pixel.0.iter().zip(colour).all(|(own, other)| own.abs_diff(other) < 8);
    picture.pixels().filter(is_near).count()
}

const PATH: [u8; 3] = [226, 60, 30];
const START: [u8; 3] = [40, 150, 70];

#[test]
fn overviews_show_the_area_and_the_flight() {
    let site = Site::new();
    let text = site.ends("overview area.hop -o whole.png --size 400", 0);
    assert!(text.contains("400x200 pixels of 4 m"), "{text}");
    let whole = site.picture("whole.png");
    assert_eq!((whole.dimensions(), count(&whole, PATH)), ((400, 200), 0));
    // Slopes that fall to the east lie away from the sun in the north-west, steps up to them are lit.
    let light = |x: u32| u32::from(whole.get_pixel(x, 40).0[1]);
    assert!(light(150) < light(50), "{} {}", light(150), light(50));
    let text = site.ends("overview area.hop --path path.csv -o flight.png --size 400 --footprints 2", 0);
    let flight = site.picture("flight.png");
    // 400 m and the least of it, 100 m, on either side.
    assert!(text.contains("400x250 pixels of 1.5 m"), "{text}");
    assert!(count(&flight, PATH) > 100 && count(&flight, START) > 20, "{text}");
    let bare = site.ends("overview area.hop --path path.csv -o bare.png --size 400 --footprints 0 -j 1", 0);
    assert!(bare.contains("bare.png") && site.picture("bare.png") != flight);
    site.ends("overview area.hop --path path.csv -o again.png --size 400 --footprints 2 -j 3", 0);
    assert!(site.picture("again.png") == flight, "the number of workers changes it");
}

#[test]
fn overviews_that_cannot_be_are_refused_before_any_work() {
    let site = Site::new();
    assert!(site.ends("overview area.hop -o map.svg", 2).contains("map.png"));
    assert!(site.ends("overview none.hop -o map.png", 5).contains("none.hop"));
    assert!(site.ends("overview area.hop --path none.csv -o map.png", 5).contains("none.csv"));
    site.ends("overview area.hop -o map.png --size 9", 2);
    fs::rename(site.path("path.csv"), site.path("path.png")).expect("a path");
    assert!(site.ends("overview area.hop --path path.png -o path.png", 2).contains("input"));
    assert!(!site.path("map.png").exists());
}

#[test]
fn sheets_hold_frames_in_the_order_of_their_numbers() {
    let site = Site::new();
    site.frames("frames", &[10, 30, 50, 70, 90, 110, 130, 150, 170, 190, 210]);
    let text = site.ends("contact-sheet frames -o frames/sheet.png --count 3 --columns 2 --width 64", 0);
    assert!(text.contains("3 frames on frames/sheet.png, 152x110 pixels"), "{text}");
    // Repeated, the sheet is not one of the frames.
    site.ends("contact-sheet frames -o frames/sheet.png --count 3 --columns 2 --width 64", 0);
    let sheet = site.picture("frames/sheet.png");
    let shade = |x: u32, y: u32| sheet.get_pixel(x, y).0[0];
    assert_eq!([shade(40, 20), shade(110, 20), shade(40, 75)], [10, 110, 210]);
    assert!(site.ends("contact-sheet none -o sheet.png", 5).contains("none"));
    assert!(site.ends("contact-sheet frames -o sheet.jpg", 2).contains("sheet.png"));
    fs::create_dir(site.path("empty")).expect("a folder");
    assert!(site.ends("contact-sheet empty -o sheet.png", 3).contains("no .png"));
    assert!(site.ends("contact-sheet frames path.csv -o sheet.png", 2).contains("film"));
    assert!(!site.path("sheet.png").exists());
}

/// A flight of eleven small frames.
const FLY: &str = "render area.hop --path path.csv --fps 1 --size 32x18 -o f/####.png";

#[test]
fn frames_of_another_render_are_not_replaced_unless_asked_for() {
    let site = Site::new();
    let fly = |more: &str, code: i32| site.ends(&format!("{FLY} {more}"), code);
    let all = || {
        let names = ["f/0003.png", "f/0011.png", "f/manifest.json", "f/poses.csv"];
        names.map(|name| fs::read(site.path(name)).expect("a file"))
    };
    let rows = || fs::read_to_string(site.path("f/poses.csv")).expect("poses").lines().count();
    fly("", 0);
    let before = all();

    for more in ["", "--skip-existing"] {
        let text = fly(&format!("--frames 3 --visibility 500 {more}"), 2);
        for part in ["frames 1-11 of another render", "visibility_m is 40000.0, not 500.0", "--overwrite"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(all() == before);
    }

    // A part of the same flight joins the others.
    fly("--frames 3", 0);
    assert_eq!(rows(), 12);

    let text = fly("--frames 3 --visibility 500 --overwrite", 0);
    assert!(text.contains("10 frames of another render stay in f"), "{text}");
    assert!(rows() == 2 && all()[0] != before[0]);

    // One file is listed now, and those beside it say themselves what they are.
    assert!(fly("--frames 2 --visibility 500", 2).contains("0002.png is of another render"));
    assert!(fly("--skip-existing --visibility 500", 0).contains("kept 1"));
    assert_eq!(rows(), 12);

    // Others' names stand in nobody's way, and the list stays whose it is.
    let aside = FLY.replace("f/####", "f/aside-####");
    let text = site.ends(&format!("{aside} --frames 4-5 --visibility 900"), 0);
    assert!(text.contains("do not list these frames: visibility_m is 500.0, not 900.0"), "{text}");
    assert_eq!(rows(), 12);
    let look = "render area.hop --eye 410,400,120 --size 32x18 -o";
    assert!(site.ends(&format!("{look} f/0003.png"), 2).contains("0003.png is a frame of a flight"));
    site.ends(&format!("{look} f/0033.png"), 0);
    site.ends(&format!("{look} f/0033.png --visibility 500"), 0);
}

#[test]
fn folders_of_frames_are_verified() {
    let site = Site::new();
    site.ends(FLY, 0);
    assert!(site.ends("verify f", 0).contains("f: 11 frames checked, sound"));
    let whole = fs::read(site.path("f/0003.png")).expect("a frame");
    fs::write(site.path("f/0003.png"), &whole[..whole.len() - 20]).expect("a frame");
    fs::remove_file(site.path("f/0005.png")).expect("a frame");
    fs::copy(site.path("f/0008.png"), site.path("f/0007.png")).expect("a frame");
    let text = site.ends("verify f", 6);
    assert!(text.contains("3 with problems; render them again with --frames 3,5,7\n"), "{text}");
    let output = site.run("verify f --json");
    let found: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!((&found["sound"], &found["problems"][1]["frame"]), (&Value::Bool(false), &Value::from(5)));
    site.ends(&format!("{FLY} --frames 3,5,7"), 0);
    site.ends("verify f", 0);

    // What a killed run leaves has no manifest.
    fs::remove_file(site.path("f/manifest.json")).expect("a manifest");
    fs::remove_file(site.path("f/0004.png")).expect("a frame");
    let text = site.ends("verify f", 0);
    assert!(text.contains("there are no frames 4\n") && text.contains("no manifest"), "{text}");
    fs::create_dir(site.path("empty")).expect("a folder");
    assert!(site.ends("verify empty", 3).contains("empty"));
}

#[test]
fn eyes_below_the_ground_are_refused() {
    let site = Site::new();
    let look = "render area.hop --eye 410,400,20 --size 32x18 -o v.png";
    let text = site.ends(look, 2);
    assert!(text.contains("m below the ground") && text.contains("--clearance"), "{text}");
    assert!(!site.path("v.png").exists());
    assert!(site.ends(&format!("{look} --allow-below-ground"), 0).contains("m below the ground"));
    site.ends(&format!("{look} --clearance 2"), 0);
    site.ends("render area.hop --eye 410,400,0 --alt-mode agl --size 32x18 -o on.png", 0);

    let path = "t_s,x_m,y_m,alt_msl_m\n0,300,400,60\n10,700,400,60\n";
    fs::write(site.path("path.csv"), path).expect("a path");
    let text = site.ends(FLY, 2);
    assert!(text.contains("the eye of frame ") && text.contains(" of 11 frames do"), "{text}");
}

#[test]
fn sheets_of_films_need_ffmpeg_and_say_so() {
    let site = Site::new();
    site.frames("frames", &[10, 30, 50]);
    let has_ffmpeg =
        Command::new("ffmpeg").arg("-version").output().is_ok_and(|output| output.status.success());
    if !has_ffmpeg {
        fs::write(site.path("film.mp4"), b"film").expect("a film");
        let text = site.ends("contact-sheet film.mp4 -o sheet.png", 4);
        assert!(text.contains("apt-get install ffmpeg"), "{text}");
        return;
    }

    // Of a longer film not all frames are held, and those between the first and the last may be a neighbour.
    let render = "render area.hop --path path.csv --fps 4 --frames 1-12 --size 64x36 -o flight/####.png";
    site.ends(&format!("{render} --video film.mkv"), 0);
    site.ends("contact-sheet film.mkv -o film.png --count 4 --width 64", 0);
    site.ends("contact-sheet flight -o flight.png --count 4 --width 64", 0);
    let (film, flight) = (site.picture("film.png"), site.picture("flight.png"));
    assert_eq!(film.dimensions(), flight.dimensions());

    // All pictures are those of the flight, as well as the film's codec has them; numbers too.
    let differs = |x: u32, y: u32| film.get_pixel(x, y).0[1].abs_diff(flight.get_pixel(x, y).0[1]) > 40;
    let wrong = (0..film.width())
        .flat_map(|x| (0..film.height()).map(move |y| (x, y)))
        .filter(|(x, y)| differs(*x, *y));
    assert!(wrong.count() < 60);
    fs::write(site.path("cut.mp4"), b"film").expect("a film");
    assert!(site.ends("contact-sheet cut.mp4 -o sheet.png", 3).contains("ffmpeg could not decode"));
}

#[test]
fn comparisons_tell_figures_and_show_what_differs() {
    let site = Site::new();
    site.frames("a", &[100, 100, 100]);
    site.frames("b", &[100, 104, 100]);
    fs::copy(site.path("a/1.png"), site.path("b/7.png")).expect("a frame");
    let text = site.ends("compare a b -o out --amplify 10 --html page/view.html", 0);
    let row = |name: &str| {
        let line = text.lines().find(|line| line.split_whitespace().next() == Some(name));
        line.expect("a row").split_whitespace().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(row("1"), ["same", "0", "0.0000", "0.0000"]);

    // 20 log10(255 / 4), and of three frames together a third of the squares.
    assert_eq!(row("2"), ["36.09", "4", "4.0000", "100.0000"]);
    assert_eq!(row("all"), ["40.86", "4", "1.3333", "33.3333"]);
    assert!(text.contains("7.png") && text.contains("one of the folders"), "{text}");
    let panels = site.picture("out/2.png");
    let (step, middle) = (72, panels.height() - 20);
    assert_eq!([0, 1, 2].map(|panel| panels.get_pixel(40 + panel * step, middle).0[0]), [100, 104, 40]);
    let page = fs::read_to_string(site.path("page/view.html")).expect("a page");
    assert!(page.contains("data:image/png;base64,") && page.matches("\"a\":\"iVBORw0KGgo").count() == 3);
    let json = site.run("compare a/1.png b/2.png --json");
    let json: Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert_eq!((&json["all"]["max"], &json["frames"][0]["name"]), (&4.into(), &"1.png".into()));
    assert!((json["all"]["psnr_db"].as_f64().expect("a number") - 36.0896).abs() < 1e-3);
}

#[test]
fn comparisons_that_make_no_sense_are_refused() {
    let site = Site::new();
    site.frames("a", &[100]);
    fs::create_dir(site.path("b")).expect("a folder");
    RgbImage::new(32, 36).save(site.path("b/1.png")).expect("a frame");
    let text = site.ends("compare a b -o out", 3);
    assert!(text.contains("64x36") && text.contains("32x36"), "{text}");
    assert!(site.ends("compare a b/1.png", 2).contains("two of a kind"));
    assert!(site.ends("compare a/1.png b/1.png -o a/1.png", 2).contains("input"));
    assert!(site.ends("compare a b -o b", 2).contains("input"));
    assert!(site.ends("compare a none.png", 2).contains("two of a kind"));
    assert!(site.ends("compare a/1.png none.png", 5).contains("none.png"));
    fs::rename(site.path("b/1.png"), site.path("b/2.png")).expect("a frame");
    assert!(site.ends("compare a b", 2).contains("same name"));
}

#[test]
fn the_manual_and_the_help_name_every_flag() {
    let (site, manual) = (Site::new(), include_str!("../../../../docs/cli.md"));
    let sheets = ["overview", "contact-sheet", "compare", "bake"];
    let maps = ["hillshade", "contours", "continuity", "extract", "merge"];
    for command in sheets.into_iter().chain(maps) {
        let help = site.ends(&format!("{command} --help"), 0);
        assert!(help.contains("Example") && help.contains("130  interrupted"), "{command}: {help}");
        let flags =
            help.lines().filter(|line| line.trim_start().starts_with('-')).flat_map(str::split_whitespace);
        for flag in flags.filter(|word| word.starts_with("--")) {
            let flag = flag.trim_end_matches([',', '.', ';', ':']);
            assert!(manual.contains(flag), "docs/cli.md does not mention {flag} of {command}");
        }
    }
}
