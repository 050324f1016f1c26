//! The rasters of a build, placed in the database's grid.

use super::footprint::{Bounds, RasterFootprint};
use super::kernel::Samples;
use super::plan::Plan;
use super::synthetic::Lattice;
use super::vertical::Shift;
use super::warp::RasterPlacement;
use crate::opened::Opened;
use hedgehop::Size;
use hedgehop_base::error::{Error, Result};
use hedgehop_geo::{Transform, VerticalDatum};

/// An elevation raster, placed in the database's grid.
pub(super) struct ElevationInput {
    pub samples: Box<dyn Samples<f64>>,
    /// Natural block for reading.
    pub block: Size,
    pub placement: RasterPlacement,
    /// Shift that brings its heights to the database's datum.
    pub shift: Shift,
    /// Side of a pixel at its centre, metres; infinite where that has no place in the database's system.
    pub pixel_side: f64,
    /// Lattice of its posts on the ground.
    pub lattice: Lattice,
    /// West, south, east, north of what it can reach, in the database's system; for quick rejection.
    pub reach: Bounds,
}

/// Imagery, placed in the database's grid.
pub(super) struct ImageryInput {
    pub samples: Box<dyn Samples<[u8; 4]>>,
    pub placement: RasterPlacement,
    /// Side of its pixels, as of elevation.
    pub pixel_side: f64,
    pub reach: Bounds,
}

impl ElevationInput {
    /// Places a raster in the grid, with heights above `datum`.
    pub fn place(raster: Opened<f64>, plan: &Plan, datum: VerticalDatum) -> Result<Self> {
        let (placement, reach) = raster.place(plan)?;
        let pixel_side = raster.pixel_side(&plan.crs)?.unwrap_or(f64::INFINITY);
        let shift = Shift::between(raster.datum, datum, &plan.grid, &plan.crs)?;
        let lattice = Lattice::of(&raster, raster.pixel_sides(&plan.crs)?);
        Ok(Self {
            samples: raster.samples,
            block: raster.block,
            placement,
            shift,
            pixel_side,
            lattice,
            reach,
        })
    }
}

impl ImageryInput {
    /// Places a raster in the grid.
    pub fn place(raster: Opened<[u8; 4]>, plan: &Plan) -> Result<Self> {
        let (placement, reach) = raster.place(plan)?;
        let pixel_side = raster.pixel_side(&plan.crs)?.unwrap_or(f64::INFINITY);
        Ok(Self { samples: raster.samples, placement, pixel_side, reach })
    }
}

impl<T> Opened<T> {
    /// Finds how it lies in the grid, and what it can reach.
    pub fn place(&self, plan: &Plan) -> Result<(RasterPlacement, Bounds)> {
        let size = self.samples.size();
        let placement = RasterPlacement::new(Transform::new(&plan.crs, &self.crs)?, &self.geo, size)
            .ok_or_else(|| Error::invalid(&self.path, "its geotransform maps the raster onto a line"))?;
        // Room for the curve between the points that bound it, and for kernels that hang over its edge.
        const ROOM: f64 = 0.05;
        let widest = plan.grid.side(plan.stored.outside());
        let room = |low: f64, high: f64| ROOM * (high - low) + 2.0 * widest;
        let everywhere = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
        let reach = match self.footprint(&plan.crs)? {
            RasterFootprint::Whole([west, south, east, north]) => {
                let (x, y) = (room(west, east), room(south, north));
                [west - x, south - y, east + x, north + y]
            }
            RasterFootprint::Partial(_) | RasterFootprint::Nowhere => everywhere,
        };
        Ok((placement, reach))
    }
}
