//! Shares of the memory that a flight may take, and reports of paging.

use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};

use crate::args;
use crate::product::Product;
use hedgehop::memory::{Paging, ResidentPages};
use hedgehop::progress::Observer;
use hedgehop::{Error, Result, Size};

const MIB: u64 = 1 << 20;

/// Bytes of a pixel while its frame is rendered: what planes saw, and the picture.
const FLYING: u64 = 9;
/// Bytes of a pixel for its range, as planes see it and on the screen, which objects are merged by.
const RANGED: u64 = 10;
/// Bytes of a pixel of a finished picture.
const WAITING: u64 = 3;
/// Bytes a pixel of a frame with all its planes.
const WHOLE: u64 = 36;
/// Bytes of a pixel for what comes together when a view changes at once: what the view before was made of and what this one is, and what
/// the system's allocator keeps between their pieces of all sizes; more the finer the screen.
const BETWEEN: u64 = 40;
/// The program itself, its threads and their scratch memory.
const PROGRAM: u64 = 16 * MIB;
/// Least worth having for pages, and for what is computed from them.
const LEAST: u64 = 24 * MIB;
/// Parts of a hundred of what frames leave that pages take; what is computed from them takes the others. What is lit and turned once needs
/// no paint and no turning when a view comes back to it; but heights that frames ahead need must have room.
const PAGES_SHARE: u64 = 78;

/// Flags of the memory that a flight may take.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Memory {
    /// Memory to get along with, bytes with suffix K, M or G: frames in flight, pages of the database, light computed from
    /// them; views that need more take more [default: what the system gives]
    #[arg(long, value_name = "BYTES", value_parser = args::bytes)]
    memory: Option<u64>,

    /// Load the whole database into memory first; refused if it does not fit
    #[arg(long)]
    preload: bool,
}

/// Treatment of a frame whose pages are not in memory when it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Late {
    /// Wait until they are: pictures are the same on every machine
    #[default]
    Wait,
    /// Begin at once, and the next coarser level stands in
    Coarser,
}

impl Late {
    /// Adds to the settings that decide the pictures that they depend on time.
    pub fn record(self, settings: &mut serde_json::Value) {
        if self == Self::Coarser {
            settings["late"] = "coarser".into();
        }
    }
}

/// Bytes for what is kept of a database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shares {
    /// Bytes for pages.
    pub pages: u64,
    /// Bytes for what is computed from them.
    pub derived: u64,
}

/// Frames that a flight holds besides what it keeps of its database.
#[derive(Debug, Clone, Copy)]
pub struct Frames {
    /// Size of each frame.
    pub size: Size,
    /// Product made of it.
    pub product: Product,
    /// Rays of each pixel along a side, of frames that light is gathered for; 0: codes are made at once.
    pub gathered: u32,
    /// Objects are merged into them.
    pub has_objects: bool,
    /// Bytes of memory that further channels take per pixel of a whole frame.
    pub aov_bytes: u64,
    /// Frames that are rendered at once.
    pub in_flight: usize,
    /// Threads that write.
    pub encoders: usize,
}

impl Frames {
    /// Bytes of them, with those of the program.
    fn bytes(self) -> u64 {
        let pixels = u64::from(self.size.width) * u64::from(self.size.height);
        let with_aov = WHOLE + self.aov_bytes;
        let whole = if self.product == Product::Frame { with_aov } else { 0 };
        // Every encoder holds a frame and what it makes of it, and may have another waiting.
        let waiting = 3 * (WAITING + whole) * self.encoders as u64;
        let ranged = if self.has_objects { RANGED } else { 0 };
        // Frames whose light is gathered are whole ones of so many pixels, and one of as many as are asked for, which alone has further channels.
        let rays = u64::from(self.gathered.max(1)).pow(2);
        let light = if self.gathered > 0 { WHOLE * rays + with_aov } else { whole };
        PROGRAM
            + pixels * (((FLYING + ranged) * rays + light) * self.in_flight as u64 + waiting + BETWEEN * rays)
    }

    /// Least memory that has room for so many bytes of pages.
    pub fn memory_for(self, pages: u64) -> u64 {
        let rest = pages.saturating_sub(LEAST).div_ceil(PAGES_SHARE) * 100;
        self.bytes() + 2 * LEAST + rest
    }
}

/// Memory that is free for a program, and that its group may take, bytes; `None` where the system does not say.
pub fn available() -> Option<u64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    // Not its `free_memory`: that counts cached files as taken, the database's own pages among them.
    let group = system.cgroup_limits().map(|limits| limits.total_memory.saturating_sub(limits.rss));
    let free = Some(system.available_memory()).filter(|bytes| *bytes > 0)?;
    Some(group.map_or(free, |group| group.min(free)))
}

impl Memory {
    /// Grants so many bytes, of which pages come as they are needed.
    pub fn of(bytes: u64) -> Self {
        Self { memory: Some(bytes), preload: false }
    }

    /// Returns the bytes to get along with; `None`: there is no limit.
    pub fn bytes(self) -> Option<u64> {
        self.memory
    }

    /// Loads the database if that was asked for.
    ///
    /// # Errors
    /// It does not fit; a page that is damaged; an interruption.
    pub fn preload(
        self,
        pages: &ResidentPages,
        shares: Option<Shares>,
        observer: &dyn Observer,
    ) -> Result<()> {
        if !self.preload {
            return Ok(());
        }

        if let (Some(memory), Some(shares)) = (self.memory, shares)
            && let Some(missing) = pages.bytes().checked_sub(shares.pages).filter(|missing| *missing > 0)
        {
            return Err(Error::Configuration(format!(
                "--preload needs {} for all pages of {}, and --memory {} leaves {} for pages; give --memory {}M, or leave out one of the \
                 two",
                amount(pages.bytes()),
                pages.file().path().display(),
                amount(memory),
                amount(shares.pages),
                (memory + missing * 100 / PAGES_SHARE).div_ceil(MIB) + 1
            )));
        }

        if let Some(free) = available()
            && free < pages.bytes()
        {
            return Err(Error::Configuration(format!(
                "--preload needs {} MiB for all pages of {}, and {} MiB of memory are free; leave it out, pages then come as they are \
                 needed",
                pages.bytes().div_ceil(MIB),
                pages.file().path().display(),
                free / MIB
            )));
        }

        pages.load_all(observer)
    }

    /// Returns the shares of what frames leave of the memory; `None`: there is no limit.
    ///
    /// # Errors
    /// The memory is too little for frames of this size.
    pub fn shares(self, frames: Frames) -> Result<Option<Shares>> {
        let Some(memory) = self.memory else { return Ok(None) };
        let least = frames.memory_for(LEAST);
        let Some(rest) = memory.checked_sub(least) else {
            let (count, remedy) = match frames.in_flight {
                1 => ("one frame".into(), " or a smaller --size"),
                count => (format!("{count} frames"), ", a smaller --size or --in-flight 1"),
            };
            return Err(Error::Configuration(format!(
                "--memory of {} is too little for {count} of {} in flight; give at least {} MiB{remedy}",
                amount(memory),
                frames.size,
                least.div_ceil(MIB)
            )));
        };
        let pages = LEAST + rest * PAGES_SHARE / 100;
        Ok(Some(Shares { pages, derived: rest + 2 * LEAST - pages }))
    }
}

/// Bytes as people read them: a small database has less than a MiB.
pub fn amount(bytes: u64) -> String {
    let mib = bytes as f64 / MIB as f64;
    match bytes {
        0..1024 => format!("{bytes} B"),
        1024..MIB => format!("{:.0} KiB", 1024.0 * mib),
        _ if mib < 10_000.0 && bytes.is_multiple_of(MIB) => format!("{mib:.0} MiB"),
        _ if mib < 10_000.0 => format!("{mib:.1} MiB"),
        _ => format!("{:.1} GiB", mib / 1024.0),
    }
}

/// Says what paging cost, in a sentence.
pub fn sentence(paging: &Paging) -> String {
    let late = match paging.pages_late {
        0 => String::new(),
        1 => ", 1 part late".into(),
        count => format!(", {count} parts late, added up over the frames"),
    };
    let in_sight = match paging.pages_in_sight {
        0 => String::new(),
        count => format!(", {count} brought once they were visible"),
    };

    format!(
        "parts of pages: {} read ({}), {} of them unused ({}), {} evicted{in_sight}, at most {} in memory; {}{late}",
        paging.pages_read,
        amount(paging.bytes_read),
        paging.pages_unused,
        amount(paging.bytes_unused),
        paging.pages_evicted,
        amount(paging.resident_bytes_most),
        waits(paging),
    )
}

/// Says who waited for pages, and how long.
fn waits(paging: &Paging) -> String {
    let seconds = |ns: u64| ns as f64 / 1e9;
    let plural = |count: u64, ending: &'static str| if count == 1 { "" } else { ending };
    let (misses, waits) = (paging.demand_misses, paging.demand_waits);
    let coming = match waits {
        0 => String::new(),
        _ => format!(" and {waits} wait{} for pages on their way", plural(waits, "s")),
    };
    format!(
        "{misses} demand miss{}{coming} ({:.3} s), frames waited {:.3} s",
        plural(misses, "es"),
        seconds(paging.demand_wait_ns),
        seconds(paging.frame_wait_ns),
    )
}

/// Tells a flight's paging while it goes on.
#[derive(Debug)]
pub struct Live {
    told: Instant,
    frames: u64,
    before: Paging,
}

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(1);

impl Live {
    /// Begins now.
    pub fn new(paging: Paging) -> Self {
        Self { told: Instant::now(), frames: 0, before: paging }
    }

    /// Another frame was delivered; what there is to say, once a second.
    pub fn deliver(&mut self, number: u64, paging: impl Fn() -> Paging) -> Option<String> {
        self.frames += 1;
        let seconds = self.told.elapsed().as_secs_f64();
        if seconds < INTERVAL.as_secs_f64() {
            return None;
        }
        let now = paging();
        let since = now.since(&self.before);
        let mib = |bytes: u64| bytes as f64 / MIB as f64;
        let text = format!(
            "frame {number}: {:.1} frames/s, {:.1} MiB of pages in memory, {:.1} MiB/s read, {} evicted, {}",
            self.frames as f64 / seconds,
            mib(since.resident_bytes),
            mib(since.bytes_read) / seconds,
            since.pages_evicted,
            waits(&since),
        );
        *self = Self { told: Instant::now(), frames: 0, before: now };
        Some(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size { width: 1920, height: 1080 };

    fn frames(product: Product, in_flight: usize) -> Frames {
        Frames { size: SIZE, product, gathered: 0, has_objects: false, aov_bytes: 0, in_flight, encoders: 1 }
    }

    fn shares(mib: u64, in_flight: usize) -> Result<Option<Shares>> {
        Memory { memory: Some(mib * MIB), preload: false }.shares(frames(Product::Picture, in_flight))
    }

    #[test]
    fn shares_leave_room_for_frames() {
        let Shares { pages, derived } = shares(512, 2).unwrap().unwrap();
        assert!(pages > 260 * MIB && derived > 85 * MIB && pages + derived < 375 * MIB, "{pages} {derived}");
        assert_eq!(Memory::default().shares(frames(Product::Frame, 2)).unwrap(), None);
    }

    #[test]
    fn too_little_memory_is_refused_with_what_would_do() {
        let refusal = shares(64, 2).unwrap_err().to_string();
        let least: u64 =
            refusal.split("at least ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(refusal.contains("--memory of 64 MiB") && refusal.contains("--in-flight 1"), "{refusal}");
        let alone = shares(64, 1).unwrap_err().to_string();
        assert!(alone.contains("one frame") && !alone.contains("--in-flight"), "{alone}");
        assert!(shares(least, 2).is_ok() && shares(least - 1, 2).is_err());
    }

    #[test]
    fn further_channels_take_memory_in_flight_even_where_light_is_gathered() {
        let pixels = u64::from(SIZE.width) * u64::from(SIZE.height);
        for gathered in [0, 2] {
            let plain = Frames { gathered, encoders: 0, ..frames(Product::Frame, 2) };
            let rich = Frames { aov_bytes: 20, ..plain };
            assert_eq!(rich.bytes() - plain.bytes(), 2 * 20 * pixels, "{gathered}");
        }
    }

    #[test]
    fn little_is_not_told_as_nothing() {
        let told = [1, 13 << 10, 64 * MIB, 3 * MIB / 2, 20_000 * MIB].map(amount);
        assert_eq!(told, ["1 B", "13 KiB", "64 MiB", "1.5 MiB", "19.5 GiB"]);
    }

    #[test]
    fn memory_for_pages_holds_them() {
        for pages in [LEAST, 200 * MIB, 777 * MIB + 1] {
            let memory = Memory { memory: Some(frames(Product::Frame, 3).memory_for(pages)), preload: false };
            let got = memory.shares(frames(Product::Frame, 3)).unwrap().unwrap().pages;
            assert!(got >= pages && got < pages + MIB, "{got} for {pages}");
        }
    }
}
