//! The march of one group of planes, block by block.

use glam::DVec3;

use super::blocks::{LineBlock, Way};
use super::bounds::highest_code;
use super::displaced_field::{DisplacedField, DisplacedPlanes};
use super::displaced_stretch::DisplacedStretch;
use super::ground::PlaneGround;
use super::lines::{LinePosts, Lines};
use super::march_field::MarchField;
use super::profile::{NO_SLOPE, Post};
use super::steep::SteepRise;
use super::strides::Stride;
use super::{BoundPyramid, Pages, PlaneGroup, Profile, Strides, TurnedPages};
use crate::simd::{Each, Floats, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::voxel::{BARE, Grid, HeightCode, PageSource};
use hedgehop_base::error::Result;

/// Lines from the eye within which straight stretches from line to line are too coarse: near the ground,
/// planes follow the bilinear surface itself there, which bends within a cell.
const NEAR: f64 = 48.0;

/// Least major distance of a post, units.
pub(super) const LEAST_DISTANCE: f32 = 1.0e-6;

/// Voxels along a block whose bounds are looked at, at most.
pub(super) const MOST_VOXELS: i64 = 4;

/// Lines of a block, at most.
pub(super) const MOST_LINES: usize = 16;

/// Marches groups of planes through one database.
pub struct PlaneMarch<'a> {
    pub(super) pages: Pages<'a>,
    grid: Grid,
    heights: HeightCode,
    pub(super) level_count: u8,
    /// Height that no surface reaches, metres above the datum.
    ceiling: f64,
    strides: Strides,
    /// Bounds that wide stretches are passed over by.
    pub(super) bounds: &'a BoundPyramid,
    /// Displacement of the ground.
    displaced: Option<&'a DisplacedField<'a>>,
}

impl<'a> PlaneMarch<'a> {
    /// A march over `source`, with lines as far apart as `strides` says.
    pub fn new(
        source: &'a dyn PageSource,
        turned: &'a TurnedPages,
        strides: Strides,
        bounds: &'a BoundPyramid,
    ) -> Self {
        let header = source.header();
        Self {
            pages: Pages::new(source, turned),
            grid: header.grid,
            heights: header.heights,
            level_count: header.level_count,
            ceiling: header.height_range.high + header.heights.scale,
            strides,
            bounds,
            displaced: None,
        }
    }

    /// The same over displaced ground.
    #[must_use]
    pub fn displaced(self, field: Option<&'a DisplacedField<'a>>) -> Self {
        let ceiling = self.ceiling + field.map_or(0.0, |field| field.bound(0.0));
        Self { displaced: field, ceiling, ..self }
    }

    /// Returns the level index of the voxels whose bounds skip a stride's blocks, and how many of them lie along one; `None` where they are too
    /// many.
    pub(super) fn bounding(&self, stride: &Stride) -> Option<(u8, i64)> {
        // Where there are no voxels as long as a block, a few shorter ones.
        let level = stride.skip_level().min(self.level_count - 1);
        let block = stride.block_lines() * i64::from(Grid::side_units(stride.level));
        let voxels = block / i64::from(Grid::side_units(level));
        (voxels <= MOST_VOXELS).then_some((level, voxels))
    }

    /// Finds what the planes of `group` see from `eye` (units, units, metres) of the surface, within `field`. Returns the major distance up to
    /// which that is bare ground, units.
    ///
    /// # Errors
    /// A page that is damaged.
    pub fn see(
        &mut self,
        isa: Isa,
        eye: DVec3,
        group: &PlaneGroup,
        field: MarchField,
        profile: &mut Profile,
    ) -> Result<f64> {
        profile.clear();
        isa.run(Seeing { march: self, eye, group, field, profile })
    }
}

struct Seeing<'f, 'a> {
    march: &'f mut PlaneMarch<'a>,
    eye: DVec3,
    group: &'f PlaneGroup,
    field: MarchField,
    profile: &'f mut Profile,
}

impl Kernel for Seeing<'_, '_> {
    type Output = Result<f64>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<f64> {
        let Self { march, eye, group, field, profile } = self;
        let [enter, leave] = group.over;
        let under_ceiling = field.begin(group, march.ceiling - eye.z);
        let nearest = enter.iter().fold(f32::INFINITY, |a, &b| a.min(b)).max(under_ceiling);
        let farthest = leave.iter().fold(0.0_f32, |a, &b| a.max(b));
        if nearest > farthest {
            return Ok(0.0);
        }

        let size = [march.grid.nx, march.grid.ny][group.major];
        let ground = PlaneGround {
            simd,
            across: eye[1 - group.major],
            forward: group.forward as i64,
            depth: simd.load(&group.depth),
            per_depth: simd.load(&group.depth).recip(),
            minor: simd.load(&group.minor),
            drop: simd.load(&group.drop),
            scale: simd.splat(march.heights.scale as f32),
            offset: simd.splat((march.heights.offset - eye.z) as f32),
        };

        Planes {
            simd,
            eye,
            group,
            ground,
            way: Way::new(eye[group.major], group.forward, size, f64::from(nearest)),
            over: [simd.load(&enter), simd.load(&leave)],
            inner: [
                enter.iter().fold(0.0_f32, |a, &b| a.max(b)),
                leave.iter().fold(f32::INFINITY, |a, &b| a.min(b)),
            ],
            farthest,
            field,
            steep: SteepRise::new(&field),
            clearance: ((eye.z - march.ceiling) / march.grid.spacing).max(0.0),
            horizon: simd.splat(field.tangents[0]),
            profile,
            is_begun: false,
            last: simd.splat(NO_SLOPE),
            reached: nearest,
            latest: None,
            leapt_from: None,
            bare_until: 0.0,
            relief: march.displaced.map(|field| DisplacedPlanes::new(simd, field, eye, group)),
            displaced_stretch: DisplacedStretch::new(march.displaced),
            march,
        }
        .march()
    }
}

/// Sixteen planes on their way.
pub(super) struct Planes<'f, 'a, V: Simd> {
    pub(super) simd: V,
    pub(super) march: &'f mut PlaneMarch<'a>,
    pub(super) eye: DVec3,
    pub(super) group: &'f PlaneGroup,
    pub(super) ground: PlaneGround<V>,
    pub(super) way: Way,
    /// Major distances at which planes enter and leave the area, units; between those of `inner` all are over it.
    pub(super) over: [V::F; 2],
    pub(super) inner: [f32; 2],
    pub(super) farthest: f32,
    pub(super) field: MarchField,
    /// Tangents that a stretch may rise over before the surface between its ends is looked at.
    pub(super) steep: SteepRise,
    /// Least height of the eye above the ground, units; 0 if it is among the hills.
    clearance: f64,
    /// Greatest slope of the surface so far: what lies below is hidden.
    pub(super) horizon: V::F,
    pub(super) profile: &'f mut Profile,
    /// Slope of the surface at `reached`, if it `is_begun`: known there. Beside the area it goes on as its edge.
    pub(super) last: V::F,
    pub(super) is_begun: bool,
    /// Major distance up to which the march has come, units.
    pub(super) reached: f32,
    /// Lines of the block before.
    pub(super) latest: Option<Lines<'a>>,
    /// Index of the narrowest square from which a leap was tried last.
    pub(super) leapt_from: Option<i64>,
    /// Major distance at which bare ground ends, units.
    bare_until: f64,
    /// Displacement of the ground, and where it is.
    pub(super) relief: Option<DisplacedPlanes<'a, V>>,
    pub(super) displaced_stretch: DisplacedStretch<'a>,
}

/// The march of one block: most of the code of a march, and needed wherever lines are read.
struct BlockMarch<'p, 'f, 'a, V: Simd> {
    planes: &'p mut Planes<'f, 'a, V>,
    block: &'p LineBlock,
}

impl<V: Simd> Kernel for BlockMarch<'_, '_, '_, V> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Result<()> {
        self.planes.march_lines(self.block)
    }
}

impl<'a, V: Simd> Planes<'_, 'a, V> {
    #[inline(always)]
    fn march(mut self) -> Result<f64> {
        let ceiling = self.simd.splat((self.march.ceiling - self.eye.z) as f32);
        let mut stride = 0;
        while self.reached < self.farthest {
            if self.is_over(ceiling) {
                return Ok(self.bare_until);
            }

            let (chosen, _) = self.next_stride(&mut stride);
            let mut way = self.way;

            let Some(mut block) = way.next(chosen, self.reached.into()) else {
                if let Some((lines, block)) = self.march_last_line(chosen)? {
                    self.pass_last_line(&lines, &block);
                }
                break;
            };

            if chosen.level == BARE {
                // Bare ground ends where the reference has it end, to a line.
                let until = self.march.strides.bare_until() / self.group.ground;
                if way.end(&block) > until {
                    let Some(near) = way.cut(&block, until) else {
                        stride = self.march.strides.first_of_surface();
                        continue;
                    };
                    block = near;
                }
                self.bare_until = way.passed();
            }

            self.way = way;
            self.march_block(&block)?;
            if !self.is_begun && chosen.level != BARE {
                self.leap(stride);
            }
        }

        Ok(self.bare_until)
    }

    /// Goes on to the stride of where the march has come to, no shorter than `stride` so far; returns it and the major distance up to which it holds,
    /// units.
    #[inline(always)]
    pub(super) fn next_stride(&self, stride: &mut usize) -> (Stride, f64) {
        let strides = &self.march.strides;
        *stride = strides.index_at(f64::from(self.reached) * self.group.ground, *stride);
        let (chosen, until) = strides.with_end(*stride);
        (chosen, until / self.group.ground)
    }

    /// Whether nothing can rise above the rays any more.
    #[inline(always)]
    fn is_over(&self, ceiling: V::F) -> bool {
        let cleared = self.clears(self.simd.splat(self.reached), ceiling);
        let rising = self.simd.splat(0.0).le(self.horizon);
        (cleared & rising | self.is_full()).all()
    }

    /// Planes that are covered up to their highest row.
    #[inline(always)]
    fn is_full(&self) -> V::M {
        self.simd.splat(self.field.tangents[1]).le(self.horizon)
    }

    /// Planes whose horizon hides the height `z` (metres above the eye) at a major distance.
    #[inline(always)]
    fn clears(&self, distance: V::F, z: V::F) -> V::M {
        z.lt(self.horizon * self.ground.depth * distance)
    }

    /// Marches the lines of a block.
    ///
    /// # Errors
    /// A page that is damaged.
    #[inline(always)]
    pub(super) fn march_block(&mut self, block: &LineBlock) -> Result<()> {
        if block.count == 0 {
            return Ok(());
        }
        self.simd.call(BlockMarch { planes: self, block })
    }

    #[inline(always)]
    fn march_lines(&mut self, block: &LineBlock) -> Result<()> {
        let level = block.stride.level;
        let last = self.way.distance(level, block.first + block.step * (block.count - 1));
        let hidden = self.is_hidden(block)?;
        if hidden && !self.is_begun {
            self.reached = last as f32;
            return Ok(());
        }

        let posts = self.posts(level, [self.reached.into(), last]);
        let latest = self.latest.take();
        let pages = &mut self.march.pages;
        let Some(lines) = Lines::find(pages, latest, level, self.group.major, block.first, posts)? else {
            self.march_coarser(block)?;
            // Coarser lines saw what ends in the block; behind it nothing is known.
            if hidden {
                self.is_begun = false;
                self.reached = self.reached.max(last as f32);
            }
            return Ok(());
        };

        if !self.is_begun {
            self.prime(block)?;
        }
        let is_displaced = self.reached < self.displaced_stretch.until && !block.stride.stands_in;
        if hidden {
            // The segment that ends in it began before.
            if is_displaced {
                self.march_displaced(&lines, block, 1);
            } else {
                let post = self.line(&lines, block, block.first, block.stride.lines);
                self.step(&lines, block, &post, false)?;
            }
            self.is_begun = false;
            self.reached = last as f32;
        } else if is_displaced {
            self.march_displaced(&lines, block, block.count);
        } else {
            self.march_along(&lines, block, last as f32)?;
        }
        self.latest = Some(lines);
        Ok(())
    }

    /// Marches along the lines of a block, the last of which lies at a major distance.
    #[inline(always)]
    fn march_along(&mut self, lines: &Lines<'a>, block: &LineBlock, last: f32) -> Result<()> {
        let near = block.stride.lines == 1 && self.is_near(block.stride.level);
        // Most blocks end here.
        let slopes = self.slopes(lines, block);
        let at_edge = self.is_at_edge(last);
        let is_whole = slopes.is_whole && !self.is_nothing(self.last).any();
        let is_in_sight = near || at_edge || self.horizon.lt(slopes.highest).any();
        let last_slope = slopes.slope(block.count - 1);
        if !is_in_sight && (is_whole || !self.is_at_rim(self.simd.load(&last_slope.0))) {
            self.skip(block, last, last_slope);
            return Ok(());
        }
        if is_whole && !near && !at_edge {
            return self.pass_lines(lines, block, &slopes);
        }

        for index in 0..block.count {
            let line = block.first + index * block.step;
            let post = self.stored(block, line, slopes.slope(index));
            self.step(lines, block, &post, near)?;
        }

        Ok(())
    }

    /// Whether straight stretches from line to line of a level are too coarse here.
    #[inline(always)]
    pub(super) fn is_near(&self, level: u8) -> bool {
        self.clearance.hypot(self.reached.into()) < NEAR * f64::from(Grid::side_units(level))
    }

    /// Passes a block in which nothing rises above the horizons.
    #[inline(always)]
    fn skip(&mut self, block: &LineBlock, last: f32, last_slope: &Sixteen) {
        let line = block.first + (block.count - 1) * block.step;
        let post = self.stored(block, line, last_slope);
        // No edge of the area is in the block.
        self.profile.begin(&post);
        self.last = post.slope;
        self.reached = last;
    }

    /// A post of which the slope is known.
    #[inline(always)]
    pub(super) fn stored(&self, block: &LineBlock, line: i64, slope: &Sixteen) -> Post<V> {
        let mark = self.mark(block, line);
        let inverse = self.ground.per_depth * self.simd.splat(1.0 / mark.distance);
        Post { slope: self.simd.load(&slope.0), inverse, line: mark }
    }

    /// Marches a block of which a page is absent along lines of the next coarser level.
    #[cold]
    fn march_coarser(&mut self, block: &LineBlock) -> Result<()> {
        let level = block.stride.coarser();
        if level >= self.march.level_count {
            return Ok(());
        }
        let lines = if block.stride.lines == 4 { 1 } else { block.stride.lines };
        let stride = Stride { level, lines, stands_in: true, ..block.stride };
        let mut way = self.way.back_to(block);
        while !way.is_past(block)
            && let Some(part) = way.next(stride, self.reached.into())
        {
            self.march_block(&part)?;
        }
        Ok(())
    }

    /// Posts of a level between which the planes are at two major distances.
    #[inline(always)]
    pub(super) fn posts(&self, level: u8, distances: [f64; 2]) -> LinePosts {
        let side = f64::from(Grid::side_units(level));
        let units = self.units(distances);
        let [first, last] =
            [(units[0] / side - 0.5).floor() as i64, (units[1] / side - 0.5).floor() as i64 + 1];
        let ahead = self.group.minor[0] < self.group.minor[LANES - 1];
        let next = if ahead { 2 * last - first } else { 2 * first - last };
        LinePosts { ends: [first, last], next }
    }

    /// Position across, least and greatest, of the planes between two major distances, units.
    #[inline(always)]
    pub(super) fn units(&self, distances: [f64; 2]) -> [f64; 2] {
        let eye = self.eye[1 - self.group.major];
        let [a, b] = [0, LANES - 1].each(|lane| f64::from(self.group.minor[lane]));
        let (low, high) = (a.min(b), a.max(b));
        [
            eye + (low * distances[0]).min(low * distances[1]),
            eye + (high * distances[0]).max(high * distances[1]),
        ]
    }

    /// Whether all rays clear the highest surface from here to the end of a block.
    #[inline(always)]
    pub(super) fn is_hidden(&mut self, block: &LineBlock) -> Result<bool> {
        let Some((level, voxels)) = self.march.bounding(&block.stride) else { return Ok(false) };

        let end = self.way.end(block);
        let dims = self.march.grid.dims(level);
        let last = i64::from([dims.0, dims.1][1 - self.group.major] - 1);
        let side = f64::from(Grid::side_units(level));
        let minor = self
            .units([self.reached.into(), end])
            .each(|units| ((units / side).floor() as i64).clamp(0, last) as u32);
        let length = i64::from([dims.0, dims.1][self.group.major]);
        let major = [block.index * voxels, ((block.index + 1) * voxels).min(length) - 1];
        let major = major.each(|index| index as u32);
        let code = highest_code(&mut self.march.pages, level, self.group.major, major, minor)?;
        if code == u16::MAX {
            return Ok(false);
        }
        Ok(self.hides(code, [self.reached, end as f32]))
    }

    /// Whether all rays clear a surface that is nowhere higher than a code between two major distances.
    #[inline(always)]
    pub(super) fn hides(&self, code: u16, [from, to]: [f32; 2]) -> bool {
        if code == HeightCode::EMPTY {
            return true;
        }
        let lift = self.displaced_stretch.bound(from);
        let height = self.march.heights.offset + self.march.heights.scale * f64::from(code) - self.eye.z;
        let height = height + lift;
        let (from, to) = (self.simd.splat(from), self.simd.splat(to));
        let top = self.ground.drop.neg_mul_add(from * from, self.simd.splat(height as f32));
        (self.clears(from, top) & self.clears(to, top) | self.is_full()).all()
    }
}
