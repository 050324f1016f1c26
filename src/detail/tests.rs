//! Means of voxels, amplitudes and the tile, against what they are made to hold.

use glam::DVec2;
use proptest::prelude::*;

use super::walls::STEEP;
use super::*;
use crate::simd::{Floats, Isa, Kernel, LANES, Simd};
use crate::voxel::{
    Attributes, DetailRecord, Grid, Material, MemPages, Metadata, PageId, PageSource, build_in_memory,
};
use hedgehop_base::colour::linear_from_srgb8;
use hedgehop_texture::Generator;

const SIDE: u32 = 40;

/// Tiles of a database that asks for nothing, under a sun of the morning.
fn usual() -> std::sync::Arc<DetailTiles> {
    DetailTiles::of(&DetailRecord::default(), SunAngles { azimuth: 135.0, elevation: 40.0 }).unwrap()
}

/// Level ground of the colours that `colour` gives posts.
fn ground(colour: impl Fn(i64, i64) -> [u8; 3]) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
    let posts = (0..i64::from(SIDE)).flat_map(|y| (0..i64::from(SIDE)).map(move |x| (x, y)));
    let colours: Vec<_> = posts.map(|(x, y)| colour(x, y)).collect();
    build_in_memory(grid, &vec![0.0; colours.len()], &colours, None, &Metadata::default()).unwrap()
}

/// Numbers that look random, 0…1.
fn chance(x: i64, y: i64, seed: u64) -> f64 {
    let mut mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9)
        ^ seed;
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 40) as f64 / (1_u64 << 24) as f64
}

fn at(blocks: &mut DetailBlocks, source: &MemPages, place: DVec2) -> DetailedColour {
    let id = PageId { level: 0, px: 0, py: 0 };
    let view = source.page(id).unwrap().unwrap();
    let post = (place - 0.5).floor();
    let share = (place - 0.5 - post).as_vec2();
    blocks.at(id, &view, PostCell { post: [post.x as i64, post.y as i64], share: share.to_array() })
}

/// Mean of a voxel's light between its posts, by Gauss's rule in each quarter, where light is bilinear.
fn voxel_mean(blocks: &mut DetailBlocks, source: &MemPages, voxel: [i64; 2]) -> f32 {
    let points =
        [0.25, 0.75].map(|middle: f64| [-1.0, 1.0].map(|side| middle + 0.25 * side / 3.0_f64.sqrt()));
    let mut sum = 0.0;
    for x in points.as_flattened() {
        for y in points.as_flattened() {
            sum += at(blocks, source, DVec2::new(voxel[0] as f64 + x, voxel[1] as f64 + y)).albedo.y;
        }
    }
    sum / 16.0
}

#[test]
fn light_between_posts_keeps_the_means_of_voxels() {
    for seed in 0..4 {
        let colour = |x: i64, y: i64| [120 + (16.0 * chance(x, y, seed)) as u8; 3];
        let source = ground(colour);
        let mut blocks = DetailBlocks::new(source.header());
        let mut worst = 0.0_f32;
        for (x, y) in (4..36).flat_map(|x| (4..36).map(move |y| (x, y))) {
            let own = linear_from_srgb8(colour(x, y))[1];
            worst = worst.max((voxel_mean(&mut blocks, &source, [x, y]) - own).abs());
        }
        assert!(worst < 1.0e-3, "{worst}");
    }
}

#[test]
fn light_keeps_its_sign_and_white_stays_white() {
    let source = ground(|x, y| if (x + y) % 2 == 0 { [255; 3] } else { [0; 3] });
    let mut blocks = DetailBlocks::new(source.header());
    for (x, y) in (0..400).flat_map(|x| (0..400).map(move |y| (x, y))) {
        let light = at(&mut blocks, &source, DVec2::new(f64::from(x), f64::from(y)) * 0.1).albedo;
        assert!(light.min_element() >= 0.0 && light.max_element() <= 1.0, "{light}");
    }
}

#[test]
fn amplitudes_follow_the_imagery_and_the_material() {
    // Roots of light of standard deviation 0.03 about 0.5, white from post to post.
    let rough = ground(|x, y| {
        let root = 0.5 + 0.03 * 12.0_f64.sqrt() * (chance(x, y, 9) - 0.5);
        [hedgehop_base::colour::srgb8_from_linear((root * root) as f32); 3]
    });
    let deviation = |source: &MemPages| {
        let mut blocks = DetailBlocks::new(source.header());
        let mut sum = 0.0;
        for (x, y) in (8..32).flat_map(|x| (8..32).map(move |y| (x, y))) {
            sum += at(&mut blocks, source, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).deviation;
        }
        sum / 576.0
    };
    // The filter leaves (1 − ¼)² + 4·⅛² + 4·(1/16)² of white energy; of neighbours that hang together the lesser sides have two thirds of the deviation.
    let left = (0.75_f32.powi(2) + 4.0 / 64.0 + 4.0 / 256.0).sqrt();
    let wanted = super::amplitude::PER_MAGNITUDE * 0.6 * 0.03 * left / 0.5;
    let found = deviation(&rough);
    assert!((found / wanted - 1.0).abs() < 0.15, "{found} for {wanted}");
    assert_eq!(deviation(&ground(|_, _| [120; 3])), 0.0);
    // Posts that are nearly white have little room: three deviations are white.
    let pale = linear_from_srgb8([235; 3])[0];
    let found = deviation(&ground(|x, y| [if chance(x, y, 5) < 0.5 { 225 } else { 245 }; 3]));
    assert!(found < 1.2 * (1.0 / pale - 1.0) / 3.0, "{found}");
    // Edges are no roughness.
    assert_eq!(deviation(&ground(|x, y| if x < 20 || y > 25 { [40; 3] } else { [200; 3] })), 0.0);
    assert!(
        deviation(&ground(|x, y| [if chance(x, y, 3) < 0.5 { 0 } else { 255 }; 3])) < 1.001 * MOST_DEVIATION
    );
    assert!(
        super::amplitude::material_factor(Material::Asphalt)
            < super::amplitude::material_factor(Material::Grass)
    );
}

/// Means of a tile over sixteen boxes on ground of a roughness.
struct Means<'t> {
    tile: &'t GroundTile,
    roughness: f32,
    centre: [[f32; LANES]; 2],
    squares: [[f32; LANES]; 2],
}

impl Kernel for Means<'_> {
    type Output = [f32; LANES];

    #[inline(always)]
    fn run<V: Simd>(self, simd: V) -> Self::Output {
        let mut means = [0.0; LANES];
        let [centre, squares] = [self.centre, self.squares].map(|axes| axes.map(|lanes| simd.load(&lanes)));
        self.tile.means(simd, simd.splat(self.roughness), centre, squares).store(&mut means);
        means
    }
}

#[test]
fn grounds_of_each_roughness_have_their_own_pattern() {
    let cells = [1, 2, 3].map(|seed| Generator::White.cells(seed).unwrap());
    let factors = [0.5, 1.0, 2.0];
    let patterns = std::array::from_fn::<_, 3, _>(|class| RoughPattern {
        least: 0.1 * class as f32,
        light: cells[class].joined(&cells[class], |value, _| factors[class] * value),
    });
    let tile = GroundTile::by_roughness(&patterns).unwrap();

    for (class, roughness) in [(0, 0.0), (0, 0.0999), (1, 0.1), (2, 0.2), (2, 7.0)] {
        let mut squares = 0.0;
        for (x, y) in (0..255).flat_map(|x| (0..255).map(move |y| (x, y))) {
            let place = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / 15.0;
            squares += tile.mean(roughness, place, DVec2::splat(1e-6)).powi(2);
        }
        // Means over voxels, rows and columns are taken away.
        let deviation = (squares / (255.0 * 255.0)).sqrt() / (factors[class] * cells[class].deviation());
        assert!((0.9..1.01).contains(&deviation), "{roughness}: {deviation}");

        let unit = DVec2::splat((1.0 - 1.0 / 225.0_f64).sqrt());
        assert!(tile.mean(roughness, DVec2::new(3.5, -8.5), unit).abs() < 1e-9);
        let lanes = |first: f32| std::array::from_fn(|lane| first + 11.3 * lane as f32);
        for isa in Isa::available() {
            let (centre, squares) = ([lanes(-40.0), lanes(7.0)], [lanes(1.0), lanes(2.0)]);
            let found = isa.run(Means { tile: &tile, roughness, centre, squares });
            for lane in 0..LANES {
                let at =
                    |axes: [[f32; LANES]; 2]| DVec2::new(f64::from(axes[0][lane]), f64::from(axes[1][lane]));
                let wanted = tile.mean(roughness, at(centre) / 15.0, at(squares).map(f64::sqrt) / 15.0);
                assert!(
                    (f64::from(found[lane]) - wanted).abs() < 2e-3,
                    "{roughness}: {} for {wanted}",
                    found[lane]
                );
            }
        }
    }
}

#[test]
fn voxels_have_no_mean_of_the_tile() {
    let tiles = usual();
    let tile = &tiles.ground;
    let unit = DVec2::splat((1.0 - 1.0 / 225.0_f64).sqrt());
    for (x, y) in (-20..20).flat_map(|x| (-20..20).map(move |y| (x, y))) {
        // Its side with a cell more is that of a voxel.
        let mean = tile.mean(0.0, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), unit);
        assert!(mean.abs() < 1e-9, "{x}, {y}: {mean}");
    }
}

#[test]
fn the_tile_varies_by_one_and_is_hardly_ever_darker_than_black() {
    let tiles = usual();
    let tile = &tiles.ground;
    let (mut sum, mut black) = (0.0, 0.0);
    for (x, y) in (0..255).flat_map(|x| (0..255).map(move |y| (x, y))) {
        let place = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / 15.0;
        let value = tile.mean(0.0, place, DVec2::splat(1e-6));
        sum += value * value;
        black += f64::from(u8::from(1.0 + value * f64::from(MOST_DEVIATION) < 0.0));
    }
    let [square, black] = [sum, black].map(|sum| sum / (255.0 * 255.0));
    assert!((square.sqrt() - 1.0).abs() < 0.05 && black < 0.015, "{square} {black}");
}

proptest! {
    #[test]
    fn sixteen_means_are_those_of_one_box(
        x in -400.0_f64..400.0, y in -400.0_f64..400.0, wide in 0.0_f64..4.0, high in 0.0_f64..4.0,
    ) {
        let tiles = usual();
        let tile = &tiles.ground;
        let lanes = |value: f64, step: f64| -> [f32; LANES] { std::array::from_fn(|lane| (value + step * lane as f64) as f32) };
        let (centre, sides) = ([lanes(15.0 * x, 3.7), lanes(15.0 * y, -1.3)], [wide, high]);
        let squares = sides.map(|side| lanes((15.0 * side).powi(2), 2.0));
        for isa in Isa::available() {
            let found = isa.run(Means { tile, roughness: 0.0, centre, squares });
            for lane in 0..LANES {
                let place = DVec2::new(f64::from(centre[0][lane]), f64::from(centre[1][lane])) / 15.0;
                let size = DVec2::new(f64::from(squares[0][lane]), f64::from(squares[1][lane])).map(f64::sqrt) / 15.0;
                let wanted = tile.mean(0.0, place, size);
                prop_assert!((f64::from(found[lane]) - wanted).abs() < 2e-3, "{isa}: {} for {wanted}", found[lane]);
            }
        }
    }
}

/// Ground that rises by `slope` (eastward and northward) per voxel, of the colours that `colour` gives posts.
fn incline(slope: [f64; 2], colour: impl Fn(i64, i64) -> [u8; 3]) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
    let posts = (0..i64::from(SIDE)).flat_map(|y| (0..i64::from(SIDE)).map(move |x| (x, y)));
    let (heights, colours): (Vec<_>, Vec<_>) =
        posts.map(|(x, y)| (slope[0] * x as f64 + slope[1] * y as f64, colour(x, y))).unzip();
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

#[test]
fn walls_are_calm_and_their_detail_lies_over_them() {
    let colour = |x: i64, y: i64| [100 + (60.0 * chance(x, y, 1)) as u8; 3];
    let look = |slope: [f64; 2]| -> Vec<DetailedColour> {
        let source = incline(slope, colour);
        let mut blocks = DetailBlocks::new(source.header());
        let posts = (8..32).flat_map(|x| (8..32).map(move |y| DVec2::new(f64::from(x), f64::from(y)) + 0.5));
        posts.map(|place| at(&mut blocks, &source, place)).collect()
    };
    let spread = |posts: &[DetailedColour]| {
        let mean = posts.iter().map(|post| post.albedo.y).sum::<f32>() / posts.len() as f32;
        (posts.iter().map(|post| (post.albedo.y - mean).powi(2)).sum::<f32>() / posts.len() as f32).sqrt()
            / mean
    };

    // Level ground and gentle slopes have none of it.
    let level = look([0.0, 0.0]);
    for (gentle, level) in look([1.0, 1.0]).iter().zip(&level) {
        assert_eq!(gentle, level);
        assert_eq!(level.wall, 0.0);
    }

    // 49 posts have a seventh of the spread of one; sharpened ones of the level have half as much again.
    for (slope, sign) in [([3.0, 0.5], 1.0), ([-3.0, 0.5], 1.0), ([0.5, 3.0], -1.0), ([1.0, -3.0], -1.0)] {
        let steep = look(slope);
        assert!(spread(&steep) < 0.2 * spread(&level), "{slope:?}: {} of {}", spread(&steep), spread(&level));
        for post in &steep {
            assert!(post.deviation < 1e-6 && post.wall * sign > 0.149, "{slope:?}: {post:?}");
        }
    }

    // Half of the way variance is shared.
    for (half, level) in look([(0.5 * f64::from(STEEP[0] + STEEP[1])).sqrt(), 0.0]).iter().zip(&level) {
        let whole = (half.deviation.powi(2) + half.wall.powi(2)).sqrt();
        assert!(whole > 0.999 * level.deviation && half.wall > 0.1, "{half:?} for {level:?}");
    }
}

#[test]
fn walls_of_smooth_materials_and_white_ones_are_calmer() {
    let look = |colour: u8, material: Material| {
        let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
        let posts = (SIDE * SIDE) as usize;
        let heights: Vec<_> = (0..posts).map(|post| 4.0 * (post % SIDE as usize) as f64).collect();
        let attributes = vec![Attributes { material: material.code(), ..Attributes::default() }; posts];
        let colours = vec![[colour; 3]; posts];
        let source =
            build_in_memory(grid, &heights, &colours, Some(&attributes), &Metadata::default()).unwrap();
        at(&mut DetailBlocks::new(source.header()), &source, DVec2::splat(20.5)).wall
    };
    let (rock, pale) = (look(120, Material::Rock), linear_from_srgb8([245; 3])[0]);
    assert!((rock - 0.15).abs() < 1e-6, "{rock}");
    assert!((look(120, Material::Concrete) - 0.5 * rock).abs() < 1e-6);
    assert!((look(245, Material::Rock) - (1.0 / pale - 1.0) / 3.0).abs() < 1e-4);
    assert_eq!(look(255, Material::Rock), 0.0);
}
