//! Short ways to what a ray meets, against the plain ones.

use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::scenes::{DENSE, SIDE, SPACING, village, wood};
use hedgehop::earth::Curvature;
use hedgehop::raymarch::{
    Contact, GridRay, GroundLanes, LevelBands, Marcher, MetGround, RayLanes, SectorHorizons, SolidHit,
    Surface, SurfaceFilter,
};
use hedgehop::render::{RenderOptions, level_bands};
use hedgehop::simd::{Isa, LANES};
use hedgehop::space::{Attitude, Camera, Pose, Screen};
use hedgehop::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};

/// A village, a wood, and bare hills with a steep side and a hole.
static PLACES: LazyLock<[MemPages; 3]> = LazyLock::new(|| {
    let hills = |index: u32| {
        let [x, y] = [index % SIDE, index / SIDE].map(f64::from);
        let cliff = if x > 200.0 { 12.0 } else { 0.0 };
        if (x - 90.0).hypot(y - 220.0) < 6.0 {
            f64::NAN
        } else {
            6.0 * (x / 17.0).sin() * (y / 23.0).cos() + 2.0 * (x / 3.1 + y / 4.3).sin() + cliff
        }
    };
    let heights: Vec<f64> = (0..SIDE * SIDE).map(hills).collect();
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: SPACING, origin: DVec2::new(1000.0, 2000.0) };
    let bare =
        build_in_memory(grid, &heights, &vec![[80, 120, 60]; heights.len()], None, &Metadata::default());
    [village(false), wood(DENSE), bare.unwrap()]
});

/// View from somewhere about a place: metres from the middle of its sides, and above the datum.
fn view((x, y, z): (f64, f64, f64), [yaw, pitch, roll]: [f64; 3], screen: Screen) -> Camera {
    let middle = DVec2::new(1000.0, 2000.0) + 0.5 * f64::from(SIDE) * SPACING;
    let eye = (middle + DVec2::new(x, y)).extend(z);
    Camera::with_screen(Pose { eye, attitude: Attitude { yaw, pitch, roll }, hfov: 60.0 }, screen, 160, 96)
}

/// Directions, from level to straight down.
fn attitudes() -> impl Strategy<Value = [f64; 3]> {
    let pitch = prop_oneof![-12.0..4.0_f64, -90.0..30.0_f64, Just(-90.0)];
    (prop_oneof![0.0..360.0_f64, Just(90.0), Just(0.0)], pitch, prop_oneof![Just(0.0), -180.0..180.0_f64])
        .prop_map(|(yaw, pitch, roll)| [yaw, pitch, roll])
}

fn screens() -> impl Strategy<Value = Screen> {
    prop_oneof![
        3 => Just(Screen::Planar { hfov: 60.0 }),
        1 => Just(Screen::Fisheye { fov: 180.0 }),
        1 => Just(Screen::Equirectangular { hfov: 360.0, vfov: 180.0 }),
    ]
}

fn curvature(is_curved: bool) -> Curvature {
    if is_curved { Curvature { inverse_diameter: 1.0e-5 } } else { Curvature::FLAT }
}

/// Whether two values are the same but for rounding.
fn is_near(one: f64, other: f64) -> bool {
    one == other || (one - other).abs() <= 1e-9 * (1.0 + one.abs())
}

/// Whether two rays met the same ground.
fn is_same_contact(one: Option<Contact>, other: Option<Contact>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => {
            is_near(one.range, other.range)
                && (one.level, one.wanted, one.bare, one.face)
                    == (other.level, other.wanted, other.bare, other.face)
        }
        (one, other) => one.is_none() && other.is_none(),
    }
}

/// Rays of sixteen pixels, where each of them meets the ground, and about there what is asked of sixteen at a time.
struct PixelRays {
    sixteen: RayLanes,
    rays: Vec<GridRay>,
    contacts: Vec<Option<Contact>>,
}

impl PixelRays {
    /// Follows rays of pixels from one on to the right; asks for what is so many `pixels` behind where they meet the ground.
    fn new(marcher: &mut Marcher<'_>, camera: &Camera, [column, row]: [u32; 2], pixels: f64) -> Self {
        let (mut sixteen, mut rays, mut contacts) = (RayLanes::default(), Vec::new(), Vec::new());
        for lane in 0..LANES {
            let ray = camera.ray(f64::from(column) + lane as f64 + 0.5, f64::from(row) + 0.5).unwrap();
            let ray = marcher.ray(ray.origin, ray.direction);
            let contact = marcher.first_contact(&ray, 0.0).unwrap();
            if let Some(contact) = contact {
                sixteen.lanes |= 1 << lane;
                let near = contact.range + pixels * camera.pixel_angle() * contact.range;
                sixteen.range.0[lane] = near as f32;
                (0..3).for_each(|axis| sixteen.slope[axis].0[lane] = ray.slope[axis] as f32);
            }
            rays.push(ray);
            contacts.push(contact);
        }
        Self { sixteen, rays, contacts }
    }
}

/// Whether two rays met the same that stands.
fn are_same_hits(one: &[SolidHit], other: &[SolidHit]) -> bool {
    let is_same = |(one, other): (&SolidHit, &SolidHit)| {
        is_near(one.range, other.range)
            && is_near(one.end, other.end)
            && is_near(one.opacity, other.opacity)
            && (one.face, one.normal, one.span) == (other.face, other.normal, other.span)
    };
    one.len() == other.len() && one.iter().zip(other).all(is_same)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn rays_that_begin_beyond_horizons_meet_the_same(
        place in 0..3_usize,
        eye in (-500.0..500.0_f64, -500.0..500.0_f64, 0.5..120.0_f64),
        attitude in attitudes(), screen in screens(), is_curved: bool,
        detail in prop_oneof![Just(1.0), Just(20.0), Just(0.1)],
        pixels in prop::collection::vec((0.0..160.0_f64, 0.0..96.0_f64), 60),
        until in 1.0..400.0_f64,
    ) {
        let pages = &PLACES[place];
        let camera = view(eye, attitude, screen);
        let options = RenderOptions { detail, ..RenderOptions::of(pages.header()) };
        let bands = level_bands(pages.header(), &camera, &options);
        let curvature = curvature(is_curved);
        let horizons = SectorHorizons::new(pages.header().grid, bands.clone(), curvature, &camera);
        let mut plain = Marcher::new(pages, bands, options.surface).curved(curvature);
        let mut short = Marcher::new(pages, level_bands(pages.header(), &camera, &options), options.surface)
            .curved(curvature)
            .beyond(horizons.as_ref());

        let (mut hits, mut expected) = (Vec::new(), Vec::new());
        for (column, row) in pixels {
            let Some(ray) = camera.ray(column, row) else { continue };
            let ray = plain.ray(ray.origin, ray.direction);
            let contact = plain.first_contact(&ray, 0.0).unwrap();
            let own = short.first_contact(&ray, 0.0).unwrap();
            prop_assert!(is_same_contact(own, contact), "{own:?} for {contact:?}");
            let before = plain.contact_before(&ray, until).unwrap();
            let own = short.contact_before(&ray, until).unwrap();
            prop_assert!(is_same_contact(own, before), "{own:?} for {before:?} before {until} m");

            for contact in [contact, None] {
                let left = plain.solids(&ray, contact.as_ref(), &mut expected).unwrap();
                let own = short.solids(&ray, contact.as_ref(), &mut hits).unwrap();
                prop_assert!(is_near(own, left) && are_same_hits(&hits, &expected), "{hits:?} for {expected:?}");
                let until = contact.map_or(f64::INFINITY, |contact| contact.range);
                let half = plain.half_hidden(&ray, until, &mut expected).unwrap();
                let own = short.half_hidden(&ray, until, &mut hits).unwrap();
                prop_assert_eq!(own.is_some(), half.is_some());
                prop_assert!(are_same_hits(&hits, &expected), "{hits:?} for {expected:?}");
            }
            if let Some(first) = expected.first() {
                prop_assert!(!short.is_free_of_standing(&ray, first.end).unwrap());
            }
        }
    }

    /// Where rays meet the ground, a pixel before or behind it; what sixteen rays leave is for one to find.
    #[test]
    fn sixteen_rays_meet_the_ground_as_each_of_them_does(
        place in 0..3_usize,
        eye in (-300.0..300.0_f64, -300.0..300.0_f64, 25.0..150.0_f64),
        attitude in attitudes(), is_curved: bool,
        detail in prop_oneof![Just(1.0), Just(20.0), Just(0.2)],
        rows in prop::collection::vec((0..10_u32, 0..96_u32, -0.4..0.4_f64), 12),
    ) {
        let pages = &PLACES[place];
        let camera = view(eye, attitude, Screen::Planar { hfov: 60.0 });
        let options = RenderOptions { detail, ..RenderOptions::of(pages.header()) };
        let bands: LevelBands = level_bands(pages.header(), &camera, &options);
        let curvature = curvature(is_curved);
        let mut marcher = Marcher::new(pages, bands.clone(), Surface::Smooth).curved(curvature);
        let mut filter = SurfaceFilter::new(pages, camera.footprint());
        let eye = marcher.ray(camera.pose.eye, DVec3::Z).eye;

        for (part, row, pixels) in rows {
            let PixelRays { sixteen, rays, contacts } =
                PixelRays::new(&mut marcher, &camera, [16 * part, row], pixels);

            for isa in Isa::available() {
                let mut ground = GroundLanes::new(pages, bands.clone(), curvature, eye, camera.pixel_angle());
                let mut met = MetGround::default();
                ground.meet(isa, &sixteen, &mut met).unwrap();
                prop_assert_eq!(met.lanes & !sixteen.lanes, 0);

                for lane in (0..LANES).filter(|lane| met.lanes >> lane & 1 != 0) {
                    let (ray, contact) = (&rays[lane], contacts[lane].unwrap());
                    let range = f64::from(met.range.0[lane]);
                    // A ray may meet a fold of the ground beside the first one: there it is on the surface, too.
                    let own = Contact { range, level: met.level[lane] as u8, ..contact };
                    let above = filter.clearance(ray, &own).unwrap().unwrap();
                    prop_assert!(above.abs() < 4.0e-4 + 4.0e-5 * range, "{isa}: {above} m above at {range} m");
                    prop_assert!((range - contact.range).abs() < 0.1 * contact.range + 1.0);
                    let (normal, attributes) = filter.surface(ray, &own).unwrap();
                    let lanes = met.normal.map(|part| part.0[lane]);
                    let off = normal.to_array().iter().zip(lanes).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    prop_assert!(off < 2.0e-3, "{isa}: {normal} for {lanes:?}");
                    prop_assert_eq!(attributes, met.attributes[lane]);
                }
            }
        }
    }
}

#[test]
fn few_rays_are_left_to_be_followed_one_by_one() {
    for (place, pages) in PLACES.iter().enumerate() {
        let (mut asked, mut found) = (0, 0);
        for (yaw, pitch) in [(0.0, -10.0), (100.0, -25.0), (200.0, -50.0), (300.0, -90.0)] {
            let camera = view((0.0, 0.0, 80.0), [yaw, pitch, 0.0], Screen::Planar { hfov: 60.0 });
            let options = RenderOptions::of(pages.header());
            let bands = level_bands(pages.header(), &camera, &options);
            let mut marcher = Marcher::new(pages, bands.clone(), Surface::Smooth);
            let eye = marcher.ray(camera.pose.eye, DVec3::Z).eye;
            let mut ground = GroundLanes::new(pages, bands, Curvature::FLAT, eye, camera.pixel_angle());

            for (part, row) in (0..96).flat_map(|row| (0..10).map(move |part| (part, row))) {
                let sixteen = PixelRays::new(&mut marcher, &camera, [16 * part, row], 0.1).sixteen;
                let mut met = MetGround::default();
                ground.meet(Isa::best(), &sixteen, &mut met).unwrap();
                asked += sixteen.lanes.count_ones();
                found += met.lanes.count_ones();
            }
        }
        assert!(found * 10 >= 9 * asked, "place {place}: {found} of {asked}");
    }
}
