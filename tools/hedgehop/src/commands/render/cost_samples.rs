//! Sample frames, rendered to see what frames of a flight cost on this machine.

use std::path::Path;
use std::time::Instant;

use super::{RenderArgs, fly};
use crate::farm::cost::CostSample;
use crate::frame_ranges::ranges;
use crate::progress::{Mode, Reporter};
use hedgehop::encode::sidecar::Manifest;
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
    let mut samples = Vec::new();
    let mut made_of = None;

    reporter.begin("sample", places as u64, "places");
    for place in 0..places {
        let middle = (2 * place + 1) * numbers.len() / (2 * places);
        let index = middle.saturating_sub(IN_A_ROW / 2).min(numbers.len().saturating_sub(IN_A_ROW));
        let row = &numbers[index..numbers.len().min(index + IN_A_ROW)];
        let (manifest, seconds) = render_row(flags()?, row, &folder.path().join(place.to_string()), &silent)?;
        samples.push(sample(index, seconds, &manifest));
        made_of.get_or_insert(manifest.without_frames());
        reporter.advance(1);
    }
    reporter.end();

    let made_of = made_of.ok_or_else(|| Error::Configuration("there is no frame to render".into()))?;
    Ok(CostSamples { samples, made_of })
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

/// Reads off what frames cost that took `seconds` in all.
fn sample(index: usize, seconds: f64, manifest: &Manifest) -> CostSample {
    let walls: Vec<f64> =
        manifest.frames.iter().filter_map(|frame| Some(frame.cost.as_ref()?.wall_s)).collect();
    let first_s = walls.first().copied().unwrap_or(seconds);
    let mut later: Vec<f64> = walls.iter().skip(1).copied().collect();
    later.sort_by(f64::total_cmp);
    let frame_s = later.get(later.len() / 2).copied().unwrap_or(first_s);
    let start_s = (seconds - walls.iter().sum::<f64>()).max(0.0);
    CostSample { index, start_s, first_s, frame_s }
}
