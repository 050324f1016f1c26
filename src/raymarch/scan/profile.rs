//! What sixteen planes see of the surface: the posts at which it rises above everything before.

use crate::simd::{Floats, Simd, Sixteen};

/// Tangent of the elevation of what is no surface: below any ray.
pub const NO_SLOPE: f32 = -1.0e18;

/// A line that the planes saw, and the stretch of surface that ends in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Tangent of each plane's elevation to the surface, times depth per ground distance as rows have it.
    pub slope: Sixteen,
    /// Inverse depth, 1/metres.
    pub inverse: Sixteen,
    /// Which line.
    pub mark: Mark,
}

/// A line: where a sight's surface and its colour come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Index of the line at its level.
    pub line: i64,
    /// Major distance, units.
    pub distance: f32,
    /// Share of the way from the line before it; 1 on the line itself.
    pub share: f32,
    /// Level index.
    pub level: u8,
    /// Lines from one that was read to the next, 1, 2 or 4: what a colour stands for.
    pub span: u8,
    /// Nothing of the surface before it is in sight.
    pub begins: bool,
}

/// Sights of one group of planes, nearest first: the surface goes straight from each to the next, unless that one
/// [begins](Mark::begins).
///
/// Every row's range and light follow from it: a plane's ray ends where the first stretch rises above it.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    sights: Vec<Sight>,
    /// Whether the last sight is the march's last line.
    is_joined: bool,
}

/// A post of each plane on its way into the profile.
#[derive(Clone, Copy)]
pub struct Post<V: Simd> {
    /// Tangent of its elevation.
    pub slope: V::F,
    /// Inverse depth, 1/metres.
    pub inverse: V::F,
    /// Which line.
    pub mark: Mark,
}

impl Profile {
    /// Sights, nearest first.
    pub fn sights(&self) -> &[Sight] {
        &self.sights
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.sights.clear();
        self.is_joined = false;
    }

    /// What follows does not begin at the last sight.
    #[inline(always)]
    pub fn part(&mut self) {
        self.is_joined = false;
    }

    /// Adds the stretch from one post to the next, which is in sight.
    #[inline(always)]
    pub fn add<V: Simd>(&mut self, from: &Post<V>, to: &Post<V>) {
        if !self.is_joined {
            self.push(from, true);
        }
        self.push(to, false);
        self.is_joined = true;
    }

    #[inline(always)]
    fn push<V: Simd>(&mut self, post: &Post<V>, begins: bool) {
        let mut sight = Sight {
            slope: Sixteen::default(),
            inverse: Sixteen::default(),
            mark: Mark { begins, ..post.mark },
        };
        post.slope.store(&mut sight.slope.0);
        post.inverse.store(&mut sight.inverse.0);
        self.sights.push(sight);
    }
}
