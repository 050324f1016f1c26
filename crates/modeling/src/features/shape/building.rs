//! Buildings over voxels: straight walls, roofs, lower ends.

use glam::DVec2;

use super::super::kinds::{Building, Top};
use super::super::layer::Area;
use super::facade::BoundFacade;
use super::footprint::Footprint;
use super::patch::{ConvexPatch, HalfPlane};
use super::roof::{self, RoofPlane};
use super::solid::{Ground, PlacedSolid, Solid, Square, Wall, stored_facing};

/// A building where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundBuilding {
    pub(super) footprint: Footprint,
    roof: roof::RoofBound,
    /// Height of the lower end, metres; `None`: it stands on the ground.
    low_m: Option<f64>,
    /// Height of the eaves, metres.
    eaves_m: f64,
    /// `None`: its walls are plain.
    facade: Option<BoundFacade>,
    building: Building,
}

/// Metres between places of an outline at which the ground is looked at, and most of them.
const STEP: f64 = 4.0;
const MOST: usize = 400;
/// Highest lowest floor above the ground, metres.
const CELLAR: f64 = 1.2;
/// Places across it at which the ground is looked at if there is none along its outline.
const ACROSS: usize = 64;
/// Parts of a roof that are smaller than this share of a voxel, and sides that are shorter than this share of its side, come from rounding.
const NOTHING: f64 = 1e-6;
/// Steepest roof, rise over run eastward and northward: more is not stored.
const STEEPEST: f64 = 3.9;

/// The lowest ground along an outline, metres: that on which a building of that area stands; `None` where there is no ground, or no outline.
pub(in super::super::super) fn foot_of(area: &Area, ground: &dyn Ground) -> Option<f64> {
    lowest(&Footprint::of(area)?, ground)
}

fn lowest(footprint: &Footprint, ground: &dyn Ground) -> Option<f64> {
    let heights = footprint.outline(STEP, MOST).into_iter().filter_map(|place| ground.height_at(place));
    // One that surrounds all ground stands on that.
    let within = || {
        let [west, south, east, north] = footprint.bounds;
        let share = |index: usize| (index as f64 + 0.5) / ACROSS as f64;
        let places = (0..ACROSS * ACROSS).map(|index| {
            let (column, row) = (share(index % ACROSS), share(index / ACROSS));
            DVec2::new(west + (east - west) * column, south + (north - south) * row)
        });
        places
            .filter(|place| footprint.holds(*place))
            .filter_map(|place| ground.height_at(place))
            .reduce(f64::min)
    };
    heights.reduce(f64::min).or_else(within)
}

/// Height of the lowest floor on ground that rises along an outline from `base`, metres: that of the highest ground, or of a low cellar.
fn lowest_floor(base: f64, footprint: &Footprint, ground: &dyn Ground) -> f64 {
    let heights = footprint.outline(STEP, MOST).into_iter().filter_map(|place| ground.height_at(place));
    heights.fold(base, f64::max).min(base + CELLAR)
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
        let roof = roof::RoofBound::over(&footprint, &building.roof, total);
        let eaves_m = base
            + match building.top {
                Top::Ridge(height) => height - roof.height_m,
                Top::Eaves(height) => height,
            };
        let low_m = (building.min_height_m > 0.0).then_some(base + building.min_height_m);
        let floor_m = low_m.unwrap_or_else(|| lowest_floor(base, &footprint, ground));
        let facade = building.facade.and_then(|kind| BoundFacade::of(kind, &footprint, [floor_m, eaves_m]));
        Some(Self { footprint, roof, low_m, eaves_m, facade, building: *building })
    }

    /// Whether it is a part of a building that may be there as a whole, too.
    pub fn is_part(&self) -> bool {
        self.building.is_part
    }

    /// Height of the ridge, metres.
    pub fn top_m(&self) -> f64 {
        self.eaves_m + self.roof.height_m
    }

    /// Height that nothing of it rises above, over voxels of this side, metres: planes of the roof may do over a voxel's centre where they end before that.
    pub fn highest(&self, spacing: f64) -> f64 {
        self.top_m() + self.roof.steepest().min(2.0 * self.steepest(spacing)) * spacing
    }

    /// Steepest roof over voxels of this side, rise over run eastward and northward: where a voxel is wider than a roof's run, planes that end within it would
    /// rise far above the ridge over its centre.
    fn steepest(&self, spacing: f64) -> f64 {
        STEEPEST.min(self.roof.height_m / spacing)
    }

    /// Raises its solids, with the index of their voxel: one for each plane of the roof over it.
    pub fn raise(&self, square: &Square, out: &mut Vec<PlacedSolid>) {
        for cover in self.footprint.cover_with_walls(square) {
            let index = square.index(cover.column, cover.row);
            let centre = square.centre(cover.column, cover.row);
            let parts = self.parts(centre, square.spacing, cover.wall);
            out.extend(parts.into_iter().map(|solid| solid.over(index)));
        }
    }

    fn parts(&self, centre: DVec2, spacing: f64, wall: Wall) -> Vec<Solid> {
        let walls: Vec<HalfPlane> =
            wall.planes().map(|(facing, distance)| HalfPlane::towards(facing, distance)).collect();
        let floor = ConvexPatch::voxel(spacing).within_all(walls.iter().enumerate());
        if floor.area() <= 0.0 {
            return Vec::new();
        }

        let roof = self.roof.planes_over(centre, &floor);
        let least = |place: DVec2| {
            let heights = roof.iter().map(|planes| roof::greatest(planes, centre + place));
            heights.fold(f64::INFINITY, f64::min)
        };

        // Of each, the plane that counts at the centre.
        let at_centre = |planes: &Vec<RoofPlane>| {
            planes.iter().copied().max_by(|a, b| a.height(centre).total_cmp(&b.height(centre)))
        };
        let ends: Vec<Option<RoofPlane>> = roof.iter().map(at_centre).collect();

        let part = |number: usize, plane: &RoofPlane| {
            let others = ends.iter().enumerate().filter(|(other, _)| *other != number);
            let hips = others.filter_map(|(_, other)| plane.below(other.as_ref()?, centre));

            // In a valley the higher one counts: they do not lie in each other.
            let valleys = roof[number].iter().filter_map(|other| other.below(plane, centre));
            let joints = hips.chain(valleys);
            let halves: Vec<HalfPlane> = walls.iter().copied().chain(joints).collect();
            let part = ConvexPatch::voxel(spacing).within_all(halves.iter().enumerate());
            if part.area() < NOTHING * spacing * spacing {
                return None;
            }

            let is_joint = |number: usize| number >= walls.len();
            let mut bounds = part.bounded_by(NOTHING * spacing);

            // A third wall is a joint: footprints leave no more than two in a voxel.
            if bounds.len() > 3 {
                bounds = least_harm(&bounds, &halves, spacing, |place| {
                    plane.height(centre + place) - least(place)
                });
            }

            // A wall that passes beside the voxel, or in another part of it, lights what stands out there.
            for wall in 0..walls.len() {
                if bounds.len() < 3 && !bounds.contains(&wall) {
                    bounds.push(wall);
                }
            }

            bounds.sort_unstable();
            let kept = |number: usize| {
                let half = &halves[number];
                let others = bounds.iter().filter(|other| **other != number);
                let met = others.filter_map(|other| half.crossing(&halves[*other])).filter(|place| {
                    let is_corner =
                        bounds.iter().all(|other| halves[*other].beyond(*place) < NOTHING * spacing);
                    is_corner && place.abs().max_element() <= 0.5 * spacing
                });
                let (count, sum) =
                    met.fold((0.0, DVec2::ZERO), |(count, sum), place| (count + 1.0, sum + place));
                if !is_joint(number) || count == 0.0 {
                    return (half.facing(), half.distance);
                }

                // Directions are stored in steps: where planes meet they still do.
                let facing = stored_facing(half.facing());
                (facing, DVec2::from_angle(facing).dot(sum / count))
            };

            let (wall, joined) = match bounds[..] {
                [] => (Wall::Whole, [false; 2]),
                [one] => {
                    let (facing, distance_m) = kept(one);
                    (Wall::Plane { facing, distance_m }, [is_joint(one), false])
                }
                [one, other] => (Wall::Corner([one, other].map(kept)), [one, other].map(is_joint)),
                [one, other, third, ..] => {
                    (Wall::Wedge([one, other, third].map(kept)), [one, other].map(is_joint))
                }
            };

            let stored = plane.no_steeper(self.steepest(spacing), centre + part.middle());
            Some(self.with_top(centre, stored, wall, joined, walls.is_empty()))
        };

        let all = roof
            .iter()
            .enumerate()
            .flat_map(|(number, planes)| planes.iter().map(move |plane| (number, plane)));

        all.filter_map(|(number, plane)| part(number, plane)).collect()
    }

    /// A part of it; where no wall is near, all that may stand out beside it is roof.
    fn with_top(
        &self,
        centre: DVec2,
        plane: RoofPlane,
        wall: Wall,
        joined: [bool; 2],
        is_inside: bool,
    ) -> Solid {
        let Building { walls, cover, .. } = self.building;
        let side = if is_inside && self.low_m.is_none() { cover.colour } else { walls.colour };
        Solid {
            slope: plane.slope.into(),
            wall,
            joined,
            side,
            facade: self.facade.as_ref().filter(|_| !is_inside).map(|facade| facade.at(centre)),
            ..Solid::level(self.low_m, self.eaves_m + plane.height(centre), cover)
        }
    }
}

/// Chooses, of several half-planes, the three that leave the least of what lies beyond the others: above the roof, or before a wall.
fn least_harm(
    bounds: &[usize],
    halves: &[HalfPlane],
    spacing: f64,
    above_roof: impl Fn(DVec2) -> f64,
) -> Vec<usize> {
    let after = |at: usize| bounds.iter().enumerate().skip(at);
    let threes = after(0).flat_map(|(at, one)| {
        after(at + 1).flat_map(move |(at, other)| after(at + 1).map(move |(_, third)| [*one, *other, *third]))
    });
    let harm = |three: &[usize; 3]| {
        let part =
            ConvexPatch::voxel(spacing).within_all(three.iter().map(|number| (*number, &halves[*number])));
        let beyond = |place: DVec2| {
            let walls = bounds.iter().map(|number| halves[*number].beyond(place));
            walls.fold(0.0, f64::max)
        };
        part.corners().map(|place| beyond(place).max(above_roof(place))).fold(0.0, f64::max)
    };
    let best = threes.min_by(|a, b| harm(a).total_cmp(&harm(b)));
    best.map_or_else(Vec::new, Vec::from)
}
