//! Builds that go on from builds before: always the bytes of a build of everything, and no more made than what changed.

mod handover;
mod shadows;

use std::collections::BTreeMap;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};

use tempfile::TempDir;

use hedgehop::memory::PageFile;
use hedgehop::progress::{Observer, Silent};
use hedgehop::voxel::{DetailRecord, PageSource};
use hedgehop::{Error, Result};
use hedgehop_modeling::{
    BuildOptions, BuildReport, Corridor, ElevationFile, FeatureFile, ImageryFile, NodataFill, Place, Route,
    build, forget_steps, is_own_work,
};

/// West and south edge, metres, and voxels along a side: 5 × 5 pages of level 1, 4 of level 4, one of level 16 and of level 64.
const CORNER: (f64, f64) = (500_000.0, 5_000_000.0);
const SIDE: u32 = 1280;
const PAGES: u64 = 25 + 4 + 1 + 1;

/// Posts of 10 m, in two halves.
fn raster(folder: &Path, name: &str, west: u32, columns: u32, rise: u32) {
    let row = |row: u32| {
        let post = |column: u32| format!("{}", 100 + rise + (column + west) * row % 37 + row / 4);
        (0..columns).map(post).collect::<Vec<_>>().join(" ")
    };
    let rows: Vec<_> = (0..SIDE / 10).map(row).collect();
    let head = format!(
        "ncols {columns}\nnrows {}\nxllcorner {}\nyllcorner {}\ncellsize 10\n",
        SIDE / 10,
        CORNER.0 + f64::from(west * 10),
        CORNER.1
    );
    fs::write(folder.join(name), head + &rows.join("\n") + "\n").unwrap();
}

/// A house of 10 m by its south-west corner and its height, each.
fn houses(folder: &Path, houses: &[(f64, f64, f64)]) {
    let house = |(x, y, height): &(f64, f64, f64)| {
        let (x, y) = (CORNER.0 + x, CORNER.1 + y);
        let ring = [(x, y), (x + 10.0, y), (x + 10.0, y + 10.0), (x, y + 10.0), (x, y)]
            .map(|(x, y)| format!("[{x},{y}]"));
        format!(
            r#"{{"type":"Feature","properties":{{"building":"yes","height":{height}}},"geometry":{{"type":"Polygon","coordinates":[[{}]]}}}}"#,
            ring.join(",")
        )
    };
    let houses: Vec<_> = houses.iter().map(house).collect();
    let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}}"#;
    let text = format!(r#"{{"type":"FeatureCollection",{crs},"features":[{}]}}"#, houses.join(","));
    fs::write(folder.join("town.geojson"), text).unwrap();
}

const TOWN: [(f64, f64, f64); 3] = [(100.0, 100.0, 9.0), (640.0, 640.0, 12.0), (1100.0, 300.0, 6.0)];

/// Two elevation files, an image and a town.
fn site() -> TempDir {
    let folder = TempDir::new().unwrap();
    raster(folder.path(), "west.asc", 0, 64, 0);
    raster(folder.path(), "east.asc", 64, 64, 0);
    houses(folder.path(), &TOWN);
    let image = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * 4) as u8, (y * 4) as u8, 90]));
    image.save(folder.path().join("photo.png")).unwrap();
    let (x, y) = (CORNER.0 + 5.0, CORNER.1 + f64::from(SIDE) - 5.0);
    fs::write(folder.path().join("photo.pgw"), format!("10\n0\n0\n-10\n{x}\n{y}\n")).unwrap();
    folder
}

fn options(folder: &Path, output: &str) -> BuildOptions {
    let path = |name: &str| folder.join(name);
    let mut options = BuildOptions::new(Vec::new(), Vec::new(), path(output));
    let crs = Some("EPSG:32632".to_owned());
    let elevation = |name| ElevationFile { path: path(name), crs: crs.clone(), ..ElevationFile::default() };
    options.elevation = vec![elevation("west.asc"), elevation("east.asc")];
    options.imagery =
        vec![ImageryFile { path: path("photo.png"), crs: crs.clone(), bands: None, extent: None }];
    options.features = vec![FeatureFile::from(path("town.geojson"))];
    options.spacing = Some(1.0);
    (options.steps, options.overwrite) = (true, true);
    options
}

fn bytes(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap()
}

/// Result of a build that takes nothing over.
struct Whole {
    report: BuildReport,
    bytes: Vec<u8>,
}

/// Builds everything beside an output, once for the same inputs and options.
fn whole(options: &BuildOptions) -> &'static Whole {
    static KNOWN: Mutex<BTreeMap<String, &'static OnceLock<Whole>>> = Mutex::new(BTreeMap::new());

    let folder = options.output.parent().unwrap();
    let clean = BuildOptions { output: folder.join("a.clean"), steps: false, ..options.clone() };
    let mut inputs: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    inputs.retain(|path| {
        path.extension().is_some_and(|end| ["asc", "geojson", "pgw", "png"].iter().any(|known| end == *known))
    });
    inputs.sort();
    let mut hasher = DefaultHasher::new();
    inputs.iter().for_each(|path| (path.file_name(), bytes(path)).hash(&mut hasher));
    let key = format!("{clean:?} of {}", hasher.finish()).replace(folder.to_str().unwrap(), "");

    // Another test may be at it: it is waited for, but nobody waits for other builds.
    let known = *KNOWN.lock().unwrap().entry(key).or_insert_with(|| Box::leak(Box::default()));
    known.get_or_init(|| {
        let report = build(&clean, &Silent).unwrap();
        assert!(report.reused == 0 && !is_own_work(&clean.output));
        let bytes = bytes(&clean.output);
        fs::remove_file(&clean.output).unwrap();
        Whole { report, bytes }
    })
}

/// Builds again, and holds the result against a build of everything.
fn updated(options: &BuildOptions) -> BuildReport {
    let report = build(options, &Silent).unwrap();
    let whole = whole(options);
    assert_eq!((whole.report.pages, whole.report.content_hash), (report.pages, report.content_hash));
    assert!(bytes(&options.output) == whole.bytes, "the same bytes");
    assert!(is_own_work(&options.output));
    report
}

#[test]
fn detail_below_the_voxel_makes_no_page_again() {
    let folder = site();
    let mut options = options(folder.path(), "a.hop");
    updated(&options);
    let record = DetailRecord { seed: 4, strength: 0.5, ..DetailRecord::default() };
    options.synthetic.below_voxel = Some(record.clone());
    assert_eq!(updated(&options).reused, PAGES);
    assert_eq!(PageFile::open(&options.output).unwrap().header().metadata.detail, Some(record));
}

#[test]
fn what_did_not_change_is_not_made_again() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    let first = updated(&options);
    assert_eq!((first.pages, first.reused), (PAGES, 0));
    assert_eq!(updated(&options).reused, PAGES);
    // However much of the machine it may use.
    let other = BuildOptions { threads: 3, memory: 900 << 20, ..options };
    assert_eq!(updated(&other).reused, PAGES);
}

#[test]
fn a_house_changes_its_own_pages() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    updated(&options);
    let mut town = TOWN;
    town[1].2 = 13.5;
    houses(folder.path(), &town);
    // One page of each level.
    assert_eq!(updated(&options).reused, PAGES - 4);
    // Much higher than what was there, and the code of heights changes.
    town[1].2 = 300.0;
    houses(folder.path(), &town);
    assert_eq!(updated(&options).reused, 0);
    houses(folder.path(), &town[..2]);
    // And a coarse page that has a rim of the changed one for its apron.
    assert_eq!(updated(&options).reused, PAGES - 5);
}

/// What the file system knows a file by.
#[cfg(unix)]
fn file_number(path: &Path) -> u64 {
    std::os::unix::fs::MetadataExt::ino(&fs::metadata(path).unwrap())
}

#[test]
#[cfg(unix)]
fn only_what_changed_is_written() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    updated(&options);
    let number = || file_number(&options.output);
    let first = number();
    let mut town = TOWN;
    town[1].2 = 13.5;
    houses(folder.path(), &town);
    assert_eq!((updated(&options).reused, number()), (PAGES - 4, first), "changed in place");
    assert_eq!((updated(&options).reused, number()), (PAGES, first), "nothing to write");
    assert_eq!(left(folder.path()), ["a.hop", "a.hop.steps"]);

    // One that reads it sees the old one to the end.
    let reader = PageFile::open(&options.output).unwrap();
    town[1].2 = 14.5;
    houses(folder.path(), &town);
    assert_eq!(updated(&options).reused, PAGES - 4);
    assert_ne!(number(), first, "replaced");
    assert!(reader.verify(&Silent).unwrap().problems.is_empty() && reader.intact().is_ok());
    drop(reader);

    // More spans than fit where the page lies: all that follows moves.
    let second = number();
    let many: Vec<_> = (0..400).map(|k| (f64::from(k % 20) * 12.0, f64::from(k / 20) * 12.0, 8.0)).collect();
    houses(folder.path(), &[&town[..], &many[..]].concat());
    assert!(updated(&options).reused > 0);
    assert_ne!(number(), second, "replaced");

    // A build that is stopped leaves what it has made, though it was not to be written there.
    let third = (number(), bytes(&options.output));
    let alone = BuildOptions { threads: 1, ..options.clone() };
    town[1].2 = 11.5;
    houses(folder.path(), &[&town[..], &many[..]].concat());

    // Surveys and features count as well.
    let after = 2 + 403 + 27;
    assert!(matches!(interrupted(&alone, after), Err(Error::Interrupted(what)) if what.contains("goes on")));
    assert!((number(), bytes(&options.output)) == third);
    assert_eq!(left(folder.path()).len(), 4, "a part and its log");
    assert!(updated(&options).reused > PAGES - 4);
    assert_eq!(number(), third.0, "changed in place");
    assert_eq!(left(folder.path()), ["a.hop", "a.hop.steps"]);
}

#[test]
fn a_log_that_was_not_given_its_name_is_found() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    updated(&options);
    let log = folder.path().join("a.hop.steps");
    fs::rename(&log, folder.path().join("a.hop.part-x.steps")).unwrap();
    fs::write(folder.path().join("a.hop.part-x"), []).unwrap();
    assert!(is_own_work(&options.output));
    assert_eq!(left(folder.path()), ["a.hop", "a.hop.steps"]);
    assert_eq!(updated(&options).reused, PAGES);
}

#[test]
fn files_change_what_they_reach() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    updated(&options);
    raster(folder.path(), "east.asc", 64, 64, 0);
    assert_eq!(updated(&options).reused, PAGES, "written anew, but the same");

    // Another colour in the south-west: an image reaches everywhere.
    let mut image = image::open(folder.path().join("photo.png")).unwrap().to_rgb8();
    image.put_pixel(2, 61, image::Rgb([1, 2, 3]));
    image.save(folder.path().join("photo.png")).unwrap();
    assert!(updated(&options).reused < PAGES);

    // A height in the east, of no consequence for the range of heights: the west stays.
    let text = fs::read_to_string(folder.path().join("east.asc")).unwrap();
    fs::write(folder.path().join("east.asc"), text.replacen(" 120 ", " 121 ", 1)).unwrap();
    let reused = updated(&options).reused;
    assert!((5..PAGES).contains(&reused), "{reused}");

    for changed in [
        BuildOptions { nodata_fill: NodataFill::Interpolate, ..options.clone() },
        BuildOptions { spacing: Some(2.0), ..options.clone() },
        BuildOptions { imagery: Vec::new(), ..options.clone() },
    ] {
        assert_eq!(updated(&changed).reused, 0);
    }
}

#[test]
fn corridors_are_brought_up_to_date() {
    let folder = site();
    let place = |x: f64, y: f64| Place::Xy(CORNER.0 + x, CORNER.1 + y);
    let route =
        Route { file: PathBuf::from("route.csv"), places: vec![place(0.0, 700.0), place(1280.0, 700.0)] };
    let mut options = options(folder.path(), "a.hop");
    options.corridors = vec![Corridor { route, width: 100.0, spacing: 1.0 }];
    let first = updated(&options);
    assert_eq!(updated(&options).reused, first.pages);
    let mut town = TOWN;
    town[2].2 = 7.5;
    houses(folder.path(), &town);
    let reused = updated(&options).reused;
    assert!(reused > 0 && reused < first.pages, "{reused} of {}", first.pages);
    options.corridors[0].width = 600.0;
    let wider = updated(&options);
    assert!(wider.reused > 0 && wider.reused < wider.pages);
}

/// Stops after so many pages.
struct Impatient {
    left: AtomicU64,
}

impl Observer for Impatient {
    fn advance(&self, count: u64) {
        let left = self.left.load(Ordering::Relaxed);
        self.left.store(left.saturating_sub(count), Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }
}

/// What lies in a folder beside its inputs.
fn left(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name.starts_with("a.hop")).collect();
    names.sort();
    names
}

fn interrupted(options: &BuildOptions, after: u64) -> Result<BuildReport> {
    build(options, &Impatient { left: AtomicU64::new(after) })
}

#[test]
fn an_interrupted_build_goes_on() {
    let folder = site();
    let options = BuildOptions { threads: 1, features: Vec::new(), ..options(folder.path(), "a.hop") };
    let surveys: u64 = 2;
    let mut stopped = 0;

    for after in [20, 24, 28].map(|pages| pages + surveys) {
        match interrupted(&options, after) {
            Err(Error::Interrupted(what)) => {
                stopped += u64::from(what.contains("goes on from there"));
                // One part with its log, however often it is stopped.
                assert_eq!(left(folder.path()).len(), 2, "{:?}", left(folder.path()));
                assert!(!options.output.exists());
            }
            other => panic!("{other:?}"),
        }
    }

    assert_eq!(stopped, 3);
    let report = updated(&options);

    // All that was made before the last request to stop, but for pages that a worker had in hand.
    assert!(report.reused >= 27, "{report:?}");
    assert_eq!(left(folder.path()), ["a.hop", "a.hop.steps"]);
}

/// Takes a copy of what lies beside the output after so many units: what a program that is killed then leaves.
struct Killed<'f> {
    left: AtomicU64,
    folders: [&'f Path; 2],
}

impl Observer for Killed<'_> {
    fn advance(&self, count: u64) {
        let before = self.left.load(Ordering::Relaxed);
        self.left.store(before.saturating_sub(count), Ordering::Relaxed);
        if before > 0 && before <= count {
            for name in left(self.folders[0]) {
                fs::copy(self.folders[0].join(&name), self.folders[1].join(&name)).unwrap();
            }
        }
    }
}

#[test]
fn a_killed_build_goes_on_from_pages_that_waited_for_their_place() {
    let surveys: u64 = 2;
    // The area has one band of pages of level 1, and others of coarser levels.
    for after in [1, 12, 25, 28] {
        let (folder, copy) = (site(), site());
        let kill = Killed { left: AtomicU64::new(after + surveys), folders: [folder.path(), copy.path()] };
        let options = |folder: &TempDir| BuildOptions {
            threads: 1,
            features: Vec::new(),
            ..options(folder.path(), "a.hop")
        };
        build(&options(&folder), &kill).unwrap();
        assert_eq!(left(folder.path()), ["a.hop", "a.hop.steps"]);
        assert!(left(copy.path()).len() >= 4, "{:?}", left(copy.path()));
        let report = updated(&options(&copy));
        assert!(report.reused + 1 >= after, "{} of {after}", report.reused);
        assert_eq!(left(copy.path()), ["a.hop", "a.hop.steps"]);
    }
}

#[test]
fn pages_without_a_surface_are_taken_over_as_others_are() {
    let folder = site();
    // The second file lies 18 pages further east, and a third one keeps the area what it is.
    raster(folder.path(), "far.asc", 512, 30, 0);
    raster(folder.path(), "end.asc", 566, 10, 0);
    let elevation = |name: &str| ElevationFile {
        path: folder.path().join(name),
        crs: Some("EPSG:32632".into()),
        ..ElevationFile::default()
    };

    let options = BuildOptions {
        threads: 1,
        elevation: ["west.asc", "far.asc", "end.asc"].map(elevation).into(),
        features: Vec::new(),
        imagery: Vec::new(),
        ..options(folder.path(), "a.hop")
    };

    let surveys = 3;
    for after in [40, 100, 115] {
        assert!(matches!(interrupted(&options, after + surveys), Err(Error::Interrupted(_))), "{after}");
    }

    let report = updated(&options);
    let file = PageFile::open(&options.output).unwrap();
    let empty = file.directory().present().filter(|(_, entry)| entry.empty().is_some()).count() as u64;
    assert!(report.pages > 120 && empty > 80, "{empty} of {report:?}");
    assert!(report.reused > 105, "{report:?}");
    drop(file);

    // Nothing changed: nothing is made, and nothing read.
    assert_eq!(updated(&options).reused, report.pages);
    // The far file comes nearer: what it leaves has no bytes any more.
    raster(folder.path(), "far.asc", 300, 30, 0);
    let moved = updated(&options);
    assert!(moved.reused > 10 && moved.reused < moved.pages, "{moved:?}");
}

#[test]
fn what_was_stopped_before_its_first_page_leaves_nothing() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    assert!(matches!(interrupted(&options, 1), Err(Error::Interrupted(_))));
    assert_eq!(left(folder.path()), Vec::<String>::new());
}

#[test]
fn what_was_to_be_made_afresh_stays_a_work_of_its_own() {
    let folder = site();
    let options = BuildOptions { threads: 1, ..options(folder.path(), "a.hop") };
    updated(&options);
    forget_steps(&options.output);
    assert!(matches!(interrupted(&options, 20), Err(Error::Interrupted(_))));
    assert!(is_own_work(&options.output), "so that the next build may replace it");
    assert_eq!(updated(&options).pages, PAGES);
}

/// Where the last record of a log begins: what the file was when it was done.
fn times_in(log: &[u8]) -> usize {
    let text = b"{\"bytes\":";
    log.windows(text.len()).rposition(|words| words == text).unwrap() - 12
}

#[test]
#[cfg(unix)]
fn pages_of_a_file_that_nobody_changed_are_not_read() {
    use std::os::unix::fs::MetadataExt;

    let folder = site();
    let options = options(folder.path(), "a.hop");
    updated(&options);
    let log = folder.path().join("a.hop.steps");
    let mut damaged = bytes(&options.output);
    damaged[40_000] ^= 1;
    fs::write(&options.output, &damaged).unwrap();

    // The log of a build that left it like that.
    let file = fs::metadata(&options.output).unwrap();
    let times =
        [(file.mtime(), file.mtime_nsec()), (file.ctime(), file.ctime_nsec()), (0, file.ino() as i64)];
    let times =
        times.map(|(seconds, rest)| (i128::from(seconds) * 1_000_000_000 + i128::from(rest)).to_string());
    let record = format!("{{\"bytes\":{},\"times\":[{}]}}", file.len(), times.join(","));
    let mut forged = bytes(&log);
    forged.truncate(times_in(&forged));
    for number in [6, record.len() as u32, crc32fast::hash(record.as_bytes())] {
        forged.extend(number.to_ne_bytes());
    }

    forged.extend(record.as_bytes());
    fs::write(&log, &forged).unwrap();
    assert_eq!(build(&options, &Silent).unwrap().reused, PAGES);
    assert!(bytes(&options.output) == damaged, "nobody looked at the page");

    // Once more it is as it was left; then somebody touches it.
    fs::write(&options.output, &damaged).unwrap();
    assert_eq!(updated(&options).reused, PAGES - 1);
}

/// Whether a byte tells that a record is a survey, which the record's checksum does not cover.
fn tells_of_survey(log: &[u8], at: usize) -> bool {
    const SURVEY: u32 = 2;

    let word = |at: usize| log.get(at..at + 4).map(|bytes| u32::from_ne_bytes(bytes.try_into().unwrap()));
    let mut start = b"HOPSTEP1".len();
    while let (Some(kind), Some(length)) = (word(start), word(start + 4)) {
        if (start..start + 4).contains(&at) {
            return kind == SURVEY;
        }
        start += 12 + length as usize;
    }
    false
}

#[test]
fn damaged_files_cost_time_and_no_more() {
    let folder = site();
    // Coarse, so that many places can be tried: 2 × 2 pages of level 1, and one of each other level.
    let options = BuildOptions { spacing: Some(4.9), ..options(folder.path(), "a.hop") };
    let pages = updated(&options).pages;
    assert_eq!(pages, 4 + 1 + 1 + 1);
    let log = folder.path().join("a.hop.steps");
    let (good, good_log) = (bytes(&options.output), bytes(&log));

    // A page.
    let mut damaged = good.clone();
    damaged[40_000] ^= 1;
    fs::write(&options.output, damaged).unwrap();
    assert_eq!(updated(&options).reused, pages - 1);

    // The log, anywhere. Without what the file was, which comes last, all is read, and as good.
    let last = times_in(&good_log);
    for at in (0..good_log.len()).step_by(269) {
        let mut damaged = good_log.clone();
        damaged[at] ^= 0x55;
        fs::write(&log, &damaged).unwrap();
        fs::write(&options.output, &good).unwrap();
        let report = build(&options, &Silent).unwrap();
        assert!(bytes(&options.output) == good, "byte {at}: {report:?}");
        // A record of no known kind is passed over. A survey is made again, and finds what all pages were made of.
        let may_reuse_all = at >= last || tells_of_survey(&good_log, at);
        assert!(report.reused < pages || may_reuse_all, "byte {at}: {report:?}");
    }

    for length in (0..good_log.len()).step_by(449) {
        fs::write(&log, &good_log[..length]).unwrap();
        build(&options, &Silent).unwrap();
        assert!(bytes(&options.output) == good, "{length} bytes");
    }

    // Somebody else's database.
    fs::write(&options.output, &good[..good.len() / 2]).unwrap();
    assert!(!is_own_work(&options.output));
    assert_eq!(updated(&options).reused, 0);
}
