//! Classes from a raster of samples: the number of a material for each pixel, 0 where none is known.

use super::scheme::Scheme;
use crate::kernel::Samples;
use crate::raster::{Raster, RasterInfo, SampleType, Window};
use hedgehop::Size;
use hedgehop_base::error::{Error, Result};

/// A raster of classes.
pub(crate) struct ClassRaster {
    raster: Box<dyn Raster>,
    /// The band of classes, and the alpha band if there is one.
    bands: Vec<u32>,
    /// Class of each sample of 16 bits (two's complement).
    classes: Vec<SampleClass>,
}

/// Class that a sample states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SampleClass {
    /// A material, by its number.
    Known(u8),
    /// Nothing is known there.
    Void,
    /// A number that the scheme does not have.
    Unknown(i32),
}

impl ClassRaster {
    /// Takes the first band of `raster` that is no alpha; `nodata` are samples that say nothing besides what the file declares.
    ///
    /// # Errors
    /// A raster that holds no classes.
    pub fn new(raster: Box<dyn Raster>, scheme: &Scheme, nodata: &[f64]) -> Result<Self> {
        let info = raster.info();
        if !matches!(info.sample, SampleType::U8 | SampleType::I8 | SampleType::U16 | SampleType::I16) {
            let what = format!(
                "holds {} samples, and classes are whole numbers of 8 or 16 bits",
                info.sample.name()
            );
            return Err(Error::unsupported(
                &info.path,
                what,
                "convert it: gdal_translate -ot UInt16 IN out.tif",
            ));
        }

        let seen: Vec<u32> = info.seen_bands().collect();
        if seen.len() >= 3 {
            let what =
                format!("holds {} bands and looks like a picture of classes, not like classes", seen.len());
            let remedy =
                "name the raster of the classes themselves, or take one band: gdal_translate -b 1 IN out.tif";
            return Err(Error::unsupported(&info.path, what, remedy));
        }
        let Some(band) = seen.first().copied() else {
            return Err(Error::invalid(&info.path, "holds an alpha band only, no classes"));
        };

        let bands = std::iter::once(band).chain(info.alpha_band).collect();
        let voids: Vec<f64> = info.nodata_of(band).iter().chain(nodata).copied().collect();
        let class = |number: u16| {
            let is_signed = matches!(info.sample, SampleType::I8 | SampleType::I16);
            let sample = if is_signed { f64::from(number as i16) } else { f64::from(number) };
            match scheme.material(number) {
                _ if voids.contains(&sample) || scheme.is_void(number) => SampleClass::Void,
                Some(material) => SampleClass::Known(material.code()),
                None => SampleClass::Unknown(sample as i32),
            }
        };

        let classes = (0..=u16::MAX).map(class).collect();
        Ok(Self { raster, bands, classes })
    }

    /// Says which of the file's statements are not used.
    pub fn notes(&self) -> Vec<String> {
        let info = self.info();
        let is_scaled = (info.scale, info.offset) != (1.0, 0.0);
        let name = info.path.file_name().unwrap_or_default().to_string_lossy();
        let note = format!("{name}: states a scale and an offset, and classes are taken as they are stored");
        is_scaled.then_some(note).into_iter().collect()
    }

    /// Returns the raster's properties.
    pub fn info(&self) -> &RasterInfo {
        self.raster.info()
    }
}

impl Samples<SampleClass> for ClassRaster {
    fn size(&self) -> Size {
        self.info().size()
    }

    fn read(&self, window: Window, classes: &mut Vec<SampleClass>) -> Result<()> {
        let mut samples = Vec::new();
        self.raster.read(window, &self.bands, &mut samples)?;
        classes.clear();
        classes.extend(samples.chunks_exact(self.bands.len()).map(|pixel| match pixel {
            [_, 0.0] => SampleClass::Void,
            // Samples have 16 bits at most.
            pixel => self.classes[usize::from(pixel[0] as i32 as u16)],
        }));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::raster::testing::raster;
    use hedgehop::voxel::Material;

    #[test]
    fn samples_are_classes_voids_or_unknown() {
        let own = Scheme::Own(BTreeMap::from([(1, Material::Sand), (700, Material::Water)]));
        let mut sheet = raster(SampleType::I16, 1, &[1.0, 700.0, 9.0, -5.0, -1.0, 2.0]);
        sheet.0.nodata = Some(-1.0);
        let classes = ClassRaster::new(Box::new(sheet), &own, &[2.0]).unwrap();
        let mut read = Vec::new();
        classes.read(Window { x: 0, y: 0, width: 6, height: 1 }, &mut read).unwrap();
        let wanted = [
            SampleClass::Known(Material::Sand.code()),
            SampleClass::Known(Material::Water.code()),
            SampleClass::Unknown(9),
            SampleClass::Unknown(-5),
            SampleClass::Void,
            SampleClass::Void,
        ];
        assert_eq!(read, wanted);
    }

    #[test]
    fn nothing_is_known_where_a_mask_says_so() {
        let mut sheet = raster(SampleType::U8, 2, &[1.0, 255.0, 1.0, 0.0]);
        (sheet.0.alpha_band, sheet.0.scale) = (Some(1), 2.0);
        let own = Scheme::Own(BTreeMap::from([(1, Material::Sand)]));
        let classes = ClassRaster::new(Box::new(sheet), &own, &[]).unwrap();
        let mut read = Vec::new();
        classes.read(Window { x: 0, y: 0, width: 2, height: 1 }, &mut read).unwrap();
        assert_eq!(read, [SampleClass::Known(Material::Sand.code()), SampleClass::Void]);
        assert!(classes.notes()[0].contains("as they are stored"), "{:?}", classes.notes());
    }

    #[test]
    fn what_holds_no_classes_is_refused() {
        let refusal = |raster| {
            ClassRaster::new(Box::new(raster), &Scheme::Nlcd, &[]).err().map(|error| error.to_string())
        };
        assert!(refusal(raster(SampleType::F32, 1, &[11.0])).unwrap().contains("whole numbers"));
        assert!(refusal(raster(SampleType::U8, 3, &[1.0, 2.0, 3.0])).unwrap().contains("picture of classes"));
    }
}
