//! Labels: what each pixel shows, as numbers that training reads.
//!
//! | kind | PNG | a pixel |
//! |---|---|---|
//! | semantic | 8 bits, indexed | number of the ground's material, [`OBJECT`] or [`SKY`]; PLTE has their colours |
//! | instance | 16 bits, grey | 0, or the number of an object of the scene, counted from 1 |
//!
//! Both are [`Frame::id`] again, pixel by pixel. `palette.json` beside them names the numbers of both.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::encode::ours::check_ours;
use crate::encode::png::{self, PngPixels};
use crate::encode::{FrameInfo, Written, atomic};
use crate::frame::Frame;
use crate::voxel::{Material, Metadata};
use hedgehop_base::error::{Error, Result};

/// Name of the file that names the numbers.
pub const PALETTE: &str = "palette.json";
/// Index of pixels that show an object of the scene.
pub const OBJECT: u8 = 254;
/// Index of pixels that show the sky, or nothing.
pub const SKY: u8 = 255;

/// Colour of objects, which no material has.
const OBJECT_COLOUR: [u8; 3] = [255; 3];
/// Colour of the sky.
const SKY_COLOUR: [u8; 3] = [70, 130, 180];

/// Kind of labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabelKind {
    /// Materials, objects, sky.
    Semantic,
    /// Objects one by one.
    Instance,
}

/// Numbers that labels may hold, and their names.
#[derive(Debug, Clone)]
pub struct LabelTable {
    palette: Palette,
    /// Instance of each body by its number.
    instances: Vec<u16>,
}

/// `palette.json`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Palette {
    /// Program and version.
    program: String,
    semantic: Vec<SemanticEntry>,
    instance: Vec<InstanceEntry>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct SemanticEntry {
    index: u8,
    name: String,
    /// Colour in PLTE, sRGB.
    colour: [u8; 3],
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct InstanceEntry {
    index: u16,
    name: String,
}

impl LabelTable {
    /// Names the numbers of a database and of a scene, of which `bodies` has the name of each body's object; bodies of one name are one
    /// instance. `program` is name and version of the writer.
    ///
    /// # Errors
    /// [`Error::Configuration`] for materials or objects whose numbers labels cannot hold.
    pub fn new(program: &str, metadata: &Metadata, bodies: &[String]) -> Result<Self> {
        let own = |number: u8| metadata.materials.iter().find(|record| record.number == number);
        if let Some(record) = [OBJECT, SKY].into_iter().find_map(own) {
            return Err(Error::Configuration(format!(
                "the database's material {} has the number {}, and labels have {OBJECT} for objects and {SKY} for the sky; \
                 build it with another number",
                record.name, record.number
            )));
        }

        let entry = |material: Material| {
            let index = material.code();
            SemanticEntry { index, name: metadata.material_name(index), colour: colour(index) }
        };
        let mut semantic: Vec<_> =
            [Material::Unknown].into_iter().chain(Material::ALL.iter().copied()).map(entry).collect();
        let own = metadata.materials.iter().map(|record| Material::of_code(record.number));
        semantic.extend(own.filter(|material| matches!(material, Material::Own(_))).map(entry));
        semantic.sort_by_key(|entry| entry.index);
        let fixed = [(OBJECT, "object"), (SKY, "sky")];
        semantic.extend(fixed.map(|(index, name)| SemanticEntry {
            index,
            name: name.to_owned(),
            colour: colour(index),
        }));

        let (mut instance, mut instances, mut known) = (Vec::new(), Vec::new(), BTreeMap::new());
        for name in bodies {
            let next = u16::try_from(known.len() + 1).map_err(|_| {
                Error::Configuration(
                    "the scene has more objects than --labels instance has numbers, 65535; leave some out"
                        .into(),
                )
            })?;
            let index = *known.entry(name).or_insert(next);
            instances.push(index);
            if index == next {
                instance.push(InstanceEntry { index, name: name.clone() });
            }
        }

        Ok(Self { palette: Palette { program: program.to_owned(), semantic, instance }, instances })
    }

    /// Refuses a folder whose `palette.json` somebody else wrote: a run would replace it.
    pub fn check_folder(folder: &Path) -> Result<()> {
        check_ours(&folder.join(PALETTE), &|text| serde_json::from_str::<Palette>(text).is_ok())
    }

    /// Writes `palette.json` into a folder.
    pub fn write_palette(&self, folder: &Path) -> Result<()> {
        let path = folder.join(PALETTE);
        let mut bytes = serde_json::to_vec_pretty(&self.palette)
            .map_err(|error| Error::invalid(&path, format!("the palette is no JSON: {error}")))?;
        bytes.push(b'\n');
        atomic::write_bytes(&path, &bytes)
    }

    /// Writes the labels of a frame as PNG. The file appears whole or not at all, and the same frame always gives the same bytes.
    ///
    /// # Errors
    /// A frame with a body that the table does not know; a file that cannot be written.
    pub fn write(&self, path: &Path, kind: LabelKind, frame: &Frame, info: &FrameInfo) -> Result<Written> {
        frame.check_lengths(path)?;
        let encode = |pixels| png::encode(path, pixels, &frame.camera, info);
        let bytes = match kind {
            LabelKind::Semantic => {
                let palette: Vec<u8> = (0..=u8::MAX).flat_map(colour).collect();
                let indices: Vec<u8> = frame.id.iter().map(|id| semantic(*id)).collect();
                encode(PngPixels::Indexed { indices: &indices, palette: &palette })?
            }
            LabelKind::Instance => {
                let of = |id: &u32| {
                    let unknown =
                        || Error::invalid(path, format!("the scene names no object of the id {id}"));
                    self.instance(*id).ok_or_else(unknown)
                };
                let numbers: Vec<u16> = frame.id.iter().map(of).collect::<Result<_>>()?;
                encode(PngPixels::Grey(&numbers))?
            }
        };
        atomic::write_bytes(path, &bytes)?;
        Ok(Written::from_bytes(&bytes))
    }

    /// The object of an id, counted from 1; 0 of ground and sky.
    fn instance(&self, id: u32) -> Option<u16> {
        match Frame::body_of(id) {
            Some(body) => self.instances.get(body as usize).copied(),
            None => Some(0),
        }
    }
}

/// Turns an id into the number of a material, [`OBJECT`] or [`SKY`].
fn semantic(id: u32) -> u8 {
    match Frame::material_of(id) {
        Some(material) => material.code(),
        None if id == Frame::SKY_ID => SKY,
        None => OBJECT,
    }
}

fn colour(index: u8) -> [u8; 3] {
    match index {
        OBJECT => OBJECT_COLOUR,
        SKY => SKY_COLOUR,
        material => Material::of_code(material).mark(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::testing;
    use crate::voxel::MaterialRecord;

    fn metadata(number: u8) -> Metadata {
        let record =
            MaterialRecord { number, name: "lava".into(), like: Some("rock".into()), colour: [200, 40, 10] };
        Metadata { materials: vec![record], ..Metadata::default() }
    }

    #[test]
    fn numbers_have_names_and_colours_of_their_own() {
        let bodies = ["truck", "glider", "truck", "truck"].map(str::to_owned);
        let table = LabelTable::new("hedgehop 1", &metadata(200), &bodies).unwrap();
        let named: Vec<_> =
            table.palette.semantic.iter().map(|entry| (entry.index, entry.name.as_str())).collect();
        assert_eq!(named.len(), 1 + Material::ALL.len() + 3);
        assert_eq!((named[0], named[1]), ((0, "unknown"), (1, "water")));
        assert_eq!(named[named.len() - 3..], [(200, "lava"), (254, "object"), (255, "sky")]);

        let mut colours: Vec<_> = table.palette.semantic.iter().map(|entry| entry.colour).collect();
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), named.len());
        assert_eq!(table.instances, [1, 2, 1, 1]);
        let instances: Vec<_> =
            table.palette.instance.iter().map(|entry| (entry.index, entry.name.as_str())).collect();
        assert_eq!(instances, [(1, "truck"), (2, "glider")]);
    }

    #[test]
    fn numbers_that_mean_something_else_are_refused() {
        for number in [OBJECT, SKY] {
            let said = LabelTable::new("hedgehop 1", &metadata(number), &[]).unwrap_err().to_string();
            assert!(said.contains("lava") && said.contains("another number"), "{said}");
        }
        let many: Vec<String> = (0..65_536).map(|number| number.to_string()).collect();
        assert!(LabelTable::new("hedgehop 1", &Metadata::default(), &many[1..]).is_ok());
        let said = LabelTable::new("hedgehop 1", &Metadata::default(), &many).unwrap_err().to_string();
        assert!(said.contains("65535"), "{said}");
    }

    #[test]
    fn another_reader_sees_the_ids() {
        let (folder, path) = testing::place("0042.png");
        let mut frame = testing::frame(4, 2);
        frame.id = vec![
            7 << 16 | 14 << 8 | 3,
            200 << 8,
            0,
            Frame::SKY_ID,
            Frame::body_id(0),
            Frame::body_id(3),
            1,
            2,
        ];
        let bodies = ["truck", "glider", "truck", "tower"].map(str::to_owned);
        let table = LabelTable::new("hedgehop 1", &metadata(200), &bodies).unwrap();

        table.write(&path, LabelKind::Semantic, &frame, &testing::info()).unwrap();
        let mut reader = ::png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        reader.set_transformations(::png::Transformations::IDENTITY);
        let mut reader = reader.read_info().unwrap();
        let mut indices = vec![0; 8];
        reader.next_frame(&mut indices).unwrap();
        assert_eq!(indices, [14, 200, 0, 255, 254, 254, 0, 0]);
        assert_eq!(reader.info().color_type, ::png::ColorType::Indexed);
        let palette = reader.info().palette.clone().unwrap();
        for entry in &table.palette.semantic {
            let at = 3 * usize::from(entry.index);
            assert_eq!(palette[at..at + 3], entry.colour, "{}", entry.name);
        }

        table.write(&path, LabelKind::Instance, &frame, &testing::info()).unwrap();
        let picture = image::open(&path).unwrap();
        assert!(matches!(picture, image::DynamicImage::ImageLuma16(_)));
        assert_eq!(picture.into_luma16().into_raw(), [0, 0, 0, 0, 1, 3, 0, 0]);

        frame.id[6] = Frame::body_id(4);
        let said = table.write(&path, LabelKind::Instance, &frame, &testing::info()).unwrap_err();
        assert!(said.to_string().contains("names no object"), "{said}");
        drop(folder);
    }

    #[test]
    fn palettes_of_others_stay() {
        let (_folder, path) = testing::place("0042.png");
        let folder = path.parent().unwrap();
        LabelTable::check_folder(folder).unwrap();
        let table = LabelTable::new("hedgehop 1", &Metadata::default(), &[]).unwrap();
        table.write_palette(folder).unwrap();
        LabelTable::check_folder(folder).unwrap();
        std::fs::write(folder.join(PALETTE), "{\"colours\": []}").unwrap();
        assert!(LabelTable::check_folder(folder).unwrap_err().to_string().contains("palette.json"));
    }
}
