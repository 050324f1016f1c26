//! Sound track of a film: whether ffmpeg can read it, and how long it lasts.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::failure::{last_words, missing};
use hedgehop_base::error::{Error, Result};

/// Length of the fade where sound is cut at the film's end, seconds.
const FADE: f64 = 1.0;

/// File with sound that ffmpeg can read.
#[derive(Debug, Clone, PartialEq)]
pub struct SoundTrack {
    /// The file.
    pub file: PathBuf,
    /// Length, seconds; `None`: the file does not say.
    pub seconds: Option<f64>,
}

impl SoundTrack {
    /// Has ffmpeg begin to read `file`.
    ///
    /// # Errors
    /// A file that is not there, or that holds no sound that this ffmpeg reads; ffmpeg is not there.
    pub fn read(file: &Path) -> Result<Self> {
        Self::read_with(OsStr::new("ffmpeg"), file)
    }

    pub(super) fn read_with(program: &OsStr, file: &Path) -> Result<Self> {
        std::fs::metadata(file).map_err(|error| Error::io(file, "read it", error))?;
        let read = Command::new(program)
            .args(["-hide_banner", "-nostdin", "-nostats", "-t", "1", "-i"])
            .arg(argument(file))
            .args(["-map", "0:a:0", "-f", "null", "-"])
            .stdin(Stdio::null())
            .output()
            .map_err(|error| missing(file, &error))?;

        let said = String::from_utf8_lossy(&read.stderr);
        if !read.status.success() {
            let has_none = said.contains("matches no streams");
            let words = last_words(&said).unwrap_or_else(|| read.status.to_string());
            return Err(Error::invalid(
                file,
                if has_none {
                    "it holds no sound; --audio takes music, speech or a film that has sound".to_owned()
                } else {
                    format!("ffmpeg finds no sound in it: {words}")
                },
            ));
        }
        Ok(Self { file: file.to_owned(), seconds: duration(&said) })
    }

    /// Arguments of ffmpeg that read as much of it as a film of so many seconds takes.
    pub(super) fn input(&self, film_seconds: f64) -> [OsString; 4] {
        ["-t".into(), format!("{film_seconds:.6}").into(), "-i".into(), argument(&self.file)]
    }

    /// Filter that fades it out where a film of so many seconds ends before it does.
    pub(super) fn fade(&self, film_seconds: f64) -> Option<String> {
        let fade = FADE.min(film_seconds / 2.0);
        let is_cut = self.seconds.is_none_or(|seconds| seconds > film_seconds);
        is_cut.then(|| format!("afade=t=out:st={:.6}:d={fade:.6}", film_seconds - fade))
    }

    /// Says that it ends before a film of so many seconds does, if that is so.
    pub(super) fn shortfall(&self, film_seconds: f64) -> Option<String> {
        let seconds = self.seconds.filter(|seconds| seconds + 0.1 < film_seconds)?;
        Some(format!(
            "{} lasts {seconds:.1} s, and the film {film_seconds:.1} s, whose end is without sound",
            self.file.display()
        ))
    }
}

/// A file's name as ffmpeg takes it: a colon in it is no protocol.
pub(super) fn argument(file: &Path) -> OsString {
    let mut argument = OsString::from("file:");
    argument.push(file);
    argument
}

/// Length that ffmpeg tells of a file, seconds: `  Duration: 00:01:02.34, start: …`.
fn duration(said: &str) -> Option<f64> {
    let clock = said.split("Duration: ").nth(1)?.split(',').next()?;
    let parts: Vec<f64> = clock.split(':').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    match parts.as_slice() {
        [hours, minutes, seconds] => Some((hours * 60.0 + minutes) * 60.0 + seconds),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sound_is_cut_with_a_fade_and_is_told_to_be_short() {
        let said = "Input #0, wav, from 'file:a.wav':\n  Duration: 01:02:03.50, bitrate: 1411 kb/s\n";
        assert_eq!(duration(said), Some(3723.5));
        assert_eq!(duration("Duration: N/A, start: 0"), None);

        let track = |seconds| SoundTrack { file: "a b.wav".into(), seconds };
        assert_eq!(track(Some(8.0)).fade(10.0), None);
        assert!(track(Some(8.0)).shortfall(10.0).unwrap().contains("8.0 s"));
        assert_eq!(track(Some(11.0)).fade(10.0).unwrap(), "afade=t=out:st=9.000000:d=1.000000");
        assert_eq!(track(None).fade(1.0).unwrap(), "afade=t=out:st=0.500000:d=0.500000");
        assert_eq!(track(Some(11.0)).shortfall(10.0), None);
        assert_eq!(
            track(None).input(2.5).map(|word| word.into_string().unwrap()),
            ["-t", "2.500000", "-i", "file:a b.wav"]
        );
    }
}
