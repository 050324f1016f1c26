//! Files of a job that tell something else than what is there: nothing of it passes for a finished frame.

use std::fs;

use serde_json::Value;

use super::site::{FLIGHT, Site, submission};
use crate::common::ends;

/// Submits a job of three chunks and lets it end.
fn finished() -> Site {
    let site = Site::new("site");
    let flags = ["--engine", "local", "--chunks", "3", "--samples", "0"];
    ends(&site.run(&submission(&flags, FLIGHT, "f/####.png")), 0);
    site
}

/// Adds lines to a file of records of its own.
fn add_records(site: &Site, name: &str, lines: &[Value]) {
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    fs::write(site.path("f.job/parts").join(name), text).expect("records are written");
}

/// Returns the line that tells of a frame of the first chunk.
fn record(site: &Site, number: u64) -> Value {
    let entries = fs::read_dir(site.path("f.job/parts")).expect("records").flatten();
    let texts = entries.filter_map(|entry| fs::read_to_string(entry.path()).ok());
    let lines: Vec<String> =
        texts.flat_map(|text| text.lines().map(str::to_owned).collect::<Vec<_>>()).collect();
    let of_frame = |line: &String| {
        let line: Value = serde_json::from_str(line).ok()?;
        (line["frame"]["frame"] == number).then_some(line)
    };
    lines.iter().rev().find_map(of_frame).expect("a record")
}

#[test]
fn frames_that_are_damaged_are_not_listed_and_retry_renders_them() {
    let site = finished();
    fs::write(site.path("f/0001.png"), []).expect("it is cut");
    let said = ends(&site.run(&["farm", "finish", "f.job"]), 6);
    assert!(said.contains("chunk 1 lacks frames 1\n"), "{said}");
    ends(&site.run(&["farm", "retry", "f.job"]), 0);
    site.assert_frames("f/####.png", FLIGHT);
}

/// A film is made of the frames that are there, whatever has become of what they were made of.
#[test]
fn what_is_finished_is_not_rendered_from_other_inputs() {
    let site = Site::new("site");
    let flags = ["--engine", "local", "--chunks", "2", "--samples", "0"];
    let flight = [FLIGHT, &["--video", "f.avi"]].concat();
    ends(&site.run(&submission(&flags, &flight, "f/####.png")), 0);
    let before = fs::read(site.path("f/0003.png")).expect("a frame");
    let path = fs::read_to_string(site.path("path.csv")).expect("a path").replace(",60", ",75");
    fs::write(site.path("path.csv"), path).expect("the path is written");
    fs::remove_file(site.path("f.avi")).expect("a film");

    ends(&site.run(&["farm", "retry", "f.job"]), 0);
    assert!(site.path("f.avi").is_file());
    assert_eq!(fs::read(site.path("f/0003.png")).expect("a frame"), before);
    fs::remove_file(site.path("f/0003.png")).expect("a frame");
    let said = ends(&site.run(&["farm", "retry", "f.job"]), 6);
    assert!(said.contains("path.csv has another content now"), "{said}");
    assert!(!site.path("f/0003.png").exists());
}

#[test]
fn records_of_other_frames_and_files_are_nobodys() {
    let site = finished();
    let mut other = record(&site, 1);
    other["frame"]["frame"] = 999.into();
    let mut elsewhere = record(&site, 2);
    elsewhere["frame"]["file"] = "../../secret.png".into();
    let mut borrowed = record(&site, 1);
    borrowed["frame"]["frame"] = 5.into();
    add_records(&site, "0001.zz.jsonl", &[other, elsewhere, borrowed]);
    fs::remove_file(site.path("f/0005.png")).expect("a frame");

    let said = ends(&site.run(&["farm", "finish", "f.job"]), 6);
    assert!(said.contains("lacks frames 5\n") && said.contains("1 frames are missing"), "{said}");
    assert!(ends(&site.run(&["verify-frames", "f"]), 6).contains("--frames 5\n"));
    ends(&site.run(&["farm", "retry", "f.job"]), 0);
    site.assert_frames("f/####.png", FLIGHT);
}

#[test]
fn a_job_that_was_moved_says_so() {
    let site = finished();
    fs::rename(site.path("f.job"), site.path("g.job")).expect("it is moved");
    for command in ["status", "finish", "retry"] {
        let said = ends(&site.run(&["farm", command, "g.job"]), 2);
        assert!(said.contains("submitted as f.job"), "{said}");
    }
    assert!(!site.path("f.job").exists());
}

#[test]
fn workers_that_write_elsewhere_are_refused() {
    let site = finished();
    fs::remove_file(site.path("f/0001.png")).expect("a frame");
    let worker = ["-o", "g/####.png", "--skip-existing", "--farm", "f.job", "--chunk", "1"];
    let simd = site.json("f.job/job.json")["simd"].as_str().expect("a set").to_owned();
    let said = ends(&site.run(&[&["render"], FLIGHT, &worker, &["--simd", &simd]].concat()), 7);
    assert!(said.contains("its frames go to"), "{said}");
    assert!(!site.path("g").exists());
}

#[test]
fn a_folder_behind_a_link_has_its_job() {
    let site = finished();
    fs::rename(site.path("f"), site.path("big")).expect("it is moved");
    std::os::unix::fs::symlink("big", site.path("f")).expect("a link");
    fs::remove_file(site.path("f/0001.png")).expect("a frame");
    fs::remove_file(site.path("f/manifest.json")).expect("a manifest");
    assert!(ends(&site.run(&["verify-frames", "f"]), 6).contains("--frames 1\n"));
}

#[test]
fn numbers_out_of_range_are_refused() {
    let site = finished();
    let job = fs::read_to_string(site.path("f.job/job.json")).expect("a job");
    let mut wrong: Value = serde_json::from_str(&job).expect("JSON");
    wrong["chunks"][0]["frames"] = "1-18446744073709551615".into();
    fs::write(site.path("f.job/job.json"), wrong.to_string()).expect("the job is written");
    assert!(ends(&site.run(&["farm", "status", "f.job"]), 3).contains("does not hold"));
    fs::write(site.path("f.job/job.json"), job).expect("the job is written");

    fs::remove_file(site.path("f/0001.png")).expect("a frame");
    let mut record = site.json("f.job/submissions/0001.json");
    for (key, value) in [("cores", 0), ("at_once", 0)] {
        record["tasks"][key] = value.into();
        fs::write(site.path("f.job/submissions/0001.json"), record.to_string()).expect("it is written");
        assert!(ends(&site.run(&["farm", "retry", "f.job"]), 3).contains("0001.json"));
    }
}

#[test]
fn addresses_with_secrets_are_not_kept() {
    let site = Site::new("site");
    let url = "http://me:SECRET@127.0.0.1:9/area.hop?signature=SECRET";
    let flight = [&[url], &FLIGHT[1..]].concat();
    let said = ends(&site.run(&submission(&["--engine", "local"], &flight, "f/####.png")), 2);
    assert!(said.contains("password or a signature") && !said.contains("SECRET"), "{said}");
    assert!(!site.path("f.job").exists());
}
