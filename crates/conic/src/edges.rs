//! Edge algorithm: an ellipse on one scan line as straight edges between up to eight points (§2.4.4).
//!
//! ```text
//!  line top     2 ─────── 4        1 left, 3 top, 5 right, 7 bottom: extrema, kept if they lie on the line
//!             1     3       5      2, 4 and 6, 8: crossings of its top and bottom, kept where there are two
//!  line bottom  8 ─────── 6        kept points in a ring; edges along the top and the bottom are dropped
//! ```

use glam::DVec2;

use crate::{ImageConic, ImagePoint, clipped_area};

/// One of the eight points of a scan line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgePoint {
    /// 1…8, from the left extremum clockwise.
    pub number: u8,
    /// Place on the screen.
    pub place: ImagePoint,
}

/// Edges of an ellipse on one scan line.
#[derive(Debug, Clone, PartialEq)]
pub struct LineEdges {
    /// Case, 2…16: one more than the number whose bits say whether points 1, 5, 2 and 6 are kept.
    pub case: u8,
    /// Kept points by their numbers: corners of a convex polygon, as many as there are potential edges.
    pub points: Vec<EdgePoint>,
}

impl LineEdges {
    /// Finds the edges between a `line` and the next one; `None`: the ellipse is not there.
    pub fn of(conic: &ImageConic, line: f64) -> Option<Self> {
        let ([top, bottom], [left, right]) = (conic.vertical_extrema()?, conic.horizontal_extrema()?);
        let below = line + 1.0;
        if top.line >= below || bottom.line <= line {
            return None;
        }

        // By their numbers; those that are not kept are missing.
        let extremum = |at: ImagePoint| (line..below).contains(&at.line).then_some(at);
        let crossed = |line: f64| {
            let found = conic.crossings(line);
            [0, 1].map(|side| found.map(|elements| ImagePoint { line, element: elements[side] }))
        };
        let ([second, fourth], [eighth, sixth]) = (crossed(line), crossed(below));
        let ring =
            [extremum(left), second, extremum(top), fourth, extremum(right), sixth, extremum(bottom), eighth];

        let bits = [1, 5, 2, 6].map(|number| u8::from(ring[number - 1].is_some()));
        let case = 1 + bits.into_iter().fold(0, |bits, bit| 2 * bits + bit);
        let points = (1..).zip(ring).filter_map(|(number, place)| Some(EdgePoint { number, place: place? }));
        Some(Self { case, points: points.collect() })
    }

    /// Edges that do not lie along the top or the bottom of the line.
    pub fn edges(&self) -> impl Iterator<Item = [EdgePoint; 2]> {
        let next = self.points.iter().cycle().skip(1);
        let all = self.points.iter().zip(next).map(|(from, to)| [*from, *to]);
        all.filter(|[from, to]| !matches!([from.number, to.number], [2, 4] | [4, 2] | [6, 8] | [8, 6]))
    }

    /// Returns the share of the pixel from an element to the next that lies between the edges, 0…1.
    pub fn pixel(&self, at: ImagePoint) -> f64 {
        let corners: Vec<_> =
            self.points.iter().map(|point| DVec2::new(point.place.line, point.place.element)).collect();
        let low = DVec2::new(at.line, at.element);
        clipped_area(&corners, low, low + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Table 2: case, potential edges, actual edges.
    const TABLE: [[u8; 3]; 13] = [
        [2, 3, 2],
        [3, 3, 2],
        [4, 4, 2],
        [6, 4, 3],
        [7, 4, 3],
        [8, 5, 3],
        [10, 4, 3],
        [11, 4, 3],
        [12, 5, 3],
        [13, 4, 4],
        [14, 5, 4],
        [15, 5, 4],
        [16, 6, 4],
    ];

    #[test]
    fn all_thirteen_cases_have_the_counts_of_table_2() {
        let mut found: BTreeMap<u8, [u8; 3]> = BTreeMap::new();
        for index in 0..20_000 {
            let part = |step: f64| (f64::from(index) * step).fract();
            let size = if index % 4 == 0 { 30.0 } else { 1.5 };
            let [wide, high] = [0.1 + size * part(0.618_033), 0.1 + size * part(0.414_213)];
            let turn = DVec2::from_angle(3.1 * part(0.732_050));
            let centre = DVec2::new(50.0 + part(0.236_067), 50.0 + part(0.870_550));
            let conic = ImageConic::of_image(centre, [turn * wide, turn.perp() * high]);
            for line in 15..86 {
                let Some(edges) = LineEdges::of(&conic, f64::from(line)) else { continue };
                let counts = [edges.case, edges.points.len() as u8, edges.edges().count() as u8];
                let known = *found.entry(edges.case).or_insert(counts);
                assert_eq!(known, counts, "{edges:?}");
                assert!(edges.points.is_sorted_by_key(|point| point.number));
            }
        }
        assert_eq!(found.into_values().collect::<Vec<_>>(), TABLE);
    }

    #[test]
    fn lines_beside_an_ellipse_have_no_edges() {
        let conic = ImageConic::of_image(DVec2::new(10.5, 4.0), [DVec2::X * 2.25, DVec2::Y * 3.0]);
        let active: Vec<i32> =
            (0..20).filter(|line| LineEdges::of(&conic, f64::from(*line)).is_some()).collect();
        assert_eq!(active, [8, 9, 10, 11, 12]);
    }
}
