//! Values of the tables of what no file holds: numbers within bounds, places, circles, colours, kinds.

use glam::DVec2;
use toml::Spanned;

use super::cover;
use super::fields::Fields;
use crate::Materials;
use crate::features::colour;
use crate::synthetic::Circle;
use hedgehop::voxel::Material;
use hedgehop_base::document::Reading;

/// Numbers that a key may have.
#[derive(Clone, Copy)]
pub(super) struct NumberRange {
    /// Whether a number is one of them.
    pub holds: fn(f64) -> bool,
    /// Words for them, after the key's name.
    pub want: &'static str,
}

impl NumberRange {
    pub(super) const fn new(holds: fn(f64) -> bool, want: &'static str) -> Self {
        Self { holds, want }
    }
}

/// Range of heights of ground: the steps of height of a whole place grow with it.
pub(super) const HEIGHT: NumberRange =
    NumberRange::new(|metres| metres.abs() <= 20_000.0, "must be −20000 to 20000 m");
pub(super) const AMOUNT: NumberRange =
    NumberRange::new(|metres| metres > 0.0 && metres <= 20_000.0, "must be more than 0 and at most 20000 m");
pub(super) const LENGTH: NumberRange =
    NumberRange::new(|metres| metres > 0.0 && metres <= 1.0e7, "must be more than 0 and at most 10000000 m");
pub(super) const WIDTH: NumberRange =
    NumberRange::new(|metres| (0.0..=1.0e7).contains(&metres), "must be 0 to 10000000 m");
pub(super) const PLACE: NumberRange =
    NumberRange::new(|metres| metres.abs() <= 1.0e9, "must be a place in metres");
pub(super) const AZIMUTH: NumberRange =
    NumberRange::new(|degrees| degrees.abs() <= 360.0, "must be −360 to 360 degrees");
pub(super) const ROUGHNESS: NumberRange =
    NumberRange::new(|share| (0.2..=0.9).contains(&share), "must be 0.2 to 0.9");
pub(super) const SHARE: NumberRange =
    NumberRange::new(|share| (0.0..=1.0).contains(&share), "must be 0 to 1");
pub(super) const HALF: NumberRange =
    NumberRange::new(|share| (0.0..=0.5).contains(&share), "must be 0 to 0.5");
pub(super) const PERCENT: NumberRange =
    NumberRange::new(|percent| percent.abs() <= 1000.0, "must be −1000 to 1000 %");

impl Fields<'_, '_, '_> {
    /// A number that must be there.
    pub(super) fn needed(&mut self, key: &'static str, example: &str, range: NumberRange) -> Option<f64> {
        let number = self.need::<f64>(key, example)?;
        self.mistakes.check(&number.span(), Reading::checked(key, *number.get_ref(), range.holds, range.want))
    }

    /// A number, or what it is without the key.
    pub(super) fn number_or(&mut self, key: &'static str, otherwise: f64, range: NumberRange) -> f64 {
        self.number(key, range.holds, range.want).unwrap_or(otherwise)
    }

    pub(super) fn material(&mut self, known: &Materials) -> Option<Material> {
        let name = self.take::<String>("material")?;
        cover::named(&name, known, self.mistakes)
    }

    pub(super) fn seed(&mut self) -> u64 {
        self.take::<u32>("seed").map_or(0, |seed| u64::from(seed.into_inner()))
    }

    /// Reads which kind a key may name, by the names that it has.
    pub(super) fn kind<T: Copy, const N: usize>(
        &mut self,
        kinds: [KindWord<T>; N],
        example: &str,
    ) -> Option<T> {
        let kind = self.need::<String>("kind", example)?;
        let known = kinds.iter().find(|known| known.word == kind.get_ref()).map(|known| known.kind);
        let wanted = || {
            format!("kind is one of {}, not {:?}", kinds.map(|known| known.word).join(", "), kind.get_ref())
        };
        self.mistakes.check(&kind.span(), known.ok_or_else(wanted))
    }

    /// A place of a table, metres.
    pub(super) fn place(&self, key: &'static str, place: &Spanned<Vec<f64>>) -> Option<DVec2> {
        let found = match place.get_ref().as_slice() {
            [x, y] => {
                let checked = |metres| Reading::checked(key, metres, PLACE.holds, PLACE.want);
                checked(*x).and_then(|x| Ok(DVec2::new(x, checked(*y)?)))
            }
            _ => Err(format!("{key} is a place, [x, y] in metres")),
        };
        self.mistakes.check(&place.span(), found)
    }

    pub(super) fn circle(&mut self) -> Option<Circle> {
        let centre = self.need::<Vec<f64>>("centre", "[4000, 4000]");
        let centre = centre.and_then(|centre| self.place("centre", &centre));
        let radius = self.needed("radius_m", "500", LENGTH);
        Some(Circle { centre: centre?, radius_m: radius? })
    }

    /// A circle, or nothing without its keys; the outer `None` is a mistake.
    pub(super) fn within(&mut self) -> Option<Option<Circle>> {
        let is_there = self.has("centre") || self.has("radius_m");
        if is_there {
            return self.circle().map(Some);
        }
        // Known, so that a slip of the pen is told with them.
        ["centre", "radius_m"].into_iter().for_each(|key| drop(self.value(key)));
        Some(None)
    }

    pub(super) fn colour(&self, text: &Spanned<String>) -> Option<[u8; 3]> {
        let wanted = || format!("a colour is #rrggbb (sRGB) or a name, not {:?}", text.get_ref());
        self.mistakes.check(&text.span(), colour(text.get_ref()).ok_or_else(wanted))
    }
}

/// Word for a kind of thing in a recipe.
#[derive(Clone, Copy)]
pub(super) struct KindWord<T> {
    /// The word.
    pub word: &'static str,
    /// Kind that it stands for.
    pub kind: T,
}
