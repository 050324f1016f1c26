//! Builds that make only what changed since the last one, or go on where one was interrupted.
//!
//! ```text
//! each step has a key: a hash of all that its result is a function of
//!     survey of an elevation file   ← the file, the part of it that the area needs
//!     extent of a feature           ← the feature, all elevation
//!     page of level 1               ← the grid, the code of heights, the rasters and features that reach it
//!     coarser page                  ← the hashes of the finer pages that it is made from; where some are absent, as of level 1
//! beside AREA.hop lies AREA.hop.steps: keys and results of steps, where each page lies
//! shadows are a database of their own, of the one without: [`super::bake_shadows`]
//!     light on a page               ← the way of the sun's rays, the pages that they pass over
//!     page                          ← it without shadows, the shares of the sun that came of its light and of that around it
//! a page whose key is there is taken from AREA.hop, all others are made: the file is the same, byte for byte, as if all were
//! where pages stay in their place, only those that were made are written; and as long as the system's times tell that nobody changed the file,
//! none of the others is read
//! while a build runs, its pages lie in AREA.hop.part-…, and what is known of them in AREA.hop.part-….steps: the next build takes them from there;
//! those that wait for their place lie in another such pair, so that one who is killed loses none
//! ```
//! After "Build Systems à la Carte" (Mokhov, Mitchell and Peyton Jones 2018, §3): verifying traces, with early cut-off at coarser
//! levels.

mod aside;
mod handover;
mod key;
mod log;

use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::counts::PageCounts;
use crate::survey_result::Survey;
pub(super) use aside::Aside;
pub use handover::take_over;
use hedgehop::voxel::{ContentHash, EarlierFile, EarlierPage, Grid, PageId, PageWriter, SealedFile};
use hedgehop_base::error::{Error, Result};
pub(super) use key::{Key, Keyer};
pub(super) use log::{Extent, MadeRecord};
use log::{KnownSteps, Log, Stamp, name_of};

/// Suffix of a file that notes steps.
const SUFFIX: &str = ".steps";
/// A file that was changed so shortly before it was looked at may be changed again without a sign of it.
const SETTLED: Duration = Duration::from_secs(2);
/// The same where the system's times are finer than seconds.
const TICK: Duration = Duration::from_millis(20);

/// Steps of builds before, and of this one.
#[derive(Debug)]
pub(super) struct BuildCache {
    output: PathBuf,
    files: HashMap<String, (Stamp, Key)>,
    surveys: HashMap<Key, Survey>,
    features: HashMap<Key, Extent>,
    lights: HashMap<Key, Key>,
    earlier: Vec<Earlier>,
    /// File that is to be replaced, if pages of it are known.
    base: Option<EarlierFile>,
    /// Parts that earlier builds left, and pages that are known of each.
    left: Vec<(PathBuf, usize)>,
    log: Mutex<Log>,
}

/// A file of pages.
#[derive(Debug)]
struct Earlier {
    file: EarlierFile,
    pages: HashMap<PageId, MadeRecord>,
    /// Nobody changed it since it was done.
    is_as_left: bool,
}

/// A page that need not be made again, and that of bare ground that goes with it.
pub(super) struct Reused {
    pub page: EarlierPage,
    pub bare: Option<EarlierPage>,
    pub counts: PageCounts,
}

/// Whether a build that keeps its steps wrote what is there now, so that the next build may replace it.
pub fn is_own_work(output: &Path) -> bool {
    let file = EarlierFile::open(output);
    adopt(output, file.as_ref());
    let whole = KnownSteps::read(&beside(output)).whole;
    whole.is_some() && whole == file.and_then(|file| file.identity())
}

/// Whether builds that keep their steps left something at `kept` for the database `output`: all of it, or the pages of one that was interrupted.
pub fn is_kept_for(kept: &Path, output: &Path) -> bool {
    let is_for = |log: &Path| KnownSteps::read(log).kept_for == Some(name_of(output));
    if fs::symlink_metadata(kept).is_ok() {
        return is_own_work(kept) && is_for(&beside(kept));
    }
    parts(kept).iter().any(|part| is_for(&beside(part)) && EarlierFile::open_abandoned(part).is_some())
}

/// Gives `output` its log, if the build that wrote it was killed before it could.
fn adopt(output: &Path, file: Option<&EarlierFile>) {
    let Some(identity) = file.and_then(EarlierFile::identity) else { return };
    let is_of_output = |log: &Path| KnownSteps::read(log).whole == Some(identity);
    let parts = parts(output);
    if parts.is_empty() || is_of_output(&beside(output)) {
        return;
    }
    if let Some(part) = parts.into_iter().find(|part| is_of_output(&beside(part)))
        && fs::rename(beside(&part), beside(output)).is_ok()
    {
        forget(&part);
    }
}

/// Forgets the steps of builds of `output`, so that the next one makes all of it; but not that it is [own work](is_own_work).
pub fn forget_steps(output: &Path) {
    adopt(output, EarlierFile::open(output).as_ref());
    let known = KnownSteps::read(&beside(output));
    parts(output).iter().for_each(|part| forget(part));
    note_own_work(output, &known);
}

/// Notes that a build of a recipe wrote `output`, without any steps; nothing is known of it if it was none.
fn note_own_work(output: &Path, known: &KnownSteps) {
    let path = beside(output);
    let written = known.whole.and_then(|identity| {
        let mut log = Log::default();
        log.whole(identity);
        if let Some(name) = &known.kept_for {
            log.kept_for(name);
        }
        // Whoever is killed meanwhile has the one or the other.
        let fresh = beside(&path);
        let _ = fs::remove_file(&fresh);
        log.begin(&fresh).ok()?;
        fs::rename(log.keep()?, &path).ok()
    });
    if written.is_none() {
        // Without it the next build asks for --overwrite. What is not there need not be forgotten.
        let _ = fs::remove_file(path);
    }
}

/// The log of a file.
fn beside(file: &Path) -> PathBuf {
    let mut name = OsString::from(file);
    name.push(SUFFIX);
    name.into()
}

impl BuildCache {
    /// Reads the steps that are known of `output`.
    pub fn of(output: &Path) -> Self {
        let mut cache = Self {
            output: output.to_owned(),
            files: HashMap::new(),
            surveys: HashMap::new(),
            features: HashMap::new(),
            lights: HashMap::new(),
            earlier: Vec::new(),
            base: None,
            left: Vec::new(),
            log: Mutex::default(),
        };

        let file = EarlierFile::open(output);
        adopt(output, file.as_ref());
        let known = KnownSteps::read(&beside(output));
        let file = file.filter(|file| file.content_hash() == known.whole);
        cache.base = file.clone().filter(|_| !known.pages.is_empty());
        let is_as_left = known.left.is_some() && known.left == stamp(output).ok();
        cache.take(known, file, is_as_left);

        for part in parts(output) {
            // A build was killed between its part and its log; one that runs has just written to it.
            if fs::symlink_metadata(&part).is_err() && is_settled(&beside(&part)) {
                forget(&part);
                continue;
            }
            let Some(file) = EarlierFile::open_abandoned(&part) else { continue };
            let known = KnownSteps::read(&beside(&part));
            cache.left.push((part, known.pages.len()));
            cache.take(known, Some(file), false);
        }

        cache
    }

    fn take(&mut self, known: KnownSteps, file: Option<EarlierFile>, is_as_left: bool) {
        self.files.extend(known.files);
        self.surveys.extend(known.surveys);
        self.features.extend(known.features);
        self.lights.extend(known.lights);
        self.earlier.extend(file.map(|file| Earlier { file, pages: known.pages, is_as_left }));
    }

    fn log(&self) -> std::sync::MutexGuard<'_, Log> {
        self.log.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Key of what a file holds: read anew unless it is as it was when it was read last.
    pub fn content(&self, path: &Path) -> Result<Key> {
        let unreadable = |error| Error::io(path, "read it", error);
        let stamp = stamp(path).map_err(unreadable)?;
        let name = path.canonicalize().map_err(unreadable)?.display().to_string();
        let content = match self.files.get(&name) {
            Some((known, content)) if *known == stamp => *content,
            _ => key::content(path).map_err(unreadable)?,
        };
        if is_settled(path) {
            self.log().file(name, stamp, content);
        }
        Ok(content)
    }

    /// A survey that was made before.
    pub fn survey(&self, key: Key) -> Option<Survey> {
        self.surveys.get(&key).cloned()
    }

    /// Notes a survey, whoever made it.
    pub fn surveyed(&self, key: Key, survey: &Survey) {
        self.log().survey(key, survey);
    }

    /// Returns what a feature may change, as it was found before.
    pub fn extent(&self, key: Key) -> Option<Extent> {
        self.features.get(&key).copied()
    }

    /// Notes what a feature may change.
    pub fn bound(&self, key: Key, extent: &Extent) {
        self.log().feature(key, extent);
    }

    /// Returns the key of the light on a page, as it was found before.
    pub fn light(&self, key: Key) -> Option<Key> {
        self.lights.get(&key).copied()
    }

    /// Notes what came of the light on a page.
    pub fn lit(&self, key: Key, light: Key) {
        self.log().light(key, light);
    }

    /// Notes for which database this one is kept.
    pub fn kept_for(self, output: Option<&Path>) -> Self {
        if let Some(output) = output {
            self.log().kept_for(&name_of(output));
        }
        self
    }

    /// Whether builds before left pages.
    pub fn knows_pages(&self) -> bool {
        self.earlier.iter().any(|earlier| !earlier.pages.is_empty())
    }

    /// A page that was made of the same before.
    pub fn page(&self, grid: &Grid, id: PageId, key: Key, scratch: &mut Vec<u8>) -> Option<Reused> {
        let mut of = |earlier: &Earlier, id: PageId| {
            let made = earlier.pages.get(&id).filter(|made| made.key == key)?;
            let page = match earlier.is_as_left {
                true => earlier.file.page_as_left(grid, id, &made.entry),
                false => earlier.file.page(grid, id, &made.entry, scratch),
            };
            Some((page?, *made))
        };
        self.earlier.iter().find_map(|earlier| {
            let (page, made) = of(earlier, id)?;
            let bare = if made.has_bare { Some(of(earlier, id.bare())?.0) } else { None };
            Some(Reused { page, bare, counts: made.counts })
        })
    }

    /// Begins to write notes to the disk, beside the part that the build writes.
    fn begin(&self, part: &Path) -> Result<()> {
        let path = beside(part);
        self.log().begin(&path).map_err(|error| Error::io(path, "write what is known of the pages", error))
    }

    /// Notes pages that now lie in the part.
    pub fn made(&self, pages: &[MadeRecord]) -> Result<()> {
        let mut log = self.log();
        pages.iter().for_each(|made| log.page(made));
        log.write().map_err(|error| self.unwritable(error))
    }

    fn unwritable(&self, error: std::io::Error) -> Error {
        Error::io(beside(&self.output), "write what is known of the pages", error)
    }

    /// Notes what the output will be: from then on, should the build be killed, its log is known for that of the output.
    fn seal(&self, identity: ContentHash) -> Result<()> {
        let mut log = self.log();
        log.whole(identity);
        log.write().map_err(|error| self.unwritable(error))
    }

    /// The build is done: the output has all pages.
    fn finish(&self) {
        let mut log = self.log();
        // What is changed from now on has another time than what was written here.
        std::thread::sleep(TICK);
        if let Ok(stamp) = stamp(&self.output)
            && stamp.is_fine()
        {
            log.left(&stamp);
            // Without it the next build reads all pages.
            let _ = log.write();
        }
        // Without its log a database is as good; the next build then makes all of it.
        if let Some(path) = log.keep()
            && fs::rename(&path, beside(&self.output)).is_err()
        {
            let _ = fs::remove_file(path);
        }
        self.left.iter().for_each(|(part, _)| forget(part));
    }

    /// The build was interrupted after so many pages, and leaves its part behind.
    fn interrupted(&self, pages: u64) {
        self.log().keep();
        self.left.iter().filter(|(_, known)| *known as u64 <= pages).for_each(|(part, _)| forget(part));
    }
}

/// Begins a database: noted from now on, and a change of the one that is there, of so many bytes at most, if steps are kept.
pub(super) fn begin(cache: Option<&BuildCache>, mut writer: PageWriter, changes: u64) -> Result<PageWriter> {
    let Some(cache) = cache else { return Ok(writer) };
    if let Some(base) = &cache.base {
        writer = writer.patching(base, changes);
    }
    cache.begin(writer.part())?;
    Ok(writer)
}

/// Gives a finished database its name. Returns identity and bytes.
pub(super) fn publish(cache: Option<&BuildCache>, sealed: SealedFile) -> Result<(ContentHash, u64)> {
    let (content_hash, bytes) = (sealed.content_hash, sealed.bytes);
    cache.map_or(Ok(()), |cache| cache.seal(content_hash))?;
    sealed.publish()?;
    cache.into_iter().for_each(BuildCache::finish);
    Ok((content_hash, bytes))
}

/// Builds the error of a build that ends after so many pages; if it is an interruption and steps are kept, they wait for the next build.
pub(super) fn kept(cache: Option<&BuildCache>, writer: PageWriter, pages: u64, error: Error) -> Error {
    match (cache, error) {
        (Some(cache), Error::Interrupted(_)) if pages > 0 => {
            writer.keep();
            cache.interrupted(pages);
            let kept = "no database was written; the pages made so far are kept, and the same command goes on from there";
            Error::Interrupted(kept.into())
        }
        (_, error) => error,
    }
}

/// Removes a part and its log.
fn forget(part: &Path) {
    // What cannot be removed takes room, and no more.
    let _ = fs::remove_file(part);
    let _ = fs::remove_file(beside(part));
}

/// Parts of `output` that have a log, in an order of their own.
fn parts(output: &Path) -> Vec<PathBuf> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let prefix = output.file_name().map(|name| format!("{}.part-", name.to_string_lossy()));
    let Some((prefix, entries)) = prefix.zip(fs::read_dir(folder).ok()) else { return Vec::new() };
    let names: HashSet<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let logs = names.iter().filter_map(|name| name.strip_suffix(SUFFIX));
    let mut parts: Vec<PathBuf> =
        logs.filter(|name| name.starts_with(&prefix)).map(|name| folder.join(name)).collect();
    parts.sort();
    parts
}

fn nanoseconds(time: SystemTime) -> i128 {
    match time.duration_since(UNIX_EPOCH) {
        Ok(since) => since.as_nanos() as i128,
        Err(before) => -(before.duration().as_nanos() as i128),
    }
}

/// Returns the stamp that tells a file that was changed, without reading it.
fn stamp(path: &Path) -> std::io::Result<Stamp> {
    let metadata = fs::metadata(path)?;
    let modified = nanoseconds(metadata.modified()?);
    let times = std::iter::once(modified).chain(unforged(&metadata)).collect();
    Ok(Stamp { bytes: metadata.len(), times })
}

/// Returns what programs cannot set as they like, which they can the time of the last change.
#[cfg(unix)]
fn unforged(metadata: &fs::Metadata) -> Vec<i128> {
    use std::os::unix::fs::MetadataExt;
    let changed = i128::from(metadata.ctime()) * 1_000_000_000 + i128::from(metadata.ctime_nsec());
    vec![changed, i128::from(metadata.ino())]
}

#[cfg(not(unix))]
fn unforged(_: &fs::Metadata) -> Vec<i128> {
    Vec::new()
}

fn is_settled(path: &Path) -> bool {
    let modified = fs::metadata(path).and_then(|metadata| metadata.modified());
    modified.is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age > SETTLED))
}
