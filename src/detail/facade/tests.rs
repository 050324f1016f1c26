use super::*;
use crate::voxel::FacadeStyle;
use hedgehop_base::chance::Random;

const CODE: HeightCode = HeightCode { scale: 0.01, offset: 0.0 };
const WALL: [u8; 3] = [190, 170, 150];

fn facade(style: FacadeStyle, seed: u64, width: f64) -> Facade {
    let bays = Bays::new(0, width, 0.0);
    Facade { floor: 100, eaves: 100 + 840, storeys: 3, look: Facade::look(style, seed), bays: [bays; 2] }
}

fn pattern(style: FacadeStyle, seed: u64, width: f64, colour: [u8; 3]) -> FacadePattern {
    let facade = facade(style, seed, width);
    let bays = (width > 0.0).then_some(facade.bays[0]);
    FacadePattern::new(&facade, bays, CODE, colour).unwrap()
}

/// Mean of factors at places much nearer than any part is wide.
fn sampled(pattern: &FacadePattern, at: &WallFootprint) -> [f64; 3] {
    const STEPS: usize = 60;
    let mut sum = [0.0; 3];
    for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
        let place = |[middle, extent]: [f32; 2], step: usize| {
            [middle + extent * ((step as f32 + 0.5) / STEPS as f32 - 0.5), LEAST]
        };
        let point = WallFootprint { along: place(at.along, i), up: place(at.up, j) };
        let factor = pattern.factor(&point);
        sum = [0, 1, 2].map(|channel| sum[channel] + f64::from(factor[channel]));
    }
    sum.map(|sum| sum / (STEPS * STEPS) as f64)
}

#[test]
fn means_are_those_of_many_places() {
    let mut random = Random(7);
    for style in FacadeStyle::ALL {
        for seed in 0..6 {
            let pattern = pattern(style, seed, 2.75, WALL);
            let mut number = |from: f64, to: f64| (from + (to - from) * random.unit()) as f32;
            let at = WallFootprint {
                along: [number(-20.0, 60.0), number(0.05, 4.0)],
                up: [number(-0.5, 10.0), number(0.05, f64::from(FADING[0]))],
            };
            let (exact, sampled) = (pattern.factor(&at), sampled(&pattern, &at));
            for (exact, sampled) in exact.into_iter().zip(sampled) {
                assert!((f64::from(exact) - sampled).abs() < 0.04, "{style:?} {at:?}: {exact} {sampled}");
            }
        }
    }
}

#[test]
fn whole_walls_keep_their_colour() {
    for style in FacadeStyle::ALL {
        for (seed, width) in [(0, 2.75), (3, 3.4), (6, 0.0), (9, 6.0)] {
            for colour in [WALL, [250, 250, 248], [60, 40, 35], [20, 20, 20]] {
                let pattern = pattern(style, seed, width, colour);
                let up = |step: usize| 8.4 * (step as f32 + 0.5) / 400.0;
                // Footprints of eight bays, thin enough not to fade.
                let period = if width > 0.0 { pattern.period } else { 9.0 };
                let of = |step| {
                    pattern
                        .factor(&WallFootprint { along: [0.5 * period, period], up: [up(step), 8.4 / 400.0] })
                };
                for channel in 0..3 {
                    let mean = (0..400).map(|step| of(step)[channel]).sum::<f32>() / 400.0;
                    assert!((mean - 1.0).abs() < 2.0e-3, "{style:?} {seed} {width} {colour:?}: {mean}");
                }
                let least = (0..400).flat_map(of).fold(1.0, f32::min);
                assert!(least >= 0.0);
            }
        }
    }
}

#[test]
fn walls_are_plain_from_afar() {
    let pattern = pattern(FacadeStyle::Apartments, 1, 3.0, WALL);
    for up in [0.2, 1.5, 4.0, 8.3, 12.0] {
        let at = WallFootprint { along: [3.3, 2.0], up: [up, FADING[1]] };
        assert_eq!(pattern.factor(&at), [1.0; 3]);
    }
    let dark = pattern.factor(&WallFootprint { along: [4.5, 0.1], up: [4.3, 0.1] });
    assert!(dark[1] < 0.5, "a pane is dark: {dark:?}");
}
