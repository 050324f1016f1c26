//! Baked pages against a scalar calculation, seams, the sampler against scalar bilinear filtering, eviction.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec2, Vec3};

use super::page::{CODE_LIMIT, ROOT_OF_BRIGHTEST};
use super::*;
use crate::colour::linear_from_srgb8;
use crate::error::Result;
use crate::raymarch::PageCursor;
use crate::sensor::{Sun, VisualSensor};
use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::voxel::{
    Grid, Header, MemPages, Metadata, PAGE_SIDE, PageId, PageSource, PageView, RADIX, build_in_memory,
};

const SPACING: f64 = 10.0;

/// A database of which some pages are absent.
struct Holey<F> {
    whole: MemPages,
    absent: F,
    /// How often a page was asked for.
    asked: AtomicU32,
}

impl<F: Fn(PageId) -> bool + Sync> PageSource for Holey<F> {
    fn header(&self) -> &Header {
        self.whole.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        if (self.absent)(id) { Ok(None) } else { self.whole.page(id) }
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
fn rough(nx: u32, ny: u32, holes: u64) -> MemPages {
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

fn sensor() -> VisualSensor {
    VisualSensor::new(Sun { azimuth: 120.0, elevation: 35.0 })
}

fn bake(source: &impl PageSource, level: u8, px: u32, py: u32) -> Option<RadiancePage> {
    RadiancePage::bake(source, PageId { level, px, py }, &sensor(), Isa::best()).unwrap()
}

/// Codes of a texel; −1 is the apron.
fn codes(image: &super::page::Image, x: i64, y: i64) -> [u32; 3] {
    let texel = image.texels[((y + 1) * i64::from(image.size[0] + 2) + x + 1) as usize];
    [texel & 1023, texel >> 10 & 1023, texel >> 20]
}

fn radiance_of(codes: [u32; 3]) -> Vec3 {
    let root = |code: u32| code as f32 * ROOT_OF_BRIGHTEST / CODE_LIMIT;
    Vec3::from_array(codes.map(|code| root(code) * root(code)))
}

/// What the post of a level sends if it is lit by that level: voxel by voxel through a cursor.
fn lit<S: PageSource>(cursor: &mut PageCursor<'_, S>, level: u8, cell: [i64; 2]) -> Option<Vec3> {
    let dims = cursor.dims(level);
    let here = cursor.height(level, cell).unwrap()??;
    let mut slope = |axis: usize| {
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
    let normal = Vec3::new(-slope(0), -slope(1), 1.0).normalize();
    let colour = Vec3::from_array(linear_from_srgb8(cursor.colour(level, cell).unwrap()?));
    Some(colour * sensor().light(normal))
}

/// The mean over the 4 × 4 finer posts; black if none has a surface.
fn mean_of_finer<S: PageSource>(cursor: &mut PageCursor<'_, S>, level: u8, cell: [i64; 2]) -> Vec3 {
    let dims = cursor.dims(level - 1);
    let radix = i64::from(RADIX);
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for y in (radix * cell[1]..radix * (cell[1] + 1)).filter(|y| *y < dims[1]) {
        for x in (radix * cell[0]..radix * (cell[0] + 1)).filter(|x| *x < dims[0]) {
            if let Some(radiance) = lit(cursor, level - 1, [x, y]) {
                sum += radiance;
                count += 1.0;
            }
        }
    }
    sum / f32::max(count, 1.0)
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
            let size = page.images[0].size.map(i64::from);
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let cell = [x + i64::from(px * PAGE_SIDE), y + i64::from(py * PAGE_SIDE)];
                    // What has no surface is not seen.
                    if let Some(wanted) = lit(&mut cursor, 0, cell) {
                        assert_near(codes(&page.images[0], x, y), wanted, &format!("{cell:?}"));
                    }
                }
            }
        }
    }
}

#[test]
fn voxels_send_the_mean_of_their_finer_posts() {
    for holes in [0, 3] {
        let source = rough(1090, 270, holes);
        let mut cursor = PageCursor::new(&source);
        for (level, px) in [(1, 0), (1, 1), (2, 0)] {
            let page = bake(&source, level, px, 0).unwrap();
            let size = page.images[0].size.map(i64::from);
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let cell = [x + i64::from(px * PAGE_SIDE), y];
                    let wanted = mean_of_finer(&mut cursor, level, cell);
                    assert_near(codes(&page.images[0], x, y), wanted, &format!("level {level}, {cell:?}"));
                }
            }
        }
    }
}

#[test]
fn where_a_finer_page_is_absent_voxels_are_lit_by_their_own_normals() {
    let absent = |id: PageId| id == PageId { level: 0, px: 1, py: 0 };
    let source = Holey { whole: rough(600, 300, 0), absent, asked: AtomicU32::new(0) };
    let mut cursor = PageCursor::new(&source.whole);
    let page = bake(&source, 1, 0, 0).unwrap();
    for (x, y) in [(62, 3), (63, 40), (64, 40), (100, 63), (100, 64), (127, 10), (128, 10)] {
        let is_own = (64..128).contains(&x) && y < 64;
        let wanted =
            if is_own { lit(&mut cursor, 1, [x, y]).unwrap() } else { mean_of_finer(&mut cursor, 1, [x, y]) };
        assert_near(codes(&page.images[0], x, y), wanted, &format!("({x}, {y})"));
    }
}

/// Holds every apron texel of a page against the page that the texel belongs to.
fn assert_seams(source: &impl PageSource, level: u8) -> usize {
    let (nx, ny) = source.header().grid.page_dims(level);
    let radiance = Radiance::new(sensor());
    let mut pages = RadiancePages::new(source, &radiance);
    let mut bake = |px, py| pages.get(PageId { level, px, py }).unwrap();
    let mut compared = 0;
    for (px, py) in (0..ny).flat_map(|py| (0..nx).map(move |px| (px, py))) {
        let Some(page) = bake(px, py) else { continue };
        for (index, image) in page.images.iter().enumerate() {
            let side = i64::from(PAGE_SIDE >> index);
            let size = image.size.map(i64::from);
            for y in -1..=size[1] {
                for x in -1..=size[0] {
                    if (0..size[0]).contains(&x) && (0..size[1]).contains(&y) {
                        continue;
                    }
                    let at = [x + i64::from(px) * side, y + i64::from(py) * side];
                    let last = [i64::from(nx), i64::from(ny)].map(|pages| pages * side - 1);
                    let outside = (0..2).any(|axis| at[axis] < 0 || at[axis] > last[axis]);
                    let owner = at.map(|texel| texel.div_euclid(side) as u32);
                    let Some(other) = (!outside).then(|| bake(owner[0], owner[1])).flatten() else {
                        continue;
                    };
                    let inside = at.map(|texel| texel.rem_euclid(side));
                    if inside[0] >= i64::from(other.images[index].size[0])
                        || inside[1] >= i64::from(other.images[index].size[1])
                    {
                        continue;
                    }
                    assert_eq!(
                        codes(image, x, y),
                        codes(&other.images[index], inside[0], inside[1]),
                        "level {level}, page ({px}, {py}), image {index}, texel ({x}, {y})"
                    );
                    compared += 1;
                }
            }
        }
    }
    compared
}

#[test]
fn aprons_hold_what_the_neighbours_hold() {
    // One row or column more than whole pages, and odd and even rests.
    for (nx, ny) in [(257, 513), (300, 259)] {
        let compared = assert_seams(&rough(nx, ny, 7), 0);
        assert!(compared > 1000, "{compared}");
    }
}

#[test]
fn coarse_aprons_hold_what_the_neighbours_hold() {
    assert!(assert_seams(&rough(1030, 1045, 7), 1) > 500);
    // Some finer pages are absent on both sides of the border.
    let absent = |id: PageId| id.level == 0 && (id.px + id.py).is_multiple_of(2);
    let holey = Holey { whole: rough(1100, 300, 7), absent, asked: AtomicU32::new(0) };
    assert!(assert_seams(&holey, 1) > 100);
}

#[test]
fn at_the_edge_of_the_area_aprons_repeat_the_edge() {
    let source = rough(301, 17, 0);
    let page = bake(&source, 0, 1, 0).unwrap();
    let image = &page.images[0];
    assert_eq!(image.size, [45, 17]);
    assert_eq!(page.images[1].size, [23, 9]);
    for y in 0..17 {
        assert_eq!(codes(image, 45, y), codes(image, 44, y));
    }
    for x in 0..45 {
        assert_eq!(codes(image, x, -1), codes(image, x, 0));
        assert_eq!(codes(image, x, 17), codes(image, x, 16));
    }
}

#[test]
fn a_page_without_neighbours_ends_like_the_area() {
    let id = PageId { level: 0, px: 1, py: 1 };
    let source =
        Holey { whole: rough(768, 768, 0), absent: move |page| page != id, asked: AtomicU32::new(0) };
    let page = bake(&source, 0, 1, 1).unwrap();
    for image in &page.images {
        let last = i64::from(image.size[0]) - 1;
        for at in 0..=last {
            assert_eq!(codes(&page.images[0], at, -1), codes(&page.images[0], at, 0));
            assert_eq!(codes(&page.images[0], -1, at), codes(&page.images[0], 0, at));
        }
    }
    assert!(bake(&source, 0, 0, 1).is_none());
}

#[test]
fn every_instruction_set_bakes_the_same_bits() {
    let source = rough(300, 270, 7);
    for level in 0..2 {
        let id = PageId { level, px: 0, py: 0 };
        let baked = |isa| RadiancePage::bake(&source, id, &sensor(), isa).unwrap();
        for isa in Isa::available() {
            assert!(baked(isa) == baked(Isa::PORTABLE), "level {level}, {isa}");
        }
    }
}

/// Samples places (units) over footprints of log₂ `detail`.
struct Sampling<'s, 'a> {
    sampler: &'s mut Sampler<'a>,
    places: [[f32; LANES]; 2],
    detail: [f32; LANES],
    wanted: u16,
}

impl Kernel for Sampling<'_, '_> {
    type Output = [[f32; LANES]; 3];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let place = [simd.load(&self.places[0]), simd.load(&self.places[1])];
        let detail = simd.load(&self.detail);
        let found = self.sampler.sample(simd, place, detail, simd.mask(self.wanted)).unwrap();
        found.map(|channel| {
            let mut out = [0.0; LANES];
            channel.store(&mut out);
            out
        })
    }
}

/// Radiance of a texel of an image of a level, counted from the area's first.
fn texel(pages: &mut RadiancePages<'_>, level: u8, half: usize, at: [i64; 2]) -> Option<Vec3> {
    let dims = pages.source().header().grid.dims(level);
    let side = i64::from(PAGE_SIDE) >> half;
    let count = [dims.0, dims.1].map(|voxels| i64::from(if half == 1 { voxels.div_ceil(2) } else { voxels }));
    let at = [0, 1].map(|axis| at[axis].clamp(0, count[axis] - 1));
    let (px, py) = ((at[0] / side) as u32, (at[1] / side) as u32);
    let page = pages.get(PageId { level, px, py }).unwrap()?;
    Some(radiance_of(codes(&page.images[half], at[0] % side, at[1] % side)))
}

/// The sampler's answer, in double precision; roots are blended, not radiance.
fn scalar(pages: &mut RadiancePages<'_>, place: DVec2, image: usize) -> Vec3 {
    let levels = usize::from(pages.source().header().level_count);
    for image in (image..2 * levels).step_by(2) {
        let (level, half) = ((image / 2) as u8, image % 2);
        let side = f64::from(Grid::side_units(level)) * f64::from(1 << half);
        let at = place / side - 0.5;
        let (west, south) = (at.x.floor() as i64, at.y.floor() as i64);
        let (u, v) = ((at.x - at.x.floor()) as f32, (at.y - at.y.floor()) as f32);
        let mut corner = |x, y| texel(pages, level, half, [west + x, south + y]).map(|c| c.map(f32::sqrt));
        let Some(sw) = corner(0, 0) else { continue };
        let (se, nw, ne) = (corner(1, 0).unwrap(), corner(0, 1).unwrap(), corner(1, 1).unwrap());
        let root = sw.lerp(se, u).lerp(nw.lerp(ne, u), v);
        return root * root;
    }
    Vec3::ZERO
}

/// Holds all sets against the scalar calculation at places of the eye's surroundings.
fn assert_sampled(source: &impl PageSource, eye: DVec2, places: &[(DVec2, usize)]) {
    let radiance = Radiance::new(sensor());
    let mut pages = RadiancePages::new(source, &radiance);
    for isa in Isa::available() {
        let mut sampler = Sampler::new(RadiancePages::new(source, &radiance), eye);
        for group in places.chunks(LANES) {
            let (mut from_eye, mut detail) = ([[0.0; LANES]; 2], [0.0; LANES]);
            for (lane, (place, image)) in group.iter().enumerate() {
                from_eye[0][lane] = (place.x - eye.x) as f32;
                from_eye[1][lane] = (place.y - eye.y) as f32;
                detail[lane] = *image as f32;
            }
            // Lane 0 is not wanted.
            let wanted = (((1_u32 << group.len()) - 1) & !1) as u16;
            let found = isa.run(Sampling { sampler: &mut sampler, places: from_eye, detail, wanted });
            assert_eq!(found.map(|channel| channel[0]), [0.0; 3], "{isa}");
            for (lane, (place, image)) in group.iter().enumerate().skip(1) {
                let wanted = scalar(&mut pages, *place, *image);
                let difference = (Vec3::from_array(found.map(|channel| channel[lane])) - wanted).abs();
                assert!(
                    difference.max_element() < 2e-3,
                    "{isa}, {place}, image {image}: {difference} from {wanted}"
                );
            }
        }
    }
}

/// Random places within `from..to`, in images 0 to 3.
fn places(from: DVec2, to: DVec2, count: u64) -> Vec<(DVec2, usize)> {
    let unit = |seed| (noise(seed) >> 11) as f64 / (1_u64 << 53) as f64;
    let place = |k: u64| from + DVec2::new(unit(3 * k), unit(3 * k + 1)) * (to - from);
    (0..count).map(|k| (place(k), (noise(3 * k + 2) % 4) as usize)).collect()
}

#[test]
fn samples_are_bilinear_everywhere() {
    let source = rough(530, 301, 0);
    let (west_south, size) = (DVec2::splat(-0.5), DVec2::new(530.5, 301.5));
    let eye = DVec2::new(270.25, 100.5);
    assert_sampled(&source, eye, &places(west_south, size, 160));
    // Along the border of two pages, and where four meet.
    let meeting = DVec2::splat(f64::from(PAGE_SIDE));
    assert_sampled(&source, eye, &places(meeting - 1.0, meeting + 1.0, 80));
    assert_sampled(&source, DVec2::new(-700.0, 4000.0), &places(meeting - 1.0, meeting + 1.0, 80));
    // At and half a voxel beyond the area's edges.
    assert_sampled(&source, eye, &places(west_south, DVec2::new(0.5, 301.5), 48));
    assert_sampled(&source, eye, &places(DVec2::new(0.0, 300.5), size, 48));
}

#[test]
fn a_coarser_page_stands_in_for_an_absent_one() {
    let absent = |id: PageId| id.level == 0 && id.px == 1;
    let source = Holey { whole: rough(600, 300, 0), absent, asked: AtomicU32::new(0) };
    // Blends across the border of what is there end at the border.
    let inside = |x: &(DVec2, usize)| (x.0.x - 256.0).abs() > 1.0 && (x.0.x - 512.0).abs() > 1.0;
    let places: Vec<_> =
        places(DVec2::ZERO, DVec2::new(600.0, 300.0), 160).into_iter().filter(inside).collect();
    assert_sampled(&source, DVec2::new(300.0, 10.0), &places);
}

#[test]
fn what_was_not_used_for_longest_makes_room_and_comes_again() {
    let source = Holey { whole: rough(1024, 256, 0), absent: |_| false, asked: AtomicU32::new(0) };
    let id = |px| PageId { level: 0, px, py: 0 };
    let page = |radiance: &Radiance, px| {
        RadiancePages::new(&source, radiance).get(id(px)).unwrap().map(|page| (*page).clone())
    };
    let one = bake(&source, 0, 1, 0).unwrap().bytes();
    let radiance = Radiance::with_budget(sensor(), 2 * one);
    let first: Vec<_> = (0..4).map(|px| page(&radiance, px)).collect();
    assert!(radiance.bytes() > 3 * one);
    for _ in 0..3 {
        radiance.begin_frame();
        page(&radiance, 2);
    }
    radiance.begin_frame();
    assert!(radiance.bytes() <= 2 * one, "{} bytes", radiance.bytes());
    let before = source.asked.load(Ordering::Relaxed);
    assert!(page(&radiance, 2) == first[2]);
    assert_eq!(source.asked.load(Ordering::Relaxed), before, "what was used last is kept");
    assert!(page(&radiance, 0) == first[0]);
    assert!(source.asked.load(Ordering::Relaxed) > before, "what was dropped is computed again");
}

#[test]
fn pages_of_frames_in_flight_stay() {
    let source = rough(512, 256, 0);
    let radiance = Radiance::with_budget(sensor(), 0);
    let mut pages = RadiancePages::new(&source, &radiance);
    let kept = pages.get(PageId { level: 0, px: 0, py: 0 }).unwrap();
    radiance.begin_frame();
    radiance.begin_frame();
    assert!(radiance.bytes() > 0);
    radiance.begin_frame();
    assert_eq!(radiance.bytes(), 0);
    // Whoever still holds one may go on with it.
    assert!(kept.is_some());
}
