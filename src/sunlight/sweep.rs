//! Shadows, carried away from the sun.

use super::course::{Course, Leg};
use super::rows::{CourseRows, NONE, mix};
use crate::simd::{Isa, Kernel, Simd};
use hedgehop_base::error::Result;

/// Shadows by strand.
#[derive(Debug)]
pub(super) struct Shadow {
    /// Height up to which nothing is seen of the sun, metres: what lies below it, and behind what throws it, sees not even the upper rim.
    pub full: Vec<f32>,
    /// Height from which on all of it is seen, metres.
    pub half: Vec<f32>,
    /// Distance to what throws the half-shadow, metres.
    pub way: Vec<f32>,
}

/// Step from one row to the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Metres along the ground.
    way: f32,
    /// Falls of rays from the sun's upper and lower rim, metres.
    falls: [f32; 2],
}

/// Effect of a row on the strands that cross it.
pub(super) struct Crossing<'s> {
    /// Just before the row; just before the next one afterwards.
    pub shadow: &'s mut Shadow,
    /// Heights of the row's posts from the first strand on.
    pub row: &'s [f32],
    /// Share of the way from a post to the next one.
    pub share: f32,
    /// Until the next row.
    pub step: Step,
}

impl Step {
    /// Computes the step from row to row of a level.
    pub fn of(course: &Course, level: u8) -> Self {
        Self { way: course.way(level), falls: course.falls(level) }
    }

    /// A part of it.
    pub fn times(self, part: f32) -> Self {
        Self { way: self.way * part, falls: self.falls.map(|fall| fall * part) }
    }
}

impl Kernel for Crossing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Simd>(self, _: V) {
        let Self { shadow: Shadow { full, half, way }, row, share, step } = self;
        let heights = row.iter().zip(&row[1..]);
        for ((((from, to), full), half), way) in heights.zip(full).zip(half).zip(way) {
            let height = mix(*from, *to, share);
            *way = if height > *half { 0.0 } else { *way } + step.way;
            *full = full.max(height) - step.falls[0];
            *half = half.max(height) - step.falls[1];
        }
    }
}

impl Shadow {
    /// Makes a shadow of nothing.
    fn none(strands: usize) -> Self {
        Self { full: vec![NONE; strands], half: vec![NONE; strands], way: vec![0.0; strands] }
    }

    /// Carries it over ground that throws none.
    pub fn go(&mut self, step: Step) {
        self.full.iter_mut().for_each(|height| *height -= step.falls[0]);
        self.half.iter_mut().for_each(|height| *height -= step.falls[1]);
        self.way.iter_mut().for_each(|way| *way += step.way);
    }

    /// Brings the shadow of a coarser leg, the one `before`, to the strands of `leg`.
    fn on_finer(&self, course: &Course, leg: &Leg, before: &Leg) -> Self {
        let finer = |coarse: &Vec<f32>| {
            let strand = |index: usize| {
                let place = course.coarser_strand(leg, leg.first + index as i64) - before.first as f64;
                let index = place as usize;
                mix(coarse[index], coarse[index + 1], place.fract() as f32)
            };
            (0..leg.strands).map(strand).collect()
        };
        Self { full: finer(&self.full), half: finer(&self.half), way: finer(&self.way) }
    }
}

/// Carries shadows over `legs`, the last of which comes first, to where that ends.
pub(super) fn carry(rows: &CourseRows<'_>, legs: &[Leg], strands: usize, isa: Isa) -> Result<Shadow> {
    let course = rows.course;
    let mut carried: Option<(Shadow, &Leg)> = None;
    let mut row = Vec::new();
    for leg in legs.iter().rev() {
        let mut shadow = match &carried {
            None => Shadow::none(leg.strands),
            Some((coarse, before)) => coarse.on_finer(course, leg, before),
        };
        let step = Step::of(course, leg.level);

        // From where the leg begins, half a row before its first.
        shadow.go(step.times(0.5));
        row.resize(leg.strands + 1, NONE);
        for index in (0..leg.count).rev() {
            let number = leg.near + index * course.towards;
            let (aside, share) = course.aside(number);
            rows.read(leg.level, number, leg.first + aside, &mut row)?;
            let part = if index == 0 { (leg.end - number as f64).abs() as f32 } else { 1.0 };
            isa.run(Crossing { shadow: &mut shadow, row: &row, share, step: step.times(part) });
        }

        carried = Some((shadow, leg));
    }

    Ok(carried.map_or_else(|| Shadow::none(strands), |(shadow, _)| shadow))
}
