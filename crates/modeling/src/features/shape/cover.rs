//! Covers of areas and lines without a form of their own: water, pavement, woods, walls and hedges.

use glam::DVec2;

use super::super::kinds::{Barrier, FieldRows, Leaf, Paint, Tree, Wood};
use super::super::meaning::{WATER, crown, mix};
use super::field_rows::RowLattice;
use super::footprint::Footprint;
use super::ribbon::{Ends, Line};
use super::round::{BoundTree, chance};
use super::solid::{Ground, PlacedSolid, Solid, Square, Wall};
use super::strips::Strips;
use super::tree_kind::{PlacedTree, TALLER, TreeKind, WIDER};
use super::way::{Graded, Rank};
use hedgehop::voxel::Material;

/// An area with a surface of its own; level, if it has a level.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundCover {
    pub(super) footprint: Footprint,
    /// Height of all of its ground, metres; `None`: as it is.
    pub(super) level_m: Option<f64>,
    pub(super) paint: Paint,
    /// Rows on it, and their paint.
    pub(super) rows: Option<(Strips, Paint)>,
    /// Whether it is the ground itself, and not something on it.
    pub(super) is_ground: bool,
}

/// Share of the shore that lies below the level of a lake: elevation has errors, and banks are higher than the water.
const SHORE: f64 = 0.1;

impl BoundCover {
    /// A lake at the level of its shore; `None` where there is no ground.
    pub(super) fn lake(footprint: Footprint, ground: &dyn Ground) -> Option<Self> {
        const STEP: f64 = 10.0;
        const MOST: usize = 4000;
        let outline = footprint.outline(STEP, MOST);
        let mut heights: Vec<f64> = outline.into_iter().filter_map(|place| ground.height_at(place)).collect();
        heights.sort_by(f64::total_cmp);
        let level = heights.get((SHORE * heights.len() as f64) as usize)?;
        Some(Self { level_m: Some(*level), footprint, paint: WATER, rows: None, is_ground: false })
    }

    /// Farmed ground with rows; `hash` tells it from other fields.
    pub(super) fn field(footprint: Footprint, paint: Paint, rows: FieldRows, hash: u64) -> Self {
        let strips = RowLattice::of(rows, &footprint, hash).strips(rows, &footprint);
        let rows = Some((strips, row_paint(rows, paint)));
        Self { footprint, level_m: None, paint, rows, is_ground: true }
    }

    /// Grades the ground.
    pub fn grade(&self, square: &Square) -> Vec<Graded> {
        let rank = match (self.level_m, self.paint) {
            _ if self.is_ground => Rank::Ground,
            (Some(_), _) => Rank::Lake,
            (None, WATER) => Rank::River,
            _ => Rank::Cover,
        };
        let grade = |cover: super::footprint::VoxelCover| Graded {
            height_m: self.level_m.filter(|_| cover.share >= 0.5),
            paint: Some((self.paint, cover.share)),
            ..Graded::any(square.index(cover.column, cover.row), rank)
        };
        let mut graded: Vec<Graded> = self.footprint.cover(square).into_iter().map(grade).collect();
        if let Some((strips, paint)) = &self.rows {
            graded.extend(of_rows(strips, *paint, square));
        }
        graded
    }
}

/// Paints rows on the ground.
fn of_rows(strips: &Strips, paint: Paint, square: &Square) -> impl Iterator<Item = Graded> {
    let shares = strips.shares(square).into_iter();
    shares
        .map(move |(index, share)| Graded { paint: Some((paint, share)), ..Graded::any(index, Rank::Ground) })
}

/// Tilled ground.
const TILLED: [u8; 3] = [142, 122, 94];

/// Paint of rows on a surface: soil under plants; of a crop that wheels have pressed down something is left.
fn row_paint(rows: FieldRows, surface: Paint) -> Paint {
    match rows {
        FieldRows::Tramlines => {
            let mean = |channel: usize| surface.colour[channel].midpoint(TILLED[channel]);
            Paint { colour: std::array::from_fn(mean).map(darker), ..surface }
        }
        FieldRows::Vines | FieldRows::Fruit => Paint { colour: TILLED, material: surface.material },
    }
}

/// Colour in the shadow of the stalks beside, sRGB.
fn darker(code: u8) -> u8 {
    code / 8 * 7
}

/// Course of a barrier.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Course {
    /// Along a line.
    Line(Line),
    /// Over all of an area.
    Area(Footprint),
}

/// A wall, fence or hedge where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundBarrier {
    pub(super) course: Course,
    pub(super) barrier: Barrier,
}

impl BoundBarrier {
    /// Raises its solids, with the index of their voxel. It follows the ground, and along a line it is a voxel thick at least, so that its faces are straight.
    pub fn raise(&self, square: &Square, ground: &dyn Ground, out: &mut Vec<PlacedSolid>) {
        let half = 0.5 * self.barrier.thickness_m.max(square.spacing);
        match &self.course {
            Course::Line(line) => {
                for cross in line.crosses(square, half + 0.7072 * square.spacing, Ends::Butt) {
                    let wall = Wall::Corner([
                        (cross.outward.to_angle(), half - cross.off),
                        ((-cross.outward).to_angle(), half + cross.off),
                    ]);
                    out.extend(self.over([cross.column, cross.row], wall, square, ground));
                }
            }
            Course::Area(footprint) => {
                for cover in footprint.cover_with_walls(square) {
                    out.extend(self.over([cover.column, cover.row], cover.wall, square, ground));
                }
            }
        }
    }

    /// A part of it over a voxel, as steep as the ground there.
    fn over(
        &self,
        [column, row]: [usize; 2],
        wall: Wall,
        square: &Square,
        ground: &dyn Ground,
    ) -> Option<PlacedSolid> {
        let Barrier { height_m, opacity, paint, .. } = self.barrier;
        let centre = square.centre(column, row);
        let base = ground.height_at(centre)?;
        let step = 0.5 * square.spacing;
        let slope = |direction: DVec2| {
            let ends =
                ground.height_at(centre + direction * step).zip(ground.height_at(centre - direction * step));
            ends.map_or(0.0, |(ahead, behind)| (ahead - behind) / square.spacing)
        };
        let solid = Solid {
            slope: [slope(DVec2::X), slope(DVec2::Y)],
            wall,
            opacity,
            ..Solid::level(None, base + height_m, paint)
        };
        Some(solid.over(square.index(column, row)))
    }
}

/// A wood where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundWood {
    pub(super) footprint: Footprint,
    pub(super) wood: Wood,
    /// Rows in which trees stand, and ground below them.
    rows: Option<(RowLattice, Strips)>,
}

/// Share to either side by which heights of trees differ.
const HEIGHTS: f64 = 0.25;
/// Diameter of a crown as a share of the tree's height, and as a share of the trees' distance at the most.
const SLENDER: f64 = 0.45;
const CROWDED: f64 = 1.35;

impl BoundWood {
    /// A wood over an outline; `hash` tells it from others.
    pub(super) fn of(footprint: Footprint, wood: Wood, hash: u64) -> Self {
        let rows = wood.rows.map(|rows| {
            let lattice = RowLattice::of(rows, &footprint, hash);
            let strips = lattice.strips(rows, &footprint);
            (lattice, strips)
        });
        Self { footprint, wood, rows }
    }

    /// Grades the ground: tilled under rows.
    pub fn grade(&self, square: &Square) -> Vec<Graded> {
        let Some((_, strips)) = &self.rows else { return Vec::new() };
        let paint = Paint { colour: TILLED, material: Material::Soil };
        of_rows(strips, paint, square).collect()
    }

    /// Farthest that a crown reaches from its tree, metres.
    pub(super) fn reach(&self) -> f64 {
        self.wood.height_m * (1.0 + HEIGHTS) * SLENDER * WIDER
    }

    /// Height of its highest tree, metres.
    pub(super) fn highest(&self) -> f64 {
        self.wood.height_m * (1.0 + HEIGHTS) * TALLER
    }

    /// Returns the trees that may reach into a square: one in each cell of a lattice that is the same for all of the database.
    pub fn trees(&self, square: &Square, ground: &dyn Ground) -> Vec<PlacedTree> {
        let cell = self.wood.cell(square.spacing);
        let margin = (self.reach() / square.spacing).ceil() + 1.0;
        let grown = Square {
            first: square.first.map(|first| first - margin as i64),
            columns: square.columns + 2 * margin as usize,
            rows: square.rows + 2 * margin as usize,
            ..*square
        };
        let covers = self.footprint.cover(&grown);
        if covers.is_empty() {
            return Vec::new();
        }

        let mut shares = vec![0.0; grown.columns * grown.rows];
        covers.iter().for_each(|cover| shares[grown.index(cover.column, cover.row)] = cover.share);
        let [west, south, east, north] = grown.bounds();
        // Voxels as wide as rows are apart show none.
        let lattice = self.rows.as_ref().map(|(lattice, _)| *lattice);
        let lattice = lattice.filter(|lattice| lattice.step > square.spacing);
        let moved = lattice.map_or(0.0, |lattice| 0.5 * lattice.step);
        let range = |low: f64, high: f64| {
            ((low - moved) / cell).floor() as i64..=((high + moved) / cell).floor() as i64
        };
        let mut trees = Vec::new();

        for j in range(south, north) {
            for i in range(west, east) {
                let hash = mix((i as u64) ^ mix(j as u64));
                let jitter = DVec2::new(chance(hash, 0), chance(hash, 1)) * 0.7 + 0.15;
                let place = (DVec2::new(i as f64, j as f64) + jitter) * cell;
                let place = lattice.map_or(place, |lattice| lattice.nearest(place));
                let (columns, rows) = grown.touched([place.x, place.y, place.x, place.y]);
                let (Some(column), Some(row)) = (columns.into_iter().next(), rows.into_iter().next()) else {
                    continue;
                };
                if shares[grown.index(column, row)] < 0.5 {
                    continue;
                }

                if let Some(base_m) = ground.height_at(place) {
                    let kind = TreeKind::of(&self.wood.tree(hash, cell), hash);
                    trees.push(PlacedTree { kind, place, base_m, hash });
                }
            }
        }

        trees
    }
}

impl PlacedTree {
    /// Raises its solids over the voxels of a square, with their row-major index.
    pub fn raise(&self, square: &Square, out: &mut Vec<PlacedSolid>) {
        let Self { kind, place, base_m, hash } = *self;
        BoundTree { place, base_m, tree: kind.tree(), hash }.raise(square, out);
    }
}

impl Wood {
    /// Distance of its trees on voxels of this side, metres: no less than a voxel.
    fn cell(&self, spacing: f64) -> f64 {
        (10_000.0 / self.density).sqrt().max(spacing)
    }

    /// All kinds of its trees on voxels of this side, metres.
    pub fn kinds(&self, spacing: f64) -> Vec<TreeKind> {
        let cell = self.cell(spacing);
        let [low, high] = [1.0 - HEIGHTS, 1.0 + HEIGHTS].map(|share| share * self.height_m);
        let leaves = match self.leaf {
            Leaf::Mixed => vec![Leaf::Needle, Leaf::Broad],
            one => vec![one],
        };
        let of =
            |leaf: Leaf| TreeKind::all_between(low, high, move |height| self.tree_of(leaf, height, cell));
        leaves.into_iter().flat_map(of).collect()
    }

    fn tree(&self, hash: u64, cell: f64) -> Tree {
        let leaf = match self.leaf {
            Leaf::Mixed if chance(hash, 2) < 0.5 => Leaf::Needle,
            Leaf::Mixed => Leaf::Broad,
            one => one,
        };
        let height_m = self.height_m * (1.0 + HEIGHTS * (2.0 * chance(hash, 3) - 1.0));
        // Crowns follow the kind's height, so that there are not more kinds than heights.
        self.tree_of(leaf, TreeKind::height_like(height_m), cell)
    }

    fn tree_of(&self, leaf: Leaf, height_m: f64, cell: f64) -> Tree {
        let crown_m = (2.0 * SLENDER * height_m).min(CROWDED * cell);
        Tree { height_m, crown_m, leaf, paint: crown(leaf) }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::super::super::kinds::Meaning;
    use super::super::bind;
    use super::super::testing::{HEIGHTS, PAINT, at, level, of_line, raised, square};
    use super::*;

    #[test]
    fn both_faces_of_a_wall_are_straight() {
        let square = square(1.0);
        for step in 0..9 {
            let along = DVec2::from_angle(0.1 + 0.17 * f64::from(step));
            let middle = at(32.3, 24.1);
            let barrier =
                Barrier { height_m: 2.0, thickness_m: 0.4, opacity: 1.0, paint: PAINT, is_filled: false };
            let line = of_line(&[middle - along * 15.0, middle + along * 15.0]);
            let solids = raised(&bind(&Meaning::Barrier(barrier), &line, 1, &level), &square, &level);

            for place in 0..400 {
                let (from, off) = (0.06 * f64::from(place) - 12.0, 0.031 * f64::from(place % 60) - 0.93);
                let place = middle + along * from + along.perp() * off;
                let local = square.local(place);
                let (column, row) = (local.x as usize, local.y as usize);
                let index = square.index(column, row);
                let from_centre = place - square.centre(column, row);

                let is_there = solids.iter().filter(|placed| placed.voxel == index).any(
                    |PlacedSolid { solid, .. }| {
                        let span = solid.encode(&HEIGHTS, square.spacing);
                        span.is_some_and(|span| {
                            span.walls().all(|(normal, distance)| {
                                let normal = dvec2(f64::from(normal[0]), f64::from(normal[1]));
                                normal.dot(from_centre) <= f64::from(distance)
                            })
                        })
                    },
                );

                // It is a voxel thick.
                if (off.abs() - 0.5).abs() > 0.02 {
                    assert_eq!(is_there, off.abs() < 0.5, "{step}: {off} m beside the line");
                }
            }
        }
    }
}
