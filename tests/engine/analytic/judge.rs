//! What a scene holds an engine to: the reference to every single pixel, scan planes to all of them together.

use std::fmt::Debug;

use hedgehop::render::Engine;

use super::ENGINE;

/// Relative errors of range: no more than this share of a scene's pixels may have a greater one.
const BOUNDS: [(f64, f64); 3] = [(0.5, 1.5e-4), (0.01, 3e-3), (0.004, 1e-2)];
/// Share of a scene's pixels at which sky may be seen in place of ground, or ground in place of sky.
const APART: f64 = 1e-3;

/// What is said of the reference, or of scan planes.
pub fn by_engine<T>(reference: T, planes: T) -> T {
    match ENGINE {
        Engine::Reference => reference,
        Engine::Planes => planes,
    }
}

/// What an engine saw of a scene, pixel by pixel.
#[derive(Debug, Default)]
pub struct Judge {
    /// Relative errors of range.
    errors: Vec<f64>,
    /// Pixels that see the sky in place of the ground, or the ground in place of the sky.
    apart: usize,
    pixels: usize,
}

impl Judge {
    /// A pixel must see ground at `exact` metres. The reference may be off by the share `within` of it.
    #[track_caller]
    pub fn range(&mut self, found: f64, exact: f64, within: f64, pixel: impl Debug) {
        let error = (found / exact - 1.0).abs();
        assert!(ENGINE != Engine::Reference || error < within, "{pixel:?}: {found} m for {exact} m");
        self.add(found, error);
    }

    /// A pixel must see ground at `exact` metres, of which the scene knows no more than that they are `slack` metres
    /// off at most: only what is beyond counts, with both engines.
    #[track_caller]
    pub fn range_about(&mut self, found: f64, exact: f64, slack: f64, pixel: impl Debug) {
        let beyond = ((found - exact).abs() - slack).max(0.0);
        assert!(ENGINE != Engine::Reference || beyond == 0.0, "{pixel:?}: {found} m for {exact} m");
        self.add(found, beyond / exact);
    }

    /// A pixel must see the sky.
    #[track_caller]
    pub fn sky(&mut self, found: f64, pixel: impl Debug) {
        assert!(
            ENGINE != Engine::Reference || found.is_infinite(),
            "{pixel:?}: no sky but ground at {found} m"
        );
        self.pixels += 1;
        self.apart += usize::from(found.is_finite());
    }

    fn add(&mut self, found: f64, error: f64) {
        self.pixels += 1;
        if found.is_finite() {
            self.errors.push(error);
        } else {
            self.apart += 1;
        }
    }

    /// Passes sentence on the scene.
    #[track_caller]
    pub fn decide(mut self) {
        assert!(self.errors.len() > 1000, "too few pixels to judge by: {}", self.errors.len());
        self.errors.sort_by(|a, b| b.total_cmp(a));
        for (share, bound) in BOUNDS {
            let error = self.errors[(share * self.errors.len() as f64) as usize];
            assert!(error <= bound, "{share} of the ranges are off by {error} and more, for {bound}");
        }
        let (apart, pixels) = (self.apart, self.pixels);
        assert!(
            apart as f64 <= APART * pixels as f64,
            "sky and ground are mistaken at {apart} of {pixels} pixels"
        );
    }
}
