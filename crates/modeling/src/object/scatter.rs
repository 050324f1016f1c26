//! Placements by chance: a function of the seed and the place alone.
//!
//! ```text
//! for each cell of a lattice of the mean distance, counted from the origin of coordinates:
//!     a place within it, by chance (jittered grid; Cook 1986), moved to the middle of its voxel
//!     dropped: outside of the area, on ground that is too high, low, steep or level, or of another material, where something else is
//!     form, scale and one of eight ways to lay it, by chance
//! ```

use glam::{DVec2, dvec2};

use super::placement::Placement;
use crate::features::{Footprint, Square, mix, share};
use crate::materials::Classes;
use hedgehop::voxel::Symmetry;

/// Part of a cell that a place is moved within.
const JITTER: f64 = 0.86;

/// A scatter in the database's system.
#[derive(Debug)]
pub(super) struct Scatter {
    /// Distance of its cells, metres.
    pub cell: f64,
    pub seed: u64,
    /// Numbers of its shapes: of each form at each scale.
    pub shapes: Vec<Vec<u32>>,
    /// Areas that it keeps to; `None`: everything.
    pub areas: Option<Vec<Footprint>>,
    pub bbox: Option<[f64; 4]>,
    pub heights_m: Option<[f64; 2]>,
    /// Rise over run.
    pub slopes: Option<[f64; 2]>,
    /// Materials of the ground; `None`: any.
    pub grounds: Option<Classes>,
    pub avoids: bool,
}

/// The natural ground of some voxels, and where something is already.
pub(super) struct ScatterSite<'s> {
    pub square: Square,
    /// Heights, metres; NaN where there is none.
    pub heights: &'s [f64],
    /// Numbers of its materials; empty if no scatter asks for them.
    pub materials: &'s [u8],
    /// Voxels that features change.
    pub features: &'s [bool],
    /// Voxels that objects cover.
    pub objects: &'s [bool],
}

impl Scatter {
    /// West, south, east, north of all that it may reach, without the size of its shapes.
    pub fn bounds(&self) -> [f64; 4] {
        let everything = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
        let areas = self.areas.as_ref().map_or(everything, |areas| {
            let nothing = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
            areas.iter().fold(nothing, |a, area| {
                let b = area.bounds;
                [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
            })
        });
        let bbox = self.bbox.unwrap_or(everything);
        [areas[0].max(bbox[0]), areas[1].max(bbox[1]), areas[2].min(bbox[2]), areas[3].min(bbox[3])]
    }

    /// Chooses its placements on the voxels of a site. Those of its outermost ring have no slope, and none.
    pub fn placements(&self, site: &ScatterSite<'_>, out: &mut Vec<Placement>) {
        let square = &site.square;
        let within = self.within(square);
        let [west, south, east, north] = square.bounds();
        let range =
            |low: f64, high: f64| (low / self.cell).floor() as i64..=(high / self.cell).floor() as i64;

        for j in range(south, north) {
            for i in range(west, east) {
                let chance = Chance(mix(self.seed ^ mix(i as u64 ^ mix(j as u64))));
                let jitter = (dvec2(chance.of(0), chance.of(1)) - 0.5) * JITTER + 0.5;
                let local = square.local((dvec2(i as f64, j as f64) + jitter) * self.cell).floor();
                let inner = local.cmpge(DVec2::ONE).all()
                    && local.x + 1.0 < square.columns as f64
                    && local.y + 1.0 < square.rows as f64;
                if !inner {
                    continue;
                }

                let (column, row) = (local.x as usize, local.y as usize);
                let index = square.index(column, row);
                let is_taken = site.objects[index] || self.avoids && site.features[index];
                let is_ground = |grounds: &Classes| grounds.has(site.materials[index]);

                if !is_taken
                    && self.grounds.as_ref().is_none_or(is_ground)
                    && within.as_ref().is_none_or(|within| within[index])
                    && self.suits(site, column, row)
                {
                    out.push(self.placement(chance, site, column, row));
                }
            }
        }
    }

    fn placement(&self, chance: Chance, site: &ScatterSite<'_>, column: usize, row: usize) -> Placement {
        let pick = |index: u64, count: usize| ((chance.of(index) * count as f64) as usize).min(count - 1);
        let scales = &self.shapes[pick(2, self.shapes.len())];
        Placement {
            shape: scales[pick(3, scales.len())],
            voxel: [site.square.first[0] + column as i64, site.square.first[1] + row as i64],
            symmetry: Symmetry::new((chance.of(4) * 8.0) as u64),
            foot_m: site.heights[site.square.index(column, row)],
        }
    }

    /// Voxels whose middles it keeps to; `None`: all.
    fn within(&self, square: &Square) -> Option<Vec<bool>> {
        let holds = |[west, south, east, north]: [f64; 4], place: DVec2| {
            place.x >= west && place.x <= east && place.y >= south && place.y <= north
        };
        let centre = |index: usize| square.centre(index % square.columns, index / square.columns);

        let mut within: Option<Vec<bool>> = self.areas.as_ref().map(|areas| {
            let mut within = vec![false; square.columns * square.rows];
            for area in areas {
                for cover in area.cover(square) {
                    let index = square.index(cover.column, cover.row);
                    within[index] |= cover.share >= 1.0 || area.holds(centre(index));
                }
            }
            within
        });

        if let Some(bbox) = self.bbox {
            let within = within.get_or_insert_with(|| vec![true; square.columns * square.rows]);
            within.iter_mut().enumerate().for_each(|(index, is_in)| *is_in &= holds(bbox, centre(index)));
        }

        within
    }

    /// Whether the ground is as it is to be.
    fn suits(&self, site: &ScatterSite<'_>, column: usize, row: usize) -> bool {
        let height = |column: usize, row: usize| site.heights[site.square.index(column, row)];
        let here = height(column, row);
        if here.is_nan() || self.heights_m.is_some_and(|[low, high]| here < low || here > high) {
            return false;
        }
        self.slopes.is_none_or(|[least, most]| {
            let east = height(column + 1, row) - height(column - 1, row);
            let north = height(column, row + 1) - height(column, row - 1);
            let slope = east.hypot(north) / (2.0 * site.square.spacing);
            slope >= least && slope <= most
        })
    }
}

/// Numbers of 0…1 for a cell.
#[derive(Debug, Clone, Copy)]
struct Chance(u64);

impl Chance {
    fn of(self, index: u64) -> f64 {
        share(mix(self.0.wrapping_add((index + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::{Area, Path};

    const EVERYWHERE: fn() -> Scatter = || Scatter {
        cell: 8.0,
        seed: 5,
        shapes: vec![vec![0, 1], vec![2]],
        areas: None,
        bbox: None,
        heights_m: None,
        slopes: None,
        grounds: None,
        avoids: true,
    };

    /// Those on a square of voxels of a metre, of ground that rises eastward ever more steeply.
    fn placed(
        scatter: &Scatter,
        first: [i64; 2],
        side: usize,
        taken: impl Fn(usize) -> bool,
    ) -> Vec<Placement> {
        let square = Square { origin: DVec2::ZERO, first, spacing: 1.0, columns: side, rows: side };
        let height = |index: usize| square.centre(index % side, 0).x.powi(2) / 1000.0;
        let heights: Vec<f64> = (0..side * side).map(height).collect();
        let features: Vec<bool> = (0..side * side).map(taken).collect();
        let objects = vec![false; side * side];
        let materials: Vec<u8> = (0..side * side).map(|index| (index / side % 3) as u8).collect();
        let site = ScatterSite {
            square,
            heights: &heights,
            materials: &materials,
            features: &features,
            objects: &objects,
        };
        let mut placements = Vec::new();
        scatter.placements(&site, &mut placements);
        placements
    }

    #[test]
    fn they_are_as_dense_as_they_should_be_and_all_different() {
        let found = placed(&EVERYWHERE(), [1000, 2000], 402, |_| false);
        assert!((found.len() as f64 / 2500.0 - 1.0).abs() < 0.02, "{}", found.len());
        for shape in 0..3 {
            let share =
                found.iter().filter(|placement| placement.shape == shape).count() as f64 / found.len() as f64;
            assert!((share - [0.25, 0.25, 0.5][shape as usize]).abs() < 0.04, "{shape}: {share}");
        }
        let ways: std::collections::BTreeSet<_> = found
            .iter()
            .map(|placement| (placement.symmetry.is_mirrored(), placement.symmetry.turns()))
            .collect();
        assert_eq!(ways.len(), 8);
        assert_ne!(found, placed(&Scatter { seed: 6, ..EVERYWHERE() }, [1000, 2000], 402, |_| false));
    }

    #[test]
    fn they_do_not_depend_on_the_block() {
        let wide = placed(&EVERYWHERE(), [0, 0], 300, |_| false);
        for first in [[40, 90], [97, 13]] {
            let near = placed(&EVERYWHERE(), first, 102, |_| false);
            let inner = |placement: &&Placement| {
                (0..2).all(|axis| (1..101).contains(&(placement.voxel[axis] - first[axis])))
            };
            let of_wide: Vec<Placement> = wide.iter().filter(inner).copied().collect();
            assert_eq!((near.len() > 100, near), (true, of_wide));
        }
    }

    /// Regions of three classes in blobs of a map, each with a density, sizes and forms of its own: counts are within three deviations of what these come to.
    #[test]
    fn counts_are_those_of_the_statistics_of_regions() {
        const SIDE: usize = 602;
        let square =
            Square { origin: DVec2::ZERO, first: [-300, 5000], spacing: 1.0, columns: SIDE, rows: SIDE };
        let class = |index: usize| {
            let blob = |at: usize| (at / 37) as u64;
            (mix(blob(index % SIDE) ^ mix(blob(index / SIDE))) % 4) as u8
        };
        let materials: Vec<u8> = (0..SIDE * SIDE).map(class).collect();
        let (heights, free) = (vec![7.0; SIDE * SIDE], vec![false; SIDE * SIDE]);
        let site =
            ScatterSite { square, heights: &heights, materials: &materials, features: &free, objects: &free };
        let inner = |index: &usize| {
            (1..SIDE - 1).contains(&(index % SIDE)) && (1..SIDE - 1).contains(&(index / SIDE))
        };
        let near = |count: usize, expected: f64, what: &str| {
            let deviation = (count as f64 - expected) / expected.sqrt();
            assert!(deviation.abs() < 3.0, "{what}: {count}, not {expected}, {deviation} deviations");
        };

        for seed in 0..20 {
            for (number, cell) in [(0, 5.3), (1, 8.0), (2, 17.1)] {
                let mut grounds = Classes::default();
                grounds.add(number);
                let scatter = Scatter { cell, seed, grounds: Some(grounds), ..EVERYWHERE() };
                let mut found = Vec::new();
                scatter.placements(&site, &mut found);

                let area = (0..SIDE * SIDE).filter(inner).filter(|index| class(*index) == number).count();
                near(found.len(), area as f64 / (cell * cell), &format!("seed {seed}, class {number}"));
                for (shape, share) in [(0, 0.25), (1, 0.25), (2, 0.5)] {
                    let count = found.iter().filter(|placement| placement.shape == shape).count();
                    near(count, share * found.len() as f64, &format!("seed {seed}, shape {shape}"));
                }
            }
        }
    }

    #[test]
    fn they_keep_to_their_ground() {
        // The slope at x is x / 500.
        let gentle = Scatter { slopes: Some([0.0, 0.3]), heights_m: Some([2.5, 1e9]), ..EVERYWHERE() };
        let found = placed(&gentle, [0, 0], 300, |_| false);
        assert!(found.len() > 300);
        assert!(found.iter().all(|placement| (50..=150).contains(&placement.voxel[0])));

        // Rows of three materials, of which two are asked for.
        let mut classes = Classes::default();
        [0, 2].into_iter().for_each(|number| classes.add(number));
        let found = placed(&Scatter { grounds: Some(classes), ..EVERYWHERE() }, [0, 0], 300, |_| false);
        assert!((found.len() as f64 / 936.0 - 1.0).abs() < 0.05, "{}", found.len());
        assert!(found.iter().all(|placement| placement.voxel[1] % 3 != 1));

        // A triangle, but for where something is already.
        let corners = [(20.0, 20.0), (280.0, 20.0), (20.0, 280.0)].map(|(x, y)| dvec2(x, y));
        let area = Area { outer: Path::flat(corners.to_vec()), holes: Vec::new() };
        let areas = Some(vec![Footprint::of(&area).unwrap()]);
        let bbox = Some([20.0, 100.0, 280.0, 280.0]);
        let found = placed(&Scatter { areas, bbox, ..EVERYWHERE() }, [0, 0], 300, |index| index % 300 < 50);
        assert!(found.len() > 80, "{}", found.len());
        for Placement { voxel: [x, y], .. } in found {
            assert!(x >= 50 && y >= 100 && x + y < 300, "{x} {y}");
        }
    }
}
