//! State of a resource on a server, by which a replaced one is told.

/// Headers of an answer that change when the resource does.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Validator {
    /// Entity tag as the server writes it, with quotes.
    pub etag: Option<String>,
    /// Time of the last change, as the server writes it.
    pub last_modified: Option<String>,
    /// Bytes of the resource.
    pub length: u64,
}

impl Validator {
    /// Returns the tag, if equal ones say that all bytes are equal.
    pub fn strong_etag(&self) -> Option<&str> {
        self.etag.as_deref().filter(|etag| etag.len() > 2 && etag.starts_with('"') && etag.ends_with('"'))
    }

    /// Returns the header that has a server refuse the request if the resource is another one by now.
    pub fn condition(&self) -> Option<(&'static str, &str)> {
        let unless_later = || Some(("If-Unmodified-Since", self.last_modified.as_deref()?));
        self.strong_etag().map(|etag| ("If-Match", etag)).or_else(unless_later)
    }

    /// Whether an answer is of the same resource: a server may not know conditions.
    pub fn agrees(&self, other: &Self) -> bool {
        let same = |a: &Option<String>, b: &Option<String>| a.is_none() || b.is_none() || a == b;
        self.length == other.length
            && same(&self.etag, &other.etag)
            && (self.strong_etag().is_some() || same(&self.last_modified, &other.last_modified))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn validator(etag: &str, last_modified: &str) -> Validator {
        let given = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
        Validator { etag: given(etag), last_modified: given(last_modified), length: 9 }
    }

    #[test]
    fn strong_tags_come_first() {
        assert_eq!(validator("\"a\"", "Mon").condition(), Some(("If-Match", "\"a\"")));
        assert_eq!(validator("W/\"a\"", "Mon").condition(), Some(("If-Unmodified-Since", "Mon")));
        assert_eq!(validator("\"\"", "").condition(), None);
    }

    #[test]
    fn another_resource_differs() {
        let first = validator("\"a\"", "Mon");
        assert!(first.agrees(&validator("\"a\"", "Tue")) && first.agrees(&validator("", "")));
        assert!(!first.agrees(&validator("\"b\"", "Mon")));
        assert!(!first.agrees(&Validator { length: 8, ..first.clone() }));
        assert!(!validator("", "Mon").agrees(&validator("", "Tue")));
        assert!(!validator("W/\"a\"", "").agrees(&validator("W/\"b\"", "")));
    }
}
