//! Outlines of areas on the raster, and lines that are drawn for a map. Places are metres in the area.
//!
//! ```text
//! cells between four centres; on each side whose ends differ: the place of 0 between them (marching squares,
//!   Lorensen and Cline 1987 in the plane)
//! each cell joins the side where the walk leaves the area's left to the one where it enters, so rings run
//!   counterclockwise around what is inside
//! ring = such joints until the first side is met again; then simplified (Ramer 1972; Douglas and Peucker 1973)
//! ```

use std::collections::BTreeMap;

use glam::{DVec2, dvec2};

use crate::grid::{SIDE, SIZE, SPACING};

/// Rings around where values are 0 or less, counterclockwise, the first place not repeated; around holes they run clockwise.
/// At the area's edge they follow it.
pub fn rings(values: impl Fn(usize) -> f64, tolerance: f64) -> Vec<Vec<DVec2>> {
    // One column and one row more on each side, outside.
    const WIDE: usize = SIZE + 2;

    let value = |c: usize, r: usize| match (c, r) {
        (1..=SIZE, 1..=SIZE) => values((SIZE - r) * SIZE + c - 1).clamp(-20.0, 20.0),
        _ => 1.0,
    };
    let place = |c: f64, r: f64| {
        let metres = |k: f64| ((k - 0.5) * SPACING).clamp(0.0, SIDE);
        dvec2(metres(c), metres(r))
    };
    let mut joints = BTreeMap::new();

    for r in 0..WIDE - 1 {
        for c in 0..WIDE - 1 {
            // Corners counterclockwise from the south-west, and the sides that begin at each.
            let inside = [(c, r), (c + 1, r), (c + 1, r + 1), (c, r + 1)].map(|(c, r)| value(c, r) <= 0.0);
            let side = [(c, r, 0), (c + 1, r, 1), (c, r + 1, 0), (c, r, 1)];
            for k in (0..4).filter(|&k| inside[k] && !inside[(k + 1) % 4]) {
                let entry =
                    (1..4).map(|back| (k + 4 - back) % 4).find(|&j| !inside[j] && inside[(j + 1) % 4]);
                if let Some(entry) = entry {
                    joints.insert(side[k], side[entry]);
                }
            }
        }
    }

    let crossing = |(c, r, upright): (usize, usize, usize)| {
        let (c1, r1) = (c + 1 - upright, r + upright);
        let (a, b) = (value(c, r), value(c1, r1));
        let t = a / (a - b);
        place(c as f64 + t * (c1 - c) as f64, r as f64 + t * (r1 - r) as f64)
    };
    let mut rings = Vec::new();

    while let Some((first, mut next)) = joints.pop_first() {
        let mut ring = vec![crossing(first)];
        while next != first {
            ring.push(crossing(next));
            let Some(after) = joints.remove(&next) else { break };
            next = after;
        }
        rings.push(simplified_ring(&ring, tolerance));
    }

    rings
}

/// Twice the area of a ring is the sum of these; positive if it runs counterclockwise.
pub fn area(ring: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>() / 2.0
}

fn simplified_ring(ring: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let far = |place: &DVec2| (place.x - ring[0].x).hypot(place.y - ring[0].y);
    let half = (0..ring.len()).max_by(|&a, &b| far(&ring[a]).total_cmp(&far(&ring[b]))).unwrap_or(0);
    let back: Vec<DVec2> = ring[half..].iter().chain(&ring[..1]).copied().collect();
    let mut whole = simplified(&ring[..=half], tolerance);
    whole.pop();
    whole.extend(simplified(&back, tolerance));
    whole.pop();
    whole
}

/// A line without the places that lie nearer than `tolerance` to what is left.
pub fn simplified(line: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let [first, .., last] = line else { return line.to_vec() };
    let way = last - first;
    let length = way.x.hypot(way.y);
    let off = |place: &DVec2| {
        let DVec2 { x, y } = place - first;
        if length > 0.0 { (x * way.y - y * way.x).abs() / length } else { x.hypot(y) }
    };
    let farthest = (1..line.len() - 1).max_by(|&a, &b| off(&line[a]).total_cmp(&off(&line[b])));
    match farthest.filter(|&k| off(&line[k]) > tolerance) {
        Some(k) => {
            let mut whole = simplified(&line[..=k], tolerance);
            whole.pop();
            whole.extend(simplified(&line[k..], tolerance));
            whole
        }
        None => vec![*first, *last],
    }
}

/// The parts of a line, no shorter than `least` metres, along which every place is free.
pub fn free_parts(line: &[DVec2], least: f64, free: impl Fn(f64, f64) -> bool) -> Vec<Vec<DVec2>> {
    let mut parts = vec![Vec::new()];
    for pair in line.windows(2) {
        let way = pair[1] - pair[0];
        let count = way.x.hypot(way.y).ceil().max(1.0);
        for k in 0..count as usize {
            let t = k as f64 / count;
            let place = pair[0] + t * way;
            match (free(place.x, place.y), parts.last_mut()) {
                (true, Some(part)) => part.push(place),
                _ => parts.push(Vec::new()),
            }
        }
    }
    parts.retain(|part| part.len() as f64 >= least);
    parts.into_iter().map(|part| simplified(&part, 0.1)).collect()
}
