//! Renderer of one database, and the state that its frames share.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::options::{Engine, RenderOptions};
use super::plane_image::{LightingScratch, PlaneImage};
use super::plane_view::LastScreen;
use crate::cache::Used;
use crate::frame::Picture;
use crate::raymarch::scan::{Profile, TurnedPages};
use crate::sensor::radiance::Radiance;
use crate::sensor::{Facets, VisualSensor};
use crate::simd::Isa;
use crate::voxel::PageSource;
use crate::weather::clouds::CloudField;

/// One part of so many of the memory for what is computed from pages holds heights, the others light: light takes longer, and paint that
/// may have to be read again.
const TURNED_SHARE: usize = 3;

/// And one part of so many shares of the sun, where there are shadows.
const SHADED_SHARE: usize = 8;

/// Bytes of shares of the sun that are kept unless told otherwise.
pub(super) const SHADES: usize = 128 << 20;

/// Renders frames of one database, one after the other or several at once.
///
/// Keeps what frames share: the radiance of pages under the sun of the options.
#[derive(Debug)]
pub struct Renderer<'a> {
    pub(super) source: &'a dyn PageSource,
    pub(super) options: RenderOptions,
    pub(super) isa: Isa,
    /// Since the flight's first fix, seconds.
    pub(super) seconds: f64,
    /// Velocity of the eye, metres per second.
    pub(super) velocity: DVec3,
    pub(super) shared: Arc<SharedState>,
}

/// State that frames of one database share.
#[derive(Debug)]
pub(super) struct SharedState {
    pub(super) radiance: Radiance,
    pub(super) turned: TurnedPages,
    pub(super) screen: LastScreen,
    pub(super) plane_images: Used<PlaneImage>,
    pub(super) pictures: Used<Vec<u8>>,
    pub(super) ranges: Used<Vec<f32>>,
    pub(super) profiles: Used<Profile>,
    pub(super) lighting: Used<LightingScratch>,
    pub(super) clouds: OnceLock<CloudField>,
    pub(super) facets: Facets,
}

impl SharedState {
    /// Nothing yet.
    fn new(sensor: VisualSensor, radiance: Radiance, turned: TurnedPages) -> Self {
        Self {
            radiance,
            turned,
            screen: LastScreen::default(),
            plane_images: Used::default(),
            pictures: Used::default(),
            ranges: Used::default(),
            profiles: Used::default(),
            lighting: Used::default(),
            clouds: OnceLock::new(),
            facets: Facets::new(sensor),
        }
    }
}

impl<'a> Renderer<'a> {
    /// A renderer with the fastest instruction set of this machine.
    pub fn new(source: &'a dyn PageSource, options: &RenderOptions) -> Self {
        let shades = options.shades(source.header(), SHADES);
        let radiance = Radiance::new(options.sensor()).shaded(shades);
        let shared = Arc::new(SharedState::new(options.sensor(), radiance, TurnedPages::default()));
        Self { source, options: *options, isa: Isa::best(), seconds: 0.0, velocity: DVec3::ZERO, shared }
    }

    /// The same, keeping at most `bytes` of what is computed from pages, besides what the latest frames used.
    #[must_use]
    pub fn with_memory(self, bytes: usize) -> Self {
        let turned = bytes / TURNED_SHARE;
        let shaded = if self.options.has_shadows() { bytes / SHADED_SHARE } else { 0 };
        let radiance = Radiance::with_budget(self.options.sensor(), bytes - turned - shaded)
            .shaded(self.options.shades(self.source.header(), shaded));
        let shared = SharedState::new(self.options.sensor(), radiance, TurnedPages::new(turned));
        Self { shared: Arc::new(shared), ..self }
    }

    /// The same over another source of the same database, one that has some of its pages only, say; what is kept is shared.
    pub fn over<'b>(&self, source: &'b dyn PageSource) -> Renderer<'b> {
        Renderer {
            source,
            options: self.options,
            isa: self.isa,
            seconds: self.seconds,
            velocity: self.velocity,
            shared: self.shared.clone(),
        }
    }

    /// The same with another instruction set; frames differ by rounding.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The same, so many seconds after the flight's first fix: as far the wind has taken the clouds.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Self {
        Self { seconds, ..self.over(self.source) }
    }

    /// The same for an eye that moves, metres per second (x east, y north, z up): how rain and snow come towards it.
    #[must_use]
    pub fn moving(&self, velocity: DVec3) -> Self {
        Self { velocity, ..self.over(self.source) }
    }

    /// Takes back the memory of a picture that nobody needs any more, for a later one.
    pub fn recycle(&self, picture: Picture) {
        if self.options.engine == Engine::Planes {
            self.shared.pictures.give_back(picture.rgb);
        }
    }
}
