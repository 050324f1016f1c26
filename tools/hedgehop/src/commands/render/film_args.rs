//! Flags of films: where to, for which use, with what sound and chapters.

use std::path::PathBuf;

use hedgehop::encode::video::{SoundTrack, VideoQuality, VideoSettings, read_chapters};
use hedgehop::flight::FrameRate;
use hedgehop::{Error, Result, Size};

use crate::screen::{ScreenArgs, ScreenKind};

/// Frames a second where a preset says so; others have those of `--fps`.
pub const PRESET_RATES: [(&str, &str, Option<&str>); 2] =
    [("preset", "preview", Some("15")), ("preset", "4k60", Some("60"))];

/// Flags of the film.
#[derive(Debug, Default, clap::Args)]
#[command(next_help_heading = "Film")]
pub struct FilmArgs {
    /// Film to make: .mp4, .mov, .mkv, .m4v or .webm through an installed ffmpeg, or .avi without one; of the frames that -o writes, once all are there,
    /// or, without -o, of pictures as they come
    #[arg(long, value_name = "FILM.mp4")]
    pub video: Option<PathBuf>,

    /// Size, rate and encoding of the film at once; --size and --fps go before it
    #[arg(long = "film", value_enum, value_name = "PRESET", requires = "video")]
    pub preset: Option<FilmPreset>,

    /// Sound of the film: any file that ffmpeg reads; what lasts longer than the film is faded out at its end
    #[arg(long, value_name = "SOUND", requires = "video")]
    pub audio: Option<PathBuf>,

    /// Chapters of the film: a text file of lines such as 1:30 Over the lake, by the film's own time, or ffmpeg's metadata
    #[arg(long, value_name = "CHAPTERS.txt", requires = "video")]
    pub chapters: Option<PathBuf>,
}

/// Uses that films are made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FilmPreset {
    /// 640x360 at 15 frames a second, soon encoded
    Preview,
    /// 1920x1080 at 30
    #[value(name = "1080p")]
    FullHd,
    /// 3840x2160 at 60
    #[value(name = "4k60")]
    UltraHd,
    /// 1920x1080 at 30 in ProRes 422 HQ, 10 bits, for editing: a .mov
    #[value(name = "prores")]
    ProRes,
}

impl FilmPreset {
    fn size(self) -> Size {
        match self {
            Self::Preview => Size { width: 640, height: 360 },
            Self::FullHd | Self::ProRes => Size { width: 1920, height: 1080 },
            Self::UltraHd => Size { width: 3840, height: 2160 },
        }
    }

    fn quality(self) -> VideoQuality {
        match self {
            Self::Preview => VideoQuality::Draft,
            Self::FullHd | Self::UltraHd => VideoQuality::Final,
            Self::ProRes => VideoQuality::Mezzanine,
        }
    }
}

impl FilmArgs {
    /// Returns the screen with the preset's size, unless it has one.
    ///
    /// # Errors
    /// A screen that no picture of 16 by 9 is of.
    pub fn sized(&self, screen: &ScreenArgs) -> Result<ScreenArgs> {
        let Some(preset) = self.preset.filter(|_| screen.size.is_none()) else { return Ok(screen.clone()) };
        match screen.screen {
            ScreenKind::Planar | ScreenKind::Cylindrical | ScreenKind::Orthographic => {
                Ok(ScreenArgs { size: Some(preset.size()), ..screen.clone() })
            }
            ScreenKind::Equirectangular | ScreenKind::Fisheye | ScreenKind::Table(_) => {
                Err(Error::Configuration(
                    "pictures of --film are 16 by 9, as this --screen's are not; say its --size as well"
                        .into(),
                ))
            }
        }
    }

    /// Returns what film is to be made, if one is; looks into its sound and chapters.
    ///
    /// # Errors
    /// Files that hold no sound, or no chapters.
    pub fn settings(&self, rate: FrameRate) -> Result<Option<VideoSettings>> {
        let Some(out) = &self.video else { return Ok(None) };
        Ok(Some(VideoSettings {
            quality: self.preset.map(FilmPreset::quality).unwrap_or_default(),
            sound: self.audio.as_deref().map(SoundTrack::read).transpose()?,
            chapters: self.chapters.as_deref().map(read_chapters).transpose()?.unwrap_or_default(),
            ..VideoSettings::new(out.clone(), rate)
        }))
    }
}
