//! Planes through points: weighted least squares, about the middle of a voxel.
//!
//! ```text
//! Σ w (a + b·x + c·y − z)² + λ Σw (b² + c²) → least        (x, y from the points' own middle)
//! ```
//! The second term, ridge regression (Hoerl and Kennard 1970), holds slopes that the points say nothing of at none; of others it takes a part in
//! some hundreds.

/// λ, squares of a voxel's side.
const RIDGE: f64 = 1.0e-3;

/// Sums over points.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaneFit {
    weight: f64,
    /// Σ w · (x, y, z, xx, xy, yy, xz, yz), heights from the first point's.
    sums: [f64; 8],
    datum: f64,
    low: f64,
    high: f64,
}

/// A plane over a voxel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FittedPlane {
    /// Height in the middle of the voxel, metres.
    pub height: f64,
    /// Metres per voxel, eastward and northward.
    pub rise: [f64; 2],
}

impl FittedPlane {
    /// Returns the height at a place, sides of a voxel from its middle.
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.height + self.rise[0] * x + self.rise[1] * y
    }
}

impl PlaneFit {
    /// Through no points.
    pub fn new() -> Self {
        Self { weight: 0.0, sums: [0.0; 8], datum: 0.0, low: f64::INFINITY, high: f64::NEG_INFINITY }
    }

    /// Adds a point.
    pub fn add(&mut self, [x, y]: [f64; 2], z: f64, weight: f64) {
        if weight <= 0.0 {
            return;
        }
        if self.weight == 0.0 {
            self.datum = z;
        }
        let z = z - self.datum;
        let terms = [x, y, z, x * x, x * y, y * y, x * z, y * z];
        self.sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
        self.weight += weight;
        (self.low, self.high) = (self.low.min(z), self.high.max(z));
    }

    /// Weight of all points.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// The plane; `None` without points. In the middle of the voxel it lies no higher and no lower than the points do.
    pub fn plane(&self) -> Option<FittedPlane> {
        if self.weight <= 0.0 {
            return None;
        }
        let mean = self.sums.map(|sum| sum / self.weight);
        let [x, y, z, ..] = mean;
        let (xx, xy, yy) = (mean[3] - x * x + RIDGE, mean[4] - x * y, mean[5] - y * y + RIDGE);
        let (xz, yz) = (mean[6] - x * z, mean[7] - y * z);
        let determinant = xx * yy - xy * xy;
        let rise = [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant];
        let height = (z - rise[0] * x - rise[1] * y).clamp(self.low, self.high);
        Some(FittedPlane { height: self.datum + height, rise })
    }
}

/// A tent of this radius, at a place in the same units.
pub(super) fn tent([x, y]: [f64; 2], radius: f64) -> f64 {
    (1.0 - x.abs() / radius).max(0.0) * (1.0 - y.abs() / radius).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_found_again() {
        let mut fit = PlaneFit::new();
        for (x, y) in [(-0.7, 0.2), (0.4, -0.9), (0.1, 0.6), (0.8, 0.5), (-0.2, -0.3)] {
            fit.add([x, y], 1200.0 + 0.4 * x - 0.2 * y, tent([x, y], 1.5));
        }
        let plane = fit.plane().unwrap();
        assert!((plane.height - 1200.0).abs() < 0.002, "{plane:?}");
        assert!((plane.rise[0] - 0.4).abs() < 0.01 && (plane.rise[1] + 0.2).abs() < 0.01, "{plane:?}");
    }

    #[test]
    fn few_points_make_no_slopes() {
        let mut fit = PlaneFit::new();
        assert_eq!(fit.plane(), None);
        fit.add([0.3, 0.3], 7.0, 0.5);
        assert_eq!(fit.plane(), Some(FittedPlane { height: 7.0, rise: [0.0; 2] }));
        fit.add([0.301, 0.3], 9.0, 0.5);
        let plane = fit.plane().unwrap();
        assert!((7.0..=9.0).contains(&plane.height) && plane.rise[0] < 2.0, "{plane:?}");
    }
}
