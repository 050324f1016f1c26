//! Plants and rocks that need no file: turned outlines, dented by chance.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::soup::{Face, Soup};
use crate::features::{Leaf, TreeKind, mix, share};
use hedgehop::voxel::Material;
use hedgehop_base::colour::linear_from_srgb8;

/// Forms that can be scattered without a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuiltIn {
    /// A broad-leaved tree, 12 m high.
    Broadleaf,
    /// A spruce, 16 m high.
    Conifer,
    /// A bush, 2 m high.
    Shrub,
    /// A boulder, 1.6 m high.
    Rock,
}

/// Sides of a turned outline.
const SIDES: usize = 14;

/// A turned outline.
struct Turned<'o> {
    /// Distance from the axis and height, from below, metres.
    outline: &'o [[f64; 2]],
    /// Part of the distance by which corners are dented or bulge.
    rough: f64,
    /// sRGB below and above.
    colours: [[u8; 3]; 2],
    seed: u64,
}

impl BuiltIn {
    const NAMES: [(&'static str, Self); 4] = [
        ("broadleaf", Self::Broadleaf),
        ("conifer", Self::Conifer),
        ("shrub", Self::Shrub),
        ("rock", Self::Rock),
    ];

    /// Finds a form by its name in recipes.
    pub fn of(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, form)| *form)
    }

    /// All names.
    pub fn names() -> String {
        Self::NAMES.map(|(name, _)| name).join(", ")
    }

    /// Returns the material.
    pub fn material(self) -> Material {
        match self {
            Self::Broadleaf | Self::Shrub => Material::Broadleaf,
            Self::Conifer => Material::Needleleaf,
            Self::Rock => Material::Rock,
        }
    }

    /// The tree that it is, on voxels too wide for its outline: an eighth of its crown, or more.
    pub(super) fn tree(self, scale: f64, spacing: f64) -> Option<TreeKind> {
        let (height_m, crown_m, leaf) = match self {
            Self::Broadleaf => (12.0 * scale, 7.4 * scale, Leaf::Broad),
            Self::Conifer => (16.0 * scale, 6.4 * scale, Leaf::Needle),
            Self::Shrub | Self::Rock => return None,
        };
        (8.0 * spacing > crown_m).then(|| TreeKind::nearest(height_m, crown_m, leaf))
    }

    /// Builds the triangles.
    pub(super) fn soup(self, scale: f64) -> Soup {
        let trunk = |radius: f64, high: f64| {
            Turned {
                outline: &[[0.0, 0.0], [radius, 0.0], [0.7 * radius, high], [0.0, high]],
                rough: 0.0,
                colours: [[78, 66, 52], [88, 76, 62]],
                seed: 0,
            }
            .faces()
        };

        // Trunks end below crowns: else crowns would have the colours of bark above them.
        let faces = match self {
            Self::Broadleaf => {
                let outline = ball(3.7, 2.6, 12.0, 0.85);
                let crown =
                    Turned { outline: &outline, rough: 0.2, colours: [[50, 68, 34], [92, 112, 54]], seed: 1 };
                [trunk(0.28, 2.5), crown.faces()].concat()
            }
            Self::Conifer => {
                // No tier overhangs the next: at coarse voxels that would be slits.
                let tier = |index: usize| {
                    let part = index as f64 / 7.0;
                    let (radius, height) = (3.0 * (1.0 - part), 1.6 + 14.4 * part);
                    [[radius + 0.3, height + 0.1], [0.8 * radius + 0.2, height + 0.9]]
                };
                let mut outline = vec![[0.0, 1.6]];
                outline.extend((0..7).flat_map(tier));
                outline.push([0.0, 16.0]);
                let crown =
                    Turned { outline: &outline, rough: 0.16, colours: [[32, 48, 32], [62, 84, 52]], seed: 2 };
                [trunk(0.25, 1.5), crown.faces()].concat()
            }
            Self::Shrub => {
                let outline = ball(1.3, 0.0, 2.0, 1.0);
                Turned { outline: &outline, rough: 0.22, colours: [[58, 72, 38], [104, 116, 62]], seed: 3 }
                    .faces()
            }
            Self::Rock => {
                let outline = ball(1.25, 0.0, 1.6, 1.3);
                Turned { outline: &outline, rough: 0.25, colours: [[104, 98, 90], [150, 146, 138]], seed: 4 }
                    .faces()
            }
        };

        let mut faces = faces;
        faces.iter_mut().flat_map(|face| &mut face.corners).for_each(|corner| *corner *= scale);
        Soup::built_in(faces)
    }
}

/// The outline of something round between two heights, widest at a part (0…2) of the middle one.
fn ball(radius: f64, low: f64, high: f64, widest: f64) -> Vec<[f64; 2]> {
    const STEPS: usize = 9;
    let at = |step: usize| {
        let part = step as f64 / STEPS as f64;
        let across = (std::f64::consts::PI * part.powf(widest)).sin().max(0.0).powf(0.75);
        [if step.is_multiple_of(STEPS) { 0.0 } else { radius * across }, low + (high - low) * part]
    };
    (0..=STEPS).map(at).collect()
}

impl Turned<'_> {
    fn faces(&self) -> Vec<Face> {
        let last = self.outline.len() - 1;
        let (low, high) = (self.outline[0][1], self.outline[last][1]);
        let corner = |step: usize, side: usize| {
            let [radius, height] = self.outline[step];
            let chance =
                |index: u64| share(mix(self.seed << 32 | (step * SIDES + side) as u64 ^ index << 48));
            let radius = radius * (1.0 + self.rough * (2.0 * chance(1) - 1.0));
            let turn =
                DVec2::from_angle(TAU * (side as f64 + 0.5 * (step % 2) as f64) / SIDES as f64) * radius;
            let part = ((height - low) / (high - low)) as f32;
            let [dark, light] = self.colours.map(|colour| Vec3::from_array(linear_from_srgb8(colour)));
            let tone = 0.8 + 0.4 * chance(2) as f32;
            (DVec3::new(turn.x, turn.y, height), dark.lerp(light, part) * tone)
        };

        let mut faces = Vec::with_capacity(2 * SIDES * last);
        let mut push = |corners: [(DVec3, Vec3); 3]| {
            faces.push(Face {
                corners: corners.map(|(place, _)| place),
                places: [Vec2::ZERO; 3],
                colours: corners.map(|(_, colour)| colour),
                material: 0,
                piece: 0,
            });
        };

        for step in 0..last {
            for side in 0..SIDES {
                let next = (side + 1) % SIDES;
                let [a, b, c, d] =
                    [corner(step, side), corner(step, next), corner(step + 1, next), corner(step + 1, side)];
                push([a, b, c]);
                push([a, c, d]);
            }
        }

        // At its poles all corners are one.
        faces.retain(|face| face.across().length_squared() > 0.0);
        faces
    }
}
