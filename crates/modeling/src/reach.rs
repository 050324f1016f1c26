//! Pages that the inputs of a build can reach: all others have no surface, and no bytes.

use super::footprint::Bounds;
use super::inputs::Inputs;
use super::options::BuildOptions;
use super::plan::Plan;
use super::synthetic::Synthetic;
use super::warp::{LevelGrid, RasterPlacement, Rect};
use crate::opened::Opened;
use hedgehop::voxel::{APRON, Grid, PAGE_SIDE, PageId};
use hedgehop_base::Size;
use hedgehop_base::error::Result;

/// An elevation raster in the grid.
struct ReachSheet {
    placement: RasterPlacement,
    size: Size,
    reach: Bounds,
}

/// Bounds of the inputs, which tell the pages they reach.
#[derive(Default)]
pub(super) struct Reach {
    elevation: Vec<ReachSheet>,
    /// Bounds that imagery and land cover can reach.
    others: Vec<Bounds>,
    /// Something that has no bounds is everywhere.
    is_everywhere: bool,
}

impl Reach {
    /// Finds the bounds of opened inputs.
    ///
    /// # Errors
    /// A raster that has no place in the grid.
    pub fn of(inputs: &Inputs, plan: &Plan, options: &BuildOptions) -> Result<Self> {
        if inputs.has_spans() || options.synthetic != Synthetic::default() {
            return Ok(Self { is_everywhere: true, ..Self::default() });
        }
        let sheet = |raster: &Opened<f64>| {
            let (placement, reach) = raster.place(plan)?;
            Ok(ReachSheet { placement, size: raster.samples.size(), reach })
        };
        let imagery = inputs.imagery.iter().map(|raster| Ok(raster.place(plan)?.1));
        let land_cover = inputs.land_cover.iter().map(|raster| Ok(raster.place(plan)?.1));
        Ok(Self {
            elevation: inputs.elevation.iter().map(sheet).collect::<Result<_>>()?,
            others: imagery.chain(land_cover).collect::<Result<_>>()?,
            is_everywhere: false,
        })
    }

    /// Whether all pages may have something.
    pub fn is_everywhere(&self) -> bool {
        self.is_everywhere
    }

    /// Whether a page may have more than its entry.
    pub fn may_fill(&self, grid: &Grid, id: PageId) -> bool {
        let level = LevelGrid::of(grid, id.level).grid;
        let around = rect_of(grid, id).grown(APRON + 2, &level);
        let sheets = self.elevation.iter().map(|sheet| &sheet.reach);
        self.is_everywhere || sheets.chain(&self.others).any(|reach| around.meets(reach, &level))
    }

    /// Whether a page lies on elevation for certain, be there data or not.
    pub fn has_elevation(&self, grid: &Grid, id: PageId) -> bool {
        // The middle, then those of the quarters.
        const PLACES: [[f64; 2]; 5] = [[0.5, 0.5], [0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]];
        if self.is_everywhere {
            return true;
        }
        let level = LevelGrid::of(grid, id.level).grid;
        let own = rect_of(grid, id);
        let [low, high] = grid.page_square(id);
        let mut near = self.elevation.iter().filter(|sheet| own.meets(&sheet.reach, &level));
        near.any(|ReachSheet { placement, size, .. }| {
            let is_on = |at: f64, size: u32| (0.0..=f64::from(size) - 1.0).contains(&at);
            PLACES.iter().any(|share| {
                let place = low + (high - low) * glam::DVec2::from_array(*share);
                let pixel = placement.pixel_from_world(place.x, place.y);
                pixel.is_some_and(|(column, row)| is_on(column, size.width) && is_on(row, size.height))
            })
        })
    }
}

/// The voxels of a page.
fn rect_of(grid: &Grid, id: PageId) -> Rect {
    let Size { width, height } = grid.page_size(id).unwrap_or_default();
    let (x0, y0) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
    Rect { x0, y0, x1: x0 + width, y1: y0 + height }
}
