//! Whole databases from arrays in memory: for tests, examples and small areas.

use std::path::Path;
use std::sync::Arc;

use super::assembly::{Assembly, MemoryStorage};
use super::{
    APRON, Attributes, ContentHash, Directory, EncodedPage, FinerPages, Grid, HeightCode, MemPages, Metadata,
    PAGE_SIDE, PageBuffer, PageId, PageWriter, coarse_page,
};
use crate::error::{Error, Result};

/// Level 1 of an area. All arrays are `[ny][nx]`, row 0 southernmost.
#[derive(Debug, Clone, Copy)]
pub struct Arrays<'a> {
    /// The grid.
    pub grid: Grid,
    /// Heights of the posts, metres; NaN where there is no surface.
    pub heights: &'a [f64],
    /// sRGB-encoded colours.
    pub colours: &'a [[u8; 3]],
    /// Attributes; `None`: default ones everywhere.
    pub attributes: Option<&'a [Attributes]>,
}

/// A complete database in memory from arrays (see [`Arrays`] for their shapes). Shares of voids in
/// `metadata` are kept as given.
pub fn build_in_memory(
    grid: Grid,
    heights: &[f64],
    colours: &[[u8; 3]],
    attributes: Option<&[Attributes]>,
    metadata: &Metadata,
) -> Result<MemPages> {
    let arrays = Arrays { grid, heights, colours, attributes };
    arrays.check()?;
    let (code, range) = arrays.height_code()?;
    let name = Path::new("database in memory");
    let storage = Arc::new(MemoryStorage::default());
    let mut assembly = Assembly::new(name, storage.clone(), grid, code)?;
    let readback = assembly.readback();
    arrays.encode_pages(&code, &readback, |page| assembly.append(page))?;
    assembly.seal(metadata, range)?;
    MemPages::new(name, storage.take())
}

/// The same database as [`build_in_memory`] gives, byte for byte, as a file. Returns identity and bytes.
pub fn write_arrays(
    path: &Path,
    arrays: &Arrays<'_>,
    metadata: &Metadata,
    overwrite: bool,
) -> Result<(ContentHash, u64)> {
    arrays.check()?;
    let (code, range) = arrays.height_code()?;
    let mut writer = PageWriter::create(path, arrays.grid, code, overwrite)?;
    let readback = writer.readback();
    arrays.encode_pages(&code, &readback, |page| writer.append(page))?;
    writer.finish(metadata, range)
}

impl Arrays<'_> {
    fn check(&self) -> Result<()> {
        self.grid.check().map_err(Error::Configuration)?;
        let voxels = u64::from(self.grid.nx) * u64::from(self.grid.ny);
        let lengths = [
            ("heights", self.heights.len()),
            ("colours", self.colours.len()),
            ("attributes", self.attributes.map_or(voxels as usize, <[_]>::len)),
        ];
        match lengths.into_iter().find(|(_, length)| *length as u64 != voxels) {
            Some((name, length)) => Err(Error::Configuration(format!(
                "{name}: {length} values for a grid of {} x {}",
                self.grid.nx, self.grid.ny
            ))),
            None => Ok(()),
        }
    }

    /// The finest code for the heights, and their range.
    fn height_code(&self) -> Result<(HeightCode, (f64, f64))> {
        if self.heights.iter().any(|height| height.is_infinite()) {
            return Err(Error::Configuration("heights: infinite; give NaN where there is no surface".into()));
        }
        let surface = self.heights.iter().copied().filter(|height| !height.is_nan());
        let (low, high) =
            surface.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (h.min(low), h.max(high)));
        let range = if low <= high { (low, high) } else { (0.0, 0.0) };
        Ok((HeightCode::spanning(range.0, range.1), range))
    }

    /// Every page in the order of the directory, which is an order in which they can be made.
    fn encode_pages(
        &self,
        code: &HeightCode,
        finer: &impl FinerPages,
        mut append: impl FnMut(&EncodedPage) -> Result<()>,
    ) -> Result<()> {
        let directory = Directory::empty(&self.grid).map_err(Error::Configuration)?;
        for id in directory.ids() {
            let page = if id.level == 0 {
                self.finest_page(code, id)
            } else {
                coarse_page(finer, &self.grid, *code, id)?
            };
            append(&page.encode(id))?;
        }
        Ok(())
    }

    /// A page of level 1.
    fn finest_page(&self, code: &HeightCode, id: PageId) -> PageBuffer {
        let (width, height) = self.grid.page_size(id).unwrap_or((0, 0));
        let nx = self.grid.nx as usize;
        let (first_x, first_y) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let clamped =
            |first: u32, k: u32, limit: u32| (first + k).saturating_sub(APRON).min(limit - 1) as usize;
        let index =
            |x: u32, y: u32| clamped(first_y, y, self.grid.ny) * nx + clamped(first_x, x, self.grid.nx);
        let with_apron = || (0..height + 2 * APRON).flat_map(|y| (0..width + 2 * APRON).map(move |x| (x, y)));
        let own = || (APRON..height + APRON).flat_map(|y| (APRON..width + APRON).map(move |x| (x, y)));
        PageBuffer {
            width,
            height,
            heights: with_apron().map(|(x, y)| code.encode(self.heights[index(x, y)])).collect(),
            low: Vec::new(),
            high: Vec::new(),
            colours: with_apron().map(|(x, y)| self.colours[index(x, y)]).collect(),
            relief: Vec::new(),
            attributes: own()
                .map(|(x, y)| self.attributes.map_or_else(Attributes::default, |a| a[index(x, y)]))
                .collect(),
        }
    }
}
