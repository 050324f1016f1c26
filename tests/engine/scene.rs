//! Small worlds from functions, and views of them.

use glam::{DVec2, DVec3};
use hedgehop::render::RenderOptions;
use hedgehop::space::{Attitude, Camera, Pose};
use hedgehop::voxel::{Grid, MemPages, Metadata, build_in_memory};

/// Where the worlds lie: far from the origin, as georeferenced areas do.
pub const ORIGIN: DVec2 = DVec2::new(500_000.0, 4_000_000.0);

/// Posts of a world, and its grid.
pub struct Terrain {
    pub grid: Grid,
    pub heights: Vec<f64>,
    pub colours: Vec<[u8; 3]>,
}

impl Terrain {
    /// `count` voxels each way of `spacing` metres. Height (metres) and colour are functions of the post's
    /// distance (east, north) in metres from the south-west corner.
    pub fn new(
        count: [u32; 2],
        spacing: f64,
        height: impl Fn(DVec2) -> f64,
        colour: impl Fn(DVec2) -> [u8; 3],
    ) -> Self {
        let [nx, ny] = count;
        let grid = Grid { nx, ny, spacing, origin: ORIGIN };
        let posts = || {
            (0..ny).flat_map(move |y| {
                (0..nx).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * spacing)
            })
        };
        Self { grid, heights: posts().map(height).collect(), colours: posts().map(colour).collect() }
    }

    pub fn in_memory(&self) -> MemPages {
        self.described(&Metadata::default())
    }

    /// The same with metadata of its own.
    pub fn described(&self, metadata: &Metadata) -> MemPages {
        build_in_memory(self.grid, &self.heights, &self.colours, None, metadata).unwrap()
    }
}

/// An eye and its screen. Positions are metres from the area's south-west corner.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub eye: DVec3,
    /// Yaw, pitch, roll, degrees.
    pub ypr: [f64; 3],
    /// Degrees.
    pub hfov: f64,
    /// Width, height, pixels.
    pub size: [u32; 2],
}

impl View {
    pub fn camera(&self) -> Camera {
        let [yaw, pitch, roll] = self.ypr;
        let attitude = Attitude { yaw, pitch, roll };
        let eye = self.eye + ORIGIN.extend(0.0);
        Camera::new(Pose { eye, attitude, hfov: self.hfov }, self.size[0], self.size[1])
    }
}

/// The command's default look but without haze, so that colours are the ground's own.
pub fn clear_air() -> RenderOptions {
    RenderOptions { visibility: f64::INFINITY, ..RenderOptions::default() }
}
