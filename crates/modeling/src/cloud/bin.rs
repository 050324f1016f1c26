//! Points of all files, by tile of the grid.

use super::super::plan::Plan;
use super::super::vertical::Shift;
use super::class::{self, PointKind};
use super::columns;
use super::open::Cloud;
use super::read::{Points, RawPoint};
use super::store::{Store, TILE};
use super::window::Mark;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;
use hedgehop_geo::{Transform, VerticalDatum};

/// Points between two looks at whether to go on.
const STEP: u64 = 1 << 16;
/// Parts of a voxel's side that places are kept in.
const PARTS: f64 = 65536.0;

/// Sorts the points of all files into an empty store, file after file, with heights above `datum`.
pub(super) fn bin(
    clouds: &[Cloud],
    plan: &Plan,
    datum: VerticalDatum,
    mut store: Store<Mark>,
    observer: &dyn Observer,
) -> Result<Store<Mark>> {
    observer.begin("points", clouds.iter().map(|cloud| cloud.head.count).sum(), "points");
    for cloud in clouds {
        let placing = Placing {
            cloud,
            plan,
            world: Transform::new(&cloud.crs, &plan.crs)?,
            shift: Shift::between(cloud.datum, datum, &plan.grid, &plan.crs)?,
        };
        let mut points = Points::open(&cloud.path, &cloud.head)?;
        let mut failed = Ok(());

        loop {
            let mut put = |point: RawPoint| {
                if let Some((tile, mark)) = placing.mark(&point)
                    && failed.is_ok()
                {
                    failed = store.push(tile, mark);
                }
            };

            let count = points.take(STEP, &mut put)?;
            std::mem::replace(&mut failed, Ok(()))?;
            if count == 0 {
                break;
            }

            observer.advance(count);
            if observer.cancelled() {
                return Err(Error::Interrupted("no database was written".into()));
            }
        }
    }

    store.settle()?;
    observer.end();
    Ok(store)
}

/// Transformation of the points of a file into the grid.
struct Placing<'a> {
    cloud: &'a Cloud,
    plan: &'a Plan,
    world: Transform,
    shift: Shift,
}

impl Placing<'_> {
    /// Finds where a point lies; `None` if it is of no use or far outside.
    fn mark(&self, point: &RawPoint) -> Option<((i64, i64), Mark)> {
        let kind = class::kind(point.class).filter(|_| !point.is_withheld)?;
        // A file without ground shows what is highest.
        let kind = if self.cloud.look.is_classified() { kind } else { PointKind::Surface };
        let [x, y, z] = point.place;
        let (x, y) = self.world.apply(x, y)?;
        let grid = &self.plan.grid;
        let place = [(x - grid.origin.x) / grid.spacing, (y - grid.origin.y) / grid.spacing];
        let size = [grid.nx, grid.ny].map(f64::from);
        let halo = columns::HALO as f64;
        let is_near = |axis: usize| place[axis] >= -halo && place[axis] < size[axis] + halo;
        if !(is_near(0) && is_near(1)) {
            return None;
        }

        let voxel = place.map(|place| place.floor() as i64);
        let within = [0, 1].map(|axis| ((place[axis] - place[axis].floor()) * PARTS) as u16);
        let height = z * self.cloud.metres_per_unit + self.shift.at(place.into());
        let colour = self.cloud.look.srgb(point.colour);

        let mark = Mark {
            z: height as f32,
            within,
            voxel: voxel.map(|voxel| voxel.rem_euclid(TILE) as u8),
            kind: kind as u8,
            is_coloured: u8::from(colour.is_some()),
            colour: colour.unwrap_or_default(),
            rest: 0,
        };

        let tile = (voxel[0].div_euclid(TILE), voxel[1].div_euclid(TILE));
        mark.z.is_finite().then_some((tile, mark))
    }
}
