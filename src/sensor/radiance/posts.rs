//! What the posts of one stored page send.

use std::ops::Range;

use glam::Vec3;

use super::facing::{self, Facing, Slopes};
use crate::colour::linear_from_srgb8;
use crate::sensor::VisualSensor;
use crate::voxel::{Header, HeightCode, PAGE_SIDE, PageId, PageView, RADIX};

/// Posts of a whole page's row.
const SIDE: usize = PAGE_SIDE as usize;
/// Finer posts along a voxel.
const FINER: usize = RADIX as usize;

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

/// A page's posts under a lamp. Each is lit by heights of its own page and that page's apron alone, so that
/// it is the same whichever page asks.
pub struct Posts<'a> {
    lamp: &'a Lamp<'a>,
    view: PageView<'a>,
    /// Slope of one step of height from post to post.
    rise: f32,
    /// Whether the page's (west, south) and (east, north) posts are the area's last.
    edges: [[bool; 2]; 2],
}

impl<'a> Posts<'a> {
    pub fn new(lamp: &'a Lamp<'a>, header: &Header, id: PageId, view: PageView<'a>) -> Self {
        let rise = (header.heights.scale / header.grid.side(id.level)) as f32;
        let pages = header.grid.page_dims(id.level);
        let edges = [[id.px == 0, id.py == 0], [id.px + 1 == pages.0, id.py + 1 == pages.1]];
        Self { lamp, view, rise, edges }
    }

    /// Radiance of posts `columns` of row `y`, [`VOID`] where they have no surface.
    #[inline(always)]
    pub fn row(&self, y: usize, columns: Range<usize>, target: Rows<'_>) {
        let mut light = [0.0; SIDE];
        self.light(y, columns.clone(), &mut light, target.slopes);
        let colours = self.colours(y, columns.clone());
        let linear = &self.lamp.linear;
        let [red, green, blue] = target.light;
        for (index, (colour, light)) in colours.iter().zip(light).enumerate() {
            red[index] = linear[usize::from(colour[0])] * light;
            green[index] = linear[usize::from(colour[1])] * light;
            blue[index] = linear[usize::from(colour[2])] * light;
        }
        let codes = &self.codes(y + 1)[columns.start + 1..columns.end + 1];
        for (index, _) in codes.iter().enumerate().filter(|(_, code)| **code == HeightCode::EMPTY) {
            red[index] = VOID;
            target.slopes[index] = facing::VOID;
        }
    }

    /// Radiance of voxels `columns` of row `y` of the next coarser level, counted from the page's first: the mean of their
    /// posts here that have a surface, by what `facing` shows of them; [`VOID`] if none has.
    #[inline(always)]
    pub fn mean_row(&self, y: usize, columns: Range<usize>, facing: &Facing, mut target: Rows<'_>) {
        let (width, height) = (self.view.width as usize, self.view.height as usize);
        let posts = columns.start * FINER..(columns.end * FINER).min(width);
        let linear = &self.lamp.linear;
        let mut sums = [[0.0_f32; 3]; SIDE / FINER];
        let mut counts = [0.0_f32; SIDE / FINER];
        let mut rises = [[0_i16; 2]; SIDE / FINER];
        for y in y * FINER..((y + 1) * FINER).min(height) {
            let mut light = [0.0; SIDE];
            let mut cover = [0.0; SIDE];
            let mut slopes = [Slopes::default(); SIDE];
            self.light(y, posts.clone(), &mut light, &mut slopes);
            let codes = &self.codes(y + 1)[posts.start + 1..posts.end + 1];
            for (((cover, light), slopes), code) in cover.iter_mut().zip(&mut light).zip(&slopes).zip(codes) {
                *cover = if *code == HeightCode::EMPTY { 0.0 } else { facing.weight(*slopes) };
                *light *= *cover;
            }
            for (rises, slopes) in rises.iter_mut().zip(slopes[..posts.len()].chunks(FINER)) {
                for slopes in slopes {
                    *rises = [rises[0] + i16::from(slopes[0]), rises[1] + i16::from(slopes[1])];
                }
            }
            let rows = self.colours(y, posts.clone()).chunks(FINER).zip(light.chunks(FINER));
            for ((sum, count), ((colours, lights), cover)) in
                sums.iter_mut().zip(&mut counts).zip(rows.zip(cover.chunks(FINER)))
            {
                for (colour, light) in colours.iter().zip(lights) {
                    for channel in 0..3 {
                        sum[channel] += linear[usize::from(colour[channel])] * light;
                    }
                }
                *count += cover.iter().sum::<f32>();
            }
        }
        for (channel, target) in target.light.iter_mut().enumerate() {
            for ((target, sum), count) in target.iter_mut().zip(&sums).zip(&counts) {
                *target = sum[channel] / count.max(f32::MIN_POSITIVE);
            }
        }
        for (target, rises) in target.slopes.iter_mut().zip(rises) {
            *target = rises.map(|rise| (rise / (FINER * FINER) as i16) as i8);
        }
        for (index, _) in counts[..columns.len()].iter().enumerate().filter(|(_, count)| **count == 0.0) {
            target.light[0][index] = VOID;
            target.slopes[index] = facing::VOID;
        }
    }

    /// Codes of heights of a row, apron included in row and count of rows.
    #[inline(always)]
    fn codes(&self, row: usize) -> &[u16] {
        let stride = self.view.width as usize + 2;
        &self.view.heights[row * stride..(row + 1) * stride]
    }

    #[inline(always)]
    fn colours(&self, y: usize, columns: Range<usize>) -> &[[u8; 3]] {
        let first = (y + 1) * (self.view.width as usize + 2) + 1;
        &self.view.colours[first + columns.start..first + columns.end]
    }

    /// Light on posts `columns` of row `y`, and their slopes.
    #[inline(always)]
    fn light(&self, y: usize, columns: Range<usize>, target: &mut [f32; SIDE], slopes: &mut [Slopes]) {
        let count = columns.len().min(SIDE);
        let row = |row: usize, step: usize| &self.codes(row)[columns.start + step..][..count];
        let (here, west, east) = (row(y + 1, 1), row(y + 1, 0), row(y + 1, 2));
        let (south, north) = (row(y, 1), row(y + 2, 1));
        let last = [self.view.width as usize - 1, self.view.height as usize - 1];
        // The apron repeats the area's last post: half the way, so twice the slope.
        let rise = |axis: usize, at: usize| {
            let at_edge = self.edges[0][axis] && at == 0 || self.edges[1][axis] && at == last[axis];
            if at_edge { 2.0 * self.rise } else { self.rise }
        };
        let (across, along) = (self.rise, rise(1, y));
        let sensor = self.lamp.sensor;
        for (index, (target, slopes)) in target[..count].iter_mut().zip(&mut *slopes).enumerate() {
            let eastward = across * steps(here[index], west[index], east[index]);
            let northward = along * steps(here[index], south[index], north[index]);
            *target = light_on_slope(sensor, eastward, northward);
            *slopes = facing::encode([eastward, northward]);
        }
        for column in [0, last[0]].into_iter().filter(|column| columns.contains(column)) {
            let index = column - columns.start;
            let eastward = rise(0, column) * steps(here[index], west[index], east[index]);
            let northward = along * steps(here[index], south[index], north[index]);
            target[index] = light_on_slope(sensor, eastward, northward);
            slopes[index] = facing::encode([eastward, northward]);
        }
    }
}

#[inline(always)]
fn light_on_slope(sensor: &VisualSensor, eastward: f32, northward: f32) -> f32 {
    sensor.light(Vec3::new(-eastward, -northward, 1.0).normalize())
}

/// Steps of height per post from central differences; one-sided beside what has no surface.
#[inline(always)]
fn steps(here: u16, behind: u16, ahead: u16) -> f32 {
    let known = |code: u16| if code == HeightCode::EMPTY { here } else { code };
    let one_sided = behind == HeightCode::EMPTY || ahead == HeightCode::EMPTY;
    let share = if one_sided { 1.0 } else { 0.5 };
    let share = if here == HeightCode::EMPTY { 0.0 } else { share };
    share * (f32::from(known(ahead)) - f32::from(known(behind)))
}
