//! Lines of posts that are read, by distance.
//!
//! At a grazing angle a pixel covers many voxels along the ray but about one across it (foreshortening;
//! Evans & Sutherland's CT5A corrects its levels of detail for it). So beyond a part of TH_1 only every
//! second level-1 line is read, then every fourth; beyond TH_4 the lines of level 4, every fourth, and so on:
//! the number of lines grows with the logarithm of distance.

use crate::voxel::{BARE, Grid};

/// Lines of one level at one stride, from some distance on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stride {
    /// Ground distance from which it holds, metres.
    pub from: f64,
    /// Level index, or [`BARE`].
    pub level: u8,
    /// Every how many lines of the level one is read: 1, 2 or 4.
    pub lines: u32,
    /// The level stands in for a finer one, of which a page is absent.
    pub stands_in: bool,
}

/// Strides by ground distance, nearest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Strides {
    steps: Vec<Stride>,
    /// Ground distance up to which it is bare, metres.
    bare_until: f64,
}

/// Distances, in units of TH_1, from which every second and every fourth level-1 line is read.
const SECOND: f64 = 0.7;
const FOURTH: f64 = 1.4;

/// Rows that flat ground may rise over from one line that is read to the next.
const MOST_ROWS: f64 = 0.4;

/// Outlook of the planes: eye, field and fineness.
#[derive(Debug, Clone, Copy)]
pub struct Outlook {
    /// Angle of a pixel, radians, > 0.
    pub pixel_angle: f64,
    /// Height above the highest surface, metres; negative below it.
    pub clearance: f64,
    /// Height above the ground about, metres, ≥ 0.
    pub height: f64,
}

impl Strides {
    /// Chooses the strides that `outlook` asks for. `detail` (> 0) scales all distances.
    pub fn new(grid: &Grid, level_count: u8, outlook: Outlook, detail: f64) -> Self {
        let Outlook { pixel_angle, clearance, height } = outlook;
        let threshold = detail * grid.spacing / pixel_angle;

        // Flat ground rises by height / distance² per metre.
        let flat = |lines: u32, level: u8| {
            let rows = f64::from(lines * Grid::side_units(level)) * height * threshold;
            (rows / MOST_ROWS).sqrt()
        };
        // Lines a pixel apart, seen across, are close enough however steep the view: levels begin there too.
        let across = |lines: u32, level: u8| {
            let range = f64::from(lines * Grid::side_units(level)) * threshold;
            (range * range - clearance.max(0.0).powi(2)).max(0.0).sqrt()
        };
        let mut steps: Vec<Stride> = Vec::new();

        for level in 0..level_count {
            let side = f64::from(Grid::side_units(level));
            let from = if level == 0 { 0.0 } else { side * threshold };

            // From high above, a level is fine enough at any distance.
            if from <= clearance {
                steps.clear();
            }
            let [second, fourth] =
                if level == 0 { [SECOND, FOURTH].map(|share| share * threshold) } else { [from; 2] };

            for (lines, at_least) in [(1, from), (2, second), (4, fourth)] {
                let longer = at_least.max(flat(lines, level)).min(across(lines, level));
                let from = if lines == 1 { from } else { longer };
                // What would be read nowhere is none.
                while steps.last().is_some_and(|last| last.from >= from) {
                    steps.pop();
                }
                steps.push(Stride { from, level, lines, stands_in: false });
            }
        }

        if let Some(first) = steps.first_mut() {
            first.from = 0.0;
        }

        Self { steps, bare_until: 0.0 }
    }

    /// The same with bare ground up to a ground distance, metres.
    #[must_use]
    pub fn with_bare_ground(mut self, until: f64) -> Self {
        let finest = self.steps.iter().take_while(|step| step.level == 0 && step.from < until).count();
        let Some(last) = finest.checked_sub(1) else { return self };
        let surface = Stride { from: until, ..self.steps[last] };
        self.steps[..finest].iter_mut().for_each(|step| step.level = BARE);
        if self.steps.get(finest).is_none_or(|next| until < next.from) {
            self.steps.insert(finest, surface);
        }
        self.bare_until = until;
        self
    }

    /// Ground distance up to which bare ground is seen, metres; 0: nowhere.
    pub fn bare_until(&self) -> f64 {
        self.bare_until
    }

    /// Index of the first stride that is not of bare ground.
    pub fn first_of_surface(&self) -> usize {
        self.steps.iter().take_while(|step| step.level == BARE).count()
    }

    /// Index of the stride at a ground distance, not less than `from`.
    pub fn index_at(&self, ground_distance: f64, from: usize) -> usize {
        let mut index = from;
        while self.steps.get(index + 1).is_some_and(|next| next.from <= ground_distance) {
            index += 1;
        }
        index
    }

    /// A stride, and the ground distance up to which it holds.
    pub fn with_end(&self, index: usize) -> (Stride, f64) {
        (self.steps[index], self.steps.get(index + 1).map_or(f64::INFINITY, |next| next.from))
    }

    /// A stride.
    pub fn get(&self, index: usize) -> Stride {
        self.steps[index]
    }
}

impl Stride {
    /// Length of a block in lines of the level, of which sixteen are read.
    pub fn block_lines(&self) -> i64 {
        16 * i64::from(self.lines)
    }

    /// The same in units.
    pub fn block_units(&self) -> f64 {
        self.block_lines() as f64 * f64::from(Grid::side_units(self.level))
    }

    /// Level index of the voxels whose bounds skip a block of lines: 16 lines' worth or so.
    pub fn skip_level(&self) -> u8 {
        let level = if self.level == BARE { 0 } else { self.level };
        level + if self.lines < 4 { 2 } else { 3 }
    }

    /// The next coarser level, which stands in where a page of this one is absent.
    pub fn coarser(&self) -> u8 {
        if self.level == BARE { 1 } else { self.level + 1 }
    }
}
