//! Parts of pages that were found to be needed.

use std::collections::HashMap;

use glam::DVec3;

use super::ring::{Sides, Wedge};
use crate::voxel::{PAGE_SIDE, PageId, PageNeeds, PagePart, PageSource};

/// Posts around a stretch where a coarser level stands in.
const COARSER: f64 = 16.0;

/// Parts of pages that are needed, as they are found.
pub(super) struct Needs<'a> {
    source: &'a dyn PageSource,
    level_count: u8,
    /// Parts that are needed, and where first; heights stand for all posts.
    parts: HashMap<PagePart, FirstNeed>,
    /// Need of this wedge that was noted last, by level, of each kind.
    noted: Vec<[Option<Noted>; What::COUNT]>,
    /// Wedges before this one.
    wedges: u32,
}

/// First place at which a part of a page is needed.
#[derive(Debug, Clone, Copy)]
struct FirstNeed {
    /// Likely nothing of it is touched.
    is_doubtful: bool,
    /// Wedge that needs it.
    wedge: u32,
    /// At which ground distance, metres.
    distance: f64,
}

/// Pages that are all noted, and there.
#[derive(Debug, Clone, Copy)]
struct Noted {
    /// Major distances between which all of a wedge lies on them, with so many voxels before and around.
    from: f64,
    until: f64,
    margins: [f64; 2],
    is_likely: bool,
}

/// Need of some planes for data of a level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Need {
    pub level: u8,
    pub what: What,
    /// Major distances.
    pub from: f64,
    pub to: f64,
    /// Voxels before and around it that are read with it.
    pub margins: [f64; 2],
    /// Whether they are likely to read it.
    pub is_likely: bool,
}

/// Parts of a page that are told apart here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum What {
    /// Heights and paint.
    Posts,
    Bounds,
    /// Bare ground under pages of level index 0, where there is some, and what stands on it.
    Standing,
}

impl What {
    const COUNT: usize = 3;

    /// Iterates over the parts of a page that serve this need; heights stand for paint, too.
    fn of(self, page: PageId) -> impl Iterator<Item = PagePart> {
        let parts = match self {
            Self::Posts => [Some(PagePart::Heights(page)), None],
            Self::Bounds => [Some(PagePart::Bounds(page)), None],
            Self::Standing => [Some(PagePart::Heights(page.bare())), Some(PagePart::Spans(page.bare()))],
        };
        parts.into_iter().flatten()
    }
}

impl Noted {
    /// Whether nothing of `need` is left to be noted.
    fn holds(&self, need: &Need) -> bool {
        self.from <= need.from
            && need.to < self.until
            && (self.is_likely || !need.is_likely)
            && need.margins[0] <= self.margins[0]
            && need.margins[1] <= self.margins[1]
    }
}

impl<'a> Needs<'a> {
    pub fn new(source: &'a dyn PageSource) -> Self {
        let level_count = source.header().level_count;
        let noted = vec![[None; What::COUNT]; usize::from(level_count)];
        Self { source, level_count, parts: HashMap::new(), noted, wedges: 0 }
    }

    /// Begins another wedge: what follows belongs to it.
    pub fn next_wedge(&mut self) {
        self.noted.fill([None; What::COUNT]);
        self.wedges += 1;
    }

    /// Notes what `wedge` needs around `eye`, or what stands in for it where pages are absent. Stretches come as they lie, the nearest first.
    #[inline]
    pub fn add(&mut self, eye: DVec3, wedge: &Wedge, sides: &[Sides], need: Need) {
        let noted = &self.noted[usize::from(need.level)][need.what as usize];
        if !noted.as_ref().is_some_and(|noted| noted.holds(&need)) {
            self.note(eye, wedge, sides, need);
        }
    }

    #[inline(never)]
    fn note(&mut self, eye: DVec3, wedge: &Wedge, sides: &[Sides], need: Need) {
        let Need { level, what, from, to, margins, is_likely } = need;
        let own = &sides[usize::from(level)];
        let units = margins.map(|voxels| own.units(voxels));
        let pages =
            wedge.voxels(eye, own, [from, to], units).map(|range| range.map(|voxel| voxel / PAGE_SIDE));
        let place =
            FirstNeed { is_doubtful: !is_likely, wedge: self.wedges, distance: from * wedge.ground[0] };
        let [x, y] = pages;
        let mut is_whole = true;

        for py in y[0]..=y[1] {
            for px in x[0]..=x[1] {
                let id = PageId { level, px, py };
                let has = self.source.has(if what == What::Standing { id.bare() } else { id });

                // Where nothing stands nothing is missing.
                is_whole &= has || what == What::Standing;
                if !has && what == What::Standing {
                    continue;
                }

                for part in what.of(id) {
                    // Stretches go outward: the first one is the nearest.
                    let known = self.parts.entry(part).or_insert(place);
                    if known.is_doubtful && is_likely {
                        *known = place;
                    }
                }
            }
        }

        self.noted[usize::from(level)][what as usize] = is_whole.then(|| {
            let voxels = pages.map(|[first, last]| [first * PAGE_SIDE, last * PAGE_SIDE + (PAGE_SIDE - 1)]);
            Noted { from, until: wedge.within(eye, own, voxels, units[1]), margins, is_likely }
        });

        if !is_whole {
            // Blocks there begin and end elsewhere, and are skipped by bounds of their own.
            let need = Need { margins: [COARSER; 2], ..need };
            self.add(eye, wedge, sides, Need { level: level + 1, ..need });
            let last = self.level_count - 1;
            for level in ((level + 3).min(last)..=(level + 4).min(last)).filter(|_| what == What::Posts) {
                self.add(eye, wedge, sides, Need { level, what: What::Bounds, ..need });
            }
        }
    }

    /// Notes pages whose materials are looked at before planes march.
    pub fn add_materials(&mut self, pages: &[PageId]) {
        let place = FirstNeed { is_doubtful: false, wedge: 0, distance: 0.0 };
        for page in pages.iter().filter(|page| self.source.has(**page)) {
            self.parts.insert(PagePart::Heights(*page), place);
        }
    }

    /// Notes the bounds of the coarsest level, of which a [pyramid](crate::raymarch::scan::BoundPyramid) is made.
    pub fn add_coarsest_bounds(&mut self) {
        let level = self.level_count - 1;
        let (columns, rows) = self.source.header().grid.page_dims(level);
        let place = FirstNeed { is_doubtful: false, wedge: self.wedges, distance: f64::INFINITY };
        for (px, py) in (0..rows).flat_map(|py| (0..columns).map(move |px| (px, py))) {
            let known = self.parts.entry(PagePart::Bounds(PageId { level, px, py })).or_insert(place);
            if known.is_doubtful {
                *known = place;
            }
        }
    }

    /// The parts of pages as planes come to them: those that are likely to be touched, then the others; of both wedge by wedge, and the nearest of
    /// each first.
    pub fn into_page_needs(self) -> PageNeeds {
        let mut parts: Vec<_> = self.parts.into_iter().collect();
        parts.sort_unstable_by(|(a, first), (b, second)| {
            let places = first.is_doubtful.cmp(&second.is_doubtful).then(first.wedge.cmp(&second.wedge));
            places.then(first.distance.total_cmp(&second.distance)).then(a.cmp(b))
        });
        let all_of = |part: PagePart| {
            let paint = matches!(part, PagePart::Heights(_)).then(|| PagePart::Paint(part.page()));
            [Some(part), paint].into_iter().flatten()
        };
        let (likely, others) = parts.split_at(parts.partition_point(|(_, place)| !place.is_doubtful));
        let [likely, others] = [likely, others].map(|parts| parts.iter().flat_map(|(part, _)| all_of(*part)));
        let mut parts: Vec<_> = likely.collect();
        let likely = parts.len();
        parts.extend(others);
        PageNeeds { parts, likely }
    }
}
