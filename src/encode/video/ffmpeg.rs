//! Pipe of raw pictures into an installed ffmpeg.
//!
//! ```text
//! start it on a temporary file beside out.mp4: raw rgb24 on its standard input, sound and chapters from files
//! write pictures to the pipe, in order
//! close the pipe, wait, sync, rename to out.mp4
//! ```
//!
//! Frames are converted to Y′CbCr of BT.709, limited range, and tagged so; the transfer tag is sRGB, which is what the
//! frames are coded in. 4:2:0 needs even sizes: an odd last column or row is cut.

use std::ffi::OsStr;
use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStderr, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use super::chapters::ffmetadata;
use super::encoders::Encoders;
use super::failure::{last_words, missing};
use super::footage::Footage;
use super::settings::VideoSettings;
use super::sound::argument;
use crate::encode::atomic;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Words of the system, which ffmpeg passes on, for a disk that is full.
const FULL: &str = "No space left on device";

/// Most bytes of ffmpeg's complaints that are kept.
const COMPLAINT_BYTES: usize = 1 << 16;

/// Even size, and BT.709 instead of ffmpeg's default of BT.601.
const CONVERT: &str = "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,\
     scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int";
/// Tags of each frame: encoders of ffmpeg 7 and later take primaries and transfer from frames alone, those before from flags alone.
const TAG: &str = "setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";
/// Flags with the same tags, and the table of contents at the beginning of MP4 and QuickTime, so that a film on the web plays at once.
pub(super) const TAGS: [&str; 10] = [
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

/// A running ffmpeg. Dropped before it is finished, it is ended, and its temporary file removed.
pub(super) struct FfmpegPipe {
    child: ProcessEnd,
    pixels: ChildStdin,
    complaints: JoinHandle<String>,
    temporary: tempfile::NamedTempFile,
    /// Chapters, which it reads from a file.
    _chapters: Option<tempfile::NamedTempFile>,
    out: PathBuf,
}

/// Ends the process when dropped; one that has ended already is left alone.
struct ProcessEnd(Child);

impl Drop for ProcessEnd {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl FfmpegPipe {
    /// Starts `program` on a film of pictures such as `footage`.
    pub(super) fn start(
        program: &OsStr,
        encoders: &Encoders,
        settings: &VideoSettings,
        footage: Footage,
    ) -> Result<Self> {
        let VideoSettings { out, .. } = settings;
        let Size { width, height } = footage.size;
        if width < 2 || height < 2 {
            let what = format!("a video of {width}×{height} pixels");
            return Err(Error::unsupported(out, what, "render frames of at least 2×2 (--size)"));
        }

        let temporary = atomic::temporary_for(out)?;
        let chapters = chapters_file(settings, footage)?;
        let mut command = Command::new(program);
        command.args(["-hide_banner", "-loglevel", "error", "-y"]);
        add_inputs(&mut command, settings, footage, chapters.as_ref());
        add_streams(&mut command, encoders, settings, footage);

        command.arg(argument(temporary.path()));
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = ProcessEnd(command.spawn().map_err(|error| missing(out, &error))?);
        let (Some(pixels), Some(errors)) = (child.0.stdin.take(), child.0.stderr.take()) else {
            return Err(Error::unsupported(out, "ffmpeg has no pipes", "write y4m with `-o -`"));
        };

        let complaints = std::thread::Builder::new()
            .name("ffmpeg-complaints".to_owned())
            .spawn(move || read_complaints(errors))
            .map_err(|error| Error::io(out, "start a thread for ffmpeg's messages", error))?;

        Ok(Self { child, pixels, complaints, temporary, _chapters: chapters, out: out.clone() })
    }

    /// Sends a picture, `r g b r g b …`.
    pub(super) fn push(&mut self, rgb: &[u8]) -> Result<()> {
        self.pixels
            .write_all(rgb)
            .map_err(|source| Error::io(&self.out, "send frames to ffmpeg for it", source))
    }

    /// Waits until all is encoded, and gives the film its name.
    ///
    /// # Errors
    /// In ffmpeg's own words, if it gave up.
    pub(super) fn finish(self) -> Result<()> {
        let Self { mut child, pixels, complaints, temporary, out, .. } = self;
        drop(pixels);
        let complaints = complaints.join().unwrap_or_default();
        let status = child.0.wait().map_err(|source| Error::io(&out, "wait for ffmpeg", source))?;
        if !status.success() {
            let words = last_words(&complaints).unwrap_or_else(|| status.to_string());
            if complaints.contains(FULL) {
                return Err(atomic::write_error(&out, io::Error::new(io::ErrorKind::StorageFull, FULL)));
            }
            return Err(Error::invalid(&out, format!("ffmpeg could not encode it: {words}")));
        }
        // ffmpeg has written through its own handle; this one sees the same file.
        temporary.as_file().sync_all().map_err(|source| atomic::write_error(&out, source))?;
        atomic::persist(temporary, &out)
    }
}

/// Writes chapters, if there are some, where ffmpeg can read them.
fn chapters_file(settings: &VideoSettings, footage: Footage) -> Result<Option<tempfile::NamedTempFile>> {
    if settings.chapters.is_empty() {
        return Ok(None);
    }
    let text = ffmetadata(&settings.chapters, settings.seconds(footage.frame_count));
    let written = tempfile::NamedTempFile::new().and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        Ok(file)
    });
    written
        .map(Some)
        .map_err(|error| Error::io(&settings.out, "write its chapters to a temporary file", error))
}

/// Names the inputs: pictures from standard input; then sound and chapters, if there are some.
fn add_inputs(
    command: &mut Command,
    settings: &VideoSettings,
    footage: Footage,
    chapters: Option<&tempfile::NamedTempFile>,
) {
    let (Size { width, height }, rate) = (footage.size, settings.rate);
    command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", &format!("{width}x{height}")]);
    command.args(["-r", &format!("{}/{}", rate.numerator(), rate.denominator()), "-i", "-"]);
    if let Some(sound) = &settings.sound {
        command.args(sound.input(settings.seconds(footage.frame_count)));
    }
    if let Some(chapters) = chapters {
        command.args(["-f", "ffmetadata", "-i"]).arg(argument(chapters.path()));
    }
}

/// Asks for streams, filters and encoders of the film.
fn add_streams(command: &mut Command, encoders: &Encoders, settings: &VideoSettings, footage: Footage) {
    // Titles and chapters of the sound's own file are of something else.
    let is_plain = settings.sound.is_none() && settings.chapters.is_empty();
    if !is_plain {
        command.args(["-map", "0:v:0", "-map_metadata:g", "-1", "-map_chapters"]);
        let inputs = 1 + usize::from(settings.sound.is_some());
        command.arg(if settings.chapters.is_empty() { "-1".to_owned() } else { inputs.to_string() });
    }

    match (&settings.sound, encoders.sound) {
        (Some(sound), Some(encoder)) => {
            command.args(["-map", "1:a:0", "-c:a", encoder.name]).args(encoder.options);
            if let Some(fade) = sound.fade(settings.seconds(footage.frame_count)) {
                command.args(["-af", &fade]);
            }
        }
        _ => {
            command.arg("-an");
        }
    }

    command.args(["-vf", &format!("{CONVERT},format={},{TAG}", encoders.pixels)]);
    command.args(["-c:v", encoders.video.name]).args(encoders.video.options).args(TAGS);
}

/// Reads all that ffmpeg complains of, so that it never waits for a reader, and keeps the first part.
fn read_complaints(mut errors: ChildStderr) -> String {
    let mut kept = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(length @ 1..) = errors.read(&mut buffer) {
        let room = COMPLAINT_BYTES.saturating_sub(kept.len());
        kept.extend_from_slice(&buffer[..length.min(room)]);
    }
    String::from_utf8_lossy(&kept).into_owned()
}
