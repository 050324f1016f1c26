//! Numbered tasks on several threads, results in order.
//!
//! The calling thread hands out numbers and takes results; it lets no more than a few tasks per worker be ahead
//! of the last result taken, so that the reorder buffer is bounded. The first error *by number* wins, whichever
//! thread was faster: a failing build says the same on every machine.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam::channel;

use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Tasks in flight or waiting for their turn, per worker.
pub(super) const AHEAD: u64 = 3;

/// Result of a task of any type.
type Answer = Box<dyn Any + Send>;

/// Function that does one task after the other, with a state of its own.
type Worker<'w> = Box<dyn FnMut(u64) -> Result<Answer> + 'w>;

/// Runs tasks `0..count`: `work` on `threads` threads, each with a state from `prepare`; `take` here, in order.
pub(super) fn in_order<S, R: Send + 'static>(
    count: u64,
    threads: usize,
    observer: &dyn Observer,
    prepare: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, u64) -> Result<R> + Sync,
    mut take: impl FnMut(u64, R) -> Result<()>,
) -> Result<()> {
    let (prepare, work) = (&prepare, &work);
    let hire = || -> Worker<'_> {
        let mut state = prepare();
        Box::new(move |task| work(&mut state, task).map(|result| Box::new(result) as Answer))
    };

    run(count, threads, observer, &hire, &mut |task, answer| {
        take(task, *answer.downcast().expect("answers are of the type that tasks return"))
    })
}

/// Runs tasks of any type: threads and queues are compiled once, whatever the tasks are.
fn run<'w>(
    count: u64,
    threads: usize,
    observer: &dyn Observer,
    hire: &(dyn Fn() -> Worker<'w> + Sync),
    take: &mut dyn FnMut(u64, Answer) -> Result<()>,
) -> Result<()> {
    let threads = threads.max(1);
    let window = AHEAD * threads as u64;
    let (tasks, inbox) = channel::bounded::<u64>(window as usize);
    let (outbox, results) = channel::bounded::<(u64, Result<Answer>)>(window as usize);
    let stop = AtomicBool::new(false);

    std::thread::scope(|scope| {
        for _ in 0..threads {
            let (inbox, outbox, stop) = (inbox.clone(), outbox.clone(), &stop);
            scope.spawn(move || {
                let mut worker = hire();
                for task in inbox {
                    if stop.load(Ordering::Relaxed) || outbox.send((task, worker(task))).is_err() {
                        break;
                    }
                }
            });
        }

        drop((inbox, outbox));
        let mut issued = 0;
        let mut early = BTreeMap::new();

        let mut deliver = |next: u64| -> Result<()> {
            while issued < count.min(next + window) {
                // Capacity is the window, so this never waits; it fails only if all workers are gone.
                if tasks.send(issued).is_err() {
                    break;
                }
                issued += 1;
            }

            let result = loop {
                if observer.cancelled() {
                    return Err(Error::Interrupted("no database was written".into()));
                }
                if let Some(result) = early.remove(&next) {
                    break result;
                }
                match results.recv() {
                    Ok((task, result)) => drop(early.insert(task, result)),
                    Err(_) => return Err(Error::Configuration("a worker thread ended early".into())),
                }
            };

            take(next, result?)
        };

        let outcome = (0..count).try_for_each(&mut deliver);
        stop.store(true, Ordering::Relaxed);
        drop((tasks, results));

        outcome
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop_base::progress::Silent;

    fn run(threads: usize, fails: &[u64]) -> (Vec<u64>, Option<String>) {
        let mut taken = Vec::new();
        let outcome = in_order(
            100,
            threads,
            &Silent,
            || (),
            |(), task| {
                std::thread::sleep(std::time::Duration::from_micros((task * 7919) % 300));
                if fails.contains(&task) {
                    Err(Error::Configuration(format!("task {task}")))
                } else {
                    Ok(task * 2)
                }
            },
            |task, result| {
                assert_eq!(result, task * 2);
                taken.push(task);
                Ok(())
            },
        );

        (taken, outcome.err().map(|error| error.to_string()))
    }

    #[test]
    fn results_come_in_order() {
        for threads in [1, 2, 7] {
            assert_eq!(run(threads, &[]), ((0..100).collect(), None));
        }
    }

    #[test]
    fn the_first_failing_task_is_reported() {
        for threads in [1, 4] {
            assert_eq!(run(threads, &[41, 40, 43]), ((0..40).collect(), Some("task 40".into())));
        }
    }

    #[test]
    fn no_tasks_no_work() {
        in_order(0, 3, &Silent, || (), |(), _| Ok(()), |_, ()| unreachable!("no tasks")).unwrap();
    }

    #[test]
    fn a_stopped_observer_interrupts() {
        struct Stopped;
        impl Observer for Stopped {
            fn cancelled(&self) -> bool {
                true
            }
        }
        let outcome = in_order(9, 2, &Stopped, || (), |(), _| Ok(()), |_, ()| Ok(()));
        assert!(matches!(outcome, Err(Error::Interrupted(_))));
    }
}
