//! Processes of this machine: `--engine local`, what it leaves, and how a job goes on.

use std::fs;

use super::site::{FLIGHT, LONG, Site, submission, wait_for};
use crate::common::ends;

#[test]
fn a_job_gives_what_one_process_gives() {
    let site = Site::new("site");
    let flags = ["--engine", "local", "--chunks", "4", "--contact-sheet", "sheet.png"];
    let said = ends(&site.run(&submission(&flags, FLIGHT, "frames/####.png")), 0);
    assert!(said.contains("frames.job: 21 frames, listed in"), "{said}");
    site.assert_frames("frames/####.png", FLIGHT);
    site.assert_once("frames.job", 21);
    assert!(site.path("sheet.png").is_file());

    let status = site.status("frames.job");
    assert_eq!(
        (&status["frames"], &status["finished"], &status["left_s"]),
        (&21.into(), &21.into(), &0.0.into())
    );
    assert_eq!(site.stages("frames.job"), ["done"; 4]);
}

/// A file of flags is as good as flags, and names in it count from its folder.
#[test]
fn a_job_is_read_from_a_file() {
    let site = Site::new("site");
    let request = "area = \"area.hop\"\npath = \"path.csv\"\nfps = 5\nsize = \"160x90\"\nlevel = true\noutput = \"frames/####.png\"\n";
    fs::write(site.path("night.toml"), request).expect("the file is written");
    let around = site.folder.parent().expect("a folder");
    let args = ["farm", "submit", "--engine", "local", "--chunks", "2", "--samples", "0", "site/night.toml"];
    let output = site.command(env!("CARGO_BIN_EXE_hedgehop")).current_dir(around).args(args).output();
    ends(&output.expect("the program starts"), 0);
    site.assert_frames("frames/####.png", FLIGHT);
}

/// Flags that workers get, too, may be among the user's.
#[test]
fn flags_of_workers_may_be_given() {
    let site = Site::new("site");
    let own = ["--simd", "portable", "-j", "2", "--skip-existing", "--memory", "500M"];
    let flight = [FLIGHT, &own[..]].concat();
    let flags = ["--engine", "local", "--chunks", "3", "--samples", "0"];
    ends(&site.run(&submission(&flags, &flight, "frames/####.png")), 0);
    site.assert_frames("frames/####.png", &flight);
}

#[test]
fn two_jobs_in_one_folder_do_not_disturb_each_other() {
    let site = Site::new("site");
    let flags = ["--engine", "local", "--chunks", "4", "--samples", "0", "--at-once", "2"];
    let wide = [FLIGHT, &["--hfov", "80"]].concat();
    let mut jobs = [
        site.start(&submission(&flags, FLIGHT, "a/####.png")),
        site.start(&submission(&flags, &wide, "b/####.png")),
    ];
    for job in &mut jobs {
        assert!(job.wait().expect("it ends").success());
    }
    site.assert_frames("a/####.png", FLIGHT);
    site.assert_frames("b/####.png", &wide);
    site.assert_once("a.job", 21);
    site.assert_once("b.job", 21);
}

#[test]
fn a_retry_renders_what_is_missing_and_nothing_else() {
    let site = Site::new("site");
    let flags = ["--engine", "local", "--chunks", "4", "--samples", "0"];
    ends(&site.run(&submission(&flags, FLIGHT, "frames/####.png")), 0);
    let before = site.tries("frames.job");
    let missing = [before[1].1[0], before[1].1[2], before[3].1[1]];
    for frame in missing {
        fs::remove_file(site.path(&format!("frames/{frame:04}.png"))).expect("the frame was there");
    }

    let said = ends(&site.run(&["farm", "finish", "frames.job"]), 6);
    let lacks = format!("chunk 2 lacks frames {},{}\n", missing[0], missing[1]);
    assert!(said.contains(&lacks) && said.contains("3 frames are missing"), "{said}");
    let status = site.status("frames.job");
    assert_eq!(status["finished"], 18);
    assert_eq!(status["chunks"][3]["missing"], missing[2].to_string());

    let printed = ends(&site.run(&["farm", "retry", "--dry-run", "frames.job"]), 0);
    for (chunk, is_asked) in [(1, false), (2, true), (3, false), (4, true)] {
        assert_eq!(printed.contains(&format!("chunk.sh {chunk}\n")), is_asked, "{printed}");
    }
    assert_eq!(site.tries("frames.job"), before);

    ends(&site.run(&["farm", "retry", "frames.job"]), 0);
    let mut after = site.tries("frames.job");
    after.retain(|attempt| !before.contains(attempt));
    assert_eq!(after, [(2, missing[..2].to_vec()), (4, vec![missing[2]])]);
    site.assert_frames("frames/####.png", FLIGHT);

    let said = ends(&site.run(&["farm", "retry", "frames.job"]), 0);
    assert!(said.contains("no frame is missing"), "{said}");
    assert_eq!(site.tries("frames.job").len(), 6);
}

#[test]
fn a_job_that_is_cancelled_can_be_gone_on_with() {
    let site = Site::new("site");
    let flags = ["--engine", "local", "--chunks", "4", "--samples", "0", "--at-once", "2"];
    let mut job = site.start(&submission(&flags, LONG, "frames/####.png"));
    wait_for("frame", || site.path("frames.job/parts").is_dir().then_some(()));
    wait_for("frame", || (site.told("frames.job", 1) > 1).then_some(()));
    let said = ends(&site.run(&["farm", "cancel", "frames.job"]), 0);
    assert!(said.contains("asked the processes on this machine to stop"), "{said}");
    assert_eq!(job.wait().expect("it ends").code(), Some(130));
    assert_eq!(site.workers(), []);

    let finished = site.status("frames.job")["finished"].as_u64().expect("a count");
    assert!((1..81).contains(&finished), "{finished}");
    let said = ends(&site.run(&["farm", "cancel", "frames.job"]), 2);
    assert!(said.contains("nothing of frames.job is known to run"), "{said}");

    ends(&site.run(&["farm", "retry", "frames.job"]), 0);
    site.assert_frames("frames/####.png", LONG);
    site.assert_once("frames.job", 81);
}
