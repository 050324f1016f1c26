//! Schedulers for real, where they are to be had: each gives what one process gives.
//!
//! tools/farm/engines says what they need. `HEDGEHOP_FARM_PYTHON` names a Python with their packages.

use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::site::{FLIGHT, HOSTILE, Site, submission};
use crate::common::ends;

const OUTPUT: &str = "f {} $x %d/f ####.png";
const JOB: &str = "j {} it's.job";
/// Code of a program of tools/farm/engines whose scheduler is missing.
const MISSING: i32 = 77;

/// The Python that has packages, if it is there, else any.
fn python() -> PathBuf {
    let named = std::env::var_os("HEDGEHOP_FARM_PYTHON").map(PathBuf::from);
    named.filter(|python| python.is_file()).unwrap_or_else(|| "python3".into())
}

/// Folders of programs, those of Python's packages first.
fn path() -> OsString {
    let beside = python().parent().map(Path::to_owned).into_iter();
    let usual = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths(beside.chain(std::env::split_paths(&usual))).expect("folders")
}

fn skip(what: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {what}; tools/farm/engines/README.md says what it needs");
}

/// Whether a program is there; says so if it is not.
fn has(program: &str) -> bool {
    let has = std::env::split_paths(&path()).any(|folder| folder.join(program).is_file());
    if !has {
        skip(&format!("no program {program}"));
    }
    has
}

/// Flags of a job in four chunks.
fn flags<'a>(engine: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["--engine", engine, "--chunks", "4", "--samples", "0", "--job", JOB], more].concat()
}

#[track_caller]
fn assert_done(site: &Site) {
    assert_eq!(site.stages(JOB), ["done"; 4]);
    site.assert_frames(OUTPUT, FLIGHT);
    site.assert_once(JOB, 21);
}

/// Runs a program of tools/farm/engines; `None` if what it needs is missing.
fn harness(site: &Site, program: &str, args: &[&str]) -> Option<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../farm/engines");
    let mut command: Command = site.command(python());
    let output = match command.arg(folder.join(program)).args(args).output() {
        Ok(output) => output,
        Err(error) => {
            skip(&format!("no {}: {error}", python().display()));
            return None;
        }
    };
    if output.status.code() == Some(MISSING) {
        skip(String::from_utf8_lossy(&output.stderr).trim().trim_start_matches("skipped: "));
        return None;
    }
    ends(&output, 0);
    Some(serde_json::from_slice(&output.stdout).expect("it is JSON"))
}

/// Schedulers whose command ends when all is done.
fn works_off(engine: &str, program: &str) {
    if !has(program) {
        return;
    }
    let site = Site::new(HOSTILE);
    let mut submit = site.command(env!("CARGO_BIN_EXE_hedgehop"));
    submit.env("PATH", path()).args(submission(&flags(engine, &[]), FLIGHT, OUTPUT));
    ends(&submit.output().expect("the program starts"), 0);
    assert_done(&site);

    // What is missing is handed to the same scheduler.
    let frame = site.path("f {} $x %d/f 0009.png");
    fs::remove_file(&frame).expect("the frame was there");
    let mut retry = site.command(env!("CARGO_BIN_EXE_hedgehop"));
    let output = retry.env("PATH", path()).args(["farm", "retry", JOB]).output().expect("it starts");
    ends(&output, 0);
    assert!(frame.is_file());
    assert_eq!(site.tries(JOB).len(), 5);
}

#[test]
fn gnu_parallel() {
    works_off("parallel", "parallel");
}

#[test]
fn open_job_description() {
    works_off("openjd", "openjd");
}

/// A template tells of more chunks than a list in it may.
#[test]
fn open_job_description_of_many_chunks() {
    if !has("openjd") {
        return;
    }
    let site = Site::new("site");
    let flight = [FLIGHT, &["--fps", "400", "--memory", "500M"]].concat();
    let many = ["--engine", "openjd", "--chunks", "1100", "--samples", "0", "--prepare"];
    ends(&site.run(&submission(&many, &flight, "frames/####.png")), 0);
    for command in ["check", "summary"] {
        let mut openjd = site.command("openjd");
        openjd.env("PATH", path()).args([command, "frames.job/openjd.json"]);
        let said = ends(&openjd.output().expect("it starts"), 0);
        assert!(command == "check" || said.contains("1100"), "{said}");
    }
}

#[test]
fn hyperqueue() {
    let site = Site::new(HOSTILE);
    ends(&site.run(&submission(&flags("hyperqueue", &["--prepare"]), FLIGHT, OUTPUT)), 0);
    let Some(codes) = harness(&site, "hyperqueue_cluster.py", &[JOB, "4"]) else { return };
    assert_eq!(codes, serde_json::json!({ "1": 0, "2": 0, "3": 0, "4": 0 }));
    let finish = site.path(JOB).join("finish.sh");
    ends(&site.command("sh").arg(finish).output().expect("sh starts"), 0);
    assert_done(&site);
}

/// Three nodes, arrays that are cut in two, and a controller that is restarted, or not.
#[test]
fn slurm() {
    for cluster in [&["--max-array", "3"][..], &["--restart"]] {
        let site = Site::new(HOSTILE);
        let flags = flags("slurm", &["--at-once", "3"]);
        let submit = submission(&flags, FLIGHT, OUTPUT);
        let args = [cluster, &["--", env!("CARGO_BIN_EXE_hedgehop")], &submit].concat();
        let Some(found) = harness(&site, "slurm_cluster.py", &args) else { return };
        assert!(
            found["said"].as_str().is_some_and(|said| said.contains("submitted 4 chunks as ")),
            "{found}"
        );
        let tasks = found["tasks"].as_object().expect("tasks");
        assert!(tasks.len() == 5 && tasks.values().all(|task| task["state"] == "COMPLETED"), "{found}");
        let finished = fs::read_to_string(site.path(JOB).join("logs/finish.log")).expect("a log");
        assert!(finished.contains("21 frames, listed in"), "{finished}");
        assert_done(&site);
    }
}
