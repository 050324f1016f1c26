//! Builds that end with a sentence, and leave nothing behind.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use super::support::{Area, options};
use crate::{BuildOptions, build};
use hedgehop::voxel::PageSource;
use hedgehop_base::error::Error;
use hedgehop_base::progress::{Observer, Silent};

/// An Esri grid of `side` × `side` heights without a word on its reference system.
fn grid_file(folder: &Path, side: usize, corner: (f64, f64), cell: f64) -> BuildOptions {
    let path = folder.join("heights.asc");
    let mut text = format!(
        "ncols {side}\nnrows {side}\nxllcorner {}\nyllcorner {}\ncellsize {cell}\n",
        corner.0, corner.1
    );
    for row in 0..side {
        let heights: Vec<String> = (0..side).map(|column| (row * 3 + column * 2).to_string()).collect();
        text += &(heights.join(" ") + "\n");
    }
    std::fs::write(&path, text).unwrap();
    let mut options = options(folder);
    options.elevation = vec![path.into()];
    options
}

fn refused(options: &BuildOptions) -> String {
    let error = build(options, &Silent).unwrap_err().to_string();
    let files = std::fs::read_dir(options.output.parent().unwrap()).unwrap();
    let left: Vec<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert!(
        left.iter().all(|name| [".asc", ".png", ".prj"].iter().any(|end| name.ends_with(end))),
        "{left:?}"
    );
    error
}

#[test]
fn a_missing_system_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut degrees = grid_file(folder.path(), 20, (10.0, 47.0), 0.001);
    let error = refused(&degrees);
    assert!(error.contains("heights.asc") && error.contains("--elevation-crs EPSG:4326"), "{error}");
    degrees.local = true;
    let error = refused(&degrees);
    assert!(error.contains("look like degrees") && error.contains("--elevation-crs EPSG:4326"), "{error}");
    degrees.local = false;
    degrees.elevation[0].crs = Some("EPSG:32633".into());
    assert!(refused(&degrees).contains("look like degrees"));
    degrees.elevation[0].crs = Some("EPSG:4326".into());
    build(&degrees, &Silent).unwrap();
    let area = Area::open(&degrees.output).unwrap();
    let metadata = &area.pages.header().metadata;
    assert_eq!(metadata.crs_epsg, Some(32632));
    assert!(metadata.notes.iter().any(|note| note.contains("states no reference system, taken as WGS 84")));
}

#[test]
fn metres_are_no_degrees() {
    let folder = tempfile::tempdir().unwrap();
    let mut metres = grid_file(folder.path(), 20, (400_000.0, 5_000_000.0), 10.0);
    let error = refused(&metres);
    assert!(error.contains("--local") && error.contains("--elevation-crs"), "{error}");
    metres.elevation[0].crs = Some("EPSG:4326".into());
    assert!(refused(&metres).contains("cannot be degrees"));
    metres.elevation[0].crs = None;
    metres.local = true;
    build(&metres, &Silent).unwrap();
    let area = Area::open(&metres.output).unwrap();
    assert_eq!(area.pages.header().metadata.crs_name, "local");
    assert_eq!((area.grid.origin.x, area.grid.spacing), (400_000.0, 10.0));
    // South-west pixel: last row, first column.
    assert!((area.height(0, 0).unwrap() - 57.0).abs() <= area.step());
}

/// Plain metres are none of feet that a file states.
#[test]
fn local_systems_keep_their_unit() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 20, (1000.0, 2000.0), 10.0);
    let state = |unit: &str| {
        std::fs::write(folder.path().join("heights.prj"), format!(r#"LOCAL_CS["site",UNIT[{unit}]]"#))
            .unwrap();
    };
    state(r#""foot",0.3048"#);
    for local in [false, true] {
        options.local = local;
        let error = refused(&options);
        assert!(error.contains("'site', in units of 0.3048 m"), "{error}");
        assert!(error.contains("-a_ullr 304.8 670.56 365.76 609.6") == local, "{error}");
    }

    state(r#""metre",1"#);
    build(&options, &Silent).unwrap();
    let notes = Area::open(&options.output).unwrap().pages.header().metadata.notes.join("; ");
    assert!(notes.contains("states a local system, 'site', taken as local"), "{notes}");
}

#[test]
fn pictures_without_georeferencing_need_a_spacing() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = options(folder.path());
    let path = folder.path().join("heights.png");
    let picture = image::ImageBuffer::from_fn(30, 20, |x, y| image::Luma([(100 * x + y) as u16]));
    picture.save(&path).unwrap();
    options.elevation = vec![path.into()];
    assert!(refused(&options).contains("--spacing"));
    options.raw_spacing = Some(-2.0);
    assert!(refused(&options).contains("--spacing"));
    options.raw_spacing = Some(4.0);

    // Imagery of another size belongs to the same ground.
    let colours = folder.path().join("colours.png");
    image::RgbImage::from_fn(60, 40, |x, y| image::Rgb([(x * 4) as u8, (y * 6) as u8, 9]))
        .save(&colours)
        .unwrap();
    options.imagery = vec![colours.into()];
    build(&options, &Silent).unwrap();
    let area = Area::open(&options.output).unwrap();
    assert_eq!((area.grid.nx, area.grid.ny, area.grid.spacing), (30, 20, 4.0));
    assert_eq!((area.grid.origin.x, area.grid.origin.y), (0.0, 0.0));
    assert!((area.height(29, 19).unwrap() - 2900.0).abs() <= area.step(), "row 0 is north");
    let [east, north, _] = area.colour(29, 19);
    assert!(east > 220 && north < 12, "{east} {north}");
}

#[test]
fn systems_must_fit_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 20, (400_000.0, 5_000_000.0), 10.0);
    options.local = true;
    options.crs = Some("EPSG:32633".into());
    assert!(refused(&options).contains("do not go together"));
    options.local = false;
    options.elevation[0].crs = Some("EPSG:32633".into());
    options.crs = Some("EPSG:4326".into());
    assert!(refused(&options).contains("not in metres"));
    options.elevation.clear();
    assert!(refused(&options).contains("--elevation"));
}

#[test]
fn kept_files_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 9, (400_000.0, 5_000_000.0), 10.0);
    (options.local, options.overwrite) = (true, false);
    std::fs::write(&options.output, b"mine").unwrap();
    let error = build(&options, &Silent).unwrap_err().to_string();
    assert!(error.contains("--overwrite"), "{error}");
    assert_eq!(std::fs::read(&options.output).unwrap(), b"mine");
}

#[test]
fn inputs_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 9, (400_000.0, 5_000_000.0), 10.0);
    options.local = true;
    options.output = folder.path().join(".").join("heights.asc");
    let heights = std::fs::read(&options.output).unwrap();
    assert!(refused(&options).contains("is an input"));
    assert_eq!(std::fs::read(&options.output).unwrap(), heights);
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_neither_read_nor_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 9, (400_000.0, 5_000_000.0), 10.0);
    options.local = true;
    options.output = folder.path().join("socket");
    let _socket = std::os::unix::net::UnixListener::bind(&options.output).unwrap();
    let sentence = |options: &BuildOptions| build(options, &Silent).unwrap_err().to_string();
    assert!(sentence(&options).contains("no regular file"));
    options.elevation = vec![std::mem::replace(&mut options.output, folder.path().join("area.hop")).into()];
    assert!(sentence(&options).contains("no regular file"));
}

#[test]
fn a_missing_folder_is_told_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 9, (400_000.0, 5_000_000.0), 10.0);
    options.output = folder.path().join("absent").join("area.hop");
    // Heights without a system would be refused next.
    let error = build(&options, &Silent).unwrap_err().to_string();
    assert!(error.contains("cannot create a file beside it"), "{error}");
}

#[test]
fn voxels_larger_than_the_area_have_no_surface() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 9, (400_000.0, 5_000_000.0), 10.0);
    (options.local, options.spacing) = (true, Some(1.0e6));
    assert!(refused(&options).contains("--spacing"));
}

/// Stops the work after a number of units.
struct Impatient {
    left: AtomicU64,
}

impl Observer for Impatient {
    fn advance(&self, count: u64) {
        self.left.fetch_sub(count.min(self.left.load(Ordering::Relaxed)), Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}

#[test]
fn stopped_builds_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = grid_file(folder.path(), 600, (400_000.0, 5_000_000.0), 10.0);
    options.local = true;
    for units in [0, 1, 3, 6, 12] {
        let outcome = build(&options, &Impatient { left: AtomicU64::new(units) });
        assert!(matches!(outcome, Err(Error::Interrupted(_))), "{units}: {outcome:?}");
        let files: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
        assert_eq!(files, ["heights.asc"], "after {units}");
    }
}
