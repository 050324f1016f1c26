//! Who reads a page, who waits for it and who lets it go, in many orders in which threads may run: the code of `src/memory` over threads of which
//! shuttle says who goes on. Nobody waits for ever (shuttle ends such an order with a panic), nobody reads what is not in memory, and no more is there
//! than may be.
//!
//! `HEDGEHOP_SCHEDULES` says how many orders each test runs (default: few), `HEDGEHOP_SEED` which.

mod memory;

use std::collections::{HashSet, VecDeque};
use std::sync::LazyLock;

use glam::DVec2;
use shuttle::scheduler::{PctScheduler, RandomScheduler, Scheduler};
use shuttle::{Config, Runner};

use hedgehop::voxel::{
    AlignedBytes, Grid, Metadata, PageId, PageNeeds, PagePart, PageSource, build_in_memory,
};
use hedgehop::{Result, voxel};
use memory::{PageFile, PagePlanner, PresentPages, ResidentPages, sync};

/// Orders of each test, unless told otherwise.
const SCHEDULES: usize = 1000;
/// Changes of mind of a scheduler that lets the most urgent thread run otherwise.
const DEPTH: usize = 4;
/// Pages of the finest level.
const PAGES: u32 = 5;
const FRAMES: u32 = 4;
const IN_FLIGHT: usize = 2;
const COARSEST: u8 = 3;
/// Turns that a test gives others for what they must do without being told again.
const PATIENCE: u32 = 3000;

static AREA: LazyLock<AlignedBytes> = LazyLock::new(|| {
    let grid = Grid { nx: PAGES * 256, ny: 3, spacing: 1.0, origin: DVec2::ZERO };
    let heights: Vec<f64> = (0..grid.nx * grid.ny).map(f64::from).collect();
    let colours = vec![[1, 2, 3]; heights.len()];
    let pages = build_in_memory(grid, &heights, &colours, None, &Metadata::default());
    AlignedBytes::copy_of(pages.expect("a database").bytes())
});

/// The same with one page's heights damaged.
static DAMAGED: LazyLock<AlignedBytes> = LazyLock::new(|| {
    let mut bytes = AlignedBytes::copy_of(AREA.as_slice());
    let pages = voxel::MemPages::from_bytes("area.hop", AREA.as_slice()).expect("a database");
    let heights = pages.stretch(fine(1));
    bytes.as_mut_slice()[heights.start + heights.len() / 2] ^= 1;
    bytes
});

fn number(name: &str, default: usize) -> usize {
    std::env::var(name).map_or(default, |value| value.parse().expect("a number"))
}

/// Half of the orders are random; in the other half one thread runs as long as it can, but for some changes.
fn in_many_orders(test: impl Fn() + Clone + Send + Sync + 'static) {
    fn run(scheduler: impl Scheduler + 'static, test: impl Fn() + Send + Sync + 'static) {
        let mut config = Config::new();
        config.stack_size = 1 << 18;
        Runner::new(scheduler, config).run(test);
    }
    let (schedules, seed) = (number("HEDGEHOP_SCHEDULES", SCHEDULES), number("HEDGEHOP_SEED", 1) as u64);
    run(RandomScheduler::new_from_seed(seed, schedules.div_ceil(2)), test.clone());
    run(PctScheduler::new_from_seed(seed, DEPTH, schedules.div_ceil(2)), test);
}

fn heights(level: u8, px: u32) -> PagePart {
    PagePart::Heights(PageId { level, px, py: 0 })
}

fn paint(level: u8, px: u32) -> PagePart {
    PagePart::Paint(PageId { level, px, py: 0 })
}

fn bounds(level: u8, px: u32) -> PagePart {
    PagePart::Bounds(PageId { level, px, py: 0 })
}

fn fine(px: u32) -> PagePart {
    heights(0, px % PAGES)
}

/// What no frame of a [`Plan`] needs.
const BESIDE: PagePart = PagePart::Heights(PageId { level: 0, px: 4, py: 0 });

/// What a [`Plan`] reads itself.
const FORESEEN_WITH: PagePart = PagePart::Bounds(PageId { level: 2, px: 0, py: 0 });

/// Heights of two fine pages, of which the next frame needs one, and in turn parts of two coarse pages.
fn view(frame: u32) -> Vec<PagePart> {
    let coarse = match frame % 4 {
        0 => vec![bounds(1, 0)],
        1 => vec![heights(1, 0), paint(1, 0)],
        2 => vec![heights(1, 1), paint(1, 1)],
        _ => vec![bounds(1, 1)],
    };
    [vec![fine(frame % 4), fine((frame + 1) % 4)], coarse].concat()
}

fn all_of(level: u8, px: u32) -> Vec<PagePart> {
    PagePart::all(PageId { level, px, py: 0 }).collect()
}

/// All parts of pages but those that stay.
fn everything() -> Vec<PagePart> {
    let coarse = [(1, 0), (1, 1), (2, 0)].map(|(level, px)| all_of(level, px));
    (0..PAGES).map(fine).chain(coarse.concat()).collect()
}

/// Frames need their view; to know it takes the bounds of a coarse page.
struct Plan<'a>(&'a ResidentPages);

/// The same, of frames that have paint brought once it is in sight.
struct Sighted<'a>(Plan<'a>);

impl PagePlanner for Sighted<'_> {
    fn needs(&self, frame: u32) -> Result<PageNeeds> {
        self.0.needs(frame)
    }

    fn is_behind(&self, frame: u32, page: PageId) -> bool {
        self.0.is_behind(frame, page)
    }

    fn brings_paint(&self) -> bool {
        true
    }
}

impl PagePlanner for Plan<'_> {
    fn needs(&self, frame: u32) -> Result<PageNeeds> {
        touch(self.0, FORESEEN_WITH)?;
        Ok(view(frame).into())
    }

    fn is_behind(&self, frame: u32, page: PageId) -> bool {
        page.px < frame % PAGES
    }
}

/// Nobody foresees anything.
struct Blind;

impl PagePlanner for Blind {
    fn needs(&self, _: u32) -> Result<PageNeeds> {
        Ok(PageNeeds::default())
    }

    fn is_behind(&self, _: u32, _: PageId) -> bool {
        false
    }
}

/// Whether a part of a page is there.
fn touch(pages: &impl PageSource, part: PagePart) -> Result<bool> {
    match part {
        PagePart::Heights(id) => pages.heights(id).map(|heights| heights.is_some()),
        PagePart::Paint(id) => pages.page(id).map(|page| page.is_some()),
        PagePart::Bounds(id) => pages.bounds(id).map(|bounds| bounds.is_some()),
        PagePart::Spans(id) => pages.spans(id).map(|spans| spans.is_some()),
    }
}

fn open(budget: Option<u64>) -> ResidentPages {
    ResidentPages::new(PageFile::new(&AREA), budget)
}

fn bytes_of(parts: impl IntoIterator<Item = PagePart>) -> u64 {
    let pages = voxel::MemPages::from_bytes("area.hop", AREA.as_slice()).expect("a database");
    parts.into_iter().map(|part| pages.part_bytes(part)).sum()
}

/// The most that frames in flight hold together.
fn held_bytes() -> u64 {
    held_by(IN_FLIGHT as u32)
}

/// The most that so many neighbouring frames need together.
fn held_by(frames: u32) -> u64 {
    (0..FRAMES).map(|first| held_from(first, frames)).max().unwrap_or_default()
}

/// What so many neighbouring frames need together, from frame `first` on.
fn held_from(first: u32, frames: u32) -> u64 {
    bytes_of((first..first + frames).flat_map(view).collect::<HashSet<_>>())
}

/// What is always in memory once it was asked for.
fn kept_bytes(coarsest: u8) -> u64 {
    (3..=coarsest).map(|level| bytes_of(all_of(level, 0))).sum()
}

/// When all is quiet, what counts as in memory is there, and nothing else; and what frames may rely on was always there. What was asked for without
/// notice may have gone before it was looked at.
fn check_account(pages: &ResidentPages) {
    let paging = pages.paging();
    assert_eq!(paging.resident_bytes, pages.file().store().bytes_here(), "{paging:?}");
    let mut strays = pages.file().store().strays();
    strays.retain(|part| ![BESIDE, FORESEEN_WITH].contains(part));
    assert_eq!(strays, [], "read though not in memory");
}

/// Frames that wait for their pages, two of them at a time; `beside`: each also asks for a page that nobody foresaw.
fn fly(pages: &ResidentPages, frames: u32, beside: Option<PagePart>) {
    fly_by(&Plan(pages), pages, frames, beside);
}

fn fly_by(plan: &dyn PagePlanner, pages: &ResidentPages, frames: u32, beside: Option<PagePart>) {
    let render = |frame: u32| {
        let (paint, others): (Vec<_>, Vec<_>) =
            view(frame).into_iter().chain(beside).partition(|part| matches!(part, PagePart::Paint(_)));
        for part in others {
            assert!(touch(pages, part).expect("no damage"), "{part:?}");
        }

        let missing = paint.iter().map(|part| part.page()).filter(|page| !pages.is_at_hand(*page));
        let missing: Vec<_> = missing.inspect(|page| pages.announce(*page)).collect();
        if !missing.is_empty() && plan.brings_paint() {
            pages.bring(&missing);
        }
        for part in paint {
            assert!(touch(pages, part).expect("no damage"), "{part:?}");
        }
    };

    let flown = pages.ahead_of(FRAMES, plan, |flight| {
        sync::scope(|scope| {
            let mut in_flight = VecDeque::new();
            for frame in 0..frames {
                in_flight.push_back(scope.spawn(move || {
                    flight.begin(frame);
                    render(frame);
                }));
                if in_flight.len() == IN_FLIGHT {
                    in_flight.pop_front().into_iter().for_each(|first| first.join().expect("a frame"));
                    flight.deliver(frame + 1 - IN_FLIGHT as u32);
                }
            }
        });
    });

    flown.expect("the memory thread starts");
    check_account(pages);
}

#[test]
fn what_was_foreseen_is_there_within_the_budget() {
    let budget = held_bytes() + bytes_of([FORESEEN_WITH]);
    in_many_orders(move || {
        let pages = open(Some(budget));
        fly(&pages, FRAMES, None);
        let paging = pages.paging();
        assert_eq!(paging.demand_misses, 0, "{paging:?}");
        assert!(paging.resident_bytes_most <= budget, "{paging:?}");
    });
}

#[test]
fn what_is_in_sight_is_brought_whatever_the_memory() {
    let beside = bytes_of([FORESEEN_WITH]);
    // A byte is lacking for two frames in flight, or for the next one beside them.
    let short = (0..FRAMES - 1).flat_map(|first| [2, 3].map(|frames| held_from(first, frames) - beside - 1));
    for budget in short.chain([0, held_by(1), held_bytes(), u64::MAX]) {
        in_many_orders(move || {
            let pages = open(Some(budget));
            fly_by(&Sighted(Plan(&pages)), &pages, FRAMES, None);
            // Where two frames do not fit with all that they will have in sight, one waits for the other.
            let most = budget.max(held_by(1)).saturating_add(beside);
            assert!(pages.paging().resident_bytes_most <= most, "{:?}, not {most}", pages.paging());
        });
    }
}

#[test]
fn frames_go_on_in_any_memory_and_hold_no_more_than_they_need() {
    let fine_page = bytes_of([BESIDE]);
    for budget in [0, fine_page, 2 * fine_page, 4 * fine_page] {
        in_many_orders(move || {
            let pages = open(Some(budget));
            fly(&pages, FRAMES, Some(BESIDE));
            let beside = bytes_of([BESIDE, FORESEEN_WITH]);
            let most = budget.max(held_bytes() + beside);
            assert!(pages.paging().resident_bytes_most <= most, "{:?}, not {most}", pages.paging());
        });
    }
}

#[test]
fn a_flight_may_end_whatever_the_memory_thread_is_doing() {
    for (frames, budget) in [(0, u64::MAX), (0, 0), (1, 0), (2, held_bytes())] {
        in_many_orders(move || fly(&open(Some(budget)), frames, None));
    }
}

#[test]
fn a_page_is_read_once_whoever_asks_for_it() {
    let parts = [fine(0), heights(1, 0), paint(1, 0), bounds(1, 0)];
    in_many_orders(move || {
        let pages = open(None);
        sync::scope(|scope| {
            for turn in 0..3 {
                let pages = &pages;
                scope.spawn(move || {
                    for at in 0..parts.len() {
                        assert!(touch(pages, parts[(at + turn) % parts.len()]).expect("no damage"));
                    }
                });
            }
        });
        assert_eq!(pages.paging().pages_read, parts.len() as u64);
        assert_eq!(pages.file().store().strays(), []);
        check_account(&pages);
    });
}

#[test]
fn whoever_waits_for_a_damaged_page_is_told() {
    in_many_orders(|| {
        let pages = ResidentPages::new(PageFile::new(&DAMAGED), None);
        let flown = pages.ahead_of(FRAMES, &Plan(&pages), |flight| {
            sync::scope(|scope| {
                for frame in [0, 0, 1] {
                    let pages = &pages;
                    scope.spawn(move || {
                        flight.begin(frame);
                        for part in view(frame) {
                            assert_eq!(touch(pages, part).is_err(), part == fine(1), "{part:?}");
                        }
                    });
                }
            });
        });
        flown.expect("the memory thread starts");
        check_account(&pages);
    });
}

/// A worker of a frame that does not wait: what it sees once it sees again, and what it does not see it never does.
fn see_twice(present: &PresentPages<'_>, parts: &[PagePart]) -> usize {
    let see = || parts.iter().map(|part| touch(present, *part).unwrap_or(false)).collect::<Vec<_>>();
    let seen = see();
    assert_eq!(seen, see());
    seen.iter().filter(|is_here| **is_here).count()
}

/// Frames that do not wait, two of them at a time, each with two workers.
fn fly_late(pages: &ResidentPages, frames: u32, planner: &dyn PagePlanner) {
    let flown = pages.live(planner, |flight| {
        sync::scope(|scope| {
            let mut in_flight = VecDeque::new();
            for frame in 0..frames {
                let present = flight.begin(frame);
                in_flight.push_back(scope.spawn(move || {
                    sync::scope(|workers| {
                        // Also what goes because no frame is known to need it.
                        workers.spawn(|| see_twice(&present, &everything()));
                        see_twice(&present, &view(frame));
                    });
                }));

                if in_flight.len() == IN_FLIGHT {
                    in_flight.pop_front().into_iter().for_each(|first| first.join().expect("a frame"));
                    flight.deliver(frame + 1 - IN_FLIGHT as u32);
                }
            }
        });
    });

    flown.expect("the memory thread starts");
    check_account(pages);
    let paging = pages.paging();
    assert_eq!((paging.demand_misses, paging.demand_waits), (0, 0), "{paging:?}");
}

#[test]
fn what_a_frame_that_does_not_wait_began_with_stays() {
    let kept = kept_bytes(COARSEST);
    for room in [bytes_of([fine(0), fine(1)]), held_bytes()] {
        in_many_orders(move || {
            let budget = kept + room;
            let pages = open(Some(budget));
            fly_late(&pages, FRAMES, &Plan(&pages));
            // PagePlanner takes what it needs; frames get along with what there is room for.
            let most = budget + bytes_of([FORESEEN_WITH]);
            assert!(pages.paging().resident_bytes_most <= most, "{:?}, not {most}", pages.paging());
        });
    }
}

#[test]
fn a_flight_that_does_not_wait_may_end_at_any_time() {
    for frames in [0, 1] {
        in_many_orders(move || {
            let pages = open(Some(kept_bytes(COARSEST) + held_bytes()));
            fly_late(&pages, frames, &Plan(&pages));
        });
    }
}

/// A frame asks for a view once, and others are told of nothing but that; whether all of it comes.
fn comes_by_itself(is_damaged: bool) {
    let file = PageFile::new(if is_damaged { &DAMAGED } else { &AREA });
    let expected = view(0).len() as u64 - u64::from(is_damaged);

    // With heights comes the paint, and fine pages are asked for by their heights.
    let reads = view(0).len() as u64 + 2 - u64::from(is_damaged);
    let pages = ResidentPages::new(file, None);

    let flown = pages.live(&Blind, |flight| {
        let before = pages.paging().pages_read;
        let present = flight.begin(0);

        // The memory thread has nothing to do, and sleeps, in some orders.
        sync::yield_now();
        assert_eq!(see_twice(&present, &view(0)), 0);
        let is_there = |_: &u32| {
            sync::yield_now();
            pages.paging().pages_read == before + reads
        };
        assert!((0..PATIENCE).any(|turn| is_there(&turn)), "{:?}", pages.paging());
        drop(present);
        let present = flight.begin(1);
        let seen =
            view(0).into_iter().filter_map(|part| touch(&present, part).ok()).filter(|is_here| *is_here);
        assert_eq!(seen.count() as u64, expected);
    });

    flown.expect("the memory thread starts");
    check_account(&pages);
}

#[test]
fn what_a_frame_wants_comes_without_another_word() {
    in_many_orders(|| comes_by_itself(false));
}

#[test]
fn a_damaged_page_holds_up_no_other() {
    in_many_orders(|| comes_by_itself(true));
}
