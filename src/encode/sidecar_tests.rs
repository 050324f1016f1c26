//! Manifests and poses beside frames.

use super::*;
use crate::encode::{testing, write_frame};

fn manifest(settings: &str) -> Manifest {
    let database = DatabaseRecord {
        file: "valley.hop".to_owned(),
        content_hash: "abc".to_owned(),
        crs: "EPSG:32633".to_owned(),
        vertical_datum: "mean sea level".to_owned(),
    };
    let flight = FlightRecord { file: "flight.csv".to_owned(), blake3: "def".to_owned() };
    Manifest::new(
        "hedgehop 0.1.0",
        database,
        Some(flight),
        serde_json::json!({ "hfov": 60.0, "sky": settings }),
    )
}

/// Renders frames and writes their manifest, as a run does.
fn run(folder: &Path, settings: &str, numbers: &[u64]) -> Manifest {
    run_with(folder, settings, numbers, &[])
}

/// The same with further files of poses.
fn run_with(folder: &Path, settings: &str, numbers: &[u64], formats: &[PoseFormat]) -> Manifest {
    let mut manifest = manifest(settings);
    if !formats.is_empty() {
        let formats = formats.iter().copied().collect();
        manifest.poses = Some(PosesRecord { formats, offset_m: [500_000.0, 4_649_000.0, 0.0] });
    }
    let frame = testing::frame(4, 3);
    for &number in numbers {
        let info = FrameInfo { frame: number, ..testing::info() };
        let path = folder.join(format!("{number:04}.png"));
        let written = write_frame(&path, &frame, &info).unwrap();
        let lon_lat = (number % 2 == 0).then_some([15.1, 42.0]);
        manifest.frames.push(FrameRecord::new(&info, &frame.camera, lon_lat, Some((&path, &written))));
    }
    manifest.write(folder).unwrap()
}

fn numbers(folder: &Path) -> Vec<u64> {
    let manifest = Manifest::read(folder).unwrap().unwrap();
    manifest.frames.iter().map(|frame| frame.frame).collect()
}

#[test]
fn the_manifest_says_what_made_each_frame() {
    let (folder, _) = testing::place("");
    let written = run(folder.path(), "clear", &[2, 1]);
    let read = Manifest::read(folder.path()).unwrap().unwrap();
    assert_eq!(read, written, "every f64 comes back");
    assert_eq!(read.frames[1].file.as_deref(), Some("0002.png"));
    let file = Written::of(&folder.path().join("0002.png")).unwrap();
    assert_eq!(read.frames[1].blake3.as_ref(), Some(&file.blake3));
    assert_eq!(read.frames[0].eye_m, [500_123.456_789, 4_649_776.225, 312.75]);
}

#[test]
fn poses_are_a_table() {
    let (folder, _) = testing::place("");
    run(folder.path(), "clear", &[1, 2]);
    assert_eq!(
        std::fs::read_to_string(folder.path().join(POSES)).unwrap(),
        "frame,t_s,x_m,y_m,z_m,lon_deg,lat_deg,yaw_deg,pitch_deg,roll_deg,hfov_deg\n\
         1,1.64,500123.456789,4649776.225,312.75,,,33,-5.25,20,60\n\
         2,1.64,500123.456789,4649776.225,312.75,15.1,42,33,-5.25,20,60\n"
    );
}

#[test]
fn subsets_of_one_sequence_add_up() {
    let (folder, _) = testing::place("");
    run(folder.path(), "clear", &[5, 6]);
    run(folder.path(), "clear", &[1, 6]);
    assert_eq!(numbers(folder.path()), [1, 5, 6]);
    std::fs::remove_file(folder.path().join("0005.png")).unwrap();
    run(folder.path(), "clear", &[2]);
    assert_eq!(numbers(folder.path()), [1, 2, 6], "the file of 5 is gone");
}

#[test]
fn a_frame_that_stays_keeps_what_it_cost() {
    let (folder, _) = testing::place("");
    let mut first = run(folder.path(), "clear", &[1, 2]);
    let cost = Some(FrameCost { wall_s: 0.25, cpu_s: None, paging: None });
    for frame in &mut first.frames {
        (frame.coarser_share, frame.cost) = (Some(0.5), cost);
    }
    first.frames[1].blake3 = Some("another file".to_owned());
    first.write(folder.path()).unwrap();
    let again = run(folder.path(), "clear", &[1, 2]);
    assert_eq!((again.frames[0].coarser_share, again.frames[0].cost), (Some(0.5), cost));
    assert_eq!((again.frames[1].coarser_share, again.frames[1].cost), (None, None), "it is another file now");
}

#[test]
fn files_of_poses_go_on_with_their_sequence() {
    use PoseFormat::{Colmap, Transforms, Tum};
    const FILES: [&str; 5] = [
        "transforms.json",
        "sparse/0/cameras.txt",
        "sparse/0/images.txt",
        "sparse/0/points3D.txt",
        "poses.tum",
    ];
    let texts =
        |folder: &Path| FILES.map(|name| std::fs::read_to_string(folder.join(name)).unwrap_or_default());
    let (whole, _) = testing::place("");
    run_with(whole.path(), "clear", &[1, 2, 3], &PoseFormat::ALL);
    let whole = texts(whole.path());
    assert!(whole.iter().all(|text| !text.is_empty()) && whole[4].lines().count() == 2 + 3);

    // Whatever the parts, and whichever of them asked for what.
    let (folder, _) = testing::place("");
    run(folder.path(), "clear", &[3]);
    assert!(texts(folder.path()).iter().all(String::is_empty), "none are written unasked");
    run_with(folder.path(), "clear", &[1, 3], &[Tum, Colmap]);
    run_with(folder.path(), "clear", &[1], &[Transforms]);
    run(folder.path(), "clear", &[2]);
    assert!(texts(folder.path()) == whole);

    // Poses of another sequence would tell of frames that are not there any more.
    run_with(folder.path(), "haze", &[1], &[Tum]);
    let left = texts(folder.path()).map(|text| text.is_empty());
    assert_eq!(left, [true, true, true, true, false]);
    std::fs::write(folder.path().join("poses.tum"), "0 1 2 3 0 0 0 1\n").unwrap();
    let message = Manifest::check_folder(folder.path()).unwrap_err().to_string();
    assert!(message.contains("poses.tum"), "{message}");
}

#[test]
fn another_sequence_replaces_what_was_there() {
    let (folder, _) = testing::place("");
    run(folder.path(), "clear", &[5, 6]);
    run(folder.path(), "haze", &[1]);
    assert_eq!(numbers(folder.path()), [1]);
    let said = manifest("clear").difference(&manifest("haze")).unwrap();
    assert_eq!(said, r#"sky is "haze", not "clear""#);
    assert_eq!(manifest("clear").difference(&manifest("clear")), None);
    let bare = serde_json::json!({});

    for (one, said) in [
        (serde_json::json!({"scene": {"blake3": "a"}}), "it has a scene, and this has none"),
        (serde_json::json!({"radius_m": 2.5}), "radius_m is 2.5, and not set here"),
    ] {
        assert_eq!(changed_settings(&one, &bare), said);
    }

    assert_eq!(changed_settings(&bare, &serde_json::json!({"scene": {}})), "it has no scene");
    std::fs::write(folder.path().join(MANIFEST), b"{").unwrap();
    let message = Manifest::read(folder.path()).unwrap_err().to_string();
    assert!(message.contains(MANIFEST) && message.contains("line 1"), "{message}");
    run(folder.path(), "haze", &[3]);
    assert_eq!(numbers(folder.path()), [3]);
}

#[test]
fn a_folder_with_files_of_somebody_else_is_refused() {
    let (folder, _) = testing::place("");
    run(folder.path(), "clear", &[5]);
    Manifest::check_folder(folder.path()).unwrap();
    for (name, text) in [(POSES, "t,lon,lat\n0,1,2\n"), (MANIFEST, "{\"name\": \"my app\"}")] {
        let other = tempfile::tempdir().unwrap();
        std::fs::write(other.path().join(name), text).unwrap();
        let message = Manifest::check_folder(other.path()).unwrap_err().to_string();
        assert!(message.contains(name) && message.contains("-o"), "{message}");
    }
}

#[test]
fn workers_that_finish_at_once_lose_nothing() {
    let (folder, _) = testing::place("");
    std::thread::scope(|scope| {
        for worker in 0..4 {
            let folder = folder.path();
            scope.spawn(move || {
                for round in 0..5 {
                    run(folder, "clear", &[worker * 5 + round + 1]);
                }
            });
        }
    });
    assert_eq!(numbers(folder.path()), (1..=20).collect::<Vec<_>>());
}

#[test]
fn the_digest_ignores_the_order_of_keys() {
    let one: serde_json::Value = serde_json::from_str(r#"{"a":1,"b":2}"#).unwrap();
    let other: serde_json::Value = serde_json::from_str(r#"{"b":2,"a":1}"#).unwrap();
    assert_eq!(settings_digest(&one), settings_digest(&other));
    assert_ne!(settings_digest(&one), settings_digest(&serde_json::json!({"a":1})));
}
