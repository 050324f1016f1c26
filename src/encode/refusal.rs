//! Reasons why a file is not the picture that was looked for.

use hedgehop_base::Size;

/// Why a file is not the picture that was looked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum PictureRefusal {
    /// The file is damaged, or no picture of ours.
    Broken(String),
    /// A sound picture of another size.
    Size(Size),
}

impl PictureRefusal {
    /// Refuses a `size` that is not the `wanted` one, if one is wanted. Called before anything is allocated.
    pub(super) fn other_size(size: Size, wanted: Option<Size>) -> Result<(), Self> {
        if wanted.is_some_and(|wanted| wanted != size) { Err(Self::Size(size)) } else { Ok(()) }
    }
}

impl From<String> for PictureRefusal {
    fn from(what: String) -> Self {
        Self::Broken(what)
    }
}

impl std::fmt::Display for PictureRefusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Broken(what) => f.write_str(what),
            Self::Size(Size { width, height }) => write!(f, "it is {width}×{height} pixels"),
        }
    }
}
