//! What frames that never wait see, want and hold, and what others get where there is little room.

use std::collections::VecDeque;

use glam::DVec2;
use tempfile::TempDir;

use super::resident::Purpose;
use super::sync::{Receiver, Sender, bounded};
use super::{PageFile, PresentPages, ResidentPages};
use crate::voxel::{Arrays, Grid, Metadata, PageId, PageNeeds, PagePart, PageSource, write_arrays};
use hedgehop_base::progress::Silent;

/// Four by four pages of the finest level.
const SIDE: u32 = 1024;

struct Site {
    pages: ResidentPages,
    news: (Sender<()>, Receiver<()>),
    _folder: TempDir,
}

impl Site {
    /// With room for so many bytes beside the coarsest level, which is there.
    fn new(room: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("area.hop");
        let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
        let heights: Vec<f64> = (0..SIDE * SIDE).map(|post| f64::from(post % 100)).collect();
        let colours = vec![[9; 3]; heights.len()];
        let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
        write_arrays(&path, &arrays, &Metadata::default(), false).unwrap();
        let length = |id| PageFile::open(&path).unwrap().directory().get(id).map_or(0, |entry| entry.length);
        let coarsest = u64::from(length(PageId { level: 3, px: 0, py: 0 }));
        let budget = coarsest.saturating_add(room);
        let pages = ResidentPages::new(PageFile::open(&path).unwrap(), Some(budget));
        pages.manage();
        pages.bring_coarsest().unwrap();
        Self { pages, news: bounded(1), _folder: folder }
    }

    fn present(&self) -> PresentPages<'_> {
        self.pages.present(&self.news.0)
    }

    /// Brings what there is room for; what is left.
    fn bring(&self, parts: &[PagePart], need: Purpose<'_>) -> Vec<PagePart> {
        let mut parts: VecDeque<_> = parts.iter().copied().collect();
        while self.pages.bring_some(&mut parts, need) && !parts.is_empty() {}
        parts.into()
    }

    fn wanted(&self) -> Vec<PagePart> {
        let mut wanted = Vec::new();
        self.pages.take_wanted(&mut wanted);
        wanted
    }

    fn bytes(&self) -> u64 {
        self.pages.paging().resident_bytes
    }
}

fn page(number: u32) -> PageId {
    PageId { level: 0, px: number % 4, py: number / 4 }
}

fn heights(number: u32) -> PagePart {
    PagePart::Heights(page(number))
}

/// All parts of pages.
fn fine(numbers: &[u32]) -> Vec<PagePart> {
    numbers.iter().flat_map(|number| PagePart::posts(page(*number))).collect()
}

fn page_bytes() -> u64 {
    let site = Site::new(u64::MAX);
    fine(&[5]).into_iter().map(|part| site.pages.file().store().part_bytes(part)).sum()
}

fn heights_bytes() -> u64 {
    Site::new(u64::MAX).pages.file().store().part_bytes(heights(5))
}

/// A site with a surface on its south-western page alone.
fn bare_site(room: Option<u64>) -> Site {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("area.hop");
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 1.0, origin: DVec2::ZERO };
    let places = (0..SIDE * SIDE).map(|post| (post % SIDE, post / SIDE));
    let heights: Vec<f64> =
        places.map(|(x, y)| if x < 200 && y < 200 { f64::from(x % 90) } else { f64::NAN }).collect();
    let colours = vec![[9; 3]; heights.len()];
    let arrays = Arrays { grid, heights: &heights, colours: &colours, attributes: None };
    write_arrays(&path, &arrays, &Metadata::default(), false).unwrap();
    let pages = ResidentPages::new(PageFile::open(&path).unwrap(), room);
    Site { pages, news: bounded(1), _folder: folder }
}

#[test]
fn pages_without_bytes_are_always_there() {
    let site = bare_site(Some(1 << 30));
    let frame = site.present();
    for number in 1..16 {
        let id = page(number);
        assert!(frame.has(id) && frame.is_at_hand(id) && site.pages.is_at_hand(id), "{id}");
        assert!(frame.page(id).unwrap().is_some() && frame.heights(id).unwrap().is_some());
        assert!(frame.bounds(id).unwrap().is_some() && site.pages.page(id).unwrap().is_some());
        site.pages.bring(&[id]);
    }

    assert!(!frame.has(page(0)) && frame.page(page(0)).unwrap().is_none());
    assert_eq!(site.wanted(), fine(&[0]));
    let paging = site.pages.paging();
    let counts = [paging.demand_misses, paging.pages_read, paging.bytes_read, paging.resident_bytes];
    assert_eq!((counts, paging.pages_late), ([0; 4], 2));
    drop(frame);

    // All of the database is what has bytes.
    let bytes = site.pages.bytes();
    assert!(bytes < 1_500_000, "{bytes}");
    let site = bare_site(Some(bytes));
    site.pages.load_all(&Silent).unwrap();
    assert!(site.pages.is_whole() && site.bytes() == bytes);
    let expected = fine(&[0, 7, 9]);
    let missing = bare_site(None).pages.expect(3, &PageNeeds::from(expected), None, |_| true).unwrap();
    assert_eq!(missing.iter().map(|(part, _)| *part).collect::<Vec<_>>(), fine(&[0]));
}

const NOTHING_BEHIND: &dyn Fn(PageId) -> bool = &|_| false;

#[test]
fn a_frame_sees_what_was_there_when_it_began_and_wants_the_rest_once() {
    let site = Site::new(u64::MAX);
    assert_eq!(site.bring(&fine(&[1]), Purpose::Now(0, NOTHING_BEHIND)), []);
    let before = site.pages.paging();
    let frame = site.present();
    assert!(frame.has(page(1)) && frame.page(page(1)).unwrap().is_some());
    assert_eq!(frame.count(), 5, "all parts of the coarsest page, both of another");
    for _ in 0..3 {
        assert!(!frame.has(page(2)) && frame.page(page(2)).unwrap().is_none());
    }

    assert!(site.news.1.try_recv().is_ok(), "the memory thread was told");
    assert_eq!(site.wanted(), fine(&[2]));

    // What comes while it is rendered is not for it, but for the next one.
    site.bring(&fine(&[2]), Purpose::Now(0, NOTHING_BEHIND));
    assert!(!frame.has(page(2)) && frame.page(page(2)).unwrap().is_none());
    assert_eq!(site.wanted(), []);
    assert!(site.present().page(page(2)).unwrap().is_some());

    // Nowhere and absent are not wanted.
    assert!(frame.page(PageId { level: 0, px: 99, py: 0 }).unwrap().is_none());
    let paging = site.pages.paging().since(&before);
    assert_eq!((paging.demand_misses, paging.pages_late, paging.pages_read), (0, 2, 2));

    // Wanted in vain: it may be asked for again.
    frame.page(page(3)).unwrap();
    site.pages.forget_wanted(site.wanted().into_iter());
    frame.page(page(3)).unwrap();
    assert_eq!(site.wanted(), fine(&[3]));
}

#[test]
fn what_a_frame_holds_leaves_when_it_ends() {
    let site = Site::new(2 * page_bytes());
    site.bring(&fine(&[5, 6]), Purpose::Now(0, NOTHING_BEHIND));
    let full = site.bytes();
    let frame = site.present();
    // Both may go, but not before the frame ends: there is no room until then.
    assert_eq!(site.bring(&fine(&[9, 10]), Purpose::Now(0, NOTHING_BEHIND)), fine(&[9, 10]));
    assert_eq!(site.bytes(), full);
    assert!(frame.has(page(5)) && !site.present().has(page(5)));
    drop(frame);
    assert_eq!(site.bring(&fine(&[9, 10]), Purpose::Now(0, NOTHING_BEHIND)), []);
    assert!(site.bytes() <= full && site.present().has(page(10)));
    assert_eq!(site.pages.paging().pages_evicted, 4);
}

#[test]
fn a_page_that_left_and_came_again_counts_once() {
    let site = Site::new(2 * page_bytes());
    site.bring(&fine(&[5]), Purpose::Now(0, NOTHING_BEHIND));
    let one = site.bytes();
    let frame = site.present();
    fine(&[5]).into_iter().for_each(|part| site.pages.evict_now(part));
    assert_eq!(site.bring(&fine(&[5]), Purpose::Now(0, NOTHING_BEHIND)), []);
    assert_eq!(site.bytes(), one);
    drop(frame);
    site.pages.let_go_all();
    assert_eq!(site.bytes(), one);
    assert!(site.present().page(page(5)).unwrap().is_some());
}

#[test]
fn frames_far_ahead_make_room_behind_the_eye_only() {
    let site = Site::new(2 * page_bytes());
    site.bring(&fine(&[5, 6]), Purpose::Now(0, NOTHING_BEHIND));
    let far = fine(&[9]);
    assert_eq!(site.bring(&far, Purpose::Ahead(30, NOTHING_BEHIND)), far);
    assert_eq!(site.bring(&far, Purpose::Ahead(30, &|id| id == page(6))), []);
    assert!(site.present().has(page(5)) && !site.present().has(page(6)));
    // What the next frame needs takes the room, but not from what it needs itself.
    site.pages.keep_for(1, &fine(&[9, 10]).into());
    assert_eq!(site.bring(&fine(&[9, 10]), Purpose::Now(1, NOTHING_BEHIND)), []);
    assert_eq!(site.bring(&fine(&[5]), Purpose::Now(1, NOTHING_BEHIND)), fine(&[5]));
    site.pages.deliver(2);
    assert_eq!(site.bring(&fine(&[5]), Purpose::Now(2, NOTHING_BEHIND)), []);
}

#[test]
fn what_is_likely_to_be_read_has_room_before_what_may_be() {
    let site = Site::new(2 * heights_bytes());
    let needs = |parts: &[u32], likely| PageNeeds {
        parts: parts.iter().map(|number| heights(*number)).collect(),
        likely,
    };
    let expect = |frame, needs: &PageNeeds| {
        let expected = site.pages.expect(frame, needs, None, |_| false)?;
        site.pages.read(&expected);
        Some(expected.into_iter().map(|(part, _)| part).collect::<Vec<_>>())
    };

    // Far ahead nothing is done by halves; soon what is likely must do.
    assert_eq!(expect(3, &needs(&[1, 2, 3], 2)), None);
    assert_eq!(expect(2, &needs(&[1, 2, 3], 2)), Some(vec![heights(1), heights(2)]));
    assert_eq!(expect(2, &needs(&[4, 1, 2], 3)), None, "three are too many before a frame is delivered");

    // What may be read and is there gives way to what is likely, also where the frame was asked for in vain before.
    assert_eq!(expect(3, &needs(&[4, 5, 1, 2], 2)), None);
    site.pages.deliver(3);
    assert_eq!(expect(3, &needs(&[4, 5, 1, 2], 2)), Some(vec![heights(4), heights(5)]));

    // With room for all of it, all of it comes.
    site.pages.deliver(4);
    assert_eq!(expect(9, &needs(&[6, 7], 1)), Some(vec![heights(6), heights(7)]));
}

#[test]
fn what_is_in_sight_is_brought_and_stays_for_the_frame() {
    let site = Site::new(2 * page_bytes());
    site.pages.begin(4);
    site.pages.deliver(4);
    assert!(!site.pages.is_at_hand(page(1)));
    site.pages.bring(&[page(1)]);
    assert!(site.pages.is_at_hand(page(1)) && !site.pages.is_at_hand(page(2)));
    assert_eq!(site.pages.paging().pages_in_sight, 2);
    site.pages.bring(&[page(1)]);
    assert_eq!(site.pages.paging().pages_in_sight, 2, "it is there");

    // Others have no room while frame 4 is in flight.
    let expect = |frame, parts: &[PagePart]| {
        let expected = site.pages.expect(frame, &PageNeeds::from(parts.to_vec()), None, NOTHING_BEHIND)?;
        site.pages.read(&expected);
        Some(expected.into_iter().map(|(part, _)| part).collect::<Vec<_>>())
    };
    assert_eq!(expect(8, &fine(&[5, 6])), None);
    assert!(site.pages.is_at_hand(page(1)));
    site.pages.deliver(5);
    assert_eq!(expect(8, &fine(&[5, 6])), Some(fine(&[5, 6])));
    assert!(!site.pages.is_at_hand(page(1)));

    // A frame needs what it needs, also where others have all the room.
    assert!(site.bytes() <= site.pages.budget());
    site.pages.begin(5);
    site.pages.bring(&[page(2)]);
    assert!(site.pages.is_at_hand(page(2)) && site.pages.is_at_hand(page(5)));
}

#[test]
fn frames_leave_room_for_paint_that_will_be_in_sight() {
    let site = Site::new(3 * page_bytes());
    let heights =
        |numbers: &[u32]| PageNeeds::from(numbers.iter().map(|number| heights(*number)).collect::<Vec<_>>());
    let expect = |frame, needs: &PageNeeds, paint: &[PagePart]| {
        let paint = vec![(frame, paint.to_vec())];
        let expected = site.pages.expect(frame, needs, Some(&paint), NOTHING_BEHIND);
        expected.inspect(|expected| site.pages.read(expected)).is_some()
    };
    let six = heights(&[0, 1, 2, 3, 4, 5]);
    assert!(!expect(9, &six, &[]), "six pages' heights are more than half of three pages");
    let paint = |count| (0..count).map(|number| PagePart::Paint(page(number))).collect::<Vec<_>>();
    assert!(expect(2, &six, &[]), "soon they may be");
    // While another frame is in flight that holds them, a view elsewhere has no room for what it will have in sight.
    let elsewhere = heights(&[8]);
    assert!(!expect(2, &elsewhere, &paint(4)) && expect(2, &elsewhere, &[]));
    site.pages.deliver(2);
    assert!(expect(2, &elsewhere, &paint(14)), "it begins with what there is");
}

#[test]
fn paint_is_taken_out_of_what_is_needed() {
    let mut needs = PageNeeds { parts: fine(&[1, 2, 3]), likely: 3 };
    let paint = needs.take_paint();
    assert_eq!(needs, PageNeeds { parts: [1, 2, 3].map(heights).to_vec(), likely: 2 });
    assert_eq!(paint, [1, 2, 3].map(|number| PagePart::Paint(page(number))));
}

#[test]
fn beside_a_flight_what_is_brought_is_not_held() {
    let site = Site::new(2 * page_bytes());
    for number in [1, 2, 3] {
        site.pages.bring(&[page(number)]);
        assert!(site.pages.is_at_hand(page(number)) && site.bytes() <= site.pages.budget());
    }
    assert!(!site.pages.is_at_hand(page(1)));
}
