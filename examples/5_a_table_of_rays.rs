//! A screen of one's own, as a table of rays: the stereographic "little planet", everything but a cone above the eye.
//!
//!     cargo run --release -- demo
//!     cargo run --release --example 5_a_table_of_rays
//!     hedgehop render hedgehop-demo/valley.hop --path hedgehop-demo/valley-path.csv --frames 1 \
//!         --screen table:hedgehop-demo/planet-rays.exr -o planet.png
//!
//! The same way leads to any mapping: projectors on a curved wall, a mirror under a dome, a lens that was measured.

#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use hedgehop::colour::srgb8_picture;
use hedgehop::encode::write_ray_table;
use hedgehop::memory::PageFile;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::space::{Attitude, Camera, Pose, RayTable, Screen};
use hedgehop::subimage::Farm;

/// Pixels of a side.
const SIDE: u32 = 600;
/// Distance from the picture's centre, half sides, at which the horizon lies.
const HORIZON: f64 = 0.45;

/// Directions in the axes of the view: x right, y up, z forward. The eye looks forward, so that its nadir is at −y.
fn little_planet() -> hedgehop::Result<RayTable> {
    let half = 0.5 * f64::from(SIDE);
    let pixels = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (column, row)));
    let directions = pixels.map(|(column, row)| {
        let (x, y) = (f64::from(column) + 0.5 - half, half - f64::from(row) - 0.5);
        let radius = x.hypot(y) / half;
        let from_nadir = 2.0 * (radius / HORIZON).atan();
        let level = from_nadir.sin();
        // Forward is at the top. Of any length: the table is told directions.
        [x / half / radius * level, -from_nadir.cos(), y / half / radius * level].map(|part| part as f32)
    });
    RayTable::new(SIDE, SIDE, directions.collect())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let table = little_planet()?;
    let file = Path::new("hedgehop-demo/planet-rays.exr");
    let written = write_ray_table(file, &table)?;
    println!("wrote {}, {} bytes", file.display(), written.bytes);

    // With the library, the table need not go through a file.
    let area = PageFile::open(Path::new("hedgehop-demo/valley.hop"))?;
    let eye = DVec3::new(613_290.0, 5_241_620.0, 980.0);
    let pose = Pose { eye, attitude: Attitude { yaw: 35.0, ..Attitude::default() }, hfov: 60.0 };
    let camera = Camera::with_screen(pose, Screen::Table(Arc::new(table)), SIDE, SIDE);
    let farm = Farm::new(std::thread::available_parallelism()?.get())?;
    let frame = render_frame(&area, &camera, &RenderOptions::default(), &farm)?.frame;
    let picture = "hedgehop-demo/example-5.png";
    image::save_buffer(picture, &srgb8_picture(&frame.colour), SIDE, SIDE, image::ColorType::Rgb8)?;
    println!("wrote {picture}");
    Ok(())
}
