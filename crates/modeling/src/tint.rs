//! Colours for ground that no imagery covers: a hypsometric ramp, greyed by slope.
//!
//! At the datum, where elevation models put the sea, and below it blues deepen. Above, the ramp runs from the
//! lowland's green over ochre and rock to snow, stretched between the datum (or the lowest ground, if that is higher) and
//! the highest ground. Steep ground shows rock. Shading by the sun is left to the renderer.

use hedgehop_base::colour::linear_from_srgb8;

/// A colour of a ramp.
#[derive(Debug, Clone, Copy)]
struct RampStop {
    /// Place on the ramp, 0…1.
    place: f64,
    /// sRGB.
    colour: [u8; 3],
}

/// Stops of the ramp above the datum.
const LAND: [RampStop; 6] = [
    RampStop { place: 0.00, colour: [96, 128, 74] },
    RampStop { place: 0.15, colour: [122, 146, 84] },
    RampStop { place: 0.35, colour: [168, 164, 108] },
    RampStop { place: 0.60, colour: [156, 132, 98] },
    RampStop { place: 0.82, colour: [138, 126, 116] },
    RampStop { place: 1.00, colour: [236, 236, 238] },
];
/// Stops below the datum, by depth.
const SEA: [RampStop; 3] = [
    RampStop { place: 0.00, colour: [112, 158, 176] },
    RampStop { place: 0.10, colour: [66, 116, 154] },
    RampStop { place: 1.00, colour: [20, 44, 92] },
];
const ROCK: [u8; 3] = [124, 116, 108];
/// Slopes (rise over run) between which ground turns into rock.
const SCREE: (f64, f64) = (0.7, 1.4);
/// Colour where there is no surface.
pub(super) const NEUTRAL: [u8; 3] = [128, 128, 128];

/// A ramp fitted to an area's heights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tint {
    low: f64,
    high: f64,
    /// Heights below the datum are under water: false for local areas, where 0 may be anywhere.
    sea: bool,
}

impl Tint {
    /// Builds the tint of heights `low..=high`, metres; `sea` if 0 is the sea's level.
    pub fn new(low: f64, high: f64, sea: bool) -> Self {
        Self { low, high, sea }
    }

    /// Linear colour at a height in metres and a slope (rise over run).
    pub fn colour(&self, height: f64, slope: f64) -> [f32; 3] {
        if height.is_nan() {
            return linear_from_srgb8(NEUTRAL);
        }
        if self.sea && height <= 0.0 {
            return ramp(&SEA, height / self.low.min(-1.0));
        }
        let foot = if self.sea { self.low.max(0.0) } else { self.low };
        // A flat area has one colour, the lowland's.
        let place = (height - foot) / (self.high - foot).max(1.0);
        let rock = ((slope - SCREE.0) / (SCREE.1 - SCREE.0)).clamp(0.0, 1.0) as f32;
        mix(ramp(&LAND, place), linear_from_srgb8(ROCK), rock)
    }
}

fn ramp(stops: &[RampStop], place: f64) -> [f32; 3] {
    let above = stops.partition_point(|stop| stop.place <= place).clamp(1, stops.len() - 1);
    let (from, to) = (stops[above - 1], stops[above]);
    let share = ((place - from.place) / (to.place - from.place)).clamp(0.0, 1.0);
    mix(linear_from_srgb8(from.colour), linear_from_srgb8(to.colour), share as f32)
}

/// `a` and `share` of `b`.
pub(super) fn mix(a: [f32; 3], b: [f32; 3], share: f32) -> [f32; 3] {
    std::array::from_fn(|channel| a[channel] + (b[channel] - a[channel]) * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::colour::srgb8_from_linear;

    #[test]
    fn sea_is_blue_lowland_green_and_summits_white() {
        let tint = Tint::new(-4000.0, 3000.0, true);
        let srgb = |height, slope| tint.colour(height, slope).map(srgb8_from_linear);
        assert_eq!(srgb(-4000.0, 0.0), SEA[2].colour);
        assert_eq!((srgb(0.0, 0.0), srgb(1e-6, 0.0)), (SEA[0].colour, LAND[0].colour));
        assert_eq!(srgb(3000.0, 0.0), LAND[5].colour);
        assert_eq!(srgb(1500.0, 9.0), ROCK);
        assert_eq!(srgb(f64::NAN, 0.0), NEUTRAL);
    }

    #[test]
    fn a_local_area_has_no_sea() {
        let [red, green, blue] = Tint::new(-50.0, -10.0, false).colour(-50.0, 0.0).map(srgb8_from_linear);
        assert!(green > red && green > blue);
    }
}
