//! `hedgehop verify`: is a database, or a folder of frames, whole?

use serde_json::{Value, json};

use super::verify_frames;
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use hedgehop::voxel::{Problem, VerifyReport};

const EXAMPLE: &str = "\
Examples:
  hedgehop verify area.hop && echo sound
  hedgehop verify --json area.hop
  hedgehop verify frames";

/// Check a database, or a folder of frames, from end to end.
///
/// Reads every page, compares checksums, heights of all levels and the content hash, and lists each problem. Of a folder, decodes every frame, compares it with
/// the manifest beside it, and lists frames that are damaged or missing as render --frames takes them.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct VerifyArgs {
    /// Database, or folder of frames, to check
    #[arg(value_name = "AREA.hop|FOLDER")]
    file: DatabaseName,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    cache: CacheArgs,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Runs the command.
pub fn run(args: &VerifyArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    if args.file.is_dir() {
        return verify_frames::verify(&args.file, args.json, &reporter);
    }
    let report = args.cache.open(&args.file)?.verify(&reporter)?;
    let text = if args.json { format!("{:#}\n", json(args, &report)) } else { lines(args, &report) };
    exit::print(&text)?;
    if report.is_sound() { Ok(()) } else { Err(Failure::Problems) }
}

fn lines(args: &VerifyArgs, report: &VerifyReport) -> String {
    let mut text: String = report.problems.iter().map(|problem| format!("problem: {problem}\n")).collect();
    let verdict = match report.problems.len() {
        0 => "sound".to_owned(),
        1 => "1 problem; build the database again".to_owned(),
        count => format!("{count} problems; build the database again"),
    };
    let empty = match report.empty {
        0 => String::new(),
        count => format!(" ({count} of them without a surface)"),
    };
    text += &format!("{}: {} pages checked{empty}, {verdict}\n", args.file.display(), report.pages);
    text
}

fn json(args: &VerifyArgs, report: &VerifyReport) -> Value {
    json!({
        "file": args.file.display().to_string(),
        "bytes": report.bytes,
        "pages": report.pages,
        "empty_pages": report.empty,
        "absent_pages": report.absent,
        "sound": report.is_sound(),
        "problems": report.problems.iter().map(problem_json).collect::<Vec<_>>(),
    })
}

fn problem_json(problem: &Problem) -> Value {
    json!({
        "page": problem.page.map(|id| json!({ "level": id.level, "px": id.px, "py": id.py })),
        "byte": problem.byte,
        "what": problem.what,
    })
}
