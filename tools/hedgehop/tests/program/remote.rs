//! Databases behind a URL: the same answers and pixels as of the file, whatever the server and the network do.

#![expect(clippy::print_stdout, reason = "figures for whoever runs them with --nocapture")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

use tempfile::TempDir;

use crate::common::ends;
use crate::common::range_server::{Behaviour, RangeServer, Tells};

/// Two databases of the same shape, a path over them, frames of both from their files, and what the flight needs.
struct RemoteSite {
    folder: TempDir,
    area: Arc<Vec<u8>>,
    other: Arc<Vec<u8>>,
    /// Bytes that the plan says, and those of header, directory and metadata.
    flight_bytes: u64,
    ends_bytes: u64,
}

static SITE: LazyLock<RemoteSite> = LazyLock::new(RemoteSite::built);

const FLIGHT: [&str; 11] =
    ["--path", "path.csv", "--size", "160x90", "--fps", "5", "--level", "--hfov", "30", "--progress", "none"];

impl RemoteSite {
    fn built() -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let grid = |raised: f64| {
            let side = 1000;
            let mut grid = format!("ncols {side}\nnrows {side}\nxllcorner 0\nyllcorner 0\ncellsize 3\n");
            for row in 0..side {
                let wave = 30.0 * (f64::from(row) * 0.03).cos() + raised * (f64::from(row) * 0.2).sin();
                let height = |column: i32| 100.0 + 40.0 * (f64::from(column) * 0.02).sin() + wave;
                let heights: Vec<String> = (0..side).map(|column| format!("{:.2}", height(column))).collect();
                grid += &heights.join(" ");
                grid.push('\n');
            }
            grid
        };
        let path = "t_s,x_m,y_m,alt_agl_m\n0,700,900,60\n2,1100,1200,60\n4,1500,1500,60\n";
        fs::write(folder.path().join("path.csv"), path).expect("the path is written");
        // Of one name, so that both files are as long.
        for (name, raised) in [("area", 0.0), ("other", 6.0)] {
            fs::create_dir(folder.path().join(name)).expect("a folder");
            let (dem, area) = (format!("{name}/dem.asc"), format!("{name}.hop"));
            fs::write(folder.path().join(&dem), grid(raised)).expect("the grid is written");
            ends(&program(folder.path(), &["build", "--elevation", &dem, "--local", "-o", &area]), 0);
        }

        let plan =
            [&["plan", "area.hop", "--json", "--no-timing", "--page-list", "list.csv"], &FLIGHT[..]].concat();
        let planned = program(folder.path(), &plan);
        ends(&planned, 0);
        let planned: serde_json::Value = serde_json::from_slice(&planned.stdout).expect("it is JSON");
        let flight_bytes = planned["flight_bytes"].as_u64().expect("bytes");
        let list = fs::read_to_string(folder.path().join("list.csv")).expect("the list is there");
        let length = |line: &str| line.split(',').nth(1).and_then(|length| length.parse::<u64>().ok());
        let bytes = |is: &dyn Fn(&str) -> bool| -> u64 {
            list.lines().skip(1).filter(|line| is(line)).filter_map(length).sum()
        };
        println!("the flight needs {flight_bytes} bytes");
        let ends_bytes = bytes(&|line| line.contains(",file,"));
        assert_eq!(bytes(&|line| !line.ends_with(',')), flight_bytes, "the list is the plan");

        let read = |name: &str| Arc::new(fs::read(folder.path().join(name)).expect("it was built"));
        let (area, other) = (read("area.hop"), read("other.hop"));
        assert_eq!(area.len(), other.len(), "only what they say differs");
        let site = Self { area, other, flight_bytes, ends_bytes, folder };
        ends(&site.render("area.hop", "local", &[]), 0);
        ends(&site.render("area.hop", "local-unchecked", &["--verify", "never"]), 0);
        site
    }

    /// Flies over a database into a folder of frames.
    fn render(&self, area: &str, frames: &str, args: &[&str]) -> Output {
        self.renderer(area, frames, args).output().expect("it starts")
    }

    fn renderer(&self, area: &str, frames: &str, args: &[&str]) -> Command {
        let pattern = format!("{frames}/####.png");
        let mut command = command(self.folder.path());
        command.args(["render", area, "-o", &pattern, "-j", "2"]).args(FLIGHT).args(args);
        command
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a database that has the name which frames tell.
    fn named_area(&self, folder: &str, bytes: &[u8]) -> String {
        fs::create_dir(self.path(folder)).expect("a folder");
        fs::write(self.path(folder).join("area.hop"), bytes).expect("it is written");
        format!("{folder}/area.hop")
    }

    /// Frames of a folder by their names.
    fn frames(&self, folder: &str) -> Vec<(String, Vec<u8>)> {
        let Ok(entries) = fs::read_dir(self.path(folder)) else { return Vec::new() };
        let names = entries.map(|entry| entry.expect("an entry").path());
        let pngs = names.filter(|path| path.extension().is_some_and(|ending| ending == "png"));
        let mut frames: Vec<_> = pngs
            .map(|path| {
                (
                    path.file_name().expect("a name").to_string_lossy().into(),
                    fs::read(&path).expect("a frame"),
                )
            })
            .collect();
        frames.sort();
        frames
    }

    #[track_caller]
    fn assert_same(&self, folder: &str) {
        self.assert_same_as("local", folder);
    }

    /// As [`Self::assert_same`], of pages that were not checked, which frames tell.
    #[track_caller]
    fn assert_same_unchecked(&self, folder: &str) {
        self.assert_same_as("local-unchecked", folder);
    }

    #[track_caller]
    fn assert_same_as(&self, local: &str, folder: &str) {
        let (local, remote) = (self.frames(local), self.frames(folder));
        assert_eq!((local.len(), remote.len()), (21, 21));
        for (one, other) in local.iter().zip(&remote) {
            assert!(one == other, "{folder}/{} differs from the one of the file", one.0);
        }
    }
}

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hedgehop"));
    for proxy in ["http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY", "https_proxy", "HTTPS_PROXY"] {
        command.env_remove(proxy);
    }
    command.current_dir(folder).stdin(Stdio::null());
    command
}

fn program(folder: &Path, args: &[&str]) -> Output {
    command(folder).args(args).output().expect("it starts")
}

/// A cache of one's own.
struct OwnCache(TempDir);

impl OwnCache {
    fn new() -> Self {
        Self(TempDir::new().expect("a temporary folder"))
    }

    fn flags(&self) -> [&str; 2] {
        ["--cache", self.0.path().to_str().expect("a name")]
    }

    /// Copies of databases in it.
    fn copies(&self) -> Vec<PathBuf> {
        let entries =
            fs::read_dir(self.0.path()).expect("a folder").map(|entry| entry.expect("an entry").path());
        entries.map(|path| path.join("area.hop")).filter(|path| path.exists()).collect()
    }
}

#[test]
fn a_flight_from_a_url_shows_the_same_fetches_what_is_planned_and_keeps_it() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let server = RangeServer::start(site.area.clone(), Behaviour::default());
    let said = ends(&site.render(&server.url(), "url", &cache.flags()), 0);
    site.assert_same("url");
    let sent = server.take_sent();
    println!(
        "fetched {sent} bytes in {} requests, {} at once; planned {} and {} of the ends",
        server.requests(),
        server.most_at_once(),
        site.flight_bytes,
        site.ends_bytes
    );
    assert!(sent as f64 <= 1.1 * site.flight_bytes as f64 + site.ends_bytes as f64 + 8192.0, "{sent}");
    assert!(
        server.heads().iter().all(|head| head.to_ascii_lowercase().contains("accept-encoding: identity\r\n"))
    );

    // Nothing is fetched again, and nothing secret was written anywhere.
    let again = ends(&site.render(&server.url(), "url-again", &cache.flags()), 0);
    site.assert_same("url-again");
    assert_eq!(server.take_sent(), 0);
    assert!(!(said + &again).contains("HIDDEN"));
    for folder in [site.path("url"), cache.0.path().to_owned()] {
        let found = Command::new("grep").args(["-r", "-l", "HIDDEN"]).arg(&folder).output().expect("grep");
        assert_eq!(String::from_utf8_lossy(&found.stdout), "", "{}", folder.display());
    }
}

#[test]
fn servers_that_fail_and_are_slow_change_no_pixel() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let behaviour = Behaviour { fails_every: 5, pause: Duration::from_millis(30), ..Behaviour::default() };
    let server = RangeServer::start(site.area.clone(), behaviour);
    ends(&site.render(&server.url(), "failing", &cache.flags()), 0);
    site.assert_same("failing");
    println!("{} requests of which every fifth failed, {} at once", server.requests(), server.most_at_once());
    assert!(server.requests() > 15 && server.most_at_once() > 3);
}

#[test]
fn a_server_that_always_fails_ends_the_run_with_its_name() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let failing = Behaviour { fails_every: 1, ..Behaviour::default() };
    let server = RangeServer::start(site.area.clone(), failing);
    let said = ends(&site.render(&server.url(), "never", &cache.flags()), 5);
    assert!(
        said.contains("/areas/area.hop: cannot open it as a database:") && said.contains("8 times"),
        "{said}"
    );
    assert_eq!((site.frames("never").len(), server.requests()), (0, 8));
}

/// Unchecked pages would show what was mixed.
#[test]
fn a_database_replaced_meanwhile_ends_the_run_and_mixes_no_frame() {
    let site = &*SITE;
    for (tells, after) in [
        (Tells::Tag, 4),
        (Tells::Tag, 12),
        (Tells::TagAlone, 4),
        (Tells::Time, 6),
        (Tells::Nothing, 6),
        (Tells::Nothing, 12),
    ] {
        let cache = OwnCache::new();
        let behaviour =
            Behaviour { tells, replaced: Some((after, site.other.clone())), ..Behaviour::default() };
        let server = RangeServer::start(site.area.clone(), behaviour);
        let folder = format!("replaced-{tells:?}-{after}");
        let args = [&cache.flags()[..], &["--verify", "never"]].concat();
        let said = ends(&site.render(&server.url(), &folder, &args), 5);
        assert!(said.contains("was replaced on its server while it was in use"), "{tells:?}: {said}");
        // The first frame needs more requests than six; those that were whole before a later one are of the first database.
        let (before, whole) = (site.frames(&folder), site.frames("local-unchecked"));
        assert!(before.is_empty() || after > 6, "{tells:?} {after}");
        assert!(before.iter().all(|frame| whole.iter().any(|other| other == frame)), "{tells:?} {after}");

        // Nothing of the other one was kept as this one's: a run with the server as it was before shows this.
        let server = RangeServer::start(site.area.clone(), Behaviour { tells, ..Behaviour::default() });
        ends(&site.render(&server.url(), &format!("{folder}-again"), &args), 0);
        site.assert_same_unchecked(&format!("{folder}-again"));
    }
}

#[test]
fn a_database_replaced_between_two_runs_is_another_one() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let replaced = Behaviour { replaced: Some((0, site.other.clone())), ..Behaviour::default() };
    let (before, after) = (
        RangeServer::start(site.area.clone(), Behaviour::default()),
        RangeServer::start(site.area.clone(), replaced),
    );
    ends(&site.render(&before.url(), "before", &cache.flags()), 0);
    ends(&site.render(&after.url(), "after", &cache.flags()), 0);
    let other = site.named_area("of-other-file", &site.other);
    ends(&site.render(&other, "of-other", &[]), 0);
    site.assert_same("before");
    assert!(site.frames("after") == site.frames("of-other") && site.frames("after") != site.frames("before"));
    assert_eq!(cache.copies().len(), 2);
}

#[test]
fn two_processes_share_a_cache() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let slow = Behaviour { pause: Duration::from_millis(20), ..Behaviour::default() };
    let server = RangeServer::start(site.area.clone(), slow);
    let start = |frames: &str| {
        let mut command = site.renderer(&server.url(), frames, &cache.flags());
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts")
    };
    let both = [start("one"), start("two")];
    for process in both {
        ends(&process.wait_with_output().expect("it ends"), 0);
    }
    site.assert_same("one");
    site.assert_same("two");
    println!("two processes fetched {} bytes, planned {}", server.sent(), site.flight_bytes);
    server.take_sent();
    ends(&site.render(&server.url(), "three", &cache.flags()), 0);
    site.assert_same("three");
    assert_eq!(server.sent(), 0);
}

/// Unchecked pages would show blocks that are said to be there and are not.
#[test]
fn a_killed_process_leaves_a_sound_cache() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let slow = Behaviour { pause: Duration::from_millis(400), ..Behaviour::default() };
    let server = RangeServer::start(site.area.clone(), slow);
    let kept = || -> u32 {
        let bits = |copy: PathBuf| fs::read(copy.with_file_name("present")).unwrap_or_default();
        cache.copies().into_iter().flat_map(bits).map(u8::count_ones).sum()
    };
    let mut blocks = Vec::new();
    for after in [Duration::ZERO, Duration::from_millis(250), Duration::ZERO] {
        let (mut command, before) = (site.renderer(&server.url(), "killed", &cache.flags()), kept());
        let mut process = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts");
        while kept() == before && process.try_wait().expect("a process").is_none() {
            std::thread::sleep(Duration::from_millis(2));
        }
        std::thread::sleep(after);
        process.kill().expect("it is killed");
        process.wait().expect("it has ended");
        blocks.push(kept());
        let _ = fs::remove_dir_all(site.path("killed"));
    }

    println!("blocks kept after each kill: {blocks:?}");
    assert!(blocks[0] > 0);
    let args = [&cache.flags()[..], &["--verify", "never"]].concat();
    ends(&site.render(&server.url(), "after-kill", &args), 0);
    site.assert_same_unchecked("after-kill");
}

#[test]
#[cfg(target_os = "linux")]
fn a_cache_smaller_than_the_flight_holds_its_bound_afterwards() {
    use std::os::unix::fs::MetadataExt;
    let (site, cache) = (&*SITE, OwnCache::new());
    let server = RangeServer::start(site.area.clone(), Behaviour::default());
    let args = [&cache.flags()[..], &["--cache-size", "1M", "--verify", "never"]].concat();
    for frames in ["small", "small-again"] {
        ends(&site.render(&server.url(), frames, &args), 0);
        site.assert_same_unchecked(frames);
        let taken: u64 =
            cache.copies().iter().map(|copy| fs::metadata(copy).expect("a copy").blocks() * 512).sum();
        println!("{frames}: {taken} bytes on the disk, {} fetched", server.take_sent());
        // File systems need some blocks to know where the others are.
        assert!(taken > 0 && taken <= (1 << 20) + (64 << 10), "{taken}");
    }
}

#[test]
fn what_the_cache_has_damaged_is_fetched_again() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let server = RangeServer::start(site.area.clone(), Behaviour::default());
    ends(&site.render(&server.url(), "undamaged", &cache.flags()), 0);
    let copy = &cache.copies()[0];
    let damaged: Vec<u8> = fs::read(copy).expect("the copy").iter().map(|byte| byte ^ 1).collect();
    fs::write(copy, damaged).expect("it is damaged");
    ends(&site.render(&server.url(), "healed", &cache.flags()), 0);
    site.assert_same("healed");
}

#[test]
fn servers_that_do_not_give_it_are_told_apart() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let whole = Behaviour { ignores_ranges: true, ..Behaviour::default() };
    let status = |code| Behaviour { status: Some(code), ..Behaviour::default() };
    for (behaviour, what) in [
        (whole, "does not give parts of files"),
        (status(403), "sign a new one"),
        (status(404), "nothing is there"),
        (status(410), "there no more"),
    ] {
        let server = RangeServer::start(site.area.clone(), behaviour);
        let url = server.url().replace("http://", "http://me:HIDDEN@");
        let info = program(site.folder.path(), &[&["info", &url][..], &cache.flags()].concat());
        let said = ends(&info, 5);
        assert!(said.contains(what) && !said.contains("HIDDEN") && said.lines().count() == 1, "{said}");
        assert!(said.contains("error: http://127.0.0.1:") && said.contains("/areas/area.hop: "), "{said}");
        let named =
            |head: &String| head.contains("Basic bWU6SElEREVO") || head.contains("basic bWU6SElEREVO");
        assert!(server.heads().iter().all(named), "the name and the password are sent");
    }

    let said = ends(&program(site.folder.path(), &["info", "s3://bucket/area.hop?key=HIDDEN"]), 2);
    assert!(said.contains("presigned") && !said.contains("HIDDEN"), "{said}");
    let text = RangeServer::start(Arc::new(vec![b'x'; 9000]), Behaviour::default());
    let info = program(site.folder.path(), &[&["info", &text.url()][..], &cache.flags()].concat());
    assert!(ends(&info, 3).contains("not a hedgehop database"));
}

#[test]
fn commands_say_the_same_of_a_url_and_follow_where_it_leads() {
    let (site, cache) = (&*SITE, OwnCache::new());
    let server = RangeServer::start(site.area.clone(), Behaviour::default());
    let moved = server.url().replace("/areas/area.hop", "/moved/area.hop");
    let shown = server.url().replace("/areas/area.hop?signature=HIDDEN", "/moved/area.hop");
    for line in [
        "info AREA",
        "info --classes AREA",
        "height AREA 500 600 700,800 --xy",
        "profile AREA --from 100,100 --to 2000,1500 --xy",
        "sight AREA --from 300,300,10 --to 1500,1500,10 --xy",
        "plan AREA --path path.csv --size 160x90 --fps 5 --no-timing --progress none",
        "verify AREA --progress none",
    ] {
        let said = |area: &str, more: &[&str]| {
            let line = line.replace("AREA", area);
            let args: Vec<_> = line.split(' ').chain(more.iter().copied()).collect();
            ends(&program(site.folder.path(), &args), 0)
        };
        let free = |text: String| -> Vec<String> {
            text.lines().filter(|line| !line.contains("this machine")).map(str::to_owned).collect()
        };
        let (local, remote) = (said("area.hop", &[]), said(&moved, &cache.flags()));
        assert_eq!(free(remote.replace(&shown, "area.hop")), free(local), "{line}");
    }
}

/// Of the file nothing is there but what the list names.
#[test]
fn a_copy_of_the_listed_bytes_serves_the_flight() {
    let site = &*SITE;
    let list = fs::read_to_string(site.path("list.csv")).expect("the list");
    let mut part = vec![0; site.area.len()];
    for line in list.lines().skip(1) {
        let mut numbers = line.split(',').map(|field| field.parse::<usize>());
        let (first, length) = (numbers.next(), numbers.next());
        let (first, length) =
            (first.expect("a column").expect("a byte"), length.expect("a column").expect("a length"));
        part[first..first + length].copy_from_slice(&site.area[first..first + length]);
    }
    assert!(part != *site.area, "a flight needs a part");
    let area = site.named_area("part-file", &part);
    ends(&site.render(&area, "part", &[]), 0);
    site.assert_same("part");
}
