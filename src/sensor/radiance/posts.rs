//! Radiance of the posts of one stored page.

use std::ops::Range;

use super::facing::{Facing, VOID_WEIGHT};
use crate::detail::{DETAIL_MARGIN, DetailPosts};
use crate::sensor::VisualSensor;
use crate::sensor::radiance::part::{LIT, PostPart};
use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd};
use crate::sunlight::{SHADE_APRON, ShadePage};
use crate::voxel::{
    APRON, Header, HeightCode, PAGE_SIDE, PageId, PageView, RELIEF_APRON, Relief, ReliefLanes, half_steps_of,
};
use hedgehop_base::colour::linear_from_srgb8;

/// Numbers of lanes.
const NUMBERS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Red of posts without a surface: not light.
pub const VOID: f32 = -1.0;

/// Light on a page.
#[derive(Debug, Clone, Copy)]
pub struct PageLight<'s> {
    sensor: &'s VisualSensor,
    /// Sunlight on the page's posts; `None`: all of it.
    shade: Option<&'s ShadePage>,
}

impl<'s> PageLight<'s> {
    /// A sun that nothing hides.
    pub fn new(sensor: &'s VisualSensor) -> Self {
        Self { sensor, shade: None }
    }

    /// One that posts see a share of.
    #[must_use]
    pub fn with_shade(self, shade: Option<&'s ShadePage>) -> Self {
        Self { shade, ..self }
    }
}

// Shares of the sun are there for all posts that are lit.
const _: () = assert!(SHADE_APRON as usize == LIT);

// And so are colours that keep means.
const _: () = assert!(DETAIL_MARGIN == LIT);

/// Rows to write to, from the first lit post on; some lanes behind the last one are written too.
pub struct PostRows<'t> {
    /// Red, green and blue.
    pub light: [&'t mut [f32]; 3],
    /// Weight of each post: how much of it is seen.
    pub weights: &'t mut [f32],
    /// Share of each post's luminance that is the ground's and not that of snow.
    pub bare: &'t mut [f32],
}

/// A part of a page's posts under a lamp, and those around it. All that a post needs is in the page.
pub struct Posts<'a> {
    lamp: PageLight<'a>,
    /// The colours' linear values, as wet as the ground is.
    linear: [f32; 256],
    view: PageView<'a>,
    facing: Facing,
    /// Detail of the part's posts, whose colours keep means.
    pub detail: Option<&'a DetailPosts>,
    /// Slope of half a step of height from post to post.
    half_step: f32,
    /// First posts (eastward, northward) in the area, counted from the page's first with [`LIT`] around it, and those behind its
    /// last.
    inside: [Range<usize>; 2],
    /// Posts of the part, with [`LIT`] around it.
    pub part: [Range<usize>; 2],
    /// Posts that are in both.
    pub lit: [Range<usize>; 2],
    /// Whether the area begins, and ends, there.
    edges: [[bool; 2]; 2],
}

impl<'a> Posts<'a> {
    pub fn new(
        lamp: &PageLight<'a>,
        header: &Header,
        id: PageId,
        view: PageView<'a>,
        part: PostPart,
        facing: &Facing,
    ) -> Self {
        let half_step = (0.5 * header.heights.scale / header.grid.side(id.level)) as f32;
        let (nx, ny) = header.grid.dims(id.level);
        let axes = [(id.px, view.width, nx), (id.py, view.height, ny)];

        // The area may also end within the apron of a page that is not its last.
        let inside = axes.each(|(page, size, count)| {
            let first = (page * PAGE_SIDE) as usize;
            let end = size as usize + 2 * LIT;
            LIT.saturating_sub(first)..end.min(count as usize + LIT - first)
        });
        let edges = axes.each(|(page, size, count)| {
            let (first, lit) = ((page * PAGE_SIDE) as usize, size as usize + LIT);
            [first <= LIT, first + lit >= count as usize]
        });
        let part = [0, 1].each(|axis| {
            let (first, size) = (part.first[axis] as usize, part.size[axis] as usize);
            first..first + size + 2 * LIT
        });
        let lit = [0, 1].each(|axis: usize| {
            let (inside, part) = (&inside[axis], &part[axis]);
            inside.start.max(part.start)..inside.end.min(part.end)
        });
        let linear = std::array::from_fn(|code| lamp.sensor.wetted(linear_from_srgb8([code as u8; 3])[0]));

        Self { lamp: *lamp, linear, view, facing: *facing, detail: None, half_step, inside, part, lit, edges }
    }

    /// Writes what the lit posts of row `y` send, seen as `facing` says, with [`VOID`] where they have no surface. Whether there are such.
    #[inline(always)]
    pub fn row<V: Simd>(&self, simd: V, y: usize, target: PostRows<'_>) -> bool {
        let along = if self.is_last(1, y) { 2.0 * self.half_step } else { self.half_step };
        let PostRows { light: [red, green, blue], weights, bare } = target;
        let [zero, void] = [0.0, VOID].each(|value| simd.splat(value));
        let columns = self.lit[0].clone();
        let mut has_voids = false;

        for x in columns.clone().step_by(LANES) {
            let here = self.heights(simd, self.place([x, y], APRON));
            let none = here.eq(simd.splat_int(i32::from(HeightCode::EMPTY)));
            let slopes = self.slopes(simd, [x, y], here, along);
            let (light, weight) = self.light(simd, [x, y], slopes);
            let mut colour = self.linear(simd, [x, y]);
            if self.lamp.sensor.has_snow() {
                let share;
                (colour, share) = self.lamp.sensor.snowed(simd, slopes, colour);
                store(share, bare, x - columns.start);
            }

            let first = x - columns.start;
            store(void.select(none, colour[0] * light[0]), red, first);
            store(zero.select(none, colour[1] * light[1]), green, first);
            store(zero.select(none, colour[2] * light[2]), blue, first);
            store(simd.splat(VOID_WEIGHT).select(none, weight), weights, first);
            let lit = (columns.end - x).min(LANES);
            has_voids |= (none & simd.mask(u16::MAX >> (LANES - lit))).any();
        }

        has_voids
    }

    /// Whether snow may lie on them.
    pub fn has_snow(&self) -> bool {
        self.lamp.sensor.has_snow()
    }

    /// Whether the area ends at a post.
    #[inline(always)]
    fn is_last(&self, axis: usize, at: usize) -> bool {
        let ([first, last], inside) = (self.edges[axis], &self.inside[axis]);
        first && at == inside.start || last && at + 1 == inside.end
    }

    /// Place of a post in planes with an apron, [`LIT`] posts of which lie before the page's own.
    #[inline(always)]
    fn place(&self, [x, y]: [usize; 2], apron: u32) -> usize {
        let beyond = apron as usize - LIT;
        (y + beyond) * (self.view.width + 2 * apron) as usize + x + beyond
    }

    /// Height codes of sixteen posts from a place on.
    #[inline(always)]
    fn heights<V: Simd>(&self, simd: V, place: usize) -> V::I {
        simd.load_shorts(&from(self.view.heights, place))
    }

    /// Returns the sunlight on sixteen posts.
    #[inline(always)]
    fn sun<V: Simd>(&self, simd: V, [x, y]: [usize; 2]) -> V::F {
        let Some(shade) = self.lamp.shade else { return simd.splat(1.0) };
        let bytes: [u8; LANES] = from(&shade.shares, y * shade.stride + x);
        let mut shares = [0.0; LANES];
        for (lane, share) in shares.iter_mut().enumerate() {
            *share = f32::from(bytes[lane]);
        }
        simd.load(&shares) * simd.splat(1.0 / 255.0)
    }

    /// Linear colours of sixteen posts, as wet as they are.
    #[inline(always)]
    fn linear<V: Simd>(&self, simd: V, at: [usize; 2]) -> [V::F; 3] {
        if let Some(detail) = self.detail {
            let kept = detail.colours([0, 1].each(|axis: usize| at[axis] - self.part[axis].start));
            let mut colours = [simd.splat(0.0); 3];
            for (colour, kept) in colours.iter_mut().zip(kept) {
                *colour = self
                    .lamp
                    .sensor
                    .wetted_posts(simd, simd.load(kept.first_chunk().unwrap_or(&[0.0; LANES])));
            }
            return colours;
        }
        let bytes = from(bytemuck::cast_slice(self.view.colours), 3 * self.place(at, APRON));
        let codes = simd.load_triples(&bytes);
        let low = simd.splat_int(0xff);
        [codes & low, codes.shr::<8>() & low, codes.shr::<16>()].each(|code| simd.gather(&self.linear, code))
    }

    /// Slopes eastward and northward of the level's own heights, `along`: a northward half step's.
    #[inline(always)]
    fn slopes<V: Simd>(&self, simd: V, [x, y]: [usize; 2], here: V::I, along: f32) -> [V::F; 2] {
        // The apron repeats the area's last post: half the way, so twice the slope.
        let half_step = simd.splat(self.half_step);
        let mut across = half_step;
        for edge in [self.inside[0].start, self.inside[0].end - 1] {
            if self.is_last(0, edge) {
                let lane = simd.splat_int(edge as i32 - x as i32);
                across = (half_step + half_step).select(simd.load_ints(&NUMBERS).eq(lane), across);
            }
        }
        let (place, stride) = (self.place([x, y], APRON), (self.view.width + 2 * APRON) as usize);
        let [west, east, south, north] = [place - 1, place + 1, place - stride, place + stride].each(
            #[inline(always)]
            |place| self.heights(simd, place),
        );
        let eastward = half_steps_of(simd, here, west, east).to_float();
        let northward = half_steps_of(simd, here, south, north).to_float();
        [eastward * across, northward * simd.splat(along)]
    }

    /// Red, green and blue light on sixteen posts, whose own slopes are given, and how much of them is seen.
    #[inline(always)]
    fn light<V: Simd>(&self, simd: V, at: [usize; 2], own: [V::F; 2]) -> ([V::F; 3], V::F) {
        let ([alike, direct], weight) = self.lit(simd, at, own);
        let [red, green, blue] = self.lamp.sensor.daylight().beam().to_array();
        let light = |beam| direct * simd.splat(beam) + alike;
        ([light(red), light(green), light(blue)], weight)
    }

    /// The same light as [`Daylight::on_slopes`](crate::sunlight::Daylight::on_slopes) gives it.
    #[inline(always)]
    fn lit<V: Simd>(&self, simd: V, at: [usize; 2], own: [V::F; 2]) -> ([V::F; 2], V::F) {
        let (daylight, sun) = (self.lamp.sensor.daylight(), self.sun(simd, at));
        if self.view.relief.is_empty() {
            return (daylight.on_slopes(simd, own, sun), self.facing.weight(simd, own));
        }
        let first = size_of::<Relief>() * self.place(at, RELIEF_APRON);
        let relief = ReliefLanes::load(simd, &from(bytemuck::cast_slice(self.view.relief), first));
        let mean = relief.mean(own);
        let (mut sums, mut weights) = ([simd.splat(0.0); 2], simd.splat(0.0));
        for slopes in relief.slopes(mean) {
            let weight = self.facing.weight(simd, slopes);
            let light = daylight.on_slopes(simd, slopes, sun);
            sums = [sums[0] + weight * light[0], sums[1] + weight * light[1]];
            weights = weights + weight;
        }
        ([sums[0] / weights, sums[1] / weights], self.facing.weight(simd, mean))
    }
}

/// Reads as many elements of a plane as there are from an index on; beyond the plane's end they are 0.
#[inline(always)]
fn from<T: Copy + Default, const N: usize>(plane: &[T], start: usize) -> [T; N] {
    let rest = &plane[start..];
    rest.first_chunk().copied().unwrap_or_else(|| {
        let mut chunk = [T::default(); N];
        chunk[..rest.len()].copy_from_slice(rest);
        chunk
    })
}

#[inline(always)]
fn store<F: Floats>(lanes: F, target: &mut [f32], first: usize) {
    if let Some(target) = target[first..].first_chunk_mut() {
        lanes.store(target);
    }
}
