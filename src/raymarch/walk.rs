//! Stepping along a ray from cell border to cell border; knows nothing of what the cells hold.
//!
//! Borders are addressed by integers and their ranges come from one formula, so that neighbouring
//! cells, and cells of different levels, agree on them to the last bit, and every step makes
//! progress (Hughes patent, "stepping by integer boundaries"; Amanatides and Woo, *A fast voxel
//! traversal algorithm for ray tracing*, 1987).

use glam::DVec2;

use super::GridRay;

/// One cell on the way, and the ranges between which the ray is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellStep {
    /// Cell column and row.
    pub cell: [i64; 2],
    /// Position of the copy of the area that they are counted in, units; 0 in an area that does not repeat.
    pub origin: [f64; 2],
    /// Range at which the ray enters, metres.
    pub enter: f64,
    /// Range at which it leaves, metres, ≥ `enter`.
    pub leave: f64,
}

/// Rectangle of ground that a cell covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellRect {
    /// South-west corner, units.
    pub corner: DVec2,
    /// Sides eastward and northward, units.
    pub extent: DVec2,
}

/// Cells of a lattice along a ray, in order.
#[derive(Debug, Clone)]
pub struct CellWalk {
    axes: [Axis; 2],
    range: f64,
    end: f64,
    done: bool,
}

/// The walk along one axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    span: Extent,
    lattice: (f64, f64),
    cell: i64,
    forward: bool,
    eye: f64,
    range_per_unit: f64,
    /// Range of the next border, metres.
    border: f64,
}

/// A lattice of square cells: along an axis, cell `i` covers `origin + side · [i + shift, i + 1 + shift)` units.
/// Where the area repeats, so do the cells; the last one of each copy then ends where the next copy's first one
/// begins, and is narrower than the others if the area's side is no multiple of theirs.
#[derive(Debug, Clone, Copy)]
pub struct Lattice {
    /// Side of a cell, units.
    pub side: f64,
    /// Shift of the whole lattice, cells.
    pub shift: f64,
    /// Cells eastward and northward.
    pub spans: [Extent; 2],
}

/// Extent of a lattice's cells along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// First cell; 0 where they repeat.
    pub first: i64,
    /// Last cell.
    pub last: i64,
    /// Position from which cells are counted, units.
    pub origin: f64,
    /// Distance at which they repeat, units; infinite where they do not.
    pub period: f64,
}

impl Extent {
    /// Cells `first..=last` without repetition.
    pub fn once(first: i64, last: i64, origin: f64) -> Self {
        Self { first, last, origin, period: f64::INFINITY }
    }

    #[inline]
    fn repeats(&self) -> bool {
        self.period.is_finite()
    }

    /// Moves to this span in the copy of the area that holds `position`, and the cell there, clamped into the span.
    #[inline]
    fn locate(mut self, position: f64, side: f64, shift: f64) -> (Self, i64) {
        if self.repeats() {
            self.origin = ((position - shift * side) / self.period).floor() * self.period;
        }
        let cell = whole_below((position - self.origin) / side - shift);
        (self, cell.clamp(self.first, self.last))
    }

    /// Lower border of a cell, units. Sums of whole and half units, hence exact; so is [`Self::upper`].
    #[inline]
    fn lower(&self, cell: i64, side: f64, shift: f64) -> f64 {
        self.origin + (cell as f64 + shift) * side
    }

    /// Upper border of a cell, units.
    #[inline]
    fn upper(&self, cell: i64, side: f64, shift: f64) -> f64 {
        if cell == self.last && self.repeats() {
            self.origin + self.period + shift * side
        } else {
            self.lower(cell + 1, side, shift)
        }
    }
}

/// Rounds down as `floor` does, which is a call where the processor that is compiled for has no instruction for it.
#[inline]
fn whole_below(position: f64) -> i64 {
    let towards_zero = position as i64;
    towards_zero.saturating_sub(i64::from(towards_zero as f64 > position))
}

impl Lattice {
    /// The cell (clamped into the lattice) at a position in units, and the position within it, 0…1.
    #[inline]
    pub fn cell_at(&self, position: DVec2) -> ([i64; 2], DVec2) {
        let (mut cell, mut within) = ([0; 2], [0.0; 2]);
        for axis in 0..2 {
            let (span, index) = self.spans[axis].locate(position[axis], self.side, self.shift);
            let low = span.lower(index, self.side, self.shift);
            cell[axis] = index;
            within[axis] = (position[axis] - low) / (span.upper(index, self.side, self.shift) - low);
        }
        (cell, DVec2::from_array(within).clamp(DVec2::ZERO, DVec2::ONE))
    }

    /// Cells that hold so many of these along a side, from the first on.
    pub fn grouped(self, count: u32) -> Self {
        let last = |span: Extent| span.last / i64::from(count);
        Self {
            side: self.side * f64::from(count),
            spans: self.spans.map(|span| Extent { last: last(span), ..span }),
            ..self
        }
    }

    /// Returns the lattice of these cells that lie in one of [the wider ones](Self::grouped), where a walk along those is.
    pub fn inside(self, step: &CellStep, count: u32) -> Self {
        let spans = [0, 1].map(|axis| {
            let first = step.cell[axis] * i64::from(count);
            let last = (first + i64::from(count) - 1).min(self.spans[axis].last);
            Extent::once(first, last, step.origin[axis])
        });
        Self { spans, ..self }
    }

    /// Returns the rectangle of the cell of a step.
    pub fn place(&self, step: &CellStep) -> CellRect {
        let borders = |axis: usize| {
            let span = Extent { origin: step.origin[axis], ..self.spans[axis] };
            let cell = step.cell[axis];
            (span.lower(cell, self.side, self.shift), span.upper(cell, self.side, self.shift))
        };
        let (x, y) = (borders(0), borders(1));
        CellRect { corner: DVec2::new(x.0, y.0), extent: DVec2::new(x.1 - x.0, y.1 - y.0) }
    }
}

impl CellWalk {
    /// The cells of `lattice` that `ray` crosses between the ranges `start` and `end`.
    pub fn new(ray: &GridRay, lattice: Lattice, start: f64, end: f64) -> Self {
        let point = ray.at(start);
        let axes = [Axis::new(ray, &lattice, 0, point.x), Axis::new(ray, &lattice, 1, point.y)];
        Self { axes, range: start, end, done: start > end }
    }
}

impl Axis {
    /// The walk of a ray along axis `index` of a lattice, from the cell at a position in units.
    #[inline]
    fn new(ray: &GridRay, lattice: &Lattice, index: usize, position: f64) -> Self {
        let &Lattice { side, shift, spans } = lattice;
        let (span, cell) = spans[index].locate(position, side, shift);
        let range_per_unit = ray.range_per_unit[index];
        let mut axis = Self {
            span,
            lattice: (side, shift),
            cell,
            forward: range_per_unit > 0.0,
            eye: ray.eye[index],
            range_per_unit,
            border: f64::INFINITY,
        };
        if range_per_unit.is_finite() {
            axis.find_border();
        }
        axis
    }

    #[inline]
    fn find_border(&mut self) {
        let (side, shift) = self.lattice;
        let border = if self.forward {
            self.span.upper(self.cell, side, shift)
        } else {
            self.span.lower(self.cell, side, shift)
        };
        self.border = (border - self.eye) * self.range_per_unit;
    }

    /// Moves on by one cell; false at the end of the lattice.
    #[inline]
    fn advance(&mut self) -> bool {
        let Extent { first, last, period, .. } = self.span;
        let (step, end, begin) = if self.forward { (1, last, first) } else { (-1, first, last) };
        if self.cell != end {
            self.cell += step;
        } else if self.span.repeats() {
            self.cell = begin;
            self.span.origin += period * step as f64;
        } else {
            return false;
        }
        self.find_border();
        true
    }
}

impl Iterator for CellWalk {
    type Item = CellStep;

    #[inline]
    fn next(&mut self) -> Option<CellStep> {
        if self.done {
            return None;
        }
        let [x, y] = &mut self.axes;
        let (cell, origin) = ([x.cell, y.cell], [x.span.origin, y.span.origin]);
        let nearer = if x.border <= y.border { x } else { y };
        let border = nearer.border;
        let enter = self.range;
        if border >= self.end {
            self.done = true;
            return Some(CellStep { cell, origin, enter, leave: self.end });
        }
        let leave = if border > enter { border } else { enter };
        self.range = leave;
        self.done = !nearer.advance();
        Some(CellStep { cell, origin, enter, leave })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_rounded_as_floor_does() {
        let near =
            [0.0, -0.0, 0.5, 1.0, 1e-300, 1.0 - f64::EPSILON, 7.25, 4.0e9, 9.0e15, 1e18, 9.3e18, 1e300];
        let far = [f64::INFINITY, f64::NAN, i64::MAX as f64, (1_u64 << 53) as f64];
        for position in near.into_iter().chain(far).flat_map(|position| [position, -position]) {
            assert_eq!(whole_below(position), position.floor() as i64, "{position}");
        }
    }
}
