//! One page's radiance.

use super::facing::Facing;
use super::posts::{PageLight, Posts};
use super::window::Window;
use crate::detail::{DetailMeasure, DetailPosts, DetailSource};
use crate::pixels::{CODE_LIMIT, ROOT_OF_BRIGHTEST};
use crate::sensor::radiance::part::{PostPart, RING};
use crate::simd::{Each, Floats, Ints, Isa, Kernel, LANES, Simd};
use crate::voxel::{PageId, PageSource};
use hedgehop_base::error::Result;

/// Radiance of a page or of a part of it: texels with an apron, rows from south to north.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RadiancePage {
    /// `red | green << 10 | blue << 20`, each the root of radiance.
    pub texels: Vec<u32>,
    /// Texels eastward and northward, without the apron.
    pub size: [i32; 2],
}

impl RadiancePage {
    /// Computes the radiance of the posts of a part of a page under a lamp, on coarse levels of the part that `facing` shows of them;
    /// `None` where the page is absent. With memory for `detail` the colours of posts keep the means of voxels. Every instruction set gives the same bits, and parts those of the whole.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn bake(
        source: &dyn PageSource,
        id: PageId,
        part: PostPart,
        lamp: &PageLight<'_>,
        facing: &Facing,
        detail: Option<&mut DetailPosts>,
        isa: Isa,
    ) -> Result<Option<Self>> {
        let window = &mut Window::default();
        isa.run(Baking { source, id, part, lamp, facing, window, detail, finish: Encoding })
    }

    /// Texel of a post; the apron has negative indices.
    pub fn texel(&self, east: i32, north: i32) -> u32 {
        let ring = RING as i32;
        self.texels[((north + ring) * (self.size[0] + 2 * ring) + east + ring) as usize]
    }

    /// Bytes of the texels.
    pub fn bytes(&self) -> usize {
        size_of_val(self.texels.as_slice())
    }
}

/// Lights a part of a page, and makes an image of it.
pub struct Baking<'a, M> {
    pub source: &'a dyn PageSource,
    pub id: PageId,
    pub part: PostPart,
    pub lamp: &'a PageLight<'a>,
    pub facing: &'a Facing,
    /// Window in which posts are lit.
    pub window: &'a mut Window,
    /// Memory for detail of the posts; `None`: they have none.
    pub detail: Option<&'a mut DetailPosts>,
    /// Last step, which makes the image.
    pub finish: M,
}

/// Posts of a part of a page that are lit.
#[derive(Clone, Copy)]
pub struct LitPosts<'w> {
    pub window: &'w Window,
    pub detail: Option<&'w DetailPosts>,
    /// Posts of the part, eastward and northward.
    pub size: [usize; 2],
}

/// Makes an image of posts.
pub trait ImageFinish {
    type Image;
    /// Makes the image of posts of a part, and [`RING`] around it. Implementations are `#[inline(always)]`.
    fn image<V: Simd>(self, simd: V, posts: LitPosts<'_>) -> Self::Image;
}

impl<M: ImageFinish> Kernel for Baking<'_, M> {
    /// `None` where the page is absent.
    type Output = Result<Option<M::Image>>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let Self { source, id, part, lamp, facing, window, detail, finish } = self;
        let Some(view) = source.page(id)? else { return Ok(None) };
        let part = part.within(view.width, view.height);
        let detail = detail.map(|detail| {
            let measure = &DetailMeasure::of(source.header());
            detail.look(simd, DetailSource { view, first: part.first, size: part.size, measure });
            &*detail
        });
        let mut posts = Posts::new(lamp, source.header(), id, view, part, facing);
        posts.detail = detail;
        window.light(simd, &posts);
        Ok(Some(finish.image(simd, LitPosts { window, detail, size: part.size.each(|side| side as usize) })))
    }
}

/// Texels of the posts themselves.
struct Encoding;

impl ImageFinish for Encoding {
    type Image = RadiancePage;

    #[inline(always)]
    fn image<V: Simd>(self, simd: V, posts: LitPosts<'_>) -> RadiancePage {
        let LitPosts { window, size, .. } = posts;
        let [width, rows] = size.each(|side| side + 2 * RING);
        let mut texels = vec![0; width * rows];
        for (row, texels) in texels.chunks_exact_mut(width).enumerate() {
            encode(simd, texels, window.row(row).light);
        }
        RadiancePage { texels, size: size.each(|side| side as i32) }
    }
}

/// Codes of radiance of one colour.
#[inline(always)]
fn code<V: Simd>(simd: V, radiance: &[f32; LANES]) -> V::I {
    let unit = simd.splat(1.0 / (ROOT_OF_BRIGHTEST * ROOT_OF_BRIGHTEST));
    let share = (simd.load(radiance) * unit).max(simd.splat(0.0)).min(simd.splat(1.0));
    // Not in one step, which not all sets round once: codes are the same on every machine.
    (share.sqrt() * simd.splat(CODE_LIMIT) + simd.splat(0.5)).to_int()
}

/// Texels of a row of radiance, which has [`LANES`] more behind it.
#[inline(always)]
pub fn encode<V: Simd>(simd: V, texels: &mut [u32], light: [&[f32]; 3]) {
    for (chunk, texels) in texels.chunks_mut(LANES).enumerate() {
        let [red, green, blue] =
            light.each(|plane| plane[chunk * LANES..].first_chunk().unwrap_or(&[0.0; LANES]));
        let [red, green, blue] = [code(simd, red), code(simd, green), code(simd, blue)];
        let mut codes = [0; LANES];
        (red | green.shl::<10>() | blue.shl::<20>()).store(&mut codes);
        texels.copy_from_slice(bytemuck::cast_slice(&codes[..texels.len()]));
    }
}
