//! Models of dynamic objects: fitted into bodies, and cut into parts that move.
//!
//! ```text
//! file ──hedgehop_assets::model──▶ Model in its own axes ──cut──▶ Mesh in a body's axes, and of each node that moves in its own
//! ```

mod fit;
mod nodes;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::scene::model::fit::Knife;

pub(crate) use fit::{Fit, Origin, Rest, Size};
use hedgehop_assets::model::{MOST_TRIANGLES, Read, read};
use hedgehop_base::error::{Error, Result};
pub(crate) use nodes::NodeSplit;

/// Triangles of all models of a scene.
const MOST_OF_SCENE: usize = 4 * MOST_TRIANGLES;

/// Models of a scene, each of which is read once.
#[derive(Debug, Default)]
pub(super) struct Models {
    read: BTreeMap<PathBuf, Arc<Read>>,
    fitted: Vec<(PathBuf, Fit, Knife, Arc<NodeSplit>)>,
    triangles: usize,
}

/// A model for an object.
#[derive(Debug)]
pub(super) struct Fitted {
    pub cut: Arc<NodeSplit>,
    /// All files that it was read from.
    pub files: Vec<PathBuf>,
    /// Parts that are not shown, as clauses.
    pub notes: Vec<String>,
}

impl Models {
    /// The model in a file, of which `nodes` are cut off; what is read goes into `hasher`. `None` among the nodes is cut off nothing. They
    /// move in the axes `rests`, or, if there are none, in their own.
    ///
    /// # Errors
    /// [`Error::Io`] of files that cannot be read, [`Error::Invalid`] and [`Error::Unsupported`] of what is in them.
    pub fn get(
        &mut self,
        path: &Path,
        fit: &Fit,
        nodes: &[Option<&str>],
        rests: &[Rest],
        hasher: &mut blake3::Hasher,
    ) -> Result<Fitted> {
        let read = match self.read.get(path) {
            Some(read) => read.clone(),
            None => {
                let read = Arc::new(read(path, hasher)?);
                self.read.insert(path.to_owned(), read.clone());
                read
            }
        };

        let nodes = nodes.iter().map(|node| node.map(str::to_owned)).collect();
        let knife = Knife { nodes, rests: rests.to_vec() };
        let known =
            self.fitted.iter().find(|(known, its, by, _)| known == path && its == fit && *by == knife);

        let cut = match known {
            Some((.., cut)) => cut.clone(),
            None => {
                let wrong = |what: String| Error::invalid(path, what);
                let cut = Arc::new(NodeSplit::new(&read.model, fit, &knife).map_err(wrong)?);
                self.triangles += cut.triangle_count();
                if self.triangles > MOST_OF_SCENE {
                    return Err(wrong(format!(
                        "with it the models of the scene have {} triangles, more than the {MOST_OF_SCENE} that fit; models of one size and \
                         turn are counted once",
                        self.triangles
                    )));
                }

                self.fitted.push((path.to_owned(), *fit, knife, cut.clone()));
                cut
            }
        };

        Ok(Fitted { cut, files: read.files.clone(), notes: read.model.notes.clone() })
    }
}
