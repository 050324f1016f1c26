//! Clouds of known scenes, and databases of them.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3, dvec2, dvec3};
use las::point::{Classification, Format};
use las::{Builder, Color, Point, Transform, Vector, Vlr, Writer};

use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::raymarch::{Contact, LevelBands, Marcher, SolidHit, Surface};
use hedgehop::voxel::PageSource;
use hedgehop_modeling::{BuildOptions, build};

/// South-west corner of all scenes, metres of UTM zone 33.
pub const CORNER: DVec2 = dvec2(500_000.0, 5_000_000.0);
/// GeoTIFF's keys of UTM zone 33: a projected system, EPSG:32633, metres.
const KEYS: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 32633, 3076, 0, 1, 9001];

/// A point of a scene: place from its corner, ASPRS class, colour.
pub type Mark = (DVec3, u8, [u8; 3]);

/// Numbers that look like chance, 0…1.
pub struct Chance(pub u64);

impl Chance {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1_u64 << 24) as f64
    }
}

/// Writes points as LAS, or as LAZ where the name says so, in a point format with colours (3, 7) or without.
pub fn write(path: &Path, format: u8, marks: &[Mark]) {
    let mut builder = Builder::from((1, if format < 6 { 2 } else { 4 }));
    builder.point_format = Format::new(format).unwrap();
    builder.point_format.is_compressed = path.extension().is_some_and(|extension| extension == "laz");
    let axis = |offset: f64| Transform { scale: 0.001, offset };
    builder.transforms = Vector { x: axis(CORNER.x), y: axis(CORNER.y), z: axis(0.0) };
    let (has_colour, has_time) = (builder.point_format.has_color, builder.point_format.has_gps_time);
    let data = KEYS.iter().flat_map(|key| key.to_le_bytes()).collect();
    let keys = Vlr { user_id: "LASF_Projection".into(), record_id: 34735, data, ..Vlr::default() };
    builder.vlrs.push(keys);
    let file = BufWriter::new(File::create(path).unwrap());
    let mut writer = Writer::new(file, builder.into_header().unwrap()).unwrap();

    for (place, class, colour) in marks {
        let [red, green, blue] = colour.map(|code| u16::from(code) << 8);
        let point = Point {
            x: CORNER.x + place.x,
            y: CORNER.y + place.y,
            z: place.z,
            classification: Classification::new(*class).unwrap(),
            color: has_colour.then(|| Color::new(red, green, blue)),
            gps_time: has_time.then_some(0.0),
            return_number: 1,
            number_of_returns: 1,
            ..Point::default()
        };

        writer.write_point(point).unwrap();
    }

    writer.close().unwrap();
}

/// A plane, a house, a tree and a wire.
pub struct Village;

impl Village {
    pub const SIDE: f64 = 80.0;
    /// West, south, east, north of the house.
    pub const HOUSE: [f64; 4] = [20.0, 20.0, 34.0, 30.0];
    pub const ROOF: f64 = 112.0;
    /// Middle and radius of the tree; its crown begins and ends so high above the ground.
    pub const TREE: DVec2 = dvec2(55.0, 50.0);
    pub const RADIUS: f64 = 5.0;
    pub const CROWN: [f64; 2] = [6.0, 12.0];
    /// Where the wire runs northward, and how high.
    pub const WIRE: [f64; 2] = [10.3, 120.0];

    pub fn ground(place: DVec2) -> f64 {
        100.0 + 0.05 * place.x + 0.02 * place.y
    }

    /// Twelve points on a square metre.
    pub fn marks() -> Vec<Mark> {
        let mut chance = Chance(7);
        let mut marks = Vec::new();
        let [west, south, east, north] = Self::HOUSE;
        for _ in 0..(12.0 * Self::SIDE * Self::SIDE) as usize {
            let place = Self::SIDE * dvec2(chance.next(), chance.next());
            let ground = Self::ground(place);
            if place.x > west && place.x < east && place.y > south && place.y < north {
                marks.push((place.extend(Self::ROOF), 6, [180, 60, 50]));
                continue;
            }

            let is_hidden = place.distance(Self::TREE) < Self::RADIUS && chance.next() < 0.7;
            if is_hidden {
                let height = Self::CROWN[0] + (Self::CROWN[1] - Self::CROWN[0]) * chance.next();
                marks.push((place.extend(ground + height), 5, [60, 110, 40]));
            } else {
                marks.push((place.extend(ground), 2, [120, 130, 90]));
            }
        }

        let along = (0..400).map(|step| 0.2 * f64::from(step));
        marks.extend(along.map(|y| (dvec3(Self::WIRE[0], y, Self::WIRE[1]), 14, [40, 40, 40])));

        // Noise: a bird, and a multipath echo below the ground.
        marks.push((dvec3(40.0, 40.0, 300.0), 18, [0; 3]));
        marks.push((dvec3(41.0, 40.0, 20.0), 7, [0; 3]));

        marks
    }
}

/// Options of a build from one cloud, of voxels of a metre.
pub fn options(cloud: &Path, output: PathBuf) -> BuildOptions {
    let mut options = BuildOptions::new(Vec::new(), Vec::new(), output);
    options.clouds = vec![cloud.to_owned().into()];
    options.spacing = Some(1.0);
    options
}

/// A database that is sound.
pub fn database(options: &BuildOptions) -> PageFile {
    build(options, &Silent).unwrap();
    let pages = PageFile::open(&options.output).unwrap();
    assert_eq!(pages.verify(&Silent).unwrap().problems, []);
    pages
}

/// What a ray between two places meets: solids, and the ground.
pub fn met(pages: &PageFile, from: DVec3, to: DVec3) -> (Vec<SolidHit>, Option<Contact>) {
    let grid = pages.header().grid;
    let bands = LevelBands::finest_only().with_bare_ground(&grid, 1.0e-9, 0.0, 1.0);
    let mut marcher = Marcher::new(pages, bands, Surface::Smooth);
    let ray = marcher.ray(from + CORNER.extend(0.0), (to - from).normalize());
    let contact = marcher.first_contact(&ray, 0.0).unwrap();
    let mut hits = Vec::new();
    marcher.solids(&ray, contact.as_ref(), &mut hits).unwrap();
    (hits, contact)
}

/// Height of the bare ground, metres.
pub fn ground(pages: &PageFile, place: DVec2) -> Option<f64> {
    met(pages, place.extend(900.0), place.extend(0.0)).1.map(|contact| 900.0 - contact.range)
}

/// Height of what stands highest, metres.
pub fn top(pages: &PageFile, place: DVec2) -> Option<f64> {
    met(pages, place.extend(900.0), place.extend(0.0)).0.first().map(|hit| 900.0 - hit.range)
}
