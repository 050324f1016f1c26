//! Work of one process for a job: which frames, and whether this machine may render them.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use super::chunk_lock::lock;
use super::job::{FarmJob, PageCheck, ProgramRecord};
use super::parts::{ChunkState, PartLog, holds};
use crate::args::Instructions;
use crate::sequence::Delivery;
use hedgehop::encode::FrameSet;
use hedgehop::encode::sidecar::{FrameRecord, Manifest};
use hedgehop::memory::{PageFile, PagePlan};
use hedgehop::progress::Observer;
use hedgehop::render::{Engine, FlightPlan, NumberedCamera, Renderer};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{PageId, PagePart};
use hedgehop::{Error, Result};

/// Variables by which schedulers tell a task its number.
const TASK_NUMBERS: [&str; 2] = ["HQ_TASK_ID", "SLURM_ARRAY_TASK_ID"];
/// Variable of a number that is added to the scheduler's, for arrays that begin anew.
const OFFSET: &str = "HEDGEHOP_CHUNK_OFFSET";

/// Flags of a worker.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Farm")]
pub struct WorkArgs {
    /// Render a chunk of this job, as the commands of `farm submit` do: nothing else than what it was submitted for
    #[arg(long, value_name = "FRAMES.job")]
    farm: Option<PathBuf>,

    /// Number of the chunk [default: HQ_TASK_ID, or SLURM_ARRAY_TASK_ID and HEDGEHOP_CHUNK_OFFSET]
    #[arg(long, value_name = "N", requires = "farm")]
    chunk: Option<u64>,
}

/// A chunk that this process works on.
#[derive(Debug)]
pub struct ChunkWork {
    folder: PathBuf,
    job: FarmJob,
    /// Frames of the chunk.
    pub frames: FrameSet,
    /// Frames that are finished, by number.
    finished: BTreeMap<u64, FrameRecord>,
    log: PartLog,
    /// Keeps other workers from the chunk.
    _lock: Option<File>,
}

impl WorkArgs {
    /// Asks for a chunk of the job in `folder`.
    pub fn of(folder: PathBuf, chunk: u64) -> Self {
        Self { farm: Some(folder), chunk: Some(chunk) }
    }

    /// Whether this process works for a job.
    pub fn is_worker(&self) -> bool {
        self.farm.is_some()
    }

    /// Records that this process renders nothing, so that whoever asks how far the job is gets to know why.
    pub fn give_up(&self, why: &Error) {
        let Some(folder) = &self.farm else { return };
        // What went wrong before explains more than that it cannot be recorded.
        let log = self.number().and_then(|number| PartLog::begin(folder, number));
        let _ = log.and_then(|log| log.end(Some(why)));
    }

    fn number(&self) -> Result<u64> {
        match self.chunk {
            Some(number) => Ok(number),
            None => number_of_task(&|name| std::env::var(name).ok()),
        }
    }

    /// Takes the chunk on, if there is one: waits until nobody else is at it, and begins a file of records.
    ///
    /// # Errors
    /// No job, no such chunk; another program or instruction set than the job's.
    pub fn begin(&self, instructions: Instructions, observer: &dyn Observer) -> Result<Option<ChunkWork>> {
        let Some(folder) = &self.farm else { return Ok(None) };
        let job = FarmJob::read(folder)?;
        let number = self.number()?;
        let frames = job.chunk(number, folder)?.set()?;
        if let Err(refusal) = check_program(&job, instructions, folder) {
            self.give_up(&refusal);
            return Err(refusal);
        }
        let lock = lock(folder, number, observer)?;
        Ok(Some(ChunkWork {
            folder: folder.clone(),
            finished: ChunkState::read(folder, number)?.records,
            log: PartLog::begin(folder, number)?,
            job,
            frames,
            _lock: lock,
        }))
    }
}

/// Returns the number of the chunk that a scheduler gives this process.
fn number_of_task(variable: &dyn Fn(&str) -> Option<String>) -> Result<u64> {
    let number = |name: &str| {
        let Some(text) = variable(name).filter(|text| !text.trim().is_empty()) else { return Ok(None) };
        let wrong = |_| Error::Configuration(format!("{name} is {text:?}, which is no number of a chunk"));
        text.trim().parse::<u64>().map(Some).map_err(wrong)
    };

    for name in TASK_NUMBERS {
        if let Some(task) = number(name)? {
            return Ok(task.saturating_add(number(OFFSET)?.unwrap_or(0)));
        }
    }
    Err(Error::Configuration(format!(
        "--farm needs the number of a chunk: give --chunk, or run it as a task of an array, which sets {}",
        TASK_NUMBERS.join(" or ")
    )))
}

/// Refuses a program or an instruction set whose frames may differ in a bit.
fn check_program(job: &FarmJob, instructions: Instructions, folder: &Path) -> Result<()> {
    let own = ProgramRecord::own()?;
    if own != job.program {
        let which = if own.version == job.program.version { "another build of " } else { "" };
        return Err(other_job(
            folder,
            &format!(
                "it is rendered by {}, and this is {which}{}; give all machines the program that submitted it",
                job.program.version, own.version
            ),
        ));
    }

    let simd = (instructions.engine() == Engine::Planes).then(|| instructions.isa().name().to_owned());
    match &job.simd {
        Some(pinned) if simd.as_ref() != Some(pinned) => Err(other_job(
            folder,
            &format!("it is rendered with --simd {pinned}, which this command does not say"),
        )),
        _ => Ok(()),
    }
}

fn other_job(folder: &Path, what: &str) -> Error {
    Error::Mismatch(format!("{}: {what}", folder.display()))
}

impl ChunkWork {
    /// Refuses frames that are not the job's: of another database, flight or setting, or of pages that are damaged here. `anew` is the
    /// database, of which nothing was read yet.
    pub fn check(
        &self,
        own: &Manifest,
        output: Option<&Path>,
        renderer: &Renderer<'_>,
        cameras: &[NumberedCamera],
        anew: &PageFile,
        observer: &dyn Observer,
    ) -> Result<()> {
        // A folder that is not there yet is told by its name.
        let real = |folder: &Path| {
            let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            folder.canonicalize().or_else(|_| std::path::absolute(folder)).ok()
        };
        let frames = self.job.frames();
        if output.and_then(real).is_none_or(|output| Some(output) != real(&frames)) {
            return Err(other_job(&self.folder, &format!("its frames go to {}, not here", frames.display())));
        }
        if let Some(what) = self.job.made_of.difference(own) {
            let remedy = "give this machine what the job was submitted with, or submit a job of its own";
            return Err(other_job(
                &self.folder,
                &format!("this is not what was submitted: {what}; {remedy}"),
            ));
        }

        let parts = match self.job.check {
            PageCheck::Planned if is_planned(renderer, cameras)? => {
                planned(renderer, cameras, anew, observer)?
            }
            PageCheck::Planned | PageCheck::Whole => {
                anew.directory().present().flat_map(|(id, _): (PageId, _)| PagePart::all(id)).collect()
            }
        };
        anew.check(&parts, observer).map_err(|error| match error {
            damaged @ Error::Invalid { .. } => {
                other_job(&self.folder, &format!("the database is not that of the job: {damaged}"))
            }
            other => other,
        })
    }

    /// Refuses a flight that has become too short for the chunk.
    pub fn check_length(&self, count: u64) -> Result<()> {
        match self.frames.last() {
            Some(last) if last > count => Err(other_job(
                &self.folder,
                &format!(
                    "this is not what was submitted: the flight had {last} frames or more, and has {count} now; submit a job of its own"
                ),
            )),
            _ => Ok(()),
        }
    }

    /// Whether a frame is finished: its file holds the bytes that a record tells of.
    pub fn is_finished(&self, number: u64, file: &Path) -> bool {
        self.finished.get(&number).is_some_and(|record| holds(record, file))
    }

    /// Records a frame that was written now.
    pub fn record(&self, record: FrameRecord, delivery: &Delivery) -> Result<()> {
        self.log.append(FrameRecord {
            coarser_share: Some(delivery.rays.coarser_share()),
            cost: Some(delivery.cost(None)),
            ..record
        })
    }

    /// Records frames anew that were written now, with all that is known of them in the end.
    pub fn complete(&self, records: Vec<FrameRecord>) -> Result<()> {
        records.into_iter().try_for_each(|record| self.log.append(record))
    }

    /// Records the end of this try, and what ended it early.
    pub fn end(&self, failure: Option<&Error>) -> Result<()> {
        self.log.end(failure)
    }
}

/// Whether the pages of all frames are known beforehand.
fn is_planned(renderer: &Renderer<'_>, cameras: &[NumberedCamera]) -> Result<bool> {
    for frame in cameras {
        if renderer.engine_for(&frame.camera)? == Engine::Reference {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Lists the parts of pages that the frames may touch.
fn planned(
    renderer: &Renderer<'_>,
    cameras: &[NumberedCamera],
    file: &PageFile,
    observer: &dyn Observer,
) -> Result<Vec<PagePart>> {
    let farm = Farm::new(1)?;
    let planner = FlightPlan::new(renderer, &farm, cameras);
    let plan = PagePlan::new(file, cameras.len() as u32, &planner, observer)?;
    Ok(plan.first_use.into_iter().map(|(part, _)| part).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedulers_tell_the_number_of_a_chunk() {
        let number = |variables: &[(&str, &str)]| {
            let find = |name: &str| {
                variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
            };
            number_of_task(&find).map_err(|error| error.to_string())
        };
        assert_eq!(number(&[("HQ_TASK_ID", "7")]), Ok(7));
        assert_eq!(number(&[("SLURM_ARRAY_TASK_ID", "7"), (OFFSET, "1000")]), Ok(1007));
        assert!(number(&[]).unwrap_err().contains("--chunk"));
        assert!(number(&[("HQ_TASK_ID", "x")]).unwrap_err().contains("HQ_TASK_ID"));
    }
}
