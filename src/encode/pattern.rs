//! Output names: from `frames/####.png` to the file of frame 42.
//!
//! ```text
//! -                      y4m on standard output
//! flight.y4m             y4m in one file
//! frames/####.png        one run of # in the file name, replaced by the number, zero padded to its length
//! frames/%04d.png        the same, as printf writes it; %d is without padding
//! frames/flight.png      no placeholder: #### goes before the extension (Blender's rule), except for
//!                        a single picture, which keeps the name
//! frames/                a folder: frames/####.png
//! ```
//!
//! Numbers are absolute: frame 42 has the same name whichever subset is rendered. One that is longer
//! than the padding is written in full. Folders are taken literally, `C#/####.png` included.

use std::path::{Path, PathBuf};

use hedgehop_base::error::{Error, Result};

/// Widest padding: more digits than any frame number has, and far below what a file name may hold.
const WIDEST: usize = 32;
/// Padding of a pattern that has no placeholder.
const DEFAULT_WIDTH: usize = 4;

/// Kind of file that is written; the extension decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// 8-bit sRGB, one file per frame.
    Png,
    /// Linear colour and geometry, one file per frame.
    Exr,
    /// Depth alone, one file per frame.
    Npy,
    /// Every frame in one YUV4MPEG2 stream.
    Y4m,
}

impl Target {
    /// The target that the extension of `path` names, in any case of letters.
    pub fn of(path: &Path) -> Result<Self> {
        let extension =
            path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            Some("npy") => Ok(Self::Npy),
            Some("y4m") => Ok(Self::Y4m),
            Some(video @ ("mp4" | "mkv" | "mov" | "m4v" | "webm" | "avi")) => {
                Err(Error::Configuration(format!(
                    "{video} is not a frame format; write --video {}, and -o frames/####.png only if frames are wanted \
                 too",
                    path.display()
                )))
            }
            other => Err(Error::Configuration(format!(
                "{}: {}; -o takes .png, .exr, .npy, .y4m, or - for y4m on standard output",
                path.display(),
                match other {
                    Some(other) => format!("no encoder for .{other}"),
                    None => "no extension to choose the encoder by".to_owned(),
                }
            ))),
        }
    }
}

/// Pattern of the names of frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FramePattern {
    target: Target,
    name: Name,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Name {
    StandardOutput,
    /// One file for all frames.
    File(PathBuf),
    Numbered {
        folder: PathBuf,
        before: String,
        width: usize,
        after: String,
        /// The pattern had no placeholder.
        implied: bool,
    },
}

/// A placeholder in a file name: bytes `start .. end`, digits.
struct Placeholder {
    start: usize,
    end: usize,
    width: usize,
}

impl FramePattern {
    /// Understands what `-o` was given.
    pub fn parse(text: &str) -> Result<Self> {
        if text == "-" {
            return Ok(Self { target: Target::Y4m, name: Name::StandardOutput });
        }
        if text.is_empty() {
            return Err(Error::Configuration("-o is empty; write for instance frames/####.png".to_owned()));
        }

        let cut = text.rfind(std::path::is_separator).map_or(0, |at| at + 1);
        let (folder, file) = text.split_at(cut);
        let file = if file.is_empty() { "####.png" } else { file };
        let target = Target::of(Path::new(file)).map_err(|_| explain(text))?;
        let placeholder = placeholder(text, file)?;
        if target == Target::Y4m {
            return match placeholder {
                None => Ok(Self { target, name: Name::File(PathBuf::from(text)) }),
                Some(_) => Err(Error::Configuration(format!(
                    "{text}: y4m holds all frames in one file; leave the number out of its name"
                ))),
            };
        }

        let implied = placeholder.is_none();
        let dot = file.rfind('.').unwrap_or(file.len());
        let place = placeholder.unwrap_or(Placeholder { start: dot, end: dot, width: DEFAULT_WIDTH });

        let name = Name::Numbered {
            folder: PathBuf::from(folder),
            before: file[..place.start].to_owned(),
            width: place.width,
            after: file[place.end..].to_owned(),
            implied,
        };

        Ok(Self { target, name })
    }

    /// Returns the kind of file that is written there.
    pub fn target(&self) -> Target {
        self.target
    }

    /// Whether the frames go to standard output.
    pub fn is_standard_output(&self) -> bool {
        self.name == Name::StandardOutput
    }

    /// The file of frame `number`; the one file of a y4m stream, `-` for standard output.
    pub fn path(&self, number: u64) -> PathBuf {
        match &self.name {
            Name::StandardOutput => PathBuf::from("-"),
            Name::File(path) => path.clone(),
            Name::Numbered { folder, before, width, after, .. } => {
                folder.join(format!("{before}{number:0width$}{after}"))
            }
        }
    }

    /// The file of a picture that is no part of a sequence: without a number, unless one was asked for.
    pub fn single_path(&self, number: u64) -> PathBuf {
        match &self.name {
            Name::Numbered { folder, before, after, implied: true, .. } => {
                folder.join(format!("{before}{after}"))
            }
            _ => self.path(number),
        }
    }

    /// The folder that the files lie in; `None` for standard output. Empty means the working folder.
    pub fn folder(&self) -> Option<&Path> {
        match &self.name {
            Name::StandardOutput => None,
            Name::File(path) => Some(path.parent().unwrap_or(Path::new(""))),
            Name::Numbered { folder, .. } => Some(folder),
        }
    }
}

/// The sentence for a name whose extension says nothing.
fn explain(text: &str) -> Error {
    Target::of(Path::new(text)).err().unwrap_or_else(|| {
        Error::Configuration(format!("{text}: no file name; write for instance frames/####.png"))
    })
}

/// The one placeholder of `file`, the last component of `text`.
fn placeholder(text: &str, file: &str) -> Result<Option<Placeholder>> {
    let mut found = hash_runs(file);
    found.extend(printf_runs(text, file)?);
    let Some(first) = found.pop() else { return Ok(None) };
    if !found.is_empty() {
        return Err(Error::Configuration(format!(
            "{text}: more than one place for the frame number in the file name; keep one #### or one %04d"
        )));
    }
    if first.width > WIDEST {
        return Err(Error::Configuration(format!(
            "{text}: a frame number of {} digits; keep to {WIDEST} or fewer",
            first.width
        )));
    }
    Ok(Some(first))
}

fn hash_runs(file: &str) -> Vec<Placeholder> {
    let mut runs: Vec<Placeholder> = Vec::new();
    for (at, _) in file.match_indices('#') {
        match runs.last_mut() {
            Some(run) if run.end == at => {
                run.end += 1;
                run.width += 1;
            }
            _ => runs.push(Placeholder { start: at, end: at + 1, width: 1 }),
        }
    }
    runs
}

/// `%d` and `%0Nd`; a `%` with anything else behind is part of the name, but `%4d` is refused, because
/// it would pad with spaces.
fn printf_runs(text: &str, file: &str) -> Result<Vec<Placeholder>> {
    let mut runs = Vec::new();
    for (start, _) in file.match_indices('%') {
        let rest = &file[start + 1..];
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        if rest.as_bytes().get(digits) != Some(&b'd') {
            continue;
        }
        let number = &rest[..digits];
        if digits > 0 && !number.starts_with('0') {
            return Err(Error::Configuration(format!(
                "{text}: %{number}d pads with spaces; write %0{number}d"
            )));
        }
        let width = if digits == 0 { 0 } else { number.parse().unwrap_or(usize::MAX) };
        runs.push(Placeholder { start, end: start + 1 + digits + 1, width });
    }
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(pattern: &str, number: u64) -> String {
        FramePattern::parse(pattern).unwrap().path(number).display().to_string()
    }

    #[test]
    fn names_of_frames() {
        for (pattern, number, expected) in [
            ("frames/####.png", 42, "frames/0042.png"),
            ("frames/##.exr", 7, "frames/07.exr"),
            ("depth/#.npy", 7, "depth/7.npy"),
            ("frames/#.png", 7, "frames/7.png"),
            ("frames/####.png", 123_456, "frames/123456.png"),
            ("####.PNG", u64::MAX, "18446744073709551615.PNG"),
            ("a_%04d_b.png", 42, "a_0042_b.png"),
            ("a%d.png", 42, "a42.png"),
            ("a%00d.png", 42, "a42.png"),
            ("frames/flight.png", 42, "frames/flight0042.png"),
            ("frames/", 42, "frames/0042.png"),
            ("C#/50%d/####.png", 1, "C#/50%d/0001.png"),
            ("100%.png", 3, "100%0003.png"),
            ("Zürich_###.exr", 3, "Zürich_003.exr"),
            ("v1.2/flight.v3.png", 5, "v1.2/flight.v30005.png"),
        ] {
            assert_eq!(path(pattern, number), expected, "{pattern}");
        }
    }

    #[test]
    fn a_single_picture_keeps_its_name() {
        let single = |pattern| FramePattern::parse(pattern).unwrap().single_path(3).display().to_string();
        assert_eq!(single("out/valley.png"), "out/valley.png");
        assert_eq!(single("out/valley_##.png"), "out/valley_03.png");
    }

    #[test]
    fn streams_have_one_name() {
        let standard = FramePattern::parse("-").unwrap();
        assert!(standard.is_standard_output() && standard.folder().is_none());
        assert_eq!(standard.target(), Target::Y4m);
        assert_eq!(path("a/flight.y4m", 1), path("a/flight.y4m", 99));
        assert_eq!(FramePattern::parse("a/flight.y4m").unwrap().folder(), Some(Path::new("a")));
        assert_eq!(FramePattern::parse("flight.png").unwrap().folder(), Some(Path::new("")));
    }

    #[test]
    fn refusals_say_the_remedy() {
        for (pattern, words) in [
            ("frames/####.jpg", "no encoder for .jpg; -o takes .png, .exr, .npy, .y4m"),
            ("frames", "no extension"),
            ("####", "no extension"),
            ("", "frames/####.png"),
            ("out.mp4", "--video"),
            ("##_##.png", "more than one"),
            ("##_%d.png", "more than one"),
            ("%4d.png", "write %04d"),
            ("%0999999999999999999999d.png", "32 or fewer"),
            ("%064d.png", "32 or fewer"),
            ("##.y4m", "leave the number out"),
        ] {
            let message = FramePattern::parse(pattern).unwrap_err().to_string();
            assert!(message.contains(words), "{pattern}: {message}");
        }
    }
}
