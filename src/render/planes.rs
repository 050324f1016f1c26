//! A frame through scan planes: march, then the image stage.

use std::sync::Mutex;
use std::sync::PoisonError;
use std::time::{Duration, Instant};

use glam::DVec3;

use super::{Rendered, Renderer, StageTimes};
use crate::error::Result;
use crate::frame::stage::{Air, Band, Cell, Painter, Planes, Rows, Scale, Sums};
use crate::frame::{Atmosphere, Frame, Picture};
use crate::raymarch::PageCursor;
use crate::raymarch::scan::{Field, Outlook, PlaneMarch, Profile, Strides, Upright};
use crate::sensor::radiance::{LineSampler, RadiancePages};
use crate::simd::{LANES, Sixteen};
use crate::space::Camera;
use crate::subimage::{Farm, Stage, TaskSize};
use crate::voxel::{Header, PageSource};

/// Planes of a march task, and rows of an image task, unless told otherwise: fewer cost up to a quarter of their stage, more
/// leave workers idle at the end of a frame.
const SUITABLE: TaskSize = TaskSize { lines: 64, rows: 36 };

/// Level whose surface the height above ground is counted from.
const COARSE_LEVEL: u8 = 3;

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

/// What planes saw, before it is taken to a screen.
#[derive(Debug, Default)]
pub struct Fan {
    cells: Vec<Cell>,
    inverse: Vec<Sixteen>,
}

/// Memory that no frame in flight uses any more, for the next: what is new must be cleared by the system page by page.
#[derive(Debug, Default)]
pub struct Used<T>(Mutex<Vec<T>>);

impl<T: Default> Used<T> {
    fn take(&self) -> T {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub fn give_back(&self, memory: T) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(memory);
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
    // All of it is overwritten.
    let mut rgb = renderer.pictures.take();
    rgb.resize(width as usize * height as usize * 3, 0);
    let band = band_rows(farm) * width as usize * 3;
    let bands = rgb.chunks_mut(band).map(Band::Picture).collect();
    let times = render(renderer, view, farm, bands, false)?;
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
    let times = render(renderer, view, farm, bands, true)?;
    super::surface::describe(renderer, &mut frame, farm)?;
    Ok(Rendered { frame, times })
}

/// Frames hold light as it is, pictures what a display shows.
fn scale(with_range: bool) -> Scale {
    if with_range { Scale::ALL } else { Scale::DISPLAY }
}

/// Rows of an image task.
fn band_rows(farm: &Farm) -> usize {
    farm.task_size_or(SUITABLE).rows.max(1) as usize
}

/// Has planes look, then fills `bands` of [`band_rows`] rows.
fn render<S: PageSource>(
    renderer: &Renderer<'_, S>,
    view: &View<'_>,
    farm: &Farm,
    bands: Vec<Band<'_>>,
    with_range: bool,
) -> Result<StageTimes> {
    let (marching, shading, imaging) = (Clock::default(), Clock::default(), Clock::default());
    renderer.radiance.begin_frame();
    renderer.turned.begin_frame();
    let size = view.upright.groups() * view.upright.size[1];
    // What a frame before left in it is overwritten, or not looked at.
    let mut fan = renderer.fans.take();
    fan.cells.resize(size, Cell::default());
    fan.inverse.resize(if with_range { size } else { 0 }, Sixteen::default());
    see(renderer, view, farm, [&marching, &shading], &mut fan)?;
    let scale = scale(with_range);
    let planes = Planes { upright: &view.upright, cells: &fan.cells, scale, inverse: &fan.inverse };
    let (rows, width) = (band_rows(farm), view.camera.width as usize);
    farm.each(Stage::Image, bands, |index, band| {
        imaging.time(|| {
            band.fill(renderer.isa, planes, width, index * rows);
            Ok(())
        })
    })?;
    renderer.fans.give_back(fan);
    Ok(StageTimes { march: marching.total(), shade: shading.total(), image: imaging.total() })
}

/// Height of the eye above the ground about it, metres: of a coarse level, since it is not to change with every stone; above the lowest
/// ground beside the area.
fn height_above_ground<S: PageSource>(source: &S, eye: DVec3) -> Result<f64> {
    let header = source.header();
    let level = COARSE_LEVEL.min(header.level_count - 1);
    let is_over = eye.x >= 0.0
        && eye.y >= 0.0
        && eye.x <= f64::from(header.grid.nx)
        && eye.y <= f64::from(header.grid.ny);
    let ground = if is_over { PageCursor::new(source).smooth_height(level, eye.truncate())? } else { None };
    Ok((eye.z - ground.unwrap_or(header.height_range.0)).max(0.0))
}

/// What groups of planes see, `[group][row]`.
fn see<S: PageSource>(
    renderer: &Renderer<'_, S>,
    view: &View<'_>,
    farm: &Farm,
    [marching, shading]: [&Clock; 2],
    Fan { cells, inverse }: &mut Fan,
) -> Result<()> {
    let header = renderer.source.header();
    let above_ground = height_above_ground(renderer.source, view.eye)?;
    let angle = view.camera.pixel_angle();
    let outlook =
        Outlook { pixel_angle: angle, clearance: view.eye.z - header.height_range.1, height: above_ground };
    let strides = Strides::new(&header.grid, header.level_count, outlook, renderer.options.detail);
    let (edges, centres) = (view.upright.edges(), view.upright.centres());
    let per_row: Vec<f32> = edges.windows(2).map(|edge| 1.0 / (edge[1] - edge[0])).collect();
    let fineness = per_row.iter().fold(0.0_f32, |a, &b| a.max(b));
    let height = view.upright.size[1];
    let per_task = (farm.task_size_or(SUITABLE).lines as usize / LANES).max(1);
    let bend = renderer.options.curvature.inverse_diameter;
    let atmosphere = Atmosphere::new(renderer.options.visibility, header.height_range.0);
    // Without ranges there are as many chunks of nothing.
    let with_range = !inverse.is_empty();
    let mut inverse = inverse.chunks_mut(per_task * height);
    let tasks = cells.chunks_mut(per_task * height).map(|cells| (cells, inverse.next().unwrap_or_default()));
    farm.each(Stage::March, tasks.collect(), |task, (cells, inverse)| {
        let mut march = PlaneMarch::new(renderer.source, &renderer.turned, strides.clone());
        let mut painter = Painter {
            sampler: LineSampler::new(RadiancePages::new(renderer.source, &renderer.radiance)),
            air: Air::new(&atmosphere, view.eye.z),
            eye: view.eye,
            pixel_angle: angle,
            spacing: header.grid.spacing,
            height: above_ground,
        };
        let (mut profile, mut lights, mut sums) = (Profile::default(), Vec::new(), Sums::new());
        for (index, cells) in cells.chunks_mut(height).enumerate() {
            let inverse = if with_range { &mut inverse[index * height..][..height] } else { &mut [] };
            let index = task * per_task + index;
            let rows = view.upright.rows(index);
            if rows.is_empty() {
                continue;
            }
            let group = view.upright.group(index, &header.grid, view.eye, bend);
            let squares = view.upright.squares(index);
            let field = Field { tangents: [edges[rows.start], edges[rows.end]], fineness };
            marching.time(|| march.see(renderer.isa, view.eye, &group, field, &mut profile))?;
            shading.time(|| {
                painter.paint(renderer.isa, &group, &profile, &squares, &mut lights)?;
                let rows = Rows {
                    edges: &edges[rows.start..=rows.end],
                    centres: &centres[rows.clone()],
                    per_row: &per_row[rows.clone()],
                    cells: &mut cells[rows.clone()],
                    scale: scale(with_range),
                    inverse: if with_range { &mut inverse[rows] } else { inverse },
                };
                rows.fill(renderer.isa, &profile, &lights, &painter.air, &squares, &mut sums);
                Result::Ok(())
            })?;
        }
        Ok(())
    })
}
