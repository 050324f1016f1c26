//! Displacement of the ground between the finest posts: bumps and hollows of the pattern, as high as materials let them be.
//!
//! ```text
//! m      = √(ground distance² + height above the ground²)                      voxels
//! width  = m · angle of a pixel
//! fading = 1 up to half of the end, 0 at the end                                linear in m
//! height = bilinear + reach(material) · fading · mean of heights over a square as wide as a pixel
//! ```
//!
//! All of it depends on the place alone for one eye: the surface has one height everywhere, which does not depend on who looks at it, so that range coherence stays exact. Heights are
//! at most 1, and so is their mean: bounds of the surface are wrong by no more than the greatest reach times fading.

use std::sync::Arc;

use glam::DVec2;
use hedgehop_texture::{CELLS_PER_VOXEL, MicroRelief};

use super::ground_tile::GroundTile;
use super::measure::{CLASSES, classes_named};
use crate::simd::{Floats, Simd};
use crate::voxel::{DetailRecord, Header};
use hedgehop_base::error::Result;

/// Cells of the tile per voxel.
const CELLS: f64 = CELLS_PER_VOXEL as f64;

/// Room of bounds for rounding of single precision, relative.
const ROOM: f64 = 1.0e-3;

/// Relief that displaces the ground of a database, whoever looks at it.
#[derive(Debug)]
pub struct DisplacedRelief {
    /// Heights, and the unit in which none is beyond ±1.
    tile: GroundTile,
    unit: f64,
    /// Greatest displacement by the number of a class of material, metres.
    reaches: [f32; CLASSES],
    /// Greatest of them.
    most: f32,
}

/// View in which ground is displaced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplacementView {
    /// The eye, units from the area's south-west corner.
    pub eye: DVec2,
    /// Its height above the ground about it, units.
    pub above: f64,
    /// Angle of a pixel, radians.
    pub pixel: f64,
    /// Distance at which nothing is left of it, units.
    pub end: f64,
}

/// Displacement of the ground as one view sees it.
#[derive(Debug, Clone)]
pub struct Displacement {
    relief: Arc<DisplacedRelief>,
    view: DisplacementView,
    /// Ground distance up to which there is some, units.
    until: f64,
}

impl DisplacedRelief {
    /// Makes the relief of a database, `factor` times as high; `None`: its ground lies as its posts say.
    ///
    /// # Errors
    /// The pattern that the database asks for has nothing below the voxel.
    pub fn of(header: &Header, factor: f64) -> Result<Option<Self>> {
        let Some(record) = &header.metadata.detail else { return Ok(None) };
        let DetailRecord { pattern, seed, displacement, displacements, .. } = record;
        let mut reaches = [(factor * displacement) as f32; CLASSES];
        for (name, metres) in displacements {
            classes_named(&header.metadata, name).for_each(|class| reaches[class] = (factor * metres) as f32);
        }
        let most = reaches.iter().fold(0.0_f32, |most, reach| most.max(*reach));
        if most == 0.0 {
            return Ok(None);
        }

        let tile = GroundTile::of(&MicroRelief::new(pattern.cells(*seed)?).heights())?;
        let unit = tile.peak().recip();
        Ok(Some(Self { tile, unit, reaches, most }))
    }

    /// Greatest displacement of a class of material by its number, metres.
    pub fn reach(&self, class: u8) -> f32 {
        self.reaches[usize::from(class)]
    }

    /// Greatest displacement of all classes, metres.
    pub fn most(&self) -> f32 {
        self.most
    }
}

impl Displacement {
    /// Displacement in a view; `None`: all ground is too far away for it.
    pub fn new(relief: Arc<DisplacedRelief>, view: DisplacementView) -> Option<Self> {
        let square = view.end * view.end - view.above * view.above;
        (view.above >= 0.0 && square > 0.0).then(|| Self { relief, view, until: square.sqrt() })
    }

    /// The relief.
    pub fn relief(&self) -> &DisplacedRelief {
        &self.relief
    }

    /// The eye, units.
    pub fn eye(&self) -> DVec2 {
        self.view.eye
    }

    /// Ground distance up to which ground is displaced, units.
    pub fn until(&self) -> f64 {
        self.until
    }

    /// Bound of displacements, up or down, at a ground distance (units) or beyond, metres.
    pub fn bound(&self, distance: f64) -> f64 {
        if distance >= self.until {
            return 0.0;
        }
        f64::from(self.relief.most) * self.fading(distance.hypot(self.view.above)) * (1.0 + ROOM)
    }

    /// Displacement of ground of a reach in metres, at a place in units, metres.
    pub fn height(&self, place: DVec2, reach: f64) -> f64 {
        let distance = place.distance(self.view.eye).hypot(self.view.above);
        let fading = self.fading(distance);
        if fading == 0.0 {
            return 0.0;
        }
        let width = DVec2::splat(distance * self.view.pixel);
        reach * fading * self.relief.unit * self.relief.tile.mean(0.0, place, width)
    }

    /// Shares of their reach by which ground is displaced, at places in cells from a corner of the tile and squared ground distances in squared units.
    #[inline(always)]
    pub fn shares<V: Simd>(&self, simd: V, places: [V::F; 2], squares: V::F) -> V::F {
        let DisplacementView { above, pixel, end, .. } = self.view;
        let squares = squares + simd.splat((above * above) as f32);
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let fading = squares.sqrt().neg_mul_add(simd.splat((2.0 / end) as f32), simd.splat(2.0));
        let width = squares * simd.splat((pixel * CELLS).powi(2) as f32);
        let mean = self.relief.tile.means(simd, simd.splat(0.0), places, [width; 2]);
        mean * simd.splat(self.relief.unit as f32) * fading.max(zero).min(one)
    }

    /// Width of the finest bumps at a ground distance, both in units.
    pub fn grain(&self, distance: f64) -> f64 {
        CELLS.recip().hypot(distance.hypot(self.view.above) * self.view.pixel)
    }

    /// Share of their reach that displacements have at a distance from the eye, units.
    fn fading(&self, distance: f64) -> f64 {
        (2.0 - 2.0 * distance / self.view.end).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::simd::{Isa, Kernel, LANES, Sixteen};
    use crate::voxel::{Grid, MemPages, Metadata, PageSource, build_in_memory};

    /// Level ground whose materials have reaches of 0.25 m, and 2 m of grass.
    fn ground() -> MemPages {
        let grid = Grid { nx: 32, ny: 32, spacing: 0.5, origin: DVec2::ZERO };
        let detail = DetailRecord {
            displacement: 0.25,
            displacements: BTreeMap::from([("grass".to_owned(), 2.0)]),
            ..DetailRecord::default()
        };
        let metadata = Metadata { detail: Some(detail), ..Metadata::default() };
        build_in_memory(grid, &[7.0; 1024], &[[99; 3]; 1024], None, &metadata).unwrap()
    }

    fn displacement(pixel: f64, end: f64) -> Displacement {
        let relief = DisplacedRelief::of(ground().header(), 1.0).unwrap().unwrap();
        let view = DisplacementView { eye: DVec2::new(5.3, -2.9), above: 3.0, pixel, end };
        Displacement::new(Arc::new(relief), view).unwrap()
    }

    /// Places about the eye, ever farther.
    fn places(displacement: &Displacement) -> impl Iterator<Item = DVec2> {
        let (eye, until) = (displacement.eye(), displacement.until());
        (0..40_000).map(move |index| {
            let index = f64::from(index);
            eye + DVec2::from_angle(index * 2.399_963) * (index / 40_000.0 * 1.1 * until)
        })
    }

    /// Shares at sixteen places.
    struct SharesAt<'d>(&'d Displacement, [DVec2; LANES]);

    impl Kernel for SharesAt<'_> {
        type Output = [f32; LANES];

        fn run<V: Simd>(self, simd: V) -> Self::Output {
            let Self(displacement, places) = self;
            let axis = |axis: usize| places.map(|place| (place[axis] * CELLS) as f32);
            let squares = places.map(|place| place.distance_squared(displacement.eye()) as f32);
            let cells = [simd.load(&axis(0)), simd.load(&axis(1))];
            let mut shares = Sixteen::default();
            displacement.shares(simd, cells, simd.load(&squares)).store(&mut shares.0);
            shares.0
        }
    }

    #[test]
    fn bounds_hold_in_both_precisions() {
        let displacement = displacement(1.0e-3, 200.0);
        let places: Vec<_> = places(&displacement).collect();
        let (mut highest, mut farthest) = (0.0_f64, 0.0_f64);
        for chunk in places.chunks_exact(LANES) {
            let chunk: &[DVec2; LANES] = chunk.try_into().unwrap();
            let shares = Isa::best().run(SharesAt(&displacement, *chunk));
            for (place, share) in chunk.iter().zip(shares) {
                let exact = displacement.height(*place, 2.0);
                let bound = displacement.bound(place.distance(displacement.eye()));
                assert!(
                    exact.abs() <= bound && f64::from(share.abs()) * 2.0 <= bound,
                    "{place}: {exact} {share}"
                );
                highest = highest.max(exact);
                farthest = farthest.max((exact - 2.0 * f64::from(share)).abs());
            }
        }
        assert!(highest > 1.6 && farthest < 3e-3, "up to {highest} m, and {farthest} m apart");
        assert_eq!(displacement.bound(displacement.until()), 0.0);
    }

    #[test]
    fn voxels_keep_their_means() {
        // Pixels next to nothing wide, at half of the end and nearer.
        let displacement = displacement(1.0e-9, 1.0e6);
        let side = CELLS_PER_VOXEL;
        for voxel in (0..400).map(|index| DVec2::new(f64::from(index % 20), f64::from(index / 20))) {
            let cells = (0..side * side)
                .map(|cell| (DVec2::new((cell % side) as f64, (cell / side) as f64) + 0.5) / CELLS);
            let heights: Vec<_> = cells.map(|cell| displacement.height(voxel + cell, 1.0)).collect();
            let mean = heights.iter().sum::<f64>() / heights.len() as f64;
            assert!(mean.abs() < 1e-6 && heights.iter().any(|height| height.abs() > 0.1), "{voxel}: {mean}");
        }
    }

    #[test]
    fn databases_say_how_far() {
        let pages = ground();
        let relief = DisplacedRelief::of(pages.header(), 0.5).unwrap().unwrap();
        assert_eq!((relief.reach(14), relief.reach(2), relief.most()), (1.0, 0.125, 1.0));
        assert!(DisplacedRelief::of(pages.header(), 0.0).unwrap().is_none());

        let mut header = pages.header().clone();
        header.metadata.detail = Some(DetailRecord::default());
        assert!(DisplacedRelief::of(&header, 1.0).unwrap().is_none());

        // From as high as displacement ends there is none.
        let view = DisplacementView { eye: DVec2::ZERO, above: 80.0, pixel: 1e-3, end: 80.0 };
        assert!(Displacement::new(Arc::new(relief), view).is_none());
    }
}
