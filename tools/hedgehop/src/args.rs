//! Arguments that users type, and their meaning: parsers of flag values, and flags that several commands share.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use serde::Serialize;

use hedgehop::Error;
use hedgehop::Size;
use hedgehop::raymarch::SPAN_PIXELS;
use hedgehop::render::Engine;
use hedgehop::simd::Isa;
use hedgehop::subimage::TaskSize;
use hedgehop::sunlight::{FilmSun, Sun, SunSetting};
use hedgehop_modeling::raster::{FORMATS, RasterFormat};
use hedgehop_modeling::recipe::matching;

/// Widest and highest picture, pixels. A frame holds about 40 bytes per pixel.
const MAX_SIDE: u32 = 16384;

/// `WIDTHxHEIGHT`, pixels.
pub fn size(text: &str) -> Result<Size, String> {
    let sides = text.split_once(['x', 'X']).map(|(w, h)| (w.trim().parse(), h.trim().parse()));
    match sides {
        Some((Ok(width), Ok(height)))
            if (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) =>
        {
            Ok(Size { width, height })
        }
        _ => Err(format!("want WIDTHxHEIGHT in pixels, each 1 to {MAX_SIDE}, such as 1280x720")),
    }
}

/// Bytes: `512M`, `2GiB`, `800K`, `1.5G` or a plain number; K, M, G and T are powers of 1024.
pub fn bytes(text: &str) -> Result<u64, String> {
    let wrong = || "want bytes such as 512M, 2G or 1.5GiB".to_owned();
    let digits = text.trim().find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.trim().len());
    let (number, unit) = text.trim().split_at(digits);
    let unit = unit.trim().to_ascii_lowercase();
    let letter = unit.strip_suffix("ib").or_else(|| unit.strip_suffix('b')).unwrap_or(&unit);
    let power = ["", "k", "m", "g", "t"].iter().position(|&known| known == letter).ok_or_else(wrong)?;
    let value = number.parse::<f64>().map_err(|_| wrong())? * 1024_f64.powi(power as i32);
    // 2^53 bytes: beyond every machine, and exact in f64.
    if (1.0..9.0e15).contains(&value) { Ok(value as u64) } else { Err(wrong()) }
}

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("want a number".into()),
    }
}

/// A finite number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|value| *value > 0.0).ok_or_else(|| "want a number above 0".into())
}

/// Factor on how finely ground is looked at.
pub fn detail(text: &str) -> Result<f64, String> {
    let range = 0.1..=16.0;
    number(text)
        .ok()
        .filter(|factor| range.contains(factor))
        .ok_or_else(|| "want a factor from 0.1 (coarse and fast) to 16; 1 is usual".into())
}

/// Factor on the amplitude of detail below the voxel: on, off or a number.
pub fn detail_synthesis(text: &str) -> Result<f64, String> {
    match text {
        "on" => Ok(1.0),
        "off" => Ok(0.0),
        factor => number(factor)
            .ok()
            .filter(|factor| (0.0..=2.0).contains(factor))
            .ok_or_else(|| "want on, off, or a factor on its strength from 0 to 2".into()),
    }
}

/// Pixels that a voxel fills at least where what stands is seen as spans.
pub fn far_spans(text: &str) -> Result<f64, String> {
    let range = SPAN_PIXELS..=16.0;
    number(text)
        .ok()
        .filter(|pixels| range.contains(pixels))
        .ok_or_else(|| format!("want pixels from {SPAN_PIXELS} (far, as usual) to 16 (near)"))
}

/// A field of view, degrees.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    number(text)
        .ok()
        .filter(|angle| *angle > 0.0 && *angle <= 360.0)
        .ok_or_else(|| "want degrees above 0 and up to 360; a planar screen sees up to 175".into())
}

fn numbers<const N: usize>(text: &str, example: &str) -> Result<[f64; N], String> {
    let values: Result<Vec<f64>, String> = text.split(',').map(number).collect();
    values
        .ok()
        .and_then(|values| <[f64; N]>::try_from(values).ok())
        .ok_or_else(|| format!("want {N} numbers with commas between, such as {example}"))
}

/// `K1,K2`.
pub fn pair(text: &str) -> Result<[f64; 2], String> {
    numbers(text, "-0.2,0.05")
}

/// Farthest that a place may be from the origin, metres, as in path files.
const FARTHEST: f64 = 1.0e9;

/// `x,y,z`.
pub fn position(text: &str) -> Result<[f64; 3], String> {
    let position: [f64; 3] = numbers(text, "500120,4180300,850")?;
    if position.iter().any(|value| value.abs() > FARTHEST) {
        return Err("want metres, at most 10⁹ from the origin".into());
    }
    Ok(position)
}

/// A finite number that is not below zero.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|value| *value >= 0.0).ok_or_else(|| "want a number of at least 0".into())
}

/// Ten turns, degrees: more is an error of units, as in path files, and loses the direction to rounding in the end.
const MAX_TURN: f64 = 3600.0;

/// `yaw,pitch,roll`, degrees.
pub fn attitude(text: &str) -> Result<[f64; 3], String> {
    let [yaw, pitch, roll]: [f64; 3] = numbers(text, "90,-10,0")?;
    if pitch.abs() > 90.0 {
        return Err("want a pitch from -90 to 90 degrees".into());
    }
    if yaw.abs() > MAX_TURN || roll.abs() > MAX_TURN {
        return Err("want yaw and roll in degrees, at most ten turns".into());
    }
    Ok([yaw, pitch, roll])
}

/// The sun's `azimuth,elevation`, degrees, or a time.
pub fn sun(text: &str) -> Result<SunSetting, String> {
    if text.contains(['T', 't']) {
        let wrong = || "want a date and time with an offset from UTC, such as 2026-06-21T09:30Z".to_owned();
        return SunSetting::parse_time(text).map(SunSetting::Time).ok_or_else(wrong);
    }
    let angles: [f64; 2] = numbers(text, "225,40")?;
    if angles[0].abs() > MAX_TURN {
        Err("want an azimuth in degrees, at most ten turns".into())
    } else if angles[1].abs() <= 90.0 {
        Ok(SunSetting::At(Sun { azimuth: angles[0], elevation: angles[1] }))
    } else {
        Err("want an elevation from -90 to 90 degrees".into())
    }
}

/// The sun of a film: that of [`sun`], or `track`.
pub fn film_sun(text: &str) -> Result<FilmSun, String> {
    match text {
        "track" => Ok(FilmSun::Track),
        still => sun(still).map(FilmSun::Still),
    }
}

/// `west,south,east,north`.
pub fn bounding_box(text: &str) -> Result<[f64; 4], String> {
    let [west, south, east, north] = numbers(text, "498000,4178000,506000,4186000")?;
    if west < east && south < north {
        Ok([west, south, east, north])
    } else {
        Err("want west,south,east,north with west < east and south < north".into())
    }
}

/// Three one-based bands.
pub fn bands(text: &str) -> Result<[u32; 3], String> {
    let values: Option<Vec<u32>> =
        text.split(',').map(|band| band.trim().parse().ok().filter(|&band| band >= 1)).collect();
    values
        .and_then(|values| <[u32; 3]>::try_from(values).ok())
        .ok_or_else(|| "want three band numbers counted from 1, such as 3,2,1".into())
}

/// Flags of the worker threads.
#[derive(Debug, Clone, Args)]
pub struct Workers {
    /// Worker threads [default: one per core]
    #[arg(short, long = "jobs", value_name = "N", value_parser = workers)]
    pub jobs: Option<usize>,
}

/// Flags of the engine that marches, and of its vector instructions.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Instructions {
    /// Engine that marches: scan planes, or the reference, ray by ray and exact, which takes 40 (straight down) to more
    /// than a hundred times as long
    #[arg(long, value_enum, value_name = "ENGINE", default_value = "planes")]
    pub engine: EngineName,

    /// Vector instructions of scan planes: avx512, avx2, neon or portable [default: the fastest that this machine has]
    #[arg(long, value_name = "SET", value_parser = Isa::from_str)]
    pub simd: Option<Isa>,
}

/// Engines as users name them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum EngineName {
    /// Sixteen vertical planes at a time; the reference for orthographic screens, --tile-world, --surface blocks, pixels of less than 5 µrad,
    /// planar pictures of more than 200 million pixels, steep ones and other screens of more than 67 million, and tables of rays that are strewn
    #[default]
    Planes,
    /// Ray by ray, exact
    Reference,
}

impl Instructions {
    /// Refuses a set for an engine that has none.
    pub fn check(&self) -> hedgehop::Result<()> {
        match (self.engine, self.simd) {
            (EngineName::Reference, Some(_)) => Err(Error::Configuration(
                "--simd chooses the instructions of scan planes, which --engine reference does not use; leave out one of \
                 the two"
                    .into(),
            )),
            _ => Ok(()),
        }
    }

    /// The engine that was asked for.
    pub fn engine(&self) -> Engine {
        match self.engine {
            EngineName::Reference => Engine::Reference,
            EngineName::Planes => Engine::Planes,
        }
    }

    /// Returns the instruction set that was asked for, or the fastest.
    pub fn isa(&self) -> Isa {
        self.simd.unwrap_or_default()
    }
}

/// More threads than any machine has cores are a typing error, and would exhaust the system.
const MAX_WORKERS: usize = 1024;

/// A count of worker threads.
pub fn workers(text: &str) -> Result<usize, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|count| (1..=MAX_WORKERS).contains(count))
        .ok_or_else(|| format!("want 1 to {MAX_WORKERS} worker threads"))
}

impl Workers {
    /// Returns the number of workers that was asked for, or one per core.
    pub fn count(&self) -> usize {
        self.jobs.unwrap_or_else(available_cores)
    }
}

/// Returns a name that holds in every working folder.
pub fn absolute(path: &Path) -> hedgehop::Result<PathBuf> {
    std::path::absolute(path).map_err(|error| Error::io(path, "find it", error))
}

/// Cores that this process may use; 1 where the system does not say.
pub fn available_cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

/// Flags of the frames that are rendered at once.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Overlap {
    /// Frames in flight: the next begins while the last tasks of one run; each takes memory for a frame
    /// [default: 2; always 1 with one worker]
    #[arg(long, value_name = "N", value_parser = in_flight)]
    pub in_flight: Option<usize>,
}

/// Beyond this, frames only take memory.
const MAX_IN_FLIGHT: usize = 64;

fn in_flight(text: &str) -> Result<usize, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|count| (1..=MAX_IN_FLIGHT).contains(count))
        .ok_or_else(|| format!("want 1 to {MAX_IN_FLIGHT} frames"))
}

/// `LINES,ROWS`: scan lines of a march task, screen rows of an image task.
pub fn task_size(text: &str) -> Result<TaskSize, String> {
    let sides = text.split_once(',').map(|(lines, rows)| (lines.trim().parse(), rows.trim().parse()));
    match sides {
        Some((Ok(lines), Ok(rows))) if lines > 0 && rows > 0 => Ok(TaskSize { lines, rows }),
        _ => Err("want LINES,ROWS, each at least 1, such as 16,8".into()),
    }
}

/// Surface that altitudes are measured from, where a path file leaves it open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AltitudeMode {
    /// Mean sea level: the database's own datum
    Msl,
    /// Height above the ground below
    Agl,
    /// Height above the WGS 84 ellipsoid
    Ellipsoid,
}

impl From<AltitudeMode> for hedgehop::flight::AltitudeMode {
    fn from(mode: AltitudeMode) -> Self {
        match mode {
            AltitudeMode::Msl => Self::Msl,
            AltitudeMode::Agl => Self::Agl,
            AltitudeMode::Ellipsoid => Self::Ellipsoid,
        }
    }
}

/// Formats of elevation, the commonest first.
pub fn elevation_formats() -> impl Iterator<Item = &'static RasterFormat> {
    FORMATS.iter().filter(|format| format.is_elevation)
}

/// Formats of imagery, the commonest first.
pub fn imagery_formats() -> impl Iterator<Item = &'static RasterFormat> {
    FORMATS.iter().filter(|format| format.is_imagery)
}

/// Lists the names of formats for a sentence of help.
pub fn names(formats: impl Iterator<Item = &'static RasterFormat>) -> String {
    formats.map(|format| format.name).collect::<Vec<_>>().join(", ")
}

/// Collects the endings of files of formats, for the pattern that is proposed in place of a folder.
pub fn endings(formats: impl Iterator<Item = &'static RasterFormat>) -> Vec<&'static str> {
    formats.flat_map(|format| format.endings.iter().copied()).collect()
}

/// Files that an argument names, patterns expanded that no shell has. Refuses folders before any work begins, with a pattern for those of
/// their files that end like one of `endings`.
pub fn input_files(flag: &str, files: &[PathBuf], endings: &[&str]) -> hedgehop::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for file in files {
        if file.is_dir() {
            return Err(folder(flag, file, endings));
        }
        found.extend(expanded(flag, file)?);
    }
    Ok(found)
}

/// The files that an argument names, of which there are several if it is a pattern.
pub fn expanded(flag: &str, file: &Path) -> hedgehop::Result<Vec<PathBuf>> {
    if file.exists() {
        return Ok(vec![file.to_owned()]);
    }
    matching(Path::new(""), &file.to_string_lossy()).map_err(|error| match error {
        Error::Configuration(what) => Error::Configuration(format!("{flag} {what}")),
        other => other,
    })
}

/// Builds the error of a folder that was given in place of a file.
fn folder(flag: &str, folder: &Path, endings: &[&str]) -> Error {
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut counts: Vec<(&str, usize)> = endings.iter().map(|ending| (*ending, 0)).collect();
    for name in names.filter(|name| name.is_file()) {
        let ending = name.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        if let Some((_, count)) = counts.iter_mut().find(|(known, _)| ending.as_deref() == Some(known)) {
            *count += 1;
        }
    }

    // Of several kinds the commonest; the first of them in an empty folder.
    let most = counts.iter().rev().max_by_key(|(_, count)| *count);
    let (ending, count) = most.copied().unwrap_or(("*", 0));
    let there = match count {
        0 => String::new(),
        1 => " (1 file there)".to_owned(),
        count => format!(" ({count} files there)"),
    };

    Error::Configuration(format!(
        "{} is a folder; {flag} takes files, such as {flag} \"{}\"{there}",
        folder.display(),
        folder.join(format!("*.{ending}")).display()
    ))
}

/// Refuses an output that would take the place of an input.
pub fn check_no_input(flag: &str, output: &Path, inputs: &[&Path]) -> hedgehop::Result<()> {
    let Ok(target) = output.canonicalize() else { return Ok(()) };
    let is_target = |input: &&&Path| input.canonicalize().is_ok_and(|input| input == target);
    match inputs.iter().find(is_target) {
        Some(input) => Err(Error::Configuration(format!(
            "{flag} would replace {}, which is an input; write to another file or folder",
            input.display()
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn byte_suffixes_are_powers_of_1024() {
        assert_eq!(bytes("512M"), Ok(512 << 20));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("1.5g"), Ok(3 << 29));
        assert_eq!(bytes("4096"), Ok(4096));
        for wrong in ["", "M", "-1", "1X", "0", "1e30T", "nan", "5 5"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn an_instruction_set_is_for_scan_planes_alone() {
        let check = |engine, simd| Instructions { engine, simd }.check();
        let refusal = check(EngineName::Reference, Some(Isa::PORTABLE)).unwrap_err().to_string();
        assert!(refusal.contains("--engine reference"), "{refusal}");
        for (engine, simd) in [
            (EngineName::Reference, None),
            (EngineName::Planes, None),
            (EngineName::Planes, Some(Isa::PORTABLE)),
        ] {
            assert!(check(engine, simd).is_ok(), "{engine:?} {simd:?}");
        }
    }

    #[test]
    fn sizes_are_bounded() {
        assert_eq!(size("640x360"), Ok(Size { width: 640, height: 360 }));
        for wrong in ["640", "0x5", "5x-1", "99999x5", "x", "640x360x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_folder_is_answered_with_a_pattern_for_its_files() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = || {
            let files = [folder.path().to_owned()];
            input_files("--elevation", &files, &endings(elevation_formats())).unwrap_err().to_string()
        };
        assert!(refusal().contains("is a folder") && refusal().ends_with("*.tif\""), "{}", refusal());
        for name in ["a.HGT", "b.hgt", "c.tif", "notes.txt"] {
            std::fs::write(folder.path().join(name), b"").unwrap();
        }
        assert!(refusal().ends_with("*.hgt\" (2 files there)"), "{}", refusal());

        let pattern = [folder.path().join("?.*")];
        assert_eq!(input_files("--elevation", &pattern, &endings(elevation_formats())).unwrap().len(), 3);
        let pattern = [folder.path().join("*.laz")];
        let error = input_files("--cloud", &pattern, &["laz"]).unwrap_err().to_string();
        assert!(error.starts_with("--cloud ") && error.contains("no file matches"), "{error}");
    }

    #[test]
    fn endings_are_proposed_with_the_commonest_first() {
        assert_eq!(endings(imagery_formats()), ["tif", "tiff", "jpg", "jpeg", "png"]);
        let elevation = endings(elevation_formats());
        assert_eq!((elevation.len(), elevation[0], elevation[13]), (14, "tif", "png"));
    }

    #[test]
    fn lists_have_the_right_length_and_order() {
        assert_eq!(bounding_box("-10.5,-20,30,40"), Ok([-10.5, -20.0, 30.0, 40.0]));
        assert!(bounding_box("30,0,10,5").is_err());
        assert!(bounding_box("1,2,3").is_err());
        assert_eq!(bands("3,2,1"), Ok([3, 2, 1]));
        assert!(bands("0,1,2").is_err());
        assert_eq!(attitude("-3600,90,720"), Ok([-3600.0, 90.0, 720.0]));
        for wrong in ["0,91,0", "1e300,0,0", "0,0,-3601"] {
            assert!(attitude(wrong).is_err(), "{wrong}");
        }
        assert!(sun("180,40").is_ok() && sun("1e300,40").is_err());
        assert!(sun("2026-06-21T09:30Z").is_ok() && sun("2026-06-21T09:30").is_err());
        assert!(position("1,2,inf").is_err() && position("1e308,0,0").is_err());
        assert!(not_negative("0").is_ok() && not_negative("-10").is_err());
    }
}
