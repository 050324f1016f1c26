//! Shifts of a datum to WGS 84, each with the area where it holds.
//!
//! A datum seldom has one shift: that of ED50 differs by dozens of metres between Norway and Cyprus. The tables list them
//! as PROJ orders them, and the one is taken that PROJ takes (proj_trans, PROJ 9.5):
//!
//! ```text
//! the first whose area holds the place,
//! a later one in its stead if it is more exact, or as exact and of a smaller area, and not made for the sea
//! where no area holds the place, the first of all
//! ```

use std::fmt;

/// West, south, east, north in degrees; west lies beyond east for an area across the 180th meridian.
pub(super) type Degrees = [f64; 4];

/// A shift to WGS 84, and where it holds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shift {
    /// Greatest error of a place, metres; `None` where nobody knows.
    pub accuracy: Option<f64>,
    /// Area in which it holds.
    pub area: Degrees,
    /// PROJ's `+towgs84`: metres, arc seconds, parts per million; `None` where no shift is known, and degrees of the datum are taken for WGS 84's.
    pub towgs84: Option<String>,
    kind: ShiftKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ShiftKind {
    Land,
    /// Made for the sea.
    Offshore,
    /// None is known there: the datum is taken for WGS 84.
    Unknown,
}

/// The shifts of a datum, in PROJ's order.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Shifts {
    list: Vec<Shift>,
}

impl Shifts {
    /// One shift for all places.
    pub(super) fn everywhere(towgs84: &str) -> Self {
        let shift = Shift {
            accuracy: None,
            area: [-180.0, -90.0, 180.0, 90.0],
            towgs84: Some(towgs84.to_owned()),
            kind: ShiftKind::Land,
        };
        Self { list: vec![shift] }
    }

    /// Reads a field of the table: `accuracy,west,south,east,north,dx,dy,…;~…;?…|…`. What stands after the bar is for
    /// those alone that choose by `order`, indices of all.
    pub(super) fn read(field: &str, order: Option<&str>) -> Option<Self> {
        let own = field.split('|').next().unwrap_or_default();
        let entries = |text: &str| {
            let entries = text.split([';', '|']).filter(|entry| !entry.is_empty());
            entries.map(Shift::read).collect::<Option<Vec<_>>>()
        };
        let Some(order) = order else { return Some(Self { list: entries(own)? }) };
        let all = entries(field)?;
        let chosen = order.split(',').map(|index| all.get(index.parse::<usize>().ok()?).cloned());
        Some(Self { list: chosen.collect::<Option<_>>()? })
    }

    /// Takes a shift where none is known.
    pub(super) fn take_unknown_for(&mut self, towgs84: &str) {
        for shift in self.list.iter_mut().filter(|shift| shift.is_unknown()) {
            shift.towgs84 = Some(towgs84.to_owned());
        }
    }

    pub(super) fn list(&self) -> &[Shift] {
        &self.list
    }

    /// The shift at a place, degrees; `None` if there is none at all.
    pub(super) fn at(&self, longitude: f64, latitude: f64) -> Option<&Shift> {
        let index = self.choose(|index| contains(self.list[index].area, longitude, latitude));
        self.list.get(index)
    }

    /// The index of the shift that is taken where some of them hold; 0 where none does.
    pub(super) fn choose(&self, holds: impl Fn(usize) -> bool) -> usize {
        let mut best: Option<&Shift> = None;
        let mut chosen = 0;
        for (index, shift) in self.list.iter().enumerate().filter(|(index, _)| holds(*index)) {
            if best.is_none_or(|best| shift.is_better_than(best)) {
                (best, chosen) = (Some(shift), index);
            }
        }
        chosen
    }

    /// The shift where no area holds the place.
    pub(super) fn elsewhere(&self) -> Option<&Shift> {
        self.list.first()
    }
}

impl Shift {
    /// Reads one of the table.
    fn read(entry: &str) -> Option<Self> {
        let kind = match entry.as_bytes().first()? {
            b'~' => ShiftKind::Offshore,
            b'?' => ShiftKind::Unknown,
            _ => ShiftKind::Land,
        };
        let mut parts = entry.trim_start_matches(['~', '?']).splitn(6, ',');
        let mut number = || parts.next()?.parse::<f64>().ok();
        let accuracy = Some(number()?).filter(|metres| *metres >= 0.0);
        let area = [number()?, number()?, number()?, number()?];
        let towgs84 = Some(parts.next()?.to_owned()).filter(|_| kind != ShiftKind::Unknown);
        Some(Self { accuracy, area, towgs84, kind })
    }

    /// No shift is known in its area, and the datum is taken for WGS 84.
    pub(super) fn is_unknown(&self) -> bool {
        self.kind == ShiftKind::Unknown
    }

    fn is_better_than(&self, other: &Self) -> bool {
        let Some(accuracy) = self.accuracy.filter(|_| self.kind != ShiftKind::Offshore) else { return false };
        other.accuracy.is_some_and(|others| {
            accuracy < others || accuracy == others && extent(self.area) < extent(other.area)
        })
    }
}

/// A measure of an area, as large on a sphere.
fn extent([west, south, east, north]: Degrees) -> f64 {
    let width = if east < west { east - west + 360.0 } else { east - west };
    width * (north.to_radians().sin() - south.to_radians().sin())
}

impl fmt::Display for Shift {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.towgs84 {
            Some(towgs84) => write!(formatter, "+towgs84={towgs84}"),
            None => formatter.write_str("none"),
        }
    }
}

/// Whether an area holds a place, degrees. Longitudes may run on beyond ±180.
pub(super) fn contains([west, south, east, north]: Degrees, longitude: f64, latitude: f64) -> bool {
    let longitude = longitude - ((longitude + 180.0) / 360.0).floor() * 360.0;
    let within = if west <= east {
        (west..=east).contains(&longitude)
    } else {
        longitude >= west || longitude <= east
    };
    within && (south..=north).contains(&latitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_take_the_most_exact_shift_that_holds_there() {
        let field = "2,-10,40,10,50,1,2,3;9,170,-20,-170,0,4,5,6,7,8,9,10;1,0,40,5,50,7,7,7;~0.5,0,40,5,50,8,8,8;?-1,60,0,80,10,0,0,0";
        let shifts = Shifts::read(field, None).unwrap();
        let at = |longitude, latitude| shifts.at(longitude, latitude).unwrap().towgs84.as_deref();
        assert_eq!(at(-5.0, 45.0), Some("1,2,3"));
        assert_eq!(at(355.0, 45.0), Some("1,2,3"));
        assert_eq!(at(3.0, 45.0), Some("7,7,7"));
        assert_eq!(at(179.0, -10.0), Some("4,5,6,7,8,9,10"));
        assert_eq!(at(-179.0, -10.0), Some("4,5,6,7,8,9,10"));
        assert_eq!(at(100.0, 0.0), Some("1,2,3"));
        assert_eq!(at(70.0, 5.0), None);
        assert!(Shifts::read("2,-10,40,10", None).is_none());
        assert!(Shifts::default().at(0.0, 0.0).is_none());
    }

    #[test]
    fn maps_have_an_order_of_their_own() {
        let field = "2,-10,40,10,50,1,2,3|2,-10,40,10,50,4,5,6";
        let at = |order| {
            Shifts::read(field, order).map(|shifts| shifts.at(0.0, 45.0).unwrap().towgs84.clone().unwrap())
        };
        assert_eq!(at(None).unwrap(), "1,2,3");
        assert_eq!(at(Some("1,0")).unwrap(), "4,5,6");
        assert!(at(Some("2")).is_none());
    }
}
