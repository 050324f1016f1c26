//! Procedural texture that is fixed to the ground: each value is a function of the place alone.
//!
//! ```text
//! Generator ── codes, ground maps, waves, sea ──▶ Cells, 255 × 255 ──▶ Tile: zero mean over each voxel
//!                                                                        └──▶ exact mean over any box, four looks
//! ```
//!
//! | files | hold |
//! |---|---|
//! | `polynomial`, `code` | polynomials over two elements; shift registers, at any place by a jump |
//! | `pattern`, `superimposed`, `subterrain`, `solid`, `sea` | codes over the ground: joined, added, slipped, in space, in time |
//! | `strand`, `levels` | exact means of a code over boxes, and over levels of voxels |
//! | `estimate`, `footprint`, `pixel_tone`, `projection`, `shades`, `window` | the study's way to a pixel's tone, beside the exact one |
//! | `maps` | linear functions, tables along six axes, waves, materials |
//! | `classes`, `bands` | classes of land, and how sensors see them |
//! | `study` | pictures, flights and settings of the study |
//! | `cells`, `octaves`, `tile`, `rounding`, `generator` | tiles, and what they are made of |
//! | `quilt`, `matched` | patterns quilted from fine imagery, by roughness |
//! | `fourier`, `micro_relief` | frequencies of patterns; relief that the sun lights |
//!
//! Sources: the study of cyclic codes for surface texture that the Air Force Human Resources Laboratory ran
//! on ACTES (author and year unknown to us), for codes, their averages and estimators; Bunker and Ferris 1977
//! (AFHRL-TR-77-66), for ground maps.

mod bands;
mod cell_box;
mod cells;
mod classes;
mod code;
mod estimate;
mod footprint;
mod fourier;
mod generator;
mod levels;
mod maps;
mod matched;
mod micro_relief;
mod octaves;
mod pattern;
mod pixel_tone;
mod polynomial;
mod projection;
mod quilt;
mod rounding;
mod sea;
mod shades;
mod solid;
mod strand;
mod study;
mod subterrain;
mod superimposed;
mod table_text;
mod tile;
mod window;

#[cfg(test)]
mod coherence_tests;
#[cfg(test)]
mod spectrum;

pub use bands::{BandTone, BandTones, SensorBand};
pub use cell_box::CellBox;
pub use cells::{Cells, SIDE};
pub use classes::{ClassTexture, TextureClass, TextureClasses};
pub use code::CyclicCode;
pub use estimate::{GroupEstimate, group_means};
pub use footprint::{Footprint, Slice, Stacking, TonalGroups};
pub use generator::Generator;
pub use levels::LevelTables;
pub use maps::{
    BoardFace, FaceAxes, LinearFunction, MapMaterial, QuantityMode, QuantityTexture, Sinusoid, SixMaps,
    TestBoard, ZoneTable,
};
pub use matched::{MAX_CLASSES, MatchedPattern, RoughnessClass};
pub use micro_relief::MicroRelief;
pub use octaves::{broad_band, octave, sharpened};
pub use pattern::{Direction, Strand, XorPattern};
pub use pixel_tone::{Averaging, PixelTones};
pub use polynomial::primitive_polynomials;
pub use projection::{GroundExtent, Projection};
pub use quilt::{PATCH_VOXELS, PatchPlace, Swatch, quilted};
pub use sea::Sea;
pub use shades::Shades;
pub use solid::SolidPattern;
pub use strand::{FixedBox, StrandMeans};
pub use study::{
    AircraftSettings, DatabaseSettings, DisplaySettings, Eye, EyeAttitude, GreyPicture, GroundQuad,
    GroundView, HalfPlane, Run, Runway, Screen, ScreenPoint, Settings, SimulatorSettings, StudyScene,
    TexturedTerrain,
};
pub use subterrain::{Subterrain, SubterrainCode};
pub use superimposed::Superimposed;
pub use tile::{CELLS_PER_VOXEL, Tile};
pub use window::{ToneErrors, Window};
