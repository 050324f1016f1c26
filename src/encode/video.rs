//! `--video out.mp4`: an installed ffmpeg encodes the finished frames.
//!
//! ```text
//! ask ffmpeg for its encoders, take the first that suits the container
//! start it on .out.mp4.XXXXXX.part.mp4, raw rgb24 on its standard input
//! for each frame in order: read the file, write its pixels to the pipe
//! close the pipe, wait, sync, rename to out.mp4
//! ```
//!
//! Encoding comes once, after the frames, so that subsets, reruns and farms end in the same video, and a
//! video that fails costs no frame. [`check_video`] finds out beforehand whether it can succeed.
//!
//! Frames are converted to Y′CbCr of BT.709 at 4:2:0, limited range, and tagged so; the transfer tag is
//! sRGB, which is what the frames are coded in. 4:2:0 needs even sizes: an odd last column or row is cut.

use std::ffi::{OsStr, OsString};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;

use crate::encode::{atomic, read_picture};
use crate::flight::FrameRate;
use crate::frame::Picture;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Most bytes of ffmpeg's complaints that are kept.
const COMPLAINT_BYTES: usize = 1 << 16;

/// An encoder and how it is asked for a quality at which frames cannot be told from the originals at a glance.
struct Encoder {
    name: &'static str,
    options: &'static [&'static str],
}

const H264: &[Encoder] = &[
    Encoder { name: "libx264", options: &["-preset", "medium", "-crf", "18"] },
    Encoder { name: "libopenh264", options: &["-b:v", "16M"] },
    Encoder { name: "h264_videotoolbox", options: &["-b:v", "16M"] },
    Encoder { name: "mpeg4", options: &["-q:v", "3"] },
];
const WEBM: &[Encoder] = &[
    Encoder { name: "libvpx-vp9", options: &["-crf", "24", "-b:v", "0", "-row-mt", "1"] },
    Encoder { name: "libvpx", options: &["-crf", "8", "-b:v", "16M"] },
];

/// Encodes finished frames (PNG or EXR, all of one size), in the order given, into the video `out`.
/// Stages and notes go to `observer`; when it cancels, `out` is left as it was.
pub fn encode_video(
    frames: impl Iterator<Item = PathBuf>,
    rate: FrameRate,
    out: &Path,
    observer: &dyn Observer,
) -> Result<()> {
    encode_with(OsStr::new("ffmpeg"), frames, rate, out, observer)
}

/// Whether [`encode_video`] can write `out`: the container is known, ffmpeg is installed and has an encoder.
pub fn check_video(out: &Path) -> Result<()> {
    choose_encoder(OsStr::new("ffmpeg"), out).map(drop)
}

fn encode_with(
    program: &OsStr,
    frames: impl Iterator<Item = PathBuf>,
    rate: FrameRate,
    out: &Path,
    observer: &dyn Observer,
) -> Result<()> {
    let encoder = choose_encoder(program, out)?;
    let mut frames = frames.peekable();
    let total = frames.size_hint().1.unwrap_or(0) as u64;
    let Some(first) = frames.peek() else {
        return Err(Error::Configuration(format!("{}: no frames for the video", out.display())));
    };

    let picture = read_picture(first)?;
    note_choices(encoder, &picture, out, observer);
    let size = Size { width: picture.width, height: picture.height };
    let mut pipe = Pipe::start(program, encoder, size, rate, out)?;
    observer.begin("video", total, "frames");

    for path in frames {
        if observer.cancelled() {
            return Err(interrupted(out));
        }
        if let Err(error) = pipe.push(&path, read_picture(&path)?) {
            // An interrupt from the terminal reaches ffmpeg too, and closes the pipe.
            return Err(if observer.cancelled() { interrupted(out) } else { pipe.explain(error) });
        }
        observer.advance(1);
    }

    pipe.finish()?;
    observer.end();
    Ok(())
}

fn interrupted(out: &Path) -> Error {
    Error::Interrupted(format!("{} was not written, the frames are whole", out.display()))
}

fn note_choices(encoder: &Encoder, picture: &Picture, out: &Path, observer: &dyn Observer) {
    if encoder.name == "mpeg4" {
        observer.note(&format!(
            "{}: this ffmpeg has no H.264 encoder, so it is MPEG-4 part 2; some browsers do not play that",
            out.display()
        ));
    }
    if picture.width % 2 == 1 || picture.height % 2 == 1 {
        observer.note(&format!(
            "{}: the video is {}×{}, because 4:2:0 needs even sizes; the odd column or row is cut",
            out.display(),
            picture.width & !1,
            picture.height & !1
        ));
    }
}

/// The first suitable encoder that this ffmpeg has.
fn choose_encoder(program: &OsStr, out: &Path) -> Result<&'static Encoder> {
    let extension = out.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
    let suitable = match extension.as_deref() {
        Some("mp4" | "m4v" | "mov" | "mkv") => H264,
        Some("webm") => WEBM,
        _ => {
            return Err(Error::Configuration(format!(
                "--video {}: not a known container; write .mp4, .mkv, .mov, .m4v or .webm",
                out.display()
            )));
        }
    };

    let listing = Command::new(program)
        .args(["-hide_banner", "-loglevel", "error", "-encoders"])
        .stdin(Stdio::null())
        .output()
        .map_err(|error| missing(out, &error))?;
    let listing = String::from_utf8_lossy(&listing.stdout);
    let has = |name: &str| listing.lines().any(|line| line.split_whitespace().nth(1) == Some(name));

    suitable.iter().find(|encoder| has(encoder.name)).ok_or_else(|| {
        let names: Vec<_> = suitable.iter().map(|encoder| encoder.name).collect();
        Error::unsupported(
            out,
            format!("the installed ffmpeg has none of the encoders {}", names.join(", ")),
            "install a full ffmpeg (Debian, Ubuntu: apt-get install ffmpeg), or write y4m with `-o -`",
        )
    })
}

fn missing(out: &Path, error: &std::io::Error) -> Error {
    Error::unsupported(
        out,
        format!("a video needs the program ffmpeg, which cannot be started ({error})"),
        "install it (Debian, Ubuntu: apt-get install ffmpeg), or write y4m with `-o -` and encode that elsewhere",
    )
}

/// A running ffmpeg. Dropped before it is finished, it is ended, and its temporary file removed.
struct Pipe {
    child: ProcessEnd,
    pixels: ChildStdin,
    complaints: JoinHandle<String>,
    temporary: tempfile::NamedTempFile,
    out: PathBuf,
    size: Size,
}

/// Ends the process when dropped; one that has ended already is left alone.
struct ProcessEnd(Child);

impl Drop for ProcessEnd {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Pipe {
    fn start(program: &OsStr, encoder: &Encoder, size: Size, rate: FrameRate, out: &Path) -> Result<Self> {
        let Size { width, height } = size;
        if width < 2 || height < 2 {
            let what = format!("a video of {width}×{height} pixels");
            return Err(Error::unsupported(out, what, "render frames of at least 2×2 (--size)"));
        }

        let temporary = atomic::temporary_for(out)?;
        let mut command = Command::new(program);
        command.args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
        command.args(["-s", &format!("{width}x{height}")]);
        command.args(["-r", &format!("{}/{}", rate.numerator(), rate.denominator()), "-i", "-", "-an"]);
        command.args(["-vf", FILTER, "-c:v", encoder.name]).args(encoder.options).args(TAGS);

        // `file:` keeps a colon in the name from being taken for a protocol.
        let mut target = OsString::from("file:");
        target.push(temporary.path());
        command.arg(target).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = ProcessEnd(command.spawn().map_err(|error| missing(out, &error))?);
        let (Some(pixels), Some(errors)) = (child.0.stdin.take(), child.0.stderr.take()) else {
            return Err(Error::unsupported(out, "ffmpeg has no pipes", "write y4m with `-o -`"));
        };

        let complaints = std::thread::Builder::new()
            .name("ffmpeg-complaints".to_owned())
            .spawn(move || read_complaints(errors))
            .map_err(|error| Error::io(out, "start a thread for ffmpeg's messages", error))?;

        Ok(Self { child, pixels, complaints, temporary, out: out.to_owned(), size })
    }

    fn push(&mut self, path: &Path, picture: Picture) -> Result<()> {
        let Size { width, height } = self.size;
        if (picture.width, picture.height) != (width, height) {
            let what = format!(
                "{}×{} pixels, but the video began with {width}×{height}; render all frames with one --size",
                picture.width, picture.height
            );
            return Err(Error::invalid(path, what));
        }
        self.pixels
            .write_all(&picture.rgb)
            .map_err(|source| Error::io(&self.out, "send frames to ffmpeg for it", source))
    }

    /// ffmpeg's own words, if the pipe broke because ffmpeg gave up; else `error` as it is.
    fn explain(self, error: Error) -> Error {
        if !matches!(error, Error::Io { .. }) {
            return error;
        }
        self.finish().err().unwrap_or(error)
    }

    fn finish(self) -> Result<()> {
        let Self { mut child, pixels, complaints, temporary, out, .. } = self;
        drop(pixels);
        let complaints = complaints.join().unwrap_or_default();
        let status = child.0.wait().map_err(|source| Error::io(&out, "wait for ffmpeg", source))?;
        if !status.success() {
            return Err(failed(&out, status, &complaints));
        }
        // ffmpeg has written through its own handle; this one sees the same file.
        temporary.as_file().sync_all().map_err(|source| atomic::write_error(&out, source))?;
        atomic::persist(temporary, &out)
    }
}

/// Even size, and BT.709 instead of ffmpeg's default of BT.601, and tagged so.
const FILTER: &str = "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,\
     scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,format=yuv420p,\
     setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";
/// Frames carry the same tags as the flags: encoders of ffmpeg 7 and later take primaries and transfer from frames alone, those before from flags alone.
const TAGS: [&str; 10] = [
    "-color_range",
    "tv",
    "-colorspace",
    "bt709",
    "-color_primaries",
    "bt709",
    "-color_trc",
    "iec61966-2-1",
    "-movflags",
    "+faststart",
];

fn failed(out: &Path, status: ExitStatus, complaints: &str) -> Error {
    let last = complaints.lines().rev().map(str::trim).find(|line| !line.is_empty());
    let words = last.map_or_else(|| status.to_string(), str::to_owned);
    Error::invalid(
        out,
        format!("ffmpeg could not encode it: {words}; the frames are whole, repeat with --skip-existing"),
    )
}

/// All that ffmpeg complains of, so that it never waits for a reader; the first part is kept.
fn read_complaints(mut errors: ChildStderr) -> String {
    let mut kept = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(length @ 1..) = errors.read(&mut buffer) {
        let room = COMPLAINT_BYTES.saturating_sub(kept.len());
        kept.extend_from_slice(&buffer[..length.min(room)]);
    }
    String::from_utf8_lossy(&kept).into_owned()
}

#[cfg(test)]
#[path = "video_tests.rs"]
mod tests;
