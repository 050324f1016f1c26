//! Which lines are read at which distance.
//!
//! At a grazing angle a pixel covers many voxels along the ray but about one across it (foreshortening;
//! Evans & Sutherland's CT5A corrects its levels of detail for it). So beyond a part of TH_1 only every
//! second level-1 line is read, then every fourth; beyond TH_4 the lines of level 4, every fourth, and so on:
//! the number of lines grows with the logarithm of distance.

use crate::voxel::Grid;

/// Lines of one level at one stride, from some distance on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stride {
    /// Ground distance from which it holds, metres.
    pub from: f64,
    /// Level index.
    pub level: u8,
    /// Every how many lines of the level one is read: 1, 2 or 4.
    pub lines: u32,
}

/// Strides by ground distance, nearest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Strides {
    steps: Vec<Stride>,
}

/// Distances, in units of TH_1, from which every second and every fourth level-1 line is read.
const SECOND: f64 = 0.27;
const FOURTH: f64 = 0.54;

impl Strides {
    /// For pixels of `pixel_angle` radians (> 0) seen from `clearance` metres above the highest surface
    /// (negative: below it). `detail` (> 0) scales all distances.
    pub fn new(grid: &Grid, level_count: u8, pixel_angle: f64, clearance: f64, detail: f64) -> Self {
        let threshold = detail * grid.spacing / pixel_angle;
        let mut steps = vec![
            Stride { from: 0.0, level: 0, lines: 1 },
            Stride { from: SECOND * threshold, level: 0, lines: 2 },
            Stride { from: FOURTH * threshold, level: 0, lines: 4 },
        ];
        for level in 1..level_count {
            let from = threshold * f64::from(Grid::side_units(level));
            // From high above, a level is fine enough at any distance.
            if from <= clearance {
                steps = vec![Stride { from: 0.0, level, lines: 1 }];
            } else {
                steps.push(Stride { from, level, lines: 4 });
            }
        }
        Self { steps }
    }

    /// Index of the stride at a ground distance, not less than `from`.
    pub fn index_at(&self, ground_distance: f64, from: usize) -> usize {
        let mut index = from;
        while self.steps.get(index + 1).is_some_and(|next| next.from <= ground_distance) {
            index += 1;
        }
        index
    }

    /// A stride.
    pub fn get(&self, index: usize) -> Stride {
        self.steps[index]
    }
}

impl Stride {
    /// Length of a block in lines of the level: the side of a voxel of the skip level.
    pub fn block_lines(&self) -> i64 {
        if self.lines < 4 { 16 } else { 64 }
    }

    /// Level index of the voxels whose bounds skip a block of lines: 16 lines' worth or so.
    pub fn skip_level(&self) -> u8 {
        self.level + if self.lines < 4 { 2 } else { 3 }
    }
}
