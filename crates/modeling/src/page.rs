//! Pages and blocks of voxels straight from the rasters, at any level.
//!
//! ```text
//! heights = the mosaic over the block and a voxel around it (slopes need that)
//! voids   = left empty | the fixed height | interpolated (over a wider mosaic, as far as the fill reaches)
//! ground  = changed by synthetic shapes
//! colours = imagery over the block, on top of the palette or the tint by height and slope; textures, water, features and patches over it
//! ```
//! Every sample depends on its place in the grid alone, never on the page: aprons equal the neighbours' voxels.

mod painting;

use std::collections::HashMap;
use std::ops::Range;

use super::cloud::CloudSolids;
use super::corridor::Stored;
use super::counts::PageCounts;
use super::drape::Drape;
use super::feather::Sheets;
use super::feature_solids::FeatureSolids;
use super::land_cover::{CoverInput, LandCover, Sampler};
use super::materials::Materials;
use super::mosaic::{Mosaic, Surface};
use super::object::{ObjectGround, Objects};
use super::options::{Interpolation, NodataFill};
use super::placed::{ElevationInput, ImageryInput};
use super::placing::{Placed, Raised, covered, on_page};
use super::synthetic::{self, Synthetic};
use super::tint::Tint;
use super::warp::{self, LevelGrid, Rect};
use crate::built::{Built, Tiles};
use crate::natural::{NaturalBlock, NaturalGround};
use crate::survey_result::Survey;
use crate::void_fill;
use hedgehop::voxel::{
    APRON, Attributes, Grid, HeightCode, Material, PAGE_SIDE, PageBuffer, PageId, Placement, RADIX,
    SharedObjects, Span, SpanTable, StandIn, VoxelBlock,
};
use hedgehop_base::Size;
use hedgehop_base::error::Result;

/// Bytes that a reader holds besides a pixel's own four while it decodes imagery, as a multiple of these.
const DECODED_PIXEL: usize = 9;

/// Everything that all pages are made from.
pub(super) struct Project<'a> {
    pub grid: Grid,
    pub stored: &'a Stored,
    pub code: HeightCode,
    pub tint: Tint,
    pub fill: NodataFill,
    pub elevation: &'a [ElevationInput],
    pub surveys: &'a [Survey],
    pub imagery: &'a [ImageryInput],
    pub land_cover: &'a [CoverInput],
    pub materials: &'a Materials,
    pub synthetic: &'a Synthetic,
    pub interpolation: Interpolation,
    /// `None`: nothing stands or lies on the ground.
    pub feature_solids: Option<&'a FeatureSolids>,
    /// The same for what point clouds show.
    pub cloud_solids: Option<&'a CloudSolids>,
    /// The same for models.
    pub objects: Option<&'a Objects>,
    /// Objects that stand in many places.
    pub shared: &'a SharedObjects,
    /// Largest window of samples, bytes.
    pub window_bytes: usize,
}

/// Makes pages and blocks of any level straight from the rasters; one per worker.
pub(super) struct PageMaker<'a> {
    project: &'a Project<'a>,
    level: LevelGrid,
    mosaic: Mosaic<'a>,
    drape: Drape<'a>,
    cover: Sampler<'a>,
    /// Natural ground that features were bound to.
    pub tiles: Tiles,
}

/// The surface around a block after filling.
struct PageGround {
    surface: Surface,
    /// Voxels that the sources left void.
    voids: Vec<bool>,
}

/// A block of voxels, and which of them the sources left void.
struct MadeBlock {
    voxels: VoxelBlock,
    voids: Vec<bool>,
    /// Bare ground, where something stands on it.
    bare: Option<Bare>,
}

/// The bare ground of a block, and what stands on its voxels.
struct Bare {
    heights: Vec<u16>,
    colours: Vec<[u8; 3]>,
    attributes: Vec<Attributes>,
    /// Spans of each voxel, lowest first.
    spans: HashMap<usize, Vec<Span>>,
    /// Objects that may reach it.
    placed: Vec<Placed>,
}

/// A page, that of bare ground under it if there is one, and counts over its voxels.
pub(super) struct MadePage {
    pub page: PageBuffer,
    pub bare: Option<PageBuffer>,
    pub counts: PageCounts,
}

impl NaturalGround for PageMaker<'_> {
    fn code(&self) -> HeightCode {
        self.project.code
    }

    fn grid(&self) -> Grid {
        self.project.grid
    }

    fn natural(&mut self, rect: Rect) -> Result<Vec<f64>> {
        let level = self.level.level;
        self.turn_to(0);
        let ground = self.ground(rect);
        self.turn_to(level);
        Ok(ground?.surface.heights)
    }

    fn tiles(&mut self) -> &mut Tiles {
        &mut self.tiles
    }
}

impl<'a> PageMaker<'a> {
    pub fn new(project: &'a Project<'a>) -> Self {
        let window_bytes = project.window_bytes;
        let level = LevelGrid::of(&project.grid, 0);
        let elevation = project.elevation.iter().map(|source| (&source.placement, source.samples.size()));
        let imagery = project.imagery.iter().map(|source| (&source.placement, source.samples.size()));

        Self {
            project,
            level,
            mosaic: Mosaic {
                sources: project.elevation,
                surveys: project.surveys,
                sheets: Sheets::of(elevation, &project.grid),
                interpolation: project.interpolation,
                detail: project.synthetic.detail,
                level,
                window_bytes,
                window: Vec::new(),
            },
            drape: Drape {
                sources: project.imagery,
                sheets: Sheets::of(imagery, &project.grid),
                level,
                window_bytes: window_bytes / DECODED_PIXEL,
                window: Vec::new(),
            },
            cover: Sampler {
                sources: project.land_cover,
                materials: project.materials,
                grid: project.grid,
                window_bytes,
                window: Vec::new(),
            },
            tiles: Tiles::default(),
        }
    }

    /// A page as if there were no finer level, without bounds and slopes.
    pub fn make(&mut self, id: PageId) -> Result<MadePage> {
        self.turn_to(id.level);
        let size = self.project.grid.page_size(id).unwrap_or_default();
        let Size { width, height } = size;
        let (x0, y0) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let rect = Rect { x0, y0, x1: x0 + width, y1: y0 + height };
        let around = rect.grown(APRON, &self.level.grid);
        if self.is_beyond(around) {
            return Ok(MadePage::empty(id, size));
        }

        let made = self.block(around)?;
        let rows = rect.rows_in(around);
        let counts = made.counts(rows.clone());

        let page = |heights: &[u16], colours: &[[u8; 3]], attributes: &[Attributes], spans: SpanTable| {
            let (low, high, relief) = Default::default();
            let (heights, colours) = (with_apron(heights, around, rect), with_apron(colours, around, rect));
            let attributes = rows.clone().map(|row| &attributes[row]).collect::<Vec<_>>().concat();
            PageBuffer { width, height, heights, low, high, colours, relief, attributes, spans }
        };

        let bare = made.bare.as_ref().map(|bare| {
            let rise = SpanTable::rise(self.project.code, self.project.grid.spacing);
            let spans = SpanTable::new(size, rise, |x, y, spans| {
                spans.extend(bare.spans.get(&around.index(rect.x0 + x, rect.y0 + y)).into_iter().flatten());
            });
            let placements: Vec<Placement> =
                bare.placed.iter().filter_map(|placed| on_page(placed, rect)).collect();
            let spans = spans.with_objects(size, self.project.shared, &placements);
            page(&bare.heights, &bare.colours, &bare.attributes, spans)
        });

        let VoxelBlock { heights, colours, attributes, .. } = &made.voxels;
        let page = page(heights, colours, attributes, SpanTable::default());

        // Where only a road was cut in, bare ground is the surface.
        let bare = bare.filter(|bare| *bare != page);
        Ok(MadePage { page, bare, counts })
    }

    /// Whether nothing reaches a block: it has no surface, and its voxels are all alike.
    fn is_beyond(&self, rect: Rect) -> bool {
        let Project {
            elevation, imagery, land_cover, synthetic, feature_solids, cloud_solids, objects, ..
        } = self.project;
        let level = &self.level;
        // As far as slopes ask.
        let wide = rect.grown(1, &level.grid);
        let mut reaches = elevation
            .iter()
            .map(|source| &source.reach)
            .chain(imagery.iter().map(|source| &source.reach))
            .chain(land_cover.iter().map(|source| &source.reach));
        **synthetic == Synthetic::default()
            && cloud_solids.is_none()
            && feature_solids.is_none_or(|feature_solids| feature_solids.margin(wide, level).is_none())
            && objects.is_none_or(|objects| objects.margin(wide, level).is_none())
            && !reaches.any(|reach| wide.meets(reach, &level.grid))
    }

    /// Raises features and clouds on a block with this natural ground; `None`: none reaches it.
    fn built(&mut self, rect: Rect, natural: &[f64]) -> Result<Option<Built>> {
        let mut built = self.features(rect)?;
        let materials = self.project.materials;
        if let Some(built) = &mut built {
            materials.dress(&mut built.solids);
        }

        if let Some(cloud_solids) = self.project.cloud_solids {
            let mut solids = cloud_solids.solids(rect, &self.level)?;
            if !cloud_solids.is_coloured {
                materials.dress(&mut solids);
            }
            if !solids.is_empty() {
                let built = built.get_or_insert_with(|| Built::on(natural));
                let first = built.solids.len();
                built.solids.extend(solids);
                built.uncoloured = first..if cloud_solids.is_coloured { first } else { built.solids.len() };
            }
        }

        let (mut solids, placed) = self.objects(rect)?;
        materials.dress(&mut solids);
        if !(solids.is_empty() && placed.is_empty()) {
            let built = built.get_or_insert_with(|| Built::on(natural));
            built.solids.extend(solids);
            built.placed.extend(placed);
        }

        Ok(built)
    }

    /// Solids of models over a block, and those models that are placed.
    fn objects(&mut self, rect: Rect) -> Result<Raised> {
        let Some(objects) = self.project.objects else { return Ok(Default::default()) };
        let Some(margin) = objects.margin(rect, &self.level) else { return Ok(Default::default()) };
        let wide = rect.grown(margin, &self.level.grid);
        let natural = self.ground(wide)?.surface.heights;
        let mut changed = vec![false; wide.len()];
        let mut materials = Vec::new();
        let (avoids, asks) = (objects.avoid_features(), objects.ask_for_materials());
        let built = if avoids || asks { self.features(wide)? } else { None };

        if avoids || asks {
            let covers = self.cover.over(wide, self.level.level)?;
            let is_water = |cover: &LandCover| cover.material == Material::Water.code();
            changed.iter_mut().zip(&covers).for_each(|(changed, cover)| *changed = avoids && is_water(cover));
            if asks {
                materials = self.materials(wide, &covers, built.as_ref());
            }
        }

        if avoids {
            for (index, ..) in self.project.synthetic.water(&self.level, wide) {
                changed[index] = true;
            }
            for voxel in self.project.synthetic.painted(&self.level, wide) {
                let patch = &self.project.synthetic.patches[voxel.patch];
                changed[voxel.index] |= patch.material == Some(Material::Water) && voxel.share >= 0.5;
            }
        }

        if avoids && let Some(built) = built {
            let painted = built.paints.iter().map(|(index, ..)| *index);
            painted
                .chain(built.solids.iter().map(|placed| placed.voxel))
                .for_each(|index| changed[index] = true);
            for placed in &built.placed {
                let Some(object) = self.project.shared.get(placed.1) else { continue };
                let stands = |(index, mut spans): (usize, _)| Iterator::next(&mut spans).map(|_: Span| index);
                covered(placed, object, wide).filter_map(stands).for_each(|index| changed[index] = true);
            }
        }

        let ground = ObjectGround {
            natural: NaturalBlock { rect: wide, heights: &natural },
            materials: &materials,
            features: &changed,
        };
        Ok(objects.solids(rect, ground, &self.level, &self.project.code))
    }

    /// Raises features on a block; `None`: none reaches it.
    fn features(&mut self, rect: Rect) -> Result<Option<Built>> {
        let Some(feature_solids) = self.project.feature_solids else { return Ok(None) };
        let Some(margin) = feature_solids.margin(rect, &self.level) else { return Ok(None) };
        let wide = rect.grown(margin, &self.level.grid);
        let natural = self.ground(wide)?.surface.heights;
        let level = self.level;
        feature_solids.build(rect, NaturalBlock { rect: wide, heights: &natural }, &level, self).map(Some)
    }

    /// Takes the grid of another level.
    fn turn_to(&mut self, level: u8) {
        self.level = LevelGrid::of(&self.project.grid, level);
        (self.mosaic.level, self.drape.level) = (self.level, self.level);
    }

    /// Voxels over `rect` of the level.
    fn block(&mut self, rect: Rect) -> Result<MadeBlock> {
        // Slopes need a voxel around.
        let around = rect.grown(1, &self.level.grid);
        let mut ground = self.ground(around)?;
        let mut built = self.built(around, &ground.surface.heights)?;
        if let Some(built) = &built {
            ground.surface.heights.clone_from(&built.ground);
        }

        let voxels = match self.copied(rect, &ground, built.is_some())? {
            Some(voxels) => voxels,
            None => self.draped(rect, &ground, built.as_mut())?,
        };
        let voids = rect.rows_in(around).map(|row| &ground.voids[row]).collect::<Vec<_>>().concat();
        let mut made = MadeBlock { voids, voxels, bare: None };
        for (at, share, colour) in self.project.synthetic.water(&self.level, rect) {
            let colour = self.project.materials.moved(Material::Water, colour);
            synthetic::flood(&mut made.voxels, at, share, colour);
        }

        if let Some(built) = &built {
            self.lay(&mut made, rect, built, around);
        }
        self.paint(&mut made.voxels, rect);
        if let Some(built) = &built {
            self.put(&mut made, rect, built, around);
        }

        Ok(made)
    }

    /// Mosaic and fill.
    fn ground(&mut self, rect: Rect) -> Result<PageGround> {
        let mut surface = self.mosaic.surface(rect)?;
        let voids = surface.voids();
        match self.project.fill {
            NodataFill::Value(height) => {
                for (voxel, _) in voids.iter().enumerate().filter(|(_, void)| **void) {
                    surface.heights[voxel] = height;
                }
            }
            NodataFill::Interpolate if voids.contains(&true) => {
                let wide = self.mosaic.surface(rect.grown(void_fill::REACH, &self.level.grid))?;
                for (voxel, _) in voids.iter().enumerate().filter(|(_, void)| **void) {
                    let (x, y) = rect.voxel(voxel);
                    let coarse = surface.source(voxel).and_then(|source| self.coarse(source, x, y));
                    surface.heights[voxel] = void_fill::interpolate(&wide, x, y, coarse);
                }
            }
            NodataFill::Small if void_fill::may_have_small(rect, &voids) => {
                let wide = self.mosaic.surface(rect.grown(void_fill::REACH, &self.level.grid))?;
                let small = void_fill::small(&wide, rect, &self.level);
                for (voxel, _) in small.iter().enumerate().filter(|(_, small)| **small) {
                    let (x, y) = rect.voxel(voxel);
                    surface.heights[voxel] = void_fill::interpolate(&wide, x, y, None);
                }
            }
            NodataFill::None | NodataFill::Small | NodataFill::Interpolate => {}
        }

        self.project.synthetic.shape(&self.level, rect, &mut surface.heights);
        Ok(PageGround { surface, voids })
    }

    /// A source's coarse surface at a voxel, above the database's datum.
    fn coarse(&self, source: u16, x: u32, y: u32) -> Option<f64> {
        let input = self.project.elevation.get(usize::from(source))?;
        let coarse = self.project.surveys.get(usize::from(source))?.coarse.as_ref()?;
        let (east, north) = warp::world(&self.level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (column, row) = input.placement.pixel_from_world(east, north)?;
        Some(coarse.at(column, row) + input.shift.at(self.level.units(x, y)))
    }
}

impl MadePage {
    /// A page that nothing reaches.
    fn empty(id: PageId, size: Size) -> Self {
        let attributes =
            Attributes { flags: Attributes::VOID | Attributes::NO_IMAGERY, ..Attributes::default() };
        let voxels = u64::from(size.width) * u64::from(size.height);
        let counts = PageCounts { voxels, made: voxels, empty: voxels, ..PageCounts::default() };
        // What is made of its level alone has neither bounds nor slopes.
        let page = PageBuffer::empty(PageId { level: 0, ..id }, size, attributes);
        Self { page, bare: None, counts }
    }
}

impl MadeBlock {
    /// Counts over voxels at places of the block.
    fn counts(&self, rows: impl Iterator<Item = Range<usize>>) -> PageCounts {
        let mut counts = PageCounts::default();
        for row in rows {
            for at in row {
                let code = self.voxels.heights[at];
                let (is_empty, is_bare) = (
                    code == HeightCode::EMPTY,
                    self.voxels.attributes[at].flags & Attributes::NO_IMAGERY != 0,
                );
                counts.made += 1;
                counts.voxels += 1;
                counts.voids += u64::from(self.voids[at]);
                counts.filled += u64::from(self.voids[at] && !is_empty);
                counts.empty += u64::from(is_empty);
                counts.bare += u64::from(!is_empty && is_bare);
            }
        }
        counts
    }
}

/// Samples of a rectangle with its apron, of those `around` it; beyond the area lies what lies at its edge.
fn with_apron<T: Copy>(samples: &[T], around: Rect, rect: Rect) -> Vec<T> {
    let missing = |apron: u32| (APRON - apron) as usize;
    let (west, east) = (missing(rect.x0 - around.x0), missing(around.x1 - rect.x1));
    let apron = i64::from(APRON);
    let mut all = Vec::with_capacity(samples.len());
    for y in i64::from(rect.y0) - apron..i64::from(rect.y1) + apron {
        let y = y.clamp(i64::from(around.y0), i64::from(around.y1) - 1) as u32;
        let row = &samples[around.index(around.x0, y)..][..around.width()];
        all.extend(std::iter::repeat_n(row[0], west));
        all.extend_from_slice(row);
        all.extend(std::iter::repeat_n(row[row.len() - 1], east));
    }
    all
}

/// Stands in for pages that are not stored.
pub(super) struct FromSources<'m, 'a> {
    pub maker: &'m mut PageMaker<'a>,
}

impl FromSources<'_, '_> {
    /// Whether some raster shows more of the ground of a page than the voxels of the next coarser level do.
    fn is_worth_making(&self, id: PageId) -> bool {
        let Project { grid, elevation, synthetic, .. } = self.maker.project;
        // Shapes and detail are as fine as one asks for.
        if !synthetic.terrain.is_empty() || synthetic.detail.is_some() {
            return true;
        }
        let level = LevelGrid::of(grid, id.level).grid;
        let Size { width, height } = grid.page_size(id).unwrap_or_default();
        let (x0, y0) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let rect = Rect { x0, y0, x1: x0 + width, y1: y0 + height };
        // A pixel that fills most of the coarser voxel tells nothing about slopes in it.
        let is_fine = |source: &&ElevationInput| source.pixel_side < 0.5 * f64::from(RADIX) * level.spacing;
        elevation.iter().filter(is_fine).any(|source| rect.meets(&source.reach, &level))
    }
}

impl StandIn for FromSources<'_, '_> {
    fn finer(&mut self, id: PageId, x: Range<u32>, y: Range<u32>) -> Result<Option<VoxelBlock>> {
        if !self.is_worth_making(id) {
            return Ok(None);
        }
        self.maker.turn_to(id.level);
        let rect = Rect { x0: x.start, y0: y.start, x1: x.end, y1: y.end };
        Ok(Some(self.maker.block(rect)?.voxels))
    }

    fn page(&mut self, id: PageId) -> Result<PageBuffer> {
        Ok(self.maker.make(id)?.page)
    }
}
