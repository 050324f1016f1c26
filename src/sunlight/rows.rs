//! Heights along rows of posts.

use std::ops::Range;

use super::course::Course;
use crate::voxel::{APRON, HeightCode, PAGE_SIDE, PageId, PageSource, RADIX};
use hedgehop_base::error::Result;

/// Height of what is not there: below all ground, and far enough from infinity to be calculated with, metres.
pub(super) const NONE: f32 = -1.0e30;

/// Reads rows across a course.
pub(super) struct CourseRows<'a> {
    pub source: &'a dyn PageSource,
    pub course: &'a Course,
}

impl CourseRows<'_> {
    /// Heights of a level's posts from `first` on along a row, metres; [`NONE`] beside the area and where there is no surface. Where a page is absent the
    /// next coarser level stands in.
    pub fn read(&self, level: u8, row: i64, first: i64, target: &mut [f32]) -> Result<()> {
        target.fill(NONE);
        let dims = self.course.dims(level);
        let major = self.course.major;
        if !(0..dims[major]).contains(&row) {
            return Ok(());
        }

        let side = i64::from(PAGE_SIDE);
        let end = (first + target.len() as i64).min(dims[1 - major]);
        let mut from = first.max(0);
        while from < end {
            let page = from / side;
            let until = end.min((page + 1) * side);
            let part = &mut target[(from - first) as usize..(until - first) as usize];
            let [px, py] = if major == 0 { [row / side, page] } else { [page, row / side] };
            let id = PageId { level, px: px as u32, py: py as u32 };

            match self.source.heights(id)? {
                Some(view) => {
                    let stride = (view.width + 2 * APRON) as usize;
                    let [along, across] =
                        [row % side, from % side].map(|place| place as usize + APRON as usize);
                    let (start, step) = if major == 0 {
                        (across * stride + along, stride)
                    } else {
                        (along * stride + across, 1)
                    };
                    decode(&self.source.header().heights, &view.heights[start..], step, part);
                }
                None => self.stand_in(level, row, from..until, part)?,
            }

            from = until;
        }

        Ok(())
    }

    /// The next coarser level's heights at some posts; none of the coarsest.
    fn stand_in(&self, level: u8, row: i64, posts: Range<i64>, target: &mut [f32]) -> Result<()> {
        if level + 1 >= self.source.header().level_count {
            return Ok(());
        }

        let coarser = |post: i64| (post as f64 + 0.5) / f64::from(RADIX) - 0.5;
        let (place, first) = (coarser(row), coarser(posts.start).floor());
        let count = (coarser(posts.end - 1).floor() - first) as usize + 2;
        let last =
            [self.course.major, 1 - self.course.major].map(|axis| self.course.dims(level + 1)[axis] - 1);
        let mut rows = [vec![0.0; count], vec![0.0; count]];

        for (next, heights) in (0..).zip(&mut rows) {
            let row = (place.floor() as i64 + next).clamp(0, last[0]);
            self.read(level + 1, row, first as i64, heights)?;
            // The ground goes on level beside the last posts.
            let within = |index: usize| (first as i64 + index as i64).clamp(0, last[1]) - first as i64;
            let nearest: Vec<_> = (0..count).map(|index| heights[within(index) as usize]).collect();
            *heights = nearest;
        }

        let share = (place - place.floor()) as f32;
        for (target, post) in target.iter_mut().zip(posts) {
            let place = coarser(post) - first;
            let (index, across) = (place as usize, place.fract() as f32);
            let [low, high] = rows.each_ref().map(|row| mix(row[index], row[index + 1], across));
            *target = mix(low, high, share);
        }

        Ok(())
    }
}

/// Between two heights.
#[inline(always)]
pub(super) fn mix(from: f32, to: f32, share: f32) -> f32 {
    from * (1.0 - share) + to * share
}

/// Heights of every `step`th code.
fn decode(heights: &HeightCode, codes: &[u16], step: usize, target: &mut [f32]) {
    let (scale, offset) = (heights.scale as f32, heights.offset as f32);
    let height = |code: u16| if code == HeightCode::EMPTY { NONE } else { f32::from(code) * scale + offset };
    if step == 1 {
        for (target, code) in target.iter_mut().zip(codes) {
            *target = height(*code);
        }
    } else {
        for (target, code) in target.iter_mut().zip(codes.iter().step_by(step)) {
            *target = height(*code);
        }
    }
}
