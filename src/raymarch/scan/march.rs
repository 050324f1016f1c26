//! The march of one group of planes, block by block.

use glam::DVec3;

use super::blocks::{Block, Way};
use super::bounds::highest_code;
use super::ground::{Ground, NOTHING};
use super::lines::Lines;
use super::segment::{Open, Post, Segment};
use super::strides::Stride;
use super::{Pages, PlaneGroup, Strides};
use crate::error::Result;
use crate::simd::{Floats, Isa, Kernel, LANES, Mask, Simd, Sixteen};
use crate::voxel::{Grid, HeightCode, PageSource};

/// Distances that differ by less than this, in sides of a voxel, are one and the same line.
const SAME: f64 = 1.0e-3;

/// Lines from the eye within which the straight segments between lines are too coarse: near the
/// ground, planes follow the bilinear surface itself there.
const NEAR: f64 = 48.0;

/// Rows to fill, for one group of planes.
pub struct Rows<'r> {
    /// Tangent of each row's elevation angle, rising; one more than there are rows, the last is +∞.
    pub tangents: &'r [f32],
    /// Inverse depth, 1/metres, of each row and plane; zero where the sky is seen, and before the march.
    pub inverse: &'r mut [Sixteen],
}

/// Marches groups of planes through one database.
pub struct PlaneMarch<'a> {
    pages: Pages<'a>,
    grid: Grid,
    heights: HeightCode,
    level_count: u8,
    /// Height that no surface reaches, metres above the datum.
    ceiling: f64,
    strides: Strides,
}

impl<'a> PlaneMarch<'a> {
    /// A march over `source`, with lines as far apart as `strides` says.
    pub fn new(source: &'a dyn PageSource, strides: Strides) -> Self {
        let header = source.header();
        Self {
            pages: Pages::new(source),
            grid: header.grid,
            heights: header.heights,
            level_count: header.level_count,
            ceiling: header.height_range.1 + header.heights.scale,
            strides,
        }
    }

    /// Fills `rows` with what the planes of `group` see from `eye` (units, units, metres).
    pub fn fill(&mut self, isa: Isa, eye: DVec3, group: &PlaneGroup, rows: Rows<'_>) -> Result<()> {
        isa.run(Filling { march: self, eye, group, rows })
    }
}

struct Filling<'f, 'a> {
    march: &'f mut PlaneMarch<'a>,
    eye: DVec3,
    group: &'f PlaneGroup,
    rows: Rows<'f>,
}

impl Kernel for Filling<'_, '_> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Result<()> {
        let Self { march, eye, group, rows } = self;
        let [enter, leave] = group.over;
        let nearest = enter.iter().fold(f32::INFINITY, |a, &b| a.min(b));
        let farthest = leave.iter().fold(0.0_f32, |a, &b| a.max(b));
        if nearest > farthest {
            rows.inverse.fill(Sixteen::default());
            return Ok(());
        }
        let size = [march.grid.nx, march.grid.ny][group.major];
        let ground = Ground {
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
            open: Open::new(simd, rows, ground.depth),
            last: None,
            reached: nearest,
            march,
        }
        .march()
    }
}

/// Sixteen planes on their way.
struct Planes<'f, 'a, V: Simd> {
    simd: V,
    march: &'f mut PlaneMarch<'a>,
    eye: DVec3,
    group: &'f PlaneGroup,
    ground: Ground<V>,
    way: Way,
    /// Major distances at which planes enter and leave the area, units; between those of `inner` all are over it.
    over: [V::F; 2],
    inner: [f32; 2],
    farthest: f32,
    open: Open<'f, V>,
    /// Where the surface was at `reached`; `None` where that was skipped.
    last: Option<Post<V>>,
    /// Major distance up to which the march has come, units.
    reached: f32,
}

impl<'a, V: Simd> Planes<'_, 'a, V> {
    #[inline(always)]
    fn march(mut self) -> Result<()> {
        let ceiling = self.simd.splat((self.march.ceiling - self.eye.z) as f32);
        let mut stride = 0;
        while !self.is_over(ceiling) {
            stride = self.march.strides.index_at(f64::from(self.reached) * self.group.ground, stride);
            let mut way = self.way;
            let Some(block) = way.next(self.march.strides.get(stride), self.reached.into()) else { break };
            self.way = way;
            self.march_block(&block)?;
        }
        // What a plane sees between its last line and the edge of the area.
        if self.last.is_some() {
            let nothing = self.simd.splat(NOTHING);
            self.reach(f32::INFINITY, Post { z: nothing, depth: nothing, slope: nothing }, None);
        }
        self.open.finish();
        Ok(())
    }

    /// Whether nothing can rise above the rays any more.
    #[inline(always)]
    fn is_over(&self, ceiling: V::F) -> bool {
        let cleared = self.open.clears(self.simd.splat(self.reached), ceiling);
        let rising = self.simd.splat(0.0).le(self.open.tangent);
        self.reached >= self.farthest || (cleared & rising).all()
    }

    #[inline(always)]
    fn march_block(&mut self, block: &Block) -> Result<()> {
        if block.count == 0 {
            return Ok(());
        }
        let level = block.stride.level;
        let last = self.way.distance(level, block.first + block.step * (block.count - 1));
        let hidden = self.is_hidden(block)?;
        if hidden && self.last.is_none() {
            self.reached = last as f32;
            return Ok(());
        }
        let posts = self.posts(level, [self.reached.into(), last]);
        let Some(lines) = Lines::find(&mut self.march.pages, level, self.group.major, block.first, posts)?
        else {
            return self.march_coarser(block);
        };
        if self.last.is_none() {
            self.prime(block)?;
        }
        if hidden {
            // The segment that ends in it began before.
            self.step(&lines, level, block.first, false);
            self.last = None;
            self.reached = last as f32;
            return Ok(());
        }
        let near =
            block.stride.lines == 1 && f64::from(self.reached) < NEAR * f64::from(Grid::side_units(level));
        for index in 0..block.count {
            self.step(&lines, level, block.first + index * block.step, near);
        }
        Ok(())
    }

    /// Marches a block of which a page is absent along lines of the next coarser level.
    #[cold]
    fn march_coarser(&mut self, block: &Block) -> Result<()> {
        let level = block.stride.level + 1;
        if level >= self.march.level_count {
            return Ok(());
        }
        let lines = if block.stride.lines == 4 { 1 } else { block.stride.lines };
        let stride = Stride { level, lines, ..block.stride };
        let mut way = self.way.back_to(block);
        while !way.is_past(block)
            && let Some(part) = way.next(stride, self.reached.into())
        {
            self.march_block(&part)?;
        }
        Ok(())
    }

    /// Posts of a level, first and last, between which the planes are at two major distances.
    #[inline(always)]
    fn posts(&self, level: u8, distances: [f64; 2]) -> [i64; 2] {
        let side = f64::from(Grid::side_units(level));
        let units = self.units(distances);
        [(units[0] / side - 0.5).floor() as i64, (units[1] / side - 0.5).floor() as i64 + 1]
    }

    /// Position across, least and greatest, of the planes between two major distances, units.
    #[inline(always)]
    fn units(&self, distances: [f64; 2]) -> [f64; 2] {
        let eye = self.eye[1 - self.group.major];
        let [a, b] = [0, LANES - 1].map(|lane| f64::from(self.group.minor[lane]));
        let (low, high) = (a.min(b), a.max(b));
        [
            eye + (low * distances[0]).min(low * distances[1]),
            eye + (high * distances[0]).max(high * distances[1]),
        ]
    }

    /// Whether all rays clear the highest surface from here to the end of a block.
    #[inline(always)]
    fn is_hidden(&mut self, block: &Block) -> Result<bool> {
        let level = block.stride.skip_level();
        if level >= self.march.level_count {
            return Ok(false);
        }
        let end = self.way.end(block);
        let dims = self.march.grid.dims(level);
        let last = i64::from([dims.0, dims.1][1 - self.group.major] - 1);
        let side = f64::from(Grid::side_units(level));
        let minor = self
            .units([self.reached.into(), end])
            .map(|units| ((units / side).floor() as i64).clamp(0, last) as u32);
        let code = highest_code(&mut self.march.pages, level, self.group.major, block.index as u32, minor)?;
        if code == u16::MAX {
            return Ok(false);
        }
        if code == HeightCode::EMPTY {
            return Ok(true);
        }
        let height = self.march.heights.offset + self.march.heights.scale * f64::from(code) - self.eye.z;
        let (from, to) = (self.simd.splat(self.reached), self.simd.splat(end as f32));
        let top = self.ground.drop.neg_mul_add(from * from, self.simd.splat(height as f32));
        Ok((self.open.clears(from, top) & self.open.clears(to, top)).all())
    }

    /// Finds where the surface is one line before a block's first: nothing is known after blocks that
    /// were skipped, or at the start.
    #[inline(always)]
    fn prime(&mut self, block: &Block) -> Result<()> {
        let level = block.stride.level;
        let side = f64::from(Grid::side_units(level));
        let before = block.first - block.step;
        let distance = self.way.distance(level, before);
        let start = f64::from(self.reached).max(distance).max(0.0);
        let at = self.simd.splat(start as f32);
        let posts = self.posts(level, [start, start]);
        let z = if distance < start - SAME * side {
            // In the middle of a stride, where the march begins.
            match Lines::find(&mut self.march.pages, level, self.group.major, block.first, posts)? {
                Some(lines) => {
                    let ahead = (self.way.distance(level, block.first) - start) / side;
                    let share = self.simd.splat((1.0 - ahead).max(0.0) as f32);
                    self.ground.surface(&lines, level, block.first, at, share)
                }
                None => self.simd.splat(NOTHING),
            }
        } else {
            match Lines::find(&mut self.march.pages, level, self.group.major, before, posts)? {
                Some(lines) => self.ground.height(self.ground.codes(&lines, level, before, at), at),
                None => self.simd.splat(NOTHING),
            }
        };
        self.reached = start as f32;
        if start == 0.0 && self.simd.splat(0.0).lt(z).any() && self.inner[0] == 0.0 {
            self.open.flood();
        }
        let post = self.post(z, at, start as f32);
        self.open.raise(&post);
        self.last = Some(post);
        Ok(())
    }

    /// Goes to a line.
    #[inline(always)]
    fn step(&mut self, lines: &Lines<'a>, level: u8, line: i64, near: bool) {
        let distance = self.way.distance(level, line) as f32;
        let at = self.simd.splat(distance);
        let z = self.ground.height(self.ground.codes(lines, level, line, at), at);
        let post = self.post(z, at, distance);
        self.reach(distance, post, near.then_some((lines, level, line)));
    }

    /// The surface at height `z` above the eye, at a major distance.
    #[inline(always)]
    fn post(&self, z: V::F, at: V::F, distance: f32) -> Post<V> {
        let per_unit = self.simd.splat(1.0 / distance.max(f32::MIN_POSITIVE));
        Post { z, depth: self.ground.depth * at, slope: z * self.ground.per_depth * per_unit }
    }

    /// Fills what the surface hides between here and a line at a major distance.
    #[inline(always)]
    fn reach(&mut self, distance: f32, post: Post<V>, near: Option<(&Lines<'a>, u8, i64)>) {
        let Some(last) = self.last.replace(post) else { return };
        let from = std::mem::replace(&mut self.reached, distance);
        let mut segment = Segment { last, post, inside: self.simd.mask(u16::MAX) };
        if from < self.inner[0] || distance > self.inner[1] {
            segment = self.within_area(segment, from, distance);
        }
        let Some(first) = self.open.first_risen(&segment) else {
            self.open.raise(&segment.post);
            return;
        };
        match near {
            None => self.open.fill(&segment, first, |linear, _, _| linear),
            Some((lines, level, line)) => {
                let (ground, way) = (self.ground, self.way);
                let side = Grid::side_units(level) as f32;
                let surface = |at: V::F| {
                    let share = (at - self.simd.splat(way.distance(level, line) as f32))
                        * self.simd.splat(1.0 / side);
                    ground.surface(lines, level, line, at, share + self.simd.splat(1.0))
                };
                self.open.fill(&segment, first, |inverse, tangent, heights| {
                    ground.refine(&segment, inverse, tangent, heights, surface)
                });
            }
        }
        self.open.raise(&segment.post);
    }

    /// Ends the segment where planes enter and leave the area: the surface goes on level to its edge.
    #[cold]
    fn within_area(&self, segment: Segment<V>, from: f32, to: f32) -> Segment<V> {
        let [enter, leave] = self.over;
        let inside = |distance: f32| {
            let at = self.simd.splat(distance);
            enter.le(at) & at.le(leave)
        };
        let (before, after) = (inside(from), inside(to));
        let Segment { mut last, mut post, .. } = segment;
        let (entering, leaving) = (after & !before, before & !after);
        last.z = post.z.select(entering, last.z);
        last.depth = (self.ground.depth * enter).select(entering, last.depth);
        post.z = last.z.select(leaving, post.z);
        post.depth = (self.ground.depth * leave).select(leaving, post.depth);
        post.slope = post.slope.select(after, self.simd.splat(NOTHING));
        Segment { last, post, inside: before | after }
    }
}
