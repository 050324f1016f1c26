//! Share of a pixel that each body covers.

use super::Looking;
use crate::objects::ray_coverage::RAYS;
use crate::objects::{BodyLight, PixelGround, Square};
use crate::simd::Isa;

/// Share of a pixel that one body covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyShare {
    /// The body's number.
    pub id: u32,
    /// Share of the pixel, 0…1, more than 0.
    pub share: f32,
}

impl Square<'_> {
    /// Tells `put` row and column of every pixel of the screen in which bodies are seen, and what each of them covers of it before what
    /// `ground` says of a pixel: the most first, of equals that of the lower number. The shares add up to the light's [`share`](super::super::BodyLight::share).
    pub fn shares(
        &self,
        isa: Isa,
        ground: impl Fn(usize, usize) -> PixelGround,
        mut put: impl FnMut(usize, usize, &[BodyShare]),
    ) {
        let mut shares = Vec::new();
        self.each(
            isa,
            ground,
            |_, _| glam::Vec3::ZERO,
            |row, column, seen, looking| {
                shares.clear();
                match looking {
                    Some(looking) => looking.split(seen, &mut shares),
                    None => shares.push(BodyShare { id: seen.hit.id, share: seen.share }),
                }
                put(row, column, &shares);
            },
        );
    }
}

impl Looking<'_> {
    /// Adds what each body has of what was `seen` of the latest pixel to `shares`, which is empty.
    fn split(&self, seen: &BodyLight, shares: &mut Vec<BodyShare>) {
        // Where all rays see one face, they are not counted.
        if self.faces.is_empty() {
            shares.push(BodyShare { id: seen.hit.id, share: seen.share });
        }
        for face in &self.faces {
            let (id, share) = (self.near[face.aim].id, face.rays as f32 / RAYS as f32);
            match shares.iter_mut().find(|known| known.id == id) {
                Some(known) => known.share += share,
                None => shares.push(BodyShare { id, share }),
            }
        }
        shares.sort_unstable_by(|a, b| b.share.total_cmp(&a.share).then(a.id.cmp(&b.id)));
    }
}
