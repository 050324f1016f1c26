//! A cloud of a real surface: what a drone's photographs make.

use std::path::Path;

use glam::{DVec2, dvec2};

use super::scene::{CORNER, Mark, database, ground, options, top, write};
use hedgehop::memory::PageFile;
use hedgehop::voxel::PageSource;
use hedgehop_modeling::BuildOptions;
use hedgehop_testing::realdata;

/// Heights of a real surface in columns and rows from its south-west corner, metres; NaN where there is none.
struct Surface {
    columns: usize,
    rows: usize,
    spacing: f64,
    heights: Vec<f64>,
}

impl Surface {
    fn read(data: &Path, folder: &Path) -> Self {
        let raster = data.join("odm_drone_dsm/dsm.tif");
        let mut options = BuildOptions::new(vec![raster], Vec::new(), folder.join("raster.hop"));
        options.local = false;
        let pages = database(&options);
        let grid = pages.header().grid;
        let (columns, rows, spacing) = (grid.nx as usize, grid.ny as usize, grid.spacing);
        let mut surface = Self { columns, rows, spacing, heights: Vec::new() };
        let places = (0..columns * rows).map(|index| grid.origin - CORNER + surface.place(index));
        surface.heights = places.map(|place| ground(&pages, place).unwrap_or(f64::NAN)).collect();
        surface
    }

    /// Middle of a voxel, metres from the corner.
    fn place(&self, index: usize) -> DVec2 {
        self.spacing * (dvec2((index % self.columns) as f64, (index / self.columns) as f64) + 0.5)
    }

    /// Its bare ground, roughly: the surface without what is narrower than `2 * reach` voxels (an opening, of columns and rows).
    fn bare(&self, reach: usize) -> Vec<f64> {
        let mut heights = self.heights.clone();
        for (pick, none) in [(f64::min as fn(f64, f64) -> f64, f64::INFINITY), (f64::max, f64::NEG_INFINITY)]
        {
            for [length, step, lines, stride] in
                [[self.columns, 1, self.rows, self.columns], [self.rows, self.columns, self.columns, 1]]
            {
                let before = heights.clone();
                for (line, at) in (0..lines).flat_map(|line| (0..length).map(move |at| (line, at))) {
                    let about = at.saturating_sub(reach)..length.min(at + reach + 1);
                    let near = about.map(|other| before[line * stride + other * step]);
                    heights[line * stride + at * step] =
                        near.filter(|height| height.is_finite()).fold(none, pick);
                }
            }
        }
        heights
    }

    /// A point in the middle of each voxel, in a system of which nothing but metres is needed.
    fn marks(&self, class: impl Fn(usize) -> u8) -> Vec<Mark> {
        let whole = self.heights.iter().enumerate().filter(|(_, height)| height.is_finite());
        whole.map(|(index, height)| (self.place(index).extend(*height), class(index), [0; 3])).collect()
    }

    fn cloud(&self, folder: &Path, marks: &[Mark]) -> PageFile {
        let cloud = folder.join("dsm.laz");
        write(&cloud, 0, marks);
        let mut from_cloud = options(&cloud, folder.join("cloud.hop"));
        (from_cloud.spacing, from_cloud.overwrite) = (Some(self.spacing), true);
        database(&from_cloud)
    }
}

#[test]
fn a_surface_of_points_is_that_of_its_raster() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let surface = Surface::read(&data, folder.path());

    // Never classified, and unclassified.
    for class in [0, 1] {
        let marks = surface.marks(|_| class);
        assert!(marks.len() > 100_000);
        let points = surface.cloud(folder.path(), &marks);
        let (mut off, mut count): (f64, f64) = (0.0, 0.0);

        for (place, ..) in marks.iter().step_by(7) {
            assert_eq!(top(&points, place.truncate()), None, "nothing stands on a surface");
            if let Some(height) = ground(&points, place.truncate()) {
                let far = (height - place.z).abs();
                assert!(far < 0.6, "{place}: {height}");
                off += far;
                count += 1.0;
            }
        }

        assert!(count > 0.99 * marks.len() as f64 / 7.0, "{count}");
        let mean = off / count;
        assert!(mean < 0.02, "heights are {mean} m off");
    }
}

/// Where houses stand, metres from the corner: west, south, east, north.
const HOUSES: [[f64; 4]; 3] =
    [[62.7, 220.9, 94.7, 253.9], [189.7, 201.9, 226.7, 261.9], [31.7, 192.9, 53.7, 228.9]];

#[test]
fn houses_and_trees_of_a_real_surface_stand_on_its_ground() {
    let Some(data) = realdata() else { return };
    let folder = tempfile::tempdir().unwrap();
    let surface = Surface::read(&data, folder.path());
    let bare = surface.bare(24);

    let class = |index: usize| {
        let (place, high) = (surface.place(index), surface.heights[index] - bare[index]);
        let is_in = |[west, south, east, north]: &[f64; 4]| {
            place.x > *west && place.x < *east && place.y > *south && place.y < *north
        };
        match high {
            _ if high < 1.0 => 2,
            _ if high > 2.5 && HOUSES.iter().any(is_in) => 6,
            _ => 5,
        }
    };

    let marks = surface.marks(class);
    let pages = surface.cloud(folder.path(), &marks);

    // By class: points, those with something standing there, the sum of how far its top is off, and the sum of how high it stands.
    let mut tallies = [(0.0, 0.0, 0.0, 0.0); 7];
    for index in (0..surface.heights.len()).step_by(3).filter(|index| surface.heights[*index].is_finite()) {
        let (place, own) = (surface.place(index), class(index));
        let [x, y] = [index % surface.columns, index / surface.columns];
        if x < 3 || y < 3 || x + 3 >= surface.columns || y + 3 >= surface.rows {
            continue;
        }

        let about = (0..25).map(|near| (y + near / 5 - 2) * surface.columns + x + near % 5 - 2);
        if about.into_iter().any(|near| surface.heights[near].is_nan() || class(near) != own) {
            continue;
        }

        let tally = &mut tallies[usize::from(own)];
        tally.0 += 1.0;
        let ground = ground(&pages, place).unwrap();

        // An opening is no survey: slopes are steeper than what it leaves of them.
        assert!(
            own == 5 || (ground - bare[index]).abs() < 3.0,
            "{place}: the ground of class {own} lies at {ground}"
        );

        if let Some(top) = top(&pages, place) {
            tally.1 += 1.0;
            tally.2 += (top - surface.heights[index]).abs();
            tally.3 += top - ground;
        }
    }

    let [.., ground, _, _, trees, houses] = tallies;
    assert!(ground.0 > 10_000.0 && ground.1 == 0.0, "{ground:?}");
    assert!(trees.0 > 10_000.0 && trees.1 > 0.95 * trees.0 && trees.2 < 0.25 * trees.1, "{trees:?}");
    assert!(trees.3 > 2.0 * trees.1, "trees stand {} m high in the mean", trees.3 / trees.1);
    assert!(houses.0 > 500.0 && houses.1 == houses.0 && houses.2 < 0.1 * houses.1, "{houses:?}");
    assert!(houses.3 > 6.0 * houses.1, "houses stand {} m high in the mean", houses.3 / houses.1);
}
