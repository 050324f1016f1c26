//! Spans of a voxel, where planes cross them.

use super::coverage::SpanCoverage;
use super::fill::{Fill, Haze, LinearTerm, PlanePassage};
use super::horizon::FloatingHorizon;
use super::metric::{FaceDirection, FacetLight, LEAST_DISTANCE, Metric};
use crate::raymarch::scan::RowCoordinate;
use crate::simd::{Each, Floats, Ints, LANES, Mask, Simd};
use crate::voxel::{Cut, PageId, Span};

/// Distance of walls and upper ends of neighbours that are taken for one, sides of a voxel; as the reference has it.
const SEAM: f32 = Cut::BESIDE as f32;

/// Distance by which a place on a voxel's border may lie beyond a wall along it by rounding, sides of a voxel: what is seen there is the voxel's side and no wall within.
const BY_ROUNDING: f32 = 1.0e-5;

/// Spans of a voxel that are put in order together.
const MOST_SORTED: usize = 16;

/// Planes as the voxels that they cross see them.
#[derive(Clone, Copy)]
pub(super) struct PlaneLanes<V: Simd> {
    /// Metres of depth per unit of major distance.
    pub depth: V::F,
    /// Curvature's drop per squared unit of major distance, metres.
    pub drop: V::F,
    /// Height of the datum above the eye, metres.
    pub datum: V::F,
    /// Sides of a voxel along the ground per unit of major distance.
    pub ground: V::F,
    /// Depth per distance along the ground.
    pub level: V::F,
    /// Sides of a voxel eastward and northward per metre of depth, and by how much that changes to the next plane.
    pub ahead: [V::F; 2],
    pub beside: [V::F; 2],
}

/// What hides all below it, of each plane.
#[derive(Clone, Copy)]
pub(super) struct Floor<V: Simd> {
    /// Tangent, and the rows below it.
    pub tangent: V::F,
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
    pub row_coordinate: RowCoordinate,
    /// Index of the first row.
    pub first: f32,
    /// Tangents of the middles of rows from there on.
    pub centres: &'c [f32],
    pub lanes: &'c PlaneLanes<V>,
    pub floor: Floor<V>,
    pub horizon: &'c FloatingHorizon<'p, V>,
    /// Major distance between the ends, units.
    pub length: V::F,
    /// Entry and exit of the planes: from the voxel's centre, sides of it; and inverse depths there, 1/metres.
    pub ends: [[V::F; 2]; 2],
    pub inverse: [V::F; 2],
    /// Height of the datum there above the eye, with the Earth's curvature, metres; and about that of all planes.
    pub above: V::F,
    pub about: f32,
    /// Place of the eye from the voxel's centre, sides of it.
    pub eye: [f32; 2],
}

/// Span that planes meet, and between which shares of their ways through the voxel.
#[derive(Clone, Copy)]
pub(super) struct MetSpan<'s, V: Simd> {
    pub span: &'s Span,
    pub planes: V::M,
    pub shares: [V::F; 2],
}

/// The walls of a span that are nearest to places.
struct NearestWall<V: Simd> {
    /// Direction that it looks in, 256ths of a turn.
    facing: V::I,
    normal: [V::F; 2],
    /// Distance of the place before the wall, sides of a voxel.
    before: V::F,
    /// Beyond it the same thing goes on.
    is_joint: V::M,
}

impl<V: Simd> PlaneLanes<V> {
    /// Inverse depths at major distances, 1/metres.
    #[inline(always)]
    pub fn inverse(&self, simd: V, distance: V::F) -> V::F {
        (self.depth * distance.max(simd.splat(LEAST_DISTANCE as f32))).recip()
    }

    /// Heights of the datum above the eye at major distances, with the Earth's curvature, metres.
    #[inline(always)]
    pub fn datum(&self, distance: V::F) -> V::F {
        (self.drop * distance).neg_mul_add(distance, self.datum)
    }
}

impl<L: FacetLight, V: Simd> VoxelCrossing<'_, '_, L, V> {
    /// Whether a span's upper end lies below the eye.
    #[inline(always)]
    fn is_below(&self, span: &Span) -> bool {
        let Metric { scale, spacing, .. } = *self.metric;
        let slope = span.slopes();
        let rise = (slope[0] * self.eye[0] + slope[1] * self.eye[1]) * spacing;
        scale * f32::from(span.high) + self.about + rise <= 0.0
    }

    /// Looks at the spans of the voxel.
    #[inline(always)]
    pub fn look_at(&mut self, planes: V::M, spans: &[Span]) {
        let simd = self.simd;
        // Of two above each other the upper is met first from above the plane between them, the lower from below: outward from the eye, as ends that slope go on to it.
        // The steps of `slice::partition_point`, whose closure would be a function of its own without the instruction set. Spans that stand beside
        // each other have no order, so which of them are looked at matters.
        let (mut first, mut size) = (0, spans.len());
        while size > 1 {
            let half = size / 2;
            first += if self.is_below(&spans[first + half]) { half } else { 0 };
            size -= half;
        }
        first += usize::from(size > 0 && self.is_below(&spans[first]));
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

            // Halves of a ridge stand beside each other in one voxel: the nearer one comes first.
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
        [self.dot(normal, near) - distance, self.dot(normal, far) - distance]
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
        let rows = self.row_coordinate.rows_below(self.simd, tangents) - self.simd.splat(self.first);
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
            let [near, far] = self.ends;
            let place =
                |share: V::F| [mix::<V>([near[0], far[0]], share), mix::<V>([near[1], far[1]], share)];
            (depth, [depth[0].recip(), depth[1].recip()], [place(shares[0]), place(shares[1])])
        } else {
            (depth, self.inverse, self.ends)
        };

        // Heights of both ends over the eye where the planes enter and leave.
        let top = simd.splat(scale * f32::from(span.high)) + self.above;
        let slope = span.slopes();
        let is_sloped = span.slope != [0; 2];
        let metric = slope.each(|slope| slope * spacing);
        let rise = if is_sloped { [self.dot(metric, at[0]), self.dot(metric, at[1])] } else { [zero; 2] };
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
        let front = self.front(span, at[0], shares[0], inverse[0], depth[0]);

        // The rim of the front that is lit as the upper end is.
        let rim = (front.seam * simd.splat(spacing)).neg_mul_add(inverse[0], top_near);
        let side = [low_near.max(horizon), rim.max(low_near)];
        let is_top_seen = planes & top_near.lt(top_far);

        // Right below the eye no ground is seen that near: what hides the roof there would hide it from all rows.
        let mut upper = [rim.max(low_near).max(horizon), highest];
        let is_grounded = is_top_seen & simd.splat(self.horizon.lowest()).lt(horizon);
        if is_grounded.any() {
            let beyond = self.horizon.at(simd, planes, inverse[1]);
            let [emerges, submerges] = above_ground::<V>(simd, [top_near, top_far], [horizon, beyond]);
            upper = [
                upper[0].max(emerges).select(is_grounded, upper[0]),
                upper[1].min(submerges).select(is_grounded, upper[1]),
            ];
        }

        let lower = [low_far.max(horizon), low_near];
        let is_bottom_seen = planes & low_far.lt(low_near);
        let level = LinearTerm { tangent: zero, value: inverse[0], slope: zero };
        let bottom = if hangs { lows } else { [simd.splat(f32::NEG_INFINITY); 2] };
        let passage = PlanePassage { inverse, top: [top_near, top_far], bottom };
        let opacity = span.state & Span::OPACITY;

        for (face, tangents) in [side, upper, lower].into_iter().enumerate() {
            let [low, high] = tangents;
            let seen = planes & low.lt(high) & self.floor.tangent.lt(high);
            if !seen.any() {
                continue;
            }
            let places = [self.rows(low), self.rows(high)];
            let seen = seen & places[0].lt(places[1]);
            let rows = self.coverage.rows_between(simd, seen, places);
            if !self.coverage.has_open(seen.bits(), rows.clone()) {
                continue;
            }

            let (light, (linear, across)) = match face {
                0 => (self.front_light(span, seen, &front), (level, front.across)),
                1 => {
                    let end = SlopedEnd { height: top, slope: metric, rise, far: top_far };
                    (
                        self.face_light(span, FaceDirection::Top(span.slope)),
                        self.along(&end, is_top_seen, depth, inverse, front.across),
                    )
                }
                _ => {
                    let slope = if span.is(Span::PARALLEL) { metric } else { [0.0; 2] };
                    let end = SlopedEnd { height: low_end, slope, rise: low_rise, far: low_far };
                    (
                        self.face_light(span, FaceDirection::Bottom),
                        self.along(&end, is_bottom_seen, depth, inverse, front.across),
                    )
                }
            };

            let haze = (opacity < Span::OPAQUE).then(|| {
                let sides = match span.is(Span::STRIP) {
                    true => f32::from(span.thickness()) * scale / spacing,
                    false => 1.0,
                };
                let way = self.lanes.ground * self.length * (shares[1] - shares[0]);
                let clearness = way * simd.splat(self.metric.clearness[usize::from(opacity)] / sides);
                Haze { clearness, level: self.lanes.level, tangents, passage }
            });

            let bounds = [inverse[1], inverse[0]];
            let fill = Fill { light, haze, inverse: linear, across, bounds, front: front.across };
            self.coverage.fill(simd, seen.bits(), rows, places, &fill, self.centres);
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

    /// How inverse depth goes along an end of a span: linear in the tangent, by as much as the end lies above the eye where it goes on to it; and the
    /// rise to the next plane. Where the end is not seen, as on the front.
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
            let across = zero - self.dot(slope, self.lanes.beside) * per_tangent;
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

    /// The walls of a span that places within are nearest to: those that they lie on, if they lie on one. `None`: it has none.
    #[inline(always)]
    fn nearest_wall(&self, span: &Span, at: [V::F; 2]) -> Option<NearestWall<V>> {
        let simd = self.simd;
        let mut nearest: Option<NearestWall<V>> = None;
        for (index, cut) in span.cuts.iter().enumerate() {
            if !cut.is_wall() {
                break;
            }
            let normal = self.metric.directions[usize::from(cut.facing)];
            let before = simd.splat(cut.distance()) - self.dot(normal, at);
            let normal = normal.each(|part| simd.splat(part));
            let facing = simd.splat_int(i32::from(cut.facing));
            let is_joint = simd.mask(if span.is_joined(index) { u16::MAX } else { 0 });
            nearest = Some(match nearest {
                None => NearestWall { facing, normal, before, is_joint },
                Some(other) => {
                    let nearer = before.lt(other.before);
                    NearestWall {
                        facing: facing.select(nearer, other.facing),
                        normal: [
                            normal[0].select(nearer, other.normal[0]),
                            normal[1].select(nearer, other.normal[1]),
                        ],
                        before: before.min(other.before),
                        is_joint: (is_joint & nearer) | (other.is_joint & !nearer),
                    }
                }
            });
        }
        nearest
    }

    /// The front of a span that begins at shares of the way, at places from the voxel's centre, seen at depths.
    #[inline(always)]
    fn front(&self, span: &Span, at: [V::F; 2], share: V::F, inverse: V::F, depth: V::F) -> Front<V> {
        let simd = self.simd;
        let (zero, seam) = (simd.splat(0.0), simd.splat(SEAM));
        let wall = self.nearest_wall(span, at);

        // Of the voxel's sides the one that the plane enters through.
        let [east, north] = at;
        let through_east = north.abs().le(east.abs());
        let sides = [0, 128, 64, 192].each(|facing| simd.splat_int(facing));
        let side = sides[0].select(zero.lt(east), sides[1]);
        let side = side.select(through_east, sides[2].select(zero.lt(north), sides[3]));

        let (facing, seam) = if span.cuts[0].is_round() {
            (simd.splat_int(i32::from(span.cuts[0].facing)), seam)
        } else if let Some(wall) = &wall {
            // On a wall, or beside one.
            let is_on = zero.lt(share);
            let facing = wall.facing.select(is_on | wall.before.lt(seam), side);
            (facing, zero.select(is_on & !wall.is_joint, seam))
        } else {
            (side, seam)
        };

        let across = if self.coverage.has_depths() {
            inverse * self.turning(wall.as_ref(), share, at, depth)
        } else {
            zero
        };
        Front { facing, seam, across }
    }

    /// Returns the share of itself by which the inverse depth of a span's front, which is seen at a depth, rises to the next plane.
    ///
    /// A wall goes on in the next voxel. A side of a voxel may end with it: half of the way to the next plane is to end there, too.
    #[inline(always)]
    fn turning(&self, wall: Option<&NearestWall<V>>, share: V::F, at: [V::F; 2], depth: V::F) -> V::F {
        let simd = self.simd;
        let (zero, half, one) = (simd.splat(0.0), simd.splat(0.5), simd.splat(1.0));
        let PlaneLanes { ahead, beside, .. } = *self.lanes;
        let through_east = at[1].abs().le(at[0].abs());
        let through = [ahead, beside].each(|way| way[0].select(through_east, way[1]));
        let along = [ahead, beside].each(|way| way[1].select(through_east, way[0]));
        let turning = finite::<V>(simd, through[1] / through[0]);
        let step = depth * turning.neg_mul_add(along[0], along[1]);
        let room = (half - at[1].select(through_east, at[0]).abs()).max(zero);
        let side = turning * ((room + room) / step.abs()).min(one);

        match wall {
            Some(NearestWall { normal, .. }) => {
                let [ahead, beside] =
                    [ahead, beside].each(|way| normal[0].mul_add(way[0], normal[1] * way[1]));
                finite::<V>(simd, beside / ahead).select(zero.lt(share), side)
            }
            None => side,
        }
    }

    #[inline(always)]
    fn dot(&self, [east, north]: [f32; 2], at: [V::F; 2]) -> V::F {
        at[0].mul_add(self.simd.splat(east), at[1] * self.simd.splat(north))
    }
}

/// The front of a span.
struct Front<V: Simd> {
    /// Direction that it looks in, 256ths of a turn.
    facing: V::I,
    /// How much of it below its upper rim is lit as the upper end, sides of a voxel.
    seam: V::F,
    /// Rise of its inverse depth to the next plane, 1/metres.
    across: V::F,
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

/// Finds the span that planes are to meet next, and these planes: each meets what begins nearest, of spans that begin together the first one. `None`: none is
/// left.
#[inline(always)]
pub(super) fn next_of<V: Simd>(simd: V, met: &[Option<MetSpan<'_, V>>]) -> Option<(usize, V::M)> {
    let mut nearest = simd.splat(f32::INFINITY);
    for span in met.iter().flatten() {
        let is_nearer = span.planes & span.shares[0].lt(nearest);
        nearest = span.shares[0].select(is_nearer, nearest);
    }

    let (mut next, mut others) = (None, simd.mask(u16::MAX));
    for (index, span) in met.iter().enumerate() {
        let Some(span) = span else { continue };
        let planes = span.planes & span.shares[0].le(nearest) & others;
        others = others & !planes;
        // Best is a span that all of its planes are to meet now.
        if planes.any() {
            if !(span.planes & !planes).any() {
                return Some((index, planes));
            }
            next = next.or(Some((index, planes)));
        }
    }

    next
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

#[inline(always)]
fn mix<V: Simd>([near, far]: [V::F; 2], share: V::F) -> V::F {
    (far - near).mul_add(share, near)
}

/// Values that are finite, 0 for others.
#[inline(always)]
fn finite<V: Simd>(simd: V, value: V::F) -> V::F {
    value.select(value.abs().lt(simd.splat(f32::INFINITY)), simd.splat(0.0))
}
