//! Poses of a flight's frames in formats of computer vision.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use hedgehop::earth::Curvature;
use hedgehop::encode::poses::PoseFormat;
use hedgehop::encode::sidecar::PosesRecord;
use hedgehop::frame::map_offset;
use hedgehop::voxel::Grid;

/// Flags of the files of poses besides `poses.csv`.
#[derive(Debug, Clone, Default, Args)]
pub struct PoseArgs {
    /// Poses in further files beside poses.csv, with commas between: transforms (transforms.json of nerfstudio and instant-ngp), colmap (a text model,
    /// sparse/0), tum (a trajectory, poses.tum)
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = formats())]
    pub poses: Vec<PoseFormat>,
}

/// Reads the name of a format.
fn formats() -> impl TypedValueParser<Value = PoseFormat> {
    let named = |name: String| PoseFormat::ALL.into_iter().find(|format| format.name() == name);
    PossibleValuesParser::new(PoseFormat::ALL.map(PoseFormat::name))
        .try_map(move |name| named(name).ok_or("no format of poses"))
}

impl PoseArgs {
    /// Returns the record of the files that were asked for, if any were; positions count from a point in the grid.
    pub fn record(&self, grid: &Grid) -> Option<PosesRecord> {
        let formats = self.poses.iter().copied().collect();
        let record = PosesRecord { formats, offset_m: map_offset(grid).to_array() };
        (!self.poses.is_empty()).then_some(record)
    }

    /// Says that poses alone do not explain pictures of a curved Earth, if such are told.
    pub fn note(&self, curvature: Curvature) -> Option<String> {
        let drop = |kilometres: f64| curvature.drop_at(1000.0 * kilometres);
        (!self.poses.is_empty() && curvature != Curvature::FLAT).then(|| {
            format!(
                "over the curved Earth ground appears lower than the map has it, by {:.2} m at 1 km and {:.1} m at 10 km, which --poses do not tell; \
                 --curvature off renders the map as it is",
                drop(1.0),
                drop(10.0)
            )
        })
    }
}
