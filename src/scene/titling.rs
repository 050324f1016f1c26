//! The tables `[overlay]` and `[[caption]]`: text and figures over a film's pictures.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

use serde::Deserialize;
use toml::Spanned;

use super::Hud;
use crate::flight::FlightTime;
use hedgehop_base::document::Reading;
use hedgehop_base::error::Result;
use hedgehop_base::read_whole_file;

/// Longest text, characters.
const LONGEST_TEXT: usize = 1000;

/// Share of the picture's sides that text keeps clear of.
const MARGINS: RangeInclusive<f64> = 0.0..=0.25;

/// Offsets from UTC that clocks of this world have, hours.
const OFFSETS: RangeInclusive<f64> = -14.0..=14.0;

/// Largest file of a font, bytes; fonts of all Chinese characters have some 20 million.
pub const MOST_FONT_BYTES: u64 = 200_000_000;

/// Latest moment of a caption, seconds.
const LATEST: f64 = 1.0e7;

/// Text and figures over finished pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Titling {
    /// Instruments of the pilot's style.
    pub hud: Hud,
    /// Figures of the film's style.
    pub figures: Figures,
    /// Title over the film's beginning.
    pub title: Option<String>,
    /// Line below the title.
    pub subtitle: Option<String>,
    /// Credits over the film's end.
    pub credits: Option<String>,
    /// Captions, in the order that they were given.
    pub captions: Vec<Caption>,
    /// Files of fonts that have the letters which the program's own has not; the first that has a letter serves.
    pub fonts: Vec<PathBuf>,
    /// Units of the figures.
    pub units: Units,
    /// Offset of the clock shown from UTC, hours, −14…14.
    pub utc_offset: f64,
    /// Share of the picture's sides that text and figures keep clear of, 0…0.25.
    pub margin: f64,
}

impl Default for Titling {
    /// Nothing; text would keep within the safe area of broadcasts (SMPTE ST 2046-1, 2009: 90 % of each side).
    fn default() -> Self {
        Self {
            hud: Hud::default(),
            figures: Figures::default(),
            title: None,
            subtitle: None,
            credits: None,
            captions: Vec::new(),
            fonts: Vec::new(),
            units: Units::default(),
            utc_offset: 0.0,
            margin: 0.05,
        }
    }
}

/// Text over a part of the film.
#[derive(Debug, Clone, PartialEq)]
pub struct Caption {
    /// Moment that it comes.
    pub from: Cue,
    /// Moment that it goes; `None`: after some seconds, or when the next one comes.
    pub to: Option<Cue>,
    /// Text, of one line or several.
    pub text: String,
}

/// Moment of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cue {
    /// Seconds after the film's first frame.
    Film(f64),
    /// Moment of the flight.
    Flight(FlightTime),
}

/// Style of the figures over a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OverlayStyle {
    /// All of [`Figures`], for an audience.
    Film,
    /// All of [`Hud`], for a pilot.
    Pilot,
    /// None of them.
    None,
}

/// Units of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    /// Metres, kilometres an hour, metres a second.
    #[default]
    Metric,
    /// Feet, knots, feet a minute; distances in nautical miles.
    Aviation,
    /// Feet, miles an hour, feet a minute; distances in miles.
    Imperial,
}

/// Figures of the film's style that are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Figures {
    /// The flight's clock, or the time since its first fix.
    pub clock: bool,
    /// Longitude and latitude, or x and y.
    pub place: bool,
    /// Altitude above the datum and above the ground.
    pub altitude: bool,
    /// Speed over ground and rate of climb.
    pub speed: bool,
    /// An arrow to the north.
    pub north: bool,
    /// A bar of a round length on the map.
    pub scale: bool,
    /// A small map with the path and what flies.
    pub map: bool,
    /// Altitude and ground along the path.
    pub profile: bool,
}

impl Figures {
    /// All of them.
    pub const ALL: Self = Self {
        clock: true,
        place: true,
        altitude: true,
        speed: true,
        north: true,
        scale: true,
        map: true,
        profile: true,
    };

    /// Names of figures, in the order of the fields.
    pub const NAMES: [&'static str; 8] =
        ["clock", "place", "altitude", "speed", "north", "scale", "map", "profile"];

    /// Finds the figures of some names.
    ///
    /// # Errors
    /// The first name that is none of [`Self::NAMES`].
    pub fn of_names<'n>(names: impl IntoIterator<Item = &'n str>) -> std::result::Result<Self, &'n str> {
        let mut figures = Self::default();
        for name in names {
            let index = Self::NAMES.iter().position(|known| *known == name).ok_or(name)?;
            let fields = [
                &mut figures.clock,
                &mut figures.place,
                &mut figures.altitude,
                &mut figures.speed,
                &mut figures.north,
                &mut figures.scale,
                &mut figures.map,
                &mut figures.profile,
            ];
            if let Some(field) = fields.into_iter().nth(index) {
                *field = true;
            }
        }
        Ok(figures)
    }

    /// Returns the names of what is drawn.
    pub fn names(&self) -> Vec<&'static str> {
        let Self { clock, place, altitude, speed, north, scale, map, profile } = *self;
        let drawn = [clock, place, altitude, speed, north, scale, map, profile];
        Self::NAMES.into_iter().zip(drawn).filter(|(_, drawn)| *drawn).map(|(name, _)| name).collect()
    }
}

impl Titling {
    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.hud.is_empty() && self.figures == Figures::default() && self.texts().next().is_none()
    }

    /// Returns all texts that somebody wrote.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        let cards = [&self.title, &self.subtitle, &self.credits].into_iter().flatten();
        cards.chain(self.captions.iter().map(|caption| &caption.text)).map(String::as_str)
    }

    /// Shows all figures of a style, and none of another.
    pub fn set_style(&mut self, style: OverlayStyle) {
        let (hud, figures) = match style {
            OverlayStyle::Film => (Hud::default(), Figures::ALL),
            OverlayStyle::Pilot => (Hud::ALL, Figures::default()),
            OverlayStyle::None => (Hud::default(), Figures::default()),
        };
        (self.hud, self.figures) = (hud, figures);
    }

    /// Checks a text that somebody wrote.
    ///
    /// # Errors
    /// A clause that says what is wrong with it.
    pub fn check_text(text: &str) -> std::result::Result<(), String> {
        let is_seen = |letter: char| {
            !letter.is_whitespace() && !matches!(letter, '\u{200B}'..='\u{200F}' | '\u{2060}' | '\u{FEFF}')
        };
        if !text.contains(is_seen) {
            return Err("is empty; write something, or leave it out".into());
        }
        let length = text.chars().count();
        if length > LONGEST_TEXT {
            return Err(format!("has {length} characters, and {LONGEST_TEXT} are the most"));
        }
        match text.chars().find(|letter| letter.is_control() && *letter != '\n') {
            Some(control) => Err(format!(
                "holds the control character U+{:04X}; only line ends may be in it",
                u32::from(control)
            )),
            None => Ok(()),
        }
    }
}

impl FromStr for Units {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text {
            "metric" => Ok(Self::Metric),
            "aviation" => Ok(Self::Aviation),
            "imperial" => Ok(Self::Imperial),
            _ => Err("must be metric, aviation or imperial"),
        }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [overlay]")]
pub(super) struct OverlayTable {
    style: Option<OverlayStyle>,
    show: Option<Spanned<Vec<Spanned<String>>>>,
    title: Option<Spanned<String>>,
    subtitle: Option<Spanned<String>>,
    credits: Option<Spanned<String>>,
    fonts: Option<Vec<Spanned<PathBuf>>>,
    units: Option<Units>,
    utc_offset_hours: Option<Spanned<f64>>,
    margin: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[caption]]")]
pub(super) struct CaptionTable {
    text: Spanned<String>,
    from_s: Option<Spanned<f64>>,
    to_s: Option<Spanned<f64>>,
    film_from_s: Option<Spanned<f64>>,
    film_to_s: Option<Spanned<f64>>,
}

impl OverlayTable {
    /// Reads the table; `hud` is what the table `[hud]` says, `hasher` takes the files of fonts.
    pub fn read(
        self,
        reading: &Reading<'_>,
        hud: Option<Hud>,
        hasher: &mut blake3::Hasher,
    ) -> Result<Titling> {
        let mut titling = Titling::default();
        if let Some(style) = self.style {
            titling.set_style(style);
        }
        if let Some(show) = &self.show {
            titling.figures = self.figures(reading, show)?;
        }
        titling.hud = hud.unwrap_or(titling.hud);

        let text = |key: &str, text: Option<Spanned<String>>| {
            text.map(|text| checked(reading, key, &text)).transpose()
        };
        titling.title = text("title", self.title)?;
        titling.subtitle = text("subtitle", self.subtitle)?;
        titling.credits = text("credits", self.credits)?;

        titling.units = self.units.unwrap_or_default();
        let number = |key: &str, value: &Option<Spanned<f64>>, range: RangeInclusive<f64>| {
            let want = format!("must be {} to {}", range.start(), range.end());
            value
                .as_ref()
                .map(|value| reading.number(key, value, |value| range.contains(&value), &want))
                .transpose()
        };
        titling.utc_offset = number("utc_offset_hours", &self.utc_offset_hours, OFFSETS)?.unwrap_or_default();
        titling.margin = number("margin", &self.margin, MARGINS)?.unwrap_or(titling.margin);

        let folder = reading.path.parent().unwrap_or("".as_ref());
        for font in self.fonts.into_iter().flatten() {
            let path = folder.join(font.get_ref());
            let bytes = read_whole_file(&path, MOST_FONT_BYTES)
                .map_err(|error| reading.through(font.span(), "fonts", error))?;
            hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
            titling.fonts.push(path);
        }
        Ok(titling)
    }

    fn figures(&self, reading: &Reading<'_>, show: &Spanned<Vec<Spanned<String>>>) -> Result<Figures> {
        if matches!(self.style, Some(OverlayStyle::Pilot | OverlayStyle::None)) {
            let what = "show is of the style film; leave out style, or say show in a table [hud]";
            return Err(reading.wrong(show.span(), what));
        }
        let names = show.get_ref();
        Figures::of_names(names.iter().map(|name| name.get_ref().as_str())).map_err(|unknown| {
            let span = names.iter().find(|name| name.get_ref() == unknown).map_or(show.span(), Spanned::span);
            reading.wrong(span, format!("show takes {}, not {unknown:?}", Figures::NAMES.join(", ")))
        })
    }
}

/// Reads all captions.
pub(super) fn read_captions(reading: &Reading<'_>, tables: &[Spanned<CaptionTable>]) -> Result<Vec<Caption>> {
    let caption = |table: &Spanned<CaptionTable>| {
        let CaptionTable { text, from_s, to_s, film_from_s, film_to_s } = table.get_ref();
        let cue = |[flight_key, film_key]: [&str; 2],
                   flight: &Option<Spanned<f64>>,
                   film: &Option<Spanned<f64>>| {
            match (flight, film) {
                (Some(_), Some(second)) => Err(reading.wrong(
                    second.span(),
                    format!("{flight_key} is a moment of the flight and {film_key} one of the film; leave one of them out"),
                )),
                (Some(seconds), None) => {
                    Ok(Some(Cue::Flight(FlightTime::Seconds(moment(reading, flight_key, seconds)?))))
                }
                (None, Some(seconds)) => Ok(Some(Cue::Film(moment(reading, film_key, seconds)?))),
                (None, None) => Ok(None),
            }
        };

        let text = checked(reading, "text", text)?;
        let from = cue(["from_s", "film_from_s"], from_s, film_from_s)?.ok_or_else(|| {
            let what = "a caption needs from_s, seconds after the flight's first fix, or film_from_s, seconds after the film's first frame";
            reading.wrong(table.span(), what)
        })?;
        let to = cue(["to_s", "film_to_s"], to_s, film_to_s)?;
        let is_backward = match (from, to) {
            (Cue::Film(from), Some(Cue::Film(to)))
            | (Cue::Flight(FlightTime::Seconds(from)), Some(Cue::Flight(FlightTime::Seconds(to)))) => {
                to <= from
            }
            _ => false,
        };
        if is_backward {
            return Err(reading.wrong(table.span(), "a caption must end after it begins"));
        }
        Ok(Caption { from, to, text })
    };
    tables.iter().map(caption).collect()
}

/// Returns a text, if it can be shown.
fn checked(reading: &Reading<'_>, key: &str, text: &Spanned<String>) -> Result<String> {
    Titling::check_text(text.get_ref())
        .map_err(|what| reading.wrong(text.span(), format!("{key} {what}")))?;
    Ok(text.get_ref().clone())
}

/// Returns a moment, seconds.
fn moment(reading: &Reading<'_>, key: &str, seconds: &Spanned<f64>) -> Result<f64> {
    reading.number(key, seconds, |seconds| (0.0..=LATEST).contains(&seconds), "must be 0 to 10000000 seconds")
}
