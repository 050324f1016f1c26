//! The farm: a fixed number of workers, and how they share out tasks.
//!
//! ```text
//! each(tasks):  a share of neighbouring tasks for every worker
//!               on every worker:  first task of the own share, or else last of another's:  work(index, task)
//!               until no worker works on any of them
//! ```
//! Neighbours read much of the same data, which one worker then has in its cache, and of the frame before, in which its
//! share was the same (2 % of two workers' frames a second on one machine); whoever is done with its share helps
//! with another's from the far end, so that workers are never more than one task apart at the end. Taking one
//! is an atomic exchange. A worker never waits inside a task for other tasks; that is why a free one
//! can always go on with the next frame (see [`Farm::fly`]), and why this is no parallel iterator:
//! there, a worker that waits for its frame may take on all of another one first.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::queue::Queue;
use super::task::{Stage, Subimage, TaskSize, split};
use super::trace::Trace;
use hedgehop_base::error::{Error, Result};

/// A fixed number of workers. Clones are handles of the same workers.
#[derive(Debug, Clone)]
pub struct Farm {
    /// `None`: the only worker is the thread that calls, which saves waking another.
    pool: Option<Arc<rayon::ThreadPool>>,
    /// `None`: what suits the engine.
    task_size: Option<TaskSize>,
    trace: Option<Arc<Trace>>,
    /// Number of the frame that tasks belong to, for the trace.
    frame: u64,
}

impl Farm {
    /// A farm of `workers` threads, at least one.
    ///
    /// A farm of one has no thread of its own: the caller's does the work.
    pub fn new(workers: usize) -> Result<Self> {
        let pool = if workers > 1 { Some(Arc::new(start(workers)?)) } else { None };
        Ok(Self { pool, task_size: None, trace: None, frame: 0 })
    }

    /// The same workers, with tasks of another size.
    #[must_use]
    pub fn with_task_size(&self, task_size: TaskSize) -> Self {
        Self { task_size: Some(task_size), ..self.clone() }
    }

    /// The same workers; `trace`, which must have as many lanes, learns when each task ran.
    #[must_use]
    pub fn with_trace(&self, trace: &Arc<Trace>) -> Self {
        Self { trace: Some(Arc::clone(trace)), ..self.clone() }
    }

    /// The same workers; the trace files their tasks under frame `number`.
    #[must_use]
    pub fn for_frame(&self, number: u64) -> Self {
        Self { frame: number, ..self.clone() }
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Returns how large tasks should be: what was asked for, or else the default.
    pub fn task_size(&self) -> TaskSize {
        self.task_size_or(TaskSize::default())
    }

    /// Returns how large tasks should be: what was asked for, or else what suits the work.
    pub fn task_size_or(&self, suitable: TaskSize) -> TaskSize {
        self.task_size.unwrap_or(suitable)
    }

    pub(super) fn trace(&self) -> Option<&Trace> {
        self.trace.as_deref()
    }

    /// Runs `work(index, task)` for every task on the workers and returns when all are done. A task owns what it
    /// writes: slices that `chunks_mut` or `split_at_mut` made, for instance.
    ///
    /// After an error tasks behind it no longer start, and those before it still
    /// run, so that the error returned is that of the first task that has one, for any number of workers.
    ///
    /// A task must not call the farm.
    pub fn each<T: Send>(
        &self,
        stage: Stage,
        tasks: Vec<T>,
        work: impl Fn(usize, T) -> Result<()> + Sync,
    ) -> Result<()> {
        self.each_with(stage, tasks, || (), |(), index, task| work(index, task))
    }

    /// [`Self::each`] with scratch memory: each worker that takes part makes one and lends it to each of its tasks. A
    /// task must not find in it what another left there, or frames depend on the number of workers.
    pub fn each_with<T: Send, W>(
        &self,
        stage: Stage,
        tasks: Vec<T>,
        scratch: impl Fn() -> W + Sync,
        work: impl Fn(&mut W, usize, T) -> Result<()> + Sync,
    ) -> Result<()> {
        let failure = Failure::default();
        self.run(stage, tasks, scratch, |scratch, index, task| {
            if failure.permits(index)
                && let Err(error) = work(scratch, index, task)
            {
                failure.report(index, error);
            }
        });
        failure.into_result()
    }

    /// Works on every subimage of a screen of `width` columns; results in order, or the first error.
    pub fn render<T: Send>(
        &self,
        width: u32,
        task: impl Fn(Subimage) -> Result<T> + Sync + Send,
    ) -> Result<Vec<T>> {
        let subimages: Vec<_> = split(width, self.task_size().lines).collect();
        let mut results: Vec<Option<T>> = subimages.iter().map(|_| None).collect();
        let tasks = subimages.into_iter().zip(&mut results).collect();
        self.each(Stage::March, tasks, |_, (subimage, result)| {
            *result = Some(task(subimage)?);
            Ok(())
        })?;
        Ok(results.into_iter().flatten().collect())
    }

    /// Works on every row of an image with `width` elements a row, in place: `task(row index, row)`.
    pub fn rows<T: Send>(&self, image: &mut [T], width: usize, task: impl Fn(usize, &mut [T]) + Sync + Send) {
        let rows = self.task_size().rows.max(1) as usize;
        let blocks = image.chunks_mut(width.saturating_mul(rows).max(1)).collect();
        self.run(
            Stage::Image,
            blocks,
            || (),
            |(), index, block| {
                for (row, line) in block.chunks_mut(width.max(1)).enumerate() {
                    task(index * rows + row, line);
                }
            },
        );
    }

    /// Hands out `tasks` until all are done; to one worker in order.
    fn run<T: Send, W>(
        &self,
        stage: Stage,
        tasks: Vec<T>,
        scratch: impl Fn() -> W + Sync,
        work: impl Fn(&mut W, usize, T) + Sync,
    ) {
        let workers = self.workers().min(tasks.len());
        let queue = Queue::new(tasks, workers);
        let take_part = |worker: usize| {
            let mut scratch = scratch();
            let own = worker % workers.max(1);
            while let Some((index, task)) = queue.take(own) {
                match &self.trace {
                    None => work(&mut scratch, index, task),
                    Some(trace) => {
                        let start = trace.now();
                        work(&mut scratch, index, task);
                        trace.task(worker, stage, self.frame, index, start);
                    }
                }
            }
        };

        let Some(pool) = &self.pool else { return take_part(0) };
        pool.in_place_scope(|scope| {
            for _ in 0..workers {
                scope.spawn(|_| take_part(rayon::current_thread_index().unwrap_or(0)));
            }
        });
    }
}

fn start(workers: usize) -> Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(workers)
        .thread_name(|index| format!("subimage-{index}"))
        .build()
        .map_err(|error| {
            Error::Configuration(format!("cannot start {workers} workers: {error}; ask for fewer (-j)"))
        })
}

/// The error of the first task that has one.
struct Failure {
    /// Index of that task; `usize::MAX` if none failed.
    index: AtomicUsize,
    error: Mutex<Option<(usize, Error)>>,
}

impl Default for Failure {
    fn default() -> Self {
        Self { index: AtomicUsize::new(usize::MAX), error: Mutex::default() }
    }
}

impl Failure {
    /// Whether task `index` can still matter.
    fn permits(&self, index: usize) -> bool {
        index < self.index.load(Ordering::Relaxed)
    }

    fn report(&self, index: usize, error: Error) {
        let mut first = self.error.lock().unwrap_or_else(PoisonError::into_inner);
        if first.as_ref().is_none_or(|(other, _)| index < *other) {
            *first = Some((index, error));
        }
        self.index.fetch_min(index, Ordering::Relaxed);
    }

    fn into_result(self) -> Result<()> {
        match self.error.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::thread;
    use std::time::Duration;

    use super::*;

    fn farms() -> [Farm; 4] {
        [1, 2, 3, 5].map(|workers| Farm::new(workers).unwrap())
    }

    fn no(index: usize) -> Error {
        Error::Configuration(format!("task {index}"))
    }

    #[test]
    fn every_task_runs_once_and_writes_its_own_slice() {
        for farm in farms() {
            for (length, size) in [(0, 1), (1, 4), (1000, 7), (64, 64)] {
                let mut buffer = vec![0_u32; length];
                farm.each(Stage::March, buffer.chunks_mut(size).collect(), |index, slice| {
                    slice
                        .iter_mut()
                        .enumerate()
                        .for_each(|(at, value)| *value += (index * size + at) as u32 + 1);
                    Ok(())
                })
                .unwrap();
                assert!(buffer.iter().zip(1..).all(|(&found, wanted)| found == wanted));
            }
        }
    }

    #[test]
    fn no_more_scratch_is_made_than_there_are_workers() {
        for farm in farms() {
            let made = AtomicUsize::new(0);
            let scratch = || vec![made.fetch_add(1, Ordering::Relaxed); 4];
            farm.each_with(Stage::March, (0..100).collect(), scratch, |scratch, _, task: usize| {
                scratch.fill(task);
                Ok(())
            })
            .unwrap();
            assert!((1..=farm.workers()).contains(&made.into_inner()));
        }
    }

    #[test]
    fn the_first_error_in_task_order_wins() {
        for farm in farms() {
            for _ in 0..20 {
                let outcome = farm.each(Stage::Image, (0..100).collect(), |index, task: usize| {
                    assert_eq!(index, task);
                    match index {
                        // The first to fail is the last to say so.
                        20 => thread::sleep(Duration::from_millis(2)),
                        21..=40 => {}
                        _ => return Ok(()),
                    }
                    Err(no(index))
                });
                assert_eq!(outcome.unwrap_err().to_string(), "task 20", "{} workers", farm.workers());
            }
        }
    }

    #[test]
    fn tasks_behind_an_error_do_not_start() {
        let started = AtomicUsize::new(0);
        let farm = Farm::new(2).unwrap();
        let outcome = farm.each(Stage::March, vec![(); 10_000], |index, ()| {
            started.fetch_add(1, Ordering::Relaxed);
            thread::sleep(Duration::from_millis(1));
            if index == 3 { Err(no(index)) } else { Ok(()) }
        });
        assert!(outcome.is_err());
        assert!(started.load(Ordering::Relaxed) < 1000);
    }

    #[test]
    fn results_come_in_order_and_an_error_ends_the_frame() {
        for farm in farms() {
            let columns = farm.render(61, |subimage| Ok(subimage.first_column)).unwrap();
            assert_eq!(columns, [0, 8, 16, 24, 32, 40, 48, 56]);
            let failed = farm.render(64, |subimage| match subimage.first_column {
                32 => Err(no(32)),
                column => Ok(column),
            });
            assert_eq!(failed.unwrap_err().to_string(), "task 32");
        }
    }

    #[test]
    fn rows_know_their_index_for_any_block() {
        for rows in [0, 1, 3, 8, u32::MAX] {
            let farm = Farm::new(3).unwrap().with_task_size(TaskSize { lines: 1, rows });
            let mut image = vec![0; 5 * 19];
            farm.rows(&mut image, 5, |row, line| line.fill(row));
            assert!(image.chunks(5).enumerate().all(|(row, line)| line == [row; 5]), "{rows} rows a task");
            farm.rows(&mut image, 0, |_, _| {});
        }
    }

    #[test]
    fn a_panic_in_a_task_reaches_the_caller() {
        for farm in farms() {
            let caught = catch_unwind(AssertUnwindSafe(|| {
                farm.each(Stage::March, (0..50).collect(), |_, task: u32| {
                    assert_ne!(task, 17);
                    Ok(())
                })
            }));
            assert!(caught.is_err());
            assert!(farm.each(Stage::March, vec![1], |_, _| Ok(())).is_ok(), "the farm works on");
        }
    }
}
