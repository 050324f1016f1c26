//! Roofs over footprints.
//!
//! ```text
//! frame     = the rectangle of least area around the footprint: one of its sides lies along an edge of the convex hull
//! gabled    = two planes along the longer side (or across it, or by the stated direction)
//! hipped    = four planes of one slope over a rectangle; else a plane from each wall, and valleys at corners that point inward
//! pyramidal = a plane from each edge of the hull to its middle;  skillion = one plane;  dome = planes through rings of an ellipsoid over the hull
//! ```
//! All are the least of some planes, or in valleys of the greatest of two, so that ridges, hips and valleys are known exactly: a
//! voxel that they cross has a solid for each plane.

use std::cell::LazyCell;

use glam::DVec2;

use super::super::kinds::{Rise, Roof, RoofShape};
use super::footprint::Footprint;
use super::frame::{Frame, extent, hull};
use super::patch::{ConvexPatch, HalfPlane};
use super::sectors::Sectors;
use super::walls::Walls;

/// Angles of a dome's rings, degrees from its top around the ellipsoid's middle: the lowest planes are as steep as slopes of solids can be told.
const RINGS: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 90.0];

/// A plane: height above the eaves over a place, and its slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RoofPlane {
    pub at: DVec2,
    pub height: f64,
    pub slope: DVec2,
}

impl RoofPlane {
    pub fn height(&self, place: DVec2) -> f64 {
        self.height + self.slope.dot(place - self.at)
    }

    /// The plane, or one that is no steeper than that eastward and northward and as high over a place.
    pub fn no_steeper(&self, steepest: f64, place: DVec2) -> Self {
        let slope = self.slope.clamp(DVec2::splat(-steepest), DVec2::splat(steepest));
        match slope == self.slope {
            true => *self,
            false => Self { at: place, height: self.height(place), slope },
        }
    }

    /// Returns the half-plane in which it is no higher than another one, from a place; `None` if they are parallel.
    pub fn below(&self, other: &Self, from: DVec2) -> Option<HalfPlane> {
        let rising = self.slope - other.slope;
        let normal = rising.try_normalize()?;
        Some(HalfPlane { normal, distance: (other.height(from) - self.height(from)) / rising.length() })
    }

    /// Whether another one is the same, but for rounding; looked at around a place.
    fn is_same(&self, other: &Self, place: DVec2) -> bool {
        self.slope.distance(other.slope) < 1e-6 && (self.height(place) - other.height(place)).abs() < 1e-6
    }
}

/// A roof's upper side, as height above its eaves.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum RoofForm {
    /// The least of these.
    Planes(Vec<RoofPlane>),
    /// The least of the planes around a middle, those over each edge of a hull one after the other.
    Around(Sectors, Vec<RoofPlane>),
    /// Roof that rises from all walls with a slope, up to a height; with valleys where corners point inward.
    FromWalls { walls: Walls, slope: f64, most: f64 },
}

impl RoofForm {
    /// Planes over the edges of a hull, the same number over each.
    fn around(hull: &[DVec2], middle: DVec2, planes: Vec<RoofPlane>) -> Self {
        match Sectors::of(hull, middle) {
            Some(sectors) => Self::Around(sectors, planes),
            None => Self::Planes(planes),
        }
    }
}

/// A roof over a footprint: form, and height of the ridge above the eaves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RoofBound {
    pub form: RoofForm,
    pub height_m: f64,
}

/// Planes over a voxel, more than which are told by some of them.
const MOST: usize = 6;

/// Half width from which a roof of which nothing is said is flat, metres.
const WIDE: f64 = 9.0;
/// Share of its rectangle that a footprint covers, from which on it counts as one.
const RECTANGULAR: f64 = 0.9;

impl RoofBound {
    /// The roof over a footprint; of a building `most_m` high at the most from its lower end to the ridge.
    pub fn over(footprint: &Footprint, roof: &Roof, most_m: f64) -> Self {
        let hull = hull(&footprint.rings[0]);
        let Some(frame) = Frame::around(&hull) else { return Self::level() };
        let fill = footprint.area() / (4.0 * frame.half.x * frame.half.y);
        let shape = match roof.shape {
            RoofShape::Gabled if roof.is_guess && frame.half.y > WIDE => RoofShape::Flat,
            RoofShape::Gabled if roof.is_guess && fill < 0.75 => RoofShape::Hipped,
            shape => shape,
        };

        // Across the ridge.
        let across = match roof.direction {
            Some(degrees) => DVec2::from_angle((90.0 - degrees).to_radians()),
            None if roof.across => frame.along,
            None => frame.along.perp(),
        };
        let (low, high) = extent(&hull, across, frame.middle);
        let half = 0.5 * (high - low);
        let walls = LazyCell::new(|| Walls::of(footprint));

        // Larger planes of a hipped roof rise from two sides of its rectangle.
        let is_across = across.dot(frame.along).abs() > across.dot(frame.along.perp()).abs();
        let (main, main_half, beside) = match is_across {
            true => (frame.along, frame.half.x, frame.half.y),
            false => (frame.along.perp(), frame.half.y, frame.half.x),
        };

        let run = match shape {
            RoofShape::Skillion => 2.0 * half,
            RoofShape::Gabled | RoofShape::Flat => half,
            RoofShape::Dome => frame.half.y,
            _ if fill < RECTANGULAR => inradius(footprint, &walls, frame),
            RoofShape::Hipped => main_half,
            _ => frame.half.y,
        };

        let rise = match roof.rise {
            Rise::Height(height) => height,
            Rise::Angle(degrees) if shape == RoofShape::Dome => run * (0.5 * degrees).to_radians().tan(),
            Rise::Angle(degrees) => run * degrees.to_radians().tan(),
        };
        // Something is left for the walls.
        let height = rise.min(0.9 * most_m);
        if !(height > 0.0 && run > 0.0) || shape == RoofShape::Flat {
            return Self::level();
        }

        let middle = frame.middle + across * low.midpoint(high);
        let facing = |normal: DVec2, far: f64, slope: f64| RoofPlane {
            at: frame.middle + normal * far,
            height: 0.0,
            slope: -normal * slope,
        };

        let form = match shape {
            RoofShape::Skillion => RoofForm::Planes(vec![RoofPlane {
                at: frame.middle + across * high,
                height: 0.0,
                slope: -across * (height / run),
            }]),
            RoofShape::Gabled => RoofForm::Planes(
                [across, -across]
                    .map(|normal| RoofPlane {
                        at: middle + normal * half,
                        height: 0.0,
                        slope: -normal * (height / half),
                    })
                    .into(),
            ),
            RoofShape::Hipped if fill < RECTANGULAR => {
                RoofForm::FromWalls { walls: walls.clone(), slope: height / run, most: height }
            }
            RoofShape::Hipped => {
                let hip = match run <= beside {
                    true => run,
                    // A ridge across the longer side is half as long as the shorter one.
                    false => 0.5 * beside,
                };
                let sides = [(main, run, run), (main.perp(), beside, hip)];
                let planes = sides.iter().flat_map(|(normal, far, run)| {
                    [*normal, -*normal].map(|normal| facing(normal, *far, height / run))
                });
                RoofForm::Planes(planes.collect())
            }
            RoofShape::Pyramidal => {
                let plane = |edge: DVec2| RoofPlane { at: frame.middle, height, slope: -edge * height };
                RoofForm::around(&hull, frame.middle, hull_edges(&hull, frame.middle).map(plane).collect())
            }
            _ => RoofForm::around(&hull, frame.middle, dome(&hull, frame.middle, height)),
        };

        Self { form, height_m: height }
    }

    fn level() -> Self {
        Self {
            form: RoofForm::Planes(vec![RoofPlane { at: DVec2::ZERO, height: 0.0, slope: DVec2::ZERO }]),
            height_m: 0.0,
        }
    }

    /// The greatest sum of slopes eastward and northward.
    pub fn steepest(&self) -> f64 {
        let sum = |slope: DVec2| slope.x.abs() + slope.y.abs();
        match &self.form {
            RoofForm::Planes(planes) | RoofForm::Around(_, planes) => {
                planes.iter().map(|plane| sum(plane.slope)).fold(0.0, f64::max)
            }
            RoofForm::FromWalls { slope, .. } => slope * std::f64::consts::SQRT_2,
        }
    }

    /// The roof over a part of a voxel, from `centre`: the least of these, each of which is the greatest of some planes.
    pub fn planes_over(&self, centre: DVec2, part: &ConvexPatch) -> Vec<Vec<RoofPlane>> {
        let corners: Vec<DVec2> = part.corners().map(|corner| centre + corner).collect();
        let mut all: Vec<Vec<RoofPlane>> = match &self.form {
            RoofForm::Planes(planes) => planes.iter().map(|plane| vec![*plane]).collect(),
            RoofForm::Around(sectors, planes) => {
                let of_edge = planes.len() / sectors.count();
                let edges = sectors.over(&corners);
                edges
                    .flat_map(|edge| &planes[edge * of_edge..][..of_edge])
                    .map(|plane| vec![*plane])
                    .collect()
            }
            RoofForm::FromWalls { walls, slope, most } => from_walls(walls, [*slope, *most], centre, part),
        };

        all = least_somewhere(all, &corners);
        if all.len() > MOST {
            // A little within, where of two that meet in a corner one is the least.
            let middle = centre + part.middle();
            let places = corners.iter().map(|corner| corner.lerp(middle, 1e-3)).chain([middle]);
            all = least_at(all, places);
        }

        for planes in &mut all {
            let is_below = |one: &RoofPlane, other: &RoofPlane| {
                corners.iter().all(|corner| one.height(*corner) <= other.height(*corner))
            };
            let known = planes.clone();
            planes.retain(|one| !known.iter().any(|other| other != one && is_below(one, other)));
        }

        all
    }
}

/// Height of the greatest of some planes over a place.
pub(super) fn greatest(planes: &[RoofPlane], place: DVec2) -> f64 {
    planes.iter().map(|plane| plane.height(place)).fold(f64::NEG_INFINITY, f64::max)
}

/// Chooses, of surfaces that are each the greatest of some planes, those that may be the least somewhere between places; one at least, if there are any.
fn least_somewhere(mut all: Vec<Vec<RoofPlane>>, corners: &[DVec2]) -> Vec<Vec<RoofPlane>> {
    // No higher than that, and no lower: planes are so in corners.
    let highest = |planes: &Vec<RoofPlane>| {
        corners.iter().map(|corner| greatest(planes, *corner)).fold(f64::NEG_INFINITY, f64::max)
    };
    let lowest = |planes: &Vec<RoofPlane>| {
        let of = |plane: &RoofPlane| corners.iter().map(|at| plane.height(*at)).fold(f64::INFINITY, f64::min);
        planes.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    };
    let bound = all.iter().min_by(|a, b| highest(a).total_cmp(&highest(b))).cloned();
    let least = bound.as_ref().map_or(f64::INFINITY, highest);
    all.retain(|planes| lowest(planes) < least);
    if all.is_empty() {
        // A level one is as high everywhere as at its highest.
        all.extend(bound);
    }
    all
}

/// Chooses of such surfaces those that are the least at places, each once.
fn least_at(all: Vec<Vec<RoofPlane>>, places: impl Iterator<Item = DVec2>) -> Vec<Vec<RoofPlane>> {
    let mut kept: Vec<Vec<RoofPlane>> = Vec::new();
    for place in places {
        let least = all.iter().min_by(|a, b| greatest(a, place).total_cmp(&greatest(b, place)));
        if let Some(planes) = least.filter(|planes| !kept.contains(planes)) {
            kept.push(planes.clone());
        }
    }
    kept
}

/// The planes of a dome through rings of places on an ellipsoid over the hull: one from ring to ring over each edge.
fn dome(hull: &[DVec2], middle: DVec2, height: f64) -> Vec<RoofPlane> {
    let planes = |edge: DVec2| {
        RINGS.windows(2).map(move |rings| {
            let [upper, lower] = [rings[0], rings[1]].map(|degrees| DVec2::from_angle(degrees.to_radians()));
            // Height over distance from the middle, as shares of the dome's and of the edge's.
            let fall = (upper.x - lower.x) / (lower.y - upper.y);
            let at_middle = upper.x + fall * upper.y;
            RoofPlane { at: middle, height: height * at_middle, slope: -edge * (height * fall) }
        })
    };
    hull_edges(hull, middle).flat_map(planes).collect()
}

/// A roof that rises from all walls alike, up to a height, over a part of a voxel.
fn from_walls(
    walls: &Walls,
    [slope, most]: [f64; 2],
    centre: DVec2,
    part: &ConvexPatch,
) -> Vec<Vec<RoofPlane>> {
    let middle = part.middle();
    // Away from corners, where two walls are as near.
    let places = part.corners().map(|corner| corner.lerp(middle, 0.125)).chain([middle]);
    let mut all: Vec<Vec<RoofPlane>> = Vec::new();

    for place in places {
        let Some((distance, eaves)) = walls.eaves(centre + place) else { continue };
        let mut found: Vec<RoofPlane> = match distance * slope < most {
            true => eaves
                .iter()
                .map(|eaves| RoofPlane { at: eaves.at, height: 0.0, slope: eaves.inward * slope })
                .collect(),
            false => vec![RoofPlane { at: centre, height: most, slope: DVec2::ZERO }],
        };

        // What runs down into a valley on one side of it runs on beside it.
        let (same, others): (Vec<_>, Vec<_>) = all.into_iter().partition(|known: &Vec<RoofPlane>| {
            known.iter().any(|known| found.iter().any(|plane| plane.is_same(known, centre)))
        });

        for plane in same.into_iter().flatten() {
            if !found.iter().any(|known| known.is_same(&plane, centre)) {
                found.push(plane);
            }
        }

        all = others;
        all.push(found);
    }

    if all.is_empty() {
        // Walls are rounded: it may lie beside them.
        all.push(vec![RoofPlane { at: centre, height: 0.0, slope: DVec2::ZERO }]);
    }

    all
}

/// Outward normal of each edge of a hull, over its distance from a place within.
fn hull_edges(hull: &[DVec2], middle: DVec2) -> impl Iterator<Item = DVec2> + '_ {
    hull.iter().zip(hull.iter().cycle().skip(1)).filter_map(move |(a, b)| {
        let along = (*b - *a).try_normalize()?;
        let normal = DVec2::new(along.y, -along.x);
        let distance = normal.dot(*a - middle);
        (distance > 0.0).then(|| normal / distance)
    })
}

/// Radius of the largest circle within a footprint, metres, to a hundredth of its size: the best of a grid, which then grows finer.
fn inradius(footprint: &Footprint, walls: &Walls, frame: Frame) -> f64 {
    const GRID: i32 = 8;
    let (mut middle, mut reach, mut best) = (frame.middle, frame.half.x, 0.0_f64);
    for _ in 0..6 {
        let from = middle;
        for sample in 0..(2 * GRID + 1).pow(2) {
            let (i, j) = (sample % (2 * GRID + 1) - GRID, sample / (2 * GRID + 1) - GRID);
            let place = from + DVec2::new(f64::from(i), f64::from(j)) * (reach / f64::from(GRID));
            let distance = walls.eaves(place).map_or(0.0, |(distance, _)| distance);
            if distance > best && footprint.holds(place) {
                (best, middle) = (distance, place);
            }
        }
        reach *= 0.3;
    }
    best
}
