//! Rings to polygons: which are outsides, and whose holes the others are.
//!
//! ```text
//! depth of a ring = how many others hold its first place that is on none of their edges
//! even depth: an outside;  odd depth: a hole of the smallest ring that holds it
//! ```
//! The formats say it by the way that rings run, but writers err in it, and nesting does not.

use glam::DVec2;

use super::super::layer::{Area, Path, bounds};

/// Rings of one row that are compared with each other; more of them are taken by the way they run. Likewise edges over the same stretch eastward.
const MOST_COMPARED: usize = 2000;

/// Twice the area that a ring encloses, positive if it runs counter-clockwise.
pub(in super::super) fn doubled_area(ring: &[DVec2]) -> f64 {
    let Some(&origin) = ring.first() else { return 0.0 };
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    pairs.map(|(&a, &b)| (a - origin).perp_dot(b - origin)).sum()
}

/// Whether a place lies within a ring, by the edges that cross the line eastward from it.
pub(in super::super) fn is_inside(ring: &[DVec2], place: DVec2) -> bool {
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    let crosses = |(a, b): &(&DVec2, &DVec2)| {
        (a.y > place.y) != (b.y > place.y) && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    pairs.filter(crosses).count() % 2 == 1
}

/// Whether a ring crosses itself. Edges that touch do not cross: rounding would find faults in sound rings.
pub(in super::super) fn crosses_itself(ring: &[DVec2]) -> bool {
    let eastward = |(a, b): (DVec2, DVec2)| if a.x <= b.x { [a, b] } else { [b, a] };
    let mut edges: Vec<_> =
        ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)).map(eastward).collect();
    edges.sort_by(|one, other| one[0].x.total_cmp(&other[0].x));
    let is_between = |edge: &[DVec2; 2], other: &[DVec2; 2]| {
        let [from, to] = other.map(|place| (edge[1] - edge[0]).perp_dot(place - edge[0]));
        let least = 1e-9 * (edge[1] - edge[0]).length() * (other[1] - other[0]).length();
        from * to < 0.0 && from.abs().min(to.abs()) > least
    };
    edges.iter().enumerate().any(|(index, one)| {
        let beside = edges[index + 1..].iter().take_while(|other| other[0].x <= one[1].x);
        beside.take(MOST_COMPARED).any(|other| is_between(one, other) && is_between(other, one))
    })
}

/// Whether `outer` holds `inner`, both rings that do not cross.
fn holds(outer: &[DVec2], inner: &[DVec2]) -> bool {
    // Rings may touch: most of a few places decide.
    let votes = inner.iter().step_by((inner.len() / 3).max(1)).take(3);
    votes.filter(|place| is_inside(outer, **place)).count() >= 2
}

/// The polygons of a row's rings.
pub(super) fn areas(rings: Vec<Path>) -> Vec<Area> {
    let rings: Vec<Path> = rings.into_iter().filter_map(Path::ring).collect();
    if rings.len() <= 1 {
        return rings.into_iter().map(|outer| Area { outer, holes: Vec::new() }).collect();
    }
    if rings.len() > MOST_COMPARED {
        return by_direction(rings);
    }

    let boxes: Vec<[f64; 4]> = rings.iter().filter_map(|ring| bounds(ring.places.iter().copied())).collect();
    let sizes: Vec<f64> = rings.iter().map(|ring| doubled_area(&ring.places).abs()).collect();
    let within = |a: &[f64; 4], b: &[f64; 4]| a[0] >= b[0] && a[1] >= b[1] && a[2] <= b[2] && a[3] <= b[3];

    // Of every ring, those that hold it.
    let holders: Vec<Vec<usize>> = (0..rings.len())
        .map(|inner| {
            let may = |outer: &usize| sizes[*outer] > sizes[inner] && within(&boxes[inner], &boxes[*outer]);
            let does = |outer: &usize| holds(&rings[*outer].places, &rings[inner].places);
            (0..rings.len()).filter(may).filter(does).collect()
        })
        .collect();

    let mut found: Vec<Option<Area>> = vec![None; rings.len()];
    let mut holes = Vec::new();
    for (index, ring) in rings.into_iter().enumerate() {
        if holders[index].len().is_multiple_of(2) {
            found[index] = Some(Area { outer: ring, holes: Vec::new() });
        } else {
            let smallest = holders[index].iter().copied().min_by(|a, b| sizes[*a].total_cmp(&sizes[*b]));
            holes.push((smallest, ring));
        }
    }

    for (owner, hole) in holes {
        if let Some(area) = owner.and_then(|owner| found[owner].as_mut()) {
            area.holes.push(hole);
        }
    }

    found.into_iter().flatten().collect()
}

/// Shapefiles' rule: outsides run clockwise, and holes follow theirs.
fn by_direction(rings: Vec<Path>) -> Vec<Area> {
    let mut areas: Vec<Area> = Vec::new();
    for ring in rings {
        match areas.last_mut() {
            Some(area) if doubled_area(&ring.places) > 0.0 => area.holes.push(ring),
            _ => areas.push(Area { outer: ring, holes: Vec::new() }),
        }
    }
    areas
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;

    fn square(x: f64, y: f64, side: f64, turned: bool) -> Path {
        let mut places = vec![dvec2(x, y), dvec2(x + side, y), dvec2(x + side, y + side), dvec2(x, y + side)];
        if turned {
            places.reverse();
        }
        places.push(places[0]);
        Path::flat(places)
    }

    #[test]
    fn nesting_decides_whatever_way_rings_run() {
        for turned in 0..32 {
            let way = |bit: u32| turned & (1 << bit) != 0;
            let rings = vec![
                square(2.0, 2.0, 2.0, way(0)),
                square(0.0, 0.0, 10.0, way(1)),
                square(1.0, 1.0, 5.0, way(2)),
                square(20.0, 0.0, 4.0, way(3)),
                square(21.0, 1.0, 1.0, way(4)),
            ];

            let mut areas = areas(rings);
            areas.sort_by(|a, b| {
                doubled_area(&a.outer.places).abs().total_cmp(&doubled_area(&b.outer.places).abs())
            });

            let sides: Vec<(f64, Vec<f64>)> = areas
                .iter()
                .map(|area| {
                    let side = |path: &Path| (doubled_area(&path.places).abs() / 2.0).sqrt();
                    (side(&area.outer), area.holes.iter().map(side).collect())
                })
                .collect();

            assert_eq!(sides, [(2.0, vec![]), (4.0, vec![1.0]), (10.0, vec![5.0])]);
        }
    }

    #[test]
    fn many_rings_are_taken_by_the_way_they_run() {
        let rings = (0..3000).flat_map(|i| {
            let x = f64::from(i) * 10.0;
            [square(x, 0.0, 5.0, true), square(x + 1.0, 1.0, 1.0, false)]
        });
        let areas = areas(rings.collect());
        assert_eq!(areas.len(), 3000);
        assert!(areas.iter().all(|area| area.holes.len() == 1));
    }
}
