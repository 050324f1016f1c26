//! Exact picture of the database: level 1 at any distance, one ray at a time, with the renderer's own light and air.
//!
//! ```text
//! sample(column, row) = exact contact with level 1 → light of its posts, bilinear → haze, or sky
//! one sample          = sample at the pixel's centre
//! truth               = mean radiance over n × n samples, one at random in each cell of the pixel
//! ```
//!
//! The mean is that of a box filter over the pixel, in linear light. The samples' places are a hash of their index.

use std::ops::Range;

use glam::Vec3;

use crate::posts::PostLight;
use crate::random::pair_of;
use hedgehop::Result;
use hedgehop::raymarch::{GridRay, LevelBands, Marcher};
use hedgehop::render::RenderOptions;
use hedgehop::sensor::VisualSensor;
use hedgehop::sensor::radiance::Radiance;
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::{Grid, PageSource};
use hedgehop::weather::Atmosphere;

/// Colour and range of some columns of a view of level 1, `[height][columns]`, row 0 at the top.
#[derive(Debug, Clone)]
pub struct ExactView {
    /// Linear Rec. 709 radiance, 1 = display white.
    pub colour: Vec<[f32; 3]>,
    /// Range at the last sample of the pixel, metres; infinite where that one sees the sky.
    pub range: Vec<f32>,
}

/// Sees level 1 in single directions.
pub struct ExactEye<'a> {
    marcher: Marcher<'a>,
    light: PostLight<'a>,
    atmosphere: Atmosphere,
    grid: Grid,
    camera: &'a Camera,
}

impl<'a> ExactEye<'a> {
    /// At the pose of `camera`, over ground that sends `radiance`.
    pub fn new(
        source: &'a dyn PageSource,
        radiance: &'a Radiance,
        camera: &'a Camera,
        options: &RenderOptions,
    ) -> Self {
        let header = source.header();
        Self {
            marcher: Marcher::new(source, LevelBands::finest_only(), options.surface),
            light: PostLight::new(source, radiance),
            atmosphere: options.atmosphere(header),
            grid: header.grid,
            camera,
        }
    }

    /// Range in metres at a position on the screen in pixels; infinite for the sky.
    pub fn range(&mut self, column: f64, row: f64) -> Result<f64> {
        let ray = GridRay::new(&self.grid, self.camera.pose.eye, self.camera.direction(column, row));
        Ok(self.marcher.first_contact(&ray, 0.0)?.map_or(f64::INFINITY, |contact| contact.range))
    }

    /// Radiance and range (metres, infinite for the sky) at a position on the screen in pixels.
    pub fn sample(&mut self, column: f64, row: f64) -> Result<(Vec3, f64)> {
        let direction = self.camera.direction(column, row);
        let (eye, toward) = (self.camera.pose.eye, direction.as_vec3());
        let ray = GridRay::new(&self.grid, eye, direction);
        let Some(contact) = self.marcher.first_contact(&ray, 0.0)? else {
            return Ok((self.atmosphere.sky(eye.z, toward), f64::INFINITY));
        };
        let radiance = self.light.at(ray.at(contact.range).truncate())?;
        Ok((self.atmosphere.haze(radiance, eye.z, toward, contact.range as f32), contact.range))
    }
}

/// Columns of the view with one sample at the centre of each pixel.
pub fn one_sample(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    columns: Range<u32>,
    farm: &Farm,
) -> Result<ExactView> {
    view(source, camera, options, columns, farm, |eye, column, row| {
        eye.sample(f64::from(column) + 0.5, f64::from(row) + 0.5)
    })
}

/// Columns of the view with `side` × `side` samples in each pixel.
pub fn supersampled(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    columns: Range<u32>,
    farm: &Farm,
    side: u32,
) -> Result<ExactView> {
    let per_pixel = u64::from(side * side);
    view(source, camera, options, columns, farm, |eye, column, row| {
        let first = (u64::from(row) * u64::from(camera.width) + u64::from(column)) * per_pixel;
        let (mut sum, mut range) = (Vec3::ZERO, f64::INFINITY);
        for index in 0..side * side {
            let [across, down] = pair_of(first + u64::from(index));
            let at = |pixel: u32, cell: u32, within| {
                f64::from(pixel) + (f64::from(cell) + within) / f64::from(side)
            };
            let (colour, seen) = eye.sample(at(column, index % side, across), at(row, index / side, down))?;
            sum += colour;
            range = seen;
        }
        Ok((sum / per_pixel as f32, range))
    })
}

/// Every pixel of `columns` by `sample`, which is given the eye, the column and the row.
fn view(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    columns: Range<u32>,
    farm: &Farm,
    sample: impl Fn(&mut ExactEye<'_>, u32, u32) -> Result<(Vec3, f64)> + Sync + Send,
) -> Result<ExactView> {
    let radiance = Radiance::new(VisualSensor::new(options.sun));
    let columns: Vec<Vec<(Vec3, f64)>> = farm
        .render(columns.len() as u32, |subimage| {
            let mut eye = ExactEye::new(source, &radiance, camera, options);
            let first = columns.start + subimage.first_column;
            (first..first + subimage.columns)
                .map(|column| (0..camera.height).map(|row| sample(&mut eye, column, row)).collect())
                .collect::<Result<Vec<_>>>()
        })?
        .concat();
    let pixels = (0..camera.height as usize).flat_map(|row| columns.iter().map(move |column| column[row]));
    let (colour, range) = pixels.map(|(colour, range)| (colour.to_array(), range as f32)).unzip();
    Ok(ExactView { colour, range })
}
