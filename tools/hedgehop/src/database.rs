//! Databases as commands name them: files of this machine, and URLs.

use std::convert::Infallible;
use std::ffi::OsString;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;

use crate::args;
use hedgehop::memory::PageFile;
use hedgehop::voxel::Trust;
use hedgehop::{Error, Result};
use hedgehop_remote::{Address, CacheSettings, DEFAULT_SIZE, default_folder};

/// Heading of the flags in help: they follow others, which are not to stand under it.
const HEADING: &str = "Databases behind a URL";

/// Environment variable that names the cache.
const CACHE: &str = "HEDGEHOP_CACHE";

/// Name of a database. As a path it is the file, or the URL without passwords and queries, so that messages can show it.
#[derive(Debug, Clone)]
pub struct DatabaseName {
    shown: PathBuf,
    address: Option<Address>,
}

impl DatabaseName {
    /// Whether it is a URL with what others are not to see: a password, or a query, which may be a signature.
    pub fn has_secret(&self) -> bool {
        self.address.as_ref().is_some_and(Address::has_secret)
    }

    /// Whether it is a URL.
    pub fn is_remote(&self) -> bool {
        self.address.is_some()
    }
}

impl From<OsString> for DatabaseName {
    fn from(name: OsString) -> Self {
        PathBuf::from(name).into()
    }
}

impl From<PathBuf> for DatabaseName {
    fn from(name: PathBuf) -> Self {
        let address = name.to_str().and_then(Address::of);
        let shown = address.as_ref().map(|address| address.shown().to_owned());
        Self { shown: shown.unwrap_or(name), address }
    }
}

impl FromStr for DatabaseName {
    type Err = Infallible;

    fn from_str(name: &str) -> std::result::Result<Self, Infallible> {
        Ok(PathBuf::from(name).into())
    }
}

impl Deref for DatabaseName {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.shown
    }
}

/// Flags of the cache of databases on other machines.
#[derive(Debug, Clone, Default, Args)]
pub struct CacheArgs {
    /// Folder for what was fetched of them [default: $HEDGEHOP_CACHE, or hedgehop where the system keeps caches]
    #[arg(long, value_name = "DIR", help_heading = HEADING)]
    cache: Option<PathBuf>,

    /// Bytes that the cache may take, with suffix K, M or G; a flight that needs more takes more while it lasts [default: 20G]
    #[arg(long, value_name = "BYTES", value_parser = args::bytes, help_heading = HEADING)]
    cache_size: Option<u64>,
}

impl CacheArgs {
    /// Opens a database.
    pub fn open(&self, name: &DatabaseName) -> Result<PageFile> {
        self.open_trusting(name, Trust::default())
    }

    /// Opens a database with pages checked otherwise, or with damaged ones left out.
    pub fn open_trusting(&self, name: &DatabaseName, trust: Trust) -> Result<PageFile> {
        let Some(address) = &name.address else {
            return PageFile::open_trusting(name, trust);
        };
        let of_environment = || std::env::var_os(CACHE).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = self.cache.clone().or_else(of_environment).or_else(default_folder).ok_or_else(|| {
            Error::Configuration("no folder is known for what is fetched; give one by --cache DIR".into())
        })?;
        let settings = CacheSettings { folder, size: self.cache_size.unwrap_or(DEFAULT_SIZE) };
        hedgehop_remote::open(address, &settings, trust)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_told_from_files_and_keep_their_secrets() {
        let remote = DatabaseName::from(OsString::from("https://me:key@host/area.hop?signature=abc"));
        assert!(remote.is_remote());
        assert_eq!(&*remote, Path::new("https://host/area.hop"));
        let said = format!("{remote:?}");
        assert!(!said.contains("key") && !said.contains("abc"), "{said}");
        assert!(!DatabaseName::from(OsString::from("areas/area.hop")).is_remote());
    }
}
