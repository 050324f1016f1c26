//! Frames straight into a film, without files between.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use crate::output::unfinished;
use crate::progress::Reporter;
use crate::sequence::{Fineness, Image, Sequence, Shot};
use hedgehop::colour::srgb8_picture;
use hedgehop::encode::video::{Footage, VideoSettings, VideoWriter};
use hedgehop::frame::Picture;
use hedgehop::progress::Observer;
use hedgehop::render::NumberedCamera;
use hedgehop::{Error, Result, Size};

/// Renders frames into a film that appears when it is whole. Returns how many were rendered, and how finely.
pub fn fly_film(
    settings: &VideoSettings,
    size: Size,
    sequence: &Sequence<'_>,
    cameras: &[NumberedCamera],
    reporter: &Reporter,
) -> Result<(usize, Fineness)> {
    let out = settings.out.as_path();
    let footage = Footage { size, frame_count: cameras.len() as u64 };
    let writer = Mutex::new(VideoWriter::start(settings, footage, reporter)?);

    // An interrupt from the terminal reaches ffmpeg too, and closes the pipe.
    let told = |error| if reporter.cancelled() { Error::Interrupted(String::new()) } else { error };
    let write = |shot: &Shot| {
        let mut writer = writer.lock().unwrap_or_else(PoisonError::into_inner);
        push(&mut writer, shot, out).map_err(told)
    };
    // Its order matters: one thread hands the frames over.
    let flown = Sequence { encoders: 1, ..*sequence }.fly(cameras, &write, reporter);
    let summed = flown.summed();
    flown.end.map_err(|error| unfinished(out, error))?;

    let writer = writer.into_inner().unwrap_or_else(PoisonError::into_inner);
    writer.finish().map_err(|error| unfinished(out, told(error)))?;
    Ok(summed)
}

fn push(writer: &mut VideoWriter, shot: &Shot, out: &Path) -> Result<()> {
    match &shot.image {
        Image::Picture(picture, _) => writer.push(picture, out),
        Image::Frame(frame) => {
            let rgb = srgb8_picture(&frame.colour);
            writer.push(&Picture { width: frame.camera.width, height: frame.camera.height, rgb }, out)
        }
    }
}
