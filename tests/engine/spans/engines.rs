//! What stands on the ground, by scan planes and by the reference.

use glam::{DVec2, DVec3, Vec3};

use super::scenes::{
    CODE, DENSE, SPACING, pillar, pyramid, short_ridge, standing, standing_on, village, wood,
};
use hedgehop::Result;
use hedgehop::earth::Curvature;
use hedgehop::frame::Frame;
use hedgehop::raymarch::Marcher;
use hedgehop::render::{Overlays, RenderOptions, Renderer, level_bands, render_reference};
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::voxel::{
    Attributes, BoundsView, Header, MemPages, PageId, PageSource, PageView, Span, SpansView,
};

fn camera(east: f64, north: f64, up: f64, attitude: [f64; 3]) -> Camera {
    camera_of(east, north, up, attitude, 60.0)
}

fn camera_of(east: f64, north: f64, up: f64, [yaw, pitch, roll]: [f64; 3], hfov: f64) -> Camera {
    let eye = DVec3::new(1000.0 + east * SPACING, 2000.0 + north * SPACING, up);
    let attitude = Attitude { yaw, pitch, roll };
    Camera::new(Pose { eye, attitude, hfov }, 320, 180)
}

/// Ranges of a pixel and of those about it.
fn nine(frame: &Frame, index: usize) -> impl Iterator<Item = f32> {
    let (width, height) = (frame.camera.width as i64, frame.camera.height as i64);
    let (x, y) = (index as i64 % width, index as i64 / width);
    let about = (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
    about
        .filter(move |(x, y)| (0..width).contains(x) && (0..height).contains(y))
        .map(move |(x, y)| frame.range[(y * width + x) as usize])
}

/// Share of the pixels of which the range is more than a hundredth from that of all nine about it of the other frame, and mean difference of colours
/// where it is not from its own.
fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    let near = |one: f32, other: f32| one == other || (one - other).abs() <= 0.01 * one.min(other);
    let (mut off, mut sum, mut same) = (0, 0.0, 0);
    for (index, &one) in a.range.iter().enumerate() {
        off += u32::from(!nine(b, index).any(|other| near(one, other)));
        if near(one, b.range[index]) {
            same += 1;
            let [one, other] = [a, b].map(|frame| Vec3::from_array(frame.colour[index]));
            sum += f64::from((one - other).abs().max_element());
        }
    }
    (f64::from(off) / a.range.len() as f64, sum / f64::from(same.max(1)))
}

#[test]
fn planes_see_what_stands_as_the_reference_does() {
    let pages = village(false);
    let farm = Farm::new(2).unwrap();
    let options = RenderOptions { curvature: Curvature::standard(), ..RenderOptions::of(pages.header()) };
    for (index, camera) in [
        camera(150.0, 100.0, 12.0, [0.0, 0.0, 0.0]),
        camera(100.0, 155.0, 25.0, [80.0, -8.0, 0.0]),
        camera(200.0, 210.0, 40.0, [225.0, -20.0, 12.0]),
        camera(110.0, 160.0, 3.0, [60.0, 2.0, -5.0]),
        camera(150.0, 150.0, 90.0, [30.0, -60.0, 0.0]),
        // Bare ground ends some 40 voxels away.
        camera_of(150.0, 120.0, 8.0, [20.0, 0.0, 0.0], 125.0),
        camera_of(185.0, 160.0, 6.0, [250.0, 3.0, 0.0], 140.0),
    ]
    .into_iter()
    .enumerate()
    {
        let fast = Renderer::new(&pages, &options).frame(&camera, &farm).unwrap().frame;
        let exact = render_reference(&pages, &camera, &options, &farm).unwrap().frame;
        let (off, mean) = difference(&fast, &exact);
        assert!(off < 0.015 && mean < 0.005, "{index}: {off} of the pixels, {mean}");
    }
}

/// The upper disc of a tower comes into sight where the eye passes its plane, and has a colour of its own (Bunker and Ferris 1977, §2.5).
#[test]
fn a_tower_shows_its_top_from_above_its_plane_alone() {
    const HIGH: f64 = 20.0;
    let tower = |x: u32, y: u32| {
        let out = DVec2::new(f64::from(x) - 160.0, f64::from(y) - 160.0).length();
        if out < 8.0 { vec![pillar(HIGH)] } else { Vec::new() }
    };
    let pages = standing(tower);
    let farm = Farm::new(2).unwrap();
    let options = RenderOptions::of(pages.header());

    // Pixels of the top's red and of the sides' cream.
    let seen = |frame: &Frame| {
        let is_red = |light: &&[f32; 3]| light[0] > 2.5 * light[1] && light[0] > 0.1;
        let is_cream = |light: &&[f32; 3]| light[0] > 1.05 * light[1] && light[0] < 1.6 * light[1];
        (frame.colour.iter().filter(is_red).count(), frame.colour.iter().filter(is_cream).count())
    };
    for above in [-2.0, -0.05, 0.2, 2.0] {
        let camera = camera(160.0, 120.0, HIGH + above, [0.0, 0.0, 0.0]);
        let fast = Renderer::new(&pages, &options).frame(&camera, &farm).unwrap().frame;
        let exact = render_reference(&pages, &camera, &options, &farm).unwrap().frame;
        for (engine, (top, side)) in [("planes", seen(&fast)), ("reference", seen(&exact))] {
            assert!(side > 500, "{engine}, {above} m: {side} pixels of the side");
            // Two metres above, the disc is eight rows high.
            assert_eq!(top > 0, above > 1.0, "{engine}, {above} m above: {top} pixels of the top");
        }
    }
}

/// Views in which a voxel is a fraction of a pixel: what stands is seen in cells of 2 × 2 and 4 × 4.
#[test]
fn planes_see_cells_of_what_stands_as_the_reference_does() {
    let farm = Farm::new(2).unwrap();
    for (place, pages) in [village(false), village(true), wood(DENSE)].iter().enumerate() {
        for (index, (camera, detail)) in [
            (camera(150.0, 60.0, 40.0, [0.0, -10.0, 0.0]), 0.12),
            (camera(60.0, 155.0, 25.0, [80.0, -8.0, 0.0]), 0.2),
            (camera(240.0, 250.0, 60.0, [225.0, -20.0, 12.0]), 0.3),
            (camera(150.0, 150.0, 120.0, [30.0, -60.0, 0.0]), 0.3),
        ]
        .into_iter()
        .enumerate()
        {
            let options = RenderOptions { detail, far_spans: 0.25, ..RenderOptions::of(pages.header()) };
            let bands = level_bands(pages.header(), &camera, &options);
            assert!(bands.span_bands().iter().any(|band| band.shift > 0 && band.start < 200.0), "{bands:?}");
            let fast = Renderer::new(pages, &options).frame(&camera, &farm).unwrap().frame;
            let exact = render_reference(pages, &camera, &options, &farm).unwrap().frame;
            let (off, mean) = difference(&fast, &exact);
            // The reference has one ray for all that a pixel shows of them.
            assert!(off < 0.03 && mean < 0.02, "{place}, {index}: {off} of the pixels, {mean}");
        }
    }
}

/// A database of which a page is damaged and left out.
struct Lacking<'p>(&'p MemPages, PageId);

impl PageSource for Lacking<'_> {
    fn header(&self) -> &Header {
        self.0.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        if id == self.1 { Ok(None) } else { self.0.page(id) }
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        if id == self.1 { Ok(None) } else { self.0.bounds(id) }
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        if id == self.1 { Ok(None) } else { self.0.spans(id) }
    }

    fn is_damaged(&self, id: PageId) -> bool {
        id == self.1
    }
}

#[test]
fn pixels_of_damaged_bare_ground_are_marked_and_no_others() {
    let pages = village(false);
    let farm = Farm::new(2).unwrap();
    let camera = camera(170.0, 190.0, 30.0, [0.0, -90.0, 0.0]);
    let options = RenderOptions::of(pages.header());
    let surface = PageId { level: 0, px: 0, py: 0 };
    for (damaged, share) in [(surface.bare(), 1.0), (surface, 0.0)] {
        let lacking = Lacking(&pages, damaged);
        let planes = Renderer::new(&lacking, &options).frame(&camera, &farm).unwrap().frame;
        let exact = render_reference(&lacking, &camera, &options, &farm).unwrap().frame;
        for frame in [planes, exact] {
            let marked = frame.id.iter().filter(|id| **id as u8 & Attributes::STAND_IN != 0).count();
            assert_eq!(marked as f64, share * frame.id.len() as f64, "{damaged:?}");
        }
    }
}

/// A road that rises northward between parapets: walls on decks, of which the planes in between go on above or below the eye.
#[test]
fn parapets_of_rising_decks_hide_their_roads() {
    let (grey, asphalt) = ([220, 220, 210], [10, 10, 12]);
    let pages = standing(|x, y| {
        if !(140..156).contains(&x) || !(120..200).contains(&y) {
            return Vec::new();
        }

        let high = 8.0 + 0.25 * SPACING * (f64::from(y) - 160.0);
        let sloping = |low: f64, high: f64| Span {
            low: CODE.encode(low),
            slope: [0, 8],
            state: Span::OPAQUE | Span::PARALLEL,
            top: grey,
            side: grey,
            ..pillar(high)
        };

        let deck = Span { top: asphalt, ..sloping(high - 1.0, high) };
        match x {
            140 | 155 => vec![deck, sloping(high, high + 1.5)],
            _ => vec![deck],
        }
    });

    let farm = Farm::new(2).unwrap();
    let options = RenderOptions { curvature: Curvature::FLAT, ..RenderOptions::of(pages.header()) };
    for height in [7.0, 9.3, 11.0, 14.0] {
        let camera = camera_of(120.0, 140.0, height, [50.0, 2.0, 0.0], 50.0);
        let fast = Renderer::new(&pages, &options).frame(&camera, &farm).unwrap().frame;
        let exact = render_reference(&pages, &camera, &options, &farm).unwrap().frame;
        let light = |frame: &Frame, index: usize| f64::from(frame.colour[index][1]);

        // Where a face fills a pixel and those about it.
        let is_inner = |at: &usize| {
            let own = light(&exact, *at);
            let about = [at - 1, at + 1, at - 320, at + 320, at - 321, at - 319, at + 319, at + 321];
            own > 0.0 && about.iter().all(|beside| (light(&exact, *beside) - own).abs() < 0.01)
        };
        let inner: Vec<_> = (321..320 * 179 - 1).filter(is_inner).collect();
        let off = inner.iter().filter(|at| (light(&fast, **at) - light(&exact, **at)).abs() > 0.05).count();
        assert!(off * 1000 < inner.len(), "{height} m: {off} of {}", inner.len());
    }
}

#[test]
fn objects_are_seen_as_the_spans_that_they_have() {
    let farm = Farm::new(2).unwrap();
    let [own, placed] = [false, true].map(village);
    assert!(placed.header().objects.len() > 100);
    let options = RenderOptions { curvature: Curvature::standard(), ..RenderOptions::of(own.header()) };
    for camera in
        [camera(100.0, 155.0, 25.0, [80.0, -8.0, 0.0]), camera(110.0, 160.0, 3.0, [60.0, 2.0, -5.0])]
    {
        let fast =
            [&own, &placed].map(|pages| Renderer::new(pages, &options).frame(&camera, &farm).unwrap().frame);
        assert!(fast[0].colour == fast[1].colour && fast[0].range == fast[1].range);
        let exact =
            [&own, &placed].map(|pages| render_reference(pages, &camera, &options, &farm).unwrap().frame);
        assert!(exact[0].colour == exact[1].colour && exact[0].range == exact[1].range);
    }
}

/// Rays that are looked along within a pixel, along each side of it.
const RAYS: u32 = 8;

/// Relative difference of range that needs no second look.
const SAME: f64 = 1e-3;

/// What a ray through a place of the screen meets (pixels from its upper left corner): range of what hides half of the light, metres; infinite: the sky.
fn range_along(marcher: &mut Marcher<'_>, camera: &Camera, x: f64, y: f64) -> f64 {
    let ray = camera.ray(x, y).unwrap();
    let ray = marcher.ray(ray.origin, ray.direction);
    let ground = marcher.first_contact(&ray, 0.0).unwrap();
    let ground = ground.map_or(f64::INFINITY, |ground| ground.range);
    let standing = marcher.half_hidden(&ray, ground, &mut Vec::new()).unwrap();
    standing.map_or(ground, |hit| hit.range)
}

/// The reference's marcher of a view.
fn marcher<'a>(pages: &'a MemPages, camera: &Camera, options: &RenderOptions) -> Marcher<'a> {
    let bands = level_bands(pages.header(), camera, options);
    Marcher::new(pages, bands, options.surface).curved(options.curvature)
}

/// Differences of the engine from the reference over several views: relative ones of range, by the ray nearest to what was found of all through a pixel,
/// and by the pixel's own; share of pixels where one sees sky, and mean difference of light.
#[derive(Default)]
struct Differences {
    within: Vec<f64>,
    own: Vec<f64>,
    sky: f64,
    light: f64,
}

impl Differences {
    /// Renders frames by both engines at level 1, where spans are seen, and compares them: those of light and range alone, and those that describe
    /// surfaces.
    fn of(pages: &MemPages, cameras: &[Camera]) -> [Self; 2] {
        let farm = Farm::new(2).unwrap();
        let options = RenderOptions {
            curvature: Curvature::standard(),
            detail: 50.0,
            ..RenderOptions::of(pages.header())
        };
        let mut all = [Self::default(), Self::default()];
        let pixels: usize = cameras.iter().map(|camera| (camera.width * camera.height) as usize).sum();

        for camera in cameras {
            let exact = render_reference(pages, camera, &options, &farm).unwrap().frame;
            let mut marcher = marcher(pages, camera, &options);
            for (all, describes) in all.iter_mut().zip([false, true]) {
                let renderer = Renderer::new(pages, &options);
                let fast = renderer.seen_with(camera, Overlays::default(), describes, &farm).unwrap().frame;
                all.add([&fast, &exact], &mut marcher, pixels);
            }
        }

        all
    }

    /// Counts a view of both engines, one of views of so many pixels in all.
    fn add(&mut self, [fast, exact]: [&Frame; 2], marcher: &mut Marcher<'_>, pixels: usize) {
        for (index, (&found, &own)) in fast.range.iter().zip(&exact.range).enumerate() {
            let [one, other] = [fast, exact].map(|frame| Vec3::from_array(frame.colour[index]));
            self.light += f64::from((one - other).abs().element_sum()) / (3 * pixels) as f64;
            if found.is_infinite() || own.is_infinite() {
                self.sky += f64::from(u8::from(found != own)) / pixels as f64;
                continue;
            }

            let error = (f64::from(found) - f64::from(own)).abs() / f64::from(own);
            self.own.push(error);
            self.within.push(error.min(least_error(marcher, &fast.camera, index, (found, error))));
        }
    }

    /// Median, 99 % and 99.6 % of some of them.
    fn shares(errors: &mut [f64]) -> [f64; 3] {
        [0.5, 0.99, 0.996].map(|share| {
            let index = (errors.len() as f64 * share) as usize;
            *errors.select_nth_unstable_by(index, f64::total_cmp).1
        })
    }
}

/// Least relative difference of a range from those along rays through its pixel; `error`, that of its own ray, if that is small.
fn least_error(marcher: &mut Marcher<'_>, camera: &Camera, index: usize, (found, error): (f32, f64)) -> f64 {
    let corner = [index as u32 % camera.width, index as u32 / camera.width].map(f64::from);
    let mut least = error;
    for ray in 0..RAYS * RAYS {
        if least <= SAME {
            break;
        }
        let [x, y] = [ray % RAYS, ray / RAYS].map(|ray| (f64::from(ray) + 0.5) / f64::from(RAYS));
        let range = range_along(marcher, camera, corner[0] + x, corner[1] + y);
        least = least.min((f64::from(found) - range).abs() / range);
    }
    least
}

/// The bounds of the surface (`../frames.rs`): median, 99 % and 99.6 % of the relative differences of range, share of pixels where one sees sky, mean difference of
/// light.
///
/// Planes lie up to half a pixel from a pixel's own ray, and in a wood there is an outline in every second pixel: what counts of them is whether a ray through the
/// pixel meets what was found. In the village the pixels' own rays do, and in level views of a wood. In frames that describe surfaces they do everywhere.
#[test]
#[expect(clippy::print_stdout, reason = "the figures are what documents say")]
fn planes_see_what_stands_within_the_bounds_of_the_surface() {
    let of_village = [
        camera(150.0, 100.0, 12.0, [0.0, 0.0, 0.0]),
        camera(100.0, 155.0, 25.0, [80.0, -8.0, 0.0]),
        camera(200.0, 210.0, 40.0, [225.0, -20.0, 0.0]),
        camera(110.0, 160.0, 3.0, [60.0, 2.0, 0.0]),
        camera(150.0, 150.0, 90.0, [30.0, -60.0, 0.0]),
    ];

    let of_pyramid = [
        camera(150.0, 145.0, 21.0, [35.0, -5.0, 0.0]),
        camera(160.0, 158.0, 24.0, [0.0, -50.0, 0.0]),
        camera(163.0, 161.0, 21.0, [270.0, -20.0, 0.0]),
    ];
    // Level roofs and pitched ones that go on into a hillside, and come out of it where it falls again.
    let hill = |_: u32, y: u32| (12.0 - 0.35 * SPACING * (f64::from(y) - 150.0).abs()).max(0.0);

    let buried = standing_on(hill, false, |x, y| {
        let is_house = |from: u32| (from..from + 12).contains(&x) && (125..175).contains(&y);
        match (is_house(140), is_house(160)) {
            (true, _) => vec![pillar(8.0)],
            (_, true) => {
                vec![Span { slope: [0, -8], ..pillar(9.0 - 0.25 * SPACING * (f64::from(y) - 150.0)) }]
            }
            _ => Vec::new(),
        }
    });

    let of_hill = [
        camera(150.0, 95.0, 16.0, [5.0, -8.0, 0.0]),
        camera(156.0, 200.0, 20.0, [183.0, -12.0, 0.0]),
        camera(190.0, 150.0, 30.0, [270.0, -30.0, 0.0]),
        camera(156.0, 140.0, 40.0, [0.0, -70.0, 0.0]),
    ];
    let of_wood = [
        camera(150.0, 100.0, 30.0, [20.0, -10.0, 0.0]),
        camera(100.0, 155.0, 60.0, [80.0, -25.0, 0.0]),
        camera(203.0, 210.0, 2.5, [225.0, 0.0, 0.0]),
    ];

    // Level: planes and rows are those of pixels, and there is nothing between them.
    let of_level_wood = [
        camera(150.0, 100.0, 14.0, [20.0, 0.0, 0.0]),
        camera(100.0, 155.0, 25.0, [80.0, 0.0, 0.0]),
        camera(203.0, 210.0, 2.5, [225.0, 0.0, 0.0]),
    ];

    // Straight down on a roof, a deck and a crown, and up from below these.
    let of_poles = [
        camera(150.3, 140.4, 40.0, [0.0, -90.0, 0.0]),
        camera(120.6, 150.2, 20.0, [10.0, -89.0, 0.0]),
        camera(165.2, 185.3, 60.0, [70.0, -84.0, 0.0]),
        camera(120.0, 160.0, 30.0, [0.0, -75.0, 0.0]),
        camera(120.6, 150.2, 1.6, [0.0, 88.0, 0.0]),
        camera(131.4, 141.1, 1.6, [0.0, 90.0, 0.0]),
    ];

    for (name, pages, cameras, own_too) in [
        ("village from above and below", village(false), &of_poles[..], true),
        ("village", village(false), &of_village[..], true),
        ("pyramid", standing(pyramid), &of_pyramid[..], true),
        ("short ridge", standing(short_ridge), &of_pyramid[..], true),
        ("houses in a hillside", buried, &of_hill[..], true),
        ("wood", wood(Span::OPAQUE), &of_wood[..], false),
        ("wood that light comes through", wood(DENSE), &of_wood[..], false),
        ("level wood", wood(Span::OPAQUE), &of_level_wood[..], true),
        ("level wood that light comes through", wood(DENSE), &of_level_wood[..], true),
    ] {
        let is_met = |shares: [f64; 3]| shares[0] <= 1.5e-4 && shares[1] <= 3e-3 && shares[2] <= 1e-2;
        for (mut found, describes) in Differences::of(&pages, cameras).into_iter().zip([false, true]) {
            let [within, own] = [&mut found.within, &mut found.own].map(|errors| Differences::shares(errors));
            let name = if describes { format!("{name}, described") } else { name.to_owned() };
            println!(
                "{name}: {within:?}, own rays {own:?}, sky {:.1e}, light {:.1e}",
                found.sky, found.light
            );
            assert!(is_met(within), "{name}: {within:?}");
            assert!(!(own_too || describes) || is_met(own), "{name}, own rays: {own:?}");
            assert!(found.sky <= 1e-3 && found.light <= 0.01, "{name}: {} {}", found.sky, found.light);
        }
    }
}
