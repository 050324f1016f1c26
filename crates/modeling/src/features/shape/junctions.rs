//! Junctions of roads: where lines painted on them end, or open.

use std::collections::HashMap;

use glam::DVec2;

use super::super::kinds::{Meaning, Way, WayKind};
use super::super::layer::Junction;
use super::super::place::Feature;
use super::node::{Node, node};

/// Narrowest road that others end their lines at, metres: paths only cross them.
const NARROWEST: f64 = 2.5;

/// Arms of roads at a node.
#[derive(Default)]
struct Arms {
    /// Width of the road of each arm, metres.
    widths: Vec<f64>,
}

/// Finds the junctions of roads with painted lines.
pub(super) fn find(features: &mut [Feature]) {
    let mut nodes: HashMap<Node, Arms> = HashMap::new();
    for feature in features.iter() {
        let Some(way) = road(feature).filter(|way| way.width_m >= NARROWEST) else { continue };
        for line in &feature.geometry.lines {
            let last = line.places.len().saturating_sub(1);
            for (index, place) in line.places.iter().enumerate() {
                // A road that goes on beyond a node has two arms there.
                let count = if index == 0 || index == last { 1 } else { 2 };
                nodes.entry(node(*place)).or_default().widths.extend([way.width_m].repeat(count));
            }
        }
    }

    for feature in features.iter_mut() {
        let Some(way) = road(feature).filter(|way| way.lines.is_some()) else { continue };
        let places = feature.geometry.lines.iter().flat_map(|line| &line.places);
        let junction = |place: &DVec2| {
            let (half_m, goes_on) = nodes.get(&node(*place))?.seen_from(way.width_m)?;
            Some(Junction { place: *place, half_m, goes_on })
        };
        feature.geometry.junctions = places.filter_map(junction).collect();
    }
}

fn road(feature: &Feature) -> Option<Way> {
    match feature.meaning {
        Meaning::Way(way) if way.kind == WayKind::Road => Some(way),
        _ => None,
    }
}

impl Arms {
    /// Half the width of the widest other road (metres), and whether a road of a width goes on through all of them; `None`: there is none but
    /// what goes on in it.
    fn seen_from(&self, width_m: f64) -> Option<(f64, bool)> {
        if self.widths.len() < 3 {
            return None;
        }

        // Two arms are its own, wherever it is cut in pieces: it and the one most like it.
        let mut others = self.widths.clone();
        others.sort_by(|a, b| (a - width_m).abs().total_cmp(&(b - width_m).abs()));
        let (own, others) = others.split_at(2);
        let widest = others.iter().copied().fold(0.0, f64::max);
        let is_through = own.iter().all(|own| (own - width_m).abs() < 0.5);

        Some((0.5 * widest, is_through && width_m > widest + 0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wider_roads_go_on_and_others_end() {
        let arms = |widths: &[f64]| Arms { widths: widths.to_vec() };
        assert_eq!(arms(&[8.0, 8.0]).seen_from(8.0), None);
        assert_eq!(arms(&[8.0, 6.0]).seen_from(8.0), None);
        assert_eq!(arms(&[8.0, 6.0, 8.0]).seen_from(8.0), Some((3.0, true)));
        // The one that ends there sees the wider one.
        assert_eq!(arms(&[8.0, 6.0, 8.0]).seen_from(6.0), Some((4.0, false)));
        assert_eq!(arms(&[7.0; 4]).seen_from(7.0), Some((3.5, false)));
        assert_eq!(arms(&[8.0, 6.0, 6.0]).seen_from(8.0), Some((3.0, false)));
    }
}
