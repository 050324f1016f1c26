//! Several databases as one.
//!
//! ```text
//! grid: around all of them; they have one spacing and one reference system, and lie whole voxels apart
//! a voxel of level 1: of the first database that has a surface there, bare ground and what stands on it included
//!     blended, near the edge of that database, with the next one that has a surface there:
//!         w = distance to the edge / width, at most 1;   height = w · own + (1 − w) · other
//! coarser levels: made anew from level 1
//! ```
//!
//! Pages need not lie on each other: voxels are copied one by one.

use std::collections::HashSet;

use glam::DVec2;

use super::counts::PageCounts;
use super::disk_space;
use super::options::OutputFile;
use super::workers::in_order;
use hedgehop::voxel::{
    APRON, Attributes, BLOCK_SIDE, BlockSpans, EncodedPage, Facade, Grid, HeightCode, Metadata, PAGE_SIDE,
    PageBuffer, PageId, PageReadback, PageSource, PageWriter, SharedObjects, Span, SpanTable, coarse_page,
};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Largest difference of spacings that are the same, as a share, and of corners from whole voxels, in voxels.
const SAME_SPACING: f64 = 1e-9;
const SAME_PLACE: f64 = 1e-3;

/// Voxels of the whole for each one of the databases, at most: more lies between them.
const MOST_BETWEEN: u64 = 16;

/// Databases that lie on one grid, the first in front.
pub struct Merger<'s> {
    layers: Vec<MergeLayer<'s>>,
    grid: Grid,
    heights: HeightCode,
    metadata: Metadata,
    /// Width over which databases are blended, metres.
    feather: f64,
}

/// A database that is to be merged.
#[derive(Clone, Copy)]
pub struct MergeInput<'s> {
    /// The database.
    pub source: &'s dyn PageSource,
    /// Name that messages give it.
    pub name: &'s str,
}

/// One of the databases.
struct MergeLayer<'s> {
    source: &'s dyn PageSource,
    /// First voxel, and the one behind the last.
    first: [i64; 2],
    end: [i64; 2],
    /// Begin of its sources in the list of all.
    sources: u16,
}

/// Fit of databases where they meet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Join {
    /// Neighbouring voxels of two databases.
    pub pairs: u64,
    /// Largest step of height, metres, and where it is, metres of the reference system.
    pub largest: f64,
    /// Place of that step.
    pub place: DVec2,
    /// Sum of all steps, metres.
    sum: f64,
}

impl Join {
    /// Mean step, metres; 0 where nothing meets.
    pub fn mean(&self) -> f64 {
        self.sum / (self.pairs.max(1)) as f64
    }

    fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.sum += other.sum;
        if other.largest > self.largest {
            (self.largest, self.place) = (other.largest, other.place);
        }
    }
}

/// Result of a merge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merged {
    /// Bytes of the file.
    pub bytes: u64,
    /// Fit of the databases.
    pub join: Join,
}

/// A voxel of level 1, of bare ground or of the surface.
#[derive(Debug, Clone, Copy)]
struct MergedVoxel {
    /// Database that it is of; `None`: it has no surface.
    owner: Option<usize>,
    height: u16,
    colour: [u8; 3],
    attributes: Attributes,
}

/// The block that was looked at last: database, and column and row of blocks.
#[derive(Default)]
struct KnownPage {
    block: Option<(usize, [u32; 2])>,
    spans: BlockSpans,
}

const NOTHING: MergedVoxel = MergedVoxel {
    owner: None,
    height: HeightCode::EMPTY,
    colour: [0; 3],
    attributes: Attributes { source: 0, material: 0, flags: Attributes::VOID | Attributes::NO_IMAGERY },
};

impl<'s> Merger<'s> {
    /// Lays databases over each other, the first in front; blended over `feather` metres ≥ 0.
    ///
    /// # Errors
    /// [`Error::Configuration`]: they do not lie on one grid, differ in what coordinates, heights or colours mean, are not stored at level 1 throughout, or lie too far
    /// apart.
    pub fn new(databases: &[MergeInput<'s>], feather: f64) -> Result<Self> {
        let wrong = |what: String| Err(Error::Configuration(what));
        let [MergeInput { source: first, name: first_name }, ..] = databases else {
            return wrong("give at least two databases".into());
        };

        let one = first.header();
        let mut metadata = one.metadata.clone();
        (metadata.sources, metadata.notes) = (Vec::new(), Vec::new());
        let (mut layers, mut voxels) = (Vec::new(), 0);

        for MergeInput { source, name } in databases {
            let own = source.header();
            if (own.grid.spacing / one.grid.spacing - 1.0).abs() > SAME_SPACING {
                return wrong(format!(
                    "{name} has voxels of {} m, {first_name} of {} m; build one of them anew with the --spacing of the other",
                    own.grid.spacing, one.grid.spacing
                ));
            }
            if let Some(what) = difference(&own.metadata, &one.metadata) {
                return wrong(format!(
                    "{name} and {first_name} differ in {what}; build one of them anew as the other"
                ));
            }

            let offset = (own.grid.origin - one.grid.origin) / one.grid.spacing;
            if (offset - offset.round()).abs().max_element() > SAME_PLACE || offset.abs().max_element() > 1e9
            {
                return wrong(format!(
                    "the voxels of {name} and {first_name} do not lie on each other, but {:.3} and {:.3} of their sides aside; build one of them anew with the grid of the other",
                    offset.x - offset.x.round(),
                    offset.y - offset.y.round()
                ));
            }

            let (columns, rows) = own.grid.page_dims(0);
            let all = (0..rows).flat_map(|py| (0..columns).map(move |px| PageId { level: 0, px, py }));
            if let Some(missing) = all.into_iter().find(|id| !source.has(*id)) {
                return wrong(format!(
                    "{name} does not store {missing}: databases with corridors cannot be merged"
                ));
            }
            if own.has_spans && feather > 0.0 {
                return wrong(format!(
                    "{name} has what stands on the ground, which cannot be blended; merge without blending"
                ));
            }

            let corner = [offset.x, offset.y].map(|at| at.round() as i64);
            let Ok(sources) = u16::try_from(metadata.sources.len()) else {
                return wrong(format!("with {name} there are more than 65,535 sources"));
            };

            metadata.sources.extend(own.metadata.sources.iter().cloned());
            metadata.notes.extend(own.metadata.notes.iter().cloned());
            voxels += u64::from(own.grid.nx) * u64::from(own.grid.ny);
            let end = [corner[0] + i64::from(own.grid.nx), corner[1] + i64::from(own.grid.ny)];
            layers.push(MergeLayer { source: *source, first: corner, end, sources });
        }

        metadata.notes.push(format!("merged from {} databases", layers.len()));
        // What several of them tell is told once.
        let mut told = HashSet::new();
        metadata.notes.retain(|note| told.insert(note.clone()));
        let low = [0, 1].map(|axis| layers.iter().map(|layer| layer.first[axis]).min().unwrap_or(0));
        let high = [0, 1].map(|axis| layers.iter().map(|layer| layer.end[axis]).max().unwrap_or(0));
        let size = [0, 1].map(|axis| u32::try_from(high[axis] - low[axis]).unwrap_or(u32::MAX));
        if u64::from(size[0]) * u64::from(size[1]) > MOST_BETWEEN.saturating_mul(voxels) {
            return wrong(format!(
                "the databases lie far apart: together they would have {} x {} voxels, most of them empty",
                size[0], size[1]
            ));
        }

        for layer in &mut layers {
            [0, 1].into_iter().for_each(|axis| {
                layer.first[axis] -= low[axis];
                layer.end[axis] -= low[axis];
            });
        }

        let origin = one.grid.origin + DVec2::new(low[0] as f64, low[1] as f64) * one.grid.spacing;
        let grid = Grid { nx: size[0], ny: size[1], origin, ..one.grid };
        let heights = common_code(databases);

        Ok(Self { layers, grid, heights, metadata, feather })
    }

    /// The grid of the whole.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Writes the whole as `output`.
    ///
    /// # Errors
    /// [`Error::Configuration`]: `output` exists and may not be replaced; a page that is damaged; what the disk refuses; an interruption.
    pub fn write(&self, output: OutputFile<'_>, threads: usize, observer: &dyn Observer) -> Result<Merged> {
        let mut writer = PageWriter::create(output.path, self.grid, self.heights, output.overwrite)?;
        let pages = |level: u8| {
            let (columns, rows) = self.grid.page_dims(level);
            u64::from(columns) * u64::from(rows)
        };
        let bare = if self.layers.iter().any(|layer| layer.source.header().has_spans) { pages(0) } else { 0 };
        writer.expect(disk_space::most_bytes(&self.grid, pages, bare));
        let finer = writer.readback();
        let (mut counts, mut join) = (PageCounts::default(), Join::default());
        let ids = |level: u8| -> Vec<PageId> {
            let (columns, rows) = self.grid.page_dims(level);
            (0..rows).flat_map(|py| (0..columns).map(move |px| PageId { level, px, py })).collect()
        };
        let levels = self.grid.level_count();
        let count: usize = (0..levels).map(|level| ids(level).len()).sum();
        observer.begin("pages", count as u64, "pages");

        for ids in (0..levels).map(ids) {
            in_order(
                ids.len() as u64,
                threads,
                observer,
                || (),
                |(), task| self.pages(ids[task as usize], &finer),
                |_, (pages, own, steps): (Vec<EncodedPage>, PageCounts, Join)| {
                    pages.iter().try_for_each(|page| writer.append(page))?;
                    counts.add(&own);
                    join.add(&steps);
                    observer.advance(1);
                    Ok(())
                },
            )?;
        }

        observer.end();
        self.layers.iter().try_for_each(|layer| layer.source.intact())?;
        let (_, bytes) =
            writer.finish(&counts.metadata(&self.metadata), counts.height_range(self.heights))?;

        Ok(Merged { bytes, join })
    }

    /// A page, and that of bare ground under it, if there is one.
    fn pages(&self, id: PageId, finer: &PageReadback) -> Result<(Vec<EncodedPage>, PageCounts, Join)> {
        if id.level > 0 {
            let page = coarse_page(finer, &self.grid, self.heights, id)?;
            return Ok((
                vec![page.encode(id)],
                PageCounts::of_stored(&page, id, &SharedObjects::default()),
                Join::default(),
            ));
        }

        let (surface, join) = self.finest(id, false)?;
        let mut counts = PageCounts::of_stored(&surface, id, &SharedObjects::default());
        let mut pages = vec![surface.encode(id)];
        if self.layers.iter().any(|layer| layer.source.header().has_spans) {
            let (bare, _) = self.finest(id, true)?;
            if bare != surface {
                counts.add(&PageCounts::of_stored(&bare, id.bare(), &SharedObjects::default()));
                pages.push(bare.encode(id.bare()));
            }
        }

        Ok((pages, counts, join))
    }

    /// A page of level 1, and the steps in it between databases.
    fn finest(&self, id: PageId, is_bare: bool) -> Result<(PageBuffer, Join)> {
        let size = self.grid.page_size(id).unwrap_or_default();
        let Size { width, height } = size;
        let around = |page: u32, size: u32, limit: u32| {
            (0..size + 2 * APRON)
                .map(move |at| i64::from((page * PAGE_SIDE + at).clamp(APRON, limit - 1 + APRON) - APRON))
        };
        let columns: Vec<i64> = around(id.px, width, self.grid.nx).collect();
        let mut voxels = Vec::with_capacity(columns.len() * (height + 2 * APRON) as usize);

        for y in around(id.py, height, self.grid.ny) {
            for &x in &columns {
                voxels.push(self.voxel(x, y, is_bare)?);
            }
        }

        let stride = columns.len();
        let place = |x: u32, y: u32| (y + APRON) as usize * stride + (x + APRON) as usize;
        let own = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let mut spans = SpanTable::default();

        if is_bare {
            let rise = SpanTable::rise(self.heights, self.grid.spacing);
            let (mut failed, mut known) = (None, KnownPage::default());
            spans = SpanTable::new(size, rise, |x, y, all| {
                let at = [i64::from(id.px * PAGE_SIDE + x), i64::from(id.py * PAGE_SIDE + y)];
                if let Err(error) = self.add_spans(voxels[place(x, y)].owner, at, &mut known, all) {
                    failed = Some(error);
                }
            });
            failed.map_or(Ok(()), Err)?;
        }

        let mut join = Join::default();
        for (x, y) in own() {
            let here = &voxels[place(x, y)];
            for there in [place(x + 1, y), place(x, y + 1)].map(|place| &voxels[place]) {
                if here.owner.is_some() && there.owner.is_some() && here.owner != there.owner {
                    let step = f64::from(here.height.abs_diff(there.height)) * self.heights.scale;
                    let voxel =
                        DVec2::new(f64::from(id.px * PAGE_SIDE + x), f64::from(id.py * PAGE_SIDE + y));
                    let place = self.grid.origin + (voxel + 0.5) * self.grid.spacing;
                    join.add(&Join { pairs: 1, largest: step, place, sum: step });
                }
            }
        }

        let page = PageBuffer {
            width,
            height,
            heights: voxels.iter().map(|voxel| voxel.height).collect(),
            low: Vec::new(),
            high: Vec::new(),
            colours: voxels.iter().map(|voxel| voxel.colour).collect(),
            relief: Vec::new(),
            attributes: own().map(|(x, y)| voxels[place(x, y)].attributes).collect(),
            spans,
        };

        Ok((page, join))
    }

    /// The voxel of the first database with a surface there.
    fn voxel(&self, x: i64, y: i64, is_bare: bool) -> Result<MergedVoxel> {
        let mut found: Option<(usize, MergedVoxel)> = None;
        for index in (0..self.layers.len()).filter(|index| self.layers[*index].covers(x, y)) {
            let Some(voxel) = self.of_layer(index, x, y, is_bare)? else { continue };
            let Some((front, own)) = found else {
                let share = self.share(index, x, y);
                if share >= 1.0 {
                    return Ok(voxel);
                }
                found = Some((index, voxel));
                continue;
            };
            return Ok(self.blended(&own, &voxel, self.share(front, x, y)));
        }
        Ok(found.map_or(NOTHING, |(_, voxel)| voxel))
    }

    /// A voxel of a database; `None` where it has no surface.
    fn of_layer(&self, index: usize, x: i64, y: i64, is_bare: bool) -> Result<Option<MergedVoxel>> {
        let layer = &self.layers[index];
        let [column, row] = [x - layer.first[0], y - layer.first[1]].map(|at| at as u32);
        let id = PageId { level: 0, px: column / PAGE_SIDE, py: row / PAGE_SIDE };
        let (column, row) = (column % PAGE_SIDE, row % PAGE_SIDE);
        let Some(view) = layer.source.page(id)? else { return Ok(None) };
        // Which database a voxel is of does not depend on what stands there.
        if view.heights[view.sample(column, row)] == HeightCode::EMPTY {
            return Ok(None);
        }
        let sheet = if is_bare { layer.source.ground_of(id.bare()) } else { id };
        let Some(view) = layer.source.page(sheet)? else { return Ok(None) };
        let (sample, mut attributes) = (view.sample(column, row), view.attributes_at(column, row));
        attributes.source += layer.sources;
        let height = self.code(layer, view.heights[sample]);
        Ok(Some(MergedVoxel { owner: Some(index), height, colour: view.colours[sample], attributes }))
    }

    /// A database's height code as one of the whole.
    fn code(&self, layer: &MergeLayer<'_>, code: u16) -> u16 {
        let own = layer.source.header().heights;
        match own.decode(code) {
            Some(height) if own != self.heights => self.heights.encode(height),
            _ => code,
        }
    }

    /// Adds the spans of a voxel; what the database places there gets spans of its own.
    fn add_spans(
        &self,
        owner: Option<usize>,
        [x, y]: [i64; 2],
        known: &mut KnownPage,
        all: &mut Vec<Span>,
    ) -> Result<()> {
        let Some(index) = owner else { return Ok(()) };
        let layer = &self.layers[index];
        let at = [x - layer.first[0], y - layer.first[1]].map(|at| at as u32);
        let id = PageId { level: 0, px: at[0] / PAGE_SIDE, py: at[1] / PAGE_SIDE }.bare();
        let header = layer.source.header();
        if !header.has_spans || !layer.source.has(id) {
            return Ok(());
        }

        let (block, within) = (at.map(|at| at / BLOCK_SIDE), at.map(|at| at % PAGE_SIDE));
        if known.block != Some((index, block)) {
            let Some(spans) = layer.source.spans(id)? else { return Ok(()) };
            let rise = SpanTable::rise(header.heights, header.grid.spacing);
            known.spans.gather(&spans, &header.objects, within, rise);
            known.block = Some((index, block));
        }

        all.extend(known.spans.of(within[0], within[1]).iter().map(|span| {
            let (low, high) = (self.code(layer, span.low), self.code(layer, span.high));
            let Facade { floor, eaves, .. } = span.facade;
            let [floor, eaves] = [floor, eaves].map(|code| self.code(layer, code));
            Span { low, high, facade: Facade { floor, eaves, ..span.facade }, ..*span }
        }));

        Ok(())
    }

    /// Returns the share of a voxel that is its own database's: less than 1 near the edges of that beyond which another one goes on.
    fn share(&self, index: usize, x: i64, y: i64) -> f64 {
        if self.feather <= 0.0 {
            return 1.0;
        }
        let layer = &self.layers[index];
        let goes_on = |x: i64, y: i64| self.layers[index + 1..].iter().any(|other| other.covers(x, y));
        let sides = [
            (x - layer.first[0], goes_on(layer.first[0] - 1, y)),
            (layer.end[0] - 1 - x, goes_on(layer.end[0], y)),
            (y - layer.first[1], goes_on(x, layer.first[1] - 1)),
            (layer.end[1] - 1 - y, goes_on(x, layer.end[1])),
        ];
        let nearest = sides.into_iter().filter(|(_, goes_on)| *goes_on).map(|(distance, _)| distance).min();
        nearest.map_or(1.0, |distance| ((distance as f64 + 0.5) * self.grid.spacing / self.feather).min(1.0))
    }

    fn blended(&self, own: &MergedVoxel, other: &MergedVoxel, share: f64) -> MergedVoxel {
        let mix = |own: f64, other: f64| (share * own + (1.0 - share) * other).round();
        let height = mix(f64::from(own.height), f64::from(other.height)) as u16;
        let colour =
            [0, 1, 2].map(|band| mix(f64::from(own.colour[band]), f64::from(other.colour[band])) as u8);
        MergedVoxel { height, colour, ..*own }
    }
}

impl MergeLayer<'_> {
    fn covers(&self, x: i64, y: i64) -> bool {
        (self.first[0]..self.end[0]).contains(&x) && (self.first[1]..self.end[1]).contains(&y)
    }
}

/// Names what two databases do not mean the same by; `None`: they do.
fn difference(own: &Metadata, other: &Metadata) -> Option<&'static str> {
    if (own.crs_epsg, &own.crs_proj) != (other.crs_epsg, &other.crs_proj) {
        Some("their reference systems")
    } else if own.vertical_datum != other.vertical_datum {
        Some("what heights are measured from")
    } else if own.baked_sun != other.baked_sun {
        Some("the shadows in their colours")
    } else if own.detail != other.detail {
        Some("the detail below their voxels")
    } else {
        None
    }
}

/// The code that all have, or the finest that holds all heights.
fn common_code(databases: &[MergeInput<'_>]) -> HeightCode {
    let headers = || databases.iter().map(|database| database.source.header());
    let codes: Vec<HeightCode> = headers().map(|header| header.heights).collect();
    if codes.windows(2).all(|pair| pair[0] == pair[1]) {
        return codes.first().copied().unwrap_or(HeightCode::spanning(0.0, 0.0));
    }
    let range = headers().map(|header| header.height_range);
    let (low, high) = range
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), own| (low.min(own.low), high.max(own.high)));
    HeightCode::spanning(low, high)
}

#[cfg(test)]
mod tests;
