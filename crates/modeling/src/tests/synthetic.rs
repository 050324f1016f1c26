//! Ground that no file holds, detail below posts, and ways of interpolation.

use glam::DVec2;

use super::support::{Area, built, north_up, sheet, terrain, try_build};
use crate::synthetic::{
    Circle, Detail, GroundPatch, Hills, Palette, Pattern, PlateauTop, Roughness, Stop, Synthetic, Terrain,
    Texture, bomb_circle,
};
use crate::warp::{LevelGrid, Rect};
use crate::{BuildOptions, Interpolation};
use hedgehop::voxel::{Grid, Material};
use hedgehop_geo::Crs;

fn plane(height_m: f64) -> Terrain {
    Terrain::Plane { height_m, centre: DVec2::ZERO, slope: 0.0, upward_deg: 0.0 }
}

fn circle(x: f64, y: f64, radius_m: f64) -> Circle {
    Circle { centre: DVec2::new(x, y), radius_m }
}

fn hills(amplitude_m: f64, wavelength_m: f64) -> Terrain {
    let waves = Hills { seed: 9, wavelength_m, roughness: 0.6 };
    Terrain::Fractal { waves, amplitude_m, crests: false, within: None }
}

fn pond() -> Terrain {
    let circle = circle(900.0, 700.0, 200.0);
    Terrain::Pond { circle, bank_m: 80.0, level_m: 96.3, ragged: 0.3, seed: 2, colour: [20, 40, 60] }
}

/// One of each.
fn country() -> Vec<Terrain> {
    let line = [(100.0, 1500.0), (800.0, 1300.0), (1400.0, 1550.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
    let below = line.iter().map(|place| *place - DVec2::new(0.0, 700.0)).collect();
    vec![
        plane(100.0),
        pond(),
        hills(30.0, 800.0),
        Terrain::Ridge { line, width_m: 400.0, crest_m: 0.0, height_m: 70.0 },
        Terrain::Ridge { line: below, width_m: 300.0, crest_m: 60.0, height_m: -40.0 },
        Terrain::Cone { circle: circle(400.0, 400.0, 150.0), height_m: 50.0 },
        Terrain::Dome { circle: circle(1300.0, 400.0, 180.0), height_m: 60.0 },
        Terrain::Plateau {
            circle: circle(1300.0, 1000.0, 90.0),
            flank_m: 60.0,
            top: PlateauTop::Level(140.0),
        },
    ]
}

/// Square of 1600 m without any file.
fn made(terrain: Vec<Terrain>, adjust: impl Fn(&mut BuildOptions)) -> Area {
    built(vec![], vec![], |options| {
        options.local = true;
        options.bbox = Some([0.0, 0.0, 1600.0, 1600.0]);
        options.spacing = Some(8.0);
        options.synthetic.terrain.clone_from(&terrain);
        adjust(options);
    })
}

#[test]
fn a_plane_is_level_or_as_steep_as_it_says() {
    let area = made(vec![plane(123.4)], |_| {});
    assert_eq!((area.grid.nx, area.grid.ny), (200, 200));
    assert!(area.voxels().all(|(x, y)| area.height(x, y) == area.height(0, 0)));
    assert!((area.height(0, 0).unwrap() - 123.4).abs() < 1e-9);
    let ramp =
        Terrain::Plane { height_m: 50.0, centre: DVec2::new(800.0, 0.0), slope: 0.1, upward_deg: 90.0 };
    let area = made(vec![ramp], |_| {});
    assert!(area.worst(|x, _| 50.0 + 0.1 * (x - 800.0)) <= area.step());
}

#[test]
fn shapes_have_their_heights_where_they_say() {
    let cone = Terrain::Cone { circle: circle(804.0, 804.0, 320.0), height_m: 96.0 };
    let plateau =
        Terrain::Plateau { circle: circle(204.0, 204.0, 64.0), flank_m: 32.0, top: PlateauTop::Above(20.0) };
    let area = made(vec![plane(10.0), cone, plateau], |_| {});
    // The centre of voxel (100, 100) is (804, 804); 40 voxels on is the rim.
    let height = |x, y| area.height(x, y).unwrap();
    for ((x, y), wanted) in [
        ((100, 100), 106.0),
        ((120, 100), 58.0),
        ((140, 100), 10.0),
        ((100, 60), 10.0),
        ((25, 25), 30.0),
        ((33, 25), 30.0),
        ((35, 25), 20.0),
        ((37, 25), 10.0),
    ] {
        assert!((height(x, y) - wanted).abs() <= area.step(), "{x}, {y}: {}, not {wanted}", height(x, y));
    }
}

#[test]
fn water_has_one_height_and_is_water() {
    // However rough the ground is, and wherever the pond stands among the tables.
    let area = made(country(), |_| {});
    let water = |x, y| area.attributes(x, y).material == Material::Water.code();
    let wet: Vec<_> = area.voxels().filter(|(x, y)| water(*x, *y)).collect();
    let whole = std::f64::consts::PI * (200.0_f64 / 8.0).powi(2);
    assert!((0.6..1.6).contains(&(wet.len() as f64 / whole)), "{} of {whole}", wet.len());
    let inner = wet
        .iter()
        .filter(|(x, y)| [(1, 0), (0, 1)].iter().all(|(i, j)| water(x + i, y + j) && water(x - i, y - j)));
    let codes: std::collections::BTreeSet<_> =
        inner.map(|(x, y)| area.height(*x, *y).unwrap().to_bits()).collect();
    assert_eq!(codes.len(), 1);
    assert!((area.height(112, 87).unwrap() - 96.3).abs() <= area.step());
    assert_eq!(area.colour(112, 87), [20, 40, 60]);
}

#[test]
fn heights_are_those_of_the_shapes_so_their_bounds_hold() {
    let ground = Synthetic { terrain: country(), ..Synthetic::default() };
    let area = made(ground.terrain.clone(), |_| {});
    let (low, high) = ground.heights(None, &area.grid).unwrap();
    let level = LevelGrid::of(&area.grid, 0);
    let rect = Rect { x0: 0, y0: 0, x1: area.grid.nx, y1: area.grid.ny };
    let mut heights = vec![f64::NAN; rect.len()];
    ground.shape(&level, rect, &mut heights);
    for (index, height) in heights.into_iter().enumerate() {
        let (x, y) = rect.voxel(index);
        assert!((low..=high).contains(&height), "{height} is beyond {low}…{high}");
        assert!((area.height(x, y).unwrap() - height).abs() <= area.step(), "{x}, {y}");
    }
}

#[test]
fn shapes_lie_on_elevation_and_a_plane_goes_on_beside_it() {
    let hole = |x: f64, y: f64| if x > 300.0 && y > 300.0 { f64::NAN } else { 200.0 + 0.1 * x };
    let raster = || terrain(&Crs::local(), north_up(0.0, 400.0, 8.0), (50, 50), hole);
    let dome = Terrain::Dome { circle: circle(100.0, 100.0, 60.0), height_m: 25.0 };

    let with = |terrain: Vec<Terrain>, bbox| {
        built(vec![raster()], vec![], move |options| {
            options.synthetic.terrain.clone_from(&terrain);
            options.bbox = bbox;
        })
    };
    let area = with(vec![dome.clone()], None);
    assert_eq!((area.grid.nx, area.grid.ny), (50, 50));
    assert_eq!(area.height(45, 45), None);
    assert!((area.height(40, 12).unwrap() - 232.4).abs() <= area.step());
    assert!(area.height(12, 12).unwrap() > 230.0);
    let area = with(vec![plane(150.0), dome], Some([-400.0, 0.0, 400.0, 400.0]));
    assert_eq!((area.grid.nx, area.grid.ny), (100, 50));
    for (x, y, wanted) in [(10, 10, 150.0), (90, 12, 232.4), (95, 45, 150.0)] {
        assert!((area.height(x, y).unwrap() - wanted).abs() <= area.step(), "{x}, {y}");
    }
}

#[test]
fn without_elevation_the_place_must_be_told() {
    let wrong = |adjust: &dyn Fn(&mut BuildOptions)| {
        try_build(vec![], vec![], |options| {
            (options.local, options.bbox, options.spacing) = (true, Some([0.0, 0.0, 90.0, 90.0]), Some(3.0));
            options.synthetic.terrain = vec![plane(0.0)];
            adjust(options);
        })
        .err()
        .map(|error| error.to_string())
    };
    assert_eq!(wrong(&|_| {}), None);
    assert!(wrong(&|options| options.bbox = None).unwrap().contains("--bbox is needed"));
    assert!(wrong(&|options| options.spacing = None).unwrap().contains("--spacing is needed"));
    assert!(wrong(&|options| options.local = false).unwrap().contains("--local"));
    assert!(wrong(&|options| options.bbox = Some([3.0, 0.0, 1.0, 1.0])).unwrap().contains("no area"));
    assert!(wrong(&|options| options.crs = Some("EPSG:4326".into())).unwrap().contains("not in metres"));
}

/// Everything at once, over elevation in degrees.
fn all(options: &mut BuildOptions) {
    let (x, y) = (500_000.0, 5_370_000.0);
    let moved = |circle: Circle| Circle { centre: circle.centre + DVec2::new(x, y), ..circle };
    let line = [(-900.0, 300.0), (300.0, 900.0), (900.0, -200.0)];
    let line = line.map(|(i, j)| DVec2::new(x + i, y + j)).to_vec();
    options.crs = Some("EPSG:32633".into());
    options.spacing = Some(9.0);
    options.interpolation = Interpolation::Spline;

    options.synthetic = Synthetic {
        terrain: vec![
            plane(80.0),
            hills(20.0, 300.0),
            Terrain::Ridge { line, width_m: 300.0, crest_m: 0.0, height_m: 60.0 },
            Terrain::Pond {
                circle: moved(circle(0.0, 0.0, 300.0)),
                bank_m: 90.0,
                level_m: 120.0,
                ragged: 0.4,
                seed: 1,
                colour: [9; 3],
            },
        ],
        materials: Vec::new(),
        detail: Some(Detail { seed: 3, roughness: Roughness::Auto, limit_m: None }),
        below_voxel: None,
        examples: None,
        palette: Some(Palette::new(
            &[Stop { at: 0.0, colour: [80, 110, 60] }, Stop { at: 500.0, colour: [200; 3] }],
            &[],
        )),
        textures: [
            Pattern::Checkerboard,
            Pattern::Checks,
            Pattern::Speckle,
            Pattern::Waves,
            Pattern::Fractal,
        ]
        .into_iter()
        .filter_map(|pattern| Texture::new(pattern, &[[90, 60, 30], [10, 200, 90], [5; 3]], 70.0))
        .map(|texture| Texture { strength: 0.4, over_imagery: 0.2, turned_deg: 30.0, ..texture })
        .collect(),
        patches: vec![GroundPatch {
            coats: bomb_circle(moved(circle(-600.0, -500.0, 280.0)), 5, &[[250; 3], [20, 20, 90]]),
            material: Some(Material::Concrete),
            strength: 0.8,
            priority: 0,
        }],
    };
}

#[test]
fn threads_and_memory_change_no_byte_of_what_is_made() {
    let elevation = || {
        let geo = [14.98, 1.0 / 3600.0, 0.0, 48.5, 0.0, -1.0 / 3600.0];
        vec![terrain(&Crs::wgs84(), geo, (130, 110), |x, y| {
            300.0 + 90.0 * (x * 900.0).sin() * (y * 1100.0).cos() + 5.0 * (x * y * 7e4).sin()
        })]
    };
    let with = |threads: usize, memory: u64| {
        built(elevation(), vec![], move |options| {
            all(options);
            (options.threads, options.memory) = (threads, memory << 20);
        })
    };
    let first = with(1, 512);
    assert!(first.grid.nx > 270 && first.grid.ny > 270, "several pages");
    for (threads, memory) in [(4, 512), (3, 90)] {
        assert!(with(threads, memory).bytes == first.bytes, "{threads} threads, {memory} MiB");
    }
    assert_ne!(first.colour(20, 20), first.colour(24, 29));
}

/// A surface whose profiles have the same power law at all wavelengths, from 64 posts down to the shortest: heights at places in posts.
fn rough(at: DVec2, roughness: f64, shortest: f64) -> f64 {
    let waves = Hills { seed: 21, wavelength_m: 64.0, roughness };
    300.0 + 30.0 * waves.plain(at, shortest)
}

/// Posts along a side, and metres from one to the next.
const POSTS: u32 = 80;
const APART: f64 = 32.0;

fn refined(interpolation: Interpolation, roughness: f64, detail: Option<Roughness>, spacing: f64) -> Area {
    let raster = sheet(
        &Crs::local(),
        north_up(0.0, f64::from(POSTS) * APART, APART),
        (POSTS, POSTS),
        |column, row| rough(DVec2::new(f64::from(column), f64::from(row)), roughness, 0.125),
    );
    built(vec![raster], vec![], move |options| {
        options.spacing = Some(spacing);
        options.interpolation = interpolation;
        let detail = detail.map(|roughness| Detail { seed: 5, roughness, limit_m: Some(100.0) });
        options.synthetic.detail = detail;
        // Odd numbers of voxels from post to post, so that centres lie on posts.
        options.bbox = Some([0.0, 0.0, f64::from(POSTS) * APART, f64::from(POSTS) * APART]);
    })
}

#[test]
fn detail_leaves_posts_as_they_are() {
    let spacing = APART / 5.0;
    for interpolation in [Interpolation::Linear, Interpolation::Bicubic, Interpolation::Spline] {
        let area = refined(interpolation, 0.6, Some(Roughness::Auto), spacing);
        let plain = refined(interpolation, 0.6, None, spacing);
        let (mut between, mut beside) = (0.0_f64, 0);
        for (x, y) in area.voxels() {
            let [column, row] = [x, area.grid.ny - 1 - y].map(|at| at / 5);
            let height = area.height(x, y).unwrap();
            if x % 5 == 2 && y % 5 == 2 {
                let post = rough(DVec2::new(f64::from(column), f64::from(row)), 0.6, 0.125);
                assert!((height - post).abs() <= area.step(), "{interpolation:?}, post {column}, {row}");
            } else {
                between += (height - plain.height(x, y).unwrap()).abs();
                beside += 1;
            }
        }
        assert!(between / f64::from(beside) > 0.3, "{interpolation:?}: {between} of {beside}");
    }
}

/// Mean power of profiles in octaves of frequency, of `side` metres a sample and from one wave along `count` of them on.
fn octaves(height: impl Fn(usize, usize) -> f64, count: usize) -> Vec<f64> {
    let turn = 2.0 * std::f64::consts::PI / count as f64;
    let mut powers = vec![0.0; count.ilog2() as usize - 1];
    for line in 0..24 {
        let profile: Vec<f64> = (0..count).map(|at| height(at, line)).collect();
        let mean = profile.iter().sum::<f64>() / count as f64;

        // A window after von Hann, so that the ends of the profile are no step.
        let window = |at: usize| 0.5 - 0.5 * (turn * (at as f64 + 0.5)).cos();
        let profile: Vec<f64> =
            profile.iter().enumerate().map(|(at, height)| (height - mean) * window(at)).collect();

        for wave in 1..count / 2 {
            let phase = |at: usize| turn * (wave * at % count) as f64;
            let real: f64 = profile.iter().enumerate().map(|(at, height)| height * phase(at).cos()).sum();
            let imaginary: f64 =
                profile.iter().enumerate().map(|(at, height)| height * phase(at).sin()).sum();
            let octave = wave.ilog2();
            powers[octave as usize] += (real * real + imaginary * imaginary) / f64::from(1_u32 << octave);
        }
    }

    powers
}

#[test]
fn the_spectrum_goes_on_below_the_posts() {
    // Eight voxels to a post: waves of 64 posts are the first octave, of two posts the sixth, and of two voxels the last.
    let (spacing, count) = (APART / 8.0, 512);
    for (roughness, detail) in
        [(0.5, Roughness::Given(0.5)), (0.6, Roughness::Auto), (0.7, Roughness::Given(0.7))]
    {
        let profile = |area: &Area| {
            octaves(|at, line| area.height(64 + at as u32, 40 + 23 * line as u32).unwrap(), count)
        };
        let found = profile(&refined(Interpolation::Linear, roughness, Some(detail), spacing));
        let plain = profile(&refined(Interpolation::Linear, roughness, None, spacing));

        let truth = octaves(
            |at, line| {
                let place = |voxel: usize| (voxel as f64 + 0.5) / 8.0 - 0.5;
                let row = f64::from(POSTS) - 1.0 - place(40 + 23 * line);
                // Without what is shorter than two voxels.
                rough(DVec2::new(place(64 + at), row), roughness, 0.25)
            },
            count,
        );

        // Power of ten logarithms: decibels.
        let off = |powers: &[f64]| -> Vec<f64> {
            powers.iter().zip(&truth).map(|(power, truth)| 10.0 * (power / truth).log10()).collect()
        };
        let (with, without) = (off(&found), off(&plain));
        assert!(with.iter().all(|off| off.abs() < 2.0), "{roughness}: {with:.2?} dB off the true surface");
        assert!(without[6] < -7.0, "{roughness}: {without:.2?} without detail");

        // The power law: over all octaves from the third on, 16 posts long, power falls by the same factor from each to the next.
        let slopes: Vec<f64> = found.windows(2).skip(2).map(|pair| (pair[1] / pair[0]).log2()).collect();
        let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
        let law = -1.0 + 2.0 * roughness.log2();
        assert!((mean - law).abs() < 0.3, "{roughness}: falls by {mean:.2}, not {law:.2}: {slopes:.2?}");
    }
}

#[test]
fn level_posts_stay_level() {
    let lake = |x: f64, y: f64| {
        if x < 500.0 { 70.0 } else { 70.0 + 0.2 * (x - 500.0) + 9.0 * (x * 0.11).sin() * (y * 0.13).cos() }
    };

    let with = |detail: Option<Detail>| {
        let raster = terrain(&Crs::local(), north_up(0.0, 1000.0, 20.0), (50, 50), lake);
        built(vec![raster], vec![], move |options| {
            options.spacing = Some(4.0);
            options.synthetic.detail = detail;
        })
    };

    let limit = 1.5;
    let area = with(Some(Detail { seed: 1, roughness: Roughness::Auto, limit_m: Some(limit) }));
    let plain = with(None);
    let flat = area.voxels().filter(|(x, _)| *x < 110).all(|(x, y)| area.height(x, y) == area.height(5, 5));
    assert!(flat);
    let added = area.voxels().map(|(x, y)| (area.height(x, y).unwrap() - plain.height(x, y).unwrap()).abs());
    let most = added.fold(0.0, f64::max);

    // At a place itself, and between posts of which it was taken away.
    assert!((limit..2.0 * limit + area.step() + plain.step()).contains(&most), "{most}");
}

#[test]
fn rounded_interpolation_follows_curves() {
    // Of third degree at most; and along the edges as well as in the middle.
    let slope = |x: f64, _: f64| 5.0 + 0.3 * x;
    let bowl = |x: f64, y: f64| 1e-3 * ((x - 400.0).powi(2) + (y - 300.0).powi(2));
    let wave = |x: f64, y: f64| 400.0 + 60.0 * (x * 0.02).sin() * (y * 0.017).cos();

    let of = |height: fn(f64, f64) -> f64, interpolation| {
        let raster = terrain(&Crs::local(), north_up(0.0, 800.0, 20.0), (40, 40), height);
        built(vec![raster], vec![], move |options| {
            (options.spacing, options.interpolation) = (Some(4.0), interpolation);
        })
    };

    let worst = |area: &Area, height: fn(f64, f64) -> f64, margin: u32| {
        let inner = |at: u32| (margin..area.grid.nx - margin).contains(&at);
        let voxels = area.voxels().filter(|(x, y)| inner(*x) && inner(*y));
        voxels
            .map(|(x, y)| {
                let (east, north) = area.centre(x, y);
                (area.height(x, y).unwrap() - height(east, north)).abs()
            })
            .fold(0.0, f64::max)
    };

    let [linear, bicubic, spline] =
        [Interpolation::Linear, Interpolation::Bicubic, Interpolation::Spline].map(|way| of(wave, way));
    let errors = [&linear, &bicubic, &spline].map(|area| worst(area, wave, 20));
    assert!(errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1], "{errors:?}");

    for way in [Interpolation::Bicubic, Interpolation::Spline] {
        let area = of(slope, way);
        // Half a post within the edge.
        assert!(worst(&area, slope, 3) <= area.step(), "{way:?}");
        let area = of(bowl, way);
        assert!(worst(&area, bowl, 18) <= area.step() * 1.01, "{way:?}");
    }
}

#[test]
fn rounded_tiles_join_as_one_raster() {
    let height = |x: f64, y: f64| 400.0 + 60.0 * (x * 0.02).sin() * (y * 0.017).cos() + 2.0 * (x * 0.1).sin();
    let tile = |column: u32| {
        terrain(&Crs::local(), north_up(f64::from(column) * 640.0, 640.0, 20.0), (32, 32), height)
    };
    let whole = || terrain(&Crs::local(), north_up(0.0, 640.0, 20.0), (64, 32), height);

    for way in [Interpolation::Linear, Interpolation::Bicubic, Interpolation::Spline] {
        let with = |rasters, detail: bool| {
            built(rasters, vec![], move |options| {
                (options.spacing, options.interpolation) = (Some(4.0), way);
                options.synthetic.detail =
                    detail.then_some(Detail { seed: 8, roughness: Roughness::Given(0.6), limit_m: None });
            })
        };

        let worst = |detail: bool, rows: std::ops::Range<u32>| {
            let (one, two) = (with(vec![whole()], detail), with(vec![tile(0), tile(1)], detail));
            let voxels = one.voxels().filter(|(_, y)| rows.contains(y));
            let apart = voxels.map(|(x, y)| (one.height(x, y).unwrap() - two.height(x, y).unwrap()).abs());
            (apart.fold(0.0, f64::max), one.step())
        };
        let (apart, step) = worst(false, 10..150);

        // Within a post of the seam the pixel behind it is guessed at.
        let most = if way == Interpolation::Linear { 2.0 * step } else { 0.8 };
        assert!(apart <= most, "{way:?}: {apart}");

        // Waves are the same, but near the seam their height is of the tile's own posts.
        assert!(worst(true, 10..150).0 < 3.0, "{way:?}");
    }
}

#[test]
fn coarse_levels_are_the_means_of_fine_ones_without_what_they_cannot_hold() {
    let waves = Hills { seed: 9, wavelength_m: 700.0, roughness: 0.8 };
    let hills = Terrain::Fractal { waves, amplitude_m: 90.0, crests: false, within: None };
    let ground = Synthetic { terrain: vec![plane(100.0), hills], ..Synthetic::default() };
    let grid = Grid { nx: 1024, ny: 1024, spacing: 1.5625, origin: DVec2::new(3e5, 5e6) };

    let heights = |level: u8| {
        let level = LevelGrid::of(&grid, level);
        let rect = Rect { x0: 0, y0: 0, x1: level.grid.nx, y1: level.grid.ny };
        let mut heights = vec![f64::NAN; rect.len()];
        ground.shape(&level, rect, &mut heights);
        heights
    };

    let (fine, coarse) = (heights(0), heights(2));
    let mut means = vec![0.0; 64 * 64];
    for (index, height) in fine.iter().enumerate() {
        means[index / 1024 / 16 * 64 + index % 1024 / 16] += height / 256.0;
    }

    let off = |coarse: &[f64]| {
        let apart: f64 = means.iter().zip(coarse).map(|(mean, height)| (mean - height).powi(2)).sum();
        (apart / 4096.0).sqrt()
    };
    // What the middle of each voxel would tell with all of its waves.
    let points: Vec<f64> =
        (0..4096).map(|voxel| fine[(voxel / 64 * 16 + 8) * 1024 + voxel % 64 * 16 + 8]).collect();

    assert!(
        off(&coarse) < 3.0 && off(&coarse) < 0.5 * off(&points),
        "{} m, not {} m",
        off(&coarse),
        off(&points)
    );
}
