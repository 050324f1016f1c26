//! The rasters of a build: opened, with everything known that is needed to place them (in `placed`).
//!
//! ```text
//! for each file: open it; its reference system is
//!     its own | --elevation-crs or --imagery-crs | plain metres (--local, or no georeferencing at all) | an error
//! refuse coordinates that cannot be what the system says: degrees as metres, metres as degrees, swapped axes
//! ```

use std::path::{Path, PathBuf};

use super::bare::{self, Canvas, RasterRole, Said, canvas};
use super::cloud::{self, Cloud};
use super::features::{self, Layer, LayerOptions};
use super::footprint::{Bounds, corner_bounds};
use super::kernel::Samples;
use super::land_cover::{ClassRaster, LandCoverFile, SampleClass};
use super::object::{self, OpenObject, OpenScatter};
use super::options::{BuildOptions, CloudFile, ElevationFile, FeatureFile, ImageryFile};
use super::plan;
use super::plausible::{local_in_metres, no_crs, plausible};
use super::raster::{
    ElevationRaster, GeoTransform, ImageryRaster, OpenOptions, Raster, RasterInfo, Window, open,
};
use super::source_heights::Stated;
use super::warp;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::{Observer, Silent};
use hedgehop_geo::{Crs, VerticalCrs, VerticalDatum};

/// Bytes of decoded blocks for a file that is only looked at.
const CACHE_TO_LOOK: u64 = 64 << 20;

/// A raster and where it says it lies.
pub(super) struct Opened<T> {
    pub path: PathBuf,
    pub samples: Box<dyn Samples<T>>,
    /// Natural block (columns, rows) for reading.
    pub block: (u32, u32),
    pub geo: GeoTransform,
    pub crs: Crs,
    /// Datum of heights, as stated, given or assumed; means nothing for imagery.
    pub datum: VerticalDatum,
    pub description: String,
    /// All that its side files and the user say of it, for keys of steps.
    pub facts: String,
}

/// All rasters, highest priority first, and what was assumed about them.
#[derive(Default)]
pub(super) struct Inputs {
    /// Point clouds; as many of the first of `elevation` are their places.
    pub clouds: Vec<Cloud>,
    pub elevation: Vec<Opened<f64>>,
    pub imagery: Vec<Opened<[u8; 4]>>,
    pub land_cover: Vec<Opened<SampleClass>>,
    pub features: Vec<(Layer, LayerOptions)>,
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
    fn size(&self) -> (u32, u32) {
        (self.info().width, self.info().height)
    }
    fn read(&self, window: Window, samples: &mut Vec<f64>) -> Result<()> {
        ElevationRaster::read(self, window, samples)
    }
    fn notes(&self) -> Vec<String> {
        without_folders(&self.info().path, &ElevationRaster::notes(self))
    }
}

impl Samples<[u8; 4]> for ImageryRaster {
    fn size(&self) -> (u32, u32) {
        (self.info().width, self.info().height)
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

/// A part of a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// A file of points, by its place in [`BuildOptions::clouds`].
    Cloud(usize),
    /// Elevation, by its place in [`BuildOptions::elevation`].
    Elevation(usize),
    /// Imagery, by its place in [`BuildOptions::imagery`].
    Imagery(usize),
    /// Land cover, by its place in [`BuildOptions::land_cover`].
    LandCover(usize),
    /// Features, by their place in [`BuildOptions::features`].
    Features(usize),
    /// Object, by its place in [`BuildOptions::objects`].
    Object(usize),
    /// Scatter, by its place in [`BuildOptions::scatters`].
    Scatter(usize),
    /// A shape of the ground, by its place in [`super::synthetic::Synthetic::terrain`].
    Terrain(usize),
    /// A pattern on it, by its place in [`super::synthetic::Synthetic::textures`].
    Texture(usize),
}

/// Builds the error of a file that states a reference system, if another one is given for it.
pub(super) fn contradiction(
    name: &str,
    stated: &Crs,
    given: Option<&str>,
    flag: &str,
) -> Result<Option<String>> {
    let given = given.map(Crs::from_user).transpose()?;
    Ok(given.filter(|given| given != stated && given.name() != stated.name()).map(|given| {
        format!(
            "{name}: states {}, which counts, and not {}; {flag} is of files that state none",
            stated.name(),
            given.name()
        )
    }))
}

/// Reads a file of features.
fn layer(file: &FeatureFile, options: &BuildOptions) -> Result<(Layer, LayerOptions)> {
    let materials = options.materials.clone();
    Ok((features::read(&file.path, &file.options)?, LayerOptions { materials, ..file.options.clone() }))
}

/// Finds the faults of each file by itself, or else with its place in the database: all of them, where a build ends at the first.
pub fn faults(options: &BuildOptions) -> Vec<(Input, Error)> {
    let open_options = OpenOptions { cache_bytes: CACHE_TO_LOOK, ..OpenOptions::default() };
    let mut opener = Opener::new(options, open_options, &Silent);
    let (mut inputs, mut faults) = (Inputs::default(), Vec::new());
    let clouds = sound(&options.clouds, |file| opener.cloud(file), Input::Cloud, &mut faults);
    (inputs.clouds, inputs.elevation) = clouds.into_iter().unzip();
    let elevation = sound(&options.elevation, |file| opener.elevation(file), Input::Elevation, &mut faults);
    inputs.elevation.extend(elevation);
    let canvas = canvas(&inputs.elevation);
    let imagery = |file: &ImageryFile| opener.imagery(file, canvas.as_ref());
    inputs.imagery = sound(&options.imagery, imagery, Input::Imagery, &mut faults);
    let land_cover = |file: &LandCoverFile| opener.land_cover(file, canvas.as_ref());
    inputs.land_cover = sound(&options.land_cover, land_cover, Input::LandCover, &mut faults);
    let features = |file: &FeatureFile| layer(file, options);
    inputs.features = sound(&options.features, features, Input::Features, &mut faults);
    inputs.objects = sound(&options.objects, object::open_object, Input::Object, &mut faults);
    inputs.scatters = sound(&options.scatters, object::open_scatter, Input::Scatter, &mut faults);
    if faults.is_empty() { plan::misfits(&inputs, options) } else { faults }
}

/// Opens files, and adds what is wrong with those that cannot be opened to `faults`.
fn sound<F, T>(
    files: &[F],
    open: impl FnMut(&F) -> Result<T>,
    input: fn(usize) -> Input,
    faults: &mut Vec<(Input, Error)>,
) -> Vec<T> {
    let mut opened = Vec::with_capacity(files.len());
    for (index, result) in files.iter().map(open).enumerate() {
        match result {
            Ok(file) => opened.push(file),
            Err(error) => faults.push((input(index), error)),
        }
    }
    opened
}

/// Describes what a raster says of itself and what the user says of it, but for where it lies.
fn facts(info: &RasterInfo, file: &dyn std::fmt::Debug) -> String {
    format!("{:?} {file:?}", RasterInfo { path: PathBuf::new(), ..info.clone() })
}

struct Opener<'a> {
    options: &'a BuildOptions,
    open_options: OpenOptions,
    observer: &'a dyn Observer,
    notes: Vec<String>,
    /// Elevation files whose vertical datum was assumed.
    silent: Vec<String>,
}

impl<'a> Opener<'a> {
    fn new(options: &'a BuildOptions, open_options: OpenOptions, observer: &'a dyn Observer) -> Self {
        Self { options, open_options, observer, notes: Vec::new(), silent: Vec::new() }
    }

    /// Opens a raster; what its file is told for goes to the notes.
    fn open(&mut self, path: &Path, classes: bool) -> Result<(Box<dyn Raster>, RasterInfo)> {
        let raster = open(path, &OpenOptions { classes, ..self.open_options.clone() })?;
        let info = raster.info().clone();
        self.notes.extend(info.notes.iter().cloned());
        Ok((raster, info))
    }

    fn cloud(&mut self, file: &CloudFile) -> Result<(Cloud, Opened<f64>)> {
        let (cloud, opened, notes) = cloud::open(file, self.options, self.observer)?;
        self.notes.extend(notes);
        Ok((cloud, opened))
    }

    fn elevation(&mut self, file: &ElevationFile) -> Result<Opened<f64>> {
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

    fn imagery(&mut self, file: &ImageryFile, canvas: Option<&Canvas>) -> Result<Opened<[u8; 4]>> {
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

    fn land_cover(&mut self, file: &LandCoverFile, canvas: Option<&Canvas>) -> Result<Opened<SampleClass>> {
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
        self.doubt(path, &crs, corner_bounds(&geo, (info.width, info.height)));
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

/// File name without folders.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

fn describe(info: &RasterInfo, crs: &Crs) -> String {
    let sample = info.sample.name();
    let bands = if info.bands == 1 { String::new() } else { format!(" of {} bands", info.bands) };
    format!("{} {sample} {}x{}{bands}, {}", info.format, info.width, info.height, crs_label(crs))
}

/// `EPSG:32633`, or the name of a system without a code.
pub(super) fn crs_label(crs: &Crs) -> String {
    crs.epsg().map_or_else(|| crs.name().to_owned(), |code| format!("EPSG:{code}"))
}
