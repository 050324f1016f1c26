//! Footprint of an opened raster: its bounds, and the sides of its pixels.

use glam::DVec2;

use super::warp;
use crate::naming::file_name;
use crate::opened::Opened;
use crate::raster::GeoTransform;
use hedgehop::Size;
use hedgehop::voxel::SourceRecord;
use hedgehop_base::error::Result;
use hedgehop_geo::{Crs, Transform};

/// West, south, east, north of a raster's corners.
pub(super) fn corner_bounds(geo: &GeoTransform, size: Size) -> [f64; 4] {
    let (w, h) = (f64::from(size.width), f64::from(size.height));
    [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)]
        .map(|(column, row)| warp::apply(geo, column, row))
        .into_iter()
        .fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, (x, y)| {
            [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]
        })
}

impl<T> Opened<T> {
    /// Side of the square that is as large as a pixel at the raster's centre, metres of `crs`; `None` where the
    /// centre has no place in it.
    pub fn pixel_side(&self, crs: &Crs) -> Result<Option<f64>> {
        let side = self.pixel_axes(crs)?.map(|(across, down)| across.perp_dot(down).abs().sqrt());
        Ok(side.filter(|side| side.is_normal()))
    }

    /// Lengths of a pixel along columns and rows at the raster's centre, metres of `crs`; `None` likewise.
    pub fn pixel_sides(&self, crs: &Crs) -> Result<Option<(f64, f64)>> {
        Ok(self.pixel_axes(crs)?.map(|(across, down)| (across.length(), down.length())))
    }

    /// Ways from the raster's centre one column and one row on, metres of `crs`.
    fn pixel_axes(&self, crs: &Crs) -> Result<Option<(DVec2, DVec2)>> {
        let world = Transform::new(&self.crs, crs)?;
        let Size { width, height } = self.samples.size();
        let (column, row) = (0.5 * f64::from(width), 0.5 * f64::from(height));
        let at = |column: f64, row: f64| {
            let (x, y) = warp::apply(&self.geo, column, row);
            world.apply(x, y).map(|(x, y)| DVec2::new(x, y))
        };
        let (here, east, south) = (at(column, row), at(column + 1.0, row), at(column, row + 1.0));
        Ok(here.zip(east).zip(south).map(|((here, east), south)| (east - here, south - here)))
    }

    /// Bounds of the raster's area in another system, from a lattice of points.
    pub fn footprint(&self, crs: &Crs) -> Result<RasterFootprint> {
        const LATTICE: u32 = 64;

        let world = Transform::new(&self.crs, crs)?;
        let Size { width, height } = self.samples.size();
        let part = |step: u32, size: u32| f64::from(size) * f64::from(step) / f64::from(LATTICE);
        let (mut bounds, mut whole): (Option<Bounds>, bool) = (None, true);

        for (i, j) in (0..=LATTICE).flat_map(|j| (0..=LATTICE).map(move |i| (i, j))) {
            let (x, mut y) = warp::apply(&self.geo, part(i, width), part(j, height));
            if self.crs.is_geographic() {
                // Rasters of points reach half a pixel beyond the poles.
                y = y.clamp(-90.0, 90.0);
            }
            match world.apply(x, y) {
                None => whole = false,
                Some((x, y)) => bounds = Some(joined(bounds.unwrap_or([x, y, x, y]), [x, y, x, y])),
            }
        }

        Ok(match bounds {
            None => RasterFootprint::Nowhere,
            Some(bounds) if whole => RasterFootprint::Whole(bounds),
            Some(bounds) => RasterFootprint::Partial(bounds),
        })
    }

    /// Longitudes and latitudes (WGS 84) of the raster's area; longitudes run on beyond 180 where it crosses that meridian. `None`: it has
    /// no place on Earth.
    fn on_earth(&self) -> Result<Option<Bounds>> {
        const LATTICE: u32 = 64;

        let world = Transform::new(&self.crs, &Crs::wgs84())?;
        let Size { width, height } = self.samples.size();
        let part = |step: u32, size: u32| f64::from(size) * f64::from(step) / f64::from(LATTICE);
        let mut bounds: Option<Bounds> = None;

        // The longitude that the next one lies nearest to: that beside it, or below it.
        let (mut before, mut first): (Option<f64>, Option<f64>) = (None, None);
        for (i, j) in (0..=LATTICE).flat_map(|j| (0..=LATTICE).map(move |i| (i, j))) {
            let (x, mut y) = warp::apply(&self.geo, part(i, width), part(j, height));
            if self.crs.is_geographic() {
                y = y.clamp(-90.0, 90.0);
            }
            if i == 0 {
                before = first.take().or(before);
            }

            let Some((x, y)) = world.apply(x, y) else { continue };
            let x = before.map_or(x, |before| x - ((x - before) / 360.0).round() * 360.0);
            before = Some(x);
            first = first.or(before);
            bounds = Some(joined(bounds.unwrap_or([x, y, x, y]), [x, y, x, y]));
        }

        Ok(bounds)
    }

    /// Returns the database's record of it.
    pub fn record(&self, role: &str) -> SourceRecord {
        SourceRecord { file: file_name(&self.path), role: role.into(), description: self.description.clone() }
    }
}

/// West, south, east, north.
pub(super) type Bounds = [f64; 4];

/// Bounds of a raster's area in another system.
pub(super) enum RasterFootprint {
    /// All of it has a place there.
    Whole(Bounds),
    /// Some of it has none.
    Partial(Bounds),
    /// None of it has.
    Nowhere,
}

/// Longitudes and latitudes (WGS 84) of all rasters together: of all that hold them the shortest arc, east beyond 180 where it crosses that
/// meridian. `None`: none has a place on Earth.
pub(super) fn on_earth<T>(rasters: &[Opened<T>]) -> Result<Option<Bounds>> {
    let own = rasters.iter().map(Opened::on_earth).collect::<Result<Vec<_>>>()?;
    let own: Vec<Bounds> = own.into_iter().flatten().collect();
    let (west, east) = shortest_arc(own.iter().map(|own| (own[0], own[2])).collect());
    Ok(own.into_iter().reduce(joined).map(|[_, south, _, north]| [west, south, east, north]))
}

/// The shortest arc that holds all others, degrees from west to east: all of the circle but the widest gap.
fn shortest_arc(mut arcs: Vec<(f64, f64)>) -> (f64, f64) {
    const WHOLE: (f64, f64) = (-180.0, 180.0);
    for (west, east) in &mut arcs {
        let turn = ((*west + 180.0) / 360.0).floor() * 360.0;
        (*west, *east) = (*west - turn, *east - turn);
    }
    arcs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((first, _)) = arcs.first().copied() else { return WHOLE };
    let again = arcs.iter().map(|(west, east)| (west + 360.0, east + 360.0));
    let (mut reached, mut widest) = (f64::NEG_INFINITY, (0.0, WHOLE));
    for (west, east) in arcs.iter().copied().chain(again) {
        // What lies behind the gap goes on until it, once around.
        if reached > first && west - reached > widest.0 {
            widest = (west - reached, (west, reached + 360.0));
        }
        reached = reached.max(east);
    }
    let (_, (west, east)) = widest;
    if west >= 180.0 { (west - 360.0, east - 360.0) } else { (west, east) }
}

/// Bounds of two areas together.
pub(super) fn joined(a: Bounds, b: Bounds) -> Bounds {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

#[cfg(test)]
mod tests {
    use super::shortest_arc;

    #[test]
    fn arcs_are_joined_the_short_way_round() {
        for (arcs, wanted) in [
            (vec![(9.0, 10.0)], (9.0, 10.0)),
            (vec![(9.0, 10.0), (11.0, 12.0)], (9.0, 12.0)),
            // Both sides of the 180th meridian, in either order, and one that crosses it by itself.
            (vec![(179.0, 180.0), (-180.0, -179.0)], (179.0, 181.0)),
            (vec![(-180.0, -179.0), (179.0, 180.0)], (179.0, 181.0)),
            (vec![(179.0, 181.0), (-178.0, -177.0)], (179.0, 183.0)),
            (vec![(359.0, 361.0), (1.5, 2.0)], (-1.0, 2.0)),
            (vec![(138.0, 139.0), (-122.0, -121.0)], (138.0, 239.0)),
            // Within another one.
            (vec![(-10.0, 50.0), (0.0, 1.0), (60.0, 61.0)], (-10.0, 61.0)),
            (vec![(-180.0, 180.0)], (-180.0, 180.0)),
            (vec![(0.0, 360.0), (5.0, 6.0)], (-180.0, 180.0)),
            (vec![(-180.0, 0.0), (0.0, 180.0)], (-180.0, 180.0)),
            (vec![], (-180.0, 180.0)),
        ] {
            assert_eq!(shortest_arc(arcs.clone()), wanted, "{arcs:?}");
        }
    }
}
