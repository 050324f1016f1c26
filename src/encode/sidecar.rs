//! `manifest.json` and `poses.csv` beside the frames: what made each.
//!
//! ```text
//! lock the folder (two workers of a farm may finish at once)
//! read the manifest that is there; if database, flight and settings are the same,
//!     keep its entries of frames that were not made now and still exist
//! write both files anew, each under a temporary name, and rename
//! ```
//!
//! `poses.csv` holds nothing that the manifest does not; it is there for spreadsheets and scripts.

use std::fs::File;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::encode::info::CAMERA_CONVENTIONS;
use crate::encode::{FrameInfo, Written, atomic};
use crate::memory::Paging;
use crate::space::{Camera, Screen};
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
    /// The flight; absent for a single picture.
    pub flight: Option<FlightRecord>,
    /// Everything else that decides the pictures.
    pub settings: serde_json::Value,
    /// [`settings_digest`] of `settings`.
    pub settings_digest: String,
    /// Meaning of the poses' fields.
    pub conventions: String,
    /// Pages of the database that are damaged, and that coarser levels stood in for; rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damaged_pages: Vec<DamagedRecord>,
    /// One entry per frame, in rising order.
    pub frames: Vec<FrameRecord>,
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
    /// Cost of paging from the delivery of the frame before to that of this one; absent if it was not rendered now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paging: Option<Paging>,
    /// Share of the rays that see ground which is stored more coarsely than they ask for, 0…1; absent if it was not rendered now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coarser_share: Option<f64>,
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
            paging: None,
            coarser_share: None,
        }
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
            damaged_pages: Vec::new(),
            frames: Vec::new(),
        }
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

    /// Refuses a folder whose `manifest.json` or `poses.csv` somebody else wrote: a run would replace them.
    pub fn check_folder(folder: &Path) -> Result<()> {
        let begins = |name: &str, ours: &dyn Fn(&str) -> bool| -> Result<()> {
            let path = folder.join(name);
            let bytes = match std::fs::read(&path) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
                Err(error) => return Err(Error::io(&path, "read it", error)),
            };
            if ours(&String::from_utf8_lossy(&bytes)) {
                return Ok(());
            }
            let what =
                "it is not of a render by this program, which would replace it; give another folder to -o";
            Err(Error::Configuration(format!("{}: {what}", path.display())))
        };
        begins(MANIFEST, &|text| serde_json::from_str::<Self>(text).is_ok())?;
        begins(POSES, &|text| text.lines().next() == Some(POSES_COLUMNS.join(",").as_str()))
    }

    /// Writes `manifest.json` and `poses.csv` into `folder`, keeping the entries of earlier runs of the
    /// same flight over the same database with the same settings. Returns what the manifest now holds.
    pub fn write(mut self, folder: &Path) -> Result<Self> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        std::fs::create_dir_all(folder).map_err(|source| Error::io(folder, "create the folder", source))?;
        let _lock = lock(folder);

        // A manifest that cannot be read says nothing about frames that could be kept.
        if let Ok(Some(earlier)) = Self::read(folder)
            && self.difference(&earlier).is_none()
        {
            let made: std::collections::HashSet<u64> = self.frames.iter().map(|frame| frame.frame).collect();
            let exists = |file: &Option<String>| file.as_ref().is_none_or(|file| folder.join(file).is_file());
            self.damaged_pages.extend(earlier.damaged_pages);
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
        let poses = folder.join(POSES);
        atomic::write_bytes(&poses, &poses_csv(&poses, &self.frames)?)?;
        atomic::write_bytes(&manifest, &text)?;

        Ok(self)
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
mod tests {
    use super::*;
    use crate::encode::{testing, write_frame};

    fn manifest(settings: &str) -> Manifest {
        let database = DatabaseRecord {
            file: "valley.hop".to_owned(),
            content_hash: "abc".to_owned(),
            crs: "EPSG:32633".to_owned(),
            vertical_datum: "mean sea level".to_owned(),
        };
        let flight = FlightRecord { file: "flight.csv".to_owned(), blake3: "def".to_owned() };
        Manifest::new(
            "hedgehop 0.1.0",
            database,
            Some(flight),
            serde_json::json!({ "hfov": 60.0, "sky": settings }),
        )
    }

    /// Renders frames and writes their manifest, as a run does.
    fn run(folder: &Path, settings: &str, numbers: &[u64]) -> Manifest {
        let mut manifest = manifest(settings);
        let frame = testing::frame(4, 3);
        for &number in numbers {
            let info = FrameInfo { frame: number, ..testing::info() };
            let path = folder.join(format!("{number:04}.png"));
            let written = write_frame(&path, &frame, &info).unwrap();
            let lon_lat = (number % 2 == 0).then_some([15.1, 42.0]);
            manifest.frames.push(FrameRecord::new(&info, &frame.camera, lon_lat, Some((&path, &written))));
        }
        manifest.write(folder).unwrap()
    }

    fn numbers(folder: &Path) -> Vec<u64> {
        let manifest = Manifest::read(folder).unwrap().unwrap();
        manifest.frames.iter().map(|frame| frame.frame).collect()
    }

    #[test]
    fn the_manifest_says_what_made_each_frame() {
        let (folder, _) = testing::place("");
        let written = run(folder.path(), "clear", &[2, 1]);
        let read = Manifest::read(folder.path()).unwrap().unwrap();
        assert_eq!(read, written, "every f64 comes back");
        assert_eq!(read.frames[1].file.as_deref(), Some("0002.png"));
        let file = Written::of(&folder.path().join("0002.png")).unwrap();
        assert_eq!(read.frames[1].blake3.as_ref(), Some(&file.blake3));
        assert_eq!(read.frames[0].eye_m, [500_123.456_789, 4_649_776.225, 312.75]);
    }

    #[test]
    fn poses_are_a_table() {
        let (folder, _) = testing::place("");
        run(folder.path(), "clear", &[1, 2]);
        assert_eq!(
            std::fs::read_to_string(folder.path().join(POSES)).unwrap(),
            "frame,t_s,x_m,y_m,z_m,lon_deg,lat_deg,yaw_deg,pitch_deg,roll_deg,hfov_deg\n\
             1,1.64,500123.456789,4649776.225,312.75,,,33,-5.25,20,60\n\
             2,1.64,500123.456789,4649776.225,312.75,15.1,42,33,-5.25,20,60\n"
        );
    }

    #[test]
    fn subsets_of_one_sequence_add_up() {
        let (folder, _) = testing::place("");
        run(folder.path(), "clear", &[5, 6]);
        run(folder.path(), "clear", &[1, 6]);
        assert_eq!(numbers(folder.path()), [1, 5, 6]);
        std::fs::remove_file(folder.path().join("0005.png")).unwrap();
        run(folder.path(), "clear", &[2]);
        assert_eq!(numbers(folder.path()), [1, 2, 6], "the file of 5 is gone");
    }

    #[test]
    fn another_sequence_replaces_what_was_there() {
        let (folder, _) = testing::place("");
        run(folder.path(), "clear", &[5, 6]);
        run(folder.path(), "haze", &[1]);
        assert_eq!(numbers(folder.path()), [1]);
        let said = manifest("clear").difference(&manifest("haze")).unwrap();
        assert_eq!(said, r#"sky is "haze", not "clear""#);
        assert_eq!(manifest("clear").difference(&manifest("clear")), None);
        let bare = serde_json::json!({});

        for (one, said) in [
            (serde_json::json!({"scene": {"blake3": "a"}}), "it has a scene, and this has none"),
            (serde_json::json!({"radius_m": 2.5}), "radius_m is 2.5, and not set here"),
        ] {
            assert_eq!(changed_settings(&one, &bare), said);
        }

        assert_eq!(changed_settings(&bare, &serde_json::json!({"scene": {}})), "it has no scene");
        std::fs::write(folder.path().join(MANIFEST), b"{").unwrap();
        let message = Manifest::read(folder.path()).unwrap_err().to_string();
        assert!(message.contains(MANIFEST) && message.contains("line 1"), "{message}");
        run(folder.path(), "haze", &[3]);
        assert_eq!(numbers(folder.path()), [3]);
    }

    #[test]
    fn a_folder_with_files_of_somebody_else_is_refused() {
        let (folder, _) = testing::place("");
        run(folder.path(), "clear", &[5]);
        Manifest::check_folder(folder.path()).unwrap();
        for (name, text) in [(POSES, "t,lon,lat\n0,1,2\n"), (MANIFEST, "{\"name\": \"my app\"}")] {
            let other = tempfile::tempdir().unwrap();
            std::fs::write(other.path().join(name), text).unwrap();
            let message = Manifest::check_folder(other.path()).unwrap_err().to_string();
            assert!(message.contains(name) && message.contains("-o"), "{message}");
        }
    }

    #[test]
    fn workers_that_finish_at_once_lose_nothing() {
        let (folder, _) = testing::place("");
        std::thread::scope(|scope| {
            for worker in 0..4 {
                let folder = folder.path();
                scope.spawn(move || {
                    for round in 0..5 {
                        run(folder, "clear", &[worker * 5 + round + 1]);
                    }
                });
            }
        });
        assert_eq!(numbers(folder.path()), (1..=20).collect::<Vec<_>>());
    }

    #[test]
    fn the_digest_ignores_the_order_of_keys() {
        let one: serde_json::Value = serde_json::from_str(r#"{"a":1,"b":2}"#).unwrap();
        let other: serde_json::Value = serde_json::from_str(r#"{"b":2,"a":1}"#).unwrap();
        assert_eq!(settings_digest(&one), settings_digest(&other));
        assert_ne!(settings_digest(&one), settings_digest(&serde_json::json!({"a":1})));
    }
}
