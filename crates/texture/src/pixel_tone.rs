//! Tone of a pixel whose footprint lies on a code.

use hedgehop_base::error::Result;

use crate::code::CyclicCode;
use crate::estimate::GroupEstimate;
use crate::footprint::Footprint;
use crate::pattern::{Direction, Strand};
use crate::strand::StrandMeans;

/// Greatest side of tonal groups for which estimates are fitted, cells.
const MAX_SIDE: u32 = 64;

/// Way to a pixel's tone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Averaging {
    /// Exact mean over so many slices of the footprint; one suffices along the axes.
    Exact(u32),
    /// Mean of the study's linear estimates of tonal groups.
    Linear,
    /// Mean of the tones on the diagonals of tonal groups.
    Stepped,
}

/// Code in the direction 1, 1 with all that is needed to average it over pixels.
#[derive(Debug, Clone)]
pub struct PixelTones {
    means: StrandMeans,
    /// By the side of groups, from 1.
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
        if let Averaging::Exact(slices) = averaging {
            let slices = footprint.slices(slices);
            return slices.iter().map(|slice| slice.share * self.means.mean(slice.over)).sum();
        }
        let groups = footprint.groups();
        let estimate = &self.estimates[groups.side.min(MAX_SIDE) as usize - 1];
        let diagonal = |corner: &[i64; 2]| {
            let tone = self.means.strand().tone(corner[0] + i64::from(groups.side) - 1, corner[1]);
            if averaging == Averaging::Linear { estimate.linear(tone) } else { f64::from(tone) }
        };
        groups.corners.iter().map(diagonal).sum::<f64>() / groups.corners.len() as f64
    }
}
