//! One suite over both page sources: a database in memory and a mapped file.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec2;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::voxel::{
    Arrays, CorridorRecord, Grid, MaterialRecord, MemPages, Metadata, PageId, PageSource, SourceRecord,
    write_arrays,
};

const NX: u32 = 700;
const NY: u32 = 260;

fn metadata() -> Metadata {
    Metadata {
        crs_name: "WGS 84 / UTM zone 33N".into(),
        crs_epsg: Some(32633),
        crs_proj: Some("+proj=utm +zone=33 +datum=WGS84".into()),
        vertical_datum: "mean sea level".into(),
        sources: vec![SourceRecord {
            file: "Höhe.tif".into(),
            role: "elevation".into(),
            description: "test".into(),
        }],
        corridors: vec![CorridorRecord { route: "flight.csv".into(), width: 2000.0, spacing: 1.0 }],
        materials: vec![MaterialRecord {
            number: 200,
            name: "maize".into(),
            like: Some("crop".into()),
            colour: [120, 130, 60],
        }],
        notes: vec!["nothing assumed".into()],
        void_share: 0.25,
        filled_share: Some(0.125),
        empty_share: 0.0,
        baked_sun: Some([120.5, 33.0]),
        imagery_pixel: Some(2.5),
        writer: "a test".into(),
    }
}

/// A ramp that rises by 1 m per voxel eastward and 0.5 m northward.
fn write(path: &Path) {
    let grid = Grid { nx: NX, ny: NY, spacing: 10.0, origin: DVec2::new(3.0e5, 5.0e6) };
    let voxels = || (0..NY).flat_map(|y| (0..NX).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<f64> = voxels().map(|(x, y)| x + 0.5 * y).collect();
    let colours: Vec<[u8; 3]> = voxels().map(|(x, y)| [x as u8, y as u8, 7]).collect();
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    write_arrays(path, &arrays, &metadata(), false).unwrap();
}

/// Runs `test` over the same database from a file and from memory.
fn over_both(test: impl Fn(&dyn PageSource, &dyn Fn() -> u64)) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ramp.hop");
    write(&path);
    let file = PageFile::open(&path).unwrap();
    test(&file, &|| file.touched().pages);
    let memory = MemPages::from_bytes(&path, &fs::read(&path).unwrap()).unwrap();
    test(&memory, &|| memory.touched().pages);
}

#[test]
fn header_says_what_was_written() {
    over_both(|source, _| {
        let header = source.header();
        assert_eq!(header.metadata, metadata());
        assert_eq!((header.grid.nx, header.grid.ny, header.level_count), (NX, NY, 4));
        assert_eq!(header.height_range, (0.0, 699.0 + 0.5 * 259.0));
    });
}

#[test]
fn posts_hold_the_ramp_at_every_level() {
    over_both(|source, _| {
        let header = source.header();
        for level in 0..header.level_count {
            let side = f64::from(Grid::side_units(level));
            // Whole voxels only: those at the edge average what there is.
            let (px, py) = header.grid.page_dims(level);
            for id in (0..py).flat_map(|py| (0..px).map(move |px| PageId { level, px, py })) {
                let view = source.page(id).unwrap().unwrap();
                for (x, y) in [(0, 0), (view.width / 2, view.height / 2)] {
                    let code = view.heights[view.sample(x, y)];
                    let centre = |page: u32, k: u32| (f64::from(page * 256 + k) + 0.5) * side - 0.5;
                    let expected = centre(id.px, x) + 0.5 * centre(id.py, y);
                    let whole = f64::from(id.py * 256 + y + 1) * side <= f64::from(NY);
                    let error = (header.heights.decode(code).unwrap() - expected).abs();
                    assert!(!whole || error <= header.heights.scale * f64::from(level + 1), "{id}: {error}");
                }
            }
        }
    });
}

#[test]
fn pages_outside_are_absent() {
    over_both(|source, touched| {
        let (columns, rows) = source.header().grid.page_dims(0);
        for id in [
            PageId { level: 0, px: columns, py: 0 },
            PageId { level: 0, px: 0, py: rows },
            PageId { level: 4, px: 0, py: 0 },
            PageId { level: 255, px: u32::MAX, py: u32::MAX },
        ] {
            assert!(source.page(id).unwrap().is_none());
        }
        assert_eq!(touched(), 0);
    });
}

#[test]
fn threads_see_the_same_pages_and_each_is_counted_once() {
    over_both(|source, touched| {
        let id = PageId { level: 0, px: 1, py: 1 };
        let first = source.page(id).unwrap().unwrap().to_buffer();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| assert_eq!(source.page(id).unwrap().unwrap().to_buffer(), first));
            }
        });
        assert_eq!(touched(), 1);
    });
}

#[test]
fn a_written_file_verifies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ramp.hop");
    write(&path);
    let report = PageFile::open(&path).unwrap().verify(&Silent).unwrap();
    assert_eq!(report.problems, []);
    assert_eq!(report.bytes, fs::metadata(&path).unwrap().len());
}

fn refusal(path: PathBuf) -> String {
    let error = PageFile::open(&path).unwrap_err().to_string();
    assert!(error.starts_with(&path.display().to_string()), "{error} does not begin with the file's name");
    error
}

#[test]
fn files_that_are_no_databases_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    assert!(refusal(path("missing.hop")).contains("cannot open it as a database"));
    assert!(refusal(folder.path().to_owned()).contains("is a folder"));
    fs::write(path("empty.hop"), []).unwrap();
    assert!(refusal(path("empty.hop")).contains("empty; the build was killed"));
    fs::write(path("photo.hop"), b"\x89PNG\r\n\x1a\n and so on").unwrap();
    assert!(refusal(path("photo.hop")).contains("not a hedgehop database"));
    write(&path("whole.hop"));
    let whole = fs::read(path("whole.hop")).unwrap();
    fs::write(path("half.hop"), &whole[..whole.len() / 2]).unwrap();
    assert!(refusal(path("half.hop")).contains("truncated at byte"));
}

#[cfg(unix)]
#[test]
fn databases_are_as_readable_as_other_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (database, other) = (folder.path().join("ramp.hop"), folder.path().join("other"));
    write(&database);
    fs::write(&other, []).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&database), mode(&other));
}
