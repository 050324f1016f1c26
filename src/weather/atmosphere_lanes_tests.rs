//! Sixteen lanes against the atmosphere's closed forms: plain haze, and air with fog and glow.

use glam::Vec3;
use proptest::prelude::*;

use crate::pixels::UNITS;
use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::sunlight::Sun;
use crate::weather::{Atmosphere, AtmosphereLanes, Fog, Weather};

/// Light of something at a range, and the sky, in sixteen directions.
struct Seen<'a> {
    /// The air around the eye.
    air: AtmosphereLanes,
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

/// Linear Rec. 709 radiance that reaches the eye through plain haze from sixteen places, by channel.
struct ThroughHaze {
    /// The air around the eye.
    air: AtmosphereLanes,
    /// Linear Rec. 709 radiance of the places.
    radiance: Vec3,
    /// Distances from the eye, metres.
    range: [f32; LANES],
    /// Heights above the eye, metres.
    rise: [f32; LANES],
}

impl Kernel for ThroughHaze {
    type Output = [[f32; LANES]; 3];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self { air, radiance, range, rise } = self;
        let mut ground = [simd.splat(0.0); 3];
        for (channel, ground) in ground.iter_mut().enumerate() {
            *ground = simd.splat(radiance[channel] / UNITS[channel]);
        }

        let light = air.haze::<V, false>(simd, ground, simd.load(&range), simd.load(&rise));
        let mut seen = [[0.0; LANES]; 3];
        for (seen, light) in seen.iter_mut().zip(light) {
            light.store(seen);
        }
        seen
    }
}

/// Light of sixteen lanes, one after the other.
fn by_lane(channels: [[f32; LANES]; 3]) -> [Vec3; LANES] {
    std::array::from_fn(|lane| Vec3::from_array(channels.map(|channel| channel[lane])))
}

#[test]
fn plain_haze_is_the_atmospheres_from_any_height() {
    let atmosphere = Atmosphere::new(20_000.0, 500.0);
    for eye in [500.0, 600.0, 3000.0, 30_000.0, 165_000.0, 180_000.0, 1.0e6, 4.0e7] {
        // Straight down, at inclines and level.
        let up: [f32; LANES] = std::array::from_fn(|lane| -(lane as f32) / (LANES - 1) as f32);
        let range = up.map(|up| if up < 0.0 { (eye as f32 - 500.0) / -up } else { 9000.0 });
        let rise = std::array::from_fn(|lane| up[lane] * range[lane]);
        let air = AtmosphereLanes::new(&atmosphere, eye, 5000.0);
        for isa in Isa::available() {
            for radiance in [Vec3::ZERO, LIGHT] {
                let seen = by_lane(isa.run(ThroughHaze { air, radiance, range, rise }));
                for ((seen, up), range) in seen.into_iter().zip(up).zip(range) {
                    let direction = Vec3::new(0.0, (1.0 - up * up).max(0.0).sqrt(), up);
                    let exact = atmosphere.haze(radiance, eye, direction, range);
                    let error = (seen - exact).abs().max_element();
                    assert!(error < 2.0e-3, "{isa}: {eye} m, {up}: {seen} for {exact}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn air_with_fog_and_glow_is_the_atmospheres(
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
            let air = AtmosphereLanes::new(&atmosphere, eye, 2500.0);
            let seen = isa.run(Seen { air, directions: &directions, range });
            let [ground, sky] = seen.map(by_lane);
            for (lane, direction) in directions.into_iter().enumerate() {
                // Above what the air was made for its series does not hold.
                if eye + f64::from(direction.z * range) > 2500.0 {
                    continue;
                }
                let exact = [atmosphere.haze(LIGHT, eye, direction, range), atmosphere.sky(eye, direction)];
                for (exact, found) in exact.into_iter().zip([ground[lane], sky[lane]]) {
                    prop_assert!((found - exact).abs().max_element() < 3e-3, "{isa} {direction}: {found} {exact}");
                }
            }
        }
    }
}
