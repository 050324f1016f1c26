//! `hillshade`, `contours`, `continuity` and `extract` from outside, on ground that has closed forms.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::common::{ends, run};
use hedgehop_modeling::raster::{ImageryRaster, OpenOptions, Window, open};

const SIDE: i32 = 300;

/// A folder with a database of 300 × 300 voxels of 10 m in a zone of UTM, by the height of each.
fn site(height: impl Fn(f64, f64) -> f64) -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let row = |y: i32| {
        (0..SIDE)
            .map(|x| format!("{:.4}", height(10.0 * f64::from(x) + 5.0, 10.0 * f64::from(y) + 5.0)))
            .collect::<Vec<_>>()
            .join(" ")
    };
    let rows: Vec<String> = (0..SIDE).rev().map(row).collect();
    let head = "ncols 300\nnrows 300\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\nnodata_value -9999\n";
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).expect("a file");
    write("dem.asc", format!("{head}{}\n", rows.join("\n")));
    write("place.toml", "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n".into());
    ends(&run(&folder, "build place.toml"), 0);
    folder
}

fn plane() -> TempDir {
    site(|x, y| 200.0 + 0.3 * x - 0.2 * y)
}

/// Hills of several sizes, without an edge.
fn hills(x: f64, y: f64) -> f64 {
    let waves = [(900.0, 0.3), (400.0, 1.4), (170.0, 2.6)];
    let wave = |(length, turn): (f64, f64)| {
        0.03 * length * (std::f64::consts::TAU * (x * turn.cos() + y * turn.sin()) / length).sin()
    };
    500.0 + waves.into_iter().map(wave).sum::<f64>()
}

fn picture(path: &Path) -> image::DynamicImage {
    image::open(path).expect("a picture")
}

#[test]
fn a_plane_has_one_shade_in_all_formats_and_sizes() {
    let folder = plane();
    // cos i = (s.z − s.x·p − s.y·q) / √(1 + p² + q²) of a sun in the north-west, half way up.
    let (half, p, q) = (0.5, 0.3, -0.2);
    let light = (0.5_f64.sqrt() + half * p - half * q) / (1.0_f64 + p * p + q * q).sqrt();
    let wanted = 1 + (light * 254.0).round() as u8;

    for flags in ["", "--level 4", "--pixel 7", "--bbox 500500,5000500,501500,5001200"] {
        ends(&run(&folder, &format!("hillshade place.hop -o shade.png {flags}")), 0);
        let shade = picture(&folder.path().join("shade.png")).into_luma_alpha8();
        // Beyond the outermost posts the ground is level: pixels that are no voxels see it.
        let rim = if flags.contains("pixel") { 2 } else { 0 };
        let is_inside = |at: u32, size: u32| (rim..size - rim).contains(&at);
        let inside = shade
            .enumerate_pixels()
            .filter(|(x, y, _)| is_inside(*x, shade.width()) && is_inside(*y, shade.height()));
        let far = inside.filter(|(.., pixel)| pixel[0].abs_diff(wanted) > 1).count();
        assert!(far == 0 && shade.pixels().all(|pixel| pixel[1] == 255), "{flags}: {far}, not {wanted}");
    }

    let told = ends(&run(&folder, "hillshade place.hop -o shade.tif"), 0);
    assert!(told.contains("300x300 pixels of 10 m"), "{told}");

    // The program reads its own map: shades as heights, where they are.
    ends(&run(&folder, "build --elevation shade.tif -o shade.hop"), 0);
    let told = ends(&run(&folder, "height shade.hop 501500 5001500 --xy --json"), 0);
    let told: Value = serde_json::from_str(&told).expect("JSON");
    let height = told.pointer("/0/height_m").and_then(Value::as_f64).expect("a height");
    assert!((height - f64::from(wanted)).abs() <= 1.0, "{told}");
    let told = ends(&run(&folder, "info shade.hop"), 0);
    assert!(
        told.contains("x 500000.0 to 503000.0, y 5000000.0 to 5003000.0") && told.contains("32632"),
        "{told}"
    );

    // The sun at the side, raised ground, and colours.
    ends(&run(&folder, "hillshade place.hop -o low.png --sun 90,10 --exaggeration 3 --colour"), 0);
    let low = picture(&folder.path().join("low.png")).into_rgba8();
    assert!(low.pixels().all(|pixel| pixel[3] == 255));
    let world = fs::read_to_string(folder.path().join("shade.pgw")).expect("a world file");
    let numbers: Vec<f64> = world.lines().map(|line| line.parse().expect("a number")).collect();
    assert_eq!(numbers, [10.0, 0.0, 0.0, -10.0, 500_505.0, 5_001_195.0]);
    let projection = fs::read_to_string(folder.path().join("shade.prj")).expect("a .prj");
    assert!(projection.starts_with("PROJCS[") && projection.contains("PARAMETER[\"Central_Meridian\",9.0]"));
}

#[test]
fn hillshades_refuse_what_makes_no_sense() {
    let folder = plane();
    for (args, code, words) in [
        ("-o shade.gif", 2, ".tif or a .png"),
        ("-o place.hop", 2, ".tif or a .png"),
        ("-o shade.png --bbox 0,0,10,10", 2, "outside the area"),
        ("-o shade.png --level 3", 2, "levels 1, 4, 16, 64"),
        ("-o shade.png --pixel 0.05", 2, "give --pixel"),
        ("-o shade.png --pixel 1e9", 2, "far wider than the coarsest voxels"),
        ("-o shade.png --pixel 0", 2, "above 0"),
        ("-o shade.png --sun 90,-5", 2, "above the horizon"),
        ("-o place.toml/shade.png", 5, "place.toml"),
    ] {
        let told = ends(&run(&folder, &format!("hillshade place.hop {args}")), code);
        assert!(told.contains(words), "{args}: {told}");
    }
    fs::rename(folder.path().join("place.hop"), folder.path().join("place.png")).expect("a rename");
    let told = ends(&run(&folder, "hillshade place.png -o place.png"), 2);
    assert!(told.contains("input"), "{told}");
}

#[test]
fn contour_lines_of_a_cone_are_circles_in_degrees() {
    let folder = site(|x, y| 900.0 - 0.5 * ((x - 1500.0).powi(2) + (y - 1500.0).powi(2)).sqrt());
    let told = ends(&run(&folder, "contours place.hop -o lines.geojson --interval 50 --index 4"), 0);
    assert!(told.contains("every 50 m"), "{told}");
    let text = fs::read_to_string(folder.path().join("lines.geojson")).expect("lines");
    let lines: Value = serde_json::from_str(&text).expect("GeoJSON");
    let features = lines["features"].as_array().expect("features");
    let mut rings = 0;

    for feature in features {
        let elevation = feature["properties"]["elevation"].as_f64().expect("an elevation");
        assert_eq!(feature["properties"]["index"], (elevation / 50.0) as i64 % 4 == 0);
        let points = feature["geometry"]["coordinates"].as_array().expect("points");

        // Near the zone's meridian, so many metres to the degree.
        let (east, north) = (78_846.8 / 0.9996, 111_136.0 / 0.9996);
        if points.first() == points.last() && elevation > 200.0 {
            rings += 1;
            let place = |point: &Value| {
                let at = |axis: usize| point[axis].as_f64().expect("degrees");
                [at(0) * east, at(1) * north]
            };
            let all: Vec<[f64; 2]> = points.iter().map(place).collect();

            let radius = |axis: usize| {
                let ends = all
                    .iter()
                    .map(|at| at[axis])
                    .fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)]);
                0.5 * (ends[1] - ends[0])
            };

            let wanted = (900.0 - elevation) / 0.5;
            for axis in 0..2 {
                assert!(
                    (radius(axis) / wanted - 1.0).abs() < 0.005 + 5.0 / wanted,
                    "{elevation}: {}",
                    radius(axis)
                );
            }
        }
    }

    assert_eq!(rings, 13);
    let told = ends(&run(&folder, "contours place.hop -o map.png --size 500"), 0);
    assert!(told.contains("map.png"), "{told}");
    let map = picture(&folder.path().join("map.png")).into_rgb8();
    assert_eq!(map.dimensions(), (500, 500));

    // Brown lines, and the sun from the north-west.
    let is_brown = |pixel: &&image::Rgb<u8>| pixel[0] > pixel[2].saturating_add(60);
    assert!(map.pixels().filter(is_brown).count() > 1500);
    let mean = |x: u32, y: u32| {
        let near = (0..60).flat_map(|down| (0..60).map(move |right| (x + right, y + down)));
        near.map(|(x, y)| u32::from(map.get_pixel(x, y)[2])).sum::<u32>() / 3600
    };
    assert!(mean(100, 100) > mean(340, 340) + 20);
    assert!(folder.path().join("map.pgw").exists());

    for (args, words) in [
        ("-o lines.svg", ".geojson, or a map, .tif or .png"),
        ("-o lines.geojson --interval 0", "above 0"),
        ("-o lines.geojson --interval 0.00001", "larger --interval"),
        ("-o lines.geojson --bbox 0,0,1,1", "outside the area"),
        ("-o lines.geojson --index 0", "1..=1000"),
    ] {
        let told = ends(&run(&folder, &format!("contours place.hop {args}")), 2);
        assert!(told.contains(words), "{args}: {told}");
    }
}

#[test]
fn contour_maps_are_the_same_as_geotiff() {
    let folder = site(hills);
    let [drawn, tiff] = ["map.png", "map.tif"].map(|name| {
        // More than a tile, so that there are several, and an overview.
        let told = ends(&run(&folder, &format!("contours place.hop -o {name} --interval 20 --size 600")), 0);
        assert!(told.contains(name) && told.contains("every 20 m"), "{told}");
        folder.path().join(name)
    });
    let drawn = picture(&drawn).into_rgb8();
    let raster = open(&tiff, &OpenOptions::default()).expect("a GeoTIFF");
    let info = raster.info().clone();
    assert_eq!((info.width, info.height, info.bands, info.nodata), (600, 600, 3, None));
    assert_eq!(info.geo, Some([500_000.0, 5.0, 0.0, 5_003_000.0, 0.0, -5.0]));
    assert_eq!(info.crs.and_then(|crs| crs.epsg()), Some(32632));
    let mut read = Vec::new();
    let whole = Window { x: 0, y: 0, width: 600, height: 600 };
    ImageryRaster::new(raster, None).expect("a picture").read(whole, &mut read).expect("pixels");
    assert_eq!(read.len(), 360_000);

    // All of it is data, without an alpha channel, and no colour stands for none.
    let wanted = drawn.pixels().map(|pixel| pixel.0);
    assert!(read.iter().zip(wanted).all(|(read, wanted)| read[..3] == wanted && read[3] == 255));
    assert!(!folder.path().join("map.tfw").exists() && folder.path().join("map.pgw").exists());
    let told = ends(&run(&folder, "contours place.hop -o place.toml/map.tif"), 5);
    assert!(told.contains("place.toml"), "{told}");
    fs::rename(folder.path().join("place.hop"), folder.path().join("place.tif")).expect("a rename");
    let told = ends(&run(&folder, "contours place.tif -o place.tif"), 2);
    assert!(told.contains("input"), "{told}");
}

#[test]
fn planted_faults_are_told_and_sound_ground_passes() {
    let sound = site(hills);
    let told = ends(&run(&sound, "continuity place.hop -o faults.csv --picture faults.png --size 400"), 0);
    assert!(told.contains("spikes") && !told.contains("worst"), "{told}");
    assert_eq!(fs::read_to_string(sound.path().join("faults.csv")).expect("a table").lines().count(), 1);
    let planted = site(|x, y| {
        let spike = if (x, y) == (1205.0, 805.0) { 40.0 } else { 0.0 };
        let seam = if y > 2000.0 { 8.0 } else { 0.0 };
        hills(x, y) + spike + seam
    });
    let told = ends(&run(&planted, "continuity place.hop -o faults.csv --picture faults.png --size 400"), 6);
    assert!(told.contains("x 501205.0 y 5000805.0"), "{told}");
    let table = fs::read_to_string(planted.path().join("faults.csv")).expect("a table");
    let classes: Vec<&str> = table.lines().skip(1).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(classes, ["spikes", "seams"]);
    let map = picture(&planted.path().join("faults.png")).into_rgb8();

    // 1205 m from the west of 3000 m on 400 pixels.
    assert_eq!(map.get_pixel(160, 292).0, [214, 30, 30]);
    ends(&run(&planted, "continuity place.hop --fail-on pits,voids"), 0);
    ends(&run(&planted, "continuity place.hop --fail-on seams"), 6);

    for (args, words) in [
        ("-o faults.txt", "CSV"),
        ("--picture faults.jpg", "PNG"),
        ("--fail-on mistakes", "possible values"),
        ("--spike-factor 1", "above 1"),
    ] {
        let told = ends(&run(&planted, &format!("continuity place.hop {args}")), 2);
        assert!(told.contains(words), "{args}: {told}");
    }
}

#[test]
fn parts_are_sound_and_say_what_the_whole_says() {
    let folder = site(hills);
    let told = ends(&run(&folder, "extract place.hop --bbox 502000,5000100,502500,5000300 -o part.hop"), 0);
    assert!(
        told.contains("whole pages: x 500000.0 to 502560.0, y 5000000.0 to 5002560.0, 256 x 256 voxels"),
        "{told}"
    );
    let sound = ends(&run(&folder, "verify part.hop"), 0);
    assert!(sound.contains("sound"), "{sound}");
    let told =
        ends(&run(&folder, "extract place.hop --lon-lat 9.034,45.1775,9.037,45.1795 -o corner.hop"), 0);
    assert!(told.contains("44 x 44 voxels"), "{told}");
    ends(&run(&folder, "verify corner.hop"), 0);
    let height = |area: &str, place: &str| ends(&run(&folder, &format!("height {area} {place} --xy")), 0);
    for place in ["500005 5000005", "502503 5000111"] {
        assert_eq!(height("place.hop", place), height("part.hop", place));
    }

    for (args, words) in [
        ("--bbox 0,0,1,1 -o none.hop", "outside the area"),
        ("-o none.hop", "--bbox"),
        ("--bbox 500000,5000000,500001,5000001 -o part.hop", "--overwrite"),
        ("--bbox 500000,5000000,500001,5000001 -o place.hop --overwrite", "input"),
        ("--lon-lat 100,10,101,11 -o none.hop", "outside the area"),
    ] {
        let told = ends(&run(&folder, &format!("extract place.hop {args}")), 2);
        assert!(told.contains(words), "{args}: {told}");
    }
}

#[test]
fn parts_are_merged_to_the_whole_again() {
    let folder = site(hills);
    for (name, bounds) in
        [("west", "500000,5000000,502000,5003000"), ("east", "502600,5000000,503000,5003000")]
    {
        ends(&run(&folder, &format!("extract place.hop --bbox {bounds} -o {name}.hop")), 0);
    }

    let told = ends(&run(&folder, "merge west.hop east.hop -o whole.hop"), 0);
    assert!(told.contains("300 x 300 voxels of 10 m") && told.contains("join (300 voxels)"), "{told}");
    let sound = ends(&run(&folder, "verify whole.hop"), 0);
    assert!(sound.contains("sound"), "{sound}");
    for place in ["500005 5000005", "502555 5001111", "502565 5001111", "502990 5002990"] {
        let height = |area: &str| ends(&run(&folder, &format!("height {area} {place} --xy")), 0);
        assert_eq!(height("place.hop"), height("whole.hop"), "{place}");
    }

    ends(&run(&folder, "merge west.hop place.hop --feather 300 -o soft.hop"), 0);
    ends(&run(&folder, "verify soft.hop"), 0);
    for (args, words) in [
        ("west.hop -o none.hop", "2 values required"),
        ("west.hop east.hop -o east.hop --overwrite", "input"),
        ("west.hop east.hop -o whole.hop", "--overwrite"),
    ] {
        let told = ends(&run(&folder, &format!("merge {args}")), 2);
        assert!(told.contains(words), "{args}: {told}");
    }
}

#[test]
fn parts_of_corridors_keep_them() {
    let folder = site(hills);
    fs::write(
        folder.path().join("route.csv"),
        "time_s,x_m,y_m,alt_m\n0,500100,5000300,900\n10,500900,5000300,900\n",
    )
    .expect("a route");
    let build = "build --elevation dem.asc --elevation-crs EPSG:32632 --crs EPSG:32632 --corridor route.csv --width 200 --spacing 1 --outside 16 -o strip.hop";
    ends(&run(&folder, build), 0);
    let told = ends(&run(&folder, "extract strip.hop --bbox 500000,5000000,501000,5001000 -o part.hop"), 0);
    assert!(told.contains("whole pages: x 500000.0 to 501024.0"), "{told}");
    let sound = ends(&run(&folder, "verify part.hop"), 0);
    assert!(sound.contains("sound"), "{sound}");
    for place in ["500200 5000300", "500200 5000900"] {
        let height = |area: &str| ends(&run(&folder, &format!("height {area} {place} --xy")), 0);
        assert_eq!(height("strip.hop"), height("part.hop"));
    }

    let shade = ends(
        &run(&folder, "hillshade strip.hop --level 1 --bbox 500000,5000000,501000,5001000 -o shade.png"),
        0,
    );
    assert!(shade.contains("1000x1000"), "{shade}");
}
