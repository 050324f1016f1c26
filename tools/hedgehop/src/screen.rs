//! Screen of every camera, from flags.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Value, json};

use crate::args;
use hedgehop::encode::read_ray_table;
use hedgehop::space::{Attitude, Camera, Pose, Screen};
use hedgehop::{Error, Result, Size};

/// Fields of view where nothing says otherwise, degrees.
const PLANAR_HFOV: f64 = 60.0;
const CYLINDRICAL_HFOV: f64 = 180.0;
const EQUIRECTANGULAR: (f64, f64) = (360.0, 180.0);
const FISHEYE_FOV: f64 = 180.0;

/// Fields of view of planar screens, degrees: beyond, a picture is mostly its own edge.
pub const PLANAR_RANGE: std::ops::RangeInclusive<f64> = 0.01..=175.0;

/// Picture sizes where nothing says otherwise.
const WIDE: Size = Size { width: 1280, height: 720 };
const SQUARE: Size = Size { width: 1024, height: 1024 };
/// Pixels per degree of an equirectangular picture.
const PER_DEGREE: f64 = 4.0;

/// Flags of the screen that the picture is projected on.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Screen")]
pub struct ScreenArgs {
    /// planar, cylindrical, equirectangular, fisheye, orthographic (straight down, north up), or table:FILE.exr (a
    /// direction for every pixel)
    #[arg(long, value_name = "KIND", default_value = "planar", value_parser = ScreenKind::parse)]
    pub screen: ScreenKind,

    /// Horizontal field of view, a fisheye's across its circle, degrees [default: 60 where the path gives none;
    /// cylindrical 180, equirectangular 360, fisheye 180]
    #[arg(long, value_name = "DEGREES", value_parser = args::field_of_view, allow_negative_numbers = true)]
    pub hfov: Option<f64>,

    /// Vertical field of view of an equirectangular screen, degrees [default: 180]
    #[arg(long, value_name = "DEGREES", value_parser = args::field_of_view, allow_negative_numbers = true)]
    pub vfov: Option<f64>,

    /// Ground that the width of an orthographic picture covers, metres
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    pub ground_width: Option<f64>,

    /// One of several screens around the eye: its attitude against the aircraft's axes, degrees [default: 0,0,0]
    #[arg(long, value_name = "YAW,PITCH,ROLL", value_parser = args::attitude, allow_hyphen_values = true)]
    pub channel: Option<[f64; 3]>,

    /// Picture size, pixels [default: 1280x720; equirectangular 1440x720, fisheye and orthographic 1024x1024, the size
    /// of a table]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = args::size)]
    pub size: Option<Size>,
}

/// Screens as users name them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum ScreenKind {
    /// A plane
    #[default]
    Planar,
    /// An upright cylinder
    Cylindrical,
    /// Azimuth by elevation
    Equirectangular,
    /// A dome
    Fisheye,
    /// Parallel rays
    Orthographic,
    /// A direction for every pixel, from this file
    Table(PathBuf),
}

impl ScreenKind {
    fn parse(text: &str) -> Result<Self, String> {
        match text {
            "planar" => Ok(Self::Planar),
            "cylindrical" => Ok(Self::Cylindrical),
            "equirectangular" => Ok(Self::Equirectangular),
            "fisheye" => Ok(Self::Fisheye),
            "orthographic" => Ok(Self::Orthographic),
            _ => match text.strip_prefix("table:").filter(|file| !file.is_empty()) {
                Some(file) => Ok(Self::Table(PathBuf::from(file))),
                None => {
                    Err("want planar, cylindrical, equirectangular, fisheye, orthographic or table:FILE.exr"
                        .into())
                }
            },
        }
    }
}

/// The screen of all cameras of a run.
#[derive(Debug, Clone)]
pub struct Setup {
    /// `None`: planar, with the field of view of each pose.
    screen: Option<Screen>,
    /// Field of view of planar screens where the path gives none, degrees.
    pub hfov: f64,
    /// Pixels.
    pub size: Size,
    channel: Attitude,
    /// Coefficients k₁ and k₂ of a planar screen's lens.
    distortion: [f64; 2],
}

impl ScreenArgs {
    /// The table of rays, if it is one.
    pub fn table(&self) -> Option<&Path> {
        match &self.screen {
            ScreenKind::Table(file) => Some(file),
            _ => None,
        }
    }

    /// Puts the flags together; reads the table of rays.
    ///
    /// # Errors
    /// Flags that do not belong to the screen; angles that it cannot show; a table that is none.
    pub fn setup(&self) -> Result<Setup> {
        self.check_flags()?;
        let screen = self.chosen()?;
        if let Some(screen) = &screen {
            screen.check()?;
        }
        let [yaw, pitch, roll] = self.channel.unwrap_or_default();
        Ok(Setup {
            size: self.size.unwrap_or_else(|| default_size(screen.as_ref())),
            hfov: if screen.is_none() { self.hfov.unwrap_or(PLANAR_HFOV) } else { PLANAR_HFOV },
            screen,
            channel: Attitude { yaw, pitch, roll },
            distortion: [0.0; 2],
        })
    }

    fn chosen(&self) -> Result<Option<Screen>> {
        Ok(Some(match &self.screen {
            ScreenKind::Planar => return Ok(None),
            ScreenKind::Cylindrical => Screen::Cylindrical { hfov: self.hfov.unwrap_or(CYLINDRICAL_HFOV) },
            ScreenKind::Equirectangular => Screen::Equirectangular {
                hfov: self.hfov.unwrap_or(EQUIRECTANGULAR.0),
                vfov: self.vfov.unwrap_or(EQUIRECTANGULAR.1),
            },
            ScreenKind::Fisheye => Screen::Fisheye { fov: self.hfov.unwrap_or(FISHEYE_FOV) },
            ScreenKind::Table(file) => Screen::Table(Arc::new(read_ray_table(file)?)),
            ScreenKind::Orthographic => Screen::Orthographic {
                width: self.ground_width.ok_or_else(|| {
                    Error::Configuration(
                        "--screen orthographic needs --ground-width METRES: what the picture's width covers"
                            .into(),
                    )
                })?,
            },
        }))
    }

    fn check_flags(&self) -> Result<()> {
        let refuse = |what: &str| Err(Error::Configuration(what.to_owned()));
        if self.vfov.is_some() && self.screen != ScreenKind::Equirectangular {
            return refuse(
                "--vfov goes with --screen equirectangular; on other screens --hfov and --size decide how high the picture sees",
            );
        }
        if self.ground_width.is_some() && self.screen != ScreenKind::Orthographic {
            return refuse("--ground-width goes with --screen orthographic; other screens take --hfov");
        }

        match (&self.screen, self.hfov) {
            (ScreenKind::Orthographic, Some(_)) => refuse(
                "parallel rays have no --hfov; --ground-width says how much an orthographic picture covers",
            ),
            (ScreenKind::Table(_), Some(_)) => {
                refuse("--hfov has no meaning with a table of rays, which holds the directions itself")
            }
            (ScreenKind::Planar, Some(hfov)) if !PLANAR_RANGE.contains(&hfov) => {
                Err(Error::Configuration(format!(
                    "--hfov {hfov}: a planar screen sees {} to {}°; --screen cylindrical, fisheye or equirectangular sees more",
                    PLANAR_RANGE.start(),
                    PLANAR_RANGE.end()
                )))
            }
            _ => Ok(()),
        }
    }
}

fn default_size(screen: Option<&Screen>) -> Size {
    let pixels = |degrees: f64| (degrees * PER_DEGREE).round().max(1.0) as u32;
    match screen {
        None | Some(Screen::Planar { .. } | Screen::Lens { .. } | Screen::Cylindrical { .. }) => WIDE,
        Some(Screen::Equirectangular { hfov, vfov }) => Size { width: pixels(*hfov), height: pixels(*vfov) },
        Some(Screen::Fisheye { .. } | Screen::Orthographic { .. }) => SQUARE,
        Some(Screen::Table(table)) => Size { width: table.size().x, height: table.size().y },
    }
}

impl Setup {
    /// The same behind a lens with radial distortion.
    ///
    /// # Errors
    /// A screen that is no plane has no such lens.
    pub fn behind_lens(self, distortion: [f64; 2]) -> Result<Self> {
        match &self.screen {
            Some(screen) if distortion != [0.0; 2] => Err(Error::Configuration(format!(
                "--distortion (distortion in a scene's [picture]) is of planar screens; a screen of kind {} has its own mapping",
                screen.name()
            ))),
            _ => Ok(Self { distortion, ..self }),
        }
    }

    /// Whether fields of view in the path mean something.
    pub fn takes_hfov_from_path(&self) -> bool {
        self.screen.is_none()
    }

    /// Whether the picture is projected on a plane, through a lens or not.
    pub fn is_planar(&self) -> bool {
        self.screen.is_none()
    }

    /// Whether the picture is a map, which looks straight down whatever the aircraft does.
    pub fn is_map(&self) -> bool {
        matches!(self.screen, Some(Screen::Orthographic { .. }))
    }

    /// Whether rays come from a table, of which nobody knows where a point is.
    pub fn is_table(&self) -> bool {
        matches!(self.screen, Some(Screen::Table(_)))
    }

    /// The camera of an aircraft at `pose`.
    pub fn camera(&self, pose: Pose) -> Camera {
        let planar = match self.distortion {
            [0.0, 0.0] => Screen::Planar { hfov: pose.hfov },
            k => Screen::Lens { hfov: pose.hfov, k },
        };
        let screen = self.screen.clone().unwrap_or(planar);
        Camera::with_channel(pose, self.channel, screen, self.size.width, self.size.height)
    }

    /// Returns the screen's part of the record of what made a sequence.
    pub fn record(&self) -> Value {
        let Attitude { yaw, pitch, roll } = self.channel;
        json!({
            "kind": self.screen.as_ref().map_or_else(|| "planar".to_owned(), ToString::to_string),
            "default_hfov_deg": self.takes_hfov_from_path().then_some(self.hfov),
            "channel_deg": [yaw, pitch, roll],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(args: &ScreenArgs) -> String {
        args.setup().unwrap_err().to_string()
    }

    fn of(kind: &str) -> ScreenArgs {
        ScreenArgs { screen: ScreenKind::parse(kind).unwrap(), ..ScreenArgs::default() }
    }

    #[test]
    fn screens_have_names_and_defaults() {
        let size = |kind: &str| of(kind).setup().unwrap().size.to_string();
        assert_eq!(size("planar"), "1280x720");
        assert_eq!(size("equirectangular"), "1440x720");
        assert_eq!(size("fisheye"), "1024x1024");
        let kind = |args: ScreenArgs| args.setup().unwrap().record()["kind"].clone();
        assert_eq!(kind(of("equirectangular")), "equirectangular hfov_deg=360 vfov_deg=180");
        assert_eq!(kind(ScreenArgs { hfov: Some(90.0), ..of("cylindrical") }), "cylindrical hfov_deg=90");
        for wrong in ["flat", "table", "table:", "Planar", ""] {
            assert!(ScreenKind::parse(wrong).unwrap_err().contains("table:FILE.exr"), "{wrong}");
        }
    }

    #[test]
    fn flags_that_do_not_belong_together_name_the_one_that_does() {
        let some = Some(100.0);
        assert!(message(&of("orthographic")).contains("--ground-width METRES"));
        assert!(message(&ScreenArgs { hfov: some, ..of("orthographic") }).contains("--ground-width"));
        assert!(message(&ScreenArgs { ground_width: some, ..of("fisheye") }).contains("--hfov"));
        assert!(message(&ScreenArgs { vfov: some, ..of("planar") }).contains("equirectangular"));
        assert!(message(&ScreenArgs { hfov: some, ..of("table:x.exr") }).contains("table of rays"));
        assert!(message(&ScreenArgs { hfov: Some(180.0), ..of("planar") }).contains("cylindrical"));
        assert!(message(&ScreenArgs { vfov: Some(190.0), ..of("equirectangular") }).contains("--vfov"));
        assert!(message(&of("table:no/such.exr")).contains("no/such.exr"));
    }

    #[test]
    fn a_planar_screen_follows_the_path() {
        let setup = of("planar").setup().unwrap();
        let pose = Pose { eye: glam::DVec3::ZERO, attitude: Attitude::default(), hfov: 31.0 };
        assert_eq!(setup.camera(pose).screen(), &Screen::Planar { hfov: 31.0 });
    }
}
