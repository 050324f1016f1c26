//! Text and figures over pictures: flags, and what a film's titles are drawn from.

use std::fs;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec2;
use serde_json::{Value, json};

use crate::bound_flight::FilmMotion;
use crate::playback;
use crate::reference;
use crate::world::WorldArgs;
use hedgehop::flight::FlightTime;
use hedgehop::frame::Picture;
use hedgehop::geo::{Crs, Transform};
use hedgehop::progress::Observer;
use hedgehop::scene::{Caption, Cue, Figures, Hud, OverlayStyle, Scene, Titling, Units};
use hedgehop::space::Camera;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result, Size};
use hedgehop_titling::{FilmLength, Readings, TimedCaption, TitleInputs, Titles, TrackPoint, quoted};

/// Seconds of the film that a caption without an end is shown.
const CAPTION_SECONDS: f64 = 4.0;

/// Points of a path that maps and profiles show, less one.
const POINTS: u32 = 1000;

/// Flags of text and figures over pictures; they go before what the scene says.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Text and figures")]
pub struct TitlingArgs {
    /// Figures over the picture: film, pilot (an instrument display), none, or some of clock,place,altitude,speed,north,scale,map,profile, which are those of film
    /// [default: none]
    #[arg(long, value_name = "STYLE|LIST", value_parser = overlay)]
    pub overlay: Option<Overlay>,

    /// Title over the film's first five seconds; \n begins a new line
    #[arg(long, value_name = "TEXT", value_parser = text)]
    pub title: Option<String>,

    /// Smaller line below the title
    #[arg(long, value_name = "TEXT", value_parser = text, requires = "title")]
    pub subtitle: Option<String>,

    /// Credits over the film's last five seconds
    #[arg(long, value_name = "TEXT", value_parser = text)]
    pub credits: Option<String>,

    /// Caption from a moment on, for four seconds, or until another moment: 5s=TEXT and 1m5s-1m9s=TEXT by the film's own time, 14:05:30=TEXT by the clock of the
    /// path file, UTC; any number of times
    #[arg(long, value_name = "TIME=TEXT", value_parser = caption, allow_hyphen_values = true)]
    pub caption: Vec<Caption>,

    /// Font for letters that the program's own ones have not (those have Latin, Greek, Cyrillic, Hebrew, Arabic, Armenian and Georgian ones): a TrueType or OpenType file; any number of times
    #[arg(long, value_name = "FILE.ttf")]
    pub font: Vec<PathBuf>,

    /// Units of figures [default: metric]
    #[arg(long, value_enum, value_name = "UNITS")]
    pub units: Option<UnitsArg>,

    /// Clock that is shown, in hours ahead of UTC: +2, -03:30; times of day in flags are UTC all the same, or 14:05+02:00 [default: 0]
    #[arg(long, value_name = "HOURS", value_parser = offset, allow_hyphen_values = true)]
    pub utc_offset: Option<f64>,

    /// Instruments of --overlay pilot, or some of horizon,heading,altitude,speed,time,map; none; all, which --hud alone is, too
    #[arg(long, value_name = "LIST", value_parser = instruments, num_args = 0..=1, require_equals = true, default_missing_value = "all")]
    pub hud: Option<Hud>,
}

/// Figures that `--overlay` asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overlay {
    /// All of a style.
    Style(OverlayStyle),
    /// Some of the film's.
    Some(Figures),
}

/// Units, as flags name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UnitsArg {
    /// Metres, kilometres an hour, metres a second
    Metric,
    /// Feet, knots, feet a minute
    Aviation,
    /// Feet, miles an hour, feet a minute
    Imperial,
}

impl From<UnitsArg> for Units {
    fn from(units: UnitsArg) -> Self {
        match units {
            UnitsArg::Metric => Self::Metric,
            UnitsArg::Aviation => Self::Aviation,
            UnitsArg::Imperial => Self::Imperial,
        }
    }
}

fn overlay(names: &str) -> Result<Overlay, String> {
    match names {
        "film" | "all" => Ok(Overlay::Style(OverlayStyle::Film)),
        "pilot" => Ok(Overlay::Style(OverlayStyle::Pilot)),
        "none" => Ok(Overlay::Style(OverlayStyle::None)),
        names => Figures::of_names(names.split(',').map(str::trim)).map(Overlay::Some).map_err(|unknown| {
            format!(
                "want film, pilot, none, or some of {} with commas between, not {unknown:?}",
                Figures::NAMES.join(", ")
            )
        }),
    }
}

fn instruments(names: &str) -> Result<Hud, String> {
    match names {
        "all" => Ok(Hud::ALL),
        "none" => Ok(Hud::default()),
        names => Hud::of_names(names.split(',').map(str::trim)).map_err(|unknown| {
            format!(
                "want all, none, or some of {} with commas between, not {unknown:?}",
                Hud::NAMES.join(", ")
            )
        }),
    }
}

/// Returns a text with its line ends.
fn text(given: &str) -> Result<String, String> {
    let text = given.replace("\\n", "\n");
    Titling::check_text(&text).map(|()| text).map_err(|what| format!("the text {what}"))
}

/// `TIME=TEXT`, `TIME-TIME=TEXT`.
fn caption(given: &str) -> Result<Caption, String> {
    let want = || "want TIME=TEXT, such as 5s=TEXT, 1m5s-1m9s=TEXT, or by the clock 14:05:30=TEXT".to_owned();
    let (times, said) = given.split_once('=').ok_or_else(want)?;
    let (from, to) = match times.split_once('-') {
        Some((from, to)) => (cue(from).ok_or_else(want)?, Some(cue(to).ok_or_else(want)?)),
        None => (cue(times).ok_or_else(want)?, None),
    };
    if let (Cue::Film(from), Some(Cue::Film(to))) = (from, to)
        && to <= from
    {
        return Err(format!("the caption ends at {to} s, which is not after its beginning at {from} s"));
    }
    Ok(Caption { from, to, text: text(said)? })
}

/// A moment: of the film, unless it is a time of day, departure or arrival.
fn cue(given: &str) -> Option<Cue> {
    match playback::flight_time(given.trim()).ok()? {
        FlightTime::Seconds(seconds) => Some(Cue::Film(seconds)),
        of_flight => Some(Cue::Flight(of_flight)),
    }
}

/// Hours, or hours and minutes, with a sign.
fn offset(given: &str) -> Result<f64, String> {
    let want =
        || "want how many hours the clock is ahead of UTC, -14 to 14, such as +2, -5 or +05:30".to_owned();
    let (sign, digits) = match given.strip_prefix(['-', '−']) {
        Some(digits) => (-1.0, digits),
        None => (1.0, given.strip_prefix('+').unwrap_or(given)),
    };
    let hours = match digits.split_once(':') {
        Some((hours, minutes)) => {
            let minutes: u8 = minutes.parse().ok().filter(|minutes| *minutes < 60).ok_or_else(want)?;
            f64::from(hours.parse::<u8>().map_err(|_| want())?) + f64::from(minutes) / 60.0
        }
        None => digits.parse().ok().filter(|hours: &f64| *hours >= 0.0).ok_or_else(want)?,
    };
    if hours <= 14.0 { Ok(sign * hours) } else { Err(want()) }
}

impl TitlingArgs {
    /// Returns what the flags say, and the scene where they are silent.
    ///
    /// # Errors
    /// A flag of texts or figures where there are none.
    pub fn titling(&self, scene: Option<&Scene>) -> Result<Titling> {
        let titling = self.said(scene);
        let idle = if titling.texts().next().is_none() && !self.font.is_empty() {
            Some("--font has letters for texts; give a --title, --credits or --caption, too, or leave it out")
        } else if titling.figures == Figures::default() && self.units.is_some() {
            Some("--units is of figures; give --overlay film, or some of its figures, too, or leave it out")
        } else if !titling.figures.clock && self.utc_offset.is_some() {
            Some("--utc-offset is of the clock; give --overlay film or --overlay clock, too, or leave it out")
        } else {
            None
        };
        idle.map_or(Ok(titling), |what| Err(Error::Configuration(what.into())))
    }

    fn said(&self, scene: Option<&Scene>) -> Titling {
        let mut titling = scene.map(|scene| scene.titling.clone()).unwrap_or_default();
        match self.overlay {
            Some(Overlay::Style(style)) => titling.set_style(style),
            Some(Overlay::Some(figures)) => titling.figures = figures,
            None => {}
        }
        titling.hud = self.hud.unwrap_or(titling.hud);

        if self.title.is_some() {
            (titling.title, titling.subtitle) = (self.title.clone(), self.subtitle.clone());
        }
        titling.credits = self.credits.clone().or(titling.credits);
        if !self.caption.is_empty() {
            titling.captions.clone_from(&self.caption);
        }
        titling.fonts.extend(self.font.iter().cloned());
        titling.units = self.units.map_or(titling.units, Units::from);
        titling.utc_offset = self.utc_offset.unwrap_or(titling.utc_offset);
        titling
    }
}

/// Records what is drawn over pictures; nothing, if nothing is.
pub fn record(titling: &Titling, settings: &mut Value) {
    let Titling { hud, figures, title, subtitle, credits, captions, fonts, units, utc_offset, margin } =
        titling;
    if !hud.is_empty() {
        settings["hud"] = json!(hud.names());
    }
    let beside_hud = Titling { hud: Hud::default(), ..titling.clone() };
    if beside_hud.is_empty() {
        return;
    }

    let cue = |cue: Cue| match cue {
        Cue::Film(seconds) => json!({ "film_s": seconds }),
        Cue::Flight(FlightTime::Seconds(seconds)) => json!({ "flight_s": seconds }),
        Cue::Flight(FlightTime::OfDay(seconds)) => json!({ "seconds_of_day": seconds }),
        Cue::Flight(FlightTime::Departure) => json!("departure"),
        Cue::Flight(FlightTime::Arrival) => json!("arrival"),
    };
    let captions: Vec<Value> = captions
        .iter()
        .map(|caption| json!({ "from": cue(caption.from), "to": caption.to.map(cue), "text": caption.text }))
        .collect();
    // They were read before; one that cannot be read any more is told by a null.
    let digest = |path: &PathBuf| fs::read(path).ok().map(|bytes| blake3::hash(&bytes).to_hex().to_string());
    let fonts: Vec<Option<String>> = fonts.iter().map(digest).collect();
    settings["overlay"] = json!({
        "figures": figures.names(),
        "title": title,
        "subtitle": subtitle,
        "credits": credits,
        "captions": captions,
        "fonts_blake3": fonts,
        "units": format!("{units:?}").to_lowercase(),
        "utc_offset_hours": utc_offset,
        "margin": margin,
    });
}

/// Says what is drawn over pictures, in a few words; `None`: nothing is.
pub fn sentence(titling: &Titling) -> Option<String> {
    let mut parts = Vec::new();
    if !titling.hud.is_empty() {
        parts.push(format!("instruments {}", titling.hud.names().join(", ")));
    }
    if titling.figures != Figures::default() {
        parts.push(format!("figures {}", titling.figures.names().join(", ")));
    }
    let cards = [(&titling.title, "a title"), (&titling.credits, "credits")];
    parts.extend(cards.into_iter().filter(|(text, _)| text.is_some()).map(|(_, what)| what.to_owned()));
    match titling.captions.len() {
        0 => {}
        1 => parts.push("a caption".into()),
        count => parts.push(format!("{count} captions")),
    }
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// Titles of a film, and what their figures are read from.
#[derive(Debug)]
pub struct FilmTitles<'f> {
    titles: Titles,
    motion: &'f FilmMotion,
    world: WorldArgs,
    /// Transformation to longitude and latitude, if the place is shown and the area has one on Earth.
    degrees: Option<Transform>,
    wants_ground: bool,
}

impl<'f> FilmTitles<'f> {
    /// Prepares titles over a film's pictures; `source` knows the ground.
    ///
    /// # Errors
    /// A caption outside the flight, a file that is no font, a letter that no font has, a page that is damaged.
    pub fn new(
        titling: &Titling,
        motion: &'f FilmMotion,
        world: WorldArgs,
        size: Size,
        source: &dyn PageSource,
        observer: &dyn Observer,
    ) -> Result<Self> {
        let timeline = &motion.timeline;
        let captions = timed(&titling.captions, motion, observer)?;
        if titling.utc_offset != 0.0
            && titling.figures.clock
            && motion.flown.span().time_of_day.is_none()
            && motion.flown.duration() > 0.0
        {
            observer.note("the path file tells no time of day; the time since its first fix is shown");
        }

        // The pilot's map shows the whole path; an audience is shown the film's part of it.
        let [from, to] = if titling.hud.map {
            [0.0, motion.flown.duration()]
        } else {
            [timeline.seconds_at(1), timeline.end().min(motion.flown.duration())]
        };
        let has_track = titling.hud.map || titling.figures.map || titling.figures.profile;
        let mut track = Vec::new();
        for point in (0..=POINTS).filter(|_| has_track) {
            let seconds = from + (to - from) * f64::from(point) / f64::from(POINTS);
            let place = motion.flown.pose_at(seconds).eye;
            let ground = if titling.figures.profile { world.ground(source, place.truncate())? } else { None };
            track.push(TrackPoint { seconds, place, ground });
        }

        // A single place without a clock has no time to tell.
        let mut titling = titling.clone();
        titling.figures.clock &= motion.flown.duration() > 0.0 || motion.flown.span().time_of_day.is_some();
        let titling = &titling;

        let length = FilmLength { frames: timeline.frame_count(), seconds: timeline.film_duration() };
        let titles = Titles::new(&TitleInputs {
            titling,
            captions: &captions,
            length,
            size,
            track: &track,
            is_endless: world.tile_world,
            source,
        })?;

        let crs = reference::crs(source.header())?;
        let wants_degrees = titling.figures.place && !crs.is_local();
        let degrees = wants_degrees.then(|| Transform::new(&crs, &Crs::wgs84())).transpose()?;
        let wants_ground = titling.hud.altitude || titling.figures.altitude;
        Ok(Self { titles, motion, world, degrees, wants_ground })
    }

    /// Draws all that is shown over a picture of a frame; `source` knows how high the ground is.
    pub fn draw(
        &self,
        source: &dyn PageSource,
        number: u64,
        camera: &Camera,
        picture: &mut Picture,
    ) -> Result<()> {
        let FilmMotion { flown, timeline, .. } = self.motion;
        let seconds = timeline.seconds_at(number);
        let pose = flown.pose_at(seconds);
        let place = pose.eye.truncate();
        let ground = if self.wants_ground { self.world.ground(source, place)? } else { None };
        let readings = Readings {
            heading: pose.attitude.yaw,
            altitude: pose.eye.z,
            above_ground: ground.map(|ground| pose.eye.z - ground),
            speed: flown.velocity_at(seconds).map(|velocity| [velocity.truncate().length(), velocity.z]),
            frame: number,
            film_seconds: timeline.film_seconds_at(number),
            seconds,
            clock: flown.span().time_of_day.map(|first| first + seconds),
            place,
            lonlat: self.lonlat(place),
        };
        self.titles.draw(picture, camera, &readings);
        Ok(())
    }

    fn lonlat(&self, place: DVec2) -> Option<[f64; 2]> {
        let (longitude, latitude) = self.degrees.as_ref()?.apply(place.x, place.y)?;
        Some([longitude, latitude])
    }
}

/// Finds when captions come and go, the earliest first; one goes when the next one comes.
fn timed(captions: &[Caption], motion: &FilmMotion, observer: &dyn Observer) -> Result<Vec<TimedCaption>> {
    let FilmMotion { flown, timeline, .. } = motion;
    let seconds_of = |cue: Cue| match cue {
        Cue::Film(seconds) => Ok(seconds),
        Cue::Flight(time) => {
            let span = flown.span();
            if matches!(time, FlightTime::OfDay(_)) && span.time_of_day.is_none() {
                return Err(Error::Configuration(
                    "has a time of day, and the path file tells none; give its time in the film, such as 5s=TEXT".into(),
                ));
            }
            // The first such moment of the film, or else of the flight.
            let seconds =
                [timeline.seconds_at(1), 0.0].map(|earliest| span.seconds_of("its time", time, earliest));
            let [of_film, of_flight] = seconds;
            Ok(timeline.film_seconds_of(of_film.or(of_flight)?))
        }
    };
    let of_caption = |text: &str, error: Error| match error {
        Error::Configuration(what) => Error::Configuration(format!("the caption {}: {what}", quoted(text))),
        other => other,
    };

    let (mut timed, mut outside) = (Vec::with_capacity(captions.len()), Vec::new());
    for Caption { from, to, text } in captions {
        let told = |cue: Cue| seconds_of(cue).map_err(|error| of_caption(text, error));
        let from = told(*from)?;
        let to = to.map_or(Ok(from + CAPTION_SECONDS), told)?;
        if to <= from {
            return Err(Error::Configuration(format!("the caption {} ends before it begins", quoted(text))));
        }
        if from >= timeline.film_duration() || to <= 0.0 {
            outside.push(text.as_str());
        }
        timed.push(TimedCaption { from, to, text: text.clone() });
    }

    if let Some(first) = outside.first() {
        let others = match outside.len() - 1 {
            0 => String::new(),
            1 => " and another one".to_owned(),
            more => format!(" and {more} others"),
        };
        let (caption, lasts) = (quoted(first), timeline.film_duration());
        observer
            .note(&format!("the caption {caption}{others} will not be seen: the film lasts {lasts:.1} s"));
    }

    timed.sort_by(|a, b| a.from.total_cmp(&b.from));
    for next in 1..timed.len() {
        let comes = timed[next].from;
        timed[next - 1].to = timed[next - 1].to.min(comes);
    }
    Ok(timed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_chosen_by_style_or_name() {
        assert_eq!(overlay("film"), Ok(Overlay::Style(OverlayStyle::Film)));
        let some = Figures { clock: true, map: true, ..Figures::default() };
        assert_eq!(overlay("map, clock"), Ok(Overlay::Some(some)));
        assert!(overlay("movie").unwrap_err().contains("clock, place"));
        assert_eq!(instruments("all"), Ok(Hud::ALL));
        assert_eq!(instruments("none"), Ok(Hud::default()));
        assert_eq!(instruments("time, map").unwrap().names(), ["time", "map"]);
        assert!(instruments("clock").unwrap_err().contains("horizon, heading"));
    }

    #[test]
    fn captions_have_moments_of_the_film_or_of_the_clock() {
        let said = caption("1m5s-70=Over\\nthe lake = a dam").unwrap();
        let expected = Caption {
            from: Cue::Film(65.0),
            to: Some(Cue::Film(70.0)),
            text: "Over\nthe lake = a dam".into(),
        };
        assert_eq!(said, expected);
        let clock = caption("14:05:30=Take-off").unwrap();
        assert_eq!((clock.from, clock.to), (Cue::Flight(FlightTime::OfDay(50_730.0)), None));
        for wrong in
            ["Text", "=Text", "5s=", "5s= ", "soon=Text", "9s-5s=Text", "5s-=Text", "5s=a\tb", "1e99=x"]
        {
            assert!(caption(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn clocks_are_told_by_their_offset() {
        let told = ["+2", "2", "-5", "+05:30", "-3.5", "0"].map(|text| offset(text).unwrap());
        assert_eq!(told, [2.0, 2.0, -5.0, 5.5, -3.5, 0.0]);
        for wrong in ["", "x", "15", "+2:75", "--2", "1e3", "nan", "2:x"] {
            assert!(offset(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_drawn_is_told() {
        let (mut none, mut some) = (json!({}), json!({}));
        record(&Titling::default(), &mut none);
        assert_eq!((none, sentence(&Titling::default())), (json!({}), None));
        let titling = Titling { hud: Hud::ALL, title: Some("A".into()), ..Titling::default() };
        record(&titling, &mut some);
        assert_eq!((some["hud"][5].clone(), some["overlay"]["title"].clone()), (json!("map"), json!("A")));
        assert_eq!(
            sentence(&titling).unwrap(),
            "instruments horizon, heading, altitude, speed, time, map; a title"
        );
    }
}
