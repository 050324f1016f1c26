//! Disks that are full or fail.

use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::process::Command;

use super::in_flight::{compared, streamed};
use super::random::Random;
use super::site::{Site, run};
use super::{Outcome, Verdict, ended, frames_are_right};

/// Runs a command of the system.
fn system(program: &str, args: &[&str]) -> Result<(), String> {
    let status = Command::new(program).args(args).status().map_err(|error| format!("{program}: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{program} {args:?}: {status}")) }
}

/// A mounted file system, until it is dropped.
struct Mounted(PathBuf);

impl Mounted {
    fn new(site: &Site, args: &[&str]) -> Result<Self, String> {
        let place = site.path("disk");
        fs::create_dir_all(&place).map_err(|error| error.to_string())?;
        system("mount", &[args, &[&place.to_string_lossy()]].concat())?;
        Ok(Self(place))
    }

    fn tmpfs(site: &Site, bytes: usize) -> Result<Self, String> {
        Self::new(site, &["-t", "tmpfs", "-o", &format!("size={bytes}"), "tmpfs"])
    }
}

impl Drop for Mounted {
    fn drop(&mut self) {
        let _ = system("umount", &[&self.0.to_string_lossy()]);
    }
}

/// The same command under a limit of what a file may hold, KiB.
fn within(limit: usize, command: &Command) -> Command {
    let mut limited = Command::new("bash");
    limited.args(["-c", "ulimit -f \"$0\" && exec \"$@\"", &limit.to_string()]).arg(command.get_program());
    limited.args(command.get_args());
    if let Some(folder) = command.get_current_dir() {
        limited.current_dir(folder);
    }
    limited
}

/// What a build left behind that had too little room.
fn built(site: &Site, folder: &Path, command: Command) -> Verdict {
    // 2: the area does not fit what is free, which is known before.
    let code = ended(&run(command), &[0, 2, 5], "area.hop")?;
    match fs::read(folder.join("area.hop")) {
        Ok(bytes) if code == 0 && bytes == site.area => Ok(Outcome::Same),
        Err(_) if code != 0 => Ok(Outcome::Refused(code)),
        _ => Err(format!("code {code}, but something else has the name of the database")),
    }
}

/// What a render left behind that had too little room.
fn rendered(site: &Site, out: &Path, command: Command) -> Verdict {
    let code = ended(&run(command), &[0, 5], "out")?;
    frames_are_right(site, out, code == 0)?;
    Ok(if code == 0 { Outcome::Same } else { Outcome::Refused(code) })
}

pub fn limited(site: &Site, random: &mut Random) -> Verdict {
    if random.below(2) == 0 {
        let folder = site.fresh("rest");
        let limit = random.below(site.area.len() / 1024 * 5 / 4);
        return built(site, &folder, within(limit, &site.build(&folder, "area.hop")));
    }
    let out = site.fresh("out");
    let largest = site.frames.values().map(Vec::len).max().unwrap_or(0) / 1024 + 2;
    let command = site.render(&site.path("area.hop"), "out/####.png");
    rendered(site, &out, within(random.below(largest), &command))
}

pub fn full(site: &Site, random: &mut Random) -> Verdict {
    if random.below(2) == 0 {
        let disk = Mounted::tmpfs(site, 4096 + random.below(site.area.len() * 5 / 2))?;
        return built(site, &disk.0, site.build(&disk.0, "area.hop"));
    }
    let all: usize = site.frames.values().map(Vec::len).sum();
    let disk = Mounted::tmpfs(site, 4096 + random.below(all * 2))?;
    let out = disk.0.join("out");
    let command = site.render(&site.path("area.hop"), "disk/out/####.png");
    rendered(site, &out, command)
}

/// A database with a hole, which a full disk cannot give memory for when it is read.
pub fn holed(site: &Site, random: &mut Random) -> Verdict {
    let disk = Mounted::tmpfs(site, site.area.len().next_multiple_of(4096) + 3 * 4096)?;
    let area = disk.0.join("area.hop");
    fs::write(&area, &site.area).map_err(|error| error.to_string())?;
    let pages = site.area.len() / 4096;

    streamed(site, &area, random, |random, process| {
        // Nobody reads while the hole could still be filled.
        let signal = |name: &str| system("kill", &[name, &process.to_string()]).expect("a signal");
        signal("-STOP");
        let (at, length) = (4096 * (1 + random.below(pages - 1)), 4096 * (1 + random.below(pages)));
        let hole = ["-p", "-o", &at.to_string(), "-l", &length.to_string(), &area.to_string_lossy()];

        // Punching changes the file's time; it is put back, so that what is met is the hole and nothing else.
        let modified = fs::metadata(&area).and_then(|metadata| metadata.modified()).expect("a time");
        system("fallocate", &hole).expect("a hole");
        let file = OpenOptions::new().write(true).open(&area).expect("the database opens");
        file.set_modified(modified).expect("the time is set");

        // Fills what the hole freed.
        let _ = fs::write(disk.0.join("rest"), vec![1; length + 64 * 4096]);
        signal("-CONT");
    })
}

/// A database on a disk whose end is lost.
pub fn failing(site: &Site, random: &mut Random) -> Verdict {
    let image = site.path("image");
    let name = image.to_string_lossy().into_owned();
    let size = 4 << 20;
    fs::write(&image, vec![0; size]).map_err(|error| error.to_string())?;
    system("mkfs.ext4", &["-q", "-O", "^has_journal", &name])?;
    {
        let disk = Mounted::new(site, &["-o", "loop", &name])?;
        fs::write(disk.0.join("area.hop"), &site.area).map_err(|error| error.to_string())?;
    }
    let disk = Mounted::new(site, &["-o", "loop,ro", &name])?;
    let image = OpenOptions::new().write(true).open(&image).map_err(|error| error.to_string())?;
    image.set_len(random.below(size) as u64).map_err(|error| error.to_string())?;
    let _ = fs::write("/proc/sys/vm/drop_caches", "3");
    let output = run(site.stream_of(&disk.0.join("area.hop")));
    compared(site, Vec::new(), &output)
}
