//! `hedgehop farm finish`: what comes after the last chunk.

use std::path::{Path, PathBuf};

use super::request;
use super::standing::{standing, unfinished, unsound};
use crate::commands::contact_sheet::{self, ContactSheetArgs};
use crate::commands::render::{self, RenderArgs};
use crate::exit::{self, Failure, Outcome};
use crate::farm::job::FarmJob;
use crate::farm::parts::ChunkState;
use crate::farm::shell::named;
use crate::farm::work::WorkArgs;
use crate::frame_ranges::ranges;
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use hedgehop::encode::sidecar::{FrameRecord, Manifest};
use hedgehop::encode::video::encode_video;
use hedgehop::{Error, Result};

/// List the frames of a job in one manifest, and make its film and contact sheet.
///
/// Schedulers run this after the last chunk. It ends with 6 and says which frames are missing if there are any.
#[derive(Debug, clap::Args)]
pub struct FinishJobArgs {
    /// Folder of the job
    #[arg(value_name = "FRAMES.job")]
    job: PathBuf,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &FinishJobArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    finish(&FarmJob::read(&args.job)?, &args.job, &reporter)
}

/// Ends a job whose chunks are all done, or says what is missing.
pub fn finish(job: &FarmJob, place: &Path, reporter: &Reporter) -> Outcome {
    let args = request::of_job(job)?;
    let states = standing(job, &args, place)?;
    let wrong = unsound(job, &states, reporter)?;
    let mut missing = Vec::new();
    let mut text = String::new();
    for ((number, state), frames) in (1..).zip(&states).zip(wrong) {
        if !frames.is_empty() {
            let why = state.failure.as_ref().map_or_else(String::new, |failure| format!(": {failure}"));
            text += &format!("problem: chunk {number} lacks frames {}{why}\n", ranges(&frames));
            missing.extend(frames);
        }
    }
    if !missing.is_empty() {
        let is_mended = states.iter().all(|state| state.failure.is_none() || state.is_stopped);
        let first = if is_mended { "" } else { "mend what failed, then " };
        text += &format!(
            "{}: {} frames are missing; {first}hedgehop farm retry {} renders them\n",
            place.display(),
            missing.len(),
            named(place)
        );
        exit::print(&text)?;
        return Err(Failure::Problems);
    }

    let manifest = list_records(job, states)?;
    exit::print(&format!(
        "{}: {} frames, listed in {}{}\n",
        place.display(),
        manifest.frames.len(),
        job.frames().join(hedgehop::encode::sidecar::MANIFEST).display(),
        predicted_and_taken(job, &manifest)
    ))?;

    // Names of films and sheets count from where the job was submitted.
    std::env::set_current_dir(&job.folder)
        .map_err(|error| Error::io(&job.folder, "go into the folder of the job", error))?;
    make_film(&args, &manifest, reporter)?;
    if let Some(sheet) = &job.contact_sheet {
        let frames =
            if job.frames_folder.as_os_str().is_empty() { ".".into() } else { job.frames_folder.clone() };
        let sheet = ContactSheetArgs::of_folder(frames, sheet.clone(), Mode::None);
        contact_sheet::run(&sheet, reporter.interrupt())?;
    }
    Ok(())
}

/// Says how long a process was to take for the frames, and took, behind a sentence; nothing where either is unknown.
fn predicted_and_taken(job: &FarmJob, manifest: &Manifest) -> String {
    let cpu_s = |frame: &FrameRecord| frame.cost.as_ref()?.cpu_s;
    let taken: Option<f64> = manifest.frames.iter().map(cpu_s).sum();
    let starts = job.cost.start_s * job.chunks.len() as f64;
    let predicted: f64 = job.chunks.iter().map(|chunk| chunk.predicted_s).sum::<f64>() - starts;
    match taken.filter(|_| !job.cost.samples.is_empty()) {
        Some(taken) => format!(
            "; predicted {predicted:.1} s of one process, took {:.1} s of its cores",
            taken / job.cores.max(1) as f64
        ),
        None => String::new(),
    }
}

/// Lists the frames of a job in the manifest beside them, if none is missing.
pub fn list(job: &FarmJob, place: &Path) -> Result<()> {
    let states = standing(job, &request::of_job(job)?, place)?;
    for (chunk, state) in job.chunks.iter().zip(&states) {
        if !unfinished(job, chunk, state)?.is_empty() {
            return Ok(());
        }
    }
    list_records(job, states).map(drop)
}

fn list_records(job: &FarmJob, states: Vec<ChunkState>) -> Result<Manifest> {
    let mut manifest = job.made_of.clone();
    manifest.frames = states.into_iter().flat_map(|state| state.records.into_values()).collect();
    manifest.write(&job.frames())
}

/// Renders what is missing of a chunk in this process.
pub fn work_off(job: &FarmJob, place: &Path, number: u64, reporter: &Reporter) -> Result<()> {
    let place = place.canonicalize().map_err(|error| Error::io(place, "find it", error))?;
    std::env::set_current_dir(&job.folder)
        .map_err(|error| Error::io(&job.folder, "go into the folder of the job", error))?;
    let mut args = request::of_job(job)?;
    args.work = WorkArgs::of(place, number);
    args.overwrite = true;
    render::fly(&args, args.cache.open_trusting(&args.area, args.trust.trust())?, reporter).map(drop)
}

/// Makes the film that the flags ask for, if they do, of frames that are all there.
fn make_film(args: &RenderArgs, manifest: &Manifest, reporter: &Reporter) -> Result<()> {
    let Some(film) = args.film.settings(args.fps)? else { return Ok(()) };
    let Some(pattern) = &args.output else { return Ok(()) };
    film.check_length(manifest.frames.len() as u64)?;
    encode_video(manifest.frames.iter().map(|frame| pattern.path(frame.frame)), &film, reporter)?;
    exit::print(&format!("wrote the film {}\n", film.out.display()))
}
