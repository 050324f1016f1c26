//! Blocks of lines along the major axis, in the order of the march.

use super::strides::Stride;
use crate::voxel::Grid;

/// Share of a distance by which it may be off as f32.
const ROUNDING: f64 = 1.2e-7;

/// A block of lines: `first`, and every `step`-th from there, `count` of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineBlock {
    /// Level and stride of the lines.
    pub stride: Stride,
    /// Index of the block along the major axis, in blocks of `side` units.
    pub index: i64,
    /// Length, units: that of the voxels whose bounds skip it.
    pub side: i64,
    /// Nearest line.
    pub first: i64,
    /// Difference from one line to the next, negative where the march runs down the axis.
    pub step: i64,
    /// Lines, ≥ 0.
    pub count: i64,
}

/// Lines that a stride leaves out before one of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinesBetween {
    /// The nearest.
    pub first: i64,
    /// Difference from one to the next.
    pub step: i64,
    /// Lines, ≥ 0.
    pub count: i64,
}

/// The way of a march along its major axis.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    /// The eye, units.
    pub eye: f64,
    /// +1 or −1.
    pub forward: f64,
    /// Units of the area along the axis.
    pub size: i64,
    /// Unit at which the next block begins.
    frontier: i64,
}

impl Way {
    /// Begins a way at major distance `start`, units.
    pub fn new(eye: f64, forward: f64, size: u32, start: f64) -> Self {
        let size = i64::from(size);
        let at = eye + forward * start;
        let unit = if forward > 0.0 { at.floor() } else { at.ceil() };
        Self { eye, forward, size, frontier: (unit as i64).clamp(0, size) }
    }

    /// Major distance of a line, units.
    #[inline(always)]
    pub fn distance(&self, level: u8, line: i64) -> f64 {
        let side = f64::from(Grid::side_units(level));
        ((line as f64 + 0.5) * side - self.eye) * self.forward
    }

    /// Major distance at which a block ends, units.
    #[inline(always)]
    pub fn end(&self, block: &LineBlock) -> f64 {
        let edge = if self.forward > 0.0 { block.index + 1 } else { block.index };
        ((edge * block.side) as f64 - self.eye) * self.forward
    }

    /// The same way from the beginning of a block on.
    pub fn back_to(&self, block: &LineBlock) -> Self {
        let near = if self.forward > 0.0 { block.index } else { block.index + 1 };
        Self { frontier: (near * block.side).min(self.size), ..*self }
    }

    /// The lines of a block up to a major distance; the way goes on behind them. `None`: none lies there.
    pub fn cut(&mut self, block: &LineBlock, until: f64) -> Option<LineBlock> {
        let last = (0..block.count)
            .rev()
            .find(|&index| self.distance(block.stride.level, block.first + index * block.step) <= until)?;
        let line = block.first + last * block.step;
        let side = i64::from(Grid::side_units(block.stride.level));
        self.frontier = if self.forward > 0.0 { (line + 1) * side } else { line * side };
        Some(LineBlock { count: last + 1, ..*block })
    }

    /// Major distance up to which the way has come, units.
    pub fn passed(&self) -> f64 {
        (self.frontier as f64 - self.eye) * self.forward
    }

    /// Returns the index of the square in which the way goes on, and the way from the square's far edge; `None`: the area ends. `side` is that of
    /// squares, units.
    pub fn square(&self, side: i64) -> Option<(i64, Self)> {
        let ahead = self.forward > 0.0;
        if self.is_done() {
            return None;
        }
        let index = quotient(if ahead { self.frontier } else { self.frontier - 1 }, side);
        let frontier = if ahead { ((index + 1) * side).min(self.size) } else { index * side };
        Some((index, Self { frontier, ..*self }))
    }

    /// Passes all blocks of a stride that end no further than where `end` begins, and than a major distance (units); returns the distance of their last
    /// line, or `None` if there are none.
    #[inline(always)]
    pub fn pass(&mut self, stride: Stride, end: &Self, until: f64) -> Option<f64> {
        let level_side = i64::from(Grid::side_units(stride.level));
        let side = level_side * stride.block_lines();
        let until = self.eye + self.forward * until;

        // Blocks begin with a line of the stride when they are passed northward or eastward, and end with one otherwise.
        if self.forward > 0.0 {
            let frontier = quotient(end.frontier.min(until.floor() as i64), side) * side;
            if frontier <= self.frontier {
                return None;
            }
            self.frontier = frontier;
            Some(self.distance(stride.level, quotient(frontier, level_side) - i64::from(stride.lines)))
        } else {
            let frontier = quotient(end.frontier.max(until.ceil() as i64) + side - 1, side) * side;
            if frontier >= self.frontier {
                return None;
            }
            self.frontier = frontier;
            Some(self.distance(stride.level, quotient(frontier, level_side)))
        }
    }

    /// Whether the way has come to the area's end.
    #[inline(always)]
    fn is_done(&self) -> bool {
        if self.forward > 0.0 { self.frontier >= self.size } else { self.frontier <= 0 }
    }

    /// Whether a block lies behind.
    pub fn is_past(&self, block: &LineBlock) -> bool {
        if self.forward > 0.0 {
            self.frontier >= (block.index + 1) * block.side
        } else {
            self.frontier <= block.index * block.side
        }
    }

    /// The line at or behind a major distance within the area, and the share of the way to it from the line before: 1 at the rounded distance of a line, so that a
    /// march that begins there finds what one that comes along does, to the bit.
    pub fn line_at(&self, level: u8, distance: f64) -> (i64, f64) {
        let side = f64::from(Grid::side_units(level));
        let last =
            (self.size + i64::from(Grid::side_units(level)) - 1) / i64::from(Grid::side_units(level)) - 1;
        let post = ((self.eye + self.forward * distance) / side - 0.5).clamp(0.0, last as f64);
        let nearest = post.round();
        if (post - nearest).abs() * side <= distance * ROUNDING {
            return (nearest as i64, 1.0);
        }
        let line = if self.forward > 0.0 { post.ceil() } else { post.floor() };
        (line as i64, 1.0 - (line - post).abs())
    }

    /// Returns the lines that divide the stretch before `line` of a block into `parts`, without those up to major distance `reached`: after a change of stride
    /// some of them may lie before the last one.
    #[inline(always)]
    pub fn between(&self, block: &LineBlock, line: i64, parts: i64, reached: f32) -> LinesBetween {
        let step = block.step.signum() * i64::from(block.stride.lines) / parts;
        let mut count = parts - 1;
        while count > 0 && self.distance(block.stride.level, line - step * count) <= f64::from(reached) {
            count -= 1;
        }
        LinesBetween { first: line - step * count, step, count }
    }

    /// A block of the area's last line alone.
    pub fn last_line(&self, stride: Stride) -> LineBlock {
        let ahead = self.forward > 0.0;
        let level_side = i64::from(Grid::side_units(stride.level));
        let side = level_side * stride.block_lines();
        let first = if ahead { (self.size + level_side - 1) / level_side - 1 } else { 0 };
        let step = if ahead { 1 } else { -1 };
        LineBlock {
            stride: Stride { lines: 1, ..stride },
            index: first * level_side / side,
            side,
            first,
            step,
            count: 1,
        }
    }

    /// The next block, of lines beyond major distance `reached`; `None`: the area ends.
    #[inline(always)]
    pub fn next(&mut self, stride: Stride, reached: f64) -> Option<LineBlock> {
        let ahead = self.forward > 0.0;
        if self.is_done() {
            return None;
        }

        let level_side = i64::from(Grid::side_units(stride.level));
        let every = i64::from(stride.lines);
        let side = level_side * stride.block_lines();
        let next = if ahead { self.frontier } else { self.frontier - 1 };
        let index = quotient(next, side);
        self.frontier = if ahead { (index + 1) * side } else { index * side };
        let lines = quotient(self.size + level_side - 1, level_side);
        let [low, end] = [index, index + 1].map(|index| quotient(index * side, level_side));
        let high = end.min(lines) - 1;

        // Lines keep their place whatever the eye does, so that nothing swims, and those of a stride are among
        // those of a shorter one.
        let at = (self.eye + self.forward * reached) / level_side as f64 - 0.5;

        let (first, last, step) = if ahead {
            // `reached` is rounded: a line that a cut block ended with may lie beyond it still.
            let low = low.max(at.floor() as i64 + 1).max(quotient(next, level_side));
            (low + (-low & (every - 1)), high, every)
        } else {
            let high = high.min(at.ceil() as i64 - 1).min(quotient(next, level_side));
            (high - (high & (every - 1)), low, -every)
        };

        let length = if ahead { last - first } else { first - last };
        let count = if length < 0 { 0 } else { quotient(length, every) + 1 };
        Some(LineBlock { stride, index, side, first, step, count })
    }
}

/// Quotient by a power of two, rounded down: blocks that are leaped over take no longer than this.
#[inline(always)]
fn quotient(dividend: i64, power: i64) -> i64 {
    debug_assert!(power > 0 && power & (power - 1) == 0);
    dividend >> power.trailing_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::BARE;

    #[test]
    fn a_way_that_is_cut_goes_on_behind_the_cut() {
        let stride = Stride { from: 0.0, level: BARE, lines: 1, stands_in: false };
        for number in 0..2000 {
            let eye = 700.0 + f64::from(number) * 0.123_456_789;
            let until = 300.0 + f64::from(number) * 0.377_7;
            for forward in [1.0, -1.0] {
                let mut way = Way::new(eye, forward, 1500, 0.0);
                let (mut reached, mut lines) = (0.0_f32, Vec::new());

                // As a march goes: distances are rounded.
                while let Some(block) = way.next(stride, reached.into()) {
                    let is_last = way.end(&block) > until;
                    let Some(block) = (if is_last { way.cut(&block, until) } else { Some(block) }) else {
                        break;
                    };
                    lines.extend((0..block.count).map(|index| block.first + index * block.step));
                    assert!(lines.len() <= 1500, "eye {eye}, until {until}: a line comes again and again");
                    let last = lines.last().map_or(0.0, |line| way.distance(BARE, *line));
                    reached = reached.max(last as f32);
                }

                assert!(lines.windows(2).all(|pair| (pair[1] - pair[0]) as f64 * forward > 0.0));
                let distance = |line: Option<&i64>| line.map_or(0.0, |line| way.distance(BARE, *line));
                assert!(distance(lines.last()) <= until);
                let beyond = distance(lines.last()) + 1.0;
                assert!(beyond > until || !(0.5..1499.5).contains(&(eye + forward * beyond)));
            }
        }
    }

    #[test]
    fn lines_between_are_those_that_a_stride_left_out() {
        for number in 0..2000_i64 {
            let (lines, forward) = ([2, 4][number as usize % 2], [1.0, -1.0][number as usize / 2 % 2]);
            let parts = [2, lines][number as usize / 4 % 2];
            let stride =
                Stride { from: 0.0, level: (number % 3) as u8, lines: lines as u32, stands_in: false };
            let mut way = Way::new(7000.0, forward, 20_000, (number % 17) as f64 * 31.3);
            let block = way.next(stride, 0.0).unwrap();
            let line = block.first + block.step * (block.count - 1);
            let distance = |line| way.distance(stride.level, line);
            let reached = (distance(line)
                - (number % 13) as f64 * 0.37 * (distance(line) - distance(line - block.step)))
                as f32;

            let step = block.step / parts;
            let missed: Vec<i64> = (1..parts).rev().map(|part| line - step * part).collect();
            let missed: Vec<i64> =
                missed.into_iter().filter(|&line| distance(line) > f64::from(reached)).collect();
            let LinesBetween { first, step, count } = way.between(&block, line, parts, reached);
            let between: Vec<i64> = (0..count).map(|part| first + part * step).collect();
            assert_eq!(between, missed, "{number}");
        }
    }

    #[test]
    fn blocks_that_are_passed_at_once_are_those_that_come_one_by_one() {
        for number in 0..2000_i64 {
            let (level, lines) = ((number % 4) as u8, [1, 2, 4][number as usize % 3]);
            let stride = Stride { from: 0.0, level, lines, stands_in: false };
            let eye = 20_000.0 + (number % 37) as f64 * 311.7;
            let forward = if number % 2 == 0 { 1.0 } else { -1.0 };
            let way = Way::new(eye, forward, 50_000, (number % 11) as f64 * 401.3);
            let (end, until) =
                (Way::new(eye, forward, 50_000, number as f64 * 13.7), (number % 90) as f64 * 251.3);

            let (mut one_by_one, mut reached) = (way, 0.0);
            let mut next = way;
            while let Some(block) = next.next(stride, reached)
                && next.passed() <= end.passed().min(until)
            {
                if block.count > 0 {
                    reached = way.distance(level, block.first + block.step * (block.count - 1));
                }
                one_by_one = next;
            }

            let mut at_once = way;
            let last = at_once.pass(stride, &end, until);
            assert_eq!(at_once.frontier, one_by_one.frontier, "{number}");
            assert_eq!(last.unwrap_or(0.0).max(0.0), reached, "{number}");
        }
    }
}
