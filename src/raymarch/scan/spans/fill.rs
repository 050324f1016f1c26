//! Fill of rows of sixteen planes: the light of one face of a span, how far away it is, and how much it hides.

use crate::simd::{Each, Floats, Simd, math};

/// Steepest way through a voxel whose length is told, rise over run: above and below the eye there is no end to it.
const STEEPEST: f32 = 1.0e6;

/// Fill of rows by one face.
#[derive(Clone, Copy)]
pub(super) struct Fill<V: Simd> {
    /// Radiance, linear Rec. 709.
    pub light: [V::F; 3],
    /// Haze of the span that lets light through; `None`: it hides all.
    pub haze: Option<Haze<V>>,
    /// Inverse depth, 1/metres, and by how much it rises to the next plane.
    pub inverse: LinearTerm<V>,
    pub across: V::F,
    /// Least and greatest value of the first: at the planes' exit from the visible part, and at the front of that.
    pub bounds: [V::F; 2],
    /// Rise to the next plane at the front.
    pub front: V::F,
}

/// Quantity that is linear in the tangent of elevation.
#[derive(Clone, Copy)]
pub(super) struct LinearTerm<V: Simd> {
    pub tangent: V::F,
    pub value: V::F,
    /// Rise for each unit of the tangent.
    pub slope: V::F,
}

/// Half-transparent matter on the planes' way through one voxel.
#[derive(Clone, Copy)]
pub(super) struct Haze<V: Simd> {
    /// Logarithm (of 2) of the share of light that comes through on a level way between the voxel's sides.
    pub clearness: V::F,
    /// Depth per distance along the ground.
    pub level: V::F,
    /// Tangents between which it is seen.
    pub tangents: [V::F; 2],
    /// Ends of that way.
    pub passage: PlanePassage<V>,
}

/// The ends of a span where planes enter its voxel and where they leave it, as tangents.
#[derive(Clone, Copy)]
pub(super) struct PlanePassage<V: Simd> {
    /// Inverse depths there, 1/metres.
    pub inverse: [V::F; 2],
    pub top: [V::F; 2],
    /// Tangents of the lower end; `None` where the span stands on the ground.
    pub bottom: Option<[V::F; 2]>,
}

impl<V: Simd> Fill<V> {
    /// Takes away light and depth of all but some planes: there they may be NaN, which a weight of 0 does not take away.
    #[inline(always)]
    pub fn keep(&mut self, simd: V, planes: V::M) {
        let zero = simd.splat(0.0);
        let [red, green, blue] = self.light;
        let [least, most] = self.bounds;
        self.light = [red.select(planes, zero), green.select(planes, zero), blue.select(planes, zero)];
        self.bounds = [least.select(planes, zero), most.select(planes, zero)];
    }

    /// Inverse depths at tangents, 1/metres.
    #[inline(always)]
    pub fn inverse_at(&self, tangents: V::F) -> V::F {
        let LinearTerm { tangent, value, slope } = self.inverse;
        let [least, most] = self.bounds;
        (tangents - tangent).mul_add(slope, value).max(least).min(most)
    }

    /// Tilts of these inverse depths: to the next plane, and for each unit of the tangent.
    #[inline(always)]
    pub fn tilts_at(&self, simd: V, inverse: V::F) -> [V::F; 2] {
        let goes_on = inverse.lt(self.bounds[1]);
        [self.across.select(goes_on, self.front), self.inverse.slope.select(goes_on, simd.splat(0.0))]
    }

    /// Shares of light that it hides from rays of these tangents, 0…1.
    #[inline(always)]
    pub fn opacity_at(&self, simd: V, tangents: V::F) -> V::F {
        match &self.haze {
            Some(haze) => haze.opacity(simd, tangents),
            None => simd.splat(1.0),
        }
    }
}

impl<V: Simd> Haze<V> {
    #[inline(always)]
    fn opacity(&self, simd: V, tangents: V::F) -> V::F {
        let [low, high] = self.tangents;
        let tangents = tangents.max(low).min(high);
        let [steepest, one] = [STEEPEST, 1.0].each(|value| simd.splat(value));
        let slant = (self.level * tangents).abs().min(steepest);
        let square = slant.mul_add(slant, one);
        let way = square * square.rsqrt() * self.passage.share(simd, tangents);
        one - math::exp_neg(simd, way * self.clearness * simd.splat(-std::f32::consts::LN_2))
    }
}

impl<V: Simd> PlanePassage<V> {
    /// Shares of the way through the voxel that rays of these tangents are within the span: ends are lines between the sides.
    #[inline(always)]
    fn share(&self, simd: V, tangents: V::F) -> V::F {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let (mut enter, mut leave) = (zero, one);

        // Sinking beside the ray, or rising above it.
        let [near, far] = self.top;
        let (passes, sinks) = (near.min(far).lt(tangents), far.lt(near));
        let crossing = self.crossing(tangents, self.top);
        leave = leave.min(crossing).select(passes & sinks, leave);
        enter = enter.max(crossing).select(passes & !sinks, enter);

        if let Some([near, far]) = self.bottom {
            let (passes, rises) = (tangents.lt(near.max(far)), near.lt(far));
            let crossing = self.crossing(tangents, [near, far]);
            leave = leave.min(crossing).select(passes & rises, leave);
            enter = enter.max(crossing).select(passes & !rises, enter);
        }

        (leave - enter).max(zero)
    }

    /// Share of the way at which rays are as high as an end: heights, not tangents, are linear along it, so that `near` and `far` count by
    /// the depths there.
    #[inline(always)]
    fn crossing(&self, tangents: V::F, [near, far]: [V::F; 2]) -> V::F {
        let [from, to] = self.inverse;
        let begun = (tangents - near) * to;
        let left = (far - tangents) * from;
        begun * (begun + left).recip()
    }
}
