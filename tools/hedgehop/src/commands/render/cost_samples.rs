//! Sample frames, rendered to see what frames of a flight cost on this machine.

use std::path::Path;
use std::time::{Duration, Instant};

use super::{RenderArgs, fly};
use crate::farm::cost::CostSample;
use crate::frame_ranges::ranges;
use crate::progress::{Mode, Reporter};
use hedgehop::encode::sidecar::{FrameCost, Manifest};
use hedgehop::encode::{FramePattern, FrameSet};
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::{Error, Result};

/// Frames in a row at each place: the first waits for its pages, and the others tell what a frame costs.
const IN_A_ROW: usize = 4;
/// A place stands for so many frames, if the number of places allows.
const FRAMES_A_PLACE: usize = 40;
/// Places, at least and at most, unless the user says how many.
const FEWEST: usize = 6;
const MOST: usize = 24;

/// Samples of a flight, and what its frames are made of.
#[derive(Debug)]
pub struct CostSamples {
    /// What was measured, in the order of frames.
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
/// `flags` gives the flags of the render anew; `numbers` are all of its frames.
///
/// # Errors
/// Whatever keeps these frames from being rendered.
pub fn take(
    flags: &dyn Fn() -> Result<RenderArgs>,
    numbers: &[u64],
    places: usize,
    reporter: &Reporter,
) -> Result<CostSamples> {
    let folder = tempfile::tempdir()
        .map_err(|error| Error::io(std::env::temp_dir(), "make a folder for sample frames in it", error))?;
    let silent = reporter.with_mode(Mode::Silent);
    let places = places.clamp(1, numbers.len().div_ceil(IN_A_ROW).max(1));
    let mut rows = Vec::new();
    let mut made_of = None;

    reporter.begin("sample", places as u64, "places");
    for place in 0..places {
        let middle = (2 * place + 1) * numbers.len() / (2 * places);
        let index = middle.saturating_sub(IN_A_ROW / 2).min(numbers.len().saturating_sub(IN_A_ROW));
        let row = &numbers[index..numbers.len().min(index + IN_A_ROW)];
        let (manifest, seconds) = render_row(flags()?, row, &folder.path().join(place.to_string()), &silent)?;
        let costs = manifest.frames.iter().filter_map(|frame| frame.cost).collect();
        rows.push(MeasuredRow { index, seconds, costs });
        made_of.get_or_insert(manifest.without_frames());
        reporter.advance(1);
    }
    reporter.end();

    let made_of = made_of.ok_or_else(|| Error::Configuration("there is no frame to render".into()))?;
    Ok(CostSamples { samples: undisturbed(&rows), made_of })
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

    let begun = Instant::now();
    fly(&args, PageFile::open_trusting(&args.area, args.trust.trust())?, silent)?;
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

/// Reads off what frames cost, as if nobody else had used the machine.
///
/// What else runs beside takes time from some frames and not from others, but processor time from none: it is the measure, and how much
/// of it passes in a second is taken from the frame that had most.
fn undisturbed(rows: &[MeasuredRow]) -> Vec<CostSample> {
    let later = |row: &MeasuredRow| row.costs.iter().skip(1).copied().collect::<Vec<_>>();
    let ratio = |cost: &FrameCost| Some(cost.wall_s / cost.cpu_s.filter(|cpu| *cpu > 0.0)?);
    let ratios: Vec<f64> = rows.iter().flat_map(later).filter_map(|cost| ratio(&cost)).collect();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let time = |cost: &FrameCost| match cost.cpu_s {
        Some(cpu) if least.is_finite() => cpu * least,
        _ => cost.wall_s,
    };

    let sample = |row: &MeasuredRow| {
        let waited = |cost: &FrameCost| {
            cost.paging.map_or(0.0, |paging| Duration::from_nanos(paging.frame_wait_ns).as_secs_f64())
        };
        let first_s = row.costs.first().map_or(row.seconds, |cost| time(cost) + waited(cost));
        let times = later(row).iter().map(time).fold(f64::INFINITY, f64::min);
        let wall: f64 = row.costs.iter().map(|cost| cost.wall_s).sum();
        CostSample {
            index: row.index,
            start_s: (row.seconds - wall).max(0.0),
            first_s,
            frame_s: if times.is_finite() { times } else { first_s },
        }
    };
    rows.iter().map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_beside_is_left_out() {
        let cost = |wall_s: f64, cpu: f64| FrameCost { wall_s, cpu_s: Some(cpu), paging: None };
        let row = |index, costs: Vec<FrameCost>| MeasuredRow { index, seconds: 2.0, costs };
        // Two workers: half a second of processor time passes in a quarter. The second place had half of the machine.
        let rows = [
            row(5, vec![cost(0.5, 1.0), cost(0.25, 0.5), cost(0.3, 0.5)]),
            row(90, vec![cost(1.0, 1.0), cost(0.6, 0.6), cost(0.8, 0.7)]),
        ];
        let samples = undisturbed(&rows);
        assert_eq!((samples[0].frame_s, samples[0].first_s), (0.25, 0.5));
        assert_eq!((samples[1].frame_s, samples[1].index), (0.3, 90));
        assert!((samples[0].start_s - 0.95).abs() < 1e-12);
    }

    #[test]
    fn systems_without_processor_time_are_measured_by_the_clock() {
        let costs = vec![FrameCost { wall_s: 0.5, cpu_s: None, paging: None }; 3];
        let samples = undisturbed(&[MeasuredRow { index: 0, seconds: 2.0, costs }]);
        assert_eq!((samples[0].frame_s, samples[0].start_s), (0.5, 0.5));
    }
}
