//! Faults of files, each by itself and in the database.

use super::bare::canvas;
use super::land_cover::LandCoverFile;
use super::options::{BuildOptions, FeatureFile, ImageryFile};
use super::{object, plan};
use crate::Input;
use crate::inputs::{CACHE_TO_LOOK, Inputs, Opener, layer};
use crate::raster::OpenOptions;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Silent;

/// Finds the faults of each file by itself, or else with its place in the database: all of them, where a build ends at the first.
pub fn faults(options: &BuildOptions) -> Vec<(Input, Error)> {
    let open_options = OpenOptions { cache_bytes: CACHE_TO_LOOK, ..OpenOptions::default() };
    let mut opener = Opener::new(options, open_options, &Silent);
    let (mut inputs, mut faults) = (Inputs::default(), Vec::new());
    let clouds = sound(&options.clouds, |file| opener.cloud(file), Input::Cloud, &mut faults);
    (inputs.clouds, inputs.elevation) = clouds.into_iter().unzip();
    let elevation = sound(&options.elevation, |file| opener.elevation(file), Input::Elevation, &mut faults);
    inputs.elevation.extend(elevation);
    let canvas = canvas(&inputs.elevation);
    let imagery = |file: &ImageryFile| opener.imagery(file, canvas.as_ref());
    inputs.imagery = sound(&options.imagery, imagery, Input::Imagery, &mut faults);
    let land_cover = |file: &LandCoverFile| opener.land_cover(file, canvas.as_ref());
    inputs.land_cover = sound(&options.land_cover, land_cover, Input::LandCover, &mut faults);
    let features = |file: &FeatureFile| layer(file, options);
    inputs.features = sound(&options.features, features, Input::Features, &mut faults);
    inputs.objects = sound(&options.objects, object::open_object, Input::Object, &mut faults);
    inputs.scatters = sound(&options.scatters, object::open_scatter, Input::Scatter, &mut faults);
    if faults.is_empty() { plan::misfits(&inputs, options) } else { faults }
}

/// Opens files, and adds what is wrong with those that cannot be opened to `faults`.
fn sound<F, T>(
    files: &[F],
    open: impl FnMut(&F) -> Result<T>,
    input: fn(usize) -> Input,
    faults: &mut Vec<(Input, Error)>,
) -> Vec<T> {
    let mut opened = Vec::with_capacity(files.len());
    for (index, result) in files.iter().map(open).enumerate() {
        match result {
            Ok(file) => opened.push(file),
            Err(error) => faults.push((input(index), error)),
        }
    }
    opened
}
