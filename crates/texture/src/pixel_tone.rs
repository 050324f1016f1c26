//! Tone of a pixel whose footprint lies on a code.

use hedgehop_base::error::Result;

use crate::code::CyclicCode;
use crate::estimate::GroupEstimate;
use crate::footprint::Footprint;
use crate::pattern::{Direction, Strand};
use crate::strand::StrandMeans;

/// Greatest side of tonal groups for which estimates are fitted, cells.
const MAX_SIDE: u32 = 64;

/// Steps from a sample to the next along both edges of a footprint: inverse powers of the plastic number.
const SAMPLE_STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// Way to a pixel's tone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Averaging {
    /// Exact mean over so many slices of the footprint; one suffices along the axes.
    Exact(u32),
    /// Mean of the study's linear estimates of tonal groups.
    Linear,
    /// Mean of the tones on the diagonals of tonal groups.
    Stepped,
    /// Mean of so many samples, spread evenly over the footprint (Roberts 2018, *The unreasonable
    /// effectiveness of quasirandom sequences*): what rays would see.
    Samples(u32),
}

/// Code in the direction 1, 1 with all that is needed to average it over pixels.
#[derive(Debug, Clone)]
pub struct PixelTones {
    means: StrandMeans,
    /// Estimates by the side of groups, from 1.
    estimates: Vec<GroupEstimate>,
}

impl PixelTones {
    /// Fits the estimates of a code of degree 8 to 16, for groups of up to 64 cells along a side.
    ///
    /// # Errors
    ///
    /// The degree is greater than 16.
    pub fn new(code: CyclicCode) -> Result<Self> {
        let estimates = (1..=MAX_SIDE).map(|side| GroupEstimate::new(&code, side)).collect();
        let means = StrandMeans::new(Strand { code, direction: Direction { column: 1, row: 1 }, phase: 0 })?;
        Ok(Self { means, estimates })
    }

    /// Exact means of the code.
    pub fn means(&self) -> &StrandMeans {
        &self.means
    }

    /// Tone of a pixel by its footprint; groups of more than 64 cells along a side count as 64 in their
    /// estimate.
    pub fn tone(&self, footprint: &Footprint, averaging: Averaging) -> f64 {
        match averaging {
            Averaging::Exact(slices) => {
                let slices = footprint.slices(slices);
                slices.iter().map(|slice| slice.share * self.means.mean(slice.over)).sum()
            }
            Averaging::Samples(count) => self.sampled(footprint, count.max(1)),
            Averaging::Linear => self.grouped(footprint, |estimate, tone| estimate.linear(tone)),
            Averaging::Stepped => self.grouped(footprint, |_, tone| f64::from(tone)),
        }
    }

    fn grouped(&self, footprint: &Footprint, estimated: impl Fn(&GroupEstimate, u32) -> f64) -> f64 {
        let groups = footprint.groups();
        let estimate = &self.estimates[groups.side.min(MAX_SIDE) as usize - 1];
        let on_diagonal = |corner: &[i64; 2]| {
            estimated(estimate, self.means.strand().tone(corner[0] + i64::from(groups.side) - 1, corner[1]))
        };
        groups.corners.iter().map(on_diagonal).sum::<f64>() / groups.corners.len() as f64
    }

    fn sampled(&self, footprint: &Footprint, count: u32) -> f64 {
        let sample = |number: u32| {
            let shares = SAMPLE_STEPS.map(|step| (f64::from(number) * step).fract() - 0.5);
            let [x, y] = footprint.at(shares).map(|place| place.floor() as i64);
            f64::from(self.means.strand().tone(x, y))
        };
        (0..count).map(sample).sum::<f64>() / f64::from(count)
    }
}
