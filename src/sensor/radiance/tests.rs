//! Baked pages against a scalar calculation, seams, lines against scalar means.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec2, Vec3};

use super::facing::Facing;
use super::lines::FilterScratch;
use super::posts::PageLight;
use super::*;
use crate::detail::DetailPosts;
use crate::pixels::{CODE_LIMIT, ROOT_OF_BRIGHTEST, UNITS};
use crate::raymarch::PageCursor;
use crate::sensor::VisualSensor;
use crate::sensor::radiance::part::PostPart;
use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::sunlight::Sun;
use crate::voxel::{
    BoundsView, Grid, Header, MemPages, Metadata, PAGE_SIDE, PageId, PageSource, PageView, RADIX, SpansView,
    build_in_memory,
};
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_base::error::Result;

const SPACING: f64 = 10.0;

/// A database of which some pages are absent.
pub(super) struct Holey<F> {
    pub whole: MemPages,
    pub absent: F,
    /// How often a page was asked for.
    pub asked: AtomicU32,
}

impl<F: Fn(PageId) -> bool + Sync> PageSource for Holey<F> {
    fn header(&self) -> &Header {
        self.whole.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        if (self.absent)(id) { Ok(None) } else { self.whole.page(id) }
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if (self.absent)(id) { Ok(None) } else { self.whole.spans(id) }
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        if (self.absent)(id) { Ok(None) } else { self.whole.bounds(id) }
    }

    fn has(&self, id: PageId) -> bool {
        !(self.absent)(id)
    }
}

/// Numbers that look random (splitmix).
fn noise(seed: u64) -> u64 {
    let mut mixed = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Rough ground of noise, with one post in `holes` (0: none) without surface.
pub(super) fn rough(nx: u32, ny: u32, holes: u64) -> MemPages {
    let grid = Grid { nx, ny, spacing: SPACING, origin: DVec2::ZERO };
    let posts = 0..u64::from(nx) * u64::from(ny);
    let is_hole = |post: u64| holes > 0 && noise(post + (1 << 40)).is_multiple_of(holes);
    let height = |post: u64| (noise(post) % 2000) as f64 / 100.0;
    let heights: Vec<f64> =
        posts.clone().map(|post| if is_hole(post) { f64::NAN } else { height(post) }).collect();
    let colours: Vec<[u8; 3]> = posts
        .map(|post| {
            let bytes = noise(post + (1 << 41)).to_le_bytes();
            [bytes[0], bytes[1], bytes[2]]
        })
        .collect();
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

pub(super) fn sensor() -> VisualSensor {
    VisualSensor::new(Sun { azimuth: 120.0, elevation: 35.0 })
}

pub(super) fn bake(source: &impl PageSource, level: u8, px: u32, py: u32) -> Option<RadiancePage> {
    bake_facing(source, level, px, py, &Facing::down(0))
}

fn bake_facing(
    source: &impl PageSource,
    level: u8,
    px: u32,
    py: u32,
    facing: &Facing,
) -> Option<RadiancePage> {
    RadiancePage::bake(
        source,
        PageId { level, px, py },
        PostPart::ALL,
        &PageLight::new(&sensor()),
        facing,
        None,
        Isa::best(),
    )
    .unwrap()
}

/// Codes of a texel; the apron has negative indices.
pub(super) fn codes(page: &RadiancePage, x: i64, y: i64) -> [u32; 3] {
    let texel = page.texel(x as i32, y as i32);
    [texel & 1023, texel >> 10 & 1023, texel >> 20]
}

fn radiance_of(codes: [u32; 3]) -> Vec3 {
    let root = |code: u32| code as f32 * ROOT_OF_BRIGHTEST / CODE_LIMIT;
    Vec3::from_array(codes.map(|code| root(code) * root(code)))
}

/// Slopes of a level at a post, eastward and northward; `None`: no surface.
fn slopes(cursor: &mut PageCursor<'_>, level: u8, cell: [i64; 2]) -> Option<[f32; 2]> {
    let dims = cursor.dims(level);
    let here = cursor.height(level, cell).unwrap()??;
    let slope = |axis: usize| {
        let mut known = |step: i64| {
            let mut cell = cell;
            cell[axis] += step;
            let inside = (0..dims[axis]).contains(&cell[axis]);
            inside.then(|| cursor.height(level, cell).unwrap().flatten()).flatten()
        };
        let steps = match (known(-1), known(1)) {
            (Some(behind), Some(ahead)) => (ahead - behind) / 2.0,
            (None, Some(ahead)) => ahead - here,
            (Some(behind), None) => here - behind,
            (None, None) => 0.0,
        };
        (steps / (SPACING * f64::from(Grid::side_units(level)))) as f32
    };
    Some([0, 1].map(slope))
}

/// What the post of a level sends if it is lit by that level: voxel by voxel through a cursor.
fn lit(cursor: &mut PageCursor<'_>, level: u8, cell: [i64; 2]) -> Option<Vec3> {
    let [east, north] = slopes(cursor, level, cell)?;
    let normal = Vec3::new(-east, -north, 1.0).normalize();
    let colour = Vec3::from_array(linear_from_srgb8(cursor.colour(level, cell).unwrap()?));
    Some(colour * sensor().daylight().on(normal, 1.0))
}

/// How much of ground with these slopes is seen: its rise along the view, and what the eye looks down.
fn weight_of(facing: &Facing, slopes: [f32; 2]) -> f32 {
    let slope = slopes[usize::from(facing.major)];
    let rise = if facing.forward { slope } else { -slope };
    match facing.incline {
        0 => (rise + 0.15).max(0.03),
        1 => (rise + 0.6).max(0.03),
        _ => 1.0,
    }
}

/// How much of a post is seen.
fn weight(cursor: &mut PageCursor<'_>, level: u8, cell: [i64; 2], facing: &Facing) -> f32 {
    slopes(cursor, level, cell).map_or(0.0, |slopes| weight_of(facing, slopes))
}

/// What a coarse voxel sends: its colour under the light on four slopes with mean and covariance of those of its 4 × 4 finer posts, by
/// what is seen of them; black if none of these has a surface.
fn lit_by_finer(cursor: &mut PageCursor<'_>, level: u8, cell: [i64; 2], facing: &Facing) -> Vec3 {
    let Some(colour) = cursor.colour(level, cell).unwrap() else { return Vec3::ZERO };
    let dims = cursor.dims(level - 1);
    let radix = i64::from(RADIX);
    let rows = (radix * cell[1]..radix * (cell[1] + 1)).filter(|y| *y < dims[1]);

    let finer: Vec<DVec2> = rows
        .flat_map(|y| (radix * cell[0]..radix * (cell[0] + 1)).map(move |x| [x, y]))
        .filter(|[x, _]| *x < dims[0])
        .filter_map(|cell| slopes(cursor, level - 1, cell))
        .map(|slopes| DVec2::from_array(slopes.map(f64::from)))
        .collect();
    let Some(own) = slopes(cursor, level, cell) else { return Vec3::ZERO };
    let count = finer.len() as f64;
    let mean = finer.iter().sum::<DVec2>() / count;
    let moment = |f: &dyn Fn(DVec2) -> f64| finer.iter().map(|slope| f(*slope - mean)).sum::<f64>() / count;
    let a = moment(&|d| d.x * d.x).sqrt();
    let b = if a > 0.0 { moment(&|d| d.x * d.y) / a } else { 0.0 };
    let c = (moment(&|d| d.y * d.y) - b * b).max(0.0).sqrt();

    // As they are stored.
    let stored = |value: f64, steps: f64| (value * steps).round().clamp(-127.0, 127.0) / steps;
    let own = DVec2::from_array(own.map(f64::from));
    let mean = own + DVec2::new(stored(mean.x - own.x, 128.0), stored(mean.y - own.y, 128.0));
    let root = std::f64::consts::SQRT_2;
    let [a, b, c] = [a, b, c].map(|spread| root * stored(spread, 32.0));
    let (mut light, mut total) = (Vec3::ZERO, 0.0);

    for slope in [DVec2::new(a, b), DVec2::new(-a, -b), DVec2::new(0.0, c), DVec2::new(0.0, -c)] {
        let [east, north] = (mean + slope).as_vec2().to_array();
        let weight = weight_of(facing, [east, north]);
        light += weight * sensor().daylight().on(Vec3::new(-east, -north, 1.0).normalize(), 1.0);
        total += weight;
    }

    Vec3::from_array(linear_from_srgb8(colour)) * (light / total)
}

fn assert_near(codes: [u32; 3], radiance: Vec3, place: &str) {
    for (code, light) in codes.into_iter().zip(radiance.to_array()) {
        let wanted = (light.max(0.0).sqrt() / ROOT_OF_BRIGHTEST * CODE_LIMIT).min(CODE_LIMIT);
        assert!((code as f32 - wanted).abs() < 0.52, "{place}: {code} instead of {wanted}");
    }
}

#[test]
fn posts_send_their_albedo_times_the_light_on_their_normal() {
    for holes in [0, 9] {
        let source = rough(301, 270, holes);
        let mut cursor = PageCursor::new(&source);
        for (px, py) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let page = bake(&source, 0, px, py).unwrap();
            let size = page.size.map(i64::from);
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let cell = [x + i64::from(px * PAGE_SIDE), y + i64::from(py * PAGE_SIDE)];
                    // What has no surface is not seen.
                    if let Some(wanted) = lit(&mut cursor, 0, cell) {
                        assert_near(codes(&page, x, y), wanted, &format!("{cell:?}"));
                    }
                }
            }
        }
    }
}

#[test]
fn voxels_send_what_slopes_like_those_of_their_finer_posts_do() {
    let uphill = Facing { major: 0, forward: true, incline: 0 };
    let back = Facing { major: 1, forward: false, incline: 1 };
    for (holes, facing) in [(0, Facing::down(0)), (3, Facing::down(1)), (0, uphill), (3, back)] {
        let source = rough(1090, 270, holes);
        let mut cursor = PageCursor::new(&source);
        let mut off = Vec::new();
        for (level, px) in [(1, 0), (1, 1), (2, 0)] {
            let page = bake_facing(&source, level, px, 0, &facing).unwrap();
            let size = page.size.map(i64::from);
            for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))) {
                let cell = [x + i64::from(px * PAGE_SIDE), y];
                let wanted = lit_by_finer(&mut cursor, level, cell, &facing);
                let roots = wanted.to_array().map(|light| light.max(0.0).sqrt());
                let wanted = roots.map(|root| (root / ROOT_OF_BRIGHTEST * CODE_LIMIT).min(CODE_LIMIT));
                let codes = codes(&page, x, y);
                let worst =
                    |off: f32, channel: usize| off.max((codes[channel] as f32 - wanted[channel]).abs());
                off.push((0..3).fold(0.0, worst));
            }
        }

        // A slope at the border of two steps may be stored as the other one.
        off.sort_unstable_by(f32::total_cmp);
        let [most, all] = [off[off.len() * 99 / 100], off[off.len() - 1]];
        assert!(most < 0.6 && all < 12.0, "holes {holes}: {most}, {all}");
    }
}

/// What the mean of what its finer posts send is to a voxel's light, on ground that is not rougher than terrain is.
#[test]
fn light_of_voxels_is_near_the_mean_of_that_of_their_posts() {
    let side = 512_u32;
    let grid = Grid { nx: side, ny: side, spacing: SPACING, origin: DVec2::ZERO };
    let wave =
        |x: f64, y: f64| 20.0 * (0.9 * x + 0.4 * y).sin() + 60.0 * (0.05 * x).sin() + 7.0 * (1.3 * y).cos();
    let cells = (0..side).flat_map(|y| (0..side).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<f64> = cells.map(|(x, y)| wave(x, y)).collect();
    let colours = vec![[140, 120, 90]; heights.len()];
    let source = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
    let mut cursor = PageCursor::new(&source);

    for facing in [Facing::down(0), Facing { major: 0, forward: true, incline: 0 }] {
        let page = bake_facing(&source, 1, 0, 0, &facing).unwrap();
        let (mut error, mut plain) = (0.0_f32, 0.0_f32);
        for (x, y) in (2..120).flat_map(|y| (2..120).map(move |x| (x, y))) {
            let (mut sum, mut total) = (Vec3::ZERO, 0.0);
            for cell in (0..16).map(|k| [4 * x + k % 4, 4 * y + k / 4]) {
                let slopes = slopes(&mut cursor, 0, cell).unwrap();
                let weight = weight_of(&facing, slopes);
                sum += lit(&mut cursor, 0, cell).unwrap() * weight;
                total += weight;
            }
            let wanted = sum / total;
            error += (radiance_of(codes(&page, x, y)) - wanted).abs().x;
            plain += (lit(&mut cursor, 1, [x, y]).unwrap() - wanted).abs().x;
        }

        assert!(error < 0.2 * plain, "{facing:?}: {error} against {plain}");
    }
}

#[test]
fn every_instruction_set_bakes_the_same_bits() {
    let source = rough(300, 270, 7);
    for level in 0..2 {
        let id = PageId { level, px: 0, py: 0 };
        let facing = Facing { major: 1, forward: false, incline: 0 };
        let baked = |isa| {
            RadiancePage::bake(&source, id, PostPart::ALL, &PageLight::new(&sensor()), &facing, None, isa)
                .unwrap()
        };
        for isa in Isa::available() {
            assert!(baked(isa) == baked(Isa::PORTABLE), "level {level}, {isa}");
        }
    }
}

/// Sixteen planes along axis `major` from `eye` across them, `minor` units per unit of major distance.
struct Looking<'s, 'a> {
    sampler: &'s mut LineSampler<'a>,
    major: usize,
    forward: bool,
    height: f64,
    eye: f64,
    minor: [f32; LANES],
    /// Width of a pixel's footprint at the line, voxels of level 0.
    footprint: f64,
    line: ImageLine,
}

impl Kernel for Looking<'_, '_> {
    type Output = [[f32; LANES]; 3];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self { sampler, major, forward, height, eye, minor, footprint, line } = self;
        let pixel = footprint / f64::from(line.distance);
        let planes = PlanesAbove { major, forward, height, eye, minor, pixel };
        let mut crossings = sampler.under(simd, &planes);
        let place = crossings.seek(line).unwrap();
        let mut found = crossings.sample(&place);
        for (channel, unit) in found.iter_mut().zip(UNITS) {
            *channel = *channel * simd.splat(unit);
        }
        found.map(|channel| {
            let mut out = [0.0; LANES];
            channel.store(&mut out);
            out
        })
    }
}

/// Pages of level 0 with or without the means of voxels kept.
struct Baked<'s> {
    source: &'s MemPages,
    keeps_means: bool,
    pages: RefCell<HashMap<PageId, RadiancePage>>,
}

/// Radiance of a post of level 0, of the nearest if it lies outside.
fn post(baked: &Baked<'_>, at: [i64; 2]) -> Vec3 {
    let dims = baked.source.header().grid.dims(0);
    let at = [at[0].clamp(0, i64::from(dims.0) - 1), at[1].clamp(0, i64::from(dims.1) - 1)];
    let side = i64::from(PAGE_SIDE);
    let id = PageId { level: 0, px: (at[0] / side) as u32, py: (at[1] / side) as u32 };
    let mut pages = baked.pages.borrow_mut();
    let page = pages.entry(id).or_insert_with(|| {
        let (sensor, mut detail) = (sensor(), DetailPosts::default());
        let (lamp, detail) = (PageLight::new(&sensor), baked.keeps_means.then_some(&mut detail));
        let page =
            RadiancePage::bake(baked.source, id, PostPart::ALL, &lamp, &Facing::down(0), detail, Isa::best());
        page.unwrap().unwrap()
    });
    radiance_of(codes(page, at[0] % side, at[1] % side))
}

/// Mean over a stride's lines, the ends by half, and over `wide` posts of texel `texel`, by what is seen of them.
fn mean(
    pages: &Baked<'_>,
    see: impl Fn([i64; 2]) -> f32,
    major: usize,
    line: i64,
    span: i64,
    texel: i64,
    wide: i64,
) -> Vec3 {
    let half = span / 2;
    let (mut sum, mut total) = (Vec3::ZERO, 0.0);
    for along in -half..=half {
        let share = if span > 1 && along.abs() == half { 0.5 } else { 1.0 };
        for across in texel * wide..(texel + 1) * wide {
            let at = if major == 0 { [line + along, across] } else { [across, line + along] };
            sum += post(pages, at) * share * see(at);
            total += share * see(at);
        }
    }
    sum / total
}

#[test]
fn lines_are_means_over_strides_and_footprints() {
    let source = rough(560, 520, 0);
    let radiance = Radiance::new(sensor());
    let baked =
        [false, true].map(|keeps_means| Baked { source: &source, keeps_means, pages: RefCell::default() });
    let unit = |seed| (noise(seed) >> 11) as f64 / (1_u64 << 53) as f64;

    for case in 0..400_u64 {
        let major = (case % 2) as usize;
        let span = 1 << (case / 2 % 3);
        let shift = case / 6 % 3;
        let wide = 1_i64 << shift;
        let eye = 560.0 * unit(5 * case);
        let middle = unit(5 * case + 1) - 0.5;
        let distance = (300.0 * unit(5 * case + 2)) as f32 + 1.0;
        let minor = std::array::from_fn(|lane| (middle + 0.004 * lane as f64) as f32);
        let index = (500.0 * unit(5 * case + 3)) as i64 / span * span;
        let line = ImageLine { level: 0, index, span: span as u8, distance };
        let footprint = [1.0, 2.0, 4.0][shift as usize];
        let incline = case / 18 % 3;
        let (forward, height) = (case % 5 < 2, f64::from(distance) * [0.1, 0.7, 3.0][incline as usize]);
        let facing = Facing { major: major as u8, forward, incline: incline as u8 };
        let see = |at: [i64; 2]| {
            let at = [at[0].clamp(0, 559), at[1].clamp(0, 519)];
            weight(&mut PageCursor::new(&source), 0, at, &facing)
        };

        for isa in Isa::available() {
            let mut sampler = LineSampler::new(RadiancePages::new(&source, &radiance));
            let looking =
                Looking { sampler: &mut sampler, major, forward, height, eye, minor, footprint, line };
            let found = isa.run(looking);

            for lane in 0..LANES {
                let texel = (eye + f64::from(minor[lane]) * f64::from(distance)) / wide as f64 - 0.5;
                // The area's edge goes on as its outermost texel.
                let last = ([560, 520][1 - major] as f64 / wide as f64).ceil();
                let texel = texel.clamp(-1.0, last - 0.001);
                let pages = &baked[usize::from(shift == 0 && span <= 2)];
                let near = mean(pages, see, major, index, span, texel.floor() as i64, wide);
                let far = mean(pages, see, major, index, span, texel.floor() as i64 + 1, wide);
                let share = (texel - texel.floor()) as f32;
                let wanted = near.lerp(far, share);
                let off = (Vec3::from_array(found.map(|channel| channel[lane])) - wanted).abs();
                let place = format!("{isa}, case {case}, lane {lane}, texel {texel}");
                assert!(off.max_element() < 4e-3, "{place}: {off} from {wanted}");
            }
        }
    }
}

#[test]
fn a_coarser_line_stands_in_for_an_absent_one() {
    let absent = |id: PageId| id.level == 0;
    let source = Holey { whole: rough(300, 300, 0), absent, asked: AtomicU32::new(0) };
    let radiance = Radiance::new(sensor());

    let look = |level, index| {
        let mut sampler = LineSampler::new(RadiancePages::new(&source, &radiance));
        let line = ImageLine { level, index, span: 1, distance: 50.0 };
        let (major, forward, height) = (0, true, f64::INFINITY);
        let (eye, minor, footprint) = (100.0, [0.3; LANES], 0.4);

        Isa::best().run(Looking {
            sampler: &mut sampler,
            major,
            forward,
            height,
            eye,
            minor,
            footprint,
            line,
        })
    };

    assert_eq!(look(0, 83), look(1, 20));
    assert!(look(1, 20)[1][0] > 0.0);
}

#[test]
fn every_instruction_set_weaves_the_same_bits() {
    let source = rough(300, 270, 7);
    for (level, shift, span) in [(0, 0, 1), (0, 2, 4), (1, 1, 2), (1, 2, 1), (0, 1, 1)] {
        let facing = Facing { major: level, forward: shift == 1, incline: span / 2 };
        let filter = LineFilter { facing, shift, span };
        let bake = |isa| {
            LineImage::bake(
                &source,
                PageId { level, px: 0, py: 0 },
                PostPart::lines(level, 32, 32),
                &PageLight::new(&sensor()),
                filter,
                &mut FilterScratch::default(),
                isa,
            )
            .unwrap()
        };
        for isa in Isa::available() {
            assert!(bake(isa) == bake(Isa::PORTABLE), "{filter:?}, {isa}");
        }
    }
}
