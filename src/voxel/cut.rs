//! Walls at which spans end within their voxel.

use std::sync::LazyLock;

/// Unit vectors (east, north) of directions in 256ths of a turn: rays ask for them at every wall.
static NORMALS: LazyLock<[[f32; 2]; 256]> = LazyLock::new(|| {
    std::array::from_fn(|facing| {
        let angle = (facing % 128) as f32 * (std::f32::consts::TAU / 256.0);
        let sign = if facing < 128 { 1.0 } else { -1.0 };
        [sign * angle.cos(), sign * angle.sin()]
    })
});

/// A half-plane of a voxel: what lies on the inner side of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Cut {
    /// Direction of the wall's outside in 256ths of a turn, counter-clockwise from east.
    pub facing: u8,
    /// Distance of the wall from the voxel's centre in that direction, in [`Self::STEPS`] steps of the voxel's side; there is
    /// nothing beyond it. Its lowest value says that there is no wall, its highest likewise, and that sides look to `facing`.
    pub(super) at: i8,
}

impl Cut {
    /// No wall: all of the voxel.
    pub const NONE: Self = Self { facing: 0, at: i8::MIN };
    /// Steps per voxel's side.
    pub const STEPS: f32 = 128.0;
    /// Distance to a voxel's side or corner within which a wall is taken to lie on it, sides of the voxel: walls are stored in steps, and those of neighbours that are one
    /// are apart by less. What shows in between is lit as the wall.
    pub const BESIDE: f64 = 0.04;
    const ROUND: i8 = i8::MAX;

    /// A wall that looks to `facing`, so many steps from the voxel's centre; at the farthest that a wall can be, beyond which there are
    /// no corners of a voxel either.
    pub fn wall(facing: u8, steps: i32) -> Self {
        let [nearest, farthest] = [i8::MIN + 1, i8::MAX - 1].map(i32::from);
        Self { facing, at: steps.clamp(nearest, farthest) as i8 }
    }

    /// All of the voxel, as part of something round whose sides look to `facing`.
    pub const fn round(facing: u8) -> Self {
        Self { facing, at: Self::ROUND }
    }

    /// Whether it is a wall.
    #[inline]
    pub fn is_wall(self) -> bool {
        self.at != i8::MIN && self.at != Self::ROUND
    }

    /// Whether it is all of the voxel and part of something round.
    #[inline]
    pub fn is_round(self) -> bool {
        self.at == Self::ROUND
    }

    /// Returns the distance of the wall from the voxel's centre, sides of the voxel.
    #[inline]
    pub fn distance(self) -> f32 {
        f32::from(self.at) / Self::STEPS
    }

    /// The direction of `facing`, (east, north). Those of opposite ones are opposite to the last bit, so that nothing is left between two parts
    /// that meet.
    #[inline]
    pub fn normal(self) -> [f32; 2] {
        NORMALS[usize::from(self.facing)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_walls_are_opposite_to_the_last_bit() {
        for facing in 0..=255_u8 {
            let [one, other] = [facing, facing.wrapping_add(128)].map(|facing| Cut::wall(facing, 0).normal());
            assert_eq!(one, other.map(|part| -part), "{facing}");
            let angle = f64::from(facing) * (std::f64::consts::TAU / 256.0);
            assert!(
                (f64::from(one[0]) - angle.cos()).abs() < 1e-6
                    && (f64::from(one[1]) - angle.sin()).abs() < 1e-6
            );
        }
    }

    #[test]
    fn walls_are_no_farther_than_their_code_tells() {
        for (steps, distance) in
            [(0, 0.0), (64, 0.5), (-90, -90.0 / 128.0), (500, 126.0 / 128.0), (-500, -127.0 / 128.0)]
        {
            let wall = Cut::wall(3, steps);
            assert!(wall.is_wall() && !wall.is_round() && wall.distance() == distance, "{steps}");
        }
        assert!(!Cut::NONE.is_wall() && !Cut::round(7).is_wall() && Cut::round(7).is_round());
    }
}
