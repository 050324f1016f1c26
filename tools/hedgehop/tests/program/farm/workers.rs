//! The script of a chunk: how it gets its number, and which failures it tries again.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use super::site::{FLIGHT, Site, submission};
use crate::common::ends;

/// A job whose workers are a program that writes down what it is given, and ends with the codes in a file, one after another.
fn job(retries: &str) -> Site {
    let site = Site::new("site");
    let program =
        "#!/bin/sh\necho \"$*\" >>calls\nread -r code <codes && sed -i 1d codes\nexit \"${code:-0}\"\n";
    fs::write(site.path("worker"), program).expect("the program is written");
    fs::set_permissions(site.path("worker"), fs::Permissions::from_mode(0o755)).expect("it can be run");
    fs::write(site.path("codes"), "").expect("the file is written");
    let flags = ["--engine", "local", "--prepare", "--chunks", "3", "--samples", "0", "--retries", retries];
    let flags = [&flags[..], &["--program", "./worker"]].concat();
    ends(&site.run(&submission(&flags, FLIGHT, "frames/####.png")), 0);
    site
}

/// Runs the script; returns its code, and the numbers of the chunks that its workers were given.
fn run(site: &Site, args: &[&str], variables: &[(&str, &str)]) -> (Option<i32>, Vec<String>) {
    let _ = fs::remove_file(site.path("calls"));
    let mut command = site.command("sh");
    // It is run from anywhere.
    command.current_dir("/").arg(site.path("frames.job/chunk.sh")).args(args);
    for name in ["HQ_TASK_ID", "SLURM_ARRAY_TASK_ID", "HEDGEHOP_CHUNK_OFFSET"] {
        command.env_remove(name);
    }
    let status = command.envs(variables.iter().copied()).status().expect("sh starts");
    let calls = fs::read_to_string(site.path("calls")).unwrap_or_default();
    let chunk = |call: &str| call.rsplit_once("--chunk ").expect("a chunk").1.to_owned();
    (status.code(), calls.lines().map(chunk).collect())
}

#[test]
fn a_chunk_has_the_number_that_a_scheduler_gives_it() {
    let site = job("0");
    for (args, variables, chunk) in [
        (&["3"][..], &[][..], "3"),
        (&[], &[("HQ_TASK_ID", "2")], "2"),
        (&[], &[("SLURM_ARRAY_TASK_ID", "2")], "2"),
        (&[], &[("SLURM_ARRAY_TASK_ID", "2"), ("HEDGEHOP_CHUNK_OFFSET", "1000")], "1002"),
        // HyperQueue within a job of Slurm.
        (&[], &[("SLURM_ARRAY_TASK_ID", "1"), ("HQ_TASK_ID", "2")], "2"),
        (&["3"], &[("SLURM_ARRAY_TASK_ID", "1"), ("HQ_TASK_ID", "2")], "3"),
    ] {
        assert_eq!(run(&site, args, variables), (Some(0), vec![chunk.to_owned()]), "{variables:?}");
        assert!(site.path(&format!("frames.job/logs/{chunk}.log")).is_file());
    }
}

#[test]
fn failures_that_pass_are_tried_again() {
    let site = job("2");
    let last = "0 2 3 4 7".split(' ').map(|code| (code.to_owned(), code.parse().expect("a code"), 1));
    let passing = [("5\n0", 0, 2), ("137\n1\n0", 0, 3), ("1\n7", 7, 2), ("5\n5\n5\n0", 5, 3)];
    for (codes, code, calls) in
        last.chain(passing.map(|(codes, code, calls)| (codes.to_owned(), code, calls)))
    {
        fs::write(site.path("codes"), format!("{codes}\n")).expect("the codes are written");
        let (ended, called) = run(&site, &["1"], &[]);
        assert_eq!((ended, called.len()), (Some(code), calls), "{codes:?}");
    }
}
