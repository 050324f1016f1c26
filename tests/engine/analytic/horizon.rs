//! Plane → horizon: where the ground ends on the screen, for a plane without end and for one with an edge.

use glam::{DVec2, DVec3};

use super::judge::by_engine;
use super::scene::{Terrain, View, clear_air};
use hedgehop::frame::Frame;

const GROUND: f64 = 120.0;
const GREY: [u8; 3] = [128; 3];
/// A horizon through the centres of a row of pixels is off by half of one; this much more is arithmetic. In a rolled view
/// planes have rows of their own, and a line fitted to the stairs that pixels make of one of them is uncertain.
fn half_pixel() -> f64 {
    0.5 + by_engine(1e-9, 0.05)
}

/// Width, height, field of view.
const SCREENS: [([u32; 2], f64); 4] =
    [([97, 64], 60.0), ([64, 97], 24.0), ([160, 90], 100.0), ([40, 31], 4.0)];

fn plane(side: u32, spacing: f64) -> Terrain {
    Terrain::new([side; 2], spacing, |_| GROUND, |_| GREY)
}

/// Every pixel whose centre is more than `tolerance` pixels above the line of `normal` sees the sky, and
/// every one as far below it the ground.
#[track_caller]
fn assert_border(view: &View, frame: &Frame, normal: DVec3, tolerance: f64) {
    for (index, pixel) in view.pixels() {
        let above = view.distance(normal, pixel);
        let sky = frame.range[index].is_infinite();
        assert!(above.abs() <= tolerance || sky == (above > 0.0), "{view:?}: {pixel:?} {above} sky {sky}");
    }
}

/// Least-squares line through the middles between neighbouring pixels of which one sees the ground and one
/// the sky: angle to the screen's rows (degrees, 0…180) and distance from the screen's centre (pixels).
/// `None` where the border is not on the screen or only cuts a corner.
fn fitted_border(view: &View, frame: &Frame, steep: bool) -> Option<(f64, f64)> {
    let [width, height] = view.size;
    let ground = |column: u32, row: u32| frame.range[(row * width + column) as usize].is_finite();
    let (lines, steps) = if steep { (height, width) } else { (width, height) };
    let at = |line: u32, step: u32| if steep { (step, line) } else { (line, step) };
    let mut points = Vec::new();

    for line in 0..lines {
        for step in 1..steps {
            let (before, after) = (at(line, step - 1), at(line, step));
            if ground(before.0, before.1) != ground(after.0, after.1) {
                points.push((f64::from(line) + 0.5, f64::from(step)));
            }
        }
    }

    if points.len() < 20 {
        return None;
    }

    let count = points.len() as f64;
    let mean =
        points.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / count, sum.1 + point.1 / count));
    let covariance: f64 = points.iter().map(|point| (point.0 - mean.0) * (point.1 - mean.1)).sum();
    let slope = covariance / points.iter().map(|point| (point.0 - mean.0).powi(2)).sum::<f64>();
    let middle = (0.5 * f64::from(lines), 0.5 * f64::from(steps));
    let offset = (mean.1 - middle.1 + slope * (middle.0 - mean.0)) / slope.hypot(1.0);
    let angle = if steep { 90.0 - slope.atan().to_degrees() } else { slope.atan().to_degrees() };

    Some((angle.rem_euclid(180.0), offset.abs()))
}

#[test]
fn an_endless_plane_ends_at_the_horizon() {
    // So wide that its edge lies a millionth of a degree under the horizon.
    let world = plane(256, 1.0e7).in_memory();
    let eye = DVec3::new(1.3e9, 1.25e9, GROUND + 30.0);
    let mut fitted = 0;

    for (size, hfov) in SCREENS {
        for pitch in [-20.0, -7.3, -1.0, 0.0, 0.4, 5.0, 20.0] {
            for roll in [0.0, 30.0, 90.0, 180.0, -65.0] {
                let view = View { eye, ypr: [33.0, pitch, roll], hfov, size };
                let frame = view.frame(&world, &clear_air());
                assert_border(&view, &frame, DVec3::Z, 0.5);

                // Right wing down by `roll` shows the horizon rising to the right, at `focal · tan(pitch)` from
                // the centre.
                let expected = (-roll).rem_euclid(180.0);
                let steep = (expected - 90.0).abs() < 45.0;

                if let Some((angle, offset)) = fitted_border(&view, &frame, steep) {
                    fitted += 1;
                    let turned = (angle - expected + 90.0).rem_euclid(180.0) - 90.0;
                    assert!(turned.abs() < 1.0, "{view:?}: {angle}° for {expected}°");
                    let exact = view.focal() * pitch.abs().to_radians().tan();
                    assert!((offset - exact).abs() <= half_pixel(), "{view:?}: {offset} px for {exact}");
                }
            }
        }
    }

    assert!(fitted > 60, "the border was on {fitted} screens only");
}

#[test]
fn the_far_edge_is_seen_in_its_row() {
    let (side, height) = (25_600.0, 900.0);
    let world = plane(512, 50.0).in_memory();
    for (size, hfov) in SCREENS {
        // Steep fields of view would see past the corners.
        let hfov = hfov.min(70.0);
        for pitch in [-20.0, -6.0, 0.0, 9.0, 20.0] {
            for roll in [0.0, 30.0, 90.0, 180.0] {
                for yaw in [0.0, 90.0, 180.0, 270.0_f64] {
                    let eye = DVec3::new(0.5 * side, 0.5 * side, GROUND + height);
                    let view = View { eye, ypr: [yaw, pitch, roll], hfov, size };
                    let frame = view.frame(&world, &clear_air());
                    let ahead = DVec2::from_angle((90.0 - yaw).to_radians()) * 0.5 * side;
                    let edge = DVec2::new(-ahead.y, ahead.x).extend(0.0);
                    let normal = ahead.extend(-height).cross(edge);

                    // Only where that edge is the far one: within 45° of straight ahead.
                    let beyond = |pixel| {
                        let ground = view.direction(pixel).truncate();
                        ground.length() * 0.72 > ground.dot(ahead.normalize())
                    };

                    for (index, pixel) in view.pixels().filter(|&(_, pixel)| !beyond(pixel)) {
                        let above = view.distance(normal, pixel);
                        let sky = frame.range[index].is_infinite();
                        assert!(
                            above.abs() <= 0.5 || sky == (above > 0.0),
                            "{view:?}: {pixel:?} {above} {sky}"
                        );
                    }

                    if roll == 0.0 {
                        let depression = (height / (0.5 * side)).atan();
                        let row =
                            0.5 * f64::from(size[1]) + view.focal() * (depression + pitch.to_radians()).tan();
                        let middle = (0..size[1])
                            .filter(|row| frame.range[(row * size[0] + size[0] / 2) as usize].is_infinite());
                        let found = middle.count() as f64;
                        let exact = row.clamp(0.0, f64::from(size[1]));
                        assert!((found - exact).abs() <= 0.5, "{view:?}: row {found} for {exact}");
                    }
                }
            }
        }
    }
}

#[test]
fn an_area_is_seen_from_outside_between_its_edges() {
    let (side, height) = (12_800.0, 500.0);
    let world = plane(256, 50.0).in_memory();
    let eye = DVec3::new(0.5 * side, -3000.0, GROUND + height);
    for roll in [0.0, 90.0] {
        let view = View { eye, ypr: [0.0, -5.0, roll], hfov: 40.0, size: [80, 80] };
        let frame = view.frame(&world, &clear_air());
        let near_edge = (-eye.truncate()).extend(-height).cross(DVec3::NEG_X);
        let (mut side_seen, mut top_seen) = (0, 0);

        for (index, pixel) in view.pixels() {
            let direction = view.direction(pixel);
            let found = f64::from(frame.range[index]);
            let to_plane = height / -direction.z;
            let to_side = -eye.y / direction.y;
            let inside = |range: f64| {
                let hit = eye + direction * range;
                (hit.truncate() - 0.5 * side).abs().cmplt(DVec2::splat(0.5 * side - 1e-6 * range)).all()
            };
            let across = (eye + direction * to_side).x;
            if view.distance(near_edge, pixel).abs() <= 0.5 || across.min(side - across).abs() < 20.0 {
                continue;
            }

            if direction.z < 0.0 && inside(to_plane) {
                top_seen += 1;
                assert!((found / to_plane - 1.0).abs() < 1e-4, "{pixel:?} of roll {roll}: {found}");
            } else if direction.z < 0.0 && to_plane < to_side && (0.0..side).contains(&across) {
                // The ground is the top of a solid, and that has sides.
                side_seen += 1;
                assert!((found / to_side - 1.0).abs() < 1e-6, "{pixel:?} of roll {roll}: {found}");
            } else {
                assert!(found.is_infinite(), "{pixel:?} of roll {roll}: {found}");
            }
        }

        assert!(side_seen > 500 && top_seen > 500, "{side_seen} {top_seen}");
    }

    // From below the ground's height, the solid's side is in the way.
    let view =
        View { eye: DVec3::new(6000.0, -400.0, 50.0), ypr: [0.0, 0.0, 0.0], hfov: 30.0, size: [32, 16] };
    let frame = view.frame(&world, &clear_air());
    for (index, pixel) in view.pixels() {
        let exact = 400.0 / view.direction(pixel).y;
        assert!((f64::from(frame.range[index]) / exact - 1.0).abs() < 1e-6, "{pixel:?}");
    }

    // With its back to the area it sees nothing but sky.
    let away = View { ypr: [180.0, 0.0, 0.0], ..view };
    assert!(away.frame(&world, &clear_air()).range.iter().all(|range| range.is_infinite()));
}
