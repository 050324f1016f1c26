//! Worlds that golden pictures show: mountains, a village of spans, an airfield, a corridor with voids.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use glam::DVec2;
use hedgehop::Result;
use hedgehop::voxel::{
    Arrays, BoundsView, Cut, Facade, Grid, Header, HeightCode, HeightsView, MemPages, Metadata, PageId,
    PageSource, PageView, SharedObjects, Span, SpanArrays, SpansView, build_standing,
};

use super::noise::{chance, crests, fractal, noise, smooth};
use crate::scene::{ORIGIN, Terrain};

/// A database in memory of which pages may be absent.
pub struct GoldenWorld {
    /// All pages.
    pages: MemPages,
    /// Whether a page is absent, so that a coarser level stands in.
    is_absent: fn(PageId) -> bool,
}

impl GoldenWorld {
    fn whole(pages: MemPages) -> Self {
        Self { pages, is_absent: |_| false }
    }
}

impl PageSource for GoldenWorld {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        if (self.is_absent)(id) { Ok(None) } else { self.pages.page(id) }
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        if (self.is_absent)(id) { Ok(None) } else { self.pages.heights(id) }
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        if (self.is_absent)(id) { Ok(None) } else { self.pages.bounds(id) }
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        self.pages.spans(id)
    }
}

/// Mixes two colours, sRGB codes.
fn mix(one: [f64; 3], other: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|channel| one[channel] + (other[channel] - one[channel]) * share)
}

fn codes(colour: [f64; 3]) -> [u8; 3] {
    colour.map(|code| code.round() as u8)
}

/// Level of the mountains' lake, metres.
const LAKE: f64 = 310.0;

/// Mountains on both sides of a valley that winds northward, 10 km each way, 310 to some 1500 m high.
pub static MOUNTAINS: LazyLock<GoldenWorld> = LazyLock::new(|| {
    GoldenWorld::whole(Terrain::new([512, 512], 20.0, mountain, mountain_colour).in_memory())
});

fn mountain(place: DVec2) -> f64 {
    let middle = 5100.0 + 1600.0 * (noise(DVec2::new(0.5, place.y / 2300.0), 31) - 0.5);
    let rise = smooth((place.x - middle).abs(), [250.0, 2600.0]);
    let bumps = fractal(place / 700.0, 4, 5);
    let height = LAKE - 28.0 + 60.0 * bumps + rise * (180.0 + 1150.0 * crests(place / 2600.0, 6, 11));
    height.max(LAKE)
}

fn mountain_colour(place: DVec2) -> [u8; 3] {
    let height = mountain(place);
    if height <= LAKE {
        return [46, 78, 98];
    }
    let rise = |step: DVec2| (mountain(place + step) - mountain(place - step)) / 40.0;
    let slope = DVec2::new(rise(DVec2::new(20.0, 0.0)), rise(DVec2::new(0.0, 20.0))).length();
    let patches = fractal(place / 420.0, 3, 21);
    let meadow = mix([104.0, 128.0, 62.0], [142.0, 136.0, 84.0], smooth(height, [350.0, 800.0]));
    let is_wood = smooth(patches, [0.5, 0.56]) * (1.0 - smooth(height, [640.0, 760.0]));
    let low = mix(meadow, [50.0, 74.0, 42.0], is_wood);
    let rock = mix([126.0, 116.0, 104.0], [98.0, 94.0, 92.0], noise(place / 90.0, 3));
    let ground = mix(low, rock, smooth(slope, [0.45, 0.75]).max(smooth(height, [850.0, 1050.0])));
    let snow = smooth(height + 300.0 * (patches - 0.5), [1000.0, 1080.0]) * (1.0 - smooth(slope, [0.8, 1.1]));
    codes(mix(ground, [236.0, 240.0, 246.0], snow))
}

/// The mountains' valley with voids, posts 10 m apart; west of the middle only levels from the second on are there.
pub static CORRIDOR: LazyLock<GoldenWorld> = LazyLock::new(|| {
    let corner = DVec2::new(2560.0, 0.0);
    let height = |place: DVec2| {
        let ragged = 2900.0 + 1300.0 * (noise(place / 350.0, 41) - 0.5);
        let is_torn = place.y > ragged && (place - DVec2::new(3050.0, 3500.0)).length() > 330.0;
        let is_tile = (2700.0..3200.0).contains(&place.x) && (1500.0..2000.0).contains(&place.y);
        if is_torn || is_tile { f64::NAN } else { mountain(place + corner) }
    };
    let terrain = Terrain::new([512, 512], 10.0, height, |place| mountain_colour(place + corner));
    GoldenWorld { pages: terrain.in_memory(), is_absent: |id| id.level == 0 && id.px == 0 }
});

/// Half the runway's width, metres.
pub const RUNWAY_HALF: f64 = 22.0;
/// Southern and northern end of the runway, metres north of the airfield's corner.
pub const RUNWAY_NORTH: [f64; 2] = [420.0, 1620.0];
/// Middle of the runway, metres east of the airfield's corner.
pub const RUNWAY_EAST: f64 = 1024.0;
/// Level of the airfield, metres.
pub const AIRFIELD: f64 = 30.0;

/// A runway, a taxiway and an apron among fields, 2 km each way, hills about it.
pub static AIRFIELD_WORLD: LazyLock<GoldenWorld> = LazyLock::new(|| {
    GoldenWorld::whole(Terrain::new([512, 512], 4.0, airfield, airfield_colour).in_memory())
});

fn airfield(place: DVec2) -> f64 {
    let beside = smooth((place.x - RUNWAY_EAST).abs(), [480.0, 980.0]);
    let beyond = smooth(place.y, [1700.0, 2000.0]);
    AIRFIELD + beside.max(beyond) * (20.0 + 130.0 * fractal(place / 420.0, 4, 51))
}

fn airfield_colour(place: DVec2) -> [u8; 3] {
    let from_middle = (place.x - RUNWAY_EAST).abs();
    let [south, north] = RUNWAY_NORTH;
    if from_middle < RUNWAY_HALF && (south..north).contains(&place.y) {
        let from_end = (place.y - south).min(north - place.y);
        let is_key = (8.0..40.0).contains(&from_end) && (place.x / 4.0) as i64 % 2 == 0;
        let is_line = from_end > 60.0 && from_middle < 2.5 && (place.y / 30.0) as i64 % 2 == 0;
        return if is_key || is_line { [228, 228, 222] } else { [74, 74, 78] };
    }
    let east = place.x - RUNWAY_EAST;
    let is_apron = (130.0..300.0).contains(&east) && (820.0..1120.0).contains(&place.y);
    let is_taxiway = (100.0..118.0).contains(&east) && (south..north).contains(&place.y)
        || (0.0..300.0).contains(&east) && (960.0..978.0).contains(&place.y);
    if is_apron || is_taxiway {
        return [122, 122, 120];
    }
    if from_middle < 330.0 {
        return codes(mix([92.0, 124.0, 62.0], [116.0, 136.0, 74.0], fractal(place / 60.0, 2, 61)));
    }
    field(place / 140.0)
}

/// Colour of a patchwork of fields of side 1.
fn field(at: DVec2) -> [u8; 3] {
    let cell = at.floor();
    let kinds = [[172, 158, 92], [98, 128, 58], [138, 112, 78], [120, 146, 70], [84, 108, 52]];
    kinds[(chance(cell.x as i64, cell.y as i64, 71) * 4.999) as usize]
}

/// Voxels along a side of the village.
const VILLAGE_SIDE: u32 = 512;
/// Side of a voxel of the village, metres.
const VOXEL: f64 = 2.0;
/// Height code of what stands in the village.
const CODE: HeightCode = HeightCode { scale: 2.0e-3, offset: -20.0 };
/// Row of voxels along which the village's river runs.
const RIVER: f64 = 292.0;
/// Half the river's width, voxels.
const RIVER_HALF: f64 = 6.0;

/// Houses with gabled roofs, trees, a bridge and a wire along a street that goes north, 1 km each way, in a hollow.
pub static VILLAGE: LazyLock<GoldenWorld> = LazyLock::new(|| {
    let grid = Grid { nx: VILLAGE_SIDE, ny: VILLAGE_SIDE, spacing: VOXEL, origin: ORIGIN };
    let voxels = || (0..VILLAGE_SIDE).flat_map(|y| (0..VILLAGE_SIDE).map(move |x| (x, y)));
    let middle = |(x, y): (u32, u32)| DVec2::new(f64::from(x), f64::from(y)) + 0.5;
    let houses = houses();
    let spans: BTreeMap<_, _> = voxels()
        .map(|voxel| (voxel, standing_at(middle(voxel), &houses)))
        .filter(|(_, spans)| !spans.is_empty())
        .collect();
    let ground: Vec<f64> = voxels().map(|voxel| village_ground(middle(voxel))).collect();
    let ground_colours: Vec<_> = voxels().map(|voxel| village_colour(middle(voxel))).collect();

    // The surface is the highest upper end.
    let (mut heights, mut colours) = (ground.clone(), ground_colours.clone());
    for (&(x, y), spans) in &spans {
        let at = (y * VILLAGE_SIDE + x) as usize;
        for span in spans {
            if let Some(top) = CODE.decode(span.high).filter(|top| *top > heights[at]) {
                (heights[at], colours[at]) = (top, span.top);
            }
        }
    }

    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    let standing = SpanArrays {
        heights: &ground,
        colours: &ground_colours,
        spans: &spans,
        objects: &SharedObjects::default(),
        placed: &[],
        code: CODE,
    };
    GoldenWorld::whole(build_standing(&arrays, &standing, &Metadata::default()).unwrap())
});

/// Column of the street at a row of voxels.
fn street(row: f64) -> f64 {
    256.0 + 14.0 * (noise(DVec2::new(0.5, row / 90.0), 81) - 0.5)
}

/// Height of the village's bare ground, metres, at a place in voxels.
fn village_ground(at: DVec2) -> f64 {
    let rim = ((at - 256.0).length() - 130.0).max(0.0) / 126.0;
    let bed = smooth((at.y - RIVER).abs(), [RIVER_HALF + 6.0, RIVER_HALF - 3.0]);
    let level = 4.0 + 5.0 * fractal(at / 60.0, 3, 83) * smooth((at.x - street(at.y)).abs(), [3.0, 30.0]);
    level + (30.0 * rim * rim).min(60.0) - 5.0 * bed
}

fn village_colour(at: DVec2) -> [u8; 3] {
    let from_street = (at.x - street(at.y)).abs();
    if (at.y - RIVER).abs() < RIVER_HALF {
        [58, 88, 96]
    } else if from_street < 2.0 {
        [128, 124, 118]
    } else if from_street < 22.0 {
        codes(mix([98.0, 128.0, 64.0], [122.0, 140.0, 80.0], noise(at / 4.0, 85)))
    } else {
        field(at / 44.0)
    }
}

/// A house with a gabled roof; lengths are voxels.
struct House {
    /// Middle, from the village's south-west corner.
    centre: DVec2,
    /// Half its length along the ridge, and half its width.
    half: DVec2,
    /// Angle of the ridge from east, 256ths of a turn.
    turn: u8,
    /// Height of the eaves above the datum, metres.
    eaves: f64,
    /// Colour of the roof, sRGB codes.
    roof: [u8; 3],
    /// Colour of the walls, sRGB codes.
    wall: [u8; 3],
}

/// Lists the houses on both sides of the street, none on the river, and a church.
fn houses() -> Vec<House> {
    let roofs = [[158, 74, 52], [142, 62, 48], [112, 84, 70], [96, 92, 94]];
    let walls = [[232, 224, 204], [224, 206, 170], [206, 212, 216], [236, 232, 226]];
    let lots = (0..12).flat_map(|lot| [-1.0, 1.0].map(|side| (lot, side)));
    let mut houses: Vec<_> = lots
        .map(|(lot, side)| {
            let pick = |seed: u64| chance(lot, side as i64, seed);
            let row = 150.0 + 17.0 * lot as f64 + 5.0 * pick(91);
            let centre = DVec2::new(street(row) + side * (11.0 + 3.0 * pick(92)), row);
            House {
                centre,
                half: DVec2::new(4.5 + 2.0 * pick(93), 3.2 + pick(94)),
                turn: (64.0 * pick(95).round() + 14.0 * pick(96) + 249.0) as u8,
                eaves: village_ground(centre) + 4.5 + 2.0 * pick(97),
                roof: roofs[(pick(98) * 3.999) as usize],
                wall: walls[(pick(99) * 3.999) as usize],
            }
        })
        .filter(|house| (house.centre.y - RIVER).abs() > RIVER_HALF + 9.0)
        .collect();

    let nave = DVec2::new(236.0, 238.0);
    let foot = village_ground(nave);
    let stone =
        House { roof: [88, 84, 88], wall: [214, 206, 188], turn: 0, centre: nave, half: nave, eaves: foot };
    houses.retain(|house| (house.centre - nave).length() > 22.0);
    houses.push(House { half: DVec2::new(9.0, 4.5), eaves: foot + 9.0, ..stone });
    houses.push(House {
        half: DVec2::splat(2.6),
        centre: nave + DVec2::new(11.0, 0.0),
        eaves: foot + 24.0,
        ..stone
    });
    houses
}

/// Direction of a 256th of a turn.
fn direction(turn: u8) -> DVec2 {
    DVec2::from(Cut::wall(turn, 0).normal().map(f64::from))
}

fn pillar(high: f64) -> Span {
    Span {
        low: Span::GROUND,
        high: CODE.encode(high),
        slope: [0, 0],
        cuts: [Cut::NONE; 3],
        top: [0; 3],
        state: Span::OPAQUE,
        side: [0; 3],
        material: 0,
        facade: Facade::NONE,
    }
}

impl House {
    /// Rise of the roof over run.
    const PITCH: f64 = 0.8;

    /// The part over the voxel with its middle at `at`, if there is one.
    fn over(&self, at: DVec2) -> Option<Span> {
        let along = direction(self.turn);
        let out = at - self.centre;
        let to = DVec2::new(along.dot(out), along.perp().dot(out));
        let inside = self.half - to.abs();
        if inside.min_element() < -0.75 {
            return None;
        }

        // Two walls at corners.
        let quarters = [if to.x < 0.0 { 128 } else { 0 }, if to.y < 0.0 { 192 } else { 64 }];
        let mut cuts = [Cut::NONE; 3];
        let walls = quarters.into_iter().zip(inside.to_array()).filter(|(_, inside)| *inside <= 0.75);
        for (cut, (quarter, inside)) in cuts.iter_mut().zip(walls) {
            let steps = (inside * f64::from(Cut::STEPS)).round() as i32;
            *cut = Cut::wall(self.turn.wrapping_add(quarter), steps);
        }

        let down = along.perp() * -to.y.signum() * Self::PITCH;
        let slope = down.to_array().map(|rise| (rise * f64::from(Span::SLOPE_STEPS)).round() as i8);
        let rise = Self::PITCH * VOXEL * (self.half.y - to.y.abs());
        Some(Span { cuts, slope, top: self.roof, side: self.wall, ..pillar(self.eaves + rise) })
    }
}

/// Lists all that stands over the voxel with its middle at `at`, lowest first.
fn standing_at(at: DVec2, houses: &[House]) -> Vec<Span> {
    let mut spans: Vec<_> = houses.iter().filter_map(|house| house.over(at)).collect();
    add_trees(at, &mut spans);
    let from_street = at.x - street(at.y);

    // A bridge carries the street, with parapets.
    if (at.y - RIVER).abs() < RIVER_HALF + 4.0 && from_street.abs() < 3.5 {
        let deck = Span { low: CODE.encode(4.2), top: [128, 124, 118], side: [168, 158, 142], ..pillar(5.0) };
        let is_parapet = from_street.abs() > 2.5;
        spans.push(if is_parapet { Span { high: CODE.encode(6.0), top: deck.side, ..deck } } else { deck });
    }

    // A wire beside the street on posts.
    if at.x.floor() == 252.0 && (140.0..380.0).contains(&at.y) {
        let is_post = at.y as i64 % 20 == 0;
        let wood = pillar(village_ground(at) + 9.0);
        let wood = Span { cuts: [Cut::wall(0, -40), Cut::wall(128, 56), Cut::NONE], ..wood };
        let wire = Span {
            low: CODE.encode(12.8),
            cuts: [Cut::wall(0, 0), Cut::NONE, Cut::NONE],
            state: Span::OPAQUE | Span::PARALLEL | Span::STRIP,
            ..pillar(13.0)
        };
        let span = if is_post { wood } else { wire };
        spans.push(Span { top: [70, 60, 52], side: [70, 60, 52], ..span });
    }

    spans.sort_by_key(|span| (span.low, span.high));
    spans
}

/// Trees in woods on the hollow's sides, and some between the houses.
fn add_trees(at: DVec2, spans: &mut Vec<Span>) {
    const APART: f64 = 7.0;
    let cell = (at / APART).floor();
    for step in (0..9).map(|step| DVec2::new(f64::from(step % 3), f64::from(step / 3)) - 1.0) {
        let own = cell + step;
        let pick = |seed: u64| chance(own.x as i64, own.y as i64, seed);
        let foot = (own + 0.25 + 0.5 * DVec2::new(pick(101), pick(102))) * APART;
        let from_street = (foot.x - street(foot.y)).abs();
        let is_wood = from_street > 34.0 && fractal(foot / 70.0, 2, 103) > 0.52;
        let is_garden = (19.0..32.0).contains(&from_street) && pick(104) > 0.6;
        let is_by_river = (RIVER_HALF + 3.0..RIVER_HALF + 9.0).contains(&(foot.y - RIVER).abs());
        let out = at - foot;
        if !(is_wood || is_garden || is_by_river && from_street > 9.0 && pick(105) > 0.4)
            || out.length() > 3.2
        {
            continue;
        }

        let (ground, high) = (village_ground(foot), 8.0 + 8.0 * pick(106));
        let stem = ground + 0.3 * high;
        if out.length() < 0.8 {
            spans.push(Span { top: [90, 72, 54], side: [90, 72, 54], ..pillar(stem + 1.0) });
        }
        let half = 0.35 * high * (1.0 - (out.length() / 3.2).powi(2)).max(0.0).sqrt();
        if half < 0.2 {
            continue;
        }
        let facing = facing(out);
        let shade = 0.8 + 0.4 * pick(107);
        let [top, side] =
            [[74.0, 112.0, 50.0], [52.0, 86.0, 40.0]].map(|code| codes(code.map(|code| code * shade)));
        spans.push(Span {
            low: CODE.encode(ground + 0.65 * high - half),
            cuts: [Cut::round(facing), Cut::NONE, Cut::NONE],
            top,
            side,
            state: 11,
            ..pillar(ground + 0.65 * high + half)
        });
    }
}

/// Returns the 256th of a turn nearest to a direction.
fn facing(out: DVec2) -> u8 {
    (0..=255_u8)
        .max_by(|one, other| direction(*one).dot(out).total_cmp(&direction(*other).dot(out)))
        .unwrap_or(0)
}
