//! Numbers of a database that detail depends on.

use super::amplitude::material_factor;
use crate::voxel::{Header, Material, Metadata};

/// Classes of material that a voxel can hold.
pub(super) const CLASSES: usize = 256;

/// Height step and factors of materials of a database.
#[derive(Debug, Clone, PartialEq)]
pub struct DetailMeasure {
    /// Step of height codes, in sides of a voxel of the finest level.
    pub height_step: f32,
    /// Factors on amplitudes below the voxel by the number of a class.
    factors: [f32; CLASSES],
}

impl DetailMeasure {
    /// Measures of a database.
    pub fn of(header: &Header) -> Self {
        Self {
            height_step: (header.heights.scale / header.grid.spacing) as f32,
            factors: factors(&header.metadata),
        }
    }

    /// Factor on amplitudes of a class of material by its number.
    #[inline(always)]
    pub fn factor(&self, number: u8) -> f32 {
        self.factors[usize::from(number)]
    }
}

/// Factors of all classes: the program's own, then what the database says of those it names.
fn factors(metadata: &Metadata) -> [f32; CLASSES] {
    let mut factors = std::array::from_fn(|number| material_factor(Material::of_code(number as u8)));
    for record in &metadata.materials {
        factors[usize::from(record.number)] = material_factor(metadata.material(record.number));
    }

    let asked = metadata.detail.iter().flat_map(|detail| &detail.materials);
    for (name, factor) in asked {
        classes_named(metadata, name).for_each(|class| factors[class] = *factor as f32);
    }
    factors
}

/// Iterates over the numbers of the classes of material of a name, a database's own and the program's.
pub(super) fn classes_named(metadata: &Metadata, name: &str) -> impl Iterator<Item = usize> {
    let own = metadata.materials.iter().filter(move |record| record.name == name).map(|record| record.number);
    own.chain(Material::named(name).map(Material::code)).map(usize::from)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::voxel::{DetailRecord, MaterialRecord};

    #[test]
    fn databases_say_factors_of_materials_by_name() {
        let usual = factors(&Metadata::default());
        assert_eq!((usual[2], usual[14], usual[0], usual[255]), (0.5, 1.0, 1.0, 1.0));

        // One of the place's own behaves as another; the names of both kinds are known.
        let turf =
            MaterialRecord { number: 200, name: "turf".into(), like: Some("asphalt".into()), colour: [0; 3] };
        let materials = BTreeMap::from([("grass".to_owned(), 0.25)]);
        let mut metadata = Metadata {
            materials: vec![turf],
            detail: Some(DetailRecord { materials, ..DetailRecord::default() }),
            ..Metadata::default()
        };
        let found = factors(&metadata);
        assert_eq!((found[2], found[14], found[200]), (0.5, 0.25, 0.5));

        metadata.detail = Some(DetailRecord {
            materials: BTreeMap::from([("turf".to_owned(), 2.0)]),
            ..DetailRecord::default()
        });
        let found = factors(&metadata);
        assert_eq!((found[2], found[14], found[200]), (0.5, 1.0, 2.0));
    }
}
