//! Flags of views without a path, of which data sets are made.

use clap::{Args, ValueEnum};
use glam::DVec2;
use serde_json::{Value, json};

use crate::args;
use hedgehop::flight::{GridViews, OrbitViews, RandomViews, Track, ViewLayout, Views};
use hedgehop::voxel::Grid;
use hedgehop::{Error, Result};

/// Pitches that random views have, degrees, unless flags say otherwise.
const PITCHES: [f64; 2] = [-60.0, -10.0];
/// Headings of random views, degrees, unless flags say otherwise.
const ALL_AROUND: [f64; 2] = [0.0, 360.0];
/// Pitch of a grid's views, degrees, unless flags say otherwise.
const DOWN: f64 = -90.0;

/// Flags of views without a path.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Views")]
pub struct ViewArgs {
    /// Views without a path: at random places, from a grid of places, or on an orbit around --look-at
    #[arg(long, value_enum, value_name = "HOW")]
    pub views: Option<ViewKind>,

    /// Number of views: of random in all, of orbit on each circle
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    pub count: Option<u64>,

    /// Seed of random views: the same one gives the same views, and a larger --count more of them [default: 0]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// Heights above the ground and what stands on it, of orbit above the place, metres: LOW,HIGH of random, each one of grid and orbit
    #[arg(long, value_name = "METRES,…", value_parser = height, value_delimiter = ',', allow_hyphen_values = true)]
    pub heights: Vec<f64>,

    /// Pitches, degrees: LOW,HIGH of random, each one of grid [default: random -60,-10, grid -90]
    #[arg(long, value_name = "DEGREES,…", value_parser = pitch, value_delimiter = ',', allow_hyphen_values = true)]
    pub pitches: Vec<f64>,

    /// Headings clockwise from true north, degrees: LOW,HIGH of random, each one of grid [default: random 0,360, grid 0]
    #[arg(long, value_name = "DEGREES,…", value_parser = heading, value_delimiter = ',', allow_hyphen_values = true)]
    pub headings: Vec<f64>,

    /// Distance of a grid's places, metres
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    pub spacing: Option<f64>,

    /// Radius of orbits, metres
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    pub radius: Option<f64>,

    /// Area of random and gridded eyes, metres in the database's reference system [default: all]
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    pub bbox: Option<[f64; 4]>,
}

/// Arrangements of views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ViewKind {
    /// Places, heights and directions by chance
    Random,
    /// Places side by side, looking straight down unless --pitches says otherwise
    Grid,
    /// Circles around --look-at
    Orbit,
}

/// A flag, and the arrangements that it is for.
struct FlagUse {
    /// Flag with an example of its value.
    flag: &'static str,
    is_given: bool,
    /// Arrangements that have a use for it.
    takes: &'static [ViewKind],
    /// Arrangements that do not go without it.
    needs: &'static [ViewKind],
}

impl FlagUse {
    /// The flag without its value.
    fn name(&self) -> &'static str {
        self.flag.split(' ').next().unwrap_or(self.flag)
    }

    /// Names of the arrangements that it may be given to.
    fn takers(&self) -> String {
        let names: Vec<_> = self.takes.iter().map(|kind| kind.name()).collect();
        names.join(" or ")
    }
}

impl ViewKind {
    fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Grid => "grid",
            Self::Orbit => "orbit",
        }
    }
}

impl ViewArgs {
    /// Returns the views of a kind that flags ask for: over a grid of voxels, looking at a target if there is one.
    ///
    /// # Errors
    /// A flag that is missing, or that the arrangement has no use for; ranges that are none.
    pub fn views(&self, kind: ViewKind, grid: &Grid, target: Option<Track>, hfov: f64) -> Result<Views> {
        self.check(kind, target.is_some())?;

        let count = self.count.unwrap_or(1);
        let layout = match kind {
            ViewKind::Random => ViewLayout::Random(RandomViews {
                count,
                seed: self.seed.unwrap_or_default(),
                heights: range("--heights", &self.heights, [1.0; 2])?,
                pitches: range("--pitches", &self.pitches, PITCHES)?,
                headings: range("--headings", &self.headings, ALL_AROUND)?,
            }),
            ViewKind::Grid => ViewLayout::Grid(GridViews {
                spacing: self.spacing.unwrap_or(f64::INFINITY),
                heights: self.heights.clone(),
                pitches: each(&self.pitches, DOWN),
                headings: each(&self.headings, 0.0),
            }),
            ViewKind::Orbit => ViewLayout::Orbit(OrbitViews {
                count,
                radius: self.radius.unwrap_or(1.0),
                heights: self.heights.clone(),
            }),
        };

        let area = self.bbox.map_or([grid.origin, grid.far_corner()], |[west, south, east, north]| {
            [DVec2::new(west, south), DVec2::new(east, north)]
        });
        Ok(Views { layout, area, target, hfov })
    }

    /// Records what decides views; their number decides none of the random ones.
    pub fn record(&self, settings: &mut Value) {
        let Some(kind) = self.views else { return };
        let mut views = json!({ "kind": kind.name(), "heights_m": self.heights });
        let list = |values: &[f64]| (!values.is_empty()).then(|| json!(values));
        let said = [
            ("count", self.count.filter(|_| kind != ViewKind::Random).map(Value::from)),
            ("seed", (kind == ViewKind::Random).then(|| json!(self.seed.unwrap_or_default()))),
            ("pitches_deg", list(&self.pitches)),
            ("headings_deg", list(&self.headings)),
            ("spacing_m", self.spacing.map(Value::from)),
            ("radius_m", self.radius.map(Value::from)),
            ("bbox", self.bbox.map(|bbox| json!(bbox))),
        ];
        for (key, value) in said {
            if let Some(value) = value {
                views[key] = value;
            }
        }
        settings["views"] = views;
    }

    /// Tells which flags are given, but for --look-at, and to which arrangements they may be, or must.
    fn uses(&self) -> [FlagUse; 8] {
        use ViewKind::{Grid, Orbit, Random};
        let told = |flag, is_given, takes, needs| FlagUse { flag, is_given, takes, needs };
        let all: &[ViewKind] = &[Random, Grid, Orbit];
        [
            told("--heights METRES,…", !self.heights.is_empty(), all, all),
            told("--count N", self.count.is_some(), &[Random, Orbit], &[Random, Orbit]),
            told("--spacing METRES", self.spacing.is_some(), &[Grid], &[Grid]),
            told("--radius METRES", self.radius.is_some(), &[Orbit], &[Orbit]),
            told("--seed N", self.seed.is_some(), &[Random], &[]),
            told("--pitches DEGREES,…", !self.pitches.is_empty(), &[Random, Grid], &[]),
            told("--headings DEGREES,…", !self.headings.is_empty(), &[Random, Grid], &[]),
            told("--bbox W,S,E,N", self.bbox.is_some(), &[Random, Grid], &[]),
        ]
    }

    /// Refuses flags of views where there are none.
    pub fn check_unused(&self) -> Result<()> {
        match self.uses().into_iter().find(|used| used.is_given) {
            Some(used) => Err(Error::Configuration(format!(
                "{} is of --views {}; give --views, or leave it out",
                used.name(),
                used.takers()
            ))),
            None => Ok(()),
        }
    }

    fn check(&self, kind: ViewKind, has_target: bool) -> Result<()> {
        let refuse = |what: String| Err(Error::Configuration(what));
        let name = kind.name();

        for used in self.uses() {
            if !used.is_given && used.needs.contains(&kind) {
                return refuse(format!("--views {name} needs {}", used.flag));
            }
            if used.is_given && !used.takes.contains(&kind) {
                return refuse(format!(
                    "--views {name} has no use for {}, which is of --views {}; leave it out",
                    used.name(),
                    used.takers()
                ));
            }
        }

        if kind == ViewKind::Orbit && !has_target {
            return refuse("--views orbit needs --look-at X,Y[,Z]".into());
        }
        if has_target && self.have_directions() {
            return refuse(
                "--pitches and --headings are of views that do not look at a place; leave them out, or --look-at".into(),
            );
        }
        if kind != ViewKind::Orbit && self.heights.iter().any(|height| *height <= 0.0) {
            return refuse(format!("--heights of --views {name} are above the ground; give some above 0"));
        }
        Ok(())
    }

    /// Whether flags say which way views look.
    pub fn have_directions(&self) -> bool {
        !(self.pitches.is_empty() && self.headings.is_empty())
    }
}

/// A range of one value or two, or the usual one.
fn range(flag: &str, values: &[f64], usual: [f64; 2]) -> Result<[f64; 2]> {
    match *values {
        [] => Ok(usual),
        [only] => Ok([only, only]),
        [low, high] if low <= high => Ok([low, high]),
        _ => Err(Error::Configuration(format!(
            "{flag} of --views random is a range; give LOW,HIGH, the lower value first, or one value"
        ))),
    }
}

fn each(values: &[f64], usual: f64) -> Vec<f64> {
    if values.is_empty() { vec![usual] } else { values.to_vec() }
}

fn height(text: &str) -> Result<f64, String> {
    bounded(text, 1.0e6, "metres, at most 10⁶")
}

fn pitch(text: &str) -> Result<f64, String> {
    bounded(text, 90.0, "degrees from -90, straight down, to 90")
}

fn heading(text: &str) -> Result<f64, String> {
    bounded(text, 720.0, "degrees, at most two turns")
}

fn bounded(text: &str, most: f64, wanted: &str) -> Result<f64, String> {
    let value = args::number(text).ok().filter(|value| value.abs() <= most);
    value.ok_or_else(|| format!("want {wanted}, with commas between"))
}
