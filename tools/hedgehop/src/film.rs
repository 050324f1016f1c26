//! Frames of a film, small, through an installed ffmpeg.
//!
//! ```text
//! ffmpeg: film ──scaled, as PPM──▶ pipe ──▶ every s-th picture; several times as many as wanted: every second of them, s doubles
//! ```
//! So a film of any length is decoded once, and few pictures are held.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use image::RgbImage;

use crate::contact_sheet::{Entry, spread};
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Bytes of the longest header of a picture in the pipe.
const MOST_HEADER: u64 = 64;
/// Highest picture that is taken, pixels.
const TALLEST: u32 = 16_384;
/// Pictures that are held at most, unless more are wanted.
const MOST_HELD: usize = 512;
/// Bytes of ffmpeg's complaints that are looked at.
const COMPLAINT: u64 = 1 << 16;

/// Ends the process when dropped; one that has ended already is left alone.
struct Ending(Child);

impl Drop for Ending {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Reads so many of a film's frames at most, `width` pixels wide, evenly spread, first and last included, by their numbers from 1 on.
///
/// # Errors
/// The film is not there, or cannot be decoded; ffmpeg is not there; the user wants to stop.
pub fn entries(film: &Path, width: u32, count: usize, observer: &dyn Observer) -> Result<Vec<Entry>> {
    std::fs::metadata(film).map_err(|source| Error::io(film, "read it", source))?;
    let failed = |source| Error::io(film, "read what ffmpeg makes of it", source);
    let mut complaints = tempfile::tempfile().map_err(failed)?;
    let mut child = start(film, width, &complaints)?;
    let Some(pipe) = child.0.stdout.take() else {
        return Err(Error::unsupported(film, "ffmpeg has no pipe", "give the folder of the film's frames"));
    };

    let mut pipe = BufReader::new(pipe);
    // The more are held, the more evenly those are spread that are chosen.
    let most = 2 * count.max(1).max((4 * count).min(MOST_HELD / 2));
    let (mut kept, mut last, mut stride) = (Vec::<Entry>::new(), None, 1);

    for number in 1_u64.. {
        if observer.cancelled() {
            return Err(Error::Interrupted(format!("{} was not read to its end", film.display())));
        }

        let Some(picture) = picture(&mut pipe, width).map_err(failed)? else { break };
        observer.advance(1);
        let entry = Entry { label: number.to_string(), picture };
        if (number - 1) % stride == 0 {
            kept.push(entry);
            last = None;
        } else {
            last = Some(entry);
        }

        if kept.len() == most {
            last = kept.last().cloned();
            kept = kept.into_iter().step_by(2).collect();
            stride *= 2;
        }
    }

    let status = child.0.wait().map_err(failed)?;
    if !status.success() || kept.is_empty() {
        let words = words(&mut complaints).unwrap_or_else(|| "it holds no pictures".to_owned());
        return Err(Error::invalid(film, format!("ffmpeg could not decode it: {words}")));
    }

    kept.extend(last);
    let chosen = spread(kept.len(), count);
    Ok(kept
        .into_iter()
        .enumerate()
        .filter(|(index, _)| chosen.contains(index))
        .map(|(_, entry)| entry)
        .collect())
}

fn start(film: &Path, width: u32, complaints: &File) -> Result<Ending> {
    let missing = |error: io::Error| {
        Error::unsupported(
            film,
            format!("reading a film needs the program ffmpeg, which cannot be started ({error})"),
            "install it (Debian, Ubuntu: apt-get install ffmpeg), or give the folder of the film's frames",
        )
    };
    let mut name = std::ffi::OsString::from("file:");
    name.push(film);
    let mut command = Command::new("ffmpeg");
    command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-i"]).arg(name);
    command.args(["-map", "0:v:0", "-an", "-vf", &format!("scale={width}:-1:flags=area")]);
    command.args(["-f", "image2pipe", "-c:v", "ppm", "-"]);
    let complaints = complaints.try_clone().map_err(missing)?;
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(complaints);
    command.spawn().map(Ending).map_err(missing)
}

/// The next picture of a stream of PPM (raw, 8 bits); `None`: it has ended.
fn picture(pipe: &mut impl BufRead, width: u32) -> io::Result<Option<RgbImage>> {
    if pipe.fill_buf()?.is_empty() {
        return Ok(None);
    }
    let wrong = || io::Error::new(io::ErrorKind::InvalidData, "no picture");
    let mut line = |most: u64| {
        let mut text = String::new();
        Read::take(&mut *pipe, most).read_line(&mut text).map(|_| text)
    };
    let [kind, size, depth] = [line(MOST_HEADER)?, line(MOST_HEADER)?, line(MOST_HEADER)?];
    let sides: Vec<u32> = size.split_whitespace().filter_map(|side| side.parse().ok()).collect();
    match sides.as_slice() {
        &[wide, high] if kind.trim() == "P6" && depth.trim() == "255" && wide == width && high <= TALLEST => {
            let mut pixels = vec![0; wide as usize * high as usize * 3];
            pipe.read_exact(&mut pixels)?;
            Ok(RgbImage::from_raw(wide, high, pixels))
        }
        _ => Err(wrong()),
    }
}

/// Returns the last line of ffmpeg's messages.
fn words(complaints: &mut File) -> Option<String> {
    complaints.rewind().ok()?;
    let mut text = Vec::new();
    complaints.take(COMPLAINT).read_to_end(&mut text).ok()?;
    let text = String::from_utf8_lossy(&text);
    let last = text.lines().rev().map(str::trim).find(|line| !line.is_empty())?;
    Some(last.chars().filter(|char| !char.is_control()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_out_of_a_pipe_one_by_one() {
        let one = [&b"P6\n2 1\n255\n"[..], &[1, 2, 3, 10, 10, 10]].concat();
        let mut pipe = io::Cursor::new([&one[..], &one].concat());
        for _ in 0..2 {
            let read = picture(&mut pipe, 2).unwrap().unwrap();
            assert_eq!(read.as_raw().as_slice(), [1, 2, 3, 10, 10, 10]);
        }
        assert!(picture(&mut pipe, 2).unwrap().is_none());
        for wrong in [
            &b"P6\n2 1\n255\nab"[..],
            b"P6\n4000000000 1\n255\n",
            b"P5\n2 1\n255\nabcdef",
            b"P6",
            b"\n\n\n\n",
        ] {
            assert!(picture(&mut io::Cursor::new(wrong), 2).is_err(), "{wrong:?}");
        }
    }
}
