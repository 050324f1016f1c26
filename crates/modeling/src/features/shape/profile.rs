//! Heights along a line: as the ground, but smoothed and no steeper than a grade.
//!
//! ```text
//! stations every STEP metres: height of the ground
//! between fixed places, both ends and where other roads end, one part after the other:
//! twice: mean over a window, which narrows towards the ends so that these stay
//! no farther from the heights of both ends than the grade allows; it is at least twice that from end to end
//! graded = mean of  max over j (h_j − grade · |s − s_j|)  and  min over j (h_j + grade · |s − s_j|)
//! ```
//! Neither envelope is steeper than the grade, nor is their mean; where the ground is not steeper, all three are the ground. Each takes one
//! pass forward and one back. Ends stay, since what is within the grade of them moves neither envelope there: ways that end at a node meet.

use super::ribbon::Line;
use super::solid::Ground;

/// Metres between stations.
const STEP: f64 = 4.0;
/// Ratio of a line's slope in between to that from one fixed place to the next, if that is more than its grade: with less room it would be a ramp, whatever
/// the ground is like.
const STEEPER: f64 = 2.0;
/// Most stations of a line.
const MOST: f64 = 200_000.0;

/// A place along a line that keeps its height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedPlace {
    /// Distance along the line, metres.
    pub along: f64,
    /// Distance to either side over which the line stays level, metres.
    pub level: f64,
}

/// Heights along a line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Profile {
    step: f64,
    heights: Vec<f64>,
}

impl Profile {
    /// The ground along a line; `None` where there is none.
    pub fn of_ground(line: &Line, ground: &dyn Ground) -> Option<Self> {
        let parts = (line.length() / STEP).ceil().clamp(1.0, MOST);
        let step = line.length() / parts;
        let known: Vec<Option<f64>> =
            (0..=parts as usize).map(|station| ground.height_at(line.at(step * station as f64).0)).collect();
        Some(Self { step, heights: filled(&known)? })
    }

    /// Smoothed over `window` metres to either side, and no steeper than `grade`, or than twice what takes it from one fixed place to the next. These are both ends and the
    /// stations nearest to `fixed`.
    pub fn graded(mut self, window: f64, grade: f64, fixed: &[FixedPlace]) -> Self {
        let last = self.heights.len() - 1;
        let mut places = vec![(0, 0.0), (last, 0.0)];
        places.extend(fixed.iter().map(|FixedPlace { along, level }| {
            let station = (along / self.step).round().clamp(0.0, last as f64);
            (station as usize, *level)
        }));
        places.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        places.dedup_by_key(|(station, _)| *station);
        for pair in places.windows(2) {
            let part = &mut self.heights[pair[0].0..=pair[1].0];
            grade_part(
                part,
                window / self.step,
                grade * self.step,
                [pair[0].1, pair[1].1].map(|level| level / self.step),
            );
        }
        self
    }

    /// Never rising from the end that is higher to the lower one: the surface of water.
    pub fn falling(mut self) -> Self {
        let is_turned = self.heights.first() < self.heights.last();
        if is_turned {
            self.heights.reverse();
        }

        let mut lowest = f64::INFINITY;
        let least: Vec<f64> = self
            .heights
            .iter()
            .map(|height| {
                lowest = lowest.min(*height);
                lowest
            })
            .collect();

        let mut highest = f64::NEG_INFINITY;
        let back = self.heights.iter().rev().map(|height| {
            highest = highest.max(*height);
            highest
        });
        let most: Vec<f64> = back.collect();
        self.heights =
            least.iter().zip(most.iter().rev()).map(|(least, most)| least.midpoint(*most)).collect();
        if is_turned {
            self.heights.reverse();
        }

        self
    }

    /// Height at a distance along the line, metres, and its grade there.
    pub fn at(&self, along: f64) -> (f64, f64) {
        let last = self.heights.len() - 1;
        let position = (along / self.step).clamp(0.0, last as f64);
        let station = (position as usize).min(last.saturating_sub(1));
        let (a, b) = (self.heights[station], self.heights[(station + 1).min(last)]);
        (a + (b - a) * (position - station as f64), (b - a) / self.step)
    }

    /// The greatest difference from another one along the same line, metres.
    pub fn difference(&self, other: &Self) -> f64 {
        self.heights.iter().zip(&other.heights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

/// Grades what lies between two fixed places. `window` and `level` are steps, `grade` is metres for each of these.
fn grade_part(heights: &mut [f64], window: f64, grade: f64, level: [f64; 2]) {
    let last = heights.len() - 1;
    let reach = window.round().max(0.0) as usize;
    let mut smooth = means(&means(heights, reach), reach);
    let ends = [heights[0], heights[last]];
    let room = (last as f64 - level[0] - level[1]).max(1.0);
    let most = grade.max(STEEPER * (ends[1] - ends[0]).abs() / room);

    // What is too steep from an end on.
    for (station, height) in smooth.iter_mut().enumerate() {
        for (end, distance) in [station, last - station].into_iter().enumerate() {
            let room = most * (distance as f64 - level[end]).max(0.0);
            *height = height.min(ends[end] + room).max(ends[end] - room);
        }
    }

    let (mut above, mut below) = (smooth.clone(), smooth);
    let forward = (0..last).map(|station| (station, station + 1));
    for (from, to) in forward.chain((0..last).rev().map(|station| (station + 1, station))) {
        above[to] = above[to].max(above[from] - most);
        below[to] = below[to].min(below[from] + most);
    }

    for ((height, above), below) in heights.iter_mut().zip(above).zip(below) {
        *height = above.midpoint(below);
    }
}

/// Gaps filled between what is known on either side.
fn filled(known: &[Option<f64>]) -> Option<Vec<f64>> {
    let stations: Vec<(usize, f64)> = known
        .iter()
        .enumerate()
        .filter_map(|(station, height)| height.map(|height| (station, height)))
        .collect();
    let (first, last) = (stations.first()?, stations.last()?);
    let mut next = 0;
    let fill = |station: usize| {
        while stations.get(next).is_some_and(|(at, _)| *at < station) {
            next += 1;
        }
        match (next.checked_sub(1).and_then(|before| stations.get(before)), stations.get(next)) {
            (Some((a, low)), Some((b, high))) => low + (high - low) * ((station - a) as f64 / (b - a) as f64),
            (None, _) => first.1,
            (_, None) => last.1,
        }
    };
    Some((0..known.len()).map(fill).collect())
}

/// Means over as many neighbours on either side as there are on both, `reach` at the most.
fn means(heights: &[f64], reach: usize) -> Vec<f64> {
    let mut total = 0.0;
    // From the first height on, so that sums lose nothing far above the sea.
    let origin = heights.first().copied().unwrap_or(0.0);
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(heights.iter().map(|height| {
            total += height - origin;
            total
        }))
        .collect();
    let last = heights.len().saturating_sub(1);
    let mean = |station: usize| {
        let reach = reach.min(station).min(last - station);
        origin + (sums[station + reach + 1] - sums[station - reach]) / (2 * reach + 1) as f64
    };
    (0..heights.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use glam::dvec2;
    use proptest::prelude::*;

    use super::*;

    fn profile(heights: &[f64]) -> Profile {
        Profile { step: 4.0, heights: heights.to_vec() }
    }

    #[test]
    fn gaps_are_bridged_and_no_ground_is_none() {
        let line = Line::of(&[dvec2(0.0, 0.0), dvec2(40.0, 0.0)]).unwrap();
        let hole = |place: glam::DVec2| (!(10.0..30.0).contains(&place.x)).then_some(place.x);
        assert_eq!(Profile::of_ground(&line, &hole).unwrap().at(20.0), (20.0, 1.0));
        assert_eq!(Profile::of_ground(&line, &|_: glam::DVec2| None), None);
    }

    #[test]
    fn gentle_ground_stays_and_ends_do() {
        let gentle: Vec<f64> = (0..60).map(|i| 500.0 + 0.2 * f64::from(i)).collect();
        let graded = profile(&gentle).graded(24.0, 0.1, &[]);
        assert!(graded.heights.iter().zip(&gentle).all(|(a, b)| (a - b).abs() < 1e-9));
        let rough: Vec<f64> = (0..60).map(|i| 500.0 + (0.9 * f64::from(i)).sin()).collect();
        let graded = profile(&rough).graded(24.0, 1.0, &[]);
        assert!((graded.heights[0] - rough[0]).abs() < 1e-9 && (graded.heights[59] - rough[59]).abs() < 1e-9);
        assert!(graded.heights[10..50].iter().all(|height| (height - 500.0).abs() < 0.2));
    }

    #[test]
    fn fixed_places_keep_their_height_and_are_level_about_it() {
        let rough: Vec<f64> = (0..60).map(|i| 500.0 + 3.0 * (0.9 * f64::from(i)).sin()).collect();
        let fixed = [FixedPlace { along: 0.0, level: 8.0 }, FixedPlace { along: 101.0, level: 0.0 }];
        let graded = profile(&rough).graded(24.0, 0.1, &fixed);
        for (station, from) in [(0, 0), (1, 0), (2, 0), (25, 25), (59, 59)] {
            assert!((graded.heights[station] - rough[from]).abs() < 1e-9, "{station}");
        }
        assert!((graded.heights[3] - rough[0]).abs() <= 0.4 + 1e-9);
    }

    proptest! {
        #[test]
        fn nothing_is_steeper_than_the_grade_and_water_falls(heights in prop::collection::vec(-50.0..50.0_f64, 2..80)) {
            let graded = profile(&heights).graded(16.0, 0.1, &[]);
            let mean = (heights[heights.len() - 1] - heights[0]).abs() / (heights.len() - 1) as f64;
            let most = (STEEPER * mean).max(0.4);
            for pair in graded.heights.windows(2) {
                prop_assert!((pair[1] - pair[0]).abs() <= most + 1e-9);
            }
            let last = heights.len() - 1;
            prop_assert!((graded.heights[0] - heights[0]).abs() < 1e-9);
            prop_assert!((graded.heights[last] - heights[last]).abs() < 1e-9);
            let falling = profile(&heights).falling();
            let sign = if heights.first() < heights.last() { 1.0 } else { -1.0 };
            for pair in falling.heights.windows(2) {
                prop_assert!((pair[1] - pair[0]) * sign >= 0.0);
            }
        }
    }
}
