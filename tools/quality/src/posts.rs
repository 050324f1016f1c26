//! Light of level 1: what its posts send, and between them.
//!
//! ```text
//! post:     radiance = colour × light on the post's normal      sensor::radiance, as the renderer bakes it
//! between:  bilinear in radiance                                as the renderer samples it
//! ```
//!
//! This is the database's light, not the renderer's choice of level: truth and one sample per pixel use it alike, so that
//! pictures are judged for where and how often they sample, not for what is sampled.

use glam::{DVec2, Vec3};

use hedgehop::Result;
use hedgehop::sensor::radiance::{Radiance, RadiancePages};
use hedgehop::voxel::{PAGE_SIDE, PageId, PageSource};

/// Greatest code of a channel, and the root of the radiance that it stands for.
const CODE_LIMIT: f32 = 1023.0;
const ROOT_OF_BRIGHTEST: f32 = 1.5;

/// Light of the posts of level 1.
pub struct PostLight<'a> {
    pages: RadiancePages<'a>,
    /// Pages of each level along x and y.
    dims: Vec<[i64; 2]>,
}

impl<'a> PostLight<'a> {
    /// Over a database, under the sun of `radiance`.
    pub fn new(source: &'a dyn PageSource, radiance: &'a Radiance) -> Self {
        let header = source.header();
        let dims = (0..header.level_count).map(|level| header.grid.page_dims(level));
        let dims = dims.map(|(x, y)| [i64::from(x), i64::from(y)]).collect();
        Self { pages: RadiancePages::new(source, radiance), dims }
    }

    /// Linear Rec. 709 at a place in units from the area's south-west corner; of the next coarser level where the page is
    /// absent, black where all are.
    pub fn at(&mut self, units: DVec2) -> Result<Vec3> {
        for level in 0..self.dims.len() as u8 {
            let post = units / 4.0_f64.powi(level.into()) - 0.5;
            let mut page = [0; 2];
            for axis in 0..2 {
                let index = (post[axis] / f64::from(PAGE_SIDE)).floor() as i64;
                page[axis] = index.clamp(0, self.dims[usize::from(level)][axis] - 1);
            }

            let [px, py] = page.map(|index| index as u32);
            let Some(image) = self.pages.page(PageId { level, px, py })? else { continue };
            let (mut cell, mut share) = ([0; 2], [0.0; 2]);
            for axis in 0..2 {
                let from_first = post[axis] - (page[axis] * i64::from(PAGE_SIDE)) as f64;
                let within = from_first.clamp(-0.5, f64::from(image.size[axis]) - 0.5);
                cell[axis] = within.floor() as i64;
                share[axis] = (within - within.floor()) as f32;
            }

            let texel = |east: i64, north: i64| {
                radiance(image.texel((cell[0] + east) as i32, (cell[1] + north) as i32))
            };
            let south = texel(0, 0).lerp(texel(1, 0), share[0]);
            let north = texel(0, 1).lerp(texel(1, 1), share[0]);
            return Ok(south.lerp(north, share[1]));
        }

        Ok(Vec3::ZERO)
    }
}

/// Radiance of a texel, whose codes are roots of it.
fn radiance(texel: u32) -> Vec3 {
    let codes = Vec3::new((texel & 0x3ff) as f32, (texel >> 10 & 0x3ff) as f32, (texel >> 20) as f32);
    let root = codes * (ROOT_OF_BRIGHTEST / CODE_LIMIT);
    root * root
}
