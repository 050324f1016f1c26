//! Tones of a cyclic code in flight over flat ground: how true they are, how they scintillate, and what they take.
//!
//! ```text
//! for each frame and each way to average:
//!     residual = tone − exact mean over the footprint           greys of 256, in each pixel of the window
//!     error    = shade shown − shade of the exact mean          of 256 shades, and of 32
//!     change   = residual − residual of the frame before        in the same pixel
//! ```
//!
//! The exact mean is of the ground that the pixel sees in that frame, so that motion is compensated. Source: the accuracy test of
//! the study of cyclic codes for surface texture (AFHRL on ACTES).

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::report;
use hedgehop::Result;
use hedgehop_texture::{Averaging, CyclicCode, PixelTones, Run, Settings, Shades, ToneErrors, Window};

/// Slices of footprints whose tones others are judged by.
const REFERENCE: Averaging = Averaging::Exact(256);

/// Pictures of which the fastest is told of.
const TIMED_PICTURES: u32 = 3;

/// Pixels of the study's flight, and their exact tones by frame.
struct Flight {
    window: Window,
    tones: PixelTones,
    exact: Vec<Vec<f64>>,
    /// All of 256 shades, and 32.
    shades: [Shades; 2],
}

/// One way to average, and what the report calls it.
struct Way {
    name: &'static str,
    averaging: Averaging,
}

/// Measure tones of texture against exact means, in a window of 40 × 30 pixels at 200 knots
#[derive(Debug, clap::Args)]
pub struct TextureArgs {
    /// Frames
    #[arg(long, value_name = "N", default_value_t = 180, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,

    /// Course, degrees from the lines of the texture's cells
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    course: f64,

    /// Slices of a footprint in the exact way
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=256))]
    slices: u32,

    /// Write everything measured to this file
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,

    /// Write the report of the study's own flight to this file
    #[arg(short, long, value_name = "FILE.txt")]
    output: Option<PathBuf>,
}

/// Errors over pixels, in shades or greys.
#[derive(Debug, Serialize)]
struct ErrorRecord {
    rms: f64,
    worst: f64,
    three_or_more_share: f64,
}

#[derive(Debug, Serialize)]
struct AveragingRecord {
    averaging: &'static str,
    /// Errors in shades of 256, and of 32.
    shades: Vec<ErrorRecord>,
    /// Root mean square of residuals in each frame, greys.
    frames_rms: Vec<f64>,
    /// Root mean square of residuals of all frames, greys.
    residual_rms: f64,
    /// Root mean square of changes of residuals from frame to frame, greys.
    change_rms: f64,
    /// Time of a tone on one core, nanoseconds.
    tone_ns: f64,
}

#[derive(Debug, Serialize)]
struct MeasuredTexture {
    frames: u32,
    course_deg: f64,
    slices: u32,
    /// Time of a picture of 640 × 480 pixels in the study's way, one core, milliseconds.
    picture_ms: f64,
    averagings: Vec<AveragingRecord>,
}

/// Runs the mode.
pub fn run(args: &TextureArgs) -> Result<()> {
    // A path that cannot be written to is told before all is measured.
    if let Some(path) = &args.output {
        Run::new(Settings::default())?.write_report(path)?;
    }

    let window = Window { course_deg: args.course, ..Window::OF_THE_STUDY };
    let tones = PixelTones::new(CyclicCode::default())?;
    let exact = (0..args.frames).map(|frame| window.tones(&tones, REFERENCE, frame)).collect();
    let flight = Flight { window, tones, exact, shades: [Shades::new(256, 128)?, Shades::new(32, 101)?] };
    let ways = [
        Way { name: "exact", averaging: Averaging::Exact(args.slices) },
        Way { name: "linear", averaging: Averaging::Linear },
        Way { name: "stepped", averaging: Averaging::Stepped },
        Way { name: "64 samples", averaging: Averaging::Samples(64) },
    ];

    report::line(&format!(
        "{:<11} {:>8} {:>6} {:>8} {:>8} {:>6} {:>8} {:>9} {:>9} {:>9} {:>9}",
        "averaging",
        "256: rms",
        "worst",
        "3 off",
        "32: rms",
        "worst",
        "3 off",
        "residual",
        "frame's",
        "change",
        "ns a tone"
    ));
    let mut averagings = Vec::new();
    for way in ways {
        let record = flight.measured(&way);
        report::line(&record.line());
        averagings.push(record);
    }
    report::line(
        "errors in shades of 256 and of 32; residual of all frames, of the worst, its change from frame to frame, in greys",
    );

    let picture_ms = picture_time()?.as_secs_f64() * 1e3;
    report::line(&format!(
        "a picture of 640 × 480 pixels in the study's way takes {picture_ms:.1} ms on one core; the study took 30 to 40 s"
    ));

    let measured = MeasuredTexture {
        frames: args.frames,
        course_deg: args.course,
        slices: args.slices,
        picture_ms,
        averagings,
    };
    report::json(args.json.as_deref(), &measured)
}

/// Time of the fastest of a few pictures.
fn picture_time() -> Result<Duration> {
    let run = Run::new(Settings::default())?;
    let timed = |frame: u32| {
        let begun = Instant::now();
        std::hint::black_box(run.picture(frame));
        begun.elapsed()
    };
    Ok((0..TIMED_PICTURES).map(timed).min().unwrap_or_default())
}

impl Flight {
    /// Errors of one way to average, over all frames.
    fn measured(&self, way: &Way) -> AveragingRecord {
        let frames = 0..self.exact.len() as u32;
        let begun = Instant::now();
        let shown: Vec<Vec<f64>> =
            frames.map(|frame| self.window.tones(&self.tones, way.averaging, frame)).collect();
        let taken = begun.elapsed();
        let [all_shown, all_exact] = [&shown, &self.exact].map(|frames| frames.concat());
        let shades = self.shades.iter().map(|&it| ToneErrors::of_shades(&all_shown, &all_exact, it).into());

        let residuals: Vec<f64> =
            all_shown.iter().zip(&all_exact).map(|(shown, exact)| shown - exact).collect();
        let frame = (self.window.columns * self.window.lines) as usize;
        let changes = ToneErrors::of_tones(&residuals[frame..], &residuals[..residuals.len() - frame]);
        AveragingRecord {
            averaging: way.name,
            shades: shades.collect(),
            frames_rms: shown
                .iter()
                .zip(&self.exact)
                .map(|(shown, exact)| ToneErrors::of_tones(shown, exact).rms)
                .collect(),
            residual_rms: ToneErrors::of_tones(&all_shown, &all_exact).rms,
            change_rms: changes.rms,
            tone_ns: taken.as_secs_f64() * 1e9 / all_shown.len() as f64,
        }
    }
}

impl From<ToneErrors> for ErrorRecord {
    fn from(errors: ToneErrors) -> Self {
        Self { rms: errors.rms, worst: errors.worst, three_or_more_share: errors.counted }
    }
}

impl AveragingRecord {
    fn line(&self) -> String {
        let shades: Vec<String> = self
            .shades
            .iter()
            .map(|it| format!("{:>8.3} {:>6.0} {:>6.2} %", it.rms, it.worst, 100.0 * it.three_or_more_share))
            .collect();
        let worst = self.frames_rms.iter().copied().fold(0.0, f64::max);
        format!(
            "{:<11} {} {:>9.3} {worst:>9.3} {:>9.3} {:>9.0}",
            self.averaging,
            shades.join(" "),
            self.residual_rms,
            self.change_rms,
            self.tone_ns
        )
    }
}
