//! Displacement of the ground that a camera sees.

use std::sync::Arc;

use super::above_ground::height_above_ground;
use super::limits::level_bands;
use super::options::RenderOptions;
use crate::detail::{DisplacedRelief, Displacement, DisplacementView};
use crate::raymarch::Surface;
use crate::space::{Camera, Footprint};
use crate::voxel::{Header, PageSource};
use hedgehop_base::error::Result;

/// Pixels along a voxel where displacement ends: it begins to fade at half of that distance.
const LEAST_PIXELS: f64 = 4.0;

/// Voxels beyond which there is none, however narrow pixels are: planes read samples between all lines up to there.
const FARTHEST: f64 = 512.0;

/// Finds the relief that displaces the ground of a database; `None`: the smooth surface is seen as it is, or the area repeats, which the relief does not.
///
/// # Errors
/// The pattern that the database asks for has nothing below the voxel.
pub(super) fn relief(header: &Header, options: &RenderOptions) -> Result<Option<DisplacedRelief>> {
    if options.surface == Surface::Blocks || options.tile_world {
        return Ok(None);
    }
    DisplacedRelief::of(header, options.detail_synthesis)
}

/// Finds the displacement that a camera sees; `None`: all ground is too far away for it, or rays are parallel.
///
/// # Errors
/// A page that is damaged.
pub(super) fn of_view(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    relief: &Arc<DisplacedRelief>,
) -> Result<Option<Displacement>> {
    let Footprint::Angle(pixel) = camera.footprint() else { return Ok(None) };
    let header = source.header();
    let grid = &header.grid;
    let eye = (camera.pose.eye.truncate() - grid.origin) / grid.spacing;
    let above = height_above_ground(source, eye.extend(camera.pose.eye.z))? / grid.spacing;

    // One sheet of the ground is displaced: the one that is seen near the eye.
    let bare_until = level_bands(header, camera, options).bare_until() / grid.spacing;
    let sheet_end = if bare_until > 0.0 { bare_until } else { f64::INFINITY };
    let end = options.detail.min(1.0) / (LEAST_PIXELS * pixel);
    let view = DisplacementView { eye, above, pixel, end: end.min(FARTHEST).min(sheet_end) };
    Ok(Displacement::new(relief.clone(), view))
}
