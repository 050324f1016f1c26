//! Fineness of imagery beside the voxels that keep its colours.

use super::cloud::Cloud;
use super::inputs::Inputs;
use super::options::BuildOptions;
use super::plan::Plan;
use super::warnings;
use crate::naming::file_name;
use hedgehop_base::error::Result;

/// Ratio of a pixel's and a voxel's width from which on it is worth a word.
const WORTH_A_WORD: f64 = 1.25;

/// Imagery beside voxels.
pub(super) struct Fineness {
    /// Side of the pixels of the finest imagery, metres, if voxels are finer.
    pub coarser_pixel: Option<f64>,
    /// Note of what is lost where imagery is finer, unless the user chose the voxels; of where colours are from, if there is no imagery.
    pub note: Option<String>,
}

/// Compares the finest imagery of a build with its voxels.
pub(super) fn of_imagery(inputs: &Inputs, plan: &Plan, options: &BuildOptions) -> Result<Fineness> {
    let mut finest: Option<(f64, String)> = None;
    for raster in &inputs.imagery {
        let is_elsewhere = warnings::misplaced_raster(raster, plan)?.is_some();
        let Some(side) = raster.pixel_side(&plan.crs)?.filter(|_| !is_elsewhere) else { continue };
        if finest.as_ref().is_none_or(|(least, _)| side < *least) {
            finest = Some((side, file_name(&raster.path)));
        }
    }

    let spacing = plan.grid.spacing;
    let Some((side, name)) = finest else {
        return Ok(Fineness { coarser_pixel: None, note: without_imagery(inputs, options) });
    };

    let is_chosen = options.spacing.is_some() || !options.corridors.is_empty();
    let is_finer = !is_chosen && side * WORTH_A_WORD < spacing;
    Ok(Fineness {
        coarser_pixel: (side > spacing * WORTH_A_WORD).then_some(side),
        note: is_finer.then(|| {
            format!(
                "{name}: its pixels of {} m are finer than the voxels of {} m that keep its colours; --spacing {} keeps all of it",
                short(side),
                short(spacing),
                short(side)
            )
        }),
    })
}

/// Says where colours are from instead, unless something else states them.
fn without_imagery(inputs: &Inputs, options: &BuildOptions) -> Option<String> {
    let has_colours = options.synthetic.has_colours() || inputs.clouds.iter().any(Cloud::is_coloured);
    let from = if options.land_cover.is_empty() { "height and slope" } else { "land cover" };
    let is_silent = options.imagery.is_empty() && !has_colours;
    is_silent.then(|| format!("no imagery: colours were derived from {from}"))
}

/// Writes a length with three significant digits, metres.
pub(super) fn short(metres: f64) -> String {
    let decimals = (2 - metres.abs().max(1e-6).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{metres:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn lengths_have_three_digits() {
        assert_eq!([126.7, 3.058, 0.25, 28.5, 1234.5].map(short), ["127", "3.06", "0.25", "28.5", "1234"]);
    }
}
