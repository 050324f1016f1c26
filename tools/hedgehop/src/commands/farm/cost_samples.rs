//! Sample frames, rendered to see what frames of a flight cost on this machine.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::commands::render::{RenderArgs, Survey, fly};
use crate::farm::cost::{CostSample, FrameLoad, least_known};
use crate::frame_ranges::ranges;
use crate::progress::{Mode, Reporter};
use hedgehop::encode::sidecar::{FrameCost, Manifest};
use hedgehop::encode::{FramePattern, FrameSet};
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Frames in a row at each place: the first waits for its pages, those behind it still take memory from the system that later ones
/// have again, and the last ones tell what a frame costs.
const IN_A_ROW: usize = 6;
/// Frames at the end of a row that tell so.
const SETTLED: usize = 3;
/// A place stands for so many frames, if the number of places allows.
const FRAMES_A_PLACE: usize = 40;
/// Places, at least and at most, unless the user says how many.
const FEWEST: usize = 9;
const MOST: usize = 40;

/// Samples of a flight, and what its frames are made of.
#[derive(Debug)]
pub struct CostSamples {
    /// Measurements, in the order of frames.
    pub samples: Vec<CostSample>,
    /// Manifest of the frames, without any.
    pub made_of: Manifest,
}

/// Returns how many places of a flight of `frames` are sampled unless the user says so.
pub fn usual_places(frames: usize) -> usize {
    (frames / FRAMES_A_PLACE).clamp(FEWEST, MOST)
}

/// Renders frames at `places` places of a flight into a folder that is removed again, as a worker would; at least one.
///
/// `flags` gives the flags of the render anew.
///
/// # Errors
/// Whatever keeps these frames from being rendered.
pub fn take(
    flags: &dyn Fn() -> Result<RenderArgs>,
    Survey { numbers, loads }: &Survey,
    places: usize,
    reporter: &Reporter,
) -> Result<CostSamples> {
    let folder = tempfile::tempdir()
        .map_err(|error| Error::io(std::env::temp_dir(), "make a folder for sample frames in it", error))?;
    let silent = reporter.with_mode(Mode::Silent);
    let places = places.clamp(1, numbers.len().max(1));
    let mut samples: Vec<CostSample> = Vec::new();
    let mut made_of = None;

    reporter.begin("sample", places as u64, "places");
    for place in 0..places {
        let Some(index) = next_place(place, places, loads, &samples) else { break };
        let args = flags()?;
        let workers = args.workers.count();
        let row = &numbers[index..numbers.len().min(index + IN_A_ROW)];
        let (manifest, seconds) = render_row(args, row, &folder.path().join(place.to_string()), &silent)?;
        let costs = manifest.frames.iter().filter_map(|frame| frame.cost).collect();
        samples.push(MeasuredRow { index, seconds, costs }.sample(workers));
        samples.sort_by_key(|sample| sample.index);
        made_of.get_or_insert(manifest.without_frames());
        reporter.advance(1);
    }
    reporter.end();

    let made_of = made_of.ok_or_else(|| Error::Configuration("there is no frame to render".into()))?;
    Ok(CostSamples { samples, made_of })
}

/// Returns the first frame of the next place: half of them lie evenly along the flight, the others where least is known.
fn next_place(place: usize, places: usize, loads: &[FrameLoad], samples: &[CostSample]) -> Option<usize> {
    let even = places.div_ceil(2);
    let middle =
        if place < even { (2 * place + 1) * loads.len() / (2 * even) } else { least_known(loads, samples)? };
    let first = middle.saturating_sub(IN_A_ROW / 2).min(loads.len().saturating_sub(IN_A_ROW));
    // Two rows may overlap, but not be the same.
    let is_free = |index: &usize| samples.iter().all(|sample| sample.index != *index);
    [first, middle].into_iter().find(is_free)
}

/// Renders frames into `folder`; returns their manifest, and the time that passed, seconds.
fn render_row(
    mut args: RenderArgs,
    numbers: &[u64],
    folder: &Path,
    silent: &Reporter,
) -> Result<(Manifest, f64)> {
    let list = ranges(numbers);
    let ending = match args.output.as_ref().map(|output| output.path(1)) {
        Some(path) => path.extension().map(|kind| kind.to_string_lossy().into_owned()),
        None => None,
    };
    let ending = ending.unwrap_or_else(|| "png".to_owned());
    let pattern = folder.join(format!("####.{ending}"));

    args.frames = Some(FrameSet::parse(&list)?);
    args.output = Some(FramePattern::parse(&pattern.to_string_lossy())?);
    args.film.video = None;
    args.skip_existing = false;
    args.traffic = None;
    // Frames that overlap share the processor time between two deliveries.
    args.overlap.in_flight = Some(1);

    let begun = Instant::now();
    fly(&args, args.cache.open_trusting(&args.area, args.trust.trust())?, silent)?;
    let seconds = begun.elapsed().as_secs_f64();
    let manifest = Manifest::read(folder)?;
    let manifest = manifest.ok_or_else(|| Error::invalid(folder, "no manifest of sample frames"))?;
    Ok((manifest, seconds))
}

/// Frames of one place, in the order in which they were rendered.
#[derive(Debug)]
struct MeasuredRow {
    /// Index of the first among all.
    index: usize,
    /// Time that passed in all, seconds.
    seconds: f64,
    /// Cost of each.
    costs: Vec<FrameCost>,
}

impl MeasuredRow {
    /// Reads off what frames cost a process of so many workers whose cores are its own.
    ///
    /// Other programs take time from some frames and not from others, but processor time from none.
    fn sample(&self, workers: usize) -> CostSample {
        let time = |cost: &FrameCost| cost.cpu_s.map_or(cost.wall_s, |cpu| cpu / workers as f64);
        let waited = |cost: &FrameCost| {
            cost.paging.map_or(0.0, |paging| Duration::from_nanos(paging.frame_wait_ns).as_secs_f64())
        };

        let first_s = self.costs.first().map_or(self.seconds, |cost| time(cost) + waited(cost));
        let settled = self.costs.len().saturating_sub(SETTLED).max(1);
        let later: Vec<f64> = self.costs.iter().skip(settled).map(time).collect();
        let wall: f64 = self.costs.iter().map(|cost| cost.wall_s).sum();
        CostSample {
            index: self.index,
            start_s: (self.seconds - wall).max(0.0),
            first_s,
            frame_s: if later.is_empty() { first_s } else { later.iter().sum::<f64>() / later.len() as f64 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processor_time_is_the_measure_where_it_is_known() {
        let cost = |wall_s: f64, cpu_s| FrameCost { wall_s, cpu_s, paging: None };
        let row = |costs| MeasuredRow { index: 5, seconds: 3.0, costs };
        let frames = [(1.0, 1.0), (0.75, 0.5), (0.25, 0.5)];
        let disturbed = row(frames.map(|(wall, cpu)| cost(wall, Some(cpu))).to_vec()).sample(2);
        assert_eq!((disturbed.first_s, disturbed.frame_s, disturbed.start_s), (0.5, 0.25, 1.0));
        let by_clock = row(frames.map(|(wall, _)| cost(wall, None)).to_vec()).sample(2);
        assert_eq!((by_clock.first_s, by_clock.frame_s), (1.0, 0.5));
        let settling =
            row([1.0, 0.75, 0.5, 0.25, 0.25, 0.25].map(|wall| cost(wall, None)).to_vec()).sample(1);
        assert_eq!((settling.first_s, settling.frame_s), (1.0, 0.25));
        let single = row(vec![cost(0.5, None)]).sample(1);
        assert_eq!((single.first_s, single.frame_s), (0.5, 0.5));
    }

    #[test]
    fn places_are_all_different() {
        let loads = vec![FrameLoad { mrays: 1.0, ..FrameLoad::default() }; 12];
        let mut samples: Vec<CostSample> = Vec::new();
        for place in 0..9 {
            let index = next_place(place, 9, &loads, &samples).unwrap();
            samples.push(CostSample { index, start_s: 0.0, first_s: 1.0, frame_s: 1.0 });
            samples.sort_by_key(|sample| sample.index);
        }
        assert!(samples.windows(2).all(|pair| pair[0].index < pair[1].index), "{samples:?}");
        assert_eq!(next_place(0, 1, &loads[..2], &[]), Some(0));
    }
}
