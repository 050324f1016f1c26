//! Pages that wait for their place in the file, and what is known of them: whoever is killed meanwhile leaves them to the next build.

use std::path::{Path, PathBuf};

use super::{Log, MadeRecord, beside};
use hedgehop_base::error::{Error, Result};

/// Notes on pages that are set aside in a file of their own; dropped, they are removed.
pub(crate) struct Aside {
    log: Log,
    path: PathBuf,
}

impl Aside {
    /// Opens the pages in the file `aside`.
    pub fn of(aside: &Path) -> Result<Self> {
        let path = beside(aside);
        let mut log = Log::default();
        match log.begin(&path) {
            Ok(()) => Ok(Self { log, path }),
            Err(error) => Err(Error::io(path, "write what is known of the pages", error)),
        }
    }

    /// Notes pages with their places in the file.
    pub fn note(&mut self, pages: impl IntoIterator<Item = MadeRecord>) -> Result<()> {
        pages.into_iter().for_each(|made| self.log.page(&made));
        self.log.write().map_err(|error| self.unwritable(error))
    }

    /// All pages have another place by now.
    pub fn clear(&mut self) -> Result<()> {
        self.log.restart().map_err(|error| self.unwritable(error))
    }

    fn unwritable(&self, error: std::io::Error) -> Error {
        Error::io(&self.path, "write what is known of the pages", error)
    }
}
