//! Spans above the ground, drawn before what planes see of it.

use glam::DVec3;

use super::plane_image::DepthsMut;
use super::renderer::Renderer;
use crate::frame::stage::{Cell, Scale, SpanPaint};
use crate::raymarch::SpanBand;
use crate::raymarch::scan::{
    KeptPlanes, MarchField, PlaneGroup, Profile, RowTable, SpanCoverage, SpanMarch, SpanScan,
};
use crate::sensor::ShadedFacets;
use crate::simd::{Isa, LANES};
use crate::weather::AtmosphereLanes;
use hedgehop_base::error::Result;

/// Puts what stands on the ground into rows that show it already; one per worker.
pub struct SpanRenderer<'a> {
    isa: Isa,
    eye: DVec3,
    march: SpanMarch<'a>,
    facets: ShadedFacets<'a>,
    cover: SpanCoverage,
}

/// A group of planes that have seen the ground.
pub struct SeenGroup<'s> {
    pub group: &'s PlaneGroup,
    pub profile: &'s Profile,
    /// Major distance up to which it is bare, units.
    pub bare_until: f64,
    /// Sizes of cells that what stands there is seen in.
    pub span_bands: &'s [SpanBand],
    pub field: MarchField,
    pub row_table: &'s RowTable,
    pub kept: &'s KeptPlanes,
    pub scale: Scale,
    pub air: &'s AtmosphereLanes,
    pub squares: &'s [f32; LANES],
}

impl<'a> SpanRenderer<'a> {
    /// Builds the drawing of spans for pictures from `eye` (units, units, metres); `None` where there are none.
    pub fn new(renderer: &'a Renderer<'_>, eye: DVec3) -> Option<Self> {
        let source = renderer.source;
        source.header().has_spans.then(|| Self {
            isa: renderer.isa,
            eye,
            march: SpanMarch::new(source, renderer.shared.blocks.lend()),
            facets: renderer.lit.facets.on(source, renderer.lit.radiance.shades()),
            cover: SpanCoverage::default(),
        })
    }

    /// Puts it into the rows that are filled, and their distances, if somebody asks for these.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn put(&mut self, seen: &SeenGroup<'_>, cells: &mut [Cell], depths: DepthsMut<'_>) -> Result<()> {
        let SeenGroup { group, profile, bare_until, span_bands, field, row_table, kept, scale, air, squares } =
            *seen;
        let scan = SpanScan {
            eye: self.eye,
            group,
            profile,
            until: bare_until,
            bands: span_bands,
            field,
            row_table,
            first: kept.first,
            rows: kept.filled.len(),
            has_depths: !depths.inverse.is_empty(),
        };
        self.march.see(self.isa, &scan, &mut self.facets, &mut self.cover)?;
        let DepthsMut { inverse, tilts } = depths;
        let cover = &self.cover;
        let solids =
            SpanPaint { row_table, first: kept.first, cells, scale, inverse, tilts, cover, air, squares };
        solids.put(self.isa);
        Ok(())
    }
}
