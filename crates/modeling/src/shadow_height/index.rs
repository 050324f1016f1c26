//! Index of boxes that finds those which meet a box.

use std::collections::BTreeMap;

use glam::{DVec2, I64Vec2};

use super::bounds::PlaceBounds;

/// Boxes by the square cells that they touch.
#[derive(Debug)]
pub(super) struct Index {
    cell: f64,
    cells: BTreeMap<(i64, i64), Vec<u32>>,
    /// Boxes that touch many cells.
    large: Vec<u32>,
}

/// Cells that a box touches.
#[derive(Debug, Clone, Copy)]
struct CellBlock {
    /// Lowest column and row.
    low: I64Vec2,
    /// Highest column and row.
    high: I64Vec2,
}

/// Cells along a side of a box that is not large.
const MOST: i64 = 8;

impl Index {
    /// Boxes with their numbers, by cells of a side, metres.
    pub fn new(boxes: impl IntoIterator<Item = (u32, PlaceBounds)>, cell: f64) -> Self {
        let mut index = Self { cell, cells: BTreeMap::new(), large: Vec::new() };
        for (number, bounds) in boxes {
            let CellBlock { low, high } = index.cells(bounds);
            if high.x - low.x >= MOST || high.y - low.y >= MOST {
                index.large.push(number);
                continue;
            }
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    index.cells.entry((x, y)).or_default().push(number);
                }
            }
        }
        index
    }

    fn cells(&self, bounds: PlaceBounds) -> CellBlock {
        let cell = |place: DVec2| (place / self.cell).floor().as_i64vec2();
        CellBlock { low: cell(bounds.low), high: cell(bounds.high) }
    }

    /// Numbers of boxes that may meet a box, each once, in order.
    pub fn near(&self, bounds: PlaceBounds) -> Vec<u32> {
        let CellBlock { low, high } = self.cells(bounds);
        let mut found = self.large.clone();
        // Wide boxes ask for more cells than there are.
        for x in low.x..=high.x.min(low.x.saturating_add(1 << 16)) {
            let column = self.cells.range((x, low.y)..=(x, high.y));
            column.for_each(|(_, numbers)| found.extend(numbers));
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_boxes_that_meet_are_found_once() {
        let at = |x: f64, y: f64, size: f64| PlaceBounds {
            low: DVec2::new(x, y),
            high: DVec2::new(x + size, y + size),
        };
        let boxes =
            [at(0.0, 0.0, 10.0), at(95.0, 95.0, 10.0), at(-500.0, -500.0, 10_000.0), at(700.0, 0.0, 1.0)];
        let index = Index::new((0..).zip(boxes), 100.0);
        assert_eq!(index.near(at(101.0, 101.0, 1.0)), [1, 2]);
        assert_eq!(index.near(at(-10.0, -10.0, 120.0)), [0, 1, 2]);
        assert_eq!(index.near(at(700.5, 0.5, 0.1)), [2, 3]);
    }
}
