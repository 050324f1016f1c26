//! Colours and beams of lamps.

use std::sync::Arc;

use glam::{DVec2, Vec3};

use crate::objects::{Beam, Below, Cone, Fixture};
use hedgehop_base::colour::{LUMINANCE, linear_from_srgb8, srgb8_from_hex};

/// Radius of lamps that say nothing of it, metres.
const RADIUS: f64 = 0.1;

/// Angle over which a PAPI goes from red to white, degrees: three minutes of arc (ICAO Annex 14, § 5.3.5).
const SHARP: f64 = 0.05;

/// Share of intensity that a red filter leaves.
const RED_FILTER: f32 = 0.25;

/// Aviation colours, linear Rec. 709: as near as its primaries allow to the boundaries of ICAO Annex 14, appendix 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour(pub Vec3);

impl Colour {
    pub const WHITE: Self = Self(Vec3::new(1.0, 0.92, 0.78));
    pub const RED: Self = Self(Vec3::new(1.0, 0.01, 0.0));
    pub const GREEN: Self = Self(Vec3::new(0.0, 1.0, 0.12));
    pub const YELLOW: Self = Self(Vec3::new(1.0, 0.45, 0.0));
    pub const BLUE: Self = Self(Vec3::new(0.03, 0.12, 1.0));
    /// Street lamps.
    pub const WARM: Self = Self(Vec3::new(1.0, 0.62, 0.28));

    /// A name or `#rrggbb` (sRGB).
    pub fn parse(text: &str) -> Option<Self> {
        Some(match text {
            "white" => Self::WHITE,
            "red" => Self::RED,
            "green" => Self::GREEN,
            "yellow" => Self::YELLOW,
            "blue" => Self::BLUE,
            "warm" => Self::WARM,
            hex => {
                let colour = Self(linear_from_srgb8(srgb8_from_hex(hex)?).into());
                return (colour.0 != Vec3::ZERO).then_some(colour);
            }
        })
    }

    /// Returns the colour at luminance 1.
    fn unit(self) -> Vec3 {
        self.0 / self.0.dot(LUMINANCE)
    }
}

/// A beam to an azimuth and an elevation, half as bright at angles from there; degrees.
pub fn beam(colour: Colour, candela: f64, middle: [f64; 2], half: [f64; 2]) -> Beam {
    let cone = Cone { middle: DVec2::from(middle), half: DVec2::from(half) };
    Beam { candela, colour: colour.unit(), cone: Some(cone), below: None }
}

/// Light all around.
pub fn around(colour: Colour, candela: f64) -> Beam {
    Beam { candela, colour: colour.unit(), cone: None, below: None }
}

/// A beam that is red below an elevation, degrees, over `over` degrees.
pub fn slope_beam(candela: f64, middle: [f64; 2], half: [f64; 2], elevation: f64, over: f64) -> Beam {
    let below = Below { elevation, over, colour: Colour::RED.unit(), share: RED_FILTER };
    Beam { below: Some(below), ..beam(Colour::WHITE, candela, middle, half) }
}

/// The sharpest beam of that kind: that of a PAPI.
pub fn papi_beam(candela: f64, elevation: f64) -> Beam {
    slope_beam(candela, [180.0, elevation], [10.0, 6.0], elevation, SHARP)
}

/// Lamps of these beams.
pub fn fixture(beams: impl Into<Vec<Beam>>) -> Arc<Fixture> {
    Arc::new(Fixture { radius: RADIUS, beams: beams.into() })
}
