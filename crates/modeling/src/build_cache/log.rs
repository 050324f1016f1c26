//! Log of a build's steps, record by record, so that what a kill leaves is good up to its last whole record.
//!
//! ```text
//! magic | records: kind (4 bytes), bytes of what follows (4), its CRC-32 (4), what follows
//! kinds:  file    what it held when it was looked at                         JSON
//!         survey  what was seen in one elevation file                        JSON
//!         feature what a feature may change                                  [`FeatureRecord`]
//!         page    where it lies, what it was made of, counts over its voxels [`PageRecord`]
//!         whole   identity of the database that has these pages              32 bytes
//!         left    what its file was when it was done                         JSON
//!         aside   name of the database that this one is kept for             bytes of the name
//!         light   what came of the light on a page                           two keys
//! ```
//! A note of this machine for itself, in its own byte order: nothing is lost with it but time.

use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::key::Key;
use crate::counts::PageCounts;
use crate::materials::Classes;
use crate::survey_result::Survey;
use hedgehop::voxel::{ContentHash, PageEntry, PageId, PagePart};

const MAGIC: [u8; 8] = *b"HOPSTEP1";
/// Kind, length and checksum of a record.
const HEAD: usize = 12;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
enum RecordKind {
    File = 1,
    Survey = 2,
    Feature = 3,
    Page = 4,
    Whole = 5,
    Left = 6,
    Aside = 7,
    Light = 8,
}

/// Stamp of a file when its bytes were hashed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Stamp {
    pub bytes: u64,
    /// Times at which its bytes, and it itself, were last changed, nanoseconds; as the system tells.
    pub times: Vec<i128>,
}

impl Stamp {
    /// Whether it holds two times that are finer than seconds: a later change then shows.
    pub fn is_fine(&self) -> bool {
        self.times.len() > 1 && self.times[..2].iter().all(|time| time % 1_000_000_000 != 0)
    }
}

/// A file's stamp with its content.
#[derive(Debug, Serialize, Deserialize)]
struct FileRecord {
    path: String,
    stamp: Stamp,
    content: String,
}

/// Record of the survey of an elevation file.
#[derive(Debug, Serialize, Deserialize)]
struct SurveyRecord {
    key: String,
    survey: Survey,
}

/// Extent of what a feature may change.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Extent {
    /// West, south, east, north of it, metres; not numbers where nothing of it is left.
    pub reach: [f64; 4],
    /// Distance beside a voxel within which it may ask for the ground, metres.
    pub margin: f64,
    /// Height that nothing of it rises above, metres.
    pub highest: f64,
}

/// An [`Extent`] with its key.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FeatureRecord {
    key: Key,
    extent: Extent,
}

/// A page that was written.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct PageRecord {
    offset: u64,
    counts: [u64; 6],
    classes: [u64; 4],
    level: u32,
    px: u32,
    py: u32,
    length: u32,
    spans: u32,
    crc: [u32; PagePart::COUNT],
    hash: [u8; 16],
    key: Key,
    /// Least and greatest code; zeros if there is none.
    codes: [u16; 2],
    /// Whether a page of bare ground goes with it.
    has_bare: u32,
}

/// A page that was made, and of what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MadeRecord {
    pub id: PageId,
    pub entry: PageEntry,
    pub key: Key,
    pub counts: PageCounts,
    /// Whether a page of bare ground goes with it.
    pub has_bare: bool,
}

impl From<&MadeRecord> for PageRecord {
    fn from(made: &MadeRecord) -> Self {
        let PageEntry { offset, length, spans, crc, hash } = made.entry;
        let PageCounts { voxels, made: own, voids, filled, empty, bare, codes, classes } = made.counts;
        let (low, high) = codes.unwrap_or_default();
        Self {
            offset,
            counts: [voxels, own, voids, filled, empty, bare],
            classes: classes.0,
            level: made.id.level.into(),
            px: made.id.px,
            py: made.id.py,
            length,
            spans,
            crc,
            hash,
            key: made.key,
            codes: [low, high],
            has_bare: made.has_bare.into(),
        }
    }
}

impl From<PageRecord> for MadeRecord {
    fn from(record: PageRecord) -> Self {
        let PageRecord { offset, length, spans, crc, hash, .. } = record;
        let [voxels, made, voids, filled, empty, bare] = record.counts;
        let codes = (record.codes != [0; 2]).then_some((record.codes[0], record.codes[1]));

        Self {
            id: PageId { level: record.level as u8, px: record.px, py: record.py },
            entry: PageEntry { offset, length, spans, crc, hash },
            key: record.key,
            counts: PageCounts {
                voxels,
                made,
                voids,
                filled,
                empty,
                bare,
                codes,
                classes: Classes(record.classes),
            },
            has_bare: record.has_bare != 0,
        }
    }
}

/// Contents of a log.
#[derive(Debug, Default)]
pub(super) struct KnownSteps {
    pub files: HashMap<String, (Stamp, Key)>,
    pub surveys: HashMap<Key, Survey>,
    pub features: HashMap<Key, Extent>,
    /// Keys of the shares of the sun that came of light.
    pub lights: HashMap<Key, Key>,
    pub pages: HashMap<PageId, MadeRecord>,
    /// Identity of the finished database.
    pub whole: Option<ContentHash>,
    /// Stamp of its file then.
    pub left: Option<Stamp>,
    /// Name of the database that it is kept for, as [`name_of`] has it.
    pub kept_for: Option<Vec<u8>>,
}

/// A database's name without its folder, as logs have it.
pub(super) fn name_of(database: &Path) -> Vec<u8> {
    database.file_name().unwrap_or_default().as_encoded_bytes().to_vec()
}

impl KnownSteps {
    /// All whole records of a log, up to the first that is not; nothing if there is no log.
    pub fn read(path: &Path) -> Self {
        let mut known = Self::default();
        let bytes = std::fs::read(path).unwrap_or_default();
        let mut rest = bytes.strip_prefix(&MAGIC).unwrap_or_default();
        while let Some((head, after)) = rest.split_at_checked(HEAD) {
            let number = |at: usize| head[at..at + 4].try_into().map(u32::from_ne_bytes).unwrap_or(0);
            let Some((payload, after)) = after.split_at_checked(number(4) as usize) else { break };
            if crc32fast::hash(payload) != number(8) {
                break;
            }
            // What another version wrote otherwise is passed over: the file is a build's own work still.
            let _ = known.take(number(0), payload);
            rest = after;
        }
        known
    }

    fn take(&mut self, kind: u32, payload: &[u8]) -> Option<()> {
        if kind == RecordKind::File as u32 {
            let FileRecord { path, stamp, content } = serde_json::from_slice(payload).ok()?;
            self.files.insert(path, (stamp, Key::from_hex(&content)?));
        } else if kind == RecordKind::Survey as u32 {
            let SurveyRecord { key, survey } = serde_json::from_slice(payload).ok()?;
            self.surveys.insert(Key::from_hex(&key)?, survey);
        } else if kind == RecordKind::Feature as u32 {
            let record: FeatureRecord = bytemuck::try_pod_read_unaligned(payload).ok()?;
            self.features.insert(record.key, record.extent);
        } else if kind == RecordKind::Page as u32 {
            let record: PageRecord = bytemuck::try_pod_read_unaligned(payload).ok()?;
            let made = MadeRecord::from(record);
            self.pages.insert(made.id, made);
        } else if kind == RecordKind::Whole as u32 {
            self.whole = Some(ContentHash(payload.try_into().ok()?));
        } else if kind == RecordKind::Left as u32 {
            self.left = Some(serde_json::from_slice(payload).ok()?);
        } else if kind == RecordKind::Aside as u32 {
            self.kept_for = Some(payload.to_vec());
        } else if kind == RecordKind::Light as u32 {
            let [key, light]: [Key; 2] = bytemuck::try_pod_read_unaligned(payload).ok()?;
            self.lights.insert(key, light);
        } else {
            return None;
        }

        Some(())
    }
}

/// A log that is being written: into memory until it has a file.
#[derive(Debug)]
pub(super) struct Log {
    bytes: Vec<u8>,
    file: Option<(File, PathBuf)>,
}

impl Default for Log {
    fn default() -> Self {
        Self { bytes: MAGIC.to_vec(), file: None }
    }
}

impl Log {
    /// One that goes on from the bytes of another.
    pub fn after(bytes: Vec<u8>) -> Self {
        Self { bytes, file: None }
    }

    /// Gives it a new file.
    pub fn begin(&mut self, path: &Path) -> io::Result<()> {
        let file = OpenOptions::new().write(true).create_new(true).open(path)?;
        self.file = Some((file, path.to_owned()));
        self.write()
    }

    /// Forgets everything, its file's records too.
    pub fn restart(&mut self) -> io::Result<()> {
        self.bytes = MAGIC.to_vec();
        if let Some((file, _)) = &mut self.file {
            file.set_len(0)?;
            file.rewind()?;
        }
        self.write()
    }

    /// Leaves its file where it is; the file of a log that is dropped before is removed.
    pub fn keep(&mut self) -> Option<PathBuf> {
        self.file.take().map(|(_, path)| path)
    }

    pub fn file(&mut self, path: String, stamp: Stamp, content: Key) {
        self.json(RecordKind::File, &FileRecord { path, stamp, content: content.hex() });
    }

    pub fn survey(&mut self, key: Key, survey: &Survey) {
        self.json(RecordKind::Survey, &SurveyRecord { key: key.hex(), survey: survey.clone() });
    }

    pub fn feature(&mut self, key: Key, extent: &Extent) {
        self.add(RecordKind::Feature, bytemuck::bytes_of(&FeatureRecord { key, extent: *extent }));
    }

    pub fn light(&mut self, key: Key, light: Key) {
        self.add(RecordKind::Light, bytemuck::bytes_of(&[key, light]));
    }

    pub fn page(&mut self, made: &MadeRecord) {
        self.add(RecordKind::Page, bytemuck::bytes_of(&PageRecord::from(made)));
    }

    pub fn whole(&mut self, identity: ContentHash) {
        self.add(RecordKind::Whole, &identity.0);
    }

    pub fn left(&mut self, stamp: &Stamp) {
        self.json(RecordKind::Left, stamp);
    }

    pub fn kept_for(&mut self, name: &[u8]) {
        self.add(RecordKind::Aside, name);
    }

    /// Writes what has come since.
    pub fn write(&mut self) -> io::Result<()> {
        if let Some((file, _)) = &mut self.file {
            file.write_all(&self.bytes)?;
            self.bytes.clear();
        }
        Ok(())
    }

    fn json(&mut self, kind: RecordKind, record: &impl Serialize) {
        // Records hold nothing that JSON cannot.
        if let Ok(bytes) = serde_json::to_vec(record) {
            self.add(kind, &bytes);
        }
    }

    fn add(&mut self, kind: RecordKind, payload: &[u8]) {
        for number in [kind as u32, payload.len() as u32, crc32fast::hash(payload)] {
            self.bytes.extend(number.to_ne_bytes());
        }
        self.bytes.extend(payload);
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        if let Some(path) = self.keep() {
            // What cannot be removed takes room, and no more.
            let _ = std::fs::remove_file(path);
        }
    }
}
