use super::*;
use crate::cell_box::brute_force;
use crate::code::CyclicCode;
use crate::pattern::Direction;
use crate::projection::Projection;
use hedgehop_base::chance::Random;

fn means(column: i64, row: i64) -> StrandMeans {
    let direction = Direction { column, row };
    StrandMeans::new(Strand { code: CyclicCode::default(), direction, phase: 0 }).unwrap()
}

fn tone(means: &StrandMeans) -> impl Fn(i64, i64) -> f64 {
    |column, row| f64::from(means.strand().tone(column, row))
}

fn any_box(random: &mut Random, around: f64) -> CellBox {
    let (x0, y0) = (around + random.unit() * 900.0 - 450.0, random.unit() * 900.0 - 450.0);
    CellBox { x0, x1: x0 + 0.1 + random.unit() * 90.0, y0, y1: y0 + 0.1 + random.unit() * 30.0 }
}

#[test]
fn exact_means_equal_brute_force_in_any_direction() {
    let mut random = Random(1);
    let mut worst = 0.0_f64;
    for (column, row) in [(1, 1), (1, -1), (1, 2), (2, -1), (2, 1), (1, -2), (4, 7)] {
        let means = means(column, row);
        for _ in 0..300 {
            let over = any_box(&mut random, 0.0);
            worst = worst.max((means.mean(over) - brute_force(tone(&means), over)).abs());
        }
    }
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn whole_boxes_have_no_error_at_all() {
    let (means, mut random) = (means(1, 1), Random(2));
    for _ in 0..500 {
        let mut whole = |range: f64| (random.unit() * range).floor();
        let (x0, y0) = (whole(1800.0) - 900.0, whole(1800.0) - 900.0);
        let over = CellBox { x0, x1: x0 + 1.0 + whole(120.0), y0, y1: y0 + 1.0 + whole(60.0) };
        let sum = (brute_force(tone(&means), over) * over.area()).round();
        assert_eq!((means.mean(over) * over.area()).round(), sum);
        assert_eq!(f64::from(means.mean_fixed(over.into())), (sum / over.area() + 0.5).floor());
    }
}

#[test]
fn means_are_exact_far_away_and_with_longer_codes() {
    let mut random = Random(3);
    for far in [1e9, -1e9] {
        let means = means(2, 1);
        for _ in 0..100 {
            let near = any_box(&mut random, 0.0);
            let eighths = |side: f64| (side * 8.0).round() / 8.0;
            let over = CellBox { x0: eighths(near.x0) + far, x1: eighths(near.x1) + far + 1.0, ..near };
            assert!((means.mean(over) - brute_force(tone(&means), over)).abs() < 1e-9);
        }
    }
    let code = CyclicCode::new(0x1100B).unwrap();
    let long =
        StrandMeans::new(Strand { code, direction: Direction { column: 1, row: 4 }, phase: 77 }).unwrap();
    for _ in 0..200 {
        let over = any_box(&mut random, 30_000.0);
        assert!((long.mean(over) - brute_force(tone(&long), over)).abs() < 1e-6);
    }
}

#[test]
fn detail_against_range_has_the_deviations_of_the_study() {
    // Altitude, feet, range, nautical miles, deviation of grey.
    for (altitude, miles, expected) in
        [(1000.0, 5.0, 11.2), (1000.0, 3.0, 21.1), (300.0, 2.0, 16.9), (300.0, 0.5, 56.0)]
    {
        let footprint = Projection::OF_THE_STUDY.footprint(altitude, miles * 6076.1);
        let (width, height) = (footprint.along / 6.0, footprint.across / 6.0);
        let (means, mut random) = (means(1, 1), Random(16));
        let greys: Vec<f64> = (0..20_000)
            .map(|_| {
                let (x0, y0) = (random.unit() * 255.0, random.unit() * 255.0);
                means.mean(CellBox { x0, x1: x0 + width, y0, y1: y0 + height })
            })
            .collect();
        let mean = greys.iter().sum::<f64>() / greys.len() as f64;
        let squares: f64 = greys.iter().map(|grey| (grey - mean).powi(2)).sum();
        let deviation = (squares / greys.len() as f64).sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.1, "{altitude} ft, {miles} nmi: {deviation}");
    }
}

#[test]
fn whole_numbers_are_within_a_grey_of_real_ones() {
    let (means, mut random) = (means(1, 2), Random(25));
    let mut worst = 0.0_f64;
    for around in [0.0, 1e6, -1e6] {
        for _ in 0..2000 {
            let over = any_box(&mut random, around);
            worst = worst.max((f64::from(means.mean_fixed(over.into())) - means.mean(over)).abs());
        }
    }
    assert!(worst <= 1.0, "{worst} greys");

    let turned = FixedBox { x0: 5, x1: 4, y0: 0, y1: 9 };
    assert_eq!(means.mean_fixed(turned), 128);
}

#[test]
fn directions_without_exact_means_are_refused() {
    let error = |column, row, polynomial| {
        let code = CyclicCode::new(polynomial).unwrap();
        let strand = Strand { code, direction: Direction { column, row }, phase: 0 };
        StrandMeans::new(strand).unwrap_err().to_string()
    };
    assert!(error(3, 1, 0x12B).contains("coprime to its period 255"));
    assert!(error(1, 0, 0x12B).contains("coprime"));
    assert!(error(1, 1, 0x10_0009).contains("degree 20"));
}
