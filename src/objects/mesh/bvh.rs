//! A tree of boxes around triangles.
//!
//! ```text
//! while there is a part to cut: of 16 slices along each axis, cut where the surface of both boxes,
//!     weighed by their triangles, is least; a part that no cut makes cheaper is a leaf
//! ```
//!
//! After Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007). Nothing recurses: parts wait in a list, and beyond
//! a depth they are halved by number, so that a stack of fixed size holds any way down.

use glam::Vec3;

/// Slices along an axis between which parts are cut.
const SLICES: usize = 16;

/// Triangles of a part that is not cut any more.
const LEAF: usize = 4;

/// Triangles that no leaf has more of.
const MOST_LEAF: usize = 16;

/// Depth from which on parts are halved by number.
const DEEP: u32 = 40;

/// Nodes that wait on any way down: one per depth, and no tree of 2³² triangles is deeper.
pub(super) const STACK: usize = DEEP as usize + 34;

/// Cost of looking at a node, in triangles.
const NODE_COST: f32 = 1.0;

/// A box, and what is in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct BvhNode {
    pub low: Vec3,
    /// Index of the first triangle of a leaf, or of the first of two nodes that follow each other.
    pub first: u32,
    pub high: Vec3,
    /// Triangles of a leaf; 0: it has two nodes.
    pub count: u32,
}

/// Least and greatest corner, and the middle, of a triangle's box.
#[derive(Debug, Clone, Copy)]
struct Item {
    low: Vec3,
    high: Vec3,
    triangle: u32,
}

#[derive(Debug, Clone, Copy)]
struct TreeBounds {
    low: Vec3,
    high: Vec3,
    count: usize,
}

impl TreeBounds {
    const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, count: 0 };

    fn and(self, low: Vec3, high: Vec3) -> Self {
        Self { low: self.low.min(low), high: self.high.max(high), count: self.count + 1 }
    }

    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            count: self.count + other.count,
        }
    }

    /// Half the surface of the box times what is in it.
    fn cost(&self) -> f32 {
        if self.count == 0 {
            return 0.0;
        }
        let size = self.high - self.low;
        (size.x * size.y + size.y * size.z + size.z * size.x) * self.count as f32
    }
}

impl Item {
    fn middle(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }
}

/// The nodes, the root first, and the order in which their leaves have the triangles, whose corners are given. There is one triangle at least.
pub(super) fn tree(triangles: impl Iterator<Item = [Vec3; 3]>) -> (Vec<BvhNode>, Vec<u32>) {
    let mut items: Vec<_> = (0..)
        .zip(triangles)
        .map(|(triangle, [a, b, c])| Item { low: a.min(b).min(c), high: a.max(b).max(c), triangle })
        .collect();
    let root = BvhNode { low: Vec3::ZERO, high: Vec3::ZERO, first: 0, count: 0 };
    let mut nodes = vec![root];
    let mut waiting = vec![(0, 0..items.len(), 0)];

    while let Some((node, range, depth)) = waiting.pop() {
        let part = &mut items[range.clone()];
        let all = part.iter().fold(TreeBounds::NONE, |all, item| all.and(item.low, item.high));

        // Rays that graze a box are not lost to rounding.
        let pad = 4.0e-6 * all.low.abs().max(all.high.abs()).max_element();
        (nodes[node].low, nodes[node].high) = (all.low - pad, all.high + pad);
        let Some(middle) = cut(part, &all, depth) else {
            (nodes[node].first, nodes[node].count) = (range.start as u32, part.len() as u32);
            continue;
        };

        let next = nodes.len();
        nodes[node].first = next as u32;
        nodes.extend([root; 2]);
        waiting.push((next, range.start..range.start + middle, depth + 1));
        waiting.push((next + 1, range.start + middle..range.end, depth + 1));
    }

    (nodes, items.iter().map(|item| item.triangle).collect())
}

/// Orders a part so that its first items are one child's; how many these are. `None`: it is a leaf.
fn cut(part: &mut [Item], all: &TreeBounds, depth: u32) -> Option<usize> {
    if part.len() <= LEAF {
        return None;
    }

    if depth < DEEP
        && let Some((axis, slice, cost)) = best(part)
    {
        let whole = TreeBounds { count: 1, ..*all }.cost();
        if part.len() <= MOST_LEAF && all.cost() <= cost + NODE_COST * whole {
            return None;
        }

        let slices = Slices::of(part, axis)?;
        let mut first = 0;
        for index in 0..part.len() {
            if slices.index(&part[index]) < slice {
                part.swap(first, index);
                first += 1;
            }
        }

        if first > 0 && first < part.len() {
            return Some(first);
        }
    }

    Some(part.len() / 2)
}

/// Slices along an axis, into which middles of a part fall.
struct Slices {
    axis: usize,
    from: f32,
    scale: f32,
}

impl Slices {
    /// `None`: all middles are in one place.
    fn of(part: &[Item], axis: usize) -> Option<Self> {
        let middles = part.iter().map(|item| item.middle()[axis]);
        let [low, high] =
            middles.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
        (high > low).then(|| Self { axis, from: low, scale: SLICES as f32 / (high - low) })
    }

    fn index(&self, item: &Item) -> usize {
        (((item.middle()[self.axis] - self.from) * self.scale) as usize).min(SLICES - 1)
    }
}

/// Axis, first slice of the second child, and cost of the cheapest cut.
fn best(part: &[Item]) -> Option<(usize, usize, f32)> {
    let mut best: Option<(usize, usize, f32)> = None;
    for axis in 0..3 {
        let Some(slices) = Slices::of(part, axis) else { continue };
        let mut filled = [TreeBounds::NONE; SLICES];
        for item in part {
            let slice = &mut filled[slices.index(item)];
            *slice = slice.and(item.low, item.high);
        }

        let mut behind = [0.0; SLICES];
        let mut sum = TreeBounds::NONE;
        for slice in (1..SLICES).rev() {
            sum = sum.with(filled[slice]);
            behind[slice] = sum.cost();
        }

        sum = TreeBounds::NONE;
        for slice in 1..SLICES {
            sum = sum.with(filled[slice - 1]);
            let cost = sum.cost() + behind[slice];
            if sum.count > 0 && sum.count < part.len() && best.is_none_or(|(.., least)| cost < least) {
                best = Some((axis, slice, cost));
            }
        }
    }

    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(triangles: &[[Vec3; 3]]) {
        let (nodes, order) = tree(triangles.iter().copied());
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(index, triangle)| index == *triangle as usize));
        let (mut seen, mut deepest) = (0, 0);
        let mut waiting = vec![(0_usize, 0)];

        while let Some((index, depth)) = waiting.pop() {
            let node = &nodes[index];
            deepest = deepest.max(depth);
            if node.count == 0 {
                waiting.extend([(node.first as usize, depth + 1), (node.first as usize + 1, depth + 1)]);
                continue;
            }

            seen += node.count;
            for triangle in &order[node.first as usize..][..node.count as usize] {
                for corner in triangles[*triangle as usize] {
                    assert!(corner.cmpge(node.low).all() && corner.cmple(node.high).all());
                }
            }
        }

        assert_eq!(seen as usize, triangles.len());
        assert!(deepest < STACK, "{deepest}");
    }

    #[test]
    fn leaves_hold_all_triangles_once() {
        let place =
            |index: u32| Vec3::new((index * 37 % 101) as f32, (index * 53 % 97) as f32, 0.1 * index as f32);
        let spread: Vec<_> =
            (0..1000).map(|index| [place(index), place(index) + Vec3::X, place(index) + Vec3::Y]).collect();
        check(&spread);
        check(&spread[..1]);
        // All in one place, and each a thousand times as far as the one before.
        check(&vec![[Vec3::ZERO, Vec3::X, Vec3::Y]; 500]);
        let far: Vec<_> = (0..60_i32)
            .map(|power| [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * 4.0_f32.powi(power - 30)))
            .collect();
        check(&far);
    }
}
