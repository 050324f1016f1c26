//! Workers that would render something else than their job: they end with 7 before their first frame.

use std::fs;
use std::io::Write;
use std::process::Output;

use super::site::{FLIGHT, Site, submission};
use crate::common::ends;

/// Code of a worker that has something else than its job.
const OTHER: i32 = 7;
/// Where the offset of a database's directory stands, and the size of its blocks (FORMAT.md); pages lie in between.
const DIRECTORY_OFFSET: usize = 120;
const BLOCK: usize = 4096;

/// A job in three chunks, which nobody has begun.
fn job(flags: &[&str]) -> Site {
    let site = Site::new("site");
    let common = ["--engine", "local", "--prepare", "--chunks", "3", "--samples", "0"];
    let flags = [&common[..], flags].concat();
    ends(&site.run(&submission(&flags, FLIGHT, "frames/####.png")), 0);
    site
}

/// Renders the second chunk with these flags, by that program.
fn worker_of(site: &Site, program: &str, flags: &[&str], simd: &str) -> Output {
    let common = ["-o", "frames/####.png", "--skip-existing", "--farm", "frames.job", "--chunk", "2"];
    let mut command = site.command(program);
    command.arg("render").args(flags).args(common).args(["--simd", simd]);
    command.output().expect("the program starts")
}

fn worker(site: &Site, flags: &[&str]) -> Output {
    worker_of(site, env!("CARGO_BIN_EXE_hedgehop"), flags, &simd(site))
}

fn simd(site: &Site) -> String {
    site.json("frames.job/job.json")["simd"].as_str().expect("a name").to_owned()
}

/// Whether it was refused for that reason, which the job's status tells, and no frame was written.
#[track_caller]
fn assert_refused(site: &Site, output: &Output, why: &str) {
    let said = ends(output, OTHER);
    assert!(said.contains("error: frames.job: ") && said.contains(why), "{said}");
    let files = fs::read_dir(site.path("frames")).map_or(0, Iterator::count);
    assert_eq!((files, site.told("frames.job", 2)), (0, 0));
    let chunk = &site.status("frames.job")["chunks"][1];
    assert_eq!(chunk["stage"], "failed");
    assert!(chunk["failure"].as_str().is_some_and(|failure| failure.contains(why)), "{chunk}");
}

#[test]
fn another_setting_is_refused_and_told_of() {
    let site = job(&[]);
    for (flags, why) in [
        (&["--hfov", "50"][..], "screen is another one"),
        (&["--size", "160x92"], "size_px is [160,92], not [160,90]"),
        (&["--fps", "10"], "fps is \"10\", not \"5\""),
        (&["--sun", "100,20"], "sun_azimuth_elevation_deg"),
        (&["--late", "coarser"], "late is \"coarser\""),
        (&["--antialias", "2"], "antialias is 2"),
    ] {
        // The last of flags that are given twice counts.
        assert_refused(&site, &worker(&site, &[FLIGHT, flags].concat()), why);
    }

    let said = ends(&site.run(&["farm", "finish", "frames.job"]), 6);
    assert!(said.contains("chunk 2 lacks frames 8-14: frames.job: this is not what was submitted"), "{said}");

    // What was submitted is rendered.
    ends(&worker(&site, FLIGHT), 0);
    assert_eq!(site.stages("frames.job"), ["waiting", "done", "waiting"]);
}

#[test]
fn another_flight_is_refused() {
    let site = job(&[]);
    let path = fs::read_to_string(site.path("path.csv")).expect("the path");
    fs::write(site.path("path.csv"), path.replace("1500", "1501")).expect("the path is written");
    assert_refused(&site, &worker(&site, FLIGHT), "the flight path.csv has another content now");
}

#[test]
fn another_scene_or_model_is_refused() {
    let site = Site::new("site");
    let model = "v 0 0 0\nv 50 0 0\nv 25 50 0\nv 25 25 80\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let scene = "[[object]]\nname = \"tent\"\nmodel = \"tent.obj\"\nat = [900, 900, 0]\n";
    fs::write(site.path("tent.obj"), model).expect("the model is written");
    fs::write(site.path("scene.toml"), scene).expect("the scene is written");
    let flight = [FLIGHT, &["--scene", "scene.toml"]].concat();
    let flags = ["--engine", "local", "--prepare", "--chunks", "3", "--samples", "0"];
    ends(&site.run(&submission(&flags, &flight, "frames/####.png")), 0);

    fs::write(site.path("tent.obj"), model.replace("80", "81")).expect("the model is written");
    assert_refused(&site, &worker(&site, &flight), "scene is another one");
    fs::write(site.path("tent.obj"), model).expect("the model is written");
    fs::write(site.path("scene.toml"), scene.replace("900, 0", "901, 0")).expect("the scene is written");
    assert_refused(&site, &worker(&site, &flight), "scene is another one");
    fs::write(site.path("scene.toml"), scene).expect("the scene is written");
    ends(&worker(&site, &flight), 0);
}

#[test]
fn another_program_is_refused() {
    let site = job(&[]);
    fs::copy(env!("CARGO_BIN_EXE_hedgehop"), site.path("other")).expect("a copy");
    let mut copy = fs::File::options().append(true).open(site.path("other")).expect("the copy");
    copy.write_all(b"x").expect("it is written");
    drop(copy);
    let output = worker_of(&site, "./other", FLIGHT, &simd(&site));
    assert_refused(&site, &output, "and this is another build of hedgehop");
}

#[test]
fn another_instruction_set_is_refused() {
    let site = job(&["--cores", "1"]);
    let pinned = simd(&site);
    if pinned == "portable" {
        let _ = writeln!(std::io::stderr(), "skipped: this machine has one instruction set");
        return;
    }
    let output = worker_of(&site, env!("CARGO_BIN_EXE_hedgehop"), FLIGHT, "portable");
    assert_refused(&site, &output, &format!("it is rendered with --simd {pinned}"));
}

/// A byte of a page that was swapped is found before the first frame: in any page, or in those that frames touch.
#[test]
fn a_damaged_page_is_refused() {
    for check in ["whole", "planned"] {
        let site = job(&["--check", check]);
        let area = fs::read(site.path("area.hop")).expect("the database");
        let directory =
            u64::from_le_bytes(area[DIRECTORY_OFFSET..][..8].try_into().expect("eight bytes")) as usize;
        let mut refused = 0;
        for place in 0..8 {
            // Pages begin at blocks, and no part of one is as short as this.
            let at = BLOCK + (directory - BLOCK) / 8 * place / BLOCK * BLOCK + 100;
            let mut damaged = area.clone();
            damaged[at] ^= 0x20;
            fs::write(site.path("area.hop"), &damaged).expect("it is written");

            let output = worker(&site, FLIGHT);
            match output.status.code() {
                Some(OTHER) => {
                    assert_refused(&site, &output, "the database is not that of the job");
                    refused += 1;
                }
                // The ground under the path is read even before.
                Some(3) => assert!(ends(&output, 3).contains("wrong checksum")),
                _ => {
                    assert_eq!(check, "planned", "byte {at}");
                    ends(&output, 0);
                    ends(&worker(&site, FLIGHT), 0);
                }
            }
            let frames = fs::read_dir(site.path("frames")).map_or(0, Iterator::count);
            assert!(frames == 0 || output.status.success(), "byte {at}: {frames} frames");
            let _ = fs::remove_dir_all(site.path("frames"));
            fs::remove_dir_all(site.path("frames.job/parts")).expect("records are removed");
            fs::create_dir(site.path("frames.job/parts")).expect("the folder is made");
        }
        assert!(refused > 1, "{check}: {refused}");
    }
}

#[test]
fn a_chunk_that_is_none_is_refused() {
    let site = job(&[]);
    for chunk in ["0", "4"] {
        let args =
            [&["render"], FLIGHT, &["-o", "frames/####.png", "--farm", "frames.job", "--chunk", chunk]];
        let said = ends(&site.run(&args.concat()), 2);
        assert!(said.contains(&format!("chunks 1 to 3, and none of number {chunk}")), "{said}");
    }
}
