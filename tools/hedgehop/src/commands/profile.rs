//! `hedgehop profile`: the ground along a line or under a flight.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec2;

use crate::area;
use crate::args::{self, AltitudeMode};
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::places::Places;
use crate::plot::{self, Elevations};
use crate::progress::{Mode, Reporter};
use crate::tracks::TrackArgs;
use crate::view::over_ground;
use crate::world::WorldArgs;
use hedgehop::encode::atomic::write_bytes;
use hedgehop::flight::{BindOptions, Trajectory, read_track};
use hedgehop::memory::PageFile;
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result};
use hedgehop_query::{Ground, Sample, profile};

const EXAMPLE: &str = "\
Examples:
  hedgehop profile area.hop --from -105.54,40.38 --to -105.60,40.33 -o ridge.svg
  hedgehop profile area.hop --path flight.gpx -o flight.svg
  hedgehop profile area.hop --path flight.csv --step 10 -o flight.csv";

/// Steps of a flight's heights, seconds.
const EVERY: f64 = 0.5;

/// Show the ground along a line, or under a flight and how high that is above it.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
#[command(group(clap::ArgGroup::new("line").required(true).args(["path", "from"])))]
pub struct ProfileArgs {
    /// Database to ask
    #[arg(value_name = "AREA.hop")]
    file: DatabaseName,

    /// Flight path: CSV, JSBSim CSV, KML gx:Track, GPX or IGC
    #[arg(long, value_name = "FILE")]
    path: Option<PathBuf>,

    /// Surface that altitudes are measured from where the path file does not say [default: msl]
    #[arg(long, value_enum, value_name = "MODE", requires = "path")]
    alt_mode: Option<AltitudeMode>,

    /// Begin of the line: longitude and latitude, degrees (WGS 84); of local databases x and y
    #[arg(long, value_name = "LON,LAT", value_parser = args::pair, requires = "to", allow_hyphen_values = true)]
    from: Option<[f64; 2]>,

    /// End of the line
    #[arg(long, value_name = "LON,LAT", value_parser = args::pair, requires = "from", allow_hyphen_values = true)]
    to: Option<[f64; 2]>,

    #[command(flatten)]
    tracks: TrackArgs,

    /// Places are x and y, metres of the database's reference system
    #[arg(long, requires = "from")]
    xy: bool,

    /// Tell bare ground, below roofs, crowns and bridges
    #[arg(long)]
    bare: bool,

    /// Metres from place to place [default: the side of the finest voxel]
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    step: Option<f64>,

    #[command(flatten)]
    cache: CacheArgs,

    /// Plot or table to write
    #[arg(short, long, value_name = "PROFILE.svg|.csv")]
    output: Option<PathBuf>,
}

impl ProfileArgs {
    fn ground(&self) -> Ground {
        if self.bare { Ground::Bare } else { Ground::Highest }
    }
}

/// Ground along a line, and how high a flight is above the datum at each place.
struct ProfileLine {
    title: String,
    samples: Vec<Sample>,
    flight: Option<Vec<f64>>,
}

/// Kinds of output.
enum ProfileKind {
    Plot,
    Table,
}

/// Runs the command.
pub fn run(args: &ProfileArgs, interrupt: &Interrupt) -> Outcome {
    let reporter = Reporter::new(Mode::Auto, interrupt);
    let output = args.output.as_deref().map(|path| Ok::<_, Error>((path, kind(path)?))).transpose()?;
    let inputs: Vec<&Path> = std::iter::once(&*args.file).chain(args.path.as_deref()).collect();
    if let Some((path, _)) = &output {
        args::check_no_input("-o", path, &inputs)?;
    }

    args.tracks.check(args.path.is_some(), "--path")?;
    let source = args.cache.open(&args.file)?;
    let places = Places::new(&source, args.xy || args.path.is_some())?;
    let step = args.step.unwrap_or(source.header().grid.spacing);

    let line = match (&args.path, args.from, args.to) {
        (Some(path), ..) => under_flight(args, path, &source, step, &reporter)?,
        (None, Some(from), Some(to)) => {
            let ends = [places.find(from)?, places.find(to)?];
            if ends[0] == ends[1] {
                let what = format!(
                    "--from and --to are the same place, {}; a line needs two, and hedgehop height tells one",
                    places.name(ends[0])
                );
                return Err(Error::Configuration(what).into());
            }
            let title = format!("{} to {}", places.name(ends[0]), places.name(ends[1]));
            ProfileLine { title, samples: profile(&source, args.ground(), &ends, step)?, flight: None }
        }
        _ => return Err(Error::Configuration("give --path, or --from and --to".into()).into()),
    };

    let header = source.header();
    if let Some((path, kind)) = output {
        let text = match kind {
            ProfileKind::Plot => drawn(&line, header)?,
            ProfileKind::Table => table(&line, &places),
        };
        write_bytes(path, text.as_bytes())?;
    }

    Ok(exit::print(&summary(&line, header)?)?)
}

fn kind(path: &Path) -> Result<ProfileKind> {
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => Ok(ProfileKind::Plot),
        Some("csv") => Ok(ProfileKind::Table),
        _ => {
            let what = format!("{}: a profile is a plot, .svg, or a table, .csv", path.display());
            Err(Error::Configuration(what))
        }
    }
}

/// The ground below a flight, and its heights, at times at which it is `step` metres apart or less.
fn under_flight(
    args: &ProfileArgs,
    path: &Path,
    source: &PageFile,
    step: f64,
    reporter: &Reporter,
) -> Result<ProfileLine> {
    let track = read_track(path, &args.tracks.options(args.alt_mode.map(Into::into)))?;
    let options = BindOptions { level: true, ..BindOptions::default() };
    let trajectory = over_ground(source, WorldArgs::default(), |crs, ground| {
        Trajectory::bind(&track, crs, ground, &options)
    })?;
    track.notes.iter().for_each(|note| hedgehop::progress::Observer::note(reporter, note));
    let count = (trajectory.duration() / EVERY).ceil().clamp(1.0, 1.0e6) as u32;
    let eyes: Vec<_> = (0..=count)
        .map(|index| trajectory.pose_at(trajectory.duration() * f64::from(index) / f64::from(count)).eye)
        .collect();
    let (mut samples, mut flight): (Vec<Sample>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut begun = 0.0;

    for ends in eyes.windows(2) {
        let places: [DVec2; 2] = [ends[0].truncate(), ends[1].truncate()];
        let length = places[0].distance(places[1]);
        let mut part = profile(source, args.ground(), &places, step)?;
        // The next piece begins with its last place.
        part.pop();
        for sample in part {
            let share = if length > 0.0 { sample.distance / length } else { 0.0 };
            flight.push(ends[0].z + share * (ends[1].z - ends[0].z));
            samples.push(Sample { distance: begun + sample.distance, ..sample });
        }
        begun += length;
    }

    if let Some(eye) = eyes.last() {
        let last = profile(source, args.ground(), &[eye.truncate()], step)?;
        samples.extend(last.into_iter().map(|sample| Sample { distance: begun, ..sample }));
        flight.push(eye.z);
    }

    Ok(ProfileLine { title: path.display().to_string(), samples, flight: Some(flight) })
}

fn drawn(line: &ProfileLine, header: &Header) -> std::result::Result<String, Failure> {
    // Without any height there is no scale to draw it on.
    if line.flight.is_none() && line.samples.iter().all(|sample| sample.ground.is_none()) {
        let what = format!(
            "{}: all of it lies in a gap of the data, and there is nothing to draw; give other places, or write a table, .csv",
            line.title
        );
        return Err(Error::Configuration(what).into());
    }

    let ground: Vec<_> =
        line.samples.iter().map(|sample| (sample.distance / 1000.0, sample.ground)).collect();
    let along = ground.iter().map(|(along, _)| *along);
    let flight = line.flight.iter().flat_map(|flight| along.clone().zip(flight.iter().copied())).collect();

    let shown = Elevations {
        title: line.title.clone(),
        datum: header.metadata.vertical_datum.clone(),
        ground,
        flight,
    };

    plot::profile(&shown).map_err(|error| Failure::Unforeseen(format!("the plot: {error}")))
}

/// All samples as CSV.
fn table(line: &ProfileLine, places: &Places<'_>) -> String {
    let mut text = "distance_m,lon_deg,lat_deg,x_m,y_m,ground_m".to_owned();
    text += if line.flight.is_some() { ",altitude_m,above_ground_m\n" } else { "\n" };
    for (index, sample) in line.samples.iter().enumerate() {
        let [longitude, latitude] = places
            .lonlat(sample.place)
            .map_or([String::new(), String::new()], |place| place.map(|degrees| format!("{degrees:.8}")));
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.3}"));

        // Writing to a string does not fail.
        let _ = write!(
            text,
            "{:.3},{longitude},{latitude},{:.3},{:.3},{}",
            sample.distance,
            sample.place.x,
            sample.place.y,
            number(sample.ground)
        );

        if let Some(flight) = &line.flight {
            let altitude = flight[index];
            let _ = write!(text, ",{altitude:.3},{}", number(sample.ground.map(|ground| altitude - ground)));
        }

        text.push('\n');
    }

    text
}

/// Describes the profile in a few lines.
fn summary(line: &ProfileLine, header: &Header) -> Result<String> {
    let datum = &header.metadata.vertical_datum;
    let length = line.samples.last().map_or(0.0, |sample| sample.distance);
    let heights: Vec<f64> = line.samples.iter().filter_map(|sample| sample.ground).collect();
    let mut text = format!("{}: {:.2} km, {} places", line.title, length / 1000.0, line.samples.len());
    let (low, high) = heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
        (low.min(*height), high.max(*height))
    });
    let climb: f64 = heights.windows(2).map(|pair| (pair[1] - pair[0]).max(0.0)).sum();

    // Writing to a string does not fail.
    let _ = if heights.is_empty() {
        write!(text, "; there is no ground along it")
    } else {
        write!(text, "; ground from {low:.1} to {high:.1} m above {datum}, {climb:.0} m up in all")
    };
    text += &missing(line, header)?;

    if let Some(flight) = &line.flight {
        let above = line
            .samples
            .iter()
            .zip(flight)
            .filter_map(|(sample, eye)| Some((sample.distance, eye - sample.ground?)));

        if let Some((at, least)) = above.min_by(|a, b| a.1.total_cmp(&b.1)) {
            let _ = write!(
                text,
                "\nthe flight is {least:.1} m above ground at least, {:.2} km on the way",
                at / 1000.0
            );
        }
    }

    text.push('\n');
    Ok(text)
}

/// Says where there is no ground, and why.
fn missing(line: &ProfileLine, header: &Header) -> Result<String> {
    let places = line.samples.len();
    let without = line.samples.iter().filter(|sample| sample.ground.is_none()).count();
    let outside = line.samples.iter().filter(|sample| !header.grid.contains(sample.place)).count();
    let mut text = String::new();
    let mut add = |count: usize, what: String| {
        let count = if count == places { "all".to_owned() } else { format!("{count} of {places}") };
        text += &format!("; {count} places lie {what}");
    };
    if without > outside {
        add(without - outside, "in a gap of the data".to_owned());
    }
    if outside > 0 {
        add(outside, format!("outside the area, {}", area::extents(header)?));
    }
    Ok(text)
}
