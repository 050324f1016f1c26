//! Scan planes against the reference marcher, as whole frames.

use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use hedgehop::frame::Frame;
use hedgehop::render::{Engine, RenderOptions, Renderer, render_reference};
use hedgehop::simd::Isa;
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::{Farm, TaskSize};
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};

fn hills() -> MemPages {
    let grid = Grid { nx: 600, ny: 600, spacing: 10.0, origin: DVec2::new(500_000.0, 4_000_000.0) };
    let (mut heights, mut colours) = (Vec::new(), Vec::new());
    for (y, x) in (0..600).flat_map(|y| (0..600).map(move |x| (10.0 * f64::from(y), 10.0 * f64::from(x)))) {
        let broad = 120.0 * (x / 900.0).sin() * (y / 1300.0).cos();
        heights.push(300.0 + broad + 15.0 * (x / 110.0 + y / 170.0).sin());
        colours.push([120, (100.0 + 80.0 * (x / 60.0).sin()) as u8, (90.0 + 60.0 * (y / 45.0).cos()) as u8]);
    }
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

static AREA: LazyLock<MemPages> = LazyLock::new(hills);

fn camera(area: &MemPages, pitch: f64, roll: f64) -> Camera {
    let grid = area.header().grid;
    let eye = (grid.origin + DVec2::new(2500.0, 1500.0)).extend(520.0);
    let pose = Pose { eye, attitude: Attitude { yaw: 20.0, pitch, roll }, hfov: 60.0 };
    Camera::new(pose, 320, 180)
}

fn options() -> RenderOptions {
    RenderOptions { engine: Engine::Planes, ..RenderOptions::default() }
}

/// Sorted relative differences of range, and the share of pixels where only one sees ground.
fn compare(found: &Frame, truth: &Frame) -> (Vec<f64>, f64) {
    let pairs = || found.range.iter().zip(&truth.range);
    let mut errors: Vec<f64> = pairs()
        .filter(|(found, truth)| found.is_finite() && truth.is_finite())
        .map(|(found, truth)| f64::from((found - truth).abs() / truth))
        .collect();
    errors.sort_by(f64::total_cmp);
    let apart = pairs().filter(|(found, truth)| found.is_finite() != truth.is_finite()).count();
    (errors, apart as f64 / found.range.len() as f64)
}

/// Median, 99 % and 99.6 % of the relative differences of range, share of pixels where one sees sky, mean difference of light.
fn figures(attitudes: &[(f64, f64)]) -> [f64; 5] {
    let area = hills();
    let farm = Farm::new(2).unwrap();
    let fine = RenderOptions { detail: 50.0, ..options() };
    let renderer = Renderer::new(&area, &fine);
    let (mut errors, mut apart, mut light) = (Vec::new(), 0.0, 0.0);

    for &(pitch, roll) in attitudes {
        let camera = camera(&area, pitch, roll);
        let truth = render_reference(&area, &camera, &fine, &farm).unwrap().frame;
        let found = renderer.frame(&camera, &farm).unwrap().frame;
        let (mut ranges, sky) = compare(&found, &truth);
        errors.append(&mut ranges);
        apart += sky / attitudes.len() as f64;
        let differences = found.colour.iter().flatten().zip(truth.colour.iter().flatten());
        let sum: f64 = differences.map(|(a, b)| f64::from((a - b).abs())).sum();
        light += sum / (3 * found.colour.len() * attitudes.len()) as f64;
    }

    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[(errors.len() as f64 * share) as usize];
    [at(0.5), at(0.99), at(0.996), apart, light]
}

#[test]
fn planes_see_what_rays_see() {
    let found = figures(&[(0.0, 0.0), (-10.0, 0.0), (-35.0, 0.0), (8.0, 0.0)]);
    let bounds = [1.5e-4, 3e-3, 1e-2, 1e-3, 0.01];
    assert!(found.iter().zip(bounds).all(|(found, bound)| *found <= bound), "{found:?}");
}

/// Behind its outermost lines an area goes on for half a voxel, which may be all of it.
#[test]
fn areas_are_seen_whole_from_above() {
    for (nx, ny) in [(1, 1), (2, 2), (1, 9), (5, 3), (16, 16)] {
        let grid = Grid { nx, ny, spacing: 10.0, origin: DVec2::new(500_000.0, 4_000_000.0) };
        let posts = (0..nx * ny).map(|post| (f64::from(post % nx), f64::from(post / nx)));
        let heights: Vec<f64> =
            posts.map(|(x, y)| 7.0 * (1.3 * x + y).sin() + 5.0 * (1.7 * y).cos()).collect();
        let area =
            build_in_memory(grid, &heights, &vec![[128; 3]; heights.len()], None, &Metadata::default());
        let (area, farm) = (area.unwrap(), Farm::new(1).unwrap());
        let fine = RenderOptions { detail: 50.0, ..options() };
        let size = 10.0 * DVec2::new(f64::from(nx), f64::from(ny));

        for (pitch, place) in
            [(-90.0, (0.5, 0.5)), (-90.0, (0.02, 0.5)), (-80.0, (0.97, 0.99)), (-60.0, (0.5, 0.01))]
        {
            let eye = (grid.origin + size * DVec2::from(place)).extend(13.0 + size.max_element());
            let camera = Camera::new(
                Pose { eye, attitude: Attitude { yaw: 20.0, pitch, roll: 0.0 }, hfov: 70.0 },
                160,
                120,
            );
            let truth = render_reference(&area, &camera, &fine, &farm).unwrap().frame;
            let found = Renderer::new(&area, &fine).frame(&camera, &farm).unwrap().frame;
            let (errors, apart) = compare(&found, &truth);
            let median = errors[errors.len() / 2];
            assert!(
                apart <= 0.004 && median <= 1e-3,
                "{nx} x {ny}, pitch {pitch}, {place:?}: {apart} {median}"
            );
        }
    }
}

/// With roll, the nearest of four looks counts at edges: a silhouette is off by up to half a pixel.
#[test]
fn rolled_planes_see_it_up_to_silhouettes() {
    let found = figures(&[(8.0, 30.0), (-12.0, -65.0), (-5.0, 90.0), (-8.0, 180.0)]);
    let bounds = [1.5e-4, 8e-3, 2e-2, 1e-3, 0.005];
    assert!(found.iter().zip(bounds).all(|(found, bound)| *found <= bound), "{found:?}");
}

#[test]
fn frames_do_not_depend_on_workers_or_task_size() {
    let area = hills();
    for (pitch, roll) in [(-9.0, 4.0), (-80.0, 30.0)] {
        let camera = camera(&area, pitch, roll);
        let picture = |workers, lines, rows| {
            let farm = Farm::new(workers).unwrap().with_task_size(TaskSize { lines, rows });
            Renderer::new(&area, &options()).picture(&camera, &farm).unwrap().0
        };
        let expected = picture(1, 8, 8);
        for (workers, lines, rows) in [(2, 8, 8), (3, 64, 1), (2, 1, 500), (5, 16, 7)] {
            let same = picture(workers, lines, rows) == expected;
            assert!(same, "pitch {pitch}: {workers} workers, {lines} lines, {rows} rows");
        }
    }
}

/// The memory of planes is used again: what a frame before left in it must not be seen.
#[test]
fn frames_do_not_depend_on_frames_before() {
    let area = &*AREA;
    let farm = Farm::new(1).unwrap();
    let used = Renderer::new(area, &options());
    let views = [(-10.0, 0.0), (25.0, 40.0), (-30.0, 200.0), (0.0, 90.0), (-9.0, -4.0), (12.0, 0.0)];
    for (pitch, roll) in views.into_iter().flat_map(|view| [view, (-90.0 - view.0, view.1)]) {
        let camera = camera(area, pitch, roll);
        let fresh = Renderer::new(area, &options());
        let rgb = |renderer: &Renderer<'_>| renderer.picture(&camera, &farm).unwrap().0.rgb;
        assert!(rgb(&used) == rgb(&fresh), "pitch {pitch}, roll {roll}");
        let frame = |renderer: &Renderer<'_>| renderer.frame(&camera, &farm).unwrap().frame;
        let (used, fresh) = (frame(&used), frame(&fresh));
        assert!(used.range == fresh.range && used.colour == fresh.colour, "pitch {pitch}, roll {roll}");
    }
}

/// Beside and within holes planes have no surface: whatever is next to them must keep its light.
#[test]
fn light_beside_holes_is_that_of_the_ground() {
    let grid = Grid { nx: 400, ny: 400, spacing: 10.0, origin: DVec2::ZERO };
    let (mut heights, mut colours) = (Vec::new(), Vec::new());
    for (y, x) in (0..400_i32).flat_map(|y| (0..400_i32).map(move |x| (y, x))) {
        let hole = (x / 37 + y / 29) % 3 == 0 && (180..330).contains(&y);
        heights.push(if hole { f64::NAN } else { 100.0 + f64::from(y) });
        // Never darker than a grey of 100 of 255.
        colours.push(if (x / 3 + y / 2) % 2 == 0 { [255, 250, 245] } else { [100, 110, 120] });
    }

    let area = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
    let farm = Farm::new(1).unwrap();
    for (yaw, hfov) in [(0.0, 60.0), (13.0, 40.0), (-31.0, 80.0), (44.0, 60.0)] {
        let attitude = Attitude { yaw, pitch: -6.0, roll: 0.0 };
        let camera = Camera::new(Pose { eye: DVec3::new(2000.0, 500.0, 450.0), attitude, hfov }, 200, 120);
        let clear = RenderOptions { visibility: f64::INFINITY, ..options() };
        let frame = Renderer::new(&area, &clear).frame(&camera, &farm).unwrap().frame;
        assert!(frame.range.iter().any(|range| range.is_finite()));
        for (index, light) in frame.colour.iter().enumerate() {
            let within = light.iter().all(|light| (0.02..2.0).contains(light));
            assert!(within, "yaw {yaw}, pixel {index}: {light:?}");
        }
    }
}

#[test]
fn instruction_sets_differ_by_rounding() {
    let area = hills();
    let farm = Farm::new(1).unwrap();
    let (mut pixels, mut different) = (0, 0);
    for (pitch, roll) in [(-10.0, 0.0), (3.0, 25.0), (-75.0, 10.0)] {
        let camera = camera(&area, pitch, roll);
        let picture =
            |isa| Renderer::new(&area, &options()).with_isa(isa).picture(&camera, &farm).unwrap().0.rgb;
        let expected = picture(Isa::PORTABLE);
        for isa in Isa::available() {
            let found = picture(isa);
            pixels += found.len() / 3;
            let pairs = found.chunks(3).zip(expected.chunks(3));
            different += pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count();
        }
    }
    assert!(different as f64 <= 1e-4 * pixels as f64, "{different} of {pixels}");
}

/// Sixteen planes of a coarse, wide screen would span more than a right angle.
#[test]
fn coarse_wide_screens_are_seen_right() {
    let area = &*AREA;
    let farm = Farm::new(1).unwrap();
    let fine = RenderOptions { detail: 50.0, ..options() };
    let eye = (area.header().grid.origin + DVec2::new(2500.0, 1500.0)).extend(520.0);
    for (yaw, width) in [(45.0, 16), (45.0, 5), (130.0, 33)] {
        let pose = Pose { eye, attitude: Attitude { yaw, pitch: -3.0, roll: 0.0 }, hfov: 140.0 };
        let camera = Camera::new(pose, width, width);
        let truth = render_reference(area, &camera, &fine, &farm).unwrap().frame;
        let found = Renderer::new(area, &fine).frame(&camera, &farm).unwrap().frame;
        let (errors, apart) = compare(&found, &truth);
        let median = errors[errors.len() / 2];
        assert!(median < 1e-3 && apart < 0.05, "yaw {yaw}, {width} pixels: {median} {apart}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(80))]

    #[test]
    fn any_view_ends_in_a_picture(
        x in -9000.0..15_000.0_f64, y in -9000.0..15_000.0_f64, z in -200.0..60_000.0_f64,
        yaw in 0.0..360.0_f64, pitch in -90.0..90.0_f64, roll in 0.0..360.0_f64, hfov in 0.1..175.0_f64,
        width in 1..70_u32, height in 1..50_u32,
    ) {
        let area = &*AREA;
        let eye = (area.header().grid.origin + DVec2::new(x, y)).extend(z);
        let camera = Camera::new(Pose { eye, attitude: Attitude { yaw, pitch, roll }, hfov }, width, height);
        let frame = Renderer::new(area, &options()).frame(&camera, &Farm::new(1).unwrap()).unwrap().frame;
        prop_assert!(frame.range.iter().all(|&range| range >= 0.0));
        prop_assert!(frame.colour.iter().flatten().all(|light| (0.0..10.0).contains(light)));
    }
}

/// Trajectories are splines: where there is no roll, they leave some 10⁻¹⁵ degrees.
#[test]
fn a_roll_of_rounding_errors_is_none() {
    let area = &*AREA;
    let farm = Farm::new(1).unwrap();
    let picture =
        |roll| Renderer::new(area, &options()).picture(&camera(area, -10.0, roll), &farm).unwrap().0.rgb;
    assert!(picture(8.0e-16) == picture(0.0));
    assert!(picture(0.5) != picture(0.0));
}

#[test]
fn a_picture_is_its_frame_in_8_bits() {
    let area = hills();
    let farm = Farm::new(1).unwrap();
    let camera = camera(&area, -10.0, 0.0);
    let renderer = Renderer::new(&area, &options());
    let picture = renderer.picture(&camera, &farm).unwrap().0;
    let frame = renderer.frame(&camera, &farm).unwrap().frame;
    let encoded = hedgehop::colour::srgb8_picture(&frame.colour);
    assert!(picture.rgb.iter().zip(&encoded).all(|(a, b)| a.abs_diff(*b) <= 1));
    assert!(frame.range.iter().zip(&frame.normal).all(|(range, normal)| {
        range.is_finite() == (DVec3::from_array(normal.map(f64::from)).length() > 0.5)
    }));
}
