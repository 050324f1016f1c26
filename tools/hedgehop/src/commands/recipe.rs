//! `hedgehop recipe` and `hedgehop new`: recipes to build databases from.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Subcommand;

use crate::exit::{self, Failure, Outcome};
use crate::program::program;
use hedgehop::Error;
use hedgehop::encode::atomic::write_new_bytes;
use hedgehop_modeling::is_own_work;
use hedgehop_modeling::recipe::{Mistake, Recipe, TEMPLATE, in_keys};

const EXAMPLE: &str = "\
Examples:
  hedgehop new place.toml
  hedgehop recipe check place.toml
  hedgehop build place.toml";

/// Look into recipes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct RecipeArgs {
    #[command(subcommand)]
    command: RecipeCommand,
}

#[derive(Debug, Subcommand)]
enum RecipeCommand {
    /// Read a recipe and the heads of its files, and say what it builds, or all that is wrong with it, by line
    Check {
        /// Recipe to read
        #[arg(value_name = "PLACE.toml")]
        recipe: PathBuf,
    },
}

/// Write a recipe to begin with.
///
/// It has all keys, those that are not needed commented out.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct NewArgs {
    /// Recipe to write
    #[arg(value_name = "PLACE.toml", default_value = "place.toml")]
    recipe: PathBuf,
}

/// Runs `hedgehop new`.
pub fn create(args: &NewArgs) -> Outcome {
    let path = &args.recipe;
    write_new_bytes(path, TEMPLATE.as_bytes())?;
    let (file, me) = (path.display(), program());
    exit::print(&format!("wrote {file}; name your files in it, then: {me} recipe check {file}\n"))?;
    Ok(())
}

/// Runs `hedgehop recipe`.
pub fn run(args: &RecipeArgs) -> Outcome {
    let RecipeCommand::Check { recipe: path } = &args.command;
    let checked = Recipe::check(path)?.and_then(|recipe| {
        let outline = recipe.outline()?;
        Ok((recipe, outline))
    });
    let (recipe, outline) = match checked {
        Ok(sound) => sound,
        Err(mistakes) => return Err(told(path, &mistakes)),
    };
    let grid = outline.grid;
    let options = &recipe.options;
    let is_bare = options.features.is_empty()
        && options.clouds.is_empty()
        && options.objects.is_empty()
        && options.scatters.is_empty();

    let mut text = format!(
        "{} is sound: {} x {} voxels of {} m in {}, {:.1} MB at most{}, into {}\n",
        path.display(),
        grid.nx,
        grid.ny,
        grid.spacing,
        outline.crs.name(),
        outline.most_bytes as f64 / 1e6,
        if is_bare { "" } else { " without what stands on it" },
        recipe.options.output.display()
    );

    let output = &recipe.options.output;
    if output.exists() && !is_own_work(output) {
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "  {} exists, and no build of this recipe is known to have made it as it is: build it with --overwrite",
            output.display()
        );
    }

    for note in &outline.notes {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {}", in_keys(note));
    }

    Ok(exit::print(&text)?)
}

/// All mistakes, one to a line.
fn told(path: &std::path::Path, mistakes: &[Mistake]) -> Failure {
    let lines = mistakes.iter().map(|mistake| format!("\n  {mistake}"));
    let count = match mistakes.len() {
        1 => "a mistake".to_owned(),
        count => format!("{count} mistakes"),
    };
    Error::invalid(path, format!("has {count}:{}", lines.collect::<String>())).into()
}
