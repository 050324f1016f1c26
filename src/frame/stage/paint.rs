//! Light of what planes have in sight.

use glam::DVec3;

use super::rows::{CHUNK, ChunkLights, DEVIATION, INVERSE, PlaneAir, PlaneLight, SegmentLights};
use crate::raymarch::scan::{PlaneGroup, SampleLine, VisibleSegment};
use crate::sensor::radiance::{Crossings, ImageLine, LineSampler, PlanesAbove, TexelPlace};
use crate::simd::{Floats, Simd, Sixteen};
use crate::voxel::Grid;
use crate::weather::AtmosphereLanes;
use hedgehop_base::error::Result;

/// Radiance of what planes of one frame see.
pub struct Painter<'a> {
    /// Radiance of lines.
    pub sampler: LineSampler<'a>,
    /// The eye: units, units, metres.
    pub eye: DVec3,
    /// Metres per unit.
    pub spacing: f64,
    /// Height above the ground about, metres.
    pub height: f64,
}

/// Light that segments send to the eye, through the haze between.
pub struct Painting<'f, 'a> {
    /// Where radiance comes from.
    pub painter: &'f mut Painter<'a>,
    /// The planes.
    pub group: &'f PlaneGroup,
    /// Angle between neighbouring planes, seen along the ground, radians.
    pub angle: f64,
    /// Whether amplitudes of detail below the voxel are asked for.
    pub has_detail: bool,
}

impl<'s, 'a> SegmentLights for Painting<'s, 'a> {
    #[inline(always)]
    fn begin<'f, V: Simd, const FOG_OR_GLOW: bool>(
        self,
        simd: V,
        segments: &[VisibleSegment],
        plane_air: PlaneAir<'f>,
    ) -> Result<impl ChunkLights> {
        let Self { painter, group, angle, has_detail } = self;
        let planes = PlanesAbove {
            major: group.major,
            forward: group.forward > 0.0,
            height: painter.height / group.ground,
            eye: painter.eye[1 - group.major],
            minor: group.minor,
            pixel: group.ground * angle / painter.spacing,
        };

        let mut painted = Painted::<'f, 's, 'a, V, FOG_OR_GLOW> {
            simd,
            air: plane_air.air,
            squares: simd.load(plane_air.squares),
            depth: simd.load(&group.depth),
            forward: group.forward as i64,
            crossings: painter.sampler.under(simd, &planes),
            places: [TexelPlace::default(); CHUNK],
            has_detail,
        };
        painted.seek(segments)?;
        Ok(painted)
    }
}

/// Segments of sixteen planes, painted up to one of them.
struct Painted<'f, 's, 'a, V: Simd, const FOG_OR_GLOW: bool> {
    simd: V,
    air: &'f AtmosphereLanes,
    squares: V::F,
    /// Metres of depth per unit of major distance.
    depth: V::F,
    /// Sense along the major axis.
    forward: i64,
    crossings: Crossings<'s, 'a, V>,
    /// Texels of the segments that come next, which are on their way.
    places: [TexelPlace; CHUNK],
    has_detail: bool,
}

impl<V: Simd, const FOG_OR_GLOW: bool> ChunkLights for Painted<'_, '_, '_, V, FOG_OR_GLOW> {
    #[inline(always)]
    fn next(
        &mut self,
        chunk: &[VisibleSegment],
        later: &[VisibleSegment],
        lights: &mut [PlaneLight],
    ) -> Result<bool> {
        let (simd, air) = (self.simd, self.air);
        let mut has_detail = false;
        for (index, (segment, light)) in chunk.iter().zip(lights).enumerate() {
            let place = self.places[index];
            let (slope, inverse) = (simd.load(&segment.slope.0), simd.load(&segment.inverse.0));
            let colour = if segment.line.share < 1.0 {
                self.between(segment, &place, inverse)?
            } else {
                self.crossings.sample(&place)
            };

            let depth = inverse.recip();
            let square = slope.mul_add(slope, self.squares);
            let slant = square.sqrt_rough();
            let seen = air.haze::<V, FOG_OR_GLOW>(simd, colour, slant * depth, slope * depth);
            for (channel, seen) in seen.into_iter().enumerate() {
                seen.store(&mut light[channel].0);
            }

            light[DEVIATION] = Sixteen::default();
            light[INVERSE] = segment.inverse;
            if self.has_detail && self.crossings.has_detail(&place) {
                let share = air.ground_share::<V, FOG_OR_GLOW>(simd, seen, slant * depth, slope * depth);
                (self.deviation(segment, &place, inverse) * share).store(&mut light[DEVIATION].0);
                has_detail = true;
            }

            // One after the other: a processor has only so many reads on their way.
            if let Some(segment) = later.get(index) {
                self.places[index] = self.crossings.seek(image_line(&segment.line))?;
            }
        }

        Ok(has_detail)
    }
}

impl<V: Simd, const FOG_OR_GLOW: bool> Painted<'_, '_, '_, V, FOG_OR_GLOW> {
    /// Finds where the colours of the first segments come from, and has the processor fetch them.
    #[inline(always)]
    fn seek(&mut self, segments: &[VisibleSegment]) -> Result<()> {
        for (place, segment) in self.places.iter_mut().zip(segments) {
            *place = self.crossings.seek(image_line(&segment.line))?;
        }
        Ok(())
    }

    /// Radiance of a segment between a line and the one before it.
    #[inline(always)]
    fn between(&mut self, segment: &VisibleSegment, place: &TexelPlace, inverse: V::F) -> Result<[V::F; 3]> {
        let (at, share) = between_lines(self.simd, &segment.line, (inverse * self.depth).recip());
        let line = image_line(&segment.line);
        let before = match self.crossings.beside(place, &line, -self.forward) {
            Some(before) => before,
            None => self.crossings.seek(ImageLine { index: line.index - self.forward, ..line })?,
        };
        let before = self.crossings.sample_at(&before, at);
        let mut colour = self.crossings.sample_at(place, at);
        for (channel, colour) in colour.iter_mut().enumerate() {
            let before = before[channel];
            *colour = (*colour - before).mul_add(share, before);
        }
        Ok(colour)
    }

    /// Relative deviation of a segment's radiance below the voxel.
    #[inline(always)]
    fn deviation(&self, segment: &VisibleSegment, place: &TexelPlace, inverse: V::F) -> V::F {
        let simd = self.simd;
        if segment.line.share == 1.0 {
            return self.crossings.deviation_at(place, simd.splat(segment.line.distance));
        }
        let (at, share) = between_lines(simd, &segment.line, (inverse * self.depth).recip());
        let here = self.crossings.deviation_at(place, at);
        match self.crossings.beside(place, &image_line(&segment.line), -self.forward) {
            Some(before) => {
                let before = self.crossings.deviation_at(&before, at);
                (here - before).mul_add(share, before)
            }
            None => here,
        }
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

/// Returns the line that a segment's colour comes from.
#[inline(always)]
fn image_line(mark: &SampleLine) -> ImageLine {
    ImageLine { level: mark.level, index: mark.line, span: mark.span, distance: mark.distance }
}
