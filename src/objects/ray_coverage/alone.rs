//! A shape that is alone in its pixels: sixteen pixels of a row at a time, and sixteen rays of one with an edge.

use super::{Aim, FirstHits, ONE_FACE, SeenFace, count_faces, dot, is_of, spread};
use crate::objects::PixelGround;
use crate::simd::{Floats, Kernel, LANES, Mask, Simd};

/// Corners of a pixel, from its middle.
const CORNERS: [[f32; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];

/// Rays of a pixel from its middle, pixels: a lattice with one in every sixteenth of its columns and rows.
pub(in crate::objects) const FEW: [[[f32; LANES]; 2]; 1] = {
    let mut offsets = [[0.0; LANES]; 2];
    let mut ray = 0;
    while ray < LANES {
        offsets[0][ray] = (ray as f32 + 0.5) / LANES as f32 - 0.5;
        offsets[1][ray] = ((ray * 7 % LANES) as f32 + 0.5) / LANES as f32 - 0.5;
        ray += 1;
    }
    [offsets]
};

/// Pixels around one of these rays for which it stands.
const AROUND: f32 = 0.15;

/// Looks at the middles and corners of sixteen pixels of a row.
pub(in crate::objects) struct PixelRow<'a> {
    pub aim: &'a Aim,
    /// Middles, pixels from that of the aim's pencil: to the right, and down.
    pub columns: &'a [f32; LANES],
    pub row: f32,
    /// The ground in them.
    pub ground: &'a Grounds,
    /// Looks at the corners too.
    pub corners: bool,
    pub middles: &'a mut PixelMiddles,
}

/// The ground in sixteen pixels; see [`PixelGround`].
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::objects) struct Grounds {
    pub inverse: [f32; LANES],
    pub slope: [[f32; LANES]; 2],
}

/// Sight of the middles of sixteen pixels before the ground.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::objects) struct PixelMiddles {
    /// Pixels that see something.
    pub seen: u16,
    /// Pixels of these that see one face in all corners as well.
    pub whole: u16,
    /// Metres.
    pub range: [f32; LANES],
    /// Normals, of unit length, world axes.
    pub normal: [[f32; LANES]; 3],
}

impl Kernel for PixelRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { aim, columns, row, ground, corners, middles } = self;
        let (columns, row) = (simd.load(columns), simd.splat(row));
        let inverse = simd.load(&ground.inverse);
        let slope = [simd.load(&ground.slope[0]), simd.load(&ground.slope[1])];
        let one = simd.splat(1.0);
        let (middle, seen) = aim.first(simd, [columns, row]);
        let seen = seen & (middle.at * middle.metres * inverse).lt(one);
        middles.seen = seen.bits();
        (middle.at * middle.metres).store(&mut middles.range);
        for axis in 0..3 {
            middle.normal[axis].store(&mut middles.normal[axis]);
        }

        middles.whole = 0;
        if !corners || middles.seen == 0 {
            return;
        }

        let mut whole = seen;
        for [right, down] in CORNERS {
            let (right, down) = (simd.splat(right), simd.splat(down));
            let behind = slope[1].mul_add(down, slope[0].mul_add(right, inverse));
            let (corner, seen) = aim.first(simd, [columns + right, row + down]);
            let seen = seen & (corner.at * corner.metres * behind).lt(one);
            let alike = simd.splat(ONE_FACE).le(dot::<V>(corner.normal, middle.normal));
            whole = whole & seen & alike;
        }

        middles.whole = whole.bits();
    }
}

/// Looks at a pixel with `N` times sixteen rays.
pub(in crate::objects) struct PixelRays<'a, const N: usize> {
    pub aim: &'a Aim,
    /// Rays, pixels from the middle of the pixel.
    pub rays: &'a [[[f32; LANES]; 2]; N],
    /// The pixel's middle, pixels from that of the aim's pencil.
    pub middle: [f32; 2],
    pub ground: &'a PixelGround,
    /// Output for the faces seen before the ground.
    pub faces: &'a mut Vec<SeenFace>,
}

/// Rays of the first sixteen that meet a shape.
#[derive(Debug, Clone, Copy)]
pub(in crate::objects) struct MetRays {
    pub all: u16,
    /// Rays that meet it surely before the ground, and surely behind it.
    pub before: u16,
    pub behind: u16,
}

impl<const N: usize> Kernel for PixelRays<'_, N> {
    type Output = MetRays;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> MetRays {
        let Self { aim, rays, middle, ground, faces } = self;
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let [across, along] = ground.slope;
        let around = simd.splat(AROUND * (across.abs() + along.abs()));
        let mut batches = [FirstHits::<V> { at: zero, aim: zero, normal: [zero; 3], metres: zero }; N];
        let mut met = MetRays { all: 0, before: 0, behind: 0 };

        for index in 0..N {
            let [x, y] = [simd.load(&rays[index][0]), simd.load(&rays[index][1])];
            let offsets = [x + simd.splat(middle[0]), y + simd.splat(middle[1])];
            let inverse =
                y.mul_add(simd.splat(along), x.mul_add(simd.splat(across), simd.splat(ground.inverse)));
            let (mut seen, all) = aim.first(simd, offsets);
            let range = seen.at * seen.metres;
            if index == 0 {
                let before = all & (range * (inverse + around)).lt(one);
                let behind = all & one.lt(range * (inverse - around));
                met = MetRays { all: all.bits(), before: before.bits(), behind: behind.bits() };
            }
            seen.aim = seen.aim.select((range * inverse).lt(one), simd.splat(-1.0));
            batches[index] = seen;
        }

        count_faces(simd, 0, aim.albedo, &batches, faces);
        met
    }
}

impl Aim {
    /// Finds what sixteen rays see of the body, and which of them do.
    #[inline(always)]
    fn first<V: Simd>(&self, simd: V, offsets: [V::F; 2]) -> (FirstHits<V>, V::M) {
        let zero = simd.splat(0.0);
        let direction = spread(simd, &self.direction, offsets);
        let metres = dot::<V>(direction, direction).sqrt();
        let mut seen =
            FirstHits { at: simd.splat(super::FAR), aim: simd.splat(-1.0), normal: [zero; 3], metres };
        self.look(simd, 0, offsets, &mut seen);
        (seen, is_of(&seen, zero))
    }
}
