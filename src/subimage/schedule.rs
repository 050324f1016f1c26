//! Prediction of frame times with other numbers of workers: a list scheduler over measured tasks.
//!
//! ```text
//! frame n may begin once frames 0..=n − k have been delivered              (k frames in flight)
//! a frame = serial part, then for each stage: queue its tasks; wait until the last has ended
//! queue, in the order in which stages are ready:  the worker that is free first takes its next task
//! ```
//! This is what [`Farm::each`](super::Farm::each) and [`Farm::fly`](super::Farm::fly) do, with clocks replaced by
//! sums (Graham 1966, "Bounds for certain multiprocessing anomalies", for what list schedulers can and cannot do).
//! The serial part, wherever it lies in a frame, is taken to come first; it runs on a driver and
//! keeps no worker busy. A task is taken to last as long as it did with one worker: shared caches, memory
//! bandwidth, clocks that sink when all cores work, and the cost of waking a worker are not modelled.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::Duration;

use super::queue::Queue;
use super::task::Stage;
use super::trace::Trace;

/// Work of one frame for the farm.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameWork {
    /// Time outside of tasks, with which no second worker helps.
    pub serial: Duration,
    /// The tasks of each stage in order; a stage begins when the one before has ended.
    pub stages: Vec<Vec<Duration>>,
}

impl FrameWork {
    /// Time of all tasks and of the serial part: what one worker needs.
    pub fn total(&self) -> Duration {
        self.serial + self.stages.iter().flatten().sum::<Duration>()
    }

    /// The frames of a trace that one worker left, in the order in which they were begun.
    pub fn from_trace(trace: &Trace) -> Vec<Self> {
        let mut tasks = trace.tasks();
        tasks.sort_by_key(|task| (task.frame, task.stage, task.task));
        let mut frames = trace.frames();
        frames.sort_by_key(|frame| frame.start);
        let work = |frame: &super::FrameSpan| {
            let begin = tasks.partition_point(|task| task.frame < frame.frame);
            let own = tasks[begin..].iter().take_while(|task| task.frame == frame.frame);
            let stage = |stage: Stage| {
                own.clone().filter(|task| task.stage == stage).map(|task| task.end - task.start).collect()
            };
            let stages: Vec<Vec<Duration>> = Stage::ALL.into_iter().map(stage).collect();
            let serial = (frame.end - frame.start).saturating_sub(stages.iter().flatten().sum());
            Self { serial, stages }
        };
        frames.iter().map(work).collect()
    }

    /// The shortest time of each part over several passes of the same frames: the least disturbed one.
    pub fn least(passes: impl IntoIterator<Item = Vec<Self>>) -> Vec<Self> {
        passes
            .into_iter()
            .reduce(|least, pass| least.into_iter().zip(pass).map(|(a, b)| a.lesser(b)).collect())
            .unwrap_or_default()
    }

    /// Takes the shorter time of each part.
    fn lesser(mut self, other: Self) -> Self {
        self.serial = self.serial.min(other.serial);
        for (own, other) in self.stages.iter_mut().flatten().zip(other.stages.into_iter().flatten()) {
            *own = other.min(*own);
        }
        self
    }
}

/// Time from the start of the first frame to the end of the last, with `workers` workers and up to `in_flight` frames in
/// flight (either at least one).
pub fn makespan(frames: &[FrameWork], workers: usize, in_flight: usize) -> Duration {
    let in_flight = in_flight.max(1);
    let mut workers: BinaryHeap<_> =
        (0..workers.max(1)).map(|worker| Reverse((Duration::ZERO, worker))).collect();
    let mut ended: Vec<Option<Duration>> = vec![None; frames.len()];
    let (mut delivered, mut now) = (0, Duration::ZERO);

    // (when it is ready, frame, stage); the earliest first. What follows from a stage is never ready before it.
    let mut ready: BinaryHeap<_> =
        frames.iter().enumerate().take(in_flight).map(|(n, frame)| Reverse((frame.serial, n, 0))).collect();
    while let Some(Reverse((at, n, stage))) = ready.pop() {
        if let Some(tasks) = frames[n].stages.get(stage) {
            ready.push(Reverse((hand_out(tasks, at, &mut workers), n, stage + 1)));
            continue;
        }

        ended[n] = Some(at);
        while let Some(end) = ended.get(delivered).copied().flatten() {
            now = now.max(end);
            let next = delivered + in_flight;
            if let Some(frame) = frames.get(next) {
                ready.push(Reverse((now + frame.serial, next, 0)));
            }
            delivered += 1;
        }
    }

    now
}

/// Times when workers are free, the first of them on top.
type Workers = BinaryHeap<Reverse<(Duration, usize)>>;

/// Has workers do tasks as a farm's do, not before `ready`; returns when the last ends.
fn hand_out(tasks: &[Duration], ready: Duration, workers: &mut Workers) -> Duration {
    let sharing = workers.len().min(tasks.len()).max(1);
    let queue = Queue::new(tasks.to_vec(), sharing);
    let mut last = ready;
    while let Some(mut first) = workers.peek_mut() {
        let (free, worker) = &mut first.0;
        let Some((_, task)) = queue.take(*worker % sharing) else { break };
        *free = (*free).max(ready) + task;
        last = last.max(*free);
    }
    last
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::subimage::{Batch, Farm};
    use hedgehop_base::progress::Silent;

    const MS: Duration = Duration::from_millis(1);

    fn frame(serial: u32, stages: &[&[u32]]) -> FrameWork {
        FrameWork {
            serial: MS * serial,
            stages: stages.iter().map(|tasks| tasks.iter().map(|&task| MS * task).collect()).collect(),
        }
    }

    #[test]
    fn one_worker_takes_the_sum() {
        let frames = [frame(3, &[&[5, 1, 2], &[4]]), frame(1, &[&[2], &[]]), frame(0, &[])];
        let total: Duration = frames.iter().map(FrameWork::total).sum();
        assert_eq!(makespan(&frames, 1, 1), total);
        assert_eq!(total, MS * 18);
        assert_eq!(makespan(&[], 4, 2), Duration::ZERO);
    }

    #[test]
    fn equal_tasks_take_whole_rounds() {
        let frames = [frame(0, &[&[7; 10]])];
        for workers in 1..=12 {
            assert_eq!(makespan(&frames, workers, 1), MS * 7 * 10_usize.div_ceil(workers) as u32);
        }
    }

    #[test]
    fn one_long_task_bounds_a_frame() {
        let mut tasks = [1; 50];
        tasks[20] = 30;
        let frames = [frame(0, &[&tasks, &[2; 8]])];
        // 20 tasks go before it in the first worker's share; the other does all the rest meanwhile.
        assert_eq!(makespan(&frames, 2, 1), MS * (20 + 30 + 8));
        // From 50 workers on it starts at once.
        assert_eq!(makespan(&frames, 256, 1), MS * (30 + 2));
    }

    #[test]
    fn the_serial_part_gives_amdahls_limit() {
        let tasks = [1; 900];
        let frames = vec![frame(100, &[&tasks]); 10];
        let one = makespan(&frames, 1, 1).as_secs_f64();
        let speed_up = |workers, in_flight| one / makespan(&frames, workers, in_flight).as_secs_f64();
        for workers in [2, 4, 9, 100, 900] {
            let amdahl = 1.0 / (0.1 + 0.9 / workers as f64);
            assert!((speed_up(workers, 1) - amdahl).abs() < 1e-9, "{workers}");
        }
        assert!(speed_up(100_000, 1) < 10.0);
        // Two drivers hide one's serial part behind the other's tasks.
        assert!((speed_up(100_000, 2) - 2.0 * speed_up(100_000, 1)).abs() < 1e-9);
    }

    #[test]
    fn the_next_frame_fills_the_end_of_a_stage() {
        // Alone, one of two workers idles for 4 ms at the end of each stage.
        let frames = vec![frame(0, &[&[4, 8], &[4, 8]]); 50];
        assert_eq!(makespan(&frames, 2, 1), MS * 16 * 50);
        // Together they idle at the very end only.
        let time = makespan(&frames, 2, 2);
        assert!((MS * 12 * 50..=MS * (12 * 50 + 8)).contains(&time), "{time:?}");
    }

    #[test]
    fn a_trace_of_one_worker_gives_its_own_time_back() {
        let trace = Arc::new(Trace::new(1));
        let farm = Farm::new(1).unwrap().with_trace(&trace);
        let frames: Vec<_> = (1..=3).map(|number| (number, ())).collect();
        let nap = |_, ()| {
            std::thread::sleep(MS);
            Ok(())
        };
        let batch = Batch { frames: &frames, in_flight: 1, observer: &Silent };
        let render = |farm: &Farm, (): &()| {
            std::thread::sleep(MS * 2);
            Stage::ALL.into_iter().try_for_each(|stage| farm.each(stage, vec![(); 4], nap))
        };
        farm.fly(&batch, render, |_, ()| Ok(())).unwrap();
        let work = FrameWork::from_trace(&trace);
        assert_eq!(work.len(), 3);

        for (work, span) in work.iter().zip(trace.frames()) {
            assert_eq!(work.total(), span.end - span.start);
            assert!(work.serial >= MS * 2);
            assert!(work.stages.iter().all(|tasks| tasks.len() == 4 && tasks.iter().all(|&task| task >= MS)));
        }

        let least = FrameWork::least([work.clone(), vec![frame(0, &[&[0; 4], &[9000; 4]]); 3]]);
        assert_eq!(least[0].stages[1], work[0].stages[1]);
        assert_eq!(least[0].total(), work[0].stages[1].iter().sum::<Duration>());
    }

    /// Sleeping tasks need no cores, so that more workers can be tried than the machine has.
    #[test]
    fn the_farm_takes_as_long_as_the_schedule_says() {
        let length = |task: u32, stage: Stage| MS * (2 + (task * 7 + stage as u32) % 9);
        let task_times = |stage| (0..24).map(|task| length(task, stage)).collect();
        let work = FrameWork { serial: MS * 5, stages: Stage::ALL.map(task_times).to_vec() };
        let frames: Vec<_> = (1..=6).map(|number| (number, ())).collect();

        let render = |farm: &Farm, (): &()| {
            std::thread::sleep(work.serial);
            Stage::ALL.into_iter().try_for_each(|stage| {
                farm.each(stage, (0..24).collect(), |_, task| {
                    std::thread::sleep(length(task, stage));
                    Ok(())
                })
            })
        };

        for (workers, in_flight) in [(2, 1), (8, 1), (8, 2), (24, 2), (24, 3)] {
            let farm = Farm::new(workers).unwrap();
            let batch = Batch { frames: &frames, in_flight, observer: &Silent };
            let predicted = makespan(&vec![work.clone(); frames.len()], workers, in_flight).as_secs_f64();
            let mut ratios = std::iter::repeat_with(|| {
                let begun = std::time::Instant::now();
                farm.fly(&batch, render, |_, ()| Ok(())).unwrap();
                begun.elapsed().as_secs_f64() / predicted
            });
            // Sleepers wake late where others are busy; one undisturbed flight shows what the farm does.
            let agrees = ratios.by_ref().take(10).any(|ratio| (0.95..1.3).contains(&ratio));
            assert!(agrees, "{workers} workers, {in_flight} in flight: {:?}", ratios.next());
        }
    }

    fn frames() -> impl Strategy<Value = Vec<FrameWork>> {
        let tasks = || prop::collection::vec(0_u32..50, 0..30);
        let frame = (0_u32..20, tasks(), tasks()).prop_map(|(serial, a, b)| frame(serial, &[&a, &b]));
        prop::collection::vec(frame, 1..8)
    }

    proptest! {
        /// Graham's bound for any schedule in which nobody idles while a task waits.
        #[test]
        fn nobody_idles_while_a_task_waits(frames in frames(), workers in 1..40_usize) {
            let most = |tasks: &Vec<Duration>| {
                let longest = tasks.iter().max().copied().unwrap_or_default();
                longest + tasks.iter().sum::<Duration>().saturating_sub(longest) / workers as u32
            };
            let stages = frames.iter().flat_map(|frame| &frame.stages).map(most).sum::<Duration>();
            let serial = frames.iter().map(|frame| frame.serial).sum::<Duration>();
            let rounding = Duration::from_micros(1);
            prop_assert!(makespan(&frames, workers, 1) <= serial + stages + rounding);
        }

        #[test]
        fn no_schedule_beats_the_work_or_the_longest_chain(frames in frames(), workers in 1..40_usize, in_flight in 1..4_usize) {
            let time = makespan(&frames, workers, in_flight);
            let work: Duration = frames.iter().flat_map(|frame| frame.stages.iter().flatten()).sum();
            prop_assert!(time * workers as u32 >= work);
            let chain = |frame: &FrameWork| {
                frame.serial + frame.stages.iter().filter_map(|tasks| tasks.iter().max()).sum::<Duration>()
            };
            prop_assert!(frames.iter().all(|frame| time >= chain(frame)));
            prop_assert!(time <= makespan(&frames, 1, 1));
        }
    }
}
