//! Places along the sun's azimuth, and the outlines that lie towards the sun from them.

use std::ops::Range;

use glam::{DVec2, dvec2};

/// Half of the sun's disc, radians.
const SEMIDIAMETER: f64 = 0.004_654;

/// A sun above the horizon, as its shadows need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sunward {
    /// Unit vector on the ground to the sun.
    toward: DVec2,
    /// Tangent of its elevation: metres that its rays rise on a metre of ground, > 0.
    pub rise: f64,
    /// Half of what rays of its upper and its lower rim differ in height after a metre of ground, metres.
    pub spread: f64,
}

impl Sunward {
    /// Azimuth clockwise from the y axis and elevation above the horizon, degrees; the elevation lies above 0 and below 90.
    pub fn new(azimuth: f64, elevation: f64) -> Self {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let elevation = elevation.to_radians();
        Self {
            toward: dvec2(sin, cos),
            rise: elevation.tan(),
            spread: SEMIDIAMETER / elevation.cos().powi(2),
        }
    }

    /// A place by metres towards the sun (x) and to the left of that (y).
    pub fn turned(&self, place: DVec2) -> DVec2 {
        dvec2(self.toward.dot(place), self.toward.perp_dot(place))
    }

    /// The place of what [`Self::turned`] says.
    pub fn place(&self, turned: DVec2) -> DVec2 {
        self.toward * turned.x + self.toward.perp() * turned.y
    }
}

/// An edge of an outline, turned to the sun.
#[derive(Debug, Clone, Copy)]
struct SunwardEdge {
    a: DVec2,
    b: DVec2,
    owner: u32,
}

/// Outlines, turned to the sun, in strips along its azimuth.
#[derive(Debug)]
pub(super) struct Outlines {
    low: f64,
    width: f64,
    strips: Vec<Vec<SunwardEdge>>,
}

/// Strips of one site, at most.
const MOST_STRIPS: f64 = 4096.0;

impl Outlines {
    /// Rings (turned, with their owners' numbers) that reach into a range across the sun's azimuth; strips are `width` wide or wider.
    pub fn new<'r>(
        rings: impl IntoIterator<Item = (u32, &'r [DVec2])>,
        across: Range<f64>,
        width: f64,
    ) -> Self {
        let width = width.max((across.end - across.start) / MOST_STRIPS);
        let count = ((across.end - across.start) / width).ceil().max(1.0) as usize;
        let mut strips = vec![Vec::new(); count];
        let strip = |y: f64| (((y - across.start) / width).floor().max(0.0) as usize).min(count - 1);
        for (owner, ring) in rings {
            for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let (low, high) = (a.y.min(b.y), a.y.max(b.y));
                if low < high && high >= across.start && low <= across.end {
                    strips[strip(low)..=strip(high)]
                        .iter_mut()
                        .for_each(|edges| edges.push(SunwardEdge { a, b, owner }));
                }
            }
        }
        Self { low: across.start, width, strips }
    }

    /// Edges towards the sun from a place (turned): owner, and metres to it, in no order.
    pub fn ahead(&self, place: DVec2) -> impl Iterator<Item = (u32, f64)> + '_ {
        let strip = ((place.y - self.low) / self.width).floor();
        let edges = if strip >= 0.0 { self.strips.get(strip as usize) } else { None };
        edges.into_iter().flatten().filter_map(move |edge| {
            let crosses = (edge.a.y > place.y) != (edge.b.y > place.y);
            let share = (place.y - edge.a.y) / (edge.b.y - edge.a.y);
            let distance = edge.a.x + share * (edge.b.x - edge.a.x) - place.x;
            (crosses && distance > 0.0).then_some((edge.owner, distance))
        })
    }

    /// Metres to the first outline towards the sun, and whether the place lies within it by the even-odd rule.
    pub fn nearest(&self, place: DVec2) -> Option<(f64, bool)> {
        let (mut nearest, mut count) = (f64::INFINITY, 0);
        for (_, distance) in self.ahead(place) {
            nearest = nearest.min(distance);
            count += 1;
        }
        (count > 0).then_some((nearest, count % 2 == 1))
    }
}
