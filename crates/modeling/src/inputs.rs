//! The rasters of a build: opened, with everything known that is needed to place them (in `placed`).
//!
//! ```text
//! for each file: open it; its reference system is
//!     its own | --elevation-crs or --imagery-crs | plain metres (--local, or no georeferencing at all) | an error
//! refuse coordinates that cannot be what the system says: degrees as metres, metres as degrees, swapped axes
//! ```

use crate::naming::{contradiction, crs_label, file_name};
use crate::opened::Opened;
use std::path::{Path, PathBuf};

use super::bare::{self, Canvas, RasterRole, Said, canvas};
use super::cloud::{self, Cloud};
use super::features::{self, Layer, LayerOptions};
use super::footprint::{Bounds, corner_bounds};
use super::kernel::Samples;
use super::land_cover::{ClassRaster, LandCoverFile, SampleClass};
use super::object::{self, OpenObject, OpenScatter};
use super::options::{BuildOptions, CloudFile, ElevationFile, FeatureFile, ImageryFile};
use super::plausible::{local_in_metres, no_crs, plausible};
use super::raster::{ElevationRaster, ImageryRaster, open};
use super::source_heights::Stated;
use super::warp;
use crate::raster::{GeoTransform, OpenOptions, Raster, RasterInfo, Window};
use hedgehop::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;
use hedgehop_geo::{Crs, VerticalCrs, VerticalDatum};

/// Bytes of decoded blocks for a file that is only looked at.
pub(super) const CACHE_TO_LOOK: u64 = 64 << 20;

/// Features of a file, and how they are to be taken.
pub(super) struct FeatureInput {
    /// Features as the file has them.
    pub layer: Layer,
    /// Meaning of the features, with the materials of the place.
    pub options: LayerOptions,
}

/// All rasters, highest priority first, and what was assumed about them.
#[derive(Default)]
pub(super) struct Inputs {
    /// Point clouds; as many of the first of `elevation` are their places.
    pub clouds: Vec<Cloud>,
    pub elevation: Vec<Opened<f64>>,
    pub imagery: Vec<Opened<[u8; 4]>>,
    pub land_cover: Vec<Opened<SampleClass>>,
    pub features: Vec<FeatureInput>,
    pub objects: Vec<OpenObject>,
    pub scatters: Vec<OpenScatter>,
    pub notes: Vec<String>,
}

impl Inputs {
    /// Whether something may stand on the ground.
    pub fn has_spans(&self) -> bool {
        let Self { clouds, features, objects, scatters, .. } = self;
        !(clouds.is_empty() && features.is_empty() && objects.is_empty() && scatters.is_empty())
    }
}

impl Samples<f64> for ElevationRaster {
    fn size(&self) -> Size {
        self.info().size()
    }
    fn read(&self, window: Window, samples: &mut Vec<f64>) -> Result<()> {
        ElevationRaster::read(self, window, samples)
    }
    fn notes(&self) -> Vec<String> {
        without_folders(&self.info().path, &ElevationRaster::notes(self))
    }
}

impl Samples<[u8; 4]> for ImageryRaster {
    fn size(&self) -> Size {
        self.info().size()
    }
    fn read(&self, window: Window, samples: &mut Vec<[u8; 4]>) -> Result<()> {
        ImageryRaster::read(self, window, samples)
    }
    fn notes(&self) -> Vec<String> {
        without_folders(&self.info().path, ImageryRaster::notes(self))
    }
}

/// Opens every file, with `cache_bytes` of decoded blocks for all of them together.
pub(super) fn open_all(options: &BuildOptions, cache_bytes: u64, observer: &dyn Observer) -> Result<Inputs> {
    if options.elevation.is_empty() && options.clouds.is_empty() && !options.synthetic.has_base() {
        return Err(Error::Configuration(
            "no elevation is given; name at least one file with --elevation or --cloud".into(),
        ));
    }
    open_rasters(options, cache_bytes, observer).and_then(|inputs| {
        let features =
            options.features.iter().map(|file| layer(file, options)).collect::<Result<Vec<_>>>()?;
        let objects = options.objects.iter().map(object::open_object).collect::<Result<Vec<_>>>()?;
        let scatters = options.scatters.iter().map(object::open_scatter).collect::<Result<Vec<_>>>()?;
        let told = objects.iter().flat_map(|object| &object.notes);
        let told = told.chain(scatters.iter().flat_map(|scatter| &scatter.notes)).cloned();
        let notes = inputs.notes.into_iter().chain(told).collect();
        Ok(Inputs { features, objects, scatters, notes, ..inputs })
    })
}

/// Opens every raster, of which there may be none, with `cache_bytes` of decoded blocks for all of them together.
pub(super) fn open_rasters(
    options: &BuildOptions,
    cache_bytes: u64,
    observer: &dyn Observer,
) -> Result<Inputs> {
    let count =
        options.elevation.len() + options.imagery.len() + options.clouds.len() + options.land_cover.len();
    if count >= usize::from(u16::MAX) {
        return Err(Error::Configuration(format!(
            "{count} files are too many; mosaic them first (gdalbuildvrt)"
        )));
    }

    let open_options =
        OpenOptions { cache_bytes: cache_bytes / count.max(1) as u64, ..OpenOptions::default() };
    let mut opener = Opener::new(options, open_options, observer);
    let clouds = options.clouds.iter().map(|file| opener.cloud(file)).collect::<Result<Vec<_>>>()?;
    let (clouds, mut elevation): (Vec<Cloud>, Vec<Opened<f64>>) = clouds.into_iter().unzip();
    for file in &options.elevation {
        elevation.push(opener.elevation(file)?);
    }

    let canvas = canvas(&elevation);
    let imagery = options
        .imagery
        .iter()
        .map(|file| opener.imagery(file, canvas.as_ref()))
        .collect::<Result<Vec<_>>>()?;
    let land_cover = options
        .land_cover
        .iter()
        .map(|file| opener.land_cover(file, canvas.as_ref()))
        .collect::<Result<Vec<_>>>()?;

    Ok(Inputs { clouds, elevation, imagery, land_cover, notes: opener.into_notes(), ..Inputs::default() })
}

/// Reads a file of features.
pub(super) fn layer(file: &FeatureFile, options: &BuildOptions) -> Result<FeatureInput> {
    let materials = options.materials.clone();
    Ok(FeatureInput {
        layer: features::read(&file.path, &file.options)?,
        options: LayerOptions { materials, ..file.options.clone() },
    })
}

/// Describes what a raster says of itself and what the user says of it, but for where it lies.
fn facts(info: &RasterInfo, file: &dyn std::fmt::Debug) -> String {
    format!("{:?} {file:?}", RasterInfo { path: PathBuf::new(), ..info.clone() })
}

pub(super) struct Opener<'a> {
    options: &'a BuildOptions,
    open_options: OpenOptions,
    observer: &'a dyn Observer,
    notes: Vec<String>,
    /// Elevation files whose vertical datum was assumed.
    silent: Vec<String>,
}

impl<'a> Opener<'a> {
    pub(super) fn new(
        options: &'a BuildOptions,
        open_options: OpenOptions,
        observer: &'a dyn Observer,
    ) -> Self {
        Self { options, open_options, observer, notes: Vec::new(), silent: Vec::new() }
    }

    /// Opens a raster; what its file is told for goes to the notes.
    fn open(&mut self, path: &Path, classes: bool) -> Result<(Box<dyn Raster>, RasterInfo)> {
        let raster = open(path, &OpenOptions { classes, ..self.open_options.clone() })?;
        let info = raster.info().clone();
        self.notes.extend(info.notes.iter().cloned());
        Ok((raster, info))
    }

    pub(super) fn cloud(&mut self, file: &CloudFile) -> Result<(Cloud, Opened<f64>)> {
        let (cloud, opened, notes) = cloud::open(file, self.options, self.observer)?;
        self.notes.extend(notes);
        Ok((cloud, opened))
    }

    pub(super) fn elevation(&mut self, file: &ElevationFile) -> Result<Opened<f64>> {
        let path = &file.path;
        let (raster, info) = self.open(path, false)?;
        let said = self.said(RasterRole::Elevation, file.crs.as_deref(), None);
        let (geo, crs, given) = self.place(&info, said, None)?;
        let name = file_name(path);
        let stated = Stated { name: &name, file: &info.vertical, given, flag: file.datum, crs: &crs };
        let heights = stated.settle(&mut self.notes);
        if heights.is_silent {
            self.silent.push(name);
        }
        let description = format!("{}, {}", describe(&info, &crs), heights.words());
        let facts = facts(&info, &ElevationFile { path: PathBuf::new(), ..file.clone() });
        let samples = Box::new(ElevationRaster::new(raster, &file.nodata, heights.metres_per_unit)?);
        let datum = heights.datum;
        Ok(Opened { path: path.to_owned(), samples, block: info.block, geo, crs, datum, description, facts })
    }

    pub(super) fn imagery(&mut self, file: &ImageryFile, canvas: Option<&Canvas>) -> Result<Opened<[u8; 4]>> {
        let path = &file.path;
        let (raster, info) = self.open(path, false)?;
        let (geo, crs, _) =
            self.place(&info, self.said(RasterRole::Imagery, file.crs.as_deref(), file.extent), canvas)?;
        let description = describe(&info, &crs);
        let facts = facts(&info, &ImageryFile { path: PathBuf::new(), ..file.clone() });
        let samples = Box::new(ImageryRaster::new(raster, file.bands)?);
        self.notes.extend(Samples::notes(samples.as_ref()));
        let datum = VerticalDatum::Msl;
        Ok(Opened { path: path.to_owned(), samples, block: info.block, geo, crs, datum, description, facts })
    }

    pub(super) fn land_cover(
        &mut self,
        file: &LandCoverFile,
        canvas: Option<&Canvas>,
    ) -> Result<Opened<SampleClass>> {
        let path = &file.path;
        let (raster, info) = self.open(path, true)?;
        let said = self.said(RasterRole::LandCover, file.crs.as_deref(), None);
        let (geo, crs, _) = self.place(&info, said, canvas)?;
        let description = format!("{}, {}", describe(&info, &crs), file.scheme.name());
        let facts = facts(&info, &LandCoverFile { path: PathBuf::new(), ..file.clone() });
        let samples = Box::new(ClassRaster::new(raster, &file.scheme, &file.nodata)?);
        self.notes.extend(samples.notes());
        let datum = VerticalDatum::Msl;
        Ok(Opened { path: path.to_owned(), samples, block: info.block, geo, crs, datum, description, facts })
    }

    /// Collects what the user says of a file.
    fn said<'s>(&self, role: RasterRole, crs: Option<&'s str>, extent: Option<Bounds>) -> Said<'s> {
        Said { role, crs, extent, spacing: self.options.raw_spacing, local: self.options.local }
    }

    /// Georeferencing and reference system of a file; without any, its place on `canvas`, the ground that it is of.
    fn place(
        &mut self,
        info: &RasterInfo,
        said: Said<'_>,
        canvas: Option<&Canvas>,
    ) -> Result<(GeoTransform, Crs, VerticalCrs)> {
        let path = &info.path;
        let (given, flag) = (said.crs, said.role.crs_flag());
        let Some(geo) = info.geo else {
            let (geo, crs, note) = bare::place(info, said, canvas)?;
            self.notes.push(note);
            return Ok((geo, crs, VerticalCrs::default()));
        };

        if said.extent.is_some() {
            self.notes.push(format!(
                "{}: says itself where it lies, which counts; --imagery-extent is of files that do not",
                file_name(path)
            ));
        }

        if warp::invert(&geo).is_none() {
            return Err(Error::invalid(
                path,
                format!("its geotransform {geo:?} maps the raster onto a line"),
            ));
        }

        let (crs, vertical) = match (&info.crs, given) {
            (Some(crs), given) => {
                self.notes.extend(contradiction(&file_name(path), crs, given, flag)?);
                (crs.clone(), VerticalCrs::default())
            }
            (None, Some(text)) => {
                let (crs, vertical) = Crs::with_vertical_from_user(text)?;
                (crs, vertical.unwrap_or_default())
            }
            (None, None) if self.options.local => (Crs::local(), VerticalCrs::default()),
            (None, None) => return Err(no_crs(info, geo, flag)),
        };

        if info.crs.is_none() {
            let because = if given.is_some() { format!(", as {flag} says") } else { String::new() };
            let stated = match (&info.local, &info.crs_problem) {
                (Some(local), _) => format!("states {}", local.words()),
                (None, Some(problem)) => format!("states a reference system that is not read ({problem})"),
                (None, None) => "states no reference system".to_owned(),
            };
            self.notes.push(format!("{}: {stated}, taken as {}{because}", file_name(path), crs.name()));
        }

        if crs.is_local() {
            local_in_metres(info, &geo)?;
        }
        self.doubt(path, &crs, corner_bounds(&geo, info.size()));
        plausible(info, &geo, &crs, flag)?;

        Ok((geo, crs, vertical))
    }

    /// Says how well places of a system are known, once for each system.
    fn doubt(&mut self, path: &Path, crs: &Crs, bounds: [f64; 4]) {
        let Some(doubt) = crs.doubt(bounds) else { return };
        if !self.notes.iter().any(|note| note.ends_with(&doubt)) {
            self.notes.push(format!("{}: {doubt}", file_name(path)));
        }
    }

    fn into_notes(self) -> Vec<String> {
        let mut notes = self.notes;
        if !self.silent.is_empty() {
            let files = self.silent.join(", ");
            notes.push(format!(
                "vertical datum not stated by {files}: taken as mean sea level (--src-vdatum says otherwise)"
            ));
        }
        notes
    }
}

/// Notes that name a file by its name alone: what a database records must not depend on where its sources lay.
fn without_folders(path: &Path, notes: &[String]) -> Vec<String> {
    let (path, name) = (path.display().to_string(), file_name(path));
    notes.iter().map(|note| note.replace(&path, &name)).collect()
}

fn describe(info: &RasterInfo, crs: &Crs) -> String {
    let sample = info.sample.name();
    let bands = if info.bands == 1 { String::new() } else { format!(" of {} bands", info.bands) };
    format!("{} {sample} {}x{}{bands}, {}", info.format, info.width, info.height, crs_label(crs))
}
