//! Surface of the sea: codes that run with time.
//!
//! ```text
//! tone(i, j, t) = mean of tone_k(α_k·i + β_k·j + t) over the layers        t in steps of the codes
//! ```
//!
//! A step moves a layer by a cell, each in a direction of its own, so that crests form and part. Between
//! steps layers move evenly. After 255 steps everything repeats.
//!
//! An early seascape generator that the study of cyclic codes (AFHRL on ACTES) mentions had a time term;
//! layers are ours.

use crate::cell_box::CellBox;
use crate::strand::StrandMeans;
use crate::superimposed::Superimposed;

/// Codes that drift over each other.
#[derive(Debug, Clone)]
pub struct Sea {
    codes: Superimposed,
}

impl Sea {
    /// Steps after which the sea repeats.
    pub const PERIOD: f64 = 255.0;

    /// Lets so many codes drift, one to eight.
    pub fn new(codes: usize) -> Self {
        Self { codes: Superimposed::new(codes) }
    }

    /// Exact mean tone over a box at a time in steps; not a number of one without finite corners, or of no
    /// finite time.
    pub fn mean(&self, over: CellBox, time: f64) -> f64 {
        let time = time.rem_euclid(Self::PERIOD);
        let layers = self.codes.layers();
        let mean = |layer: &StrandMeans| {
            let [x, y] = step(layer);
            layer.mean(over.shifted(x * time, y * time))
        };
        layers.iter().map(mean).sum::<f64>() / layers.len() as f64
    }
}

/// Cells along x and y that are one step along a layer's code: along an axis on which a cell is a step.
fn step(layer: &StrandMeans) -> [f64; 2] {
    let direction = layer.strand().direction;
    if direction.column.abs() == 1 { [direction.column as f64, 0.0] } else { [0.0, direction.row as f64] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(column: i64, row: i64) -> CellBox {
        let (x0, y0) = (column as f64, row as f64);
        CellBox { x0, x1: x0 + 1.0, y0, y1: y0 + 1.0 }
    }

    #[test]
    fn time_adds_to_the_index() {
        let sea = Sea::new(8);
        for (column, row, time) in [(0, 0, 1), (-5, 1000, 37), (77, 3, 254)] {
            let tone = |layer: &StrandMeans| {
                let strand = layer.strand();
                f64::from(strand.code.tone(strand.place(column, row) + time))
            };
            let tones: f64 = sea.codes.layers().iter().map(tone).sum();
            assert!((sea.mean(cell(column, row), time as f64) - tones / 8.0).abs() < 1e-9);
        }
    }

    #[test]
    fn frames_repeat_after_a_period() {
        let sea = Sea::new(5);
        let over = CellBox { x0: 3.5, x1: 11.25, y0: -70.0, y1: -68.5 };
        for time in [0.0, 0.25, 17.5, -3.0] {
            assert_eq!(sea.mean(over, time), sea.mean(over, time + Sea::PERIOD));
            assert_ne!(sea.mean(over, time), sea.mean(over, time + 1.0));
        }
    }

    #[test]
    fn frames_are_coherent() {
        let sea = Sea::new(4);
        let frame = |time: f64| -> Vec<f64> {
            (0..2500).map(|number| sea.mean(cell(number % 50, number / 50), time) - 128.0).collect()
        };
        let correlation = |a: &[f64], b: &[f64]| {
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            product(a, b) / (product(a, a) * product(b, b)).sqrt()
        };
        let first = frame(0.0);
        let later = [0.05, 0.1, 0.3, 20.0].map(|time| correlation(&first, &frame(time)));
        assert!(later[0] > 0.99 && later[1] > 0.98 && later[2] > 0.85 && later[3] < 0.3, "{later:?}");
    }
}
