//! The tables of what no file holds: `[[terrain]]`, `[detail]`, `[[texture]]`, `[palette]`; `[[patch]]` is in `patches`.

use std::path::Path;

use glam::DVec2;
use serde::Deserialize;
use toml::Spanned;

use super::below_voxel::below_voxel;
use super::fields::Fields;
use super::patches::patch;
use super::values::{
    AMOUNT, AZIMUTH, HALF, HEIGHT, KindWord, LENGTH, NumberRange, PERCENT, ROUGHNESS, SHARE, WIDTH,
};
use crate::Materials;
use crate::features::WATER;
use crate::recipe::contents::Lines;
use crate::synthetic::{
    Circle, Detail, Hills, Palette, Pattern, PlateauTop, Roughness, Stop, Synthetic, Terrain, Texture,
    TextureExamples,
};
use hedgehop::voxel::DetailRecord;
use hedgehop_base::document::Reading;

/// Reads all of them, and whether all shapes of terrain could be read; `lines` takes where they stand.
pub(super) fn synthetic(
    root: &mut Fields<'_, '_, '_>,
    known: &Materials,
    folder: &Path,
    lines: &mut Lines,
) -> (Synthetic, bool) {
    let (mut shapes, mut materials) = (Vec::new(), Vec::new());
    let tables = root.tables("terrain", "[[terrain]]");
    let count = tables.len();
    for mut table in tables {
        let material = table.material(known);
        let line = table.line();
        if let Some(shape) = terrain(table) {
            lines.terrain.push(line);
            materials.extend(material.map(|material| (shapes.len(), material)));
            shapes.push(shape);
        }
    }

    let is_whole = shapes.len() == count;
    let mut textures = Vec::new();
    for table in root.tables("texture", "[[texture]]") {
        let line = table.line();
        let texture = texture(table, known);
        lines.textures.extend(texture.iter().map(|_| line));
        textures.extend(texture);
    }

    let mut patches = Vec::new();
    for table in root.tables("patch", "[[patch]]") {
        let line = table.line();
        let painted = patch(table, known);
        lines.patches.extend(painted.iter().map(|_| line));
        patches.extend(painted);
    }

    let detail =
        root.table("detail", "[detail]").and_then(|table| detail(table, known, folder)).unwrap_or_default();
    let synthetic = Synthetic {
        terrain: shapes,
        materials,
        detail: detail.below_posts,
        below_voxel: detail.below_voxel,
        examples: detail.examples,
        palette: root.table("palette", "[palette]").and_then(palette),
        textures,
        patches,
    };

    (synthetic, is_whole)
}

/// Most places of a line; each is met by every voxel near it.
const MOST_PLACES: usize = 1000;

#[derive(Clone, Copy)]
enum NamedKind {
    Plane,
    Fractal,
    Ridge,
    Valley,
    Cone,
    Dome,
    Plateau,
    Pond,
}

const KINDS: [KindWord<NamedKind>; 8] = [
    KindWord { word: "plane", kind: NamedKind::Plane },
    KindWord { word: "fractal", kind: NamedKind::Fractal },
    KindWord { word: "ridge", kind: NamedKind::Ridge },
    KindWord { word: "valley", kind: NamedKind::Valley },
    KindWord { word: "cone", kind: NamedKind::Cone },
    KindWord { word: "dome", kind: NamedKind::Dome },
    KindWord { word: "plateau", kind: NamedKind::Plateau },
    KindWord { word: "pond", kind: NamedKind::Pond },
];

/// `[[terrain]]`: a shape of the ground.
fn terrain(mut table: Fields<'_, '_, '_>) -> Option<Terrain> {
    // Without its kind nobody knows which keys it has.
    let shape = match table.kind(KINDS, "\"ridge\"")? {
        NamedKind::Plane => plane(&mut table),
        NamedKind::Fractal => fractal(&mut table),
        NamedKind::Ridge => swept(&mut table, ["height_m", "crest_m"], 1.0),
        NamedKind::Valley => swept(&mut table, ["depth_m", "floor_m"], -1.0),
        NamedKind::Cone => raised(&mut table).map(|(circle, height_m)| Terrain::Cone { circle, height_m }),
        NamedKind::Dome => raised(&mut table).map(|(circle, height_m)| Terrain::Dome { circle, height_m }),
        NamedKind::Plateau => plateau(&mut table),
        NamedKind::Pond => pond(&mut table),
    };
    table.finish();
    shape
}

fn plane(table: &mut Fields<'_, '_, '_>) -> Option<Terrain> {
    let height = table.needed("height_m", "400", HEIGHT);
    let percent = table.number_or("slope_percent", 0.0, PERCENT);
    let upward_deg = table.number_or("upward_deg", 0.0, AZIMUTH);
    let centre = if percent == 0.0 {
        table.take::<Vec<f64>>("centre")
    } else {
        Some(table.need::<Vec<f64>>("centre", "[4000, 4000]")?)
    };
    let centre = centre.map_or(Some(DVec2::ZERO), |centre| table.place("centre", &centre));
    Some(Terrain::Plane { height_m: height?, centre: centre?, slope: percent / 100.0, upward_deg })
}

fn fractal(table: &mut Fields<'_, '_, '_>) -> Option<Terrain> {
    let amplitude = table.needed("amplitude_m", "150", AMOUNT);
    let wavelength = table.needed("wavelength_m", "3000", LENGTH);
    let roughness = table.number_or("roughness", 0.5, ROUGHNESS);
    let seed = table.seed();
    let crests = table.take("crests").is_some_and(Spanned::into_inner);
    let within = table.within();
    let waves = Hills { seed, wavelength_m: wavelength?, roughness };
    Some(Terrain::Fractal { waves, amplitude_m: amplitude?, crests, within: within? })
}

/// Reads what is swept along a line: the keys of its height and of what is level in its middle, and 1 if it is a ridge, −1 if it is a valley.
fn swept(table: &mut Fields<'_, '_, '_>, [height, level]: [&'static str; 2], sign: f64) -> Option<Terrain> {
    let line = table.need::<Vec<Vec<f64>>>("line", "[[0, 4000], [8000, 5000]]").and_then(|line| {
        let span = line.span();
        let places = line
            .get_ref()
            .iter()
            .map(|place| table.place("line", &Spanned::new(span.clone(), place.clone())));
        let mut places: Vec<DVec2> = places.collect::<Option<_>>()?;
        places.dedup();
        let wanted =
            format!("line is 2 to {MOST_PLACES} places, [[x, y], [x, y]] in metres, not all the same");
        let is_line = (2..=MOST_PLACES).contains(&places.len());
        table.mistakes.check(&span, if is_line { Ok(places) } else { Err(wanted) })
    });

    let height_m = table.needed(height, "80", AMOUNT);
    let width = table.needed("width_m", "900", LENGTH);
    let crest_m = table.number_or(level, 0.0, WIDTH);
    let (line, height_m, width_m) = (line?, sign * height_m?, width?);
    if crest_m >= width_m {
        table
            .mistakes
            .add(&table.span(), format!("{level} is {crest_m}, but must be less than width_m, {width_m}"));
        return None;
    }

    Some(Terrain::Ridge { line, width_m, crest_m, height_m })
}

fn raised(table: &mut Fields<'_, '_, '_>) -> Option<(Circle, f64)> {
    let circle = table.circle();
    let height = table.needed("height_m", "80", HEIGHT);
    Some((circle?, height?))
}

fn plateau(table: &mut Fields<'_, '_, '_>) -> Option<Terrain> {
    let circle = table.circle();
    let flank = table.needed("flank_m", "120", LENGTH);
    let top = match (table.has("height_m"), table.has("level_m")) {
        (true, false) => table.needed("height_m", "60", HEIGHT).map(PlateauTop::Above),
        (false, true) => table.needed("level_m", "480", HEIGHT).map(PlateauTop::Level),
        _ => {
            let both = (table.value("height_m"), table.value("level_m"));
            let say =
                "a plateau needs height_m, above the ground as it is, or level_m, at which its top is level";
            let what = if both.0.is_some() { format!("{say}; not both") } else { say.to_owned() };
            table.mistakes.add(&table.span(), what);
            None
        }
    };
    Some(Terrain::Plateau { circle: circle?, flank_m: flank?, top: top? })
}

fn pond(table: &mut Fields<'_, '_, '_>) -> Option<Terrain> {
    let circle = table.circle();
    let level = table.needed("level_m", "395", HEIGHT);
    let bank = table.number("bank_m", LENGTH.holds, LENGTH.want);
    let ragged = table.number_or("ragged", 0.0, HALF);
    let seed = table.seed();
    let colour = table.take::<String>("colour");
    let colour = colour.map_or(Some(WATER.colour), |text| table.colour(&text));
    let circle = circle?;
    let bank_m = bank.unwrap_or(0.25 * circle.radius_m);
    Some(Terrain::Pond { circle, bank_m, level_m: level?, ragged, seed, colour: colour? })
}

/// Roughness of detail.
#[derive(Deserialize)]
#[serde(untagged, expecting = "roughness is \"auto\", or 0.2 to 0.9")]
enum RoughnessWord {
    Share(f64),
    Word(String),
}

/// Tables of detail: of elevation, and of imagery.
#[derive(Default)]
struct DetailTable {
    below_posts: Option<Detail>,
    below_voxel: Option<DetailRecord>,
    examples: Option<TextureExamples>,
}

/// `[detail]`: what is finer than the posts of elevation, and than voxels. A table that speaks of imagery alone leaves heights as they are.
fn detail(mut table: Fields<'_, '_, '_>, known: &Materials, folder: &Path) -> Option<DetailTable> {
    let of_heights =
        !table.has("imagery") || ["seed", "roughness", "limit_m"].iter().any(|key| table.has(key));
    let below_voxel = below_voxel(&mut table, known, folder);
    let seed = table.seed();
    let roughness = match table.take::<RoughnessWord>("roughness") {
        None => Some(Roughness::Auto),
        Some(rough) => {
            let found = match rough.get_ref() {
                RoughnessWord::Word(word) if word == "auto" => Ok(Roughness::Auto),
                RoughnessWord::Share(share) if (ROUGHNESS.holds)(*share) => Ok(Roughness::Given(*share)),
                _ => Err("roughness is \"auto\", or 0.2 to 0.9"),
            };
            table.mistakes.check(&rough.span(), found)
        }
    };
    let limit_m = table.number("limit_m", AMOUNT.holds, AMOUNT.want);
    table.finish();
    let below_posts = Detail { seed, roughness: roughness?, limit_m };
    let (below_voxel, examples) =
        below_voxel?.map_or((None, None), |below| (Some(below.record), below.examples));
    Some(DetailTable { below_posts: of_heights.then_some(below_posts), below_voxel, examples })
}

const PATTERNS: [KindWord<Pattern>; 5] = [
    KindWord { word: "checkerboard", kind: Pattern::Checkerboard },
    KindWord { word: "checks", kind: Pattern::Checks },
    KindWord { word: "speckle", kind: Pattern::Speckle },
    KindWord { word: "waves", kind: Pattern::Waves },
    KindWord { word: "fractal", kind: Pattern::Fractal },
];

/// `[[texture]]`: a pattern on the ground.
fn texture(mut table: Fields<'_, '_, '_>, known: &Materials) -> Option<Texture> {
    let material = table.material(known);
    let pattern = table.kind(PATTERNS, "\"fractal\"");
    let colours =
        table.need::<Vec<Spanned<String>>>("colours", "[\"#6a7a4a\", \"#8c8a58\"]").and_then(|texts| {
            let colours =
                texts.get_ref().iter().map(|text| table.colour(text)).collect::<Option<Vec<_>>>()?;
            let is_several = (2..=256).contains(&colours.len());
            table
                .mistakes
                .check(&texts.span(), if is_several { Ok(colours) } else { Err("colours are 2 to 256") })
        });

    let size = table.needed("size_m", "60", LENGTH);
    if pattern == Some(Pattern::Checkerboard) {
        table.refuse("seed", "all checkerboards of a size are alike: leave seed out, or write kind = \"checks\", whose squares are by chance");
    }

    let seed = table.seed();
    let turned_deg = table.number_or("turned_deg", 0.0, AZIMUTH);
    let strength = table.number_or("strength", 1.0, SHARE) as f32;
    let over_imagery = table.number_or("over_imagery", 0.0, SHARE) as f32;
    let within = table.within();
    table.finish();
    let texture = Texture::new(pattern?, &colours?, size?)?;

    Some(Texture { seed, turned_deg, strength, over_imagery, within: within?, material, ..texture })
}

/// `[palette]`: colours of ground by height and slope.
fn palette(mut table: Fields<'_, '_, '_>) -> Option<Palette> {
    let heights =
        table.need::<Vec<(f64, Spanned<String>)>>("heights", "[[0, \"#5c7a46\"], [900, \"#8a8070\"]]");
    let heights = heights.and_then(|stops| self::stops(&table, "heights", &stops, HEIGHT));
    let slopes = table.take::<Vec<(f64, Spanned<String>)>>("slopes");
    let steep =
        NumberRange::new(|degrees| (1.0..90.0).contains(&degrees), "must be 1 to less than 90 degrees");
    let slopes = slopes.map_or(Some(Vec::new()), |stops| self::stops(&table, "slopes", &stops, steep));
    let over_imagery = table.number_or("over_imagery", 0.0, SHARE);
    table.finish();
    Some(Palette::new(&heights?, &slopes?).over_imagery(over_imagery))
}

/// Stops of which each lies above the one before it.
fn stops(
    table: &Fields<'_, '_, '_>,
    key: &'static str,
    stops: &Spanned<Vec<(f64, Spanned<String>)>>,
    range: NumberRange,
) -> Option<Vec<Stop>> {
    let read = stops.get_ref().iter().map(|(at, text)| {
        let at = table.mistakes.check(&stops.span(), Reading::checked(key, *at, range.holds, range.want))?;
        Some(Stop { at, colour: table.colour(text)? })
    });
    let read = read.collect::<Option<Vec<_>>>()?;
    let rises = !read.is_empty() && read.windows(2).all(|pair| pair[0].at < pair[1].at);
    let wanted = format!(
        "{key} are one stop at least, each higher than the one before it: [[20, \"#5c7a46\"], [40, \"#8a8070\"]]"
    );
    table.mistakes.check(&stops.span(), if rises { Ok(read) } else { Err(wanted) })
}
