//! Where areas lie, and what is kept of builds.

use std::fs;
use std::time::{Duration, Instant};

use super::replay::{Replay, told};

pub fn tiles_across_the_180th_meridian(inputs: &Replay) {
    let info = inputs.built("--elevation S17E179.tif S17W180.tif");
    let bounds =
        ["west", "south", "east", "north"].map(|side| info["bounds"][side].as_f64().expect("metres"));
    let [width, height] = [bounds[2] - bounds[0], bounds[3] - bounds[1]];
    assert!((200.0e3..230.0e3).contains(&width) && (105.0e3..120.0e3).contains(&height), "{bounds:?}");
    let code = info["metadata"]["crs_epsg"].as_u64();
    assert!([Some(32_701), Some(32_760)].contains(&code), "{code:?}");
}

/// Longest that a build may take to have pages to keep.
const PATIENCE: Duration = Duration::from_secs(120);

/// Bytes beside the output that are pages which wait for their place.
const SOME_PAGES: u64 = 1 << 20;

#[cfg(unix)]
pub fn pages_of_interrupted_builds(inputs: &Replay) {
    let mut build = inputs.command("build p.toml", &[]);
    build.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut build = build.spawn().expect("the program starts");
    let start = Instant::now();

    while start.elapsed() < PATIENCE && kept(inputs) < SOME_PAGES {
        assert!(
            build.try_wait().expect("a process").is_none(),
            "the build ended before it had pages to keep"
        );
        std::thread::sleep(Duration::from_millis(20));
    }

    let pid = build.id().to_string();
    let is_sent = std::process::Command::new("kill").args(["-INT", &pid]).status().expect("kill starts");
    assert!(is_sent.success());
    let output = build.wait_with_output().expect("an end");
    assert_eq!(output.status.code(), Some(130), "{}", told(&output));
    assert!(kept(inputs) >= SOME_PAGES, "{} bytes are kept", kept(inputs));

    let again = inputs.done("build p.toml");
    assert!(again.contains("pages are as before"), "{again}");
}

#[cfg(not(unix))]
pub fn pages_of_interrupted_builds(_: &Replay) {}

/// Bytes of all files that a build of `p.toml` writes.
fn kept(inputs: &Replay) -> u64 {
    let entries = fs::read_dir(inputs.path(".")).expect("a folder").filter_map(Result::ok);
    let of_build = entries.filter(|entry| entry.file_name().to_string_lossy().contains("p.hop"));
    of_build.filter_map(|entry| entry.metadata().ok()).map(|metadata| metadata.len()).sum()
}
