//! JPEG (ITU-T T.81, 1992): checked block by block, then decoded by `image`.
//!
//! A JPEG has no checksums, and its decoder fills what it cannot read with grey. So the coded data are gone through once
//! without making samples of them (`scan`): whatever ends too early, too late or in codes that do not exist is damage. A flip
//! that leaves the codes in step changes colours, and nobody can know.

mod bits;
mod frame;
mod layout;
mod scan;
mod segments;
#[cfg(test)]
mod tests;

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};

use crate::picture::{Fault, Format, Header};

/// Reads size and bands.
pub fn header(bytes: &[u8]) -> Result<Header, Fault> {
    let decoder = decoder(bytes)?;
    let (width, height) = decoder.dimensions();
    let bands = bands(&decoder)?;
    Ok(Header {
        format: Format::Jpeg,
        width,
        height,
        bands,
        has_alpha: false,
        is_wide: false,
        stored_bits: 8,
        is_palette: false,
        transparent_grey: None,
    })
}

/// Decodes a picture all of whose blocks are there.
pub fn decode(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    frame::check(bytes)?;
    let decoder = decoder(bytes)?;
    bands(&decoder)?;
    let size = usize::try_from(decoder.total_bytes())
        .map_err(|_| Fault::Unsupported("its size exceeds memory".to_owned()))?;
    let mut samples = vec![0; size];
    decoder.read_image(&mut samples).map_err(fault)?;
    Ok(samples)
}

fn decoder(bytes: &[u8]) -> Result<JpegDecoder<Cursor<&[u8]>>, Fault> {
    JpegDecoder::new(Cursor::new(bytes)).map_err(fault)
}

/// The decoder's words may end in a line of their own.
fn fault(error: image::ImageError) -> Fault {
    let what = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    match error {
        image::ImageError::Unsupported(_) => Fault::Unsupported(what),
        _ => Fault::Damaged(what),
    }
}

fn bands(decoder: &JpegDecoder<Cursor<&[u8]>>) -> Result<u32, Fault> {
    match decoder.color_type() {
        ColorType::L8 => Ok(1),
        ColorType::Rgb8 => Ok(3),
        other => Err(Fault::Unsupported(format!("it has pixels of type {other:?}"))),
    }
}
