//! The tables of what no file holds: `[[terrain]]`, `[detail]`, `[[texture]]`, `[palette]`.

use glam::DVec2;
use serde::Deserialize;
use toml::Spanned;

use super::cover;
use super::fields::Fields;
use crate::Materials;
use crate::features::{WATER, colour};
use crate::recipe::contents::Lines;
use crate::synthetic::{
    Circle, Detail, Hills, Palette, Pattern, PlateauTop, Roughness, Stop, Synthetic, Terrain, Texture,
};
use hedgehop::voxel::Material;
use hedgehop_base::document::Reading;

/// Reads all of them, and whether all shapes of terrain could be read; `lines` takes where they stand.
pub(super) fn synthetic(
    root: &mut Fields<'_, '_, '_>,
    known: &Materials,
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

    let synthetic = Synthetic {
        terrain: shapes,
        materials,
        detail: root.table("detail", "[detail]").and_then(detail),
        palette: root.table("palette", "[palette]").and_then(palette),
        textures,
    };

    (synthetic, is_whole)
}

/// Numbers that a key may have.
#[derive(Clone, Copy)]
pub(super) struct NumberRange {
    /// Whether a number is one of them.
    pub holds: fn(f64) -> bool,
    /// Words for them, after the key's name.
    pub want: &'static str,
}

impl NumberRange {
    const fn new(holds: fn(f64) -> bool, want: &'static str) -> Self {
        Self { holds, want }
    }
}

/// Most places of a line; each is met by every voxel near it.
const MOST_PLACES: usize = 1000;

/// Range of heights of ground: the steps of height of a whole place grow with it.
pub(super) const HEIGHT: NumberRange =
    NumberRange::new(|metres| metres.abs() <= 20_000.0, "must be −20000 to 20000 m");
const AMOUNT: NumberRange =
    NumberRange::new(|metres| metres > 0.0 && metres <= 20_000.0, "must be more than 0 and at most 20000 m");
const LENGTH: NumberRange =
    NumberRange::new(|metres| metres > 0.0 && metres <= 1.0e7, "must be more than 0 and at most 10000000 m");
const WIDTH: NumberRange =
    NumberRange::new(|metres| (0.0..=1.0e7).contains(&metres), "must be 0 to 10000000 m");
const PLACE: NumberRange = NumberRange::new(|metres| metres.abs() <= 1.0e9, "must be a place in metres");
const AZIMUTH: NumberRange =
    NumberRange::new(|degrees| degrees.abs() <= 360.0, "must be −360 to 360 degrees");
const ROUGHNESS: NumberRange = NumberRange::new(|share| (0.2..=0.9).contains(&share), "must be 0.2 to 0.9");
const SHARE: NumberRange = NumberRange::new(|share| (0.0..=1.0).contains(&share), "must be 0 to 1");
const HALF: NumberRange = NumberRange::new(|share| (0.0..=0.5).contains(&share), "must be 0 to 0.5");
const PERCENT: NumberRange = NumberRange::new(|percent| percent.abs() <= 1000.0, "must be −1000 to 1000 %");

impl Fields<'_, '_, '_> {
    /// A number that must be there.
    fn needed(&mut self, key: &'static str, example: &str, range: NumberRange) -> Option<f64> {
        let number = self.need::<f64>(key, example)?;
        self.mistakes.check(&number.span(), Reading::checked(key, *number.get_ref(), range.holds, range.want))
    }

    /// A number, or what it is without the key.
    fn number_or(&mut self, key: &'static str, otherwise: f64, range: NumberRange) -> f64 {
        self.number(key, range.holds, range.want).unwrap_or(otherwise)
    }

    fn material(&mut self, known: &Materials) -> Option<Material> {
        let name = self.take::<String>("material")?;
        cover::named(&name, known, self.mistakes)
    }

    fn seed(&mut self) -> u64 {
        self.take::<u32>("seed").map_or(0, |seed| u64::from(seed.into_inner()))
    }

    /// Reads which kind a key may name, by the names that it has.
    fn kind<T: Copy, const N: usize>(&mut self, kinds: [KindWord<T>; N], example: &str) -> Option<T> {
        let kind = self.need::<String>("kind", example)?;
        let known = kinds.iter().find(|known| known.word == kind.get_ref()).map(|known| known.kind);
        let wanted = || {
            format!("kind is one of {}, not {:?}", kinds.map(|known| known.word).join(", "), kind.get_ref())
        };
        self.mistakes.check(&kind.span(), known.ok_or_else(wanted))
    }

    /// A place of a table, metres.
    fn place(&self, key: &'static str, place: &Spanned<Vec<f64>>) -> Option<DVec2> {
        let found = match place.get_ref().as_slice() {
            [x, y] => {
                let checked = |metres| Reading::checked(key, metres, PLACE.holds, PLACE.want);
                checked(*x).and_then(|x| Ok(DVec2::new(x, checked(*y)?)))
            }
            _ => Err(format!("{key} is a place, [x, y] in metres")),
        };
        self.mistakes.check(&place.span(), found)
    }

    fn circle(&mut self) -> Option<Circle> {
        let centre = self.need::<Vec<f64>>("centre", "[4000, 4000]");
        let centre = centre.and_then(|centre| self.place("centre", &centre));
        let radius = self.needed("radius_m", "500", LENGTH);
        Some(Circle { centre: centre?, radius_m: radius? })
    }

    /// A circle, or nothing without its keys; the outer `None` is a mistake.
    fn within(&mut self) -> Option<Option<Circle>> {
        let is_there = self.has("centre") || self.has("radius_m");
        if is_there {
            return self.circle().map(Some);
        }
        // Known, so that a slip of the pen is told with them.
        ["centre", "radius_m"].into_iter().for_each(|key| drop(self.value(key)));
        Some(None)
    }

    fn colour(&self, text: &Spanned<String>) -> Option<[u8; 3]> {
        let wanted = || format!("a colour is #rrggbb (sRGB) or a name, not {:?}", text.get_ref());
        self.mistakes.check(&text.span(), colour(text.get_ref()).ok_or_else(wanted))
    }
}

/// Word for a kind of thing in a recipe.
#[derive(Clone, Copy)]
struct KindWord<T> {
    /// The word.
    word: &'static str,
    /// Kind that it stands for.
    kind: T,
}

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

/// `[detail]`: what is finer than the posts of elevation.
fn detail(mut table: Fields<'_, '_, '_>) -> Option<Detail> {
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
    Some(Detail { seed, roughness: roughness?, limit_m })
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
