//! Air with weather in it against the atmosphere's closed forms.

use glam::Vec3;
use proptest::prelude::*;

use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::sunlight::Sun;
use crate::weather::{Air, Atmosphere, Fog, Weather};

/// What sixteen directions show of light at a range, and of the sky.
struct Seen<'a> {
    air: Air,
    directions: &'a [Vec3; LANES],
    range: f32,
}

impl Kernel for Seen<'_> {
    type Output = [[[f32; LANES]; 3]; 2];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self { mut air, directions, range } = self;
        let parts = [0, 1, 2].map(|axis| directions.map(|direction| direction[axis]));
        let (east, north, up) = (simd.load(&parts[0]), simd.load(&parts[1]), simd.load(&parts[2]));
        air.turn(simd, [east, north]);
        let range = simd.splat(range);
        let light = [simd.splat(LIGHT.x), simd.splat(LIGHT.y), simd.splat(LIGHT.z)];
        let mut seen = [[[0.0; LANES]; 3]; 2];
        for (seen, light) in
            seen.iter_mut().zip([air.over(simd, light, range, range * up), air.sky::<V, true>(simd, up)])
        {
            for (seen, light) in seen.iter_mut().zip(light) {
                light.store(seen);
            }
        }
        seen
    }
}

const LIGHT: Vec3 = Vec3::new(0.05, 0.5, 0.9);

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn air_with_weather_is_the_atmospheres(
        eye in 90.0_f64..3000.0,
        range in 1.0_f32..30_000.0,
        turn in 0.0_f32..6.3,
        glow in 0.0_f64..1.0,
        elevation in 1.0_f64..90.0,
        visibility in 200.0_f64..80_000.0,
        fog in prop::option::of((100.0_f64..1500.0, 30.0_f64..5000.0, 1.0_f64..300.0)),
    ) {
        let fog = fog.map(|(top, visibility, soft)| Fog { top, visibility, soft });
        let weather = Weather { glow, fog, ..Weather::default() };
        let atmosphere =
            Atmosphere::new(visibility, 100.0).with_weather(&weather, Sun { azimuth: 77.0, elevation });

        let directions: [Vec3; LANES] = std::array::from_fn(|lane| {
            let up = 0.06 * (lane as f32 - 8.5);
            let level = (1.0 - up * up).sqrt();
            let azimuth = turn + 0.1 * lane as f32;
            Vec3::new(azimuth.sin() * level, azimuth.cos() * level, up)
        });

        for isa in Isa::available() {
            let air = Air::new(&atmosphere, eye, 2500.0);
            let seen = isa.run(Seen { air, directions: &directions, range });
            for (lane, direction) in directions.into_iter().enumerate() {
                // Above what the air was made for its series does not hold.
                if eye + f64::from(direction.z * range) > 2500.0 {
                    continue;
                }
                let exact = [atmosphere.haze(LIGHT, eye, direction, range), atmosphere.sky(eye, direction)];
                for (exact, seen) in exact.into_iter().zip(seen) {
                    let found = Vec3::new(seen[0][lane], seen[1][lane], seen[2][lane]);
                    prop_assert!((found - exact).abs().max_element() < 3e-3, "{isa} {direction}: {found} {exact}");
                }
            }
        }
    }
}
