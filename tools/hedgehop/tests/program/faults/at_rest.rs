//! Files that are damaged before they are opened.

use std::fs;
use std::path::{Path, PathBuf};

use super::random::Random;
use super::site::{Site, program, run, stderr};
use super::{Outcome, Verdict, ended, frames_are_right};

/// Blocks that disks lose or mix up.
const BLOCK: usize = 4096;
/// Bytes of the fixed header, and where the directory's offset stands in it (FORMAT.md).
const HEADER: usize = 256;
const DIRECTORY_OFFSET: usize = 120;

/// How reading a damaged database may end; 4: the damage is in the version, which is looked at before any checksum.
const REFUSED: &[i32] = &[0, 3, 4];

fn directory_of(area: &[u8]) -> usize {
    u64::from_le_bytes(area[DIRECTORY_OFFSET..][..8].try_into().expect("eight bytes")) as usize
}

/// Somewhere in the file: header, directory and metadata, first bytes of a page, or anywhere.
fn place(area: &[u8], directory: usize, random: &mut Random) -> usize {
    match random.below(5) {
        0 => random.below(HEADER),
        1 => directory + random.below(area.len() - directory),
        2 => (BLOCK * (1 + random.below(directory / BLOCK)) + random.below(64)).min(area.len() - 1),
        _ => random.below(area.len()),
    }
}

fn flip(area: &mut [u8], random: &mut Random) {
    // Before it can be flipped itself.
    let directory = directory_of(area);
    for _ in 0..*random.of(&[1, 1, 2, 16]) {
        let at = place(area, directory, random);
        area[at] ^= 1 << random.below(8);
    }
}

fn write_area(site: &Site, bytes: &[u8]) -> PathBuf {
    let path = site.fresh("rest").join("area.hop");
    fs::write(&path, bytes).expect("the database is written");
    path
}

/// Renders a database: all frames as they are to be, or an error.
fn rendered(site: &Site, area: &Path, random: &mut Random) -> Verdict {
    let out = site.fresh("out");
    let mut command = site.render(area, "out/####.png");
    command.args(*random.of(&[&["-j", "1"][..], &["-j", "2"], &["-j", "2", "--memory", "100M"]]));
    let code = ended(&run(command), REFUSED, "area.hop")?;
    frames_are_right(site, &out, code == 0)?;
    Ok(if code == 0 { Outcome::Same } else { Outcome::Refused(code) })
}

pub fn flips_rendered(site: &Site, random: &mut Random) -> Verdict {
    let mut area = site.area.clone();
    flip(&mut area, random);
    rendered(site, &write_area(site, &area), random)
}

pub fn flips_verified(site: &Site, random: &mut Random) -> Verdict {
    let mut area = site.area.clone();
    flip(&mut area, random);
    let path = write_area(site, &area);
    let mut command = program();
    command.args(["verify", "--progress", "none"]).arg(&path);
    let output = run(command);
    if output.status.code() == Some(6) && String::from_utf8_lossy(&output.stdout).contains("problem: ") {
        return Ok(Outcome::Refused(6));
    }
    let code = ended(&output, REFUSED, "area.hop")?;
    match code == 0 {
        true if area != site.area => Err("`verify` calls a changed database sound".into()),
        true => Ok(Outcome::Same),
        false => Ok(Outcome::Refused(code)),
    }
}

pub fn blocks_rendered(site: &Site, random: &mut Random) -> Verdict {
    let mut area = site.area.clone();
    let blocks = area.len() / BLOCK;
    let (one, other) = (random.below(blocks) * BLOCK, random.below(blocks) * BLOCK);
    match random.below(3) {
        0 => area[one..one + BLOCK].fill(0),
        1 => area.copy_within(other..other + BLOCK, one),
        _ => (0..BLOCK).for_each(|byte| area.swap(one + byte, other + byte)),
    }
    rendered(site, &write_area(site, &area), random)
}

pub fn flips_left_out(site: &Site, random: &mut Random) -> Verdict {
    let mut area = site.area.clone();
    let pages = directory_of(&area) - BLOCK;
    for _ in 0..=random.below(3) {
        area[BLOCK + random.below(pages)] ^= 1 << random.below(8);
    }

    let path = write_area(site, &area);
    let streams = ["1", "2"].map(|workers| {
        let mut command = site.stream_of(&path);
        command.args(["--damaged", "coarser", "-j", workers]);
        run(command)
    });
    let code = ended(&streams[0], &[0, 3], "area.hop")?;
    if ended(&streams[1], &[0, 3], "area.hop")? != code {
        return Err("whether it is refused depends on the number of workers".into());
    }
    if code != 0 {
        return Ok(Outcome::Refused(code));
    }
    if streams[0].stdout != streams[1].stdout {
        return Err("pictures depend on the number of workers".into());
    }
    if stderr(&streams[0]).contains("shown from coarser levels") {
        return Ok(Outcome::StoodIn);
    }

    if streams[0].stdout == site.stream { Ok(Outcome::Same) } else { Err("differs without a word".into()) }
}

pub fn resized(site: &Site, random: &mut Random) -> Verdict {
    let mut area = site.area.clone();
    let (whole, directory) = (area.len(), directory_of(&area));
    let structural =
        [0, 1, 4, 8, 12, HEADER - 1, HEADER, BLOCK - 1, BLOCK, directory, directory + 32, whole - 1];
    match random.below(4) {
        0 => area.truncate(*random.of(&structural)),
        1 => area.truncate(BLOCK * random.below(whole / BLOCK) + random.below(3)),
        2 => area.truncate(random.below(whole)),
        _ => area.resize(whole + 1 + random.below(3 * BLOCK), *random.of(&[0, 0xff])),
    }
    let path = write_area(site, &area);
    match rendered(site, &path, random)? {
        Outcome::Same => Err("a database of another length was rendered".into()),
        other => Ok(other),
    }
}

/// Damages text: a bit, a missing end, a missing or doubled part.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(bytes.len());
    let part = at..(at + 1 + random.below(200)).min(bytes.len());
    match random.below(9) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(part)),
        2 => {
            let part = bytes[part].to_vec();
            drop(bytes.splice(at..at, part));
        }
        // The head of the file steers what follows.
        3 => bytes[at % 80] ^= 1 << random.below(8),
        _ => bytes[at] ^= 1 << random.below(8),
    }
}

pub fn inputs(site: &Site, random: &mut Random) -> Verdict {
    let folder = site.fresh("rest");
    let mut grid = fs::read(site.path("dem.asc")).expect("the grid");
    damage(&mut grid, random);
    fs::write(folder.join("dem.asc"), grid).expect("the grid is written");
    let mut build = program();
    build.current_dir(&folder).args(["build", "--elevation", "dem.asc", "--local", "-o", "area.hop"]);
    build.args(["--progress", "none"]);
    let code = ended(&run(build), &[0, 2, 3, 4], "")?;
    let is_there = folder.join("area.hop").exists();
    if code != 0 {
        return if is_there {
            Err("a refused input left a database".into())
        } else {
            Ok(Outcome::Refused(code))
        };
    }

    let mut verify = program();
    verify.current_dir(&folder).args(["verify", "--progress", "none", "area.hop"]);
    ended(&run(verify), &[0], "")?;
    let same = fs::read(folder.join("area.hop")).is_ok_and(|area| area == site.area);

    Ok(if same { Outcome::Same } else { Outcome::OtherInput })
}

pub fn paths(site: &Site, random: &mut Random) -> Verdict {
    let mut path = fs::read(site.path("path.csv")).expect("the path");
    damage(&mut path, random);
    let file = site.fresh("rest").join("path.csv");
    fs::write(&file, path).expect("the path is written");
    let out = site.fresh("out");
    let mut command = site.render(&site.path("area.hop"), "out/####.png");
    // Damage can make a flight of days; its first frames will do.
    command.arg("--path").arg(&file).args(["--frames", "1-9"]);
    let code = ended(&run(command), &[0, 2, 3, 4], "")?;
    match code == 0 {
        true if frames_are_right(site, &out, true).is_ok() => Ok(Outcome::Same),
        true => Ok(Outcome::OtherInput),
        false => Ok(Outcome::Refused(code)),
    }
}
