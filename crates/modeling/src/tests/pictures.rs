//! Colours.

use glam::DVec2;

use super::support::{Area, built, north_up, sheet, terrain};
use crate::synthetic::{Circle, Palette, Pattern, Stop, Synthetic, Texture};
use crate::{BuildOptions, build};
use hedgehop::voxel::{Attributes, Material, PageSource};
use hedgehop_base::colour::{linear_from_srgb8, srgb8_from_linear};
use hedgehop_base::progress::Silent;
use hedgehop_geo::Crs;

fn ground() -> Vec<crate::opened::Opened<f64>> {
    vec![terrain(&Crs::local(), north_up(0.0, 640.0, 10.0), (64, 64), |_, _| 100.0)]
}

#[test]
fn pixels_on_voxels_keep_their_colours() {
    let picture = |c: u32, r: u32| [(c * 4) as u8, (r * 4) as u8, ((c * r) % 256) as u8, 255];
    let image = sheet(&Crs::local(), north_up(0.0, 640.0, 10.0), (64, 64), picture);
    let area = built(ground(), vec![image], |_| {});
    for (x, y) in area.voxels() {
        assert_eq!(area.colour(x, y)[..], picture(x, 63 - y)[..3]);
        assert_eq!(area.attributes(x, y).flags, 0);
    }
}

#[test]
fn a_palette_takes_its_share_of_imagery_and_leaves_water_alone() {
    let picture = |c: u32, _: u32| if c < 32 { [0, 0, 0, 255] } else { [0; 4] };
    let white = Palette::new(&[Stop { at: 0.0, colour: [255; 3] }], &[]);

    // It only states what the ground is made of.
    let water = Texture::new(Pattern::Checks, &[[9; 3], [9; 3]], 5.0).map(|texture| Texture {
        strength: 0.0,
        over_imagery: 0.0,
        within: Some(Circle { centre: DVec2::new(165.0, 325.0), radius_m: 60.0 }),
        material: Some(Material::Water),
        ..texture
    });

    let over = |share: f64| {
        let image = sheet(&Crs::local(), north_up(0.0, 640.0, 10.0), (64, 64), picture);
        let synthetic = Synthetic {
            textures: water.clone().into_iter().collect(),
            palette: Some(white.clone().over_imagery(share)),
            ..Synthetic::default()
        };
        built(ground(), vec![image], |options| options.synthetic = synthetic.clone())
    };

    let (none, quarter) = (over(0.0), over(0.25));
    let beside = |area: &Area| [area.colour(4, 4), area.colour(16, 32), area.colour(60, 4)];
    let [photographed, water, bare] = beside(&none);
    assert_eq!((photographed, water, bare), ([0; 3], [0; 3], [255; 3]));
    assert_eq!(Material::of_code(none.attributes(16, 32).material), Material::Water);
    let grey = srgb8_from_linear(0.25 * linear_from_srgb8([255; 3])[0]);
    assert_eq!(beside(&quarter), [[grey; 3], water, bare]);
}

#[test]
fn imagery_beside_the_area_is_told() {
    let notes = |x: f64| {
        let image = sheet(&Crs::local(), north_up(x, 640.0, 10.0), (64, 64), |_, _| [9, 9, 9, 255]);
        built(ground(), vec![image], |_| {}).pages.header().metadata.notes.join("; ")
    };
    assert!(!notes(0.0).contains("outside") && !notes(0.0).contains("leaves"), "{}", notes(0.0));
    assert!(notes(320.0).contains("imagery leaves 50.00 %"), "{}", notes(320.0));
    let far = notes(5000.0);
    assert!(far.contains("memory.tif lies outside the area") && far.contains("100.00 %"), "{far}");
}

#[test]
fn the_spacing_that_keeps_finer_imagery_is_told() {
    let notes = |side: f64, spacing: Option<f64>| {
        let pixels = (640.0 / side) as u32;
        let image = sheet(&Crs::local(), north_up(0.0, 640.0, side), (pixels, pixels), |_, _| [9, 9, 9, 255]);
        let area = built(ground(), vec![image], |options| options.spacing = spacing);
        area.pages.header().metadata.notes.join("; ")
    };
    let told = notes(2.0, None);
    assert!(told.contains("--spacing 2 ") && told.contains("about 25 times"), "{told}");
    for quiet in [notes(8.0, None), notes(20.0, None), notes(2.0, Some(10.0))] {
        assert!(!quiet.contains("--spacing"), "{quiet}");
    }
}

#[test]
fn finer_imagery_is_averaged_in_linear_light() {
    let board = sheet(&Crs::local(), north_up(0.0, 640.0, 1.0), (640, 640), |c, r| {
        let byte = if (c + r) % 2 == 0 { 255 } else { 0 };
        [byte, byte, byte, 255]
    });
    let area = built(ground(), vec![board], |_| {});
    for (x, y) in area.voxels() {
        let [red, green, blue] = area.colour(x, y);
        assert!(red.abs_diff(188) <= 1 && red == green && green == blue, "{red}");
    }
}

#[test]
fn filters_keep_the_mean() {
    let noise = |c: u32, r: u32| {
        let hash = (c.wrapping_mul(73_856_093) ^ r.wrapping_mul(19_349_663)).wrapping_mul(2_654_435_761);
        [(hash >> 24) as u8, (hash >> 16) as u8, (hash >> 8) as u8, 255]
    };

    for side in [2.5, 7.0, 23.0] {
        let pixels = (640.0 / side) as u32 + 2;
        let image = sheet(&Crs::local(), north_up(0.0, 640.0, side), (pixels, pixels), noise);
        let area = built(ground(), vec![image], |_| {});

        let mean = |values: &mut dyn Iterator<Item = u8>| {
            let (sum, count) = values.fold((0.0, 0.0), |(sum, count), byte| {
                (sum + f64::from(linear_from_srgb8([byte; 3])[0]), count + 1.0)
            });
            sum / count
        };
        let built_mean = mean(&mut area.voxels().map(|(x, y)| area.colour(x, y)[1]));
        let wanted = (640.0 / side) as u32;
        let source = mean(&mut (0..wanted).flat_map(|r| (0..wanted).map(move |c| noise(c, r)[1])));
        assert!((built_mean - source).abs() < 0.02, "{side}: {built_mean} instead of {source}");
    }
}

#[test]
fn coarser_imagery_does_not_ring() {
    let edge = sheet(&Crs::local(), north_up(0.0, 640.0, 80.0), (8, 8), |c, _| {
        let byte = if c < 4 { 60 } else { 200 };
        [byte, byte, byte, 255]
    });
    let area = built(ground(), vec![edge], |_| {});
    let row: Vec<u8> = (0..64).map(|x| area.colour(x, 30)[0]).collect();
    assert!(row.is_sorted() && row[0] == 60 && row[63] == 200, "{row:?}");
}

#[test]
fn the_next_picture_shows_through_and_then_the_tint() {
    let local = Crs::local();
    let upper =
        sheet(&local, north_up(0.0, 640.0, 10.0), (32, 64), |_, r| [200, 0, 0, if r < 32 { 255 } else { 0 }]);
    let lower = sheet(&local, north_up(0.0, 640.0, 10.0), (48, 64), |_, _| [0, 0, 200, 255]);
    let area = built(ground(), vec![upper, lower], |_| {});
    assert_eq!(area.colour(10, 50), [200, 0, 0]);
    assert_eq!(area.colour(10, 10), [0, 0, 200]);
    assert_eq!(area.colour(40, 50), [0, 0, 200]);
    let bare = area.colour(60, 50);
    assert!(bare[1] > bare[0] && bare[1] > bare[2], "{bare:?} is a lowland's green");
    assert_eq!(area.attributes(60, 50).flags, Attributes::NO_IMAGERY);
    assert_eq!(area.attributes(40, 50).flags, 0);
}

#[test]
fn abutting_pictures_join_without_a_line() {
    let local = Crs::local();
    let ramp = |x: u32| srgb8_from_linear(x as f32 / 40.0);
    let tile = |first: u32| {
        sheet(&local, north_up(f64::from(first) * 16.0, 640.0, 16.0), (20, 40), move |c, _| {
            let byte = ramp(first + c);
            [byte, byte, byte, 255]
        })
    };
    let whole = sheet(&local, north_up(0.0, 640.0, 16.0), (40, 40), |c, _| {
        let byte = ramp(c);
        [byte, byte, byte, 255]
    });
    let two = built(ground(), vec![tile(0), tile(20)], |_| {});
    let one = built(ground(), vec![whole], |_| {});
    for (x, y) in one.voxels() {
        assert!(two.colour(x, y)[0].abs_diff(one.colour(x, y)[0]) <= 2, "{x} {y}");
    }
}

/// Of one colour, with its north-west corner at (x, 640).
fn plain(x: f64, size: (u32, u32), colour: [u8; 3]) -> crate::opened::Opened<[u8; 4]> {
    let [red, green, blue] = colour;
    sheet(&Crs::local(), north_up(x, 640.0, 10.0), size, move |_, _| [red, green, blue, 255])
}

#[test]
fn a_picture_fades_into_a_lower_one_where_it_ends() {
    // Tiles alike, and pixels of another size below.
    let coarse = sheet(&Crs::local(), north_up(-160.0, 800.0, 20.0), (48, 48), |_, _| [20, 20, 20, 255]);
    for lower in [plain(80.0, (64, 64), [20; 3]), coarse] {
        let area = built(ground(), vec![plain(0.0, (40, 64), [220; 3]), lower], |_| {});
        let light: Vec<f32> = (0..64).map(|x| linear_from_srgb8([area.colour(x, 32)[0]; 3])[0]).collect();
        let difference = light[22] - light[45];
        let steps = light[16..].windows(2).map(|pair| pair[0] - pair[1]);
        let (least, most) = steps.fold((f32::MAX, 0.0_f32), |(a, b), step| (a.min(step), b.max(step)));
        // Bytes are rounded.
        assert!(most < difference / 8.0 && least > -0.01, "steps of {least} to {most}");
        let colours = [16, 22, 40, 63].map(|x| area.colour(x, 32)[0]);
        assert_eq!(colours, [220, 220, 20, 20]);
    }
}

#[test]
fn nothing_shows_through_where_pictures_abut() {
    let row = |imagery| {
        let area = built(ground(), imagery, |_| {});
        (0..64).map(|x| area.colour(x, 32)).collect::<Vec<_>>()
    };
    let tiles = || [plain(0.0, (32, 64), [200, 10, 10]), plain(320.0, (32, 64), [10, 10, 200])];
    let joined = row(tiles().into());
    assert_eq!((joined[31], joined[32]), ([200, 10, 10], [10, 10, 200]));
    let base = plain(-320.0, (128, 64), [10, 200, 10]);
    assert_eq!(row(tiles().into_iter().chain([base]).collect())[16..48], joined[16..48]);
}

#[test]
fn a_picture_without_a_lower_one_is_whole_to_its_edge() {
    let area = built(ground(), vec![plain(0.0, (40, 64), [220; 3])], |_| {});
    for x in [0, 30, 38, 39] {
        assert_eq!(area.colour(x, 32), [220; 3]);
    }
    assert_eq!(area.attributes(40, 32).flags, Attributes::NO_IMAGERY);
}

/// Heights over 400 m by 400 m of EPSG:32633, and a photograph that does not say where it lies: its left half is red, its right half blue.
fn bare_photograph(folder: &std::path::Path) -> BuildOptions {
    let heights = folder.join("heights.asc");
    let head = "ncols 40\nnrows 40\nxllcorner 400000\nyllcorner 5000000\ncellsize 10\n";
    std::fs::write(&heights, format!("{head}{}", "5 ".repeat(1600))).unwrap();
    let photo = folder.join("photo.png");
    let red_and_blue = |x: u32, _| if x < 20 { image::Rgb([250, 0, 0]) } else { image::Rgb([0, 0, 250]) };
    image::RgbImage::from_fn(40, 40, red_and_blue).save(&photo).unwrap();
    let mut options = BuildOptions::new(vec![heights], vec![photo], folder.join("area.hop"));
    options.elevation[0].crs = Some("EPSG:32633".into());
    options.overwrite = true;
    options
}

#[test]
fn an_image_without_a_place_is_refused_with_the_command_that_gives_it_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = bare_photograph(folder.path());
    for spacing in [None, Some(10.0)] {
        options.raw_spacing = spacing;
        let error = build(&options, &Silent).unwrap_err().to_string();
        for words in [
            "has no georeferencing",
            "--imagery-extent 400000,5000000,400400,5000400, in EPSG:32633",
            "gdal_translate -a_srs EPSG:32633 -a_ullr 400000 5000400 400400 5000000",
            "photo.placed.tif",
        ] {
            assert!(error.contains(words), "{words}: {error}");
        }
        assert!(!error.contains("--spacing"), "{error}");
    }
}

#[test]
fn edges_of_an_image_are_taken_in_degrees_or_in_metres() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = bare_photograph(folder.path());

    // All of the ground in degrees: its bounds.
    let degrees = [13.727_89, 45.146_39, 13.733_05, 45.150_05];
    for (extent, crs) in [
        ([400_000.0, 5_000_000.0, 400_400.0, 5_000_400.0], None),
        (degrees, None),
        (degrees, Some("EPSG:4326")),
        ([400_000.0, 5_000_000.0, 400_400.0, 5_000_400.0], Some("EPSG:32633")),
    ] {
        (options.imagery[0].extent, options.imagery[0].crs) = (Some(extent), crs.map(str::to_owned));
        build(&options, &Silent).unwrap();
        let area = Area::open(&options.output).unwrap();
        assert_eq!(
            (area.colour(3, 20), area.colour(36, 20)),
            ([250, 0, 0], [0, 0, 250]),
            "{extent:?} {crs:?}"
        );
    }

    // East of the middle there is nothing of it.
    options.imagery[0].extent = Some([400_000.0, 5_000_000.0, 400_200.0, 5_000_400.0]);
    build(&options, &Silent).unwrap();
    let area = Area::open(&options.output).unwrap();
    assert_eq!((area.colour(3, 20), area.colour(13, 20)), ([250, 0, 0], [0, 0, 250]));
    assert_ne!(area.colour(36, 20), [0, 0, 250]);

    for (extent, words) in [
        ([400_400.0, 5_000_000.0, 400_000.0, 5_000_400.0], "is no area"),
        ([f64::NAN, 0.0, 1.0, 1.0], "is no area"),
    ] {
        options.imagery[0].extent = Some(extent);
        let error = build(&options, &Silent).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn the_fineness_of_imagery_is_told_beside_that_of_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = bare_photograph(folder.path());
    let metadata = |options: &BuildOptions| {
        build(options, &Silent).unwrap();
        Area::open(&options.output).unwrap().pages.header().metadata.clone()
    };
    let finer = |notes: &[String]| notes.iter().any(|note| note.contains("--spacing 5 keeps all of it"));

    options.imagery[0].extent = Some([400_000.0, 5_000_000.0, 400_200.0, 5_000_200.0]);
    let fine = metadata(&options);
    assert!(finer(&fine.notes) && fine.imagery_pixel.is_none(), "{fine:?}");
    options.spacing = Some(10.0);
    assert!(!finer(&metadata(&options).notes));
    options.spacing = Some(2.0);
    assert_eq!(metadata(&options).imagery_pixel, Some(5.0));
    // Beside the area it says nothing of it.
    options.imagery[0].extent = Some([500_000.0, 5_000_000.0, 500_200.0, 5_000_200.0]);
    assert_eq!(metadata(&options).imagery_pixel, None);
}
