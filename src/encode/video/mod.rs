//! `--video out.mp4`: a film of pictures as they come, or of finished frames.
//!
//! ```text
//! .mp4 .m4v .mov .mkv .webm   ask the installed ffmpeg for its encoders, take the first that suits
//!                             start it on a temporary file, raw pictures on its standard input
//! .avi                        Motion JPEG, encoded here
//! for each picture, in order: send it on
//! end, sync, rename to out.mp4
//! ```
//!
//! [`encode_video`] makes a film of frames that are written and whole, so that subsets, reruns and farms end in the
//! same one, and a film that fails costs no frame. [`VideoWriter`] takes pictures straight from rendering; its films
//! are the same, byte by byte. [`check_video`] finds out beforehand whether either can succeed.

mod avi;
mod avi_head;
mod chapters;
mod encoders;
mod failure;
mod ffmpeg;
mod footage;
mod settings;
mod sound;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

pub use chapters::{Chapter, read_chapters};
pub use footage::Footage;
pub use settings::{VideoQuality, VideoSettings};
pub use sound::SoundTrack;

use crate::encode::read_picture;
use crate::frame::Picture;
use avi::AviWriter;
use encoders::{Container, Encoders};
use ffmpeg::FfmpegPipe;
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Checks that a film can be made: the container is known and holds what it is to hold, and an ffmpeg that it needs is
/// installed and has the encoders.
pub fn check_video(settings: &VideoSettings) -> Result<()> {
    check_with(OsStr::new("ffmpeg"), settings)
}

fn check_with(program: &OsStr, settings: &VideoSettings) -> Result<()> {
    match Container::of(&settings.out)? {
        Container::Avi => avi::check(settings),
        _ => encoders::choose(program, settings).map(drop),
    }
}

/// Film that takes pictures in order. Dropped before it is finished, it leaves what was there.
pub struct VideoWriter {
    out: PathBuf,
    size: Size,
    encoder: Running,
}

/// Encoder at work.
enum Running {
    Ffmpeg(FfmpegPipe),
    /// ffmpeg has given up, and said why.
    Ended,
    MotionJpeg(Box<AviWriter>),
}

impl std::fmt::Debug for VideoWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "VideoWriter({}×{})", self.size.width, self.size.height)
    }
}

impl VideoWriter {
    /// Begins a film; notes on what it cannot have go to `observer`.
    ///
    /// # Errors
    /// As [`check_video`]; a file that cannot be written.
    pub fn start(settings: &VideoSettings, footage: Footage, observer: &dyn Observer) -> Result<Self> {
        Self::start_with(OsStr::new("ffmpeg"), settings, footage, observer)
    }

    fn start_with(
        program: &OsStr,
        settings: &VideoSettings,
        footage: Footage,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let encoder = if Container::of(&settings.out)? == Container::Avi {
            Running::MotionJpeg(Box::new(AviWriter::start(settings, footage)?))
        } else {
            let encoders = encoders::choose(program, settings)?;
            note_choices(&encoders, settings, footage, observer);
            Running::Ffmpeg(FfmpegPipe::start(program, &encoders, settings, footage)?)
        };
        Ok(Self { out: settings.out.clone(), size: footage.size, encoder })
    }

    /// Appends a picture, which errors call `name`.
    ///
    /// # Errors
    /// A picture of another size; in ffmpeg's words, if it gave up.
    pub fn push(&mut self, picture: &Picture, name: &Path) -> Result<()> {
        let Size { width, height } = self.size;
        if (picture.width, picture.height) != (width, height) {
            let what = format!(
                "{}×{} pixels, but the video began with {width}×{height}; render all frames with one --size",
                picture.width, picture.height
            );
            return Err(Error::invalid(name, what));
        }

        let sent = match &mut self.encoder {
            Running::Ffmpeg(pipe) => pipe.push(&picture.rgb),
            Running::MotionJpeg(film) => film.push(&picture.rgb),
            Running::Ended => Err(unfinished(&self.out)),
        };
        sent.map_err(|error| match std::mem::replace(&mut self.encoder, Running::Ended) {
            // The pipe broke because ffmpeg gave up, and says why.
            Running::Ffmpeg(pipe) => pipe.finish().err().unwrap_or(error),
            _ => error,
        })
    }

    /// Waits until all is encoded, and gives the film its name.
    pub fn finish(self) -> Result<()> {
        match self.encoder {
            Running::Ffmpeg(pipe) => pipe.finish(),
            Running::MotionJpeg(film) => film.finish(),
            Running::Ended => Err(unfinished(&self.out)),
        }
    }
}

/// Encodes finished frames (PNG or EXR, all of one size), in the order given, into a film.
/// Stages and notes go to `observer`; when it cancels, what was there stays.
pub fn encode_video(
    frames: impl ExactSizeIterator<Item = PathBuf>,
    settings: &VideoSettings,
    observer: &dyn Observer,
) -> Result<()> {
    encode_with(OsStr::new("ffmpeg"), frames, settings, observer)
}

fn encode_with(
    program: &OsStr,
    frames: impl ExactSizeIterator<Item = PathBuf>,
    settings: &VideoSettings,
    observer: &dyn Observer,
) -> Result<()> {
    let out = settings.out.as_path();
    let frame_count = frames.len() as u64;
    let mut frames = frames.peekable();
    let Some(first) = frames.peek() else {
        return Err(Error::Configuration(format!("{}: no frames for the video", out.display())));
    };

    let picture = read_picture(first)?;
    let size = Size { width: picture.width, height: picture.height };
    let mut writer = VideoWriter::start_with(program, settings, Footage { size, frame_count }, observer)?;
    observer.begin("video", frame_count, "frames");

    for path in frames {
        if observer.cancelled() {
            return Err(interrupted(out));
        }
        if let Err(error) = writer.push(&read_picture(&path)?, &path) {
            // An interrupt from the terminal reaches ffmpeg too, and closes the pipe.
            return Err(if observer.cancelled() { interrupted(out) } else { repeatable(error) });
        }
        observer.advance(1);
    }

    writer.finish().map_err(repeatable)?;
    observer.end();
    Ok(())
}

/// The sentence for a film whose encoder has failed before, and said why.
fn unfinished(out: &Path) -> Error {
    Error::invalid(out, "its encoder has given up, and it was not written")
}

fn interrupted(out: &Path) -> Error {
    Error::Interrupted(format!("{} was not written, the frames are whole", out.display()))
}

/// Adds to ffmpeg's words that no frame is lost.
fn repeatable(error: Error) -> Error {
    match error {
        Error::Invalid { path, what } if what.starts_with("ffmpeg") => {
            Error::invalid(path, format!("{what}; the frames are whole, repeat with --skip-existing"))
        }
        other => other,
    }
}

fn note_choices(encoders: &Encoders, settings: &VideoSettings, footage: Footage, observer: &dyn Observer) {
    let out = settings.out.display();
    if encoders.video.name == "mpeg4" {
        observer.note(&format!(
            "{out}: this ffmpeg has no H.264 encoder, so it is MPEG-4 part 2; some browsers do not play that"
        ));
    }

    let Size { width, height } = footage.size;
    if width % 2 == 1 || height % 2 == 1 {
        observer.note(&format!(
            "{out}: the video is {}×{}, because 4:2:0 needs even sizes; the odd column or row is cut",
            width & !1,
            height & !1
        ));
    }

    let seconds = settings.seconds(footage.frame_count);
    if let Some(note) = settings.sound.as_ref().and_then(|sound| sound.shortfall(seconds)) {
        observer.note(&note);
    }
}

#[cfg(test)]
mod tests;
