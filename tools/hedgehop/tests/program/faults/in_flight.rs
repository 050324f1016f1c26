//! Files that change, and processes that are killed, while they work.

use std::fs::{self, OpenOptions};
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::Duration;

use super::random::Random;
use super::site::{Site, finish, program, run, start, stderr};
use super::{Outcome, Verdict, ended, frames_are_right};

fn resize(path: &Path, length: u64) {
    let file = OpenOptions::new().write(true).open(path).expect("the database opens");
    file.set_len(length).expect("the database is resized");
}

/// Renders to a pipe that is not read further than some byte until `change`, which is told the process, has happened.
pub fn streamed(
    site: &Site,
    area: &Path,
    random: &mut Random,
    change: impl FnOnce(&mut Random, u32),
) -> Verdict {
    let mut command = site.stream_of(area);
    command.args(*random.of(&[&["-j", "1"][..], &["-j", "2"], &["-j", "2", "--memory", "100M"]]));
    let mut child = start(command);
    let mut before = vec![0; random.below(site.stream.len() * 2 / 3)];
    let read = child.stdout.as_mut().map_or(Ok(()), |stdout| stdout.read_exact(&mut before));
    change(random, child.id());
    let output = finish(child);
    if let Err(error) = read {
        return Err(format!("the stream ends early: {error}: {}", stderr(&output)));
    }
    compared(site, before, &output)
}

/// A stream, its beginning and what the program then gave, against that of an undisturbed run.
pub fn compared(site: &Site, mut stream: Vec<u8>, output: &Output) -> Verdict {
    let code = ended(output, &[0, 3, 5], "area.hop")?;
    stream.extend(&output.stdout);
    if !site.stream.starts_with(&stream) {
        return Err(format!("code {code}: the stream differs from that of an undisturbed run"));
    }
    match code == 0 {
        true if stream.len() < site.stream.len() => Err("the stream is cut short without a word".into()),
        true => Ok(Outcome::Same),
        false => Ok(Outcome::Refused(code)),
    }
}

pub fn truncated(site: &Site, random: &mut Random) -> Verdict {
    let area = site.fresh("rest").join("area.hop");
    fs::write(&area, &site.area).expect("the database is written");
    streamed(site, &area, random, |random, _| resize(&area, random.below(site.area.len()) as u64))
}

pub fn rewritten(site: &Site, random: &mut Random) -> Verdict {
    let area = site.fresh("rest").join("area.hop");
    fs::write(&area, &site.area).expect("the database is written");
    streamed(site, &area, random, |random, _| {
        let mut other = site.area.clone();
        if random.below(2) == 0 {
            other[4096..].reverse();
        }
        // As `cp` does it: cut to nothing first.
        fs::write(&area, &other).expect("the database is written anew");
    })
}

/// Waits a while, then kills outright; some runs have ended by then, which usually take `time`.
fn kill_later(child: &mut Child, time: Duration, random: &mut Random) {
    thread::sleep(time.mul_f64(random.below(1250) as f64 / 1000.0));
    let _ = child.kill();
}

fn start_silently(mut command: Command) -> Child {
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts")
}

pub fn render_killed(site: &Site, random: &mut Random) -> Verdict {
    let out = site.fresh("out");
    let area = site.path("area.hop");
    let mut child = start_silently(site.render(&area, "out/####.png"));
    kill_later(&mut child, site.render_time, random);
    let status = child.wait().map_err(|error| error.to_string())?;
    frames_are_right(site, &out, status.success())?;
    let mut again = site.render(&area, "out/####.png");
    again.arg("--skip-existing");
    ended(&run(again), &[0], "")?;
    frames_are_right(site, &out, true)?;
    Ok(if status.success() { Outcome::Same } else { Outcome::Recovered })
}

pub fn build_killed(site: &Site, random: &mut Random) -> Verdict {
    let folder = site.fresh("rest");
    let target = folder.join("area.hop");

    // Over nothing, or over an older database, which must then be there until the new one is.
    let older = random.below(2) == 0;
    if older {
        fs::write(&target, b"older").expect("an older file");
    }

    let build = || {
        let mut command = site.build(&folder, "area.hop");
        command.arg("--overwrite");
        command
    };
    let mut child = start_silently(build());
    kill_later(&mut child, site.build_time, random);
    let status = child.wait().map_err(|error| error.to_string())?;

    match fs::read(&target) {
        Ok(bytes) if bytes == site.area => {}
        Ok(bytes) if older && bytes == b"older" && !status.success() => {}
        Err(_) if !older && !status.success() => {}
        _ => return Err("something else than a whole database has its name".into()),
    }

    for entry in fs::read_dir(&folder).map_err(|error| error.to_string())? {
        let left = entry.map_err(|error| error.to_string())?.path();
        if left != target {
            let mut info = program();
            info.arg("info").arg(&left);
            // A build that was killed between its last write and the rename leaves a database that is whole.
            let code = ended(&run(info), &[0, 3], "part-")?;
            if code == 0 && fs::read(&left).is_ok_and(|bytes| bytes != site.area) {
                return Err("what a killed build left opens, and is not whole".into());
            }
        }
    }

    ended(&run(build()), &[0], "")?;
    match fs::read(&target) {
        Ok(bytes) if bytes != site.area => Err("a second build gives other bytes".into()),
        Err(error) => Err(format!("a second build leaves nothing: {error}")),
        Ok(_) if status.success() => Ok(Outcome::Same),
        Ok(_) => Ok(Outcome::Recovered),
    }
}

/// A grid of 20 × 20 posts on top of the others, of one height but for one post.
fn cover(folder: &Path, height: u32) {
    let mut rows = vec![vec![120; 20]; 20];
    rows[9][9] = height;
    let rows: Vec<String> =
        rows.iter().map(|row| row.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")).collect();
    let head = "ncols 20\nnrows 20\nxllcorner 400\nyllcorner 400\ncellsize 10\n";
    fs::write(folder.join("cover.asc"), format!("{head}{}\n", rows.join("\n"))).expect("the grid is written");
}

/// A recipe is built, changed, and built again: killed at any time, or as soon as the database itself is being changed.
pub fn update_killed(site: &Site, random: &mut Random) -> Verdict {
    let folder = site.fresh("rest");
    let (target, journal) = (folder.join("area.hop"), folder.join("area.hop.undo"));
    let dem = site.path("dem.asc");
    let recipe = format!(
        "[place]\nlocal = true\n[[elevation]]\nfile = \"cover.asc\"\n[[elevation]]\nfile = \"{}\"\n",
        dem.display()
    );
    fs::write(folder.join("area.toml"), recipe).expect("the recipe is written");
    let build = |output: &str| {
        let mut command = program();
        command.current_dir(&folder).args(["build", "area.toml", "--progress", "none", "-o", output]);
        command
    };
    cover(&folder, 120);
    ended(&run(build("area.hop")), &[0], "")?;
    let before = fs::read(&target).map_err(|error| error.to_string())?;
    cover(&folder, 121 + random.below(9) as u32);
    ended(&run(build("clean.hop")), &[0], "")?;
    let after = fs::read(folder.join("clean.hop")).map_err(|error| error.to_string())?;

    let mut child = start_silently(build("area.hop"));
    if random.below(4) == 0 {
        kill_later(&mut child, site.build_time.div_f64(2.0), random);
    } else {
        while !journal.exists() && child.try_wait().map_err(|error| error.to_string())?.is_none() {
            thread::yield_now();
        }
        thread::sleep(Duration::from_micros(random.below(3000) as u64));
        let _ = child.kill();
    }

    let status = child.wait().map_err(|error| error.to_string())?;
    let mut info = program();
    info.arg("info").arg(&target);
    ended(&run(info), &[0], "")?;
    let found = fs::read(&target).map_err(|error| error.to_string())?;
    if journal.exists() || !(found == after || (found == before && !status.success())) {
        return Err("neither the database that was there, nor the new one".into());
    }

    ended(&run(build("area.hop")), &[0], "")?;
    match fs::read(&target) {
        Ok(bytes) if bytes == after && status.success() => Ok(Outcome::Same),
        Ok(bytes) if bytes == after => Ok(Outcome::Recovered),
        _ => Err("a second build gives other bytes".into()),
    }
}
