//! Weather: what lies in the air between the eye and what is seen.
//!
//! ```text
//! scene file ──▶ Weather: glow, fog, clouds, precipitation, wet or white ground
//! Atmosphere: haze, fog and glow along one ray          Air: the same for sixteen planes at once
//! over what was rendered:  plumes, clouds, precipitation
//! ```

mod air;
#[cfg(test)]
mod air_tests;
mod atmosphere;
pub(crate) mod chance;
#[doc(hidden)]
pub mod clouds;
mod fog;
mod glow;
mod layers;
mod plume;
mod precipitation;
mod precipitation_stage;

#[doc(hidden)]
pub use air::Air;
#[doc(hidden)]
pub use atmosphere::{Atmosphere, Veil};
pub use layers::{Clouds, Fog, Weather};
pub(crate) use layers::{CloudsTable, FogTable, glow};
#[doc(hidden)]
pub use plume::{Puff, SeenPuff};
pub use precipitation::{GroundCover, Precipitation, PrecipitationKind};
pub(crate) use precipitation::{GroundTable, PrecipitationTable};
#[doc(hidden)]
pub use precipitation_stage::PrecipitationStage;
