//! Trace of tasks: when each ran, and on which worker.
//!
//! Each worker has a list of its own, so that noting a task costs two looks at the clock and a lock
//! that nobody else holds. A farm without a trace pays one branch per task.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::task::Stage;

/// One task that ran. Times are since the trace was begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskSpan {
    /// Worker that ran it, `0..workers`.
    pub worker: usize,
    /// Stage that it was for.
    pub stage: Stage,
    /// Number of the frame.
    pub frame: u64,
    /// Number among the tasks of its frame and stage, 0….
    pub task: usize,
    /// Start of the task.
    pub start: Duration,
    /// End of the task.
    pub end: Duration,
}

/// One frame from its first instruction to its last. Times are since the trace was begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameSpan {
    /// Number of the frame.
    pub frame: u64,
    /// Number among the frames in flight, 0….
    pub driver: usize,
    /// Start of the frame.
    pub start: Duration,
    /// End of the frame.
    pub end: Duration,
}

/// Remembers every task of a [`Farm`](super::Farm).
#[derive(Debug)]
pub struct Trace {
    begun: Instant,
    workers: Vec<Mutex<Vec<TaskSpan>>>,
    frames: Mutex<Vec<FrameSpan>>,
}

impl Trace {
    /// An empty trace of `workers` workers that begins now.
    pub fn new(workers: usize) -> Self {
        let workers = (0..workers).map(|_| Mutex::default()).collect();
        Self { begun: Instant::now(), workers, frames: Mutex::default() }
    }

    /// Time since the trace was begun.
    pub fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.workers.len()
    }

    /// Notes a task that ends now. A worker beyond the lanes is not noted.
    pub(super) fn task(&self, worker: usize, stage: Stage, frame: u64, task: usize, start: Duration) {
        let end = self.now();
        if let Some(lane) = self.workers.get(worker) {
            let span = TaskSpan { worker, stage, frame, task, start, end };
            lane.lock().unwrap_or_else(PoisonError::into_inner).push(span);
        }
    }

    /// Notes a frame that ends now.
    pub fn frame(&self, driver: usize, frame: u64, start: Duration) {
        let span = FrameSpan { frame, driver, start, end: self.now() };
        self.frames.lock().unwrap_or_else(PoisonError::into_inner).push(span);
    }

    /// All tasks, worker by worker, each worker's in the order in which they ran.
    pub fn tasks(&self) -> Vec<TaskSpan> {
        let lane = |lane: &Mutex<Vec<TaskSpan>>| lane.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.workers.iter().flat_map(lane).collect()
    }

    /// All frames in the order in which they ended.
    pub fn frames(&self) -> Vec<FrameSpan> {
        self.frames.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::subimage::Farm;

    #[test]
    fn every_task_is_noted_once_and_no_worker_does_two_at_a_time() {
        for workers in [1, 2, 5] {
            let trace = Arc::new(Trace::new(workers));
            let farm = Farm::new(workers).unwrap().with_trace(&trace).for_frame(7);
            for stage in Stage::ALL {
                farm.each(stage, vec![(); 100], |_, ()| {
                    std::hint::black_box(());
                    Ok(())
                })
                .unwrap();
            }

            let tasks = trace.tasks();
            let mut noted: Vec<_> = tasks.iter().map(|span| (span.stage, span.task)).collect();
            noted.sort_unstable();
            let wanted: Vec<_> =
                Stage::ALL.into_iter().flat_map(|stage| (0..100).map(move |task| (stage, task))).collect();
            assert_eq!(noted, wanted);
            assert!(
                tasks.iter().all(|span| span.frame == 7 && span.start <= span.end && span.worker < workers)
            );
            for pair in tasks.windows(2).filter(|pair| pair[0].worker == pair[1].worker) {
                assert!(pair[0].end <= pair[1].start);
            }

            let image = tasks.iter().filter(|span| span.stage == Stage::Image).map(|span| span.start).min();
            let march = tasks.iter().filter(|span| span.stage == Stage::March).map(|span| span.end).max();
            assert!(march <= image, "the second stage begins when the first has ended");
        }
    }
}
