//! Three ways to draw an edge, each against 1,024 samples of every pixel on the outline.

use glam::DVec2;

use crate::{CellOverlap, ImageConic, ImagePoint, LineEdges, distance_coverage};

/// Samples along a side of a pixel.
const SIDE: u32 = 32;

/// Mean and greatest error of shares.
#[derive(Debug, Default, Clone, Copy)]
struct ShareError {
    sum: f64,
    count: u32,
    most: f64,
}

impl ShareError {
    fn add(&mut self, error: f64) {
        self.sum += error.abs();
        self.count += 1;
        self.most = self.most.max(error.abs());
    }

    fn mean(&self) -> f64 {
        self.sum / f64::from(self.count)
    }
}

fn sampled(conic: &ImageConic, at: ImagePoint) -> f64 {
    let place = |index: u32| (f64::from(index) + 0.5) / f64::from(SIDE);
    let inside = |index: u32| {
        let (down, right) = (place(index / SIDE), place(index % SIDE));
        conic.value(ImagePoint { line: at.line + down, element: at.element + right }) < 0.0
    };
    f64::from((0..SIDE * SIDE).filter(|index| inside(*index)).count() as u32) / f64::from(SIDE * SIDE)
}

/// Errors of exact areas, edges and distances over ellipses whose half axes lie in a range of pixels.
fn errors(half_axes: [f64; 2], count: u32) -> [ShareError; 3] {
    let [low, high] = half_axes;
    let mut errors = [ShareError::default(); 3];
    for index in 0..count {
        let part = |step: f64| (f64::from(index + 1) * step).fract();
        let [wide, tall] = [0.618_033_9, 0.414_213_5].map(|step| low + (high - low) * part(step));
        let tall = if index % 2 == 0 { tall } else { 0.3 * tall };
        let turn = DVec2::from_angle(3.1 * part(0.732_050_8));
        let centre = DVec2::new(200.0 + part(0.236_067_9), 200.0 + part(0.870_550_5));
        let conic = ImageConic::of_image(centre, [turn * wide, turn.perp() * tall]);
        let overlap = CellOverlap::of(&conic).unwrap();
        let [first, last] = overlap.bounds().map(DVec2::floor);

        for line in first.x as i32..=last.x as i32 {
            let edges = LineEdges::of(&conic, f64::from(line));
            for element in first.y as i32..=last.y as i32 {
                let at = ImagePoint { line: f64::from(line), element: f64::from(element) };
                let exact = overlap.pixel(at);
                if exact.min(1.0 - exact) < 1e-9 {
                    continue;
                }
                let truth = sampled(&conic, at);
                errors[0].add(exact - truth);
                errors[1].add(edges.as_ref().map_or(0.0, |edges| edges.pixel(at)) - truth);
                errors[2].add(distance_coverage(&conic, at).unwrap() - truth);
            }
        }
    }
    errors
}

#[test]
fn exact_areas_are_exact_at_all_sizes() {
    for (range, count) in [([1.0, 3.0], 60), ([5.0, 10.0], 20), ([20.0, 40.0], 8), ([60.0, 110.0], 3)] {
        let [exact, ..] = errors(range, count);
        assert!(exact.count > 500, "{range:?}: {exact:?}");
        assert!(exact.mean() <= 1.0 / 128.0 && exact.most <= 1.0 / 16.0, "{range:?}: {exact:?}");
    }
}

#[test]
fn edges_are_better_than_distances_where_ellipses_are_large() {
    let [_, edges, distances] = errors([20.0, 40.0], 24);
    assert!(edges.mean() <= 0.02, "{edges:?}");
    assert!(distances.mean() > edges.mean(), "{distances:?} {edges:?}");
    let [_, edges, distances] = errors([60.0, 110.0], 6);
    assert!(distances.mean() > 1.5 * edges.mean(), "{distances:?} {edges:?}");
    // Where they are small, edges have no advantage.
    let [_, edges, distances] = errors([1.0, 3.0], 60);
    assert!(edges.mean() > distances.mean(), "{distances:?} {edges:?}");
}
