//! What the posts of one stored page send.

use std::ops::Range;

use glam::Vec3;

use super::facing::{self, Facing, Slopes};
use super::page::Part;
use super::window::LIT;
use crate::colour::linear_from_srgb8;
use crate::sensor::VisualSensor;
use crate::voxel::{APRON, Header, HeightCode, PAGE_SIDE, PageId, PageView, RELIEF_APRON, half_steps};

/// Posts of a whole page's row that are lit, at most.
const SIDE: usize = PAGE_SIDE as usize + 2 * LIT;

/// Red of posts without a surface: not light.
pub const VOID: f32 = -1.0;

/// A sensor's light and the colours' linear values.
pub struct Lamp<'s> {
    sensor: &'s VisualSensor,
    linear: [f32; 256],
}

impl<'s> Lamp<'s> {
    pub fn new(sensor: &'s VisualSensor) -> Self {
        Self { sensor, linear: std::array::from_fn(|code| linear_from_srgb8([code as u8; 3])[0]) }
    }
}

/// Rows of the same length: red, green and blue, and slopes.
pub struct Rows<'t> {
    pub light: [&'t mut [f32]; 3],
    pub slopes: &'t mut [Slopes],
}

/// A part of a page's posts under a lamp, and those around it. All that a post needs is in the page.
pub struct Posts<'a> {
    lamp: &'a Lamp<'a>,
    view: PageView<'a>,
    facing: Facing,
    /// Slope of half a step of height from post to post.
    half_step: f32,
    /// First posts (eastward, northward) in the area, counted from the page's first with [`LIT`] around it, and those behind its
    /// last.
    inside: [Range<usize>; 2],
    /// Those of the part, with [`LIT`] around it.
    pub part: [Range<usize>; 2],
    /// Those that are in both.
    pub lit: [Range<usize>; 2],
    /// Whether the area begins, and ends, there.
    edges: [[bool; 2]; 2],
}

impl<'a> Posts<'a> {
    pub fn new(
        lamp: &'a Lamp<'a>,
        header: &Header,
        id: PageId,
        view: PageView<'a>,
        part: Part,
        facing: &Facing,
    ) -> Self {
        let half_step = (0.5 * header.heights.scale / header.grid.side(id.level)) as f32;
        let (nx, ny) = header.grid.dims(id.level);
        let axes = [(id.px, view.width, nx), (id.py, view.height, ny)];
        // The area may also end within the apron of a page that is not its last.
        let inside = axes.map(|(page, size, count)| {
            let first = (page * PAGE_SIDE) as usize;
            let end = size as usize + 2 * LIT;
            LIT.saturating_sub(first)..end.min(count as usize + LIT - first)
        });
        let edges = axes.map(|(page, size, count)| {
            let (first, lit) = ((page * PAGE_SIDE) as usize, size as usize + LIT);
            [first <= LIT, first + lit >= count as usize]
        });
        let part = [0, 1].map(|axis| {
            let (first, size) = (part.first[axis] as usize, part.size[axis] as usize);
            first..first + size + 2 * LIT
        });
        let lit = [0, 1].map(|axis: usize| {
            let (inside, part) = (&inside[axis], &part[axis]);
            inside.start.max(part.start)..inside.end.min(part.end)
        });
        Self { lamp, view, facing: *facing, half_step, inside, part, lit, edges }
    }

    /// Radiance of the lit posts of row `y`, seen as `facing` says; [`VOID`] where they have no surface.
    #[inline(always)]
    pub fn row(&self, y: usize, target: Rows<'_>) {
        let columns = self.lit[0].clone();
        let count = columns.len();
        let mut own = [[0.0; 2]; SIDE];
        self.slopes(y, &mut own);
        let mut light = [0.0; SIDE];
        let sensor = self.lamp.sensor;
        if self.view.relief.is_empty() {
            for ((light, slopes), own) in light.iter_mut().zip(&mut *target.slopes).zip(&own[..count]) {
                *light = light_on_slope(sensor, *own);
                *slopes = facing::encode(*own);
            }
        } else {
            let beyond = RELIEF_APRON as usize - LIT;
            let stride = self.view.width as usize + 2 * RELIEF_APRON as usize;
            let relief = &self.view.relief[(y + beyond) * stride + columns.start + beyond..][..count];
            let posts = relief.iter().zip(&own[..count]);
            for ((light, slopes), (relief, own)) in light.iter_mut().zip(&mut *target.slopes).zip(posts) {
                let (mut sum, mut weights) = (0.0, 0.0);
                for slopes in relief.slopes(*own) {
                    let weight = self.facing.weight_of(slopes);
                    sum += weight * light_on_slope(sensor, slopes);
                    weights += weight;
                }
                *light = sum / weights;
                *slopes = facing::encode(relief.mean(*own));
            }
        }
        let linear = &self.lamp.linear;
        let [red, green, blue] = target.light;
        let (colours, codes) = (&self.colours(y)[columns.clone()], &self.codes(y)[columns]);
        for (index, (colour, light)) in colours.iter().zip(light).enumerate() {
            red[index] = linear[usize::from(colour[0])] * light;
            green[index] = linear[usize::from(colour[1])] * light;
            blue[index] = linear[usize::from(colour[2])] * light;
        }
        for (index, _) in codes.iter().enumerate().filter(|(_, code)| **code == HeightCode::EMPTY) {
            red[index] = VOID;
            target.slopes[index] = facing::VOID;
        }
    }

    /// Where row `y` begins in planes with apron, from [`LIT`] posts before the page's own on.
    fn start(&self, y: usize) -> usize {
        let beyond = APRON as usize - LIT;
        (y + beyond) * self.stride() + beyond
    }

    fn stride(&self) -> usize {
        self.view.width as usize + 2 * APRON as usize
    }

    #[inline(always)]
    fn codes(&self, y: usize) -> &[u16] {
        &self.view.heights[self.start(y)..][..self.view.width as usize + 2 * LIT]
    }

    #[inline(always)]
    fn colours(&self, y: usize) -> &[[u8; 3]] {
        &self.view.colours[self.start(y)..][..self.view.width as usize + 2 * LIT]
    }

    /// Slopes of the level's own heights at the lit posts of row `y`.
    #[inline(always)]
    fn slopes(&self, y: usize, target: &mut [[f32; 2]; SIDE]) {
        let columns = &self.lit[0];
        let (start, stride) = (self.start(y) + columns.start, self.stride());
        let row = |first: usize| &self.view.heights[first..][..columns.len()];
        let (here, west, east) = (row(start), row(start - 1), row(start + 1));
        let (south, north) = (row(start - stride), row(start + stride));
        // The apron repeats the area's last post: half the way, so twice the slope.
        let is_last = |at: usize, inside: &Range<usize>, edges: [bool; 2]| {
            edges[0] && at == inside.start || edges[1] && at + 1 == inside.end
        };
        let along =
            if is_last(y, &self.inside[1], self.edges[1]) { 2.0 * self.half_step } else { self.half_step };
        for (index, target) in target[..columns.len()].iter_mut().enumerate() {
            let eastward = half_steps(here[index], west[index], east[index]) as f32;
            let northward = half_steps(here[index], south[index], north[index]) as f32;
            *target = [eastward * self.half_step, northward * along];
        }
        for index in [0, columns.len() - 1] {
            if is_last(columns.start + index, &self.inside[0], self.edges[0]) {
                let eastward = half_steps(here[index], west[index], east[index]) as f32;
                target[index][0] = eastward * 2.0 * self.half_step;
            }
        }
    }
}

#[inline(always)]
fn light_on_slope(sensor: &VisualSensor, [eastward, northward]: [f32; 2]) -> f32 {
    sensor.light(Vec3::new(-eastward, -northward, 1.0).normalize())
}
