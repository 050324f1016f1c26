//! `build --cloud` and `[[cloud]]` from outside.

use std::fs;

use tempfile::TempDir;

use crate::common::{ends, run};

/// A LAS 1.2 file of points of format 0: places in centimetres from (500000, 5000000, 0), and classes. It states no reference system.
fn las(points: &[([i32; 3], u8)]) -> Vec<u8> {
    let mut bytes = vec![0; 227];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, b"LASF");
    put(24, &[1, 2]);
    put(94, &227_u16.to_le_bytes());
    put(96, &227_u32.to_le_bytes());
    put(105, &20_u16.to_le_bytes());
    put(107, &(points.len() as u32).to_le_bytes());
    let offset = [500_000.0, 5_000_000.0, 0.0_f64];

    for axis in 0..3 {
        put(131 + 8 * axis, &0.01_f64.to_le_bytes());
        put(155 + 8 * axis, &offset[axis].to_le_bytes());
        let all = || points.iter().map(|(place, _)| 0.01 * f64::from(place[axis]) + offset[axis]);
        put(179 + 16 * axis, &all().fold(f64::MIN, f64::max).to_le_bytes());
        put(187 + 16 * axis, &all().fold(f64::MAX, f64::min).to_le_bytes());
    }

    for (place, class) in points {
        let mut record = [0; 20];
        for axis in 0..3 {
            record[4 * axis..4 * axis + 4].copy_from_slice(&place[axis].to_le_bytes());
        }
        // The first of one return.
        record[14] = 9;
        record[15] = *class;
        bytes.extend(record);
    }

    bytes
}

/// A folder with level ground of 50 m and a house of 8 m on it, four points on a square metre.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let points: Vec<_> = (0..120 * 120)
        .map(|index| {
            let [x, y] = [50 * (index % 120) + 13, 50 * (index / 120) + 31];
            let is_house = (2000..3200).contains(&x) && (2000..3000).contains(&y);
            ([x, y, if is_house { 5800 } else { 5000 }], if is_house { 6 } else { 2 })
        })
        .collect();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("a file");
    write("town.las", &las(&points));
    write("cut.las", &las(&points)[..9000]);
    write("place.toml", b"[place]\nspacing_m = 1\n[[cloud]]\nfile = \"town.las\"\ncrs = \"EPSG:32632\"\n");
    write("cut.toml", b"[[cloud]]\nfile = \"town.las\"\n\n[[cloud]]\nfile = \"cut.las\"\n");
    folder
}

#[test]
fn flags_and_recipes_build_the_same_whatever_the_workers() {
    let folder = site();
    let told = ends(&run(&folder, "recipe check place.toml"), 0);
    assert!(told.contains("60 x 60 voxels of 1 m"), "{told}");
    ends(&run(&folder, "build place.toml"), 0);
    let flags = "build --cloud town.las --cloud-crs EPSG:32632 --spacing 1";
    ends(&run(&folder, &format!("{flags} -o one.hop --jobs 1")), 0);
    ends(&run(&folder, &format!("{flags} -o three.hop --jobs 3 --memory 300M")), 0);
    let read = |name: &str| fs::read(folder.path().join(name)).expect("a database");
    assert!(read("one.hop") == read("three.hop"));
    let told = ends(&run(&folder, "verify place.hop"), 0);
    assert!(told.contains("sound"), "{told}");
    let told = ends(&run(&folder, "info place.hop"), 0);
    assert!(told.contains("LAS 1.2 of 14400 points") && told.contains("bare ground: 1 pages"), "{told}");
    let told = ends(&run(&folder, "height place.hop --xy 500026.5 5000024.5 500050 5000050"), 0);
    assert!(told.contains("58.0") && told.contains("50.0"), "{told}");
}

#[test]
fn spacing_follows_from_the_points_and_what_is_assumed_is_told() {
    let folder = site();
    let told = ends(&run(&folder, "build --cloud town.las -o town.hop"), 0);
    assert!(told.contains("good for voxels of 0.75 m") && told.contains("plain metres"), "{told}");
    // A cloud that is cut short is told with its table.
    let told = ends(&run(&folder, "recipe check cut.toml"), 3);
    assert!(told.contains("line 4") && told.contains("cut.las") && told.contains("holds 438"), "{told}");
    assert!(!told.contains("line 1"), "{told}");
    let told = ends(&run(&folder, "build --cloud cut.las -o cut.hop"), 3);
    assert!(told.contains("states 14400 points and holds 438"), "{told}");
    assert!(!folder.path().join("cut.hop").exists());
}

#[test]
fn a_cloud_is_seen_before_a_coarser_raster() {
    let folder = site();
    let rows = vec![vec!["44"; 40].join(" "); 40].join("\n");
    let head = "ncols 40\nnrows 40\nxllcorner 499980\nyllcorner 4999980\ncellsize 4\n";
    fs::write(folder.path().join("dem.asc"), format!("{head}{rows}\n")).expect("a file");
    let build = "build --cloud town.las --cloud-crs EPSG:32632 --elevation dem.asc --elevation-crs EPSG:32632 --spacing 1";
    ends(&run(&folder, &format!("{build} -o both.hop")), 0);
    let told =
        ends(&run(&folder, "height both.hop --xy 500026.5 5000024.5 500040 5000030 500100 5000100"), 0);
    assert!(told.contains("58.0") && told.contains("50.0") && told.contains("44.0"), "{told}");
}
