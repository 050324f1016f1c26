//! Faults that are planted are found where they are, and in sound ground there are none.

use std::sync::OnceLock;

use glam::DVec2;

use super::*;
use hedgehop::voxel::{BoundsView, Grid, Header, HeightsView, MemPages, Metadata, PageView, build_in_memory};
use hedgehop_base::progress::Silent;

const SIDE: u32 = 600;

/// A place in voxels.
type Ground = dyn Fn(u32, u32) -> f64;

/// Hills of all sizes: sines in many directions, half as high as they are half as long.
fn hills(x: f64, y: f64) -> f64 {
    (0..28)
        .map(|wave| {
            let number = f64::from(wave);
            let length = 4000.0 / 1.13_f64.powf(number);
            let (sine, cosine) = (2.4 * number).sin_cos();
            0.03 * length * (std::f64::consts::TAU * (x * cosine + y * sine) / length + number * number).sin()
        })
        .sum()
}

fn ground(x: u32, y: u32) -> f64 {
    static HEIGHTS: OnceLock<Vec<f64>> = OnceLock::new();
    let heights = HEIGHTS.get_or_init(|| {
        let voxels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (f64::from(x), f64::from(y))));
        voxels.map(|(x, y)| 500.0 + hills(10.0 * x, 10.0 * y)).collect()
    });
    heights[(y * SIDE + x) as usize]
}

fn area(height: &Ground) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: 10.0, origin: DVec2::new(5000.0, 8000.0) };
    let heights: Vec<f64> =
        (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))).map(|(x, y)| height(x, y)).collect();
    build_in_memory(grid, &heights, &vec![[9; 3]; heights.len()], None, &Metadata::default()).unwrap()
}

fn report(height: &Ground) -> ContinuityReport {
    continuity(&area(height), &ContinuityLimits::default(), &Silent).unwrap()
}

/// The only finding there is.
#[track_caller]
fn only(report: &ContinuityReport, fault: Fault) -> Finding {
    assert_eq!(report.findings.len(), 1, "{:?}", report.findings);
    assert_eq!((report.findings[0].fault, report.count(fault)), (fault, 1));
    report.findings[0]
}

/// The middle of a voxel.
fn middle(x: u32, y: u32) -> DVec2 {
    DVec2::new(5005.0 + 10.0 * f64::from(x), 8005.0 + 10.0 * f64::from(y))
}

#[test]
fn sound_ground_has_no_faults() {
    assert_eq!(report(&ground).findings, []);
    // Nor has a plane of any slope, nor level ground.
    assert_eq!(report(&|x, y| 0.7 * f64::from(x) + 0.2 * f64::from(y)).findings, []);
    assert_eq!(report(&|_, _| 7.0).findings, []);
    assert_eq!(report(&ground).pages, 9);
}

#[test]
fn spikes_and_pits_are_found_also_beside_pages_and_each_other() {
    for (x, y) in [(300, 300), (255, 256), (256, 255), (5, 300)] {
        let spike = report(&move |i, j| ground(i, j) + if (i, j) == (x, y) { 60.0 } else { 0.0 });
        let found = only(&spike, Fault::Spike);
        assert_eq!(found.place, middle(x, y));
        assert!((40.0..80.0).contains(&found.size), "{found:?}");
        let pit = report(&move |i, j| ground(i, j) - if (i, j) == (x, y) { 60.0 } else { 0.0 });
        assert_eq!(only(&pit, Fault::Pit).place, middle(x, y));
    }
    let pair = report(&|i, j| ground(i, j) + if (i == 300 || i == 302) && j == 300 { 60.0 } else { 0.0 });
    assert_eq!(pair.count(Fault::Spike), 2);
}

#[test]
fn seams_are_found_along_columns_and_rows() {
    for line in [256, 311] {
        let column = report(&move |x, y| ground(x, y) + if x >= line { 9.0 } else { 0.0 });
        let found = only(&column, Fault::Seam);
        assert_eq!(found.extent[0].x, 5000.0 + 10.0 * f64::from(line));
        assert_eq!(found.extent[0].x, found.extent[1].x);
        assert!(found.voxels >= 512 && (found.size - 9.0).abs() < 2.0, "{found:?}");
        let row = report(&move |x, y| ground(x, y) + if y >= line { 9.0 } else { 0.0 });
        assert_eq!(only(&row, Fault::Seam).extent[1].y, 8000.0 + 10.0 * f64::from(line));
    }
    // Nor is the foot of an even slope, wherever between columns it lies.
    for share in [0.0, 0.1, 0.2, 0.25, 0.3, 0.5] {
        let foot = report(&move |x, _| 300.0 - 4.0 * (300.0 + share - f64::from(x)).max(0.0));
        assert_eq!(foot.count(Fault::Seam), 0, "{share}: {:?}", foot.findings);
    }
    // A wall is none.
    let wall = report(&|x, y| ground(x, y) + if x == 300 { 6.0 } else { 0.0 });
    assert_eq!(wall.count(Fault::Seam), 0);
}

#[test]
fn tops_that_were_cut_off_are_found_once() {
    let cone = |x: u32, y: u32| 600.0 - 8.0 * (DVec2::new(f64::from(x), f64::from(y)) - 255.5).length();
    assert_eq!(report(&cone).count(Fault::FlatTop), 0);
    // Across four pages.
    let cut = report(&move |x, y| cone(x, y).min(500.0));
    let found = cut.findings.iter().find(|finding| finding.fault == Fault::FlatTop).copied().unwrap();
    assert_eq!(cut.count(Fault::FlatTop), 1);
    assert!((found.voxels as f64 / (std::f64::consts::PI * 12.5 * 12.5) - 1.0).abs() < 0.05, "{found:?}");
    assert!((found.height - 500.0).abs() < 0.1);
    // A lake in a bowl, and level ground up to the edge, are none.
    assert_eq!(report(&move |x, y| (1200.0 - cone(x, y)).max(700.0)).count(Fault::FlatTop), 0);
}

#[test]
fn slopes_of_few_heights_are_terraces() {
    let slope = |x: u32, y: u32| 100.0 + 0.3 * f64::from(x) + 0.1 * f64::from(y);
    assert_eq!(report(&slope).count(Fault::Terrace), 0);
    let terraces = report(&move |x, y| (slope(x, y) / 4.0).round() * 4.0);
    // All blocks, but for small ones in the corner.
    assert!((96..=100).contains(&terraces.count(Fault::Terrace)), "{}", terraces.count(Fault::Terrace));
    let worst = terraces.findings.iter().find(|finding| finding.fault == Fault::Terrace).unwrap();
    assert!((worst.size - 4.0).abs() < 0.01);
    // A lake before mountains is none.
    let lake = report(&|x, y| ground(x, y).max(520.0));
    assert_eq!(lake.count(Fault::Terrace), 0);
}

#[test]
fn voids_are_holes_unless_they_are_the_end_of_the_data() {
    let holed = report(&|x, y| {
        let is_hole = (250..262).contains(&x) && (100..110).contains(&y);
        if is_hole || x + y < 100 { f64::NAN } else { ground(x, y) }
    });
    let found = only(&holed, Fault::Void);
    assert_eq!((found.voxels, holed.ends), (120, 1));
    assert_eq!(found.extent, [DVec2::new(7500.0, 9000.0), DVec2::new(7620.0, 9100.0)]);
    assert!(found.height.is_nan() && (found.size - 120.0_f64.sqrt() * 10.0).abs() < 1e-6);
}

/// An area, one page of which says something else of its neighbours.
struct Cracked {
    pages: MemPages,
    id: PageId,
    heights: Vec<u16>,
}

impl PageSource for Cracked {
    fn header(&self) -> &Header {
        self.pages.header()
    }

    fn page(&self, id: PageId) -> Result<Option<PageView<'_>>> {
        self.pages.page(id)
    }

    fn bounds(&self, id: PageId) -> Result<Option<BoundsView<'_>>> {
        self.pages.bounds(id)
    }

    fn heights(&self, id: PageId) -> Result<Option<HeightsView<'_>>> {
        let own = |view: HeightsView<'_>| HeightsView { heights: &self.heights, ..view };
        let view = self.pages.heights(id)?;
        Ok(if id == self.id { view.map(own) } else { view })
    }
}

#[test]
fn cracks_are_where_a_page_disagrees_with_its_neighbour() {
    let pages = area(&ground);
    let id = PageId { level: 0, px: 1, py: 0 };
    let mut heights = pages.heights(id).unwrap().unwrap().heights.to_vec();
    let scale = pages.header().heights.scale;
    // Beside its western edge, in the apron: row 40 of its own.
    let stride = (PAGE_SIDE + 2 * APRON) as usize;
    let at = (40 + APRON as usize) * stride + APRON as usize - 1;
    heights[at] += 9;
    heights[at + stride] += 5;
    let found = continuity(&Cracked { pages, id, heights }, &ContinuityLimits::default(), &Silent).unwrap();
    let crack = only(&found, Fault::Crack);
    assert!((crack.size - 9.0 * scale).abs() < 1.0e-9 && crack.voxels == 2, "{crack:?}");
    assert_eq!(crack.place, middle(255, 40));
}

#[test]
fn limits_are_factors() {
    let area = area(&|_, _| 1.0);
    for wrong in [0.0, 1.0, f64::NAN, f64::INFINITY] {
        let limits = ContinuityLimits { spike: wrong, ..ContinuityLimits::default() };
        assert!(continuity(&area, &limits, &Silent).is_err());
    }
}
