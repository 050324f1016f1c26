//! The tables `[picture]` and `[hud]`: what is made of light, and what is drawn over it.

use serde::Deserialize;
use toml::Spanned;

use hedgehop_base::document::Reading;
use hedgehop_base::error::{Error, Result};

/// Stops of exposure, either way.
const MOST_STOPS: f64 = 16.0;

/// Exponents of gamma curves.
const GAMMAS: std::ops::RangeInclusive<f64> = 1.0..=4.0;

/// Share of their light that the corners may lose.
const MOST_VIGNETTE: f64 = 0.95;

/// Coefficients of distortion, either way: lenses have less.
const MOST_DISTORTION: f64 = 10.0;

/// Steps from light to a picture. The default changes nothing: 8-bit sRGB of the light as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finish {
    /// Factor on light, as a power of two, −16…16.
    pub exposure: f64,
    /// Tone mapping of bright light.
    pub tone: Tone,
    /// Codes are the 1/gamma-th power of light, 1…4; `None`: the curve of sRGB.
    pub gamma: Option<f64>,
    /// Rounding of codes.
    pub dither: Dither,
    /// Share of their light that the picture's corners lose, 0…0.95.
    pub vignette: f64,
    /// Coefficients k₁ and k₂ of a planar screen's radial distortion, ±10, radii in units of the focal length.
    pub distortion: [f64; 2],
    /// Rays per pixel along each side: 1, 2 or 4.
    pub antialias: u32,
    /// Time for which the shutter is open: degrees of a turn that takes from frame to frame, 0…360.
    pub shutter: f64,
}

/// Curves for bright light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tone {
    /// Light as it is; what is brighter than white is white.
    #[default]
    None,
    /// `x·(2.51x + 0.03) / (x·(2.43x + 0.59) + 0.14)` for each channel (Narkowicz 2015, a fit to the curve of the Academy Color Encoding System): dark
    /// tones darker, bright ones rolled off towards white.
    Filmic,
}

/// Ways to round codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dither {
    /// Rounds to the nearest.
    #[default]
    None,
    /// Up or down by the thresholds of Bayer (1973) in squares of 8 × 8 pixels, so that slow gradients show no bands.
    Ordered,
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            tone: Tone::None,
            gamma: None,
            dither: Dither::None,
            vignette: 0.0,
            distortion: [0.0; 2],
            antialias: 1,
            shutter: 0.0,
        }
    }
}

impl Finish {
    /// Whether codes are other than those of the light as it is.
    pub fn is_developed(&self) -> bool {
        let plain = Self::default();
        (self.exposure, self.tone, self.gamma, self.dither, self.vignette)
            != (plain.exposure, plain.tone, plain.gamma, plain.dither, plain.vignette)
    }

    /// Whether light of one pixel comes from several rays.
    pub fn gathers(&self) -> bool {
        self.antialias > 1 || self.shutter > 0.0
    }

    /// Refuses values outside the ranges of the fields.
    ///
    /// # Errors
    /// [`Error::Configuration`], a sentence that names the flag and its range.
    pub fn check(&self) -> Result<()> {
        let finite = |value: f64, most: f64| value.abs() <= most;
        let within = [
            (finite(self.exposure, MOST_STOPS), "the exposure (--exposure) must be -16 to 16 stops"),
            (self.gamma.is_none_or(|gamma| GAMMAS.contains(&gamma)), "gamma (--gamma) must be 1 to 4"),
            (
                (0.0..=MOST_VIGNETTE).contains(&self.vignette),
                "the vignette (--vignette) must be a share of 0 to 0.95",
            ),
            (
                self.distortion.into_iter().all(|k| finite(k, MOST_DISTORTION)),
                "coefficients of the distortion (--distortion) must lie between -10 and 10",
            ),
            (matches!(self.antialias, 1 | 2 | 4), "anti-aliasing (--antialias) takes 1, 2 or 4 rays a side"),
            ((0.0..=360.0).contains(&self.shutter), "the shutter (--shutter) must be open 0 to 360 degrees"),
        ];

        match within.iter().find(|(holds, _)| !holds) {
            Some((_, sentence)) => Err(Error::Configuration((*sentence).to_owned())),
            None => Ok(()),
        }
    }
}

/// Instruments that are drawn over pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Hud {
    /// The horizon, and where the view's axis points.
    pub horizon: bool,
    /// Heading, by number and tape.
    pub heading: bool,
    /// Altitudes above the datum and above the ground.
    pub altitude: bool,
    /// Speed over ground and rate of climb.
    pub speed: bool,
    /// The frame's number and time.
    pub time: bool,
    /// A small map with the path and the own position.
    pub map: bool,
}

impl Hud {
    /// All instruments.
    pub const ALL: Self =
        Self { horizon: true, heading: true, altitude: true, speed: true, time: true, map: true };

    /// Names of instruments, in the order of the fields.
    pub const NAMES: [&'static str; 6] = ["horizon", "heading", "altitude", "speed", "time", "map"];

    /// The instruments of some names; the first name that is none of [`Self::NAMES`] otherwise.
    pub fn of_names<'n>(names: impl IntoIterator<Item = &'n str>) -> std::result::Result<Self, &'n str> {
        let mut hud = Self::default();
        for name in names {
            let index = Self::NAMES.iter().position(|known| *known == name).ok_or(name)?;
            let fields = [
                &mut hud.horizon,
                &mut hud.heading,
                &mut hud.altitude,
                &mut hud.speed,
                &mut hud.time,
                &mut hud.map,
            ];
            if let Some(field) = fields.into_iter().nth(index) {
                *field = true;
            }
        }
        Ok(hud)
    }

    /// The names of what is shown.
    pub fn names(&self) -> Vec<&'static str> {
        let shown = [self.horizon, self.heading, self.altitude, self.speed, self.time, self.map];
        Self::NAMES.into_iter().zip(shown).filter(|(_, shown)| *shown).map(|(name, _)| name).collect()
    }

    /// Whether nothing is shown.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [picture]")]
pub(super) struct PictureTable {
    exposure_ev: Option<Spanned<f64>>,
    tone: Option<Spanned<String>>,
    gamma: Option<Spanned<f64>>,
    dither: Option<Spanned<String>>,
    vignette: Option<Spanned<f64>>,
    distortion: Option<Spanned<[f64; 2]>>,
    antialias: Option<Spanned<u32>>,
    shutter_deg: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "the table [hud]")]
pub(super) struct HudTable {
    show: Option<Vec<Spanned<String>>>,
}

impl std::str::FromStr for Tone {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text {
            "none" => Ok(Self::None),
            "filmic" => Ok(Self::Filmic),
            _ => Err("must be none or filmic"),
        }
    }
}

impl std::str::FromStr for Dither {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text {
            "none" => Ok(Self::None),
            "ordered" => Ok(Self::Ordered),
            _ => Err("must be none or ordered"),
        }
    }
}

impl PictureTable {
    pub(super) fn read(&self, reading: &Reading<'_>) -> Result<Finish> {
        let plain = Finish::default();
        let number = |key: &str, value: &Option<Spanned<f64>>, range: [f64; 2], want: &str| {
            let holds = |value: f64| (range[0]..=range[1]).contains(&value);
            value.as_ref().map(|value| reading.number(key, value, holds, want)).transpose()
        };
        let gammas = [*GAMMAS.start(), *GAMMAS.end()];
        if let Some(distortion) = self
            .distortion
            .as_ref()
            .filter(|given| !given.get_ref().iter().all(|k| k.abs() <= MOST_DISTORTION))
        {
            let what =
                format!("distortion must be [k1, k2] between -10 and 10, not {:?}", distortion.get_ref());
            return Err(reading.wrong(distortion.span(), what));
        }
        if let Some(antialias) = self.antialias.as_ref().filter(|given| !matches!(given.get_ref(), 1 | 2 | 4))
        {
            let what = format!("antialias must be 1, 2 or 4, not {}", antialias.get_ref());
            return Err(reading.wrong(antialias.span(), what));
        }

        Ok(Finish {
            exposure: number(
                "exposure_ev",
                &self.exposure_ev,
                [-MOST_STOPS, MOST_STOPS],
                "must be -16 to 16 stops",
            )?
            .unwrap_or(plain.exposure),
            tone: choice(reading, "tone", self.tone.as_ref())?,
            gamma: number("gamma", &self.gamma, gammas, "must be 1 to 4")?,
            dither: choice(reading, "dither", self.dither.as_ref())?,
            vignette: number("vignette", &self.vignette, [0.0, MOST_VIGNETTE], "must be 0 to 0.95")?
                .unwrap_or(plain.vignette),
            distortion: self.distortion.as_ref().map_or(plain.distortion, |given| *given.get_ref()),
            antialias: self.antialias.as_ref().map_or(plain.antialias, |given| *given.get_ref()),
            shutter: number("shutter_deg", &self.shutter_deg, [0.0, 360.0], "must be 0 to 360 degrees")?
                .unwrap_or(plain.shutter),
        })
    }
}

/// Returns the value that a word stands for; nothing where it is not given.
fn choice<T>(reading: &Reading<'_>, key: &str, given: Option<&Spanned<String>>) -> Result<T>
where
    T: Default + std::str::FromStr<Err = &'static str>,
{
    given.map_or(Ok(T::default()), |word| {
        let wrong = |want| reading.wrong(word.span(), format!("{key} {want}, not {:?}", word.get_ref()));
        word.get_ref().parse().map_err(wrong)
    })
}

impl HudTable {
    pub(super) fn read(&self, reading: &Reading<'_>) -> Result<Hud> {
        let Some(names) = &self.show else { return Ok(Hud::ALL) };
        Hud::of_names(names.iter().map(|name| name.get_ref().as_str())).map_err(|unknown| {
            let span = names.iter().find(|name| name.get_ref() == unknown).map_or(0..0, Spanned::span);
            let what = format!("show takes {}, not {unknown:?}", Hud::NAMES.join(", "));
            reading.wrong(span, what)
        })
    }
}
