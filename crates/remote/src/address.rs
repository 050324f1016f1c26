//! Address of a database, and the part of it that may be shown.

use std::fmt;
use std::path::{Path, PathBuf};

/// URL of a database. Names, passwords and queries, which may hold signatures, are used and never shown.
#[derive(Clone, PartialEq, Eq)]
pub struct Address {
    url: String,
    shown: PathBuf,
}

impl Address {
    /// Reads a URL, of whatever scheme; `None`: the text names a file.
    pub fn of(text: &str) -> Option<Self> {
        let (scheme, rest) = text.split_once("://")?;
        let is_scheme = scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
        if !is_scheme {
            return None;
        }

        // Fragments are never sent.
        let rest = rest.split('#').next().unwrap_or_default();
        let (authority, path) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
        let host = authority.rsplit('@').next().unwrap_or_default();
        let path = path.split('?').next().unwrap_or_default();
        let scheme_shown = scheme.to_ascii_lowercase();

        Some(Self {
            url: format!("{scheme_shown}://{rest}"),
            shown: format!("{scheme_shown}://{host}{path}").into(),
        })
    }

    /// Whether databases are read from addresses of this scheme.
    pub fn is_http(&self) -> bool {
        ["http://", "https://"].iter().any(|scheme| self.url.starts_with(scheme))
    }

    /// Returns what may be shown: the URL without name, password and query.
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// Whether it holds what others are not to see: a password, or a query, which may be a signature.
    pub fn has_secret(&self) -> bool {
        self.url.len() > self.shown.as_os_str().len()
    }

    /// Returns all of it. Nobody prints it.
    pub(crate) fn secret(&self) -> &str {
        &self.url
    }
}

impl fmt::Debug for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Address").field(&self.shown).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_are_not_shown() {
        let url = "HTTPS://me:pass@word@host:8443/a/area.hop?X-Amz-Signature=abc#part";
        let address = Address::of(url).unwrap();
        assert_eq!(address.shown(), Path::new("https://host:8443/a/area.hop"));
        assert_eq!(address.secret(), "https://me:pass@word@host:8443/a/area.hop?X-Amz-Signature=abc");
        assert_eq!(format!("{address:?}"), "Address(\"https://host:8443/a/area.hop\")");
        let bare = Address::of("http://host?key=1/2").unwrap();
        assert_eq!((bare.shown(), bare.is_http()), (Path::new("http://host"), true));
    }

    #[test]
    fn files_are_no_addresses() {
        for file in ["area.hop", "/data/area.hop", "C:\\area.hop", "./a b://c", "://x"] {
            assert_eq!(Address::of(file), None, "{file}");
        }
        assert!(!Address::of("s3://bucket/area.hop").unwrap().is_http());
    }
}
