//! Lengths and tips that rows state.

use glam::{DVec2, dvec2};

use super::super::site::Site;
use super::super::sunward::Sunward;
use super::synthetic::{Prism, Random, hills};
use super::{dem, foot, ring, turned};

/// Calls with a site on a ground, and the ring's foot.
fn on<R>(ground: &dyn Fn(DVec2) -> f64, sun: (f64, f64), ring: &[DVec2], ask: impl Fn(&Site<'_>) -> R) -> R {
    let sun = Sunward::new(sun.0, sun.1);
    let rings = [turned(ring, &sun)];
    let height = |place: DVec2| Some(ground(sun.place(place)));
    let base = foot(ring, ground);
    ask(&Site { sun, base, rings: &rings, others: &[], neighbours: &[], ground: &height, range: (2.0, 80.0) })
}

#[test]
fn on_level_ground_the_formula_is_exact() {
    let ring = ring(&mut Random(1), dvec2(500.0, 500.0));
    for (azimuth, elevation) in [(0.0, 10.0), (123.0, 30.0), (271.0, 62.5)] {
        for length in [1.0, 17.25, 240.0] {
            let tangent = f64::tan(f64::to_radians(elevation));
            on(&|_| 312.5, (azimuth, elevation), &ring, |site| {
                let height = site.height_of_length(length).unwrap();
                assert!((height - length * tangent).abs() < 1e-9, "{height}");
                assert!((site.length_of_height(height) - length).abs() < 1e-6);
            });
        }
    }
}

#[test]
fn on_slopes_the_tip_is_where_the_ray_meets_the_ground() {
    // Rising by 1 in 10 away from the sun in the south: z = L·tan A + 0.1·(distance of the tip from the foot).
    let square = [dvec2(490.0, 490.0), dvec2(510.0, 490.0), dvec2(510.0, 510.0), dvec2(490.0, 510.0)];
    let rising = |place: DVec2| 100.0 + 0.1 * place.y;
    on(&rising, (180.0, 45.0), &square, |site| {
        let height = site.height_of_length(10.0).unwrap();
        assert!((height - (10.0 + 0.1 * 30.0)).abs() < 1e-9, "{height}");
        let (by_tip, length) = site.height_of_tip(site.sun.turned(dvec2(500.0, 520.0))).unwrap();
        assert!((by_tip - height).abs() < 1e-9 && (length - 10.0).abs() < 1e-9, "{by_tip} {length}");
        assert!((site.length_of_height(height) - 10.0).abs() < 1e-6);
        // A metre beside the corner is taken as the corner; far beside, on it and before it nothing is.
        assert!(site.height_of_tip(site.sun.turned(dvec2(511.0, 520.0))).is_ok());
        for wrong in [dvec2(530.0, 520.0), dvec2(500.0, 500.0), dvec2(500.0, 480.0)] {
            assert!(site.height_of_tip(site.sun.turned(wrong)).is_err(), "{wrong}");
        }
    });
}

#[test]
fn tips_on_hills_give_back_the_roof() {
    let sun = (140.0, 28.0);
    for seed in 0..20 {
        let ring = ring(&mut Random(seed), dvec2(500.0, 500.0));
        let height = 10.0 + f64::from(seed as u32);
        let prism = Prism { roof: foot(&ring, |place| dem(place).unwrap()) + height, ring: ring.clone() };
        on(&|place| dem(place).unwrap(), sun, &ring, |site| {
            // By steps of a centimetre away from the sun, from the corner that is farthest from it.
            let corner = site.rings[0].iter().copied().min_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
            let meets = |length: &f64| {
                let place = site.sun.place(corner - dvec2(*length, 0.0));
                dem(place).unwrap() + length * site.sun.rise >= prism.roof
            };
            let length = (1..).map(|step| 0.01 * f64::from(step)).find(meets).unwrap();
            assert!((site.height_of_length(length).unwrap() - height).abs() < 0.02);
            assert!((site.length_of_height(height) - length).abs() < 0.011);
        });
    }
    assert!(hills(DVec2::ZERO) > 300.0);
}
