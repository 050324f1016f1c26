//! Wavefront OBJ and MTL: polygons with their normals and places in textures; of materials `Kd`, `map_Kd` and `d`.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec2, Vec3};

use super::files::Files;
use super::picture::Pictures;
use super::{Texture, Wrap};
use crate::model::contents::{MOST_CORNERS, within};
use crate::model::{Clause, MOST_TRIANGLES, Material, Model, ModelPart};
use hedgehop_base::document::unmarked;
use hedgehop_base::error::Result;

/// Opacity below which a part is not shown.
const SEEN_THROUGH: f32 = 0.5;

/// A corner of a face: position, place in the texture, normal.
type Corner = [Option<usize>; 3];

/// State of reading: the file's contents so far.
#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    /// Linear, of the positions; as many as these, or none.
    colours: Vec<Vec3>,
    places: Vec<Vec2>,
    normals: Vec<Vec3>,
    materials: BTreeMap<String, Material>,
    pictures: Pictures,
    parts: Vec<Building>,
    /// Index of the part of each material.
    part_of: BTreeMap<Option<String>, usize>,
    current: Option<String>,
    triangles: usize,
}

/// A part while its corners come.
struct Building {
    part: ModelPart,
    known: HashMap<Corner, u32>,
    has_normals: bool,
    has_places: bool,
}

/// Y is up, and the front looks along −Z, as most programs write it.
fn axes() -> DMat3 {
    DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y)
}

pub(super) fn read(bytes: &[u8], files: &mut Files<'_>) -> Result<Model> {
    let text = String::from_utf8_lossy(files.text(bytes)?);
    let mut reader = Reader::default();
    let mut notes = Vec::new();
    for (number, line) in lines(&text) {
        let wrong = |what: String| format!("line {number}: {what}");
        let mut words = line.split_whitespace();
        let Some(word) = words.next() else { continue };
        let rest: Vec<&str> = words.collect();

        let done = match word {
            "v" => reader.position(&rest),
            "vt" => numbers::<2>(&rest).map(|[x, y]| reader.places.push(Vec2::new(x as f32, 1.0 - y as f32))),
            "vn" => {
                numbers::<3>(&rest).map(|normal| reader.normals.push(DVec3::from_array(normal).as_vec3()))
            }
            "f" => reader.face(&rest),
            "usemtl" => {
                let name = line["usemtl".len()..].trim().to_owned();
                reader.current = reader.materials.contains_key(&name).then_some(name);
                Ok(())
            }
            "mtllib" => {
                let name = line["mtllib".len()..].trim();
                reader.library(name, files)?;
                Ok(())
            }
            "p" | "l" => {
                let note = "its points and lines are not shown";
                if !notes.iter().any(|known| known == note) {
                    notes.push(note.to_owned());
                }
                Ok(())
            }
            // Names, groups, smoothing; what is not known is left out, as everybody does.
            _ => Ok(()),
        };

        done.map_err(|what| files.wrong(wrong(what)))?;
    }

    // Parts are faces of one material each.
    let parts: Vec<_> = reader.parts.into_iter().map(Building::done).collect();
    if parts.is_empty() {
        return Err(files.wrong("it has no faces"));
    }

    let mut raw = Model { notes, ..Model::new(axes()) };
    parts.into_iter().for_each(|part| raw.push(part));
    Ok(raw)
}

/// Lines with their numbers, joined where they end in a backslash, without what follows a `#`.
fn lines(text: &str) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    let mut lines = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let plain = |line: &'_ str| line.split('#').next().unwrap_or("").trim().to_owned();
        let mut joined = plain(line);
        while joined.ends_with('\\') {
            joined.pop();
            let Some((_, next)) = lines.next() else { break };
            joined.push(' ');
            joined.push_str(&plain(next));
        }
        Some((number, joined.into()))
    })
}

/// The first numbers of a line.
fn numbers<const N: usize>(words: &[&str]) -> Clause<[f64; N]> {
    let mut numbers = [0.0_f64; N];
    for (index, number) in numbers.iter_mut().enumerate() {
        let word = words.get(index).ok_or_else(|| format!("it has {index} of {N} numbers"))?;
        *number = word.parse().map_err(|_| format!("{word:?} is no number"))?;
        if !number.is_finite() {
            return Err(format!("{word} is not finite"));
        }
    }
    Ok(numbers)
}

impl Reader {
    fn position(&mut self, words: &[&str]) -> Clause<()> {
        within("corners", self.positions.len(), MOST_CORNERS)?;
        let place = DVec3::from_array(numbers::<3>(words)?);
        // Six numbers: a colour follows, by a custom that is wide-spread.
        if let Some(colour) = words.get(3..6) {
            let colour = numbers::<3>(colour)?.map(hedgehop_base::colour::linear_from_encoded);
            self.colours.resize(self.positions.len(), Vec3::ONE);
            self.colours.push(DVec3::from_array(colour).as_vec3());
        } else if !self.colours.is_empty() {
            self.colours.push(Vec3::ONE);
        }
        self.positions.push(place);
        Ok(())
    }

    fn face(&mut self, words: &[&str]) -> Clause<()> {
        let corners = words.iter().map(|word| self.corner(word)).collect::<Clause<Vec<_>>>()?;
        let [first, rest @ ..] = corners.as_slice() else { return Err("a face without corners".to_owned()) };
        self.triangles += rest.len().saturating_sub(1);
        within("triangles", self.triangles, MOST_TRIANGLES)?;
        let material = self.current.as_ref().and_then(|name| self.materials.get(name));
        if material.is_some_and(|material| material.cutoff.is_some() && material.texture.is_none()) {
            return Ok(());
        }

        let material = material
            .cloned()
            .unwrap_or_else(|| Material::of((!self.colours.is_empty()).then_some(Vec3::ONE)));
        let part = *self.part_of.entry(self.current.clone()).or_insert_with(|| {
            self.parts.push(Building::new(material));
            self.parts.len() - 1
        });
        let mut building = std::mem::replace(&mut self.parts[part], Building::new(Material::of(None)));
        let first = building.corner(self, first);
        let mut before = None;

        for corner in rest {
            let corner = building.corner(self, corner);
            if let Some(before) = before.replace(corner) {
                building.part.triangles.push([first, before, corner]);
            }
        }

        self.parts[part] = building;
        Ok(())
    }

    /// `position/place/normal`, of which the last two may be left out; negative numbers count backward.
    fn corner(&self, word: &str) -> Clause<Corner> {
        let counts = [self.positions.len(), self.places.len(), self.normals.len()];
        let mut corner = [None; 3];
        let mut parts = word.split('/');
        for (index, count) in counts.into_iter().enumerate() {
            let Some(part) = parts.next().filter(|part| !part.is_empty()) else { continue };
            let number: i64 = part.parse().map_err(|_| format!("{word:?} is no corner of a face"))?;
            let place = if number < 0 { (count as i64).checked_add(number) } else { number.checked_sub(1) };
            let place = place.and_then(|place| usize::try_from(place).ok()).filter(|place| *place < count);
            corner[index] = Some(place.ok_or_else(|| format!("{word:?} names number {number} of {count}"))?);
        }
        if corner[0].is_none() || parts.next().is_some() {
            return Err(format!("{word:?} is no corner of a face"));
        }
        Ok(corner)
    }

    /// Reads a file of materials.
    fn library(&mut self, name: &str, files: &mut Files<'_>) -> Result<()> {
        let bytes = files.beside(name)?;
        let text = String::from_utf8_lossy(unmarked(name.as_ref(), &bytes)?);
        let mut current: Option<(String, Material)> = None;
        for (number, line) in lines(&text) {
            let wrong = |what: String| format!("{name}, line {number}: {what}");
            let mut words = line.split_whitespace();
            let Some(word) = words.next() else { continue };
            let rest: Vec<&str> = words.collect();
            if word == "newmtl" {
                self.materials.extend(current.take());
                current =
                    Some((line["newmtl".len()..].trim().to_owned(), Material::of(Some(Vec3::splat(0.8)))));
                continue;
            }

            // Other lines say more of the material that was named last.
            let Some((_, material)) = &mut current else { continue };
            let opacity = |value: f64, material: &mut Material| {
                material.alpha = value as f32;
                material.cutoff = (material.alpha < SEEN_THROUGH).then_some(SEEN_THROUGH);
            };

            let done = match word {
                // Values are those of the screen in most programs that write them, but meant as light by the format's description.
                "Kd" => numbers::<3>(&rest).map(|colour| {
                    material.colour = Some(DVec3::from_array(colour).as_vec3().clamp(Vec3::ZERO, Vec3::ONE));
                }),
                "d" => numbers::<1>(&rest).map(|[value]| opacity(value, material)),
                "Tr" => numbers::<1>(&rest).map(|[value]| opacity(1.0 - value, material)),
                "map_Kd" => {
                    let (texture, wrap) = options(&rest);
                    let texture = self.texture(&texture, wrap, files)?;
                    // The picture has the colour; many files write Kd 0 0 0 beside it.
                    material.colour = Some(Vec3::ONE);
                    material.texture = Some(texture);
                    Ok(())
                }
                _ => Ok(()),
            };

            done.map_err(|what| files.wrong(wrong(what)))?;
        }

        self.materials.extend(current);
        Ok(())
    }

    fn texture(&mut self, name: &str, wrap: [Wrap; 2], files: &mut Files<'_>) -> Result<Arc<Texture>> {
        let bytes = files.beside(name)?;
        self.pictures.decode(&bytes, wrap).map_err(|what| files.wrong(format!("texture {name}: {what}")))
    }
}

/// The file's name of a `map_Kd`, and how its options let it go on.
fn options(words: &[&str]) -> (String, [Wrap; 2]) {
    let mut wrap = Wrap::Repeat;
    let mut rest = words;
    while let [option, after @ ..] = rest
        && option.starts_with('-')
    {
        let values = match *option {
            "-o" | "-s" | "-t" => {
                after.iter().take(3).take_while(|value| value.parse::<f64>().is_ok()).count()
            }
            "-mm" => 2,
            _ => 1,
        };
        if *option == "-clamp" && after.first() == Some(&"on") {
            wrap = Wrap::Clamp;
        }
        rest = after.get(values..).unwrap_or_default();
    }
    (rest.join(" "), [wrap; 2])
}

impl Building {
    fn new(material: Material) -> Self {
        let part = ModelPart {
            positions: Vec::new(),
            normals: Vec::new(),
            places: Vec::new(),
            colours: Vec::new(),
            triangles: Vec::new(),
            material,
            node: None,
        };
        Self { part, known: HashMap::new(), has_normals: true, has_places: true }
    }

    /// Number of a corner.
    fn corner(&mut self, reader: &Reader, corner: &Corner) -> u32 {
        if let Some(known) = self.known.get(corner) {
            return *known;
        }
        let [position, place, normal] = *corner;
        let position = position.unwrap_or(0);
        let number = self.part.positions.len() as u32;
        self.known.insert(*corner, number);
        self.part.positions.push(reader.positions[position]);
        self.part.colours.extend(reader.colours.get(position));
        self.has_places &= place.is_some();
        self.part.places.push(place.map_or(Vec2::ZERO, |place| reader.places[place]));
        self.has_normals &= normal.is_some();
        // Corners without one have that of their triangle.
        self.part.normals.push(normal.map_or(Vec3::ZERO, |normal| reader.normals[normal]));
        number
    }

    fn done(mut self) -> ModelPart {
        if !self.has_normals {
            self.part.normals.clear();
        }
        if !self.has_places {
            self.part.places.clear();
        }
        self.part
            .colours
            .resize(if self.part.colours.is_empty() { 0 } else { self.part.positions.len() }, Vec3::ONE);
        self.part
    }
}
