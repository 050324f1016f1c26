//! Faults in a folder of finished frames: `verify-frames` lists exactly these, and `--repair` mends them.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::common::{ends, run};

/// Frames of the flight.
const FRAMES: u64 = 41;

/// A folder with a database of hills, a path over it, and frames of it in `f`, rendered by a farm's job.
fn site() -> TempDir {
    let folder = TempDir::new().expect("a temporary folder");
    let side = 200;
    let mut grid = format!("ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize 5\n");
    for row in 0..side {
        let height = |column: i32| {
            100.0 + 20.0 * (f64::from(column) * 0.1).sin() + 15.0 * (f64::from(row) * 0.07).cos()
        };
        let heights: Vec<String> = (0..side).map(|column| format!("{:.2}", height(column))).collect();
        grid += &(heights.join(" ") + "\n");
    }
    fs::write(folder.path().join("dem.asc"), grid).expect("the grid is written");
    let path = "t_s,x_m,y_m,alt_agl_m\n0,200,200,60\n4,700,700,60\n";
    fs::write(folder.path().join("path.csv"), path).expect("the path is written");
    ends(&run(&folder, "build --elevation dem.asc --local -o area.hop"), 0);
    let flight = "area.hop --path path.csv --fps 10 --size 64x36 --level -o f/####.png";
    ends(&run(&folder, &format!("farm submit --engine local --chunks 5 --samples 0 -- {flight}")), 0);
    folder
}

fn frame(folder: &TempDir, number: u64) -> PathBuf {
    folder.path().join(format!("f/{number:04}.png"))
}

/// Bytes of all files in the folder of the frames, but for the manifest, which tells of times.
fn bytes(folder: &TempDir) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder.path().join("f")).expect("it is there");
    entries
        .map(|entry| entry.expect("an entry"))
        .map(|entry| {
            (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).expect("a file"))
        })
        .filter(|(name, _)| name != "manifest.json")
        .collect()
}

/// Damages twenty frames in five ways; returns their numbers.
fn damage(folder: &TempDir) -> Vec<u64> {
    let numbers: Vec<u64> = (0..20).map(|place| 2 + 2 * place).collect();
    for (place, &number) in numbers.iter().enumerate() {
        let file = frame(folder, number);
        let whole = fs::read(&file).expect("a frame");
        match place % 5 {
            0 => fs::remove_file(&file),
            1 => fs::write(&file, &whole[..whole.len() * 2 / 3]),
            2 => fs::copy(frame(folder, number + 1), &file).map(drop),
            3 => {
                let mut flipped = whole;
                let at = (7919 * place + 40) % flipped.len();
                flipped[at] ^= 1 << (place % 8);
                fs::write(&file, flipped)
            }
            _ => fs::write(&file, []),
        }
        .expect("the frame is damaged");
    }
    numbers
}

#[test]
fn twenty_faults_are_found_and_mended() {
    let folder = site();
    let before = bytes(&folder);
    let sound = ends(&run(&folder, "verify-frames f"), 0);
    assert!(sound.contains(&format!("{FRAMES} frames checked, sound")), "{sound}");

    let numbers = damage(&folder);
    let told = ends(&run(&folder, "verify-frames f"), 6);
    let list: Vec<String> = numbers.iter().map(u64::to_string).collect();
    assert!(told.contains(&format!("as render does with --frames {}\n", list.join(","))), "{told}");
    // A frame that no manifest lists any more is missed by its job.
    fs::remove_file(folder.path().join("f/manifest.json")).expect("a manifest");
    assert_eq!(
        ends(&run(&folder, "verify f --progress none"), 6),
        ends(&run(&folder, "verify-frames f --progress none"), 6)
    );
    let json = run(&folder, "verify-frames f --json");
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).expect("it is JSON");
    let found: Vec<u64> =
        json["problems"].as_array().expect("a list").iter().filter_map(|one| one["frame"].as_u64()).collect();
    assert_eq!((found, &json["job"]), (numbers, &serde_json::Value::from(true)));

    ends(&run(&folder, "verify-frames f --repair"), 0);
    assert_eq!(bytes(&folder), before);
    ends(&run(&folder, "verify-frames f"), 0);
}

#[test]
fn the_manifest_serves_where_there_is_no_job() {
    let folder = site();
    fs::remove_dir_all(folder.path().join("f.job")).expect("the job is removed");
    fs::remove_file(frame(&folder, 7)).expect("a frame is removed");
    let told = ends(&run(&folder, "verify-frames f"), 6);
    assert!(told.contains("--frames 7\n"), "{told}");
    let refused = ends(&run(&folder, "verify-frames f --repair"), 2);
    assert!(refused.contains("--job") && refused.contains("--frames"), "{refused}");
}

#[test]
fn a_repair_with_another_database_is_refused() {
    let folder = site();
    fs::remove_file(frame(&folder, 7)).expect("a frame is removed");
    ends(&run(&folder, "build --elevation dem.asc --local --spacing 4 -o area.hop --overwrite"), 0);
    let refused = ends(&run(&folder, "verify-frames f --repair"), 7);
    assert!(refused.contains("area.hop has another content"), "{refused}");
    assert!(!frame(&folder, 7).exists());
}

#[test]
fn a_job_of_another_folder_is_refused() {
    let folder = site();
    fs::create_dir(folder.path().join("g")).expect("a folder");
    let refused = ends(&run(&folder, "verify-frames g --job f.job"), 2);
    assert!(refused.contains("go to") && refused.contains("not to g"), "{refused}");
}
