//! Voxels of a block: their colours and materials, and the surface of what stands on them.

use std::collections::HashMap;

use glam::DVec2;

use super::{Bare, MadeBlock, PageGround, PageMaker, Project};
use crate::built::{Built, DENSE};
use crate::cloud;
use crate::features::PlacedSolid;
use crate::land_cover::{self, LandCover};
use crate::placing::{Placed, covered};
use crate::synthetic::PaintedVoxel;
use crate::tint::mix;
use crate::warp::{self, Rect};
use hedgehop::voxel::{Attributes, HeightCode, Material, Span, VoxelBlock};
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_linear};
use hedgehop_base::error::Result;

impl PageMaker<'_> {
    /// Voxels over `rect` where their colours are those of pixels as they stand: what [`Self::draped`] comes to as well.
    pub(super) fn copied(
        &mut self,
        rect: Rect,
        ground: &PageGround,
        has_spans: bool,
    ) -> Result<Option<VoxelBlock>> {
        let Project { cloud_solids, synthetic, land_cover, .. } = self.project;
        let is_graded = synthetic.palette.as_ref().is_some_and(|palette| palette.over_imagery > 0.0);
        let has_own_colours =
            has_spans && cloud_solids.is_some() || !synthetic.textures.is_empty() || is_graded;
        if has_own_colours || !land_cover.is_empty() || synthetic.states_materials() {
            return Ok(None);
        }

        let Some(colours) = self.drape.pixels(rect)? else { return Ok(None) };
        let surface = &ground.surface;
        let mut heights = Vec::with_capacity(rect.len());
        let mut attributes = Vec::with_capacity(rect.len());
        let code = self.project.code;

        for row in rect.rows_in(surface.rect) {
            let first = heights.len();
            heights.extend(surface.heights[row.clone()].iter().map(|height| code.encode(*height)));
            let voids = ground.voids[row.clone()].iter().zip(&heights[first..]);
            let flags = voids.map(|(is_void, code)| match *is_void || *code == HeightCode::EMPTY {
                true => Attributes::VOID,
                false => 0,
            });
            let source = |at: usize| surface.source(at).unwrap_or(0);
            attributes.extend(row.zip(flags).map(|(at, flags)| Attributes {
                source: source(at),
                material: 0,
                flags,
            }));
        }

        Ok(Some(VoxelBlock { x: rect.x0..rect.x1, y: rect.y0..rect.y1, heights, colours, attributes }))
    }

    /// Voxels over `rect` with their colours from imagery, materials, palette and textures; what stands there gets colours from imagery if it has none.
    pub(super) fn draped(
        &mut self,
        rect: Rect,
        ground: &PageGround,
        built: Option<&mut Built>,
    ) -> Result<VoxelBlock> {
        let pigments = self.drape.pigments(rect)?;
        let covers = self.cover.over(rect, self.level.level)?;
        if let Some(built) = built {
            cloud::drape(&mut built.solids[built.uncoloured.clone()], |index| {
                let pigment = &pigments[within(rect, ground.surface.rect, index)?];
                let colour = pigment.linear.map(|linear| srgb8_from_linear(linear / pigment.alpha));
                (pigment.alpha >= 0.5).then_some(colour)
            });
        }

        let mut voxels = VoxelBlock {
            x: rect.x0..rect.x1,
            y: rect.y0..rect.y1,
            heights: Vec::with_capacity(rect.len()),
            colours: Vec::with_capacity(rect.len()),
            attributes: Vec::with_capacity(rect.len()),
        };

        for (voxel, (pigment, mapped)) in pigments.iter().zip(&covers).enumerate() {
            let (x, y) = rect.voxel(voxel);
            let at_world = warp::world(&self.level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let cover = &self.stated(mapped, at_world.into());
            let at = ground.surface.rect.index(x, y);
            let code = self.project.code.encode(ground.surface.heights[at]);
            let over = match &self.project.synthetic.palette {
                Some(palette) if cover.material != Material::Water.code() => palette.over_imagery as f32,
                _ => 0.0,
            };
            let bare = 1.0 - pigment.alpha * (1.0 - over);
            let tint = if bare > 0.0 { self.tint(ground, x, y) } else { [0.0; 3] };
            let side = self.level.grid.spacing;
            let is_known = cover.material > 0 && code != HeightCode::EMPTY;
            let ground_linear = match &self.project.synthetic.palette {
                None if is_known => land_cover::varied(cover, tint, at_world.into(), side),
                _ => tint,
            };
            let mut linear: [f32; 3] = std::array::from_fn(|channel| {
                pigment.linear[channel] * (1.0 - over) + bare * ground_linear[channel]
            });
            let material = if is_known { cover.material } else { 0 };
            let share = pigment.alpha * self.project.materials.tint(Material::of_code(material));
            if share > 0.0 {
                linear = mix(linear, cover.linear, share);
            }

            let linear = self.project.synthetic.textured(linear, pigment.alpha, at_world.into(), side);
            voxels.heights.push(code);
            voxels.colours.push(linear.map(srgb8_from_linear));
            let is_void = ground.voids[at] || code == HeightCode::EMPTY;
            let flags = [(is_void, Attributes::VOID), (pigment.alpha < 0.5, Attributes::NO_IMAGERY)];
            let flags = flags.iter().filter(|(is_set, _)| *is_set).fold(0, |flags, (_, flag)| flags | flag);
            let source = ground.surface.source(at).unwrap_or(0);
            voxels.attributes.push(Attributes { source, material, flags });
        }

        Ok(voxels)
    }

    /// Numbers of what bare ground over `rect` is made of, without what lies on it.
    pub(super) fn materials(&self, rect: Rect, covers: &[LandCover], built: Option<&Built>) -> Vec<u8> {
        let stated = |(voxel, mapped): (usize, &LandCover)| {
            let (x, y) = rect.voxel(voxel);
            let place = warp::world(&self.level.grid, f64::from(x) + 0.5, f64::from(y) + 0.5);
            self.stated(mapped, place.into()).material
        };
        let mut materials: Vec<u8> = covers.iter().enumerate().map(stated).collect();
        let natural = built.into_iter().flat_map(|built| &built.natural);
        natural
            .filter(|(.., share)| *share >= 0.5)
            .for_each(|(index, paint, _)| materials[*index] = paint.material.code());
        for voxel in self.project.synthetic.painted(&self.level, rect) {
            if let Some(material) = self.project.synthetic.patches[voxel.patch].material
                && voxel.share >= 0.5
            {
                materials[voxel.index] = material.code();
            }
        }
        materials
    }

    /// The cover at a place, as shapes and textures state it over what maps show.
    fn stated(&self, mapped: &LandCover, at: DVec2) -> LandCover {
        let known = Material::of_code(mapped.material);
        match self.project.synthetic.material(at, known) {
            material if material == known => *mapped,
            material => LandCover::of(material.code(), self.project.materials),
        }
    }

    /// Lays what is painted over `around` on the voxels of a block.
    pub(super) fn lay(&self, made: &mut MadeBlock, rect: Rect, built: &Built, around: Rect) {
        let inside = |index: usize| within(rect, around, index);
        let VoxelBlock { colours, attributes, .. } = &mut made.voxels;
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
                let cover =
                    LandCover { linear: own, ..LandCover::of(paint.material.code(), self.project.materials) };
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
            colours[at] = mix(under, over, *share as f32).map(srgb8_from_linear);
            if *share >= 0.5 {
                attributes[at].material = paint.material.code();
            }
        }
    }

    /// Paints patches on the voxels of a block.
    pub(super) fn paint(&self, voxels: &mut VoxelBlock, rect: Rect) {
        let Project { synthetic, materials, .. } = self.project;
        for PaintedVoxel { index, share, patch, coat } in synthetic.painted(&self.level, rect) {
            let patch = &synthetic.patches[patch];
            let own = match (patch.coats[coat].colour, patch.material) {
                (Some(colour), _) => linear_from_srgb8(colour),
                (None, Some(material)) => materials.linear(material),
                (None, None) => continue,
            };
            let under = linear_from_srgb8(voxels.colours[index]);
            voxels.colours[index] = mix(under, own, share * patch.strength).map(srgb8_from_linear);
            if share >= 0.5
                && let Some(material) = patch.material
            {
                voxels.attributes[index].material = material.code();
            }
        }
    }

    /// Puts what was built over `around` on the voxels of a block, whose heights are those of its bare ground.
    pub(super) fn put(&self, made: &mut MadeBlock, rect: Rect, built: &Built, around: Rect) {
        let Project { code, grid, .. } = self.project;
        let inside = |index: usize| within(rect, around, index);
        let VoxelBlock { heights, colours, attributes, .. } = &mut made.voxels;
        let mut spans: HashMap<usize, Vec<Span>> = HashMap::new();
        for PlacedSolid { voxel: index, solid } in &built.solids {
            if let Some(at) = inside(*index)
                && let Some(span) = solid.encode(code, grid.spacing)
            {
                spans.entry(at).or_default().push(span);
            }
        }

        if spans.is_empty() && built.placed.is_empty() {
            return;
        }

        spans.values_mut().for_each(|spans| spans.sort_by_key(|span| (span.low, span.high)));
        let bare = Bare {
            heights: heights.clone(),
            colours: colours.clone(),
            attributes: attributes.clone(),
            spans,
            placed: built.placed.clone(),
        };

        for (index, solid) in built.surfaces(around.len()).into_iter().enumerate() {
            if let (Some(at), Some(solid)) = (inside(index), solid) {
                heights[at] = code.encode(solid.high_m);
                colours[at] = solid.top;
                attributes[at].material = solid.material;
            }
        }

        for placed in &built.placed {
            self.top_off(&mut made.voxels, rect, placed);
        }
        made.bare = (self.level.level == 0).then_some(bare);
    }

    /// Makes an object the surface where it is the highest.
    fn top_off(&self, voxels: &mut VoxelBlock, rect: Rect, placed: &Placed) {
        let Some(object) = self.project.shared.get(placed.1) else { return };
        for (at, spans) in covered(placed, object, rect) {
            for span in spans {
                let is_surface =
                    span.holds_centre() && !span.is(Span::STRIP) && f64::from(span.opacity()) >= DENSE;
                if is_surface && span.high > voxels.heights[at] {
                    voxels.heights[at] = span.high;
                    voxels.colours[at] = span.top;
                    voxels.attributes[at].material = span.material;
                }
            }
        }
    }

    fn tint(&self, ground: &PageGround, x: u32, y: u32) -> [f32; 3] {
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
