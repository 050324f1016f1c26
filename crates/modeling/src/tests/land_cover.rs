//! Maps of land cover: each voxel has the class of the pixel under its centre, and coarser ones the most frequent.

use glam::DVec2;

use super::support::{Area, north_up, options, sheet, terrain};
use crate::budget::Budget;
use crate::inputs::Inputs;
use crate::land_cover::SampleClass;
use crate::opened::Opened;
use crate::{BuildOptions, Corridor, Finish, LandCoverFile, Materials, Place, Route, Scheme, build, warp};
use hedgehop::voxel::{Attributes, Material, PAGE_SIDE, PageId, PageSource};
use hedgehop_base::progress::Silent;
use hedgehop_geo::{Crs, Transform};

fn place() -> (Crs, f64, f64) {
    (Crs::from_epsg(32632).unwrap(), 500_000.0, 5_000_000.0)
}

/// Rolling ground of `count` posts of 10 m along a side.
fn ground(count: u32) -> Vec<Opened<f64>> {
    let (crs, west, south) = place();
    let geo = north_up(west, south + 10.0 * f64::from(count), 10.0);
    vec![terrain(&crs, geo, (count, count), |x, y| 300.0 + 20.0 * (x / 90.0).sin() + 0.02 * (y - 5.0e6))]
}

/// Classes by chance, one pixel in eight void.
fn class(column: u32, row: u32, seed: u32) -> SampleClass {
    let mixed =
        (column.wrapping_mul(0x9E37_79B1) ^ row.wrapping_mul(0x85EB_CA77) ^ seed).wrapping_mul(0xC2B2_AE35);
    match mixed >> 24 {
        0..32 => SampleClass::Void,
        byte => SampleClass::Known(1 + (byte % 30) as u8),
    }
}

fn built(land_cover: Vec<Opened<SampleClass>>, posts: u32, adjust: impl Fn(&mut BuildOptions)) -> Area {
    built_with(land_cover, posts, &adjust)
}

/// Builds a database with land cover; compiled once for all closures.
fn built_with(land_cover: Vec<Opened<SampleClass>>, posts: u32, adjust: &dyn Fn(&mut BuildOptions)) -> Area {
    let folder = tempfile::tempdir().unwrap();
    let mut options = options(folder.path());
    adjust(&mut options);
    let file = LandCoverFile {
        path: "memory.tif".into(),
        crs: None,
        scheme: Scheme::WorldCover,
        nodata: Vec::new(),
    };
    options.land_cover = land_cover.iter().map(|_| file.clone()).collect();
    let budget = Budget::of(&options).unwrap();
    let inputs = Inputs { elevation: ground(posts), land_cover, ..Inputs::default() };
    build::build_from(inputs, &options, budget, &Silent).unwrap();
    Area::open(&options.output).unwrap()
}

/// Number of the class under a place of the raster's system; 0: void.
fn under(geo: &[f64; 6], (x, y): (f64, f64), seed: u32) -> u8 {
    let (column, row) = warp::apply(&warp::invert(geo).unwrap(), x, y);
    match class(column.floor() as u32, row.floor() as u32, seed) {
        SampleClass::Known(number) => number,
        _ => 0,
    }
}

#[test]
fn each_voxel_has_the_class_under_its_centre() {
    let (crs, west, south) = place();
    for (side, spacing) in [(10.0, 2.0), (7.3, 5.0), (3.7, 10.0)] {
        let geo = north_up(west - 11.3, south + 821.9, side);
        let raster = sheet(&crs, geo, (230, 230), |column, row| class(column, row, 1));
        let area = built(vec![raster], 80, |options| options.spacing = Some(spacing));
        for (x, y) in area.voxels() {
            assert_eq!(
                area.attributes(x, y).material,
                under(&geo, area.centre(x, y), 1),
                "{x} {y} at {spacing}"
            );
        }
    }
}

#[test]
fn other_systems_are_exact_too() {
    let (crs, ..) = place();
    // Three tenths of an arc second: 9 m northward.
    let geo = [8.998, 8.4e-5, 0.0, 45.162, 0.0, -8.4e-5];
    let raster = sheet(&Crs::wgs84(), geo, (260, 260), |column, row| class(column, row, 2));
    let area = built(vec![raster], 80, |options| options.spacing = Some(2.5));
    let degrees = Transform::new(&crs, &Crs::wgs84()).unwrap();
    for (x, y) in area.voxels() {
        let (east, north) = area.centre(x, y);
        let place = degrees.apply(east, north).unwrap();
        assert_eq!(area.attributes(x, y).material, under(&geo, place, 2), "{x} {y}");
    }
}

#[test]
fn the_first_raster_that_knows_a_class_counts() {
    let (crs, west, south) = place();
    let geo = north_up(west, south + 800.0, 10.0);
    let upper = sheet(&crs, geo, (40, 80), |column, row| class(column, row, 3));
    let lower = sheet(&crs, geo, (80, 40), |column, row| class(column, row, 4));
    let area = built(vec![upper, lower], 80, |_| {});
    for (x, y) in area.voxels() {
        let place = area.centre(x, y);
        let first = if x < 40 { under(&geo, place, 3) } else { 0 };
        let second = if y >= 40 { under(&geo, place, 4) } else { 0 };
        let wanted = if first > 0 { first } else { second };
        assert_eq!(area.attributes(x, y).material, wanted, "{x} {y}");
    }
    let metadata = &area.pages.header().metadata;
    assert_eq!(metadata.sources.iter().filter(|source| source.role == "land cover").count(), 2);
    let numbers: Vec<u8> = metadata.materials.iter().map(|record| record.number).collect();
    assert_eq!(numbers, (1..=30).collect::<Vec<_>>(), "those that are there");
}

#[test]
fn corridors_have_the_most_frequent_class_outside() {
    let (crs, west, south) = place();
    let geo = north_up(west, south + 8000.0, 10.0);
    let patch = |column: u32, row: u32| class(column / 5, row / 5, 5);
    let raster = sheet(&crs, geo, (800, 800), patch);
    let route = Route {
        file: "route.csv".into(),
        places: vec![Place::Xy(west, south + 700.0), Place::Xy(west + 8000.0, south + 700.0)],
    };
    let area = built(vec![raster], 800, |options| {
        options.corridors = vec![Corridor { route: route.clone(), width: 400.0, spacing: 2.5 }];
        (options.spacing, options.outside) = (Some(2.5), Some(10.0));
    });

    let of = |x: f64, y: f64| {
        let (column, row) = (((x - west) / 10.0) as u32, ((south + 8000.0 - y) / 10.0) as u32);
        match patch(column, row) {
            SampleClass::Known(number) => number,
            _ => 0,
        }
    };

    let mut looked_at = [0_u32; 3];
    for level in 0..3_u8 {
        let side = 2.5 * 4_f64.powi(level.into());
        let (columns, rows) = area.grid.page_dims(level);
        for (px, py) in (0..rows).flat_map(|py| (0..columns).map(move |px| (px, py))) {
            let Some(page) = area.pages.page(PageId { level, px, py }).unwrap() else { continue };
            for (x, y) in
                (0..page.height).step_by(7).flat_map(|y| (0..page.width).step_by(5).map(move |x| (x, y)))
            {
                let corner = DVec2::new(f64::from(px * PAGE_SIDE + x), f64::from(py * PAGE_SIDE + y)) * side;
                let found = page.attributes_at(x, y).material;

                // Of level 4, voxels are pixels; of level 16, they have most of 16 pixels.
                let wanted: Vec<u8> = match level {
                    0 | 1 => vec![of(west + corner.x + 0.5 * side, south + corner.y + 0.5 * side)],
                    _ => {
                        let parts = (0..16)
                            .map(|part| DVec2::new(f64::from(part % 4), f64::from(part / 4)) * 10.0 + 5.0);
                        let all: Vec<u8> = parts
                            .map(|part| of(west + corner.x + part.x, south + corner.y + part.y))
                            .collect();
                        let count = |number: u8| all.iter().filter(|other| **other == number).count();
                        let most = all.iter().map(|number| count(*number)).max().unwrap();
                        let mut best: Vec<u8> =
                            all.iter().copied().filter(|number| count(*number) == most).collect();
                        best.sort_unstable();
                        best.truncate(1);
                        best
                    }
                };

                assert!(
                    wanted.contains(&found),
                    "level {level}, {px} {py}, {x} {y}: {found}, not {wanted:?}"
                );
                looked_at[usize::from(level)] += 1;
            }
        }
    }

    assert!(looked_at.iter().all(|count| *count > 1000), "{looked_at:?}");
}

#[test]
fn ground_has_the_colour_of_its_material_and_varies() {
    let (crs, west, south) = place();
    let geo = north_up(west, south + 800.0, 400.0);
    let half = |column: u32, _| {
        SampleClass::Known(if column == 0 { Material::Water } else { Material::Sand }.code())
    };

    let sand = Finish {
        material: Material::Sand,
        name: "sand".into(),
        colour: Some([200, 120, 60]),
        ..Finish::default()
    };
    let area = |said: Vec<Finish>| {
        built(vec![sheet(&crs, geo, (2, 2), half)], 80, |options| {
            options.materials = Materials::new(said.clone())
        })
    };
    let plain = area(Vec::new());

    let mean = |area: &Area, columns: std::ops::Range<u32>| -> [f64; 3] {
        let colours: Vec<[u8; 3]> =
            columns.flat_map(|x| (0..80).map(move |y| (x, y))).map(|(x, y)| area.colour(x, y)).collect();
        std::array::from_fn(|channel| {
            colours.iter().map(|colour| f64::from(colour[channel])).sum::<f64>() / colours.len() as f64
        })
    };

    let near = |found: [f64; 3], wanted: [u8; 3]| {
        found.iter().zip(wanted).all(|(a, b)| (a - f64::from(b)).abs() < 18.0)
    };
    assert!(near(mean(&plain, 0..30), Material::Water.colour()), "{:?}", mean(&plain, 0..30));
    assert!(near(mean(&plain, 50..80), Material::Sand.colour()), "{:?}", mean(&plain, 50..80));
    let shades: std::collections::HashSet<_> =
        (50..80).flat_map(|x| (0..80).map(move |y| (x, y))).map(|(x, y)| plain.colour(x, y)).collect();
    assert!(shades.len() > 100, "{}", shades.len());
    assert_eq!(
        plain.attributes(10, 10),
        Attributes { source: 0, material: 1, flags: Attributes::NO_IMAGERY }
    );
    let red = area(vec![sand]);
    assert!(near(mean(&red, 50..80), [200, 120, 60]), "{:?}", mean(&red, 50..80));

    // Water far from the border, which colours cross by a part of a pixel.
    assert!(near(mean(&red, 0..8), Material::Water.colour()), "{:?}", mean(&red, 0..8));
}

#[test]
fn borders_of_wide_pixels_are_no_stairs_but_classes_are() {
    let (crs, west, south) = place();
    let geo = north_up(west, south + 800.0, 20.0);
    // Water below a diagonal.
    let diagonal = |column: u32, row: u32| SampleClass::Known(if column < row { 1 } else { 17 });
    let area = built(vec![sheet(&crs, geo, (40, 40), diagonal)], 80, |options| options.spacing = Some(1.0));
    let is_dark = |x: u32, y: u32| area.colour(x, y)[0] < 125;
    let voxels: Vec<(u32, u32)> = (100..700).flat_map(|y| (100..700).map(move |x| (x, y))).collect();
    let differs =
        voxels.iter().filter(|(x, y)| is_dark(*x, *y) != (area.attributes(*x, *y).material == 1)).count();
    // Colours leave the stairs, by less than a pixel on either side: of 600 columns 20 voxels each way at most.
    assert!((1000..12_000).contains(&differs), "{differs}");
    // Most voxels beside the border lie between the colours of the two.
    let between = voxels.iter().filter(|(x, y)| (70..180).contains(&area.colour(*x, *y)[0])).count();
    assert!(between > 1500, "{between}");
}
