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
mod png;
#[cfg(test)]
mod tests;

/// Kind of a picture, by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// JPEG, of the Joint Photographic Experts Group.
    Jpeg,
}

/// Why a picture is not read: a clause without the file's name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// Differs from how it was written.
    Damaged(String),
    /// Is sound, but of a kind that is not read.
    Unsupported(String),
}

/// Meaning of a PNG's transparent value (`tRNS`) in a picture of greys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transparency {
    /// Told as [`Header::transparent_grey`]; samples stay as stored.
    Value,
    /// An alpha band.
    Alpha,
}

/// Size and kind of a picture, and the form in which [`decode`] hands it over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Format of the file.
    pub format: Format,
    /// Columns, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
    /// Bands of a decoded pixel: grey or red, green, blue; alpha is the last one if there is one.
    pub bands: u32,
    /// Whether the last band is alpha, not multiplied into the others.
    pub has_alpha: bool,
    /// Whether decoded samples have 16 bits, in native byte order, and not 8.
    pub is_wide: bool,
    /// Bits of a stored sample.
    pub stored_bits: u8,
    /// Whether stored samples are places in a palette, which is looked up.
    pub is_palette: bool,
    /// Grey that means no data, if [`Transparency::Value`] was asked for.
    pub transparent_grey: Option<u16>,
}

impl Header {
    /// Bytes of the decoded picture; `None` if they exceed 64 bits.
    pub fn bytes(&self) -> Option<u64> {
        let pixel = u64::from(self.bands) * if self.is_wide { 2 } else { 1 };
        (u64::from(self.width) * u64::from(self.height)).checked_mul(pixel)
    }
}

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

impl std::fmt::Display for Fault {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Damaged(what) => write!(formatter, "{what}; it is damaged, fetch it again"),
            Self::Unsupported(what) => write!(formatter, "{what}; save it as PNG"),
        }
    }
}
