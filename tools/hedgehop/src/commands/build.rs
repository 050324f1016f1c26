//! `hedgehop build`: elevation and imagery in, a database out.

mod order;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::making::Making;
use crate::program::program;
use crate::progress::Reporter;
use crate::tracks::TrackArgs;
use crate::{area, args};
use hedgehop::Error;
use hedgehop::geo::VerticalDatum;
use hedgehop::memory::PageFile;
use hedgehop::sunlight::SunSetting;
use hedgehop::voxel::PageSource;
use hedgehop_modeling::recipe::{InKeys, route};
use hedgehop_modeling::synthetic::Synthetic;
use hedgehop_modeling::{
    BuildOptions, BuildReport, CloudFile, Corridor, ElevationFile, FeatureFile, ImageryFile, Interpolation,
    LandCoverFile, Materials, NodataFill, Scheme, is_own_work,
};

pub use order::Order;

const EXAMPLE: &str = "\
Examples:
  hedgehop build --elevation dem.tif --imagery ortho.tif -o area.hop
  hedgehop build place.toml
  hedgehop build --elevation fine.tif tiles/*.hgt --imagery sat.tif --spacing 10 \\
      --bbox 480000,5120000,520000,5160000 --nodata-fill interp -o alps.hop
  hedgehop build --cloud survey.laz -o survey.hop
  hedgehop build --elevation heights.png --local --spacing 2 -o model.hop
  hedgehop build --elevation strip-1m.tif area-16m.tif --corridor flight.csv --width 2000 --spacing 1 -o route.hop";

/// Flags that say what recipes say.
const SAID_BY_RECIPES: [&str; 25] = [
    "cloud",
    "cloud_crs",
    "elevation",
    "features",
    "imagery",
    "imagery_extent",
    "land_cover",
    "land_cover_scheme",
    "land_cover_crs",
    "crs",
    "elevation_crs",
    "imagery_crs",
    "local",
    "spacing",
    "corridor",
    "width",
    "track",
    "sort",
    "outside",
    "bbox",
    "src_vdatum",
    "nodata",
    "nodata_fill",
    "bands",
    "bake_shadows",
];

/// Returns the help of `--elevation`.
fn elevation_help() -> String {
    format!("Elevation rasters, highest priority first: {}", args::names(args::elevation_formats()))
}

/// Returns the help of `--imagery`.
fn imagery_help() -> String {
    let names = args::names(args::imagery_formats());
    format!(
        "Imagery, highest priority first: {names}, pictures with world files [default: none, colour follows height]"
    )
}

/// Build a database from elevation rasters, point clouds and imagery, or as a recipe says.
///
/// A recipe is a file that says what flags say and stays with its data: `hedgehop new` writes one to begin with. Inputs may be in any reference system; the database is in metres. Give several files in order of
/// priority: where they overlap, the first one that has data counts. Memory stays bounded for inputs of any size.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct BuildArgs {
    /// Recipe that says what to build from what; instead of the flags below, but for -o, --memory, --jobs, --overwrite and --progress
    #[arg(value_name = "PLACE.toml", conflicts_with_all = SAID_BY_RECIPES)]
    recipe: Option<PathBuf>,

    /// Elevation rasters, highest priority first
    #[arg(long, value_name = "FILE", num_args = 1.., help = elevation_help(), required_unless_present_any = ["recipe", "cloud"])]
    elevation: Vec<PathBuf>,

    /// Point clouds, LAS or LAZ: their ground lies above that of --elevation, and buildings, plants and wires stand on it by their classes
    #[arg(long, value_name = "FILE", num_args = 1..)]
    cloud: Vec<PathBuf>,

    /// Imagery, highest priority first
    #[arg(long, value_name = "FILE", num_args = 1.., help = imagery_help())]
    imagery: Vec<PathBuf>,

    /// Maps of land cover, highest priority first: GeoTIFF of classes; the ground has their materials, and their colours where there is no imagery
    #[arg(long, value_name = "FILE", num_args = 1.., requires = "land_cover_scheme")]
    land_cover: Vec<PathBuf>,

    /// Meaning of land-cover classes: worldcover (ESA), corine, nlcd; recipes may say others
    #[arg(long, value_name = "SCHEME", value_parser = Scheme::named, requires = "land_cover")]
    land_cover_scheme: Option<Scheme>,

    /// Reference system of maps of land cover that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true, requires = "land_cover")]
    land_cover_crs: Option<String>,

    /// Features that stand or lie on the ground, by OpenStreetMap's tags: GeoJSON, Shapefiles, GeoPackages, tables of outlines (.csv)
    #[arg(long, value_name = "FILE", num_args = 1..)]
    features: Vec<PathBuf>,

    /// Database to write [default with a recipe: what it says, or its own name with .hop]
    #[arg(short, long, value_name = "AREA.hop", required_unless_present = "recipe")]
    output: Option<PathBuf>,

    /// Reference system of the database, in metres: EPSG:32633, a PROJ string, a .prj file [default: UTM zone of the centre]
    #[arg(long, value_name = "CRS", allow_hyphen_values = true)]
    crs: Option<String>,

    /// Reference system of point clouds that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true, requires = "cloud")]
    cloud_crs: Option<String>,

    /// Reference system of elevation files that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true)]
    elevation_crs: Option<String>,

    /// Reference system of imagery files that state none
    #[arg(long, value_name = "CRS", allow_hyphen_values = true, requires = "imagery")]
    imagery_crs: Option<String>,

    /// Edges of an image that does not say where it lies: degrees, or coordinates of --imagery-crs, or without it of the
    /// first elevation file where they cannot be degrees
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, requires = "imagery", allow_hyphen_values = true)]
    imagery_extent: Option<[f64; 4]>,

    /// Take coordinates of files without a reference system as plain metres
    #[arg(long)]
    local: bool,

    /// Side of the finest voxel in metres, and pixel size of inputs without georeferencing [default: pixel size of the finest elevation file];
    /// with --corridor, of the voxels within each --width
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true)]
    spacing: Vec<f64>,

    /// Routes near which the area is stored more finely than elsewhere: path files, as `render --path` takes them
    #[arg(long, value_name = "ROUTE", num_args = 1.., requires = "width")]
    corridor: Vec<PathBuf>,

    /// Width of the corridor, metres from side to side, that the --spacing in the same place holds in; several nest
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true, requires = "corridor")]
    width: Vec<f64>,

    #[command(flatten)]
    tracks: TrackArgs,

    /// Side of the finest voxel outside of corridors, metres: 4, 16, 64, … times the finest
    /// [default: of these, the largest that is no wider than the pixels of the coarsest elevation file]
    #[arg(long, value_name = "METRES", value_parser = args::positive, allow_negative_numbers = true, requires = "corridor")]
    outside: Option<f64>,

    /// Area to build, metres in the database's reference system [default: all that elevation covers]
    #[arg(long, value_name = "W,S,E,N", value_parser = args::bounding_box, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,

    /// Vertical datum of files that state none [default: msl]
    #[arg(long, value_name = "DATUM")]
    src_vdatum: Option<Datum>,

    /// Elevation values that mean "no data", besides those that the files declare
    #[arg(long, value_name = "VALUE", value_parser = args::number, value_delimiter = ',', allow_hyphen_values = true)]
    nodata: Vec<f64>,

    /// Filling of voids: small (those of up to 64 voxels that heights enclose are interpolated), none (no surface there), interp (all, from the heights around), or a height in metres
    #[arg(long, value_name = "small|none|interp|METRES", default_value = "small", value_parser = nodata_fill, allow_hyphen_values = true)]
    nodata_fill: NodataFill,

    /// Imagery bands to take as red, green and blue, counted from 1 [default: as the file says]
    #[arg(long, value_name = "R,G,B", value_parser = args::bands, requires = "imagery")]
    bands: Option<[u32; 3]>,

    /// Put the shadows of a sun at these angles, or at this time, into the colours, as `hedgehop bake` does
    #[arg(long, value_name = "AZ,EL|TIME", value_parser = args::sun, allow_hyphen_values = true)]
    bake_shadows: Option<SunSetting>,

    /// Memory that the build may hold, bytes with suffix K, M or G
    #[arg(long, value_name = "BYTES", default_value = "512M", value_parser = args::bytes)]
    memory: u64,

    /// Make all pages, also those that were made of the same before; with a recipe
    #[arg(long, requires = "recipe")]
    fresh: bool,

    #[command(flatten)]
    making: Making,
}

/// Vertical datums as users name them.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Datum {
    /// Mean sea level, not further specified
    Msl,
    /// EGM96 geoid (SRTM)
    Egm96,
    /// EGM2008 geoid (Copernicus)
    Egm2008,
    /// WGS 84 ellipsoid
    Ellipsoid,
    /// NAVD88 (United States)
    Navd88,
}

impl From<Datum> for VerticalDatum {
    fn from(datum: Datum) -> Self {
        match datum {
            Datum::Msl => Self::Msl,
            Datum::Egm96 => Self::Egm96,
            Datum::Egm2008 => Self::Egm2008,
            Datum::Ellipsoid => Self::Ellipsoid,
            Datum::Navd88 => Self::Navd88,
        }
    }
}

fn nodata_fill(text: &str) -> Result<NodataFill, String> {
    match text.trim() {
        "small" => Ok(NodataFill::Small),
        "none" => Ok(NodataFill::None),
        "interp" => Ok(NodataFill::Interpolate),
        other => args::number(other)
            .map(NodataFill::Value)
            .map_err(|_| "want small, none, interp or a height in metres".into()),
    }
}

impl BuildArgs {
    fn cloud(&self, path: &Path) -> CloudFile {
        let datum = self.src_vdatum.map(VerticalDatum::from);
        CloudFile { path: path.to_owned(), crs: self.cloud_crs.clone(), datum, ..CloudFile::default() }
    }

    fn elevation(&self, path: &Path) -> ElevationFile {
        let datum = self.src_vdatum.map(VerticalDatum::from);
        ElevationFile {
            path: path.to_owned(),
            crs: self.elevation_crs.clone(),
            datum,
            nodata: self.nodata.clone(),
        }
    }

    fn imagery(&self, path: &Path) -> ImageryFile {
        let (crs, extent) = (self.imagery_crs.clone(), self.imagery_extent);
        ImageryFile { path: path.to_owned(), crs, bands: self.bands, extent }
    }

    fn land_cover(&self, path: &Path) -> Option<LandCoverFile> {
        let (path, crs) = (path.to_owned(), self.land_cover_crs.clone());
        Some(LandCoverFile { path, crs, scheme: self.land_cover_scheme.clone()?, nodata: Vec::new() })
    }

    fn options(&self) -> hedgehop::Result<BuildOptions> {
        let corridors = self.corridors()?;
        // Of several, the finest holds; without corridors the last one given.
        let finest = self.spacing.iter().copied().reduce(f64::min);
        let spacing = if corridors.is_empty() { self.spacing.last().copied() } else { finest };

        Ok(BuildOptions {
            kept_for: None,
            clouds: self.cloud.iter().map(|path| self.cloud(path)).collect(),
            elevation: self.elevation.iter().map(|path| self.elevation(path)).collect(),
            imagery: self.imagery.iter().map(|path| self.imagery(path)).collect(),
            land_cover: self.land_cover.iter().filter_map(|path| self.land_cover(path)).collect(),
            materials: Materials::default(),
            features: self.features.iter().cloned().map(FeatureFile::from).collect(),
            objects: Vec::new(),
            scatters: Vec::new(),
            synthetic: Synthetic::default(),
            interpolation: Interpolation::default(),
            output: self.output.clone().unwrap_or_default(),
            overwrite: self.making.overwrite,
            steps: false,
            crs: self.crs.clone(),
            local: self.local,
            spacing,
            raw_spacing: spacing,
            corridors,
            outside: self.outside,
            bbox: self.bbox,
            nodata_fill: self.nodata_fill,
            memory: self.memory,
            threads: self.making.workers.count(),
        })
    }

    /// Every route with every width.
    fn corridors(&self) -> hedgehop::Result<Vec<Corridor>> {
        self.tracks.check(!self.corridor.is_empty(), "--corridor")?;
        if self.corridor.is_empty() {
            return Ok(Vec::new());
        }
        let (widths, spacings) = (self.width.len(), self.spacing.len());
        if widths != spacings {
            return Err(Error::Configuration(format!(
                "--corridor with {widths} --width and {spacings} --spacing: each width takes its spacing, in the same order, \
                 as in --width 2000 --spacing 1 --width 10000 --spacing 4"
            )));
        }
        let mut corridors = Vec::new();
        for file in &self.corridor {
            let route = route(file, &self.tracks.options(None))?;
            let strip = |(&width, &spacing)| Corridor { route: route.clone(), width, spacing };
            corridors.extend(self.width.iter().zip(&self.spacing).map(strip));
        }
        Ok(corridors)
    }
}

impl BuildArgs {
    /// The same with files in place of patterns.
    fn with_files(mut self) -> hedgehop::Result<Self> {
        let files: [(&str, &mut Vec<PathBuf>, &[&str]); 6] = [
            ("--elevation", &mut self.elevation, &args::endings(args::elevation_formats())),
            ("--cloud", &mut self.cloud, &["laz", "las"]),
            ("--imagery", &mut self.imagery, &args::endings(args::imagery_formats())),
            ("--land-cover", &mut self.land_cover, &["tif", "tiff"]),
            ("--features", &mut self.features, &["geojson", "json", "shp", "gpkg", "csv"]),
            ("--corridor", &mut self.corridor, &["csv", "gpx", "igc", "kml"]),
        ];
        for (flag, files, endings) in files {
            *files = args::input_files(flag, files, endings)?;
        }
        if self.imagery_extent.is_some() && self.imagery.len() > 1 {
            return Err(Error::Configuration(format!(
                "--imagery-extent is of one image, and --imagery gives {}; a recipe says an `extent` for each (`hedgehop new place.toml`)",
                self.imagery.len()
            )));
        }
        Ok(self)
    }

    fn order(&self) -> hedgehop::Result<Order> {
        let Some(file) = &self.recipe else {
            return Ok(Order::new(self.options()?, self.bake_shadows));
        };
        let mut order = Order::of(file)?;
        let options = &mut order.options;
        if let Some(output) = &self.output {
            options.output.clone_from(output);
        }
        // Before anything beside it is touched.
        order.check_name().map_err(|error| if self.output.is_some() { error } else { order.told(error) })?;
        let options = &mut order.options;
        // What a build of a recipe left is there to be brought up to date.
        options.overwrite = self.making.overwrite || is_own_work(&options.output);
        (options.memory, options.threads) = (self.memory, self.making.workers.count());
        if self.fresh {
            order.forget_steps();
        }
        Ok(order)
    }
}

/// Runs the command.
pub fn run(args: &BuildArgs, interrupt: &Interrupt) -> Outcome {
    let args = &args.clone().with_files()?;
    let order = args.order()?;
    let output = &order.options.output;

    // What is no file is refused for that: nothing replaces it.
    if output.is_file() && !order.options.overwrite {
        let mut what = format!("{} exists; --overwrite replaces it", output.display());
        let steps = format!("{}.steps", output.display());
        if args.recipe.is_some() && Path::new(&steps).is_file() {
            what += &format!(
                " ({steps}, which should say that a build of this recipe made it as it is, is damaged or of another file)"
            );
        }
        return Err(Error::Configuration(what).into());
    }

    let reporter = Reporter::new(args.making.progress, interrupt);
    let report = if args.recipe.is_some() {
        order.fill(&InKeys(&reporter)).map_err(|error| order.told(error))
    } else {
        order.fill(&reporter)
    };
    exit::print(&summary(output, &report?)?)?;

    Ok(())
}

/// Says what was built, and what to try next.
pub fn summary(output: &Path, report: &BuildReport) -> hedgehop::Result<String> {
    let source = PageFile::open(output)?;
    let megabytes = report.bytes as f64 / 1e6;
    let voxels = report.voxels as f64 / 1e6;

    // A build that took no measurable time has no rate to speak of.
    let seconds = report.seconds.max(1e-3);
    let mut text = format!(
        "built {}: {megabytes:.1} MB in {:.1} s ({:.1} MB/s, {:.2} million voxels/s)\n",
        output.display(),
        report.seconds,
        megabytes / seconds,
        voxels / seconds
    );

    if report.reused > 0 {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  {} of {} pages are as before", report.reused, report.pages);
    }

    text += &area::description(source.header())?;
    text += &area::stored(source.header(), source.directory());
    let [x, y, z] = area::viewpoint(source.header()).to_array();

    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "Next:\n  {me} render {file} --eye {x:.0},{y:.0},{z:.0} --ypr 0,-15,0 -o view.png\n  \
         {me} render {file} --path TRACK -o frames/####.png\n",
        me = program(),
        file = output.display()
    );

    Ok(text)
}
