//! Posts of a part of a page with what detail needs of them.

use super::amplitude::{AMPLITUDE_REACH, AmplitudeFields, AmplitudeScratch};
use super::field::{FieldArea, PostField, VOID_POST, load};
use super::mean_keeping::{KEEPING_REACH, keep_means};
use super::measure::DetailMeasure;
use super::walls::{WALL_REACH, Walls};
use crate::simd::{Floats, Ints, Isa, Kernel, LANES, Simd};
use crate::voxel::{APRON, HeightCode, PageView};
use hedgehop_base::colour::{LUMINANCE, linear_of_codes};

/// Posts around a part whose colours keep means and which have amplitudes: as many as interpolation takes.
pub const DETAIL_RING: usize = 1;

/// Posts around those that they depend on.
const REACH: usize = AMPLITUDE_REACH;

// Nothing else depends on more of them.
const _: () = assert!(KEEPING_REACH <= REACH && WALL_REACH <= REACH);

/// Posts around a part that have colours.
pub const DETAIL_MARGIN: usize = DETAIL_RING + REACH;

// A page's apron holds all that its posts need.
const _: () = assert!(DETAIL_MARGIN <= APRON as usize);

/// Part of a page whose posts are looked at.
#[derive(Debug, Clone, Copy)]
pub struct DetailSource<'v> {
    /// Planes of it.
    pub view: PageView<'v>,
    /// First post of the part, eastward and northward, counted from the page's first.
    pub first: [u32; 2],
    /// Posts of the part, eastward and northward.
    pub size: [u32; 2],
    /// Numbers of its database.
    pub measure: &'v DetailMeasure,
}

/// Colours and amplitudes of a part's posts and of those around it; memory for them that is used again and again.
#[derive(Debug, Default)]
pub struct DetailPosts {
    /// Linear reflectances by channel with [`DETAIL_MARGIN`] around the part. Up to [`DETAIL_RING`] around it their luminance keeps the means of voxels.
    colours: [PostField; 3],
    /// Relative deviations of light below the voxel, `[north][east]`, with [`DETAIL_RING`] around the part.
    deviations: Vec<f32>,
    /// Posts of a row of these.
    padded: usize,
    /// Steep posts among these.
    walls: Walls,
    scratch: PostScratch,
}

#[derive(Debug, Default)]
struct PostScratch {
    /// Roots of luminance and materials, as colours.
    fields: AmplitudeFields,
    /// Luminance, as colours.
    luminance: PostField,
    between: Vec<f32>,
    kept: Vec<f32>,
    amplitude: AmplitudeScratch,
}

/// Look at a part of a page.
struct DetailLook<'p, 'v> {
    posts: &'p mut DetailPosts,
    source: DetailSource<'v>,
}

impl Kernel for DetailLook<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) {
        let Self { posts, source } = self;
        posts.read(simd, &source);

        let size = source.size.map(|side| side as usize + 2 * DETAIL_RING);
        let DetailPosts { colours, deviations, padded, walls, scratch } = posts;
        let PostScratch { fields, luminance, between, kept, amplitude } = scratch;
        let area = FieldArea { first: REACH * (fields.roots.stride + 1), size };
        amplitude.find(simd, fields, area, deviations);
        *padded = AmplitudeScratch::padded(size[0]);
        walls.find(simd, area);
        if walls.is_any {
            walls.split(simd, deviations, &fields.roots, area);
            walls.average(simd, luminance, area);
            reduce(&mut walls.deviations, *padded, source.measure, &fields.materials, area);
        }
        reduce(deviations, *padded, source.measure, &fields.materials, area);

        keep_means(simd, luminance, area, between, kept);
        if walls.is_any {
            walls.calm(simd, luminance, area);
        }
        brighten(simd, colours, &fields.roots, luminance, area);
    }
}

impl DetailPosts {
    /// Looks at a part. Every instruction set gives the same bits.
    #[inline(always)]
    pub fn look<V: Simd>(&mut self, simd: V, source: DetailSource<'_>) {
        simd.call(DetailLook { posts: self, source });
    }

    /// Looks at a part with whatever instructions there are.
    pub fn look_best(&mut self, source: DetailSource<'_>) {
        Isa::best().run(DetailLook { posts: self, source });
    }

    /// Reads the light of a part's posts and of all that they depend on.
    #[inline(always)]
    fn read<V: Simd>(&mut self, simd: V, source: &DetailSource<'_>) {
        let Self { colours, walls, scratch: PostScratch { fields, luminance: luminances, .. }, .. } = self;
        let AmplitudeFields { roots, materials } = fields;
        let view = &source.view;
        let wide = view.width as usize + 2 * APRON as usize;
        let before = APRON as usize - DETAIL_MARGIN;
        let [width, height] = source.size.map(|side| side as usize + 2 * DETAIL_MARGIN);
        let bytes: &[u8] = bytemuck::cast_slice(view.colours);
        let (low, void) = (simd.splat_int(0xff), simd.splat(VOID_POST));
        colours
            .iter_mut()
            .chain([&mut *roots, &mut *materials, &mut *luminances, &mut walls.heights])
            .for_each(|field| field.resize(width, height));

        source.materials(materials, [width, height]);
        for row in 0..height {
            let start = (source.first[1] as usize + row + before) * wide + source.first[0] as usize + before;
            // Lanes behind a row are those of the next, which is read later.
            for column in (0..width).step_by(LANES) {
                let post = start + column;
                let codes = simd.load_triples(&some(bytes, 3 * post));
                let height = simd.load_shorts(&some(view.heights, post));
                let none = height.eq(simd.splat_int(i32::from(HeightCode::EMPTY)));
                let height = height.to_float() * simd.splat(source.measure.height_step);
                let channels = [codes & low, codes.shr::<8>() & low, codes.shr::<16>()];
                let mut luminance = simd.splat(0.0);
                for (channel, code) in channels.into_iter().enumerate() {
                    let light = simd.gather(linear_of_codes(), code);
                    luminance = luminance + light * simd.splat(LUMINANCE.to_array()[channel]);
                    if let Some(target) = colours[channel].values[row * width + column..].first_chunk_mut() {
                        void.select(none, light).store(target);
                    }
                }
                let at = row * width + column;
                for (field, value) in [
                    (&mut *roots, luminance.sqrt()),
                    (&mut *luminances, luminance),
                    (&mut walls.heights, height),
                ] {
                    if let Some(target) = field.values[at..].first_chunk_mut() {
                        void.select(none, value).store(target);
                    }
                }
            }
        }
    }

    /// Linear reflectances by channel of a post and those behind it, of column and row counted from the first of the margin.
    #[inline(always)]
    pub fn colours(&self, [column, row]: [usize; 2]) -> [&[f32]; 3] {
        self.colours
            .each_ref()
            .map(|field| field.values.get(row * field.stride + column..).unwrap_or_default())
    }

    /// Relative deviations of light below the voxel of a post and those behind it, of column and row counted from the first of the ring.
    #[inline(always)]
    pub fn deviations(&self, [column, row]: [usize; 2]) -> &[f32] {
        self.deviations.get(row * self.padded + column..).unwrap_or_default()
    }
}

impl DetailPosts {
    /// Relative deviations of light over walls, as [`Self::deviations`]: above 0 over (y, z), below over (x, z); empty if there are no walls.
    #[inline(always)]
    pub fn wall_deviations(&self, [column, row]: [usize; 2]) -> &[f32] {
        let walls = if self.walls.is_any { &self.walls.deviations[..] } else { &[] };
        walls.get(row * self.padded + column..).unwrap_or_default()
    }
}

impl DetailSource<'_> {
    /// Tells the materials of `size` posts with [`DETAIL_MARGIN`] around the part; beside the page that of the nearest of its posts.
    fn materials(&self, target: &mut PostField, size: [usize; 2]) {
        if let [uniform] = self.view.attributes {
            target.values.fill(f32::from(uniform.material));
            return;
        }

        let within = |at: usize, axis: usize, side: u32| {
            (self.first[axis] + at as u32).saturating_sub(DETAIL_MARGIN as u32).min(side - 1) as usize
        };
        let wide = self.view.width as usize;
        for (y, row) in target.values.chunks_exact_mut(target.stride).take(size[1]).enumerate() {
            let posts = &self.view.attributes[within(y, 1, self.view.height) * wide..][..wide];
            for (x, material) in row.iter_mut().enumerate() {
                *material = f32::from(posts[within(x, 0, self.view.width)].material);
            }
        }
    }
}

/// Brightens the colours of an area's posts from the luminance whose root is known to another one: hues stay, so that edges have no fringes.
#[inline(always)]
fn brighten<V: Simd>(
    simd: V,
    colours: &mut [PostField; 3],
    roots: &PostField,
    luminance: &PostField,
    area: FieldArea,
) {
    let FieldArea { first, size: [width, height] } = area;
    let (zero, least) = (simd.splat(0.0), simd.splat(f32::MIN_POSITIVE));
    for row in 0..height {
        let start = first + row * roots.stride;
        for column in (0..width).step_by(LANES) {
            let (root, light) =
                (load(simd, &roots.values, start + column), load(simd, &luminance.values, start + column));
            let factor = light / (root * root).max(least);
            let factor = factor.select(zero.lt(root), simd.splat(1.0));
            // Lanes behind the area are as they were.
            let lanes = simd.mask(u16::MAX >> (LANES - (width - column).min(LANES)));
            for field in colours.iter_mut() {
                let colour = load(simd, &field.values, start + column) * factor;
                if let Some(target) = field.values[start + column..].first_chunk_mut() {
                    colour.store_masked(lanes, target);
                }
            }
        }
    }
}

/// Multiplies deviations of an area's posts by the factors of their materials.
fn reduce(
    deviations: &mut [f32],
    padded: usize,
    measure: &DetailMeasure,
    materials: &PostField,
    area: FieldArea,
) {
    for (y, row) in deviations.chunks_exact_mut(padded).take(area.size[1]).enumerate() {
        let kinds = &materials.values[area.first + y * materials.stride..];
        for (deviation, &kind) in row.iter_mut().zip(kinds).take(area.size[0]) {
            *deviation *= measure.factor(kind as u8);
        }
    }
}

/// Copies elements from an index on; beyond the end they are 0.
#[inline(always)]
fn some<T: Copy + Default, const N: usize>(plane: &[T], start: usize) -> [T; N] {
    let rest = plane.get(start..).unwrap_or_default();
    rest.first_chunk().copied().unwrap_or_else(|| {
        let mut chunk = [T::default(); N];
        chunk[..rest.len()].copy_from_slice(rest);
        chunk
    })
}
