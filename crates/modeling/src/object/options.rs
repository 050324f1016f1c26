//! Options of objects: what is to stand where.

use std::path::PathBuf;

use super::built_in::BuiltIn;
use super::soup::Stance;
use hedgehop::voxel::Material;

/// Models that stand on the ground, all of them at each of some places.
#[derive(Debug, Clone, Default)]
pub struct ObjectFile {
    /// The files: glTF, OBJ or MagicaVoxel. They share their origin.
    pub paths: Vec<PathBuf>,
    /// Places on which it stands: metres of the database's system.
    pub places: Vec<[f64; 2]>,
    /// Stance of the object.
    pub stance: Stance,
    /// Height of its foot above the ground, metres.
    pub up_m: f64,
    /// Material of all of it.
    pub material: Material,
}

/// Form that is scattered.
#[derive(Debug, Clone, PartialEq)]
pub enum ScatterForm {
    /// A file: glTF, OBJ or MagicaVoxel.
    File(PathBuf),
    /// One of those that need none.
    BuiltIn(BuiltIn),
}

/// The same forms at many places, by chance.
#[derive(Debug, Clone)]
pub struct ScatterFile {
    /// Forms, one of them at each place.
    pub forms: Vec<ScatterForm>,
    /// Material of those of files; built-in ones have materials of their own.
    pub material: Material,
    /// Stance of the objects; headings are by chance, of eight ways to lay them over voxels.
    pub stance: Stance,
    /// A file of polygons that they keep to.
    pub area: Option<PathBuf>,
    /// Reference system of that file, if it states none.
    pub crs: Option<String>,
    /// West, south, east, north that they keep to, metres of the database's system.
    pub bbox: Option<[f64; 4]>,
    /// Mean distance, metres, > 0.
    pub spacing_m: f64,
    /// Least and greatest factor of their size, > 0.
    pub scale: [f64; 2],
    /// Seed that picks one scatter among all alike.
    pub seed: u64,
    /// Only where the ground is so high, metres.
    pub heights_m: Option<[f64; 2]>,
    /// Only where the ground is so steep, degrees.
    pub slopes_deg: Option<[f64; 2]>,
    /// Only where the ground is made of one of these, or of what is like one; empty: of anything.
    pub grounds: Vec<Material>,
    /// Not where features stand or lie.
    pub avoid: bool,
}

impl ScatterFile {
    /// The files that it is read from.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        let forms = self.forms.iter().filter_map(|form| match form {
            ScatterForm::File(path) => Some(path),
            ScatterForm::BuiltIn(_) => None,
        });
        forms.chain(&self.area)
    }
}

impl Default for ScatterFile {
    fn default() -> Self {
        Self {
            forms: Vec::new(),
            material: Material::Unknown,
            stance: Stance::default(),
            area: None,
            crs: None,
            bbox: None,
            spacing_m: 10.0,
            scale: [1.0; 2],
            seed: 0,
            heights_m: None,
            slopes_deg: None,
            grounds: Vec::new(),
            avoid: true,
        }
    }
}
