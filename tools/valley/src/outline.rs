//! Outlines of areas on the raster, and lines that are drawn for a map.
//!
//! ```text
//! cells between four centres; on each side whose ends differ: the place of 0 between them (marching squares,
//!   Lorensen and Cline 1987 in the plane)
//! each cell joins the side where the walk leaves the area's left to the one where it enters, so rings run
//!   counterclockwise around what is inside
//! ring = such joints until the first side is met again; then simplified (Ramer 1972; Douglas and Peucker 1973)
//! ```

use std::collections::BTreeMap;

use crate::grid::{SIDE, SIZE, SPACING};

/// A place, metres in the area.
pub type Place = (f64, f64);

/// Rings around where values are 0 or less, counterclockwise, the first place not repeated; around holes they run clockwise.
/// At the area's edge they follow it.
pub fn rings(values: impl Fn(usize) -> f64, tolerance: f64) -> Vec<Vec<Place>> {
    // One column and one row more on each side, outside.
    const WIDE: usize = SIZE + 2;

    let value = |c: usize, r: usize| match (c, r) {
        (1..=SIZE, 1..=SIZE) => values((SIZE - r) * SIZE + c - 1).clamp(-20.0, 20.0),
        _ => 1.0,
    };
    let place = |c: f64, r: f64| {
        let metres = |k: f64| ((k - 0.5) * SPACING).clamp(0.0, SIDE);
        (metres(c), metres(r))
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
pub fn area(ring: &[Place]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>() / 2.0
}

fn simplified_ring(ring: &[Place], tolerance: f64) -> Vec<Place> {
    let far = |place: &Place| (place.0 - ring[0].0).hypot(place.1 - ring[0].1);
    let half = (0..ring.len()).max_by(|&a, &b| far(&ring[a]).total_cmp(&far(&ring[b]))).unwrap_or(0);
    let back: Vec<Place> = ring[half..].iter().chain(&ring[..1]).copied().collect();
    let mut whole = simplified(&ring[..=half], tolerance);
    whole.pop();
    whole.extend(simplified(&back, tolerance));
    whole.pop();
    whole
}

/// A line without the places that lie nearer than `tolerance` to what is left.
pub fn simplified(line: &[Place], tolerance: f64) -> Vec<Place> {
    let [first, .., last] = line else { return line.to_vec() };
    let (dx, dy) = (last.0 - first.0, last.1 - first.1);
    let length = dx.hypot(dy);
    let off = |place: &Place| {
        let (x, y) = (place.0 - first.0, place.1 - first.1);
        if length > 0.0 { (x * dy - y * dx).abs() / length } else { x.hypot(y) }
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
pub fn free_parts(line: &[Place], least: f64, free: impl Fn(f64, f64) -> bool) -> Vec<Vec<Place>> {
    let mut parts = vec![Vec::new()];
    for pair in line.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        let count = dx.hypot(dy).ceil().max(1.0);
        for k in 0..count as usize {
            let t = k as f64 / count;
            let place = (pair[0].0 + t * dx, pair[0].1 + t * dy);
            match (free(place.0, place.1), parts.last_mut()) {
                (true, Some(part)) => part.push(place),
                _ => parts.push(Vec::new()),
            }
        }
    }
    parts.retain(|part| part.len() as f64 >= least);
    parts.into_iter().map(|part| simplified(&part, 0.1)).collect()
}
