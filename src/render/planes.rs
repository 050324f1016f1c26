//! A frame through scan planes: march, then the image stage.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::{Rendered, Renderer, StageTimes};
use crate::error::Result;
use crate::frame::stage::{Band, ImageStage};
use crate::frame::{Atmosphere, Frame, Picture};
use crate::raymarch::scan::{PlaneMarch, Rows, Strides, Upright};
use crate::simd::{LANES, Sixteen};
use crate::space::Camera;
use crate::subimage::{Farm, Stage};
use crate::voxel::{Header, PageSource};

/// What planes need to know of a view.
pub struct View<'c> {
    camera: &'c Camera,
    upright: Upright,
    /// The eye: units, units, metres.
    eye: DVec3,
}

impl<'c> View<'c> {
    /// `None`: planes do not serve this camera.
    pub fn new(header: &Header, camera: &'c Camera) -> Option<Self> {
        let upright = Upright::new(camera)?;
        let eye = camera.pose.eye;
        let ground = (eye.truncate() - header.grid.origin) / header.grid.spacing;
        Some(Self { camera, upright, eye: ground.extend(eye.z) })
    }
}

/// Time that tasks took, added up by all workers.
#[derive(Default)]
struct Clock(Mutex<Duration>);

impl Clock {
    fn time<T>(&self, work: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let result = work();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += begun.elapsed();
        result
    }

    fn total(self) -> Duration {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Renders an 8-bit picture.
pub fn picture<S: PageSource>(
    renderer: &Renderer<'_, S>,
    view: &View<'_>,
    farm: &Farm,
) -> Result<(Picture, StageTimes)> {
    let (width, height) = (view.camera.width, view.camera.height);
    let mut rgb = vec![0; width as usize * height as usize * 3];
    let band = band_rows(farm) * width as usize * 3;
    let bands = rgb.chunks_mut(band).map(Band::Picture).collect();
    let times = render(renderer, view, farm, bands)?;
    Ok((Picture { width, height, rgb }, times))
}

/// Renders a frame with all its planes.
pub fn frame<S: PageSource>(renderer: &Renderer<'_, S>, view: &View<'_>, farm: &Farm) -> Result<Rendered> {
    let mut frame = Frame::sky(view.camera.clone());
    let width = view.camera.width as usize;
    let band = band_rows(farm) * width;
    let bands = frame
        .colour
        .chunks_mut(band)
        .zip(frame.range.chunks_mut(band))
        .map(|(colour, range)| Band::Frame { colour, range })
        .collect();
    let times = render(renderer, view, farm, bands)?;
    super::surface::describe(renderer, &mut frame, farm)?;
    Ok(Rendered { frame, times })
}

/// Rows of an image task.
fn band_rows(farm: &Farm) -> usize {
    farm.task_size().rows.max(1) as usize
}

/// Marches, then fills `bands` of [`band_rows`] rows.
fn render<S: PageSource>(
    renderer: &Renderer<'_, S>,
    view: &View<'_>,
    farm: &Farm,
    bands: Vec<Band<'_>>,
) -> Result<StageTimes> {
    let (marching, shading) = (Clock::default(), Clock::default());
    renderer.radiance.begin_frame();
    let inverse = march(renderer, view, farm, &marching)?;
    let header = renderer.source.header();
    let atmosphere = Atmosphere::new(renderer.options.visibility, header.height_range.0);
    let stage = ImageStage {
        source: renderer.source,
        radiance: &renderer.radiance,
        upright: &view.upright,
        inverse: &inverse,
        atmosphere: &atmosphere,
        eye: view.eye,
        width: view.camera.width as usize,
        pixel_angle: view.camera.pixel_angle(),
    };
    let rows = band_rows(farm);
    farm.each(Stage::Image, bands, |index, band| {
        shading.time(|| stage.fill(renderer.isa, index * rows, band))
    })?;
    Ok(StageTimes { march: marching.total(), shade: shading.total(), image: Duration::ZERO })
}

/// Inverse depth, `[group][row][lane]`.
fn march<S: PageSource>(
    renderer: &Renderer<'_, S>,
    view: &View<'_>,
    farm: &Farm,
    clock: &Clock,
) -> Result<Vec<Sixteen>> {
    let header = renderer.source.header();
    let clearance = view.eye.z - header.height_range.1;
    let angle = view.camera.pixel_angle();
    let strides = Strides::new(&header.grid, header.level_count, angle, clearance, renderer.options.detail);
    let tangents = view.upright.tangents();
    let height = view.upright.size[1];
    let mut inverse = vec![Sixteen::default(); view.upright.groups() * height];
    let per_task = (farm.task_size().lines as usize / LANES).max(1);
    let bend = renderer.options.curvature.inverse_diameter;
    farm.each(Stage::March, inverse.chunks_mut(per_task * height).collect(), |task, groups| {
        clock.time(|| {
            let mut march = PlaneMarch::new(renderer.source, strides.clone());
            let mut open = Vec::with_capacity(height + 1);
            for (index, inverse) in groups.chunks_mut(height).enumerate() {
                let index = task * per_task + index;
                let rows = view.upright.rows(index);
                open.clear();
                open.extend_from_slice(&tangents[rows.clone()]);
                open.push(f32::INFINITY);
                let group = view.upright.group(index, &header.grid, view.eye, bend);
                inverse[..rows.start].fill(Sixteen::default());
                inverse[rows.end..].fill(Sixteen::default());
                let rows = Rows { tangents: &open, inverse: &mut inverse[rows] };
                march.fill(renderer.isa, view.eye, &group, rows)?;
            }
            Ok(())
        })
    })?;
    Ok(inverse)
}
