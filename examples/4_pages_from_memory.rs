//! A terrain from a formula, a database in memory, and a page source of one's own around it.
//!
//!     cargo run --release --example 4_pages_from_memory

#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec2, DVec3};
use hedgehop::colour::srgb8_picture;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{
    BoundsView, Grid, Header, MemPages, Metadata, PageId, PageSource, PageView, build_in_memory,
};

const SIDE: u32 = 1024;

/// Counts the look-ups of each level. A source may as well fetch or invent pages; where one is `None`, the next
/// coarser level stands in.
struct Counted {
    pages: MemPages,
    looks: Vec<AtomicU64>,
}

impl PageSource for Counted {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> hedgehop::Result<Option<PageView<'_>>> {
        self.looks[usize::from(id.level)].fetch_add(1, Ordering::Relaxed);
        self.pages.page(id)
    }

    fn bounds(&self, id: PageId) -> hedgehop::Result<Option<BoundsView<'_>>> {
        self.looks[usize::from(id.level)].fetch_add(1, Ordering::Relaxed);
        self.pages.bounds(id)
    }
}

/// Round hills, with contour lines every 20 m.
fn hills() -> hedgehop::Result<MemPages> {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 5.0, origin: DVec2::ZERO };
    let height = |x: f64, y: f64| 60.0 * (x / 45.0).sin() * (y / 60.0).cos() + 20.0 * (x / 13.0).sin();
    let colour = |h: &f64| if h.rem_euclid(20.0) < 2.0 { [70, 60, 40] } else { [110, 150, 70] };
    // Row 0 is the southernmost.
    let heights: Vec<f64> = (0..SIDE * SIDE).map(|i| height((i % SIDE).into(), (i / SIDE).into())).collect();
    let colours: Vec<[u8; 3]> = heights.iter().map(colour).collect();
    let metadata = Metadata { crs_name: "local".into(), ..Metadata::default() };
    build_in_memory(grid, &heights, &colours, None, &metadata)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pages = hills()?;
    let looks = (0..pages.header().level_count).map(|_| AtomicU64::new(0)).collect();
    let area = Counted { pages, looks };

    let attitude = Attitude { yaw: 30.0, pitch: -8.0, roll: 0.0 };
    let pose = Pose { eye: DVec3::new(1000.0, 300.0, 200.0), attitude, hfov: 60.0 };
    let farm = Farm::new(std::thread::available_parallelism()?.get())?;
    let rendered = render_frame(&area, &Camera::new(pose, 640, 360), &RenderOptions::default(), &farm)?;
    for (level, looks) in area.looks.iter().enumerate() {
        println!("level {:3}: {looks:?} look-ups", Grid::side_units(level as u8));
    }
    let rgb = srgb8_picture(&rendered.frame.colour);
    image::save_buffer("example-4.png", &rgb, 640, 360, image::ColorType::Rgb8)?;
    println!("wrote example-4.png");
    Ok(())
}
