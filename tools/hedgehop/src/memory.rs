//! How the memory that a flight may take is shared out, and what is said of paging.

use clap::Args;
use hedgehop::memory::Paging;
use hedgehop::{Error, Result};

use crate::args::{self, Size};
use crate::sequence::Product;

const MIB: u64 = 1 << 20;

/// Bytes of a pixel while its frame is rendered: what planes saw, and the picture.
const FLYING: u64 = 12;
/// Bytes of a pixel on its way to the disk, with what an encoder holds.
const WRITTEN: u64 = 8;
/// The same of a frame with all its planes.
const WRITTEN_WHOLE: u64 = 72;
/// The program itself, its threads and their scratch memory.
const PROGRAM: u64 = 24 * MIB;
/// Least worth having for pages, and for what is computed from them.
const LEAST: u64 = 24 * MIB;
/// Of what frames leave, pages take so many parts of a hundred; what is computed from them takes the others.
const PAGES_SHARE: u64 = 70;

/// The memory of a flight.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Memory {
    /// Memory to get along with, bytes with suffix K, M or G: frames in flight, pages of the database, light computed from
    /// them; views that need more take more [default: what the system gives]
    #[arg(long, value_name = "BYTES", value_parser = args::bytes)]
    memory: Option<u64>,
}

/// Bytes for what is kept of a database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shares {
    /// Its pages.
    pub pages: u64,
    /// What is computed from them.
    pub derived: u64,
}

impl Memory {
    /// What frames leave of the memory; `None`: there is no limit.
    ///
    /// # Errors
    /// The memory is too little for frames of this size.
    pub fn shares(
        self,
        size: Size,
        product: Product,
        in_flight: usize,
        encoders: usize,
    ) -> Result<Option<Shares>> {
        let Some(memory) = self.memory else { return Ok(None) };
        let pixels = u64::from(size.width) * u64::from(size.height);
        let written = if product == Product::Frame { WRITTEN_WHOLE } else { WRITTEN };
        let (in_flight, waiting) = (in_flight as u64, in_flight as u64 + 2 * encoders as u64);
        let frames = PROGRAM + pixels * (FLYING * in_flight + written * waiting);
        let Some(rest) = memory.checked_sub(frames + 2 * LEAST) else {
            return Err(Error::Configuration(format!(
                "--memory of {} MiB is too little for {} frames of {}x{} in flight; give at least {} MiB, a smaller --size \
                 or --in-flight 1",
                memory / MIB,
                in_flight,
                size.width,
                size.height,
                (frames + 2 * LEAST).div_ceil(MIB)
            )));
        };
        let pages = LEAST + rest * PAGES_SHARE / 100;
        Ok(Some(Shares { pages, derived: rest + 2 * LEAST - pages }))
    }
}

/// What paging cost, in a sentence.
pub fn sentence(paging: &Paging) -> String {
    let seconds = |ns: u64| ns as f64 / 1e9;
    let mib = |bytes: u64| bytes as f64 / MIB as f64;
    let plural = |count: u64| if count == 1 { "" } else { "s" };
    format!(
        "pages: {} read ({:.1} MiB), {} of them unused, {} evicted, at most {:.1} MiB in memory; {} demand miss{} ({:.3} s), frames \
         waited {:.3} s",
        paging.pages_read,
        mib(paging.bytes_read),
        paging.pages_unused,
        paging.pages_evicted,
        mib(paging.resident_bytes_most),
        paging.demand_misses,
        if plural(paging.demand_misses).is_empty() { "" } else { "es" },
        seconds(paging.demand_wait_ns),
        seconds(paging.frame_wait_ns),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size { width: 1920, height: 1080 };

    fn shares(mib: u64, in_flight: usize) -> Result<Option<Shares>> {
        Memory { memory: Some(mib * MIB) }.shares(SIZE, Product::Picture, in_flight, 1)
    }

    #[test]
    fn shares_leave_room_for_frames() {
        let Shares { pages, derived } = shares(512, 2).unwrap().unwrap();
        assert!(pages > 200 * MIB && derived > 80 * MIB && pages + derived < 430 * MIB, "{pages} {derived}");
        assert_eq!(Memory::default().shares(SIZE, Product::Frame, 2, 1).unwrap(), None);
    }

    #[test]
    fn too_little_memory_is_refused_with_what_would_do() {
        let refusal = shares(64, 2).unwrap_err().to_string();
        let least: u64 =
            refusal.split("at least ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(refusal.contains("--memory of 64 MiB"), "{refusal}");
        assert!(shares(least, 2).is_ok() && shares(least - 1, 2).is_err());
    }
}
