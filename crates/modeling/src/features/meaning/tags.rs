//! A row's attributes while their meaning is looked for.

use std::ops::RangeInclusive;

use super::super::kinds::Paint;
use super::super::layer::{LayerOptions, Row, Value};
use super::colours::{colour, hash, varied};
use super::material::material_of_word;
use super::quantity;

/// A row, and what is wrong with its values.
pub(super) struct Tags<'r> {
    row: &'r Row,
    pub options: &'r LayerOptions,
    pub doubts: Vec<String>,
    /// Hash that tells it from other rows.
    pub hash: u64,
}

/// Heights and widths that things on Earth have, metres.
pub(super) const LENGTHS: RangeInclusive<f64> = 0.01..=1000.0;

impl<'r> Tags<'r> {
    pub fn of(row: &'r Row, options: &'r LayerOptions) -> Self {
        Self { row, options, doubts: Vec::new(), hash: hash(&row.place) }
    }

    /// A value as text; whole numbers without a point.
    pub fn text(&self, name: &str) -> Option<String> {
        Some(match self.row.attributes.get(name)? {
            Value::Text(text) => text.trim().to_owned(),
            Value::Number(number) => number.to_string(),
        })
    }

    /// A value of OpenStreetMap's words, in lower case; the first of several.
    pub fn word(&self, name: &str) -> Option<String> {
        let text = self.text(name)?.to_ascii_lowercase();
        Some(text.split(';').next().unwrap_or_default().trim().to_owned())
    }

    /// The word of a name, if it says more than "no".
    pub fn yes(&self, name: &str) -> Option<String> {
        self.word(name).filter(|word| !["no", "0", "false", "f", "none", ""].contains(&word.as_str()))
    }

    /// Whether a name has one of some words.
    pub fn is(&self, name: &str, words: &[&str]) -> bool {
        self.word(name).is_some_and(|word| words.contains(&word.as_str()))
    }

    /// Returns the kind within its class: by the named column, by OpenStreetMap's key, or as extracts of it call it.
    pub fn kind(&self, key: &str) -> String {
        let named = self.options.columns.class.as_deref().and_then(|name| self.word(name));
        named.or_else(|| self.yes(key)).or_else(|| self.word("fclass")).unwrap_or_default()
    }

    /// The first value there is of a named column (if one is named, it alone) and of other names.
    fn found(&self, column: Option<&String>, names: &[&str]) -> Option<(String, String)> {
        let one = |name: &str| self.text(name).map(|text| (name.to_owned(), text));
        match column {
            Some(column) => one(column),
            None => names.iter().find_map(|name| one(name)),
        }
    }

    /// A value that a function understands, within a range; others become doubts.
    pub fn measured(
        &mut self,
        column: Option<&String>,
        names: &[&str],
        read: impl Fn(&str) -> Option<f64>,
        range: &RangeInclusive<f64>,
    ) -> Option<f64> {
        let (name, text) = self.found(column, names)?;
        let found = read(&text).filter(|value| range.contains(value));
        if found.is_none() {
            let shown: String = text.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect();
            let (low, high) = (range.start(), range.end());
            self.doubts
                .push(format!("{name} = \"{shown}\" is passed over: it is no number from {low} to {high}"));
        }
        found
    }

    /// A length in metres, with or without unit.
    pub fn length(&mut self, column: Option<&String>, names: &[&str]) -> Option<f64> {
        self.measured(column, names, quantity::length, &LENGTHS)
    }

    /// A number of things.
    pub fn count(
        &mut self,
        column: Option<&String>,
        names: &[&str],
        range: &RangeInclusive<f64>,
    ) -> Option<f64> {
        self.measured(column, names, quantity::number, range)
    }

    /// Reads the paint of a surface: by its colour, else its material, else `otherwise`; the latter two vary from row to row.
    pub fn paint(
        &mut self,
        columns: [Option<&String>; 2],
        colours: &[&str],
        materials: &[&str],
        otherwise: Paint,
    ) -> Paint {
        /// Codes by which like surfaces differ.
        const VARIATION: f64 = 12.0;

        let named = |(_, text): (String, String)| {
            let word = text.trim().to_ascii_lowercase();
            let own = || self.options.materials.named(&word);
            material_of_word(&word).or_else(|| own().map(|own| (own, self.options.materials.usual(own))))
        };
        let material = self.found(columns[1], materials).and_then(named);
        let (material, usual) = material.unwrap_or((otherwise.material, otherwise.colour));
        let usual = varied(usual, self.hash, VARIATION);
        let Some((name, text)) = self.found(columns[0], colours) else {
            return Paint { colour: usual, material };
        };

        let colour = colour(&text).unwrap_or_else(|| {
            let shown: String = text.chars().take(40).map(|c| if c.is_control() { ' ' } else { c }).collect();
            self.doubts.push(format!("{name} = \"{shown}\" is passed over: it is no colour"));
            usual
        });

        Paint { colour, material }
    }

    /// Whether it has areas.
    pub fn has_area(&self) -> bool {
        !self.row.geometry.areas.is_empty()
    }
}
