//! `hedgehop compare`: two runs side by side, and what differs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::json;

use crate::args::check_no_input;
use crate::difference::{HEAD, PictureFile, Sums, check_sizes, panels};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::pictures;
use crate::progress::{Mode, Reporter};
use crate::viewer::Viewer;
use hedgehop::Error;
use hedgehop::encode::atomic::{check_writable, write_bytes};
use hedgehop::progress::Observer;

const EXAMPLE: &str = "\
Examples:
  hedgehop compare before.png after.png -o difference.png
  hedgehop compare planes/ reference/ -o differences/ --amplify 16 --html compare.html
  hedgehop compare planes/ reference/ --json";

/// Names of pairs that are told when they stand alone.
const MOST_TOLD: usize = 3;

/// Compare two pictures, or two folders of frames, as 8-bit sRGB.
///
/// Frames of folders are those of one name, whatever their format. Pictures that differ are no failure: the exit code is 0.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct CompareArgs {
    /// A picture (.png, .exr, .jpg), or a folder of frames
    #[arg(value_name = "A")]
    a: PathBuf,

    /// Another one
    #[arg(value_name = "B")]
    b: PathBuf,

    /// Both and their difference side by side: a picture, of folders a folder [default: figures only]
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,

    /// Factor by which differences are enlarged
    #[arg(long, value_name = "FACTOR", default_value = "8", value_parser = clap::value_parser!(u32).range(1..=255))]
    amplify: u32,

    /// Write a page with all pictures in it, to wipe between them in a browser
    #[arg(long, value_name = "PAGE.html")]
    html: Option<PathBuf>,

    /// Print figures as JSON
    #[arg(long)]
    json: bool,

    /// Form of progress on standard error
    #[arg(long, value_enum, value_name = "MODE", default_value = "auto")]
    progress: Mode,
}

/// Two pictures, and where what is made of them goes.
struct Pair {
    name: String,
    files: [PathBuf; 2],
    output: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &CompareArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(args.progress, interrupt);
    let pairs = pairs(args, &reporter)?;
    for output in pairs.iter().filter_map(|pair| pair.output.as_ref()).chain(&args.html) {
        let inputs: Vec<_> = pairs.iter().flat_map(|pair| &pair.files).map(PathBuf::as_path).collect();
        check_no_input(if args.html.as_ref() == Some(output) { "--html" } else { "-o" }, output, &inputs)?;
    }

    args.html.iter().try_for_each(|page| check_writable(page))?;
    let (mut all, mut table, mut rows) = (Sums::default(), HEAD.to_owned(), Vec::new());
    let mut viewer = Viewer::of([&args.a, &args.b].map(|run| run.display().to_string()));
    reporter.begin("compare", pairs.len() as u64, "frames");

    for pair in &pairs {
        if reporter.cancelled() {
            return Err(Error::Interrupted("what was compared before is written".into()).into());
        }
        let sums = one(pair, args, &mut viewer)?;
        all.add(&sums);
        table.push_str(&sums.row(&pair.name));
        rows.push(sums.json(&pair.name));
        reporter.advance(1);
    }

    reporter.end();
    if let Some(page) = &args.html {
        write_bytes(page, viewer.page().as_bytes())?;
    }
    if args.json {
        let report = json!({ "frames": rows, "all": all.json("all") });
        return Ok(exit::print(&format!("{report:#}\n"))?);
    }

    if pairs.len() > 1 {
        table.push_str(&all.row("all"));
    }
    for written in args.output.iter().chain(&args.html) {
        table.push_str(&format!("wrote {}\n", written.display()));
    }

    Ok(exit::print(&table)?)
}

/// Compares one pair, and writes what was asked for.
fn one(pair: &Pair, args: &CompareArgs, viewer: &mut Viewer) -> hedgehop::Result<Sums> {
    let [first, second] = &pair.files;
    let (a, b) = (pictures::open(first)?, pictures::open(second)?);
    check_sizes(PictureFile { path: first, picture: &a }, PictureFile { path: second, picture: &b })?;
    let sums = Sums::of(&a, &b);
    if let Some(output) = &pair.output {
        write_bytes(output, &pictures::png(&panels(&a, &b, args.amplify), output)?)?;
    }
    if args.html.is_some() {
        let [a, b] = [pictures::png(&a, first)?, pictures::png(&b, second)?];
        viewer.add([&a, &b], sums.json(&pair.name))?;
    }
    Ok(sums)
}

/// Finds the pairs to be compared.
fn pairs(args: &CompareArgs, observer: &dyn Observer) -> hedgehop::Result<Vec<Pair>> {
    match (args.a.is_dir(), args.b.is_dir()) {
        (false, false) => {
            args.output.iter().try_for_each(|output| {
                pictures::check_png(output, "what compares two pictures")
                    .and_then(|()| check_writable(output))
            })?;
            let files = [args.a.clone(), args.b.clone()];
            Ok(vec![Pair { name: pictures::name(&args.a), files, output: args.output.clone() }])
        }
        (true, true) => in_folders(args, observer),
        _ => Err(Error::Configuration(format!(
            "{} and {} are a picture and a folder; give two of a kind",
            args.a.display(),
            args.b.display()
        ))),
    }
}

/// Pictures of two folders that have the same name.
fn in_folders(args: &CompareArgs, observer: &dyn Observer) -> hedgehop::Result<Vec<Pair>> {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let first = pictures::in_folder(&args.a)?;
    let mut second: BTreeMap<String, PathBuf> = BTreeMap::new();
    for path in pictures::in_folder(&args.b)? {
        second.entry(stem(&path)).or_insert(path);
    }

    let (mut pairs, mut alone): (Vec<Pair>, Vec<String>) = (Vec::new(), Vec::new());
    for path in first {
        let name = stem(&path);
        if pairs.last().is_some_and(|last| last.name == name) {
            continue;
        }
        match second.remove(&name) {
            Some(other) => {
                let output = args.output.as_ref().map(|folder| folder.join(format!("{name}.png")));
                pairs.push(Pair { name, files: [path, other], output });
            }
            None => alone.push(pictures::name(&path)),
        }
    }

    alone.extend(second.values().map(|path| pictures::name(path)));
    if pairs.is_empty() {
        return Err(Error::Configuration(format!(
            "{} and {} hold no pictures of the same name",
            args.a.display(),
            args.b.display()
        )));
    }

    if !alone.is_empty() {
        let told = alone.iter().take(MOST_TOLD).cloned().collect::<Vec<_>>().join(", ");
        let more = if alone.len() > MOST_TOLD { ", …" } else { "" };
        observer.note(&format!("{} pictures are in one of the folders only: {told}{more}", alone.len()));
    }

    Ok(pairs)
}
