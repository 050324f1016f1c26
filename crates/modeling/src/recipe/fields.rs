//! Tables of which every mistake is told, not the first one alone.

use std::cell::RefCell;
use std::ops::Range;

use serde::de::{DeserializeOwned, IntoDeserializer};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::recipe::Mistake;
use hedgehop_base::document::{Reading, plain};

/// All that is wrong with a file, in the order in which it was found.
#[derive(Debug)]
pub(super) struct Mistakes<'r> {
    pub reading: Reading<'r>,
    found: RefCell<Vec<Mistake>>,
}

impl<'r> Mistakes<'r> {
    /// None yet.
    pub fn of(reading: Reading<'r>) -> Self {
        Self { reading, found: RefCell::default() }
    }

    /// Something is wrong at a place of the file.
    pub fn add(&self, span: &Range<usize>, what: impl std::fmt::Display) {
        let what = plain(&what.to_string());
        self.found.borrow_mut().push(Mistake { line: self.reading.line(span), what });
    }

    /// Takes a result, or nothing and a mistake at a place of the file.
    pub fn check<T>(&self, span: &Range<usize>, found: Result<T, impl std::fmt::Display>) -> Option<T> {
        found.map_err(|what| self.add(span, what)).ok()
    }

    /// Whether nothing was found wrong so far.
    pub fn is_empty(&self) -> bool {
        self.found.borrow().is_empty()
    }

    /// Returns the mistakes by line.
    pub fn into_vec(self) -> Vec<Mistake> {
        let mut found = self.found.into_inner();
        found.sort_by_key(|mistake| mistake.line);
        found
    }
}

/// Names a value of the wrong kind, for people who do not write programs.
fn plain_words(key: &str, message: &str) -> String {
    let kinds = ["invalid type: ", "invalid value: "].iter().find_map(|begin| message.strip_prefix(begin));
    let Some((given, wanted)) = kinds.and_then(|kinds| kinds.rsplit_once(", expected ")) else {
        // What a value may be is told with its key already.
        let is_named = message.strip_prefix(key).is_some_and(|rest| rest.starts_with(' '));
        return if is_named { message.to_owned() } else { format!("{key}: {message}") };
    };
    let wanted = match wanted {
        "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u32" => "a whole number from 0 to 4294967295",
        "a boolean" => "true or false",
        "a tuple of size 2" => "a number and a colour in brackets",
        "a string" | "path string" => "text in quotation marks",
        "a sequence" => "several values in brackets",
        other => other,
    };
    let given = given.trim_end_matches(" as i128").replace("floating point", "decimal number");
    format!("{key} is {wanted}, not {given}")
}

/// A table while its keys are taken from it.
pub(super) struct Fields<'m, 'r, 'i> {
    /// Name in the file.
    name: &'static str,
    span: Range<usize>,
    table: DeTable<'i>,
    known: Vec<&'static str>,
    /// Lines of the keys that were there.
    lines: Vec<(&'static str, usize)>,
    pub mistakes: &'m Mistakes<'r>,
}

impl<'m, 'r, 'i> Fields<'m, 'r, 'i> {
    /// The table `value`, if it is one.
    pub fn of(name: &'static str, value: Spanned<DeValue<'i>>, mistakes: &'m Mistakes<'r>) -> Option<Self> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => {
                Some(Self { name, span, table, known: Vec::new(), lines: Vec::new(), mistakes })
            }
            other => {
                mistakes.add(&span, format!("{name} is a table, not {}", other.type_str()));
                None
            }
        }
    }

    /// The table of a whole file.
    pub fn root(table: DeTable<'i>, mistakes: &'m Mistakes<'r>) -> Self {
        Self { name: "a recipe", span: 0..0, table, known: Vec::new(), lines: Vec::new(), mistakes }
    }

    /// Whether a key is there, and not yet taken.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Returns the span of a key's value that is there, and not yet taken.
    pub fn span_of(&self, key: &str) -> Option<Range<usize>> {
        self.table.get(key).map(Spanned::span)
    }

    /// Names a key that the table may have, and has not: a slip of the pen is told with it.
    pub fn known(&mut self, key: &'static str) {
        self.known.push(key);
    }

    /// A key that would say nothing where it stands is a mistake; it must not have been taken yet.
    pub fn refuse(&self, key: &str, what: impl std::fmt::Display) {
        if let Some(span) = self.span_of(key) {
            self.mistakes.add(&span, what);
        }
    }

    /// Returns the span of the table.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The value of a key as it stands there.
    pub fn value(&mut self, key: &'static str) -> Option<Spanned<DeValue<'i>>> {
        self.known.push(key);
        let value = self.table.remove(key)?;
        self.lines.push((key, self.mistakes.reading.line(&value.span())));
        Some(value)
    }

    /// The table of a key, if there is one.
    pub fn table(&mut self, key: &'static str, name: &'static str) -> Option<Self> {
        let value = self.value(key)?;
        Self::of(name, value, self.mistakes)
    }

    /// The line on which it begins, from 1 on.
    pub fn line(&self) -> usize {
        self.mistakes.reading.line(&self.span)
    }

    /// The value of a key, if it is there and of the right kind.
    pub fn take<T: DeserializeOwned>(&mut self, key: &'static str) -> Option<Spanned<T>> {
        let value = self.value(key)?;
        let span = value.span();
        let read = T::deserialize(value.into_deserializer());
        let read = read.map_err(|error| plain_words(key, &error.message().trim().replace('\n', ", ")));
        Some(Spanned::new(span.clone(), self.mistakes.check(&span, read)?))
    }

    /// The value of a key that must be there.
    pub fn need<T: DeserializeOwned>(&mut self, key: &'static str, example: &str) -> Option<Spanned<T>> {
        if !self.table.contains_key(key) {
            self.mistakes.add(&self.span, format!("{} needs `{key}`, as in {key} = {example}", self.name));
        }
        self.take(key)
    }

    /// A number that `holds`; `want` says which do, beginning with a verb.
    pub fn number(&mut self, key: &'static str, holds: impl Fn(f64) -> bool, want: &str) -> Option<f64> {
        let number = self.take::<f64>(key)?;
        self.mistakes.check(&number.span(), Reading::checked(key, *number.get_ref(), holds, want))
    }

    /// The tables of `[[key]]`, in their order.
    pub fn tables(&mut self, key: &'static str, name: &'static str) -> Vec<Self> {
        let Some(value) = self.value(key) else { return Vec::new() };
        let span = value.span();
        match value.into_inner() {
            DeValue::Array(array) => {
                array.into_iter().filter_map(|value| Self::of(name, value, self.mistakes)).collect()
            }
            _ => {
                self.mistakes.add(&span, format!("write {name}, in two brackets: there may be several"));
                Vec::new()
            }
        }
    }

    /// Whatever is left is a mistake. The lines of the keys that were there.
    pub fn finish(self) -> Vec<(&'static str, usize)> {
        for key in self.table.keys() {
            let given = key.get_ref();
            let nearest =
                self.known.iter().map(|known| (strsim::damerau_levenshtein(known, given), known)).min();
            let hint = match nearest {
                Some((steps, known)) if steps <= 1 + known.len() / 4 => format!("did you mean `{known}`?"),
                _ => format!("it has {}", self.known.join(", ")),
            };
            self.mistakes.add(&key.span(), format!("{} has no key `{given}`; {hint}", self.name));
        }
        self.lines
    }
}
