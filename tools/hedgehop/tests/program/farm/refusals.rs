//! What `farm submit` refuses, before it writes anything.

use std::fs;

use super::site::{FLIGHT, Site, submission};
use crate::common::ends;

const LOCAL: &[&str] = &["--engine", "local", "--chunks", "2", "--samples", "0"];

#[track_caller]
fn assert_refused(site: &Site, args: &[&str], why: &str) {
    let names = || {
        let mut names: Vec<_> = fs::read_dir(&site.folder)
            .expect("the folder")
            .flatten()
            .map(|entry| entry.file_name())
            .collect();
        names.sort();
        names
    };
    let before = names();
    let said = ends(&site.run(args), 2);
    assert!(said.contains(why), "{args:?}: {said}");
    assert_eq!(names(), before, "{args:?}");
}

#[test]
fn what_no_farm_can_render_is_refused() {
    let site = Site::new("site");
    let view = ["area.hop", "--eye", "900,900,400", "--size", "160x90"];
    for (flight, output, why) in [
        (FLIGHT, "film.y4m", "a farm writes frames in files"),
        (FLIGHT, "-", "a farm writes frames in files"),
        (&view[..], "view.png", "a single picture has no frames to share out"),
        (&[FLIGHT, &["--late", "coarser"]].concat(), "f/####.png", "depend on how fast a machine is"),
        (&[FLIGHT, &["--damaged", "coarser"]].concat(), "f/####.png", "depend on which pages are damaged"),
        (&[FLIGHT, &["--traffic", "map.svg"]].concat(), "f/####.png", "draws the pages of one process"),
        (&[FLIGHT, &["--farm", "f.job", "--chunk", "1"]].concat(), "f/####.png", "are flags of workers"),
        (&[FLIGHT, &["--chnuk", "1"]].concat(), "f/####.png", "the flags of render: unexpected argument"),
        (FLIGHT, "####.png", "say with --job where the job is to be kept"),
    ] {
        assert_refused(&site, &submission(LOCAL, flight, output), why);
    }

    let film = [&["farm", "submit"], LOCAL, &["--"], FLIGHT, &["--video", "film.mp4"]].concat();
    assert_refused(&site, &film, "give -o frames/####.png");
    assert_refused(&site, &[&["farm", "submit"], LOCAL].concat(), "name a file with the flags of render");
    assert_refused(
        &site,
        &["farm", "submit", "--engine", "magic", "--", "area.hop"],
        "invalid value 'magic'",
    );
}

#[test]
fn a_folder_holds_one_job() {
    let site = Site::new("site");
    let prepare = [LOCAL, &["--prepare"]].concat();
    ends(&site.run(&submission(&prepare, FLIGHT, "frames/####.png")), 0);
    let job = fs::read(site.path("frames.job/job.json")).expect("the job");
    for flags in [&prepare[..], LOCAL] {
        assert_refused(
            &site,
            &submission(flags, FLIGHT, "frames/####.png"),
            "frames.job holds a job already; go on with it by `hedgehop farm retry frames.job`",
        );
    }
    assert!(fs::read(site.path("frames.job/job.json")).expect("the job") == job);
    // What is written nowhere disturbs none.
    let dry = [LOCAL, &["--dry-run"]].concat();
    ends(&site.run(&submission(&dry, FLIGHT, "frames/####.png")), 0);
    let beside = [LOCAL, &["--job", "second.job"]].concat();
    ends(&site.run(&submission(&beside, FLIGHT, "second/####.png")), 0);
}

#[test]
fn a_scheduler_that_is_not_there_is_named() {
    let site = Site::new("site");
    fs::create_dir(site.path("empty")).expect("a folder");
    for (engine, command) in
        [("parallel", "parallel"), ("hyperqueue", "hq"), ("slurm", "sbatch"), ("openjd", "openjd")]
    {
        let args = submission(&["--engine", engine, "--samples", "0"], FLIGHT, "frames/####.png");
        let mut submit = site.command(env!("CARGO_BIN_EXE_hedgehop"));
        let output = submit.args(&args).env("PATH", site.path("empty")).output().expect("it starts");
        let said = ends(&output, 2);
        assert!(said.contains(&format!("needs the program {command}, which is not on the PATH")), "{said}");
        assert!(!site.path("frames.job").exists());
    }
}

#[test]
fn a_folder_without_a_job_is_named() {
    let site = Site::new("site");
    for command in ["status", "retry", "cancel", "finish"] {
        let said = ends(&site.run(&["farm", command, "none.job"]), 5);
        assert!(said.contains("none.job/job.json") && said.contains("farm submit"), "{said}");
    }
}
