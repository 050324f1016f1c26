//! Renderer of one database, and the state that its frames share.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::displaced;
use super::options::{Engine, RenderOptions};
use super::plane_image::PlaneImage;
use super::plane_view::LastScreen;
use crate::cache::Used;
use crate::detail::{DisplacedRelief, Displacement, Synthesis};
use crate::frame::Picture;
use crate::frame::stage::EdgeSums;
use crate::raymarch::BlockTable;
use crate::raymarch::scan::{BoundPyramid, Profile, TurnedPages};
use crate::sensor::Facets;
use crate::sensor::radiance::Radiance;
use crate::simd::Isa;
use crate::space::Camera;
use crate::sunlight::{Night, Sky};
use crate::voxel::{Header, PageSource};
use crate::weather::clouds::{CloudDensities, CloudField};
use hedgehop_base::error::Result;

/// One part of so many of the memory for what is computed from pages holds heights, the others light: light takes longer, and paint that
/// may have to be read again.
const TURNED_SHARE: usize = 3;

/// And one part of so many shares of the sun, where there are shadows.
const SHADED_SHARE: usize = 8;

/// Bytes of shares of the sun that are kept unless told otherwise.
pub(super) const SHADES: usize = 128 << 20;

/// Renders frames of one database, one after the other or several at once.
///
/// Keeps what frames share: what is found in pages, and their radiance under the sun of the options.
#[derive(Debug)]
pub struct Renderer<'a> {
    pub(super) source: &'a dyn PageSource,
    pub(super) options: RenderOptions,
    pub(super) isa: Isa,
    /// Since the flight's first fix, seconds.
    pub(super) seconds: f64,
    /// Velocity of the eye, metres per second.
    pub(super) velocity: DVec3,
    /// Bytes of what is computed from pages; `None`: as usual.
    memory: Option<usize>,
    pub(super) shared: Arc<SharedState>,
    pub(super) lit: Arc<LitState>,
}

/// State that frames of one database share under any sun.
#[derive(Debug, Default)]
pub(super) struct SharedState {
    pub(super) bounds: OnceLock<BoundPyramid>,
    pub(super) turned: TurnedPages,
    pub(super) screen: LastScreen,
    pub(super) plane_images: Used<PlaneImage>,
    pub(super) pictures: Used<Vec<u8>>,
    pub(super) ranges: Used<Vec<f32>>,
    pub(super) profiles: Used<Profile>,
    pub(super) edge_sums: Used<EdgeSums>,
    pub(super) blocks: Used<BlockTable>,
    pub(super) clouds: OnceLock<CloudDensities>,
    relief: OnceLock<Option<Arc<DisplacedRelief>>>,
}

/// State that frames of one database share under one sun.
#[derive(Debug)]
pub(super) struct LitState {
    pub(super) radiance: Radiance,
    pub(super) clouds: OnceLock<CloudField>,
    pub(super) facets: Facets,
    synthesis: OnceLock<Option<Synthesis>>,
}

impl SharedState {
    /// Nothing yet, within a budget in bytes.
    fn new(memory: Option<usize>) -> Self {
        let turned = memory.map(|bytes| TurnedPages::new(bytes / TURNED_SHARE)).unwrap_or_default();
        Self { turned, ..Self::default() }
    }
}

impl LitState {
    /// Nothing yet of a database with this header, under the sun of `options`, within a budget in bytes.
    fn new(header: &Header, options: &RenderOptions, memory: Option<usize>) -> Self {
        let sensor = options.sensor();
        let radiance = match memory {
            None => Radiance::new(sensor).shaded(options.shades(header, SHADES)),
            Some(bytes) => {
                let shaded = if options.has_shadows() { bytes / SHADED_SHARE } else { 0 };
                Radiance::with_budget(sensor, bytes - bytes / TURNED_SHARE - shaded)
                    .shaded(options.shades(header, shaded))
            }
        };
        Self { radiance, clouds: OnceLock::new(), facets: Facets::new(sensor), synthesis: OnceLock::new() }
    }
}

impl<'a> Renderer<'a> {
    /// A renderer with the fastest instruction set of this machine.
    pub fn new(source: &'a dyn PageSource, options: &RenderOptions) -> Self {
        Self {
            source,
            options: *options,
            isa: Isa::best(),
            seconds: 0.0,
            velocity: DVec3::ZERO,
            memory: None,
            shared: Arc::new(SharedState::new(None)),
            lit: Arc::new(LitState::new(source.header(), options, None)),
        }
    }

    /// The same, keeping at most `bytes` of what is computed from pages, besides what the latest frames used.
    #[must_use]
    pub fn with_memory(self, bytes: usize) -> Self {
        let memory = Some(bytes);
        let shared = Arc::new(SharedState::new(memory));
        let lit = Arc::new(LitState::new(self.source.header(), &self.options, memory));
        Self { memory, shared, lit, ..self }
    }

    /// The same over another source of the same database, one that has some of its pages only, say; what is kept is shared.
    pub fn over<'b>(&self, source: &'b dyn PageSource) -> Renderer<'b> {
        Renderer {
            source,
            options: self.options,
            isa: self.isa,
            seconds: self.seconds,
            velocity: self.velocity,
            memory: self.memory,
            shared: self.shared.clone(),
            lit: self.lit.clone(),
        }
    }

    /// The same with another instruction set; frames differ by rounding.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// The same under another sun and, if there are stars, other ones, for a frame of its own: what depends on light is not shared. `None`: under those of the options.
    #[must_use]
    pub fn under(&self, sky: Option<Sky>) -> Self {
        let same = self.over(self.source);
        let Some(Sky { sun, firmament }) = sky else { return same };
        let stars = self.options.night.stars.map(|_| firmament);
        let options = RenderOptions { sun, night: Night { stars, ..self.options.night }, ..self.options };
        let lit = Arc::new(LitState::new(self.source.header(), &options, self.memory));
        Self { options, lit, ..same }
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

    /// Returns the detail below the finest voxel under the sun of the options; `None`: there is none.
    ///
    /// # Errors
    /// The pattern that the database asks for has nothing below the voxel.
    pub(super) fn synthesis(&self) -> Result<Option<&Synthesis>> {
        if let Some(found) = self.lit.synthesis.get() {
            return Ok(found.as_ref());
        }
        let made = self.options.synthesis(self.source.header())?;
        Ok(self.lit.synthesis.get_or_init(|| made).as_ref())
    }

    /// Returns the displacement of the ground that a camera sees; `None`: there is none.
    ///
    /// # Errors
    /// A page that is damaged, or a pattern that has nothing below the voxel.
    pub(super) fn displacement(&self, camera: &Camera) -> Result<Option<Displacement>> {
        let relief = match self.shared.relief.get() {
            Some(relief) => relief,
            None => {
                let made = displaced::relief(self.source.header(), &self.options)?.map(Arc::new);
                self.shared.relief.get_or_init(|| made)
            }
        };
        match relief {
            Some(relief) => displaced::of_view(self.source, camera, &self.options, relief),
            None => Ok(None),
        }
    }

    /// Takes back the memory of a picture that nobody needs any more, for a later one.
    pub fn recycle(&self, picture: Picture) {
        if self.options.engine == Engine::Planes {
            self.shared.pictures.give_back(picture.rgb);
        }
    }
}
