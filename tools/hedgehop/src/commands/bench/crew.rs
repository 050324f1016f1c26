//! Numbers of workers, and what each was measured to do.

use std::sync::Arc;
use std::time::Duration;

use super::frames::FrameTimes;
use crate::args;
use crate::commands::bench::flags::BenchArgs;
use hedgehop::Result;
use hedgehop::memory::Paging;
use hedgehop::render::StageTimes;
use hedgehop::subimage::{Farm, NamedTrace, Trace, chrome_trace};

/// One timed pass over all frames.
pub(super) struct Pass {
    pub wall: Duration,
    pub stages: StageTimes,
    /// Empty where frames overlap: none is measured alone then.
    pub frames: Vec<FrameTimes>,
    pub trace: Arc<Trace>,
    pub paging: Paging,
}

/// A number of workers, and what it was measured to do.
pub(super) struct Crew {
    pub farm: Farm,
    pub in_flight: usize,
    /// Whether it was asked for; one worker is measured in any case, to predict others from.
    pub is_listed: bool,
    pub passes: Vec<Pass>,
}

/// The numbers of workers that were asked for, rising, and always one.
pub(super) fn crews(args: &BenchArgs) -> Result<Vec<Crew>> {
    let asked = if args.workers.is_empty() { default_workers() } else { args.workers.clone() };
    let mut counts = asked.clone();
    counts.push(1);
    counts.sort_unstable();
    counts.dedup();
    let crew = |workers| {
        let farm = Farm::new(workers)?;
        let farm = args.task_size.map_or(farm.clone(), |task_size| farm.with_task_size(task_size));
        let in_flight = farm.in_flight(args.overlap.in_flight);
        Ok(Crew { farm, in_flight, is_listed: asked.contains(&workers), passes: Vec::new() })
    };
    counts.into_iter().map(crew).collect()
}

/// The last pass of every number of workers.
pub(super) fn last_passes(crews: &[Crew]) -> serde_json::Value {
    let name =
        |crew: &Crew| format!("workers: {}, frames in flight: {}", crew.farm.workers(), crew.in_flight);
    let runs: Vec<_> = crews
        .iter()
        .filter_map(|crew| Some(NamedTrace { name: name(crew), trace: &crew.passes.last()?.trace }))
        .collect();
    chrome_trace(&runs)
}

/// 1, 2, 4, … and the number of cores.
fn default_workers() -> Vec<usize> {
    let cores = args::available_cores();
    let mut counts: Vec<usize> =
        std::iter::successors(Some(1_usize), |n| n.checked_mul(2)).take_while(|&n| n < cores).collect();
    counts.push(cores);
    counts
}
