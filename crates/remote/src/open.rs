//! Opening a database by its URL.

use std::io;
use std::ops::Range;

use super::address::Address;
use super::blocks::BLOCK;
use super::cache::{Cache, CacheSettings};
use super::client::{Answer, Client, Condition};
use super::fetcher::{Fetcher, Origin};
use super::known::Known;
use hedgehop::memory::{HoleFiller, PageFile};
use hedgehop::voxel::{FileEnds, HEADER_BYTES, Trust};
use hedgehop_base::error::{Error, Result};

/// Opens the database behind a URL. Its pages are fetched when they are first needed, and kept in the cache.
///
/// # Errors
/// The server does not give it, or not in parts; it is no database, or damaged; no copy of it can be kept.
pub fn open(address: &Address, cache: &CacheSettings, trust: Trust) -> Result<PageFile> {
    if !address.is_http() {
        return Err(Error::Configuration(format!(
            "{}: databases are read from addresses that begin with http:// or https://; give such a one (of S3 a public or presigned one), \
             or copy the file",
            address.shown().display()
        )));
    }

    match open_once(address, cache, trust, Copied::Trusted) {
        // What was kept may be damaged, and not what is on the server.
        Err(Error::Invalid { .. }) => open_once(address, cache, trust, Copied::Fetched),
        opened => opened,
    }
}

/// Treatment of the header and the directory in the cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Copied {
    /// Read as they are.
    Trusted,
    /// Fetched again.
    Fetched,
}

fn open_once(address: &Address, settings: &CacheSettings, trust: Trust, copied: Copied) -> Result<PageFile> {
    let cache = Cache::open(settings.clone())?;
    let folder = cache.folder().to_owned();
    let name = address.shown();
    let known = Known::read(&folder, address).filter(|_| copied == Copied::Trusted);

    let client = Client::new(address.clone())?;
    let Known { validator, start } = first_bytes(&client, known)
        .map_err(|what| Error::io(name, "open it as a database", io::Error::other(what)))?;
    let ends = FileEnds::of_start(name, &start, validator.length)?;

    // Where pages lie is not a part of a database's identity, but of its header.
    let layout = blake3::hash(&start[..HEADER_BYTES]).to_hex();
    let identity = format!("{}-{}-{}", ends.content_hash, validator.length, &layout[..16]);
    let entry = cache.entry(identity, validator.length)?;
    entry.make_room();

    let known = Known { validator: validator.clone(), start: start.clone() };
    let fetcher = Fetcher::new(Origin { client, validator, start }, entry);
    for stretch in ends.stretches() {
        let is_there = match copied {
            Copied::Trusted => fetcher.fill(stretch),
            Copied::Fetched => fetcher.refill(stretch),
        };
        if !is_there {
            fetcher.intact()?;
        }
    }
    known.write(&folder, address);

    let data = fetcher.entry().copy().data()?;
    PageFile::open_sparse(name, data, Box::new(fetcher), trust)
}

/// Asks for the first bytes of the database, and what they are of: as they were, if the server says that nothing changed.
fn first_bytes(client: &Client, known: Option<Known>) -> Result<Known, String> {
    let pause = |time| {
        std::thread::sleep(time);
        true
    };
    let range: Range<u64> = 0..BLOCK;
    let condition = known.as_ref().map_or(Condition::Any, |known| Condition::Other(&known.validator));
    match Origin::ask(client, &range, condition, pause)? {
        Answer::Part(start, validator) => Ok(Known { validator, start }),
        Answer::Unchanged => known.ok_or_else(|| "the server answered what it was not asked".into()),
    }
}
