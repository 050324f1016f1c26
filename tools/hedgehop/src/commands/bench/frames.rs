//! What single frames took: wall time, CPU time, stages.
//!
//! On a machine that does other work meanwhile, wall time counts that work too; CPU time hardly does. Of
//! the passes over a frame the fastest one is reported, as a whole: it is the one that was disturbed least,
//! and the figures of one entry then belong together.

use std::time::{Duration, Instant};

use hedgehop::render::StageTimes;

use crate::figures::FrameFigures;

/// One frame of one pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameTimes {
    /// Number of the frame.
    pub number: u64,
    /// Wall time, without encoding.
    pub wall: Duration,
    /// CPU time of all threads in it, where the system tells.
    pub cpu: Option<Duration>,
    /// Its stages, summed over workers.
    pub stages: StageTimes,
}

/// Both clocks at the start of a frame.
pub(super) struct Clocks {
    wall: Instant,
    cpu: Option<Duration>,
}

impl Clocks {
    /// Starts both.
    pub(super) fn start() -> Self {
        // The CPU clock is read first and last: what reading it costs is never hidden.
        let cpu = process_cpu_time();
        Self { wall: Instant::now(), cpu }
    }

    /// Wall and CPU time since the start.
    pub(super) fn elapsed(&self) -> (Duration, Option<Duration>) {
        let wall = self.wall.elapsed();
        let cpu = self.cpu.zip(process_cpu_time()).map(|(begin, end)| end.saturating_sub(begin));
        (wall, cpu)
    }
}

/// CPU time of all threads of this process so far.
#[cfg(unix)]
fn process_cpu_time() -> Option<Duration> {
    use rustix::time::{ClockId, clock_gettime};
    Duration::try_from(clock_gettime(ClockId::ProcessCPUTime)).ok()
}

/// CPU time of all threads of this process so far.
#[cfg(not(unix))]
fn process_cpu_time() -> Option<Duration> {
    None
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

    #[cfg(unix)]
    #[test]
    fn cpu_time_is_spent_by_work_and_not_by_sleep() {
        let clocks = Clocks::start();
        std::thread::sleep(Duration::from_millis(300));
        let (wall, slept) = clocks.elapsed();
        assert!(wall >= Duration::from_millis(300));
        let busy = Instant::now();
        let mut sum = 0_u64;
        while busy.elapsed() < Duration::from_millis(20) {
            sum = std::hint::black_box(sum.wrapping_add(1));
        }
        let (_, worked) = clocks.elapsed();
        // Other tests of this process may run meanwhile, so that only growth is certain.
        assert!(worked.unwrap() > slept.unwrap());
    }
}
