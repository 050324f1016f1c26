//! A path file → a trajectory → frames.
//!
//!     cargo run --release -- demo
//!     cargo run --release --example 3_fly_a_path
//!     cargo run --release --example 3_fly_a_path -- AREA.hop TRACK

#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::path::PathBuf;

use glam::DVec2;

use hedgehop::encode::{FrameInfo, write_frame};
use hedgehop::flight::{BindOptions, ReadOptions, Trajectory, read_track};
use hedgehop::geo::Crs;
use hedgehop::memory::PageFile;
use hedgehop::raymarch::ground_height;
use hedgehop::render::{RenderOptions, render_frame};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;

/// A frame every four seconds of flight.
const FRAMES_PER_SECOND: f64 = 0.25;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let argument = |index: usize, default: &str| std::env::args_os().nth(index).unwrap_or(default.into());
    let database = PathBuf::from(argument(1, "hedgehop-demo/valley.hop"));
    let area = PageFile::open(&database)?;
    let metadata = &area.header().metadata;

    // What the file says: CSV, JSBSim CSV, KML, GPX or IGC.
    let path = PathBuf::from(argument(2, "hedgehop-demo/valley-path.csv"));
    let track = read_track(&path, &ReadOptions::default())?;
    println!("{}: {}, {} fixes", track.path.display(), track.format, track.fixes.len());

    // Bound to the area: its reference system, its ground, and the attitude that follows from the motion.
    let crs = Crs::from_record(&metadata.crs_name, metadata.crs_epsg, metadata.crs_proj.as_deref())?;
    let ground = |place: DVec2| ground_height(&area, place).ok().flatten();
    let options = BindOptions { hfov: 65.0, clearance: Some(15.0), ..BindOptions::default() };
    let trajectory = Trajectory::bind(&track, &crs, &ground, &options)?;
    track.notes.iter().chain(trajectory.notes()).for_each(|note| println!("note: {note}"));

    let farm = Farm::new(std::thread::available_parallelism()?.get())?;
    for frame in 1..=trajectory.frame_count(FRAMES_PER_SECOND) {
        let seconds = (frame - 1) as f64 / FRAMES_PER_SECOND;
        let pose = trajectory.pose_at(seconds);
        let rendered = render_frame(&area, &Camera::new(pose, 480, 270), &RenderOptions::default(), &farm)?;

        let info = FrameInfo {
            frame,
            seconds,
            database_hash: area.header().content_hash.to_string(),
            database_file: database.display().to_string(),
            crs_name: metadata.crs_name.clone(),
            vertical_datum: metadata.vertical_datum.clone(),
            settings_digest: String::new(),
            writer: "example 3".into(),
        };

        let file = PathBuf::from(format!("hedgehop-demo/example-3/{frame:04}.png"));
        write_frame(&file, &rendered.frame, &info)?;
        println!("{}: yaw {:.0}, roll {:.0}", file.display(), pose.attitude.yaw, pose.attitude.roll);
    }

    Ok(())
}
