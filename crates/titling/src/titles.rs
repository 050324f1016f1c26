//! Titles of a film: all that is drawn over its pictures.

use crate::film::{Card, CardPlace, CardText, FilmFigures, FilmSubject, Page};
use crate::fonts::Fonts;
use crate::hud::{self, MiniMap};
use crate::readings::Readings;
use crate::relief::{Relief, Window};
use crate::track_point::TrackPoint;
use glam::DVec2;
use hedgehop::frame::Picture;
use hedgehop::scene::{Figures, Hud, Titling};
use hedgehop::space::Camera;
use hedgehop::voxel::PageSource;
use hedgehop_base::Size;
use hedgehop_base::error::Result;

/// Seconds that title and credits are shown, and the share of a short film.
const SHOWN: f64 = 5.0;
const SHARE: f64 = 0.4;

/// Sizes of letters, units.
const TITLE: f64 = 96.0;
const SUBTITLE: f64 = 44.0;
const CREDITS: f64 = 38.0;
const CAPTION: f64 = 42.0;

/// Part of the path's width that the inset map shows beside it, and its least width, metres.
const BESIDE: f64 = 0.2;
const LEAST_WIDTH: f64 = 1000.0;

/// Text with the seconds of the film at which it comes and goes.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedCaption {
    /// Seconds of the film.
    pub from: f64,
    /// Seconds of the film, after `from`.
    pub to: f64,
    /// Text, of one line or several.
    pub text: String,
}

/// Length of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmLength {
    /// Number of frames, at least 1.
    pub frames: u64,
    /// Seconds from the first frame to the end of the last.
    pub seconds: f64,
}

/// Data of a film that its titles need.
pub struct TitleInputs<'i> {
    /// Text and figures that are asked for.
    pub titling: &'i Titling,
    /// Captions, with their times.
    pub captions: &'i [TimedCaption],
    /// Length of the whole film.
    pub length: FilmLength,
    /// Size of the pictures.
    pub size: Size,
    /// Path of what flies over the film, rising in time; needed by maps and profiles.
    pub track: &'i [TrackPoint],
    /// Whether the path may leave the area, which repeats without end.
    pub is_endless: bool,
    /// Database, of which maps show the relief.
    pub source: &'i dyn PageSource,
}

/// Titles of a film, ready to be drawn.
#[derive(Debug)]
pub struct Titles {
    page: Page,
    fonts: Fonts,
    hud: Hud,
    mini_map: Option<MiniMap>,
    figures: Option<FilmFigures>,
    cards: Vec<Card>,
    /// Time from frame to frame, seconds of the film.
    step: f64,
}

impl Titles {
    /// Draws what is the same in all pictures of a film.
    ///
    /// # Errors
    /// A page that is damaged, a file that is no font, a letter that no font has.
    pub fn new(inputs: &TitleInputs<'_>) -> Result<Self> {
        let TitleInputs { titling, captions, length, size, track, is_endless, source } = *inputs;
        let fonts = Fonts::read(titling.fonts.iter().map(std::path::PathBuf::as_path))?;
        titling.texts().try_for_each(|text| fonts.check(text))?;

        let page = Page::new(size, titling.margin);
        let mini_map = if titling.hud.map {
            let path: Vec<DVec2> = track.iter().map(|point| point.place.truncate()).collect();
            Some(MiniMap::new(source, &path, is_endless)?)
        } else {
            None
        };

        let has_figures = titling.figures != Figures::default();
        let figures = if has_figures {
            let whole = Window { is_endless, ..Window::whole(source) };
            let window = if is_endless { whole } else { around(track, source) };
            let relief = titling.figures.map.then(|| Relief::new(source, window)).transpose()?;
            let subject = FilmSubject { track: track.to_vec(), relief };
            Some(FilmFigures::new(titling.figures, titling.units, titling.utc_offset, page, subject, &fonts))
        } else {
            None
        };

        let width = figures.as_ref().map_or(page.safe().size.x, FilmFigures::title_width);
        let title = CardPlace::Title { width };
        let cards = cards(titling, captions, length, title, &page, &fonts);
        let step = length.seconds / length.frames.max(1) as f64;
        Ok(Self { page, fonts, hud: titling.hud, mini_map, figures, cards, step })
    }

    /// Draws all that is shown over a picture of what `camera` saw.
    pub fn draw(&self, picture: &mut Picture, camera: &Camera, readings: &Readings) {
        hud::draw(picture, camera, &self.hud, readings, self.mini_map.as_ref());
        let mut free = self.page.bottom();
        if let Some(figures) = &self.figures {
            let (layers, above) = figures.layers(camera, readings, &self.fonts);
            layers.iter().for_each(|layer| layer.blend(picture, 1.0));
            free = above;
        }

        for card in &self.cards {
            let opacity = card.opacity(readings.film_seconds, self.step);
            if let Some(layer) = (opacity > 0.0).then(|| card.layer(&self.page, free)).flatten() {
                layer.blend(picture, opacity);
            }
        }
    }
}

/// Sets all cards of a film. One of a single picture, or of less than a second, shows title and credits throughout.
fn cards(
    titling: &Titling,
    captions: &[TimedCaption],
    length: FilmLength,
    title_place: CardPlace,
    page: &Page,
    fonts: &Fonts,
) -> Vec<Card> {
    let is_still = length.frames == 1 || length.seconds < 1.0;
    let shown = SHOWN.min(SHARE * length.seconds);
    let mut cards = Vec::new();

    let title: Vec<CardText<'_>> = [(&titling.title, TITLE), (&titling.subtitle, SUBTITLE)]
        .into_iter()
        .filter_map(|(text, size)| Some(CardText { text: text.as_deref()?, units: size }))
        .collect();
    if !title.is_empty() {
        let to = if is_still { f64::INFINITY } else { shown };
        cards.push(Card::new(title_place, [0.0, to], &title, page, fonts));
    }

    if let Some(credits) = &titling.credits {
        let from = if is_still { 0.0 } else { length.seconds - shown };
        cards.push(Card::new(
            CardPlace::Credits,
            [from, f64::INFINITY],
            &[CardText { text: credits, units: CREDITS }],
            page,
            fonts,
        ));
    }
    for TimedCaption { from, to, text } in captions {
        cards.push(Card::new(
            CardPlace::Caption,
            [*from, *to],
            &[CardText { text, units: CAPTION }],
            page,
            fonts,
        ));
    }
    cards
}

/// Returns the part of an area that a map of a path shows.
fn around(track: &[TrackPoint], source: &dyn PageSource) -> Window {
    let whole = Window::whole(source);
    let places = || track.iter().map(|point| point.place.truncate());
    let (least, most) = places().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(least, most), place| {
        (least.min(place), most.max(place))
    });
    if !(least.is_finite() && most.is_finite()) {
        return whole;
    }

    let side = ((1.0 + 2.0 * BESIDE) * (most - least).max_element()).max(LEAST_WIDTH);
    let middle = 0.5 * (least + most);
    // Maps are square, so that they stand where they do; those of a narrow area are as narrow as it is.
    let far = whole.origin + whole.extent;
    let extent = DVec2::splat(side).min(whole.extent);
    let origin = (middle - 0.5 * extent).clamp(whole.origin, far - extent);
    Window { origin, extent, is_endless: false }
}
