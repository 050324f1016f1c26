//! Textures of models.

use std::io::Cursor;
use std::sync::Arc;

use image::{ImageReader, Limits};

use super::{Clause, Texture, Wrap};

/// Texels of all textures of the largest model: with what is coarser 180 MB.
const MOST_TEXELS: u64 = 1 << 25;

/// Texels across or down.
const MOST_SIDE: u32 = 16_384;

/// Memory for whatever decoding takes besides, bytes.
const MOST_BYTES: u64 = 512 << 20;

/// Counts the texels of a model.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    texels: u64,
}

impl Pictures {
    /// A PNG or JPEG as a texture.
    pub fn decode(&mut self, bytes: &[u8], wrap: [Wrap; 2]) -> Clause<Arc<Texture>> {
        let wrong = |error: &dyn std::fmt::Display| format!("it is no PNG or JPEG that can be read: {error}");
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(MOST_SIDE), Some(MOST_SIDE));
        limits.max_alloc = Some(MOST_BYTES);
        let reader = || {
            let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
            reader.limits(limits.clone());
            Ok::<_, std::io::Error>(reader)
        };
        let size = reader().map_err(|error| wrong(&error))?.into_dimensions();
        let (width, height) = size.map_err(|error| wrong(&error))?;
        self.texels += u64::from(width) * u64::from(height);
        if self.texels > MOST_TEXELS {
            return Err(format!(
                "it has {width} × {height} texels; all textures of a model may have {MOST_TEXELS} together"
            ));
        }
        let picture = reader().map_err(|error| wrong(&error))?.decode().map_err(|error| wrong(&error))?;
        let texels = picture.to_rgba8().pixels().map(|pixel| pixel.0).collect();
        let texture = Texture::new(width as usize, height as usize, texels, wrap);
        texture.map(Arc::new).ok_or_else(|| "it has no texels".to_owned())
    }
}
