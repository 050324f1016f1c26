//! Light of what planes have in sight.

use glam::DVec3;

use super::row_detail::{RowDetail, StretchEnds};
use super::rows::{CHUNK, ChunkLights, PlaneAir, SegmentLights};
use super::segment_light::{ChunkDetail, GROUND, PlaneLight, WALL};
use crate::raymarch::scan::{NO_SLOPE, PlaneGroup, SampleLine, VisibleSegment};
use crate::sensor::radiance::{Crossings, Deviations, ImageLine, LineSampler, PlanesAbove, TexelPlace};
use crate::simd::{Floats, Simd};
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
    /// Detail below the voxel; `None`: there is none.
    pub detail: Option<&'f RowDetail<'f>>,
}

impl<'s, 'a> SegmentLights for Painting<'s, 'a> {
    #[inline(always)]
    fn begin<'f, V: Simd, const FOG_OR_GLOW: bool>(
        self,
        simd: V,
        segments: &[VisibleSegment],
        plane_air: PlaneAir<'f>,
    ) -> Result<impl ChunkLights> {
        let Self { painter, group, angle, detail } = self;
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
            detail,
            before: [simd.splat(NO_SLOPE), simd.splat(0.0)],
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
    detail: Option<&'s RowDetail<'s>>,
    /// Tangents and inverse depths of the latest segment.
    before: [V::F; 2],
}

impl<V: Simd, const FOG_OR_GLOW: bool> ChunkLights for Painted<'_, '_, '_, V, FOG_OR_GLOW> {
    #[inline(always)]
    fn next(
        &mut self,
        chunk: &[VisibleSegment],
        later: &[VisibleSegment],
        lights: &mut [PlaneLight],
    ) -> Result<ChunkDetail> {
        let (simd, air) = (self.simd, self.air);
        let mut seen_detail = ChunkDetail::None;
        for (index, (segment, light)) in chunk.iter().zip(lights).enumerate() {
            let place = self.places[index];
            let (slope, inverse) = (simd.load(&segment.slope.0), simd.load(&segment.inverse.0));
            let depth = inverse.recip();
            let before = std::mem::replace(&mut self.before, [slope, inverse]);
            let is_detailed = self.has_detail(&place, depth, before);
            let (colour, mut deviations) = match (is_detailed, segment.line.share < 1.0) {
                (false, false) => (self.crossings.sample(&place), Deviations::none(simd)),
                (true, false) => self.crossings.sample_detail_at(&place, simd.splat(segment.line.distance)),
                (false, true) => self.between::<false>(segment, &place, depth)?,
                (true, true) => self.between::<true>(segment, &place, depth)?,
            };

            let square = slope.mul_add(slope, self.squares);
            let slant = square.sqrt_rough();
            let seen = air.haze::<V, FOG_OR_GLOW>(simd, colour, slant * depth, slope * depth);
            if is_detailed {
                let share = air.ground_share::<V, FOG_OR_GLOW>(simd, seen, slant * depth, slope * depth);
                deviations.ground = deviations.ground * share;
                deviations.wall = deviations.wall * share;
                let own = if deviations.has_walls { ChunkDetail::Walls } else { ChunkDetail::Ground };
                seen_detail = seen_detail.max(own);
            }
            for (channel, seen) in seen.into_iter().enumerate() {
                seen.store(&mut light[channel].0);
            }
            if self.detail.is_some() {
                deviations.ground.store(&mut light[GROUND].0);
                deviations.wall.store(&mut light[WALL].0);
            }

            // One after the other: a processor has only so many reads on their way.
            if let Some(segment) = later.get(index) {
                self.places[index] = self.crossings.seek(image_line(&segment.line))?;
            }
        }

        Ok(seen_detail)
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

    /// Whether detail below the voxel is seen from the segment `before`, of such tangents and inverse depths, to the latest, in a place at depths.
    #[inline(always)]
    fn has_detail(&self, place: &TexelPlace, depth: V::F, before: [V::F; 2]) -> bool {
        let Some(detail) = self.detail.filter(|_| self.crossings.has_detail(place)) else { return false };
        let [[low, near], [high, far]] = [before, self.before];
        detail.is_seen(self.simd, &StretchEnds { slopes: [low, high], inverse: [near, far], depth })
    }

    /// Radiance of a segment between a line and the one before it at depths, and its relative deviations below the voxel, which are none without `DETAIL`.
    #[inline(always)]
    fn between<const DETAIL: bool>(
        &mut self,
        segment: &VisibleSegment,
        place: &TexelPlace,
        depth: V::F,
    ) -> Result<([V::F; 3], Deviations<V>)> {
        let (at, share) = between_lines(self.simd, &segment.line, depth * self.depth.recip());
        let line = image_line(&segment.line);
        let before = match self.crossings.beside(place, &line, -self.forward) {
            Some(before) => before,
            None => self.crossings.seek(ImageLine { index: line.index - self.forward, ..line })?,
        };

        let [(before, rough_before), (mut colour, mut rough)] = if DETAIL {
            [self.crossings.sample_detail_at(&before, at), self.crossings.sample_detail_at(place, at)]
        } else {
            let none = Deviations::none(self.simd);
            [(self.crossings.sample_at(&before, at), none), (self.crossings.sample_at(place, at), none)]
        };
        for (channel, colour) in colour.iter_mut().enumerate() {
            let before = before[channel];
            *colour = (*colour - before).mul_add(share, before);
        }
        if DETAIL {
            rough.ground = (rough.ground - rough_before.ground).mul_add(share, rough_before.ground);
            rough.wall = (rough.wall - rough_before.wall).mul_add(share, rough_before.wall);
            rough.has_walls |= rough_before.has_walls;
        }
        Ok((colour, rough))
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
