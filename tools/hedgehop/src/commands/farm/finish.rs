//! `hedgehop farm finish`: what comes after the last chunk.

use std::path::{Path, PathBuf};

use super::request;
use crate::commands::contact_sheet::{self, ContactSheetArgs};
use crate::commands::render;
use crate::exit::{self, Failure, Outcome};
use crate::farm::job::FarmJob;
use crate::farm::parts::ChunkState;
use crate::farm::scheduler::named;
use crate::farm::work::WorkArgs;
use crate::frame_ranges::ranges;
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use hedgehop::encode::sidecar::Manifest;
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
    let states = ChunkState::read_all(place, job.chunks.len())?;
    let mut missing = Vec::new();
    let mut text = String::new();
    for (number, state) in (1..).zip(&states) {
        let frames = unfinished(job, number, place, state)?;
        if !frames.is_empty() {
            let why = state.failure.as_ref().map_or_else(String::new, |failure| format!(": {failure}"));
            text += &format!("problem: chunk {number} lacks frames {}{why}\n", ranges(&frames));
            missing.extend(frames);
        }
    }
    if !missing.is_empty() {
        let is_mended = states.iter().all(|state| state.failure.is_none());
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
        "{}: {} frames, listed in {}\n",
        place.display(),
        manifest.frames.len(),
        job.frames().join(hedgehop::encode::sidecar::MANIFEST).display()
    ))?;

    // Names of films and sheets count from where the job was submitted.
    std::env::set_current_dir(&job.folder)
        .map_err(|error| Error::io(&job.folder, "go into the folder of the job", error))?;
    make_film(job, reporter)?;
    if let Some(sheet) = &job.contact_sheet {
        let frames =
            if job.frames_folder.as_os_str().is_empty() { ".".into() } else { job.frames_folder.clone() };
        let sheet = ContactSheetArgs::of_folder(frames, sheet.clone(), Mode::None);
        contact_sheet::run(&sheet, reporter.interrupt())?;
    }
    Ok(())
}

/// Lists the frames of a job in the manifest beside them, if none is missing.
pub fn list(job: &FarmJob, place: &Path) -> Result<()> {
    let states = ChunkState::read_all(place, job.chunks.len())?;
    for (number, state) in (1..).zip(&states) {
        if !unfinished(job, number, place, state)?.is_empty() {
            return Ok(());
        }
    }
    list_records(job, states).map(drop)
}

fn list_records(job: &FarmJob, states: Vec<ChunkState>) -> Result<Manifest> {
    let mut manifest = job.made_of.clone();
    for (chunk, state) in job.chunks.iter().zip(states) {
        let frames = chunk.set()?;
        manifest.frames.extend(state.records.into_values().filter(|record| frames.contains(record.frame)));
    }
    manifest.write(&job.frames())
}

/// Renders what is missing of a chunk in this process.
pub fn work_off(job: &FarmJob, place: &Path, number: u64, reporter: &Reporter) -> Result<()> {
    let place = place.canonicalize().map_err(|error| Error::io(place, "find it", error))?;
    std::env::set_current_dir(&job.folder)
        .map_err(|error| Error::io(&job.folder, "go into the folder of the job", error))?;
    let mut args = request::parse(&job.worker_flags(), "the flags of the job")?;
    args.work = WorkArgs::of(place, number);
    args.overwrite = true;
    render::fly(&args, args.cache.open_trusting(&args.area, args.trust.trust())?, reporter).map(drop)
}

/// Lists the frames of a chunk that are not finished: they have no record, or no file.
pub fn unfinished(job: &FarmJob, number: u64, place: &Path, state: &ChunkState) -> Result<Vec<u64>> {
    let folder = job.frames();
    let is_there = |number: &u64| {
        let file = state.records.get(number).and_then(|record| record.file.as_ref());
        file.is_some_and(|file| folder.join(file).is_file())
    };
    Ok(job.chunk(number, place)?.set()?.iter().filter(|number| !is_there(number)).collect())
}

/// Makes the film that the flags ask for, if they do: of the frames, which are all there.
fn make_film(job: &FarmJob, reporter: &Reporter) -> Result<()> {
    let args = request::parse(&job.worker_flags(), "the flags of the job")?;
    let Some(film) = &args.film.video else { return Ok(()) };
    render::fly(&args, args.cache.open_trusting(&args.area, args.trust.trust())?, reporter)?;
    exit::print(&format!("wrote the film {}\n", film.display()))
}
