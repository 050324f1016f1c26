//! A page's radiance as lines across scan planes: filtered over what a line stands for.
//!
//! ```text
//! along the planes:   mean over the stride from one line to the next     the ends count half
//! across them:        mean over 1, 2 or 4 posts, by the footprint
//! both:               posts count by what is seen of them                facing
//! ```
//!
//! At a grazing angle a pixel covers several times as much along the ray as across it: a stride follows
//! from the first, and the width of texels from the second. Texels of a line lie side by side
//! whichever axis the planes run along.

use std::borrow::Cow;

use super::facing::{Facing, Slopes};
use super::page::{CODE_LIMIT, ROOT_OF_BRIGHTEST, RadiancePage, encode};
use super::window::RING;
use crate::simd::{Isa, Kernel, Simd, turned};

/// Which lines of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Weave {
    /// How the planes run: lines are columns of the page if along x, rows if along y.
    pub facing: Facing,
    /// log₂ of posts across a texel, up to 2.
    pub shift: u8,
    /// Lines from one to the next: 1, 2 or 4. Those divisible by it are there.
    pub span: u8,
}

/// Lines of a part of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineImage {
    /// As a page's, `[line][texel]`; a texel more on either side of all that lie across the part.
    pub texels: Vec<u32>,
    /// Texels from one line to the next: those of the part and two.
    pub row: usize,
}

impl LineImage {
    /// The lines of a page, or of a part of it that begins with a line.
    pub fn new(page: &RadiancePage, weave: Weave) -> Self {
        Self::with_isa(page, weave, Isa::best())
    }

    /// The same; every instruction set gives the same bits.
    pub fn with_isa(page: &RadiancePage, weave: Weave, isa: Isa) -> Self {
        isa.run(Weaving { page, weave })
    }

    /// Where line `index` begins, the last one's if it is beyond.
    #[inline(always)]
    pub fn start_of(&self, index: usize) -> usize {
        index.saturating_mul(self.row).min(self.texels.len() - self.row)
    }

    /// Bytes of the texels.
    pub fn bytes(&self) -> usize {
        size_of_val(self.texels.as_slice())
    }
}

struct Weaving<'p> {
    page: &'p RadiancePage,
    weave: Weave,
}

impl Kernel for Weaving<'_> {
    type Output = LineImage;

    #[inline(always)]
    fn run<V: Simd>(self, _: V) -> LineImage {
        let Self { page, weave } = self;
        let (major, wide) = (usize::from(weave.facing.major), 1 << weave.shift);
        let [along, across] = [page.size[major] as usize, page.size[1 - major] as usize];
        let span = usize::from(weave.span);
        let row = across.div_ceil(wide) + 2;
        // A last texel may be narrower than the others; the apron goes on from it.
        let posts = across + 2 * wide;
        let mut sums = [(); 3].map(|()| vec![0.0_f32; posts]);
        let mut weights = vec![0.0_f32; posts];
        let mut means = [(); 3].map(|()| vec![0.0_f32; row]);
        let mut texels = vec![0; along.div_ceil(span) * row];
        let lying = Lying::new(page, &weave.facing);
        for (line, texels) in texels.chunks_exact_mut(row).enumerate() {
            let middle = line * span + RING;
            let half = span / 2;
            sums.iter_mut().for_each(|sums| sums.fill(0.0));
            weights.fill(0.0);
            for at in middle - half..=middle + half {
                let is_end = span > 1 && at.abs_diff(middle) == half;
                let share = if is_end { 0.5 } else { 1.0 };
                lying.add_line(at, RING - wide, share, &mut sums, &mut weights);
            }
            for (means, sums) in means.iter_mut().zip(&sums) {
                let texels = sums.chunks(wide).zip(weights.chunks(wide));
                for (mean, (sums, weights)) in means.iter_mut().zip(texels) {
                    *mean = sums.iter().sum::<f32>() / weights.iter().sum::<f32>();
                }
            }
            encode(texels, [&means[0], &means[1], &means[2]]);
        }
        LineImage { texels, row }
    }
}

/// A page whose lines lie in memory as rows.
struct Lying<'p> {
    texels: Cow<'p, [u32]>,
    slopes: Cow<'p, [Slopes]>,
    /// Posts of a row, with the apron.
    stride: usize,
    facing: &'p Facing,
}

impl<'p> Lying<'p> {
    #[inline(always)]
    fn new(page: &'p RadiancePage, facing: &'p Facing) -> Self {
        let stride = page.size.map(|side| side as usize + 2 * RING);
        let (texels, slopes) = match facing.major {
            0 => (turned(&page.texels, stride[0]).into(), turned(&page.slopes, stride[0]).into()),
            _ => ((&page.texels).into(), (&page.slopes).into()),
        };
        Self { texels, slopes, stride: stride[1 - usize::from(facing.major)], facing }
    }

    /// Adds radiance of posts from `first` on along a line, times their weights, and these; both are counted with the apron.
    #[inline(always)]
    fn add_line(&self, line: usize, first: usize, share: f32, sums: &mut [Vec<f32>; 3], weights: &mut [f32]) {
        let start = line * self.stride + first;
        let [red, green, blue] = sums;
        let scale = ROOT_OF_BRIGHTEST / CODE_LIMIT;
        let posts = self.texels[start..].iter().zip(&self.slopes[start..]);
        for (((((texel, slopes), red), green), blue), sum) in posts.zip(red).zip(green).zip(blue).zip(weights)
        {
            let weight = share * self.facing.weight(*slopes);
            *sum += weight;
            let add = |sum: &mut f32, code: u32| {
                let root = (code & 0x3ff) as i32 as f32 * scale;
                *sum += root * root * weight;
            };
            add(red, *texel);
            add(green, *texel >> 10);
            add(blue, *texel >> 20);
        }
    }
}
