//! Groups of planes that pages are foreseen for together.

use crate::raymarch::scan::advance::DIVIDE;
use crate::raymarch::scan::{Field, PlaneGroup};
use crate::simd::LANES;

/// Groups side by side.
pub struct Wedge {
    /// The first group, and the one behind the last, counted in the order in which they were added.
    pub groups: [usize; 2],
    pub major: usize,
    pub forward: f64,
    /// Units across per unit of major distance, least and greatest.
    pub minor: [f64; 2],
    /// Curvature's drop per squared unit of major distance, metres, least and greatest.
    pub drop: [f64; 2],
    /// Ground distance per unit of major distance, metres.
    pub ground: [f64; 2],
    /// Major distances between which some plane lies over the area, and between which all do.
    pub over: [f64; 2],
    pub inner: [f64; 2],
    /// Metres of height per unit of major distance: below the lowest rows, and above the highest.
    pub slopes: [f64; 2],
    /// Major distance before which all rays are above the highest surface.
    pub begin: f64,
    /// Metres of height per unit of major distance that ground may rise over from line to line before more lines are read, at least.
    pub steep: f64,
}

impl Wedge {
    /// `ceiling`: height of the highest surface, metres above the eye. `index`: that of the first group.
    pub fn new(groups: &[(PlaneGroup, Field)], ceiling: f64, index: usize) -> Self {
        let extremes = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        };
        let lanes = |of: &dyn Fn(&PlaneGroup) -> [f32; LANES]| {
            extremes(&mut groups.iter().flat_map(|(group, _)| of(group)).map(f64::from))
        };
        let enter = lanes(&|group| group.over[0]);
        let leave = lanes(&|group| group.over[1]);
        let slopes = groups.iter().flat_map(|(group, field)| {
            group.depth.map(|depth| field.tangents.map(|tangent| f64::from(tangent) * f64::from(depth)))
        });
        let slopes = slopes.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [least, most]| {
            [low.min(least), high.max(most)]
        });
        let begin = groups.iter().map(|(group, field)| f64::from(field.begin(group, ceiling)));
        let steep = groups.iter().map(|(group, field)| {
            let tangent = DIVIDE * field.steep_rises().into_iter().fold(0.0, f32::max);
            f64::from(group.depth.iter().fold(f32::INFINITY, |least, &depth| least.min(depth * tangent)))
        });
        let first = &groups[0].0;
        Self {
            groups: [index, index + groups.len()],
            major: first.major,
            forward: first.forward,
            minor: lanes(&|group| group.minor),
            drop: lanes(&|group| group.drop),
            ground: extremes(&mut groups.iter().map(|(group, _)| group.ground)),
            over: [enter[0], leave[1]],
            inner: [enter[1], leave[0]],
            slopes,
            begin: begin.fold(f64::INFINITY, f64::min),
            steep: steep.fold(f64::INFINITY, f64::min),
        }
    }
}
