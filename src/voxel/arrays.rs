//! Whole databases from arrays in memory: for tests, examples and small areas.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::assembly::{Assembly, MemoryStorage};
use super::{
    APRON, Attributes, ContentHash, Directory, EncodedPage, FinerPages, Grid, HeightCode, HeightRange,
    MemPages, Metadata, PAGE_SIDE, PageBuffer, PageId, PageWriter, Placement, SharedObjects, Span, SpanTable,
    coarse_page,
};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

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

/// Spans on level 1 of an area, and the bare ground under them.
#[derive(Debug, Clone, Copy)]
pub struct SpanArrays<'a> {
    /// Heights of the bare ground's posts, metres, `[ny][nx]`; NaN where there is none.
    pub heights: &'a [f64],
    /// Colours of the ground, sRGB-encoded, `[ny][nx]`.
    pub colours: &'a [[u8; 3]],
    /// Spans of voxels (x, y), lowest first, none of them empty.
    pub spans: &'a BTreeMap<(u32, u32), Vec<Span>>,
    /// Objects that stand in many places.
    pub objects: &'a SharedObjects,
    /// Origins of placed instances: the south-west voxel in the area, whatever the placement says.
    pub placed: &'a [([i64; 2], Placement)],
    /// Height code of the spans, and of all heights of the database.
    pub code: HeightCode,
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
    in_memory(&arrays, None, code, range, metadata)
}

/// The same with what stands on the ground; the arrays have the highest surface, which is what is seen from afar.
pub fn build_standing(
    arrays: &Arrays<'_>,
    standing: &SpanArrays<'_>,
    metadata: &Metadata,
) -> Result<MemPages> {
    arrays.check()?;
    Arrays { heights: standing.heights, colours: standing.colours, ..*arrays }.check()?;
    let (_, of_arrays) = arrays.height_code()?;
    let spans = standing.spans.values().flatten().map(|span| [span.low, span.high]);
    let placed = standing.placed.iter().filter_map(|(_, placement)| {
        standing.objects.get(*placement).map(|object| object.codes(placement.foot))
    });
    let ends = spans.chain(placed).map(|[low, high]| {
        let [low, high] = [low.max(1), high].map(|code| f64::from(code) * standing.code.scale);
        [low + standing.code.offset, high + standing.code.offset]
    });
    let ground = standing.heights.iter().filter(|height| !height.is_nan()).map(|&height| [height, height]);
    let range = ground.chain(ends).fold(of_arrays, |range, [low, high]| HeightRange {
        low: range.low.min(low),
        high: range.high.max(high),
    });
    in_memory(arrays, Some(standing), standing.code, range, metadata)
}

fn in_memory(
    arrays: &Arrays<'_>,
    standing: Option<&SpanArrays<'_>>,
    code: HeightCode,
    range: HeightRange,
    metadata: &Metadata,
) -> Result<MemPages> {
    let name = Path::new("database in memory");
    let storage = Arc::new(MemoryStorage::default());
    let mut assembly = Assembly::new(name, storage.clone(), arrays.grid, code)?;
    let readback = assembly.readback();
    arrays.encode_pages(&code, &readback, |page| assembly.append(page))?;
    if let Some(standing) = standing {
        standing.encode_pages(arrays, |page| assembly.append(page))?;
    }
    let none = SharedObjects::default();
    assembly.seal(metadata, standing.map_or(&none, |standing| standing.objects), range)?;
    MemPages::new(name, storage.take())
}

impl SpanArrays<'_> {
    /// Placements as a page has them.
    fn placed_on(&self, id: PageId) -> Vec<Placement> {
        let here = |(first, placement): &([i64; 2], Placement)| {
            let first = [first[0] - i64::from(id.px * PAGE_SIDE), first[1] - i64::from(id.py * PAGE_SIDE)];
            let [x, y] = first.map(|at| i16::try_from(at).ok());
            Some(Placement { first: [x?, y?], ..*placement })
        };
        self.placed.iter().filter_map(here).collect()
    }

    /// Pages of bare ground where it is not the surface.
    fn encode_pages(
        &self,
        arrays: &Arrays<'_>,
        mut append: impl FnMut(&EncodedPage) -> Result<()>,
    ) -> Result<()> {
        let Arrays { grid, .. } = arrays;
        let ground = Arrays { heights: self.heights, colours: self.colours, ..*arrays };
        let rise = SpanTable::rise(self.code, grid.spacing);
        let (pages_x, pages_y) = grid.page_dims(0);
        for id in (0..pages_y).flat_map(|py| (0..pages_x).map(move |px| PageId { level: 0, px, py })) {
            let (surface, mut page) =
                (arrays.finest_page(&self.code, id), ground.finest_page(&self.code, id));
            let size = Size { width: page.width, height: page.height };
            page.spans = SpanTable::new(size, rise, |x, y, spans| {
                let voxel = (id.px * PAGE_SIDE + x, id.py * PAGE_SIDE + y);
                spans.extend(self.spans.get(&voxel).into_iter().flatten());
            });
            page.spans = page.spans.with_objects(size, self.objects, &self.placed_on(id));
            if page != surface {
                append(&page.encode(id.bare()))?;
            }
        }
        Ok(())
    }
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
    fn height_code(&self) -> Result<(HeightCode, HeightRange)> {
        if self.heights.iter().any(|height| height.is_infinite()) {
            return Err(Error::Configuration("heights: infinite; give NaN where there is no surface".into()));
        }
        let surface = self.heights.iter().copied().filter(|height| !height.is_nan());
        let (low, high) =
            surface.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (h.min(low), h.max(high)));
        let range = if low <= high { HeightRange { low, high } } else { HeightRange::default() };
        Ok((HeightCode::spanning(range.low, range.high), range))
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
        let Size { width, height } = self.grid.page_size(id).unwrap_or_default();
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
            spans: SpanTable::default(),
        }
    }
}
