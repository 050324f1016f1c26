//! Arguments that users type, and flags that the modes share.

use std::path::{Path, PathBuf};

use hedgehop::memory::PageFile;
use hedgehop::render::RenderOptions;
use hedgehop::subimage::Farm;
use hedgehop::{Result, Size};

/// Widest and highest picture, pixels.
const MAX_SIDE: u32 = 16384;

/// `WIDTHxHEIGHT`, pixels.
pub fn size(text: &str) -> Result<Size, String> {
    let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some(Size { width: side(width)?, height: side(height)? }))
        .ok_or_else(|| format!("want WIDTHxHEIGHT in pixels, each 1 to {MAX_SIDE}, such as 480x270"))
}

/// `COLUMN,ROW`, pixels.
pub fn pixel(text: &str) -> Result<[u32; 2], String> {
    text.split_once(',')
        .and_then(|(column, row)| Some([column.trim().parse().ok()?, row.trim().parse().ok()?]))
        .ok_or_else(|| "want COLUMN,ROW in pixels, such as 812,44".into())
}

/// A finite number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("want a number above 0".into()),
    }
}

/// Arguments that every mode needs.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Decides poses and pixels
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub seed: u64,

    /// Workers
    #[arg(short = 'j', long, value_name = "N", default_value_t = 2)]
    pub workers: usize,

    /// The renderer's `--detail`
    #[arg(long, value_name = "FACTOR", default_value = "1", value_parser = positive)]
    pub detail: f64,

    /// Write everything measured to this file
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
}

impl Common {
    /// The workers.
    pub fn farm(&self) -> Result<Farm> {
        Farm::new(self.workers)
    }

    /// Returns the options of the renderer under test.
    pub fn judged(&self) -> RenderOptions {
        RenderOptions { detail: self.detail, ..RenderOptions::default() }
    }
}

/// A database and the name that it goes by.
pub struct Area {
    /// The file's name without extension.
    pub name: String,
    /// The pages.
    pub source: PageFile,
}

impl Area {
    /// Opens a database file.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, source: PageFile::open(path)? })
    }
}
