//! The front of a span: which way it looks, and how it goes on from plane to plane.

use super::crossing::{PlaneLanes, VoxelCrossing};
use super::metric::FacetLight;
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

impl<L: FacetLight, V: Simd> VoxelCrossing<'_, '_, L, V> {
    /// Finds the walls of a span that places are nearest to: those that they lie on, if they lie on one. `None`: it has none.
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

    /// Finds the front of a span that begins at shares of the way, at places from the voxel's centre, seen at depths.
    #[inline(always)]
    pub fn front(&self, span: &Span, at: [V::F; 2], share: V::F, inverse: V::F, depth: V::F) -> Front<V> {
        let simd = self.simd;
        let (zero, seam) = (simd.splat(0.0), simd.splat(SEAM));
        let wall = self.nearest_wall(span, at);

        // The plane enters the voxel through the side that is nearest.
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

        // The voxel's side ends where its width does.
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
}

/// Values that are finite, 0 for others.
#[inline(always)]
fn finite<V: Simd>(simd: V, value: V::F) -> V::F {
    value.select(value.abs().lt(simd.splat(f32::INFINITY)), simd.splat(0.0))
}
