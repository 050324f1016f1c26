//! Object processors: bodies that are not the surface, seen ray by ray and merged with it by range.
//!
//! ```text
//! for each square of pixels: the bodies that may be in it
//!     planar screens: what shapes that are alone in their pixels show, by the exact share of their outlines (`plot`)
//!     for each other pixel: those whose box the pixel's ray comes near
//!         its corners and its middle see one face before the ground → that face
//!         else 96 rays, each to the nearest of bodies and ground   → the share of each
//! ```
//!
//! The patent's object processors (Hughes 1994) give each pixel of an object colour and range, and its image processor keeps the nearer of object
//! and ground. So do these, but by shares of a pixel, so that silhouettes, and curves in which a body enters the ground, are smooth.
//! Bodies are asked in an order of their own, not that of a scene, and every pixel is looked at in the same way whichever square it
//! lies in: neither insertion order nor the cut of a frame into tasks changes a byte.

mod area_coverage;
mod body;
mod glint;
mod lens;
mod light;
mod mesh;
mod model;
mod outline;
mod pixel;
mod pixel_light;
mod plot;
mod rank;
mod ray_coverage;
mod ribbon;
mod shadow;
mod shape;
mod sheet;
mod stroke;
mod view;

pub use body::{Body, Form};
#[doc(hidden)]
pub use glint::{Glint, GlowSums, PARTS};
pub use hedgehop_assets::model::Material;
#[doc(hidden)]
pub use hedgehop_assets::model::{Texture, Wrap};
#[doc(hidden)]
pub use lens::Lens;
pub use light::PointLight;
#[doc(hidden)]
pub use light::{Beam, Below, Cone, Fixture};
#[doc(hidden)]
pub use mesh::{Mesh, MeshPart};
#[doc(hidden)]
pub use model::Level;
pub use model::Model;
#[doc(hidden)]
pub use pixel::BodyShare;
#[doc(hidden)]
pub use pixel_light::{BodyLight, PixelGround};
#[doc(hidden)]
pub use ribbon::{ChordNode, ColourRamp, Ribbon, RibbonLine, RibbonSample, Sight};
#[doc(hidden)]
pub use shadow::{Bounds, Caster, Casters, LitPatch};
pub use shape::Shape;
#[doc(hidden)]
pub use stroke::{StrokeCover, StrokeEnd, StrokePiece, StrokeSquare, Strokes};
#[doc(hidden)]
pub use view::{BodyView, Hit, SQUARE, Square, Surroundings};
