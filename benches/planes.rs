//! Scan planes on one worker, stage by stage, over what a frame's time may depend on: `cargo bench --bench planes -- march/pitch`.
//!
//! Whole pictures are rendered; what counts is the stage that the frame's own clock states. Each group varies one
//! thing about the same view: hills, 100 m above ground, level, 60° wide, 960 × 540 pixels.

mod terrain;

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec2;
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Engine, RenderOptions, Renderer, StageTimes};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{MemPages, PageSource};

/// What is looked at, and from where: [`BASE`] but for one value.
#[derive(Clone, Copy)]
struct View {
    /// Names a terrain of [`terrain::ROUGHNESS`].
    roughness: usize,
    /// Of the eye above the ground, metres.
    height: f64,
    /// Degrees, nose up.
    pitch: f64,
    /// Horizontal field of view, degrees.
    hfov: f64,
    /// Pixels.
    size: [u32; 2],
}

const BASE: View = View { roughness: 1, height: 100.0, pitch: 0.0, hfov: 60.0, size: [960, 540] };

/// Name of the group, name of the view, view.
fn views() -> Vec<(&'static str, String, View)> {
    let roughness = terrain::ROUGHNESS.iter().enumerate();
    let roughness =
        roughness.map(|(roughness, (name, _))| ("roughness", (*name).to_owned(), View { roughness, ..BASE }));
    let height = [10.0, 100.0, 1000.0]
        .map(|height| ("height above ground", format!("{height} m"), View { height, ..BASE }));
    let pitch = [0.0, -15.0, -40.0].map(|pitch| ("pitch", format!("{pitch}°"), View { pitch, ..BASE }));
    let hfov = [20.0, 60.0, 110.0].map(|hfov| ("field of view", format!("{hfov}°"), View { hfov, ..BASE }));
    let sizes = [[480, 270], [960, 540], [1920, 1080]];
    let size = sizes.map(|size| ("resolution", format!("{}x{}", size[0], size[1]), View { size, ..BASE }));
    roughness.chain(height).chain(pitch).chain(hfov).chain(size).collect()
}

/// A tenth of the area from its southern edge, looking north over it.
fn camera(area: &MemPages, view: View) -> Camera {
    let header = area.header();
    let side = header.grid.far_corner() - header.grid.origin;
    let place = header.grid.origin + side * DVec2::new(0.5, 0.1);
    let ground = ground_height(area, place).expect("a sound page").expect("a place in the area");
    let attitude = Attitude { yaw: 0.0, pitch: view.pitch, roll: 0.0 };
    let pose = Pose { eye: place.extend(ground + view.height), attitude, hfov: view.hfov };
    Camera::new(pose, view.size[0], view.size[1])
}

/// The part of every view's pictures that `time` picks.
fn stage(criterion: &mut Criterion, name: &str, time: fn(&StageTimes) -> Duration) {
    let areas = terrain::ROUGHNESS.map(|(_, amplitude)| terrain::area(amplitude));
    let farm = Farm::new(1).expect("one worker");
    let options = RenderOptions { engine: Engine::Planes, ..RenderOptions::default() };
    for (varied, label, view) in views() {
        let area = &areas[view.roughness];
        let camera = camera(area, view);
        let renderer = Renderer::new(area, &options);
        assert_eq!(renderer.engine_for(&camera).unwrap(), Engine::Planes, "the reference would be measured");
        let mut group = criterion.benchmark_group(format!("{name}/{varied}"));
        group.throughput(Throughput::Elements(view.size.iter().map(|&side| u64::from(side)).product()));
        group.bench_function(BenchmarkId::from_parameter(label), |bencher| {
            let times = || renderer.picture(&camera, &farm).expect("sound pages").1.times;
            bencher.iter_custom(|frames| (0..frames).map(|_| time(&times())).sum());
        });
    }
}

fn march(criterion: &mut Criterion) {
    stage(criterion, "march", |times| times.march);
}

/// Resampling between planes, filtered colour and light, haze, sky, 8-bit codes.
fn shade(criterion: &mut Criterion) {
    stage(criterion, "shade", |times| times.shade + times.image);
}

criterion_group! {
    name = planes;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(500));
    targets = march, shade
}
criterion_main!(planes);
