//! `manifest.json` and `poses.csv` beside the frames: what made each.
//!
//! ```text
//! lock the folder (two workers of a farm may finish at once)
//! read the manifest that is there; if database, flight and settings are the same,
//!     keep its entries of frames that were not made now and still exist
//! write both files anew, each under a temporary name, and rename
//! ```
//!
//! `poses.csv` holds nothing that the manifest does not; it is there for spreadsheets and scripts. Nor do the files of
//! [`poses`](super::poses), which are there for programs of computer vision, if they are asked for, or were before.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::encode::info::CAMERA_CONVENTIONS;
use crate::encode::ours::check_ours;
use crate::encode::poses::{PoseFormat, PoseList, PosedFrame};
use crate::encode::{FrameInfo, Written, atomic};
use crate::memory::Paging;
use crate::space::{Attitude, Camera, Screen};
use hedgehop_base::Size;
use hedgehop_base::error::{Error, Result};

/// Name of the manifest in the folder of the frames.
pub const MANIFEST: &str = "manifest.json";
/// Name of the table of poses in the folder of the frames.
pub const POSES: &str = "poses.csv";
const POSES_COLUMNS: [&str; 11] = [
    "frame",
    "t_s",
    "x_m",
    "y_m",
    "z_m",
    "lon_deg",
    "lat_deg",
    "yaw_deg",
    "pitch_deg",
    "roll_deg",
    "hfov_deg",
];
const LOCK: &str = ".manifest.lock";
/// Settings that a sentence names at most.
const MOST_CLAUSES: usize = 3;
/// Version of the manifest's layout.
const LAYOUT: u32 = 1;

/// Record of what made a folder of frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    layout: u32,
    /// Program and version.
    pub program: String,
    /// The database.
    pub database: DatabaseRecord,
    /// The flight; absent for views without one.
    pub flight: Option<FlightRecord>,
    /// Everything else that decides the pictures.
    pub settings: serde_json::Value,
    /// [`settings_digest`] of `settings`.
    pub settings_digest: String,
    /// Meaning of the poses' fields.
    pub conventions: String,
    /// Further files of poses; absent without any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<PosesRecord>,
    /// Pages of the database that are damaged, and that coarser levels stood in for; rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damaged_pages: Vec<DamagedRecord>,
    /// One entry per frame, in rising order.
    pub frames: Vec<FrameRecord>,
}

/// Files of poses beside `poses.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PosesRecord {
    /// Formats of the files.
    pub formats: BTreeSet<PoseFormat>,
    /// Point that their positions count from, metres in the database's reference system.
    pub offset_m: [f64; 3],
}

/// A damaged page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DamagedRecord {
    /// Level index.
    pub level: u8,
    /// Page column.
    pub px: u32,
    /// Page row.
    pub py: u32,
    /// First byte of the page in the database.
    pub byte: u64,
}

/// Identity of a database.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DatabaseRecord {
    /// File name.
    pub file: String,
    /// Content hash.
    pub content_hash: String,
    /// Coordinate reference system.
    pub crs: String,
    /// Datum that heights count from.
    pub vertical_datum: String,
}

/// Identity of a flight.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FlightRecord {
    /// File name of the path.
    pub file: String,
    /// BLAKE3 of that file, hexadecimal.
    pub blake3: String,
}

/// One frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Number, absolute, from 1.
    pub frame: u64,
    /// File name, relative to the manifest; absent for frames of a stream.
    pub file: Option<String>,
    /// BLAKE3 of the file, hexadecimal; absent for frames of a stream.
    pub blake3: Option<String>,
    /// Time since the start of the flight, seconds.
    pub seconds: f64,
    /// Eye in the database's reference system, metres: east, north, up.
    pub eye_m: [f64; 3],
    /// Longitude and latitude of the eye, degrees; absent in a local system.
    pub lon_lat_deg: Option<[f64; 2]>,
    /// Clockwise from grid north, degrees.
    pub yaw_deg: f64,
    /// Nose up positive, degrees.
    pub pitch_deg: f64,
    /// Right wing down positive, degrees.
    pub roll_deg: f64,
    /// Projection and its parameters: [`Screen`] as text.
    #[serde(default)]
    pub screen: String,
    /// Horizontal field of view of a planar screen, degrees; absent on others.
    pub hfov_deg: Option<f64>,
    /// Pixels: width, height.
    pub size_px: [u32; 2],
    /// Sun of the frame, clockwise from grid north and above the horizon, degrees; absent if it stands still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun_azimuth_elevation_deg: Option<[f64; 2]>,
    /// Share of the rays that see ground which is stored more coarsely than they ask for, 0…1; absent if nobody knows who rendered it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coarser_share: Option<f64>,
    /// Cost on the machine that rendered it; absent if nobody knows who did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<FrameCost>,
}

/// Cost of a frame in the process that rendered it: the one part of a manifest that differs from run to run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FrameCost {
    /// Time from the delivery of the frame before, or from the first frame's begin, to that of this one, seconds.
    pub wall_s: f64,
    /// Processor time of all threads of the process in the same time, seconds; absent where the system does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_s: Option<f64>,
    /// Cost of paging in the same time; absent if its process ended before it told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paging: Option<Paging>,
}

impl FrameRecord {
    /// The entry of a frame; `file` is where it went and what was written, `None` for a stream.
    pub fn new(
        info: &FrameInfo,
        camera: &Camera,
        lon_lat_deg: Option<[f64; 2]>,
        file: Option<(&Path, &Written)>,
    ) -> Self {
        let pose = &camera.pose;
        let hfov_deg = match *camera.screen() {
            Screen::Planar { hfov } => Some(hfov),
            _ => None,
        };
        let name =
            file.and_then(|(path, _)| path.file_name()).map(|name| name.to_string_lossy().into_owned());

        Self {
            frame: info.frame,
            file: name,
            blake3: file.map(|(_, written)| written.blake3.clone()),
            seconds: info.seconds,
            eye_m: pose.eye.to_array(),
            lon_lat_deg,
            yaw_deg: pose.attitude.yaw,
            pitch_deg: pose.attitude.pitch,
            roll_deg: pose.attitude.roll,
            screen: camera.screen().to_string(),
            hfov_deg,
            size_px: [camera.width, camera.height],
            sun_azimuth_elevation_deg: None,
            coarser_share: None,
            cost: None,
        }
    }

    /// Takes over what an earlier record of the same file knows and this one does not: its fineness and cost.
    fn complete_by(&mut self, earlier: &Self) {
        if self.blake3.is_some() && self.blake3 == earlier.blake3 {
            self.coarser_share = self.coarser_share.or(earlier.coarser_share);
            self.cost = self.cost.or(earlier.cost);
        }
    }

    /// The frame as files of poses tell it; `None` for one of a stream.
    fn posed(&self) -> Option<PosedFrame<'_>> {
        let [width, height] = self.size_px;
        Some(PosedFrame {
            number: self.frame,
            file: self.file.as_deref()?,
            seconds: self.seconds,
            eye: DVec3::from_array(self.eye_m),
            attitude: Attitude { yaw: self.yaw_deg, pitch: self.pitch_deg, roll: self.roll_deg },
            screen: &self.screen,
            size: Size { width, height },
        })
    }
}

impl Manifest {
    /// A manifest without frames.
    pub fn new(
        program: impl Into<String>,
        database: DatabaseRecord,
        flight: Option<FlightRecord>,
        settings: serde_json::Value,
    ) -> Self {
        let settings_digest = settings_digest(&settings);
        let conventions = CAMERA_CONVENTIONS.to_owned();
        let program = program.into();
        Self {
            layout: LAYOUT,
            program,
            database,
            flight,
            settings,
            settings_digest,
            conventions,
            poses: None,
            damaged_pages: Vec::new(),
            frames: Vec::new(),
        }
    }

    /// Returns what the frames are made of, without any of them.
    #[must_use]
    pub fn without_frames(self) -> Self {
        Self { damaged_pages: Vec::new(), frames: Vec::new(), ..self }
    }

    /// Reads the manifest of `folder`; `None` where there is none.
    pub fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(MANIFEST);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Error::io(&path, "read it", error)),
        };
        serde_json::from_slice(&bytes).map(Some).map_err(|error| {
            Error::invalid(&path, format!("no manifest of frames: {error}; delete it and render again"))
        })
    }

    /// Refuses a folder whose `manifest.json`, `poses.csv` or further files of poses somebody else wrote: a run would replace them.
    pub fn check_folder(folder: &Path) -> Result<()> {
        check_ours(&folder.join(MANIFEST), &|text| serde_json::from_str::<Self>(text).is_ok())?;
        let is_table = |text: &str| text.lines().next() == Some(POSES_COLUMNS.join(",").as_str());
        check_ours(&folder.join(POSES), &is_table)?;
        // A run goes on with the formats of the run before.
        let earlier = Self::read(folder)?.and_then(|manifest| manifest.poses);
        let formats = earlier.map(|earlier| earlier.formats).unwrap_or_default();
        formats.iter().try_for_each(|format| format.check_folder(folder))
    }

    /// Writes `manifest.json`, `poses.csv` and further files of poses into `folder`, keeping the entries of earlier runs
    /// of the same flight over the same database with the same settings. Returns what the manifest now holds.
    pub fn write(mut self, folder: &Path) -> Result<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        std::fs::create_dir_all(folder).map_err(|source| Error::io(folder, "create the folder", source))?;
        let _lock = lock(folder);

        // A manifest that cannot be read says nothing about frames that could be kept.
        let mut outdated = BTreeSet::new();
        let earlier = Self::read(folder).ok().flatten();
        let is_continued = earlier.as_ref().is_some_and(|earlier| self.difference(earlier).is_none());
        if let Some(earlier) = earlier.as_ref().and_then(|earlier| earlier.poses.as_ref()) {
            outdated.clone_from(&earlier.formats);
            if is_continued {
                self.poses.get_or_insert_with(|| earlier.clone()).formats.extend(&earlier.formats);
            }
        }
        if let Some(earlier) = earlier.filter(|_| is_continued) {
            let made: BTreeSet<u64> = self.frames.iter().map(|frame| frame.frame).collect();
            let exists = |file: &Option<String>| file.as_ref().is_none_or(|file| folder.join(file).is_file());
            self.damaged_pages.extend(earlier.damaged_pages);
            let known: BTreeMap<u64, &FrameRecord> =
                earlier.frames.iter().map(|frame| (frame.frame, frame)).collect();
            for frame in &mut self.frames {
                if let Some(earlier) = known.get(&frame.frame) {
                    frame.complete_by(earlier);
                }
            }
            let kept = earlier.frames.into_iter();
            self.frames.extend(kept.filter(|frame| !made.contains(&frame.frame) && exists(&frame.file)));
        }

        self.frames.sort_by_key(|frame| frame.frame);
        self.damaged_pages.sort_unstable();
        self.damaged_pages.dedup();
        let manifest = folder.join(MANIFEST);
        let mut text = serde_json::to_vec_pretty(&self)
            .map_err(|error| Error::invalid(&manifest, format!("the manifest is no JSON: {error}")))?;
        text.push(b'\n');
        self.write_poses(folder, outdated)?;
        let poses = folder.join(POSES);
        atomic::write_bytes(&poses, &poses_csv(&poses, &self.frames)?)?;
        atomic::write_bytes(&manifest, &text)?;

        Ok(self)
    }

    /// Writes files of poses in the formats that are asked for, and removes those in `outdated` ones.
    fn write_poses(&self, folder: &Path, mut outdated: BTreeSet<PoseFormat>) -> Result<()> {
        if let Some(PosesRecord { formats, offset_m }) = &self.poses {
            outdated.retain(|format| !formats.contains(format));
            let list = PoseList {
                frames: self.frames.iter().filter_map(FrameRecord::posed).collect(),
                offset: DVec3::from_array(*offset_m),
                crs: &self.database.crs,
                vertical_datum: &self.database.vertical_datum,
            };
            formats.iter().try_for_each(|format| format.write(folder, &list))?;
        }
        outdated.into_iter().try_for_each(|format| format.remove(folder))
    }

    /// Clause that says what of database, flight and settings is another in `other`, which is the one that is there; `None`: frames of both are of one
    /// sequence.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let content = |manifest: &Self| manifest.flight.as_ref().map(|flight| flight.blake3.clone());
        if self.layout != other.layout {
            return Some("its manifest has another layout".to_owned());
        }
        if self.database.content_hash != other.database.content_hash {
            return Some(another("database", &other.database.file, &self.database.file));
        }
        if content(self) != content(other) {
            let name =
                |manifest: &Self| manifest.flight.as_ref().map_or("none", |flight| &flight.file).to_owned();
            return Some(another("flight", &name(other), &name(self)));
        }
        if self.settings_digest == other.settings_digest {
            return None;
        }
        Some(changed_settings(&other.settings, &self.settings))
    }
}

/// Says that files of this kind differ, which may have the same name.
fn another(kind: &str, there: &str, here: &str) -> String {
    if there == here {
        format!("the {kind} {here} has another content now")
    } else {
        format!("its {kind} is {there}, not {here}")
    }
}

/// Says which settings differ.
fn changed_settings(there: &serde_json::Value, here: &serde_json::Value) -> String {
    let keys =
        [there, here].into_iter().filter_map(serde_json::Value::as_object).flat_map(|object| object.keys());
    let keys: std::collections::BTreeSet<&String> =
        keys.filter(|key| there.get(*key) != here.get(*key)).collect();

    let clause = |key: &&String| {
        let value =
            |settings: &serde_json::Value| settings.get(*key).filter(|value| !value.is_null()).cloned();
        match (value(there), value(here)) {
            (Some(there), Some(here)) if there.is_object() || here.is_object() => {
                format!("{key} is another one")
            }
            (Some(there), Some(here)) => format!("{key} is {there}, not {here}"),
            (Some(there), None) if there.is_object() => format!("it has a {key}, and this has none"),
            (Some(there), None) => format!("{key} is {there}, and not set here"),
            (None, Some(here)) if here.is_object() => format!("it has no {key}"),
            (None, here) => format!("{key} is not set, but {} here", here.unwrap_or_default()),
        }
    };

    let mut clauses: Vec<String> = keys.iter().take(MOST_CLAUSES).map(clause).collect();
    if keys.len() > MOST_CLAUSES {
        clauses.push(format!("and {} more settings differ", keys.len() - MOST_CLAUSES));
    }

    clauses.join(", ")
}

/// BLAKE3 of settings as JSON with sorted keys, hexadecimal.
pub fn settings_digest(settings: &serde_json::Value) -> String {
    blake3::hash(settings.to_string().as_bytes()).to_hex().to_string()
}

/// Holds the lock of `folder` until it is dropped. Where locks are not to be had (some network file
/// systems), work goes on without: the worst is an entry that is missing from the manifest.
fn lock(folder: &Path) -> Option<File> {
    let file = File::options().create(true).truncate(false).write(true).open(folder.join(LOCK)).ok()?;
    file.lock().ok()?;
    Some(file)
}

fn poses_csv(path: &Path, frames: &[FrameRecord]) -> Result<Vec<u8>> {
    let rows = || -> Result<Vec<u8>, Box<dyn std::error::Error>> {
        let mut table = csv::Writer::from_writer(Vec::new());
        table.write_record(POSES_COLUMNS)?;
        for frame in frames {
            let [x, y, z] = frame.eye_m;
            let [lon, lat] =
                frame.lon_lat_deg.map_or_else(Default::default, |at| at.map(|at| at.to_string()));
            let attitude = [frame.yaw_deg, frame.pitch_deg, frame.roll_deg].map(|angle| angle.to_string());
            let hfov = frame.hfov_deg.map_or_else(String::new, |hfov| hfov.to_string());
            let before = [frame.frame.to_string(), frame.seconds.to_string()];
            let position = [x, y, z].map(|value| value.to_string()).into_iter().chain([lon, lat]);
            table.write_record(before.into_iter().chain(position).chain(attitude).chain([hfov]))?;
        }
        Ok(table.into_inner()?)
    };
    rows().map_err(|error| Error::invalid(path, format!("the poses cannot be written as CSV: {error}")))
}

#[cfg(test)]
#[path = "sidecar_tests.rs"]
mod tests;
