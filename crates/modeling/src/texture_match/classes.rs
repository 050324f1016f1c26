//! Patterns of ground by how rough it is.

use super::window::FineWindow;
use hedgehop::detail::{MOST_DEVIATION, RoughPattern};
use hedgehop_base::error::Result;
use hedgehop_texture::{
    CELLS_PER_VOXEL, Cells, Generator, MAX_CLASSES, MatchedPattern, PATCH_VOXELS, PatchPlace, RoughnessClass,
    Swatch, octave, quilted, sharpened,
};

/// Least deviation of a pattern that is worth having.
const LEAST_DEVIATION: f64 = 1.0e-3;

/// Least and greatest change of light, relative to it, that a pattern makes on the roughest ground of its class: nothing is black.
const CHANGES: [f64; 2] = [-0.8, 2.0];

/// Matches patterns from windows of pictures that have so many octaves below the voxel; `None` where they have no window, or nothing in it.
///
/// # Errors
/// Patterns are none.
pub(super) fn matched(windows: Vec<FineWindow>, octaves: f64, seed: u64) -> Result<Option<MatchedPattern>> {
    let mut roughness: Vec<f32> = windows.iter().flat_map(|window| window.roughness()).copied().collect();
    if roughness.is_empty() {
        return Ok(None);
    }
    roughness.sort_unstable_by(f32::total_cmp);
    let bound = |class: usize| match class {
        0 => 0.0,
        MAX_CLASSES => f32::INFINITY,
        _ => roughness[class * roughness.len() / MAX_CLASSES],
    };

    let swatches: Vec<Swatch> = windows.iter().map(|window| window.swatch.clone()).collect();
    let mut patterns: Vec<RoughPattern> = Vec::new();
    for class in 0..MAX_CLASSES {
        let places = places(&windows, bound(class), bound(class + 1));
        let Some(cells) = quilted(&swatches, &places, seed.wrapping_add(class as u64)) else { continue };
        let asked = deviation(&windows, bound(class), bound(class + 1));
        if cells.deviation().min(asked) < LEAST_DEVIATION {
            continue;
        }
        // Patches that fit are calmer than others.
        let factor = asked / cells.deviation();
        let cells = cells.joined(&cells, |value, _| factor * value);
        let light = with_finer_octaves(sharpened(&cells, pixel_cells(octaves)), octaves, seed)?;
        // The first class reaches down to even ground.
        let least = if patterns.is_empty() { 0.0 } else { bound(class) };
        if patterns.last().is_none_or(|last| last.least < least) {
            patterns.push(RoughPattern { least, light });
        }
    }
    if patterns.is_empty() {
        return Ok(None);
    }

    // Each pattern lies on all ground up to where the next one begins.
    let mut classes = Vec::new();
    for (number, RoughPattern { least, light }) in patterns.iter().enumerate() {
        let roughest = patterns.get(number + 1).map_or(MOST_DEVIATION, |next| next.least.min(MOST_DEVIATION));
        let [darkest, brightest] = CHANGES.map(|change| change / f64::from(roughest));
        let light = light.joined(light, |value, _| value.clamp(darkest, brightest));
        classes.push(RoughnessClass::new(*least, &light));
    }
    MatchedPattern::new(classes).map(Some)
}

/// Deviation of a pattern for ground of relative deviations within bounds.
fn deviation(windows: &[FineWindow], least: f32, below: f32) -> f64 {
    let (mut changes, mut foretold) = (0.0, f64::MIN_POSITIVE);
    for window in windows {
        let energies = window.energies(least, below);
        changes += energies.changes;
        foretold += energies.foretold;
    }
    (changes / foretold).sqrt()
}

/// Places of patches whose mean relative deviation lies within bounds.
fn places(windows: &[FineWindow], least: f32, below: f32) -> Vec<PatchPlace> {
    let mut places = Vec::new();
    for (swatch, window) in windows.iter().enumerate() {
        let [columns, rows] = window.swatch.voxels().map(|voxels| voxels - PATCH_VOXELS);
        for voxel in (0..=rows).flat_map(|y| (0..=columns).map(move |x| [x, y])) {
            let roughness = window.roughness_of(voxel, PATCH_VOXELS);
            if least <= roughness && roughness < below {
                places.push(PatchPlace { swatch, voxel });
            }
        }
    }
    places
}

/// Adds the octaves that pixels of a picture are too wide for, each as strong as the finest one that it has.
fn with_finer_octaves(cells: Cells, octaves: f64, seed: u64) -> Result<Cells> {
    let missing = ((CELLS_PER_VOXEL as f64).log2() - octaves).round().max(0.0) as u32;
    if missing == 0 {
        return Ok(cells);
    }
    let strength = octave(&cells, pixel_cells(octaves)).deviation();
    let finer = Generator::Broad { octaves: missing }.cells(seed)?;
    Ok(cells.joined(&finer, |value, finer| value + strength * finer))
}

/// Cells along a pixel of pictures that have so many octaves below the voxel.
fn pixel_cells(octaves: f64) -> usize {
    (CELLS_PER_VOXEL as f64 / octaves.exp2()).round() as usize
}
