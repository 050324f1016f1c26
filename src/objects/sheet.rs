//! Triangles of meshes before a square of pixels.
//!
//! On planar and orthographic screens positions are linear in homogeneous coordinates, so that a square asks a mesh once; on others each pixel does.

use std::ops::Range;

use glam::{DVec2, Vec3};

use super::body::{PlacedBody, SeenForm};
use super::lens::Lens;
use super::mesh::{Facet, Mesh, PixelBounds};
use super::ray_coverage::{MeshItem, MeshPatch, Pencil};
use crate::space::Footprint;

/// Pixels from the middle of a pixel to its sides.
const HALF: f32 = 0.5;

/// Meshes before a square.
#[derive(Debug, Default)]
pub(super) struct Sheets {
    /// On screens where they serve all of a square.
    known: Vec<Sheet>,
    /// Facets of the pixel that is looked at, around its middle.
    pub facets: Vec<Facet>,
}

/// A mesh before several pixels.
#[derive(Debug)]
struct Sheet {
    id: u32,
    middle: DVec2,
    /// Way at which the facets' own begin.
    begin: f32,
    /// Length of the ray through the middle as the lens gives it.
    length: f64,
    facets: Vec<Facet>,
    /// The row of pixels that was asked for last, and the facets that may be in it, by index.
    row: f32,
    in_row: Vec<u32>,
}

impl Sheet {
    /// `body` before pixels up to `reach` from a position of the screen.
    fn new(lens: &Lens<'_>, body: &PlacedBody, mesh: &Mesh, middle: DVec2, reach: [f32; 2]) -> Option<Self> {
        let mut facets = Vec::new();
        let length = lens.line(middle)?.direction.length();
        let basis = Pencil::new(lens, middle)?.basis(body, body.middle())?;
        let bounds = PixelBounds { low: reach.map(|reach| -reach), high: reach };
        mesh.before(&basis, &bounds, &mut facets);
        Some(Self {
            id: body.id,
            middle,
            begin: basis.begin,
            length,
            facets,
            row: f32::NAN,
            in_row: Vec::new(),
        })
    }
}

impl Sheet {
    /// Finds what may be in the row of pixels around `y`, unless it is known.
    fn go_to(&mut self, y: f32) {
        if self.row == y {
            return;
        }
        self.row = y;
        self.in_row.clear();
        let is_in = |facet: &Facet| facet.bounds.low[1] <= y + HALF && facet.bounds.high[1] >= y - HALF;
        self.in_row.extend((0..).zip(&self.facets).filter(|(_, facet)| is_in(facet)).map(|(index, _)| index));
    }
}

impl Sheets {
    /// Returns what `pencil` at a position of the screen may meet of `body`, a pixel of the square of `columns` and `rows`; `None`: nothing.
    pub fn item<'b>(
        &mut self,
        lens: &Lens<'_>,
        square: [&Range<usize>; 2],
        pencil: &Pencil,
        place: DVec2,
        body: &'b PlacedBody,
    ) -> Option<MeshItem<'b>> {
        let mesh = match &body.sight {
            SeenForm::Shape(shape) => return Some(MeshItem::Shape(pencil.aim(body, *shape))),
            SeenForm::Mesh(mesh) => mesh,
        };
        let first = self.facets.len();

        let (begin, ratio) = if lens.is_straight() {
            let known = self.sheet(lens, square, body, mesh)?;
            let length = lens.line(place)?.direction.length();
            let sheet = &mut self.known[known];
            let [x, y] = (place - sheet.middle).to_array().map(|pixels| pixels as f32);
            let around = PixelBounds { low: [x - HALF, y - HALF], high: [x + HALF, y + HALF] };
            let (begin, ratio) = (sheet.begin, (length / sheet.length) as f32);
            sheet.go_to(y);
            let near = sheet.in_row.iter().map(|index| &sheet.facets[*index as usize]);
            let near = near.filter(|facet| facet.is_in(&around));
            self.facets.extend(near.map(|facet| facet.around(x, y)));
            (begin, ratio)
        } else {
            let basis = pencil.basis(body, body.middle())?;
            let around = PixelBounds { low: [-HALF; 2], high: [HALF; 2] };
            mesh.before(&basis, &around, &mut self.facets);
            (basis.begin, 1.0)
        };

        let facets = first..self.facets.len();
        let footprint = match lens.camera.footprint() {
            Footprint::Angle(angle) => [angle as f32, 0.0],
            Footprint::Width(width) => [0.0, width as f32],
        };
        let patch = MeshPatch {
            mesh,
            facets,
            begin,
            ratio,
            footprint,
            albedo: body.albedo,
            axes: body.axes(),
            higher: 0,
        };

        (!patch.facets.is_empty()).then_some(MeshItem::Mesh(patch))
    }

    /// Index of a body's sheet.
    fn sheet(
        &mut self,
        lens: &Lens<'_>,
        [columns, rows]: [&Range<usize>; 2],
        body: &PlacedBody,
        mesh: &Mesh,
    ) -> Option<usize> {
        if let Some(known) = self.known.iter().position(|sheet| sheet.id == body.id) {
            return Some(known);
        }
        let half = |range: &Range<usize>| 0.5 * range.len() as f64;
        let middle = DVec2::new(columns.start as f64 + half(columns), rows.start as f64 + half(rows));
        let reach = [half(columns) as f32, half(rows) as f32];
        self.known.push(Sheet::new(lens, body, mesh, middle, reach)?);
        Some(self.known.len() - 1)
    }
}

/// Whether two faces of a mesh look alike: what of them is in a pixel then hardly matters.
pub(super) fn are_alike(patch: &MeshPatch<'_>, a: &Facet, b: &Facet) -> bool {
    let of = |facet: &Facet| {
        let triangle = patch.mesh.triangle_at(facet.triangle);
        let normal: Vec3 = if facet.is_behind { -triangle.normal } else { triangle.normal };
        (triangle, normal)
    };
    let ((first, one), (second, other)) = (of(a), of(b));
    if one.dot(other) < super::ray_coverage::ONE_FACE {
        return false;
    }
    if first.varies || second.varies {
        return first.varies && second.varies && first.material == second.material;
    }
    first.material == second.material && (first.colour - second.colour).abs().max_element() < 1.0 / 128.0
}
