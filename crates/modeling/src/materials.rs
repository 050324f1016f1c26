//! The materials of a place: the table that all places have, and what its recipe says otherwise.
//!
//! ```text
//! colour of a class = what the recipe says | that of the class which it is like | the table's
//! what features and clouds have of a class  = their own colour, moved by as much as the recipe moves that of the class
//! imagery over it                           = mixed with a share of the class's colour
//! ```

use super::features::{PlacedSolid, Solid};
use hedgehop::voxel::{Material, MaterialRecord};
use hedgehop_base::colour::linear_from_srgb8;

/// Finish that a recipe gives to a class.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Finish {
    /// The class.
    pub material: Material,
    /// Name of the class.
    pub name: String,
    /// Class of the table that a place's own class behaves as.
    pub like: Option<Material>,
    /// Colour of the class, sRGB.
    pub colour: Option<[u8; 3]>,
    /// Share of its colour in imagery over it, 0…1.
    pub tint: f32,
}

/// The materials of a place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Materials {
    said: Vec<Finish>,
}

impl Materials {
    /// Builds the classes with what a recipe says of each; later ones hold where a class comes twice.
    pub fn new(mut said: Vec<Finish>) -> Self {
        said.reverse();
        Self { said }
    }

    fn said(&self, material: Material) -> Option<&Finish> {
        self.said.iter().find(|finish| finish.material == material)
    }

    /// The class of a name, the place's own among them.
    pub fn named(&self, name: &str) -> Option<Material> {
        let own = self.said.iter().find(|finish| finish.name == name).map(|finish| finish.material);
        own.or_else(|| Material::named(name))
    }

    /// All names, for people who look for one.
    pub fn names(&self) -> String {
        let own = self.said.iter().rev().filter(|finish| matches!(finish.material, Material::Own(_)));
        let names = Material::ALL.iter().filter_map(|material| material.name());
        names.chain(own.map(|finish| finish.name.as_str())).collect::<Vec<_>>().join(", ")
    }

    /// The colour that a class has without what is said of its colour, sRGB.
    pub(super) fn usual(&self, material: Material) -> [u8; 3] {
        self.like(material).colour()
    }

    /// Colour of a class, sRGB.
    pub fn colour(&self, material: Material) -> [u8; 3] {
        let said = self.said(material).and_then(|finish| finish.colour);
        said.unwrap_or_else(|| self.usual(material))
    }

    /// The class of the table that a class is, or behaves as.
    pub(super) fn like(&self, material: Material) -> Material {
        self.said(material).and_then(|finish| finish.like).unwrap_or(material)
    }

    /// Numbers of these classes, and of those that behave as one of them.
    pub(super) fn numbers_of(&self, classes: &[Material]) -> Classes {
        let mut numbers = Classes::default();
        let asked = |material: Material| classes.contains(&material);
        let all = (1..=u8::MAX).map(|number| (number, Material::of_code(number)));
        all.filter(|(_, material)| asked(*material) || asked(self.like(*material)))
            .for_each(|(number, _)| numbers.add(number));
        numbers
    }

    /// Returns the colour of a class in linear light.
    pub(super) fn linear(&self, material: Material) -> [f32; 3] {
        linear_from_srgb8(self.colour(material))
    }

    /// Share of a class's colour in imagery over it, 0…1.
    pub(super) fn tint(&self, material: Material) -> f32 {
        self.said(material).map_or(0.0, |finish| finish.tint)
    }

    /// A colour that something of a class has by itself, as it is here: what differs from surface to surface goes on differing.
    pub(super) fn moved(&self, material: Material, own: [u8; 3]) -> [u8; 3] {
        let Some(said) = self.said(material).and_then(|finish| finish.colour) else { return own };
        let usual = self.usual(material);
        let code =
            |channel: usize| i16::from(own[channel]) + i16::from(said[channel]) - i16::from(usual[channel]);
        std::array::from_fn(|channel| code(channel).clamp(0, 255) as u8)
    }

    /// A solid in the colours that it has here.
    pub(super) fn dressed(&self, solid: &Solid) -> Solid {
        let material = Material::of_code(solid.material);
        // Below a roof are walls, of which a span does not tell the material.
        let is_roof = matches!(material, Material::RoofTiles | Material::RoofFelt);
        let side = if is_roof { solid.side } else { self.moved(material, solid.side) };
        Solid { top: self.moved(material, solid.top), side, ..*solid }
    }

    /// Gives solids the colours that they have here.
    pub(super) fn dress(&self, solids: &mut [PlacedSolid]) {
        solids.iter_mut().for_each(|placed| placed.solid = self.dressed(&placed.solid));
    }

    /// Returns the database's records of the classes with these numbers.
    pub(super) fn records(&self, numbers: impl Iterator<Item = u8>) -> Vec<MaterialRecord> {
        let record = |number: u8| {
            let material = Material::of_code(number);
            let own = self.said(material).map(|finish| finish.name.clone());
            let name = material.name().map(str::to_owned).or(own);
            let like = self.said(material).and_then(|finish| finish.like);
            MaterialRecord {
                number,
                name: name.unwrap_or_else(|| format!("class {number}")),
                like: like.and_then(Material::name).map(str::to_owned),
                colour: self.colour(material),
            }
        };
        numbers.filter(|number| *number > 0).map(record).collect()
    }
}

/// Set of classes, by their numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Classes(pub [u64; 4]);

impl Classes {
    pub fn add(&mut self, number: u8) {
        self.0[usize::from(number / 64)] |= 1 << (number % 64);
    }

    pub fn has(&self, number: u8) -> bool {
        self.0[usize::from(number / 64)] >> (number % 64) & 1 == 1
    }

    pub fn join(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(word, other)| *word |= other);
    }

    /// Iterates over the numbers, rising.
    pub fn numbers(self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |number| self.has(*number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn materials() -> Materials {
        let asphalt = Finish {
            material: Material::Asphalt,
            name: "asphalt".into(),
            colour: Some([64, 64, 64]),
            ..Finish::default()
        };
        let maize = Finish {
            material: Material::Own(200),
            name: "maize".into(),
            like: Some(Material::Crops),
            tint: 0.3,
            ..Finish::default()
        };
        Materials::new(vec![asphalt, maize])
    }

    #[test]
    fn what_is_said_moves_all_of_a_class() {
        let materials = materials();
        assert_eq!(materials.colour(Material::Asphalt), [64; 3]);
        // The table's asphalt is 92, 92, 94; a parking is 12 lighter, and stays so.
        assert_eq!(materials.moved(Material::Asphalt, [104, 104, 106]), [76; 3]);
        assert_eq!(materials.moved(Material::Asphalt, [5, 5, 5]), [0; 3]);
        assert_eq!(materials.moved(Material::Sand, [9, 8, 7]), [9, 8, 7]);
    }

    #[test]
    fn a_class_of_ones_own_is_like_another() {
        let materials = materials();
        let maize = materials.named("maize").unwrap();
        assert_eq!((maize, materials.colour(maize)), (Material::Own(200), Material::Crops.colour()));
        assert_eq!((materials.tint(maize), materials.tint(Material::Crops)), (0.3, 0.0));
        assert!(materials.names().ends_with("mud, maize"), "{}", materials.names());
        let mut classes = Classes::default();
        [200, 0, 14, 255].into_iter().for_each(|number| classes.add(number));
        let records = materials.records(classes.numbers());
        assert_eq!(records.iter().map(|record| record.number).collect::<Vec<_>>(), [14, 200, 255]);
        assert_eq!((records[0].name.as_str(), records[1].like.as_deref()), ("grass", Some("crop")));
        assert_eq!((records[1].name.as_str(), records[2].name.as_str()), ("maize", "class 255"));
    }
}
