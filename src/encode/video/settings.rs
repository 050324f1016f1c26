//! Settings of a film: where to, how fast, how good, with what sound and chapters.

use std::path::PathBuf;

use super::chapters::Chapter;
use super::sound::SoundTrack;
use crate::flight::FrameRate;
use hedgehop_base::error::{Error, Result};

/// Use that a film is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VideoQuality {
    /// A quick look: soon encoded, small.
    Draft,
    /// Watching: frames cannot be told from the originals at a glance.
    #[default]
    Final,
    /// Editing: ProRes 422 HQ, 10 bits, each frame by itself.
    Mezzanine,
}

/// Film that is to be made.
#[derive(Debug, Clone)]
pub struct VideoSettings {
    /// File to write; its extension chooses the container.
    pub out: PathBuf,
    /// Frames per second.
    pub rate: FrameRate,
    /// Use that it is for.
    pub quality: VideoQuality,
    /// Sound under the pictures.
    pub sound: Option<SoundTrack>,
    /// Chapters, rising by their beginning.
    pub chapters: Vec<Chapter>,
}

impl VideoSettings {
    /// A film to watch, without sound and chapters.
    pub fn new(out: PathBuf, rate: FrameRate) -> Self {
        Self { out, rate, quality: VideoQuality::default(), sound: None, chapters: Vec::new() }
    }

    /// Length of a film of so many frames, seconds.
    pub fn seconds(&self, frame_count: u64) -> f64 {
        self.rate.seconds_at(frame_count + 1)
    }

    /// Refuses chapters that begin after a film of so many frames has ended.
    pub fn check_length(&self, frame_count: u64) -> Result<()> {
        let seconds = self.seconds(frame_count);
        match self.chapters.iter().find(|chapter| chapter.begin >= seconds) {
            Some(Chapter { begin, title }) => Err(Error::Configuration(format!(
                "chapter `{title}` begins at {begin} s, and {} has ended at {seconds:.3} s; chapters count from the film's own beginning",
                self.out.display()
            ))),
            None => Ok(()),
        }
    }
}
