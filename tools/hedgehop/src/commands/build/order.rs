//! Order of a build, from the command line or a recipe.
//!
//! ```text
//! without shadows:  ──build──▶ AREA.hop
//! with shadows:     ──build──▶ AREA.without-shadows.hop ──bake──▶ AREA.hop
//! not any more:     ──build──▶ AREA.without-shadows.hop ──take over──▶ AREA.hop
//! ```

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use tempfile::TempDir;

use crate::area;
use hedgehop::memory::PageFile;
use hedgehop::progress::Observer;
use hedgehop::sunlight::SunSetting;
use hedgehop::voxel::PageSource;
use hedgehop::{Error, Result};
use hedgehop_modeling::recipe::Recipe;
use hedgehop_modeling::{
    Baked, Baking, BuildOptions, BuildReport, bake_shadows, build, check_name, check_output, check_shadows,
    forget_steps, is_kept_for, outline, take_over,
};

/// Order of a build.
pub struct Order {
    pub options: BuildOptions,
    /// The sun whose shadows go into the colours.
    shadows: Option<SunSetting>,
    /// Recipe that gives the order, if it is not the command line.
    recipe: Option<Recipe>,
}

impl Order {
    /// Builds the order that a command line gives.
    pub fn new(options: BuildOptions, shadows: Option<SunSetting>) -> Self {
        Self { options, shadows, recipe: None }
    }

    /// Builds the order that a recipe gives.
    pub fn of(recipe: &Path) -> Result<Self> {
        let recipe = Recipe::read(recipe)?;
        Ok(Self { options: recipe.options.clone(), shadows: recipe.shadows, recipe: Some(recipe) })
    }

    /// An error for who gave the order: of a recipe in its words, and with its line.
    pub fn told(&self, error: Error) -> Error {
        match &self.recipe {
            Some(recipe) => recipe.located(error),
            None => error,
        }
    }

    /// Refuses an output that no database can be.
    pub fn check_name(&self) -> Result<()> {
        self.recipe.as_ref().map_or(Ok(()), |recipe| recipe.check_output(&self.options.output))?;
        check_name(&self.options)
    }

    /// Forgets what builds before made.
    pub fn forget_steps(&self) {
        let output = &self.options.output;
        [output, &without_shadows(output)].into_iter().for_each(|database| forget_steps(database));
    }

    /// Builds it.
    pub fn fill(&self, observer: &dyn Observer) -> Result<BuildReport> {
        let Some(sun) = self.shadows else { return self.fill_without_shadows(observer) };
        let BuildOptions { output, overwrite, threads, steps, .. } = &self.options;
        let begun = Instant::now();
        check_output(&self.options)?;
        self.check_sun(sun)?;

        // Where steps are kept, so is what shadows are baked into: the next build changes that, and bakes what changed.
        let aside = if *steps { Aside::kept(output)? } else { Aside::temporary(output)? };
        let kept_for = steps.then(|| output.clone());
        let options =
            BuildOptions { output: aside.path(), overwrite: *steps, kept_for, ..self.options.clone() };
        let report = build(&options, observer)?;
        let source = built(&options.output, &report)?;
        let sun = area::sky(sun, source.header())?.sun;

        let baking = Baking {
            source: &source,
            directory: source.directory(),
            sun,
            output,
            overwrite: *overwrite,
            steps: *steps,
            threads: *threads,
        };

        let Baked { content_hash, bytes, pages, reused } = bake_shadows(&baking, observer)?;
        let seconds = begun.elapsed().as_secs_f64();
        Ok(BuildReport { content_hash, bytes, pages, reused, seconds, ..report })
    }

    /// Builds what has no shadows. What is kept of builds that had them becomes the output.
    fn fill_without_shadows(&self, observer: &dyn Observer) -> Result<BuildReport> {
        let output = &self.options.output;
        let kept = without_shadows(output);
        if !self.takes_over(&kept) {
            let report = build(&self.options, observer)?;
            if self.options.steps && is_kept_for(&kept, output) {
                let kept = kept.display();
                observer.note(&format!(
                    "{kept} is of builds with shadows, which this one has not; delete it and {kept}.steps, unless another recipe builds it"
                ));
            }
            return Ok(report);
        }

        check_output(&self.options)?;
        let kept_for = Some(output.clone());
        let options =
            BuildOptions { output: kept.clone(), overwrite: true, kept_for, ..self.options.clone() };
        let report = build(&options, observer)?;
        built(&kept, &report)?;

        // Somebody may have put something there meanwhile.
        check_output(&self.options)?;
        take_over(&kept, output)?;

        Ok(report)
    }

    /// Whether the output is to come of what builds with shadows kept at a place: there is something, and the output is of such a build, or not there.
    fn takes_over(&self, kept: &Path) -> bool {
        let BuildOptions { output, overwrite, steps, .. } = &self.options;
        let has_shadows =
            || PageFile::open(output).is_ok_and(|file| file.header().metadata.baked_sun.is_some());
        *steps
            && is_kept_for(kept, output)
            && (fs::symlink_metadata(output).is_err() || *overwrite && has_shadows())
    }

    /// Refuses a sun that throws no shadows before the database that they are to lie in is made.
    fn check_sun(&self, sun: SunSetting) -> Result<()> {
        if let SunSetting::At(sun) = sun {
            return check_shadows(sun);
        }
        // Elevation says where the place is.
        let bare = BuildOptions {
            imagery: Vec::new(),
            land_cover: Vec::new(),
            features: Vec::new(),
            objects: Vec::new(),
            scatters: Vec::new(),
            ..self.options.clone()
        };
        let place = outline(&bare)?;
        let middle = 0.5 * (place.grid.origin + place.grid.far_corner());
        check_shadows(sun.over(&place.crs, middle)?.sun)
    }
}

/// Opens what a build has made, if it is there still.
fn built(output: &Path, report: &BuildReport) -> Result<PageFile> {
    let source = PageFile::open(output)?;
    if source.header().content_hash == report.content_hash {
        return Ok(source);
    }
    let path = output.display();
    Err(Error::Configuration(format!("another build changed {path} meanwhile; repeat the command")))
}

/// Place of a database without shadows while, or as long as, another one has them.
enum Aside {
    /// Beside the output, for the builds to come.
    Kept(PathBuf),
    /// Folder that is removed with it.
    Temporary(TempDir),
}

impl Aside {
    /// Prepares a file that is kept. A file that lies there is replaced if a build left it for this output, and only then.
    fn kept(output: &Path) -> Result<Self> {
        let path = without_shadows(output);
        // A link that leads nowhere is somebody's, too.
        if fs::symlink_metadata(&path).is_ok() && !is_kept_for(&path, output) {
            let path = path.display();
            let what = format!(
                "{path} is in the way: a build with shadows keeps the database without them there; move it elsewhere, or delete it if a build left it"
            );
            return Err(Error::Configuration(what));
        }
        Ok(Self::Kept(path))
    }

    fn temporary(output: &Path) -> Result<Self> {
        let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
        // Named as what else a kill leaves behind.
        let mut prefix = output.file_name().unwrap_or_default().to_owned();
        prefix.push(".part-");
        let folder = tempfile::Builder::new().prefix(&prefix).tempdir_in(folder.unwrap_or(Path::new(".")));
        folder.map(Self::Temporary).map_err(|error| Error::io(output, "create a folder beside it", error))
    }

    fn path(&self) -> PathBuf {
        match self {
            Self::Kept(path) => path.clone(),
            Self::Temporary(folder) => folder.path().join("without-shadows.hop"),
        }
    }
}

/// Returns where builds that keep their steps have the database without shadows of one that has them.
fn without_shadows(output: &Path) -> PathBuf {
    const ENDING: &str = "without-shadows.hop";
    if output.extension().is_some_and(|extension| extension == "hop") {
        return output.with_extension(ENDING);
    }
    // Names that differ in their ending only are of different databases.
    let mut name = output.as_os_str().to_owned();
    name.push(".");
    name.push(ENDING);
    name.into()
}
