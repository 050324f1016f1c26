//! Light of what planes have in sight.

use glam::DVec3;

use crate::raymarch::scan::{PlaneGroup, Profile, SampleLine};
use crate::sensor::radiance::{Crossings, ImageLine, LineSampler, PlanesAbove, TexelPlace};
use crate::simd::{Floats, Isa, Kernel, LANES, Simd, Sixteen};
use crate::voxel::Grid;
use crate::weather::AtmosphereLanes;
use hedgehop_base::error::Result;

/// Sights from the one that is painted to the one that is fetched, a power of two.
const AHEAD: usize = 8;

/// Linear light of sixteen planes.
pub type PlaneLight = [Sixteen; 3];

/// Finds the light of profiles of one frame.
pub struct Painter<'a> {
    /// Radiance of lines.
    pub sampler: LineSampler<'a>,
    /// Haze and sky.
    pub air: AtmosphereLanes,
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// Metres per unit.
    pub spacing: f64,
    /// Height above the ground about, metres.
    pub height: f64,
}

impl Painter<'_> {
    /// Light that each segment of a profile sends to the eye, through the haze between. `angle` lies between neighbouring planes, seen
    /// along the ground, radians; `squares` is 1 + a² of each plane.
    pub fn paint(
        &mut self,
        isa: Isa,
        group: &PlaneGroup,
        profile: &Profile,
        angle: f64,
        squares: &[f32; LANES],
        lights: &mut Vec<PlaneLight>,
    ) -> Result<()> {
        lights.clear();
        if self.air.has_fog_or_glow() {
            isa.run(Painting::<true> { painter: self, group, profile, angle, squares, lights })
        } else {
            isa.run(Painting::<false> { painter: self, group, profile, angle, squares, lights })
        }
    }
}

struct Painting<'f, 'a, const FOG_OR_GLOW: bool> {
    painter: &'f mut Painter<'a>,
    group: &'f PlaneGroup,
    profile: &'f Profile,
    angle: f64,
    squares: &'f [f32; LANES],
    lights: &'f mut Vec<PlaneLight>,
}

impl<const FOG_OR_GLOW: bool> Kernel for Painting<'_, '_, FOG_OR_GLOW> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { painter, group, profile, angle, squares, lights } = self;
        let (squares, depth) = (simd.load(squares), simd.load(&group.depth));
        let planes = PlanesAbove {
            major: group.major,
            forward: group.forward > 0.0,
            height: painter.height / group.ground,
            eye: painter.eye[1 - group.major],
            minor: group.minor,
            pixel: group.ground * angle / painter.spacing,
        };

        let mut crossings = painter.sampler.under(simd, &planes);
        let (air, forward) = (painter.air, group.forward as i64);
        let segments = profile.segments();
        let mut ahead = [[TexelPlace::default(); 2]; AHEAD];
        for (places, segment) in ahead.iter_mut().zip(segments) {
            *places = seek(&mut crossings, &segment.line, forward)?;
        }

        for (index, segment) in segments.iter().enumerate() {
            let [place, before] = ahead[index % AHEAD];
            if let Some(later) = segments.get(index + AHEAD) {
                ahead[index % AHEAD] = seek(&mut crossings, &later.line, forward)?;
            }

            let (slope, inverse) = (simd.load(&segment.slope.0), simd.load(&segment.inverse.0));
            let colour = if segment.line.share < 1.0 {
                let (at, share) = between_lines(simd, &segment.line, (inverse * depth).recip());
                let mut colour = crossings.sample_at(&place, at);
                let before = crossings.sample_at(&before, at);
                for (channel, colour) in colour.iter_mut().enumerate() {
                    let before = before[channel];
                    *colour = (*colour - before).mul_add(share, before);
                }
                colour
            } else {
                crossings.sample(&place)
            };

            let depth = inverse.recip();
            let square = slope.mul_add(slope, squares);
            let slant = square.sqrt_rough();
            let seen = air.haze::<V, FOG_OR_GLOW>(simd, colour, slant * depth, slope * depth);
            let mut light = PlaneLight::default();
            for (channel, light) in light.iter_mut().enumerate() {
                seen[channel].store(&mut light.0);
            }

            lights.push(light);
        }

        Ok(())
    }
}

/// Major distances of planes (units) between a segment's line and the one before it, and their share of the way from that one.
#[inline(always)]
fn between_lines<V: Simd>(simd: V, mark: &SampleLine, distance: V::F) -> (V::F, V::F) {
    let side = Grid::side_units(mark.level) as f32;
    let line = simd.splat(mark.distance + (1.0 - mark.share) * side);
    let back = ((line - distance) * simd.splat(1.0 / side)).max(simd.splat(0.0)).min(simd.splat(1.0));
    (back.neg_mul_add(simd.splat(side), line), simd.splat(1.0) - back)
}

/// Finds the line that a segment's colour comes from, and the line before it if it is asked for.
#[inline(always)]
fn seek<V: Simd>(
    crossings: &mut Crossings<'_, '_, V>,
    mark: &SampleLine,
    forward: i64,
) -> Result<[TexelPlace; 2]> {
    let line = ImageLine { level: mark.level, index: mark.line, span: mark.span, distance: mark.distance };
    let place = crossings.seek(line)?;
    if mark.share < 1.0 {
        return Ok([place, crossings.seek(ImageLine { index: mark.line - forward, ..line })?]);
    }
    Ok([place; 2])
}
