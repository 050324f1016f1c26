//! `[[object]]` and `[[scatter]]`: models that stand on the ground.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;

use super::cover::named;
use super::fields::Fields;
use crate::Materials;
use crate::object::{BuiltIn, ObjectFile, ScatterFile, ScatterForm, Stance};
use crate::recipe::files::{OneOrMany, crs, file, files};
use hedgehop::voxel::Material;

/// Square metres of a hectare.
const HECTARE: f64 = 10_000.0;

/// Farthest that the foot of an object may be above or below the ground, metres: the steps of height of the whole place grow with it.
const MOST_UP_M: f64 = 10_000.0;

/// Greatest factor of the size of built-in forms, likewise: models of files are no more than some kilometres high.
const MOST_SCALE: f64 = 100.0;

/// One place, or several.
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "at is a place, [612000, 5240100], or several of them in brackets")]
enum Places {
    One([f64; 2]),
    Many(Vec<[f64; 2]>),
}

/// One factor, or the least and the greatest.
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "scale is a number, or the least and the greatest: [0.8, 1.2]")]
enum Scales {
    One(f64),
    Range([f64; 2]),
}

/// Reads how a model stands, but for its size; what is scattered has no heading.
fn stance(table: &mut Fields<'_, '_, '_>, has_heading: bool) -> Stance {
    let mut angle = |key| table.number(key, f64::is_finite, "must be a number of degrees").unwrap_or(0.0);
    let (pitch_deg, roll_deg) = (angle("pitch_deg"), angle("roll_deg"));
    let heading_deg = if has_heading { angle("heading_deg") } else { 0.0 };
    let is_z_up = table.take::<String>("up").and_then(|up| {
        let known = match up.get_ref().as_str() {
            "y" => Ok(false),
            "z" => Ok(true),
            other => Err(format!("up is the axis of the file that points up, \"y\" or \"z\", not {other:?}")),
        };
        table.mistakes.check(&up.span(), known)
    });
    Stance { scale: 1.0, is_z_up, heading_deg, pitch_deg, roll_deg }
}

/// Reads the material of models.
fn material(table: &mut Fields<'_, '_, '_>, materials: &Materials) -> Material {
    let name = table.take::<String>("material");
    name.and_then(|name| named(&name, materials, table.mistakes)).unwrap_or_default()
}

/// `[[object]]`.
pub(super) fn object(mut table: Fields<'_, '_, '_>, folder: &Path, materials: &Materials) -> ObjectFile {
    let mistakes = table.mistakes;
    let paths = files(&mut table, folder, "\"barn.glb\"");
    let places = table.need::<Places>("at", "[612000, 5240100]").map_or(Vec::new(), |places| {
        let span = places.span();
        let places = match places.into_inner() {
            Places::One(place) => vec![place],
            Places::Many(places) => places,
        };
        if places.is_empty() || places.iter().flatten().any(|at| !at.is_finite()) {
            mistakes.add(&span, "at needs one place at least, of finite numbers");
        }
        places
    });

    let mut stance = stance(&mut table, true);
    stance.scale = table.number("scale", |scale| scale > 0.0, "must be more than 0").unwrap_or(1.0);
    let is_plausible = |metres: f64| metres.abs() <= MOST_UP_M;
    let up_m = table.number("up_m", is_plausible, "must be −10000 to 10000 m").unwrap_or(0.0);
    let material = material(&mut table, materials);
    table.finish();

    ObjectFile { paths, places, stance, up_m, material }
}

/// Two numbers, the first no more than the second.
fn range(table: &mut Fields<'_, '_, '_>, key: &'static str, example: &str) -> Option<[f64; 2]> {
    let range = table.take::<[f64; 2]>(key)?;
    let [low, high] = *range.get_ref();
    let wanted = || format!("{key} are the least and the greatest, as in {key} = {example}");
    table.mistakes.check(&range.span(), (low <= high).then_some([low, high]).ok_or_else(wanted))
}

/// A form by its name: of a built-in one, or of a file.
fn form(table: &Fields<'_, '_, '_>, span: &Range<usize>, name: &str, folder: &Path) -> Option<ScatterForm> {
    if let Some(form) = BuiltIn::of(name) {
        return Some(ScatterForm::BuiltIn(form));
    }
    if Path::new(name).extension().is_none() {
        let what = format!("{name:?} is neither a file nor one of {}", BuiltIn::names());
        table.mistakes.add(span, what);
        return None;
    }
    file(table, span, &folder.join(name)).map(ScatterForm::File)
}

/// Reads the forms that a scatter sets, and whether files are among them.
fn forms(table: &mut Fields<'_, '_, '_>, folder: &Path) -> (Vec<ScatterForm>, bool) {
    let Some(names) = table.need::<OneOrMany<String>>("objects", "[\"broadleaf\", \"oak.glb\"]") else {
        return (Vec::new(), true);
    };
    let span = names.span();
    let names = names.into_inner().into_vec();
    if names.is_empty() {
        table.mistakes.add(&span, "objects names none; write objects = [\"broadleaf\"]");
    }
    // A file that cannot be read is one, too: nobody is told that there is none.
    let has_files = names.is_empty() || names.iter().any(|name| BuiltIn::of(name).is_none());
    (names.iter().filter_map(|name| form(table, &span, name, folder)).collect(), has_files)
}

/// Materials of the ground that a scatter keeps to.
fn grounds(table: &mut Fields<'_, '_, '_>, materials: &Materials) -> Vec<Material> {
    let Some(names) = table.take::<OneOrMany<String>>("on") else { return Vec::new() };
    let span = names.span();
    let names = names.into_inner().into_vec();
    if names.is_empty() {
        table.mistakes.add(&span, "on names no material; write on = [\"conifer\"], or leave it out");
    }
    let known = |name| named(&Spanned::new(span.clone(), name), materials, table.mistakes);
    names.into_iter().filter_map(known).collect()
}

/// `[[scatter]]`.
pub(super) fn scatter(mut table: Fields<'_, '_, '_>, folder: &Path, materials: &Materials) -> ScatterFile {
    let mistakes = table.mistakes;
    let mut scatter = ScatterFile::default();
    let has_files;
    (scatter.forms, has_files) = forms(&mut table, folder);
    if !has_files {
        let what = "material is what models of files are made of; built-in plants and rocks have theirs, so leave it out";
        table.refuse("material", what);
    }

    scatter.material = material(&mut table, materials);
    for key in ["pitch_deg", "roll_deg", "up"].into_iter().filter(|_| !has_files) {
        let what = format!(
            "{key} is how models of files stand; built-in plants and rocks stand upright, so leave it out"
        );
        table.refuse(key, what);
    }

    scatter.stance = stance(&mut table, false);
    if !table.has("area") {
        table.refuse("crs", "crs is of the file of area, which is not there; add area, or leave crs out");
    }

    scatter.area = table
        .take::<String>("area")
        .and_then(|name| file(&table, &name.span(), &folder.join(name.get_ref())));
    scatter.crs = crs(&mut table);

    scatter.bbox = table.take::<[f64; 4]>("bbox").and_then(|bbox| {
        let [west, south, east, north] = *bbox.get_ref();
        let wanted =
            "bbox is west, south, east and north, metres: west is less than east, south less than north";
        mistakes.check(&bbox.span(), (west < east && south < north).then_some(*bbox.get_ref()).ok_or(wanted))
    });
    let more = |number: f64| number > 0.0;
    let spacing = table.number("spacing_m", more, "must be more than 0 m");
    let density = table.number("per_hectare", more, "must be more than 0");

    scatter.spacing_m = match (spacing, density) {
        (Some(spacing), None) => spacing,
        (None, Some(density)) => (HECTARE / density).sqrt(),
        (Some(spacing), Some(_)) => {
            mistakes.add(
                &table.span(),
                "[[scatter]] has spacing_m and per_hectare, which say the same; keep one",
            );
            spacing
        }
        (None, None) => {
            mistakes
                .add(&table.span(), "[[scatter]] needs `spacing_m`, as in spacing_m = 8, or `per_hectare`");
            scatter.spacing_m
        }
    };

    if let Some(scales) = table.take::<Scales>("scale") {
        let [low, high] = match *scales.get_ref() {
            Scales::One(scale) => [scale; 2],
            Scales::Range(range) => range,
        };
        let has_built_in = scatter.forms.iter().any(|form| matches!(form, ScatterForm::BuiltIn(_)));

        let checked = if !(low > 0.0 && low <= high && high.is_finite()) {
            Err("scale is more than 0; of two numbers the first is the least: [0.8, 1.2]".to_owned())
        } else if has_built_in && high > MOST_SCALE {
            Err(format!("scale of built-in plants and rocks must be at most {MOST_SCALE}, not {high}"))
        } else {
            Ok([low, high])
        };

        if let Some(scale) = mistakes.check(&scales.span(), checked) {
            scatter.scale = scale;
        }
    }

    scatter.seed = table.take::<u32>("seed").map_or(0, |seed| u64::from(seed.into_inner()));
    scatter.heights_m = range(&mut table, "heights_m", "[0, 1800]");
    scatter.slopes_deg = range(&mut table, "slopes_deg", "[0, 35]");
    if let Some([low, high]) = scatter.slopes_deg
        && !(low >= 0.0 && high < 90.0)
    {
        mistakes.add(&table.span(), "slopes_deg lie from 0 to less than 90 degrees");
    }

    scatter.grounds = grounds(&mut table, materials);
    scatter.avoid = table.take("avoid").is_none_or(Spanned::into_inner);
    table.finish();

    scatter
}
