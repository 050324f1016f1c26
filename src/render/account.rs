//! Times and counts of a rendered frame.

use std::time::Duration;

use crate::frame::Frame;

/// Time that a frame took in each stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Finding the range of each pixel, summed over the workers.
    pub march: Duration,
    /// Filtering the surface and applying the sensor, summed over the workers; of scan planes the whole image stage.
    pub shade: Duration,
    /// Merging, haze and sky of the reference marcher: wall time.
    pub image: Duration,
}

/// Counts of a picture's rays that see ground stored more coarsely than they ask for.
///
/// Rays are the pixels of the reference marcher, and of scan planes the rows of each plane, before these are taken to the screen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Rays {
    /// All of them, those to the sky too.
    pub all: u64,
    /// Rays that meet a level that stands in for a finer one, whose page is absent.
    pub coarser: u64,
}

impl Rays {
    /// Share of the rays that meet a level that stands in, 0…1.
    pub fn coarser_share(&self) -> f64 {
        self.coarser as f64 / self.all.max(1) as f64
    }
}

impl std::ops::AddAssign for Rays {
    fn add_assign(&mut self, other: Self) {
        (self.all, self.coarser) = (self.all + other.all, self.coarser + other.coarser);
    }
}

/// Times and counts of one picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Account {
    /// Time of each stage.
    pub times: StageTimes,
    /// Fineness of the ground that was seen.
    pub rays: Rays,
}

/// A frame and what it cost.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// Times and counts of the frame.
    pub account: Account,
}
