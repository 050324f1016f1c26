//! Groups of lines of ground, each of which begins its code anew.
//!
//! ```text
//! place(line, column) = S + (line − first) + column          S, first: of the last subterrain that begins at or before the line
//! ```
//!
//! Starts are given outright. The study slips them by a number of steps, of which its one example can be read
//! in two ways.
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES).

use hedgehop_base::error::{Error, Result};

use crate::cell_box::CellBox;
use crate::code::CyclicCode;
use crate::pattern::{Direction, Strand};
use crate::strand::StrandMeans;

/// First line of a group of lines, and the place along the code where it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subterrain {
    /// First line, as a row of cells; the next subterrain's ends it.
    pub first_line: i64,
    /// Place along the code of the first line's column 0.
    pub start: i64,
}

/// Code over subterrains.
#[derive(Debug, Clone)]
pub struct SubterrainCode {
    means: StrandMeans,
    subterrains: Vec<Subterrain>,
}

impl SubterrainCode {
    /// Lays a code of degree 8 to 16 over subterrains in ascending order; the first and last go on beyond.
    ///
    /// # Errors
    ///
    /// There is no subterrain, they are not in order, or the degree is greater.
    pub fn new(code: CyclicCode, subterrains: Vec<Subterrain>) -> Result<Self> {
        if subterrains.is_empty() {
            return Err(Error::Configuration("a code over subterrains has none; want at least one".into()));
        }
        if let Some(pair) = subterrains.windows(2).find(|pair| pair[0].first_line >= pair[1].first_line) {
            return Err(Error::Configuration(format!(
                "a subterrain that begins at line {} follows one of line {}; want them in ascending order",
                pair[1].first_line, pair[0].first_line
            )));
        }
        let direction = Direction { column: 1, row: 1 };
        Ok(Self { means: StrandMeans::new(Strand { code, direction, phase: 0 })?, subterrains })
    }

    /// Tone of a cell of the plane; the line is its row.
    pub fn tone(&self, column: i64, line: i64) -> u32 {
        let phase = self.phase(self.number(line));
        self.means.strand().code.tone(column.wrapping_add(line).wrapping_add(phase))
    }

    /// Exact mean tone over a box, split where subterrains meet; not a number of one without finite corners.
    pub fn mean(&self, over: CellBox) -> f64 {
        let over = over.ordered();
        let (first, last) = (self.number(over.y0.floor() as i64), self.number(over.y1.ceil() as i64 - 1));
        let border =
            |number: usize| self.subterrains.get(number).map_or(f64::INFINITY, |it| it.first_line as f64);
        let part = |number: usize| {
            let y0 = if number == first { over.y0 } else { border(number) };
            let y1 = if number == last { over.y1 } else { border(number + 1) };
            let mean = self.means.mean(CellBox { y0, y1, ..over }.shifted(self.phase(number) as f64, 0.0));
            mean * (y1 - y0)
        };
        (first..=last).map(part).sum::<f64>() / (over.y1 - over.y0)
    }

    /// Number of the subterrain that a line belongs to.
    fn number(&self, line: i64) -> usize {
        self.subterrains.partition_point(|subterrain| subterrain.first_line <= line).saturating_sub(1)
    }

    /// Steps by which a subterrain's code is ahead of one that begins at cell 0, 0, reduced by the period.
    fn phase(&self, number: usize) -> i64 {
        let Subterrain { first_line, start } = self.subterrains[number];
        let period = self.means.strand().code.period();
        (start.rem_euclid(period) - first_line.rem_euclid(period)).rem_euclid(period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell_box::brute_force;
    use crate::shades::Shades;
    use hedgehop_base::chance::Random;

    fn laid(subterrains: Vec<Subterrain>) -> SubterrainCode {
        SubterrainCode::new(CyclicCode::default(), subterrains).unwrap()
    }

    /// Subterrains of so many lines whose starts are a function of their number.
    fn every(lines: i64, start: impl Fn(i64) -> i64) -> Vec<Subterrain> {
        (0..255 / lines)
            .map(|number| Subterrain { first_line: number * lines, start: start(number) })
            .collect()
    }

    #[test]
    fn lines_1_to_5_begin_with_states_1_to_5_then_slip() {
        let code = CyclicCode::default();
        let laid =
            laid(vec![Subterrain { first_line: 1, start: 1 }, Subterrain { first_line: 6, start: 11 }]);
        for line in 1..=5 {
            assert_eq!(laid.tone(0, line), code.tone(line));
        }
        assert_eq!((laid.tone(0, 6), laid.tone(3, 7)), (code.tone(11), code.tone(15)));
        assert_eq!((laid.tone(-9, -40), laid.tone(0, 1000)), (code.tone(-49), code.tone(1005)));
    }

    #[test]
    fn four_patterns_come_from_one_polynomial() {
        let mut random = Random(10);
        let starts: Vec<i64> = (0..255).map(|_| (random.unit() * 255.0) as i64).collect();
        let few = Shades::new(4, 128).unwrap();
        let shown = |laid: &SubterrainCode, shades: Option<Shades>| {
            let cells = (0..255 * 255).map(|cell| laid.tone(cell % 255, cell / 255) as u8);
            cells.map(|tone| shades.map_or(tone, |shades| shades.shade(tone))).collect::<Vec<u8>>()
        };
        // Banded: every line alike. Two mosaics: blocks of lines that slip, in many shades and few.
        // Continuous: one group.
        let banded = shown(&laid(every(1, |_| 7)), None);
        let mosaic = laid(every(8, |number| starts[number as usize]));
        let patterns = [
            banded.clone(),
            shown(&mosaic, None),
            shown(&mosaic, Some(few)),
            shown(&laid(every(255, |_| 0)), None),
        ];
        assert!((1..255).all(|line| banded[line * 255..][..255] == banded[..255]));

        // Shares of cells that are as the one below, and as one far down the diagonal, tell bands, slips and
        // ramps apart.
        let alike = |cells: &[u8], step: usize| {
            let pairs = cells[9..].iter().zip(&cells[9 + step..]).filter(|(a, b)| a == b);
            pairs.count() as f64 / (cells.len() - 9 - step) as f64
        };
        let measured = patterns.map(|cells| [alike(&cells, 255), alike(&cells, 9 * 255 - 9)]);
        let expected = [[1.0, 0.0], [0.0, 0.0], [0.25, 0.25], [0.0, 1.0]];
        for (measured, expected) in measured.iter().flatten().zip(expected.iter().flatten()) {
            assert!((measured - expected).abs() < 0.05, "{measured}, not {expected}");
        }
    }

    #[test]
    fn means_over_borders_are_exact() {
        let mut random = Random(88);
        let laid = laid(every(7, |number| number * number * 31));
        for _ in 0..400 {
            let (x0, y0) = (random.unit() * 400.0 - 200.0, random.unit() * 400.0 - 100.0);
            let over =
                CellBox { x0, x1: x0 + 0.2 + random.unit() * 40.0, y0, y1: y0 + 0.2 + random.unit() * 60.0 };
            let brute = brute_force(|column, line| f64::from(laid.tone(column, line)), over);
            assert!((laid.mean(over) - brute).abs() < 1e-9, "{over:?}");
        }
    }

    #[test]
    fn subterrains_out_of_order_are_refused() {
        let error =
            |subterrains| SubterrainCode::new(CyclicCode::default(), subterrains).unwrap_err().to_string();
        assert!(error(vec![]).contains("at least one"));
        let at = |first_line| Subterrain { first_line, start: 0 };
        assert!(error(vec![at(5), at(5)]).contains("ascending order"));
    }
}
