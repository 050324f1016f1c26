//! Pictures on surfaces.

use glam::{Vec2, Vec3, Vec4};

use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_linear};

/// Continuation of a texture beyond its sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Repeats from the start.
    #[default]
    Repeat,
    /// Backward and forward.
    Mirror,
    /// Continues with the outermost texels.
    Clamp,
}

/// A picture and its halves, quarters, … down to one texel (Williams, "Pyramidal parametrics", 1983).
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    levels: Vec<Level>,
    wrap: [Wrap; 2],
}

/// One size of a picture.
#[derive(Debug, Clone, PartialEq)]
struct Level {
    width: usize,
    height: usize,
    /// sRGB and alpha, row by row from the top.
    texels: Vec<[u8; 4]>,
}

impl Texture {
    /// A picture of `width` × `height` texels, row by row from the top: sRGB and alpha. `None`: there are not as many, or none.
    pub fn new(width: usize, height: usize, texels: Vec<[u8; 4]>, wrap: [Wrap; 2]) -> Option<Self> {
        if texels.is_empty() || width.checked_mul(height) != Some(texels.len()) {
            return None;
        }
        let mut levels = vec![Level { width, height, texels }];
        while let Some(half) = levels.last().and_then(Level::half) {
            levels.push(half);
        }
        Some(Self { levels, wrap })
    }

    /// Texels across and down.
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// Linear colour and alpha, 0…1, around a place (0…1 rightward and downward), over about `texels` of the largest size across.
    pub fn sample(&self, place: Vec2, texels: f32) -> Vec4 {
        let level = texels.max(1.0).log2().min((self.levels.len() - 1) as f32);
        let (fine, part) = (level as usize, level.fract());
        let near = self.levels[fine].sample(place, self.wrap);
        match self.levels.get(fine + 1) {
            Some(coarse) if part > 0.0 => near.lerp(coarse.sample(place, self.wrap), part),
            _ => near,
        }
    }
}

impl Level {
    /// `None` of a single texel.
    fn half(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }

        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut texels = Vec::with_capacity(width * height);
        for row in 0..height {
            for column in 0..width {
                let mut sum = Vec4::ZERO;
                for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                    let (column, row) =
                        ((2 * column + right).min(self.width - 1), (2 * row + down).min(self.height - 1));
                    let texel = self.texel(column, row);
                    // What is not there has no colour to give.
                    sum += (texel.truncate() * texel.w).extend(texel.w);
                }
                let colour = if sum.w > 0.0 { sum.truncate() / sum.w } else { Vec3::ZERO };
                let [red, green, blue] = colour.to_array().map(srgb8_from_linear);
                texels.push([red, green, blue, (255.0 * 0.25 * sum.w).round() as u8]);
            }
        }

        Some(Self { width, height, texels })
    }

    fn texel(&self, column: usize, row: usize) -> Vec4 {
        let [red, green, blue, alpha] = self.texels[row * self.width + column];
        Vec3::from_array(linear_from_srgb8([red, green, blue])).extend(f32::from(alpha) / 255.0)
    }

    fn sample(&self, place: Vec2, wrap: [Wrap; 2]) -> Vec4 {
        let ([left, right], across) = neighbours(place.x, self.width, wrap[0]);
        let ([above, below], down) = neighbours(place.y, self.height, wrap[1]);
        let upper = self.texel(left, above).lerp(self.texel(right, above), across);
        let lower = self.texel(left, below).lerp(self.texel(right, below), across);
        upper.lerp(lower, down)
    }
}

/// The texels whose middles lie around a place, and the share of the second.
fn neighbours(place: f32, size: usize, wrap: Wrap) -> ([usize; 2], f32) {
    let inside = match wrap {
        Wrap::Repeat => place - place.floor(),
        Wrap::Mirror => {
            let twice = place * 0.5;
            let turn = 2.0 * (twice - twice.floor());
            if turn > 1.0 { 2.0 - turn } else { turn }
        }
        Wrap::Clamp => place.clamp(0.0, 1.0),
    };

    let at = inside * size as f32 - 0.5;
    let first = at.floor();
    let index = |at: f32| {
        // A float converts saturating; no number is 0.
        let last = size - 1;
        if at < 0.0 {
            if wrap == Wrap::Repeat { last } else { 0 }
        } else if at as usize > last {
            if wrap == Wrap::Repeat { 0 } else { last }
        } else {
            at as usize
        }
    };

    ([index(first), index(first + 1.0)], at - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green; blue, white.
    fn four(wrap: Wrap) -> Texture {
        let texels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
        Texture::new(2, 2, texels, [wrap; 2]).unwrap()
    }

    fn at(texture: &Texture, x: f32, y: f32) -> Vec4 {
        texture.sample(Vec2::new(x, y), 1.0)
    }

    #[test]
    fn the_first_texel_is_the_upper_left_one() {
        let texture = four(Wrap::Clamp);
        assert_eq!(at(&texture, 0.25, 0.25), Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(at(&texture, 0.75, 0.25), Vec4::new(0.0, 1.0, 0.0, 1.0));
        assert_eq!(at(&texture, 0.25, 0.75), Vec4::new(0.0, 0.0, 1.0, 1.0));
        assert_eq!(at(&texture, 0.5, 0.25), Vec4::new(0.5, 0.5, 0.0, 1.0));
        assert_eq!(at(&texture, -3.0, 0.25), at(&texture, 0.0, 0.25));
    }

    #[test]
    fn beyond_its_sides_it_repeats_or_turns() {
        let [repeated, mirrored] = [Wrap::Repeat, Wrap::Mirror].map(four);
        assert_eq!(at(&repeated, 1.25, -1.75), at(&repeated, 0.25, 0.25));
        assert_eq!(at(&repeated, 0.0, 0.25), Vec4::new(0.5, 0.5, 0.0, 1.0));
        assert_eq!(at(&mirrored, 1.25, 0.25), at(&mirrored, 0.75, 0.25));
        assert_eq!(at(&mirrored, -0.25, 2.25), at(&mirrored, 0.25, 0.25));
        for texture in [&repeated, &mirrored] {
            for place in [f32::NAN, f32::INFINITY, -1.0e30, 1.0e30] {
                let _ = at(texture, place, place);
            }
        }
    }

    #[test]
    fn far_away_it_is_its_mean() {
        let mean = four(Wrap::Repeat).sample(Vec2::new(0.1, 0.9), 100.0);
        assert!((mean - Vec4::new(0.5, 0.5, 0.5, 1.0)).abs().max_element() < 0.01, "{mean}");
        let odd = Texture::new(3, 1, vec![[255; 4]; 3], [Wrap::Repeat; 2]).unwrap();
        assert_eq!(odd.sample(Vec2::ZERO, 1000.0), Vec4::ONE);
        assert!(Texture::new(2, 2, vec![[0; 4]; 3], [Wrap::Repeat; 2]).is_none());
    }
}
