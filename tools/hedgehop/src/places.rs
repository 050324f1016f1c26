//! Places of a database's area, as commands take and tell them.

use glam::{DVec2, DVec3};

use crate::{area, reference};
use hedgehop::geo::{Crs, Transform};
use hedgehop::voxel::{Header, PageSource};
use hedgehop::{Error, Result};
use hedgehop_query::{Sample, footing};

/// Between what users give and a database's reference system.
pub struct Places<'s> {
    source: &'s dyn PageSource,
    /// Transformations to the system, and from it, in degrees; `None`: the area has no place on Earth.
    degrees: Option<[Transform; 2]>,
    /// Places are given and named in metres of the system.
    in_metres: bool,
}

/// Numbers below it are told digit by digit.
const MANY_DIGITS: f64 = 1.0e9;

/// A number as it was given, in short.
fn short(number: f64) -> String {
    if number.abs() < MANY_DIGITS { number.to_string() } else { format!("{number:e}") }
}

impl<'s> Places<'s> {
    /// Places are longitude and latitude, degrees (WGS 84), unless `xy` or the area has no place on Earth.
    pub fn new(source: &'s dyn PageSource, xy: bool) -> Result<Self> {
        let crs = reference::crs(source.header())?;
        let wgs84 = Crs::wgs84();
        let degrees = (!crs.is_local())
            .then(|| Ok::<_, Error>([Transform::new(&wgs84, &crs)?, Transform::new(&crs, &wgs84)?]))
            .transpose()?;
        let in_metres = xy || degrees.is_none();
        Ok(Self { source, degrees, in_metres })
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
            Some([into, _]) if !self.in_metres => into.apply(x, y).map(DVec2::from),
            _ => Some(DVec2::new(x, y)),
        };
        let found = place.filter(|place| self.header().grid.contains(*place));
        found.ok_or_else(|| {
            let extents = area::extents(self.header()).unwrap_or_default();
            let advice = match (self.in_metres, x.abs() > 180.0 || y.abs() > 90.0) {
                (false, true) => "; longitude and latitude are wanted, or --xy for metres",
                (true, false) if self.degrees.is_some() => {
                    "; metres of its reference system are wanted, or without --xy longitude and latitude"
                }
                _ => "",
            };
            let [x, y] = [x, y].map(short);
            Error::Configuration(format!("{x} {y} lies outside the area, {extents}{advice}"))
        })
    }

    /// A point at a height above the ground or the roof there, or with `msl` above the database's datum, metres.
    ///
    /// # Errors
    /// A place outside of the area, or without ground below it if that is asked for; a page that is damaged.
    pub fn point(&self, [x, y, height]: [f64; 3], msl: bool) -> Result<DVec3> {
        let place = self.find([x, y])?;
        if msl {
            return Ok(place.extend(height));
        }
        let ground = footing(self.source, place)?;
        let ground = ground.ok_or_else(|| {
            let what = format!("there is no ground at {x} {y}, a gap of the data, to be {height} m above; give heights above the datum with --msl");
            Error::Configuration(what)
        })?;
        Ok(place.extend(ground + height))
    }

    /// Longitude and latitude of a place, degrees, if it has some.
    pub fn lonlat(&self, place: DVec2) -> Option<[f64; 2]> {
        let [_, from] = self.degrees.as_ref()?;
        from.apply(place.x, place.y).map(|(longitude, latitude)| [longitude, latitude])
    }

    /// A place as places are given, in words.
    pub fn name(&self, place: DVec2) -> String {
        match self.lonlat(place).filter(|_| !self.in_metres) {
            Some([longitude, latitude]) => format!("{longitude:.6} {latitude:.6}"),
            None => format!("{:.1} {:.1}", place.x, place.y),
        }
    }

    /// A sample as JSON; without longitude and latitude where it has none.
    pub fn json(&self, sample: &Sample) -> serde_json::Value {
        let mut json = serde_json::json!({
            "distance_m": sample.distance,
            "x_m": sample.place.x,
            "y_m": sample.place.y,
            "height_m": sample.ground,
        });
        if let Some([longitude, latitude]) = self.lonlat(sample.place) {
            json["lon_deg"] = serde_json::json!(longitude);
            json["lat_deg"] = serde_json::json!(latitude);
        }
        json
    }
}
