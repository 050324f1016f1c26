//! Canvas that a frame is composed on: all channels in linear light, or 8-bit codes.

use std::borrow::Cow;

use crate::frame::{Frame, Matte, Picture};
use crate::objects::SQUARE;
use crate::pixels::Pixels;

/// Bytes of an 8-bit pixel.
const RGB: usize = 3;

/// Image of a view while overlays are drawn over its ground.
#[expect(clippy::large_enum_variant, reason = "a frame has one")]
pub(super) enum Canvas {
    /// All channels; light is linear.
    Frame(Frame),
    /// Codes alone, and the range of each pixel, metres, `[height][width]`.
    Picture {
        /// The codes.
        picture: Picture,
        /// Ranges of what is seen; empty where nobody asks for them.
        range: Vec<f32>,
        /// Whether passes after the bodies ask for ranges: then bodies change them.
        is_ranged: bool,
    },
}

/// [`SQUARE`] rows of a canvas, as bodies are drawn on them.
pub(super) struct BodyRows<'c> {
    pub pixels: Pixels<'c>,
    /// Ranges, metres; empty where nobody asks for them.
    pub range: &'c mut [f32],
    /// Channels of the surface; `None` on pictures.
    pub surface: Option<SurfaceRows<'c>>,
}

/// Channels of the surface in some rows.
pub(super) struct SurfaceRows<'c> {
    pub normal: &'c mut [[f32; 3]],
    pub level: &'c mut [u8],
    pub id: &'c mut [u32],
}

impl Canvas {
    /// Returns the width, pixels.
    pub fn width(&self) -> usize {
        match self {
            Self::Frame(frame) => frame.camera.width as usize,
            Self::Picture { picture, .. } => picture.width as usize,
        }
    }

    /// Splits into light, `rows` rows at a time, and the range of what is seen, metres, `[height][width]`.
    pub fn light_and_range(&mut self, rows: usize) -> (Vec<Pixels<'_>>, &[f32]) {
        let pixels = rows * self.width();
        match self {
            Self::Frame(Frame { colour, range, .. }) => {
                (colour.chunks_mut(pixels).map(Pixels::Linear).collect(), range)
            }
            Self::Picture { picture, range, .. } => {
                (picture.rgb.chunks_mut(RGB * pixels).map(Pixels::Srgb8).collect(), range)
            }
        }
    }

    /// Splits into rows for bodies, and the range of the ground, metres, `[height][width]`: a copy where bodies change it, since pixels look at
    /// their neighbours' ground, which other tasks may have covered.
    pub fn body_rows(&mut self) -> (Vec<BodyRows<'_>>, Cow<'_, [f32]>) {
        let pixels = SQUARE * self.width();
        match self {
            Self::Frame(Frame { colour, range, normal, level, id, .. }) => {
                let ground = Cow::Owned(range.clone());
                let light = colour.chunks_mut(pixels).map(Pixels::Linear);
                let surfaces = normal
                    .chunks_mut(pixels)
                    .zip(level.chunks_mut(pixels).zip(id.chunks_mut(pixels)))
                    .map(|(normal, (level, id))| Some(SurfaceRows { normal, level, id }));
                let rows = light.zip(range.chunks_mut(pixels)).zip(surfaces);
                let rows = rows.map(|((pixels, range), surface)| BodyRows { pixels, range, surface });
                (rows.collect(), ground)
            }
            Self::Picture { picture, range, is_ranged } => {
                let light = picture.rgb.chunks_mut(RGB * pixels).map(Pixels::Srgb8);
                let bare = |(pixels, range)| BodyRows { pixels, range, surface: None };
                if *is_ranged {
                    let ground = Cow::Owned(range.clone());
                    (light.zip(range.chunks_mut(pixels)).map(bare).collect(), ground)
                } else {
                    let none = std::iter::repeat_with(Default::default);
                    (light.zip(none).map(bare).collect(), Cow::Borrowed(range))
                }
            }
        }
    }

    /// Returns the ranges of a frame, metres, `[height][width]`; `None`: it is a picture.
    pub fn frame_ranges(&self) -> Option<&[f32]> {
        match self {
            Self::Frame(frame) => Some(&frame.range),
            Self::Picture { .. } => None,
        }
    }

    /// Returns the frame and takes its matte away, if it has one.
    pub fn take_matte(&mut self) -> Option<(&mut Frame, Matte)> {
        match self {
            Self::Frame(frame) => frame.aov.matte.take().map(|matte| (frame, matte)),
            Self::Picture { .. } => None,
        }
    }
}
