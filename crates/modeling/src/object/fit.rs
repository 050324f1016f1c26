//! Stretches of rays over a voxel, as few solids.
//!
//! ```text
//! layers:  stretches that overlap; a layer is split where the upper or the lower ends of its rays leave a gap and lie on no plane
//! a layer: upper end = the plane with the least squares of distances; lower end = the ground, the same plane, or level
//!          covered places → the whole voxel | a half-plane, of a direction that steep faces have, or two | a strip | what is narrow: as dense as
//!          the mean width of its outline, which is its length by π (Cauchy 1832)
//! foliage: sheets that are no plane: as dense as the share of rays that they stop
//! poles:   steep faces that no ray is inside of
//! ```

use glam::{DVec2, Vec3, dvec2};

use super::bands::banded;
use super::mask::{Mask, MaskForm, RAYS, place};
use super::rays::{RayCell, Steep, Stretch};
use super::soup::Soup;
use crate::features::{HalfPlane, Solid, Wall};
use hedgehop_base::colour::srgb8_from_linear;

/// Gap of heights at which a layer is split, and rise of a sheet's places over its plane that is foliage, in voxels.
const STEP: f64 = 0.25;
/// Share of the widest gap between ends that a plane through them leaves if they lie on a slope: at a step it leaves a quarter.
const SLOPED: f64 = 0.2;
/// Height above the foot up to which a solid stands on the ground, in voxels.
const STANDS: f64 = 0.25;
/// Layers of one voxel.
const MOST_LAYERS: usize = 12;
/// Share that a pole hides at least, so that it is seen at all.
const FAINTEST: f64 = 0.07;
/// Least opacity of what is kept.
const LEAST: f64 = 0.035;
/// Part of a voxel by which a wall must reach into it.
const NOTHING: f64 = 1.0 / 256.0;
/// Steepest upper end, rise over run.
const STEEPEST: f64 = 3.5;
/// Light that sides have less than tops, where no face tells their colour.
const SHADE: f32 = 0.75;

/// Over which voxel, and of what.
pub(super) struct Over<'s> {
    pub soup: &'s Soup,
    /// The voxel's centre, metres from the foot.
    pub centre: DVec2,
    pub spacing: f64,
    pub material: u8,
    /// Whether its foot is on the ground.
    pub stands: bool,
}

/// A plane over a voxel: height over its centre, and slopes.
#[derive(Debug, Clone, Copy)]
struct EndPlane {
    height: f64,
    slope: DVec2,
    /// Root of the mean square of what it leaves.
    rest: f64,
}

impl Over<'_> {
    /// The solids.
    pub fn fit(&self, cell: &mut RayCell) -> Vec<Solid> {
        let stretches = cell.stretches(&self.soup.pieces, self.spacing);
        let (sheets, dense): (Vec<Stretch>, Vec<Stretch>) =
            stretches.into_iter().partition(|stretch| stretch.is_sheet);
        let mut solids: Vec<Solid> =
            self.layers(dense).iter().filter_map(|layer| self.layer(layer, &cell.steep)).collect();
        let dense = solids.len();
        for layer in overlapping(sheets, self.spacing) {
            self.sheets(layer, &cell.steep, &mut solids);
        }

        solids.extend(self.poles(&cell.steep, &solids));
        // Last, since a wall is one to what looks whether it is there.
        let rest = solids.split_off(dense);
        let banded = |solid: Solid| {
            let ends = [solid.low_m.unwrap_or(f64::NEG_INFINITY), solid.high_m];
            banded(solid, &beside(&cell.sides, ends), self.spacing)
        };
        let mut solids: Vec<Solid> = solids.into_iter().flat_map(banded).chain(rest).collect();
        solids.sort_by(|a, b| {
            let low = |solid: &Solid| solid.low_m.unwrap_or(f64::NEG_INFINITY);
            low(a).total_cmp(&low(b)).then(a.high_m.total_cmp(&b.high_m))
        });

        solids
    }

    fn layers(&self, stretches: Vec<Stretch>) -> Vec<Vec<Stretch>> {
        let mut waiting = overlapping(stretches, 0.0);
        let mut layers = Vec::new();
        while let Some(layer) = waiting.pop() {
            let room = layers.len() + waiting.len() + 2 <= MOST_LAYERS;
            let ends: [fn(&Stretch) -> f64; 2] = [|stretch| stretch.high, |stretch| stretch.low];
            let parts = ends.into_iter().filter(|_| room).find_map(|end| {
                let (gap, parts) = split(&layer, end, STEP * self.spacing)?;
                // Ends of neighbouring rays on a steep slope lie far apart, too.
                (self.plane(&layer, end).rest > SLOPED * gap).then_some(parts)
            });
            match parts {
                Some(parts) => waiting.extend(parts),
                None => layers.push(layer),
            }
        }
        layers
    }

    /// Fits a solid to what encloses something.
    fn layer(&self, layer: &[Stretch], steep: &[Steep]) -> Option<Solid> {
        let mask = mask_of(layer);
        let (upper, lower) =
            (self.plane(layer, |stretch| stretch.high), self.plane(layer, |stretch| stretch.low));
        let ends = [mean(layer, |stretch| stretch.low), mean(layer, |stretch| stretch.high)];
        let beside = beside(steep, ends);
        let dense = beside.iter().filter(|steep| !steep.is_sheet);
        let facings: Vec<HalfPlane> = dense
            .filter_map(|steep| {
                let normal = steep.normal.try_normalize()?;
                Some(HalfPlane { normal, distance: steep.distance / steep.area / self.spacing })
            })
            .collect();
        let turned = |half: HalfPlane| (half.facing(), half.distance * self.spacing);
        let form = mask.form(&facings);

        let (wall, opacity) = match form {
            MaskForm::Whole => (Wall::Whole, 1.0),
            MaskForm::Half(half) | MaskForm::Strip(half) => {
                let (facing, distance_m) = turned(half);
                (Wall::Plane { facing, distance_m }, 1.0)
            }
            MaskForm::Corner(walls) => (Wall::Corner(walls.map(turned)), 1.0),
            MaskForm::Island => {
                let around: f64 =
                    beside.iter().filter(|steep| !steep.is_sheet).map(|steep| steep.length()).sum();
                let round = 2.0 * (std::f64::consts::PI * mask.share()).sqrt() * self.spacing;
                let width = (around.max(round) / std::f64::consts::PI / self.spacing).min(1.0);
                (self.round(), width)
            }
        };

        // Narrow ones have no slope that their places would tell; one that is steep and does not fit would stand out beyond them.
        let is_plane = mask.count() >= RAYS / 4 || upper.rest < 0.2 * STEP * self.spacing;
        let is_broad = mask.count() >= RAYS / 8 && form != MaskForm::Island && is_plane;
        let upper = if is_broad { upper } else { EndPlane { height: ends[1], slope: DVec2::ZERO, ..upper } };
        let is_parallel = is_broad && upper.slope.length() > 0.05 && upper.slope.distance(lower.slope) < 0.15;
        let low_m = match self.is_ground(ends[0]) {
            true => None,
            false if is_parallel => Some(lower.height),
            false => Some(ends[0]),
        };
        let (top, side) = self.colours(layer, &beside);

        self.solid(Solid {
            low_m,
            high_m: upper.height,
            slope: upper.slope.into(),
            wall,
            top,
            side,
            opacity,
            material: self.material,
            parallel: is_parallel && low_m.is_some(),
            strip: false,
            joined: [false; 2],
            facade: None,
        })
    }

    /// Sheets that overlap: a plane, or foliage.
    fn sheets(&self, layer: Vec<Stretch>, steep: &[Steep], solids: &mut Vec<Solid>) {
        let mask = mask_of(&layer);
        let is_single = layer.len() <= mask.count() + mask.count() / 8;
        let upper = self.plane(&layer, |stretch| stretch.high);
        if is_single && (upper.rest <= STEP * self.spacing || mask.count() < 4) {
            let ends = [mean(&layer, |stretch| stretch.low), mean(&layer, |stretch| stretch.high)];
            let thickness = ends[1] - ends[0];
            solids.extend(self.layer(&layer, steep).map(|solid| Solid {
                low_m: (!self.is_ground(ends[0])).then_some(solid.high_m - thickness),
                parallel: !self.is_ground(ends[0]),
                ..solid
            }));
            return;
        }

        let low = layer.iter().map(|stretch| stretch.low).fold(f64::INFINITY, f64::min);
        let beside = beside(steep, [low, upper.height]);
        let (top, side) = self.colours(&layer, &beside);
        let around: f64 = beside.iter().map(|steep| steep.length()).sum::<f64>() / self.spacing;

        solids.extend(self.solid(Solid {
            low_m: (!self.is_ground(low)).then_some(low),
            high_m: upper.height,
            slope: (0.5 * upper.slope.clamp_length_max(2.0)).into(),
            wall: self.round(),
            top,
            side,
            opacity: mask.share().max(around * std::f64::consts::FRAC_1_PI).min(1.0),
            material: self.material,
            parallel: false,
            strip: false,
            joined: [false; 2],
            facade: None,
        }));
    }

    /// Steep faces beside which no solid is: what is narrower than rays lie apart, and sheets that stand.
    fn poles(&self, steep: &[Steep], solids: &[Solid]) -> Vec<Solid> {
        let is_known = |steep: &Steep| {
            let reach = 0.5 * self.spacing;
            solids.iter().any(|solid| {
                let low = solid.low_m.unwrap_or(f64::NEG_INFINITY) - reach;
                let high = solid.high_m + reach;
                steep.high.min(high) - steep.low.max(low) > 0.5 * (steep.high - steep.low)
            })
        };

        let mut left: Vec<&Steep> = steep.iter().filter(|steep| !is_known(steep)).collect();
        left.sort_by(|a, b| a.low.total_cmp(&b.low).then(a.high.total_cmp(&b.high)));
        let mut groups: Vec<(f64, Vec<&Steep>)> = Vec::new();
        for steep in left {
            match groups.last_mut().filter(|(high, _)| steep.low < *high) {
                Some((high, group)) => {
                    *high = high.max(steep.high);
                    group.push(steep);
                }
                None => groups.push((steep.high, vec![steep])),
            }
        }

        groups.into_iter().filter_map(|(_, group)| self.pole(&group)).collect()
    }

    fn pole(&self, group: &[&Steep]) -> Option<Solid> {
        let area: f64 = group.iter().map(|steep| steep.area).sum();
        let normal: DVec2 = group.iter().map(|steep| steep.normal).sum();
        let sheets: f64 = group.iter().filter(|steep| steep.is_sheet).map(|steep| steep.area).sum();
        let low = group.iter().map(|steep| steep.low).fold(f64::INFINITY, f64::min);
        let high = group.iter().map(|steep| steep.high).fold(f64::NEG_INFINITY, f64::max);
        let is_dense = 2.0 * sheets < area;

        // Of one wall alone that much is here which no ray meets.
        let is_rim = is_dense && normal.length() > 0.95 * area;
        if is_dense && !is_rim && normal.length() > 0.5 * area || high - low < 1e-6 {
            return None;
        }

        let length = area / (high - low) / self.spacing * if is_dense { 0.5 } else { 1.0 };
        let along = group.iter().max_by(|a, b| a.area.total_cmp(&b.area))?;
        let facing = along.normal.try_normalize().unwrap_or(DVec2::X);
        let is_wall = length > 0.7 && along.normal.length() > 0.4 * area;

        let (wall, opacity) = if is_wall || is_rim {
            let distance_m = along.distance / along.area;
            let reach = 0.5 * (facing.x.abs() + facing.y.abs());
            if is_rim && distance_m / self.spacing < NOTHING - reach {
                return None;
            }
            let is_turned = distance_m < 0.0 && !is_rim;
            let (facing, distance_m) = if is_turned { (-facing, -distance_m) } else { (facing, distance_m) };
            (
                Wall::Plane { facing: facing.y.atan2(facing.x), distance_m },
                if is_rim { 1.0 } else { length.min(1.0) },
            )
        } else {
            let width = 2.0 * length * std::f64::consts::FRAC_1_PI;
            let is_tall = high - low > 0.5 * self.spacing;
            (self.round(), width.clamp(if is_tall { FAINTEST } else { 0.0 }, 1.0))
        };

        let all: Vec<Steep> = group.iter().map(|steep| **steep).collect();
        let side = colour_of(&all)?;
        self.solid(Solid {
            low_m: (!self.is_ground(low)).then_some(low),
            high_m: high,
            slope: [0.0; 2],
            wall,
            top: side.to_array().map(srgb8_from_linear),
            side: side.to_array().map(srgb8_from_linear),
            opacity,
            material: self.material,
            parallel: false,
            strip: false,
            joined: [false; 2],
            facade: None,
        })
    }

    /// Whether what ends at a height stands on the ground.
    fn is_ground(&self, low: f64) -> bool {
        self.stands && low <= STANDS * self.spacing
    }

    /// Sides look away from the foot.
    fn round(&self) -> Wall {
        Wall::Round(self.centre.y.atan2(self.centre.x))
    }

    fn solid(&self, solid: Solid) -> Option<Solid> {
        let is_seen = solid.opacity >= LEAST && solid.high_m > solid.low_m.unwrap_or(0.0);
        (is_seen && solid.high_m.is_finite()).then_some(solid)
    }

    /// Colours of the upper ends, and of sides.
    fn colours(&self, layer: &[Stretch], beside: &[Steep]) -> ([u8; 3], [u8; 3]) {
        let metres = self.spacing / (RAYS as f64).sqrt();
        let mut sum = Vec3::ZERO;
        for stretch in layer {
            let face = &self.soup.faces[stretch.top as usize];
            let at = self.centre + place(usize::from(stretch.ray)) * self.spacing;
            let weights = face.weights(at.extend(stretch.high));
            sum += face.colour(&self.soup.materials, weights, metres).truncate();
        }
        let top = sum / layer.len().max(1) as f32;
        let side = colour_of(beside).unwrap_or(top * SHADE);
        (top.to_array().map(srgb8_from_linear), side.to_array().map(srgb8_from_linear))
    }

    /// The plane through ends of stretches.
    fn plane(&self, layer: &[Stretch], end: impl Fn(&Stretch) -> f64) -> EndPlane {
        let count = layer.len() as f64;
        let at = |stretch: &Stretch| place(usize::from(stretch.ray)) * self.spacing;
        let middle = layer.iter().map(at).sum::<DVec2>() / count;
        let height = mean(layer, &end);
        let [mut xx, mut xy, mut yy, mut xz, mut yz, mut zz] = [0.0; 6];

        for stretch in layer {
            let (from, up) = (at(stretch) - middle, end(stretch) - height);
            xx += from.x * from.x;
            xy += from.x * from.y;
            yy += from.y * from.y;
            xz += from.x * up;
            yz += from.y * up;
            zz += up * up;
        }

        let volume = xx * yy - xy * xy;
        // Places along a line tell no slope across it.
        let is_sound = volume > 1e-3 * (xx + yy) * (xx + yy) && layer.len() >= RAYS / 8;
        let slope = if is_sound { dvec2(xz * yy - yz * xy, yz * xx - xz * xy) / volume } else { DVec2::ZERO };
        let rest = ((zz - slope.x * xz - slope.y * yz).max(0.0) / count).sqrt();
        let slope = slope.clamp(DVec2::splat(-STEEPEST), DVec2::splat(STEEPEST));

        EndPlane { height: height - slope.dot(middle), slope, rest }
    }
}

fn mask_of(layer: &[Stretch]) -> Mask {
    let mut mask = Mask::default();
    layer.iter().for_each(|stretch| mask.add(usize::from(stretch.ray)));
    mask
}

fn mean(layer: &[Stretch], end: impl Fn(&Stretch) -> f64) -> f64 {
    layer.iter().map(end).sum::<f64>() / layer.len() as f64
}

/// Steep faces beside a layer.
fn beside(steep: &[Steep], [low, high]: [f64; 2]) -> Vec<Steep> {
    steep.iter().filter(|steep| steep.low < high && steep.high > low).copied().collect()
}

/// Returns their mean colour.
fn colour_of(steep: &[Steep]) -> Option<Vec3> {
    let area: f64 = steep.iter().map(|steep| steep.area).sum();
    let sum: Vec3 = steep.iter().map(|steep| steep.colour).sum();
    (area > 0.0).then(|| sum / area as f32)
}

/// Stretches by whether they overlap, or are no further apart than a gap.
fn overlapping(mut stretches: Vec<Stretch>, gap: f64) -> Vec<Vec<Stretch>> {
    stretches.sort_by(|a, b| a.low.total_cmp(&b.low).then(a.ray.cmp(&b.ray)));
    let mut layers: Vec<(f64, Vec<Stretch>)> = Vec::new();
    for stretch in stretches {
        match layers.last_mut().filter(|(high, _)| stretch.low <= *high + gap) {
            Some((high, layer)) => {
                *high = high.max(stretch.high);
                layer.push(stretch);
            }
            None => layers.push((stretch.high, vec![stretch])),
        }
    }
    layers.into_iter().map(|(_, layer)| layer).collect()
}

/// The widest gap of a layer's ends, if that is wider than `least`, and the parts below and above it.
fn split(layer: &[Stretch], end: fn(&Stretch) -> f64, least: f64) -> Option<(f64, [Vec<Stretch>; 2])> {
    let mut ends: Vec<f64> = layer.iter().map(end).collect();
    ends.sort_by(f64::total_cmp);
    let gaps = ends.windows(2).map(|pair| (pair[1] - pair[0], 0.5 * (pair[0] + pair[1])));
    let (gap, middle) = gaps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (gap > least).then(|| {
        let (below, above) = layer.iter().partition(|stretch| end(stretch) < middle);
        (gap, [below, above])
    })
}
