//! Planes over displaced ground against the reference marcher, and what bounds must not change of either.

use std::sync::{Arc, OnceLock};

use glam::DVec2;
use proptest::prelude::*;

use super::profiles::{ROWS, View, compare, noise, views};
use hedgehop::Result;
use hedgehop::detail::{DisplacedRelief, Displacement, DisplacementView};
use hedgehop::raymarch::scan::{
    BoundPyramid, DisplacedField, DisplacedPages, MarchField, Outlook, PlaneGroup, PlaneMarch, Profile,
    Strides, TurnedPages,
};
use hedgehop::raymarch::{Contact, GridRay, LevelBands, Marcher, Surface};
use hedgehop::simd::{Isa, LANES};
use hedgehop::voxel::{
    Attributes, BoundsView, DetailRecord, Grid, Header, Material, MemPages, Metadata, PageId, PageSource,
    PageView, build_in_memory,
};

/// Hills over 420 x 300 voxels of 1 m, with patches of grass and gravel; with holes where a voxel in a thousand is void.
fn hills(seed: u32, holes: bool) -> MemPages {
    let (nx, ny) = (420, 300);
    let grid = Grid { nx, ny, spacing: 1.0, origin: DVec2::new(500_000.0, 4_000_000.0) };
    let (mut heights, mut attributes) = (Vec::new(), Vec::new());
    for (x, y) in (0..ny).flat_map(|y| (0..nx).map(move |x| (f64::from(x), f64::from(y)))) {
        let height = noise(x / 60.0, y / 60.0, seed) * 30.0 + noise(x / 13.0, y / 13.0, seed ^ 5) * 4.0;
        heights.push(if holes && noise(x, y, seed ^ 9) > 0.999 { f64::NAN } else { height });
        let is_grass = noise(x / 9.0, y / 9.0, seed ^ 17) > 0.5;
        let material = if is_grass { Material::Grass } else { Material::Gravel }.code();
        attributes.push(Attributes { material, ..Attributes::default() });
    }
    let detail = DetailRecord {
        displacements: [("grass".to_owned(), 0.4), ("gravel".to_owned(), 0.1)].into(),
        ..DetailRecord::default()
    };
    let metadata = Metadata { detail: Some(detail), ..Metadata::default() };
    let colours = vec![[128; 3]; heights.len()];
    build_in_memory(grid, &heights, &colours, Some(&attributes), &metadata).unwrap()
}

/// Displacement as a view sees it, from as high above the ground as no eye is here.
fn displacement(view: &View, header: &Header) -> Displacement {
    static RELIEF: OnceLock<Arc<DisplacedRelief>> = OnceLock::new();
    let relief = RELIEF.get_or_init(|| Arc::new(DisplacedRelief::of(header, 1.0).unwrap().unwrap()));
    let eye = (view.eye.truncate() - header.grid.origin) / header.grid.spacing;
    let view = DisplacementView { eye, above: 0.0, pixel: view.pixel, end: 0.25 / view.pixel };
    Displacement::new(relief.clone(), view).unwrap()
}

/// Finds what planes see by bounds of coarse squares.
fn see(view: &View, source: &dyn PageSource, bounds: &BoundPyramid) -> Vec<[f64; LANES]> {
    let header = source.header();
    let ground = (view.eye.truncate() - header.grid.origin) / header.grid.spacing;
    let group = PlaneGroup::new(&header.grid, ground, &view.directions(), 0.0);
    let outlook = Outlook { pixel_angle: view.pixel, clearance: f64::NEG_INFINITY, height: 0.0 };
    let strides = Strides::new(&header.grid, header.level_count, outlook, 1.0);
    let tangents = [0, ROWS - 1].map(|row| view.tangent(row));
    let field = MarchField { tangents, row: [view.pixel as f32; 2], detail: 1.0 };
    let (turned, mut profile) = (TurnedPages::default(), Profile::default());

    let (displacement, eye) = (displacement(view, header), ground.extend(view.eye.z));
    let pages = DisplacedPages::of(source, &displacement, 0, [group.clone()].into_iter());
    let displaced = DisplacedField::new(source, &displacement, &pages).unwrap();
    PlaneMarch::new(source, &turned, strides, bounds)
        .displaced(displaced.as_ref())
        .see(Isa::best(), eye, &group, field, &mut profile)
        .unwrap();
    view.ranges(&profile)
}

fn march(view: &View, source: &dyn PageSource) -> Vec<[f64; LANES]> {
    see(view, source, &BoundPyramid::new(source))
}

/// Contacts that the reference finds, each ray from where the one below it ended if they are to be `coherent`; `None`: the sky.
fn contacts(view: &View, source: &dyn PageSource, coherent: bool) -> Vec<[Option<Contact>; LANES]> {
    let grid = source.header().grid;
    let displacement = displacement(view, source.header());
    let mut marcher =
        Marcher::new(source, LevelBands::finest_only(), Surface::Smooth).displaced(Some(&displacement));
    let mut begins = [0.0; LANES];
    (0..ROWS)
        .map(|row| {
            let (sin, cos) = view.elevation(row).to_radians().sin_cos();
            let directions = view.directions();
            std::array::from_fn(|lane| {
                let ray = GridRay::new(&grid, view.eye, (directions[lane] * cos).extend(sin));
                let contact = marcher.first_contact(&ray, begins[lane]).unwrap();
                if coherent {
                    begins[lane] = contact.map_or(f64::INFINITY, |contact| contact.range * ray.ground_cosine);
                }
                contact
            })
        })
        .collect()
}

fn ranges(contacts: &[[Option<Contact>; LANES]]) -> Vec<[f64; LANES]> {
    let range = |contact: Option<Contact>| contact.map_or(f64::INFINITY, |contact| contact.range);
    contacts.iter().map(|row| row.map(range)).collect()
}

/// Views from low above the ground: half a metre to 60 m.
fn low_views(count: u32, source: &MemPages) -> Vec<View> {
    let grid = source.header().grid;
    let inside = |view: &View| (view.eye.truncate() - grid.origin).cmplt(DVec2::new(410.0, 290.0)).all();
    views(4 * count, source).into_iter().filter(inside).take(count as usize).collect()
}

/// A database without bounds: nothing of it can be passed over.
struct Unbounded<'s>(&'s MemPages);

impl PageSource for Unbounded<'_> {
    fn header(&self) -> &Header {
        self.0.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.0.page(id)
    }

    fn bounds(&self, _: PageId) -> Result<Option<BoundsView<'_>>> {
        Ok(None)
    }
}

#[test]
fn planes_see_displaced_ground_as_the_reference_does() {
    let mut errors = Vec::new();
    let (mut worst, mut moved, mut pixels) = (0.0_f64, 0, 0);
    for seed in [1, 2] {
        let source = hills(seed, false);
        for view in low_views(30, &source) {
            let truth = ranges(&contacts(&view, &source, false));
            let (mut found, disagree) = compare(&march(&view, &source), &truth);
            worst = worst.max(disagree);
            errors.append(&mut found);
            let plain = view.truth(&source);
            let pairs = plain.iter().flatten().zip(truth.iter().flatten());
            moved += pairs.filter(|(plain, truth)| (*plain - *truth).abs() > 3e-3 * **truth).count();
            pixels += ROWS * LANES;
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |quantile: f64| errors[(errors.len() as f64 * quantile) as usize];
    let figures = [at(0.5), at(0.99), at(0.996), worst];
    // As near as of ground that is not displaced.
    assert!(at(0.5) <= 1.5e-4 && at(0.99) <= 3e-3 && at(0.996) <= 1e-2, "{figures:?}");
    assert!(moved * 4 > pixels, "{moved} of {pixels} pixels are moved");
}

#[test]
fn range_coherence_changes_nothing_of_displaced_ground() {
    let source = hills(3, false);
    for view in low_views(25, &source) {
        let [each, coherent] = [false, true].map(|coherent| ranges(&contacts(&view, &source, coherent)));
        for (one, other) in each.iter().flatten().zip(coherent.iter().flatten()) {
            assert!(one == other || (one - other).abs() <= 1e-9 * one, "{one} {other}");
        }

        // Higher rays end no nearer, over the ground.
        for row in 1..ROWS {
            let cosines = [row - 1, row].map(|row| view.elevation(row).to_radians().cos());
            for (below, above) in each[row - 1].iter().zip(&each[row]) {
                let [below, above] = [below * cosines[0], above * cosines[1]];
                assert!(above >= below * (1.0 - 1e-9), "{below} m, then {above} m");
            }
        }
    }
}

#[test]
fn bounds_change_nothing_of_displaced_ground() {
    for (seed, holes) in [(4, false), (5, true)] {
        let source = hills(seed, holes);
        for view in low_views(25, &source) {
            let free = Unbounded(&source);
            assert_eq!(march(&view, &source), see(&view, &free, &BoundPyramid::default()));
            let [bounded, free] =
                [&source as &dyn PageSource, &free].map(|source| ranges(&contacts(&view, source, false)));
            for (one, other) in bounded.iter().flatten().zip(free.iter().flatten()) {
                assert!(one == other || (one - other).abs() <= 1e-9 * one, "{one} {other}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn nothing_panics_over_displaced_ground(
        x in -300.0..700.0_f64, y in -300.0..600.0_f64, z in -20.0..90.0_f64,
        yaw in 0.0..360.0_f64, low in -89.9..40.0_f64, extent in 0.01..60.0_f64, pixel in 5e-4..0.03_f64,
    ) {
        static AREA: OnceLock<MemPages> = OnceLock::new();
        let source = AREA.get_or_init(|| hills(6, true));
        let eye = (source.header().grid.origin + DVec2::new(x, y)).extend(z);
        let view = View { eye, yaw, elevations: [low, (low + extent).min(89.9)], pixel };
        let with = march(&view, source);
        prop_assert!(with.iter().flatten().all(|range| *range >= 0.0));
        prop_assert_eq!(with, see(&view, source, &BoundPyramid::default()));
    }
}
