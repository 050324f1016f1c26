//! Smoothing of a track's positions: where it is done, and notes about it.

use glam::DVec3;

use super::fit::{self, MOST_INTERVALS};
use super::sampling::Sampling;
use super::track::{AltitudeMode, Track};
use hedgehop_base::error::{Error, Result};

/// Swings that are taken out of the positions of a track.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Smoothing {
    /// The noise of a receiver, as large as its fixes say: of dense recordings without full attitude.
    #[default]
    Noise,
    /// All that swings faster than a period, seconds; nothing for 0.
    Period(f64),
}

/// Takes noise, or fast swings, out of a track's positions.
pub(super) struct Smoother {
    sampling: Sampling,
    smoothing: Smoothing,
    /// Whether a receiver made the track.
    is_recorded: bool,
    /// Whether heights are above ground, and stay.
    has_ground_heights: bool,
    /// Noise that was found, horizontally and in heights: standard deviations along an axis, metres.
    noise: [Option<f64>; 2],
}

impl Smoother {
    /// A smoother of a track that has fixes.
    ///
    /// # Errors
    /// [`Error::Configuration`] for a period that is none, or too long for the track.
    pub fn new(track: &Track, smoothing: Smoothing, is_recorded: bool) -> Result<Self> {
        let sampling = Sampling::new(&track.fixes);
        let most = sampling.interval().map_or(f64::INFINITY, |interval| MOST_INTERVALS * interval);
        if let Smoothing::Period(period) = smoothing
            && !(period >= 0.0 && period <= most)
        {
            return Err(Error::Configuration(format!(
                "--smooth {period} is no time from 0 to {most:.0} s, which {MOST_INTERVALS} fixes of {} take",
                track.path.display()
            )));
        }
        let has_ground_heights = track.fixes.iter().any(|fix| fix.altitude.mode == AltitudeMode::Agl);
        Ok(Self { sampling, smoothing, is_recorded, has_ground_heights, noise: [None; 2] })
    }

    /// Median interval of the fixes, seconds; 0 for a single one.
    pub fn interval(&self) -> f64 {
        self.sampling.interval().unwrap_or(0.0)
    }

    /// Smooths the horizontal positions of all fixes, metres.
    pub fn smooth_positions(&mut self, points: &mut [DVec3]) {
        let mut axes = [0, 1].map(|axis| points.iter().map(|point| point[axis]).collect::<Vec<_>>());
        self.noise[0] = self.smooth(&mut axes);
        let [east, north] = axes;
        for (point, (x, y)) in points.iter_mut().zip(east.into_iter().zip(north)) {
            (point.x, point.y) = (x, y);
        }
    }

    /// Smooths the heights of all fixes, metres, unless the file gives them above ground.
    pub fn smooth_heights(&mut self, points: &mut [DVec3]) {
        if self.has_ground_heights {
            return;
        }
        let mut axes = [points.iter().map(|point| point.z).collect::<Vec<_>>()];
        self.noise[1] = self.smooth(&mut axes);
        let [heights] = axes;
        points.iter_mut().zip(heights).for_each(|(point, height)| point.z = height);
    }

    fn smooth(&self, axes: &mut [Vec<f64>]) -> Option<f64> {
        match self.smoothing {
            Smoothing::Noise if self.is_recorded => fit::without_noise(&self.sampling, axes),
            Smoothing::Period(period) if period > 0.0 => {
                fit::slower_than(period, &self.sampling, axes);
                None
            }
            _ => None,
        }
    }

    /// Returns what there is to say of it, as a sentence each.
    pub fn notes(&self) -> Vec<String> {
        match self.smoothing {
            Smoothing::Noise => self.found().into_iter().collect(),
            Smoothing::Period(period) if period > 0.0 => self.undone(period),
            Smoothing::Period(_) => Vec::new(),
        }
    }

    fn found(&self) -> Option<String> {
        let noise = match self.noise {
            [Some(across), Some(up)] => format!("{across:.1} m across and {up:.1} m in height"),
            [Some(across), None] => format!("{across:.1} m across"),
            [None, Some(up)] => format!("{up:.1} m in height"),
            [None, None] => return None,
        };
        Some(format!(
            "Positions smoothed: the receiver's noise is about {noise} (--smooth SECONDS decides, --smooth 0 leaves them)."
        ))
    }

    /// Says where a period that was asked for does nothing.
    fn undone(&self, period: f64) -> Vec<String> {
        let mut notes = Vec::new();
        if self.sampling.len() < 4 {
            notes.push("--smooth changes nothing: it needs four fixes at least.".into());
        } else if let Some(interval) = self.sampling.interval().filter(|interval| period <= 2.0 * interval) {
            notes.push(format!(
                "--smooth {period} changes next to nothing: {interval:.1} s are between the fixes."
            ));
        }
        if self.has_ground_heights {
            notes.push("--smooth leaves the heights, which are above ground.".into());
        }
        notes
    }
}
