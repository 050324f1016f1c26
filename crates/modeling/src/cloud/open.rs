//! Files of points, opened: where their points lie, and how finely they say it.

use std::path::PathBuf;

use super::super::kernel::Samples;
use super::super::options::{BuildOptions, CloudFile};
use super::super::source_heights::{SourceHeights, Stated};
use super::head::Head;
use super::look::Look;
use crate::naming::{contradiction, crs_label, file_name};
use crate::opened::Opened;
use crate::raster::{GeoTransform, Window};
use hedgehop::Size;
use hedgehop::voxel::limits;
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::Observer;
use hedgehop_geo::{Crs, VerticalCrs, VerticalDatum};

/// Points of the ground that a voxel holds in the mean, if nobody says how large it is.
const WANTED: f64 = 2.0;
/// Sides of voxels that are chosen from, times powers of ten.
const SIDES: [f64; 8] = [1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 5.0, 7.5];
/// Part of a voxel at the rim that is none.
const RIM: f64 = 0.1;
/// Metres of a degree of latitude.
const DEGREE: f64 = 111_320.0;

/// A file of points.
#[derive(Debug)]
pub(crate) struct Cloud {
    pub(super) path: PathBuf,
    pub(super) head: Head,
    pub(super) look: Look,
    pub(super) crs: Crs,
    pub(super) datum: VerticalDatum,
    /// Metres per unit of height.
    pub(super) metres_per_unit: f64,
    /// Nothing is to stand on its ground.
    pub(super) ground_only: bool,
    /// Points on a square metre.
    pub(super) density: f64,
}

impl Cloud {
    /// Whether its points have colours.
    pub fn is_coloured(&self) -> bool {
        self.look.brightest > 0
    }
}

/// Raster that stands for a cloud until its points are sorted: it says nothing.
struct Unread(Size);

impl Samples<f64> for Unread {
    fn size(&self) -> Size {
        self.0
    }
    fn read(&self, window: Window, samples: &mut Vec<f64>) -> Result<()> {
        samples.clear();
        samples.resize(window.width as usize * window.height as usize, f64::NAN);
        Ok(())
    }
}

/// Opens a file: the cloud, its place as that of a raster, and notes on what was assumed. All its points are looked at.
pub(crate) fn open(
    file: &CloudFile,
    options: &BuildOptions,
    observer: &dyn Observer,
) -> Result<(Cloud, Opened<f64>, Vec<String>)> {
    let path = &file.path;
    let name = file_name(path);
    let head = Head::read(path)?;
    let look = Look::at(path, &head, options.threads, observer)?;
    if observer.cancelled() {
        return Err(Error::Interrupted("no database was written".into()));
    }
    if look.used == 0 {
        return Err(Error::invalid(path, "holds nothing but noise and withheld points"));
    }

    let mut notes: Vec<String> = look.contradiction(&name, &head).into_iter().collect();
    let (crs, given) = match (&head.crs, &file.crs) {
        (Some(crs), given) => {
            notes.extend(contradiction(&name, crs, given.as_deref(), "--cloud-crs")?);
            (crs.clone(), VerticalCrs::default())
        }
        (None, Some(text)) => {
            let (crs, vertical) = Crs::with_vertical_from_user(text)?;
            let stated = match &head.crs_problem {
                Some(problem) => format!("states a reference system that is not read ({problem})"),
                None => "states no reference system".to_owned(),
            };
            notes.push(format!("{name}: {stated}, taken as {}, as --cloud-crs says", crs.name()));
            (crs, vertical.unwrap_or_default())
        }
        (None, None) => {
            if let Some(problem) = &head.crs_problem {
                let what = format!("states a reference system that is not understood ({problem})");
                return Err(Error::unsupported(path, what, "name it with --cloud-crs EPSG:…"));
            }
            notes.push(format!(
                "{name}: states no reference system, taken as plain metres (--cloud-crs says otherwise)"
            ));
            (Crs::local(), VerticalCrs::default())
        }
    };

    let bounds = [look.low[0], look.low[1], look.high[0], look.high[1]];
    notes.extend(crs.doubt(bounds).map(|doubt| format!("{name}: {doubt}")));
    plausible(file, &head, &look, &crs)?;
    let stated = Stated { name: &name, file: &head.vertical, given, flag: file.datum, crs: &crs };
    let heights = stated.settle(&mut notes);

    if heights.is_silent {
        notes.push(format!(
            "{name}: states no vertical datum, taken as mean sea level (--src-vdatum says otherwise)"
        ));
    }

    if !look.is_classified() {
        notes.push(format!(
            "{name}: has no points of the ground, and is taken as a surface on which nothing stands"
        ));
    }

    let (east, north) = metres(&look, &crs);
    let area = ((look.high[0] - look.low[0]) * east * (look.high[1] - look.low[1]) * north).max(1.0e-4);
    let density = look.used as f64 / area;
    let ground = if look.is_classified() { look.ground as f64 / area } else { density };

    let spacing = match options.spacing {
        Some(spacing) if spacing.is_finite() && spacing > 0.0 => spacing,
        _ if options.corridors.is_empty() => {
            let spacing = rounded((WANTED / ground).sqrt());
            notes.push(format!(
                "{name}: has {density:.1} points on a square metre, {ground:.1} of them of the ground: good for voxels of {spacing} m"
            ));
            spacing
        }
        _ => rounded((WANTED / ground).sqrt()),
    };

    let (geo, size) = lattice(&look, [spacing / east, spacing / north]);
    if size.iter().any(|size| *size > f64::from(limits::MOST_VOXELS)) {
        let what = format!("reaches over {:.0} x {:.0} voxels of {spacing} m", size[0], size[1]);
        return Err(Error::unsupported(
            path,
            what,
            "give a larger --spacing, or leave out stray points, as `pdal translate FILE OUT.laz outlier` does",
        ));
    }

    let description =
        format!("{} of {} points, {}, {}", head.format, head.count, crs_label(&crs), heights.words());
    let SourceHeights { datum, metres_per_unit, .. } = heights;
    let samples = Box::new(Unread(Size { width: size[0] as u32, height: size[1] as u32 }));
    let facts = format!("{:?}", CloudFile { path: PathBuf::new(), ..file.clone() });

    let opened = Opened {
        path: path.clone(),
        samples,
        block: Size { width: 256, height: 256 },
        geo,
        crs: crs.clone(),
        datum,
        description,
        facts,
    };

    let ground_only = file.ground_only;
    let cloud = Cloud { path: path.clone(), head, look, crs, datum, metres_per_unit, ground_only, density };
    Ok((cloud, opened, notes))
}

/// Refuses coordinates that cannot be what the reference system says.
fn plausible(file: &CloudFile, head: &Head, look: &Look, crs: &Crs) -> Result<()> {
    let (low, high) = (look.low, look.high);
    let is_of_degrees = low[0] >= -180.0 && high[0] <= 360.0 && low[1] >= -90.0 && high[1] <= 90.0;
    if is_of_degrees || !crs.is_geographic() {
        return Ok(());
    }

    let what = format!(
        "its coordinates, {} … {} east and {} … {} north, cannot be degrees of {}",
        low[0],
        high[0],
        low[1],
        high[1],
        crs.name()
    );

    let remedy = if head.crs.is_some() {
        "its reference system is wrong; write the right one with `las2las -epsg …`"
    } else {
        "name the right system with --cloud-crs EPSG:…"
    };

    Err(Error::unsupported(&file.path, what, remedy))
}

/// Metres of a unit eastward and northward, about.
fn metres(look: &Look, crs: &Crs) -> (f64, f64) {
    if !crs.is_geographic() {
        let metres = crs.metres_per_unit().unwrap_or(1.0);
        return (metres, metres);
    }
    let latitude = (0.5 * (look.low[1] + look.high[1])).to_radians();
    (DEGREE * latitude.cos().max(1.0e-3), DEGREE)
}

/// Pixels of these sides about all points, their borders at multiples of the sides.
fn lattice(look: &Look, side: [f64; 2]) -> (GeoTransform, [f64; 2]) {
    let cell = |value: f64, axis: usize| (value / side[axis]).floor();
    let [west, south] = [0, 1].map(|axis| cell(look.low[axis], axis));
    // Where the last points lie on a border they are not worth a voxel more.
    let [east, north] = [0, 1]
        .map(|axis| cell(look.high[axis] - RIM * side[axis], axis).max(cell(look.low[axis], axis)) + 1.0);
    let geo = [west * side[0], side[0], 0.0, north * side[1], 0.0, -side[1]];
    (geo, [east - west, north - south])
}

/// The nearest of the sides that people choose.
fn rounded(side: f64) -> f64 {
    let ten = 10.0_f64.powf(side.log10().floor());
    let sides = SIDES.iter().chain(&[10.0]).map(|step| step * ten);
    let nearest = sides.min_by(|a, b| (a / side).ln().abs().total_cmp(&(b / side).ln().abs()));
    // Without the last bits of powers of ten.
    nearest.and_then(|side| format!("{side:.3e}").parse().ok()).unwrap_or(side)
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn sides_are_those_that_people_choose() {
        for (side, wanted) in
            [(0.97, 1.0), (0.47, 0.5), (0.141, 0.15), (8.9, 10.0), (1.41, 1.5), (0.26, 0.25)]
        {
            assert_eq!(rounded(side), wanted);
        }
    }
}
