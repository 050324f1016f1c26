//! One building, the ground behind it as seen from the sun, and the photograph of that.

use glam::{DVec2, dvec2};

use super::super::features::Ground;
use super::bounds::PlaceBounds;
use super::edge::{self, EdgePart, FoundEdge, PARTS, Pixel, RoughPixel, Unclear};
use super::patch::{Cut, PlacedRaster, RasterPatch};
use super::sunward::{Outlines, Sunward};
use hedgehop_base::error::Result;

/// A building that stands near.
#[derive(Debug, Clone, Copy)]
pub(super) struct Neighbour {
    /// Height of the ground on which it stands, metres.
    pub base: f64,
    /// Height above that, metres, if it is known.
    pub height: Option<f64>,
}

/// A building whose height is looked for.
pub(super) struct Site<'s> {
    pub sun: Sunward,
    /// Height of the ground on which it stands, metres.
    pub base: f64,
    /// Rings, turned to the sun.
    pub rings: &'s [Vec<DVec2>],
    /// Rings of other buildings with their numbers in `neighbours`, turned to the sun.
    pub others: &'s [(u32, Vec<DVec2>)],
    pub neighbours: &'s [Neighbour],
    /// Heights by places turned to the sun.
    pub ground: &'s dyn Ground,
    /// Lowest and highest that it may be, metres.
    pub range: (f64, f64),
}

/// Findings of the photograph about a site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Seen {
    /// A height.
    Height(FoundEdge),
    /// None, and why.
    Nothing(Reason),
}

/// Why there is no height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reason {
    /// The ground behind it is not in the picture.
    OutOfPicture,
    /// Not all of that ground is in the picture, and no edge is seen on it.
    LeavesPicture,
    /// Other buildings hide that ground, or shade it.
    Hidden,
    /// The ground is all of a brightness, or its brightness changes in no way that a shadow's would.
    NoShadow,
    /// An edge is seen, but not along all of the building.
    Ragged,
    /// The shadow is no longer than some pixels.
    Short,
    /// The picture is too fine for the size of the site.
    TooLarge,
    /// Much paler than the other shadows of the layer.
    Pale,
}

/// Margin that is compared on either side of a shadow, as a share of its width.
const MARGIN: f64 = 0.3;

/// Pixels that are looked at, at most; of more, every second, third, … row and column.
const MOST_ROUGH: f64 = 100_000.0;
const MOST_FINE: usize = 30_000;

type View = RasterPatch<[u8; 4]>;

/// Meaning of a place to the search.
enum Spot {
    /// On the building, beside the strip behind it, or without ground.
    Beside,
    /// On another building, or perhaps in its shadow.
    Hidden,
    /// Behind the building: the critical height and half of the half-shadow's height, metres.
    Behind(f64, f64),
}

/// The site's outlines in strips.
struct SiteScene<'a> {
    site: &'a Site<'a>,
    own: Outlines,
    others: Outlines,
}

impl Site<'_> {
    /// Bounds of the building turned to the sun.
    pub fn bounds(&self) -> PlaceBounds {
        PlaceBounds::around(self.rings.iter().flatten().copied())
    }

    /// Metres behind the building that are looked at: the longest shadow, and lit ground beyond it.
    fn reach(&self) -> f64 {
        1.5 * self.range.1 / self.sun.rise
    }

    /// Returns the region that is looked at, turned to the sun.
    pub fn region(&self) -> PlaceBounds {
        let PlaceBounds { low, high } = self.bounds();
        PlaceBounds { low: low - dvec2(self.reach(), 0.0), high }
    }

    /// The same with what is compared on either side.
    pub fn surroundings(&self) -> PlaceBounds {
        let PlaceBounds { low, high } = self.region();
        let beside = dvec2(0.0, MARGIN * (high.y - low.y));
        PlaceBounds { low: low - beside, high: high + beside }
    }

    /// Metres on either side of the shadow that are compared with it.
    fn margin(&self, side: f64) -> f64 {
        let PlaceBounds { low, high } = self.bounds();
        (4.0 * side).max(MARGIN * (high.y - low.y)) + side
    }

    /// The height that the photograph shows.
    ///
    /// # Errors
    /// A raster that cannot be read.
    pub fn look(&self, pictures: &[PlacedRaster<[u8; 4]>]) -> Result<Seen> {
        let mut views = Vec::new();
        for picture in pictures {
            match picture.cut(&self.sun, self.surroundings())? {
                Cut::Part(view) => views.push(view),
                Cut::Nothing => {}
                Cut::TooMany => return Ok(Seen::Nothing(Reason::TooLarge)),
            }
        }
        let Some(side) = views.iter().map(View::side).reduce(f64::min) else {
            return Ok(Seen::Nothing(Reason::OutOfPicture));
        };
        let scene = self.scene(side);
        Ok(match scene.search(&views, side) {
            Ok(found) => Seen::Height(found),
            Err(unclear) => Seen::Nothing(scene.reason(&views, unclear)),
        })
    }

    fn scene(&self, side: f64) -> SiteScene<'_> {
        let PlaceBounds { low, high } = self.bounds();
        let margin = self.margin(side);
        let across = low.y - margin..high.y + margin;
        let own = Outlines::new(self.rings.iter().map(|ring| (0, ring.as_slice())), across.clone(), side);
        let others =
            Outlines::new(self.others.iter().map(|(owner, ring)| (*owner, ring.as_slice())), across, side);
        SiteScene { site: self, own, others }
    }
}

impl SiteScene<'_> {
    fn search(&self, views: &[View], side: f64) -> Result<FoundEdge, Unclear> {
        let site = self.site;
        let rise = side * site.sun.rise;

        // A shadow of less than two pixels has no pixel of its own.
        let (lowest, highest) = (site.range.0.max(1.5 * rise), site.range.1);
        let region = site.region();
        let size = region.high - region.low;
        let stride = (size.x * size.y / (side * side) / MOST_ROUGH).sqrt().ceil().max(1.0) as u32;
        let mut rough = Vec::new();

        for (index, view) in views.iter().enumerate() {
            view.each(stride, region, |_, place, log| {
                if views[..index].iter().any(|above| above.shows(place)) {
                    return;
                }
                if let Spot::Behind(critical, _) = self.pixel(place, side) {
                    rough.push(RoughPixel { critical, log });
                }
            });
        }

        let start = edge::coarse(&rough, rise, lowest, highest)?;
        drop(rough);

        // The half-shadow where a roof of that height throws it.
        let soft = start / site.sun.rise * site.sun.spread;
        let (from, to) = edge::window(start, rise, soft);
        let mut near = Vec::new();

        for (index, view) in views.iter().enumerate() {
            view.each(1, region, |at, place, log| {
                let Spot::Behind(critical, _) = self.pixel(place, side) else { return };
                if (from..=to).contains(&critical) && !views[..index].iter().any(|above| above.shows(place)) {
                    near.push((index as u32, at, place, log));
                }
            });
        }

        let stride = (near.len() as f64 / MOST_FINE as f64).sqrt().ceil().max(1.0) as u32;
        let chosen = near.into_iter().filter(|(_, at, ..)| at.x % stride == 0 && at.y % stride == 0);

        let pixels: Vec<Pixel> = chosen
            .filter_map(|(index, at, place, log)| {
                let parts = self.parts(&views[index as usize], place)?;
                let place_of = (index, at.x / stride, at.y / stride);
                Some(Pixel { log: log as f32, place: place_of, across: place.y as f32, parts })
            })
            .collect();

        let found = edge::fine(&pixels, start, rise, soft)?;
        // Pictures and outlines do not lie on each other better than that.
        const REGISTRATION: f64 = 0.25;

        let found = FoundEdge { error: found.error.hypot(REGISTRATION * rise), ..found };
        if self.is_lit_beside(views, side, &found) { Ok(found) } else { Err(Unclear::Flat) }
    }

    /// Whether ground beside the shadow, on one side at least, is nearer to lit than to shaded ground, or none is seen. Where there is no shadow,
    /// fields and their borders may look like an edge, but seldom like one that ends with the building.
    fn is_lit_beside(&self, views: &[View], side: f64, found: &FoundEdge) -> bool {
        const LEAST: usize = 12;

        let site = self.site;
        let PlaceBounds { low, high } = site.bounds();
        let length = found.height / site.sun.rise;
        let width = site.margin(side);
        let middle = 0.5 * (found.lit + found.shade);
        let from = PlaceBounds { low: low - dvec2(0.8 * length, width), high: dvec2(low.x, high.y + width) };
        let (mut sums, mut counts) = ([0.0; 2], [0; 2]);

        for view in views {
            let stride = (width * length / (side * side) / MOST_ROUGH).sqrt().ceil().max(1.0) as u32;
            view.each(stride, from, |_, place, log| {
                let beside = (place.y > high.y + side, place.y < low.y - side);
                let index = match beside {
                    (true, _) => 0,
                    (_, true) => 1,
                    _ => return,
                };
                let ground = site.ground.height_at(place);
                if ground.is_some_and(|ground| !self.is_hidden(place, ground, found.height, side)) {
                    sums[index] += log;
                    counts[index] += 1;
                }
            });
        }

        let lit = |index: usize| counts[index] >= LEAST && sums[index] > middle * counts[index] as f64;
        counts.iter().all(|count| *count < LEAST) || lit(0) || lit(1)
    }

    /// Classifies a pixel for the search; `place` is turned.
    fn pixel(&self, place: DVec2, side: f64) -> Spot {
        let half = 0.5 * side;
        for beside in [dvec2(0.0, half), dvec2(0.0, -half), dvec2(half, 0.0), dvec2(-half, 0.0)] {
            match self.own.nearest(place + beside) {
                None | Some((_, true)) => return Spot::Beside,
                Some((_, false)) => {}
            }
        }
        let Spot::Behind(critical, soft) = self.spot(place) else { return Spot::Beside };
        let Some(ground) = self.site.ground.height_at(place) else { return Spot::Beside };
        if self.is_hidden(place, ground, critical, side) {
            return Spot::Hidden;
        }
        Spot::Behind(critical, soft)
    }

    /// A place without regard to other buildings.
    fn spot(&self, place: DVec2) -> Spot {
        let site = self.site;
        match (self.own.nearest(place), site.ground.height_at(place)) {
            (Some((distance, false)), Some(ground)) => {
                Spot::Behind(ground - site.base + distance * site.sun.rise, distance * site.sun.spread)
            }
            _ => Spot::Beside,
        }
    }

    fn is_hidden(&self, place: DVec2, ground: f64, critical: f64, side: f64) -> bool {
        let site = self.site;
        let mut ahead: Vec<(u32, f64, usize)> = Vec::new();
        for (owner, distance) in self.others.ahead(place) {
            match ahead.iter_mut().find(|(known, ..)| *known == owner) {
                Some((_, nearest, count)) => (*nearest, *count) = (nearest.min(distance), *count + 1),
                None => ahead.push((owner, distance, 1)),
            }
        }
        ahead.into_iter().any(|(owner, distance, count)| {
            let neighbour = site.neighbours[owner as usize];
            let shades = ground - neighbour.base + distance * site.sun.rise;
            // Where nothing is known, what would be first to shade the place if both were as high.
            let may = |height: f64| 1.05 * height + side * site.sun.rise + distance * site.sun.spread;
            count % 2 == 1 || distance < side || shades < neighbour.height.map_or(critical, may)
        })
    }

    /// Parts of a pixel.
    fn parts(&self, view: &View, place: DVec2) -> Option<[EdgePart; PARTS * PARTS]> {
        const SHARE: f64 = 1.0 / PARTS as f64;
        let mut parts = [EdgePart { critical: 0.0, soft: 0.0 }; PARTS * PARTS];
        let rise = 0.5 * SHARE * view.side() * self.site.sun.rise;
        for (index, part) in parts.iter_mut().enumerate() {
            let offset = |number: usize| (number as f64 + 0.5) * SHARE - 0.5;
            let place = place + view.step(offset(index % PARTS), offset(index / PARTS));
            let Spot::Behind(critical, soft) = self.spot(place) else { return None };
            *part = EdgePart { critical: critical as f32, soft: soft.hypot(rise) as f32 };
        }
        Some(parts)
    }

    /// Why the search found nothing: what there is along some lines behind the building.
    fn reason(&self, views: &[View], unclear: Unclear) -> Reason {
        const LINES: usize = 5;
        const PLACES: usize = 40;

        let PlaceBounds { low, high } = self.site.region();
        let (mut outside, mut hidden, mut near_outside, mut all) = (0, 0, 0, 0);
        let side = views.iter().map(View::side).fold(f64::INFINITY, f64::min);
        for line in 0..LINES {
            let y = low.y + (high.y - low.y) * (line as f64 + 0.5) / LINES as f64;
            for number in 0..PLACES {
                let share = (number as f64 + 0.5) / PLACES as f64;
                let place = dvec2(high.x + (low.x - high.x) * share, y);
                let spot = self.pixel(place, side);
                if matches!(spot, Spot::Beside) {
                    continue;
                }
                all += 1;
                if !views.iter().any(|view| view.shows(place)) {
                    outside += 1;
                    near_outside += usize::from(4 * number < PLACES);
                } else if matches!(spot, Spot::Hidden) {
                    hidden += 1;
                }
            }
        }

        match unclear {
            _ if 2 * outside > all || 4 * near_outside > all => Reason::OutOfPicture,
            _ if 8 * outside > all => Reason::LeavesPicture,
            _ if 2 * hidden > all => Reason::Hidden,
            Unclear::Few if 8 * hidden > all => Reason::Hidden,
            Unclear::Few => Reason::Short,
            Unclear::Flat => Reason::NoShadow,
            Unclear::Ragged => Reason::Ragged,
        }
    }
}
