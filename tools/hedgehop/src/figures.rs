//! Figures of `bench`: what it prints, writes as JSON and plots.

use serde::Serialize;

use crate::args::EngineName;
use crate::speedup::Prediction;
use hedgehop::memory::Paging;

/// Measurements of one number of workers; medians over the repeats.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Worker threads.
    pub workers: usize,
    /// Frames that were rendered at once.
    pub in_flight: usize,
    /// Frames per second of wall time, without encoding.
    pub frames_per_s: f64,
    /// Million pixels per second of wall time, without encoding.
    pub mpixel_per_s: f64,
    /// Speed per worker against the smallest number of workers, 0…1.
    pub efficiency: f64,
    /// Marching, milliseconds per frame, summed over workers.
    pub march_ms: f64,
    /// Shading, milliseconds per frame, summed over workers.
    pub shade_ms: f64,
    /// Haze and sky of the reference, milliseconds of wall time per frame; scan planes have them in `shade_ms`.
    pub image_ms: f64,
    /// PNG encoding to memory, milliseconds per frame, one thread.
    pub encode_ms: f64,
    /// Cost of paging in the last pass.
    pub paging: Paging,
    /// Every frame in its fastest pass; empty where frames overlap (`in_flight` > 1).
    pub fastest_passes: Vec<FrameFigures>,
}

/// One frame in the pass in which it took the least wall time, without encoding.
#[derive(Debug, Clone, Serialize)]
pub struct FrameFigures {
    /// Number of the frame.
    pub frame: u64,
    /// Wall time, milliseconds.
    pub wall_ms: f64,
    /// CPU time of all threads, milliseconds; null where the system does not tell.
    pub cpu_ms: Option<f64>,
    /// Marching, milliseconds, summed over workers.
    pub march_ms: f64,
    /// Shading, milliseconds, summed over workers.
    pub shade_ms: f64,
    /// Haze and sky of the reference, milliseconds of wall time; scan planes have them in `shade_ms`.
    pub image_ms: f64,
}

/// Everything that was measured.
#[derive(Debug, Clone, Serialize)]
pub struct BenchReport {
    /// Version of the program.
    pub hedgehop: &'static str,
    /// Cores that this process may use.
    pub cores: usize,
    /// Engine that marches.
    pub engine: EngineName,
    /// Vector instructions of scan planes; null of the reference.
    pub simd: Option<&'static str>,
    /// Frames that the reference renders: all of them, or those that scan planes do not serve.
    pub frames_by_reference: usize,
    /// Database.
    pub area: String,
    /// Identity of the database.
    pub content_hash: String,
    /// Pixels per row and rows.
    pub size: [u32; 2],
    /// Frames in a pass.
    pub frames: Vec<u64>,
    /// Timed passes.
    pub repeats: u32,
    /// All numbers of workers gave the same frames, bit by bit.
    pub identical_frames: bool,
    /// One entry per number of workers, rising.
    pub results: Vec<Figures>,
    /// Prediction for other numbers of workers.
    pub prediction: Prediction,
}

impl BenchReport {
    /// Engine and instructions, for people.
    pub fn marcher(&self) -> String {
        match (self.simd, self.frames_by_reference) {
            (None, _) => "reference engine".into(),
            (Some(simd), 0) => format!("planes on {simd}"),
            (Some(simd), frames) => format!("planes on {simd}, {frames} by the reference"),
        }
    }
}
