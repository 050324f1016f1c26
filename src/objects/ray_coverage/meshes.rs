//! Rays of pixels in which meshes are: by triangles, with a colour of its own for each ray.

use glam::Vec3;

use super::{
    ALL, Aim, FirstHits, LANES, Lanes, ONE_FACE, Pencil, RAYS, SLOW, SeenFace, begin_rays, dot, is_of,
    lane_of, total,
};
use crate::objects::mesh::Facet;
use crate::objects::{Mesh, PixelGround};
use crate::simd::{Floats, Kernel, Mask, Simd, Sixteen};

/// Faces that what is seen of a mesh in a pixel is lit as, at most.
const MOST_FACES: usize = 8;

/// Part of a pixel's footprint that one of its rays stands for, where a texture is filtered: rays overlap a little.
const RAY_PART: f32 = 0.16;

/// The same of sixteen rays, which lie in a strip of a sixth of the pixel: between its width and its height.
const STRIP_PART: f32 = 0.4;

/// A mesh before a pencil.
#[derive(Debug, Clone)]
pub(in crate::objects) struct MeshPatch<'m> {
    pub mesh: &'m Mesh,
    /// Facets of this mesh among all of the pixel.
    pub facets: std::ops::Range<usize>,
    /// Way at which the facets' own begin, and factor to multiples of the pencil's direction.
    pub begin: f32,
    pub ratio: f32,
    /// Metres across a pixel: per way, and besides.
    pub footprint: [f32; 2],
    /// Albedo of the body.
    pub albedo: Vec3,
    /// Number of items before it whose bodies have a higher priority.
    pub higher: usize,
    /// Columns: the body's axes in the world.
    pub axes: [Vec3; 3],
}

/// Something before a pencil.
#[derive(Debug, Clone)]
pub(in crate::objects) enum MeshItem<'m> {
    Shape(Aim),
    Mesh(MeshPatch<'m>),
}

/// [`super::Count`] for pixels with meshes.
pub(in crate::objects) struct CountAll<'a> {
    /// Bodies by rank.
    pub items: &'a [MeshItem<'a>],
    /// Around the pixel's middle.
    pub facets: &'a [Facet],
    pub pencil: &'a Pencil,
    pub ground: &'a PixelGround,
    /// Output for the faces that are seen.
    pub faces: &'a mut Vec<SeenFace>,
}

/// Whether 16 rays, all over a pixel up to its rim, see a mesh before the ground.
pub(in crate::objects) struct Probe<'a> {
    pub patch: &'a MeshPatch<'a>,
    pub facets: &'a [Facet],
    pub pencil: &'a Pencil,
    pub ground: &'a PixelGround,
}

/// First hits of sixteen rays, where those may be on a mesh.
#[derive(Clone, Copy)]
struct Looked<V: Simd> {
    seen: FirstHits<V>,
    /// Index of the facet.
    facet: V::F,
    albedo: Lanes<V::F>,
}

/// Offsets of four by four rays: the outermost go through the pixel's rim.
const SPREAD: [[f32; LANES]; 2] = {
    let mut spread = [[0.0; LANES]; 2];
    let mut ray = 0;
    while ray < LANES {
        spread[0][ray] = (ray % 4) as f32 / 3.0 - 0.5;
        spread[1][ray] = (ray / 4) as f32 / 3.0 - 0.5;
        ray += 1;
    }
    spread
};

impl MeshPatch<'_> {
    /// Metres across a pixel at a way of the pencil's direction.
    pub fn metres(&self, at: f32) -> f32 {
        self.footprint[0].mul_add(at, self.footprint[1])
    }

    /// A vector of the body in the world.
    pub fn turned(&self, vector: Vec3) -> Vec3 {
        self.axes[0] * vector.x + self.axes[1] * vector.y + self.axes[2] * vector.z
    }

    /// Keeps what of it lies before what sixteen rays have seen so far.
    #[inline(always)]
    fn look<V: Simd>(
        &self,
        simd: V,
        index: usize,
        facets: &[Facet],
        offsets: &[[f32; LANES]; 2],
        looked: &mut Looked<V>,
    ) {
        let [x, y] = [simd.load(&offsets[0]), simd.load(&offsets[1])];
        let zero = simd.splat(0.0);
        for number in self.facets.clone() {
            let facet = &facets[number];
            let edges = [
                linear(simd, facet.edges[0], x, y),
                linear(simd, facet.edges[1], x, y),
                linear(simd, facet.edges[2], x, y),
            ];
            let inside = zero.le(edges[0].min(edges[1]).min(edges[2]));
            if !inside.any() {
                continue;
            }

            let sum = linear(simd, facet.sum, x, y).max(simd.splat(f32::MIN_POSITIVE));
            // Among those of the corners, as `Facet::ways` has it.
            let way = linear(simd, facet.way, x, y) / sum;
            let way = way.max(simd.splat(facet.near)).min(simd.splat(facet.far));
            let at = (way + simd.splat(self.begin)) * simd.splat(self.ratio);
            let mut is_seen = inside & at.lt(looked.seen.limit(simd, self.higher)) & zero.le(at);
            let triangle = self.mesh.triangle_at(facet.triangle);
            if self.mesh.is_masked(triangle) && is_seen.any() {
                is_seen = is_seen & simd.mask(self.there(facet, offsets, is_seen.bits(), lanes(at)));
            }

            looked.seen.at = at.select(is_seen, looked.seen.at);
            looked.seen.aim = simd.splat(index as f32).select(is_seen, looked.seen.aim);
            looked.facet = simd.splat(number as f32).select(is_seen, looked.facet);
        }
    }

    /// Returns those of some rays that meet something where a texture says whether.
    fn there(&self, facet: &Facet, offsets: &[[f32; LANES]; 2], rays: u16, at: [f32; LANES]) -> u16 {
        let triangle = self.mesh.triangle_at(facet.triangle);
        each(rays).fold(0, |found, lane| {
            let weights = facet.weights(offsets[0][lane], offsets[1][lane]);
            let is_there = self.mesh.is_there(triangle, weights, RAY_PART * self.metres(at[lane]));
            found | u16::from(is_there) << lane
        })
    }

    /// Tells normals and colours of what sixteen rays see of it.
    #[inline(always)]
    fn light<V: Simd>(
        &self,
        simd: V,
        index: usize,
        facets: &[Facet],
        offsets: &[[f32; LANES]; 2],
        looked: &mut Looked<V>,
    ) {
        let own = is_of(&looked.seen, simd.splat(index as f32));
        let mut left = own.bits();
        if left == 0 {
            return;
        }

        let numbers = lanes(looked.facet);
        let [x, y] = [simd.load(&offsets[0]), simd.load(&offsets[1])];
        while left != 0 {
            let number = numbers[left.trailing_zeros() as usize];
            let lane = simd.splat(number);
            let mask = own & lane.le(looked.facet) & looked.facet.le(lane);
            let bits = mask.bits();
            left &= !bits;
            let facet = &facets[number as usize];
            let triangle = self.mesh.triangle_at(facet.triangle);
            let mut normals = self.mesh.normals_of(triangle);
            for normal in &mut normals {
                *normal = self.turned(if facet.is_behind { -*normal } else { *normal });
            }

            let normal = normal(simd, facet, &normals, x, y);
            for (seen, normal) in looked.seen.normal.iter_mut().zip(normal) {
                *seen = normal.select(mask, *seen);
            }

            let colour = if triangle.varies {
                // Of the strip of the pixel that the rays lie in the mean is asked for, and from what is coarser, at once.
                let mean = |of: &[f32; LANES]| {
                    each(bits).map(|lane| of[lane]).sum::<f32>() / bits.count_ones() as f32
                };
                let weights = facet.weights(mean(&offsets[0]), mean(&offsets[1]));
                let metres = STRIP_PART * self.metres(mean(&lanes(looked.seen.at)));
                self.mesh.colour(triangle, weights, metres, self.albedo)
            } else {
                self.mesh.colour(triangle, [0.0; 3], 0.0, self.albedo)
            };

            for (albedo, part) in looked.albedo.iter_mut().zip(colour.to_array()) {
                *albedo = simd.splat(part).select(mask, *albedo);
            }
        }
    }
}

/// Unit normals in a facet with these at its corners.
#[inline(always)]
fn normal<V: Simd>(simd: V, facet: &Facet, normals: &[Vec3; 3], x: V::F, y: V::F) -> Lanes<V::F> {
    let zero = simd.splat(0.0);
    let mut sum = [zero; 3];
    if normals[0] == normals[1] && normals[1] == normals[2] {
        for axis in 0..3 {
            sum[axis] = simd.splat(normals[0][axis]);
        }
        return sum;
    }
    // Edges may be of any size.
    let scale = simd.splat(1.0) / linear(simd, facet.sum, x, y).max(simd.splat(f32::MIN_POSITIVE));
    for (edge, normal) in facet.edges.iter().zip(normals) {
        let weight = linear(simd, *edge, x, y) * scale;
        for (sum, part) in sum.iter_mut().zip(normal.to_array()) {
            *sum = weight.mul_add(simd.splat(part), *sum);
        }
    }
    let length = dot::<V>(sum, sum).max(simd.splat(SLOW)).rsqrt();
    [sum[0] * length, sum[1] * length, sum[2] * length]
}

#[inline(always)]
fn linear<V: Simd>(simd: V, [across, down, own]: [f32; 3], x: V::F, y: V::F) -> V::F {
    y.mul_add(simd.splat(down), x.mul_add(simd.splat(across), simd.splat(own)))
}

#[inline(always)]
fn lanes<F: Floats>(values: F) -> [f32; LANES] {
    let mut all = Sixteen::default();
    values.store(&mut all.0);
    all.0
}

/// Lanes of which the bit is set.
fn each(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then(|| bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(lane)
    })
}

#[inline(always)]
fn begin<V: Simd>(simd: V, pencil: &Pencil, ground: &PixelGround, offsets: &[[f32; LANES]; 2]) -> Looked<V> {
    let zero = simd.splat(0.0);
    let seen = begin_rays(simd, pencil, ground, [simd.load(&offsets[0]), simd.load(&offsets[1])]);
    Looked { seen, facet: simd.splat(-1.0), albedo: [zero; 3] }
}

impl Kernel for Probe<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> bool {
        let mut looked = begin(simd, self.pencil, self.ground, &SPREAD);
        self.patch.look(simd, 0, self.facets, &SPREAD, &mut looked);
        is_of(&looked.seen, simd.splat(0.0)).all()
    }
}

impl Kernel for CountAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { items, facets, pencil, ground, faces } = self;
        let mut batches = [begin(simd, pencil, ground, &ALL[0]); RAYS / LANES];
        for (batch, looked) in batches.iter_mut().enumerate() {
            let offsets = &ALL[batch];
            *looked = begin(simd, pencil, ground, offsets);
            for (index, item) in items.iter().enumerate() {
                match item {
                    MeshItem::Shape(aim) => {
                        let [x, y] = [simd.load(&offsets[0]), simd.load(&offsets[1])];
                        aim.look(simd, index, [x, y], &mut looked.seen);
                    }
                    MeshItem::Mesh(patch) => patch.look(simd, index, facets, offsets, looked),
                }
            }

            for (index, item) in items.iter().enumerate() {
                match item {
                    MeshItem::Shape(aim) => {
                        let own = is_of(&looked.seen, simd.splat(index as f32));
                        for axis in 0..3 {
                            looked.albedo[axis] =
                                simd.splat(aim.albedo[axis]).select(own, looked.albedo[axis]);
                        }
                    }
                    MeshItem::Mesh(patch) => patch.light(simd, index, facets, offsets, looked),
                }
            }
        }

        for index in 0..items.len() {
            count_faces(simd, index, &batches, faces);
        }
    }
}

/// Puts what rays see of an item into a few faces, each of normals like that of its first ray; the last takes what is left.
#[inline(always)]
fn count_faces<V: Simd>(
    simd: V,
    index: usize,
    batches: &[Looked<V>; RAYS / LANES],
    faces: &mut Vec<SeenFace>,
) {
    let own = simd.splat(index as f32);
    let mut left = [0_u16; RAYS / LANES];
    for (left, looked) in left.iter_mut().zip(batches) {
        *left = is_of(&looked.seen, own).bits();
    }

    let zero = simd.splat(0.0);
    for face in 0..MOST_FACES {
        let Some(first) = left.iter().position(|left| *left != 0) else { return };
        let lane = left[first].trailing_zeros() as usize;
        let [x, y, z] = batches[first].seen.normal;
        let normal =
            [simd.splat(lane_of(x, lane)), simd.splat(lane_of(y, lane)), simd.splat(lane_of(z, lane))];
        let (mut rays, mut sums) = (0, [zero; 7]);
        for (left, looked) in left.iter_mut().zip(batches) {
            let alike = simd.splat(ONE_FACE).le(dot::<V>(looked.seen.normal, normal)).bits();
            // A ray is like itself, whatever its normal is.
            let bits = *left & if face + 1 == MOST_FACES { u16::MAX } else { alike };
            *left &= !bits;
            rays += bits.count_ones();
            let mask = simd.mask(bits);
            let [x, y, z] = looked.seen.normal;
            let [red, green, blue] = looked.albedo;
            let values = [x, y, z, looked.seen.at * looked.seen.metres, red, green, blue];
            for part in 0..7 {
                sums[part] = sums[part] + values[part].select(mask, zero);
            }
        }
        if rays > 0 {
            let [x, y, z, range, red, green, blue] = sums;
            let each = 1.0 / rays as f32;
            faces.push(SeenFace {
                aim: index,
                rays,
                normal: Vec3::new(total(x), total(y), total(z)) * each,
                range: total(range) * each,
                albedo: Vec3::new(total(red), total(green), total(blue)) * each,
            });
        }
    }
}
