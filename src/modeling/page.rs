//! Pages and blocks of voxels straight from the rasters, at any level.
//!
//! ```text
//! heights = the mosaic over the block and a voxel around it (slopes need that)
//! voids   = left empty | the fixed height | interpolated (over a wider mosaic, as far as the fill reaches)
//! ground  = changed by synthetic shapes
//! colours = imagery over the block, on top of the palette or the tint by height and slope; textures and water over it
//! ```
//! Every sample depends on its place in the grid alone, never on the page: aprons equal the neighbours' voxels.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec2;

use super::census::Census;
use super::cloud::{self, Standees};
use super::corridor::Stored;
use super::drape::Drape;
use super::features::Solid;
use super::fill;
use super::land_cover::{self, Cover, CoverInput, Sampler};
use super::materials::Materials;
use super::mosaic::{Mosaic, Surface};
use super::object::Objects;
use super::options::{Interpolation, NodataFill};
use super::placed::{ElevationInput, ImageryInput};
use super::scan::Survey;
use super::standing::{Built, Standing, Tiles};
use super::synthetic::{self, Synthetic};
use super::tint::{Tint, mix};
use super::warp::{self, LevelGrid, Rect};
use crate::colour::{linear_from_srgb8, srgb8_from_linear};
use crate::error::Result;
use crate::voxel::{
    APRON, Attributes, Grid, HeightCode, Material, PAGE_SIDE, PageBuffer, PageId, RADIX, Span, SpanTable,
    StandIn, VoxelBlock,
};

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
    pub standing: Option<&'a Standing>,
    /// The same for what point clouds show.
    pub standees: Option<&'a Standees>,
    /// The same for models.
    pub objects: Option<&'a Objects>,
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
struct Ground {
    surface: Surface,
    /// Voxels that the sources left void.
    voids: Vec<bool>,
}

/// A block of voxels, and which of them the sources left void.
struct Made {
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
    /// Of each voxel, lowest first.
    spans: HashMap<usize, Vec<Span>>,
}

/// A page, that of bare ground under it if there is one, and counts over its voxels.
pub(super) struct MadePage {
    pub page: PageBuffer,
    pub bare: Option<PageBuffer>,
    pub census: Census,
}

impl<'a> PageMaker<'a> {
    pub fn new(project: &'a Project<'a>) -> Self {
        let window_bytes = project.window_bytes;
        let level = LevelGrid::of(&project.grid, 0);
        Self {
            project,
            level,
            mosaic: Mosaic {
                sources: project.elevation,
                surveys: project.surveys,
                interpolation: project.interpolation,
                detail: project.synthetic.detail,
                level,
                window_bytes,
                window: Vec::new(),
            },
            drape: Drape {
                sources: project.imagery,
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

    /// The grid of level 1.
    pub fn grid(&self) -> Grid {
        self.project.grid
    }

    /// A page as if there were no finer level, without bounds and slopes.
    pub fn make(&mut self, id: PageId) -> Result<MadePage> {
        self.turn_to(id.level);
        let (width, height) = self.project.grid.page_size(id).unwrap_or((0, 0));
        let (x0, y0) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let rect = Rect { x0, y0, x1: x0 + width, y1: y0 + height };
        let around = rect.grown(APRON, &self.level.grid);
        let made = self.block(around)?;
        let repeated = |low: u32, high: u32, around_low: u32, around_high: u32| {
            let apron = i64::from(APRON);
            (i64::from(low) - apron..i64::from(high) + apron)
                .map(move |voxel| voxel.clamp(i64::from(around_low), i64::from(around_high) - 1) as u32)
        };
        let rows = || repeated(rect.y0, rect.y1, around.y0, around.y1);
        let columns = || repeated(rect.x0, rect.x1, around.x0, around.x1);
        let with_apron: Vec<usize> =
            rows().flat_map(|y| columns().map(move |x| around.index(x, y))).collect();
        let own = (0..rect.len()).map(|voxel| rect.voxel(voxel)).map(|(x, y)| around.index(x, y));
        let census = made.census(own.clone());
        let page = |heights: &[u16], colours: &[[u8; 3]], attributes: &[Attributes], spans: SpanTable| {
            let (low, high, relief) = Default::default();
            let heights = with_apron.iter().map(|&at| heights[at]).collect();
            let colours = with_apron.iter().map(|&at| colours[at]).collect();
            let attributes = own.clone().map(|at| attributes[at]).collect();
            PageBuffer { width, height, heights, low, high, colours, relief, attributes, spans }
        };
        let bare = made.bare.as_ref().map(|bare| {
            let rise = SpanTable::rise(self.project.code, self.project.grid.spacing);
            let spans = SpanTable::new((width, height), rise, |x, y, spans| {
                spans.extend(bare.spans.get(&around.index(rect.x0 + x, rect.y0 + y)).into_iter().flatten());
            });
            page(&bare.heights, &bare.colours, &bare.attributes, spans)
        });
        let VoxelBlock { heights, colours, attributes, .. } = &made.voxels;
        let page = page(heights, colours, attributes, SpanTable::default());
        // Where only a road was cut in, bare ground is the surface.
        let bare = bare.filter(|bare| *bare != page);
        Ok(MadePage { page, bare, census })
    }

    /// Heights of the finest voxels over `rect` as the rasters have them, voids filled, metres; NaN where there is none.
    pub fn natural(&mut self, rect: Rect) -> Result<Vec<f64>> {
        let level = self.level.level;
        self.turn_to(0);
        let ground = self.ground(rect);
        self.turn_to(level);
        Ok(ground?.surface.heights)
    }

    /// What features and clouds make of a block with this natural ground; `None`: none reaches it.
    fn built(&mut self, rect: Rect, natural: &[f64]) -> Result<Option<Built>> {
        let mut built = self.features(rect)?;
        let materials = self.project.materials;
        if let Some(built) = &mut built {
            materials.dress(&mut built.solids);
        }
        if let Some(standees) = self.project.standees {
            let mut solids = standees.solids(rect, &self.level)?;
            if !standees.is_coloured {
                materials.dress(&mut solids);
            }
            if !solids.is_empty() {
                let built = built.get_or_insert_with(|| Built::on(natural));
                let first = built.solids.len();
                built.solids.extend(solids);
                built.uncoloured = first..if standees.is_coloured { first } else { built.solids.len() };
            }
        }
        let solids = self.objects(rect)?;
        if !solids.is_empty() {
            built.get_or_insert_with(|| Built::on(natural)).solids.extend(solids);
        }
        Ok(built)
    }

    /// Solids of models over a block.
    fn objects(&mut self, rect: Rect) -> Result<Vec<(usize, Solid)>> {
        let Some(objects) = self.project.objects else { return Ok(Vec::new()) };
        let Some(margin) = objects.margin(rect, &self.level) else { return Ok(Vec::new()) };
        let wide = rect.grown(margin, &self.level.grid);
        let natural = self.ground(wide)?.surface.heights;
        let mut changed = vec![false; wide.len()];
        if objects.avoid_features()
            && let Some(built) = self.features(wide)?
        {
            let painted = built.paints.iter().map(|(index, ..)| *index);
            painted
                .chain(built.solids.iter().map(|(index, _)| *index))
                .for_each(|index| changed[index] = true);
        }
        Ok(objects.solids(rect, (wide, &natural), &changed, &self.level))
    }

    /// What features make of a block; `None`: none reaches it.
    fn features(&mut self, rect: Rect) -> Result<Option<Built>> {
        let Some(standing) = self.project.standing else { return Ok(None) };
        let Some(margin) = standing.margin(rect, &self.level) else { return Ok(None) };
        let wide = rect.grown(margin, &self.level.grid);
        let natural = self.ground(wide)?.surface.heights;
        let level = self.level;
        standing.build(rect, (wide, &natural), &level, self).map(Some)
    }

    /// Takes the grid of another level.
    fn turn_to(&mut self, level: u8) {
        self.level = LevelGrid::of(&self.project.grid, level);
        (self.mosaic.level, self.drape.level) = (self.level, self.level);
    }

    /// Voxels over `rect` of the level.
    fn block(&mut self, rect: Rect) -> Result<Made> {
        // Slopes need a voxel around.
        let around = rect.grown(1, &self.level.grid);
        let mut ground = self.ground(around)?;
        let mut built = self.built(around, &ground.surface.heights)?;
        if let Some(built) = &built {
            ground.surface.heights.clone_from(&built.ground);
        }
        let pigments = self.drape.pigments(rect)?;
        let covers = self.cover.over(rect, self.level.level)?;
        if let Some(built) = &mut built {
            cloud::drape(&mut built.solids[built.uncoloured.clone()], |index| {
                let pigment = &pigments[within(rect, around, index)?];
                let colour = pigment.linear.map(|linear| srgb8_from_linear(linear / pigment.alpha));
                (pigment.alpha >= 0.5).then_some(colour)
            });
        }
        let mut made = Made {
            voxels: VoxelBlock {
                x: rect.x0..rect.x1,
                y: rect.y0..rect.y1,
                heights: Vec::with_capacity(rect.len()),
                colours: Vec::with_capacity(rect.len()),
                attributes: Vec::with_capacity(rect.len()),
            },
            voids: Vec::with_capacity(rect.len()),
            bare: None,
        };
        for (voxel, (pigment, mapped)) in pigments.iter().zip(&covers).enumerate() {
            let (x, y) = rect.voxel(voxel);
            let at_world = warp::world(&self.level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let cover = &self.stated(mapped, at_world.into());
            let at = ground.surface.rect.index(x, y);
            let code = self.project.code.encode(ground.surface.heights[at]);
            let bare = 1.0 - pigment.alpha;
            let tint = if bare > 0.0 { self.tint(&ground, x, y) } else { [0.0; 3] };
            let side = self.level.grid.spacing;
            let is_known = cover.material > 0 && code != HeightCode::EMPTY;
            let ground_linear = match &self.project.synthetic.palette {
                None if is_known => land_cover::varied(cover, tint, at_world.into(), side),
                _ => tint,
            };
            let mut linear: [f32; 3] =
                std::array::from_fn(|channel| pigment.linear[channel] + bare * ground_linear[channel]);
            let material = if is_known { cover.material } else { 0 };
            let share = pigment.alpha * self.project.materials.tint(Material::of_code(material));
            if share > 0.0 {
                linear = mix(linear, cover.linear, share);
            }
            let linear = self.project.synthetic.textured(linear, pigment.alpha, at_world.into(), side);
            made.voxels.heights.push(code);
            made.voxels.colours.push(linear.map(srgb8_from_linear));
            let is_void = ground.voids[at] || code == HeightCode::EMPTY;
            let flags = [(is_void, Attributes::VOID), (pigment.alpha < 0.5, Attributes::NO_IMAGERY)];
            let flags = flags.iter().filter(|(is_set, _)| *is_set).fold(0, |flags, (_, flag)| flags | flag);
            let source = ground.surface.source(at).unwrap_or(0);
            made.voxels.attributes.push(Attributes { source, material, flags });
            made.voids.push(ground.voids[at]);
        }
        for (at, share, colour) in self.project.synthetic.water(&self.level, rect) {
            let colour = self.project.materials.moved(Material::Water, colour);
            synthetic::flood(&mut made.voxels, at, share, colour);
        }
        if let Some(built) = &built {
            self.put(&mut made, rect, (around, built));
        }
        Ok(made)
    }

    /// The cover at a place, as shapes and textures state it over what maps show.
    fn stated(&self, mapped: &Cover, at: DVec2) -> Cover {
        let known = Material::of_code(mapped.material);
        match self.project.synthetic.material(at, known) {
            material if material == known => *mapped,
            material => Cover::of(material.code(), self.project.materials),
        }
    }

    /// Puts what was built over `around` on the voxels of a block, whose heights are those of its bare ground.
    fn put(&self, made: &mut Made, rect: Rect, (around, built): (Rect, &Built)) {
        let Project { code, grid, .. } = self.project;
        let inside = |index: usize| within(rect, around, index);
        let VoxelBlock { heights, colours, attributes, .. } = &mut made.voxels;
        for (index, paint, share) in &built.natural {
            let Some(at) = inside(*index) else { continue };
            let (x, y) = rect.voxel(at);
            let place = warp::world(&self.level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let own = linear_from_srgb8(self.project.materials.moved(paint.material, paint.colour));
            let under = linear_from_srgb8(colours[at]);
            let is_bare = attributes[at].flags & Attributes::NO_IMAGERY != 0;
            if *share >= 0.5 {
                attributes[at].material = paint.material.code();
            }
            let (over, share) = if is_bare {
                let cover = Cover { linear: own, ..Cover::of(paint.material.code(), self.project.materials) };
                (land_cover::varied(&cover, under, place.into(), self.level.grid.spacing), *share)
            } else {
                (own, *share * f64::from(self.project.materials.tint(paint.material)))
            };
            colours[at] = mix(under, over, share as f32).map(srgb8_from_linear);
        }
        for (index, paint, share) in &built.paints {
            let Some(at) = inside(*index) else { continue };
            let colour = self.project.materials.moved(paint.material, paint.colour);
            let (under, over) = (linear_from_srgb8(colours[at]), linear_from_srgb8(colour));
            let mixed = |channel: usize| under[channel] + (over[channel] - under[channel]) * *share as f32;
            colours[at] = std::array::from_fn(|channel| srgb8_from_linear(mixed(channel)));
            if *share >= 0.5 {
                attributes[at].material = paint.material.code();
            }
        }
        let mut spans: HashMap<usize, Vec<Span>> = HashMap::new();
        for (index, solid) in &built.solids {
            if let Some(at) = inside(*index)
                && let Some(span) = solid.encode(code, grid.spacing)
            {
                spans.entry(at).or_default().push(span);
            }
        }
        if spans.is_empty() {
            return;
        }
        spans.values_mut().for_each(|spans| spans.sort_by_key(|span| (span.low, span.high)));
        let bare = Bare {
            heights: heights.clone(),
            colours: colours.clone(),
            attributes: attributes.clone(),
            spans,
        };
        for (index, solid) in built.surfaces(around.len()).into_iter().enumerate() {
            if let (Some(at), Some(solid)) = (inside(index), solid) {
                heights[at] = code.encode(solid.high_m);
                colours[at] = solid.top;
                attributes[at].material = solid.material;
            }
        }
        made.bare = (self.level.level == 0).then_some(bare);
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
                let wide = self.mosaic.surface(rect.grown(fill::REACH, &self.level.grid))?;
                for (voxel, _) in voids.iter().enumerate().filter(|(_, void)| **void) {
                    let (x, y) = rect.voxel(voxel);
                    let coarse = surface.source(voxel).and_then(|source| self.coarse(source, x, y));
                    surface.heights[voxel] = fill::interpolate(&wide, x, y, coarse);
                }
            }
            NodataFill::None | NodataFill::Interpolate => {}
        }
        self.project.synthetic.shape(&self.level, rect, &mut surface.heights);
        Ok(Ground { surface, voids })
    }

    /// A source's coarse surface at a voxel, above the database's datum.
    fn coarse(&self, source: u16, x: u32, y: u32) -> Option<f64> {
        let input = self.project.elevation.get(usize::from(source))?;
        let coarse = self.project.surveys.get(usize::from(source))?.coarse.as_ref()?;
        let (east, north) = warp::world(&self.level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (column, row) = input.placement.pixel_from_world(east, north)?;
        Some(coarse.at(column, row) + input.shift.at(self.level.units((x, y))))
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
                rise / (f64::from(steps) * self.level.grid.spacing)
            }
        };
        let slope = rise(height(west, y), height(east, y), east - west).hypot(rise(
            height(x, south),
            height(x, north),
            north - south,
        ));
        match &self.project.synthetic.palette {
            Some(palette) => palette.colour(here, slope),
            None => self.project.tint.colour(here, slope),
        }
    }
}

/// Index in `rect` of a voxel of `around`, if it lies there.
fn within(rect: Rect, around: Rect, index: usize) -> Option<usize> {
    let (x, y) = around.voxel(index);
    let is_in = (rect.x0..rect.x1).contains(&x) && (rect.y0..rect.y1).contains(&y);
    is_in.then(|| rect.index(x, y))
}

impl Made {
    /// Counts over voxels at places of the block.
    fn census(&self, voxels: impl Iterator<Item = usize>) -> Census {
        let mut census = Census::default();
        for at in voxels {
            let code = self.voxels.heights[at];
            let (is_empty, is_bare) =
                (code == HeightCode::EMPTY, self.voxels.attributes[at].flags & Attributes::NO_IMAGERY != 0);
            census.made += 1;
            census.voxels += 1;
            census.voids += u64::from(self.voids[at]);
            census.empty += u64::from(is_empty);
            census.bare += u64::from(!is_empty && is_bare);
        }
        census
    }
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
        let (width, height) = grid.page_size(id).unwrap_or((0, 0));
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
