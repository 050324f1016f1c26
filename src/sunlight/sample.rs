//! Shares of the sun between posts.

use std::sync::Arc;

use glam::DVec2;

use super::shade::{SHADE_APRON, ShadePage, Shades};
use crate::voxel::{Grid, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::error::Result;

/// The page that was looked up last, and its shares; `None`: it is absent.
type Latest = Option<(PageId, Option<Arc<ShadePage>>)>;

/// Tells what share of the sun places see; looks a page up only when a place leaves the last one.
#[derive(Debug)]
pub struct ShadeSampler<'a> {
    shades: &'a Shades,
    /// Latest page of each level.
    latest: Vec<Latest>,
}

impl<'a> ShadeSampler<'a> {
    /// Nothing is looked up yet.
    pub fn new(shades: &'a Shades) -> Self {
        Self { shades, latest: Vec::new() }
    }

    /// Share of the sun, 0…1, at a place of a level (units), bilinear between its posts; where its page is absent that of the next coarser level,
    /// and all of it where the coarsest is.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn share(&mut self, source: &dyn PageSource, level: u8, units: DVec2) -> Result<f32> {
        let header = source.header();
        self.latest.resize(usize::from(header.level_count), None);
        for level in level..header.level_count {
            let (nx, ny) = header.grid.dims(level);
            let last = DVec2::new(f64::from(nx), f64::from(ny)) - 1.0;
            let post = (units / f64::from(Grid::side_units(level)) - 0.5).clamp(DVec2::ZERO, last);
            let [px, py] = post.to_array().map(|post| post as u32 / PAGE_SIDE);
            if let Some(page) = self.page(source, PageId { level, px, py })? {
                let first = DVec2::new(f64::from(px), f64::from(py)) * f64::from(PAGE_SIDE);
                return Ok(between(page, post - first + f64::from(SHADE_APRON)));
            }
        }
        Ok(1.0)
    }

    /// Share of the sun, 0…1, that comes to what stands over the finest voxel at a place (units); all of it where its page is absent.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn about(&mut self, source: &dyn PageSource, units: DVec2) -> Result<f32> {
        let header = source.header();
        self.latest.resize(usize::from(header.level_count), None);
        let (nx, ny) = header.grid.dims(0);
        let last = DVec2::new(f64::from(nx), f64::from(ny)) - 1.0;
        let [x, y] = units.floor().clamp(DVec2::ZERO, last).to_array().map(|at| at as u32);
        let page = self.page(source, PageId { level: 0, px: x / PAGE_SIDE, py: y / PAGE_SIDE })?;
        let post = [x, y].map(|at| (at % PAGE_SIDE + SHADE_APRON) as usize);
        Ok(page.map_or(1.0, |page| page.about(post)))
    }

    fn page(&mut self, source: &dyn PageSource, id: PageId) -> Result<Option<&ShadePage>> {
        let latest = &mut self.latest[usize::from(id.level)];
        if latest.as_ref().is_none_or(|(known, _)| *known != id) {
            *latest = Some((id, self.shades.page(source, id)?));
        }
        Ok(latest.as_ref().and_then(|(_, page)| page.as_deref()))
    }
}

/// Bilinear between posts.
fn between(page: &ShadePage, place: DVec2) -> f32 {
    let (index, share) = (place.floor(), place.fract().as_vec2());
    let first = index.y as usize * page.stride + index.x as usize;
    let row = |first: usize| {
        let [from, to] = [0, 1].map(|post| f32::from(page.shares[first + post]));
        from * (1.0 - share.x) + to * share.x
    };
    (row(first) * (1.0 - share.y) + row(first + page.stride) * share.y) / 255.0
}
