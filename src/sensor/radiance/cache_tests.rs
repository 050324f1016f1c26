//! What is kept, and what makes room.

use std::sync::atomic::{AtomicU32, Ordering};

use super::tests::{Holey, bake, rough, sensor};
use super::*;
use crate::voxel::{BoundsView, Header, PageId, PageSource, PageView, SpansView};
use hedgehop_base::error::Result;

#[test]
fn what_was_not_used_for_longest_makes_room_and_comes_again() {
    let source = Holey { whole: rough(1024, 256, 0), absent: |_| false, asked: AtomicU32::new(0) };
    let id = |px| PageId { level: 0, px, py: 0 };
    let page = |radiance: &Radiance, px| {
        RadiancePages::new(&source, radiance).page(id(px)).unwrap().map(|page| (*page).clone())
    };
    let one = bake(&source, 0, 1, 0).unwrap().bytes();
    let radiance = Radiance::with_budget(sensor(), 2 * one);
    let first: Vec<_> = (0..4).map(|px| page(&radiance, px)).collect();
    assert!(radiance.bytes() > 3 * one);
    for _ in 0..3 {
        radiance.begin_frame();
        page(&radiance, 2);
    }

    radiance.begin_frame();
    assert!(radiance.bytes() <= 2 * one, "{} bytes", radiance.bytes());
    let before = source.asked.load(Ordering::Relaxed);
    assert!(page(&radiance, 2) == first[2]);
    assert_eq!(source.asked.load(Ordering::Relaxed), before, "what was used last is kept");
    assert!(page(&radiance, 0) == first[0]);
    assert!(source.asked.load(Ordering::Relaxed) > before, "what was dropped is computed again");
}

/// A database of which a page is not at hand.
struct Far(Holey<fn(PageId) -> bool>, PageId);

impl PageSource for Far {
    fn header(&self) -> &Header {
        self.0.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.0.page(id)
    }

    fn spans(&self, id: PageId) -> Result<Option<SpansView<'_>>> {
        self.0.spans(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        self.0.bounds(id)
    }

    fn has(&self, id: PageId) -> bool {
        self.0.has(id)
    }

    fn is_at_hand(&self, id: PageId) -> bool {
        id != self.1
    }
}

#[test]
fn light_that_must_wait_is_dark_and_its_page_missing_until_it_is_known() {
    let whole = Holey {
        whole: rough(512, 256, 0),
        absent: (|_| false) as fn(PageId) -> bool,
        asked: AtomicU32::new(0),
    };
    let id = |px| PageId { level: 0, px, py: 0 };
    let far = Far(whole, id(1));
    let radiance = Radiance::new(sensor());
    let filter = LineFilter { facing: Facing::down(1), shift: 0, span: 1 };
    let strip = |px| super::cache::LineStrip::with(id(px), filter, 40);
    let mut patient = RadiancePages::new(&far, &radiance).without_waiting();
    let near = patient.lines(strip(0)).unwrap().unwrap();
    assert!(near.texels.iter().any(|texel| *texel > 0) && patient.take_missing().is_empty());
    let asked = || far.0.asked.load(Ordering::Relaxed);
    let before = asked();

    for _ in 0..2 {
        let dark = patient.lines(strip(1)).unwrap().unwrap();
        assert!(dark.texels.iter().all(|texel| *texel == 0));
        assert_eq!(patient.take_missing(), [id(1)]);
    }

    assert_eq!(asked(), before, "nothing was read of it");
    // Who waits has its light, and from then on all have.
    let light = RadiancePages::new(&far, &radiance).lines(strip(1)).unwrap().unwrap();
    assert!(light.texels.iter().any(|texel| *texel > 0));
    assert_eq!(patient.lines(strip(1)).unwrap().unwrap(), light);
    assert!(patient.take_missing().is_empty());
}

#[test]
fn pages_of_frames_in_flight_stay() {
    let source = rough(512, 256, 0);
    let radiance = Radiance::with_budget(sensor(), 0);
    let pages = RadiancePages::new(&source, &radiance);
    let kept = pages.page(PageId { level: 0, px: 0, py: 0 }).unwrap();
    radiance.begin_frame();
    radiance.begin_frame();
    assert!(radiance.bytes() > 0);
    radiance.begin_frame();
    assert_eq!(radiance.bytes(), 0);
    // Whoever still holds one may go on with it.
    assert!(kept.is_some());
}

#[test]
fn light_of_a_page_is_there_where_the_page_is() {
    let source =
        |absent: fn(PageId) -> bool| Holey { whole: rough(512, 256, 0), absent, asked: AtomicU32::new(0) };
    let (whole, holey) = (source(|_| false), source(|id| id.px == 1));
    let radiance = Radiance::new(sensor());
    let page = |source: &Holey<fn(PageId) -> bool>, px| {
        let found = RadiancePages::new(source, &radiance).page(PageId { level: 0, px, py: 0 }).unwrap();
        found.map(|page| (*page).clone())
    };
    // Not there yet: nothing of it is kept.
    assert!(page(&holey, 1).is_none());
    let light = page(&whole, 1);
    assert!(light.is_some());
    // Known now, but not to a frame that does not have the page.
    assert!(page(&holey, 1).is_none() && page(&holey, 0).is_some());
    assert!(page(&whole, 1) == light);
}
