//! Predicted speed of other numbers of workers, beside those that were measured.

use serde::Serialize;

use hedgehop::subimage::{FrameWork, makespan};

/// Workers up to which speed-up is predicted.
const MOST_WORKERS: usize = 256;

/// Prediction for one number of workers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedUp {
    /// Worker threads.
    pub workers: usize,
    /// Frames in flight.
    pub in_flight: usize,
    /// Time per frame, milliseconds.
    pub predicted_frame_ms: f64,
    /// Speed against one worker.
    pub predicted: f64,
    /// Speed against one worker, where this number of workers was measured.
    pub measured: Option<f64>,
    /// Excess of the prediction over the measurement, percent.
    pub error_percent: Option<f64>,
}

/// Measured speed of one number of workers.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredSpeed {
    /// Worker threads.
    pub workers: usize,
    /// Frames per second.
    pub frames_per_s: f64,
}

/// Speed-up for 1, 2, 4, … workers and for those that were measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prediction {
    /// Part of a frame, on one worker, that lies outside of tasks, 0…1.
    pub serial_share: f64,
    /// Rising numbers of workers.
    pub speed_up: Vec<SpeedUp>,
}

impl Prediction {
    /// Replays `frames`, as one worker did them, with other numbers of workers that have `in_flight` frames in flight.
    /// More workers than `cores` share them, and are not what is predicted.
    pub fn new(frames: &[FrameWork], in_flight: usize, measured: &[MeasuredSpeed], cores: usize) -> Self {
        let mut counts: Vec<usize> = std::iter::successors(Some(1), |n| Some(n * 2))
            .take_while(|&n| n <= MOST_WORKERS)
            .chain(measured.iter().map(|speed| speed.workers))
            .collect();
        counts.sort_unstable();
        counts.dedup();
        let rate =
            |workers| measured.iter().find(|speed| speed.workers == workers).map(|speed| speed.frames_per_s);
        let one = makespan(frames, 1, 1).as_secs_f64();

        let speed_up = |workers| {
            // One worker never has a second frame, as in the farm.
            let in_flight = if workers == 1 { 1 } else { in_flight };
            let seconds = makespan(frames, workers, in_flight).as_secs_f64();
            let predicted = one / seconds;
            let measured = rate(workers).zip(rate(1)).map(|(rate, one)| rate / one);

            SpeedUp {
                workers,
                in_flight,
                predicted_frame_ms: seconds * 1000.0 / frames.len() as f64,
                predicted,
                measured,
                error_percent: measured
                    .filter(|_| workers <= cores)
                    .map(|measured| (predicted / measured - 1.0) * 100.0),
            }
        };

        let serial: f64 = frames.iter().map(|frame| frame.serial.as_secs_f64()).sum();
        Self { serial_share: serial / one, speed_up: counts.into_iter().map(speed_up).collect() }
    }

    /// Formats the prediction for people.
    pub fn table(&self) -> String {
        let mut text = String::from("\nspeed-up      predicted  measured   error\n");
        for line in &self.speed_up {
            let measured = line.measured.map_or_else(|| "-".into(), |measured| format!("{measured:.2}"));
            let error = line.error_percent.map_or_else(|| "-".into(), |error| format!("{error:+.1} %"));
            text +=
                &format!("{:>4} workers  {:>9.2}  {measured:>8}  {error:>6}\n", line.workers, line.predicted);
        }
        let in_flight = self.speed_up.iter().map(|line| line.in_flight).max().unwrap_or(1);
        text += &format!(
            "\npredicted: the tasks of one worker, shared out among so many workers that help each other, {in_flight} frames in\n\
             flight, and {:.1} % of a frame that no worker shares; caches, memory bandwidth and clock rates are not predicted\n",
            self.serial_share * 100.0
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_prediction_stands_beside_what_was_measured() {
        let ms = Duration::from_millis;
        let frame = FrameWork { serial: ms(10), stages: vec![vec![ms(1); 45], vec![ms(1); 45]] };
        let measured =
            [(1, 10.0), (3, 24.0)].map(|(workers, frames_per_s)| MeasuredSpeed { workers, frames_per_s });
        let prediction = Prediction::new(&vec![frame; 4], 1, &measured, 8);
        assert!((prediction.serial_share - 0.1).abs() < 1e-9);
        let workers: Vec<_> = prediction.speed_up.iter().map(|line| line.workers).collect();
        assert_eq!(workers, [1, 2, 3, 4, 8, 16, 32, 64, 128, 256]);
        let three = &prediction.speed_up[2];
        assert!((three.predicted - 2.5).abs() < 1e-9 && (three.predicted_frame_ms - 40.0).abs() < 1e-9);
        assert_eq!(three.measured, Some(2.4));
        assert!((three.error_percent.unwrap() - 100.0 / 24.0).abs() < 1e-9);
        assert_eq!(prediction.speed_up[1].measured, None);
        let table = prediction.table();
        assert!(table.contains("   3 workers       2.50      2.40  +4.2 %\n"), "{table}");
        assert!(table.contains("   2 workers       1.79         -       -\n"), "{table}");
    }
}
