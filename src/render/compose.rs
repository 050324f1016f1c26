//! One frame, composed: the ground, and every overlay over it.
//!
//! ```text
//! camera ──▶ ground by scan planes, or by the reference ──▶ canvas
//!                shadows of bodies ──▶ bodies ──▶ trails ──▶ lights ──▶ plumes ──▶ clouds ──▶ precipitation
//! ```

use std::time::Instant;

use super::account::{Account, Rendered};
use super::bodies::BodyPass;
use super::canvas::Canvas;
use super::clouds::CloudPass;
use super::lights::LightPass;
use super::overlays::{Overlays, Pass};
use super::plumes::PlumePass;
use super::precipitation::PrecipitationPass;
use super::reference::SeenGround;
use super::renderer::Renderer;
use super::shadows::{ShadowPass, Shadows};
use super::trails::TrailPass;
use super::{matte, planes, reference, synthesised};
use crate::frame::{Frame, Picture};
use crate::objects::BodyView;
use crate::space::Camera;
use crate::subimage::Farm;
use hedgehop_base::colour::srgb8_picture;
use hedgehop_base::error::Result;

/// Image that is asked of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// A frame with all its channels.
    Channels,
    /// A frame of which only colour and range mean something; ranges at outlines of what scan planes see are those of the nearest plane and row.
    Light,
    /// An 8-bit picture.
    Codes,
}

/// Canvas with the ground on it, and what that cost.
struct Ground {
    canvas: Canvas,
    account: Account,
    /// Ranges along the pixels' own rays, where [`Wanted::Channels`] has them apart from those by which overlays are merged.
    own_ranges: Option<Vec<f32>>,
}

/// Ranges of the ground that overlays of a picture ask for.
struct AskedRanges {
    /// Whether any range is.
    any: bool,
    /// Parts of rows whose ranges are, as of [`BodyView::parts`]; empty: all of the screen.
    parts: Vec<bool>,
    /// Whether passes after the bodies ask for ranges.
    after_bodies: bool,
}

impl Renderer<'_> {
    /// Composes what `camera` sees: the ground, then one overlay after the other. The image has the same bits for any number of workers.
    pub(super) fn compose(
        &self,
        camera: &Camera,
        overlays: Overlays<'_>,
        wanted: Wanted,
        farm: &Farm,
    ) -> Result<(Canvas, Account)> {
        let Overlays { bodies, lights, puffs, trails } = overlays;
        self.options.check(camera)?;

        // Overlays are found first: the ground of a picture has ranges only where they ask for them.
        let view = BodyView::new(camera, bodies, self.options.curvature);
        let shadows = Shadows::of(self, camera, bodies);
        let mut trails = TrailPass::find(self, camera, trails, farm)?;
        let lights = LightPass::find(self, camera, lights, bodies, farm)?;
        let bodies = BodyPass::find(self, shadows.as_ref(), &view, camera.height, farm)?;
        let plumes = PlumePass { renderer: self, camera, puffs };
        let clouds = CloudPass { renderer: self, camera };
        let precipitation = PrecipitationPass { renderer: self, camera };
        let shade = ShadowPass { shadows: shadows.as_ref(), camera };

        let weather = &self.options.weather;
        let asks_all = !puffs.is_empty() || weather.clouds.is_some() || weather.precipitation.is_some();
        let whole = asks_all || shadows.is_some();
        let mut parts = if whole { Vec::new() } else { view.parts() };
        if !whole {
            trails.mark(&mut parts);
            lights.mark(&mut parts);
        }
        trails.has_ranges = asks_all || !lights.is_empty();
        let asked = AskedRanges {
            any: whole || !bodies.is_empty() || !trails.is_empty() || !lights.is_empty(),
            parts,
            after_bodies: asks_all || !trails.is_empty() || !lights.is_empty(),
        };

        let Ground { mut canvas, mut account, own_ranges } = self.ground(camera, &asked, wanted, farm)?;
        self.source.intact()?;

        let begun = Instant::now();
        if let Canvas::Frame(frame) = &mut canvas
            && self.options.matte
        {
            frame.aov.matte = Some(matte::of_ground(self, frame, farm)?);
        }
        let surfaces: [&dyn Pass; 2] = [&shade, &bodies];
        for pass in surfaces {
            pass.draw(&mut canvas, farm)?;
        }
        if let Canvas::Frame(frame) = &mut canvas
            && self.options.tells_synthesis
        {
            frame.aov.synthesis = Some(synthesised::of_frame(self, frame, farm)?);
        }
        let seen =
            canvas.frame_ranges().filter(|_| trails.has_ranges && !trails.is_empty()).map(<[f32]>::to_vec);
        let passes: [&dyn Pass; 5] = [&trails, &lights, &plumes, &clouds, &precipitation];
        for pass in passes {
            pass.draw(&mut canvas, farm)?;
        }
        account.times.image += begun.elapsed();

        // A frame's ranges are those of surfaces.
        if let (Canvas::Frame(frame), Some(seen)) = (&mut canvas, seen) {
            frame.range = seen;
        }

        if let (Canvas::Frame(frame), Some(own)) = (&mut canvas, own_ranges) {
            for ((range, level), own) in frame.range.iter_mut().zip(&frame.level).zip(own) {
                if *level != Frame::BODY_LEVEL {
                    *range = own;
                }
            }
        }
        Ok((canvas, account))
    }

    /// Renders the ground, by scan planes or, where they do not serve, by the reference marcher.
    fn ground(&self, camera: &Camera, asked: &AskedRanges, wanted: Wanted, farm: &Farm) -> Result<Ground> {
        let view = self.planes(camera, farm)?;
        if let Some(view) = &view
            && wanted == Wanted::Codes
        {
            let mut range = self.shared.ranges.take();
            range.resize(if asked.any { camera.width as usize * camera.height as usize } else { 0 }, 0.0);
            let (picture, account) = planes::picture(self, view, farm, &mut range, &asked.parts)?;
            let canvas = Canvas::Picture { picture, range, is_ranged: asked.after_bodies };
            return Ok(Ground { canvas, account, own_ranges: None });
        }

        let (Rendered { frame, account }, own_ranges) = match view {
            Some(view) => planes::frame(self, &view, wanted == Wanted::Channels, farm)?,
            None => {
                let displacement = self.displacement(camera)?;
                let seen = SeenGround {
                    shades: self.lit.radiance.shades(),
                    synthesis: self.synthesis()?,
                    displacement: displacement.as_ref(),
                };
                (reference::render(self.source, camera, &self.options, seen, farm)?, None)
            }
        };
        let canvas = if wanted == Wanted::Codes {
            let picture =
                Picture { width: camera.width, height: camera.height, rgb: srgb8_picture(&frame.colour) };
            Canvas::Picture { picture, range: frame.range, is_ranged: asked.after_bodies }
        } else {
            Canvas::Frame(frame)
        };
        Ok(Ground { canvas, account, own_ranges })
    }

    /// [`Self::frame_with`]; unless it `describes` surfaces, only colour and range mean something, and ranges at outlines of what scan
    /// planes see are those of the nearest plane and row.
    #[doc(hidden)]
    pub fn seen_with(
        &self,
        camera: &Camera,
        overlays: Overlays<'_>,
        describes: bool,
        farm: &Farm,
    ) -> Result<Rendered> {
        let wanted = if describes { Wanted::Channels } else { Wanted::Light };
        match self.compose(camera, overlays, wanted, farm)? {
            (Canvas::Frame(frame), account) => Ok(Rendered { frame, account }),
            (Canvas::Picture { .. }, _) => unreachable!("frames were asked for"),
        }
    }

    /// Renders the view of `camera` as linear light with range, normals, levels and ids. The frame has the same bits for
    /// any number of workers.
    ///
    /// # Errors
    /// A page that is damaged; a database that changed or could not be read while the frame was rendered; options or a pose outside
    /// their ranges.
    pub fn frame(&self, camera: &Camera, farm: &Farm) -> Result<Rendered> {
        self.frame_with(camera, Overlays::default(), farm)
    }

    /// Renders as [`Self::frame`] does, with bodies, lamps and plumes in it.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn frame_with<'t>(
        &self,
        camera: &Camera,
        overlays: impl Into<Overlays<'t>>,
        farm: &Farm,
    ) -> Result<Rendered> {
        self.seen_with(camera, overlays.into(), true, farm)
    }

    /// Renders the view of `camera` as an 8-bit picture: the same light as [`Self::frame`]'s, without the other channels.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn picture(&self, camera: &Camera, farm: &Farm) -> Result<(Picture, Account)> {
        self.picture_with(camera, Overlays::default(), farm)
    }

    /// Renders as [`Self::picture`] does, with bodies, lamps and plumes in it.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn picture_with<'t>(
        &self,
        camera: &Camera,
        overlays: impl Into<Overlays<'t>>,
        farm: &Farm,
    ) -> Result<(Picture, Account)> {
        match self.compose(camera, overlays.into(), Wanted::Codes, farm)? {
            (Canvas::Picture { picture, range, .. }, account) => {
                self.shared.ranges.give_back(range);
                Ok((picture, account))
            }
            (Canvas::Frame(_), _) => unreachable!("a picture was asked for"),
        }
    }
}
