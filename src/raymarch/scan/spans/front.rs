//! The front of a span: which way it looks, and how it goes on from plane to plane.

use super::metric::{Metric, dot};
use super::plane_lanes::PlaneLanes;
use crate::simd::{Each, Floats, Ints, Simd};
use crate::voxel::{Cut, Span};

/// Distance of walls and upper ends of neighbours that are taken for one, sides of a voxel; as the reference has it.
const SEAM: f32 = Cut::BESIDE as f32;

/// Front of a span: the wall or the side of the voxel at which planes enter it.
pub(super) struct Front<V: Simd> {
    /// Direction that it looks in, 256ths of a turn.
    pub facing: V::I,
    /// Height below its upper rim down to which it is lit as the upper end, sides of a voxel.
    pub seam: V::F,
    /// Rise of its inverse depth to the next plane, 1/metres.
    pub across: V::F,
}

/// Places where planes meet a front.
pub(super) struct FrontPlace<V: Simd> {
    /// East and north of the voxel's centre, sides of it.
    pub at: [V::F; 2],
    /// Shares of the planes' ways through the voxel; 0: where they enter it.
    pub share: V::F,
    /// Inverse depth, 1/metres, and depth, metres.
    pub inverse: V::F,
    pub depth: V::F,
}

/// Walls of a span nearest to places within it.
struct NearestWall<V: Simd> {
    /// Direction that it looks in, 256ths of a turn.
    facing: V::I,
    normal: [V::F; 2],
    /// Distance of the place before the wall, sides of a voxel.
    before: V::F,
    /// Whether the same thing goes on beyond it.
    is_joint: V::M,
}

impl<V: Simd> NearestWall<V> {
    /// Finds the walls of a span that places are nearest to: those that they lie on, if they lie on one. `None`: it has none.
    #[inline(always)]
    fn of(simd: V, metric: &Metric, span: &Span, at: [V::F; 2]) -> Option<Self> {
        let mut nearest: Option<Self> = None;

        for (index, cut) in span.cuts.iter().enumerate() {
            if !cut.is_wall() {
                break;
            }

            let normal = metric.directions[usize::from(cut.facing)];
            let before = simd.splat(cut.distance()) - dot(simd, normal, at);
            let normal = normal.each(|part| simd.splat(part));
            let facing = simd.splat_int(i32::from(cut.facing));
            let is_joint = simd.mask(if span.is_joined(index) { u16::MAX } else { 0 });
            nearest = Some(match nearest {
                None => Self { facing, normal, before, is_joint },
                Some(other) => {
                    let nearer = before.lt(other.before);
                    Self {
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
}

impl<V: Simd> Front<V> {
    /// Finds the front of a span. How it goes on to the next plane is found if `lanes` are given.
    #[inline(always)]
    pub fn of(
        simd: V,
        metric: &Metric,
        span: &Span,
        place: &FrontPlace<V>,
        lanes: Option<&PlaneLanes<V>>,
    ) -> Self {
        let (zero, seam) = (simd.splat(0.0), simd.splat(SEAM));
        let wall = NearestWall::of(simd, metric, span, place.at);

        // The plane enters the voxel through the side that is nearest.
        let [east, north] = place.at;
        let through_east = north.abs().le(east.abs());
        let sides = [0, 128, 64, 192].each(|facing| simd.splat_int(facing));
        let side = sides[0].select(zero.lt(east), sides[1]);
        let side = side.select(through_east, sides[2].select(zero.lt(north), sides[3]));

        let (facing, seam) = if span.cuts[0].is_round() {
            (simd.splat_int(i32::from(span.cuts[0].facing)), seam)
        } else if let Some(wall) = &wall {
            // On a wall, or beside one.
            let is_on = zero.lt(place.share);
            let facing = wall.facing.select(is_on | wall.before.lt(seam), side);
            (facing, zero.select(is_on & !wall.is_joint, seam))
        } else {
            (side, seam)
        };

        let across = match lanes {
            Some(lanes) => place.inverse * place.turning(simd, wall.as_ref(), lanes),
            None => zero,
        };
        Self { facing, seam, across }
    }
}

impl<V: Simd> FrontPlace<V> {
    /// Returns the share of itself by which the inverse depth of the front rises to the next plane.
    ///
    /// A wall goes on in the next voxel. A side of a voxel may end with it: half of the way to the next plane is to end there, too.
    #[inline(always)]
    fn turning(&self, simd: V, wall: Option<&NearestWall<V>>, lanes: &PlaneLanes<V>) -> V::F {
        let (zero, half, one) = (simd.splat(0.0), simd.splat(0.5), simd.splat(1.0));
        let PlaneLanes { ahead, beside, .. } = *lanes;
        let [east, north] = self.at;
        let through_east = north.abs().le(east.abs());
        let through = [ahead, beside].each(|way| way[0].select(through_east, way[1]));
        let along = [ahead, beside].each(|way| way[1].select(through_east, way[0]));

        // The voxel's side ends where its width does.
        let turning = finite::<V>(simd, through[1] / through[0]);
        let step = self.depth * turning.neg_mul_add(along[0], along[1]);
        let room = (half - north.select(through_east, east).abs()).max(zero);
        let side = turning * ((room + room) / step.abs()).min(one);

        match wall {
            Some(NearestWall { normal, .. }) => {
                let [ahead, beside] =
                    [ahead, beside].each(|way| normal[0].mul_add(way[0], normal[1] * way[1]));
                finite::<V>(simd, beside / ahead).select(zero.lt(self.share), side)
            }
            None => side,
        }
    }
}

/// Values that are finite, 0 for others.
#[inline(always)]
fn finite<V: Simd>(simd: V, value: V::F) -> V::F {
    value.select(value.abs().lt(simd.splat(f32::INFINITY)), simd.splat(0.0))
}
