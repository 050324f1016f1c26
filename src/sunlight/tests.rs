use std::sync::Mutex;

use glam::DVec2;

use super::*;
use crate::simd::Isa;
use crate::voxel::{
    BoundsView, Grid, Header, HeightsView, MemPages, Metadata, PAGE_SIDE, PageId, PageSource, PageView,
    SpansView, build_in_memory,
};
use hedgehop_base::error::Result;

fn area(side: u32, spacing: f64, height: impl Fn(f64, f64) -> f64) -> MemPages {
    let grid = Grid { nx: side, ny: side, spacing, origin: DVec2::ZERO };
    let posts = (0..side).flat_map(|y| (0..side).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let heights: Vec<f64> = posts.map(|(x, y)| height(x, y)).collect();
    let colours = vec![[128; 3]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

fn sun(azimuth: f64, elevation: f64) -> Sun {
    Sun { azimuth, elevation }
}

/// Share of the sun at a place, units.
fn share(source: &MemPages, shades: &Shades, units: [f64; 2]) -> f32 {
    ShadeSampler::new(shades).share(source, 0, units.into()).unwrap()
}

fn shades(source: &MemPages, sun: Sun) -> Shades {
    Shades::new(Shade::new(source.header(), sun), usize::MAX)
}

/// Hills of many sizes, metres.
fn hills(x: f64, y: f64) -> f64 {
    let wave = |length: f64, turn: f64| {
        let (sin, cos) = turn.sin_cos();
        ((x * cos + y * sin) / length).sin() * ((y * cos - x * sin) / length * 0.8).sin() * length * 0.25
    };
    400.0 + wave(170.0, 0.3) + wave(61.0, 1.1) + wave(23.0, 2.0) + wave(9.0, 2.9)
}

#[test]
fn a_towers_shadow_is_as_long_as_its_height_over_the_suns_tangent() {
    // 30 m high on a plain, an edge of it across the sun's rays, the last post of its roof 5 (aslant 2 eastward and 2 northward) from its middle.
    let square = |x: f64, y: f64| x.abs().max(y.abs());
    let diamond = |x: f64, y: f64| x.abs() + y.abs();
    let tower = |form: &dyn Fn(f64, f64) -> f64| {
        area(1024, 1.0, |x, y| if form(x - 512.5, y - 512.5) < 5.5 { 130.0 } else { 100.0 })
    };
    let (upright, turned) = (tower(&square), tower(&diamond));

    for elevation in [4.0_f64, 6.0, 8.0, 11.0, 15.0, 20.0, 27.0, 35.0, 45.0, 60.0] {
        for azimuth in (0..360).step_by(45) {
            let (source, roof) =
                if azimuth % 90 == 0 { (&upright, 5.0) } else { (&turned, 4.0 / 2.0_f64.sqrt()) };
            let shades = shades(source, sun(f64::from(azimuth), elevation));
            let mut sampler = ShadeSampler::new(&shades);
            let (sin, cos) = f64::from(azimuth).to_radians().sin_cos();
            let mut is_dark = |distance: f64| {
                let place = DVec2::new(512.5 - sin * distance, 512.5 - cos * distance);
                sampler.share(source, 0, place).unwrap() < 0.5
            };
            let wanted = roof + 30.0 / elevation.to_radians().tan();
            let distances = (0..25_000).map(|step| roof + 1.5 + 0.02 * f64::from(step));
            let length = distances.filter(|distance| is_dark(*distance)).fold(0.0, f64::max);
            assert!((length - wanted).abs() < 1.0, "{azimuth} {elevation}: {length}, not {wanted}");
        }
    }
}

/// Whether a ray towards the sun's middle from a post meets the bilinear surface of `posts`, rows of `side`: walked in small
/// steps, by its own arithmetic.
fn is_dark(posts: &[f64], at: [f64; 2], side: u32, sun: Sun) -> bool {
    let last = f64::from(side - 1);
    let post = |x: f64, y: f64| posts[(y.min(last) * f64::from(side) + x.min(last)) as usize];
    let surface = |x: f64, y: f64| {
        let (x, y) = (x - 0.5, y - 0.5);
        let [west, south] = [x, y].map(f64::floor);
        let (u, v) = (x - west, y - south);
        let [low, high] = [0.0, 1.0]
            .map(|north| post(west, south + north) * (1.0 - u) + post(west + 1.0, south + north) * u);
        low * (1.0 - v) + high * v
    };

    let (sin, cos) = sun.azimuth.to_radians().sin_cos();
    let (start, rise) = (surface(at[0], at[1]), sun.elevation.to_radians().tan());
    let mut distance = 0.1;
    loop {
        let (x, y) = (at[0] + sin * distance, at[1] + cos * distance);
        let z = start + distance * rise;
        let within = 0.5..=f64::from(side) - 0.5;
        if !within.contains(&x) || !within.contains(&y) || z > 520.0 {
            return false;
        }
        if surface(x, y) > z + 1e-6 {
            return true;
        }
        distance += 0.1;
    }
}

#[test]
fn shadows_are_those_of_rays_towards_the_sun() {
    let side = 700;
    let source = area(side, 1.0, hills);
    // Asked of the waves once a post, not at each step.
    let posts: Vec<f64> = (0..side)
        .flat_map(|y| (0..side).map(move |x| hills(f64::from(x) + 0.5, f64::from(y) + 0.5)))
        .collect();
    for (azimuth, elevation) in [(135.0, 20.0), (10.0, 8.0), (262.0, 14.0), (300.0, 4.0)] {
        let sun = sun(azimuth, elevation);
        let shades = shades(&source, sun);
        let mut sampler = ShadeSampler::new(&shades);
        let (mut dark, mut wrong, mut all) = (0, 0, 0);

        for y in (1..side - 1).step_by(7) {
            for x in (1..side - 1).step_by(7) {
                let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let wanted = is_dark(&posts, at, side, sun);
                let share = f64::from(sampler.share(&source, 0, at.into()).unwrap());
                (all, dark) = (all + 1, dark + i32::from(wanted));

                // Ground that faces away has no light to lose.
                let slope =
                    |dx: f64, dy: f64| 0.5 * (hills(at[0] + dx, at[1] + dy) - hills(at[0] - dx, at[1] - dy));
                let towards =
                    [sun.direction().x, sun.direction().y].map(|part| f64::from(part / sun.direction().z));
                let light = 1.0 - slope(1.0, 0.0) * towards[0] - slope(0.0, 1.0) * towards[1];
                let lost = light.clamp(0.0, 1.0) * (share - f64::from(u8::from(!wanted))).abs();
                wrong += i32::from(wanted != (share < 0.5) && lost > 0.1);
            }
        }

        assert!(dark * 20 > all, "{azimuth} {elevation}: {dark} of {all} are dark");
        assert!(wrong * 100 <= all, "{azimuth} {elevation}: {wrong} of {all} posts are wrong");
    }
}

#[test]
fn far_mountains_throw_shadows_over_coarser_levels() {
    // A wall 1700 voxels away, which three levels lead to.
    let source = area(2600, 2.0, |_, y| if y > 2400.0 { 600.0 } else { 100.0 });
    let elevation = (500.0_f64 / (2.0 * 1700.0)).atan().to_degrees();
    let at = |distance: f64| {
        let shades = shades(&source, sun(0.0, elevation));
        share(&source, &shades, [1300.5, 2400.0 - distance])
    };
    assert_eq!([at(1600.0), at(1800.0)], [0.0, 1.0]);
    // The half-shadow is as wide as the sun seen from there: 2·0.2666° of 3400 m, over the ray's incline.
    let middle = at(1700.0);
    assert!((middle - 0.5).abs() < 0.15, "{middle}");
    let spread = 3400.0 * 2.0 * 0.2666_f64.to_radians() / (2.0 * elevation.to_radians().sin().tan());
    let [inner, outer] = [at(1700.0 - 0.25 * spread), at(1700.0 + 0.25 * spread)];
    assert!((outer - inner - 0.5).abs() < 0.1, "{inner} {outer}");
}

#[test]
fn ground_that_faces_away_is_lit_as_long_as_rays_graze_it() {
    for (slope, wanted) in [(0.2, 1.0), (0.33, 1.0), (0.40, 0.0)] {
        // Rises towards the sun, which stands a slope of 0.364 high.
        let source = area(512, 1.0, |_, y| slope * y);
        let shades = shades(&source, sun(0.0, 20.0));
        let found = share(&source, &shades, [100.3, 100.7]);
        assert!((found - wanted).abs() < 0.05, "{slope}: {found}");
    }
}

#[test]
fn instruction_sets_agree_and_neighbours_meet() {
    let source = area(600, 1.0, hills);
    for azimuth in [20.0, 110.0, 200.0, 290.0] {
        let shade = Shade::new(source.header(), sun(azimuth, 6.0));
        let page = |px, py| shade.page(&source, PageId { level: 0, px, py }).unwrap().unwrap();
        let own = page(0, 0);
        for isa in Isa::available() {
            let other = shade.clone().with_isa(isa);
            assert!(other.page(&source, PageId { level: 0, px: 0, py: 0 }).unwrap().unwrap() == own, "{isa}");
        }

        let (east, north) = (page(1, 0), page(0, 1));
        let [side, apron] = [PAGE_SIDE, SHADE_APRON].map(|count| count as usize);
        let mut most = 0;
        for along in 0..own.stride {
            for beside in side..side + 2 * apron {
                let pairs = [
                    (
                        own.shares[along * own.stride + beside],
                        east.shares[along * east.stride + beside - side],
                    ),
                    (
                        own.shares[beside * own.stride + along],
                        north.shares[(beside - side) * north.stride + along],
                    ),
                ];
                most = pairs.iter().map(|(a, b)| a.abs_diff(*b)).fold(most, u8::max);
            }
        }

        assert!(most <= 2, "{azimuth}: {most}");
    }
}

/// Notes whose heights were read.
struct Noting<'a>(&'a MemPages, Mutex<Vec<PageId>>);

impl PageSource for Noting<'_> {
    fn header(&self) -> &Header {
        self.0.header()
    }

    fn page(&self, _: PageId) -> Result<Option<PageView<'_>>> {
        panic!("paint is read for shadows")
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        self.1.lock().unwrap().push(id);
        self.0.heights(id)
    }

    fn spans(&self, _: PageId) -> Result<Option<SpansView<'_>>> {
        panic!("spans are read for shadows")
    }

    fn bounds(&self, _: PageId) -> Result<Option<BoundsView<'_>>> {
        panic!("bounds are read for shadows")
    }
}

#[test]
fn what_is_read_was_foretold() {
    let source = area(1300, 1.0, hills);
    for azimuth in (0..360).step_by(17) {
        for elevation in [1.0, 9.0, 50.0] {
            let shade = Shade::new(source.header(), sun(f64::from(azimuth), elevation));
            for (level, px, py) in
                [(0, 0, 0), (0, 2, 3), (0, 5, 5), (1, 0, 0), (1, 1, 1), (2, 0, 0), (3, 0, 0)]
            {
                let id = PageId { level, px, py };
                let noting = Noting(&source, Mutex::default());
                shade.page(&noting, id).unwrap().unwrap();
                let read = noting.1.into_inner().unwrap();
                let foretold = shade.supports(&source, id);
                let missed: Vec<_> = read.iter().filter(|page| !foretold.contains(page)).collect();
                assert!(missed.is_empty(), "{id} under {azimuth}, {elevation}: {missed:?} of {foretold:?}");
                let idle = foretold.iter().filter(|page| !read.contains(page)).count();
                assert!(idle <= 2, "{id} under {azimuth}, {elevation}: {idle} of {} idle", foretold.len());
            }
        }
    }
}
