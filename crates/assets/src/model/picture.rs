//! Textures of models.

use std::sync::Arc;

use super::{Texture, Wrap};
use crate::model::Clause;
use crate::picture;
use crate::picture::{Fault, Header, Transparency};

/// Texels of all textures of the largest model: with what is coarser 180 MB.
const MOST_TEXELS: u64 = 1 << 25;

/// Texels across or down.
const MOST_SIDE: u32 = 16_384;

/// Counts the texels of a model.
#[derive(Debug, Default)]
pub(super) struct Pictures {
    texels: u64,
}

impl Pictures {
    /// A PNG or JPEG as a texture.
    pub fn decode(&mut self, bytes: &[u8], wrap: [Wrap; 2]) -> Clause<Arc<Texture>> {
        let wrong = |fault: Fault| format!("it is no PNG or JPEG that can be read: {fault}");
        let header = picture::header(bytes, Transparency::Alpha).map_err(wrong)?;
        let (width, height) = (header.width, header.height);
        self.texels += u64::from(width) * u64::from(height);
        if self.texels > MOST_TEXELS || width.max(height) > MOST_SIDE {
            return Err(format!(
                "it has {width} × {height} texels; all textures of a model may have {MOST_TEXELS} together, and \
                 {MOST_SIDE} across or down"
            ));
        }

        let samples = picture::decode(bytes, Transparency::Alpha).map_err(wrong)?;
        let texture = Texture::new(width as usize, height as usize, texels(&header, &samples), wrap);
        texture.map(Arc::new).ok_or_else(|| "it has no texels".to_owned())
    }
}

/// sRGB and alpha of 8 bits.
fn texels(header: &Header, samples: &[u8]) -> Vec<[u8; 4]> {
    let wide = samples.as_chunks::<2>().0;
    let byte = |at: usize| match header.is_wide {
        // 65535 is 255 times 257.
        true => ((u32::from(u16::from_ne_bytes(wide[at])) + 128) / 257) as u8,
        false => samples[at],
    };
    let texel = |first: usize| match header.bands {
        1 => [byte(first), byte(first), byte(first), u8::MAX],
        2 => [byte(first), byte(first), byte(first), byte(first + 1)],
        3 => [byte(first), byte(first + 1), byte(first + 2), u8::MAX],
        _ => [byte(first), byte(first + 1), byte(first + 2), byte(first + 3)],
    };
    let count = samples.len() / if header.is_wide { 2 } else { 1 };
    (0..count).step_by(header.bands as usize).map(texel).collect()
}

#[cfg(test)]
mod tests {
    use image::{ExtendedColorType, ImageEncoder};

    use super::*;
    use hedgehop_testing::{Count, Damage};

    const WRAP: [Wrap; 2] = [Wrap::Repeat; 2];
    const SIZE: (u32, u32) = (37, 29);

    fn decoded(bytes: &[u8]) -> Option<Arc<Texture>> {
        Pictures::default().decode(bytes, WRAP).ok()
    }

    fn samples(bands: u32) -> Vec<u8> {
        (0..SIZE.0 * SIZE.1 * bands).map(|i| (i * i / 7 + i / 90 * 31) as u8).collect()
    }

    fn png(kind: ExtendedColorType, bands: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.write_image(&samples(bands), SIZE.0, SIZE.1, kind).unwrap();
        bytes
    }

    fn jpeg() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 80);
        encoder.encode(&samples(3), SIZE.0, SIZE.1, ExtendedColorType::Rgb8).unwrap();
        bytes
    }

    #[test]
    fn texels_are_those_of_the_picture() {
        let texture = |texels: Vec<[u8; 4]>| Texture::new(37, 29, texels, WRAP).map(Arc::new);
        let colours = samples(3);
        let opaque = colours.as_chunks::<3>().0.iter().map(|[red, green, blue]| [*red, *green, *blue, 255]);
        assert_eq!(decoded(&png(ExtendedColorType::Rgb8, 3)), texture(opaque.collect()));
        let greys = samples(1).iter().map(|grey| [*grey, *grey, *grey, 255]).collect();
        assert_eq!(decoded(&png(ExtendedColorType::L8, 1)), texture(greys));
        let clear = samples(4).as_chunks::<4>().0.to_vec();
        assert_eq!(decoded(&png(ExtendedColorType::Rgba8, 4)), texture(clear));
    }

    #[test]
    fn damaged_textures_are_refused() {
        let mut damage = Damage(38);
        let mut count = |name: &str, sound: &[u8], copies: usize| {
            let (mut count, texture) = (Count::default(), decoded(sound).unwrap());
            (0..copies).for_each(|_| count.add(decoded(&damage.anywhere(sound)), &texture));
            count.print("texture", name);
            count
        };

        for (name, kind, bands) in [
            ("PNG, RGB", ExtendedColorType::Rgb8, 3),
            ("PNG, RGBA", ExtendedColorType::Rgba8, 4),
            ("PNG, 16 bits", ExtendedColorType::Rgb16, 6),
        ] {
            let found = count(name, &png(kind, bands), 250);
            assert_eq!(found.silent, 0, "{name}");
            assert!(found.told > 200, "{name}");
        }

        // Codes that stay in step tell nothing; all else does.
        let found = count("JPEG", &jpeg(), 250);
        assert!(found.told > 150, "{found}");
    }
}
