//! Solids of revolution: tanks, silos, chimneys, cooling towers, masts, crowns of trees.
//!
//! ```text
//! narrowing, waisted   circles one above the other: from one to the next the radius changes by an eighth of a voxel; where several
//!                      of them hold a voxel whole it has one solid
//! dome, cone           a surface of heights over the distance from the axis
//! rim                  voxels that a circle cuts are cut by its tangent
//! narrower than a voxel: one voxel, round, that hides as much as the width would (from every side alike)
//! ```

use glam::DVec2;

use super::super::kinds::{Cap, Leaf, Tree, Upright};
use super::super::meaning::{mix, share, varied};
use super::footprint::Footprint;
use super::solid::{PlacedSolid, Solid, Square, Wall};

/// Something round where it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundUpright {
    pub(super) middle: DVec2,
    /// Radius at the ground, metres.
    pub(super) radius: f64,
    pub(super) base_m: f64,
    pub(super) upright: Upright,
}

/// One of several cylinders above each other: heights are metres above the ground.
struct Section {
    radius: f64,
    low: f64,
    high: f64,
    is_lowest: bool,
    is_highest: bool,
}

/// A voxel beside the axis.
struct RingPlace {
    index: usize,
    /// Distance of its centre from the axis, metres.
    distance: f64,
    outward: DVec2,
    /// Distance from its centre to a corner, outward, metres.
    reach: f64,
}

impl RingPlace {
    fn of(axis: DVec2, square: &Square, column: usize, row: usize) -> Self {
        let from_axis = square.centre(column, row) - axis;
        let outward = from_axis.try_normalize().unwrap_or(DVec2::X);
        let reach = 0.5 * square.spacing * (outward.x.abs() + outward.y.abs());
        Self { index: square.index(column, row), distance: from_axis.length(), outward, reach }
    }

    /// All of it.
    fn whole(&self) -> Wall {
        Wall::Round(self.outward.to_angle())
    }
}

/// Diameter in voxels below which something round is one voxel wide.
const NARROW: f64 = 1.6;
/// Radius in voxels up to which voxels at the rim are there as a whole or not at all.
const BROAD: f64 = 1.5;
/// Share of a voxel that is enough of it there.
const LEAST_SHARE: f64 = 0.4;
/// Sections by which the radius changes by a voxel: their edges are finer than what tells walls apart.
const STEPS: f64 = 8.0;
/// Most sections.
const MOST: f64 = 4096.0;
/// Heights of a dome and a cone, as shares of the radius.
const DOME: f64 = 0.35;
const CONE: f64 = 0.5;
/// Height of a cooling tower's waist as a share of the whole, and radius at its top as a share of that at its foot.
const WAIST: f64 = 0.78;
const WAISTED_TOP: f64 = 0.7;

impl BoundUpright {
    /// Height of its highest point, metres.
    pub fn top_m(&self) -> f64 {
        self.base_m + self.upright.height_m
    }

    /// Raises its solids, with the index of their voxel.
    pub fn raise(&self, square: &Square, out: &mut Vec<PlacedSolid>) {
        if 2.0 * self.radius < square.spacing {
            return self.thin(square, self.radius, None, self.top_m(), out);
        }

        let (broad, narrow): (Vec<Section>, Vec<Section>) = self
            .sections(square.spacing)
            .into_iter()
            .partition(|section| section.radius > BROAD * square.spacing);
        narrow.iter().for_each(|section| self.raise_narrow(section, square, out));

        let radii = || broad.iter().map(|section| section.radius);
        let (least, most) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        let [low, high] = [self.middle - most, self.middle + most];
        for (column, row) in square.voxels([low.x, low.y, high.x, high.y]) {
            let place = RingPlace::of(self.middle, square, column, row);
            let ends = broad.first().zip(broad.last()).filter(|_| place.reach <= least - place.distance);
            if let Some((first, last)) = ends.filter(|_| narrow.is_empty()) {
                out.push(self.solid([first, last], &place, place.whole()).over(place.index));
            } else {
                self.raise_rim(&broad, &place, out);
            }
        }
    }

    /// The sections over one voxel: a solid for all that hold it whole one above the other, and one for each whose rim cuts it.
    fn raise_rim(&self, sections: &[Section], place: &RingPlace, out: &mut Vec<PlacedSolid>) {
        let mut whole: Option<[&Section; 2]> = None;
        for section in sections {
            let room = section.radius - place.distance;
            if let Some(run) = whole.take_if(|[_, last]| room < place.reach || last.high < section.low) {
                out.push(self.solid(run, place, place.whole()).over(place.index));
            }
            if room >= place.reach {
                let first = whole.map_or(section, |[first, _]| first);
                whole = Some([first, section]);
            } else if room > -place.reach {
                let wall = Wall::plane(place.outward, room);
                out.push(self.solid([section, section], place, wall).over(place.index));
            }
        }
        if let Some(run) = whole {
            out.push(self.solid(run, place, place.whole()).over(place.index));
        }
    }

    /// A section of a few voxels.
    fn raise_narrow(&self, section: &Section, square: &Square, out: &mut Vec<PlacedSolid>) {
        let Section { radius, low, high, is_lowest, .. } = *section;
        // Where four voxels meet none of them holds enough of a narrow circle.
        if 2.0 * radius < NARROW * square.spacing {
            let low_m = (!is_lowest).then_some(self.base_m + low);
            return self.thin(square, radius, low_m, self.base_m + high, out);
        }
        let circle = Footprint::circle(self.middle, radius, 0.02 * square.spacing);
        for cover in circle.cover(square) {
            let is_cut = matches!(cover.wall, Wall::Plane { .. } | Wall::Corner(_) | Wall::Wedge(_));
            if !is_cut || cover.share >= LEAST_SHARE {
                let place = RingPlace::of(self.middle, square, cover.column, cover.row);
                out.push(self.solid([section, section], &place, place.whole()).over(place.index));
            }
        }
    }

    /// Some sections one above the other over a voxel.
    fn solid(&self, [first, last]: [&Section; 2], place: &RingPlace, wall: Wall) -> Solid {
        // The rim's own height is that of the rim, not of what would be beyond it.
        let within = place.distance.min(last.radius * (1.0 - 1e-6));
        let (cap, fall) = if last.is_highest { self.cap(within) } else { (last.high, 0.0) };
        let low_m = (!first.is_lowest).then_some(self.base_m + first.low);
        let high_m = self.base_m + cap + fall * (place.distance - within);
        let Upright { opacity, paint, .. } = self.upright;
        Solid { slope: (place.outward * fall).into(), wall, opacity, ..Solid::level(low_m, high_m, paint) }
    }

    /// Circles one above the other that come near to its outline.
    fn sections(&self, spacing: f64) -> Vec<Section> {
        let change = if self.upright.cap == Cap::Waisted { 2.0 } else { 1.0 } * (self.radius - self.least());
        let count = (STEPS * change / spacing).ceil().clamp(1.0, MOST) as usize;
        let height = |index: usize| self.upright.height_m * index as f64 / count as f64;
        let section = |index: usize| {
            let (low, high) = (height(index), height(index + 1));
            let radius = self.radius_at(low.midpoint(high));
            Section { radius, low, high, is_lowest: index == 0, is_highest: index + 1 == count }
        };
        (0..count).map(section).collect()
    }

    /// Returns the least radius, metres.
    fn least(&self) -> f64 {
        self.radius * self.upright.taper.clamp(0.0, 1.0)
    }

    /// Radius at a height above the ground, metres.
    fn radius_at(&self, height: f64) -> f64 {
        let (taper, share) = (self.upright.taper.clamp(0.0, 1.0), height / self.upright.height_m);
        if self.upright.cap != Cap::Waisted {
            return self.radius * (1.0 + (taper - 1.0) * share);
        }
        // A hyperbola: radius² = waist² + (height from the waist)² · constant, one below the waist and one above.
        let (far, widest) = match share < WAIST {
            true => ((WAIST - share) / WAIST, 1.0),
            false => ((share - WAIST) / (1.0 - WAIST), WAISTED_TOP.max(taper)),
        };
        self.radius * (taper * taper + far * far * (widest * widest - taper * taper)).sqrt()
    }

    /// Height above the ground over a distance from the axis, and how it changes with it: its upper end.
    fn cap(&self, distance: f64) -> (f64, f64) {
        let Upright { height_m, cap, .. } = self.upright;
        let (radius, share) = (self.radius, distance / self.radius);
        match cap {
            Cap::Flat | Cap::Waisted => (height_m, 0.0),
            Cap::Dome => {
                let rise = (DOME * radius).min(height_m);
                // Near the rim the slope has no bound.
                let share = share.min(0.98);
                let rest = (1.0 - share * share).sqrt();
                (height_m - rise * (1.0 - rest), -rise * share / (rest * radius))
            }
            Cap::Cone => {
                let rise = (CONE * radius).min(height_m);
                (height_m - rise * share, -rise / radius)
            }
        }
    }

    /// A part of it that is one voxel wide.
    fn thin(
        &self,
        square: &Square,
        radius: f64,
        low_m: Option<f64>,
        high_m: f64,
        out: &mut Vec<PlacedSolid>,
    ) {
        let (columns, rows) = square.touched([self.middle.x, self.middle.y, self.middle.x, self.middle.y]);
        let Some((column, row)) = columns.into_iter().next().zip(rows.into_iter().next()) else { return };
        let width = (2.0 * radius / square.spacing).min(1.0);
        let opacity = (self.upright.opacity * width).max(FAINTEST);
        let solid =
            Solid { opacity, wall: Wall::Round(0.0), ..Solid::level(low_m, high_m, self.upright.paint) };
        out.push(solid.over(square.index(column, row)));
    }
}

/// Share that a pole hides at least, so that it is seen at all.
const FAINTEST: f64 = 0.07;

/// A tree where it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundTree {
    pub(super) place: DVec2,
    pub(super) base_m: f64,
    pub(super) tree: Tree,
    /// Hash that tells it from others.
    pub(super) hash: u64,
}

/// Height of the stem below the crown, as a share of the whole.
const STEM: f64 = 0.22;
/// Codes by which parts of a crown differ.
const ROUGH: f64 = 14.0;

impl BoundTree {
    /// Height of its top, metres.
    pub fn top_m(&self) -> f64 {
        self.base_m + self.tree.height_m
    }

    /// Raises its solids, with the index of their voxel: stem and crown.
    pub fn raise(&self, square: &Square, out: &mut Vec<PlacedSolid>) {
        let Tree { height_m, crown_m, leaf, paint } = self.tree;
        let radius = 0.5 * crown_m;
        let crown_base = self.base_m + STEM * height_m;
        let reach = DVec2::splat(radius.max(0.5 * square.spacing));
        let (low, high) = (self.place - reach, self.place + reach);
        let half_crown = 0.5 * (1.0 - STEM) * height_m;

        for (column, row) in square.voxels([low.x, low.y, high.x, high.y]) {
            let (centre, index) = (square.centre(column, row), square.index(column, row));
            let from_axis = centre - self.place;
            let half = 0.5 * square.spacing;
            let holds_stem =
                from_axis.x > -half && from_axis.x <= half && from_axis.y > -half && from_axis.y <= half;
            let share = (from_axis.length() / radius).min(if holds_stem { 0.7 } else { f64::INFINITY });

            if share < 1.0 {
                let (low_m, high_m, fall) = match leaf {
                    Leaf::Needle => {
                        let crown = (1.0 - STEM) * height_m;
                        (crown_base, crown_base + crown * (1.0 - share), -crown / radius)
                    }
                    Leaf::Broad | Leaf::Mixed => {
                        let rest = (1.0 - share * share).sqrt();
                        let middle = crown_base + half_crown;
                        let fall = -half_crown * share / (rest.max(0.2) * radius);
                        (middle - half_crown * rest, middle + half_crown * rest, fall)
                    }
                };

                let outward = from_axis.try_normalize().unwrap_or(DVec2::X);
                // A ring of shade: less light reaches what lies further out and below, and leaves are no smooth surface.
                let light = 1.0 - 0.22 * share;
                let shaded = |light: f64| paint.colour.map(|code| (f64::from(code) * light).round() as u8);
                let rough = rough_of(centre, self.hash);

                let solid = Solid {
                    slope: (outward * fall.max(STEEPEST)).into(),
                    wall: Wall::Round(outward.to_angle()),
                    top: varied(shaded(light), rough, ROUGH),
                    side: varied(shaded(0.72 * light), rough, ROUGH),
                    opacity: if share > 0.75 { 0.75 } else { 1.0 },
                    ..Solid::level(Some(low_m), high_m, paint)
                };

                match leaf {
                    Leaf::Needle if holds_stem => {
                        let sides = tip(&solid, fall.max(STEEPEST), from_axis, self.top_m());
                        out.extend(sides.map(|side| side.over(index)));
                    }
                    _ => out.push(solid.over(index)),
                }
            }

            if holds_stem {
                let width = (0.03 * height_m / square.spacing).clamp(FAINTEST, 1.0);
                let stem = Solid {
                    opacity: width,
                    wall: Wall::Round(0.0),
                    ..Solid::level(None, crown_base + half_crown, paint)
                };
                out.push(Solid { top: BARK, side: BARK, ..stem }.over(index));
            }
        }
    }
}

/// Steepest fall of a crown over a voxel, rise over run.
const STEEPEST: f64 = -2.0;

/// The four sides of a crown's tip over a voxel, whose centre lies `from_tip` (metres) from it; `fall` is their slope.
fn tip(crown: &Solid, fall: f64, from_tip: DVec2, top_m: f64) -> [Solid; 4] {
    let eighth = std::f64::consts::FRAC_PI_4;
    [0.0, 2.0, 4.0, 6.0].map(|side| {
        let slope = DVec2::from_angle(side * eighth) * fall;
        let joints = [side + 3.0, side - 3.0].map(|turn| {
            let facing = turn * eighth;
            (facing, -DVec2::from_angle(facing).dot(from_tip))
        });
        let high_m = top_m + slope.dot(from_tip);
        Solid { slope: slope.into(), wall: Wall::Corner(joints), joined: [true; 2], high_m, ..*crown }
    })
}

const BARK: [u8; 3] = [88, 76, 62];

/// Bits of a place that do not depend on who asks: by centimetres.
fn rough_of(place: DVec2, hash: u64) -> u64 {
    // Away from halves, where rounding would depend on the last bit.
    let whole = |metres: f64| (metres * 100.0 + 0.37).round() as i64 as u64;
    mix(hash ^ mix(whole(place.x)) ^ mix(whole(place.y)).rotate_left(32))
}

/// A number of 0…1 for a tree.
pub(super) fn chance(hash: u64, index: u64) -> f64 {
    share(mix(hash.wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15))))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::patch::{ConvexPatch, HalfPlane};
    use super::super::testing::{PAINT, at, square};
    use super::*;

    /// Area of a round thing at heights above the ground, from its solids, as a radius.
    fn radii(upright: Upright, radius: f64, heights: &[f64]) -> Vec<f64> {
        let bound = BoundUpright { middle: at(30.3, 24.6), radius, base_m: 100.0, upright };
        let mut solids = Vec::new();
        bound.raise(&square(1.0), &mut solids);
        let area = |solid: &Solid| {
            let planes: Vec<HalfPlane> =
                solid.wall.planes().map(|(facing, distance)| HalfPlane::towards(facing, distance)).collect();
            ConvexPatch::voxel(1.0).within_all(planes.iter().enumerate()).area()
        };
        let at = |height: f64| {
            let is_there = |solid: &Solid| {
                solid.low_m.is_none_or(|low| low <= 100.0 + height) && solid.high_m > 100.0 + height
            };
            let there = solids.iter().map(|placed| &placed.solid).filter(|solid| is_there(solid));
            (there.map(area).sum::<f64>() / PI).sqrt()
        };
        heights.iter().map(|height| at(*height)).collect()
    }

    /// Sides of what narrows have no steps that a voxel would show, however high it is.
    #[test]
    fn high_towers_narrow_without_steps() {
        let heights: Vec<f64> = (0..395).map(|step| 0.3 + f64::from(step)).collect();
        for (cap, taper) in [(Cap::Flat, 0.5), (Cap::Flat, 0.2), (Cap::Waisted, 0.6)] {
            let upright =
                Upright { height_m: 400.0, diameter_m: None, taper, cap, opacity: 1.0, paint: PAINT };
            let bound = BoundUpright { middle: DVec2::ZERO, radius: 20.0, base_m: 0.0, upright };
            let found = radii(upright, 20.0, &heights);
            for (height, found) in heights.iter().zip(&found) {
                let expected = bound.radius_at(*height);
                assert!(
                    (found - expected).abs() < 0.15,
                    "{cap:?} {taper}: {found}, not {expected} m at {height} m"
                );
            }
        }
    }

    /// What many sections hold whole is one solid.
    #[test]
    fn towers_are_of_few_solids() {
        let upright = Upright {
            height_m: 400.0,
            diameter_m: None,
            taper: 0.5,
            cap: Cap::Flat,
            opacity: 1.0,
            paint: PAINT,
        };
        let bound = BoundUpright { middle: at(30.3, 24.6), radius: 20.0, base_m: 100.0, upright };
        let mut solids = Vec::new();
        bound.raise(&square(1.0), &mut solids);
        let most =
            (0..64 * 48).map(|index| solids.iter().filter(|placed| placed.voxel == index).count()).max();
        assert!(most.is_some_and(|most| most <= 14), "{most:?}");
    }
}
