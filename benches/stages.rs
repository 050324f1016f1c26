//! Stages of the reference marcher's frame, and encoding, one at a time, on one core: `cargo bench --bench stages -- march/mountains`.

mod terrain;

use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::dvec3;

use hedgehop::encode::{FrameInfo, encode_frame};
use hedgehop::frame::Frame;
use hedgehop::raymarch::{Column, GridRay, Marcher, Surface, SurfaceFilter, march_column};
use hedgehop::render::{RenderOptions, level_bands, render_frame, render_reference};
use hedgehop::sensor::VisualSensor;
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::sunlight::Sun;
use hedgehop::voxel::{MemPages, PageSource};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;
/// Level flight, where range coherence is exact, and two attitudes where it is not, degrees.
const PITCHES: [f64; 3] = [0.0, -15.0, -60.0];

/// 100 m above the highest ground, at the southern edge, looking north over the area.
fn camera(area: &MemPages, pitch: f64) -> Camera {
    let header = area.header();
    let near = header.grid.origin;
    let side = header.grid.far_corner() - near;
    let eye = dvec3(near.x + 0.5 * side.x, near.y + 0.1 * side.y, header.height_range.high + 100.0);
    Camera::new(Pose { eye, attitude: Attitude { yaw: 0.0, pitch, roll: 0.0 }, hfov: 60.0 }, WIDTH, HEIGHT)
}

fn marcher<'a>(area: &'a MemPages, camera: &Camera, surface: Surface) -> Marcher<'a> {
    Marcher::new(area, level_bands(area.header(), camera, &RenderOptions::default()), surface)
}

/// Ranges of the middle scan line.
fn march(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("march");
    group.throughput(Throughput::Elements(u64::from(HEIGHT)));
    for (name, amplitude) in terrain::ROUGHNESS {
        let area = terrain::area(amplitude);
        for pitch in PITCHES {
            let camera = camera(&area, pitch);
            for (surface, label) in [(Surface::Smooth, "smooth"), (Surface::Blocks, "blocks")] {
                let mut marcher = marcher(&area, &camera, surface);
                group.bench_function(BenchmarkId::new(format!("{name}/{label}"), pitch), |bencher| {
                    bencher.iter(|| march_column(&mut marcher, black_box(&camera), WIDTH / 2).unwrap());
                });
            }
        }
    }
}

/// Filtered colour, normal and light of the middle scan line, whose ranges are known.
fn shade(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("shade");
    for (name, amplitude) in terrain::ROUGHNESS {
        let area = terrain::area(amplitude);
        let grid = area.header().grid;
        for pitch in PITCHES {
            let camera = camera(&area, pitch);
            let column: Column =
                march_column(&mut marcher(&area, &camera, Surface::Smooth), &camera, WIDTH / 2).unwrap();
            let seen: Vec<_> = column.iter().enumerate().filter_map(|(row, c)| c.map(|c| (row, c))).collect();
            let mut filter = SurfaceFilter::new(&area, camera.footprint());
            let sensor = VisualSensor::new(Sun::default());
            group.throughput(Throughput::Elements(seen.len() as u64));
            group.bench_function(BenchmarkId::new(name, pitch), |bencher| {
                bencher.iter(|| {
                    for (row, contact) in &seen {
                        let direction = camera.direction(f64::from(WIDTH / 2) + 0.5, *row as f64 + 0.5);
                        let ray = GridRay::new(&grid, camera.pose.eye, direction);
                        black_box(sensor.radiance(&filter.sample(&ray, contact).unwrap()));
                    }
                });
            });
        }
    }
}

/// Merge, haze and sky: the part of a frame that its own clock says, on one worker.
fn image_stage(criterion: &mut Criterion) {
    let farm = Farm::new(1).unwrap();
    let mut group = criterion.benchmark_group("image_stage");
    group.throughput(Throughput::Elements(u64::from(WIDTH * HEIGHT)));
    let area = terrain::area(terrain::ROUGHNESS[1].1);
    for pitch in PITCHES {
        let camera = camera(&area, pitch);
        group.bench_function(BenchmarkId::from_parameter(pitch), |bencher| {
            bencher.iter_custom(|frames| {
                let frame = || render_reference(&area, &camera, &RenderOptions::default(), &farm).unwrap();
                (0..frames).map(|_| frame().account.times.image).sum()
            });
        });
    }
}

fn encode(criterion: &mut Criterion) {
    let farm = Farm::new(1).unwrap();
    let area = terrain::area(terrain::ROUGHNESS[1].1);
    let frame: Frame =
        render_frame(&area, &camera(&area, 0.0), &RenderOptions::default(), &farm).unwrap().frame;

    let info = FrameInfo {
        frame: 1,
        seconds: 0.0,
        database_hash: String::new(),
        database_file: "terrain.hop".into(),
        crs_name: "local".into(),
        vertical_datum: "mean sea level".into(),
        settings_digest: String::new(),
        writer: "bench".into(),
    };

    let mut group = criterion.benchmark_group("encode");
    group.throughput(Throughput::Elements(u64::from(WIDTH * HEIGHT)));
    for name in ["frame.png", "frame.exr"] {
        group.bench_function(name, |bencher| {
            bencher.iter(|| encode_frame(Path::new(name), black_box(&frame), &info).unwrap());
        });
    }
}

criterion_group! {
    name = stages;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(1));
    targets = march, shade, image_stage, encode
}
criterion_main!(stages);
