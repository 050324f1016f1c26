//! Frames that overlap: while the last tasks of one run, tasks of the next begin.
//!
//! ```text
//! k drivers:   loop  n = next frame, once n < delivered + k;  result[n] = render(n)
//!                       └── each(march tasks) ── each(image tasks) ──▶ the farm's queue
//! the caller:  for n in order:  deliver(result[n]);  delivered = n + 1
//! ```
//! A driver is a thread that waits while the workers do its frame's tasks; it computes only what a
//! frame computes between its stages. The farm hands out the batches of tasks in the order in which the
//! drivers bring them, so with two frames in flight workers that find frame n's march done go on with
//! frame n + 1's, and by the end of that frame n's image tasks have come. Only at the last frame
//! of all does a worker run out of tasks.
//!
//! At most k frames exist between the start of their rendering and the end of their delivery: that bounds
//! memory, also if whoever takes the frames is slow. Everything that is decided depends on the order
//! of frames, never on who was first.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::farm::Farm;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;

/// Frames in flight if nobody says otherwise, and there is more than one worker. Two are enough to
/// fill the ends of stages; more take memory.
pub const DEFAULT_IN_FLIGHT: usize = 2;

/// Frames that are to be rendered.
#[derive(Clone, Copy)]
pub struct Batch<'a, C> {
    /// Number of each frame, and what it is rendered from.
    pub frames: &'a [(u64, C)],
    /// Frames that may exist at once, ≥ 1; see [`Farm::in_flight`].
    pub in_flight: usize,
    /// Observer who may stop the work.
    pub observer: &'a dyn Observer,
}

impl Farm {
    /// Returns how many frames are in flight at once if `asked` frames are wanted, or nothing in particular: 2. One worker
    /// gets one, since it is never out of tasks.
    pub fn in_flight(&self, asked: Option<usize>) -> usize {
        if self.workers() == 1 { 1 } else { asked.unwrap_or(DEFAULT_IN_FLIGHT).max(1) }
    }

    /// Renders every frame of `batch` with `render(farm, frame)` and hands the results to `deliver(number, result)` on
    /// the calling thread, in order.
    ///
    /// # Errors
    /// The first error in the order of frames, from `render` or `deliver`; every frame before it has
    /// been delivered, and none behind it. [`Error::Interrupted`] if the observer stopped the work: every
    /// frame that had been begun has been delivered.
    pub fn fly<C: Sync, R: Send>(
        &self,
        batch: &Batch<'_, C>,
        render: impl Fn(&Farm, &C) -> Result<R> + Sync,
        mut deliver: impl FnMut(u64, R) -> Result<()>,
    ) -> Result<()> {
        let in_flight = self.in_flight(Some(batch.in_flight)).min(batch.frames.len());
        if in_flight > 1 {
            return self.fly_overlapped(batch, in_flight, &render, deliver);
        }
        for (number, frame) in batch.frames {
            if batch.observer.cancelled() {
                return Err(interrupted());
            }
            deliver(*number, self.fly_one(0, *number, frame, &render)?)?;
        }
        Ok(())
    }

    fn fly_overlapped<C: Sync, R: Send>(
        &self,
        batch: &Batch<'_, C>,
        in_flight: usize,
        render: &(impl Fn(&Farm, &C) -> Result<R> + Sync),
        mut deliver: impl FnMut(u64, R) -> Result<()>,
    ) -> Result<()> {
        let window = OverlapWindow::new(batch.frames.len(), in_flight);
        let drive = |driver: usize| {
            while let Some(index) = window.begin(batch.observer) {
                let _begun = Begun { window: &window, index };
                let (number, frame) = &batch.frames[index];
                window.finish(index, self.fly_one(driver, *number, frame, render));
            }
        };

        let drive = &drive;
        thread::scope(|scope| {
            let drivers: Vec<_> = (0..in_flight).map(|driver| scope.spawn(move || drive(driver))).collect();
            let outcome = {
                let _end = Closing(&window);
                (0..batch.frames.len()).try_for_each(|index| {
                    deliver(batch.frames[index].0, window.wait_for(index)?)?;
                    window.delivered();
                    Ok(())
                })
            };

            for driver in drivers {
                driver.join().unwrap_or_else(|panic| resume_unwind(panic));
            }
            outcome
        })
    }

    fn fly_one<C, R>(
        &self,
        driver: usize,
        number: u64,
        frame: &C,
        render: &impl Fn(&Farm, &C) -> Result<R>,
    ) -> Result<R> {
        let farm = self.for_frame(number);
        let Some(trace) = self.trace() else { return render(&farm, frame) };
        let start = trace.now();
        let result = render(&farm, frame);
        trace.frame(driver, number, start);
        result
    }
}

fn interrupted() -> Error {
    Error::Interrupted("frames written so far are whole".into())
}

/// Frames in flight.
struct OverlapWindow<R> {
    count: usize,
    in_flight: usize,
    state: Mutex<OverlapState<R>>,
    changed: Condvar,
}

struct OverlapState<R> {
    /// First frame that no driver has begun.
    next: usize,
    /// Frames whose delivery has ended.
    delivered: usize,
    /// No further frame begins.
    closed: bool,
    /// Frames that wait for their turn to be delivered.
    finished: BTreeMap<usize, Result<R>>,
}

impl<R> OverlapWindow<R> {
    fn new(count: usize, in_flight: usize) -> Self {
        let state = OverlapState { next: 0, delivered: 0, closed: false, finished: BTreeMap::new() };
        Self { count, in_flight, state: Mutex::new(state), changed: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, OverlapState<R>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, state: MutexGuard<'a, OverlapState<R>>) -> MutexGuard<'a, OverlapState<R>> {
        self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
    }

    /// The next frame to render, once it may exist; `None` if none is to follow.
    fn begin(&self, observer: &dyn Observer) -> Option<usize> {
        let mut state = self.state();
        loop {
            if state.closed || state.next == self.count {
                return None;
            }
            if observer.cancelled() {
                state.closed = true;
                self.changed.notify_all();
                return None;
            }
            if state.next < state.delivered + self.in_flight {
                state.next += 1;
                return Some(state.next - 1);
            }
            state = self.wait(state);
        }
    }

    fn finish(&self, index: usize, result: Result<R>) {
        let mut state = self.state();
        state.closed |= result.is_err();
        state.finished.insert(index, result);
        self.changed.notify_all();
    }

    /// The result of frame `index`; an interruption if it is never to begin.
    fn wait_for(&self, index: usize) -> Result<R> {
        let mut state = self.state();
        loop {
            if let Some(result) = state.finished.remove(&index) {
                return result;
            }
            if state.closed && index >= state.next {
                return Err(interrupted());
            }
            state = self.wait(state);
        }
    }

    fn delivered(&self) {
        self.state().delivered += 1;
        self.changed.notify_all();
    }
}

/// A frame that a driver has begun. Should the driver panic, it has an error for a result, so that nobody waits for it;
/// the panic goes on when the driver is joined.
struct Begun<'a, R> {
    window: &'a OverlapWindow<R>,
    index: usize,
}

impl<R> Drop for Begun<'_, R> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.window.finish(self.index, Err(interrupted()));
        }
    }
}

/// Lets no frame begin once it is dropped, however that comes.
struct Closing<'a, R>(&'a OverlapWindow<R>);

impl<R> Drop for Closing<'_, R> {
    fn drop(&mut self) {
        self.0.state().closed = true;
        self.0.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::time::Duration;

    use super::*;
    use crate::subimage::{Stage, Trace};
    use hedgehop_base::progress::Silent;

    /// Twenty frames with numbers that leave gaps.
    fn frames() -> Vec<(u64, usize)> {
        (0..20).map(|index| (10 + 3 * index as u64, index)).collect()
    }

    fn every_crew(mut test: impl FnMut(&Farm, usize)) {
        for workers in [1, 2, 3, 5] {
            let farm = Farm::new(workers).unwrap();
            (1..=3).for_each(|in_flight| test(&farm, in_flight));
        }
    }

    fn batch<'a>(
        frames: &'a [(u64, usize)],
        in_flight: usize,
        observer: &'a dyn Observer,
    ) -> Batch<'a, usize> {
        Batch { frames, in_flight, observer }
    }

    /// A frame of two stages, of tasks of unlike length.
    fn render(farm: &Farm, index: usize) -> Result<Vec<usize>> {
        let mut values = vec![index; 40];
        for stage in Stage::ALL {
            farm.each(stage, values.iter_mut().collect(), |task, value| {
                thread::sleep(Duration::from_micros(if (task + index).is_multiple_of(13) {
                    400
                } else {
                    20
                }));
                *value += task;
                Ok(())
            })?;
        }
        Ok(values)
    }

    fn no(index: usize) -> Error {
        Error::Configuration(format!("frame {index}"))
    }

    #[test]
    fn frames_come_in_order_and_no_more_exist_than_may() {
        every_crew(|farm, in_flight| {
            let (frames, begun, taken) = (frames(), AtomicUsize::new(0), AtomicUsize::new(0));
            let mut numbers = Vec::new();
            let all = batch(&frames, in_flight, &Silent);

            farm.fly(
                &all,
                |farm, &index| {
                    let exist = begun.fetch_add(1, Ordering::SeqCst) + 1 - taken.load(Ordering::SeqCst);
                    assert!(exist <= farm.in_flight(Some(in_flight)), "{exist} frames at once");
                    render(farm, index)
                },
                |number, values| {
                    let index = numbers.len();
                    assert!(values.iter().enumerate().all(|(task, &value)| value == index + 2 * task));
                    numbers.push(number);
                    taken.fetch_add(1, Ordering::SeqCst);
                    Ok(())
                },
            )
            .unwrap();

            assert!(numbers.iter().eq(frames.iter().map(|(number, _)| number)));
        });
    }

    #[test]
    fn an_error_in_the_middle_keeps_what_came_before() {
        every_crew(|farm, in_flight| {
            let (frames, mut taken) = (frames(), 0);
            let outcome = farm.fly(
                &batch(&frames, in_flight, &Silent),
                |farm, &index| match index {
                    7 => {
                        // Later frames fail first.
                        thread::sleep(Duration::from_millis(3));
                        Err(no(7))
                    }
                    8.. => Err(no(index)),
                    _ => render(farm, index),
                },
                |_, _| {
                    taken += 1;
                    Ok(())
                },
            );

            assert_eq!(outcome.unwrap_err().to_string(), "frame 7");
            assert_eq!(taken, 7);
        });
    }

    #[test]
    fn an_error_of_the_taker_ends_the_flight() {
        every_crew(|farm, in_flight| {
            let (frames, begun) = (frames(), AtomicUsize::new(0));
            let outcome = farm.fly(
                &batch(&frames, in_flight, &Silent),
                |_, &index| Ok(begun.fetch_max(index, Ordering::SeqCst)),
                |number, _| if number == 22 { Err(no(4)) } else { Ok(()) },
            );
            assert_eq!(outcome.unwrap_err().to_string(), "frame 4");
            assert!(begun.into_inner() < 4 + in_flight);
        });
    }

    struct Stopped(AtomicBool);

    impl Observer for Stopped {
        fn cancelled(&self) -> bool {
            self.0.load(Ordering::SeqCst)
        }
    }

    #[test]
    fn an_interruption_keeps_every_frame_that_was_begun() {
        every_crew(|farm, in_flight| {
            let (frames, stopped) = (frames(), Stopped(AtomicBool::new(false)));
            let (begun, mut taken) = (AtomicUsize::new(0), 0);
            let outcome = farm.fly(
                &batch(&frames, in_flight, &stopped),
                |farm, &index| {
                    begun.fetch_add(1, Ordering::SeqCst);
                    stopped.0.fetch_or(index == 5, Ordering::SeqCst);
                    render(farm, index)
                },
                |_, _| {
                    taken += 1;
                    Ok(())
                },
            );

            assert!(matches!(outcome, Err(Error::Interrupted(_))));
            assert_eq!(taken, begun.into_inner());
            assert!((6..6 + in_flight).contains(&taken));
        });
    }

    #[test]
    fn a_panic_anywhere_reaches_the_caller() {
        every_crew(|farm, in_flight| {
            let frames = frames();
            let all = batch(&frames, in_flight, &Silent);
            let render = |farm: &Farm, index: usize| {
                farm.each(Stage::March, vec![(); 9], |_, ()| {
                    assert_ne!(index, 6);
                    Ok(())
                })
            };
            let rendering = catch_unwind(AssertUnwindSafe(|| {
                farm.fly(&all, |farm, &index| render(farm, index), |_, ()| Ok(()))
            }));
            assert!(rendering.is_err());

            let taking = catch_unwind(AssertUnwindSafe(|| {
                farm.fly(
                    &all,
                    |_, &index| Ok(index),
                    |_, index| {
                        assert_ne!(index, 3);
                        Ok(())
                    },
                )
            }));

            assert!(taking.is_err());
        });
    }

    #[test]
    fn no_frames_are_no_work() {
        every_crew(|farm, in_flight| {
            farm.fly(&batch(&[], in_flight, &Silent), |_, _| Ok(()), |_, ()| Err(no(0))).unwrap();
        });
    }

    #[test]
    fn the_next_frame_begins_before_the_last_task_of_one_has_ended() {
        let trace = Arc::new(Trace::new(3));
        let farm = Farm::new(3).unwrap().with_trace(&trace);
        let frames = frames();

        // The last task of a frame waits for the next frame to begin: it ends only if that
        // happens, or when so much time has passed that the assertion below should fail.
        let patience = Duration::from_secs(30);
        let begun = (Mutex::new([false; 7]), Condvar::new());
        begun.0.lock().unwrap()[6] = true;

        let render = |farm: &Farm, frame: usize| {
            Stage::ALL.into_iter().try_for_each(|stage| {
                farm.each(stage, (0..10).collect(), |_, task| {
                    let mut flags = begun.0.lock().unwrap();
                    flags[frame] = true;
                    begun.1.notify_all();
                    if stage == Stage::ALL[Stage::ALL.len() - 1] && task == 9 {
                        drop(begun.1.wait_timeout_while(flags, patience, |flags| !flags[frame + 1]));
                    }
                    Ok(())
                })
            })
        };

        farm.fly(&batch(&frames[..6], 2, &Silent), |farm, &index| render(farm, index), |_, ()| Ok(()))
            .unwrap();
        let spans = trace.frames();
        assert_eq!(spans.len(), 6);
        assert!(spans.iter().all(|span| span.driver < 2));
        let tasks = trace.tasks();

        for pair in frames[..6].windows(2) {
            let ended = tasks.iter().filter(|task| task.frame == pair[0].0).map(|task| task.end).max();
            let begun = tasks.iter().filter(|task| task.frame == pair[1].0).map(|task| task.start).min();
            assert!(begun < ended, "{pair:?}");
        }
    }
}
