//! Traces in Chrome's trace event format, which Perfetto and `chrome://tracing` open.
//!
//! Each run is a process, each worker and each driver a thread. A task or a frame is a complete event ("X"): `ts` and
//! `dur` in microseconds, as decimal fractions down to the nanosecond; `args` tell frame, stage and task.
//! Names of processes and threads are metadata events ("M"). (Google, "Trace Event Format", 2016.)

use std::time::Duration;

use serde::Serialize;
use serde_json::{Value, json};

use super::trace::{FrameSpan, TaskSpan, Trace};

/// A complete event.
#[derive(Serialize)]
struct Event {
    name: String,
    cat: &'static str,
    ph: &'static str,
    ts: f64,
    dur: f64,
    pid: usize,
    tid: usize,
    args: Value,
}

/// Trace of a run, and how the run is called.
#[derive(Debug, Clone)]
pub struct NamedTrace<'t> {
    /// Name of the run.
    pub name: String,
    /// Begin and end of each of its tasks.
    pub trace: &'t Trace,
}

/// Draws runs as one JSON object.
pub fn chrome_trace(runs: &[NamedTrace<'_>]) -> Value {
    let mut events = Vec::new();
    for (pid, NamedTrace { name, trace }) in (1..).zip(runs) {
        let frames = trace.frames();
        let drivers = frames.iter().map(|frame| frame.driver + 1).max().unwrap_or(0);
        events.push(named("process_name", pid, 0, name.clone()));
        events.extend(
            (0..trace.workers()).map(|worker| named("thread_name", pid, worker, format!("worker {worker}"))),
        );
        events.extend((0..drivers).map(|driver| {
            named("thread_name", pid, trace.workers() + driver, format!("frames, driver {driver}"))
        }));
        events.extend(trace.tasks().iter().map(|task| json!(task_event(pid, task))));
        events.extend(frames.iter().map(|frame| json!(frame_event(pid, trace.workers(), frame))));
    }
    json!({ "displayTimeUnit": "ms", "traceEvents": events })
}

fn named(what: &str, pid: usize, tid: usize, name: String) -> Value {
    json!({ "name": what, "ph": "M", "pid": pid, "tid": tid, "args": { "name": name } })
}

fn task_event(pid: usize, task: &TaskSpan) -> Event {
    let stage = task.stage.name();
    Event {
        name: stage.to_owned(),
        cat: "task",
        ph: "X",
        ts: microseconds(task.start),
        dur: microseconds(task.end - task.start),
        pid,
        tid: task.worker,
        args: json!({ "frame": task.frame, "stage": stage, "task": task.task }),
    }
}

/// Drivers are the threads behind the workers.
fn frame_event(pid: usize, workers: usize, frame: &FrameSpan) -> Event {
    Event {
        name: format!("frame {}", frame.frame),
        cat: "frame",
        ph: "X",
        ts: microseconds(frame.start),
        dur: microseconds(frame.end - frame.start),
        pid,
        tid: workers + frame.driver,
        args: json!({ "frame": frame.frame }),
    }
}

fn microseconds(time: Duration) -> f64 {
    time.as_nanos() as f64 / 1000.0
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use super::*;
    use crate::subimage::{Batch, Farm, Stage};
    use hedgehop_base::progress::Silent;

    #[test]
    fn what_is_written_reads_back_and_no_thread_does_two_things_at_a_time() {
        let trace = Arc::new(Trace::new(3));
        let farm = Farm::new(3).unwrap().with_trace(&trace);
        let frames: Vec<_> = (1..=8).map(|number| (number, ())).collect();

        let render = |farm: &Farm, (): &()| {
            Stage::ALL.into_iter().try_for_each(|stage| {
                farm.each(stage, (0..12).collect(), |_, task| {
                    std::thread::sleep(Duration::from_micros(50 + 7 * task));
                    Ok(())
                })
            })
        };

        farm.fly(&Batch { frames: &frames, in_flight: 2, observer: &Silent }, render, |_, ()| Ok(()))
            .unwrap();

        let runs = ["three workers", "again"].map(|name| NamedTrace { name: name.into(), trace: &trace });
        let text = chrome_trace(&runs).to_string();
        let read: Value = serde_json::from_str(&text).unwrap();
        let events = read["traceEvents"].as_array().unwrap();
        let of = |phase: &str, pid: u64| -> Vec<&Value> {
            events.iter().filter(|event| event["ph"] == phase && event["pid"] == pid).collect()
        };

        for pid in [1, 2] {
            let names: Vec<_> =
                of("M", pid).iter().map(|event| event["args"]["name"].as_str().unwrap()).collect();
            assert_eq!(names[1..5], ["worker 0", "worker 1", "worker 2", "frames, driver 0"]);
            let complete = of("X", pid);
            assert_eq!(complete.len(), 8 * (2 * 12 + 1));
            let tasks = complete.iter().filter(|event| event["args"]["stage"] == "image");
            assert_eq!(tasks.filter(|event| event["args"]["frame"] == 5).count(), 12);
            let mut threads: BTreeMap<u64, Vec<(u64, u64)>> = BTreeMap::new();

            for event in complete {
                // Nanoseconds are exact again once they are whole.
                let [start, duration] =
                    ["ts", "dur"].map(|key| (event[key].as_f64().unwrap() * 1000.0).round() as u64);
                threads.entry(event["tid"].as_u64().unwrap()).or_default().push((start, start + duration));
            }

            assert!(threads.len() >= 4);
            for (thread, mut spans) in threads {
                spans.sort_unstable();
                assert!(spans.windows(2).all(|pair| pair[0].1 <= pair[1].0), "thread {thread}: {spans:?}");
            }
        }
    }
}
