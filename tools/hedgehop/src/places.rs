//! Places of a database's area, as commands take and tell them.

use glam::{DVec2, DVec3};
use hedgehop::geo::{Crs, Transform};
use hedgehop::query::Sample;
use hedgehop::raymarch::ground_height;
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result};

use crate::area;

/// Between what users give and a database's reference system.
pub struct Places<'s, S> {
    source: &'s S,
    /// To the system, and from it, in degrees; `None`: places are metres of it.
    degrees: Option<[Transform; 2]>,
}

impl<'s, S: PageSource> Places<'s, S> {
    /// Places are longitude and latitude, degrees (WGS 84), unless `xy` or the area has no place on Earth.
    pub fn new(source: &'s S, xy: bool) -> Result<Self> {
        let crs = area::crs(source.header())?;
        let wgs84 = Crs::wgs84();
        let degrees = (!xy && !crs.is_local())
            .then(|| Ok::<_, Error>([Transform::new(&wgs84, &crs)?, Transform::new(&crs, &wgs84)?]))
            .transpose()?;
        Ok(Self { source, degrees })
    }

    fn header(&self) -> &'s Header {
        self.source.header()
    }

    /// A place of the area, metres of its system.
    ///
    /// # Errors
    /// A place outside of it.
    pub fn find(&self, [x, y]: [f64; 2]) -> Result<DVec2> {
        let place = match &self.degrees {
            None => Some(DVec2::new(x, y)),
            Some([into, _]) => into.apply(x, y).map(DVec2::from),
        };
        let found = place.filter(|place| self.header().grid.contains(*place));
        found.ok_or_else(|| {
            let covers = area::extents(self.header()).unwrap_or_default();
            let hint = match (&self.degrees, x.abs() > 180.0 || y.abs() > 90.0) {
                (Some(_), true) => "; longitude and latitude are wanted, or --xy for metres",
                (None, false) if self.header().metadata.crs_proj.is_some() => {
                    "; metres of its reference system are wanted, or without --xy longitude and latitude"
                }
                _ => "",
            };
            Error::Configuration(format!("{x} {y} lies outside the area, {covers}{hint}"))
        })
    }

    /// A point at a height above the ground there, or with `msl` above the database's datum, metres.
    ///
    /// # Errors
    /// A place outside of the area, or without ground below it if that is asked for; a page that is damaged.
    pub fn point(&self, [x, y, height]: [f64; 3], msl: bool) -> Result<DVec3> {
        let place = self.find([x, y])?;
        if msl {
            return Ok(place.extend(height));
        }
        let ground = ground_height(self.source, place)?;
        let ground = ground.ok_or_else(|| {
            let what = format!("there is no ground at {x} {y} to be {height} m above; give heights above the datum with --msl");
            Error::Configuration(what)
        })?;
        Ok(place.extend(ground + height))
    }

    /// Longitude and latitude of a place, degrees, if it has some that were asked for.
    pub fn lonlat(&self, place: DVec2) -> Option<[f64; 2]> {
        let [_, from] = self.degrees.as_ref()?;
        from.apply(place.x, place.y).map(|(longitude, latitude)| [longitude, latitude])
    }

    /// A place as it is given, in words.
    pub fn name(&self, place: DVec2) -> String {
        match self.lonlat(place) {
            Some([longitude, latitude]) => format!("{longitude:.6} {latitude:.6}"),
            None => format!("{:.1} {:.1}", place.x, place.y),
        }
    }

    /// A sample as JSON.
    pub fn json(&self, sample: &Sample) -> serde_json::Value {
        let [longitude, latitude] = self.lonlat(sample.place).map_or([None; 2], |place| place.map(Some));
        serde_json::json!({
            "distance_m": sample.distance,
            "lon_deg": longitude,
            "lat_deg": latitude,
            "x_m": sample.place.x,
            "y_m": sample.place.y,
            "height_m": sample.ground,
        })
    }
}
