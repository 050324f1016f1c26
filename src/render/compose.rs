//! A view with all that joins its ground, one after the other: shadows of bodies, bodies, clouds.

use std::time::{Duration, Instant};

use super::lights::Sought;
use super::merge::{Bodies, rows_of};
use super::shadows::Shadows;
use super::{Account, Rendered, Renderer, clouds, matte, planes, plumes, precipitation, reference};
use crate::frame::stage::Pixels;
use crate::frame::{Frame, Picture};
use crate::objects::{Body, BodyView, PointLight, Puff, SQUARE};
use crate::scene::Scenery;
use crate::space::Camera;
use crate::subimage::Farm;
use crate::voxel::PageSource;
use hedgehop_base::colour::srgb8_picture;
use hedgehop_base::error::Result;

/// Overlays that may be merged with the ground.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overlays<'t> {
    /// Bodies, no two with the same id.
    pub bodies: &'t [Body],
    /// Lamps that shine.
    pub lights: &'t [PointLight],
    /// Smoke and dust.
    pub puffs: &'t [Puff],
}

impl<'t> From<&'t [Body]> for Overlays<'t> {
    fn from(bodies: &'t [Body]) -> Self {
        Self { bodies, ..Self::default() }
    }
}

impl<'t> From<&'t Vec<Body>> for Overlays<'t> {
    fn from(bodies: &'t Vec<Body>) -> Self {
        bodies.as_slice().into()
    }
}

impl<'t> From<&'t Scenery> for Overlays<'t> {
    fn from(scenery: &'t Scenery) -> Self {
        Self { bodies: &scenery.bodies, lights: &scenery.lights, puffs: &scenery.puffs }
    }
}

impl<'t, const COUNT: usize> From<&'t [Body; COUNT]> for Overlays<'t> {
    fn from(bodies: &'t [Body; COUNT]) -> Self {
        bodies.as_slice().into()
    }
}

impl<S: PageSource> Renderer<'_, S> {
    /// Renders the view of `camera` as linear light with range, normals, levels and ids. The frame has the same bits for
    /// any number of workers.
    ///
    /// # Errors
    /// A page that is damaged; a database that changed or could not be read while the frame was rendered; options or a pose outside
    /// their ranges.
    pub fn frame(&self, camera: &Camera, farm: &Farm) -> Result<Rendered> {
        self.frame_with(camera, Overlays::default(), farm)
    }

    /// [`Self::frame`] with bodies and lamps in it.
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

    /// [`Self::frame_with`]; unless it `describes` surfaces, only colour and range mean something, and ranges at outlines of what scan
    /// planes see are those of the nearest plane and row.
    pub(super) fn seen_with(
        &self,
        camera: &Camera,
        overlays: Overlays<'_>,
        describes: bool,
        farm: &Farm,
    ) -> Result<Rendered> {
        let Overlays { bodies, lights, puffs } = overlays;
        self.options.check(camera)?;
        let (mut rendered, own) = match self.planes(camera, farm)? {
            Some(view) => planes::frame(self, &view, describes, farm)?,
            None => (self.by_reference(camera, farm)?, None),
        };
        self.source.intact()?;
        if self.options.matte {
            rendered.frame.aov.matte = Some(matte::of_ground(self, &rendered.frame, farm)?);
        }

        rendered.account.times.image += timed(|| {
            let frame = &mut rendered.frame;
            let shadows = Shadows::of(self, camera, bodies);
            let view = BodyView::new(camera, bodies, self.options.curvature);
            let sought = Sought::find(self, camera, lights, bodies, farm)?;
            let bodies = Bodies::find(&view, camera.height, farm)?;
            if let Some(shadows) = &shadows {
                let rows = frame.colour.chunks_mut(camera.width as usize * SQUARE).map(Pixels::Linear);
                shadows.cast(camera, rows.collect(), &frame.range, farm)?;
            }

            if !bodies.is_empty() {
                bodies.into_frame(self, shadows.as_ref(), frame, farm)?;
            }
            shadows.map_or(Ok(()), Shadows::check)?;

            if !sought.is_empty() {
                let glints = sought.seen(&frame.range, farm)?;
                let rows = frame.colour.chunks_mut(camera.width as usize * SQUARE).map(Pixels::Linear);
                glints.add(self.isa, rows.collect(), farm)?;
            }

            let rows = frame.colour.chunks_mut(camera.width as usize * SQUARE).map(Pixels::Linear);
            plumes::add(self, camera, puffs, rows.collect(), &frame.range, farm)?;
            clouds::into_frame(self, frame, farm)?;
            let rows = frame.colour.chunks_mut(camera.width as usize * SQUARE).map(Pixels::Linear);

            precipitation::add(self, camera, rows.collect(), &frame.range, farm)
        })?;

        let Frame { range, level, .. } = &mut rendered.frame;
        for ((range, level), own) in range.iter_mut().zip(level).zip(own.unwrap_or_default()) {
            if *level != Frame::BODY_LEVEL {
                *range = own;
            }
        }

        Ok(rendered)
    }

    /// Renders the view of `camera` as an 8-bit picture: the same light as [`Self::frame`]'s, without the other channels.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn picture(&self, camera: &Camera, farm: &Farm) -> Result<(Picture, Account)> {
        self.picture_with(camera, Overlays::default(), farm)
    }

    /// [`Self::picture`] with bodies and lamps in it.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn picture_with<'t>(
        &self,
        camera: &Camera,
        overlays: impl Into<Overlays<'t>>,
        farm: &Farm,
    ) -> Result<(Picture, Account)> {
        let Overlays { bodies, lights, puffs } = overlays.into();
        self.options.check(camera)?;
        let view = BodyView::new(camera, bodies, self.options.curvature);
        let shadows = Shadows::of(self, camera, bodies);
        let sought = Sought::find(self, camera, lights, bodies, farm)?;
        let bodies = Bodies::find(&view, camera.height, farm)?;
        let weather = &self.options.weather;
        let has_weather = weather.clouds.is_some() || weather.precipitation.is_some();

        // What comes after bodies asks how far these are.
        let asks_all = !puffs.is_empty() || has_weather;
        let ranges_count = asks_all || !sought.is_empty();
        let takes_all = shadows.is_some() || asks_all;
        let takes_range = takes_all || !bodies.is_empty() || !sought.is_empty();
        let mut parts = if takes_all { Vec::new() } else { view.parts() };
        if !takes_all {
            sought.mark(&mut parts);
        }

        let mut range = self.shared.ranges.take();
        range.resize(if takes_range { camera.width as usize * camera.height as usize } else { 0 }, 0.0);
        let (mut picture, mut account) = match self.planes(camera, farm)? {
            Some(view) => planes::picture(self, &view, farm, &mut range, &parts)?,
            None => {
                let Rendered { frame, account } = self.by_reference(camera, farm)?;
                let rgb = srgb8_picture(&frame.colour);
                range = frame.range;
                (Picture { width: camera.width, height: camera.height, rgb }, account)
            }
        };

        self.source.intact()?;
        account.times.image += timed(|| {
            if let Some(shadows) = &shadows {
                shadows.cast(camera, rows_of(&mut picture).collect(), &range, farm)?;
            }
            if !bodies.is_empty() {
                bodies.into_picture(
                    self,
                    shadows.as_ref(),
                    &mut picture,
                    (&mut range, ranges_count),
                    farm,
                )?;
            }

            shadows.map_or(Ok(()), Shadows::check)?;
            if !sought.is_empty() {
                let glints = sought.seen(&range, farm)?;
                glints.add(self.isa, rows_of(&mut picture).collect(), farm)?;
            }

            plumes::add(self, camera, puffs, rows_of(&mut picture).collect(), &range, farm)?;
            clouds::into_picture(self, camera, &mut picture, &range, farm)?;
            precipitation::add(self, camera, rows_of(&mut picture).collect(), &range, farm)
        })?;

        self.shared.ranges.give_back(range);
        Ok((picture, account))
    }

    fn by_reference(&self, camera: &Camera, farm: &Farm) -> Result<Rendered> {
        reference::render(self.source, camera, &self.options, self.shared.radiance.shades(), farm)
    }
}

/// Wall time of something that may fail.
fn timed(work: impl FnOnce() -> Result<()>) -> Result<Duration> {
    let begun = Instant::now();
    work().map(|()| begun.elapsed())
}
