//! Detail below the voxel and levels above it: what they must not cost or change.

use std::collections::BTreeSet;
use std::sync::Mutex;

use glam::{DVec2, DVec3};

use crate::scene::{Terrain, View, clear_air};
use hedgehop::Result;
use hedgehop::colour::srgb8_picture;
use hedgehop::frame::Frame;
use hedgehop::raymarch::Surface;
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{
    BoundsView, DetailRecord, Header, HeightsView, MemPages, Metadata, PageId, PageSource, PageView,
    SpansView,
};
use hedgehop::weather::{GroundCover, Weather};
use hedgehop_texture::{Generator, MatchedPattern, RoughnessClass};

/// Pages of which it is known which were asked for.
struct Watched {
    pages: MemPages,
    asked: Mutex<BTreeSet<[u32; 4]>>,
}

impl Watched {
    fn ask(&self, kind: u32, id: PageId) {
        self.asked.lock().unwrap().insert([kind, id.level.into(), id.px, id.py]);
    }
}

impl PageSource for Watched {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.ask(0, id);
        self.pages.page(id)
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        self.ask(1, id);
        self.pages.heights(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        self.ask(2, id);
        self.pages.bounds(id)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        self.ask(3, id);
        self.pages.spans(id)
    }
}

/// Hills of several wavelengths with posts of so many metres, in one grey or in many.
fn hills(spacing: f64, is_rough: bool) -> MemPages {
    let height = |at: DVec2| {
        100.0
            + 25.0 * (at.x / 140.0).sin() * (at.y / 110.0).cos()
            + 2.0 * (at.x / 23.0).cos()
            + (at.y / 9.0).sin()
    };
    let colour = |at: DVec2| {
        let mixed = (at.x * 12.9898 + at.y * 78.233).sin() * 43_758.547;
        [if is_rough { 100 + (40.0 * (mixed - mixed.floor())) as u8 } else { 130 }; 3]
    };
    Terrain::new([600, 600], spacing, height, colour).in_memory()
}

const VIEW: View =
    View { eye: DVec3::new(560.0, 250.0, 135.0), ypr: [20.0, -14.0, 5.0], hfov: 60.0, size: [160, 120] };

/// From so high that all ground is hundreds of metres away, where levels change.
const HIGH: View = View { eye: DVec3::new(600.0, 20.0, 420.0), ypr: [0.0, -30.0, 0.0], ..VIEW };

fn see(source: &impl PageSource, view: &View, options: &RenderOptions) -> Frame {
    let farm = Farm::new(2).unwrap();
    Renderer::new(source, options).frame_with(&view.camera(), &[], &farm).unwrap().frame
}

#[test]
fn detail_reads_the_same_pages_as_without() {
    for engine in [Engine::Planes, Engine::Reference] {
        let [on, off] = [1.0, 0.0].map(|detail_synthesis| {
            let watched = Watched { pages: hills(2.0, true), asked: Mutex::default() };
            let frame = see(&watched, &VIEW, &RenderOptions { engine, detail_synthesis, ..clear_air() });
            (watched.asked.into_inner().unwrap(), frame)
        });
        assert!(on.0.len() > 4, "{:?}", on.0);
        assert_eq!(on.0, off.0, "{engine:?}");

        // It is there, and is colour alone.
        assert_eq!(on.1.range, off.1.range, "{engine:?}");
        let changed = on.1.colour.iter().zip(&off.1.colour).filter(|(on, off)| on != off).count();
        assert!(changed > 4000, "{engine:?}: {changed} pixels");
    }
}

#[test]
fn the_channel_of_synthesis_is_the_change_of_light() {
    let ground = hills(2.0, true);
    for engine in [Engine::Planes, Engine::Reference] {
        let [on, off] = [1.0, 0.0].map(|detail_synthesis| {
            let usual = RenderOptions { engine, detail_synthesis, tells_synthesis: true, ..clear_air() };
            see(&ground, &VIEW, &usual)
        });
        let told = on.aov.synthesis.as_ref().unwrap();
        let none = off.aov.synthesis.as_ref().unwrap();
        assert!(none.iter().all(|change| *change == 0.0));

        // Planes lie up to half a pixel beside a pixel's own ray; the reference follows it.
        let (mut off_by, mut size) = (0.0, 0.0);
        for (pixel, told) in told.iter().enumerate() {
            let [with, without] = [&on, &off].map(|frame| frame.colour[pixel][1]);
            let seen = if without > 0.01 { with / without - 1.0 } else { 0.0 };
            off_by += (seen - told).abs();
            size += told.abs();
        }
        let (mean, share) = (size / told.len() as f32, off_by / size);
        let least = if engine == Engine::Reference { 0.01 } else { 0.5 };
        assert!(mean > 0.01 && share < least, "{engine:?}: {mean}, off by {share} of it");
    }
}

/// Texture dies out with distance, without a line where it ends (Bunker and Ferris 1977, §3).
#[test]
fn contrast_of_detail_falls_with_distance_in_both_engines() {
    // A camera that looks straight down at level ground, from higher and higher.
    let colour = |at: DVec2| {
        let mixed = (at.x * 12.9898 + at.y * 78.233).sin() * 43_758.547;
        [100 + (40.0 * (mixed - mixed.floor())) as u8; 3]
    };
    let ground = Terrain::new([600, 600], 2.0, |_| 100.0, colour).in_memory();
    for engine in [Engine::Planes, Engine::Reference] {
        let contrast = |height: f64| {
            let eye = DVec3::new(600.0, 600.0, 100.0 + height);
            let view = View { eye, ypr: [0.0, -90.0, 0.0], hfov: 40.0, size: [160, 120] };
            let [on, off] = [1.0, 0.0].map(|detail_synthesis| {
                see(&ground, &view, &RenderOptions { engine, detail_synthesis, ..clear_air() })
            });
            let change = |(on, off): (&[f32; 3], &[f32; 3])| f64::from(on[1] / off[1] - 1.0).powi(2);
            let squares: f64 = on.colour.iter().zip(&off.colour).map(change).sum();
            (squares / on.colour.len() as f64).sqrt()
        };

        // Pixels of 1/16 to 1.5 voxels: in steps of a fifth none changes contrast by more than a fifth of the nearest.
        let heights: Vec<f64> = (0..18).map(|step| 30.0 * 1.2_f64.powi(step)).collect();
        let contrasts: Vec<f64> = heights.into_iter().map(contrast).collect();
        let falls = contrasts.windows(2).all(|pair| pair[1] < pair[0] + 0.02 * contrasts[0]);
        let steps = contrasts.windows(2).map(|pair| (pair[0] - pair[1]).abs()).fold(0.0, f64::max);
        assert!(falls && steps < 0.2 * contrasts[0], "{engine:?}: {contrasts:?}");
        assert!(contrasts[17] < 0.02 * contrasts[0] && contrasts[0] > 0.05, "{engine:?}: {contrasts:?}");
    }
}

/// Standard deviation of green and mean difference of both engines, codes, of a western and an eastern half.
fn halves(frames: &[Frame; 2]) -> [[f64; 2]; 2] {
    let codes = frames.each_ref().map(|frame| srgb8_picture(&frame.colour));
    [0, 1].map(|half| {
        let pixels: Vec<[f64; 2]> = (0..160 * 120)
            .filter(|pixel| pixel % 160 / 80 == half)
            .map(|pixel| [0, 1].map(|frame: usize| f64::from(codes[frame][3 * pixel + 1])))
            .collect();
        let count = pixels.len() as f64;
        let mean = pixels.iter().map(|pixel| pixel[0]).sum::<f64>() / count;
        let squares: f64 = pixels.iter().map(|pixel| (pixel[0] - mean).powi(2)).sum();
        let apart: f64 = pixels.iter().map(|pixel| (pixel[0] - pixel[1]).abs()).sum();
        [(squares / count).sqrt(), apart / count]
    })
}

#[test]
fn grounds_show_the_pattern_of_their_roughness_in_both_engines() {
    // Calm posts in the west, rough ones in the east, straight from above.
    let colour = |at: DVec2| {
        let mixed = (at.x * 12.9898 + at.y * 78.233).sin() * 43_758.547;
        let span = if at.x < 600.0 { 6.0 } else { 40.0 };
        [100 + (span * (mixed - mixed.floor())) as u8; 3]
    };
    let terrain = Terrain::new([600, 600], 2.0, |_| 100.0, colour);
    let pattern = |seed: u64, factor: f64| {
        let cells = Generator::Broad { octaves: 4 }.cells(seed).unwrap();
        let unit = factor / cells.deviation();
        cells.joined(&cells, |value, _| unit * value)
    };
    let seen = |factors: [f64; 2]| {
        let classes = vec![
            RoughnessClass::new(0.0, &pattern(1, factors[0])),
            RoughnessClass::new(0.3, &pattern(2, factors[1])),
        ];
        let matched = Some(MatchedPattern::new(classes).unwrap());
        let detail = Some(DetailRecord { matched, relief: 0.0, ..DetailRecord::default() });
        let ground = terrain.described(&Metadata { detail, ..Metadata::default() });
        let eye = DVec3::new(600.0, 600.0, 130.0);
        let view = View { eye, ypr: [0.0, -90.0, 0.0], hfov: 40.0, size: [160, 120] };
        let frame = |engine| see(&ground, &view, &RenderOptions { engine, ..clear_air() });
        halves(&[Engine::Planes, Engine::Reference].map(frame))
    };

    let (calm_west, calm_east) = (seen([0.02, 1.0]), seen([1.0, 0.02]));
    for halves in [calm_west, calm_east] {
        assert!(halves.iter().all(|[_, apart]| *apart < 2.0), "{halves:?}");
    }
    // The other class is hardly changed.
    assert!(calm_east[0][0] > 1.15 * calm_west[0][0], "{calm_east:?} {calm_west:?}");
    assert!(calm_west[1][0] > 1.3 * calm_east[1][0], "{calm_east:?} {calm_west:?}");
}

#[test]
fn snow_hides_what_lies_below() {
    let ground = hills(2.0, true);
    let change = |engine, snow| {
        let weather = Weather { ground: GroundCover { wet: 0.0, snow }, ..Weather::default() };
        let [on, off] = [1.0, 0.0].map(|detail_synthesis| {
            see(&ground, &VIEW, &RenderOptions { engine, detail_synthesis, weather, ..clear_air() })
        });
        let light = |frame: &Frame| frame.colour.iter().map(|colour| f64::from(colour[1])).sum::<f64>();
        let pairs = on.colour.iter().zip(&off.colour);
        pairs.map(|(on, off)| f64::from((on[1] - off[1]).abs())).sum::<f64>() / light(&off)
    };
    let [bare, reference, planes] =
        [change(Engine::Planes, 0.0), change(Engine::Reference, 0.9), change(Engine::Planes, 0.9)];
    assert!(planes < 0.1 * bare && (planes / reference - 1.0).abs() < 0.25, "{bare} {reference} {planes}");
}

/// Mean difference of two pictures, sRGB codes.
fn mean_difference(one: &Frame, other: &Frame) -> f64 {
    let code = |light: f32| f64::from(hedgehop_base::colour::srgb8_from_linear(light));
    let pairs = one.colour.iter().zip(&other.colour);
    let sum: f64 = pairs.map(|(one, other)| (code(one[1]) - code(other[1])).abs()).sum();
    sum / one.colour.len() as f64
}

#[test]
fn a_level_coarser_changes_shading_by_less_than_two_codes() {
    let ground = hills(2.0, false);
    // All of the picture at once, where a flight changes a band at a time.
    let differences = [Surface::Smooth, Surface::Blocks].map(|surface| {
        let options =
            |detail: f64| RenderOptions { engine: Engine::Reference, surface, detail, ..clear_air() };
        let [fine, coarse] = [1.0, 0.25].map(|detail| see(&ground, &HIGH, &options(detail)));
        let changed = fine.colour.iter().zip(&coarse.colour).filter(|(fine, coarse)| fine != coarse).count();
        assert!(changed > fine.colour.len() / 3, "{surface:?}: {changed} pixels");
        mean_difference(&fine, &coarse)
    });

    // Normals by gradients of heights hide the change, which flat sides of blocks show.
    let [smooth, blocks] = differences;
    assert!(smooth < 2.0 && blocks > 4.0 * smooth, "smooth {smooth}, blocks {blocks} codes");
}
