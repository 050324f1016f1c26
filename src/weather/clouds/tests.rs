use glam::{DVec3, Vec3};

use super::*;
use crate::pixels::Pixels;
use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::space::{Attitude, Camera, Pose};
use crate::sunlight::Sun;
use crate::weather::clouds::field::{LAYERS, extinction};
use crate::weather::clouds::march::CloudRays;
use crate::weather::clouds::noise::SIDE;
use crate::weather::clouds::{CloudDensities, CloudField};
use crate::weather::{Atmosphere, Clouds};

const SUN: Sun = Sun { azimuth: 120.0, elevation: 35.0 };

const CLOUDS: Clouds = Clouds {
    base: 1000.0,
    top: 1600.0,
    coverage: 0.5,
    visibility: 150.0,
    scale: 1500.0,
    seed: 7,
    wind: [10.0, 0.0],
};

fn layer(clouds: &Clouds, sun: Sun) -> CloudField {
    CloudDensities::new(clouds).lit(clouds, sun)
}

fn camera(eye: DVec3, pitch: f64, size: [u32; 2]) -> Camera {
    let attitude = Attitude { yaw: 30.0, pitch, roll: 4.0 };
    Camera::new(Pose { eye, attitude, hfov: 25.0 }, size[0], size[1])
}

fn stage<'c>(isa: Isa, camera: &'c Camera, field: &'c CloudField, clouds: &Clouds) -> CloudStage<'c> {
    let atmosphere = Atmosphere::new(30_000.0, 0.0);
    let air = AirOverGround { atmosphere: &atmosphere, highest: 1200.0 };
    CloudStage::new(isa, camera, field, clouds, SUN, air, 12.0).unwrap()
}

/// Light and transmittance along rays of a length.
struct March<'s, 'c>(&'s CloudStage<'c>, [Vec3; LANES], [f32; LANES]);

impl Kernel for March<'_, '_> {
    type Output = [[f32; LANES]; 4];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self(stage, directions, range) = self;
        let part = |axis: usize| simd.load(&directions.map(|direction| direction[axis]));
        let direction = [part(0), part(1), part(2)];
        let rays = CloudRays::new(simd, &stage.cover, direction, simd.load(&range));
        let veil = rays.march(simd, &stage.cover, &stage.air, None);
        let mut seen = [[0.0; LANES]; 4];
        let [red, green, blue] = veil.light;
        for (seen, value) in seen.iter_mut().zip([red, green, blue, veil.through]) {
            value.store(seen);
        }
        seen
    }
}

#[test]
fn transmittance_through_uniform_clouds_follows_the_law_of_beer() {
    let densities = vec![1.0; LAYERS * SIDE * SIDE];
    let thin = Clouds { visibility: 3000.0, ..CLOUDS };
    let field = CloudField::of(&densities, &thin, 90.0, SUN);
    for (eye, sense) in [(300.0, 1.0), (1250.0, 1.0), (1250.0, -1.0), (2500.0, -1.0)] {
        let camera = camera(DVec3::new(3.0e5, 5.0e6, eye), 0.0, [16, 9]);
        let directions: [Vec3; LANES] = std::array::from_fn(|lane| {
            let up = sense * 0.06 * (lane + 1) as f32;
            Vec3::new((1.0 - up * up).sqrt(), 0.0, up)
        });

        // The lower half ends within the layer, or before it.
        let range = std::array::from_fn(|lane| if lane < 8 { 5.0e4 } else { 900.0 + 80.0 * lane as f32 });
        for isa in Isa::available() {
            let [.., through] = isa.run(March(&stage(isa, &camera, &field, &thin), directions, range));
            for lane in 0..LANES {
                let at = |height: f64| (height - eye) as f32 / directions[lane].z;
                let ends = [at(thin.base), at(thin.top)].map(|end| end.clamp(0.0, range[lane]));
                let expected = (-extinction(&thin) * (ends[1] - ends[0]).abs()).exp();
                assert!(
                    (through[lane] - expected).abs() < 2e-3,
                    "{isa} {eye} {lane}: {} {expected}",
                    through[lane]
                );
            }
        }
    }
}

#[test]
fn pixels_between_the_lattices_rays_are_as_rays_of_their_own_tell() {
    let field = layer(&CLOUDS, SUN);
    for (eye, pitch, ground) in
        [(300.0, 12.0, 6000.0), (1300.0, 0.0, 2500.0), (2600.0, -25.0, 3600.0), (1300.0, -20.0, 700.0)]
    {
        let size = [192, 108];
        let camera = camera(DVec3::new(3.0e5, 5.0e6, eye), pitch, size);
        let mut stage = stage(Isa::best(), &camera, &field, &CLOUDS);
        stage.cell = 2;
        let pixels = (size[0] * size[1]) as usize;

        // Ground with a jagged edge before the sky.
        let range: Vec<f32> = (0..pixels)
            .map(|pixel| (pixel % 192, pixel / 192))
            .map(|(x, y)| if y + x % 40 > 60 { ground + 11.0 * x as f32 } else { f32::INFINITY })
            .collect();
        let mut colour = vec![[0.0; 3]; pixels];
        let (rows, mut lattice) = (stage.band_rows(), CloudLattice::default());

        for (index, (colour, range)) in
            colour.chunks_mut(192 * rows).zip(range.chunks(192 * rows)).enumerate()
        {
            stage.fill(&mut lattice, index * rows, Pixels::Linear(colour), range);
        }

        let mut wrong = Vec::new();
        for pixel in (0..pixels).step_by(LANES) {
            let direction = |lane: usize| {
                stage.direction(((pixel + lane) % 192) as f64 + 0.5, (pixel / 192) as f64 + 0.5).unwrap()
            };
            let range = std::array::from_fn(|lane| range[pixel + lane].min(1.0e30));
            let exact = stage.isa.run(March(&stage, std::array::from_fn(direction), range));

            for lane in 0..LANES {
                // Black ground in shadow is lit by haze alone, which stays.
                let seen = colour[pixel + lane];
                wrong.push(
                    (0..3).map(|channel| (seen[channel] - exact[channel][lane]).abs()).fold(0.0, f32::max),
                );
            }
        }

        wrong.sort_by(f32::total_cmp);
        let (middle, high) = (wrong[pixels / 2], wrong[pixels * 99 / 100]);
        assert!(middle < 0.002 && high < 0.05, "{eye} {pitch}: {middle} {high}");
    }
}

#[test]
fn rows_near_the_horizon_follow_each_other_without_streaks() {
    let clouds = Clouds { base: 1500.0, top: 1900.0, coverage: 0.6, scale: 2000.0, ..CLOUDS };
    let field = layer(&clouds, SUN);
    let camera = camera(DVec3::new(613_420.0, 5_241_400.0, 1750.0), 0.0, [16, 9]);
    let stage = stage(Isa::best(), &camera, &field, &clouds);

    // Rays a thirtieth of a degree apart, up and down from level, at some azimuths.
    let mut streaks = Vec::new();
    for azimuth in (0..40).map(|step| step as f32 * 0.15) {
        let seen: Vec<f32> = (-48..48_i32)
            .step_by(LANES)
            .flat_map(|first| {
                let direction = |lane: usize| {
                    let (up, level) = ((first + lane as i32) as f32 / 30.0).to_radians().sin_cos();
                    Vec3::new(azimuth.sin() * level, azimuth.cos() * level, up)
                };
                stage.isa.run(March(&stage, std::array::from_fn(direction), [1.0e30; LANES]))[1]
            })
            .collect();
        streaks.extend(seen.windows(3).map(|three| (0.5 * (three[0] + three[2]) - three[1]).abs()));
    }

    streaks.sort_by(f32::total_cmp);
    let high = streaks[streaks.len() * 99 / 100];
    assert!(high < 0.001, "{high}");
}

#[test]
fn instruction_sets_agree() {
    let field = layer(&CLOUDS, SUN);
    let camera = camera(DVec3::new(3.0e5, 5.0e6, 1200.0), 5.0, [61, 33]);
    let pictures: Vec<Vec<[f32; 3]>> = Isa::available()
        .into_iter()
        .map(|isa| {
            let mut colour = vec![[0.2; 3]; 61 * 33];
            let range: Vec<f32> =
                (0..61 * 33).map(|pixel| if pixel < 900 { f32::INFINITY } else { 800.0 }).collect();
            let stage = stage(isa, &camera, &field, &CLOUDS);
            let (rows, mut lattice) = (stage.band_rows(), CloudLattice::default());
            for (index, (colour, range)) in
                colour.chunks_mut(61 * rows).zip(range.chunks(61 * rows)).enumerate()
            {
                stage.fill(&mut lattice, index * rows, Pixels::Linear(colour), range);
            }
            colour
        })
        .collect();

    for other in &pictures[1..] {
        for (one, other) in pictures[0].iter().flatten().zip(other.iter().flatten()) {
            assert!((one - other).abs() < 4e-3, "{one} {other}");
        }
    }
}

#[test]
fn as_much_of_the_sky_is_cloudy_as_is_asked_for() {
    let variants = [
        CLOUDS,
        Clouds { seed: 0, scale: 4000.0, ..CLOUDS },
        Clouds { top: 1200.0, visibility: 60.0, ..CLOUDS },
        Clouds { seed: 3, scale: 500.0, top: 3000.0, visibility: 400.0, ..CLOUDS },
    ];
    for clouds in variants {
        for coverage in [0.0, 0.1, 0.25, 0.5, 0.6, 0.75, 0.9, 1.0] {
            // A slanting sun casts wider shadows.
            let field = layer(&Clouds { coverage, ..clouds }, Sun { elevation: 90.0, ..SUN });
            let cloudy = field.shadow.iter().filter(|through| **through < 0.5).count();
            let share = cloudy as f64 / field.shadow.len() as f64;
            assert!((share - coverage).abs() < 0.02, "{share} for {coverage}");
        }
    }
}

#[test]
fn the_layer_repeats_without_a_seam_and_follows_seed_and_wind() {
    let field = layer(&CLOUDS, SUN);
    let step = |from: usize, to: usize| {
        (0..SIDE)
            .map(|row| (field.shadow[row * (SIDE + 1) + from] - field.shadow[row * (SIDE + 1) + to]).abs())
            .sum::<f32>()
    };
    let largest = (100..150).map(|column| step(column, column + 1)).fold(0.0, f32::max);
    assert!(step(SIDE - 1, 0) < 2.0 * largest, "{} {largest}", step(SIDE - 1, 0));
    assert!(layer(&Clouds { seed: 8, ..CLOUDS }, SUN).words != field.words);
    let at = glam::DVec2::new(4.0e5, 5.0e6);
    let moved = field.place(at + glam::DVec2::new(300.0, 0.0), &CLOUDS, 30.0);
    assert!((moved - field.place(at, &CLOUDS, 0.0)).length() < 1e-6);
}

#[test]
fn what_lies_before_clouds_keeps_its_bits() {
    let field = layer(&CLOUDS, SUN);
    let camera = camera(DVec3::new(3.0e5, 5.0e6, 2600.0), 10.0, [64, 20]);
    let stage = stage(Isa::best(), &camera, &field, &CLOUDS);
    let sky: Vec<u8> = (0..64 * 20 * 3).map(|byte| byte as u8).collect();
    let mut seen = sky.clone();
    stage.fill(
        &mut CloudLattice::default(),
        0,
        Pixels::Srgb8(&mut seen[..64 * 16 * 3]),
        &[f32::INFINITY; 64 * 16],
    );
    // The rows that look up or level.
    assert_eq!(seen[..64 * 3 * 4], sky[..64 * 3 * 4]);
}
