//! Rolling hills from everywhere: no cracks, and no step where one level follows the other.

use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::judge::by_engine;
use super::scene::{Terrain, View, clear_air};
use super::screen::is_of_one_surface;
use hedgehop::frame::Frame;
use hedgehop::render::RenderOptions;
use hedgehop::voxel::MemPages;

const SPACING: f64 = 10.0;
const SIDE: f64 = 6400.0;
const AMPLITUDE: f64 = 45.0;
const WAVE: DVec2 = DVec2::new(1.0 / 190.0, 1.0 / 260.0);
/// Steps of the height code, and arithmetic.
const ROUNDING: f64 = 0.01;

fn hills(place: DVec2) -> f64 {
    300.0 + AMPLITUDE * ((place.x * WAVE.x).sin() + (place.y * WAVE.y).cos())
}

static WORLD: LazyLock<MemPages> = LazyLock::new(|| {
    Terrain::new([(SIDE / SPACING) as u32; 2], SPACING, hills, |_| [90, 120, 60]).in_memory()
});

/// How far a level with voxels of `side` metres may lie from the hills: averaging over a voxel moves a wave
/// by side²/24 of its curvature, interpolation between posts by side²/8; none moves it by more than all of it.
fn tolerance(side: f64) -> f64 {
    let curvature = AMPLITUDE * WAVE.length_squared();
    (side * side * curvature * (1.0 / 24.0 + 1.0 / 8.0)).min(4.0 * AMPLITUDE) + ROUNDING
}

/// Side of the largest voxel that may be seen at a range: it fills no more than a pixel.
fn side_at(view: &View, detail: f64, range: f64) -> f64 {
    (range / (view.focal() * detail)).max(SPACING)
}

/// The edges' outermost half voxel goes on level; there and beyond, the hills say nothing.
fn inside(place: DVec2, side: f64) -> bool {
    (place - 0.5 * SIDE).abs().max_element() < 0.5 * SIDE - 0.5 * side
}

/// Every ray that ended did so on the hills, and every one that did not, never was under them.
fn check_ranges(view: &View, detail: f64, frame: &Frame) -> Result<(), TestCaseError> {
    for (index, pixel) in view.pixels() {
        let direction = view.direction(pixel);
        let range = f64::from(frame.range[index]);
        let at = |range: f64| view.eye + direction * range;
        if range.is_finite() {
            let side = SPACING * 4_f64.powi(i32::from(frame.level[index]));
            let allowed = side_at(view, detail, range);
            prop_assert!(side <= allowed * 1.000_001, "{pixel:?}: a voxel of {side} m at {range} m");
            let hit = at(range);

            // Planes go straight over up to four voxels, and with roll from row to row.
            let side = by_engine(1.0, 4.0) * side;
            let between_rows = by_engine(0.0, 0.1 * range / view.focal());
            if inside(hit.truncate(), side) && is_of_one_surface(frame, index) {
                let wrong = (hit.z - hills(hit.truncate())).abs();
                // A change of level is a wall between the two surfaces: its foot is the finer one's.
                prop_assert!(
                    wrong <= tolerance(side) + tolerance(0.25 * side) + between_rows,
                    "{pixel:?}: {wrong} m off at {range} m"
                );
            }
        } else {
            for step in 1..400 {
                let range = f64::from(step) * 25.0;
                let place = at(range);
                let side = by_engine(1.0, 4.0) * side_at(view, detail, range);
                let above = place.z - hills(place.truncate());
                // With roll, silhouettes of planes are those of the nearest row and plane.
                let silhouette = by_engine(0.0, 0.75 * range / view.focal());
                let clear = !inside(place.truncate(), side) || above > -tolerance(side) - silhouette;
                prop_assert!(clear, "{pixel:?} sees the sky {} m under ground, {range} m away", -above);
            }
        }
    }

    Ok(())
}

/// No pixel sees the sky under one that sees the ground.
///
/// Tangents of elevation over azimuth, of what is highest in each direction, change at most as fast as the
/// ground is steep, at any distance, and along the edge of the area by its slant. So if ground is seen, all that lies lower by more than that is ground.
fn check_cracks(view: &View, frame: &Frame) -> Result<(), TestCaseError> {
    let steepest = 2_f64.sqrt() * AMPLITUDE * WAVE.max_element();
    // Tangent of the angle at which a ray leaves the area, from the normal of the side that it leaves by.
    let slant = |direction: DVec3| {
        let ahead = direction.truncate();
        let side = DVec2::select(ahead.cmpgt(DVec2::ZERO), DVec2::splat(SIDE), DVec2::ZERO);
        let reach = ((side - view.eye.truncate()) / ahead).abs();
        if reach.x < reach.y { (ahead.y / ahead.x).abs() } else { (ahead.x / ahead.y).abs() }
    };
    let [width, height] = view.size.map(i64::from);
    let tangent = |direction: DVec3| direction.z / direction.truncate().length();

    for (index, [column, row]) in view.pixels().filter(|&(index, _)| frame.range[index].is_infinite()) {
        let sky = view.direction([column, row]);
        for (dy, dx) in (-3..=3).flat_map(|dy| (-3..=3).map(move |dx| (dy, dx))) {
            let (x, y) = (i64::from(column) + dx, i64::from(row) + dy);
            if !(0..width).contains(&x) || !(0..height).contains(&y) {
                continue;
            }

            if frame.range[(y * width + x) as usize].is_finite() {
                let ground = view.direction([x as u32, y as u32]);
                let azimuth = sky.truncate().angle_to(ground.truncate()).abs();
                let higher = tangent(ground) - tangent(sky);
                // Along an edge seen at slant ψ, of ground as steep as g: dT/dψ = g / cos ψ − T · tan ψ.
                let slant = slant(sky).max(slant(ground));
                let lowest = tangent(sky).abs().max(tangent(ground).abs());
                let rate = steepest * slant.hypot(1.0) + lowest * slant;
                let slack = by_engine(1e-9, lowest.mul_add(lowest, 1.0) / view.focal());
                prop_assert!(higher <= rate * azimuth + slack, "a crack at {column}, {row} ({index})");
            }
        }
    }

    Ok(())
}

proptest! {
    // Failing cases are printed with their values, and shrunk.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(250) })]

    #[test]
    fn hills_have_neither_cracks_nor_seams(
        x in 0.15..0.85_f64, y in 0.15..0.85_f64, above in 3.0..400.0_f64,
        yaw in 0.0..360.0_f64, pitch in -90.0..25.0_f64, roll in -180.0..180.0_f64,
        level: bool, hfov in 10.0..110.0_f64, detail in 0.15..1.5_f64, tall: bool,
    ) {
        let place = DVec2::new(x, y) * SIDE;
        // A level view is rendered with range coherence, any other ray by ray.
        let ypr = if level { [yaw, 0.0, 0.0] } else { [yaw, pitch, roll] };
        let size = if tall { [18, 40] } else { [40, 24] };
        let view = View { eye: place.extend(hills(place) + above), ypr, hfov, size };
        let frame = view.frame(&WORLD, &RenderOptions { detail, ..clear_air() });
        check_ranges(&view, detail, &frame)?;
        check_cracks(&view, &frame)?;
    }
}
