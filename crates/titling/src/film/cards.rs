//! Cards: title, credits and captions, which come and go.

use glam::DVec2;

use super::compass::Compass;
use super::page::{Page, WHITE};
use crate::fonts::Fonts;
use crate::layer::Layer;
use crate::text::{Align, LEADING, TextBlock, TextStyle, Typesetter};

/// Seconds in which a card comes or goes.
const FADE: f64 = 0.5;

/// Size of letters from which on their halo grows no more, units.
const FULL_HALO: f64 = 44.0;

/// Share of their size that letters keep where a text has no room.
const LEAST_SIZE: f64 = 0.5;

/// Place of a card on the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CardPlace {
    /// Middle of the picture, a little higher.
    Title {
        /// Width that it may take, pixels.
        width: f64,
    },
    /// Middle of the picture, a little lower.
    Credits,
    /// Lower part of the picture, above its figures.
    Caption,
}

/// One of the texts on a card.
#[derive(Debug, Clone, Copy)]
pub struct CardText<'t> {
    /// Text, of one line or several.
    pub text: &'t str,
    /// Size of its letters, units.
    pub units: f64,
}

/// Text that is shown over a part of a film.
#[derive(Debug)]
pub struct Card {
    place: CardPlace,
    /// Seconds of the film from and to which it is shown.
    shown: [f64; 2],
    /// Texts below each other, with their widths and heights.
    blocks: Vec<TextBlock>,
    /// Width and height, pixels.
    extent: DVec2,
}

impl Card {
    /// Sets texts below each other, smaller where they have no room; shown from and to seconds of the film.
    pub fn new(
        place: CardPlace,
        shown: [f64; 2],
        texts: &[CardText<'_>],
        page: &Page,
        fonts: &Fonts,
    ) -> Self {
        let typesetter = Typesetter::new(fonts.faces());
        let room = match place {
            CardPlace::Title { width } => {
                let room = page.safe().size * DVec2::new(0.9, 0.45);
                room.min(DVec2::new(width, room.y))
            }
            CardPlace::Credits => page.safe().size * DVec2::new(0.9, 0.4),
            CardPlace::Caption => page.safe().size * DVec2::new(0.75, 0.3),
        };
        let set = |shrunk: f64| {
            let block = |CardText { text, units }: &CardText<'_>| {
                let size = page.letters(units * shrunk);
                let lines = (room.y / texts.len() as f64 / f64::from(LEADING * size)) as usize;
                let style =
                    TextStyle { size, align: Align::Middle, width: room.x as f32, most_lines: usize::MAX };
                // Smaller letters come first, then an end.
                let most_lines = if shrunk > LEAST_SIZE { usize::MAX } else { lines.max(1) };
                balanced(&typesetter, text, &TextStyle { most_lines, ..style })
            };
            let blocks: Vec<TextBlock> = texts.iter().map(block).collect();
            let width = blocks.iter().map(|block| f64::from(block.extent[0])).fold(0.0, f64::max);
            let height = blocks.iter().map(|block| f64::from(block.extent[1])).sum();
            (blocks, DVec2::new(width, height))
        };

        let mut shrunk = 1.0;
        let (mut blocks, mut extent) = set(shrunk);
        while extent.cmpgt(room).any() && shrunk > LEAST_SIZE {
            shrunk = (0.9 * shrunk).max(LEAST_SIZE);
            (blocks, extent) = set(shrunk);
        }
        Self { place, shown, blocks, extent }
    }

    /// Returns how opaque the card is at a moment of the film, 0…1; `step` is the time from frame to frame, in the first of which it shows already.
    pub fn opacity(&self, seconds: f64, step: f64) -> f64 {
        let [from, to] = self.shown;
        let fade = FADE.min(0.25 * (to - from));
        if seconds < from || seconds >= to {
            return 0.0;
        }
        // A card of the first frame is there at once, and one of the last frame stays.
        let come = if from <= 0.0 { 1.0 } else { (seconds - from + step) / fade };
        let go = if to.is_finite() { (to - seconds) / fade } else { 1.0 };
        come.min(go).clamp(0.0, 1.0)
    }

    /// Draws the card; `free` is the row above which a caption ends.
    pub fn layer(&self, page: &Page, free: f64) -> Option<Layer> {
        let middle = page.safe().corner + 0.5 * page.safe().size;
        let top = match self.place {
            CardPlace::Title { .. } => {
                // The title leaves the middle of the view free below, and the compass above.
                let centred = middle.y - 0.2 * page.safe().size.y - 0.5 * self.extent.y;
                centred
                    .min(middle.y - 0.1 * page.safe().size.y - self.extent.y)
                    .max(Compass::bottom(page) + page.px(10.0))
            }
            CardPlace::Credits => middle.y + 0.02 * page.safe().size.y - 0.5 * self.extent.y,
            CardPlace::Caption => free - page.px(24.0) - self.extent.y,
        };
        let corner = DVec2::new(middle.x - 0.5 * self.extent.x, top);
        let halo = DVec2::splat(page.px(16.0));
        let mut layer = Layer::new(corner - halo, self.extent + 2.0 * halo)?;

        let mut down = 0.0;
        for block in &self.blocks {
            let across = 0.5 * (self.extent.x - f64::from(block.extent[0]));
            let narrower = (page.px(FULL_HALO) as f32 / block.size).clamp(0.4, 1.0);
            layer.text_in_halo(block, corner + DVec2::new(across, down), WHITE, narrower);
            down += f64::from(block.extent[1]);
        }
        Some(layer)
    }
}

/// Sets a text in as few lines as its style's width allows, and these as equally long as they can be.
fn balanced(typesetter: &Typesetter<'_>, text: &str, style: &TextStyle) -> TextBlock {
    const TRIES: usize = 6;
    let mut best = typesetter.set(text, style);
    // One that is cut would be as tall in a single letter's width.
    if best.is_cut {
        return best;
    }

    let (mut narrow, mut wide) = (0.0, best.extent[0]);
    for _ in 0..TRIES {
        let width = 0.5 * (narrow + wide);
        let block = typesetter.set(text, &TextStyle { width, ..*style });
        let fits = !block.is_cut && block.extent[1] <= best.extent[1] && block.extent[0] <= best.extent[0];
        if fits {
            wide = width.min(block.extent[0]);
            best = block;
        } else {
            narrow = width;
        }
    }
    best
}
