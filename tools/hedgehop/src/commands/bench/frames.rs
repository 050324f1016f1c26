//! Times of single frames: wall time, CPU time, stages.
//!
//! On a machine that does other work meanwhile, wall time counts that work too; CPU time hardly does. Of
//! the passes over a frame the fastest one is reported, as a whole: it is the one that was disturbed least,
//! and the figures of one entry then belong together.

use std::time::{Duration, Instant};

use crate::cpu_time;
use crate::figures::FrameFigures;
use hedgehop::Result;
use hedgehop::frame::Picture;
use hedgehop::render::{Account, StageTimes};

/// One frame of one pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameTimes {
    /// Number of the frame.
    pub number: u64,
    /// Wall time, without encoding.
    pub wall: Duration,
    /// CPU time of all threads in it, where the system tells.
    pub cpu: Option<Duration>,
    /// Times of its stages.
    pub stages: StageTimes,
}

/// A frame with its clocks.
pub(super) struct Timed {
    /// Picture that was rendered.
    pub picture: Picture,
    /// Times of its stages.
    pub stages: StageTimes,
    wall: Duration,
    cpu: Option<Duration>,
}

impl Timed {
    /// Renders a frame between two looks at both clocks. While frames overlap, they also tell of others.
    pub(super) fn render(render: impl FnOnce() -> Result<(Picture, Account)>) -> Result<Self> {
        // The CPU clock is read first and last, so that what reading it costs is counted, not hidden.
        let cpu_begun = cpu_time::of_process();
        let begun = Instant::now();
        let (picture, Account { times: stages, .. }) = render()?;
        let wall = begun.elapsed();
        let cpu = cpu_begun.zip(cpu_time::of_process()).map(|(begun, end)| end.saturating_sub(begun));
        Ok(Self { picture, stages, wall, cpu })
    }

    /// Returns the times as those of frame `number`.
    pub(super) fn times(&self, number: u64) -> FrameTimes {
        FrameTimes { number, wall: self.wall, cpu: self.cpu, stages: self.stages }
    }
}

/// The fastest pass of every frame; every pass holds the same frames in the same order.
pub(super) fn fastest<'a>(passes: impl IntoIterator<Item = &'a [FrameTimes]>) -> Vec<FrameFigures> {
    let mut fastest: Vec<FrameTimes> = Vec::new();
    for pass in passes {
        if fastest.is_empty() {
            fastest = pass.to_vec();
        }
        for (best, times) in fastest.iter_mut().zip(pass) {
            if times.wall < best.wall {
                *best = *times;
            }
        }
    }
    fastest.iter().map(figures).collect()
}

fn figures(times: &FrameTimes) -> FrameFigures {
    let milliseconds = |time: Duration| time.as_secs_f64() * 1000.0;
    FrameFigures {
        frame: times.number,
        wall_ms: milliseconds(times.wall),
        cpu_ms: times.cpu.map(milliseconds),
        march_ms: milliseconds(times.stages.march),
        shade_ms: milliseconds(times.stages.shade),
        image_ms: milliseconds(times.stages.image),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u64, wall: u64, march: u64) -> FrameTimes {
        let stages = StageTimes { march: Duration::from_millis(march), ..StageTimes::default() };
        let wall = Duration::from_millis(wall);
        FrameTimes { number, wall, cpu: Some(wall), stages }
    }

    #[test]
    fn the_figures_of_a_frame_come_from_one_pass() {
        let passes = [vec![frame(1, 30, 5), frame(7, 20, 9)], vec![frame(1, 20, 8), frame(7, 25, 4)]];
        let figures = fastest(passes.iter().map(Vec::as_slice));
        let seen: Vec<_> = figures.iter().map(|f| (f.frame, f.wall_ms, f.march_ms)).collect();
        assert_eq!(seen, [(1, 20.0, 8.0), (7, 20.0, 9.0)]);
    }
}
