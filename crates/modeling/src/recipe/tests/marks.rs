//! Byte order marks: every text format that is read, with a mark and without.

use std::fs;
use std::path::Path;

use crate::features::{LayerOptions, read as read_features};
use crate::raster::{OpenOptions, Window, open};
use crate::recipe::Recipe;
use hedgehop::flight::{ReadOptions, read_track};
use hedgehop_base::error::Result;
use hedgehop_geo::Crs;

/// A format: files that stand beside what is read, the marked one of them, and how it is read.
struct Format {
    name: &'static str,
    files: &'static [(&'static str, &'static str)],
    marked: &'static str,
    read: fn(&Path) -> Result<String>,
}

const ASC: &str = "ncols 2\nnrows 2\nxllcorner 500000\nyllcorner 5000000\ncellsize 10\n1 2\n3 4\n";
const UTM: &str = "PROJCS[\"WGS 84 / UTM zone 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],\
    PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],\
    PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],\
    UNIT[\"metre\",1]]";
const SAMPLES: &str = "abcdefgh";
const ENVI: &str = "ENVI\nsamples = 2\nlines = 2\nbands = 1\ndata type = 12\nbyte order = 0\ninterleave = bsq\n\
    map info = {UTM, 1, 1, 500000, 5000000, 10, 10, 32, North, WGS-84}\n";
const EHDR: &str = "NCOLS 2\nNROWS 2\nNBITS 16\nULXMAP 500005\nULYMAP 5000005\nXDIM 10\nYDIM 10\n";
const GPX: &str = "<?xml version=\"1.0\"?><gpx version=\"1.1\"><trk><trkseg>\
    <trkpt lat=\"47.5\" lon=\"8.25\"><ele>500</ele><time>2026-05-01T12:00:00Z</time></trkpt>\
    <trkpt lat=\"47.6\" lon=\"8.26\"><ele>501</ele><time>2026-05-01T12:00:09Z</time></trkpt></trkseg></trk></gpx>";
const KML: &str = "<?xml version=\"1.0\"?><kml xmlns:gx=\"http://www.google.com/kml/ext/2.2\"><Placemark><gx:Track>\
    <altitudeMode>absolute</altitudeMode><when>2026-05-01T12:00:00Z</when><when>2026-05-01T12:00:10Z</when>\
    <gx:coord>8.25 47.5 1200.5</gx:coord><gx:coord>8.26 47.6 1210</gx:coord></gx:Track></Placemark></kml>";
const IGC: &str = "AXCT123\r\nHFDTE010526\r\nB1200004730000N00815000EA004000045012\r\nB1200094730000N00815600EA004100046012\r\n";
const POINT: &str = "{\"type\":\"Feature\",\"properties\":{\"natural\":\"tree\"},\"geometry\":{\"type\":\"Point\",\"coordinates\":[9,47]}}";

const FORMATS: [Format; 13] = [
    Format { name: "Esri ASCII grid", files: &[("a.asc", ASC)], marked: "a.asc", read: raster },
    Format { name: ".prj", files: &[("a.prj", UTM), ("a.asc", ASC)], marked: "a.prj", read: raster },
    Format {
        name: "world file",
        files: &[
            ("a.bpw", "10\n0\n0\n-10\n500005\n4999995\n"),
            ("a.hdr", "NCOLS 2\nNROWS 2\nNBITS 16\n"),
            ("a.bop", SAMPLES),
        ],
        marked: "a.bpw",
        read: raster,
    },
    Format {
        name: "ENVI header",
        files: &[("a.hdr", ENVI), ("a.img", SAMPLES)],
        marked: "a.hdr",
        read: raster,
    },
    Format {
        name: "Esri header",
        files: &[("a.hdr", EHDR), ("a.bil", SAMPLES)],
        marked: "a.hdr",
        read: raster,
    },
    Format { name: "system", files: &[("a.wkt", UTM)], marked: "a.wkt", read: system },
    Format {
        name: "CSV path",
        files: &[("a.csv", "time_s,x_m,y_m,alt_m\n0,500000,5000000,90\n9,500080,5000080,90\n")],
        marked: "a.csv",
        read: track,
    },
    Format { name: "GPX", files: &[("a.gpx", GPX)], marked: "a.gpx", read: track },
    Format { name: "KML", files: &[("a.kml", KML)], marked: "a.kml", read: track },
    Format { name: "IGC", files: &[("a.igc", IGC)], marked: "a.igc", read: track },
    Format { name: "GeoJSON", files: &[("a.geojson", POINT)], marked: "a.geojson", read: features },
    Format {
        name: "table of outlines",
        files: &[("a.csv", "geometry,height\n\"POLYGON ((9 47, 9.1 47, 9.1 47.1, 9 47))\",7\n")],
        marked: "a.csv",
        read: features,
    },
    Format {
        name: "recipe",
        files: &[("dem.asc", ASC), ("a.toml", "[[elevation]]\nfile = \"dem.asc\"\ncrs = \"EPSG:32632\"\n")],
        marked: "a.toml",
        read: recipe,
    },
];

fn raster(path: &Path) -> Result<String> {
    let raster = open(path, &OpenOptions::default())?;
    let info = raster.info().clone();
    let mut samples = Vec::new();
    raster.read(Window { x: 0, y: 0, width: info.width, height: info.height }, &[0], &mut samples)?;
    Ok(format!("{info:?} {samples:?}"))
}

fn system(path: &Path) -> Result<String> {
    Crs::from_user(&path.to_string_lossy()).map(|crs| format!("{crs:?}"))
}

fn track(path: &Path) -> Result<String> {
    read_track(path, &ReadOptions::default()).map(|track| format!("{track:?}"))
}

fn features(path: &Path) -> Result<String> {
    read_features(path, &LayerOptions::default()).map(|layer| format!("{:?} {:?}", layer.rows, layer.notes))
}

fn recipe(path: &Path) -> Result<String> {
    Recipe::read(path).map(|recipe| format!("{:?}", recipe.options.elevation))
}

/// UTF-16 as Windows writes it.
fn wide(text: &str) -> Vec<u8> {
    std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
}

#[test]
fn a_mark_changes_nothing_and_other_encodings_are_named() {
    for Format { name, files, marked, read } in FORMATS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(files.last().unwrap().0);
        for (file, text) in files {
            fs::write(folder.path().join(file), text).unwrap();
        }
        let plain = read(&path).unwrap_or_else(|error| panic!("{name}: {error}"));

        let (file, text) = files.iter().find(|(file, _)| *file == marked).unwrap();
        fs::write(folder.path().join(file), format!("\u{feff}{text}")).unwrap();
        let found = read(&path).unwrap_or_else(|error| panic!("{name} with a mark: {error}"));
        assert_eq!(found, plain, "{name}");

        fs::write(folder.path().join(file), wide(text)).unwrap();
        let told = read(&path).expect_err(name).to_string();
        assert!(told.contains("UTF-16") && told.contains("iconv"), "{name}: {told}");
    }
}
