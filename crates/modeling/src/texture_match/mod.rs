//! Patterns below the voxel that are matched from imagery finer than it.
//!
//! ```text
//! fine imagery    examples that the recipe names, or else the build's own    ground
//! windows         its light over what voxels of it would show                window
//! classes         quarters of all ground, by how rough voxels say it is      classes
//! patterns        patches of a class, quilted; octaves that imagery lacks, as strong as the finest that it has
//! ```
//!
//! Texture by example after Efros and Freeman 2001 (*Image quilting for texture synthesis and transfer*).

mod classes;
mod ground;
mod window;

use crate::budget::Budget;
use crate::options::BuildOptions;
use crate::plan::Plan;
use crate::synthetic::TextureExamples;
use classes::matched;
use ground::FineGround;
use hedgehop_base::error::{Error, Result};
use hedgehop_texture::MatchedPattern;
use window::{FineWindow, WINDOW_VOXELS};

/// Finds the patterns of a build that asks for them.
///
/// # Errors
/// Imagery cannot be read, none of it is finer than half a voxel, or there is too little.
pub(super) fn find(
    examples: &TextureExamples,
    plan: &Plan,
    options: &BuildOptions,
    budget: &Budget,
) -> Result<MatchedPattern> {
    let grounds = FineGround::all(examples, plan, options, budget)?;
    let finest = grounds.iter().map(|ground| ground.octaves).fold(0.0, f64::max);

    let mut windows: Vec<FineWindow> = Vec::new();
    for ground in grounds {
        windows.extend(ground.windows(budget.window)?);
    }
    matched(windows, finest, examples.seed)?.ok_or_else(|| {
        let of = if examples.files.is_empty() { "the imagery" } else { "examples" };
        Error::Configuration(format!(
            "[detail.imagery] pattern = \"match\": {of} have no area of {WINDOW_VOXELS} by {WINDOW_VOXELS} voxels \
             of {} m without gaps and with more than one brightness; name larger pictures as examples, or write pattern = \"broad\"",
            plan.grid.spacing
        ))
    })
}
