//! Flags of labels: numbers of what pixels show, instead of pictures.

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use crate::scene::Playing;
use hedgehop::Result;
use hedgehop::encode::labels::{LabelKind, LabelTable};
use hedgehop::voxel::Metadata;

/// Flags of labels.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct LabelArgs {
    /// Labels of pixels in PNG instead of pictures, and palette.json beside them: semantic (materials, objects, sky; indexed), instance (objects of the
    /// scene one by one; 16 bits)
    #[arg(long, value_enum, value_name = "KIND")]
    pub labels: Option<LabelWord>,
}

/// Kinds of labels as users name them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LabelWord {
    /// Number of the material, 254 of objects, 255 of the sky
    Semantic,
    /// 0, or the number of the scene's object, counted from 1
    Instance,
}

/// Labels that are written, and their numbers.
#[derive(Debug)]
pub struct Labelling {
    /// Kind of labels.
    pub kind: LabelKind,
    /// Names of the numbers.
    pub table: LabelTable,
}

impl LabelArgs {
    /// Names the numbers of the labels that were asked for, if any were: over a database, of a scene's objects. `program` is name and version of the writer.
    ///
    /// # Errors
    /// Materials or objects whose numbers labels cannot hold.
    pub fn labelling(
        self,
        program: &str,
        metadata: &Metadata,
        playing: Option<&Playing>,
    ) -> Result<Option<Labelling>> {
        let labelling = |word| {
            let kind = match word {
                LabelWord::Semantic => LabelKind::Semantic,
                LabelWord::Instance => LabelKind::Instance,
            };
            let bodies = playing.map(Playing::names).unwrap_or_default();
            Ok(Labelling { kind, table: LabelTable::new(program, metadata, &bodies)? })
        };
        self.labels.map(labelling).transpose()
    }

    /// Records what files hold; pictures are not mentioned.
    pub fn record(self, settings: &mut Value) {
        match self.labels {
            Some(LabelWord::Semantic) => settings["labels"] = json!("semantic"),
            Some(LabelWord::Instance) => settings["labels"] = json!("instance"),
            None => {}
        }
    }
}
