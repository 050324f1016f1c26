//! Files of objects and scatters, opened.

use std::path::Path;

use super::built_in::BuiltIn;
use super::options::{ObjectFile, ScatterFile, ScatterForm};
use super::shape::Shape;
use super::soup::{Soup, Stance};
use crate::features::{self, Footprint, Layer, LayerOptions};
use crate::naming::file_name;
use hedgehop::voxel::{Grid, Material, SharedObject};
use hedgehop_assets::model::{self, Model};
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Crs, Transform};

/// Metres of a voxel of MagicaVoxel at scale 1.
const VOXEL_M: f64 = 0.1;

/// Scales between the least and the greatest of a scatter.
const SCALES: usize = 4;

/// An object whose files were read.
#[derive(Debug)]
pub(crate) struct OpenObject {
    pub(super) file: ObjectFile,
    pub(super) soup: Soup,
    /// Hash of all bytes that it was read from.
    pub(super) content: [u8; 32],
    /// Notes on what of it is not shown; for messages.
    pub notes: Vec<String>,
}

/// A form of a scatter at one scale.
#[derive(Debug)]
pub(super) struct Scaled {
    pub soup: Soup,
    /// Material of the form.
    pub material: Material,
    /// Built-in form, with its scale, if no file says.
    pub built_in: Option<(BuiltIn, f64)>,
}

/// A scatter whose files were read.
#[derive(Debug)]
pub(crate) struct OpenScatter {
    pub(super) file: ScatterFile,
    /// Each form at each of its scales.
    pub(super) forms: Vec<Vec<Scaled>>,
    pub(super) content: [u8; 32],
    /// The polygons that it keeps to.
    pub area: Option<Layer>,
    /// Notes on what of it is not shown; for messages.
    pub notes: Vec<String>,
}

impl OpenObject {
    /// Refuses a model that is too large for the voxels of a grid.
    pub fn fits(&self, grid: &Grid) -> Result<()> {
        Shape::check(&self.soup, grid.spacing).map_err(|what| Error::invalid(&self.file.paths[0], what))
    }
}

impl OpenScatter {
    /// Refuses a form that is too wide for the voxels of a grid: each one of it would have spans of its own.
    pub fn fits(&self, grid: &Grid) -> Result<()> {
        let most = SharedObject::MOST_VOXELS;
        let wide = |form: &Scaled| {
            let [low, high] = form.soup.corners;
            ((high - low).truncate().max_element() / grid.spacing).ceil() + 2.0
        };
        match self.forms.iter().flatten().map(wide).find(|wide| *wide > f64::from(most)) {
            None => Ok(()),
            Some(wide) => Err(Error::Configuration(format!(
                "a form of a scatter is {wide:.0} voxels wide, but {most} at most can be placed many times; make `scale` smaller or \
                 `spacing_m` of the place larger, or place it by an [[object]] table"
            ))),
        }
    }

    /// Returns the areas that it keeps to, in the database's system; `None`: everything.
    pub fn areas(&self, crs: &Crs) -> Result<Option<Vec<Footprint>>> {
        let Some(layer) = &self.area else { return Ok(None) };
        let transform = Transform::new(&layer.crs, crs)?;
        let placed = layer.rows.iter().filter_map(|row| row.geometry.transformed(&transform));
        let areas: Vec<Footprint> =
            placed.flat_map(|geometry| geometry.areas).filter_map(|area| Footprint::of(&area)).collect();
        if areas.is_empty() {
            return Err(Error::invalid(&layer.path, format!("has no place in {}", crs.name())));
        }
        Ok(Some(areas))
    }
}

/// Models of which a soup is made, all with one stance.
fn soup(models: &[&Model], paths: &[&Path], stance: &Stance) -> Result<Soup> {
    let is_vox = |path: &&&Path| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("vox"));
    let voxels = paths.iter().filter(is_vox).count();
    if voxels > 0 && voxels < paths.len() {
        let what =
            "a unit of it is a voxel, and of the files beside it a metre; give it an [[object]] of its own";
        return Err(Error::invalid(paths.iter().find(is_vox).unwrap_or(&paths[0]), what));
    }
    let stance = Stance { scale: stance.scale * if voxels > 0 { VOXEL_M } else { 1.0 }, ..*stance };
    Soup::of(models, &stance).map_err(|what| Error::invalid(paths[0], what))
}

/// Notes of a model, after its file's name.
fn named(path: &Path, model: &Model) -> Vec<String> {
    model.notes.iter().map(|note| format!("{}: {note}", file_name(path))).collect()
}

/// Reads an object's files.
pub(crate) fn open_object(file: &ObjectFile) -> Result<OpenObject> {
    let mut hasher = blake3::Hasher::new();
    let read = file.paths.iter().map(|path| model::read(path, &mut hasher)).collect::<Result<Vec<_>>>()?;
    if read.is_empty() {
        return Err(Error::Configuration("an object has no file".to_owned()));
    }
    let notes = file.paths.iter().zip(&read).flat_map(|(path, read)| named(path, &read.model)).collect();
    let models: Vec<&Model> = read.iter().map(|read| &read.model).collect();
    let paths: Vec<&Path> = file.paths.iter().map(|path| path.as_path()).collect();
    let soup = soup(&models, &paths, &file.stance)?;
    Ok(OpenObject { file: file.clone(), soup, content: *hasher.finalize().as_bytes(), notes })
}

/// Reads a scatter's files.
pub(crate) fn open_scatter(file: &ScatterFile) -> Result<OpenScatter> {
    let mut hasher = blake3::Hasher::new();
    let mut notes = Vec::new();
    let scales: Vec<f64> = match file.scale {
        [low, high] if low == high => vec![low],
        [low, high] => {
            (0..SCALES).map(|step| low + (high - low) * (step as f64 + 0.5) / SCALES as f64).collect()
        }
    };
    let mut forms = Vec::new();

    for form in &file.forms {
        let of_form = match form {
            ScatterForm::BuiltIn(form) => {
                hasher.update(format!("{form:?}").as_bytes());
                let at = |scale: &f64| {
                    let built_in = Some((*form, *scale));
                    Ok(Scaled { soup: form.soup(*scale), material: form.material(), built_in })
                };
                scales.iter().map(at).collect()
            }
            ScatterForm::File(path) => {
                let read = model::read(path, &mut hasher)?;
                notes.extend(named(path, &read.model));
                let at = |scale: &f64| {
                    let stance = Stance { scale: file.stance.scale * scale, ..file.stance };
                    let soup = soup(&[&read.model], &[path], &stance)?;
                    Ok(Scaled { soup, material: file.material, built_in: None })
                };
                scales.iter().map(at).collect::<Result<Vec<_>>>()
            }
        };

        forms.push(of_form?);
    }

    let options = LayerOptions { crs: file.crs.clone(), ..LayerOptions::default() };
    let area = file.area.as_ref().map(|path| features::read(path, &options)).transpose()?;
    if let Some(area) = &area {
        if area.rows.iter().all(|row| row.geometry.areas.is_empty()) {
            return Err(Error::invalid(
                &area.path,
                "has no polygons; those that a scatter keeps to are areas",
            ));
        }
        notes.extend(area.notes.iter().cloned());
        hasher.update(format!("{:?} {:?}", area.crs.name(), area.rows).as_bytes());
    }

    Ok(OpenScatter { file: file.clone(), forms, content: *hasher.finalize().as_bytes(), area, notes })
}
