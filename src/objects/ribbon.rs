//! Ribbons: the way that something flew, as a line of a width in pixels.
//!
//! ```text
//! samples ──▶ tree of chords: a node knows the sphere around its samples, and how far they lie off its chord
//! a view: nodes that are beside it are skipped; chords that no pixel tells from their samples ──▶ pieces, in order of time
//! ```
//!
//! A node's bound needs its two halves alone: a sample lies off the node's chord by no more than off that of its half, and the middle by as
//! much more (a chord's distance from another that begins where it does is greatest at its other end).

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};

/// Segments of the smallest nodes.
const LEAF: usize = 8;

/// A place on the way of something, and what colours it there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RibbonSample {
    /// Seconds, increasing from sample to sample.
    pub time: f64,
    /// Metres (x east, y north, z above the datum).
    pub position: DVec3,
    /// Place on the ramp of colours, 0…1.
    pub value: f32,
}

/// A way of many samples, and its tree of chords.
#[derive(Debug, Clone, Default)]
pub struct RibbonLine {
    samples: Vec<RibbonSample>,
    /// A node before what is below it.
    nodes: Vec<ChordNode>,
}

/// Samples that follow each other, and how well the chord from the first to the last one stands for them.
#[derive(Debug, Clone)]
pub struct ChordNode {
    samples: Range<usize>,
    /// Centre of a sphere around all samples, metres in the world.
    pub centre: DVec3,
    /// Radius of the sphere, metres.
    pub radius: f64,
    /// Distance of samples from the chord at most, metres.
    pub off: f64,
    /// Difference of their values from the chord's at most.
    pub unlike: f32,
    /// Number of the next node that is not below this one.
    next: usize,
}

/// Judgement of a view on a node of a ribbon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// Nothing of it is in the view.
    Beside,
    /// The chord stands for all samples.
    Fine,
    /// The halves are to be looked at.
    Coarse,
}

/// Colours from a value of 0 to one of 1, evenly spaced: linear Rec. 709.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourRamp(Vec<Vec3>);

/// A part of a way as pictures show it.
#[derive(Debug, Clone)]
pub struct Ribbon {
    /// The way.
    pub line: Arc<RibbonLine>,
    /// Times of its ends, seconds of the line.
    pub span: [f64; 2],
    /// Colours of its values, as pictures show them without haze.
    pub ramp: Arc<ColourRamp>,
    /// Width, pixels, > 0.
    pub width: f64,
    /// Width of the dark outline on either side, pixels, ≥ 0.
    pub outline: f64,
}

impl Ribbon {
    /// The same on pixels that are `times` as fine.
    #[must_use]
    pub fn enlarged(&self, times: u32) -> Self {
        let times = f64::from(times);
        Self { width: self.width * times, outline: self.outline * times, ..self.clone() }
    }

    /// Distance from the middle to the end of the outline, pixels.
    pub fn reach(&self) -> f64 {
        0.5 * self.width + self.outline
    }
}

impl ColourRamp {
    /// A ramp through `stops`; black where there are none.
    pub fn new(stops: Vec<Vec3>) -> Self {
        Self(stops)
    }

    /// Returns the colour of a value.
    pub fn at(&self, value: f32) -> Vec3 {
        let Some(last) = self.0.len().checked_sub(1) else { return Vec3::ZERO };
        let place = value.clamp(0.0, 1.0) * last as f32;
        // A float converts saturating.
        let index = (place as usize).min(last);
        self.0[index].lerp(self.0[(index + 1).min(last)], place - index as f32)
    }
}

impl RibbonLine {
    /// A line through samples of increasing times.
    pub fn new(samples: Vec<RibbonSample>) -> Self {
        let mut line = Self { nodes: Vec::with_capacity(samples.len() / LEAF * 4), samples };
        if line.samples.len() > 1 {
            line.grow(0..line.samples.len() - 1);
        }
        line
    }

    /// Time of the last sample, seconds.
    pub fn end(&self) -> f64 {
        self.samples.last().map_or(0.0, |sample| sample.time)
    }

    /// Adds the node of some segments, and all below it; the number of that node.
    fn grow(&mut self, segments: Range<usize>) -> usize {
        let own = self.nodes.len();
        let samples = segments.start..segments.end + 1;
        self.nodes.push(self.leaf(samples.clone()));
        if segments.len() > LEAF {
            let middle = usize::midpoint(segments.start, segments.end);
            let one = self.grow(segments.start..middle);
            let other = self.grow(middle..segments.end);
            self.nodes[own] = self.node(samples, middle, [one, other]);
        }
        self.nodes[own].next = self.nodes.len();
        own
    }

    /// A node without others below it.
    fn leaf(&self, samples: Range<usize>) -> ChordNode {
        let all = &self.samples[samples.clone()];
        let centre = all.iter().map(|sample| sample.position).sum::<DVec3>() / all.len() as f64;
        let chord = Chord { from: all[0], to: all[all.len() - 1] };
        let mut node = ChordNode { samples, centre, radius: 0.0, off: 0.0, unlike: 0.0, next: 0 };
        for sample in all {
            let (off, unlike) = chord.differs(sample);
            node.radius = node.radius.max((sample.position - centre).length());
            (node.off, node.unlike) = (node.off.max(off), node.unlike.max(unlike));
        }
        node
    }

    /// A node over two halves, which meet at the sample `middle`.
    fn node(&self, samples: Range<usize>, middle: usize, halves: [usize; 2]) -> ChordNode {
        let [one, other] = halves.map(|half| &self.nodes[half]);
        let chord = Chord { from: self.samples[samples.start], to: self.samples[samples.end - 1] };
        let (off, unlike) = chord.differs(&self.samples[middle]);
        let way = other.centre - one.centre;
        let apart = way.length();

        // The sphere around two spheres, of which one may hold the other.
        let radius = (0.5 * (apart + one.radius + other.radius)).max(one.radius).max(other.radius);
        let along = if radius == other.radius { apart } else { radius - one.radius };
        let centre = one.centre + way.normalize_or_zero() * along;

        ChordNode {
            samples,
            centre,
            radius,
            off: off + one.off.max(other.off),
            unlike: unlike + one.unlike.max(other.unlike),
            next: 0,
        }
    }

    /// Tells `put` the two ends of each piece of the line from `from` to `to` seconds, in order, as coarsely as `judge` lets it.
    pub fn pieces(
        &self,
        [from, to]: [f64; 2],
        judge: impl Fn(&ChordNode) -> Sight,
        mut put: impl FnMut(&RibbonSample, &RibbonSample),
    ) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let samples = &self.samples[node.samples.clone()];
            let [first, last] = [&samples[0], &samples[samples.len() - 1]];
            let sight = if last.time <= from || first.time >= to { Sight::Beside } else { judge(node) };
            let is_whole = first.time >= from && last.time <= to;
            let is_leaf = node.next == at + 1;
            match sight {
                Sight::Beside => {}
                Sight::Fine if is_whole => put(first, last),
                Sight::Fine | Sight::Coarse if is_leaf => {
                    for pair in samples.windows(2).filter(|pair| pair[1].time > from && pair[0].time < to) {
                        let chord = Chord { from: pair[0], to: pair[1] };
                        put(&chord.at(from.max(pair[0].time)), &chord.at(to.min(pair[1].time)));
                    }
                }
                Sight::Fine | Sight::Coarse => {
                    at += 1;
                    continue;
                }
            }
            at = node.next;
        }
    }
}

/// A straight piece of a line.
struct Chord {
    from: RibbonSample,
    to: RibbonSample,
}

impl Chord {
    /// The sample at a time between its ends.
    fn at(&self, time: f64) -> RibbonSample {
        let share = (time - self.from.time) / (self.to.time - self.from.time);
        match share {
            0.0 => self.from,
            1.0 => self.to,
            _ => self.along(time, share),
        }
    }

    /// The sample at a share of the way.
    fn along(&self, time: f64, share: f64) -> RibbonSample {
        RibbonSample {
            time,
            position: self.from.position.lerp(self.to.position, share),
            value: self.from.value + share as f32 * (self.to.value - self.from.value),
        }
    }

    /// Returns how far a sample lies off the chord, metres, and how much its value differs from that of the nearest place on it.
    fn differs(&self, sample: &RibbonSample) -> (f64, f32) {
        let (way, own) = (self.to.position - self.from.position, sample.position - self.from.position);
        let share = (own.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let nearest = self.along(sample.time, share);
        ((sample.position - nearest.position).length(), (sample.value - nearest.value).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A climb in circles that drift, whose value rises.
    fn helix(count: u32) -> RibbonLine {
        let at = |index: u32| {
            let time = f64::from(index);
            let (sine, cosine) = (0.3 * time).sin_cos();
            let position = DVec3::new(5.0e5 + 40.0 * sine + 2.0 * time, 5.0e6 + 40.0 * cosine, 500.0 + time);
            RibbonSample { time, position, value: time as f32 / count as f32 }
        };
        RibbonLine::new((0..count).map(at).collect())
    }

    fn pieces(line: &RibbonLine, span: [f64; 2], most: f64) -> Vec<[RibbonSample; 2]> {
        let mut all = Vec::new();
        let judge = |node: &ChordNode| if node.off <= most { Sight::Fine } else { Sight::Coarse };
        line.pieces(span, judge, |from, to| all.push([*from, *to]));
        all
    }

    #[test]
    fn chords_keep_within_what_is_asked_for_and_follow_each_other() {
        let line = helix(1000);
        for (most, counts) in [(0.0, 999..=999), (90.0, 2..=200), (1.0e4, 1..=1)] {
            let found = pieces(&line, [0.0, 999.0], most);
            assert!(counts.contains(&found.len()), "{} chords within {most} m", found.len());
            for pair in found.windows(2) {
                assert_eq!(pair[0][1], pair[1][0]);
            }
            for [from, to] in found {
                let chord = Chord { from, to };
                let within =
                    line.samples.iter().filter(|sample| (from.time..=to.time).contains(&sample.time));
                for sample in within {
                    assert!(chord.differs(sample).0 <= most + 1e-6, "{sample:?}");
                }
            }
        }
    }

    #[test]
    fn spans_are_cut_to_the_moment() {
        let line = helix(500);
        for most in [0.0, 5.0, 1.0e4] {
            let found = pieces(&line, [17.25, 300.5], most);
            let [first, last] = [found[0][0], found[found.len() - 1][1]];
            assert_eq!((first.time, last.time), (17.25, 300.5));
        }
        assert!(pieces(&line, [600.0, 700.0], 0.0).is_empty() && pieces(&line, [5.0, 5.0], 0.0).is_empty());
        assert!(pieces(&helix(1), [0.0, 1.0], 0.0).is_empty());
    }

    #[test]
    fn spheres_hold_their_samples() {
        let line = helix(777);
        for node in &line.nodes {
            for sample in &line.samples[node.samples.clone()] {
                assert!((sample.position - node.centre).length() <= node.radius * (1.0 + 1e-9) + 1e-6);
            }
        }
    }

    #[test]
    fn ramps_go_through_their_stops() {
        let ramp = ColourRamp::new(vec![Vec3::ZERO, Vec3::X, Vec3::ONE]);
        assert_eq!(
            [-1.0, 0.25, 0.5, 1.0, 2.0].map(|value| ramp.at(value)),
            [Vec3::ZERO, 0.5 * Vec3::X, Vec3::X, Vec3::ONE, Vec3::ONE]
        );
    }
}
