//! Profiles of planes against the reference marcher.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use hedgehop::Result;
use hedgehop::raymarch::scan::{
    BoundPyramid, MarchField, Outlook, Pages, PlaneGroup, PlaneMarch, Profile, Strides, TurnedPages,
    highest_code,
};
use hedgehop::raymarch::{GridRay, LevelBands, Marcher, Surface, ground_height};
use hedgehop::simd::{Isa, LANES};
use hedgehop::voxel::{
    BoundsView, Grid, Header, MemPages, Metadata, PageId, PageSource, PageView, SpansView, build_in_memory,
};

/// Rows of a test's planes.
pub(super) const ROWS: usize = 48;

pub(super) fn noise(x: f64, y: f64, seed: u32) -> f64 {
    let lattice = |i: i64, j: i64| {
        let mut bits = (i as u32).wrapping_mul(0x9E37_79B1)
            ^ (j as u32).wrapping_mul(0x85EB_CA77)
            ^ seed.wrapping_mul(0xC2B2_AE3D);
        bits = (bits ^ bits >> 15).wrapping_mul(0x2C1B_3C6D);
        bits = (bits ^ bits >> 12).wrapping_mul(0x297A_2D39);
        f64::from(bits ^ bits >> 15) / f64::from(u32::MAX)
    };
    let (i, j) = (x.floor(), y.floor());
    let (u, v) = (x - i, y - j);
    let (i, j) = (i as i64, j as i64);
    let near = lattice(i, j) * (1.0 - u) + lattice(i + 1, j) * u;
    let far = lattice(i, j + 1) * (1.0 - u) + lattice(i + 1, j + 1) * u;
    near * (1.0 - v) + far * v
}

/// Hills over 700 x 520 voxels of `spacing` metres; with holes where a voxel in a thousand is void.
fn hills(seed: u32, spacing: f64, holes: bool) -> MemPages {
    let (nx, ny) = (700, 520);
    let grid = Grid { nx, ny, spacing, origin: DVec2::new(500_000.0, 4_000_000.0) };
    let mut heights = Vec::new();
    for y in 0..ny {
        for x in 0..nx {
            let (x, y) = (f64::from(x), f64::from(y));
            let broad = noise(x / 90.0, y / 90.0, seed) * 60.0 + noise(x / 17.0, y / 17.0, seed ^ 5) * 12.0;
            let void = holes && noise(x, y, seed ^ 9) > 0.999;
            let height = (broad + noise(x, y, seed ^ 3) * 0.4) * spacing;
            heights.push(if void { f64::NAN } else { height });
        }
    }
    let colours = vec![[128; 3]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

/// Hills with holes over voxels of 1 m, made once for each seed.
fn holed(seed: u32) -> &'static MemPages {
    static AREAS: [OnceLock<MemPages>; SEEDS as usize] = [const { OnceLock::new() }; SEEDS as usize];
    AREAS[seed as usize].get_or_init(|| hills(seed, 1.0, true))
}

/// Seeds of [`holed`].
const SEEDS: u32 = 6;

/// Inverse depth of a plane's ray: on the first stretch that rises to it; 0: sky.
fn inverse_depth(profile: &Profile, lane: usize, tangent: f32) -> f32 {
    for pair in profile.segments().windows(2).filter(|pair| !pair[1].line.begins) {
        let [low, high] = [pair[0].slope.0[lane], pair[1].slope.0[lane]];
        if tangent < high {
            let share = ((tangent - low) / (high - low)).clamp(0.0, 1.0);
            let [near, far] = [pair[0].inverse.0[lane], pair[1].inverse.0[lane]];
            return near + share * (far - near);
        }
    }
    0.0
}

pub(super) struct View {
    pub eye: DVec3,
    pub yaw: f64,
    /// Elevation angles of the lowest and the highest row, degrees.
    pub elevations: [f64; 2],
    /// Angle between planes, radians.
    pub pixel: f64,
}

impl View {
    pub fn directions(&self) -> [DVec2; LANES] {
        std::array::from_fn(|lane| {
            let yaw = self.yaw.to_radians() + (lane as f64 - 7.5) * self.pixel;
            DVec2::new(yaw.sin(), yaw.cos())
        })
    }

    pub fn elevation(&self, row: usize) -> f64 {
        let share = row as f64 / (ROWS - 1) as f64;
        self.elevations[0] + share * (self.elevations[1] - self.elevations[0])
    }

    /// What planes see where steep ground is looked at `detail` times as closely as usual.
    fn profile(&self, source: &dyn PageSource, isa: Isa, detail: f32) -> Profile {
        self.profile_by(source, isa, detail, &BoundPyramid::new(source))
    }

    /// Finds what planes see that leap by `bounds`.
    fn profile_by(&self, source: &dyn PageSource, isa: Isa, detail: f32, bounds: &BoundPyramid) -> Profile {
        let grid = source.header().grid;
        let ground = (self.eye.truncate() - grid.origin) / grid.spacing;
        let group = PlaneGroup::new(&grid, ground, &self.directions(), 0.0);
        let outlook = Outlook { pixel_angle: self.pixel, clearance: f64::NEG_INFINITY, height: 0.0 };
        let strides = Strides::new(&grid, source.header().level_count, outlook, 1.0);
        let tangents = [0, ROWS - 1].map(|row| self.tangent(row));
        let field = MarchField { tangents, row: [self.pixel as f32; 2], detail };
        let (turned, mut profile) = (TurnedPages::default(), Profile::default());
        PlaneMarch::new(source, &turned, strides, bounds)
            .see(isa, ground.extend(self.eye.z), &group, field, &mut profile)
            .unwrap();
        profile
    }

    pub fn tangent(&self, row: usize) -> f32 {
        self.elevation(row).to_radians().tan() as f32
    }

    /// Ranges of rows and planes; infinite: sky.
    pub fn march(&self, source: &dyn PageSource, isa: Isa) -> Vec<[f64; LANES]> {
        self.ranges(&self.profile(source, isa, 1.0))
    }

    /// Ranges of rows and planes in a profile; infinite: sky.
    pub fn ranges(&self, profile: &Profile) -> Vec<[f64; LANES]> {
        (0..ROWS)
            .map(|row| {
                std::array::from_fn(|lane| {
                    let inverse = inverse_depth(profile, lane, self.tangent(row));
                    1.0 / f64::from(inverse) / self.elevation(row).to_radians().cos()
                })
            })
            .collect()
    }

    pub fn truth(&self, source: &impl PageSource) -> Vec<[f64; LANES]> {
        let grid = source.header().grid;
        let mut marcher = Marcher::new(source, LevelBands::finest_only(), Surface::Smooth);
        (0..ROWS)
            .map(|row| {
                let (sin, cos) = self.elevation(row).to_radians().sin_cos();
                self.directions().map(|ground| {
                    let ray = GridRay::new(&grid, self.eye, (ground * cos).extend(sin));
                    marcher.first_contact(&ray, 0.0).unwrap().map_or(f64::INFINITY, |contact| contact.range)
                })
            })
            .collect()
    }
}

/// Sorted relative range errors where both see ground, and the share of pixels where only one does.
pub(super) fn compare(found: &[[f64; LANES]], truth: &[[f64; LANES]]) -> (Vec<f64>, f64) {
    let pairs = found.iter().flatten().zip(truth.iter().flatten());
    let mut errors = Vec::new();
    let mut disagree = 0;
    for (&found, &truth) in pairs {
        match (found.is_finite(), truth.is_finite()) {
            (true, true) => errors.push((found - truth).abs() / truth.max(1e-9)),
            (false, false) => {}
            _ => disagree += 1,
        }
    }
    errors.sort_by(f64::total_cmp);
    (errors, f64::from(disagree) / (found.len() * LANES) as f64)
}

pub(super) fn views(count: u32, source: &MemPages) -> Vec<View> {
    let grid = source.header().grid;
    let random = |index: u32, what: u32| noise(f64::from(index), f64::from(what), 77);
    (0..count)
        .map(|index| {
            let place =
                DVec2::new(random(index, 1), random(index, 2)) * DVec2::new(700.0, 520.0) * 0.96 + 7.0;
            let position = grid.origin + place * grid.spacing;
            let ground = ground_height(source, position).unwrap().unwrap_or(0.0);
            let clearance = 0.5 * 2000.0_f64.powf(random(index, 3)) * grid.spacing;
            let low = -80.0 * random(index, 4) - 5.0;
            View {
                eye: position.extend(ground + clearance),
                yaw: 360.0 * random(index, 5),
                elevations: [low, low + 60.0 * random(index, 6) + 5.0],
                pixel: 0.0006,
            }
        })
        .collect()
}

#[test]
fn agrees_with_exact_intersection_within_the_bounds() {
    let mut errors = Vec::new();
    let mut worst = 0.0_f64;
    for (seed, spacing) in [(1, 1.0), (2, 30.0), (3, 0.1)] {
        let source = hills(seed, spacing, false);
        for view in views(60, &source) {
            let (mut found, disagree) = compare(&view.march(&source, Isa::best()), &view.truth(&source));
            worst = worst.max(disagree);
            errors.append(&mut found);
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |quantile: f64| errors[(errors.len() as f64 * quantile) as usize];
    let figures = [at(0.5), at(0.99), at(0.996), worst];
    assert!(at(0.5) <= 1.5e-4 && at(0.99) <= 3e-3 && at(0.996) <= 1e-2, "{figures:?}");
}

/// Hills of which a round part of the area is left, with a void in the middle.
fn island(seed: u32) -> MemPages {
    let side = 300;
    let grid = Grid { nx: side, ny: side, spacing: 10.0, origin: DVec2::new(500_000.0, 4_000_000.0) };
    let posts = (0..side * side).map(|post| (f64::from(post % side), f64::from(post / side)));
    let height = |(x, y): (f64, f64)| {
        let from_middle = (x - 150.3).hypot(y - 149.6);
        let is_there = (40.0..130.0).contains(&from_middle);
        if is_there { noise(x / 25.0, y / 25.0, seed) * 150.0 + from_middle } else { f64::NAN }
    };
    let heights: Vec<f64> = posts.map(height).collect();
    let colours = vec![[128; 3]; heights.len()];
    build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap()
}

#[test]
fn surfaces_end_where_their_cells_do() {
    // Rows straddle the far rim, behind which there is sky: it is where cells end. Where lines do 1.1e-3 would differ.
    let (mut found, mut pixels) = (0.0, 0);
    let source = island(11);
    let origin = source.header().grid.origin;
    for yaw in (0..360).step_by(7) {
        let yaw = f64::from(yaw);
        let (sin, cos) = yaw.to_radians().sin_cos();
        let eye = origin + DVec2::splat(1500.0) - 900.0 * DVec2::new(sin, cos);
        let view = View { eye: eye.extend(420.0), yaw, elevations: [-12.0, -4.0], pixel: 0.003 };
        let (_, disagree) = compare(&view.march(&source, Isa::best()), &view.truth(&source));
        found += disagree;
        pixels += 1;
    }
    let mean = found / f64::from(pixels);
    assert!(mean <= 8.5e-4, "{mean}");
}

#[test]
fn lines_are_sharp_where_ground_is_steep() {
    // A plain, and a slope of 45° from 1440 m away on: strides of two lines begin at 1400 m, over which it rises by more than three rows.
    let (nx, ny) = (80, 1600);
    let grid = Grid { nx, ny, spacing: 1.0, origin: DVec2::ZERO };
    let posts = (0..nx * ny).map(|post| f64::from(post / nx));
    let heights: Vec<f64> = posts.map(|y| (y - 1440.0).max(0.0)).collect();
    let colours = vec![[128; 3]; heights.len()];
    let source = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
    let eye = DVec3::new(40.0, 1.0, 2.0);
    let view = View { eye, yaw: 0.0, elevations: [-2.0, 20.0], pixel: 0.0005 };
    let spans = |detail: f32, distances: std::ops::Range<f32>| -> Vec<u8> {
        let profile = view.profile(&source, Isa::best(), detail);
        let marks = profile.segments().iter().map(|segment| segment.line);
        marks.filter(|mark| distances.contains(&mark.distance)).map(|mark| mark.span).collect()
    };
    let on_the_plain = spans(1.0, 1410.0..1438.0);
    assert!(!on_the_plain.is_empty() && on_the_plain.iter().all(|&span| span > 1), "{on_the_plain:?}");
    let on_the_slope = spans(1.0, 1444.0..1520.0);
    assert!(on_the_slope.len() >= 75 && on_the_slope.iter().all(|&span| span == 1), "{on_the_slope:?}");

    // Where less detail is asked for, two lines are one.
    let coarse = spans(0.2, 1444.0..1520.0);
    assert!(coarse.iter().all(|&span| span > 1), "{coarse:?}");
}

#[test]
fn instruction_sets_agree() {
    // A row that just touches a horizon may see it in one set and miss it in another.
    let source = holed(4);
    let views = views(40, source);
    for isa in Isa::available() {
        let (mut far, mut disagreeing) = (0, 0.0);
        for view in &views {
            let (errors, disagree) = compare(&view.march(source, isa), &view.march(source, Isa::PORTABLE));
            far += errors.iter().filter(|&&error| error > 1e-5).count();
            disagreeing += disagree;
        }
        let pixels = (views.len() * ROWS * LANES) as f64;
        assert!(
            far as f64 <= 1e-3 * pixels && disagreeing / views.len() as f64 <= 1e-4,
            "{isa} {far} {disagreeing}"
        );
    }
}

/// A database of which some finer pages are absent: those whose indices are `hidden` modulo five, or all of them.
pub(super) struct Sparse<'s> {
    pub all: &'s MemPages,
    pub hidden: u32,
}

pub(super) const ALL: u32 = u32::MAX;

impl PageSource for Sparse<'_> {
    fn header(&self) -> &Header {
        self.all.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        if self.hides(id) { Ok(None) } else { self.all.page(id) }
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if self.hides(id) { Ok(None) } else { self.all.spans(id) }
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        if self.hides(id) { Ok(None) } else { self.all.bounds(id) }
    }
}

impl Sparse<'_> {
    fn hides(&self, id: PageId) -> bool {
        let is_coarsest = id.level + 1 == self.header().level_count;
        let index = (3 * id.px + id.py + u32::from(id.level)) % 5;
        !is_coarsest && (self.hidden == ALL || index == self.hidden)
    }
}

#[test]
fn a_mountain_of_which_finer_pages_are_absent_is_in_sight() {
    // A plain with a cone of 200 m.
    let grid = Grid { nx: 768, ny: 768, spacing: 1.0, origin: DVec2::ZERO };
    let posts = (0..768 * 768).map(|post| DVec2::new(f64::from(post % 768), f64::from(post / 768)));
    let heights: Vec<f64> = posts.map(|at| (200.0 - at.distance(DVec2::splat(384.0))).max(0.0)).collect();
    let colours = vec![[128; 3]; heights.len()];
    let all = build_in_memory(grid, &heights, &colours, None, &Metadata::default()).unwrap();
    let sparse = Sparse { all: &all, hidden: ALL };
    for (yaw, x, y) in [(0.0, 384.0, 10.0), (90.0, 10.0, 384.0), (180.0, 384.0, 758.0), (270.0, 758.0, 384.0)]
    {
        let view = View { eye: DVec3::new(x, y, 20.0), yaw, elevations: [0.5, 40.0], pixel: 2.0e-3 };
        let seen = |source: &dyn PageSource| {
            view.march(source, Isa::best()).iter().flatten().filter(|range| range.is_finite()).count()
        };
        let (whole, sparse) = (seen(&all), seen(&sparse));
        // The cone's top is lower by what coarse voxels smooth away.
        assert!(whole > ROWS * LANES / 2 && sparse * 4 >= whole * 3, "{yaw}: {sparse} of {whole} pixels");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn bounds_of_absent_pages_are_those_of_coarser_voxels(
        hidden in 0_u32..5, level in 1_u8..3, axis in 0_usize..2, at in [(0.0..1.0_f64, 0.0..1.0_f64), (0.0..1.0_f64, 0.0..1.0_f64)],
    ) {
        let all = holed(1);
        let sparse = Sparse { all, hidden };
        let turned = TurnedPages::default();
        let dims = all.header().grid.dims(level);
        let [along, across] = if axis == 0 { [dims.0, dims.1] } else { [dims.1, dims.0] };
        let index = |share: f64, length: u32| ((share * f64::from(length)) as u32).min(length - 1);
        let [major, minor] = [(at[0], along), (at[1], across)].map(|(ends, length)| {
            let ends = [ends.0, ends.1].map(|share| index(share, length));
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        });
        let bound = |source: &dyn PageSource, level: u8, scale: u32| {
            let [major, minor] = [major, minor].map(|ends| ends.map(|index| index / scale));
            highest_code(&mut Pages::new(source, &turned), level, axis, major, minor).unwrap()
        };

        let mut pages = Pages::new(all, &turned);
        let mut one = |along: u32, across: u32| highest_code(&mut pages, level, axis, [along; 2], [across; 2]).unwrap();
        let voxels = (major[0]..=major[1]).flat_map(|along| (minor[0]..=minor[1]).map(move |across| (along, across)));
        let one_by_one = voxels.map(|(along, across)| one(along, across)).max();
        prop_assert_eq!(one_by_one, Some(bound(all, level, 1)));
        let coarsest = all.header().level_count - 1;
        let scale = Grid::side_units(coarsest) / Grid::side_units(level);
        let (exact, sparse, coarse) = (bound(all, level, 1), bound(&sparse, level, 1), bound(all, coarsest, scale));
        prop_assert!(exact <= sparse && sparse <= coarse, "{exact} {sparse} {coarse}");
    }

    #[test]
    fn leaps_change_nothing_that_is_seen(
        seed in 0_u32..SEEDS, x in -900.0..1600.0_f64, y in -900.0..1400.0_f64, z in 0.0..900.0_f64,
        yaw in 0.0..360.0_f64, low in -40.0..0.0_f64, extent in 1.0..60.0_f64, pixel in 1e-4..0.03_f64,
    ) {
        let source = holed(seed);
        let eye = (source.header().grid.origin + DVec2::new(x, y)).extend(z);
        let view = View { eye, yaw, elevations: [low, low + extent], pixel };
        let with = view.ranges(&view.profile(source, Isa::best(), 1.0));
        let without = view.ranges(&view.profile_by(source, Isa::best(), 1.0, &BoundPyramid::default()));
        prop_assert_eq!(with, without);
    }

    #[test]
    fn nothing_panics(
        seed in 0_u32..SEEDS, x in -900.0..1600.0_f64, y in -900.0..1400.0_f64, z in -50.0..3000.0_f64,
        yaw in 0.0..360.0_f64, low in -89.9..80.0_f64, extent in 0.01..60.0_f64, pixel in 1e-5..0.08_f64,
    ) {
        let source = holed(seed);
        let eye = (source.header().grid.origin + DVec2::new(x, y)).extend(z);
        let view = View { eye, yaw, elevations: [low, (low + extent).min(89.9)], pixel };
        for isa in Isa::available() {
            prop_assert!(view.march(source, isa).iter().flatten().all(|range| *range >= 0.0));
        }
    }
}
