//! Level ground with pillars, for tests of questions about what stands on it.

use std::collections::BTreeMap;

use glam::DVec2;

use hedgehop::voxel::{
    Arrays, Cut, Facade, Grid, HeightCode, MemPages, Metadata, SharedObjects, Span, SpanArrays,
    build_standing,
};

/// Voxels along the area's side, and the side of one, metres.
const SIDE: u32 = 320;
const SPACING: f64 = 2.0;

/// Steps of 1 mm from 10 m below the datum on.
pub const CODE: HeightCode = HeightCode { scale: 1.0e-3, offset: -10.0 };

/// Makes an opaque span on the ground, its upper end `high` metres high.
pub fn pillar(high: f64) -> Span {
    Span {
        low: Span::GROUND,
        high: CODE.encode(high),
        slope: [0, 0],
        cuts: [Cut::NONE; 3],
        top: [200, 60, 50],
        state: Span::OPAQUE,
        side: [220, 210, 190],
        material: 2,
        facade: Facade::NONE,
    }
}

/// Builds level ground at 0 m with spans; the surface is their highest upper end.
pub fn standing(spans_of: impl Fn(u32, u32) -> Vec<Span>) -> MemPages {
    let grid = Grid { nx: SIDE, ny: SIDE, spacing: SPACING, origin: DVec2::new(1000.0, 2000.0) };
    let voxels = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let spans: BTreeMap<_, _> =
        voxels().map(|at| (at, spans_of(at.0, at.1))).filter(|(_, spans)| !spans.is_empty()).collect();

    let ground = vec![0.0; voxels().count()];
    let top = |at: (u32, u32)| spans.get(&at).into_iter().flatten().map(|span| span.high).max();
    let heights: Vec<f64> =
        voxels().map(|at| top(at).and_then(|code| CODE.decode(code)).unwrap_or(0.0).max(0.0)).collect();

    let grass = vec![[80, 120, 60]; ground.len()];
    let arrays = Arrays { grid, heights: &heights, colours: &grass, attributes: None };
    let standing = SpanArrays {
        heights: &ground,
        colours: &grass,
        spans: &spans,
        objects: &SharedObjects::default(),
        placed: &[],
        code: CODE,
    };

    build_standing(&arrays, &standing, &Metadata::default()).unwrap()
}
