//! Colours of bare ground by its height and slope.

use super::noise::turned;
use crate::tint::{NEUTRAL, mix};
use hedgehop_base::colour::linear_from_srgb8;

/// Degrees below the first slope over which its colour comes in.
const COMING_IN: f64 = 10.0;

/// A colour at a height in metres, or at a slope in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Height or slope of the stop.
    pub at: f64,
    /// sRGB.
    pub colour: [u8; 3],
}

/// A stop in linear light.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LinearStop {
    /// Height in metres, or slope (rise over run).
    at: f64,
    /// Linear red, green and blue.
    colour: [f32; 3],
}

/// Colours between stops; before the first and after the last as there.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    /// Stops by rising height, metres; linear light, at least one.
    heights: Vec<LinearStop>,
    /// Stops by rising slope (rise over run); may be empty.
    slopes: Vec<LinearStop>,
    /// Slope at which the first of them comes in.
    gentle: f64,
    /// Share of them in the colour of imagery, 0…1.
    pub(crate) over_imagery: f64,
}

impl Palette {
    /// Builds the palette of stops by rising height (metres, at least one) and by rising slope (degrees, less than 90). Steep ground has the colours of its slope,
    /// which come in over the ten degrees below the first.
    pub fn new(heights: &[Stop], slopes: &[Stop]) -> Self {
        let rise = |degrees: f64| {
            let way = turned(degrees);
            way.x / way.y
        };
        let linear = |stop: &Stop| LinearStop { at: stop.at, colour: linear_from_srgb8(stop.colour) };
        Self {
            heights: heights.iter().map(linear).collect(),
            slopes: slopes.iter().map(linear).map(|stop| LinearStop { at: rise(stop.at), ..stop }).collect(),
            gentle: slopes.first().map_or(0.0, |first| rise((first.at - COMING_IN).max(0.0))),
            over_imagery: 0.0,
        }
    }

    /// The same with a share, 0…1, in the colour of imagery, that of water left alone.
    #[must_use]
    pub fn over_imagery(self, share: f64) -> Self {
        Self { over_imagery: share, ..self }
    }

    /// Linear colour at a height in metres and a slope (rise over run).
    pub(crate) fn colour(&self, height: f64, slope: f64) -> [f32; 3] {
        if height.is_nan() {
            return linear_from_srgb8(NEUTRAL);
        }
        let level = between(&self.heights, height);
        let Some(LinearStop { at: first, .. }) = self.slopes.first() else { return level };
        let steep =
            if slope >= *first { 1.0 } else { ((slope - self.gentle) / (first - self.gentle)).max(0.0) };
        mix(level, between(&self.slopes, slope), steep as f32)
    }
}

fn between(stops: &[LinearStop], at: f64) -> [f32; 3] {
    let after = stops.partition_point(|stop| stop.at <= at);
    let (before, next) = (after.checked_sub(1).and_then(|before| stops.get(before)), stops.get(after));
    match (before, next) {
        (Some(before), Some(next)) => {
            mix(before.colour, next.colour, ((at - before.at) / (next.at - before.at)) as f32)
        }
        (Some(only), None) | (None, Some(only)) => only.colour,
        (None, None) => linear_from_srgb8(NEUTRAL),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::colour::srgb8_from_linear;

    #[test]
    fn stops_have_their_colours() {
        let stop = |at, colour| Stop { at, colour };
        let (grass, snow, rock, cliff) = ([60, 100, 40], [240; 3], [120, 110, 100], [40; 3]);
        let palette =
            Palette::new(&[stop(100.0, grass), stop(900.0, snow)], &[stop(35.0, rock), stop(60.0, cliff)]);
        let srgb =
            |height, degrees: f64| palette.colour(height, degrees.to_radians().tan()).map(srgb8_from_linear);
        assert_eq!((srgb(-50.0, 0.0), srgb(100.0, 24.9), srgb(2000.0, 0.0)), (grass, grass, snow));
        assert_eq!((srgb(100.0, 35.001), srgb(900.0, 75.0)), (rock, cliff));
        let between = srgb(500.0, 0.0)[0];
        assert!((150..190).contains(&between), "{between}: the mean in linear light");
        assert!(srgb(100.0, 30.0)[0] > grass[0] && srgb(100.0, 30.0)[0] < rock[0]);
        assert_eq!(srgb(f64::NAN, 0.0), NEUTRAL);
    }
}
