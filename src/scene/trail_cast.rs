//! Trails over a database: ways as lines of colours, and which part of them is seen when.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use super::trail::{Trail, TrailColour, TrailQuantity, TrailSource};
use crate::flight::Trajectory;
use crate::objects::{ColourRamp, Ribbon, RibbonLine, RibbonSample};
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::Crs;

/// Distance of a way from the chords between its samples, metres, and length of these at most, where there may be so many.
const OFF: f64 = 0.03;
const LONGEST: f64 = 500.0;
const MOST_SAMPLES: usize = 1_000_000;

/// Samples between two fixes at most.
const MOST_BETWEEN: f64 = 64.0;

/// Time to either side over which speed and climb are measured, seconds: receivers err from second to second.
const ASIDE: f64 = 4.0;

/// Share of a way beyond either end of a range that is taken from its own values of speed and climb.
const BEYOND: f64 = 0.02;

/// Least climb that has the strongest colour where the range is the track's own, metres per second.
const LEAST_CLIMB: f64 = 1.0;

/// Colours from low to high, sRGB: rising in lightness, from one that is seen on dark ground.
const RISING: [[u8; 3]; 5] = [[62, 92, 190], [24, 142, 170], [52, 178, 118], [146, 208, 70], [253, 231, 37]];

/// Colours from sink to climb, sRGB: lightest where it does neither.
const DIVERGING: [[u8; 3]; 5] =
    [[36, 96, 240], [132, 178, 255], [246, 244, 238], [255, 142, 92], [226, 26, 34]];

/// Trails over a database.
#[derive(Debug, Clone, Default)]
pub(super) struct TrailCast(Vec<BoundTrail>);

/// A trail over a database.
#[derive(Debug, Clone)]
struct BoundTrail {
    line: Arc<RibbonLine>,
    ramp: Arc<ColourRamp>,
    width: f64,
    outline: f64,
    /// Seconds after the flight's first fix at which the line's time is 0.
    start: f64,
    tail: Option<f64>,
    is_whole: bool,
}

/// A way over time, seconds after its first fix.
pub(super) struct FlownWay<'w> {
    pub trajectory: &'w Trajectory,
    /// Place at a time, metres: that of the trajectory, or of what goes along it on the ground.
    pub place: Box<dyn Fn(f64) -> DVec3 + 'w>,
    /// Seconds after the flight's first fix at which it begins.
    pub start: f64,
}

impl TrailCast {
    /// `trails` over a database; `way` tells that of an object by its name.
    pub fn bind<'w>(
        trails: &[Trail],
        crs: &Crs,
        ground: &dyn Fn(DVec2) -> Option<f64>,
        wrong: impl Fn(usize, &str) -> Error,
        way: impl Fn(&str) -> Option<FlownWay<'w>>,
    ) -> Result<Self> {
        let bind = |trail: &Trail| {
            let wrong = |what: &str| wrong(trail.line, &format!("trail `{}`: {what}", trail.name));
            match &trail.source {
                TrailSource::Object(name) => {
                    let way = way(name).ok_or_else(|| wrong(&format!("there is no object `{name}`")))?;
                    Ok(BoundTrail::new(trail, &way))
                }
                TrailSource::Track { track, start, options } => {
                    let trajectory = Trajectory::bind(track, crs, ground, options)
                        .map_err(|error| wrong(&error.to_string()))?;
                    let place = Box::new(|seconds| trajectory.position_at(seconds));
                    Ok(BoundTrail::new(trail, &FlownWay { trajectory: &trajectory, place, start: *start }))
                }
            }
        };
        trails.iter().map(bind).collect::<Result<_>>().map(Self)
    }

    /// Returns what is seen of all, so many seconds after the flight's first fix.
    pub fn at(&self, seconds: f64) -> Vec<Ribbon> {
        self.0.iter().filter_map(|trail| trail.at(seconds)).collect()
    }
}

impl BoundTrail {
    fn new(trail: &Trail, way: &FlownWay<'_>) -> Self {
        let mut samples = way.samples();
        let ramp = match trail.colour {
            TrailColour::Plain(colour) => vec![colour],
            TrailColour::By(quantity, range) => {
                let values: Vec<f64> =
                    samples.iter().map(|sample| way.value(quantity, sample.time)).collect();
                let [low, high] = range.unwrap_or_else(|| own_range(quantity, &values));
                for (sample, value) in samples.iter_mut().zip(values) {
                    sample.value = ((value - low) / (high - low)).clamp(0.0, 1.0) as f32;
                }
                let stops = if quantity == TrailQuantity::Climb { DIVERGING } else { RISING };
                stops.map(|codes| Vec3::from(linear_from_srgb8(codes))).to_vec()
            }
        };

        Self {
            line: Arc::new(RibbonLine::new(samples)),
            ramp: Arc::new(ColourRamp::new(ramp)),
            width: trail.width,
            outline: trail.outline,
            start: way.start,
            tail: trail.tail,
            is_whole: trail.is_whole,
        }
    }

    fn at(&self, seconds: f64) -> Option<Ribbon> {
        let (now, end) = (seconds - self.start, self.line.end());
        let from = self.tail.map_or(0.0, |tail| (now - tail).max(0.0));
        let to = if self.is_whole { end } else { now.min(end) };
        (from < to).then(|| Ribbon {
            line: self.line.clone(),
            span: [from, to],
            ramp: self.ramp.clone(),
            width: self.width,
            outline: self.outline,
        })
    }
}

impl FlownWay<'_> {
    /// Samples between which the way is straight; none has a value yet.
    fn samples(&self) -> Vec<RibbonSample> {
        let times = self.trajectory.times();
        let most = (MOST_SAMPLES as f64 / times.len() as f64).clamp(1.0, MOST_BETWEEN);
        let sample = |time: f64| RibbonSample { time, position: (self.place)(time), value: 0.0 };
        let mut samples = vec![sample(0.0)];

        for pair in times.windows(2) {
            let at = |share: f64| pair[0] + share * (pair[1] - pair[0]);
            let [from, to] = [at(0.0), at(1.0)].map(&self.place);
            let off = |share: f64| ((self.place)(at(share)) - from.lerp(to, share)).length();
            let off = [0.25, 0.5, 0.75].into_iter().map(off).fold(0.0, f64::max);

            // Half of a step is off by a quarter.
            let count = (off / OFF).sqrt().max((to - from).length() / LONGEST).ceil().clamp(1.0, most) as u32;
            let between = (1..count).map(|part| at(f64::from(part) / f64::from(count)));
            let known = samples.last().map_or(0.0, |last| last.time);
            samples.extend(between.chain([pair[1]]).filter(|time| *time > known).map(sample));
        }

        samples
    }

    /// Value of a quantity at a time.
    fn value(&self, quantity: TrailQuantity, time: f64) -> f64 {
        if quantity == TrailQuantity::Altitude {
            return (self.place)(time).z;
        }
        let [from, to] = [(time - ASIDE).max(0.0), (time + ASIDE).min(self.trajectory.duration())];
        let velocity = ((self.place)(to) - (self.place)(from)) / (to - from);
        if quantity == TrailQuantity::Climb { velocity.z } else { velocity.truncate().length() }
    }
}

/// Range of a way's own values: all altitudes, and what speeds and climbs nearly all are.
fn own_range(quantity: TrailQuantity, values: &[f64]) -> [f64; 2] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64).round() as usize];
    let [low, high] = match quantity {
        TrailQuantity::Altitude => [at(0.0), at(1.0)],
        TrailQuantity::Speed => [at(BEYOND), at(1.0 - BEYOND)],
        TrailQuantity::Climb => {
            let most = at(1.0 - BEYOND).max(-at(BEYOND)).max(LEAST_CLIMB);
            [-most, most]
        }
    };
    // A level way is of the middle colour.
    if high > low { [low, high] } else { [low - 1.0, low + 1.0] }
}
