//! Estimates of the mean of a tonal group from one tone, as the study makes them.
//!
//! ```text
//! A(i) = 1/n² · Σ (n − |t − (n − 1)|)·P(i + t)  over t = 0 … 2n − 2       mean of n × n cells whose first has place i
//! A(i) ≈ a·P(i + k) + b                          least squares over the whole period; best with k = n − 1
//! linear: a·P + b      stepped: P      in whole numbers: (round(128·a)·P + round(128·b)) >> 7
//! ```
//!
//! Cells whose column and row have one sum are equal, so that a group has 2n − 1 distinct tones, of which
//! that of place n − 1 lies on its diagonal. Codes of one degree in Fibonacci form share a, b and the error.
//!
//! Source: study of cyclic codes for surface texture (AFHRL on ACTES), Table 1.

use crate::code::CyclicCode;

/// Fractional bits of coefficients in whole numbers.
const COEFFICIENT_BITS: u32 = 7;

/// Least-squares line from one tone of a tonal group to its mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupEstimate {
    /// Cells along the group's side.
    pub side: u32,
    /// Steps from the group's first place to the tone that is looked at.
    pub offset: u32,
    /// Factor of the tone.
    pub slope: f64,
    /// Tone that is added.
    pub intercept: f64,
    /// Sum of squared errors over the period.
    pub squared_error: f64,
    /// Sum of squared errors over the period if the tone itself is taken.
    pub stepped_squared_error: f64,
    /// Standard deviation of exact means.
    pub exact_deviation: f64,
}

/// Exact means of groups of `side` × `side` cells by the place of their first cell, for a code in the
/// direction 1, 1.
pub fn group_means(code: &CyclicCode, side: u32) -> Vec<f64> {
    let last = i64::from(side) - 1;
    let weighted = |first: i64, t: i64| (last + 1 - (t - last).abs()) * i64::from(code.tone(first + t));
    let mean =
        |first| (0..=2 * last).map(|t| weighted(first, t)).sum::<i64>() as f64 / f64::from(side).powi(2);
    (0..code.period()).map(mean).collect()
}

impl GroupEstimate {
    /// Fits groups of `side` × `side` cells, at least 1, by the tone on their diagonal, which is best.
    pub fn new(code: &CyclicCode, side: u32) -> Self {
        Self::with_offset(code, side.max(1), side.max(1) - 1)
    }

    /// Fits groups by the tone `offset` steps from their first.
    pub fn with_offset(code: &CyclicCode, side: u32, offset: u32) -> Self {
        let exact = group_means(code, side);
        let tones: Vec<f64> =
            (0..code.period()).map(|first| f64::from(code.tone(first + i64::from(offset)))).collect();
        let count = tones.len() as f64;
        let mean = tones.iter().sum::<f64>() / count;
        let pairs = || tones.iter().zip(&exact);

        // Both have the same mean, that of all tones.
        let covariance: f64 = pairs().map(|(tone, exact)| (tone - mean) * (exact - mean)).sum();
        let variance: f64 = tones.iter().map(|tone| (tone - mean).powi(2)).sum();
        let slope = covariance / variance;
        let intercept = mean - slope * mean;

        let error = |slope: f64, intercept: f64| {
            pairs().map(|(tone, exact)| (exact - slope * tone - intercept).powi(2)).sum()
        };
        let squares: f64 = exact.iter().map(|exact| (exact - mean).powi(2)).sum();
        Self {
            side,
            offset,
            slope,
            intercept,
            squared_error: error(slope, intercept),
            stepped_squared_error: error(1.0, 0.0),
            exact_deviation: (squares / count).sqrt(),
        }
    }

    /// Estimated mean of a group by the tone at its offset.
    pub fn linear(&self, tone: u32) -> f64 {
        self.slope * f64::from(tone) + self.intercept
    }

    /// Estimate in whole numbers, with coefficients in 1/128.
    pub fn linear_fixed(&self, tone: u32) -> u32 {
        let fixed = |coefficient: f64| (coefficient * f64::from(1_u32 << COEFFICIENT_BITS)).round() as i64;
        let scaled = fixed(self.slope) * i64::from(tone) + fixed(self.intercept);
        (scaled >> COEFFICIENT_BITS).max(0) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polynomial::primitive_polynomials;

    fn close(got: f64, expected: f64, half_digit: f64) {
        assert!((got - expected).abs() <= half_digit, "{got}, not {expected}");
    }

    #[test]
    fn linear_estimates_are_those_of_table_1() {
        let code = CyclicCode::default();
        let fit = |offset| GroupEstimate::with_offset(&code, 2, offset);
        for (offset, slope, intercept, squared_error) in [
            (0, 0.557307, 56.6648, 471_982.0),
            (1, 0.747036, 32.3794, 130_035.9),
            (2, 0.557307, 56.6648, 471_982.0),
        ] {
            close(fit(offset).slope, slope, 1e-6);
            close(fit(offset).intercept, intercept, 1e-4);
            close(fit(offset).squared_error, squared_error, 0.5);
        }
        close(fit(3).slope, 0.272696, 1e-6);
        close(fit(3).squared_error, 798_392.0, 0.6);
        close(fit(4).slope, 0.130338, 1e-6);
        close(fit(10).slope, -3.0 / 254.0, 1e-6);
        close(fit(10).squared_error, 900_951.0, 0.6);
        assert_eq!(GroupEstimate::new(&code, 2), fit(1));
    }

    #[test]
    fn errors_are_those_of_groups_of_1_to_64() {
        // Side; slope, intercept; deviation of exact means; rms errors linear and stepped.
        let rows = [
            (1, 1.0, 0.0, 73.6, 0.0, 0.0),
            (2, 0.7470, 32.38, 59.5, 22.6, 29.3),
            (3, 0.6065, 50.37, 52.2, 27.0, 39.6),
            (4, 0.5099, 62.74, 47.0, 28.2, 45.8),
            (8, 0.3044, 89.04, 34.9, 26.8, 57.8),
            (16, 0.1614, 107.35, 24.6, 21.5, 65.4),
            (32, 0.0785, 117.95, 16.6, 15.5, 69.6),
            (64, 0.0343, 123.61, 10.3, 10.0, 71.8),
        ];
        let code = CyclicCode::default();
        for (side, slope, intercept, deviation, linear, stepped) in rows {
            let fit = GroupEstimate::new(&code, side);
            close(fit.slope, slope, 6e-5);
            close(fit.intercept, intercept, 6e-3);
            close(fit.exact_deviation, deviation, 0.06);
            let rms = |squared: f64| (squared / 255.0).sqrt();
            close(rms(fit.squared_error), linear, 0.06);
            close(rms(fit.stepped_squared_error), stepped, 0.06);
            assert!(side == 1 || fit.stepped_squared_error > fit.squared_error);

            let others = (0..2 * side - 1).map(|offset| GroupEstimate::with_offset(&code, side, offset));
            let best = others.min_by(|a, b| a.squared_error.total_cmp(&b.squared_error)).unwrap();
            assert_eq!(best.offset, side - 1);
        }
    }

    #[test]
    fn coefficients_are_equal_for_all_polynomials() {
        let first = GroupEstimate::new(&CyclicCode::default(), 4);
        for polynomial in primitive_polynomials(8) {
            let fit = GroupEstimate::new(&CyclicCode::new(polynomial).unwrap(), 4);
            close(fit.slope, first.slope, 1e-12);
            close(fit.intercept, first.intercept, 1e-9);
            close(fit.squared_error, first.squared_error, 1e-6);
        }
    }

    #[test]
    fn whole_numbers_stay_near() {
        for side in [1, 2, 3, 4, 8] {
            let fit = GroupEstimate::new(&CyclicCode::default(), side);
            for tone in 1..=255 {
                close(f64::from(fit.linear_fixed(tone)) + 0.5, fit.linear(tone), 1.6);
            }
        }
    }
}
