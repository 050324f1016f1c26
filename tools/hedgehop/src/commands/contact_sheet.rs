//! `hedgehop contact-sheet`: many frames small on one picture.

use std::path::PathBuf;

use crate::args::{check_no_input, expanded};
use crate::contact_sheet::{Entry, WIDTH, sheet, spread};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use crate::{film, pictures};
use hedgehop::Error;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::progress::Observer;

const EXAMPLE: &str = "\
Examples:
  hedgehop contact-sheet frames/ -o sheet.png
  hedgehop contact-sheet film.mp4 --count 24 --columns 6 --width 240 -o sheet.png";

/// Put frames of a flight small on one picture.
///
/// Takes folders of frames, single pictures, and films, which an installed ffmpeg decodes. Of all of them the sheet shows so many, evenly spread, with
/// their numbers.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct ContactSheetArgs {
    /// Folders of frames, pictures (.png, .exr, .jpg), or one film
    #[arg(value_name = "FRAMES", required = true)]
    inputs: Vec<PathBuf>,

    /// Picture to write
    #[arg(short, long, value_name = "SHEET.png", default_value = "contact-sheet.png")]
    output: PathBuf,

    /// Frames on the sheet at most
    #[arg(long, value_name = "N", default_value = "12", value_parser = clap::value_parser!(u32).range(1..=1000))]
    count: u32,

    /// Frames in a row
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=100))]
    columns: u32,

    /// Width of a frame on the sheet, pixels
    #[arg(long, value_name = "PIXELS", default_value_t = WIDTH, value_parser = clap::value_parser!(u32).range(16..=4096))]
    width: u32,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

impl ContactSheetArgs {
    /// Asks for the usual sheet of a folder of frames.
    pub fn of_folder(frames: PathBuf, output: PathBuf, progress: Mode) -> Self {
        Self { inputs: vec![frames], output, count: 12, columns: 4, width: WIDTH, progress }
    }
}

/// Runs the command.
pub fn run(args: &ContactSheetArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let named = args.inputs.iter().map(|input| expanded("contact-sheet", input));
    let named = named.collect::<hedgehop::Result<Vec<_>>>()?.concat();
    let args = &ContactSheetArgs { inputs: named, ..args.clone() };
    let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    pictures::check_png(&args.output, "a contact sheet")?;
    check_no_input("-o", &args.output, &inputs)?;
    check_writable(&args.output)?;
    let is_film = |input: &PathBuf| !input.is_dir() && !pictures::is_picture(input);

    let entries = match args.inputs.as_slice() {
        [film] if is_film(film) => {
            reporter.begin("frames of the film", 0, "frames");
            let entries = film::entries(film, args.width, args.count as usize, &reporter)?;
            reporter.end();
            entries
        }
        inputs => {
            if let Some(film) = inputs.iter().find(|input| is_film(input)) {
                let what = format!("{} is no folder and no picture; a film is given alone", film.display());
                return Err(Error::Configuration(what).into());
            }
            of_files(args, &reporter)?
        }
    };

    let made = sheet(&entries, args.columns, args.width)?;
    write_bytes(&args.output, &pictures::png(&made, &args.output)?)?;
    let text = format!(
        "{} frames on {}, {}x{} pixels\n",
        entries.len(),
        args.output.display(),
        made.width(),
        made.height()
    );

    Ok(exit::print(&text)?)
}

/// Reads the entries of folders and single pictures.
fn of_files(args: &ContactSheetArgs, reporter: &Reporter) -> hedgehop::Result<Vec<Entry>> {
    let mut files = Vec::new();
    for input in &args.inputs {
        if input.is_dir() {
            files.extend(pictures::in_folder(input)?);
        } else {
            files.push(input.clone());
        }
    }

    // An earlier sheet among the frames is none of them.
    if let Ok(output) = args.output.canonicalize() {
        let is_frame =
            |name: &std::ffi::OsStr| name.to_string_lossy().bytes().all(|byte| byte.is_ascii_digit());
        if args.output.file_stem().is_some_and(is_frame) {
            let folders: Vec<_> = files.iter().map(PathBuf::as_path).collect();
            check_no_input("-o", &args.output, &folders)?;
        }
        files.retain(|file| file.canonicalize().is_ok_and(|file| file != output));
    }

    let chosen = spread(files.len(), args.count as usize);
    reporter.begin("frames", chosen.len() as u64, "frames");
    let mut entries = Vec::with_capacity(chosen.len());
    for file in chosen.into_iter().filter_map(|index| files.get(index)) {
        if reporter.cancelled() {
            return Err(Error::Interrupted(format!("{} was not written", args.output.display())));
        }
        entries.push(Entry::new(pictures::label(file), &pictures::open(file)?, args.width));
        reporter.advance(1);
    }

    reporter.end();
    Ok(entries)
}
