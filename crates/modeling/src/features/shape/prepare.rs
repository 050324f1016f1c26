//! Relations of features: bridges in several pieces, roads that meet, and buildings that stand there as a whole and in parts.

use std::collections::{HashMap, HashSet};

use glam::DVec2;

use super::super::kinds::{Meaning, Upright, WayKind};
use super::super::layer::{Area, Geometry, Joint, Path};
use super::super::place::Feature;
use super::footprint::Footprint;
use super::frame::{Frame, hull};
use super::junctions;
use super::node::{Node, node};

/// Joins ways over bridges that go on in each other (where they have other lanes, or another surface), so that decks run from bank to bank: the
/// first keeps its meaning, and the others lose their form. Places are metres of the database's system.
fn join_bridges(features: &mut [Feature]) {
    let mut ends: HashMap<(WayKind, i32, Node), Vec<usize>> = HashMap::new();
    let key = |meaning: &Meaning| match meaning {
        Meaning::Way(way) if way.is_bridge => Some((way.kind, way.layer)),
        _ => None,
    };

    for (index, Feature { meaning, geometry, .. }) in features.iter().enumerate() {
        let (Some((kind, layer)), [line]) = (key(meaning), &geometry.lines[..]) else { continue };
        for place in [line.places.first(), line.places.last()].into_iter().flatten() {
            ends.entry((kind, layer, node(*place))).or_default().push(index);
        }
    }

    // Each joint of just two ways, in an order that does not depend on the map's.
    let mut joints: Vec<[usize; 2]> = ends
        .into_values()
        .filter_map(|indices| <[usize; 2]>::try_from(indices).ok())
        .filter(|[a, b]| a != b)
        .collect();
    joints.sort_unstable();
    let mut owner: Vec<usize> = (0..features.len()).collect();

    for [a, b] in joints {
        let (a, b) = (root(&owner, a), root(&owner, b));
        let (first, second) = (a.min(b), a.max(b));
        if first == second {
            continue;
        }
        let joined = chained(&features[first].geometry, &features[second].geometry);
        if let Some(path) = joined {
            features[first].geometry.lines = vec![path];
            features[second].geometry.lines.clear();
            owner[second] = first;
        }
    }
}

fn root(owner: &[usize], mut index: usize) -> usize {
    while owner[index] != index {
        index = owner[index];
    }
    index
}

/// Two lines that share an end as one, which runs as the first does.
fn chained(first: &Geometry, second: &Geometry) -> Option<Path> {
    let ([first], [second]) = (&first.lines[..], &second.lines[..]) else { return None };
    let (mut first, mut second) = (first.places.clone(), second.places.clone());
    let end = |places: &[DVec2]| places.last().copied().map(node);
    let start = |places: &[DVec2]| places.first().copied().map(node);
    let is_before = start(&first) == start(&second) || start(&first) == end(&second);
    if is_before {
        first.reverse();
    }
    if end(&second) == end(&first) {
        second.reverse();
    }
    if end(&first) != start(&second) {
        return None;
    }

    first.extend(second.into_iter().skip(1));
    if is_before {
        first.reverse();
    }

    Some(Path::flat(first))
}

/// Share of a building that its parts cover, from which on they stand for it.
const COVERED: f64 = 0.6;

/// Relates the features of all layers to each other.
pub fn prepare(features: &mut [Feature]) {
    join_bridges(features);
    join_roads(features);
    junctions::find(features);
    carry_lines(features);
    drop_outlines(features);
}

/// Gives power lines the pylons of their vertices that have rows of their own, which are then no second ones there.
fn carry_lines(features: &mut [Feature]) {
    let mut vertices: HashSet<Node> = HashSet::new();
    for feature in features.iter().filter(|feature| matches!(feature.meaning, Meaning::PowerLine(_))) {
        vertices
            .extend(feature.geometry.lines.iter().flat_map(|line| &line.places).map(|place| node(*place)));
    }

    let mut stated: HashMap<Node, Upright> = HashMap::new();
    for feature in features.iter_mut() {
        let Meaning::Pylon(pylon, is_stated) = feature.meaning else { continue };
        feature.geometry.points.places.retain(|place| {
            let carries = vertices.contains(&node(*place));
            // Without a height of its own it is as the line has it, whose volts are known.
            if carries && is_stated {
                stated.insert(node(*place), pylon);
            }
            !carries
        });
    }

    for feature in features.iter_mut() {
        let Meaning::PowerLine(line) = &mut feature.meaning else { continue };
        let places = feature.geometry.lines.iter().flat_map(|line| &line.places);
        line.stated = places.filter_map(|place| Some((*place, *stated.get(&node(*place))?))).collect();
    }
}

/// Finds where roads end on others: there all of them keep the ground's height, so that they meet, and narrower ones go on level to the middle of the wider one.
fn join_roads(features: &mut [Feature]) {
    let road = |feature: &Feature| match feature.meaning {
        Meaning::Way(way) if way.kind == WayKind::Road => Some(way),
        _ => None,
    };
    /// Roads that meet at a node: how many, the half width of the widest one, and whether one of them ends there.
    #[derive(Default)]
    struct Meeting {
        roads: usize,
        half_m: f64,
        has_end: bool,
    }

    let mut meetings: HashMap<Node, Meeting> = HashMap::new();
    for feature in features.iter() {
        let Some(way) = road(feature) else { continue };
        for line in &feature.geometry.lines {
            let last = line.places.len().saturating_sub(1);
            for (index, place) in line.places.iter().enumerate() {
                let meeting = meetings.entry(node(*place)).or_default();
                meeting.roads += 1;
                meeting.has_end |= index == 0 || index == last;
                // Decks have heights of their own.
                meeting.half_m = meeting.half_m.max(if way.is_bridge { 0.0 } else { 0.5 * way.width_m });
            }
        }
    }

    for feature in features.iter_mut() {
        let Some(way) = road(feature).filter(|way| !way.is_bridge) else { continue };
        let joints = feature.geometry.lines.iter().flat_map(|line| &line.places).filter_map(|place| {
            let meeting =
                meetings.get(&node(*place)).filter(|meeting| meeting.roads > 1 && meeting.has_end)?;
            let half_m = if meeting.half_m > 0.5 * way.width_m { meeting.half_m } else { 0.0 };
            Some(Joint { place: *place, half_m })
        });
        feature.geometry.joints = joints.collect();
    }
}

/// Drops outlines of buildings and towers that are there in parts, too, as OpenStreetMap has it: the outline is then no solid of its own.
fn drop_outlines(features: &mut [Feature]) {
    let is_part = |feature: &Feature| match &feature.meaning {
        Meaning::Building(building) => Some(building.is_part),
        Meaning::Upright(_) => Some(false),
        _ => None,
    };
    let of_parts = features.iter().filter(|feature| is_part(feature) == Some(true));
    let footprints = of_parts.flat_map(|feature| feature.geometry.areas.iter().filter_map(Footprint::of));

    let mut parts: Vec<(DVec2, f64)> = footprints
        .filter_map(|footprint| {
            let frame = Frame::around(&hull(&footprint.rings[0]))?;
            Some((frame.middle, footprint.area()))
        })
        .collect();
    if parts.is_empty() {
        return;
    }

    parts.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    let is_covered = |area: &Area| {
        let Some(footprint) = Footprint::of(area) else { return false };
        let [west, south, east, north] = footprint.bounds;
        let from = parts.partition_point(|part| part.0.x < west);
        let near = parts[from..].iter().take_while(|part| part.0.x <= east);
        let inside =
            near.filter(|(middle, _)| (south..=north).contains(&middle.y) && footprint.holds(*middle));
        let covered: f64 = inside.map(|(_, area)| area).sum();
        covered >= COVERED * footprint.area()
    };

    for feature in features.iter_mut().filter(|feature| is_part(feature) == Some(false)) {
        feature.geometry.areas.retain(|area| !is_covered(area));
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::super::super::kinds::{Building, Cap, PowerLine, Rise, RoofShape, Top, Way, Wire};
    use super::super::super::shape::{Bound, bind, settle};
    use super::super::testing::{
        PAINT, at, house, natural, of_area, of_line, of_point, raised, rectangle, road, square,
    };
    use super::*;

    #[test]
    fn bridges_in_pieces_run_from_bank_to_bank() {
        let valley = |place: DVec2| {
            Some(if (at(12.0, 0.0).x..at(52.0, 0.0).x).contains(&place.x) { 80.0 } else { 100.0 })
        };
        let bridge = Meaning::Way(Way { is_bridge: true, ..road(8.0) });
        let feature = |meaning: &Meaning, geometry| Feature { meaning: meaning.clone(), geometry, hash: 1 };
        let piece = |from: f64, to: f64| feature(&bridge, of_line(&[at(from, 24.0), at(to, 24.0)]));

        // The middle one runs the other way; one crosses at a node of three.
        for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
            let pieces = [piece(10.0, 25.0), piece(40.0, 25.0), piece(40.0, 54.0)];
            let mut features: Vec<Feature> = order.map(|index: usize| pieces[index].clone()).into();
            features.push(feature(&Meaning::Way(road(8.0)), of_line(&[at(40.0, 24.0), at(40.0, 44.0)])));
            join_bridges(&mut features);
            let lines: Vec<usize> = features.iter().map(|feature| feature.geometry.lines.len()).collect();
            assert_eq!(lines.iter().sum::<usize>(), 2, "{order:?}");
            let bound: Vec<Bound> = features[..3]
                .iter()
                .flat_map(|feature| bind(&feature.meaning, &feature.geometry, 1, &valley))
                .collect();
            assert_eq!(bound.len(), 1);
            let decks = raised(&bound, &square(1.0), &valley);
            assert!(decks.iter().all(|placed| placed.solid.low_m.is_none() || placed.solid.high_m >= 100.0));
        }
    }

    #[test]
    fn roads_meet_in_height_where_one_ends_on_another() {
        // A slope across the main road, which alone would be cut and filled by a smoothed profile.
        let slope = |place: DVec2| Some(0.25 * (place.y - at(0.0, 0.0).y) + 4.0 * (0.05 * place.x).sin());
        let feature = |width: f64, places: &[DVec2]| Feature {
            meaning: Meaning::Way(road(width)),
            geometry: of_line(places),
            hash: 1,
        };
        let mut features = [
            feature(12.0, &[at(0.0, 24.0), at(31.0, 24.0), at(63.0, 24.0)]),
            feature(5.0, &[at(31.0, 0.0), at(31.0, 24.0)]),
            feature(5.0, &[at(10.0, 40.0), at(10.0, 47.0)]),
        ];
        prepare(&mut features);
        let halves =
            |feature: &Feature| feature.geometry.joints.iter().map(|joint| joint.half_m).collect::<Vec<_>>();
        assert_eq!([0, 1, 2].map(|index: usize| halves(&features[index])), [vec![0.0], vec![6.0], vec![]]);
        let square = square(1.0);
        let ground = natural(&square, &slope);
        let mut heights = ground.clone();
        let graded = features.iter().flat_map(|feature| {
            let bound = bind(&feature.meaning, &feature.geometry, 1, &slope);
            bound.iter().flat_map(|bound| bound.grade(&square, &ground)).collect::<Vec<_>>()
        });
        settle(graded.collect(), &mut heights, |_, _, _, _| ());
        let steps = (8..24).map(|row| heights[square.index(31, row + 1)] - heights[square.index(31, row)]);

        // 6 m higher over the 18 m to the wider road, and twice as steep at most, to its edge, which the cross-slope has lower; from the ground beside that it would
        // be a step of 1.5 m.
        let most = 2.0 * 6.0 / 18.0 + 0.02 * 6.0;
        assert!(steps.clone().all(|step| step.abs() < most), "{:?}", steps.collect::<Vec<_>>());
    }

    #[test]
    fn buildings_in_parts_have_no_outline_besides() {
        let building = |half: f64, x: f64, is_part: bool| {
            let building =
                Building { top: Top::Eaves(9.0), is_part, ..house(RoofShape::Flat, Rise::Height(0.0)) };
            let geometry = of_area(rectangle(at(20.0 + x, 20.0), dvec2(half, 5.0), DVec2::X));
            Feature { meaning: Meaning::Building(building), geometry, hash: 1 }
        };
        let left = |features: &[Feature]| -> Vec<usize> {
            features.iter().map(|feature| feature.geometry.areas.len()).collect()
        };

        let mut features = [
            building(10.0, 0.0, false),
            building(5.0, -5.0, true),
            building(4.0, 6.0, true),
            building(3.0, 20.0, false),
        ];
        prepare(&mut features);
        assert_eq!(left(&features), [0, 1, 1, 1]);

        // A part that covers little leaves the outline.
        let mut features = [building(10.0, 0.0, false), building(2.0, 6.0, true)];
        prepare(&mut features);
        assert_eq!(left(&features), [1, 1]);
    }

    #[test]
    fn lines_hang_from_the_pylons_that_are_stated() {
        let pylon = |height_m: f64| Upright {
            height_m,
            diameter_m: Some(3.0),
            taper: 0.2,
            cap: Cap::Flat,
            opacity: 0.35,
            paint: PAINT,
        };

        let wires = vec![Wire { offset_m: 0.0, height_m: 28.0 }, Wire { offset_m: 4.0, height_m: 21.0 }];
        let line = PowerLine { wires, sag_per_m: 0.0, pylon: pylon(28.0), stated: vec![] };
        let vertices = [at(2.0, 20.0), at(20.0, 20.0), at(40.0, 20.0), at(60.0, 20.0)];
        let feature = |meaning, geometry| Feature { meaning, geometry, hash: 1 };

        let mut features = [
            feature(Meaning::Pylon(pylon(56.0), true), of_point(vertices[1])),
            feature(Meaning::PowerLine(line), of_line(&vertices)),
            // Its height is as the line has it; the last one carries nothing.
            feature(Meaning::Pylon(pylon(50.0), false), of_point(vertices[2])),
            feature(Meaning::Pylon(pylon(50.0), false), of_point(at(30.0, 40.0))),
        ];

        prepare(&mut features);
        let points = features.iter().map(|feature| feature.geometry.points.places.len());
        assert_eq!(points.collect::<Vec<_>>(), [0, 0, 0, 1]);

        let bound = bind(&features[1].meaning, &features[1].geometry, 1, &|_: DVec2| Some(100.0));
        let tops: Vec<f64> = bound
            .iter()
            .filter_map(|bound| if let Bound::Upright(pylon) = bound { Some(pylon.top_m()) } else { None })
            .collect();
        assert_eq!(tops, [128.0, 156.0, 128.0, 128.0]);
        let ends: Vec<[f64; 2]> = bound
            .iter()
            .filter_map(|bound| if let Bound::Wire(wire) = bound { Some(wire.ends_m) } else { None })
            .collect();

        // Two wires of each span, then arms.
        let spans = [[128.0, 156.0], [121.0, 142.0], [156.0, 128.0], [142.0, 121.0], [128.0; 2], [121.0; 2]];
        assert_eq!(ends, [&spans[..], &[[121.0; 2], [142.0; 2], [121.0; 2], [121.0; 2]]].concat());
    }

    #[test]
    fn round_towers_in_parts_have_no_outline_besides() {
        let round = Upright {
            height_m: 60.0,
            diameter_m: None,
            taper: 1.0,
            cap: Cap::Flat,
            opacity: 1.0,
            paint: PAINT,
        };
        let area = || of_area(rectangle(at(20.0, 20.0), dvec2(10.0, 5.0), DVec2::X));
        let part =
            Building { top: Top::Eaves(9.0), is_part: true, ..house(RoofShape::Flat, Rise::Height(0.0)) };
        let mut features = [
            Feature { meaning: Meaning::Upright(round), geometry: area(), hash: 1 },
            Feature { meaning: Meaning::Building(part), geometry: area(), hash: 2 },
        ];
        prepare(&mut features);
        assert!(features[0].geometry.areas.is_empty() && features[1].geometry.areas.len() == 1);
    }
}
