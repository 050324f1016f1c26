//! The fields of a text header that stands beside raw samples.

use std::collections::HashMap;
use std::path::Path;

use hedgehop_base::error::{Error, Result};

/// A value for each key; keys are in lower case.
pub(super) struct TextFields<'a> {
    /// The header, for messages.
    pub path: &'a Path,
    pub values: HashMap<String, String>,
}

impl TextFields<'_> {
    pub fn text(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    pub fn wrong(&self, key: &str, value: &str) -> Error {
        Error::invalid(self.path, format!("states {key} = {value}, which is not understood"))
    }

    /// A finite number.
    pub fn number(&self, key: &str) -> Result<Option<f64>> {
        let Some(text) = self.text(key) else { return Ok(None) };
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.map(Some).ok_or_else(|| self.wrong(key, text))
    }

    pub fn whole(&self, key: &str) -> Result<Option<u32>> {
        let Some(text) = self.text(key) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| self.wrong(key, text))
    }

    /// A whole number that must be there, above 0.
    pub fn size(&self, key: &str) -> Result<u32> {
        match self.whole(key)? {
            Some(size) if size > 0 => Ok(size),
            _ => Err(Error::invalid(self.path, format!("states no {key} above zero"))),
        }
    }
}
