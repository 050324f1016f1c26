use super::*;
use crate::scene::Tone;

fn codes(light: f32, size: [u32; 2], finish: &Finish) -> Vec<u8> {
    let pixels = vec![[light, 0.5 * light, 0.0]; (size[0] * size[1]) as usize];
    develop(&pixels, size, finish, &Farm::new(1).unwrap()).rgb
}

#[test]
fn exposure_doubles_light_by_the_stop() {
    let exposed = |exposure: f64| codes(0.1, [1, 1], &Finish { exposure, ..Finish::default() });
    let plain = |light: f32| codes(light, [1, 1], &Finish::default());
    assert_eq!(exposed(2.0), plain(0.4));
    assert_eq!(exposed(-3.0), plain(0.0125));
    assert_eq!(exposed(0.0), hedgehop_base::colour::srgb8_picture(&[[0.1, 0.05, 0.0]]));
    assert_eq!(exposed(16.0)[..2], [255, 255]);
}

#[test]
fn corners_lose_as_much_light_as_is_asked_for() {
    let (size, linear) = ([64, 48], Finish { gamma: Some(1.0), ..Finish::default() });
    let seen = codes(0.8, size, &Finish { vignette: 0.6, ..linear });
    let at = |column: usize, row: usize| f64::from(seen[3 * (row * 64 + column)]) / 255.0;
    assert!((at(31, 23) - 0.8).abs() < 0.005 && (at(32, 24) - 0.8).abs() < 0.005);
    // The corner of the picture lies half a pixel's diagonal beyond the last pixel's middle.
    assert!((at(0, 0) / 0.8 - 0.4).abs() < 0.02 && at(0, 0) == at(63, 47) && at(63, 0) == at(0, 47));
    // Halfway: 1/(1 + a/4)², a = 1/√0.4 − 1.
    let a = 1.0 / 0.4_f64.sqrt() - 1.0;
    assert!((at(16, 12) / 0.8 - (1.0 + a / 4.0).powi(-2)).abs() < 0.02);
}

#[test]
fn dithered_codes_have_the_mean_of_the_light() {
    let finish = Finish { gamma: Some(1.0), dither: Dither::Ordered, ..Finish::default() };
    for step in 0..200 {
        let light = step as f32 * 0.004_97;
        let seen = codes(light, [16, 24], &finish);
        let mean = seen.iter().step_by(3).map(|code| f64::from(*code)).sum::<f64>() / (16.0 * 24.0);
        assert!((mean - 255.0 * f64::from(light)).abs() < 0.5 / 64.0 + 1e-3, "{light}: {mean}");
        let (least, most) = (seen.iter().step_by(3).min(), seen.iter().step_by(3).max());
        assert!(most.unwrap() - least.unwrap() <= 1);
    }
    let mut ranks: Vec<_> = (0..64).map(|index| (64.0 * threshold(index % 8, index / 8)) as usize).collect();
    ranks.sort_unstable();
    assert_eq!(ranks, (0..64).collect::<Vec<_>>());
}

#[test]
fn codes_do_not_depend_on_who_works() {
    let pixels: Vec<[f32; 3]> = (0..101 * 67).map(|pixel| [pixel as f32 * 2e-4, 0.3, 1.7]).collect();
    let finish = Finish {
        exposure: 0.7,
        tone: Tone::Filmic,
        gamma: Some(2.2),
        dither: Dither::Ordered,
        vignette: 0.3,
        ..Finish::default()
    };
    let [one, three] =
        [1, 3].map(|workers| develop(&pixels, [101, 67], &finish, &Farm::new(workers).unwrap()));
    assert!(one == three);
}
