//! Windows, doors, plinths and courses on walls, as exact means over the footprints of pixels.
//!
//! ```text
//! parts of a façade are rectangles, each a product of two indicators: one of the place along the wall, one of the height
//!     along   periodic with the bays, or with eight of them                     mean over [a, b] = (I(b) − I(a)) / (b − a)
//!     up      periodic with the storeys between floor and eaves, or one band    I: integral of the indicator
//! share of a part in a footprint = product of both means (parts that lie in others are taken off these)
//! factor on the wall's light = 1 + fading · Σ share · (colour of the part − mean colour) / mean colour
//! ```
//!
//! The mean colour over all bays and storeys is that of the span's sides, whatever stands on them: the plain wall is brighter by as much as glass is
//! darker. So walls keep their colour from afar, where the pattern has faded. Means of periodic functions in closed form are antialiasing by
//! integrals (Norton, Rockwood and Skolmoski, *Clamping*, SIGGRAPH 1982; Ebert et al., *Texturing & Modeling*, 2003, §2).

mod design;
#[cfg(test)]
mod tests;

use design::{COURSE, Design, MOST_DOOR, MOST_PLINTH, PLINTH, Tone, door, frame};

use glam::DVec2;

use crate::simd::{Each, Floats, Portable, Simd};
use crate::voxel::{Bays, Cut, Facade, HeightCode, Span};
use hedgehop_base::colour::linear_from_srgb8;

/// Parts beside the plain wall: pane, frame, door, plinth, course.
const PARTS: usize = 5;
/// Heights of footprints between which façades fade, metres.
const FADING: [f32; 2] = [0.5, 1.25];
/// Least extent of a footprint, metres.
const LEAST: f32 = 1.0e-3;
/// Reflectance that walls are not brightened beyond.
const BRIGHTEST: f32 = 0.85;

/// Pattern of one wall.
#[derive(Debug, Clone, Copy)]
pub struct FacadePattern {
    bays: Option<Bays>,
    /// Widths of a bay and of eight, metres; 0: there are no bays.
    bay: f32,
    period: f32,
    /// Heights of a storey, and of all, metres.
    storey: f32,
    height: f32,
    /// Windows with their frames, and panes: along in the bay, up in the storey, metres.
    frame: [[f32; 2]; 2],
    pane: [[f32; 2]; 2],
    /// Doors: along in the first bay, and height, metres.
    door: [f32; 2],
    door_up: f32,
    /// Heights of plinth and courses, metres.
    plinth: f32,
    course: f32,
    eaves: f32,
    /// Deviations of the plain wall from the mean colour, and of each part from the plain wall, relative to the mean colour.
    plain: [f32; 3],
    parts: [[f32; 3]; PARTS],
}

/// Footprint of a pixel on a wall: middle and extent, metres.
#[derive(Debug, Clone, Copy)]
pub struct WallFootprint {
    /// Along the wall, as [`FacadePattern::place_along`] counts.
    pub along: [f32; 2],
    /// Above the lowest floor.
    pub up: [f32; 2],
}

/// Means along a wall, of sixteen footprints.
#[derive(Clone, Copy)]
pub struct AlongMeans<V: Simd> {
    frame: V::F,
    pane: V::F,
    /// Windows in bays with a door alone.
    frame_at_door: V::F,
    pane_at_door: V::F,
    door: V::F,
}

impl FacadePattern {
    /// Height of footprints from which on nothing of a façade shows, metres.
    pub const FADED: f32 = FADING[1];

    /// The pattern on the side of a span that looks to `facing`; `None`: it is plain.
    pub fn of_wall(span: &Span, facing: u8, code: HeightCode) -> Option<Self> {
        Self::new(&span.facade, span.facade.bays_of(facing), code, span.side)
    }

    /// Unit vector along the wall, (east, north).
    pub fn tangent(&self) -> [f32; 2] {
        let [east, north] = Cut::wall(self.bays.map_or(0, |bays| bays.facing), 0).normal();
        [-north, east]
    }

    /// Distance along the wall from the start of a bay with a door, of a place in the database's system, metres.
    pub fn place_along(&self, place: DVec2) -> f32 {
        let tangent = DVec2::from(self.tangent().map(f64::from));
        self.bays.map_or(0.0, |bays| bays.within(tangent.dot(place)) as f32)
    }

    /// Factors on the wall's light, by channel, over the footprint of one pixel.
    pub fn factor(&self, at: &WallFootprint) -> [f32; 3] {
        let lane = |value: f32| Portable.splat(value);
        let along = self.along(Portable, lane(at.along[0]), lane(at.along[1]));
        self.factors(Portable, &along, lane(at.up[0]), lane(at.up[1])).map(Floats::least)
    }

    /// The pattern of a wall of a mean colour (sRGB), with its bays; `None`: it is plain.
    pub fn new(facade: &Facade, bays: Option<Bays>, code: HeightCode, colour: [u8; 3]) -> Option<Self> {
        let style = facade.style()?;
        let design = Design::of(style);
        let (frame_tone, has_shutters) = frame(facade.seed());
        let height = (f64::from(facade.eaves - facade.floor) * code.scale) as f32;
        let storey = height / f32::from(facade.storeys);
        let bay = bays.map_or(0.0, |bays| bays.width_m() as f32);

        // The pane lies in its frame, the frame in its bay and storey.
        let shutter = if has_shutters { design.shutter * bay } else { 0.0 };
        let [from, to] = design.window.map(|share| share * bay);
        let [sill, head] = design.window_up.map(|share| share * storey);
        let rim = design.frame_m;
        let frame = [
            [(from - rim - shutter).max(0.0), (to + rim + shutter).min(bay)],
            [(sill - rim).max(0.0), (head + rim).min(storey)],
        ];

        let mut pattern = Self {
            bays,
            bay,
            period: bay * Bays::PERIOD as f32,
            storey,
            height,
            frame,
            pane: [[from, to], [sill, head]],
            door: design.door.map(|share| share * bay),
            door_up: design.door_m.min(MOST_DOOR * storey),
            plinth: design.plinth_m.min(MOST_PLINTH * storey),
            course: design.course_m.min(storey - frame[1][1]).max(0.0),
            eaves: design.eaves_m.min(storey - frame[1][1]).max(0.0),
            plain: [0.0; 3],
            parts: [[0.0; 3]; PARTS],
        };
        pattern.paint(colour, [design.pane, frame_tone, door(facade.seed()), PLINTH, COURSE]);
        Some(pattern)
    }

    /// Finds deviations such that the mean over all bays and storeys is the wall's colour.
    fn paint(&mut self, colour: [u8; 3], tones: [Tone; PARTS]) {
        let mean = linear_from_srgb8(colour);
        let shares = self.shares();
        let left = 1.0 - shares.iter().sum::<f32>();
        let own = |tone: &Tone, channel: usize| {
            let wall = mean[channel].max(1.0e-4);
            (tone.of_wall * wall + tone.more[channel]) / wall - 1.0
        };
        let plain = [0, 1, 2].map(|channel| {
            let sum: f32 = shares.iter().zip(&tones).map(|(share, tone)| share * own(tone, channel)).sum();
            -sum / left
        });

        // White walls cannot be brighter: all contrast is less.
        let room = |channel: usize| {
            let [wall, deviation] = [mean[channel], plain[channel]];
            if deviation > 0.0 { (BRIGHTEST / wall.max(1.0e-4) - 1.0).max(0.0) / deviation } else { 1.0 }
        };
        // Parts far brighter than a dark wall darken it at most to nothing.
        let least = |channel: usize| if plain[channel] < -0.5 { -0.5 / plain[channel] } else { 1.0 };
        let contrast = (0..3).map(|channel| room(channel).min(least(channel))).fold(1.0, f32::min);
        self.plain = plain.map(|deviation| contrast * deviation);
        self.parts =
            tones.map(|tone| [0, 1, 2].map(|channel| contrast * (own(&tone, channel) - plain[channel])));
    }

    /// Shares of the parts in all bays and storeys.
    fn shares(&self) -> [f32; PARTS] {
        let of = |[from, to]: [f32; 2]| to - from;
        let storeys = (self.height / self.storey).round();
        let courses = ((storeys - 1.0) * self.course + self.eaves) / self.height;
        let plinth = self.plinth / self.height;
        if self.bay == 0.0 {
            return [0.0, 0.0, 0.0, plinth, courses];
        }

        let bays = Bays::PERIOD as f32;
        let windows = if of(self.door) > 0.0 { bays * storeys - 1.0 } else { bays * storeys };
        let all = self.period * self.height;
        let [frames, panes] = [self.frame, self.pane].map(|[along, up]| windows * of(along) * of(up) / all);
        let door = of(self.door) / self.period;
        [
            panes,
            frames - panes,
            door * self.door_up / self.height,
            plinth - door * self.plinth.min(self.door_up) / self.height,
            courses,
        ]
    }

    /// Means between two places along the wall, metres from the start of a bay with a door.
    #[inline(always)]
    pub fn along<V: Simd>(&self, simd: V, middle: V::F, extent: V::F) -> AlongMeans<V> {
        let zero = simd.splat(0.0);
        if self.bay == 0.0 {
            return AlongMeans {
                frame: zero,
                pane: zero,
                frame_at_door: zero,
                pane_at_door: zero,
                door: zero,
            };
        }
        let stretch = Stretch::about(simd, middle, extent);
        let [frame, pane] =
            [stretch.periodic(simd, self.bay, self.frame[0]), stretch.periodic(simd, self.bay, self.pane[0])];
        if self.door[0] >= self.door[1] {
            return AlongMeans { frame, pane, frame_at_door: zero, pane_at_door: zero, door: zero };
        }
        AlongMeans {
            frame,
            pane,
            frame_at_door: stretch.periodic(simd, self.period, self.frame[0]),
            pane_at_door: stretch.periodic(simd, self.period, self.pane[0]),
            door: stretch.periodic(simd, self.period, self.door),
        }
    }

    /// Factors on the wall's light, by channel, where footprints have their middles `middle` metres above the floor and are `extent` metres high.
    #[inline(always)]
    pub fn factors<V: Simd>(&self, simd: V, along: &AlongMeans<V>, middle: V::F, extent: V::F) -> [V::F; 3] {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let stretch = Stretch::about(simd, middle, extent);
        let storeys = stretch.within(simd, [0.0, self.height]);
        let above = stretch.within(simd, [0.5 * self.storey, self.height - 0.5 * self.storey]);
        let below = f32::NEG_INFINITY;

        // Shares of the parts; the door takes the place of a window and of the plinth.
        let [frame_up, pane_up] = [self.frame[1], self.pane[1]];
        let pane = along.pane * storeys.periodic(simd, self.storey, pane_up)
            - along.pane_at_door * stretch.band(simd, pane_up);
        let frame = along.frame * storeys.periodic(simd, self.storey, frame_up)
            - along.frame_at_door * stretch.band(simd, frame_up)
            - pane;
        let door = along.door * stretch.band(simd, [0.0, self.door_up]);
        let plinth = stretch.band(simd, [below, self.plinth])
            - along.door * stretch.band(simd, [0.0, self.plinth.min(self.door_up)]);
        let course = above.periodic(simd, self.storey, [self.storey - self.course, self.storey])
            + stretch.band(simd, [self.height - self.eaves, self.height]);

        let fading = (simd.splat(FADING[1]) - extent) * simd.splat(1.0 / (FADING[1] - FADING[0]));
        let fading = fading.max(zero).min(one);
        let shares = [pane, frame, door, plinth, course];
        [
            fading.mul_add(self.deviation(simd, 0, shares), one),
            fading.mul_add(self.deviation(simd, 1, shares), one),
            fading.mul_add(self.deviation(simd, 2, shares), one),
        ]
    }

    /// Deviations from the mean colour, relative to it, in one channel where the parts have these shares.
    #[inline(always)]
    fn deviation<V: Simd>(
        &self,
        simd: V,
        channel: usize,
        [pane, frame, door, plinth, course]: [V::F; PARTS],
    ) -> V::F {
        let parts = &self.parts;
        let sum = pane.mul_add(simd.splat(parts[0][channel]), simd.splat(self.plain[channel]));
        let sum = door.mul_add(simd.splat(parts[2][channel]), sum);
        let sum = frame.mul_add(simd.splat(parts[1][channel]), sum);
        let sum = course.mul_add(simd.splat(parts[4][channel]), sum);
        plinth.mul_add(simd.splat(parts[3][channel]), sum)
    }
}

/// Stretches that means are taken over, of sixteen footprints.
#[derive(Clone, Copy)]
struct Stretch<V: Simd> {
    from: V::F,
    to: V::F,
    /// Inverse length of the whole of each.
    per_length: V::F,
}

impl<V: Simd> Stretch<V> {
    #[inline(always)]
    fn about(simd: V, middle: V::F, extent: V::F) -> Self {
        let extent = extent.max(simd.splat(LEAST));
        let half = extent * simd.splat(0.5);
        Self { from: middle - half, to: middle + half, per_length: extent.recip() }
    }

    /// The part of it within bounds; means are still over all of it.
    #[inline(always)]
    fn within(&self, simd: V, bounds: [f32; 2]) -> Self {
        let [low, high] = bounds.each(|bound| simd.splat(bound));
        let high = high.max(low);
        Self { from: self.from.max(low).min(high), to: self.to.max(low).min(high), ..*self }
    }

    /// Mean of what is 1 between two places.
    #[inline(always)]
    fn band(&self, simd: V, [from, to]: [f32; 2]) -> V::F {
        let length = self.to.min(simd.splat(to)) - self.from.max(simd.splat(from));
        length.max(simd.splat(0.0)) * self.per_length
    }

    /// Mean of what is 1 between two places of each period.
    #[inline(always)]
    fn periodic(&self, simd: V, period: f32, part: [f32; 2]) -> V::F {
        (integral(simd, self.to, period, part) - integral(simd, self.from, period, part)) * self.per_length
    }
}

/// Integral from 0 of what is 1 between two places of each period.
#[inline(always)]
fn integral<V: Simd>(simd: V, to: V::F, period: f32, [start, end]: [f32; 2]) -> V::F {
    let whole = (to * simd.splat(1.0 / period)).floor();
    let within = whole.neg_mul_add(simd.splat(period), to) - simd.splat(start);
    let length = simd.splat(end - start);
    whole.mul_add(length, within.max(simd.splat(0.0)).min(length))
}
