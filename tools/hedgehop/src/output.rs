//! Destinations of frames: numbered files with what made them beside, or one stream.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde_json::Value;

use crate::labels::Labelling;
use crate::reference;
use crate::sequence::{Flown, Image, Shot};
use crate::trust::DamagedPage;
use hedgehop::colour::srgb8_picture;
use hedgehop::encode::check::{Existing, existing};
use hedgehop::encode::sidecar::{
    DamagedRecord, DatabaseRecord, FlightRecord, FrameRecord, Manifest, PosesRecord, settings_digest,
};
use hedgehop::encode::y4m::{Chroma, Y4mWriter};
use hedgehop::encode::{FrameInfo, FramePattern, Written, write_frame_on, write_picture};
use hedgehop::flight::{FrameRate, Timeline};
use hedgehop::geo::{Crs, Transform};
use hedgehop::progress::Observer;
use hedgehop::render::NumberedCamera;
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::sunlight::Sky;
use hedgehop::voxel::{Header, PageId};
use hedgehop::{Error, Result, Size};

/// Name and version that outputs carry.
pub const WRITER: &str = concat!("hedgehop ", env!("CARGO_PKG_VERSION"));

/// Origin of frames: which these are, and what made them.
#[derive(Debug, Clone)]
pub struct Origin<'a> {
    /// The database's file.
    pub area: &'a Path,
    /// The database.
    pub header: &'a Header,
    /// The path's file; `None` for views without one.
    pub path: Option<&'a Path>,
    /// Whether frames are several, which numbers tell apart.
    pub is_sequence: bool,
    /// Frames per second of the numbering.
    pub timeline: Timeline,
    /// Files of poses besides `poses.csv`, if any are asked for.
    pub poses: Option<PosesRecord>,
    /// Everything else that decides the pictures.
    pub settings: Value,
}

/// Numbered files, and poses and `manifest.json` beside those of a path or a set of views.
#[derive(Debug)]
pub struct Files<'a> {
    origin: Origin<'a>,
    pattern: &'a FramePattern,
    /// Labels that they hold instead of pictures, if they do.
    labels: Option<Labelling>,
    digest: String,
    /// Transform of the database's reference system to degrees; `None` of a local one.
    degrees: Option<Transform>,
    written: Mutex<BTreeMap<u64, Written>>,
}

impl<'a> Files<'a> {
    /// Files named by `pattern`.
    pub fn new(origin: Origin<'a>, pattern: &'a FramePattern, labels: Option<Labelling>) -> Result<Self> {
        let digest = settings_digest(&origin.settings);
        let crs = reference::crs(origin.header)?;
        let degrees = if crs.is_local() { None } else { Some(Transform::new(&crs, &Crs::wgs84())?) };
        Ok(Self { origin, pattern, labels, digest, degrees, written: Mutex::default() })
    }

    /// The file of frame `number`.
    pub fn path(&self, number: u64) -> PathBuf {
        if self.origin.is_sequence { self.pattern.path(number) } else { self.pattern.single_path(number) }
    }

    /// The folder that they lie in; `None` for standard output.
    pub fn folder(&self) -> Option<&Path> {
        self.pattern.folder()
    }

    /// Whether a manifest lists them: a single picture has none.
    pub fn are_listed(&self) -> bool {
        self.origin.is_sequence
    }

    /// Returns the state of the file that a frame is to go to.
    pub fn state(&self, number: u64, camera: &Camera) -> Existing {
        existing(&self.path(number), camera, &self.info(number))
    }

    /// Whether the file of this frame can stay; says why not, if one is there.
    pub fn is_whole(&self, number: u64, camera: &Camera, observer: &dyn Observer) -> bool {
        let path = self.path(number);
        let again = |why: String| {
            observer.note(&format!("{}: rendered again, {why}", path.display()));
            false
        };
        match self.state(number, camera) {
            Existing::Whole => true,
            Existing::Missing => false,
            Existing::Broken(why) => again(format!("it is not whole: {why}")),
            Existing::Different(why) => again(format!("it shows something else: {why}")),
        }
    }

    /// Writes one frame; the workers of `farm` help.
    pub fn write(&self, shot: &Shot, farm: &Farm) -> Result<()> {
        let number = shot.delivery.number;
        let (path, info) = (self.path(number), self.info(number));
        let written = match (&shot.image, &self.labels) {
            (Image::Picture(picture, camera), _) => write_picture(&path, picture, camera, &info)?,
            (Image::Frame(frame), Some(labels)) => labels.table.write(&path, labels.kind, frame, &info)?,
            (Image::Frame(frame), None) => write_frame_on(farm, &path, frame, &info)?,
        };
        self.written.lock().unwrap_or_else(PoisonError::into_inner).insert(number, written);
        Ok(())
    }

    /// Writes what the numbers of labels mean beside them, if frames are labels.
    pub fn write_palette(&self) -> Result<()> {
        match (&self.labels, self.folder()) {
            (Some(labels), Some(folder)) => labels.table.write_palette(folder),
            _ => Ok(()),
        }
    }

    /// Writes what made the frames beside them; `existing` are those whose files are whole, `damaged` the pages that coarser levels
    /// stood in for.
    pub fn list(&self, existing: &[NumberedCamera], flown: &Flown, damaged: &[DamagedPage]) -> Result<()> {
        let Some(folder) = self.folder().filter(|_| self.are_listed() && !existing.is_empty()) else {
            return Ok(());
        };
        let mut manifest = self.manifest()?;
        manifest.frames = self.records(existing, flown)?;
        manifest.damaged_pages = damaged
            .iter()
            .map(|&DamagedPage { id: PageId { level, px, py }, byte }| DamagedRecord { level, px, py, byte })
            .collect();
        manifest.write(folder).map(drop)
    }

    /// A manifest without frames.
    pub fn manifest(&self) -> Result<Manifest> {
        let metadata = &self.origin.header.metadata;
        let database = DatabaseRecord {
            file: file_name(self.origin.area),
            content_hash: self.origin.header.content_hash.to_string(),
            crs: metadata.crs_name.clone(),
            vertical_datum: metadata.vertical_datum.clone(),
        };
        let flight = self.origin.path.map(|path| {
            let track = fs::read(path).map_err(|error| Error::io(path, "read it", error))?;
            Ok(FlightRecord { file: file_name(path), blake3: blake3::hash(&track).to_hex().to_string() })
        });
        let mut manifest = Manifest::new(WRITER, database, flight.transpose()?, self.origin.settings.clone());
        manifest.poses.clone_from(&self.origin.poses);
        Ok(manifest)
    }

    /// Returns the entries of frames whose files are whole, with what those cost that were rendered now.
    pub fn records(&self, existing: &[NumberedCamera], flown: &Flown) -> Result<Vec<FrameRecord>> {
        let complete = |frame: &NumberedCamera| {
            let mut record = self.record(frame)?;
            let place = flown.delivered.binary_search_by_key(&frame.number, |delivery| delivery.number);
            if let Ok(place) = place {
                let delivery = &flown.delivered[place];
                record.coarser_share = Some(delivery.rays.coarser_share());
                record.cost = Some(delivery.cost(flown.paging.get(place).map(|(_, paging)| *paging)));
            }
            Ok(record)
        };
        existing.iter().map(complete).collect()
    }

    /// Returns the entry of a frame whose file is whole.
    pub fn record(
        &self,
        &NumberedCamera { number, ref camera, sky }: &NumberedCamera,
    ) -> Result<FrameRecord> {
        let file = self.path(number);
        let known = self.written.lock().unwrap_or_else(PoisonError::into_inner).get(&number).cloned();
        let written = match known {
            Some(written) => written,
            None => Written::of(&file)?,
        };

        let eye = camera.pose.eye;
        let lonlat = self.degrees.as_ref().and_then(|degrees| degrees.apply(eye.x, eye.y));
        let lonlat = lonlat.map(|(longitude, latitude)| [longitude, latitude]);
        Ok(FrameRecord {
            sun_azimuth_elevation_deg: sky.map(|Sky { sun, .. }| [sun.azimuth, sun.elevation]),
            ..FrameRecord::new(&self.info(number), camera, lonlat, Some((&file, &written)))
        })
    }

    fn info(&self, number: u64) -> FrameInfo {
        let header = self.origin.header;
        FrameInfo {
            frame: number,
            seconds: self.origin.timeline.seconds_at(number),
            database_hash: header.content_hash.to_string(),
            database_file: file_name(self.origin.area),
            crs_name: header.metadata.crs_name.clone(),
            vertical_datum: header.metadata.vertical_datum.clone(),
            settings_digest: self.digest.clone(),
            writer: WRITER.to_owned(),
        }
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// All frames in one y4m stream.
#[derive(Debug)]
pub struct Stream<W: Write> {
    writer: Mutex<Y4mWriter<W>>,
    name: PathBuf,
}

impl<W: Write> Stream<W> {
    /// Writes the header of a stream that errors call `name`.
    pub fn new(target: W, name: &Path, size: Size, rate: FrameRate) -> Result<Self> {
        Y4mWriter::new(target, size, rate, Chroma::default())
            .map(|writer| Self { writer: Mutex::new(writer), name: name.to_owned() })
            .map_err(|error| refused(name, error))
    }

    /// Appends one frame.
    pub fn write(&self, shot: &Shot) -> Result<()> {
        let converted;
        let picture = match &shot.image {
            Image::Picture(picture, _) => &picture.rgb,
            Image::Frame(frame) => {
                converted = srgb8_picture(&frame.colour);
                &converted
            }
        };
        let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
        writer.write(picture).map_err(|error| refused(&self.name, error))
    }
}

/// Why a film in a file of its own was not finished: an interruption leaves none of its frames, and what was there before.
pub fn unfinished(file: &Path, error: Error) -> Error {
    match error {
        Error::Interrupted(_) => Error::Interrupted(format!(
            "{} was not written, since the film was not whole yet",
            file.display()
        )),
        other => other,
    }
}

/// The sentence for a stream that could not be written.
fn refused(name: &Path, error: io::Error) -> Error {
    let action = match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "write it; free some space and repeat the command, or write frames, of which --skip-existing keeps those that are finished"
        }
        _ => "write it",
    };
    Error::io(name, action, error)
}

/// Standard output without a buffer that keeps the end of a frame, and an error, to itself.
#[derive(Debug)]
pub struct Stdout;

impl Write for Stdout {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut stdout = io::stdout().lock();
        stdout.write_all(bytes)?;
        stdout.flush()?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stdout().flush()
    }
}
