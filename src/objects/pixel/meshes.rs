//! Pixels in which meshes may be.
//!
//! ```text
//! triangles of each mesh that the pixel may hold; without any: as if the mesh were not there
//! one mesh alone: the nearest triangle that fills the pixel hides what is behind it
//!     all that is left looks alike, and fills the pixel → what its middle sees
//! else 96 rays, each to the nearest of bodies and ground → the share of each
//! ```

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::Looking;
use crate::objects::body::SeenForm;
use crate::objects::lens::Line;
use crate::objects::mesh::Facet;
use crate::objects::rank::{TIE, higher, limit};
use crate::objects::ray_coverage::{CountAll, MeshItem, MeshPatch, Pencil, Probe};
use crate::objects::sheet::are_alike;
use crate::objects::view::nearest;
use crate::objects::{BodyLight, Hit, PixelGround};
use crate::space::Ray;

/// Sample places of textures in pixels of one face, from the middle.
const PLACES: [Vec2; 4] =
    [Vec2::new(-0.25, -0.25), Vec2::new(0.25, -0.25), Vec2::new(-0.25, 0.25), Vec2::new(0.25, 0.25)];

/// Cosine of the angle at which a face is seen, below which its texture is filtered no farther.
const GRAZING: f32 = 0.05;

/// Hit of a pixel's middle on a mesh.
struct Middle {
    /// Index of the facet.
    facet: usize,
    /// Multiples of the pencil's direction.
    at: f32,
    weights: [f32; 3],
}

impl<'v> Looking<'v> {
    /// Returns what bodies add to a pixel that meshes are near to; `None`: no mesh is in it, and none is near any more.
    pub(super) fn with_meshes(
        &mut self,
        place: DVec2,
        middle: &Line,
        ground: &PixelGround,
        shade: impl Fn(&Hit, &Ray) -> Vec3,
    ) -> Option<Option<BodyLight>> {
        let lens = self.square.lens;
        let Some(pencil) = Pencil::new(&lens, place) else { return Some(None) };
        let square = [&self.square.columns, &self.square.rows];
        self.sheets.facets.clear();
        let mut items: Vec<MeshItem<'v>> = Vec::with_capacity(self.near.len());
        let sheets = &mut self.sheets;

        self.near.retain(|body| {
            let item = sheets.item(&lens, square, &pencil, place, body);
            let is_there = item.is_some();
            items.extend(item);
            is_there
        });
        if !items.iter().any(|item| matches!(item, MeshItem::Mesh(_))) {
            return None;
        }

        self.drop_hidden(&mut items);
        let ray = lens.ray(middle);
        if let [MeshItem::Mesh(patch)] = items.as_slice()
            && let Some(hit) = self.one_face(patch, &pencil, ground, ray.direction)
        {
            return Some(Some(BodyLight { share: 1.0, colour: shade(&hit, &ray), hit }));
        }

        for (index, item) in items.iter_mut().enumerate() {
            let higher = higher(&self.near, index);
            match item {
                MeshItem::Shape(aim) => aim.higher = higher,
                MeshItem::Mesh(patch) => patch.higher = higher,
            }
        }

        self.faces.clear();
        let facets = &self.sheets.facets;
        self.isa.run(CountAll { items: &items, facets, pencil: &pencil, ground, faces: &mut self.faces });
        let seen = self.sum(&ray, &shade);
        let own = self.nearest_of(&items, middle).filter(|hit| ground.shows(hit, DVec2::ZERO));

        Some(seen.map(|seen| match own {
            Some(hit) if hit.id == seen.hit.id => BodyLight { hit, ..seen },
            _ => seen,
        }))
    }

    /// Leaves out what lies behind a triangle that fills the pixel.
    fn drop_hidden(&mut self, items: &mut Vec<MeshItem<'v>>) {
        let patches = items.iter().filter_map(|item| match item {
            MeshItem::Mesh(patch) => Some(patch),
            MeshItem::Shape(_) => None,
        });
        let end = patches.map(|patch| self.end_of(patch)).fold(f32::INFINITY, f32::min);
        if end == f32::INFINITY {
            return;
        }

        // A surface that is hardly farther is seen if its priority is higher.
        let is_ranked = self.near.windows(2).any(|pair| pair[0].priority != pair[1].priority);
        let end = if is_ranked { end / (1.0 - TIE as f32) } else { end };
        let facets = &mut self.sheets.facets;
        let mut kept = 0;
        for item in items.iter_mut() {
            let MeshItem::Mesh(patch) = item else { continue };
            let first = kept;
            for number in patch.facets.clone() {
                if (facets[number].near + patch.begin) * patch.ratio <= end {
                    facets[kept] = facets[number];
                    kept += 1;
                }
            }
            patch.facets = first..kept;
        }

        facets.truncate(kept);
        let is_left = |item: &MeshItem<'_>| !matches!(item, MeshItem::Mesh(patch) if patch.facets.is_empty());
        let mut left = items.iter().map(is_left);
        self.near.retain(|_| left.next() == Some(true));
        items.retain(is_left);
    }

    /// Returns the end of the nearest triangle that fills the pixel, multiples of the pencil's direction; none: infinity.
    fn end_of(&self, patch: &MeshPatch<'_>) -> f32 {
        let filling = self.sheets.facets[patch.facets.clone()]
            .iter()
            .filter(|facet| facet.covers() && !patch.mesh.is_masked(patch.mesh.triangle_at(facet.triangle)));
        let ends = filling.filter_map(|facet| {
            let [from, to] = facet.ways().map(|way| (way + patch.begin) * patch.ratio);
            (from >= 0.0).then_some(to)
        });
        ends.fold(f32::INFINITY, f32::min)
    }

    /// Returns what the middle of a pixel sees of a mesh that fills it, and looks like one face there.
    fn one_face(
        &self,
        patch: &MeshPatch<'_>,
        pencil: &Pencil,
        ground: &PixelGround,
        direction: DVec3,
    ) -> Option<Hit> {
        let all = &self.sheets.facets[patch.facets.clone()];
        if all.iter().any(|facet| patch.mesh.is_masked(patch.mesh.triangle_at(facet.triangle))) {
            return None;
        }

        let middle = self.middle_of(patch)?;
        let own = &self.sheets.facets[middle.facet];
        let end = self.end_of(patch);
        let at = |way: f32| (way + patch.begin) * patch.ratio;
        let shown = all.iter().filter(|facet| at(facet.ways()[0]) <= end);
        let (mut is_alike, mut far) = (true, 0.0_f32);
        for facet in shown {
            is_alike = is_alike && are_alike(patch, own, facet);
            far = far.max(at(facet.far));
        }

        let far = f64::from(far.min(end));
        if !is_alike || far * ground.most() >= 1.0 {
            return None;
        }

        let is_full =
            end.is_finite() || self.isa.run(Probe { patch, facets: &self.sheets.facets, pencil, ground });
        is_full.then(|| self.hit(patch, &middle, direction))
    }

    /// Finds where the middle of a pixel meets a mesh.
    fn middle_of(&self, patch: &MeshPatch<'_>) -> Option<Middle> {
        let mut nearest: Option<Middle> = None;
        for (index, facet) in patch.facets.clone().zip(&self.sheets.facets[patch.facets.clone()]) {
            let Some((way, weights)) = facet.middle() else { continue };
            let at = (way + patch.begin) * patch.ratio;
            let triangle = patch.mesh.triangle_at(facet.triangle);
            let is_nearer = at >= 0.0 && nearest.as_ref().is_none_or(|middle| at < middle.at);
            if is_nearer
                && (!patch.mesh.is_masked(triangle)
                    || patch.mesh.is_there(triangle, weights, patch.metres(at)))
            {
                nearest = Some(Middle { facet: index, at, weights });
            }
        }
        nearest
    }

    /// The mesh as the middle of a pixel sees it, in the mean colour around it.
    fn hit(&self, patch: &MeshPatch<'_>, middle: &Middle, direction: DVec3) -> Hit {
        let facet: &Facet = &self.sheets.facets[middle.facet];
        let triangle = patch.mesh.triangle_at(facet.triangle);
        let normal = patch.turned(patch.mesh.normal(triangle, middle.weights, facet.is_behind));
        let slant = patch.turned(triangle.normal).dot(direction.as_vec3()).abs().max(GRAZING);
        // As far as a quarter of the pixel reaches on the surface, in the mean of both ways.
        let metres = 0.5 * patch.metres(middle.at) / slant.sqrt();
        let colour = |weights, metres| patch.mesh.colour(triangle, weights, metres, patch.albedo);
        // Where a texel is larger than the pixel, its middle tells as much as four places.
        let albedo = if 2.0 * triangle.texels * metres > 1.0 {
            PLACES.iter().map(|place| 0.25 * colour(facet.weights(place.x, place.y), metres)).sum()
        } else {
            colour(middle.weights, metres)
        };
        Hit { id: self.near[0].id, range: f64::from(middle.at), normal, albedo }
    }

    /// Finds the nearest hit of the middle of a pixel on some items.
    fn nearest_of(&self, items: &[MeshItem<'_>], line: &Line) -> Option<Hit> {
        let mut found: Option<(Hit, i32)> = None;
        for (body, item) in self.near.iter().zip(items) {
            let hit = match (item, &body.sight) {
                (MeshItem::Mesh(patch), _) => self.middle_of(patch).map(|middle| {
                    let facet = &self.sheets.facets[middle.facet];
                    let triangle = patch.mesh.triangle_at(facet.triangle);
                    let normal = patch.turned(patch.mesh.normal(triangle, middle.weights, facet.is_behind));
                    let albedo =
                        patch.mesh.colour(triangle, middle.weights, patch.metres(middle.at), patch.albedo);
                    Hit { id: body.id, range: f64::from(middle.at), normal, albedo }
                }),
                (MeshItem::Shape(_), SeenForm::Shape(_)) => {
                    nearest(std::iter::once(*body), line, self.square.lens.camera.footprint())
                }
                (MeshItem::Shape(_), SeenForm::Mesh(_)) => None,
            };

            if let Some(hit) = hit
                && found
                    .is_none_or(|(found, priority)| hit.range < limit(found.range, body.priority, priority))
            {
                found = Some((hit, body.priority));
            }
        }

        found.map(|(hit, _)| hit)
    }
}
