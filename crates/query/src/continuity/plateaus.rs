//! Connected voxels of one height: tops that were cut off, and voids.
//!
//! ```text
//! for each page: connect voxels with those to the east and north that have the same code
//! what goes on over the border of a page is joined when the page beyond has been seen
//! a void:      voxels without a surface
//! a flat top:  at least 9 voxels with lower ones all around, a quarter of a voxel's side lower on the mean: no summit is so level and so steep
//! ```

use std::collections::HashMap;

use glam::DVec2;

use crate::continuity::found::{Found, Patch};
use crate::continuity::{Fault, Finding};
use hedgehop::voxel::HeightCode;

/// Voxels of a flat top, at least.
const LEAST_VOXELS: u64 = 9;
/// Fall of the ground at its rim, in sides of a voxel.
const STEEP: f64 = 0.25;

/// Voxels of one height.
#[derive(Clone, Copy)]
struct Plateau {
    code: u16,
    voxels: u64,
    /// Some voxel of it that does not depend on the order of pages: the southernmost, of these the westernmost. Metres.
    place: DVec2,
    extent: [DVec2; 2],
    /// Height of it, and side of a voxel, metres.
    height: f64,
    side: f64,
    /// Some neighbour is higher, or has no surface.
    is_held: bool,
    is_at_edge: bool,
    /// Sum of the steps down to lower neighbours, metres, and their number.
    falls: [f64; 2],
}

impl Plateau {
    fn merge(&mut self, other: &Self) {
        let order = |place: DVec2| (place.y, place.x);
        if order(other.place) < order(self.place) {
            self.place = other.place;
        }
        self.voxels += other.voxels;
        self.extent = [self.extent[0].min(other.extent[0]), self.extent[1].max(other.extent[1])];
        self.is_held |= other.is_held;
        self.is_at_edge |= other.is_at_edge;
        self.falls = [self.falls[0] + other.falls[0], self.falls[1] + other.falls[1]];
    }

    fn report(&self, found: &mut Found) {
        let Self { code, voxels, place, extent, height, is_at_edge, .. } = *self;
        let finding = |fault, size| Finding { fault, place, extent, height, size, voxels, is_at_edge };
        if code == HeightCode::EMPTY {
            found.add(finding(Fault::Void, (voxels as f64).sqrt() * self.side));
            return;
        }
        let fall = self.falls[0] / self.falls[1].max(1.0);
        if voxels >= LEAST_VOXELS && !self.is_held && !is_at_edge && fall >= STEEP * self.side {
            found.add(finding(Fault::FlatTop, fall));
        }
    }
}

/// Plateaus that go on beyond their page.
#[derive(Default)]
pub(super) struct Plateaus {
    plateaus: Vec<Plateau>,
    /// Plateau that each one is part of; itself, if none.
    part_of: Vec<usize>,
    /// Sides of voxels beyond which the same code goes on, by the voxel to the south or west of it and whether it is to the north, and who waits there.
    open: HashMap<(i64, i64, bool), usize>,
}

impl Plateaus {
    pub fn add(&mut self, patch: &Patch, found: &mut Found) {
        let labels = labels(patch);
        let [width, height] = patch.size;
        let label = |x: i64, y: i64| labels[(y * width + x) as usize];
        let count = labels.iter().max().map_or(0, |most| most + 1);
        let mut own: Vec<Option<Plateau>> = vec![None; count];

        // Places of `plateaus` for those that go on.
        let mut numbers: Vec<Option<usize>> = vec![None; count];
        let mut links = Vec::new();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let voxel = voxel(patch, x, y);
            match &mut own[label(x, y)] {
                Some(known) => known.merge(&voxel),
                none => *none = Some(voxel),
            }

            for (right, up) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let (there_x, there_y) = (x + right, y + up);
                let is_own = (0..width).contains(&there_x) && (0..height).contains(&there_y);
                if !is_own
                    && is_inside(patch, there_x, there_y)
                    && patch.code_at(there_x, there_y) == patch.code_at(x, y)
                {
                    let (first_x, first_y) =
                        (patch.first[0] + x.min(there_x), patch.first[1] + y.min(there_y));
                    links.push(((first_x, first_y, up != 0), label(x, y)));
                }
            }
        }

        for (side, label) in links {
            let number = *numbers[label].get_or_insert_with(|| {
                self.plateaus.extend(own[label].take());
                self.part_of.push(self.part_of.len());
                self.part_of.len() - 1
            });
            match self.open.remove(&side) {
                Some(other) => self.unite(number, other),
                None => {
                    self.open.insert(side, number);
                }
            }
        }

        own.iter().flatten().for_each(|plateau| plateau.report(found));
    }

    /// Reports what went on beyond pages.
    pub fn join(mut self, found: &mut Found) {
        for number in 0..self.plateaus.len() {
            let root = self.root(number);
            if root != number {
                let part = self.plateaus[number];
                self.plateaus[root].merge(&part);
            }
        }
        let roots = self.plateaus.iter().zip(&self.part_of).enumerate();
        roots
            .filter(|(number, (_, part_of))| number == *part_of)
            .for_each(|(_, (plateau, _))| plateau.report(found));
    }

    fn root(&mut self, mut number: usize) -> usize {
        while self.part_of[number] != number {
            self.part_of[number] = self.part_of[self.part_of[number]];
            number = self.part_of[number];
        }
        number
    }

    fn unite(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one), self.root(other));
        self.part_of[one.max(other)] = one.min(other);
    }
}

/// A voxel as a plateau of its own.
fn voxel(patch: &Patch, x: i64, y: i64) -> Plateau {
    let code = patch.code_at(x, y);
    let corner = patch.corner(x, y);
    let mut plateau = Plateau {
        code,
        voxels: 1,
        place: corner + 0.5 * patch.side,
        extent: [corner, corner + patch.side],
        height: patch.code.decode(code).unwrap_or(f64::NAN),
        side: patch.side,
        is_held: false,
        is_at_edge: false,
        falls: [0.0; 2],
    };

    for (right, up) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
        let there = patch.code_at(x + right, y + up);
        if !is_inside(patch, x + right, y + up) {
            plateau.is_at_edge = true;
        } else if there == HeightCode::EMPTY || there > code {
            plateau.is_held |= there != code;
        } else if there < code {
            plateau.falls[0] += f64::from(code - there) * patch.code.scale;
            plateau.falls[1] += 1.0;
        }
    }

    plateau
}

fn is_inside(patch: &Patch, x: i64, y: i64) -> bool {
    let inside = |axis: usize, at: i64| (0..patch.dims[axis]).contains(&(patch.first[axis] + at));
    inside(0, x) && inside(1, y)
}

/// Numbers of the connected voxels of a page, `[height][width]`, without gaps.
fn labels(patch: &Patch) -> Vec<usize> {
    let [width, height] = patch.size;
    let none = usize::MAX;
    let mut labels = vec![none; (width * height) as usize];
    let (mut next, mut waiting) = (0, Vec::new());

    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        if labels[(y * width + x) as usize] != none {
            continue;
        }

        let code = patch.code_at(x, y);
        labels[(y * width + x) as usize] = next;
        waiting.push((x, y));
        while let Some((x, y)) = waiting.pop() {
            for (x, y) in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] {
                let is_own = (0..width).contains(&x) && (0..height).contains(&y);
                if is_own && labels[(y * width + x) as usize] == none && patch.code_at(x, y) == code {
                    labels[(y * width + x) as usize] = next;
                    waiting.push((x, y));
                }
            }
        }

        next += 1;
    }

    labels
}
