//! One frame: the picture of section 2 of the design, as code.
//!
//! ```text
//! camera ──▶ subimages ──march──▶ range ──filter──▶ surface samples ──sensor──▶ radiance
//!                                                                        │
//!                                        frame ◀── haze, sky ◀── merge ◀─┘
//! ```

mod above_ground;
mod account;
mod bodies;
mod canvas;
mod clouds;
mod compose;
mod displaced;
mod engine;
mod exposure;
mod finder;
mod lights;
mod limits;
mod matte;
mod options;
mod overlays;
mod page_planner;
mod plane_image;
mod plane_view;
mod planes;
mod plumes;
mod precipitation;
mod reference;
mod renderer;
mod shadows;
mod shown_ground;
mod spans;
mod sunlit;
mod surface;
mod synthesised;
mod trails;
mod unserved;

pub use account::Rendered;
#[doc(hidden)]
pub use account::{Account, Rays, StageTimes};
pub use exposure::Moment;
#[doc(hidden)]
pub use exposure::{Exposure, MOST_MOMENTS};
#[doc(hidden)]
pub use limits::{far_limit, level_bands};
pub use options::{Engine, RenderOptions};
pub use overlays::Overlays;
#[doc(hidden)]
pub use page_planner::{FlightPlan, LiveFrame, LivePlan, NumberedCamera};
pub use renderer::Renderer;
#[doc(hidden)]
pub use unserved::Unserved;

use std::sync::Arc;

use crate::space::Camera;
use crate::subimage::Farm;
use crate::voxel::PageSource;
use hedgehop_base::error::Result;

/// Renders what `camera` sees, once; a [`Renderer`] is faster for several frames.
///
/// # Errors
/// As of [`Renderer::frame`].
pub fn render_frame(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Rendered> {
    Renderer::new(source, options).frame(camera, farm)
}

/// Renders with the reference marcher, which every faster path is held against: pixel by pixel, in double precision.
///
/// # Errors
/// As of [`Renderer::frame`].
pub fn render_reference(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Rendered> {
    options.check(camera)?;
    let shades = options.shades(source.header(), renderer::SHADES);
    let synthesis = options.synthesis(source.header())?;
    let relief = displaced::relief(source.header(), options)?.map(Arc::new);
    let displacement = match &relief {
        Some(relief) => displaced::of_view(source, camera, options, relief)?,
        None => None,
    };
    let seen = reference::SeenGround {
        shades: shades.as_ref(),
        synthesis: synthesis.as_ref(),
        displacement: displacement.as_ref(),
    };
    let rendered = reference::render(source, camera, options, seen, farm);
    source.intact()?;
    rendered
}
