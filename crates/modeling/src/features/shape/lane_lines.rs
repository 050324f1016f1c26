//! Lines painted on roads: between lanes, and along edges.
//!
//! ```text
//! across  left edge | lane | divider | lane | … | right edge | hard shoulder
//! along   dashes by the distance along the road's own line, so that dividers dash side by side
//! bends   strips of neighbouring segments meet on the bisector (mitre), and cover the bend once
//! junction  another road that is as wide or wider: all lines end at its edge
//!           a narrower one: edge lines open over it, dividers go on
//! ```

use glam::DVec2;

use super::super::kinds::{Dashes, LaneLines};
use super::super::layer::Junction;
use super::ribbon::Line;
use super::strips::Strips;

/// Bends by more than this leave a gap on their outside, cosine of the turn.
const SHARPEST: f64 = -0.2;

/// Stretches along a line, metres, in rising order.
type Stretches = Vec<(f64, f64)>;

/// Paints the lines of a road of this half width (metres) along its line.
pub(super) fn lane_lines(lines: &LaneLines, half: f64, line: &Line, junctions: &[Junction]) -> Strips {
    let mut strips = Strips::default();
    let (mut closed_to_all, mut closed_to_edges) = (Vec::new(), Vec::new());
    for junction in junctions {
        let Some(along) = line.along_of(junction.place) else { continue };
        let mouth = (along - junction.half_m, along + junction.half_m);
        closed_to_edges.push(mouth);
        if !junction.goes_on {
            closed_to_all.push(mouth);
        }
    }
    let dividing = open(line.length(), closed_to_all);
    let edging = open(line.length(), closed_to_edges);

    // Lanes lie between the edge lines; what they leave to the right is a hard shoulder.
    let left = lines.inset_m - half;
    let room = 2.0 * (half - lines.inset_m);
    let lane = room.min(f64::from(lines.lanes) * lines.lane_m) / f64::from(lines.lanes);
    let first = if lines.is_one_way { left } else { -0.5 * lane * f64::from(lines.lanes) };

    for divider in 1..lines.lanes {
        let across = first + lane * f64::from(divider);
        let is_middle = !lines.is_one_way && lines.lanes >= 4 && 2 * divider == lines.lanes;
        let painted = if is_middle { dividing.clone() } else { dashed(&dividing, lines.dashes) };
        add(&mut strips, line, across, lines.width_m, &painted);
    }

    if let Some(edge_m) = lines.edge_m {
        let last = first + lane * f64::from(lines.lanes);
        let right = if lines.is_one_way { last } else { -left };
        for across in [left, right] {
            add(&mut strips, line, across, edge_m, &edging);
        }
    }

    strips
}

/// Stretches of a length that others leave, metres.
fn open(length: f64, mut closed: Stretches) -> Stretches {
    closed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut from, mut stretches) = (0.0_f64, Vec::new());
    for (start, end) in closed {
        if start > from {
            stretches.push((from, start));
        }
        from = from.max(end);
    }
    if from < length {
        stretches.push((from, length));
    }
    stretches
}

/// Dashes within stretches. They count from the line's start, half a gap after which the first one begins, so that ways in pieces go on alike.
fn dashed(stretches: &Stretches, dashes: Dashes) -> Stretches {
    let Dashes { dash_m, gap_m } = dashes;
    let step = dash_m + gap_m;
    let within = |&(from, to): &(f64, f64)| {
        let first = ((from - 0.5 * gap_m - dash_m) / step).floor().max(0.0) as u64;
        let starts = (first..).map(move |index| 0.5 * gap_m + step * index as f64);
        let dashes = starts.take_while(move |start| *start < to);
        dashes
            .map(move |start| (start.max(from), (start + dash_m).min(to)))
            .filter(|(start, end)| start < end)
    };
    stretches.iter().flat_map(within).collect()
}

/// Adds a line of a width, `across` metres to the right of a road's own line, along stretches of it.
fn add(strips: &mut Strips, line: &Line, across: f64, width_m: f64, stretches: &Stretches) {
    let places = line.places();
    let directions: Vec<DVec2> =
        places.windows(2).map(|pair| (pair[1] - pair[0]).normalize_or_zero()).collect();
    let ends = line.distances();
    let sides = [across - 0.5 * width_m, across + 0.5 * width_m];
    for &(from, to) in stretches {
        let segment = ends.partition_point(|end| *end <= from).clamp(1, directions.len()) - 1;
        for segment in segment..directions.len() {
            if ends[segment] >= to {
                break;
            }

            // A cut within a segment is square; one at a bend lies on the bisector.
            let along = directions[segment];
            let cut = |at: f64| {
                let is_bend = |node: usize| (at - ends[node]).abs() < 1e-9;
                let bisector = match () {
                    () if is_bend(segment) && segment > 0 && from < ends[segment] => {
                        mitre(directions[segment - 1], along)
                    }
                    () if is_bend(segment + 1)
                        && segment + 1 < directions.len()
                        && to > ends[segment + 1] =>
                    {
                        mitre(along, directions[segment + 1])
                    }
                    () => right_of(along),
                };
                let place = places[segment] + along * (at - ends[segment]);
                sides.map(|side| place + bisector * side)
            };

            let [start_left, start_right] = cut(from.max(ends[segment]));
            let [end_left, end_right] = cut(to.min(ends[segment + 1]));

            // On the inside of a bend that is tighter than the line is far off there is no room for it.
            let runs_on = |start: DVec2, end: DVec2| (end - start).dot(along) > 0.0;
            if runs_on(start_left, end_left) && runs_on(start_right, end_right) {
                strips.push(vec![vec![start_right, end_right, end_left, start_left]]);
            }
        }
    }
}

fn right_of(along: DVec2) -> DVec2 {
    DVec2::new(along.y, -along.x)
}

/// Direction to the right along the bisector of a bend, as long as it must be for one metre off both segments.
fn mitre(before: DVec2, after: DVec2) -> DVec2 {
    let middle = (right_of(before) + right_of(after)).normalize_or_zero();
    if before.dot(after) < SHARPEST { right_of(after) } else { middle / middle.dot(right_of(before)) }
}
