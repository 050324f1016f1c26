//! Ellipses and spheres on a screen in closed form, ways of drawing their edges, and tones of faces.
//!
//! ```text
//! FlatEllipse, Ball, Ellipsoid, Cylinder ──ViewFrame──▶ seen from an eye ──Raster──▶ ImageConic: extrema, crossings of scan lines
//!                                                                   ├──▶ CellOverlap: exact shares of pixels
//!                                                                   ├──▶ LineEdges: edges of eight points a scan line
//!                                                                   └──▶ distance_share: by distance from the outline
//! faces ──ToneLaw──▶ flat, gradient and curvature shading; SurfaceTone: tones painted for one eye
//! ```
//!
//! After Bunker and Ferris, *Computer Image Generation: Imagery Improvement: Circles, Contours, and Texture*, AFHRL-TR-77-66,
//! General Electric, 1977. Sections are those of that report. The renderer draws by rays; pictures are held against this.

mod cylinder;
mod distance;
mod edge_budget;
mod edges;
mod ellipsoid;
mod feature;
mod frame;
mod image;
mod overlap;
mod quadratic;
mod shadow;
mod surface_tone;
mod tone;

#[cfg(test)]
mod quality_tests;

pub use cylinder::{Cylinder, CylinderColour};
pub use distance::{distance_coverage, distance_share};
pub use edge_budget::{EDGES_PER_FEATURE, EdgeBudget, edges_needed};
pub use edges::{EdgePoint, LineEdges};
pub use ellipsoid::Ellipsoid;
pub use feature::{Ball, Cull, FlatEllipse};
pub use frame::{Raster, ViewFrame};
pub use image::{ImageConic, ImagePoint};
pub use overlap::{CellOverlap, area_of, clipped_area, disc_overlap, half_plane, rectangle};
pub use surface_tone::SurfaceTone;
pub use tone::{ShadedTriangle, ToneLaw, vertex_normal};
