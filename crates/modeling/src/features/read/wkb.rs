//! Well-known binary: OGC 06-103r4 (*Simple Feature Access*, 2011, §8), as GeoPackages hold it.
//!
//! ```text
//! geometry = byte order, type u32, body;   type = kind + 1000 (Z) | + 2000 (M) | + 3000 (Z and M), or flags in its upper bits
//! ```

use glam::dvec2;

use super::super::layer::{Geometry, Path};
use super::bytes::{Bytes, Order};
use super::rings;

/// Deepest collections within collections.
const DEEPEST: u32 = 16;

/// The geometry of all bytes.
pub(super) fn geometry(bytes: &[u8]) -> Result<Geometry, String> {
    let mut geometry = Geometry::default();
    add(&mut Bytes::of(bytes), &mut geometry, DEEPEST)?;
    Ok(geometry)
}

fn cut() -> String {
    "its geometry is cut off".to_owned()
}

fn add(rest: &mut Bytes<'_>, geometry: &mut Geometry, depth: u32) -> Result<(), String> {
    let order = match rest.u8() {
        Some(0) => Order::Big,
        Some(1) => Order::Little,
        Some(_) => return Err("its geometry has a byte order that is none".to_owned()),
        None => return Err(cut()),
    };
    let (kind, reader) = Reader::of(rest.u32(order).ok_or_else(cut)?, order);

    match kind {
        1 => {
            let point = reader.places(rest, 1)?;
            // A point without a place is one of NaN.
            if point.places.iter().all(|place| place.is_finite()) {
                geometry.absorb(Geometry { points: point, ..Geometry::default() });
            }
        }
        2 => geometry.lines.extend(reader.path(rest)?.line()),
        3 => {
            let count = rest.count(order, 4).ok_or_else(cut)?;
            let found = (0..count).map(|_| reader.path(rest)).collect::<Result<Vec<_>, _>>()?;
            geometry.areas.extend(rings::areas(found));
        }
        4..=7 => {
            let depth = depth.checked_sub(1).ok_or("its geometry is nested too deeply")?;
            for _ in 0..rest.count(order, 5).ok_or_else(cut)? {
                add(rest, geometry, depth)?;
            }
        }
        8..=17 => {
            return Err(
                "its geometry has arcs or surfaces, which are not read here (ogr2ogr -nlt CONVERT_TO_LINEAR)"
                    .to_owned(),
            );
        }
        _ => return Err("its geometry has a type that is none".to_owned()),
    }

    Ok(())
}

/// Notation of places in one geometry.
struct Reader {
    order: Order,
    has_z: bool,
    numbers: usize,
}

impl Reader {
    /// Kind of geometry, and how its places are written.
    fn of(code: u32, order: Order) -> (u32, Self) {
        let (flags, code) = (code >> 28, code & 0x0fff_ffff);
        let (kind, variant) = (code % 1000, code / 1000);
        let has_z = flags & 8 != 0 || variant == 1 || variant == 3;
        let has_m = flags & 4 != 0 || variant == 2 || variant == 3;
        let kind = if variant > 3 { u32::MAX } else { kind };
        (kind, Self { order, has_z, numbers: 2 + usize::from(has_z) + usize::from(has_m) })
    }

    fn path(&self, rest: &mut Bytes<'_>) -> Result<Path, String> {
        let count = rest.count(self.order, 8 * self.numbers).ok_or_else(cut)?;
        let path = self.places(rest, count)?;
        let is_sound = path.places.iter().all(|place| place.is_finite());
        if is_sound { Ok(path) } else { Err("a coordinate of it is no finite number".to_owned()) }
    }

    fn places(&self, rest: &mut Bytes<'_>, count: usize) -> Result<Path, String> {
        let taken =
            count.checked_mul(8 * self.numbers).and_then(|length| rest.take(length)).ok_or_else(cut)?;
        let mut path = Path::default();
        for place in taken.chunks_exact(8 * self.numbers) {
            let mut numbers = Bytes::of(place);
            let mut next = || numbers.f64(self.order).ok_or_else(cut);
            path.places.push(dvec2(next()?, next()?));
            if self.has_z {
                path.heights.push(next()?);
            }
        }
        if path.heights.iter().any(|height| !height.is_finite()) {
            path.heights.clear();
        }
        Ok(path)
    }
}
