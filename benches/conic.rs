//! Edges of a round feature on all of its scan lines, against those of a polygon of 16 edges: `cargo bench --bench conic`.
//!
//! A feature's edges follow from its conic, line by line; a polygon's from each of its edges, on the lines that it crosses. Bunker and
//! Ferris (AFHRL-TR-77-66, §2.6) count one feature as 16 edges.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::DVec2;
use hedgehop_conic::{EDGES_PER_FEATURE, ImageConic, LineEdges, clipped_area};

/// Radii of circles, pixels; the last is that of the report's largest bomb circle.
const RADII: [f64; 4] = [5.0, 20.0, 40.0, 116.4];
/// Middle of all of them, line and element, so that no extremum lies on a line.
const CENTRE: DVec2 = DVec2::new(256.3, 256.7);

/// Counts the edges of a circle on its lines.
fn feature_edges(radius: f64) -> usize {
    let conic = ImageConic::of_image(CENTRE, [DVec2::X * radius, DVec2::Y * radius]);
    lines(radius).filter_map(|line| LineEdges::of(&conic, line)).map(|line| line.edges().count()).sum()
}

/// Corners of a regular polygon around a circle's middle.
fn corners(radius: f64) -> Vec<DVec2> {
    let corner = |index: u32| {
        CENTRE + DVec2::from_angle(TAU * f64::from(index) / f64::from(EDGES_PER_FEATURE)) * radius
    };
    (0..EDGES_PER_FEATURE).map(corner).collect()
}

/// Counts the parts of a polygon's edges on the lines that they cross.
fn polygon_edges(radius: f64) -> usize {
    let corners = corners(radius);
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    edges
        .map(|(from, to)| {
            parts(*from, *to).map(|part| usize::from(black_box(part)[0] != part[1])).sum::<usize>()
        })
        .sum()
}

/// Parts of an edge between one line and the next. Lines count along x, as those of conics do.
fn parts(from: DVec2, to: DVec2) -> impl Iterator<Item = [DVec2; 2]> {
    let (low, high) = if from.x <= to.x { (from, to) } else { (to, from) };
    let slope = (high.y - low.y) / (high.x - low.x);
    let at = move |line: f64| DVec2::new(line, low.y + (line - low.x) * slope);
    let lines = low.x.floor() as u32..high.x.ceil() as u32;
    lines.map(f64::from).map(move |line| {
        let start = if line <= low.x { low } else { at(line) };
        let end = if line + 1.0 >= high.x { high } else { at(line + 1.0) };
        [start, end]
    })
}

fn lines(radius: f64) -> impl Iterator<Item = f64> {
    ((CENTRE.x - radius).floor() as u32..=(CENTRE.x + radius).ceil() as u32).map(f64::from)
}

/// Sums the shares of all pixels, as edges leave them.
fn feature_pixels(radius: f64) -> f64 {
    let conic = ImageConic::of_image(CENTRE, [DVec2::X * radius, DVec2::Y * radius]);
    let shares = |edges: LineEdges| {
        let corners: Vec<DVec2> =
            edges.points.iter().map(|point| DVec2::new(point.place.line, point.place.element)).collect();
        let line = corners.iter().fold(f64::INFINITY, |low, corner| low.min(corner.x)).floor();
        pixels(&corners, line, radius)
    };
    lines(radius).filter_map(|line| LineEdges::of(&conic, line)).map(shares).sum()
}

/// Sums the shares of all pixels of the polygon.
fn polygon_pixels(radius: f64) -> f64 {
    let corners = corners(radius);
    lines(radius).map(|line| pixels(&corners, line, radius)).sum()
}

/// Sums the shares of a line's pixels within corners.
fn pixels(corners: &[DVec2], line: f64, radius: f64) -> f64 {
    let elements = (CENTRE.y - radius).floor() as u32..=(CENTRE.y + radius).ceil() as u32;
    let low = |element: u32| DVec2::new(line, f64::from(element));
    elements.map(|element| clipped_area(corners, low(element), low(element) + 1.0)).sum()
}

fn edges(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("edges");
    for radius in RADII {
        group.bench_function(BenchmarkId::new("feature", radius), |bench| {
            bench.iter(|| feature_edges(black_box(radius)));
        });
        group.bench_function(BenchmarkId::new("polygon-16", radius), |bench| {
            bench.iter(|| polygon_edges(black_box(radius)));
        });
    }
    group.finish();
}

fn shares(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("pixels");
    for radius in [5.0, 20.0] {
        group.bench_function(BenchmarkId::new("feature", radius), |bench| {
            bench.iter(|| feature_pixels(black_box(radius)));
        });
        group.bench_function(BenchmarkId::new("polygon-16", radius), |bench| {
            bench.iter(|| polygon_pixels(black_box(radius)));
        });
    }
    group.finish();
}

criterion_group!(benches, edges, shares);
criterion_main!(benches);
