//! `hedgehop farm status`: how far a job is.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::SystemTime;

use serde::Serialize;

use super::request;
use super::standing::{standing, unfinished};
use crate::exit::{self, Failure, Outcome};
use crate::farm::chunk_lock::is_locked;
use crate::farm::job::FarmJob;
use crate::farm::parts::ChunkState;
use crate::frame_ranges::ranges;
use hedgehop::Result;

/// Say how far a job is, by its files alone.
#[derive(Debug, clap::Args)]
pub struct StatusArgs {
    /// Folder of the job
    #[arg(value_name = "FRAMES.job")]
    job: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Whether somebody is at a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum ChunkStage {
    /// All of its frames are there.
    Done,
    /// A worker holds it.
    Running,
    /// The last try ended with a failure.
    Failed,
    /// The last try was asked to stop.
    Stopped,
    /// Frames that were finished are gone.
    Lost,
    /// A try began and never told its end, and nobody is known to be at it: it was killed, or runs where locks are not seen.
    Open,
    /// Nobody has begun it.
    Waiting,
}

/// A chunk, and how far it is.
#[derive(Debug, Serialize)]
struct ChunkReport {
    chunk: u64,
    stage: ChunkStage,
    frames: u64,
    finished: u64,
    tries: usize,
    /// Frames that are missing, as `--frames` takes them.
    missing: String,
    failure: Option<String>,
    predicted_s: f64,
    /// Time since the last record, seconds; null if there is none.
    silent_s: Option<f64>,
}

/// Progress of a job.
#[derive(Debug, Serialize)]
struct JobReport {
    job: String,
    frames: u64,
    finished: u64,
    /// Time of a process that the frames which are missing take, as predicted, seconds; null without a prediction.
    left_s: Option<f64>,
    chunks: Vec<ChunkReport>,
}

/// Runs the command.
pub fn run(args: &StatusArgs) -> Outcome {
    let job = FarmJob::read(&args.job)?;
    let report = report(&job, args)?;
    let text = if args.json {
        let json = serde_json::to_value(&report).map_err(|error| Failure::Unforeseen(error.to_string()))?;
        format!("{json:#}\n")
    } else {
        report.text()
    };
    Ok(exit::print(&text)?)
}

fn report(job: &FarmJob, args: &StatusArgs) -> Result<JobReport> {
    let states = standing(job, &request::of_job(job)?, &args.job)?;
    let mut chunks = Vec::new();
    for ((number, state), chunk) in (1..).zip(&states).zip(&job.chunks) {
        let missing = unfinished(job, chunk, state)?;
        let stage = match (missing.is_empty(), state) {
            (true, _) => ChunkStage::Done,
            (false, _) if is_locked(&args.job, number) => ChunkStage::Running,
            (false, ChunkState { tries: 0, .. }) => ChunkStage::Waiting,
            (false, ChunkState { is_stopped: true, .. }) => ChunkStage::Stopped,
            (false, ChunkState { failure: Some(_), .. }) => ChunkStage::Failed,
            (false, ChunkState { open: 0, .. }) => ChunkStage::Lost,
            (false, _) => ChunkStage::Open,
        };

        let silent = state.touched.and_then(|time| SystemTime::now().duration_since(time).ok());
        chunks.push(ChunkReport {
            chunk: number,
            stage,
            frames: chunk.count,
            finished: chunk.count.saturating_sub(missing.len() as u64),
            tries: state.tries,
            missing: ranges(&missing),
            failure: state.failure.clone(),
            predicted_s: chunk.predicted_s,
            silent_s: silent.map(|time| time.as_secs_f64()),
        });
    }

    let left = |chunk: &ChunkReport| {
        chunk.predicted_s * (chunk.frames - chunk.finished) as f64 / chunk.frames.max(1) as f64
    };
    Ok(JobReport {
        job: args.job.display().to_string(),
        frames: chunks.iter().map(|chunk| chunk.frames).sum(),
        finished: chunks.iter().map(|chunk| chunk.finished).sum(),
        left_s: (!job.cost.samples.is_empty()).then(|| chunks.iter().map(left).sum()),
        chunks,
    })
}

impl JobReport {
    fn text(&self) -> String {
        let count = |stage| self.chunks.iter().filter(|chunk| chunk.stage == stage).count();
        let mut text = format!(
            "{}: {} of {} frames; {} chunks: {} done, {} running, {} failed, {} stopped, {} open, {} lost, {} waiting{}\n",
            self.job,
            self.finished,
            self.frames,
            self.chunks.len(),
            count(ChunkStage::Done),
            count(ChunkStage::Running),
            count(ChunkStage::Failed),
            count(ChunkStage::Stopped),
            count(ChunkStage::Open),
            count(ChunkStage::Lost),
            count(ChunkStage::Waiting),
            self.left_s.map_or_else(String::new, |left| format!("; {left:.0} s of one process left"))
        );

        // A line of each chunk that is neither done nor waiting.
        for chunk in
            self.chunks.iter().filter(|chunk| !matches!(chunk.stage, ChunkStage::Done | ChunkStage::Waiting))
        {
            let said = match (chunk.stage, &chunk.failure, chunk.silent_s) {
                (ChunkStage::Failed, Some(failure), _) => format!("failed: {failure}"),
                (ChunkStage::Open, _, Some(seconds)) => format!("begun, and silent for {seconds:.0} s"),
                (ChunkStage::Open, _, None) => "begun".to_owned(),
                (ChunkStage::Stopped, ..) => "stopped".to_owned(),
                (ChunkStage::Lost, ..) => "finished before, and lost since".to_owned(),
                _ => "running".to_owned(),
            };
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "  chunk {}: {} of {} frames, lacks {}, {said}",
                chunk.chunk, chunk.finished, chunk.frames, chunk.missing
            );
        }
        text
    }
}
