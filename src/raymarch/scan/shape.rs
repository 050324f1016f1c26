//! The two kinds of plane images.

use std::ops::Range;

use glam::DVec3;

use super::{Panorama, PlaneGroup, RowTable, Upright};
use crate::raymarch::scan::panorama::MOST_WORDS;
use crate::simd::{LANES, Sixteen};
use crate::voxel::Grid;

/// Arrangement of planes and rows before a screen.
#[derive(Debug, Clone)]
pub enum PlaneArray {
    /// Along a planar screen, turned upright.
    Upright(Upright),
    /// At equal steps of azimuth and elevation.
    Panorama(Panorama),
}

/// A group of planes in a plane image's memory.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptPlanes {
    /// Rows that it has there.
    pub rows: usize,
    /// Planes of the group that are filled; others are of no interest.
    pub filled: Range<usize>,
    /// Index of the first filled one among all [rows](PlaneArray::row_table).
    pub first: usize,
}

impl PlaneArray {
    /// Groups of sixteen planes.
    pub fn groups(&self) -> usize {
        match self {
            Self::Upright(upright) => upright.groups(),
            Self::Panorama(panorama) => panorama.groups(),
        }
    }

    /// Whether a plane image has room for it.
    pub fn fits(&self) -> bool {
        let rows = match self {
            Self::Upright(upright) => upright.size[1].saturating_mul(upright.groups()),
            Self::Panorama(panorama) => panorama.all_rows(),
        };
        rows < MOST_WORDS / LANES
    }

    /// Builds the table of all rows that some group has, by tangents of elevation times ground distance per depth.
    pub fn row_table(&self) -> RowTable {
        let (edges, centres) = match self {
            Self::Upright(upright) => (upright.edges(), upright.centres()),
            Self::Panorama(panorama) => (panorama.edges(), panorama.centres()),
        };
        let coordinate = match self {
            Self::Upright(upright) => upright.row_coordinate(&edges),
            Self::Panorama(panorama) => panorama.row_coordinate(&edges),
        };
        RowTable::new(edges, centres, coordinate)
    }

    /// Returns the part that is kept of a group.
    pub fn kept(&self, index: usize) -> KeptPlanes {
        match self {
            Self::Upright(upright) => {
                let filled = upright.rows(index);
                KeptPlanes { rows: upright.size[1], first: filled.start, filled }
            }
            Self::Panorama(panorama) => {
                let rows = panorama.rows(index);
                let first = rows.start - panorama.extent().start;
                KeptPlanes { rows: rows.len(), filled: 0..rows.len(), first }
            }
        }
    }

    /// The planes of a group, from `eye` (units).
    pub fn group(&self, index: usize, grid: &Grid, eye: DVec3, inverse_diameter: f64) -> PlaneGroup {
        match self {
            Self::Upright(upright) => upright.group(index, grid, eye, inverse_diameter),
            Self::Panorama(panorama) => panorama.group(index, grid, eye, inverse_diameter),
        }
    }

    /// Squared ground distance per squared depth of the planes of a group.
    pub fn squares(&self, index: usize) -> [f32; LANES] {
        match self {
            Self::Upright(upright) => upright.squares(index),
            Self::Panorama(_) => [1.0; LANES],
        }
    }

    /// Angle that a plane of a group stands for, seen along the ground, radians: to the next one, and not less than the screen's
    /// `pixel_angle`.
    pub fn plane_angle(&self, index: usize, pixel_angle: f64) -> f64 {
        match self {
            Self::Upright(_) => pixel_angle,
            Self::Panorama(panorama) => panorama.plane_angle(index).max(pixel_angle),
        }
    }

    /// Makes of a group's inverse depths what the image stage interpolates, and of how they go on (to the next plane, and per unit of the tangent; empty
    /// if all is ground) what leads to the next plane and to the next row.
    pub fn finish(&self, index: usize, inverse: &mut [Sixteen], tilts: [&mut [Sixteen]; 2]) {
        match self {
            Self::Upright(upright) => upright.per_row(index, tilts),
            Self::Panorama(panorama) => panorama.to_ranges(index, inverse, tilts),
        }
    }
}
