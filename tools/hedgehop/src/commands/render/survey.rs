//! Frames of a render and their loads, as known before any of them is rendered.

use super::flags::RenderArgs;
use super::request::{FrameRequest, bind, render_options};
use crate::bound_flight::BoundFlight;
use crate::farm::cost::FrameLoad;
use crate::progress::Reporter;
use hedgehop::Result;
use hedgehop::memory::{FrameNeeds, PageFile, PagePlan};
use hedgehop::render::{FlightPlan, NumberedCamera, Renderer};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;

/// Columns and rows of rays that tell how much of a picture is ground.
const COLUMNS: u32 = 24;
const ROWS: u32 = 16;
const MIB: f64 = 1_048_576.0;

/// Frames of a render.
#[derive(Debug)]
pub struct Survey {
    /// Numbers of the frames, rising.
    pub numbers: Vec<u64>,
    /// Load of each.
    pub loads: Vec<FrameLoad>,
}

/// Returns the frames that `args` asks for, after all checks that need no frame.
///
/// # Errors
/// Whatever `render` refuses before its first frame.
pub fn survey(args: &RenderArgs, file: &PageFile, reporter: &Reporter) -> Result<Survey> {
    let request = FrameRequest::read(args, reporter)?;
    let flight = bind(args, &request, None, file, reporter)?;
    let options = render_options(args, request.scene.as_ref(), file.header(), &flight.motion, reporter)?;
    let renderer = Renderer::new(file, &options).with_isa(args.instructions.isa());

    let side = request.finish.antialias.max(1);
    let cameras: Vec<_> = flight
        .cameras
        .iter()
        .map(|frame| NumberedCamera { camera: frame.camera.enlarged(side), ..frame.clone() })
        .collect();
    let farm = Farm::new(1)?;
    let planner = FlightPlan::new(&renderer, &farm, &cameras);
    let plan = PagePlan::new(file, cameras.len() as u32, &planner, reporter)?;

    Ok(Survey {
        numbers: cameras.iter().map(|frame| frame.number).collect(),
        loads: cameras.iter().zip(&plan.frames).map(|(frame, needs)| load(frame, needs, &flight)).collect(),
    })
}

fn load(frame: &NumberedCamera, needs: &FrameNeeds, flight: &BoundFlight) -> FrameLoad {
    let bodies = flight.playing.as_ref().map_or(0, |playing| playing.scenery(frame.number).bodies.len());
    FrameLoad {
        mrays: ground_mrays(&frame.camera),
        pages: needs.pages as f64,
        bodies: bodies as f64,
        mib: needs.bytes as f64 / MIB,
        new_mib: needs.first_bytes as f64 / MIB,
    }
}

/// Returns how many millions of a picture's rays go below the horizontal.
pub fn ground_mrays(camera: &Camera) -> f64 {
    let [width, height] = [f64::from(camera.width), f64::from(camera.height)];
    let at = |number: u32, count: u32, length: f64| (f64::from(number) + 0.5) / f64::from(count) * length;
    let rays = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (column, row)));
    let down = rays.filter(|&(column, row)| {
        let ray = camera.ray(at(column, COLUMNS, width), at(row, ROWS, height));
        ray.is_some_and(|ray| ray.direction.z < 0.0)
    });
    width * height / 1e6 * down.count() as f64 / f64::from(COLUMNS * ROWS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hedgehop::space::{Attitude, Pose};

    #[test]
    fn rays_to_the_sky_are_not_counted() {
        let looking = |pitch| {
            let attitude = Attitude { yaw: 30.0, pitch, roll: 0.0 };
            ground_mrays(&Camera::new(Pose { eye: glam::DVec3::Z * 100.0, attitude, hfov: 60.0 }, 1000, 1000))
        };
        assert_eq!((looking(-90.0), looking(90.0)), (1.0, 0.0));
        assert!((looking(0.0) - 0.5).abs() < 0.04, "{}", looking(0.0));
    }
}
