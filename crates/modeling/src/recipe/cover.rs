//! The tables of materials: `[material]` and `[[land_cover]]`.

use std::collections::BTreeMap;
use std::path::Path;

use toml::Spanned;
use toml::de::DeValue;

use super::fields::{Fields, Mistakes};
use crate::features::colour;
use crate::recipe::files::{OneOrMany, crs, files};
use crate::{Finish, LandCoverFile, Materials, Scheme};
use hedgehop::voxel::Material;

/// `[material.NAME]`: what a recipe says of classes, and its own ones.
pub(super) fn materials(root: &mut Fields<'_, '_, '_>) -> Materials {
    let mistakes = root.mistakes;
    let Some(value) = root.value("material") else { return Materials::default() };
    let span = value.span();
    let DeValue::Table(tables) = value.into_inner() else {
        mistakes.add(&span, "write [material.asphalt], a table for each material");
        return Materials::default();
    };

    let mut said: Vec<Finish> = Vec::new();
    for (name, value) in tables {
        let at = name.span();
        let name = name.into_inner().into_owned();
        let Some(finish) =
            Fields::of("[material]", value, mistakes).and_then(|table| finish(table, &at, &name))
        else {
            continue;
        };
        if let Some(other) = said.iter().find(|other| other.material == finish.material) {
            let what = format!("{name} and {} both have the number {}", other.name, finish.material.code());
            mistakes.add(&at, what);
        }

        said.push(finish);
    }

    Materials::new(said)
}

fn finish(mut table: Fields<'_, '_, '_>, at: &std::ops::Range<usize>, name: &str) -> Option<Finish> {
    let mistakes = table.mistakes;
    let known = Material::named(name);
    let number = table.take::<u8>("number");

    let like = table.take::<String>("like").and_then(|like| {
        let known = Material::named(like.get_ref());
        let wanted = || {
            format!(
                "like is a material of the table, not {:?}; {}",
                like.get_ref(),
                hint(&Materials::default(), like.get_ref())
            )
        };
        mistakes.check(&like.span(), known.ok_or_else(wanted))
    });

    let colour = table.take::<String>("colour").and_then(|text| {
        let wanted = || format!("a colour is #rrggbb (sRGB) or a name, not {:?}", text.get_ref());
        mistakes.check(&text.span(), colour(text.get_ref()).ok_or_else(wanted))
    });
    let is_share = |share: f64| (0.0..=1.0).contains(&share);
    let tint = table.number("tint", is_share, "must be 0 to 1").unwrap_or(0.0) as f32;
    let has_number = number.is_some();
    table.finish();

    let material = match (known, number) {
        (Some(known), None) => known,
        (Some(known), Some(number)) => {
            let what = format!("{name} has the number {} in all places; leave number out", known.code());
            mistakes.add(&number.span(), what);
            return None;
        }
        (None, Some(number)) => {
            let last = Material::ALL.last().map_or(0, |material| material.code());
            let own = Some(Material::Own(*number.get_ref())).filter(|_| *number.get_ref() > last);
            let wanted = format!("number of {name} must be {} to 255: the others are of the table", last + 1);
            mistakes.check(&number.span(), own.ok_or(wanted))?
        }
        (None, None) => {
            let what = format!(
                "there is no material {name}; {}; one of your own needs a number, as in number = 200",
                hint(&Materials::default(), name)
            );
            mistakes.add(at, what);
            return None;
        }
    };

    if like.is_some() && !has_number {
        mistakes.add(
            at,
            format!("{name} is a material of the table, and like says what one of your own is like"),
        );
    }

    Some(Finish { material, name: name.to_owned(), like, colour, tint })
}

/// Suggests what else a name may have meant.
fn hint(materials: &Materials, given: &str) -> String {
    let names = materials.names();
    let nearest = names.split(", ").min_by_key(|known| strsim::damerau_levenshtein(known, given));
    match nearest {
        Some(known) if strsim::damerau_levenshtein(known, given) <= 1 + known.len() / 4 => {
            format!("did you mean {known:?}?")
        }
        _ => format!("there are {names}"),
    }
}

/// The material of a name.
pub(super) fn named(
    text: &Spanned<String>,
    materials: &Materials,
    mistakes: &Mistakes<'_>,
) -> Option<Material> {
    let wanted = || format!("there is no material {:?}; {}", text.get_ref(), hint(materials, text.get_ref()));
    mistakes.check(&text.span(), materials.named(text.get_ref()).ok_or_else(wanted))
}

/// `[[land_cover]]`: maps of classes.
pub(super) fn land_cover(
    mut table: Fields<'_, '_, '_>,
    folder: &Path,
    materials: &Materials,
) -> Vec<LandCoverFile> {
    let mistakes = table.mistakes;
    let span = table.span();
    let paths = files(&mut table, folder, "\"worldcover.tif\"");
    let crs = crs(&mut table);
    let nodata = table.take::<OneOrMany<f64>>("nodata").map(|nodata| nodata.into_inner().into_vec());
    let named = table.take::<String>("scheme");
    let classes = table.value("classes");

    let scheme = match (named, classes) {
        (Some(scheme), None) => mistakes.check(&scheme.span(), Scheme::named(scheme.get_ref())),
        (None, Some(classes)) => own(classes, materials, mistakes).map(Scheme::Own),
        (scheme, _) => {
            let say = "[[land_cover]] needs scheme = \"worldcover\", \"corine\" or \"nlcd\", or classes = { 1 = \"water\" }";
            let what = if scheme.is_some() { format!("{say}; not both") } else { say.to_owned() };
            mistakes.add(&span, what);
            None
        }
    };

    table.finish();
    let Some(scheme) = scheme else { return Vec::new() };
    let nodata = nodata.unwrap_or_default();
    let of = |path| LandCoverFile { path, crs: crs.clone(), scheme: scheme.clone(), nodata: nodata.clone() };

    paths.into_iter().map(of).collect()
}

/// `classes = { 1 = "water", 2 = "conifer" }`.
fn own(
    value: Spanned<DeValue<'_>>,
    materials: &Materials,
    mistakes: &Mistakes<'_>,
) -> Option<BTreeMap<u16, Material>> {
    let span = value.span();
    let example = "classes = { 1 = \"water\", 2 = \"conifer\" }";
    let DeValue::Table(table) = value.into_inner() else {
        mistakes.add(&span, format!("classes is a table of numbers and materials, as in {example}"));
        return None;
    };

    if table.is_empty() {
        mistakes.add(&span, format!("classes names none; write {example}"));
    }
    let mut classes = BTreeMap::new();

    for (number, value) in table {
        let at = value.span();
        let wanted = || {
            format!("{} is no class; classes are numbers from 0 to 65535, as in {example}", number.get_ref())
        };
        let key = mistakes.check(&number.span(), number.get_ref().parse::<u16>().map_err(|_| wanted()));
        let text = match value.into_inner() {
            DeValue::String(text) => Ok(text.into_owned()),
            _ => Err(format!("a class is a material's name, as in {example}")),
        };
        let text = mistakes.check(&at, text);
        let material = text.and_then(|text| named(&Spanned::new(at, text), materials, mistakes));
        classes.extend(key.zip(material));
    }

    Some(classes)
}
