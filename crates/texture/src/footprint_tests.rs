use super::*;
use crate::code::CyclicCode;
use crate::pixel_tone::{Averaging, PixelTones};
use crate::projection::Projection;
use hedgehop_base::chance::Random;

/// Footprint of so many cells along and across, rolled about the line of sight, then turned by a heading.
fn seen(size: [f64; 2], roll_deg: f64, heading_deg: f64, centre: [f64; 2]) -> Footprint {
    let turned = |[x, y]: [f64; 2], deg: f64| {
        let (sin, cos) = deg.to_radians().sin_cos();
        [x * cos - y * sin, x * sin + y * cos]
    };
    let edges = [[1.0, 0.0], [0.0, 1.0]].map(|pixel| {
        let [along, across] = turned(pixel, roll_deg);
        turned([along * size[0], across * size[1]], heading_deg)
    });
    Footprint { centre, edges }
}

fn tones() -> PixelTones {
    PixelTones::new(CyclicCode::default()).unwrap()
}

fn anywhere(random: &mut Random) -> [f64; 2] {
    [random.unit() * 255.0, random.unit() * 255.0]
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn groups_are_those_of_table_5() {
    // 1000 ft and 5 nmi, 1000 and 3, 300 and 2, 300 and ½: cells along and across as printed, 6 ft each.
    for (along, across, side, count) in
        [(86.0, 3.0, 3, 29), (31.0, 2.0, 2, 16), (46.0, 1.0, 1, 46), (3.0, 1.0, 1, 3)]
    {
        let groups = seen([along, across], 0.0, 0.0, [0.0, 0.0]).groups();
        assert_eq!((groups.side, groups.corners.len()), (side, count));
    }
    let footprint = Projection::OF_THE_STUDY.footprint(1000.0, 5.0 * 6076.1);
    let groups = seen([footprint.along / 6.0, footprint.across / 6.0], 0.0, 0.0, [0.0, 0.0]).groups();
    assert_eq!(groups.side, 3);
}

#[test]
fn groups_follow_the_centreline_along_the_longer_side() {
    let flat = seen([40.0, 4.0], 0.0, 0.0, [100.0, 50.0]);
    assert_eq!(flat.stacking(), Stacking::FreeY);
    assert_eq!(flat.groups().corners, (0..10).map(|k| [80 + 4 * k, 48]).collect::<Vec<_>>());

    let upright = seen([40.0, 4.0], 0.0, 90.0, [50.0, 100.0]);
    assert_eq!(upright.stacking(), Stacking::FreeX);
    assert_eq!(upright.groups().corners, (0..10).map(|k| [48, 80 + 4 * k]).collect::<Vec<_>>());

    let slanting = seen([60.0, 3.0], 0.0, 30.0, [0.0, 0.0]).groups();
    for [x, y] in slanting.corners {
        let half = f64::from(slanting.side) / 2.0;
        let off = (y as f64 + half) - (x as f64 + half) * 30_f64.to_radians().tan();
        assert!(off.abs() < 1.2, "{off}");
    }
}

#[test]
fn slices_add_up_to_the_footprint() {
    for (roll, heading) in [(0.0, 0.0), (30.0, 0.0), (45.0, 45.0), (0.0, 90.0), (10.0, 200.0)] {
        let footprint = seen([51.0, 3.3], roll, heading, [-7.0, 1e6]);
        for count in [1, 2, 9, 64] {
            let slices = footprint.slices(count);
            let share: f64 = slices.iter().map(|slice| slice.share).sum();
            let area: f64 = slices.iter().map(|slice| slice.over.area()).sum();
            assert!(
                (share - 1.0).abs() < 1e-9 && (area / footprint.area() - 1.0).abs() < 1e-6,
                "{share} {area}"
            );
        }
    }
    assert!(Footprint { centre: [0.0; 2], edges: [[1.0, 1.0], [2.0, 2.0]] }.slices(3).is_empty());
}

#[test]
fn exact_slices_equal_many_samples_however_the_view_is_turned() {
    let (tones, mut random) = (tones(), Random(9));
    for size in [[86.0, 2.8], [30.7, 1.7], [51.0, 3.3], [10.0, 3.0]] {
        for (roll, heading) in [(0.0, 0.0), (30.0, 0.0), (45.0, 0.0), (0.0, 30.0), (0.0, 45.0), (30.0, 45.0)]
        {
            let errors: Vec<f64> = (0..150)
                .map(|_| {
                    let footprint = seen(size, roll, heading, anywhere(&mut random));
                    tones.tone(&footprint, Averaging::Exact(64))
                        - tones.tone(&footprint, Averaging::Samples(1024))
                })
                .collect();
            assert!(rms(&errors) <= 3.0, "{size:?} rolled {roll}, heading {heading}: {}", rms(&errors));
        }
    }
}

#[test]
fn pixels_have_the_errors_of_the_study() {
    // Cells along and across; rms errors of linear and stepped estimates against exact means.
    let (tones, mut random) = (tones(), Random(67));
    for (size, linear, stepped) in [([86.0, 3.0], 6.4, 7.5), ([31.0, 2.0], 8.0, 7.8), ([46.0, 1.0], 0.9, 0.9)]
    {
        let mut errors = [Vec::new(), Vec::new()];
        for _ in 0..4000 {
            let footprint = seen(size, 0.0, 0.0, anywhere(&mut random));
            let exact = tones.tone(&footprint, Averaging::Exact(1));
            errors[0].push(tones.tone(&footprint, Averaging::Linear) - exact);
            errors[1].push(tones.tone(&footprint, Averaging::Stepped) - exact);
        }
        for (errors, expected) in errors.iter().zip([linear, stepped]) {
            assert!((rms(errors) / expected - 1.0).abs() < 0.12, "{size:?}: {} {expected}", rms(errors));
        }
    }
}

#[test]
fn pixels_along_the_axes_are_exact_in_one_slice() {
    let (tones, mut random) = (tones(), Random(8));
    for _ in 0..200 {
        let footprint = seen([51.0, 3.3], 0.0, 0.0, anywhere(&mut random));
        let difference =
            tones.tone(&footprint, Averaging::Exact(1)) - tones.tone(&footprint, Averaging::Exact(9));
        assert!(difference.abs() < 1e-9, "{difference}");
    }
}
