//! Everything that can be done with a database, with any bytes for one: it may be refused, but nothing may panic or hang.

use glam::DVec3;

use hedgehop::progress::Silent;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Damaged, HeightRange, MemPages, PageSource, Trust, Verify, verify};

/// Offsets of FORMAT.md, bytes.
const MAGIC: [u8; 8] = *b"\x89HOP\r\n\x1a\n";
const VERSION: usize = 8;
const HEADER_CRC: usize = 12;
const DIRECTORY_OFFSET: usize = 120;
const DIRECTORY_LENGTH: usize = 128;
const METADATA_OFFSET: usize = 136;
const METADATA_LENGTH: usize = 144;
const DIRECTORY_CRC: usize = 152;
const METADATA_CRC: usize = 156;
const FILE_LENGTH: usize = 160;
/// Newest version of the format that is read.
const FORMAT: u32 = 9;
const HEADER: usize = 256;
const ENTRY: usize = 44;

/// Does all of it with the bytes as they are, and with all checksums made right, so that what lies behind them is met too.
pub fn exercise(bytes: &[u8]) {
    read(bytes);
    if bytes.len() >= HEADER {
        let mut sealed = bytes.to_vec();
        seal(&mut sealed);
        read(&sealed);
    }
}

fn u64_at(bytes: &[u8], offset: usize) -> u64 {
    u64::from_le_bytes(bytes[offset..offset + 8].try_into().expect("eight bytes"))
}

fn put(bytes: &mut [u8], offset: usize, value: &[u8]) {
    bytes[offset..offset + value.len()].copy_from_slice(value);
}

/// A part of the file that the header or the directory names, as far as there is one.
fn part(bytes: &[u8], offset: u64, length: u64) -> std::ops::Range<usize> {
    let within = |place: u64| usize::try_from(place).unwrap_or(bytes.len()).min(bytes.len());
    within(offset)..within(offset.saturating_add(length))
}

/// Where the parts of a page end, as far as its header tells.
fn parts(page: &[u8]) -> [usize; 3] {
    let number =
        |at: usize| page.get(at..at + 4).map_or(0, |n| u32::from_le_bytes(n.try_into().expect("four")));
    let [level, width, height] = [0, 12, 16].map(|at| u64::from(number(at)));
    let plane = |from: u64, samples: u64| {
        from.saturating_add(samples.saturating_mul(2)).checked_next_multiple_of(64).unwrap_or(u64::MAX)
    };
    let heights = plane(64, (width + 12).saturating_mul(height + 12));
    let voxels = if level > 0 { width * height } else { 0 };
    let bounds = plane(plane(heights, voxels), voxels);
    let within = |end: u64| usize::try_from(end).unwrap_or(page.len()).min(page.len());
    [within(heights), within(bounds), page.len()]
}

/// Makes magic, version, length and all checksums right.
pub fn seal(bytes: &mut [u8]) {
    put(bytes, 0, &MAGIC);
    put(bytes, VERSION, &FORMAT.to_le_bytes());
    put(bytes, FILE_LENGTH, &(bytes.len() as u64).to_le_bytes());
    let directory = part(bytes, u64_at(bytes, DIRECTORY_OFFSET), u64_at(bytes, DIRECTORY_LENGTH));

    for start in directory.clone().step_by(ENTRY) {
        if start + ENTRY <= directory.end {
            let length = u32::from_le_bytes(bytes[start + 8..start + 12].try_into().expect("four bytes"));
            let page = part(bytes, u64_at(bytes, start), u64::from(length));
            let ends = parts(&bytes[page.clone()]);
            let starts = [0, ends[0], ends[1]];
            for (number, (from, to)) in starts.into_iter().zip(ends).enumerate().filter(|_| length > 0) {
                let crc = crc32fast::hash(&bytes[page.start + from..page.start + to]);
                put(bytes, start + 16 + 4 * number, &crc.to_le_bytes());
            }
        }
    }

    let crc = crc32fast::hash(&bytes[directory]);
    put(bytes, DIRECTORY_CRC, &crc.to_le_bytes());
    let metadata = part(bytes, u64_at(bytes, METADATA_OFFSET), u64_at(bytes, METADATA_LENGTH));
    let crc = crc32fast::hash(&bytes[metadata]);
    put(bytes, METADATA_CRC, &crc.to_le_bytes());
    let covered = [&bytes[VERSION..HEADER_CRC], &bytes[HEADER_CRC + 4..HEADER]].concat();
    let crc = crc32fast::hash(&covered);
    put(bytes, HEADER_CRC, &crc.to_le_bytes());
}

fn read(bytes: &[u8]) {
    let Ok(pages) = MemPages::from_bytes("fuzz.hop", bytes) else { return };
    verify(&pages, &Silent).expect("problems are listed");
    for id in pages.directory().ids() {
        // Refused or read.
        let _ = pages.whole_page(id).map(|view| view.map(|view| view.to_buffer()));
    }
    for trust in [
        Trust { verify: Verify::FirstTouch, damaged: Damaged::Coarser },
        Trust { verify: Verify::Never, damaged: Damaged::Fail },
    ] {
        let Ok(pages) = MemPages::from_bytes("fuzz.hop", bytes) else { return };
        render(&pages.trusting(trust));
    }
}

/// Small pictures from above the middle, level and steeply down; refused or rendered.
fn render(pages: &MemPages) {
    let header = pages.header();
    let HeightRange { low, high } = header.height_range;
    let side = header.grid.spacing * f64::from(header.grid.nx.min(header.grid.ny));
    let middle = header.grid.origin + 0.4 * side;
    let eye = DVec3::new(middle.x, middle.y, high + 0.1 * side.min(1e6) + 0.1 * (high - low));
    let farm = Farm::new(1).expect("a farm");
    for (engine, pitch) in [(Engine::Planes, -5.0), (Engine::Planes, -70.0), (Engine::Reference, -20.0)] {
        let attitude = Attitude { yaw: 30.0, pitch, roll: 3.0 };
        let camera = Camera::new(Pose { eye, attitude, hfov: 60.0 }, 16, 9);
        let options = RenderOptions { engine, ..RenderOptions::default() };
        let _ = Renderer::new(pages, &options).frame(&camera, &farm);
    }
}
