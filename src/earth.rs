//! The Earth's curvature, with refraction.
//!
//! ```text
//! drop(d) = d² / 2R′        R′ = R / (1 − k)
//! ```
//!
//! The database is a plane: heights over a projected grid. Seen from an eye, ground at the horizontal distance
//! `d` lies lower than that plane says, because the Earth bends away under the eye's horizontal (`d² / 2R`), and
//! not quite as much lower, because light bends after it: by the share `k`, the refraction coefficient of
//! surveyors, about 1/7 in standard air. Both together are a sphere of the radius R′, 7/6 of the Earth's.
//! The parabola stands for the circle: at 100 km it is 3 cm off, at 500 km 19 m.

/// Curvature of the ground: how fast heights drop with distance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Curvature {
    /// `1 / 2R′`, 1/metres, finite, ≥ 0; 0 is flat.
    pub inverse_diameter: f64,
}

impl Curvature {
    /// Mean radius of the Earth, metres (IUGG: a third of the sum of the three axes of WGS 84).
    pub const EARTH_RADIUS: f64 = 6_371_008.8;
    /// Refraction coefficient of standard air: R′ is 7/6 of the Earth's radius.
    pub const STANDARD_REFRACTION: f64 = 1.0 / 7.0;
    /// No curvature: the database is what it says.
    pub const FLAT: Self = Self { inverse_diameter: 0.0 };

    /// The Earth under air of refraction coefficient `k`, −1…1: 0 is vacuum, 1 follows the ground, as if flat.
    pub fn refracted(k: f64) -> Self {
        Self { inverse_diameter: (1.0 - k) / (2.0 * Self::EARTH_RADIUS) }
    }

    /// The Earth under standard air.
    pub fn standard() -> Self {
        Self::refracted(Self::STANDARD_REFRACTION)
    }

    /// R′, metres; `None` if flat.
    pub fn radius(&self) -> Option<f64> {
        (self.inverse_diameter > 0.0).then(|| 0.5 / self.inverse_diameter)
    }

    /// Returns how much lower ground at this horizontal distance (metres) appears, metres.
    pub fn drop_at(&self, ground_distance: f64) -> f64 {
        ground_distance * ground_distance * self.inverse_diameter
    }

    /// Angle of the horizon of a level plain below the horizontal, radians, seen from `height` metres (≥ 0) above it.
    pub fn dip(&self, height: f64) -> f64 {
        (2.0 * (height * self.inverse_diameter).sqrt()).atan()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surveyors_rules_of_thumb_hold() {
        // 7 cm at 1 km; from 10 m above the sea the horizon is 12 km away and 5.6′ low.
        let air = Curvature::refracted(0.13);
        assert!((air.drop_at(1000.0) - 0.068).abs() < 1e-3, "{}", air.drop_at(1000.0));
        let horizon = (10.0 / Curvature::standard().inverse_diameter).sqrt();
        assert!((horizon - 12_200.0).abs() < 100.0, "{horizon}");
        assert!((Curvature::standard().dip(10.0).to_degrees() * 60.0 - 5.64).abs() < 0.05);
    }

    #[test]
    fn flat_is_flat() {
        assert_eq!(Curvature::FLAT.drop_at(1.0e6), 0.0);
        assert_eq!(Curvature::default(), Curvature::refracted(1.0));
        assert_eq!(Curvature::FLAT.dip(500.0), 0.0);
    }
}
