//! PNG and JPEG pictures: whole, or refused with what is wrong.
//!
//! Decoders are lenient by habit, since browsers show whatever they can: damaged chunks of a PNG that may be left out are
//! left out, though one of them says which grey is no height; a JPEG without its second half comes with a grey one. Heights,
//! colours of the ground and textures are all read through here, so that none of them takes damage for a picture.
//!
//! ```text
//! PNG   the checksum of every chunk and of the samples holds, and the file goes on to its end
//! JPEG  without checksums: every block of every scan is there, in codes that exist, and nothing is left over (jpeg/)
//! ```

mod jpeg;
mod kinds;
mod png;
pub use kinds::{Fault, Format, Header, Transparency};

#[cfg(test)]
mod tests;

/// Recognizes the kind of picture that begins with these bytes.
pub fn format(bytes: &[u8]) -> Option<Format> {
    match bytes {
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Format::Png),
        [0xff, 0xd8, 0xff, ..] => Some(Format::Jpeg),
        _ => None,
    }
}

/// Reads what stands before a picture's samples.
pub fn header(bytes: &[u8], transparency: Transparency) -> Result<Header, Fault> {
    match format(bytes) {
        Some(Format::Png) => png::header(bytes, transparency),
        Some(Format::Jpeg) => jpeg::header(bytes),
        None => Err(Fault::Damaged("it does not begin as a PNG or JPEG does".to_owned())),
    }
}

/// Samples of a whole picture, row by row from the top, bands interleaved; as many bytes as its header says.
pub fn decode(bytes: &[u8], transparency: Transparency) -> Result<Vec<u8>, Fault> {
    match format(bytes) {
        Some(Format::Jpeg) => jpeg::decode(bytes),
        _ => png::decode(bytes, transparency),
    }
}
