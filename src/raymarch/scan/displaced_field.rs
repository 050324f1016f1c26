//! Displaced ground about an eye: how far displacements reach at each post that planes may come to.
//!
//! ```text
//! window = posts that planes may come to before displacement ends
//! code   = reach of the post's material; 0 where its page is absent
//! ```

use glam::DVec3;

use super::PlaneGroup;
use super::displaced_pages::{DisplacedPages, PAGE_BITS, PostRect};
use crate::detail::Displacement;
use crate::simd::{Each, Floats, Ints, Simd};
use crate::voxel::PageSource;
use hedgehop_base::error::Result;
use hedgehop_texture::{CELLS_PER_VOXEL, SIDE};

/// Samples across a bump of the finest kind.
const SAMPLES_PER_BUMP: f64 = 2.0;

/// Displaced ground of one frame.
#[derive(Debug)]
pub struct DisplacedField<'d> {
    displacement: &'d Displacement,
    /// Level index of the ground that is displaced: the finest one, or bare ground.
    level: u8,
    /// First post of the window, eastward and northward, and posts of a row.
    first: [i64; 2],
    wide: i32,
    /// Posts that the window holds beyond its first, counted from there.
    last: [f32; 2],
    /// Codes of reaches, row by row, and metres per code.
    reaches: Vec<u16>,
    step: f32,
    /// Reach of all posts, metres, if they have the same.
    uniform: Option<f32>,
}

/// Sixteen planes over displaced ground.
#[derive(Clone, Copy)]
pub(super) struct DisplacedPlanes<'d, V: Simd> {
    simd: V,
    field: &'d DisplacedField<'d>,
    /// Units eastward and northward per unit of major distance, and the sum of their squares.
    way: [V::F; 2],
    squares: V::F,
    /// The eye, cells from a corner of the tile and posts from the window's first.
    cells: [f32; 2],
    posts: [f32; 2],
}

impl<'d> DisplacedField<'d> {
    /// Looks at the materials of some pages; `None`: none of them is displaced.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn new(
        source: &dyn PageSource,
        displacement: &'d Displacement,
        pages: &DisplacedPages,
    ) -> Result<Option<Self>> {
        if pages.ids().is_empty() {
            return Ok(None);
        }
        source.bring(pages.ids());

        let relief = displacement.relief();
        let step = relief.most() / f32::from(u16::MAX);
        let codes: [u16; 256] =
            std::array::from_fn(|class| (relief.reach(class as u8) / step).round() as u16);
        let window = &pages.window;
        let [wide, high] = window.size();
        // One more, so that the last post has one beside it.
        let mut reaches = vec![0; wide * high + 1];
        let mut ends = [u16::MAX, 0];
        for id in pages.ids() {
            let Some(view) = source.page(*id)? else {
                ends[0] = 0;
                continue;
            };
            let corner = [id.px, id.py].map(|index| i64::from(index) << PAGE_BITS);
            let last = [view.width, view.height].map(|side| i64::from(side) - 1);
            let page = PostRect { low: corner, high: [0, 1].map(|axis| corner[axis] + last[axis]) };
            let part = window.within(&page);
            for y in part.low[1]..=part.high[1] {
                let row = (y - window.low[1]) as usize * wide;
                for x in part.low[0]..=part.high[0] {
                    let attributes = view.attributes_at((x - corner[0]) as u32, (y - corner[1]) as u32);
                    let code = codes[usize::from(attributes.material)];
                    reaches[row + (x - window.low[0]) as usize] = code;
                    ends = [ends[0].min(code), ends[1].max(code)];
                }
            }
        }

        let [least, highest] = ends;
        Ok((highest > 0).then(|| Self {
            displacement,
            level: pages.level,
            first: window.low,
            wide: wide as i32,
            last: [wide, high].map(|side| side as f32 - 1.0),
            reaches,
            step,
            uniform: (least == highest).then(|| f32::from(highest) * step),
        }))
    }

    /// Bound of displacements at a major distance or beyond, metres.
    pub(super) fn bound(&self, distance: f64) -> f64 {
        // Ground distance is no less.
        self.displacement.bound(distance)
    }

    /// Major distance from which on nothing is displaced, units.
    pub(super) fn until(&self) -> f32 {
        self.displacement.until() as f32
    }

    /// Parts of the stretch between two lines that ends at a major distance (units).
    pub(super) fn parts(&self, distance: f32) -> i32 {
        (SAMPLES_PER_BUMP / self.displacement.grain(distance.into())).ceil() as i32
    }
}

impl<'d, V: Simd> DisplacedPlanes<'d, V> {
    /// Planes of a group from an eye (units, units, metres).
    #[inline(always)]
    pub fn new(simd: V, field: &'d DisplacedField<'d>, eye: DVec3, group: &PlaneGroup) -> Self {
        let minor = simd.load(&group.minor);
        let major = simd.splat(group.forward as f32);
        let cells = [eye.x, eye.y].each(|at| (at * CELLS_PER_VOXEL as f64).rem_euclid(SIDE as f64) as f32);
        let posts = [0, 1].each(|axis| (eye[axis] - 0.5 - field.first[axis] as f64) as f32);
        let way = if group.major == 0 { [major, minor] } else { [minor, major] };
        Self { simd, field, way, squares: minor.mul_add(minor, simd.splat(1.0)), cells, posts }
    }

    /// Level index of the ground that is displaced.
    #[inline(always)]
    pub fn level(&self) -> u8 {
        self.field.level
    }

    /// Displacements of the ground at a major distance, metres.
    #[inline(always)]
    pub fn heights(&self, at: V::F) -> V::F {
        let Self { simd, field, way, squares, cells, posts } = *self;
        let per_unit = simd.splat(CELLS_PER_VOXEL as f32);
        let places = [0, 1].each(
            #[inline(always)]
            |axis| way[axis].mul_add(at * per_unit, simd.splat(cells[axis])),
        );
        let shares = field.displacement.shares(simd, places, squares * at * at);
        if let Some(reach) = field.uniform {
            return shares * simd.splat(reach);
        }

        let zero = simd.splat(0.0);
        let [x, y] = [0, 1].each(
            #[inline(always)]
            |axis| way[axis].mul_add(at, simd.splat(posts[axis])).max(zero).min(simd.splat(field.last[axis])),
        );
        let (west, south) = (x.floor(), y.floor());
        let [south_pair, north_pair] = [0, 1].each(
            #[inline(always)]
            |up| {
                let last = simd.splat_int(field.last[1] as i32);
                let row = (south.to_int() + simd.splat_int(up)).min(last).mul(simd.splat_int(field.wide));
                simd.gather_pairs(&field.reaches, row + west.to_int())
            },
        );
        let [south_reach, north_reach] = [south_pair, north_pair].each(
            #[inline(always)]
            |pair| {
                let (low, high) = ((pair & simd.splat_int(0xffff)).to_float(), pair.shr::<16>().to_float());
                (high - low).mul_add(x - west, low)
            },
        );
        let reach = (north_reach - south_reach).mul_add(y - south, south_reach);
        shares * reach * simd.splat(field.step)
    }
}
