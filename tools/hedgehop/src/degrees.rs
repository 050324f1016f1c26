//! Longitude and latitude of a database.

use glam::DVec2;

use crate::reference;
use hedgehop::Result;
use hedgehop::geo::{Crs, Transform};
use hedgehop::voxel::Header;

/// Points along each edge of the area; edges of projected areas bend.
const EDGE_POINTS: u32 = 33;
/// Steps of a search for the end of a system's domain.
const STEPS: u32 = 40;

/// West, south, east and north of the area, degrees (WGS 84), west above east where it crosses the 180th meridian; `None` for areas without
/// a place on Earth.
pub fn lonlat_bounds(header: &Header) -> Result<Option<[f64; 4]>> {
    let crs = reference::crs(header)?;
    if crs.is_local() {
        return Ok(None);
    }
    let corners = [header.grid.origin, header.grid.far_corner()];
    let to_degrees = Transform::new(&crs, &Crs::wgs84())?;
    let from_degrees = Transform::new(&Crs::wgs84(), &crs)?;
    Ok(bounds(corners, &|at| to_degrees.apply(at.x, at.y), &|at| from_degrees.apply(at.x, at.y)))
}

/// A transform between places.
type Map<'m> = &'m dyn Fn(DVec2) -> Option<(f64, f64)>;

fn bounds([near, far]: [DVec2; 2], to_degrees: Map<'_>, from_degrees: Map<'_>) -> Option<[f64; 4]> {
    let middle = 0.5 * (near + far);
    let (centre, _) = to_degrees(middle)?;

    // The last voxels of the whole Earth reach beyond it: the farthest place on the way there counts.
    let seen = |place: DVec2| {
        to_degrees(place).or_else(|| {
            let on_the_way = |part: f64| to_degrees(middle + (place - middle) * part);
            let (mut inside, mut outside) = (0.0, 1.0);
            for _ in 0..STEPS {
                let half = 0.5 * (inside + outside);
                if on_the_way(half).is_some() { inside = half } else { outside = half }
            }
            on_the_way(inside)
        })
    };

    let steps = (0..EDGE_POINTS).map(|i| f64::from(i) / f64::from(EDGE_POINTS - 1));
    let edges = steps.flat_map(|t| [(t, 0.0), (t, 1.0), (0.0, t), (1.0, t)]);
    let places = edges.filter_map(|(u, v)| seen(near + (far - near) * DVec2::new(u, v)));
    let nearest = |longitude: f64| longitude - ((longitude - centre) / 360.0).round() * 360.0;
    let found =
        places.map(|(longitude, latitude)| [nearest(longitude), latitude, nearest(longitude), latitude]);
    let [mut west, mut south, mut east, mut north] =
        found.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])?;

    // A pole inside is on no edge, and all meridians meet there.
    for pole in [-90.0, 90.0] {
        let at = |longitude: f64| from_degrees(DVec2::new(longitude, pole)).map(DVec2::from);
        let Some((there, aside)) = at(centre).zip(at(centre + 90.0)) else { continue };
        if there.cmpge(near).all() && there.cmple(far).all() {
            (south, north) = (south.min(pole), north.max(pole));
            // In cylindrical systems it is an edge.
            if there.distance(aside) < 1.0 {
                (west, east) = (-180.0, 180.0);
            }
        }
    }

    let wrapped = |longitude: f64| {
        if longitude.abs() > 180.0 { longitude - longitude.signum() * 360.0 } else { longitude }
    };

    Some(if east - west >= 359.9 {
        [-180.0, south, 180.0, north]
    } else {
        [wrapped(west), south, wrapped(east), north]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(code: u32, corners: [f64; 4]) -> [f64; 4] {
        let crs = Crs::from_epsg(code).unwrap();
        let [to, from] = [Transform::new(&crs, &Crs::wgs84()), Transform::new(&Crs::wgs84(), &crs)]
            .map(|map| map.unwrap());
        let [west, south, east, north] = corners;
        let corners = [DVec2::new(west, south), DVec2::new(east, north)];
        bounds(corners, &|at| to.apply(at.x, at.y), &|at| from.apply(at.x, at.y)).unwrap()
    }

    #[test]
    fn the_whole_earth_reaches_from_pole_to_pole() {
        // As voxels of 30 km cover it, in part beyond its edges.
        let found = area(4087, [-20_040_000.0, -10_020_000.0, 20_040_000.0, 10_020_000.0]);
        assert!((found[1] + 90.0).abs() < 1e-3 && (found[3] - 90.0).abs() < 1e-3, "{found:?}");
        assert_eq!((found[0], found[2]), (-180.0, 180.0));
    }

    #[test]
    fn areas_across_180_and_about_a_pole() {
        let [west, south, east, north] = area(32760, [712_000.0, 8_110_000.0, 920_000.0, 8_230_000.0]);
        assert!((178.9..179.1).contains(&west) && (-179.2..-178.9).contains(&east), "{west} {east}");
        assert!((-17.2..-16.9).contains(&south) && (-16.1..-15.8).contains(&north), "{south} {north}");
        let [west, south, east, north] = area(32661, [1.5e6, 1.5e6, 2.5e6, 2.5e6]);
        assert!(
            (west, east) == (-180.0, 180.0)
                && (89.99..=90.0).contains(&north)
                && (80.0..86.0).contains(&south)
        );
    }
}
