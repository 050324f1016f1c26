//! Databases, rasters by their tags, and whether one lies where the other says.

use std::path::Path;

use glam::DVec2;
use tempfile::TempDir;

use hedgehop::geo::{Crs, Transform};
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::raymarch::ground_height;
use hedgehop::voxel::{Attributes, PAGE_SIDE, PageId, PageSource};
use hedgehop_modeling::raster::{OpenOptions, Window, open};
use hedgehop_modeling::{BuildOptions, build};

/// What a raster is, from its tags.
pub struct Lattice {
    pub file: &'static str,
    /// EPSG code of its coordinates.
    pub crs: u32,
    /// West and north edge of the north-west pixel; width and height of a pixel.
    pub west: f64,
    pub north: f64,
    pub pixel: [f64; 2],
}

/// One band of a raster, `[height][width]` from the north; NaN where there is no data.
struct Band {
    size: [usize; 2],
    values: Vec<f64>,
}

/// A finished database.
pub struct Area {
    file: PageFile,
    crs: Crs,
    _folder: TempDir,
}

impl Area {
    fn build(
        folder: &Path,
        elevation: &Lattice,
        imagery: &Lattice,
        adjust: impl Fn(&mut BuildOptions),
    ) -> Self {
        let output = tempfile::tempdir().unwrap();
        let mut options = BuildOptions::new(
            vec![folder.join(elevation.file)],
            vec![folder.join(imagery.file)],
            output.path().join("area.hop"),
        );
        adjust(&mut options);
        build(&options, &Silent).unwrap();
        let file = PageFile::open(&options.output).unwrap();
        let metadata = &file.header().metadata;
        let crs =
            Crs::from_record(&metadata.crs_name, metadata.crs_epsg, metadata.crs_proj.as_deref()).unwrap();
        Self { file, crs, _folder: output }
    }

    fn size(&self) -> [u32; 2] {
        let grid = self.file.header().grid;
        [grid.nx, grid.ny]
    }

    /// World position of a voxel's centre.
    pub fn centre(&self, [x, y]: [u32; 2]) -> DVec2 {
        let grid = self.file.header().grid;
        grid.origin + DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * grid.spacing
    }

    pub fn height(&self, voxel: [u32; 2]) -> f64 {
        ground_height(&self.file, self.centre(voxel)).unwrap().unwrap_or(f64::NAN)
    }

    /// Linear light of a channel; NaN where no imagery lies.
    pub fn light(&self, [x, y]: [u32; 2], channel: usize) -> f64 {
        let id = PageId { level: 0, px: x / PAGE_SIDE, py: y / PAGE_SIDE };
        let page = self.file.page(id).unwrap().unwrap();
        let (x, y) = (x % PAGE_SIDE, y % PAGE_SIDE);
        if page.attributes_at(x, y).flags & Attributes::NO_IMAGERY != 0 {
            return f64::NAN;
        }
        linear(page.colours[page.sample(x, y)][channel])
    }

    /// At most about 20,000 voxels, evenly spread.
    fn some_voxels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [nx, ny] = self.size();
        let step = (f64::from(nx) * f64::from(ny) / 20_000.0).sqrt().ceil() as usize;
        (0..ny).step_by(step).flat_map(move |y| (0..nx).step_by(step).map(move |x| [x, y]))
    }
}

/// Linear light of an sRGB code (IEC 61966-2-1).
pub fn linear(code: u8) -> f64 {
    let encoded = f64::from(code) / 255.0;
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

impl Band {
    /// Reads all bands; `value` makes one of a pixel's raw samples.
    fn read(folder: &Path, lattice: &Lattice, value: impl Fn(&[f64]) -> f64) -> Self {
        let raster = open(&folder.join(lattice.file), &OpenOptions::default()).unwrap();
        let info = raster.info();
        let bands: Vec<u32> = (0..info.bands).collect();
        let mut samples = Vec::new();
        let whole = Window { x: 0, y: 0, width: info.width, height: info.height };
        raster.read(whole, &bands, &mut samples).unwrap();
        Self {
            size: [info.width as usize, info.height as usize],
            values: samples.chunks(bands.len()).map(value).collect(),
        }
    }

    /// Mean under a tent of `radius` pixels around a place (pixels from the north-west corner), and by how
    /// much the pixels under it differ. `None` where one is missing.
    fn mean(&self, place: DVec2, radius: DVec2) -> Option<(f64, f64)> {
        let centre = place - 0.5;
        let (first, last) = ((centre - radius).ceil(), (centre + radius).floor());
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        if first.min_element() < 0.0 || last.cmpge(size).any() {
            return None;
        }

        let (mut sum, mut weights) = (0.0, 0.0);
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for row in first.y as usize..=last.y as usize {
            for column in first.x as usize..=last.x as usize {
                let away = (DVec2::new(column as f64, row as f64) - centre).abs() / radius;
                let weight = (1.0 - away.x) * (1.0 - away.y);
                let value = self.values[row * self.size[0] + column];
                sum += weight * value;
                weights += weight;
                (least, most) = (least.min(value), most.max(value));
            }
        }

        (!sum.is_nan()).then_some((sum / weights, most - least))
    }
}

/// A voxel's value and where it lies in a raster.
struct Probe {
    value: f64,
    /// Pixels from the raster's north-west corner.
    place: DVec2,
    /// Of the tent, pixels.
    radius: DVec2,
}

fn probes(area: &Area, lattice: &Lattice, value: impl Fn([u32; 2]) -> f64) -> Vec<Probe> {
    let crs = Crs::from_epsg(lattice.crs).unwrap();
    let transform = Transform::new(&area.crs, &crs).unwrap();
    let place = |world: DVec2| {
        let (x, y) = transform.apply(world.x, world.y)?;
        Some(DVec2::new((x - lattice.west) / lattice.pixel[0], (lattice.north - y) / lattice.pixel[1]))
    };
    let half = 0.5 * area.file.header().grid.spacing;
    area.some_voxels()
        .filter_map(|voxel| {
            let world = area.centre(voxel);
            let east = place(world + DVec2::X * half)? - place(world - DVec2::X * half)?;
            let north = place(world + DVec2::Y * half)? - place(world - DVec2::Y * half)?;
            let radius = DVec2::new(east.x.hypot(north.x), east.y.hypot(north.y)).max(DVec2::ONE);
            let value = value(voxel);
            (!value.is_nan()).then_some(Probe { value, place: place(world)?, radius })
        })
        .collect()
}

/// Where a file is sharpened, colours lie between those of the nearest pixels; `share` of their difference is how far
/// from the tent's mean they may be. Positions are interpolated to a twentieth of a pixel.
#[track_caller]
fn assert_registered(name: &str, probes: &[Probe], band: &Band, step: f64, share: f64) {
    let mut checked = 0;
    for probe in probes {
        if let Some((mean, spread)) = band.mean(probe.place, probe.radius) {
            checked += 1;
            let wrong = (probe.value - mean).abs();
            let allowed = step + share * spread;
            assert!(wrong <= allowed, "{name}: {} for {mean} (± {allowed}) at {}", probe.value, probe.place);
        }
    }

    assert!(checked > 2000 && checked * 2 > probes.len(), "{name}: only {checked} of {}", probes.len());

    // Mean square differences, if the raster lay half a pixel to either side: their parabola's foot is where it lies.
    let misfit = |shift: DVec2| {
        let differences: Vec<f64> = probes
            .iter()
            .filter_map(|probe| Some(probe.value - band.mean(probe.place + shift, probe.radius)?.0))
            .collect();
        differences.iter().map(|difference| difference * difference).sum::<f64>() / differences.len() as f64
    };

    let here = misfit(DVec2::ZERO);
    for (axis, half) in [("east", DVec2::X * 0.5), ("south", DVec2::Y * 0.5)] {
        let (before, after) = (misfit(-half), misfit(half));
        assert!(2.0 * here < before.min(after), "{name} {axis}: {before} {here} {after}");
        let foot = 0.25 * (before - after) / (before + after - 2.0 * here);
        assert!(foot.abs() < 0.05, "{name} lies {foot} pixels {axis} of where it should");
    }
}

/// Builds a pair and checks both of its rasters. `height` and `light` (linear, of channel 0) make values of raw
/// samples, NaN for no data.
pub fn check_pair(
    folder: &Path,
    elevation: &Lattice,
    imagery: &Lattice,
    adjust: impl Fn(&mut BuildOptions),
    height: impl Fn(&[f64]) -> f64,
    light: impl Fn(&[f64]) -> f64,
) -> Area {
    let area = Area::build(folder, elevation, imagery, adjust);
    let heights = probes(&area, elevation, |voxel| area.height(voxel));
    let step = 0.51 * area.file.header().heights.scale;
    assert_registered(elevation.file, &heights, &Band::read(folder, elevation, height), step, 0.1);
    let lights = probes(&area, imagery, |voxel| area.light(voxel, 0));
    // Half a code of sRGB is up to 0.0045 of linear light.
    assert_registered(imagery.file, &lights, &Band::read(folder, imagery, light), 0.005, 0.35);
    area
}

/// Correlation of a voxel's mask with the light of another one, `shift` voxels away.
fn correlation(
    area: &Area,
    mask: impl Fn([u32; 2]) -> Option<bool>,
    light: impl Fn([u32; 2]) -> f64,
    shift: [i64; 2],
) -> f64 {
    let size = area.size();
    let [mut count, mut x, mut y, mut xx, mut yy, mut xy] = [0.0; 6];
    for voxel in area.some_voxels() {
        let other = [0, 1].map(|axis| i64::from(voxel[axis]) + shift[axis]);
        if (0..2).any(|axis| !(0..i64::from(size[axis])).contains(&other[axis])) {
            continue;
        }
        let (Some(mask), light) = (mask(voxel), light(other.map(|index| index as u32))) else { continue };
        if !light.is_nan() {
            let mask = f64::from(u8::from(mask));
            count += 1.0;
            (x, y) = (x + mask, y + light);
            (xx, yy, xy) = (xx + mask * mask, yy + light * light, xy + mask * light);
        }
    }
    (count * xy - x * y) / ((count * xx - x * x) * (count * yy - y * y)).sqrt()
}

#[track_caller]
pub fn assert_coast(
    area: &Area,
    mask: impl Fn([u32; 2]) -> Option<bool>,
    light: impl Fn([u32; 2]) -> f64,
    least: f64,
) {
    let here = correlation(area, &mask, &light, [0, 0]);
    assert!(here > least, "land and its colour correlate by {here} only");
    for shift in [[3, 0], [-3, 0], [0, 3], [0, -3], [3, 3], [3, -3], [-3, 3], [-3, -3]] {
        let there = correlation(area, &mask, &light, shift);
        assert!(there < here, "imagery shifted by {shift:?} voxels fits better: {there}, {here}");
    }
}
