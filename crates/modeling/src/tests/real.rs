//! Real pairs of elevation and imagery.

use super::support::{Area, options};
use crate::{BuildOptions, build};
use hedgehop::voxel::{Attributes, HeightRange, PageSource};
use hedgehop_base::progress::Silent;
use hedgehop_geo::{Crs, Transform};
use hedgehop_testing::realdata;

/// The area of a pair of files, or `None` without real data.
fn pair(elevation: &str, imagery: &str, adjust: impl Fn(&mut BuildOptions)) -> Option<Area> {
    let data = realdata()?;
    let folder = tempfile::tempdir().unwrap();
    let mut options = options(folder.path());
    options.elevation = vec![data.join(elevation).into()];
    options.imagery = vec![data.join(imagery).into()];
    adjust(&mut options);
    let report = build(&options, &Silent).unwrap();
    let area = Area::open(&options.output).unwrap();
    assert_eq!(report.bytes, area.bytes.len() as u64);
    assert_eq!(report.content_hash, area.pages.header().content_hash);
    Some(area)
}

impl Area {
    /// Share of voxels with a surface that lack imagery.
    fn bare(&self) -> f64 {
        let surface: Vec<_> = self.voxels().filter(|&(x, y)| self.height(x, y).is_some()).collect();
        let bare =
            surface.iter().filter(|&&(x, y)| self.attributes(x, y).flags & Attributes::NO_IMAGERY != 0);
        bare.count() as f64 / surface.len() as f64
    }

    /// Height at a place in degrees, of the voxel there.
    fn height_at(&self, longitude: f64, latitude: f64) -> f64 {
        let metadata = &self.pages.header().metadata;
        let crs =
            Crs::from_record(&metadata.crs_name, metadata.crs_epsg, metadata.crs_proj.as_deref()).unwrap();
        let (x, y) = Transform::new(&Crs::wgs84(), &crs).unwrap().apply(longitude, latitude).unwrap();
        let voxel = |position: f64, origin: f64| ((position - origin) / self.grid.spacing) as u32;
        self.height(voxel(x, self.grid.origin.x), voxel(y, self.grid.origin.y)).unwrap()
    }

    /// Mean colour of voxels chosen by height.
    fn mean_colour(&self, chosen: impl Fn(f64) -> bool) -> [f64; 3] {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for (x, y) in self.voxels().filter(|&(x, y)| self.height(x, y).is_some_and(&chosen)) {
            let colour = self.colour(x, y);
            sum = std::array::from_fn(|channel| sum[channel] + f64::from(colour[channel]));
            count += 1.0;
        }
        sum.map(|sum| sum / count)
    }
}

#[test]
fn rocky_mountains() {
    let Some(area) = pair("rmnp/rmnp-dem.tif", "rmnp/rmnp-rgb.tif", |_| {}) else { return };
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(32613));
    assert!((area.grid.spacing - 235.0).abs() < 10.0, "{}", area.grid.spacing);
    // Longs Peak, 4346 m, on pixels of 235 m.
    let peak = area.height_at(-105.6151, 40.2549);
    assert!((4000.0..4347.0).contains(&peak), "{peak}");
    assert!(area.bare() < 0.2, "{}", area.bare());
    let HeightRange { low, high } = area.pages.header().height_range;
    assert!(low >= 2281.0 - 1.0 && high <= 4261.0 + 1.0 && high > 4200.0);
}

#[test]
fn san_francisco() {
    let Some(area) =
        pair("sf_srtm1_landsat7/srtm1_sf_485x349_int16.tif", "sf_srtm1_landsat7/landsat7_sf.tif", |_| {})
    else {
        return;
    };
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(32610));
    // Twin Peaks, 282 m.
    let peak = area.height_at(-122.4477, 37.7525);
    assert!((240.0..290.0).contains(&peak), "{peak}");
    // Infrared is red: land is brighter in it than water.
    let (land, water) = (area.mean_colour(|height| height > 20.0), area.mean_colour(|height| height < 1.0));
    assert!(land[0] > water[0] + 20.0, "{land:?} {water:?}");
    // Pixels of the sea that are black count as the file's nodata, 0.
    assert!(area.bare() < 0.05);
}

#[test]
fn drone_survey() {
    let Some(area) = pair("odm_drone_dsm/dsm.tif", "odm_drone_dsm/odm_ortho_rgb_0p25m.tif", |_| {}) else {
        return;
    };
    assert_eq!((area.grid.nx, area.grid.ny), (488, 445), "pixels are voxels");
    let HeightRange { low, high } = area.pages.header().height_range;
    assert!((low - 57.2426).abs() < 0.001 && (high - 112.926).abs() < 0.001, "{low} {high}");
    assert!(area.pages.header().metadata.void_share > 0.05);
}

#[test]
fn crater_lake() {
    let dem = "craterlake/craterlake-elev-16bit-30m.tif";
    let Some(area) = pair(dem, "craterlake/craterlake-imagery-30m.tif", |_| {}) else { return };
    let metadata = &area.pages.header().metadata;
    let HeightRange { low, high } = area.pages.header().height_range;
    assert!(low > 1280.0 && high < 1881.0, "the undeclared sentinel is no height: {low} {high}");
    assert!(metadata.void_share > 0.01 && metadata.notes.iter().any(|note| note.contains("-32767")));
    assert!(metadata.notes.iter().all(|note| !note.contains('/')), "{:?}", metadata.notes);
}

#[test]
fn olinda() {
    let Some(area) = pair("olinda/olinda_dem_utm25s.tif", "olinda/L7_ETMs.tif", |options| {
        options.imagery[0].bands = Some([3, 2, 1])
    }) else {
        return;
    };
    assert_eq!((area.grid.nx, area.grid.ny), (111, 111));
    assert!(area.bare() < 0.15, "{}", area.bare());
    let (land, sea) = (area.mean_colour(|height| height > 10.0), area.mean_colour(|height| height <= 0.0));
    assert!(sea[2] - sea[0] > land[2] - land[0], "{sea:?} is bluer than {land:?}");
}

#[test]
fn santa_barbara() {
    let dem = "sba_airport/sba_elev32_wgs84_512x512.tif";
    let said = |options: &mut BuildOptions| options.elevation[0].crs = Some("EPSG:4326".into());
    let Some(area) = pair(dem, "sba_airport/sba_rgb_wgs84_512x512.tif", said) else { return };
    assert!((area.grid.spacing - 3.05).abs() < 0.2, "{}", area.grid.spacing);
    let HeightRange { low, high } = area.pages.header().height_range;
    assert!(low > 2.5 && high < 20.8);
    assert!(area.bare() < 0.001);
}

#[test]
fn the_whole_earth() {
    let dem = "global_etopo5_bmng/etopo5_4320x2161_int16.tif";
    let adjust = |options: &mut BuildOptions| {
        options.imagery[0].crs = Some("EPSG:4326".into());
        options.spacing = Some(20_000.0);
    };
    let Some(area) = pair(dem, "global_etopo5_bmng/bmng.jpg", adjust) else { return };
    assert_eq!(area.pages.header().metadata.crs_epsg, Some(4087));
    assert!(area.height_at(86.9, 27.98) > 4000.0, "Himalaya");
    assert!(area.height_at(142.2, 11.35) < -6000.0, "Mariana trench");
    let (land, sea) =
        (area.mean_colour(|height| height > 100.0), area.mean_colour(|height| height < -1000.0));
    assert!(sea[2] > 1.5 * sea[0] && land[0] > sea[0] + 30.0, "{sea:?} {land:?}");
    assert!(area.bare() < 0.001);
}
