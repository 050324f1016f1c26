//! One page's radiance.

use glam::Vec3;

use crate::colour::linear_from_srgb8;
use crate::error::Result;
use crate::raymarch::PageCursor;
use crate::sensor::VisualSensor;
use crate::voxel::{APRON, HeightCode, PageId, PageSource, PageView};

/// Radiance of the greatest code.
pub const BRIGHTEST: f32 = 2.25;
/// Greatest code of a channel.
pub const CODE_LIMIT: f32 = 1023.0;
/// Posts around the page that are computed with it: the half-resolution image's apron takes two.
const RING: i64 = 2;

/// An image of texels with an apron of one, rows from south to north.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// `red | green << 10 | blue << 20`, each the root of radiance.
    pub texels: Vec<u32>,
    /// Texels eastward and northward, without the apron.
    pub size: [i32; 2],
}

/// A page's radiance at its own and at half its resolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RadiancePage {
    /// Full, and half.
    pub images: [Image; 2],
}

/// Radiance of posts from −RING on.
struct Posts {
    radiance: Vec<Vec3>,
    size: [i64; 2],
}

impl Posts {
    fn at(&self, x: i64, y: i64) -> Vec3 {
        let x = (x + RING).clamp(0, self.size[0] + 2 * RING - 1);
        let y = (y + RING).clamp(0, self.size[1] + 2 * RING - 1);
        self.radiance[(y * (self.size[0] + 2 * RING) + x) as usize]
    }
}

impl RadiancePage {
    /// What the posts of a page send under `sensor`'s sun; `None` where the page is absent.
    pub fn bake<S: PageSource>(
        cursor: &mut PageCursor<'_, S>,
        source: &S,
        id: PageId,
        sensor: &VisualSensor,
    ) -> Result<Option<Self>> {
        let Some(view) = source.page(id)? else { return Ok(None) };
        let size = [i64::from(view.width), i64::from(view.height)];
        let heights = Heights::read(cursor, source, id, &view)?;
        let mut radiance = Vec::with_capacity(((size[0] + 2 * RING) * (size[1] + 2 * RING)) as usize);
        let spacing = source.header().grid.side(id.level) as f32;
        for y in -RING..size[1] + RING {
            for x in -RING..size[0] + RING {
                let colour = linear_from_srgb8(heights.colour(x, y));
                radiance.push(Vec3::from_array(colour) * sensor.light(heights.normal(x, y, spacing)));
            }
        }
        let posts = Posts { radiance, size };
        let full = image(size, |x, y| posts.at(x, y));
        let half = image(size.map(|side| (side + 1) / 2), |x, y| {
            let (x, y) = (2 * x, 2 * y);
            0.25 * (posts.at(x, y) + posts.at(x + 1, y) + posts.at(x, y + 1) + posts.at(x + 1, y + 1))
        });
        Ok(Some(Self { images: [full, half] }))
    }

    /// Bytes of the texels.
    pub fn bytes(&self) -> usize {
        self.images.iter().map(|image| size_of_val(image.texels.as_slice())).sum()
    }
}

fn image(size: [i64; 2], radiance: impl Fn(i64, i64) -> Vec3) -> Image {
    let mut texels = Vec::with_capacity(((size[0] + 2) * (size[1] + 2)) as usize);
    for y in -1..=size[1] {
        for x in -1..=size[0] {
            let root = (radiance(x, y) / BRIGHTEST).clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt);
            let [red, green, blue] = (root * CODE_LIMIT + 0.5).to_array().map(|code| code as u32);
            texels.push(red | green << 10 | blue << 20);
        }
    }
    Image { texels, size: size.map(|side| side as i32) }
}

/// Heights and colours of a page and of a ring around it.
struct Heights {
    /// Metres from posts −RING − 1 on; NaN where there is no surface.
    heights: Vec<f32>,
    /// From posts −RING on.
    colours: Vec<[u8; 3]>,
    /// Posts of the page, and the first and last post of the area, counted from the page's first.
    size: [i64; 2],
    area: [[i64; 2]; 2],
}

impl Heights {
    fn read<S: PageSource>(
        cursor: &mut PageCursor<'_, S>,
        source: &S,
        id: PageId,
        view: &PageView<'_>,
    ) -> Result<Self> {
        let size = [i64::from(view.width), i64::from(view.height)];
        let side = i64::from(crate::voxel::PAGE_SIDE);
        let first = [i64::from(id.px) * side, i64::from(id.py) * side];
        let dims = cursor.dims(id.level);
        let area = [[-first[0], -first[1]], [dims[0] - 1 - first[0], dims[1] - 1 - first[1]]];
        let row = size[0] + 2 * i64::from(APRON);
        let own = |x: i64, y: i64| ((y + 1) * row + x + 1) as usize;
        let code = source.header().heights;
        let inside = |x: i64, y: i64| (-1..=size[0]).contains(&x) && (-1..=size[1]).contains(&y);
        let mut heights = Vec::new();
        let mut colours = Vec::new();
        for y in -RING - 1..=size[1] + RING {
            for x in -RING - 1..=size[0] + RING {
                let height = if inside(x, y) {
                    decode(code, view.heights[own(x, y)])
                } else {
                    let cell = clamp([x, y], area);
                    let found = cursor.height(id.level, [first[0] + cell[0], first[1] + cell[1]])?;
                    found.flatten().map_or(f32::NAN, |height| (height - code.offset) as f32)
                };
                heights.push(height);
            }
        }
        for y in -RING..size[1] + RING {
            for x in -RING..size[0] + RING {
                colours.push(if inside(x, y) {
                    view.colours[own(x, y)]
                } else {
                    let cell = clamp([x, y], area);
                    let found = cursor.colour(id.level, [first[0] + cell[0], first[1] + cell[1]])?;
                    found.unwrap_or_default()
                });
            }
        }
        Ok(Self { heights, colours, size, area })
    }

    fn colour(&self, x: i64, y: i64) -> [u8; 3] {
        self.colours[((y + RING) * (self.size[0] + 2 * RING) + x + RING) as usize]
    }

    fn height(&self, x: i64, y: i64) -> f32 {
        let row = self.size[0] + 2 * RING + 2;
        self.heights[((y + RING + 1) * row + x + RING + 1) as usize]
    }

    /// Unit normal from central differences; one-sided beside what has no surface and at the area's edge.
    fn normal(&self, x: i64, y: i64, spacing: f32) -> Vec3 {
        let here = self.height(x, y);
        let slope = |axis: usize, behind: f32, ahead: f32| {
            let at = [x, y][axis];
            let (at_west, at_east) = (at <= self.area[0][axis], at >= self.area[1][axis]);
            let (behind, ahead) =
                (if at_west { f32::NAN } else { behind }, if at_east { f32::NAN } else { ahead });
            let slope = match (behind.is_nan(), ahead.is_nan()) {
                (false, false) => (ahead - behind) / 2.0,
                (true, false) => ahead - here,
                (false, true) => here - behind,
                (true, true) => 0.0,
            };
            if slope.is_nan() { 0.0 } else { slope / spacing }
        };
        let east = slope(0, self.height(x - 1, y), self.height(x + 1, y));
        let north = slope(1, self.height(x, y - 1), self.height(x, y + 1));
        Vec3::new(-east, -north, 1.0).normalize()
    }
}

fn decode(code: HeightCode, height: u16) -> f32 {
    if height == HeightCode::EMPTY { f32::NAN } else { f32::from(height) * code.scale as f32 }
}

fn clamp(cell: [i64; 2], area: [[i64; 2]; 2]) -> [i64; 2] {
    [0, 1].map(|axis| cell[axis].clamp(area[0][axis], area[1][axis]))
}
