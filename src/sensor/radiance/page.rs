//! One page's radiance.

use super::facing::{Facing, Slopes};
use super::posts::{Lamp, Posts};
use super::window::{RING, Window};
use crate::error::Result;
use crate::sensor::VisualSensor;
use crate::simd::{Isa, Kernel, Simd};
use crate::voxel::{PAGE_SIDE, PageId, PageSource};

/// Root of the radiance of the greatest code.
pub const ROOT_OF_BRIGHTEST: f32 = 1.5;
/// Greatest code of a channel.
pub const CODE_LIMIT: f32 = 1023.0;

/// A rectangle of a page's posts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// The first post, eastward and northward.
    pub first: [u32; 2],
    /// Posts, eastward and northward, ≥ 1; what lies beyond the page is none.
    pub size: [u32; 2],
}

impl Part {
    /// The whole of any page.
    pub const ALL: Self = Self { first: [0; 2], size: [PAGE_SIDE; 2] };

    /// `count` columns (`major` 0) or rows (`major` 1).
    pub fn lines(major: u8, first: u32, count: u32) -> Self {
        let mut part = Self::ALL;
        part.first[usize::from(major)] = first;
        part.size[usize::from(major)] = count;
        part
    }

    /// What of it lies on a page of `width` × `height` posts.
    #[must_use]
    fn within(self, width: u32, height: u32) -> Self {
        let mut part = self;
        for (axis, side) in [width, height].into_iter().enumerate() {
            part.first[axis] = part.first[axis].min(side - 1);
            part.size[axis] = part.size[axis].min(side - part.first[axis]);
        }
        part
    }
}

/// Radiance of a page or of a part of it: texels with an apron, rows from south to north.
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
    /// What the posts of a part of a page send under `sensor`'s sun, those of coarse levels by what `facing` shows of them;
    /// `None` where the page is absent. Every instruction set gives the same bits, and parts those of the whole.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn bake(
        source: &dyn PageSource,
        (id, part): (PageId, Part),
        sensor: &VisualSensor,
        facing: &Facing,
        isa: Isa,
    ) -> Result<Option<Self>> {
        isa.run(Baking { source, id, part, sensor, facing })
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
    part: Part,
    sensor: &'a VisualSensor,
    facing: &'a Facing,
}

impl Kernel for Baking<'_> {
    type Output = Result<Option<RadiancePage>>;

    #[inline(always)]
    fn run<V: Simd>(self, _: V) -> Self::Output {
        let Self { source, id, part, sensor, facing } = self;
        let Some(view) = source.page(id)? else { return Ok(None) };
        let part = part.within(view.width, view.height);
        let lamp = Lamp::new(sensor);
        let posts = Posts::new(&lamp, source.header(), id, view, part, facing);
        let window = Window::around(&posts);
        let [width, rows] = window.size();
        let mut texels = vec![0; width * rows];
        let mut slopes = Vec::with_capacity(texels.len());
        for (row, texels) in texels.chunks_exact_mut(width).enumerate() {
            let (light, sloping) = window.row(row);
            encode(texels, light);
            slopes.extend_from_slice(sloping);
        }
        Ok(Some(RadiancePage { texels, slopes, size: part.size.map(|side| side as i32) }))
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
