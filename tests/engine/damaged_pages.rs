//! Damaged pages that coarser levels stand in for: as if they were absent, the same for any workers and budget, and flagged.

use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3};

use hedgehop::frame::Frame;
use hedgehop::memory::{PageFile, ResidentPages};
use hedgehop::raymarch::ground_height;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{
    Arrays, Attributes, Damaged, Grid, MemPages, Metadata, PageId, PagePart, PageSource, Trust, Verify,
    write_arrays,
};

const SIDE: u32 = 1200;
/// Offsets of FORMAT.md.
const VERSION: usize = 8;
const HEADER_CRC: usize = 12;
const HEADER_END: usize = 256;
const DIRECTORY_OFFSET: usize = 120;
const DIRECTORY_CRC: usize = 152;
const ENTRY: usize = 44;

const COARSER: Trust = Trust { verify: Verify::FirstTouch, damaged: Damaged::Coarser };

fn area() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 2.0, origin: DVec2::ZERO };
    let posts = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (f64::from(x), f64::from(y))));
    let heights: Vec<f64> = posts
        .map(|(x, y)| 40.0 * (x / 90.0).sin() + 30.0 * (y / 70.0).cos() + 3.0 * ((x + y) / 5.0).sin())
        .collect();
    let colours: Vec<_> = (0..heights.len()).map(|post| [(post / 7 % 200) as u8, 110, 80]).collect();
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    write_arrays(&path, &arrays, &Metadata::default(), false).unwrap();
    fs::read(&path).unwrap()
}

fn put(bytes: &mut [u8], offset: usize, value: u32) {
    bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
}

/// One byte of each of these pages is wrong.
fn damaged(area: &[u8], pages: &[PageId]) -> Vec<u8> {
    let mut bytes = area.to_vec();
    let directory = MemPages::from_bytes("area.hop", area).unwrap();
    for id in pages {
        bytes[directory.directory().get(*id).unwrap().offset as usize + 1000] ^= 0x40;
    }
    bytes
}

/// The directory says that there are no such pages.
fn without(area: &[u8], pages: &[PageId]) -> Vec<u8> {
    let mut bytes = area.to_vec();
    let store = MemPages::from_bytes("area.hop", area).unwrap();
    let start = u64::from_le_bytes(area[DIRECTORY_OFFSET..][..8].try_into().unwrap()) as usize;
    for id in pages {
        let entry = start + store.directory().index(*id).unwrap() * ENTRY;
        bytes[entry..entry + ENTRY].fill(0);
    }
    let directory = crc32fast::hash(&bytes[start..start + store.directory().len() * ENTRY]);
    put(&mut bytes, DIRECTORY_CRC, directory);
    sealed(bytes)
}

fn camera() -> Camera {
    let attitude = Attitude { yaw: 40.0, pitch: -8.0, roll: 0.0 };
    Camera::new(Pose { eye: DVec3::new(500.0, 450.0, 190.0), attitude, hfov: 60.0 }, 160, 90)
}

fn frame(
    path: &Path,
    trust: Trust,
    engine: Engine,
    workers: usize,
    budget: Option<u64>,
) -> hedgehop::Result<Frame> {
    let pages = ResidentPages::new(PageFile::open_trusting(path, trust)?, budget);
    let options = RenderOptions { engine, ..RenderOptions::default() };
    let renderer = Renderer::new(&pages, &options);
    Ok(renderer.frame(&camera(), &Farm::new(workers)?)?.frame)
}

fn stand_ins(frame: &Frame) -> usize {
    frame.id.iter().filter(|id| **id != u32::MAX && **id as u8 & Attributes::STAND_IN != 0).count()
}

#[test]
fn the_height_of_ground_is_known_without_its_paint() {
    let sound = MemPages::from_bytes("area.hop", &area()).unwrap();
    let mut bytes = sound.bytes().to_vec();
    bytes[sound.stretch(PagePart::Paint(PageId { level: 0, px: 0, py: 0 })).end - 1] ^= 1;
    let damaged = MemPages::from_bytes("area.hop", &bytes).unwrap();
    let at = DVec2::new(101.0, 77.0);
    assert_eq!(ground_height(&damaged, at).unwrap(), ground_height(&sound, at).unwrap());
}

#[test]
fn damaged_pages_are_as_absent_ones_and_flagged() {
    let area = area();
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let sound = file("sound.hop", &area);
    let page = |level, px, py| PageId { level, px, py };

    for bad in [vec![page(0, 1, 1)], vec![page(1, 0, 0)], vec![page(0, 0, 0), page(0, 1, 1), page(2, 0, 0)]] {
        let (path, absent) =
            (file("bad.hop", &damaged(&area, &bad)), file("absent.hop", &without(&area, &bad)));
        for engine in [Engine::Planes, Engine::Reference] {
            let expected = frame(&absent, Trust::default(), engine, 1, None).unwrap();
            for (workers, budget) in [(1, None), (3, None), (2, Some(1 << 20))] {
                let found = frame(&path, COARSER, engine, workers, budget).unwrap();
                assert!(
                    found.colour == expected.colour && found.range == expected.range,
                    "{bad:?}, {engine:?}"
                );
                assert_eq!(stand_ins(&found) > 0, bad.iter().any(|id| id.level < 2), "{bad:?}, {engine:?}");
            }

            assert_eq!(
                (stand_ins(&expected), stand_ins(&frame(&sound, COARSER, engine, 1, None).unwrap())),
                (0, 0)
            );
            let refusal = frame(&path, Trust::default(), engine, 2, None).unwrap_err().to_string();
            assert!(refusal.contains("wrong checksum; the file is damaged"), "{refusal}");
        }
    }
}

#[test]
fn damaged_pages_are_listed_and_nothing_stands_in_for_the_coarsest() {
    let area = area();
    let (fine, coarsest) = (PageId { level: 0, px: 2, py: 3 }, PageId { level: 3, px: 0, py: 0 });
    let store =
        MemPages::from_bytes("bad.hop", &damaged(&area, &[fine, coarsest])).unwrap().trusting(COARSER);
    assert!(store.has(fine) && !store.is_damaged(fine) && store.damaged().is_empty(), "nothing was touched");
    for _ in 0..2 {
        assert!(store.page(fine).unwrap().is_none());
        assert!(store.page(coarsest).unwrap_err().to_string().contains("level 64"));
    }
    assert!(!store.has(fine) && store.is_damaged(fine));
    assert_eq!(store.damaged(), [(fine, store.directory().get(fine).unwrap().offset)]);
}

/// Paths above ground read heights before any frame is rendered.
#[test]
fn ground_is_that_of_the_level_that_stands_in() {
    let area = area();
    let bad = damaged(&area, &[PageId { level: 0, px: 1, py: 1 }]);
    let ground = |bytes: &[u8]| {
        let store = MemPages::from_bytes("area.hop", bytes).unwrap().trusting(COARSER);
        ground_height(&store, DVec2::new(800.0, 700.0)).unwrap().unwrap()
    };
    let (found, expected) = (ground(&bad), ground(&area));
    assert!(found != expected && (found - expected).abs() < 6.0, "{found}, {expected}");
}

#[test]
fn without_checks_wrong_samples_are_read_and_wrong_shapes_refused() {
    let area = area();
    let never = Trust { verify: Verify::Never, ..Trust::default() };
    let id = PageId { level: 0, px: 1, py: 2 };
    let store = MemPages::from_bytes("bad.hop", &damaged(&area, &[id])).unwrap().trusting(never);
    assert!(store.page(id).unwrap().is_some());
    let offset = store.directory().get(id).unwrap().offset as usize;
    let mut shapeless = area;
    shapeless[offset] ^= 1;
    let store = MemPages::from_bytes("bad.hop", &shapeless).unwrap().trusting(never);
    assert!(store.page(id).unwrap_err().to_string().contains("says that it is level index"));
}

/// Numbers that break arithmetic, as far as a float or an integer can be one.
const HOSTILE: [f64; 9] =
    [0.0, -1.0, 1.0e300, -1.0e300, 1.0e-300, 4_294_967_295.0, 1.0e9, f64::NAN, f64::INFINITY];

/// Fields of the fixed header that FORMAT.md gives a numeric type: where each begins, and the type.
fn numeric_fields() -> Vec<(String, usize, String)> {
    let text = include_str!("../../src/voxel/FORMAT.md");
    let section = text.split("\n## ").find(|part| part.starts_with("Fixed header")).unwrap();
    let cells = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let rows = section.lines().map(cells).filter(|cells| cells.len() > 5);
    rows.filter(|cells| ["u32", "u64", "f64"].contains(&cells[4].as_str()))
        .map(|cells| (cells[3].clone(), cells[1].parse().unwrap(), cells[4].clone()))
        .collect()
}

/// Bytes of a header's field that holds a number, as far as its type can.
fn as_type(value: f64, kind: &str) -> Vec<u8> {
    match kind {
        "u32" => (value as u32).to_le_bytes().to_vec(),
        "u64" => (value as u64).to_le_bytes().to_vec(),
        _ => value.to_le_bytes().to_vec(),
    }
}

fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let covered = [&bytes[VERSION..HEADER_CRC], &bytes[HEADER_CRC + 4..HEADER_END]].concat();
    put(&mut bytes, HEADER_CRC, crc32fast::hash(&covered));
    bytes
}

/// The file with other metadata, and everything that depends on it.
fn with_metadata(area: &[u8], metadata: &serde_json::Value) -> Vec<u8> {
    const OFFSET: usize = 136;
    const CRC: usize = 156;
    const FILE_LENGTH: usize = 160;
    let start = u64::from_le_bytes(area[OFFSET..][..8].try_into().unwrap()) as usize;
    let json = serde_json::to_vec(metadata).unwrap();
    let mut bytes = [&area[..start], &json].concat();
    let length = bytes.len() as u64;
    bytes[OFFSET + 8..][..8].copy_from_slice(&(json.len() as u64).to_le_bytes());
    bytes[FILE_LENGTH..][..8].copy_from_slice(&length.to_le_bytes());
    put(&mut bytes, CRC, crc32fast::hash(&json));
    sealed(bytes)
}

/// Paths of all numbers in a document.
fn numbers(value: &serde_json::Value, path: &str) -> Vec<String> {
    match value {
        serde_json::Value::Number(_) => vec![path.to_owned()],
        serde_json::Value::Array(items) => (0..)
            .zip(items)
            .flat_map(|(at, item): (usize, _)| numbers(item, &format!("{path}/{at}")))
            .collect(),
        serde_json::Value::Object(fields) => {
            fields.iter().flat_map(|(name, field)| numbers(field, &format!("{path}/{name}"))).collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn numbers_that_no_build_writes_are_refused_or_do_no_harm() {
    use hedgehop::voxel::{CorridorRecord, MaterialRecord, build_in_memory};

    let grid = Grid { nx: 300, ny: 280, spacing: 8.0, origin: DVec2::ZERO };
    let heights: Vec<f64> = (0..300 * 280).map(|post| 50.0 + f64::from(post % 37)).collect();
    let metadata = Metadata {
        crs_epsg: Some(32633),
        corridors: vec![CorridorRecord { route: "a.csv".into(), width: 100.0, spacing: 8.0 }],
        materials: vec![MaterialRecord { number: 3, name: "mud".into(), ..MaterialRecord::default() }],
        baked_sun: Some([120.0, 30.0]),
        ..Metadata::default()
    };

    let store = build_in_memory(grid, &heights, &vec![[90; 3]; heights.len()], None, &metadata).unwrap();
    let sound = store.bytes().to_vec();

    let mut forged = Vec::new();
    for (name, at, kind) in numeric_fields() {
        for value in HOSTILE {
            let mut bytes = sound.clone();
            let wrong = as_type(value, &kind);
            bytes[at..at + wrong.len()].copy_from_slice(&wrong);
            forged.push((
                format!("{name} {value}"),
                if name == "`header_crc`" { bytes } else { sealed(bytes) },
            ));
        }
    }

    let json = serde_json::to_value(&metadata).unwrap();
    let paths = numbers(&json, "");
    assert!(paths.len() >= 10, "{paths:?}");
    for (path, value) in paths.iter().flat_map(|path| HOSTILE.map(|value| (path, value))) {
        let mut json = json.clone();
        let number = if value.fract() == 0.0 && value.abs() < 1e15 {
            serde_json::json!(value as i64)
        } else {
            serde_json::json!(value)
        };
        *json.pointer_mut(path).unwrap() = number;
        forged.push((format!("{path} {value}"), with_metadata(&sound, &json)));
    }

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("forged.hop");
    let (mut refused, mut seen) = (0, 0);
    for (what, bytes) in forged {
        fs::write(&path, &bytes).unwrap();
        if let Err(error) = PageFile::open_trusting(&path, Trust::default()) {
            assert!(error.to_string().starts_with(&path.display().to_string()), "{what}: {error}");
            refused += 1;
            continue;
        }
        for engine in [Engine::Planes, Engine::Reference] {
            let frame = small_frame(&path, engine);
            assert!(frame.range.iter().all(|range| !range.is_nan()), "{what}");
        }
        seen += 1;
    }

    assert!(refused > 150 && seen > 20, "{refused} refused, {seen} seen");
}

fn small_frame(path: &Path, engine: Engine) -> Frame {
    let pages = ResidentPages::new(PageFile::open_trusting(path, Trust::default()).unwrap(), None);
    let options = RenderOptions { engine, ..RenderOptions::default() };
    let attitude = Attitude { yaw: 40.0, pitch: -8.0, roll: 3.0 };
    let camera = Camera::new(Pose { eye: DVec3::new(500.0, 450.0, 190.0), attitude, hfov: 60.0 }, 32, 18);
    Renderer::new(&pages, &options).frame(&camera, &Farm::new(1).unwrap()).unwrap().frame
}
