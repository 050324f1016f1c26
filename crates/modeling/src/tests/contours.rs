//! Ridges and valleys as the contours of a scene: silhouettes, joins, feet.
//!
//! Of Bunker and Ferris, AFHRL-TR-77-66 (1977), §3: units 200 ft wide and 100 ft high or deep, alone and strung together.

use glam::{DVec2, DVec3};

use super::support::{Area, built};
use crate::synthetic::Terrain;
use hedgehop_conic::ToneLaw;

const FOOT: f64 = 0.3048;
const WIDTH: f64 = 200.0 * FOOT;
const HEIGHT: f64 = 100.0 * FOOT;
const SIDE: f64 = 600.0;

/// Radians of a pixel: 1920 of them across 60°.
const PIXEL: f64 = 5.5e-4;

fn made(line: &[[f64; 2]], width_m: f64, height_m: f64) -> Area {
    let line = line.iter().map(|place| DVec2::from_array(*place)).collect();
    built(vec![], vec![], |options| {
        options.local = true;
        options.bbox = Some([0.0, 0.0, SIDE, SIDE]);
        options.spacing = Some(1.0);
        let plane = Terrain::Plane { height_m: 0.0, centre: DVec2::ZERO, slope: 0.0, upward_deg: 0.0 };
        let ridge = Terrain::Ridge { line: Vec::clone(&line), width_m, crest_m: 0.0, height_m };
        options.synthetic.terrain = vec![plane, ridge];
    })
}

/// Height between the middles of voxels, metres.
fn height(area: &Area, at: DVec2) -> f64 {
    let low = (at - 0.5).floor().max(DVec2::ZERO).min(DVec2::splat(SIDE - 2.0));
    let part = at - 0.5 - low;
    let of = |x: f64, y: f64| area.height((low.x + x) as u32, (low.y + y) as u32).unwrap();
    let row = |y: f64| of(0.0, y) + (of(1.0, y) - of(0.0, y)) * part.x;
    row(0.0) + (row(1.0) - row(0.0)) * part.y
}

/// Greatest elevation angle of some ground on a way from an eye, radians, and where.
fn skyline(eye: DVec3, towards: DVec2, ground: impl Fn(DVec2) -> f64) -> f64 {
    let steps = (0..1600).map(|step| 120.0 + 0.25 * f64::from(step));
    let angle = |away: f64| ((ground(eye.truncate() + towards * away) - eye.z) / away).atan();
    steps.map(angle).fold(f64::NEG_INFINITY, f64::max)
}

/// A straight ridge from south to north.
const STRAIGHT: [[f64; 2]; 2] = [[300.0, -4000.0], [300.0, 4600.0]];

#[test]
fn a_ridge_crosses_the_horizon_of_eyes_below_its_crest() {
    let area = made(&STRAIGHT, WIDTH, HEIGHT);
    for (feet, crosses) in [(50.0, true), (90.0, true), (99.0, true), (101.0, false), (150.0, false)] {
        let eye = DVec3::new(20.0, 300.0, feet * FOOT);
        for azimuth in [-20.0_f64, 0.0, 17.0] {
            let (sin, cos) = azimuth.to_radians().sin_cos();
            let found = skyline(eye, DVec2::new(cos, sin), |at| height(&area, at));
            assert_eq!(found > 0.0, crosses, "an eye at {feet} ft: {found}");
        }
    }
}

#[test]
fn silhouettes_are_within_a_pixel_of_the_cross_section() {
    let area = made(&STRAIGHT, WIDTH, HEIGHT);
    let exact = |at: DVec2| {
        let t = (at.x - 300.0) / (0.5 * WIDTH);
        HEIGHT * (1.0 - t * t).max(0.0).powi(2)
    };
    let mut most = 0.0_f64;
    for feet in [20.0, 60.0, 120.0, 350.0] {
        let eye = DVec3::new(20.0, 300.0, feet * FOOT);
        for azimuth in -20..=20 {
            let (sin, cos) = f64::from(azimuth).to_radians().sin_cos();
            let of = |ground: &dyn Fn(DVec2) -> f64| skyline(eye, DVec2::new(cos, sin), ground);
            most = most.max((of(&|at| height(&area, at)) - of(&exact)).abs());
        }
    }
    assert!(most < PIXEL, "{} pixels", most / PIXEL);
}

/// Units strung into a winding chain: neither gap nor crease where they join, up or down.
#[test]
fn joins_have_neither_gap_nor_crease() {
    let line = [[60.0, 90.0], [260.0, 150.0], [330.0, 380.0], [540.0, 480.0]];
    for sign in [1.0, -1.0] {
        let area = made(&line, WIDTH, sign * HEIGHT);
        for leg in line.windows(2).map(|leg| [0, 1].map(|end| DVec2::from_array(leg[end]))) {
            let steps = (leg[1] - leg[0]).length() as u32;
            for step in 0..=steps {
                let at = leg[0].lerp(leg[1], f64::from(step) / f64::from(steps));
                let crest = sign * height(&area, at);
                assert!((crest / HEIGHT - 1.0).abs() < 0.005, "{at}: {crest}");
            }
        }

        // Between voxels heights bend by less than a voxel; those of the plain distance from the line would by 1.3 m where legs meet.
        let bend = |a: f64, b: f64, c: f64| (a - 2.0 * b + c).abs();
        let of = |x: u32, y: u32| area.height(x, y).unwrap();
        let most = (1..599).flat_map(|y| (1..599).map(move |x| (x, y))).map(|(x, y)| {
            let here = of(x, y);
            bend(of(x - 1, y), here, of(x + 1, y)).max(bend(of(x, y - 1), here, of(x, y + 1)))
        });
        let most = most.fold(0.0, f64::max);
        assert!(most < 0.6, "{most}");
    }
}

/// The base line is gone: tones change over the foot in small steps, where flat faces of as steep a ridge jump.
#[test]
fn the_foot_of_a_ridge_has_no_base_line() {
    let law = ToneLaw { dark: 0.0, bright: 150.0, light: DVec3::new(-0.4364, 0.2182, -0.8729) };
    let flat = (law.tone(DVec3::Z) - law.tone(DVec3::new(-1.0, 0.0, 1.0))).abs();
    assert!(flat > 40.0);
    // Alone, and with a band of 100 ft to either side.
    for (width, share) in [(WIDTH, 0.3), (2.0 * WIDTH, 0.07)] {
        let area = made(&STRAIGHT, width, HEIGHT);
        let tone = |x: u32| {
            let rise = 0.5 * (area.height(x + 1, 300).unwrap() - area.height(x - 1, 300).unwrap());
            law.tone(DVec3::new(-rise, 0.0, 1.0))
        };
        let tones: Vec<f64> = (200..300).map(tone).collect();
        let steps = tones.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let most = steps.fold(0.0, f64::max);
        assert!((tones[0] - law.tone(DVec3::Z)).abs() < 0.1);
        assert!(most < share * flat, "{width} m wide: {most} of {flat}");
    }
}
