//! Edges that round features save: what polygons of the same quality would need.
//!
//! ```text
//! deviation of a regular polygon from a circle of radius r, its area kept:  r·(√(2π/n / sin(2π/n)) − 1) at corners
//! edges needed = least n from 3 whose deviation is at most half a pixel
//! ```
//!
//! Source: Bunker and Ferris (AFHRL-TR-77-66), §2.6, who count 16 edges to a feature.

use std::f64::consts::TAU;

/// Edges of a polygon that the report takes for one round feature.
pub const EDGES_PER_FEATURE: u32 = 16;

/// Things made of round features, and of edges alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeBudget {
    /// Elliptical or spherical features.
    pub features: u32,
    /// Straight edges beside them.
    pub edges_beside: u32,
    /// Edges of the same thing in polygons alone.
    pub polygon_edges: u32,
}

impl EdgeBudget {
    /// Bomb circle of four concentric discs, each as a polygon of 16 edges.
    pub const BOMB_CIRCLE: Self = Self::of_circles(4);
    /// Shadow or lake.
    pub const SHADOW: Self = Self::of_circles(1);
    /// Storage tank: two discs, and a face of four edges; 48 edges as a prism of 16 sides.
    pub const TANK: Self = Self { features: 2, edges_beside: 4, polygon_edges: 48 };
    /// Dome of a silo, of 68 edges: one sphere.
    pub const DOME: Self = Self { features: 1, edges_beside: 0, polygon_edges: 68 };

    /// Flat circles, each as a polygon of 16 edges.
    pub const fn of_circles(count: u32) -> Self {
        Self { features: count, edges_beside: 0, polygon_edges: EDGES_PER_FEATURE * count }
    }

    /// Edges that one feature stands for; none of nothing.
    pub fn edges_per_feature(self) -> u32 {
        self.polygon_edges.saturating_sub(self.edges_beside).checked_div(self.features).unwrap_or(0)
    }
}

/// Edges of a regular polygon of equal area that lies within half a pixel of a circle of a radius in pixels.
pub fn edges_needed(radius: f64) -> u32 {
    let strays = |edges: &u32| {
        let angle = TAU / f64::from(*edges);
        radius * ((angle / angle.sin()).sqrt() - 1.0) > 0.5
    };
    // From three edges on the sine is above zero.
    (3..100_000).find(|edges| !strays(edges)).unwrap_or(100_000)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::{ImageConic, LineEdges};

    #[test]
    fn a_feature_stands_for_sixteen_edges_or_more() {
        let all = [EdgeBudget::BOMB_CIRCLE, EdgeBudget::SHADOW, EdgeBudget::TANK, EdgeBudget::DOME];
        assert_eq!(all.map(EdgeBudget::edges_per_feature), [16, 16, 22, 68]);
        assert_eq!(EdgeBudget::BOMB_CIRCLE.polygon_edges, 64);
        assert_eq!(EdgeBudget::of_circles(0).edges_per_feature(), 0);
    }

    #[test]
    fn polygons_as_good_as_a_feature_need_sixteen_edges_from_40_pixels_on() {
        let needed: Vec<u32> = [2.0, 5.0, 20.0, 40.0, 116.5].map(edges_needed).to_vec();
        assert!(needed.is_sorted() && needed[0] < 16, "{needed:?}");
        assert!(needed[3] >= EDGES_PER_FEATURE && needed[4] >= 28, "{needed:?}");

        // Corners of such a polygon stray by half a pixel at most, those of one with an edge less by more.
        for radius in [5.0, 20.0, 116.5] {
            let edges = f64::from(edges_needed(radius));
            let corner = |edges: f64| {
                let area = std::f64::consts::PI * radius * radius;
                (2.0 * area / (edges * (TAU / edges).sin())).sqrt() - radius
            };
            assert!(corner(edges) <= 0.5 && corner(edges - 1.0) > 0.5);
        }
    }

    #[test]
    fn the_largest_bomb_circle_has_two_edges_on_each_of_its_lines() {
        let conic = ImageConic::of_image(DVec2::new(240.0, 256.0), [DVec2::X * 116.4, DVec2::Y * 116.4]);
        let lines: Vec<_> = (0..480).filter_map(|line| LineEdges::of(&conic, f64::from(line))).collect();
        let edges: usize = lines.iter().map(|line| line.edges().count()).sum();
        // 233 or 234 lines; where extrema lie on a line, it has another edge.
        assert!((233..=234).contains(&lines.len()), "{}", lines.len());
        assert!((466..=472).contains(&edges), "{edges}");
    }
}
