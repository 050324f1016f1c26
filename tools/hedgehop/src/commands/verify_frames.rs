//! `hedgehop verify-frames`: is every frame of a job or a folder whole, its own, and in its place?

mod folder;
mod job;

use std::path::{Path, PathBuf};

use crate::args::absolute;
use crate::exit::{self, Failure, Outcome};
use crate::frame_ranges::ranges;
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use hedgehop::Error;
use hedgehop::progress::Observer;
use job::JobOfFrames;

const EXAMPLE: &str = "\
Examples:
  hedgehop verify-frames frames
  hedgehop verify-frames frames --repair
  hedgehop verify-frames frames --job night.job --json";

/// Check a folder of frames from end to end, and render again what is wrong.
///
/// Decodes every frame and compares it with the record of whoever rendered it: a farm's job, or the manifest beside the frames. Lists frames that are
/// missing, damaged, or of another render, as render --frames takes them.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct VerifyFramesArgs {
    /// Folder of the frames
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,

    /// Job that the frames are of [default: FOLDER.job, if it is there]
    #[arg(long, value_name = "FRAMES.job")]
    job: Option<PathBuf>,

    /// Render what is wrong again, with the flags, the database and the program of the job
    #[arg(long)]
    repair: bool,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &VerifyFramesArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    if !args.folder.is_dir() {
        return Err(
            Error::invalid(&args.folder, "is no folder; name the one that frames were rendered to").into()
        );
    }

    let job = JobOfFrames::find(&args.folder, args.job.as_deref())?;
    if !args.repair {
        return tell(&args.folder, job.as_ref(), args.json, &reporter);
    }
    let Some(job) = job else {
        let found = folder::check(&args.folder, None, &reporter)?;
        if found.is_sound() {
            return tell(&args.folder, None, args.json, &reporter);
        }
        return Err(Error::Configuration(format!(
            "no job of a farm is known for {}, which would say how its frames are rendered; name it with --job, or give render the \
             --frames that are listed without --repair",
            args.folder.display()
        ))
        .into());
    };
    // Frames are rendered from the folder that the job was submitted in.
    let folder = absolute(&args.folder)?;
    let found = folder::check(&folder, Some(job.expected()?), &reporter)?;
    job.repair(&found.numbers(), &reporter)?;
    if !found.is_sound() {
        reporter.note(&format!("rendered again: frames {}", ranges(&found.numbers())));
    }
    tell(&folder, Some(&job), args.json, &reporter)
}

/// Checks a folder against the job beside it, or its manifest, and says what was found.
pub fn verify(path: &Path, as_json: bool, reporter: &Reporter) -> Outcome {
    tell(path, JobOfFrames::find(path, None)?.as_ref(), as_json, reporter)
}

/// Checks a folder, and says what was found.
fn tell(path: &Path, job: Option<&JobOfFrames>, as_json: bool, reporter: &Reporter) -> Outcome {
    let expected = job.map(JobOfFrames::expected).transpose()?;
    let report = folder::check(path, expected, reporter)?;
    let text =
        if as_json { format!("{:#}\n", folder::json(path, &report)) } else { folder::lines(path, &report) };
    exit::print(&text)?;
    if report.is_sound() { Ok(()) } else { Err(Failure::Problems) }
}
