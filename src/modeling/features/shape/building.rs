//! Buildings over voxels: straight walls, roofs, lower ends.

use super::super::kinds::{Building, Top};
use super::super::layer::Area;
use super::footprint::{Cover, Footprint};
use super::roof;
use super::solid::{Ground, Solid, Square, Wall};

/// A building where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundBuilding {
    pub(super) footprint: Footprint,
    roof: roof::Bound,
    /// Height of the lower end, metres; `None`: it stands on the ground.
    low_m: Option<f64>,
    /// Height of the eaves, metres.
    eaves_m: f64,
    building: Building,
}

/// Metres between places of an outline at which the ground is looked at, and most of them.
const STEP: f64 = 4.0;
const MOST: usize = 400;

/// The lowest ground along an outline, metres: that on which a building of that area stands; `None` where there is no ground, or no outline.
pub(in super::super::super) fn foot_of(area: &Area, ground: &dyn Ground) -> Option<f64> {
    lowest(&Footprint::of(area)?, ground)
}

fn lowest(footprint: &Footprint, ground: &dyn Ground) -> Option<f64> {
    let heights = footprint.outline(STEP, MOST).into_iter().filter_map(|place| ground.height_at(place));
    heights.reduce(f64::min)
}

impl BoundBuilding {
    /// A building on the lowest ground along its outline; `None` where there is no ground, or no outline.
    pub fn bind(building: &Building, area: &Area, ground: &dyn Ground) -> Option<Self> {
        let footprint = Footprint::of(area)?;
        let base = lowest(&footprint, ground)?;
        let total = match building.top {
            Top::Ridge(height) => height - building.min_height_m,
            Top::Eaves(_) => f64::INFINITY,
        };
        let roof = roof::Bound::over(&footprint, &building.roof, total);
        let eaves_m = base
            + match building.top {
                Top::Ridge(height) => height - roof.height_m,
                Top::Eaves(height) => height,
            };
        let low_m = (building.min_height_m > 0.0).then_some(base + building.min_height_m);
        Some(Self { footprint, roof, low_m, eaves_m, building: *building })
    }

    /// Whether it is a part of a building that may be there as a whole, too.
    pub fn is_part(&self) -> bool {
        self.building.is_part
    }

    /// Height of the ridge, metres.
    pub fn top_m(&self) -> f64 {
        self.eaves_m + self.roof.height_m
    }

    /// Its solids, with the index of their voxel.
    pub fn raise(&self, square: &Square, out: &mut Vec<(usize, Solid)>) {
        for cover in self.footprint.cover(square) {
            let index = square.index(cover.column, cover.row);
            match (cover.wall, self.split(square, &cover)) {
                (Wall::Whole, Some(halves)) => out.extend(halves.map(|half| (index, half))),
                (wall, _) => out.push((index, self.solid(square, &cover, wall))),
            }
        }
    }

    fn solid(&self, square: &Square, cover: &Cover, wall: Wall) -> Solid {
        let centre = square.centre(cover.column, cover.row);
        // Where a wall leaves little of the voxel, its roof is that of what is left.
        let place = match wall {
            Wall::Plane { facing, distance_m } if distance_m < 0.0 => {
                centre + glam::DVec2::from_angle(facing) * (distance_m - 0.25 * square.spacing)
            }
            _ => centre,
        };
        let (height, slope) = self.roof.at(&self.footprint, place);
        self.with_top(self.eaves_m + height + slope.dot(centre - place), slope, wall)
    }

    fn with_top(&self, high_m: f64, slope: glam::DVec2, wall: Wall) -> Solid {
        Solid {
            slope: slope.into(),
            wall,
            side: self.building.walls.colour,
            ..Solid::level(self.low_m, high_m, self.building.cover)
        }
    }

    /// Both sides of a ridge that crosses a voxel.
    fn split(&self, square: &Square, cover: &Cover) -> Option<[Solid; 2]> {
        let centre = square.centre(cover.column, cover.row);
        let [low, high] = self.roof.ridge(centre)?;
        // The lower plane rises towards the ridge faster than the other one.
        let rising = low.slope - high.slope;
        let normal = rising.try_normalize()?;
        let distance = (high.height(centre) - low.height(centre)) / rising.length();
        let reach = 0.5 * square.spacing * (normal.x.abs() + normal.y.abs());
        let side = |plane: roof::Plane, normal, distance| {
            self.with_top(self.eaves_m + plane.height(centre), plane.slope, Wall::plane(normal, distance))
        };
        (distance < reach).then(|| [side(low, normal, distance), side(high, -normal, -distance)])
    }
}
