//! Kinds of pictures, their headers, and their faults.

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

/// Size and kind of a picture, and the form in which [`decode`](super::decode) hands it over.
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

impl std::fmt::Display for Fault {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Damaged(what) => write!(formatter, "{what}; it is damaged, fetch it again"),
            Self::Unsupported(what) => write!(formatter, "{what}; save it as PNG"),
        }
    }
}
