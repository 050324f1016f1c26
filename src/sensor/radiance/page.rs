//! One page's radiance.

use super::posts::Lamp;
use super::window::{RING, Window};
use crate::error::Result;
use crate::sensor::VisualSensor;
use crate::simd::{Isa, Kernel, Simd};
use crate::voxel::{PageId, PageSource};

/// Root of the radiance of the greatest code.
pub const ROOT_OF_BRIGHTEST: f32 = 1.5;
/// Greatest code of a channel.
pub const CODE_LIMIT: f32 = 1023.0;

/// An image of texels with an apron of one, rows from south to north.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// `red | green << 10 | blue << 20`, each the root of radiance.
    pub texels: Vec<u32>,
    /// Texels eastward and northward, without the apron.
    pub size: [i32; 2],
}

/// A page's radiance at its own and at half its resolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RadiancePage {
    /// Full, and half.
    pub images: [Image; 2],
}

impl RadiancePage {
    /// What the posts of a page send under `sensor`'s sun; `None` where the page is absent. Every instruction set
    /// gives the same bits.
    ///
    /// # Errors
    /// A page that is damaged: this one, or one that it depends on (its neighbours, and what lies under them in the next finer
    /// level).
    pub fn bake(
        source: &dyn PageSource,
        id: PageId,
        sensor: &VisualSensor,
        isa: Isa,
    ) -> Result<Option<Self>> {
        isa.run(Baking { source, id, sensor })
    }

    /// Bytes of the texels.
    pub fn bytes(&self) -> usize {
        self.images.iter().map(|image| size_of_val(image.texels.as_slice())).sum()
    }
}

/// Plain loops over rows, which the compiler vectorises for the set.
struct Baking<'a> {
    source: &'a dyn PageSource,
    id: PageId,
    sensor: &'a VisualSensor,
}

impl Kernel for Baking<'_> {
    type Output = Result<Option<RadiancePage>>;

    #[inline(always)]
    fn run<V: Simd>(self, _: V) -> Self::Output {
        let Self { source, id, sensor } = self;
        let Some(view) = source.page(id)? else { return Ok(None) };
        let size = [view.width as usize, view.height as usize];
        let window = Window::around(&Lamp::new(sensor), source, id, size)?;
        Ok(Some(RadiancePage { images: [full(&window, size), half(&window, size)] }))
    }
}

/// The posts themselves.
#[inline(always)]
fn full(window: &Window, size: [usize; 2]) -> Image {
    let mut image = Image::black(size);
    for (y, texels) in image.texels.chunks_exact_mut(size[0] + 2).enumerate() {
        let start = (y + RING - 1) * window.stride + RING - 1;
        encode(texels, [0, 1, 2].map(|channel: usize| &window.planes[channel][start..start + size[0] + 2]));
    }
    image
}

/// Means of 2 × 2 posts.
#[inline(always)]
fn half(window: &Window, size: [usize; 2]) -> Image {
    let size = size.map(|side| side.div_ceil(2));
    let mut image = Image::black(size);
    let mut means = [(); 3].map(|()| vec![0.0_f32; size[0] + 2]);
    for (y, texels) in image.texels.chunks_exact_mut(size[0] + 2).enumerate() {
        for (means, plane) in means.iter_mut().zip(&window.planes) {
            let rows = &plane[2 * y * window.stride..2 * (y + 1) * window.stride];
            let (south, north) = rows.split_at(window.stride);
            let posts = south.chunks_exact(2).zip(north.chunks_exact(2));
            for (mean, (south, north)) in means.iter_mut().zip(posts) {
                *mean = 0.25 * (south[0] + south[1] + north[0] + north[1]);
            }
        }
        encode(texels, [&means[0], &means[1], &means[2]]);
    }
    image
}

impl Image {
    fn black(size: [usize; 2]) -> Self {
        Self { texels: vec![0; (size[0] + 2) * (size[1] + 2)], size: size.map(|side| side as i32) }
    }
}

/// Texels of a row of radiance.
#[inline(always)]
fn encode(texels: &mut [u32], [red, green, blue]: [&[f32]; 3]) {
    let code = |radiance: f32| {
        let share = (radiance / (ROOT_OF_BRIGHTEST * ROOT_OF_BRIGHTEST)).clamp(0.0, 1.0);
        (share.sqrt() * CODE_LIMIT + 0.5) as i32 as u32
    };
    for (((texel, &red), &green), &blue) in texels.iter_mut().zip(red).zip(green).zip(blue) {
        *texel = code(red) | code(green) << 10 | code(blue) << 20;
    }
}
