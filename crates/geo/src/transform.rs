//! Transformations from one horizontal system to another.
//!
//! [`proj4rs`] works in radians, and knows neither identity nor a domain, nor shifts to WGS 84 that differ from place
//! to place; they are added here.

use proj4rs::Proj;

use super::crs::Crs;
use super::definition::Definition;
use super::shift::{Degrees, Shift, Shifts, contains};
use hedgehop_base::error::{Error, Result};

/// Angle by which a latitude may pass the pole by rounding, degrees (0.1 mm).
const POLE_SLACK: f64 = 1e-9;

/// Step along the meridian from which the direction of north is taken, degrees of latitude (about 11 m).
const NORTH_STEP: f64 = 1e-4;

/// WGS 84 for [`proj4rs`].
const WGS84: &str = "+proj=longlat +datum=WGS84";

/// Takes positions from one system to another.
#[derive(Debug)]
pub struct Transform {
    /// `None` where positions pass unchanged.
    systems: Option<Box<Systems>>,
    /// Longitude within 180° of which geographic results shall lie.
    centre: Option<f64>,
}

#[derive(Debug)]
struct Systems {
    from: Side,
    to: Side,
    wgs84: Proj,
}

/// A system as it is computed.
#[derive(Debug)]
struct Side {
    /// Projection, with the shift of places that no area of `shifts` holds.
    proj: Proj,
    degrees: bool,
    /// Longitude of the prime meridian, radians.
    meridian: f64,
    /// Shift of the datum to WGS 84 where it differs from place to place.
    shifting: Option<Shifting>,
}

/// Shifts by place.
#[derive(Debug)]
struct Shifting {
    shifts: Shifts,
    /// The system with each of them.
    projs: Vec<Proj>,
    /// The area of each on the map, in its units: boxes of least x and y, greatest x and y, two for an area
    /// across the 180th meridian. As PROJ has it, a place on a map belongs to an area that is so bounded.
    own_areas: Vec<Vec<[f64; 4]>>,
}

impl Side {
    fn new(crs: &Crs) -> Result<Self> {
        let definition = crs.definition().ok_or_else(|| {
            Error::Configuration(format!(
                "'{}' is not placed on Earth; give its reference system with --crs",
                crs.name()
            ))
        })?;
        let proj = definition.load().map_err(Error::Configuration)?;
        let shifting = Shifting::new(crs, definition).map_err(Error::Configuration)?;
        let meridian = definition.meridian().map_err(Error::Configuration)?;
        Ok(Self { proj, degrees: definition.is_geographic(), meridian, shifting })
    }

    /// The system as it is computed at a place of its own, in its units or radians.
    fn at_own(&self, x: f64, y: f64) -> &Proj {
        self.shifting.as_ref().map_or(&self.proj, |shifting| &shifting.projs[self.index_at(shifting, x, y)])
    }

    /// The index of the shift at such a place.
    fn index_at(&self, shifting: &Shifting, x: f64, y: f64) -> usize {
        if self.degrees {
            return shifting.at(x + self.meridian, y);
        }
        let holds = |&[west, south, east, north]: &[f64; 4]| {
            (west..=east).contains(&x) && (south..=north).contains(&y)
        };
        shifting.shifts.choose(|index| shifting.own_areas[index].iter().any(holds))
    }

    /// The system as it is computed at a place of another system.
    fn at_other(&self, from: &Proj, wgs84: &Proj, x: f64, y: f64) -> &Proj {
        let Some(shifting) = &self.shifting else { return &self.proj };
        let mut place = (x, y, 0.0);
        match proj4rs::transform::transform(from, wgs84, &mut place) {
            Ok(()) => &shifting.projs[shifting.at(place.0, place.1)],
            Err(_) => &self.proj,
        }
    }
}

impl Shifting {
    fn new(crs: &Crs, definition: &Definition) -> Result<Option<Self>, String> {
        if crs.shifts().list().is_empty() {
            return Ok(None);
        }

        let shifts = crs.shifts().clone();
        let degrees = definition.own_degrees()?;
        let map = definition.load()?;
        let proj = |shift: &Shift| definition.with_shift(shift.towgs84.as_deref()).load();
        let projs = shifts.list().iter().map(proj).collect::<Result<_, String>>()?;

        let boxes = |shift: &Shift| {
            if shift.is_unknown() {
                return vec![[f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY]];
            }
            let [west, south, east, north] = shift.area;
            let halves = if east < west { vec![(west, 180.0), (-180.0, east)] } else { vec![(west, east)] };
            halves
                .into_iter()
                .map(|(west, east)| bounds_of([west, south, east, north], &degrees, &map))
                .collect()
        };

        let own_areas = shifts.list().iter().map(boxes).collect();
        Ok(Some(Self { shifts, projs, own_areas }))
    }

    /// The index of the shift at a place in radians.
    fn at(&self, longitude: f64, latitude: f64) -> usize {
        let (longitude, latitude) = (longitude.to_degrees(), latitude.to_degrees());
        self.shifts.choose(|index| contains(self.shifts.list()[index].area, longitude, latitude))
    }
}

impl Crs {
    /// A sentence about how well places within bounds (west, south, east, north in its own coordinates) are known, where that is worth one.
    pub fn doubt(&self, [west, south, east, north]: [f64; 4]) -> Option<String> {
        let middle = [west.midpoint(east), south.midpoint(north)];
        let places = [middle, [west, south], [east, south], [west, north], [east, north]];
        if !is_beyond_shifts(self, &places) {
            return self.doubt.clone();
        }
        Some(format!(
            "for this area no shift of {} to WGS 84 is known: its places are taken as those of WGS 84, and may be hundreds of metres off beside other data \
             (give the shift with +towgs84=dx,dy,dz in a PROJ definition)",
            self.name
        ))
    }
}

/// Whether the datum of a system has shifts to WGS 84, but none is known at one of some places in the system's own coordinates.
fn is_beyond_shifts(crs: &Crs, places: &[[f64; 2]]) -> bool {
    let Ok(side) = Side::new(crs) else { return false };
    let Some(shifting) = &side.shifting else { return false };
    let is_unknown = |place: &[f64; 2]| {
        let [x, y] = if side.degrees { place.map(f64::to_radians) } else { *place };
        shifting.shifts.list()[side.index_at(shifting, x, y)].is_unknown()
    };
    places.iter().any(is_unknown)
}

/// Bounds of an area on a map, from the places of its rim that the map has, 20 steps a side as PROJ takes them.
fn bounds_of([west, south, east, north]: Degrees, degrees: &Proj, map: &Proj) -> [f64; 4] {
    const STEPS: u32 = 20;
    let part = |low: f64, high: f64, step: u32| low + (high - low) * f64::from(step) / f64::from(STEPS);
    let rim = (0..=STEPS).flat_map(|step| {
        let (x, y) = (part(west, east, step), part(south, north, step));
        [(x, south), (x, north), (west, y), (east, y)]
    });

    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for (longitude, latitude) in rim {
        let mut place = (longitude.to_radians(), latitude.to_radians(), 0.0);
        let is_there = proj4rs::transform::transform(degrees, map, &mut place).is_ok();
        if is_there && place.0.is_finite() && place.1.is_finite() {
            let [low_x, low_y, high_x, high_y] = bounds;
            bounds = [low_x.min(place.0), low_y.min(place.1), high_x.max(place.0), high_y.max(place.1)];
        }
    }
    bounds
}

impl Transform {
    /// Builds the transformation from `from` to `to`; an error if one of them is local and the other not.
    pub fn new(from: &Crs, to: &Crs) -> Result<Self> {
        if from.is_local() != to.is_local() {
            let placed = if from.is_local() { to } else { from };
            return Err(Error::Configuration(format!(
                "local coordinates have no place in {}; give the reference system with --crs, or take all inputs as plain metres with --local",
                placed.name()
            )));
        }
        if from.is_same(to) {
            return Ok(Self { systems: None, centre: None });
        }
        let wgs84 = Proj::from_proj_string(WGS84)
            .map_err(|error| Error::Configuration(format!("'{WGS84}': {error}")))?;
        let systems = Systems { from: Side::new(from)?, to: Side::new(to)?, wgs84 };
        Ok(Self { systems: Some(Box::new(systems)), centre: None })
    }

    /// Puts geographic results within 180° of `longitude` (degrees), for a raster whose longitudes run from 0
    /// to 360 or across the 180th meridian. Without effect if the target is not geographic.
    pub fn centred_on(mut self, longitude: f64) -> Self {
        let geographic = self.systems.as_ref().is_some_and(|systems| systems.to.degrees);
        self.centre = (geographic && longitude.is_finite()).then_some(longitude);
        self
    }

    /// The position in the target system, or `None` where there is none (outside the projection's domain).
    /// Longitude and latitude in degrees. Never NaN, never infinite. Between equivalent systems every finite
    /// position passes unchanged, be it on Earth or not.
    pub fn apply(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        if !(x.is_finite() && y.is_finite()) {
            return None;
        }

        let Some(systems) = &self.systems else { return Some((x, y)) };
        let (x, y) = if systems.from.degrees { (x.to_radians(), on_earth(y)?.to_radians()) } else { (x, y) };
        let from = systems.from.at_own(x, y);
        let to = systems.to.at_other(from, &systems.wgs84, x, y);
        let mut point = (x, y, 0.0);
        proj4rs::transform::transform(from, to, &mut point).ok()?;
        let (mut x, mut y, _) = point;

        if systems.to.degrees {
            (x, y) = (x.to_degrees(), on_earth(y.to_degrees())?);
            if let Some(centre) = self.centre {
                x -= ((x - centre) / 360.0).round() * 360.0;
            }
        }

        (x.is_finite() && y.is_finite()).then_some((x, y))
    }

    /// Transforms many positions in place; one that has none in the target becomes NaN, NaN.
    pub fn apply_many(&self, points: &mut [[f64; 2]]) {
        for point in points {
            *point = self.apply(point[0], point[1]).map_or([f64::NAN; 2], Into::into);
        }
    }

    /// Whether both systems are the same, so that positions pass unchanged.
    pub fn is_identity(&self) -> bool {
        self.systems.is_none()
    }
}

/// A latitude in degrees within ±90, or `None` beyond (NaN too).
fn on_earth(latitude: f64) -> Option<f64> {
    (latitude.abs() <= 90.0 + POLE_SLACK).then(|| latitude.clamp(-90.0, 90.0))
}

/// Degrees to add to a heading from true north, so that it counts from the grid's north, at a position of
/// `crs`. 0 for local and geographic systems, and where the position is none on Earth.
pub fn grid_convergence(crs: &Crs, x: f64, y: f64) -> f64 {
    GridNorth::new(crs).map_or(0.0, |north| north.convergence(x, y))
}

/// [`grid_convergence`] for many positions of one system.
#[derive(Debug)]
pub struct GridNorth {
    /// Transformations to and from WGS 84; `None` where true north is grid north everywhere.
    transforms: Option<(Transform, Transform)>,
}

impl GridNorth {
    /// Builds the grid north of a system; an error if it cannot be computed.
    pub fn new(crs: &Crs) -> Result<Self> {
        if crs.is_local() || crs.is_geographic() {
            return Ok(Self { transforms: None });
        }
        let wgs84 = Crs::wgs84();
        Ok(Self { transforms: Some((Transform::new(crs, &wgs84)?, Transform::new(&wgs84, crs)?)) })
    }

    /// Degrees to add to a heading from true north at a position, −180 to 180.
    pub fn convergence(&self, x: f64, y: f64) -> f64 {
        let Some((to_geographic, from_geographic)) = &self.transforms else { return 0.0 };
        let Some((longitude, latitude)) = to_geographic.apply(x, y) else { return 0.0 };
        // Towards the pole that is farther away, so that the step never crosses one.
        let step = if latitude > 0.0 { -NORTH_STEP } else { NORTH_STEP };
        let ends =
            from_geographic.apply(longitude, latitude).zip(from_geographic.apply(longitude, latitude + step));
        let Some(((x0, y0), (x1, y1))) = ends else { return 0.0 };
        let sign = step.signum();
        let (east, north) = (sign * (x1 - x0), sign * (y1 - y0));
        east.atan2(north).to_degrees()
    }
}
