//! One page's radiance.

use super::facing::{Facing, Slopes};
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

/// A page's radiance: texels with an apron, rows from south to north.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RadiancePage {
    /// `red | green << 10 | blue << 20`, each the root of radiance.
    pub texels: Vec<u32>,
    /// How they slope.
    pub slopes: Vec<Slopes>,
    /// Texels eastward and northward, without the apron.
    pub size: [i32; 2],
}

impl RadiancePage {
    /// What the posts of a page send under `sensor`'s sun, those of coarse levels by what `facing` shows of them;
    /// `None` where the page is absent. Every instruction set gives the same bits.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn bake(
        source: &dyn PageSource,
        id: PageId,
        sensor: &VisualSensor,
        facing: &Facing,
        isa: Isa,
    ) -> Result<Option<Self>> {
        isa.run(Baking { source, id, sensor, facing })
    }

    /// Texel of a post; the apron has negative indices.
    pub fn texel(&self, east: i32, north: i32) -> u32 {
        let ring = RING as i32;
        self.texels[((north + ring) * (self.size[0] + 2 * ring) + east + ring) as usize]
    }

    /// Bytes of the texels and slopes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.texels.as_slice()) + size_of_val(self.slopes.as_slice())
    }
}

/// Plain loops over rows, which the compiler vectorises for the set.
struct Baking<'a> {
    source: &'a dyn PageSource,
    id: PageId,
    sensor: &'a VisualSensor,
    facing: &'a Facing,
}

impl Kernel for Baking<'_> {
    type Output = Result<Option<RadiancePage>>;

    #[inline(always)]
    fn run<V: Simd>(self, _: V) -> Self::Output {
        let Self { source, id, sensor, facing } = self;
        let Some(view) = source.page(id)? else { return Ok(None) };
        let size = [view.width as i32, view.height as i32];
        let window = Window::around(&Lamp::new(sensor), source.header(), id, view, facing);
        let mut texels = vec![0; window.planes[0].len()];
        for (row, texels) in texels.chunks_exact_mut(window.stride).enumerate() {
            let start = row * window.stride;
            encode(texels, [0, 1, 2].map(|channel: usize| &window.planes[channel][start..][..window.stride]));
        }
        Ok(Some(RadiancePage { texels, slopes: window.slopes, size }))
    }
}

/// Texels of a row of radiance.
#[inline(always)]
pub fn encode(texels: &mut [u32], [red, green, blue]: [&[f32]; 3]) {
    let code = |radiance: f32| {
        let share = (radiance / (ROOT_OF_BRIGHTEST * ROOT_OF_BRIGHTEST)).clamp(0.0, 1.0);
        (share.sqrt() * CODE_LIMIT + 0.5) as i32 as u32
    };
    for (((texel, &red), &green), &blue) in texels.iter_mut().zip(red).zip(green).zip(blue) {
        *texel = code(red) | code(green) << 10 | code(blue) << 20;
    }
}
