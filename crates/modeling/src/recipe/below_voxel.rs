//! The key `imagery` of `[detail]`: what lies below the finest voxel.

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};
use std::path::Path;

use toml::de::DeValue;
use toml::{Spanned, Table, Value};

use super::cover;
use super::fields::{Fields, Mistakes};
use super::files::files_of;
use crate::Materials;
use crate::synthetic::TextureExamples;
use hedgehop::voxel::DetailRecord;
use hedgehop_texture::{Generator, QuantityMode};

/// The word for no detail at all.
const OFF: &str = "off";

/// The word for patterns that are matched from fine imagery.
const MATCH: &str = "match";

/// Sides of pixels of examples, metres.
const PIXELS: RangeInclusive<f64> = 0.001..=1000.0;

/// Cells of a tile along a voxel.
const CELLS: f64 = hedgehop_texture::CELLS_PER_VOXEL as f64;

/// Wavelengths of waves, voxels.
const WAVELENGTHS: RangeInclusive<f64> = 0.2..=2.0;

/// Keys of parameters, each of which some patterns have.
const PARAMETERS: [&str; 6] = ["octaves", "codes", "lines", "mode", "wavelength_voxels", "time"];

/// Detail below the voxel, and what its pattern is matched from.
pub(super) struct BelowVoxel {
    pub record: DetailRecord,
    pub examples: Option<TextureExamples>,
}

/// Reads `imagery`: the name of a pattern, or a table with that and what else there is to say; the outer `None` is a mistake.
pub(super) fn below_voxel(
    detail: &mut Fields<'_, '_, '_>,
    known: &Materials,
    folder: &Path,
) -> Option<Option<BelowVoxel>> {
    let mistakes = detail.mistakes;
    let Some(value) = detail.value("imagery") else { return Some(None) };
    let span = value.span();
    if let DeValue::String(name) = value.get_ref() {
        let named = pattern_named(name);
        return mistakes.check(&span, named).map(Some);
    }
    if !matches!(value.get_ref(), DeValue::Table(_)) {
        mistakes.add(&span, "imagery is the name of a pattern, as in imagery = \"broad\", \"off\", or a table, [detail.imagery]");
        return None;
    }
    Fields::of("[detail.imagery]", value, mistakes).and_then(|table| below(table, known, folder)).map(Some)
}

/// Detail with a pattern by its name alone.
fn pattern_named(name: &str) -> Result<BelowVoxel, String> {
    let usual = DetailRecord::default();
    match name {
        OFF => Ok(BelowVoxel { record: DetailRecord { strength: 0.0, ..usual }, examples: None }),
        // Light on the ground is in the imagery.
        MATCH => Ok(BelowVoxel {
            record: DetailRecord { relief: 0.0, ..usual },
            examples: Some(TextureExamples::default()),
        }),
        _ => {
            let pattern =
                Generator::named(name).map_err(|error| format!("{error}, or \"{MATCH}\" or \"{OFF}\""))?;
            Ok(BelowVoxel { record: DetailRecord { pattern, ..usual }, examples: None })
        }
    }
}

/// `[detail.imagery]`.
fn below(mut table: Fields<'_, '_, '_>, known: &Materials, folder: &Path) -> Option<BelowVoxel> {
    let mistakes = table.mistakes;
    let name = table.take::<String>("pattern");
    let usual = match &name {
        Some(name) => mistakes.check(&name.span(), pattern_named(name.get_ref()))?,
        None => BelowVoxel { record: DetailRecord::default(), examples: None },
    };
    let pattern = parameters(&mut table, usual.record.pattern);

    let seed = table.seed();
    let strength = bounded(&mut table, "strength", DetailRecord::STRENGTHS, usual.record.strength);
    let relief = bounded(&mut table, "relief", DetailRecord::RELIEFS, usual.record.relief);
    let materials = factors(&mut table, known);
    let displaced = displacement(&mut table, known);
    let examples = examples(&mut table, usual.examples, folder)?;
    let span = table.span();
    table.finish();

    let Displaced { all: displacement, by_material: displacements } = displaced?;
    let record = DetailRecord {
        pattern: pattern?,
        seed,
        strength: strength?,
        relief: relief?,
        materials: materials?,
        displacement,
        displacements,
        matched: None,
    };
    // Some patterns leave nothing below the voxel.
    mistakes.check(&span, record.pattern.tile(seed))?;
    let examples = examples.map(|examples| TextureExamples { seed, ..examples });
    Some(BelowVoxel { record, examples })
}

/// Takes what patterns are matched from; other patterns have no examples.
fn examples(
    table: &mut Fields<'_, '_, '_>,
    usual: Option<TextureExamples>,
    folder: &Path,
) -> Option<Option<TextureExamples>> {
    let Some(usual) = usual else {
        for key in ["examples", "pixel_m"] {
            table.refuse(key, format!("{key} is of pattern = \"{MATCH}\" alone"));
            drop(table.value(key));
        }
        return Some(None);
    };

    let files = match table.has("examples") {
        true => files_of(table, "examples", folder, "\"fine.tif\""),
        false => Vec::new(),
    };
    let pixel = table.take::<f64>("pixel_m");
    if let Some(pixel) = &pixel {
        let range = PIXELS.contains(pixel.get_ref()) && !files.is_empty();
        let wanted = || {
            format!(
                "pixel_m is the side of the pixels of examples, {} to {}; name examples, too",
                PIXELS.start(),
                PIXELS.end()
            )
        };
        table.mistakes.check(&pixel.span(), range.then_some(()).ok_or_else(wanted))?;
    }
    Some(Some(TextureExamples { files, pixel_m: pixel.map(Spanned::into_inner), ..usual }))
}

/// A number within a range.
fn bounded(
    table: &mut Fields<'_, '_, '_>,
    key: &'static str,
    range: RangeInclusive<f64>,
    otherwise: f64,
) -> Option<f64> {
    let Some(number) = table.take::<f64>(key) else { return Some(otherwise) };
    let within = range.contains(number.get_ref()).then_some(*number.get_ref());
    let wanted = || format!("{key} must be {} to {}", range.start(), range.end());
    table.mistakes.check(&number.span(), within.ok_or_else(wanted))
}

/// Takes the parameters that a pattern has; others are mistakes.
fn parameters(table: &mut Fields<'_, '_, '_>, pattern: Generator) -> Option<Generator> {
    let whole = |table: &mut Fields<'_, '_, '_>, key, otherwise: u32| {
        table.take::<u32>(key).map_or(otherwise, Spanned::into_inner)
    };
    let span = PARAMETERS.iter().find_map(|key| table.span_of(key)).unwrap_or_else(|| table.span());
    let found = match pattern {
        Generator::Broad { octaves } => Generator::Broad { octaves: whole(table, "octaves", octaves) },
        Generator::Superimposed { codes } => Generator::Superimposed { codes: whole(table, "codes", codes) },
        Generator::Mosaic { lines } => Generator::Mosaic { lines: whole(table, "lines", lines) },
        Generator::Quantity { mode } => {
            let code = table.take::<u8>("mode").map(Spanned::into_inner);
            let mode = code.map_or(Ok(mode), QuantityMode::try_from);
            Generator::Quantity { mode: table.mistakes.check(&span, mode)? }
        }
        Generator::Waves { wavelength } => {
            let voxels = bounded(table, "wavelength_voxels", WAVELENGTHS, wavelength / CELLS)?;
            Generator::Waves { wavelength: voxels * CELLS }
        }
        Generator::Sea { codes, time } => Generator::Sea {
            codes: whole(table, "codes", codes),
            time: table.take::<f64>("time").map_or(time, Spanned::into_inner),
        },
        Generator::White | Generator::Codes | Generator::Maps => pattern,
    };

    for key in PARAMETERS {
        table.refuse(key, format!("the pattern \"{}\" has no {key}", pattern.name()));
        drop(table.value(key));
    }
    table.mistakes.check(&span, found.check().map(|()| found))
}

/// Numbers that a table has of materials by name.
#[derive(Clone, Copy)]
struct MaterialNumbers {
    /// Words for one of them.
    name: &'static str,
    range: fn() -> RangeInclusive<f64>,
    unit: &'static str,
}

const FACTORS: MaterialNumbers =
    MaterialNumbers { name: "factor", range: || DetailRecord::FACTORS, unit: "" };
const DISPLACEMENTS: MaterialNumbers =
    MaterialNumbers { name: "displacement", range: || DetailRecord::DISPLACEMENTS, unit: " m" };

impl MaterialNumbers {
    /// Reads the table of a key.
    fn read(
        self,
        given: Table,
        span: &Range<usize>,
        known: &Materials,
        mistakes: &Mistakes<'_>,
    ) -> Option<BTreeMap<String, f64>> {
        let (Self { name: what, unit, .. }, range) = (self, (self.range)());
        let mut numbers = BTreeMap::new();
        for (name, value) in given {
            let Some(number) = number_of(&value).filter(|number| range.contains(number)) else {
                let (least, most) = (range.start(), range.end());
                let what = format!("the {what} of {name} must be a number from {least} to {most}{unit}");
                mistakes.add(span, what);
                return None;
            };
            cover::named(&Spanned::new(span.clone(), name.clone()), known, mistakes)?;
            numbers.insert(name, number);
        }
        Some(numbers)
    }
}

/// A number, whole or not.
fn number_of(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Factors of materials by name.
fn factors(table: &mut Fields<'_, '_, '_>, known: &Materials) -> Option<BTreeMap<String, f64>> {
    let Some(given) = table.take::<Table>("materials") else { return Some(BTreeMap::new()) };
    let span = given.span();
    FACTORS.read(given.into_inner(), &span, known, table.mistakes)
}

/// How far ground is displaced: metres, and metres of materials by name.
#[derive(Default)]
struct Displaced {
    all: f64,
    by_material: BTreeMap<String, f64>,
}

/// Reads `displacement`: metres of all ground, or a table of materials.
fn displacement(table: &mut Fields<'_, '_, '_>, known: &Materials) -> Option<Displaced> {
    let Some(given) = table.take::<Value>("displacement") else { return Some(Displaced::default()) };
    let span = given.span();
    match given.into_inner() {
        Value::Table(given) => {
            let by_material = DISPLACEMENTS.read(given, &span, known, table.mistakes)?;
            Some(Displaced { all: 0.0, by_material })
        }
        given => {
            let range = DetailRecord::DISPLACEMENTS;
            let metres = number_of(&given).filter(|metres| range.contains(metres));
            let wanted = || {
                let (least, most) = (range.start(), range.end());
                format!(
                    "displacement must be {least} to {most} m, or a table of materials, as in {{ grass = 0.1 }}"
                )
            };
            let all = table.mistakes.check(&span, metres.ok_or_else(wanted))?;
            Some(Displaced { all, ..Displaced::default() })
        }
    }
}
