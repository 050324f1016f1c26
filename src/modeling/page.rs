//! One page of level 1.
//!
//! ```text
//! heights = the mosaic over the page, its apron and a voxel around it (slopes of the apron need that)
//! voids   = left empty | the fixed height | interpolated (over a wider mosaic, as far as the fill reaches)
//! colours = imagery over the page and its apron, on top of the tint by height and slope
//! ```
//! Every sample depends on its place in the grid alone, never on the page: aprons equal the neighbours' voxels.

use super::drape::{Drape, Pigment};
use super::fill;
use super::mosaic::{Mosaic, Surface};
use super::options::NodataFill;
use super::placed::{ElevationInput, ImageryInput};
use super::scan::Survey;
use super::tint::Tint;
use super::warp::{self, Rect};
use crate::colour::srgb8_from_linear;
use crate::error::Result;
use crate::voxel::{APRON, Attributes, EncodedPage, Grid, HeightCode, PAGE_SIDE, PageBuffer, PageId};

/// Bytes that a reader holds besides a pixel's own four while it decodes imagery, as a multiple of these.
const DECODED_PIXEL: usize = 9;

/// Everything that all pages of level 1 are made from.
pub(super) struct Project<'a> {
    pub grid: Grid,
    pub code: HeightCode,
    pub tint: Tint,
    pub fill: NodataFill,
    pub elevation: &'a [ElevationInput],
    pub surveys: &'a [Survey],
    pub imagery: &'a [ImageryInput],
    /// Largest window of samples, bytes.
    pub window_bytes: usize,
}

/// A finished page and what is in it.
pub(super) struct Made {
    pub page: EncodedPage,
    pub census: Census,
}

/// Counts over voxels of level 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Census {
    pub voxels: u64,
    /// Their source had no data.
    pub voids: u64,
    /// They have no surface.
    pub empty: u64,
    /// They have a surface, but no colour from imagery.
    pub bare: u64,
    /// Least and greatest height code of those with a surface.
    pub codes: Option<(u16, u16)>,
}

impl Census {
    pub fn add(&mut self, other: &Self) {
        self.voxels += other.voxels;
        self.voids += other.voids;
        self.empty += other.empty;
        self.bare += other.bare;
        self.codes = match (self.codes, other.codes) {
            (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
            (a, b) => a.or(b),
        };
    }
}

/// Makes pages; one per worker.
pub(super) struct PageMaker<'a> {
    project: &'a Project<'a>,
    mosaic: Mosaic<'a>,
    drape: Drape<'a>,
}

/// The surface around a page after filling.
struct Ground {
    surface: Surface,
    /// Voxels that the sources left void.
    voids: Vec<bool>,
}

impl<'a> PageMaker<'a> {
    pub fn new(project: &'a Project<'a>) -> Self {
        let (grid, window_bytes) = (&project.grid, project.window_bytes);
        Self {
            project,
            mosaic: Mosaic { sources: project.elevation, grid, window_bytes, window: Vec::new() },
            drape: Drape {
                sources: project.imagery,
                grid,
                window_bytes: window_bytes / DECODED_PIXEL,
                window: Vec::new(),
            },
        }
    }

    /// The page of level 1 in column `px` and row `py`.
    pub fn make(&mut self, px: u32, py: u32) -> Result<Made> {
        let grid = &self.project.grid;
        let (x0, y0) = (px * PAGE_SIDE, py * PAGE_SIDE);
        let rect = Rect { x0, y0, x1: (x0 + PAGE_SIDE).min(grid.nx), y1: (y0 + PAGE_SIDE).min(grid.ny) };
        let ground = self.ground(rect.grown(APRON + 1, grid))?;
        let around = rect.grown(APRON, grid);
        let pigments = self.drape.pigments(around)?;
        let (heights, colours) = self.samples(rect, around, &ground, &pigments);
        let (attributes, census) = self.attributes(rect, around, &ground, &pigments);
        let buffer = PageBuffer {
            width: rect.x1 - rect.x0,
            height: rect.y1 - rect.y0,
            heights,
            low: Vec::new(),
            high: Vec::new(),
            colours,
            relief: Vec::new(),
            attributes,
        };
        Ok(Made { page: buffer.encode(PageId { level: 0, px, py }), census })
    }

    /// Mosaic and fill.
    fn ground(&mut self, rect: Rect) -> Result<Ground> {
        let mut surface = self.mosaic.surface(rect)?;
        let voids: Vec<bool> = (0..rect.len()).map(|voxel| surface.is_void(voxel)).collect();
        match self.project.fill {
            NodataFill::Value(height) => {
                for (voxel, _) in voids.iter().enumerate().filter(|(_, void)| **void) {
                    surface.heights[voxel] = height;
                }
            }
            NodataFill::Interpolate if voids.contains(&true) => {
                let wide = self.mosaic.surface(rect.grown(fill::REACH, &self.project.grid))?;
                for (voxel, _) in voids.iter().enumerate().filter(|(_, void)| **void) {
                    let (x, y) = rect.voxel(voxel);
                    let coarse = surface.source(voxel).and_then(|source| self.coarse(source, x, y));
                    surface.heights[voxel] = fill::interpolate(&wide, x, y, coarse);
                }
            }
            NodataFill::None | NodataFill::Interpolate => {}
        }
        Ok(Ground { surface, voids })
    }

    /// A source's coarse surface at a voxel, above the database's datum.
    fn coarse(&self, source: u16, x: u32, y: u32) -> Option<f64> {
        let input = self.project.elevation.get(usize::from(source))?;
        let coarse = self.project.surveys.get(usize::from(source))?.coarse.as_ref()?;
        let (east, north) = warp::world(&self.project.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (column, row) = input.placement.pixel_from_world(east, north)?;
        Some(coarse.at(column, row) + input.shift.at(x, y))
    }

    /// Height codes and colours with their apron.
    fn samples(
        &self,
        rect: Rect,
        around: Rect,
        ground: &Ground,
        pigments: &[Pigment],
    ) -> (Vec<u16>, Vec<[u8; 3]>) {
        let (mut heights, mut colours) = (Vec::new(), Vec::new());
        let clamped = |low: u32, high: u32, around_low: u32, around_high: u32| {
            let apron = i64::from(APRON);
            (i64::from(low) - apron..i64::from(high) + apron)
                .map(move |voxel| voxel.clamp(i64::from(around_low), i64::from(around_high) - 1) as u32)
        };
        for y in clamped(rect.y0, rect.y1, around.y0, around.y1) {
            for x in clamped(rect.x0, rect.x1, around.x0, around.x1) {
                let height = ground.surface.heights[ground.surface.rect.index(x, y)];
                heights.push(self.project.code.encode(height));
                let pigment = pigments[around.index(x, y)];
                let bare = 1.0 - pigment.alpha;
                let tint = if bare > 0.0 { self.tint(ground, x, y) } else { [0.0; 3] };
                colours.push(std::array::from_fn(|c| srgb8_from_linear(pigment.linear[c] + bare * tint[c])));
            }
        }
        (heights, colours)
    }

    fn tint(&self, ground: &Ground, x: u32, y: u32) -> [f32; 3] {
        let surface = &ground.surface;
        let height = |x: u32, y: u32| surface.heights[surface.rect.index(x, y)];
        let here = height(x, y);
        let rect = surface.rect;
        let (west, east) = (x.saturating_sub(1).max(rect.x0), (x + 1).min(rect.x1 - 1));
        let (south, north) = (y.saturating_sub(1).max(rect.y0), (y + 1).min(rect.y1 - 1));
        // At rims of the surface and of the area there is one neighbour, or none.
        let rise = |low: f64, high: f64, steps: u32| {
            let rise = high - low;
            if rise.is_nan() || steps == 0 {
                0.0
            } else {
                rise / (f64::from(steps) * self.project.grid.spacing)
            }
        };
        let slope = rise(height(west, y), height(east, y), east - west).hypot(rise(
            height(x, south),
            height(x, north),
            north - south,
        ));
        self.project.tint.colour(here, slope)
    }

    fn attributes(
        &self,
        rect: Rect,
        around: Rect,
        ground: &Ground,
        pigments: &[Pigment],
    ) -> (Vec<Attributes>, Census) {
        let mut census = Census { voxels: rect.len() as u64, ..Census::default() };
        let attributes = (0..rect.len()).map(|voxel| {
            let (x, y) = rect.voxel(voxel);
            let at = ground.surface.rect.index(x, y);
            let code = self.project.code.encode(ground.surface.heights[at]);
            let empty = code == HeightCode::EMPTY;
            let pictured = pigments[around.index(x, y)].alpha >= 0.5;
            census.voids += u64::from(ground.voids[at]);
            census.empty += u64::from(empty);
            census.bare += u64::from(!empty && !pictured);
            if !empty {
                census.add(&Census { codes: Some((code, code)), ..Census::default() });
            }
            let void = if ground.voids[at] || empty { Attributes::VOID } else { 0 };
            let bare = if pictured { 0 } else { Attributes::NO_IMAGERY };
            let source = ground.surface.source(at).unwrap_or(0);
            Attributes { source, material: 0, flags: void | bare }
        });
        (attributes.collect(), census)
    }
}
