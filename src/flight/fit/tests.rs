use std::f64::consts::TAU;

use hedgehop_testing::Random;

use super::super::raw::RawFix;
use super::super::track::{Altitude, AltitudeMode, Fix, Horizontal};
use super::*;

fn fix(time: f64, accuracy: Option<f64>) -> Fix {
    let altitude = Altitude { metres: 0.0, mode: AltitudeMode::Msl };
    Fix { accuracy, ..RawFix::positioned(0, time, Horizontal::Xy(0.0, 0.0), altitude).fix }
}

fn sampling(times: &[f64]) -> Sampling {
    Sampling::new(&times.iter().map(|time| fix(*time, None)).collect::<Vec<_>>())
}

/// Normally distributed (Box and Muller 1958).
fn normal(random: &mut Random) -> f64 {
    (-2.0 * (1.0 - random.share()).ln().min(0.0)).sqrt() * (TAU * random.share()).cos()
}

/// Places along both axes at each time, with noise of `sigma` metres: `[axis][fix]`.
fn noisy(times: &[f64], sigma: f64, seed: u64, place: impl Fn(f64) -> [f64; 2]) -> Vec<Vec<f64>> {
    let mut random = Random(seed);
    let places: Vec<[f64; 2]> =
        times.iter().map(|&time| place(time).map(|at| at + sigma * normal(&mut random))).collect();
    [0, 1].map(|axis| places.iter().map(|place| place[axis]).collect()).to_vec()
}

fn seconds(count: u32) -> Vec<f64> {
    (0..count).map(f64::from).collect()
}

/// A circle that is flown at 10 m/s.
fn circle(radius: f64) -> impl Fn(f64) -> [f64; 2] {
    move |time| [radius * (10.0 * time / radius).cos(), radius * (10.0 * time / radius).sin()]
}

#[test]
fn noise_is_as_large_as_it_is_said_to_be() {
    for (interval, sigma) in [(1.0, 1.5), (0.2, 0.3), (1.5, 4.0)] {
        let times: Vec<f64> =
            (0..900).map(|fix| interval * (f64::from(fix) + 0.2 * f64::from(fix % 3))).collect();
        let mut axes = noisy(&times, sigma, 3, |time| [12.0 * time, 500.0 * (0.01 * time).sin()]);
        let found = without_noise(&sampling(&times), &mut axes).unwrap();
        assert!((found / sigma - 1.0).abs() < 0.1, "{found} for {sigma}");
    }
}

/// Greatest error of the direction between neighbouring fixes, degrees, of a glide at 10 m/s.
fn most_off(interval: f64, seed: u64) -> f64 {
    let times: Vec<f64> = (0..(300.0 / interval) as u32).map(|fix| interval * f64::from(fix)).collect();
    let mut axes = noisy(&times, 1.5, seed, |time| [4e5 + 8.7 * time, 5e6 - 5.0 * time]);
    without_noise(&sampling(&times), &mut axes).unwrap();
    let direction = |fix: usize| {
        let [east, north] = [0, 1].map(|axis| axes[axis][fix] - axes[axis][fix - 1]);
        (north.atan2(east) - (-5.0_f64).atan2(8.7)).to_degrees().abs()
    };
    (1..times.len()).map(direction).fold(0.0, f64::max)
}

#[test]
fn straight_flight_keeps_its_direction() {
    for seed in 1..=8 {
        let off = most_off(1.0, seed);
        assert!(off < 0.3, "{off}° of seed {seed}");
    }
}

#[test]
fn turns_keep_their_radius() {
    for (radius, sigma) in [(30.0, 1.5), (30.0, 0.5), (200.0, 1.5), (20.0, 1.5)] {
        let times = seconds(400);
        let mut axes = noisy(&times, sigma, 5, circle(radius));
        without_noise(&sampling(&times), &mut axes).unwrap();
        let mean = (20..380).map(|fix| axes[0][fix].hypot(axes[1][fix])).sum::<f64>() / 360.0;
        assert!((mean / radius - 1.0).abs() < 0.02, "{mean} m for {radius} m");
    }
}

#[test]
fn small_swings_go_and_large_ones_stay() {
    let times = seconds(600);
    let kept = |amplitude: f64| {
        let place = |time: f64| [9.0 * time, amplitude * (TAU * time / 12.0).sin()];
        let mut axes = noisy(&times, 1.0, 9, place);
        without_noise(&sampling(&times), &mut axes).unwrap();
        let sum: f64 = times.iter().zip(&axes[1]).map(|(time, y)| y * (TAU * time / 12.0).sin()).sum();
        sum / (0.5 * 600.0 * amplitude)
    };
    assert!(kept(0.5) < 0.1 && kept(6.0) > 0.9, "{} {}", kept(0.5), kept(6.0));
}

/// A corner is flown round within some metres, and nothing swings beside it.
#[test]
fn corners_stay() {
    let times = seconds(200);
    let corner = |time: f64| [12.0 * time.min(100.0), 12.0 * (time - 100.0).max(0.0)];
    let mut axes = noisy(&times, 1.5, 4, corner);
    without_noise(&sampling(&times), &mut axes).unwrap();
    for (fix, time) in times.iter().enumerate() {
        let place = corner(*time);
        let off = (axes[0][fix] - place[0]).hypot(axes[1][fix] - place[1]);
        assert!(off < 7.0, "{off} m at fix {fix}");
    }
}

/// A wide turn, of which some fixes are ten times as unsure as the others, and say so.
#[test]
fn unsure_fixes_count_less() {
    let times = seconds(300);
    let accuracy = |at: usize| if at % 4 == 3 { 60.0 } else { 6.0 };
    let errors = |tells: bool| {
        let mut random = Random(6);
        let places = times.iter().map(|time| circle(200.0)(*time));
        let mut noisy = Vec::new();
        for (at, place) in places.enumerate() {
            noisy.push(place.map(|x| x + accuracy(at) / 6.0 * normal(&mut random)));
        }
        let mut axes = [0, 1].map(|axis| noisy.iter().map(|place| place[axis]).collect::<Vec<_>>());
        let fixes = times.iter().enumerate().map(|(at, time)| fix(*time, tells.then_some(accuracy(at))));
        without_noise(&Sampling::new(&fixes.collect::<Vec<_>>()), &mut axes).unwrap();
        let error = |at: usize| (axes[0][at].hypot(axes[1][at]) - 200.0).powi(2);
        (0..300).map(error).sum::<f64>().sqrt()
    };
    assert!(errors(true) < 0.5 * errors(false), "{} {}", errors(true), errors(false));
}

#[test]
fn what_is_exact_stays_exact() {
    // A parabola far from the origin at uneven times.
    let times: Vec<f64> = (0..900).map(|fix| 0.1 * (f64::from(fix) + 0.3 * f64::from(fix % 4))).collect();
    let parabola: Vec<f64> = times.iter().map(|time| 5.2e6 + 40.0 * time - 0.2 * time * time).collect();
    let mut axes = vec![parabola.clone()];
    assert_eq!(without_noise(&sampling(&times), &mut axes), None);
    assert_eq!(axes[0], parabola);
    slower_than(MOST_INTERVALS * 0.1, &sampling(&times), &mut axes);
    for (found, exact) in axes[0].iter().zip(&parabola) {
        assert!((found - exact).abs() < 1e-3, "{found} for {exact}");
    }

    // Turns, a corner and a stop without noise.
    let path = |time: f64| {
        let way = 12.0 * time.min(60.0) + 12.0 * (time - 100.0).clamp(0.0, 60.0);
        [way.min(400.0) + 40.0 * (0.05 * way).sin(), (way - 400.0).max(0.0)]
    };
    let times = seconds(200);
    let exact = noisy(&times, 0.0, 1, path);
    let mut axes = exact.clone();
    without_noise(&sampling(&times), &mut axes);
    for (found, exact) in axes.iter().flatten().zip(exact.iter().flatten()) {
        assert!((found - exact).abs() < 5e-3, "{found} for {exact}");
    }
}

#[test]
fn periods_part_what_goes_from_what_stays() {
    let times: Vec<f64> = (0..2000).map(|fix| 0.5 * f64::from(fix)).collect();
    let wave =
        |period: f64| -> Vec<f64> { times.iter().map(|time| 10.0 * (TAU * time / period).sin()).collect() };
    for (period, kept) in [(10.0, 0.0..0.03), (20.0, 0.45..0.55), (60.0, 0.98..1.001)] {
        let mut axes = vec![wave(period)];
        slower_than(20.0, &sampling(&times), &mut axes);
        let product: f64 = axes[0].iter().zip(wave(period)).map(|(found, exact)| found * exact).sum();
        let share = product / (0.5 * 100.0 * 2000.0);
        assert!(kept.contains(&share), "{share} of a period of {period} s");
    }
}

#[test]
fn waypoints_and_short_tracks_stay() {
    let far: Vec<f64> = (0..30).map(|fix| 30.0 * f64::from(fix)).collect();
    let mut axes = noisy(&far, 20.0, 1, |time| [time, 0.0]);
    let given = axes.clone();
    assert_eq!(without_noise(&sampling(&far), &mut axes), None);
    assert_eq!(axes, given);
    let zigzag = &mut [vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]];
    assert_eq!(without_noise(&sampling(&seconds(7)), zigzag), None);
    for times in [vec![], vec![0.0], vec![0.0, 1.0, 2.0]] {
        let mut axes = vec![times.clone()];
        assert_eq!(without_noise(&sampling(&times), &mut axes), None);
        slower_than(10.0, &sampling(&times), &mut axes);
        assert_eq!(axes[0], times);
    }
}

/// Fixes as close as clocks tell, gaps, and a receiver that stands still.
#[test]
fn odd_tracks_stay_finite_and_near() {
    let mut times = seconds(300);
    times[100] = times[99] + 1e-6;
    times.iter_mut().skip(200).for_each(|time| *time += 3600.0);
    let place = |time: f64| [3.0 * time.min(150.0), if time > 3000.0 { 500.0 } else { 0.0 }];
    let mut axes = noisy(&times, 2.0, 8, place);
    let given = axes.clone();
    let sigma = without_noise(&sampling(&times), &mut axes).unwrap();
    for (found, given) in axes.iter().flatten().zip(given.iter().flatten()) {
        assert!((found - given).abs() <= REACH * sigma + 1e-6, "{found} for {given}");
    }
    for (fix, time) in times.iter().enumerate() {
        assert!((axes[1][fix] - place(*time)[1]).abs() < 2.0, "{} at fix {fix}", axes[1][fix]);
    }
}
