//! Shapes of objects and of their parts: which keys say how large each is.

use std::ops::Range;

use glam::{DVec2, DVec3};
use toml::Spanned;

use crate::objects::{Form, Shape};
use crate::scene::object_table::{FormKind, ObjectTable};
use hedgehop_base::document::Reading;
use hedgehop_base::error::{Error, Result};

/// Pixels of the greatest width that a line or a point is to have at least.
const MOST_PIXELS: f64 = 100.0;

/// Metres of the largest object: what is larger is ground.
pub(super) const LARGEST: f64 = 100_000.0;

/// Keys that say how large a shape is.
struct Sizes<'t, 'f> {
    reading: &'t Reading<'f>,
    table: &'t ObjectTable,
    shape: Range<usize>,
    name: &'static str,
}

/// The form of a thing of a given shape.
pub(super) fn form(reading: &Reading<'_>, table: &ObjectTable, given: &Spanned<FormKind>) -> Result<Form> {
    let (kind, shape) = (*given.get_ref(), given.span());
    let sizes = |name| Sizes { reading, table, shape: shape.clone(), name };
    let shape = match kind {
        FormKind::Line => {
            let sizes = sizes("line");
            sizes.takes(&["width_m", "width_px", "to"])?;
            let length = match (&table.to, &table.length_m) {
                // Until both ends are known in the database's reference system.
                (Some(_), None) => 1.0,
                (None, length) => sizes.one("length_m, or to", length)?,
                (Some(_), Some(length)) => {
                    return Err(reading.wrong(length.span(), "give to or length_m, not both"));
                }
            };

            let width = sizes.one("width_m", &table.width_m)?;
            return Ok(Form::Line { length, width, pixels: sizes.pixels("width_px", &table.width_px)? });
        }
        FormKind::Point => {
            let sizes = sizes("point");
            sizes.takes(&["radius_m", "size_px"])?;
            let width = 2.0 * sizes.one("radius_m", &table.radius_m)?;
            return Ok(Form::Point { width, pixels: sizes.pixels("size_px", &table.size_px)? });
        }
        FormKind::Sphere => {
            let sizes = sizes("sphere");
            sizes.takes(&["radius_m"])?;
            Shape::Ellipsoid { radii: DVec3::splat(sizes.one("radius_m", &table.radius_m)?) }
        }
        FormKind::Ellipsoid => {
            let sizes = sizes("ellipsoid");
            sizes.takes(&["radii_m"])?;
            Shape::Ellipsoid { radii: sizes.several("radii_m", &table.radii_m)?.into() }
        }
        FormKind::Box => {
            let sizes = sizes("box");
            sizes.takes(&["size_m"])?;
            Shape::Box { size: sizes.several("size_m", &table.size_m)?.into() }
        }
        FormKind::Cylinder => {
            let sizes = sizes("cylinder");
            sizes.takes(&["radius_m", "height_m"])?;
            let radius = sizes.one("radius_m", &table.radius_m)?;
            Shape::Cylinder { radius, height: sizes.one("height_m", &table.height_m)? }
        }
        FormKind::Cone => {
            let sizes = sizes("cone");
            sizes.takes(&["radius_m", "height_m"])?;
            let radius = sizes.one("radius_m", &table.radius_m)?;
            Shape::Cone { radius, height: sizes.one("height_m", &table.height_m)? }
        }
        FormKind::Disc => {
            let sizes = sizes("disc");
            sizes.takes(&["radius_m"])?;
            Shape::disc(sizes.one("radius_m", &table.radius_m)?)
        }
        FormKind::Ellipse => {
            let sizes = sizes("ellipse");
            sizes.takes(&["radii_m"])?;
            let [right, forward] = sizes.several("radii_m", &table.radii_m)?;
            Shape::Ellipse { radii: DVec2::new(right, forward) }
        }
    };

    Ok(shape.into())
}

/// Refuses keys of shapes for a model.
pub(super) fn refuse_sizes(reading: &Reading<'_>, table: &ObjectTable, model: Range<usize>) -> Result<()> {
    Sizes { reading, table, shape: model, name: "model" }.takes(&[])
}

impl Sizes<'_, '_> {
    /// Refuses keys of other shapes.
    fn takes(&self, keys: &[&str]) -> Result<()> {
        let table = self.table;
        let given = [
            ("radius_m", table.radius_m.as_ref().map(Spanned::span)),
            ("radii_m", table.radii_m.as_ref().map(Spanned::span)),
            ("size_m", table.size_m.as_ref().map(Spanned::span)),
            ("height_m", table.height_m.as_ref().map(Spanned::span)),
            ("width_m", table.width_m.as_ref().map(Spanned::span)),
            ("width_px", table.width_px.as_ref().map(Spanned::span)),
            ("size_px", table.size_px.as_ref().map(Spanned::span)),
            ("to", table.to.as_ref().map(Spanned::span)),
        ];

        let other =
            given.into_iter().find_map(|(key, span)| Some(key).zip(span).filter(|_| !keys.contains(&key)));
        other.map_or(Ok(()), |(key, span)| {
            let what = match keys {
                [] => format!("a {} has no {key}; scale or length_m say how large it is", self.name),
                keys => format!("a {} has no {key}; its size is {}", self.name, keys.join(" and ")),
            };
            Err(self.reading.wrong(span, what))
        })
    }

    fn missing(&self, key: &str) -> Error {
        self.reading.wrong(self.shape.clone(), format!("a {} needs {key}", self.name))
    }

    fn one(&self, key: &str, value: &Option<Spanned<f64>>) -> Result<f64> {
        let value = value.as_ref().ok_or_else(|| self.missing(key))?;
        self.reading.number(key, value, is_size, "must be more than 0 m and at most 100 km")
    }

    fn pixels(&self, key: &str, value: &Option<Spanned<f64>>) -> Result<f64> {
        let holds = |pixels| (0.0..=MOST_PIXELS).contains(&pixels);
        let number = |value| self.reading.number(key, value, holds, "must be 0 to 100 pixels");
        value.as_ref().map_or(Ok(0.0), number)
    }

    fn several<const N: usize>(&self, key: &str, value: &Option<Spanned<Vec<f64>>>) -> Result<[f64; N]> {
        let value = value.as_ref().ok_or_else(|| self.missing(key))?;
        let sizes: [f64; N] = self.reading.numbers(key, value)?;
        if sizes.into_iter().all(is_size) {
            return Ok(sizes);
        }
        let what = format!("{key} must be {N} lengths of more than 0 m and at most 100 km, not {sizes:?}");
        Err(self.reading.wrong(value.span(), what))
    }
}

fn is_size(metres: f64) -> bool {
    metres > 0.0 && metres <= LARGEST
}
