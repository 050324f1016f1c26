//! Spans of a voxel, where planes cross them.

use std::ops::Range;

use super::coverage::{FilledFace, SpanCoverage};
use super::facade::{FacadeFront, FacedWall, FrontLanes, FrontLook, centre, row_edges};
use super::fill::{Fill, Haze, LinearTerm, PlanePassage};
use super::front::{Front, FrontPlace};
use super::horizon::FloatingHorizon;
use super::metric::{FaceDirection, FacetLight, Metric, dot};
use super::order::{MetSpan, next_of};
use super::plane_lanes::PlaneLanes;
use crate::detail::FacadePattern;
use crate::raymarch::scan::RowCoordinate;
use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd};
use crate::voxel::{Cut, PageId, Span};

/// Distance by which a place on a voxel's border may lie beyond a wall along it by rounding, sides of a voxel: what is seen there is the voxel's side and no wall within.
const BY_ROUNDING: f32 = 1.0e-5;

/// Spans of a voxel that are put in order together.
const MOST_SORTED: usize = 16;

/// Floor of each plane, below which all is hidden.
#[derive(Clone, Copy)]
pub(super) struct Floor<V: Simd> {
    /// Tangent of elevation.
    pub tangent: V::F,
    /// Rows below it, from the first one.
    pub rows: V::F,
}

/// Spans of a voxel where planes cross them.
pub(super) struct VoxelCrossing<'c, 'p, L, V: Simd> {
    pub simd: V,
    pub page: PageId,
    /// Column and row on the page.
    pub voxel: [u32; 2],
    pub metric: &'c Metric,
    pub coverage: &'c mut SpanCoverage,
    pub light: &'c mut L,
    pub coordinate: RowCoordinate,
    /// Index of the first row.
    pub first: f32,
    /// Tangents of the middles of rows from there on.
    pub centres: &'c [f32],
    /// Tangents of the edges of rows from there on.
    pub edges: &'c [f32],
    pub lanes: &'c PlaneLanes<V>,
    pub floor: Floor<V>,
    pub horizon: &'c FloatingHorizon<'p, V>,
    /// Major distance between the ends, units.
    pub length: V::F,
    /// Places where the planes enter and leave, `[end][axis]`: east and north of the voxel's centre, sides of it.
    pub ends: [[V::F; 2]; 2],
    /// Inverse depths there, 1/metres.
    pub inverse: [V::F; 2],
    /// Height of the datum halfway above the eye, with the Earth's curvature, metres.
    pub above: V::F,
    /// The same of one of the planes: within a voxel they differ by less than a step of height.
    pub about: f32,
    /// Place of the eye from the voxel's centre, sides of it.
    pub eye: [f32; 2],
}

impl<'c, L: FacetLight, V: Simd> VoxelCrossing<'c, '_, L, V> {
    /// Whether a span's upper end lies below the eye.
    #[inline(always)]
    fn is_below(&self, span: &Span) -> bool {
        let Metric { scale, spacing, .. } = *self.metric;
        let slope = span.slopes();
        let rise = (slope[0] * self.eye[0] + slope[1] * self.eye[1]) * spacing;
        scale * f32::from(span.high) + self.about + rise <= 0.0
    }

    /// Returns the index of the span that planes meet first: those from there on follow, and then those before it, from the last one back.
    ///
    /// Spans lie from the lowest to the highest. Planes meet them outward from the eye: from above the plane between two of them the upper one first, from
    /// below it the lower one. The plane goes on to the eye as sloped ends do.
    #[inline(always)]
    fn outward_from(&self, spans: &[Span]) -> usize {
        // Most voxels have one span.
        if spans.len() < 2 {
            return 0;
        }

        // The steps of `slice::partition_point`, whose closure would be a function of its own without the instruction set. Spans that stand beside
        // each other have no order, so which of them are looked at matters.
        let (mut first, mut size) = (0, spans.len());
        while size > 1 {
            let half = size / 2;
            first += if self.is_below(&spans[first + half]) { half } else { 0 };
            size -= half;
        }
        first + usize::from(self.is_below(&spans[first]))
    }

    /// Looks at the spans of the voxel.
    #[inline(always)]
    pub fn look_at(&mut self, planes: V::M, spans: &[Span]) {
        let simd = self.simd;

        let first = self.outward_from(spans);
        let mut outward = spans[first..].iter().chain(spans[..first].iter().rev());
        let mut met: [Option<MetSpan<'_, V>>; MOST_SORTED] = [None; MOST_SORTED];

        loop {
            let mut count = 0;
            while count < MOST_SORTED
                && let Some(span) = outward.next()
            {
                if let Some(span) = self.within(planes, span) {
                    met[count] = Some(span);
                    count += 1;
                }
            }

            // Halves of a ridge stand beside each other in one voxel.
            while let Some((index, planes)) = next_of(simd, &met[..count])
                && let Some(span) = &mut met[index]
            {
                span.planes = span.planes & !planes;
                let span = MetSpan { planes, ..*span };
                self.meet(&span);
            }
            if count < MOST_SORTED {
                return;
            }
        }
    }

    /// Finds which of `planes` cross a span that they may see, and between which shares of their ways through the voxel they are within its walls.
    #[inline(always)]
    fn within<'s>(&self, planes: V::M, span: &'s Span) -> Option<MetSpan<'s, V>> {
        let simd = self.simd;
        let Metric { scale, spacing, .. } = *self.metric;
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));

        let steepest = f32::from(span.slope[0].unsigned_abs()) + f32::from(span.slope[1].unsigned_abs());
        let rise = steepest * (0.5 * spacing / Span::SLOPE_STEPS);
        let top = simd.splat(scale * f32::from(span.high) + rise) + self.above;
        let top = top * self.inverse[1].select(top.lt(zero), self.inverse[0]);
        let mut planes = planes & self.floor.tangent.lt(top);
        let mut shares = [zero, one];

        for (index, cut) in span.cuts.iter().enumerate() {
            if !cut.is_wall() {
                break;
            }

            let beyond = self.beyond(cut);
            if index == 0 && span.is(Span::STRIP) {
                let half = simd.splat(0.5 * f32::from(span.high - span.low.min(span.high)) * scale / spacing);
                planes = self.clip(planes, &mut shares, [beyond[0] - half, beyond[1] - half]);
                let beyond = [zero - beyond[0] - half, zero - beyond[1] - half];
                planes = self.clip(planes, &mut shares, beyond);
            } else {
                planes = self.clip(planes, &mut shares, beyond);
            }
        }

        planes.any().then_some(MetSpan { span, planes, shares })
    }

    /// Distances of both ends beyond a wall, sides of the voxel.
    #[inline(always)]
    fn beyond(&self, cut: &Cut) -> [V::F; 2] {
        let normal = self.metric.directions[usize::from(cut.facing)];
        let distance = self.simd.splat(cut.distance() + BY_ROUNDING);
        let [near, far] = self.ends;
        [dot(self.simd, normal, near) - distance, dot(self.simd, normal, far) - distance]
    }

    /// Clips ranges of shares to where `beyond`, linear from share 0 to 1, is not positive. Returns those of `planes` of which something is left.
    #[inline(always)]
    fn clip(&self, planes: V::M, [from, to]: &mut [V::F; 2], [first, last]: [V::F; 2]) -> V::M {
        let zero = self.simd.splat(0.0);
        let outside = [zero.lt(first), zero.lt(last)];
        let crossing = first / (first - last);
        *from = from.max(crossing).select(outside[0], *from);
        *to = to.min(crossing).select(outside[1], *to);
        planes & !(outside[0] & outside[1]) & from.lt(*to)
    }

    /// Numbers of rows below tangents; rows that are hidden do not matter.
    #[inline(always)]
    fn rows(&self, tangents: V::F) -> V::F {
        let rows = self.coordinate.rows_below(self.simd, tangents) - self.simd.splat(self.first);
        self.floor.rows.select(tangents.le(self.floor.tangent), rows)
    }

    /// Fills what is seen of a span.
    #[inline(always)]
    fn meet(&mut self, met: &MetSpan<'_, V>) {
        let simd = self.simd;
        let MetSpan { span, planes, shares } = *met;
        let Metric { scale, spacing, .. } = *self.metric;
        let zero = simd.splat(0.0);
        let is_cut = span.cuts[0].is_wall();

        // Depth is linear in the distance, so is the place; the inverse is not.
        let depth = [self.inverse[0].recip(), self.inverse[1].recip()];
        let (depth, inverse, at) = if is_cut {
            let depth = [mix::<V>(depth, shares[0]), mix::<V>(depth, shares[1])];
            let at = [between::<V>(self.ends, shares[0]), between::<V>(self.ends, shares[1])];
            (depth, [depth[0].recip(), depth[1].recip()], at)
        } else {
            (depth, self.inverse, self.ends)
        };

        // Heights of both ends over the eye where the planes enter and leave.
        let top = simd.splat(scale * f32::from(span.high)) + self.above;
        let slope = span.slopes();
        let is_sloped = span.slope != [0; 2];
        let gradient = slope.each(|slope| slope * spacing);
        let rise =
            if is_sloped { [dot(simd, gradient, at[0]), dot(simd, gradient, at[1])] } else { [zero; 2] };
        let [top_near, top_far] = [(top + rise[0]) * inverse[0], (top + rise[1]) * inverse[1]];
        let highest = top_near.max(top_far);
        let hangs = span.low != Span::GROUND;
        let low_end = simd.splat(scale * f32::from(span.low)) + self.above;
        let low_rise = if span.is(Span::PARALLEL) { rise } else { [zero; 2] };
        let lows = [(low_end + low_rise[0]) * inverse[0], (low_end + low_rise[1]) * inverse[1]];

        let planes = planes & self.floor.tangent.lt(highest);
        let high_row = self.rows(highest);
        let low_row = if hangs { self.rows(lows[0].min(lows[1])) } else { self.floor.rows };
        let rows = self.coverage.rows_between(simd, planes, [low_row, high_row]);
        if !planes.any() || !self.coverage.has_open(planes.bits(), rows) {
            return;
        }

        let horizon = self.horizon.at(simd, planes, inverse[0]);
        let [low_near, low_far] = if hangs { lows } else { [horizon; 2] };
        let place = FrontPlace { at: at[0], share: shares[0], inverse: inverse[0], depth: depth[0] };
        let has_depths = self.coverage.has_depths();
        let front_lanes = FrontLanes { at: at[0], depth: depth[0], above: self.above };
        let front = Front::of(simd, self.metric, span, &place, has_depths.then_some(self.lanes));

        // The rim of the front that is lit as the upper end is.
        let rim = (front.seam * simd.splat(spacing)).neg_mul_add(inverse[0], top_near);
        let side = [low_near.max(horizon), rim.max(low_near)];
        let is_top_seen = planes & top_near.lt(top_far);

        // The roof begins where the front ends, or in the row of the ground before both.
        let side_rows = [self.rows(side[0]), self.rows(side[1])];
        let mut upper = [side[1].max(horizon), highest];
        let mut upper_rows = [side_rows[1].select(horizon.le(side[1]), side_rows[0]), high_row];

        // Right below the eye no ground is seen that near: what hides the roof there would hide it from all rows.
        let is_grounded = is_top_seen & simd.splat(self.horizon.lowest()).lt(horizon);
        if is_grounded.any() {
            let beyond = self.horizon.at(simd, planes, inverse[1]);
            let [emerges, submerges] = above_ground::<V>(simd, [top_near, top_far], [horizon, beyond]);
            let is_clipped = is_grounded & (upper[0].lt(emerges) | submerges.lt(upper[1]));
            if is_clipped.any() {
                upper = [
                    upper[0].max(emerges).select(is_clipped, upper[0]),
                    upper[1].min(submerges).select(is_clipped, upper[1]),
                ];
                upper_rows = [self.rows(upper[0]), self.rows(upper[1])];
            }
        }

        let lower = [low_far.max(horizon), low_near];
        let is_bottom_seen = planes & low_far.lt(low_near);
        let level = LinearTerm { tangent: zero, value: inverse[0], slope: zero };
        let passage = PlanePassage { inverse, top: [top_near, top_far], bottom: hangs.then_some(lows) };
        let opacity = span.state & Span::OPACITY;
        let clearness = if opacity < Span::OPAQUE {
            let sides = match span.is(Span::STRIP) {
                true => f32::from(span.thickness()) * scale / spacing,
                false => 1.0,
            };
            let way = self.lanes.ground * self.length * (shares[1] - shares[0]);
            Some(way * simd.splat(self.metric.clearness[usize::from(opacity)] / sides))
        } else {
            None
        };

        for (face, tangents) in [side, upper, lower].into_iter().enumerate() {
            let [low, high] = tangents;
            let seen = planes & low.lt(high) & self.floor.tangent.lt(high);
            if !seen.any() {
                continue;
            }
            let places = match face {
                0 => side_rows,
                1 => upper_rows,
                _ => [self.rows(lower[0]), self.rows(lower[1])],
            };
            let seen = seen & places[0].lt(places[1]);
            let rows = self.coverage.rows_between(simd, seen, places);
            if !self.coverage.has_open(seen.bits(), rows.clone()) {
                continue;
            }

            let (light, (linear, across)) = match face {
                0 => (self.front_light(span, seen, &front), (level, front.across)),
                1 => {
                    let end = SlopedEnd { height: top, slope: gradient, rise, far: top_far };
                    (
                        self.face_light(span, FaceDirection::Top(span.slope)),
                        self.along(&end, is_top_seen, depth, inverse, front.across),
                    )
                }
                _ => {
                    let slope = if span.is(Span::PARALLEL) { gradient } else { [0.0; 2] };
                    let end = SlopedEnd { height: low_end, slope, rise: low_rise, far: low_far };
                    (
                        self.face_light(span, FaceDirection::Bottom),
                        self.along(&end, is_bottom_seen, depth, inverse, front.across),
                    )
                }
            };

            let haze = match clearness {
                Some(clearness) => Some(Haze { clearness, level: self.lanes.level, tangents, passage }),
                None => None,
            };
            let bounds = [inverse[1], inverse[0]];
            let mut fill = Fill { light, haze, inverse: linear, across, bounds, front: front.across };
            fill.keep(simd, seen);

            // Each wall has a façade of its own, if not too far away to be seen.
            let has_facade =
                face == 0 && !span.facade.is_none() && self.shows_facades(seen, rows.clone(), depth[0]);
            let mut left = seen.bits();
            while left != 0 {
                let (planes, facade) = match has_facade {
                    true => self.facade(span, left, &front, &front_lanes),
                    false => (left, None),
                };
                left &= !planes;
                let seen = FilledFace { fill: &fill, facade: facade.as_ref() };
                self.coverage.fill(simd, planes, rows.clone(), places, &seen, self.centres);
            }
        }
    }

    /// Radiance of a face that looks the same way in all planes.
    #[inline(always)]
    fn face_light(&mut self, span: &Span, face: FaceDirection) -> [V::F; 3] {
        let simd = self.simd;
        self.light.light(self.page, self.voxel, span, face).each(|light| simd.splat(light))
    }

    /// Radiance of fronts in some planes.
    #[inline(always)]
    fn front_light(&mut self, span: &Span, planes: V::M, front: &Front<V>) -> [V::F; 3] {
        let simd = self.simd;
        let mut facings = [0; LANES];
        front.facing.store(&mut facings);
        let mut light = [simd.splat(0.0); 3];
        let mut left = planes.bits();

        while left != 0 {
            let facing = facings[left.trailing_zeros() as usize];
            let same = front.facing.eq(simd.splat_int(facing));
            left &= !same.bits();
            let face = self.face_light(span, FaceDirection::Side(facing as u8));
            light[0] = face[0].select(same, light[0]);
            light[1] = face[1].select(same, light[1]);
            light[2] = face[2].select(same, light[2]);
        }

        light
    }

    /// Whether façades at these depths (metres) show in some of `planes` and of these rows.
    #[inline(always)]
    fn shows_facades(&self, planes: V::M, rows: Range<usize>, depth: V::F) -> bool {
        let simd = self.simd;
        let mut lowest = f32::INFINITY;
        for row in rows {
            let [low, high] = row_edges(self.edges, row);
            lowest = lowest.min(high - low);
        }
        (planes & (simd.splat(lowest) * depth).lt(simd.splat(FacadePattern::FADED))).any()
    }

    /// The façade of the front in the first of some planes, and those of them that it holds for.
    #[inline(always)]
    fn facade(
        &self,
        span: &Span,
        planes: u16,
        front: &Front<V>,
        lanes: &FrontLanes<V>,
    ) -> (u16, Option<FacadeFront<'c, V>>) {
        let simd = self.simd;
        let mut facings = [0; LANES];
        front.facing.store(&mut facings);
        let facing = facings[planes.trailing_zeros() as usize];
        let same = front.facing.eq(simd.splat_int(facing)).bits() & planes;
        let centre = centre(&self.metric.grid, self.page, self.voxel, self.metric.shift);
        let wall = FacedWall { span, facing: facing as u8, centre };
        let Self { metric, lanes: planes, edges, .. } = *self;
        (same, simd.call(FrontLook { simd, metric, wall: &wall, front: lanes, lanes: planes, edges }))
    }

    /// Finds inverse depth along an end of a span, and its rise to the next plane; where the end is not seen, those of the front.
    ///
    /// Inverse depth along an end is linear in the tangent; its slope follows from the height of the end, carried on to the eye, above the eye.
    #[inline(always)]
    fn along(
        &self,
        end: &SlopedEnd<V>,
        is_seen: V::M,
        depth: [V::F; 2],
        inverse: [V::F; 2],
        front: V::F,
    ) -> (LinearTerm<V>, V::F) {
        let zero = self.simd.splat(0.0);
        let SlopedEnd { height, slope, rise, far } = *end;
        let at_eye = if slope == [0.0; 2] {
            height
        } else {
            height + (rise[0] * depth[1] - rise[1] * depth[0]) / (depth[1] - depth[0])
        };
        let goes_on = is_seen & (at_eye.lt(zero) | zero.lt(at_eye));
        let per_tangent = self.simd.splat(1.0) / at_eye;
        let across = if self.coverage.has_depths() {
            let across = zero - dot(self.simd, slope, self.lanes.beside) * per_tangent;
            across.select(goes_on, front)
        } else {
            front
        };

        let term = LinearTerm {
            tangent: far,
            value: inverse[1].select(goes_on, inverse[0]),
            slope: per_tangent.select(goes_on, zero),
        };
        (term, across)
    }
}

/// Upper or lower end of a span.
struct SlopedEnd<V: Simd> {
    /// Height over the eye in the voxel's middle, metres.
    height: V::F,
    /// Rise for each side of a voxel eastward and northward, metres.
    slope: [f32; 2],
    /// Rise from there to where planes enter and leave, metres.
    rise: [V::F; 2],
    /// Tangent where they leave.
    far: V::F,
}

/// Between which tangents an upper end lies above the ground, of which the tangents at its near and at its far end are known: both are linear in inverse
/// depth. A roof may go on into a slope, and come out of one.
#[inline(always)]
fn above_ground<V: Simd>(simd: V, [near, far]: [V::F; 2], horizon: [V::F; 2]) -> [V::F; 2] {
    let zero = simd.splat(0.0);
    let [never, always] = [f32::INFINITY, f32::NEG_INFINITY].each(|bound| simd.splat(bound));
    let above = [near - horizon[0], far - horizon[1]];
    let crossing = (far - near).mul_add(above[0] / (above[0] - above[1]), near);
    let is_above = [zero.le(above[0]), zero.le(above[1])];
    let emerges = always.select(is_above[0], crossing.select(is_above[1], never));
    let submerges = never.select(is_above[1], crossing.select(is_above[0], always));
    [emerges, submerges]
}

/// Places between the two ends of ways, at shares of these.
#[inline(always)]
fn between<V: Simd>([near, far]: [[V::F; 2]; 2], share: V::F) -> [V::F; 2] {
    [mix::<V>([near[0], far[0]], share), mix::<V>([near[1], far[1]], share)]
}

#[inline(always)]
fn mix<V: Simd>([near, far]: [V::F; 2], share: V::F) -> V::F {
    (far - near).mul_add(share, near)
}
