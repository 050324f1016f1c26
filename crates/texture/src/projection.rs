//! Perspective of the study: how much ground a pixel covers.
//!
//! ```text
//! d  = ½·pixels·cot(½·field of view)        distance of the screen, pixels
//! ΔX = R²/(h·d)                             along the line of sight, at slant range R from altitude h over flat ground
//! ΔY = R/d                                  across it
//! ```
//!
//! The study prints `320·cot(field of view)`; half the angle is what its geometry needs, and what its
//! footprints fit.

/// Ground that a pixel covers, in the unit of range and altitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundExtent {
    /// Along the line of sight.
    pub along: f64,
    /// Across it.
    pub across: f64,
}

/// Screen of a perspective view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Pixels along a line.
    pub pixels: u32,
    /// Horizontal field of view, degrees, above 0 and below 180.
    pub fov_deg: f64,
}

impl Projection {
    /// Lines of 640 pixels over 20 degrees.
    pub const OF_THE_STUDY: Self = Self { pixels: 640, fov_deg: 20.0 };

    /// Distance of the screen from the eye, pixels.
    pub fn distance(self) -> f64 {
        0.5 * f64::from(self.pixels) / (0.5 * self.fov_deg).to_radians().tan()
    }

    /// Flat ground that a pixel covers at a slant range, seen from an altitude; all lengths in one unit.
    pub fn footprint(self, altitude: f64, range: f64) -> GroundExtent {
        GroundExtent { along: range * range / (altitude * self.distance()), across: range / self.distance() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn footprints_are_those_of_the_study() {
        // Altitude, feet; range, nautical miles; feet along and across, and what half the last printed digit
        // leaves open.
        let printed = [
            (1000.0, 5.0, (515.0, 0.5), (17.0, 0.5)),
            (1000.0, 3.0, (184.0, 0.5), (10.0, 0.5)),
            (300.0, 2.0, (275.0, 0.5), (7.0, 0.5)),
            (300.0, 0.5, (16.9, 0.05), (1.7, 0.05)),
        ];
        for (altitude, miles, along, across) in printed {
            let footprint = Projection::OF_THE_STUDY.footprint(altitude, miles * 6076.1);
            for (got, (printed, rounding)) in [(footprint.along, along), (footprint.across, across)] {
                let off: f64 = got - printed;
                assert!(off.abs() <= rounding || (off / printed).abs() <= 0.03, "{altitude} {miles}: {got}");
            }
        }
    }

    #[test]
    fn distance_follows_field_and_size() {
        let distance = |pixels, fov_deg| Projection { pixels, fov_deg }.distance();
        assert!((distance(640, 20.0) - 1814.8).abs() < 0.1);
        assert!((distance(640, 90.0) - 320.0).abs() < 1e-9);
        assert!((distance(640, 10.0) - 3657.6).abs() < 0.1 && (distance(640, 45.0) - 772.5).abs() < 0.1);
        assert_eq!(distance(1280, 20.0), 2.0 * distance(640, 20.0));
    }
}
