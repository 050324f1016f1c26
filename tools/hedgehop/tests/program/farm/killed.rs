//! Processes that die: no frame is lost, and none that is finished is rendered again.

use std::os::unix::process::CommandExt;
use std::process::Child;

use rustix::process::{Pid, Signal, kill_process_group};

use super::site::{LONG, Site, signal, submission, wait_for};
use crate::common::ends;

const JOB: &str = "frames.job";
const FLAGS: &[&str] = &["--engine", "local", "--chunks", "4", "--samples", "0", "--at-once", "2"];

/// Starts a job, and waits until its folder is there.
fn started(site: &Site) -> Child {
    let job = site.start(&submission(FLAGS, LONG, "frames/####.png"));
    wait_for("job", || site.path("frames.job/parts").is_dir().then_some(()));
    job
}

/// Halts a worker that has told of some frames of its chunk, and not of all; returns its process and chunk.
fn halted(site: &Site) -> (u32, u64) {
    wait_for("worker in the midst of a chunk", || {
        for (process, chunk) in site.workers() {
            if site.told(JOB, chunk) < 2 {
                continue;
            }
            signal(process, Signal::STOP);
            // All frames of a chunk are told of before its worker ends.
            if site.told(JOB, chunk) < 15 && site.workers().contains(&(process, chunk)) {
                return Some((process, chunk));
            }
            signal(process, Signal::CONT);
        }
        None
    })
}

#[test]
fn a_chunk_whose_worker_is_killed_is_tried_again() {
    let site = Site::new("site");
    let mut job = started(&site);
    let (process, chunk) = halted(&site);
    let status = &site.status(JOB)["chunks"][chunk as usize - 1];
    assert_eq!(status["stage"], "running");
    assert_eq!(status["finished"].as_u64(), Some(site.told(JOB, chunk) as u64));
    signal(process, Signal::KILL);
    assert!(job.wait().expect("it ends").success());

    let tries = site.tries(JOB);
    assert_eq!(tries.iter().filter(|(of, _)| *of == chunk).count(), 2, "{tries:?}");
    assert_eq!(tries.len(), 5, "{tries:?}");
    site.assert_frames("frames/####.png", LONG);
    site.assert_once(JOB, 81);
}

#[test]
fn workers_outlive_who_started_them_and_are_waited_for() {
    let site = Site::new("site");
    let mut job = started(&site);
    let (process, chunk) = halted(&site);
    job.kill().expect("it is killed");
    job.wait().expect("it ends");
    assert!(site.workers().contains(&(process, chunk)));

    // It holds its chunk: whoever goes on with the job waits until it has ended.
    let mut next = site.start(&["farm", "retry", JOB]);
    let log = site.path(JOB).join(format!("logs/{chunk}.log"));
    wait_for("second worker of the chunk", || {
        let said = std::fs::read_to_string(&log).expect("the log");
        said.contains("another worker is at chunk").then_some(())
    });
    signal(process, Signal::CONT);
    assert!(next.wait().expect("it ends").success());
    site.assert_frames("frames/####.png", LONG);
    site.assert_once(JOB, 81);
}

#[test]
fn one_at_a_time_works_off_a_job_here() {
    let site = Site::new("site");
    let mut job = started(&site);
    let (process, _) = halted(&site);
    let said = ends(&site.run(&["farm", "retry", JOB]), 2);
    assert!(said.contains("frames.job is being worked off already"), "{said}");
    signal(process, Signal::CONT);
    assert!(job.wait().expect("it ends").success());
    site.assert_once(JOB, 81);
}

/// A script of a chunk that is killed leaves its worker behind; a machine that fails takes both along.
#[test]
fn a_task_that_is_killed_loses_no_frame() {
    let site = Site::new("site");
    let prepare = [FLAGS, &["--prepare"]].concat();
    ends(&site.run(&submission(&prepare, LONG, "frames/####.png")), 0);
    assert_eq!(site.stages(JOB), ["waiting"; 4]);

    let task = |chunk: &str| {
        let mut command = site.command("sh");
        command.args(["frames.job/chunk.sh", chunk]);
        command
    };
    let mut machine = task("2").process_group(0).spawn().expect("it starts");
    let (_, chunk) = halted(&site);
    let group = Pid::from_child(&machine);
    kill_process_group(group, Signal::KILL).expect("all are killed");
    machine.wait().expect("it ends");
    assert_eq!(chunk, 2);
    wait_for("end of the worker", || (site.stages(JOB)[1] == "open").then_some(()));

    // In a group of its own, a halted process would be hung up on when its parent ends.
    let mut script = task("1").spawn().expect("it starts");
    let (process, _) = halted(&site);
    script.kill().expect("it is killed");
    script.wait().expect("it ends");
    assert_eq!(site.stages(JOB)[0], "running");
    signal(process, Signal::CONT);

    ends(&site.run(&["farm", "retry", "--engine", "local", JOB]), 0);
    site.assert_frames("frames/####.png", LONG);
    site.assert_once(JOB, 81);
}

/// A request to stop goes from a script to its worker, which ends with whole frames.
#[test]
fn a_task_that_is_asked_to_stop_passes_it_on() {
    let site = Site::new("site");
    let prepare = [FLAGS, &["--prepare"]].concat();
    ends(&site.run(&submission(&prepare, LONG, "frames/####.png")), 0);
    let mut script = site.command("sh").args(["frames.job/chunk.sh", "1"]).spawn().expect("it starts");
    let (process, _) = halted(&site);
    signal(script.id(), Signal::TERM);
    signal(process, Signal::CONT);
    assert_eq!(script.wait().expect("it ends").code(), Some(143));
    assert_eq!(site.workers(), []);

    let chunk = &site.status(JOB)["chunks"][0];
    assert_eq!((&chunk["stage"], &chunk["tries"]), (&"stopped".into(), &1.into()));
    assert!(chunk["failure"].as_str().is_some_and(|failure| !failure.is_empty()), "{chunk}");
    ends(&site.run(&["farm", "retry", JOB]), 0);
    site.assert_once(JOB, 81);
}
