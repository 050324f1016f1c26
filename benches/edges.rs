//! Edges of a round feature on the lines of a picture, against those of the sixteen-sided polygon that stands for it (Bunker and Ferris 1977, §2.6).

use std::f64::consts::TAU;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::DVec2;

use hedgehop_conic::{EDGES_PER_FEATURE, ImageConic, LineEdges};

/// Middle of the circle, pixels.
const MIDDLE: DVec2 = DVec2::new(320.0, 240.0);

/// Corners of the polygon, in turn.
fn polygon(radius: f64) -> Vec<DVec2> {
    let corner = |number: u32| {
        MIDDLE + radius * DVec2::from_angle(TAU * f64::from(number) / f64::from(EDGES_PER_FEATURE))
    };
    (0..EDGES_PER_FEATURE).map(corner).collect()
}

/// Sums up where a line meets the sides of a polygon.
fn crossings(corners: &[DVec2], line: f64) -> f64 {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let met = sides.filter(|(from, to)| (from.y <= line) != (to.y <= line));
    met.map(|(from, to)| from.x + (to.x - from.x) * (line - from.y) / (to.y - from.y)).sum()
}

fn edges(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("edges of a circle");
    for radius in [5.0, 20.0, 100.0] {
        let lines = (MIDDLE.y - radius) as u32..=(MIDDLE.y + radius) as u32;
        let conic = ImageConic::of_image(MIDDLE, [DVec2::X * radius, DVec2::Y * radius]);
        group.bench_with_input(BenchmarkId::new("feature", radius), &conic, |bencher, conic| {
            bencher.iter(|| {
                let met = lines.clone().filter_map(|line| LineEdges::of(black_box(conic), f64::from(line)));
                met.map(|line| line.edges().count()).sum::<usize>()
            });
        });

        let corners = polygon(radius);
        group.bench_with_input(BenchmarkId::new("polygon", radius), &corners, |bencher, corners| {
            bencher.iter(|| {
                lines.clone().map(|line| crossings(black_box(corners), f64::from(line))).sum::<f64>()
            });
        });
    }
}

criterion_group! {
    name = all;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    targets = edges
}
criterion_main!(all);
