//! Spans of a voxel, where a plane crosses them.

use super::RowTable;
use super::column::{Fill, FreeRows, Haze, LinearTerm, PlanePassage};
use super::horizon::FloatingHorizon;
use crate::raymarch::scan::spans::metric::Metric;
use crate::raymarch::scan::{FaceDirection, FacetLight};
use crate::simd::{Each, Simd, Sixteen};
use crate::voxel::{Cut, PageId, Span};

/// Distance of walls and upper ends of neighbours that are taken for one, sides of a voxel; as the reference has it.
const SEAM: f32 = Cut::BESIDE as f32;

/// Distance by which a place on a voxel's border may lie beyond a wall along it by rounding, sides of a voxel: what is seen there is the voxel's side and no wall within.
const BY_ROUNDING: f32 = 1.0e-5;

/// Spans of a voxel that are put in order together.
const MOST_SORTED: usize = 16;

/// Spans of a voxel where a plane crosses them.
pub(super) struct VoxelCrossing<'c, 'f, L, V> {
    pub simd: V,
    pub page: PageId,
    /// Column and row on the page.
    pub voxel: [u32; 2],
    pub metric: &'c Metric,
    pub column: &'c mut FreeRows,
    pub light: &'c mut L,
    pub row_table: &'f RowTable,
    /// Index of the first row.
    pub first: f32,
    /// Tangents of the middles of rows from there on.
    pub centres: &'c [Sixteen],
    /// Sides of a voxel along the ground per unit of major distance.
    pub ground: f32,
    /// Depth per distance along the ground.
    pub level: f32,
    /// Sides of a voxel eastward and northward per metre of depth, and by how much that changes to the next plane.
    pub ahead: [f32; 2],
    pub beside: [f32; 2],
    /// Floor below which the ground or nearer spans hide everything: tangent, and rows from the first one.
    pub floor: f32,
    pub hidden: f32,
    /// Major distance between the ends, units.
    pub length: f32,
    /// Entry and exit of the plane: from the voxel's centre, sides of it; and inverse depths there, 1/metres.
    pub ends: [[f32; 2]; 2],
    pub inverse: [f32; 2],
    /// Height of the datum there above the eye, with the Earth's curvature, metres.
    pub above: f32,
}

/// A wall near a place.
#[derive(Debug, Clone, Copy)]
struct Wall {
    facing: u8,
    normal: [f32; 2],
    /// Distance of the place before the wall, sides of a voxel.
    before: f32,
    /// Beyond it the same thing goes on.
    is_joint: bool,
}

impl<L: FacetLight, V: Simd> VoxelCrossing<'_, '_, L, V> {
    /// Whether a span's upper end lies below the eye, which is at a place from the voxel's centre, sides of it.
    #[inline(always)]
    fn is_below(&self, span: &Span, eye: [f32; 2]) -> bool {
        let Metric { scale, spacing, .. } = *self.metric;
        let rise = if span.slope == [0, 0] { 0.0 } else { dot(span.slopes(), eye) * spacing };
        scale * f32::from(span.high) + self.above + rise <= 0.0
    }

    /// Looks at the spans of the voxel.
    #[inline(always)]
    pub fn look_at(&mut self, spans: &[Span], ground: &mut FloatingHorizon<'_>) {
        let Metric { scale, spacing, .. } = *self.metric;
        let rise_per_step = 0.5 * spacing / Span::SLOPE_STEPS;

        // Of two above each other the upper is met first from above the plane between them, the lower from below: outward from the eye, as ends that slope go on to it.
        let eye = [0, 1].each(|axis| self.ends[0][axis] - self.ahead[axis] / self.inverse[0]);
        // The steps of `slice::partition_point`, whose closure would be a function of its own without the instruction set. Spans that stand beside
        // each other have no order, so which of them are looked at matters.
        let (mut first, mut size) = (0, spans.len());
        while size > 1 {
            let half = size / 2;
            first += if self.is_below(&spans[first + half], eye) { half } else { 0 };
            size -= half;
        }
        first += usize::from(size > 0 && self.is_below(&spans[first], eye));
        let mut outward = spans[first..].iter().chain(spans[..first].iter().rev());
        let Some(any) = spans.first() else { return };
        let mut met = [([0.0_f32; 2], any); MOST_SORTED];

        loop {
            let mut count = 0;
            while count < MOST_SORTED
                && let Some(span) = outward.next()
            {
                let steepest =
                    f32::from(span.slope[0].unsigned_abs()) + f32::from(span.slope[1].unsigned_abs());
                let top = scale * f32::from(span.high) + self.above + steepest * rise_per_step;
                if top * self.inverse[usize::from(top < 0.0)] <= self.floor {
                    continue;
                }

                let Some(shares) = self.within(span) else { continue };
                // Halves of a ridge stand beside each other in one voxel: the nearer one comes first.
                let mut at = count;
                while at > 0 && met[at - 1].0[0] > shares[0] {
                    met[at] = met[at - 1];
                    at -= 1;
                }

                met[at] = (shares, span);
                count += 1;
            }

            for (shares, span) in &met[..count] {
                self.meet(span, *shares, ground);
            }
            if count < MOST_SORTED {
                return;
            }
        }
    }

    /// Returns the number of rows below a tangent; rows that are hidden do not matter.
    #[inline(always)]
    fn row(&self, tangent: f32) -> f32 {
        if tangent <= self.floor { self.hidden } else { self.row_table.rows_below(tangent) - self.first }
    }

    /// Fills what is seen of a span, of which the plane crosses a part between two shares of the way through the voxel.
    #[inline(always)]
    fn meet(&mut self, span: &Span, cut: [f32; 2], ground: &mut FloatingHorizon<'_>) {
        let Metric { scale, spacing, .. } = *self.metric;
        let between = |[near, far]: [f32; 2], share: f32| near + (far - near) * share;

        // Inverse depth is not linear in the distance, but 1 / it is.
        let inverse = cut.each(|share| match share {
            0.0 => self.inverse[0],
            1.0 => self.inverse[1],
            _ => 1.0 / between(self.inverse.each(|inverse| 1.0 / inverse), share),
        });
        let [[east, north], [far_east, far_north]] = self.ends;
        let (easts, norths) = ([east, far_east], [north, far_north]);
        let at = [
            [between(easts, cut[0]), between(norths, cut[0])],
            [between(easts, cut[1]), between(norths, cut[1])],
        ];
        let slope = span.slopes();
        let rise = at.each(|at| (slope[0] * at[0] + slope[1] * at[1]) * spacing);
        let top = scale * f32::from(span.high) + self.above;
        let [top_near, top_far] = [0, 1].each(|end| (top + rise[end]) * inverse[end]);
        let highest = top_near.max(top_far);
        let low_end = scale * f32::from(span.low) + self.above;
        let low_rise = if span.is(Span::PARALLEL) { rise } else { [0.0; 2] };
        let lows =
            (span.low != Span::GROUND).then(|| [0, 1].each(|end| (low_end + low_rise[end]) * inverse[end]));
        let lowest = lows.map_or(f32::NEG_INFINITY, |[near, far]| near.min(far));
        let high_row = self.row(highest);
        if highest <= self.floor || self.column.is_full(self.row(lowest), high_row) {
            return;
        }

        let horizon = ground.at(inverse[0]);
        let [low_near, low_far] = lows.unwrap_or([horizon; 2]);
        let wall = self.wall(span, at[0]);
        let (facet, seam) = self.front(span, wall, cut[0], at[0]);

        // The rim of the front that is lit as the upper end is.
        let rim = top_near - seam * spacing * inverse[0];
        let side = [low_near.max(horizon), rim.max(low_near)];
        let is_top_seen = top_far > top_near;

        let [emerges, submerges] = match is_top_seen {
            // Right below the eye no ground is seen that near: what hides the roof there would hide it from all rows.
            true if horizon <= ground.lowest() => [f32::NEG_INFINITY, f32::INFINITY],
            true => above_ground([top_near, top_far], [horizon, ground.beyond(inverse[1])]),
            false => [f32::NEG_INFINITY, f32::INFINITY],
        };
        let upper = [rim.max(low_near).max(horizon).max(emerges), highest.min(submerges)];
        let lower = [low_far.max(horizon), low_near];

        // Along an end inverse depth is linear in the tangent: by as much as the end lies above the eye where it goes on to it.
        let depth = inverse.each(|inverse| 1.0 / inverse);
        let has_depths = self.column.has_depths();
        let turning = if has_depths { self.turning(wall, cut[0], at[0], depth[0]) } else { 0.0 };
        let front = (LinearTerm::level(inverse[0]), inverse[0] * turning);

        let along = |height: f32, slope: [f32; 2], rise: [f32; 2], far: f32, is_seen: bool| {
            let at_eye = height + (rise[0] * depth[1] - rise[1] * depth[0]) / (depth[1] - depth[0]);
            if !is_seen || at_eye == 0.0 {
                return front;
            }
            let across = if has_depths { -dot(slope, self.beside) * spacing / at_eye } else { 0.0 };
            (LinearTerm::new(far, inverse[1], 1.0 / at_eye), across)
        };

        let low_slope = if span.is(Span::PARALLEL) { slope } else { [0.0; 2] };
        let bounds = [inverse[1], inverse[0]];
        let bottom = lows.unwrap_or([f32::NEG_INFINITY; 2]);
        let passage = PlanePassage { inverse, top: [top_near, top_far], bottom };
        let opacity = span.state & Span::OPACITY;
        let mut known = (highest, high_row);

        for (face, tangents) in [side, upper, lower].into_iter().enumerate() {
            let [low, high] = tangents;
            if low >= high || high <= self.floor {
                continue;
            }

            let high_row = if high >= highest { high_row } else { self.row(high) };
            // The upper end begins where the front ends.
            let low_row = if low == known.0 { known.1 } else { self.row(low) };
            known = (high, high_row);
            if low_row >= high_row || self.column.is_full(low_row, high_row) {
                continue;
            }

            let (facet, (inverse, across)) = match face {
                0 => (facet, front),
                1 => (FaceDirection::Top(span.slope), along(top, slope, rise, top_far, is_top_seen)),
                _ => {
                    (FaceDirection::Bottom, along(low_end, low_slope, low_rise, low_far, low_far < low_near))
                }
            };
            let light = self.light.light(self.page, self.voxel, span, facet);

            let haze = (opacity < Span::OPAQUE).then(|| {
                let sides = match span.is(Span::STRIP) {
                    true => f32::from(span.thickness()) * scale / spacing,
                    false => 1.0,
                };
                let way = self.ground * self.length * (cut[1] - cut[0]) / sides;
                let clearness = self.metric.clearness[usize::from(opacity)] * way;
                Haze { clearness, level: self.level, tangents, passage }
            });

            let fill = Fill { haze, inverse, across, bounds, front: front.1 };
            self.column.fill(self.simd, [low_row, high_row], light, &fill, self.centres);
        }
    }

    /// Returns the share of itself by which the inverse depth of a span's front, which is seen at a depth, rises to the next plane.
    ///
    /// A wall goes on in the next voxel. A side of a voxel may end with it: half of the way to the next plane is to end there, too.
    #[inline(always)]
    fn turning(&self, wall: Option<Wall>, share: f32, at: [f32; 2], depth: f32) -> f32 {
        let finite = |turning: f32| if turning.is_finite() { turning } else { 0.0 };
        if let Some(Wall { normal, .. }) = wall
            && share > 0.0
        {
            return finite(dot(normal, self.beside) / dot(normal, self.ahead));
        }
        let (through, along) = if at[0].abs() >= at[1].abs() { (0, 1) } else { (1, 0) };
        let turning = finite(self.beside[through] / self.ahead[through]);
        let step = depth * (self.beside[along] - self.ahead[along] * turning);
        let room = (0.5 - at[along].abs()).max(0.0);
        turning * (2.0 * room / step.abs()).min(1.0)
    }

    /// Shares of the way through the voxel between which the plane lies within a span's walls.
    #[inline(always)]
    fn within(&self, span: &Span) -> Option<[f32; 2]> {
        let mut within = [0.0, 1.0];
        for (index, cut) in span.cuts.iter().enumerate() {
            if !cut.is_wall() {
                break;
            }
            let normal = self.metric.directions[usize::from(cut.facing)];
            let beyond = self.ends.each(|at| dot(normal, at) - cut.distance() - BY_ROUNDING);
            if index == 0 && span.is(Span::STRIP) {
                let steps = self.metric.scale / self.metric.spacing;
                let half = 0.5 * f32::from(span.high - span.low.min(span.high)) * steps;
                within = clip(within, beyond.each(|beyond| beyond - half))?;
                within = clip(within, beyond.each(|beyond| -beyond - half))?;
            } else {
                within = clip(within, beyond)?;
            }
        }
        Some(within)
    }

    /// The wall of a span that a place within is nearest to: the one that it lies on, if it lies on one.
    #[inline(always)]
    fn wall(&self, span: &Span, at: [f32; 2]) -> Option<Wall> {
        let wall = |index: usize| {
            let cut = span.cuts[index];
            let normal = self.metric.directions[usize::from(cut.facing)];
            let is_joint = span.is_joined(index);
            Wall { facing: cut.facing, normal, before: cut.distance() - dot(normal, at), is_joint }
        };
        let nearer = |one: Wall, other: Wall| if other.before < one.before { other } else { one };
        match span.cuts.each(Cut::is_wall) {
            [false, ..] => None,
            [true, false, _] => Some(wall(0)),
            [true, true, false] => Some(nearer(wall(0), wall(1))),
            [true, true, true] => Some(nearer(nearer(wall(0), wall(1)), wall(2))),
        }
    }

    /// Returns the orientation of a span's front that begins at a share of the way, `at` from the voxel's centre, and how much of it below its upper rim is
    /// lit as the upper end, sides of a voxel. `wall` is the nearest one.
    #[inline(always)]
    fn front(&self, span: &Span, wall: Option<Wall>, share: f32, at: [f32; 2]) -> (FaceDirection, f32) {
        if let Some(wall) = wall
            && share > 0.0
        {
            return (FaceDirection::Side(wall.facing), if wall.is_joint { SEAM } else { 0.0 });
        }
        if span.cuts[0].is_round() {
            return (FaceDirection::Side(span.cuts[0].facing), SEAM);
        }
        if let Some(wall) = wall
            && wall.before < SEAM
        {
            return (FaceDirection::Side(wall.facing), SEAM);
        }

        // Of the voxel's sides the one that the plane enters through.
        let facing = if at[0].abs() >= at[1].abs() {
            if at[0] > 0.0 { 0 } else { 128 }
        } else if at[1] > 0.0 {
            64
        } else {
            192
        };

        (FaceDirection::Side(facing), SEAM)
    }
}

/// Between which tangents an upper end lies above the ground, of which the tangents at its near and at its far end are known: both are linear in inverse
/// depth. A roof may go on into a slope, and come out of one.
#[inline(always)]
fn above_ground([near, far]: [f32; 2], horizon: [f32; 2]) -> [f32; 2] {
    let above = [near - horizon[0], far - horizon[1]];
    let crossing = || near + (far - near) * (above[0] / (above[0] - above[1]));
    match above.each(|above| above >= 0.0) {
        [true, true] => [f32::NEG_INFINITY, f32::INFINITY],
        [true, false] => [f32::NEG_INFINITY, crossing()],
        [false, true] => [crossing(), f32::INFINITY],
        [false, false] => [f32::INFINITY, f32::NEG_INFINITY],
    }
}

/// Clips a range of shares to where `beyond`, linear from share 0 to 1, is not positive.
#[inline(always)]
fn clip([from, to]: [f32; 2], [first, last]: [f32; 2]) -> Option<[f32; 2]> {
    if first <= 0.0 && last <= 0.0 {
        return Some([from, to]);
    }
    if first > 0.0 && last > 0.0 {
        return None;
    }
    let crossing = first / (first - last);
    let clipped = if first > 0.0 { [from.max(crossing), to] } else { [from, to.min(crossing)] };
    (clipped[0] < clipped[1]).then_some(clipped)
}

#[inline(always)]
fn dot(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}
