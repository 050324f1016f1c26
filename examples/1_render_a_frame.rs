//! A database and an eye → a picture.
//!
//!     cargo run --release -- demo
//!     cargo run --release --example 1_render_a_frame
//!     cargo run --release --example 1_render_a_frame -- AREA.hop EAST NORTH HEIGHT YAW view.png
//!
//! East, north and height are metres in the database's reference system, yaw is degrees clockwise from north.

#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::path::Path;

use glam::DVec3;

use hedgehop::encode::{FrameInfo, write_frame};
use hedgehop::memory::PageFile;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let text = |index: usize, default: &'static str| arguments.get(index).map_or(default, String::as_str);
    let number = |index: usize, default: &'static str| text(index, default).parse::<f64>();

    // Opening reads the header and the directory; pages are mapped, and checked when they are first touched.
    let database = Path::new(text(0, "hedgehop-demo/valley.hop"));
    let area = PageFile::open(database)?;

    // Where the eye is, how it is turned, and the screen before it.
    let eye = DVec3::new(number(1, "613290")?, number(2, "5241620")?, number(3, "980")?);
    let attitude = Attitude { yaw: number(4, "35")?, pitch: -5.0, roll: 0.0 };
    let camera = Camera::new(Pose { eye, attitude, hfov: 65.0 }, 960, 540);

    // One frame on all cores. Any number of workers gives the same bits.
    let farm = Farm::new(std::thread::available_parallelism()?.get())?;
    let rendered = render_frame(&area, &camera, &RenderOptions::default(), &farm)?;
    let (times, frame) = (rendered.account.times, rendered.frame);
    let nearest = frame.range.iter().copied().fold(f32::INFINITY, f32::min);
    println!("march {:?}, shade {:?}, image stage {:?}", times.march, times.shade, times.image);
    println!("the nearest ground in view is {nearest:.1} m away");

    // The extension chooses PNG or EXR; what made the frame is written into the file.
    let header = area.header();
    let info = FrameInfo {
        frame: 1,
        seconds: 0.0,
        database_hash: header.content_hash.to_string(),
        database_file: database.display().to_string(),
        crs_name: header.metadata.crs_name.clone(),
        vertical_datum: header.metadata.vertical_datum.clone(),
        settings_digest: String::new(),
        writer: "example 1".into(),
    };

    let picture = Path::new(text(5, "hedgehop-demo/example-1.png"));
    let written = write_frame(picture, &frame, &info)?;
    println!("wrote {}, {} bytes", picture.display(), written.bytes);

    Ok(())
}
