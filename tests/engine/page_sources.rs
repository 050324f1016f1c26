//! One suite over both page sources: a database in memory and a mapped file.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use hedgehop::Result;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{
    Arrays, BoundsView, CorridorRecord, DetailRecord, Grid, Header, HeightRange, MaterialRecord, MemPages,
    Metadata, PageBuffer, PageId, PageSource, PageView, SourceRecord, write_arrays,
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
        detail: Some(DetailRecord { seed: 3, ..DetailRecord::default() }),
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
        assert_eq!(header.height_range, HeightRange { low: 0.0, high: 699.0 + 0.5 * 259.0 });
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

/// A database's pages in full: of those that have no bytes, planes of their own, with colours that would be seen from afar.
struct InFull<'p> {
    pages: &'p MemPages,
    full: HashMap<PageId, PageBuffer>,
}

impl<'p> InFull<'p> {
    fn of(pages: &'p MemPages) -> Self {
        let empty = pages.directory().present().filter(|(_, entry)| entry.empty().is_some());
        let full = empty.map(|(id, _)| {
            let mut page = pages.whole_page(id).unwrap().unwrap().to_buffer();
            let glaring = (0..page.colours.len()).map(|at| [255, (at * 37) as u8, (at * 11) as u8]);
            page.colours = glaring.collect();
            (id, page)
        });
        Self { pages, full: full.collect() }
    }
}

impl PageSource for InFull<'_> {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        match self.full.get(&id) {
            Some(page) => Ok(Some(PageBuffer::view(page))),
            None => self.pages.page(id),
        }
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        match self.full.get(&id) {
            Some(page) => Ok(Some(BoundsView { width: page.width, low: &page.low, high: &page.high })),
            None => self.pages.bounds(id),
        }
    }
}

/// Two hills far apart, and nothing between them.
fn apart() -> MemPages {
    let (nx, ny) = (2000, 1500);
    let grid = Grid { nx, ny, spacing: 2.0, origin: DVec2::new(3.0e5, 5.0e6) };
    let voxels = || (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y)));
    let height = |(x, y): (u32, u32)| {
        let is_hill = x < 300 && y < 280 || x >= 1650 && y >= 1100 && (x + y) % 50 > 2;
        let rough = 4.0 * (f64::from(x) * 0.31).sin() * (f64::from(y) * 0.27).cos();
        if is_hill { 100.0 + 30.0 * (f64::from(x) * 0.02).sin() + rough } else { f64::NAN }
    };
    let heights: Vec<f64> = voxels().map(height).collect();
    let colours: Vec<[u8; 3]> = voxels().map(|(x, y)| [90, x as u8, y as u8]).collect();
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("apart.hop");
    write_arrays(&path, &arrays, &metadata(), false).unwrap();
    MemPages::from_bytes(&path, &fs::read(&path).unwrap()).unwrap()
}

#[test]
fn views_over_pages_without_bytes_are_those_over_pages_in_full() {
    let pages = apart();
    let full = InFull::of(&pages);
    assert_eq!((pages.directory().len(), full.full.len()), (48 + 4 + 1 + 1, 40 + 2));
    let eye = |x: f64, y: f64, z: f64| DVec3::new(3.0e5 + x, 5.0e6 + y, z);

    for (eye, yaw, pitch) in [
        // On a hill towards the gap, in the gap towards the other one, and down on all of it.
        (eye(450.0, 420.0, 150.0), 60.0, -8.0),
        (eye(2600.0, 1900.0, 180.0), 45.0, -4.0),
        (eye(1900.0, 300.0, 2600.0), 10.0, -70.0),
    ] {
        let camera =
            Camera::new(Pose { eye, attitude: Attitude { yaw, pitch, roll: 4.0 }, hfov: 70.0 }, 240, 150);
        for engine in [Engine::Planes, Engine::Reference] {
            let options = RenderOptions { engine, ..RenderOptions::default() };
            let farm = Farm::new(2).unwrap();
            let frame = Renderer::new(&pages, &options).frame(&camera, &farm).unwrap().frame;
            let wanted = Renderer::new(&full, &options).frame(&camera, &farm).unwrap().frame;
            assert!(frame.range.iter().any(|range| range.is_finite()), "something is seen");
            assert!(
                frame.colour == wanted.colour && frame.range == wanted.range && frame.normal == wanted.normal,
                "{engine:?} at {eye}"
            );
        }
    }
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
