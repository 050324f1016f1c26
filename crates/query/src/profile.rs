//! The ground at places and along straight lines.

use glam::DVec2;

use super::attributes_at;
use hedgehop::raymarch::{PageCursor, Solids};
use hedgehop::voxel::{Attributes, PageSource};
use hedgehop_base::error::{Error, Result};

/// Samples of a line at most; a longer one has them farther apart.
const MOST_SAMPLES: f64 = 1.0e6;

/// Surface that counts as ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// The highest surface: roofs, crowns and decks as well, each as far as its walls.
    #[default]
    Highest,
    /// Ground below all that stands on it. Where a database stores the highest surface alone, outside of its finest level, it is that.
    Bare,
}

impl Ground {
    pub(super) fn cursor(self, source: &dyn PageSource) -> PageCursor<'_> {
        let cursor = PageCursor::new(source);
        if self == Self::Bare { cursor.on_bare_ground() } else { cursor }
    }

    /// Returns the height at a place (metres of the database's system), metres above the database's datum; `None`: there is none.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn height_at(self, source: &dyn PageSource, place: DVec2) -> Result<Option<f64>> {
        Heights::of(self, source).at(place)
    }

    /// Returns the surface of the finest voxel over a place (metres of the database's system); `None`: there is none.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn attributes_at(self, source: &dyn PageSource, place: DVec2) -> Result<Option<Attributes>> {
        let surface = attributes_at(source, place)?;
        if self == Self::Highest || surface.is_none() {
            return Ok(surface);
        }
        let grid = source.header().grid;
        self.cursor(source).attributes_at(0, (place - grid.origin) / grid.spacing).map(Some)
    }
}

/// Least opacity of what counts as a surface, as of that which is stored.
const DENSE: f32 = 0.4;

/// Tells heights at places.
struct Heights<'a> {
    /// The ground below all that stands on it, or the surface where nothing is known to.
    ground: PageCursor<'a>,
    /// Spans on the ground, if those count.
    solids: Option<Solids<'a>>,
}

impl<'a> Heights<'a> {
    fn of(ground: Ground, source: &'a dyn PageSource) -> Self {
        let counts = ground == Ground::Highest && source.header().has_spans;
        // Between voxels' centres the surface that is stored slopes from roofs to the ground: walls are steep.
        let cursor = Ground::Bare.cursor(source);
        let solids = counts.then(|| Solids::new(&PageCursor::new(source)));
        Self { ground: cursor, solids }
    }

    /// Metres above the datum; `None`: there is no ground.
    fn at(&mut self, place: DVec2) -> Result<Option<f64>> {
        let grid = self.ground.source().header().grid;
        if !grid.contains(place) {
            return Ok(None);
        }
        let units = (place - grid.origin) / grid.spacing;
        let ground = self.ground.finest_height(units)?;
        let standing = match &mut self.solids {
            Some(solids) => solids.highest_at(units, DENSE)?,
            None => None,
        };
        Ok(ground.map(|ground| standing.map_or(ground, |standing| standing.max(ground))).or(standing))
    }
}

/// A place along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Distance along the line from its beginning, metres ≥ 0.
    pub distance: f64,
    /// Metres of the database's reference system.
    pub place: DVec2,
    /// Height of the ground, metres above the database's datum; `None`: there is none.
    pub ground: Option<f64>,
}

/// The ground along straight lines from place to place (metres of the database's system): at each of them, and between at equal steps of at most `step` metres.
///
/// # Errors
/// [`Error::Configuration`]: a step that is not positive, or places that are not finite; a page that is damaged.
pub fn profile(source: &dyn PageSource, ground: Ground, places: &[DVec2], step: f64) -> Result<Vec<Sample>> {
    if !(step > 0.0 && places.iter().all(|place| place.is_finite())) {
        return Err(Error::Configuration(format!(
            "a profile needs finite places and a step of more than 0 m, not {step}"
        )));
    }

    let total: f64 = places.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
    let step = step.max(total / MOST_SAMPLES);
    let mut heights = Heights::of(ground, source);
    let mut samples = Vec::new();
    let mut add = |distance, place| -> Result<()> {
        samples.push(Sample { distance, place, ground: heights.at(place)? });
        Ok(())
    };
    let mut distance = 0.0;

    for ends in places.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        let length = from.distance(to);
        let parts = (length / step).ceil().max(1.0) as u32;
        for part in 0..parts {
            let part = f64::from(part) / f64::from(parts);
            add(distance + part * length, from.lerp(to, part))?;
        }
        distance += length;
    }

    if let Some(last) = places.last() {
        add(distance, *last)?;
    }

    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::super::sight::tests::{area, point};
    use super::*;
    use crate::testing::{CODE, pillar, standing};
    use hedgehop::voxel::Span;

    #[test]
    fn profiles_have_their_corners_and_the_ground_below() {
        let area = area(20.0);
        let places = [450.0, 500.0, 470.0].map(|x| point(x, 0.0).truncate());
        for ground in [Ground::Highest, Ground::Bare] {
            let samples = profile(&area, ground, &places, 9.0).unwrap();
            assert_eq!(samples.len(), 6 + 4 + 1);
            assert_eq!(samples[6].place, places[1]);
            assert!((samples.last().unwrap().distance - 80.0).abs() < 1e-9);
            for sample in &samples {
                let wanted = 100.0 + 20.0 * (1.0 - (sample.place.x - 1500.0).abs() / 100.0);
                assert!((sample.ground.unwrap() - wanted).abs() < 0.3, "{sample:?}");
            }
        }
        assert!(profile(&area, Ground::Highest, &places, 0.0).is_err());
        // Beside the area there is no ground.
        let beside = profile(&area, Ground::Highest, &[DVec2::ZERO; 2], 1.0).unwrap();
        assert_eq!(beside[0].ground, None);
    }

    #[test]
    fn bare_ground_lies_below_roofs_and_decks() {
        // A house and a deck of 10 × 10 voxels of 2 m each, on level ground at 0 m.
        let deck = Span { low: CODE.encode(12.0), ..pillar(13.0) };
        let pages = standing(|x, y| match (x, (100..110).contains(&y)) {
            (100..110, true) => vec![pillar(8.0)],
            (120..130, true) => vec![deck],
            _ => Vec::new(),
        });
        let line = [190.0, 270.0].map(|x| DVec2::new(1000.0 + x, 2210.0));
        let heights = |ground| -> Vec<f64> {
            let samples = profile(&pages, ground, &line, 20.0).unwrap();
            samples.iter().map(|sample| sample.ground.unwrap()).collect()
        };

        // At 190, 210, 230, 250 and 270 m.
        let near = |found: &[f64], wanted: [f64; 5]| {
            found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 2.0e-3)
        };
        let [highest, bare] = [Ground::Highest, Ground::Bare].map(heights);
        assert!(near(&highest, [0.0, 8.0, 0.0, 13.0, 0.0]), "{highest:?}");
        assert!(near(&bare, [0.0; 5]), "{bare:?}");

        // Up to their walls, though the surface that is stored slopes to the next voxels' centres.
        let at = |x: f64| Ground::Highest.height_at(&pages, DVec2::new(1000.0 + x, 2210.0)).unwrap().unwrap();
        let steep = [199.9, 200.1, 219.9, 220.1, 239.9, 240.1].map(at);
        let wanted = [0.0, 8.0, 8.0, 0.0, 0.0, 13.0];
        assert!(steep.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 2.0e-3), "{steep:?}");
        let beside = Ground::Bare.attributes_at(&pages, DVec2::ZERO).unwrap();
        assert_eq!((beside, Ground::Bare.height_at(&pages, DVec2::ZERO).unwrap()), (None, None));
    }
}
