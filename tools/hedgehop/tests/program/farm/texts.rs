//! Texts that schedulers get, in a folder whose name means something to each of them.
//!
//! `HEDGEHOP_BLESS=1` keeps texts that were meant; look at them first.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use super::site::{FLIGHT, HOSTILE, Site, submission};
use crate::common::ends;

const OUTPUT: &str = "f {} $x %d `s/f ####.png";
const JOB: &str = "j {} it's.job";
/// Flags that schedulers are told of.
const FLAGS: &[&str] = &["--chunks", "3", "--samples", "0", "--job", JOB, "--at-once", "2"];

/// A hostile folder with the program in it under a hostile name, and the flags of a job there.
fn site() -> (Site, Vec<&'static str>) {
    let site = Site::new(HOSTILE);
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_hedgehop"), site.path("hedge {} $hop")).expect("a link");
    (site, [FLAGS, &["--program", "./hedge {} $hop"]].concat())
}

/// Flags whose text is the same on every machine.
fn flight() -> Vec<&'static str> {
    [FLIGHT, &["--simd", "portable", "--memory", "500M"]].concat()
}

/// The text of a submission that is not made, with a word for the folder around.
fn text(engine: &str, more: &[&str]) -> String {
    let (site, flags) = site();
    let flags = [&["--engine", engine, "--dry-run"], &flags[..], more].concat();
    let output = site.run(&submission(&flags, &flight(), OUTPUT));
    ends(&output, 0);
    assert!(!site.path(JOB).exists());
    let text = String::from_utf8(output.stdout).expect("text");
    let around = site.folder.parent().expect("a folder").canonicalize().expect("the folder");
    text.replace(&around.display().to_string(), "AROUND")
}

/// Compares a text with the one that is kept; returns both if they differ.
fn compared(name: &str, text: &str) -> Option<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/farm/texts").join(name);
    if std::env::var("HEDGEHOP_BLESS").is_ok_and(|value| value == "1") {
        fs::write(&file, text).expect("the text is written");
    }
    let kept = fs::read_to_string(&file).unwrap_or_default();
    (text != kept).then(|| format!("{}:\n{text}\nnot\n{kept}", file.display()))
}

#[test]
fn texts_stay_as_they_are() {
    let mut differing = Vec::new();
    for engine in ["local", "parallel", "hyperqueue", "slurm", "openjd"] {
        let more: &[&str] = if engine == "openjd" { &[] } else { &["--pass=--a b", "--pass=$c"] };
        let text = text(engine, more);
        // All engines run the same scripts.
        let end = text.find("finish.log 2>&1 </dev/null\n\n").expect("the last script") + 28;
        differing.extend(compared("scripts.txt", &text[..end]));
        differing.extend(compared(&format!("{engine}.txt"), &text[end..]));
    }
    assert!(differing.is_empty(), "{}", differing.join("\n"));
}

/// The commands behind the scripts, which `sh` runs.
fn commands(text: &str) -> &str {
    text.rsplit_once("\n\n").expect("commands behind the scripts").1
}

#[test]
fn a_shell_runs_what_is_printed() {
    let (site, flags) = site();
    let flags = [&["--engine", "local", "--prepare"], &flags[..]].concat();
    let output = site.run(&submission(&flags, &flight(), OUTPUT));
    ends(&output, 0);
    let text = String::from_utf8(output.stdout).expect("text");
    let run = site.command("sh").current_dir("/").args(["-c", commands(&text)]).output().expect("sh starts");
    assert!(ends(&run, 0).is_empty());
    site.assert_frames(OUTPUT, &flight());
    site.assert_once(JOB, 21);
    for chunk in 1..=3 {
        let log = fs::read_to_string(site.path(JOB).join(format!("logs/{chunk}.log"))).expect("a log");
        assert!(log.contains("rendered 7 frames"), "{log}");
    }
}

/// Names of what was submitted are read by the shell, and nothing else is.
#[test]
fn a_shell_tells_the_last_task_which_it_waits_for() {
    for (engine, command, wanted) in
        [("slurm", "sbatch", "--dependency=afterany:11\n"), ("hyperqueue", "hq", "finish.sh\n11\n")]
    {
        let (site, flags) = site();
        let flags = [&["--engine", engine, "--prepare"], &flags[..]].concat();
        let output = site.run(&submission(&flags, &flight(), OUTPUT));
        ends(&output, 0);
        let text = String::from_utf8(output.stdout).expect("text");

        let folder = site.path("bin");
        fs::create_dir(&folder).expect("a folder");
        fs::write(folder.join(command), "#!/bin/sh\nprintf '%s\\n' \"$@\" >>told\necho 11\n")
            .expect("it is written");
        fs::set_permissions(folder.join(command), fs::Permissions::from_mode(0o755)).expect("it can be run");
        let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
        let mut shell = site.command("sh");
        ends(&shell.env("PATH", path).args(["-c", commands(&text)]).output().expect("sh starts"), 0);
        let told = fs::read_to_string(site.path("told")).expect("what it was told");
        assert!(told.contains(wanted) && told.contains(&format!("{HOSTILE}/{JOB}/chunk.sh\n")), "{told}");
    }
}
