//! Light of posts as detail sees it, of a picture that is no page.

use super::amplitude::{AMPLITUDE_REACH, AmplitudeFields, AmplitudeScratch};
use super::field::{FieldArea, PostField};
use super::mean_keeping::{KEEPING_REACH, keep_means};
use crate::simd::{Isa, Kernel, Simd};

const _: () = assert!(KEEPING_REACH <= AMPLITUDE_REACH);

/// Light of posts and how rough it is, `[north][east]`, without those at the picture's edge that others depend on.
#[derive(Debug, Default)]
pub struct PostLight {
    /// Posts eastward and northward.
    pub size: [usize; 2],
    /// Luminance that keeps means between posts.
    pub luminance: Vec<f32>,
    /// Relative deviations of light below the voxel that it foretells, before materials have their share.
    pub deviations: Vec<f32>,
}

/// Look at the posts of a picture.
struct PictureLook<'p> {
    luminance: &'p [f32],
    size: [usize; 2],
}

impl PostLight {
    /// Posts at each edge of a picture that have none.
    pub const MARGIN: usize = AMPLITUDE_REACH;

    /// Looks at a picture of posts by their luminance, row by row; one without enough of them has none.
    pub fn of(luminance: &[f32], size: [usize; 2]) -> Self {
        if size.iter().any(|side| *side <= 2 * Self::MARGIN) || luminance.len() < size[0] * size[1] {
            return Self::default();
        }
        Isa::best().run(PictureLook { luminance, size })
    }
}

impl Kernel for PictureLook<'_> {
    type Output = PostLight;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> PostLight {
        let Self { luminance, size: [width, height] } = self;
        let mut light = PostField::default();
        light.resize(width, height);
        light.values[..width * height].copy_from_slice(&luminance[..width * height]);
        let mut fields = AmplitudeFields::default();
        for field in [&mut fields.roots, &mut fields.materials] {
            field.resize(width, height);
        }
        for (root, luminance) in fields.roots.values.iter_mut().zip(luminance) {
            *root = luminance.max(0.0).sqrt();
        }

        let margin = PostLight::MARGIN;
        let size = [width - 2 * margin, height - 2 * margin];
        let area = FieldArea { first: margin * (width + 1), size };
        let mut padded = Vec::new();
        AmplitudeScratch::default().find(simd, &fields, area, &mut padded);
        keep_means(simd, &mut light, area, &mut Vec::new(), &mut Vec::new());

        let mut found = PostLight { size, ..PostLight::default() };
        for row in 0..size[1] {
            let kept = &light.values[area.first + row * width..][..size[0]];
            found.luminance.extend_from_slice(kept);
            let start = row * AmplitudeScratch::padded(size[0]);
            found.deviations.extend_from_slice(&padded[start..start + size[0]]);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_have_light_within_their_margin() {
        let side = 2 * PostLight::MARGIN + 21;
        let even = PostLight::of(&vec![0.25; side * side], [side, side]);
        assert_eq!(even.size, [21, 21]);
        assert!(even.luminance.iter().all(|light| (light - 0.25).abs() < 1e-6));
        assert!(even.deviations.iter().all(|deviation| *deviation < 1e-5));

        // Checks of posts are as rough as it gets, and stand out more than they did.
        let checks: Vec<f32> = (0..side * side)
            .map(|post| if (post % side + post / side).is_multiple_of(2) { 0.3 } else { 0.2 })
            .collect();
        let rough = PostLight::of(&checks, [side, side]);
        assert!(rough.deviations.iter().all(|deviation| *deviation > 0.3));
        let (least, most) = rough
            .luminance
            .iter()
            .fold((1.0_f32, 0.0_f32), |(least, most), light| (least.min(*light), most.max(*light)));
        assert!(least < 0.18 && most > 0.32, "{least} {most}");

        assert_eq!(PostLight::of(&checks, [2 * PostLight::MARGIN, side]).size, [0, 0]);
    }
}
