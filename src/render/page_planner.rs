//! Pages that the frames of a flight need, for the thread that keeps pages in memory.

use std::collections::HashSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::DVec2;

use super::planes;
use super::renderer::Renderer;
use crate::flight::Extrapolation;
use crate::memory::PagePlanner;
use crate::space::{Camera, Pose};
use crate::subimage::Farm;
use crate::sunlight::{Shade, Sky};
use crate::voxel::{Grid, PAGE_SIDE, PageId, PageNeeds, PagePart, PageSource};
use hedgehop_base::error::Result;

/// Camera of a frame of a flight.
#[derive(Debug, Clone)]
pub struct NumberedCamera {
    /// The frame's number.
    pub number: u64,
    /// Sees the frame.
    pub camera: Camera,
    /// Sun and stars of the frame; `None`: those of the renderer's options.
    pub sky: Option<Sky>,
}

/// Foresees the frames that a renderer is to render.
#[derive(Debug)]
pub struct FlightPlan<'a> {
    renderer: &'a Renderer<'a>,
    farm: &'a Farm,
    cameras: &'a [NumberedCamera],
    is_of_pictures: bool,
}

impl<'a> FlightPlan<'a> {
    /// Frames that `renderer` is to render are seen by `cameras`, in order; workers of `farm` may compute tables of directions.
    pub fn new(renderer: &'a Renderer<'a>, farm: &'a Farm, cameras: &'a [NumberedCamera]) -> Self {
        Self { renderer, farm, cameras, is_of_pictures: false }
    }

    /// The frames are [pictures](Renderer::picture) alone: nothing but their light looks at paint.
    #[must_use]
    pub fn of_pictures(self) -> Self {
        Self { is_of_pictures: true, ..self }
    }
}

impl PagePlanner for FlightPlan<'_> {
    fn needs(&self, frame: u32) -> Result<PageNeeds> {
        match self.cameras.get(frame as usize) {
            Some(frame) => self.renderer.under(frame.sky).foresee(&frame.camera, self.farm),
            None => Ok(PageNeeds::default()),
        }
    }

    fn is_behind(&self, frame: u32, page: PageId) -> bool {
        let seen = self.cameras.get(frame as usize);
        seen.is_none_or(|seen| lies_behind(&self.renderer.source.header().grid, &seen.camera.pose, page))
    }

    fn brings_paint(&self) -> bool {
        self.is_of_pictures
    }
}

impl Renderer<'_> {
    /// Parts of pages that a picture of what `camera` sees may touch, in the order of need; none where the reference marcher renders. Bounds
    /// of coarse pages are read to know it.
    ///
    /// # Errors
    /// As of [`Self::frame`].
    pub fn foresee(&self, camera: &Camera, farm: &Farm) -> Result<PageNeeds> {
        self.options.check(camera)?;
        match self.planes(camera, farm)? {
            Some(view) => {
                let needs = planes::footprint(self, &view)?;
                Ok(match self.lit.radiance.shades() {
                    Some(shades) => with_supports(self.source, &needs, shades.shade()),
                    None => needs,
                })
            }
            None => Ok(PageNeeds::default()),
        }
    }
}

/// `needs`, and heights of the pages that may throw shadows on those whose paint is needed: just before it, and as likely.
fn with_supports(source: &dyn PageSource, needs: &PageNeeds, shade: &Shade) -> PageNeeds {
    let mut known = HashSet::new();
    let mut found = PageNeeds::default();
    let (likely, others) = needs.parts.split_at(needs.likely);
    for parts in [likely, others] {
        found.likely = found.parts.len();
        for part in parts {
            let supports = match part {
                PagePart::Paint(page) => shade.supports(source, *page),
                PagePart::Heights(_) | PagePart::Bounds(_) | PagePart::Spans(_) => Vec::new(),
            };
            let all = supports.into_iter().map(PagePart::Heights).chain([*part]);
            found.parts.extend(all.filter(|part| known.insert(*part)));
        }
    }
    found
}

/// Whether a page lies behind the eye.
fn lies_behind(grid: &Grid, pose: &Pose, page: PageId) -> bool {
    let side = grid.side(page.level) * f64::from(PAGE_SIDE);
    let [low, high] = grid.page_square(page);
    let centre = (low + high) / 2.0;
    let (sin, cos) = pose.attitude.yaw.to_radians().sin_cos();
    (centre - pose.eye.truncate()).dot(DVec2::new(sin, cos)) < -side
}

/// Foresees frames of a flight whose path is not known: it goes on as it went so far.
#[derive(Debug)]
pub struct LivePlan<'a> {
    renderer: &'a Renderer<'a>,
    farm: &'a Farm,
    seen: Mutex<LiveEye>,
}

/// Latest pose and motion of a live flight.
#[derive(Debug, Default)]
struct LiveEye {
    motion: Extrapolation,
    /// The latest frame.
    latest: Option<LiveFrame>,
    /// Seconds from frame to frame.
    step: f64,
}

/// A frame of a live flight.
#[derive(Debug, Clone)]
pub struct LiveFrame {
    /// Number, rising.
    pub frame: u32,
    /// Time after any beginning, seconds.
    pub seconds: f64,
    /// Sees the frame.
    pub camera: Camera,
    /// Sun and stars of the frame; `None`: those of the renderer's options.
    pub sky: Option<Sky>,
}

impl LiveEye {
    /// The pose of a frame; `None` if no frame is known.
    fn pose_of(&self, frame: u32) -> Option<Pose> {
        let known = self.latest.as_ref()?;
        self.motion.pose_at(known.seconds + f64::from(frame.saturating_sub(known.frame)) * self.step)
    }
}

impl<'a> LivePlan<'a> {
    /// No frame is known yet of what `renderer` is to render; workers of `farm` may compute tables of directions.
    pub fn new(renderer: &'a Renderer<'a>, farm: &'a Farm) -> Self {
        Self { renderer, farm, seen: Mutex::default() }
    }

    fn seen(&self) -> MutexGuard<'_, LiveEye> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes note of the next frame. Frames that are not later than the last one that was told are passed over.
    ///
    /// # Errors
    /// A time or a pose that is not finite.
    pub fn tell(&self, next: LiveFrame) -> Result<()> {
        let mut seen = self.seen();
        seen.motion.observe(next.seconds, &next.camera.pose)?;
        if let Some(last) = &seen.latest {
            if next.frame <= last.frame || next.seconds <= last.seconds {
                return Ok(());
            }
            seen.step = (next.seconds - last.seconds) / f64::from(next.frame - last.frame);
        }
        seen.latest = Some(next);
        Ok(())
    }

    /// Returns the camera that will see a frame, as predicted; `None` if no frame is known.
    pub fn predict(&self, frame: u32) -> Option<Camera> {
        let seen = self.seen();
        let pose = seen.pose_of(frame)?;
        seen.latest.as_ref().map(|latest| latest.camera.moved_to(pose))
    }
}

impl PagePlanner for LivePlan<'_> {
    fn needs(&self, frame: u32) -> Result<PageNeeds> {
        match self.predict(frame) {
            Some(camera) => {
                // From frame to frame the sun hardly moves.
                let sky = self.seen().latest.as_ref().and_then(|latest| latest.sky);
                self.renderer.under(sky).foresee(&camera, self.farm)
            }
            None => Ok(PageNeeds::default()),
        }
    }

    fn is_behind(&self, frame: u32, page: PageId) -> bool {
        let pose = self.seen().pose_of(frame);
        pose.is_none_or(|pose| lies_behind(&self.renderer.source.header().grid, &pose, page))
    }
}
