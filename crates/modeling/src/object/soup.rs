//! Models as triangles over the place where they stand, and which of these enclose something.
//!
//! ```text
//! piece: triangles that hang together at their corners
//!   edges that are left open are short, for its area      winding: a ray is inside between a face that looks down and the next that looks up
//!   the same, if faces may look either way                parity: between every other two
//!   all of them lie at its foot                           standing: the ground is its floor
//!   else                                                  open: its faces are sheets
//! ```

use std::collections::HashMap;

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, Vec4};

use hedgehop_assets::model::{Material, Model};

/// Stance of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stance {
    /// Metres per unit of the file, > 0.
    pub scale: f64,
    /// Whether Z points up in the file, rather than Y; `None`: as its format has it.
    pub is_z_up: Option<bool>,
    /// Direction of its front, degrees clockwise from grid north.
    pub heading_deg: f64,
    /// Turns before that: about the axis to its right (front up), and about that to its front (right side down), degrees.
    pub pitch_deg: f64,
    /// The second of them.
    pub roll_deg: f64,
}

impl Default for Stance {
    fn default() -> Self {
        Self { scale: 1.0, is_z_up: None, heading_deg: 0.0, pitch_deg: 0.0, roll_deg: 0.0 }
    }
}

/// A triangle: eastward, northward, upward, metres from the foot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    /// Counterclockwise as seen from outside.
    pub corners: [DVec3; 3],
    /// Places in the texture.
    pub places: [Vec2; 3],
    /// Linear factors.
    pub colours: [Vec3; 3],
    pub material: u32,
    pub piece: u32,
}

/// Rule by which rays see what a piece encloses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Inside {
    /// Between a face that looks down and the next that looks up; the other way round if it is turned inside out.
    Winding { is_inverted: bool },
    /// Between every other two faces.
    Parity,
    /// Counts windings; what no face closes below ends at this height.
    Standing { is_inverted: bool, foot: f64 },
    /// Nowhere.
    Open,
}

/// Triangles over the place where a model stands, its foot at height 0.
#[derive(Debug)]
pub(super) struct Soup {
    pub faces: Vec<Face>,
    pub materials: Vec<Material>,
    pub pieces: Vec<Inside>,
    /// Least and greatest corner, metres.
    pub corners: [DVec3; 2],
}

/// Colour of what has none of its own: linear.
const PLAIN: Vec3 = Vec3::splat(0.35);
/// Square of the length of open edges by the area, up to which a piece is closed: that of a hole which is half as wide as a ball.
const OPEN: f64 = 1.0;
/// Part of a piece's height above its foot within which open edges may be that the ground closes.
const FOOT: f64 = 0.1;
/// Corners that are nearer to each other than this part of the model's size are one.
const WELD: f64 = 1e-6;

impl Soup {
    /// Models that share their origin, in one; what is in the middle below them stands on the ground.
    ///
    /// # Errors
    /// A clause that says what is wrong: nothing has an area, or a corner is nowhere.
    pub fn of(models: &[&Model], stance: &Stance) -> Result<Self, String> {
        let mut soup = Self::without_pieces(models, stance)?;
        soup.stand(stance.heading_deg);
        soup.sort_pieces();
        Ok(soup)
    }

    fn without_pieces(models: &[&Model], stance: &Stance) -> Result<Self, String> {
        let (sin, cos) = stance.pitch_deg.to_radians().sin_cos();
        let pitch = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, sin), DVec3::new(0.0, -sin, cos));
        let (sin, cos) = stance.roll_deg.to_radians().sin_cos();
        let roll = DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
        let (mut faces, mut materials) = (Vec::new(), Vec::new());

        for model in models {
            let axes = match stance.is_z_up {
                None => model.body_from_model,
                Some(true) => DMat3::IDENTITY,
                Some(false) => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
            };
            let turned = pitch * roll * axes * stance.scale;
            let is_mirrored = turned.determinant() < 0.0;

            for part in &model.parts {
                let material = materials.len() as u32;
                let is_plain = part.material.colour.is_none();
                let own = part.material.colour.unwrap_or(PLAIN);
                materials.push(part.material.clone());

                for corners in &part.triangles {
                    let [a, b, c] = corners.map(|corner| corner as usize);
                    let order = if is_mirrored { [a, c, b] } else { [a, b, c] };
                    if order.iter().any(|corner| *corner >= part.positions.len()) {
                        return Err("a triangle names a corner that is not there".to_owned());
                    }

                    let corners = order.map(|corner| turned * part.positions[corner]);
                    if corners
                        .iter()
                        .any(|corner| !corner.is_finite() || corner.abs().max_element() > FARTHEST)
                    {
                        return Err(format!(
                            "a corner of it lies beyond {FARTHEST} m of its origin; see `scale`"
                        ));
                    }

                    let places = order.map(|corner| part.places.get(corner).copied().unwrap_or(Vec2::ZERO));
                    let factor = |corner: usize| part.colours.get(corner).copied().unwrap_or(Vec3::ONE);
                    let own = if is_plain && !part.colours.is_empty() { Vec3::ONE } else { own };
                    let colours = order.map(|corner| own * factor(corner).clamp(Vec3::ZERO, Vec3::ONE));
                    faces.push(Face { corners, places, colours, material, piece: 0 });
                }
            }
        }

        faces.retain(|face| face.across().length_squared() > 0.0);
        if faces.is_empty() {
            return Err("it has no triangle with an area".to_owned());
        }

        Ok(Self { faces, materials, pieces: Vec::new(), corners: [DVec3::ZERO; 2] })
    }

    /// Builds the soup of built-in forms, which stand already.
    pub fn built_in(faces: Vec<Face>) -> Self {
        let mut soup = Self {
            faces,
            materials: vec![Material::of(None)],
            pieces: Vec::new(),
            corners: [DVec3::ZERO; 2],
        };
        soup.corners = soup.bounds();
        soup.sort_pieces();
        soup
    }

    fn bounds(&self) -> [DVec3; 2] {
        let corners = self.faces.iter().flat_map(|face| face.corners);
        corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], corner| {
            [low.min(corner), high.max(corner)]
        })
    }

    /// Puts the middle of its lower side to the origin, and its front to where it looks.
    fn stand(&mut self, heading_deg: f64) {
        let [low, high] = self.bounds();
        let origin = (0.5 * (low + high)).with_z(low.z);
        // Whole quarters without a rounding, so that walls along the grid stay so.
        let (sin, cos) = match heading_deg.rem_euclid(360.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            heading => heading.to_radians().sin_cos(),
        };
        for corner in self.faces.iter_mut().flat_map(|face| &mut face.corners) {
            let from = *corner - origin;
            *corner = DVec3::new(from.x * cos + from.y * sin, from.y * cos - from.x * sin, from.z);
        }
        self.corners = self.bounds();
    }

    /// Finds the pieces, and what they enclose.
    fn sort_pieces(&mut self) {
        let [low, high] = self.corners;
        let weld = (WELD * (high - low).max_element()).max(f64::MIN_POSITIVE);
        let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
        let mut owners: Vec<u32> = Vec::new();

        let corners: Vec<[u32; 3]> = (self.faces.iter())
            .map(|face| {
                face.corners.map(|corner| {
                    let cell = ((corner - low) / weld).round();
                    *numbers.entry([cell.x, cell.y, cell.z].map(|at| at as i64)).or_insert_with(|| {
                        owners.push(owners.len() as u32);
                        owners.len() as u32 - 1
                    })
                })
            })
            .collect();

        for [a, b, c] in &corners {
            for other in [b, c] {
                let (first, second) = (root(&mut owners, *a), root(&mut owners, *other));
                owners[first.max(second) as usize] = first.min(second);
            }
        }

        let mut of_root: HashMap<u32, u32> = HashMap::new();
        for (face, corners) in self.faces.iter_mut().zip(&corners) {
            let count = of_root.len() as u32;
            face.piece = *of_root.entry(root(&mut owners, corners[0])).or_insert(count);
        }

        let mut edges: HashMap<[u32; 2], Edge> = HashMap::new();
        for (face, corners) in self.faces.iter().zip(&corners) {
            for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (corners[from], corners[to]);
                let edge = edges.entry([a.min(b), a.max(b)]).or_default();
                edge.ways += if a < b { 1 } else { -1 };
                edge.count += 1;
                edge.length = face.corners[from].distance(face.corners[to]);
                edge.high = face.corners[from].z.max(face.corners[to].z);
                edge.piece = face.piece;
            }
        }

        let mut sums = vec![PieceSums::default(); of_root.len()];
        // Sums of floats depend on their order, which that of a map is not.
        let mut edges: Vec<([u32; 2], Edge)> = edges.into_iter().collect();
        edges.sort_unstable_by_key(|(corners, _)| *corners);

        for (_, edge) in &edges {
            let sums = &mut sums[edge.piece as usize];
            if edge.ways != 0 {
                sums.open += edge.length * f64::from(edge.ways.unsigned_abs());
                sums.open_high = sums.open_high.max(edge.high);
            }
            if edge.count % 2 == 1 {
                sums.odd += edge.length;
            }
        }

        for face in &self.faces {
            let sums = &mut sums[face.piece as usize];
            sums.area += 0.5 * face.across().length();
            face.corners.iter().for_each(|corner| {
                sums.low = sums.low.min(corner.z);
                sums.high = sums.high.max(corner.z);
            });
        }

        for face in &self.faces {
            let sums = &mut sums[face.piece as usize];
            let [a, b, c] = face.corners.map(|corner| corner - DVec3::Z * sums.low);
            sums.volume += a.dot(b.cross(c)) / 6.0;
        }

        self.pieces = sums.iter().map(PieceSums::inside).collect();
    }
}

/// Metres from a model's origin beyond which no corner of it is.
const FARTHEST: f64 = 20_000.0;

fn root(owners: &mut [u32], mut index: u32) -> u32 {
    while owners[index as usize] != index {
        owners[index as usize] = owners[owners[index as usize] as usize];
        index = owners[index as usize];
    }
    index
}

/// An edge of one or more triangles.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    /// Times it is passed one way, less those of the other.
    ways: i32,
    count: u32,
    length: f64,
    high: f64,
    piece: u32,
}

/// Sums over a piece.
#[derive(Debug, Clone, Copy)]
struct PieceSums {
    area: f64,
    volume: f64,
    /// Length of edges that no other triangle passes the other way.
    open: f64,
    open_high: f64,
    /// Length of edges of an odd number of triangles.
    odd: f64,
    low: f64,
    high: f64,
}

impl Default for PieceSums {
    fn default() -> Self {
        let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { area: 0.0, volume: 0.0, open: 0.0, open_high: high, odd: 0.0, low, high }
    }
}

impl PieceSums {
    fn inside(&self) -> Inside {
        let is_inverted = self.volume < 0.0;
        let is_short = |length: f64| length * length <= OPEN * self.area;
        if is_short(self.open) {
            Inside::Winding { is_inverted }
        } else if self.high > self.low && self.open_high <= self.low + FOOT * (self.high - self.low) {
            Inside::Standing { is_inverted, foot: self.low }
        } else if is_short(self.odd) {
            Inside::Parity
        } else {
            Inside::Open
        }
    }
}

impl Face {
    /// Across it, outward: twice its area long.
    pub fn across(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// Weights of its corners at a place of its plane.
    pub fn weights(&self, place: DVec3) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let across = self.across();
        let area = across.length_squared();
        let of = |from: DVec3, to: DVec3| (to - from).cross(place - from).dot(across) / area;
        [of(b, c), of(c, a), of(a, b)]
    }

    /// Linear colour and alpha at weights of its corners, over about `metres` of it.
    pub fn colour(&self, materials: &[Material], weights: [f64; 3], metres: f64) -> Vec4 {
        let weights = weights.map(|weight| weight as f32);
        let material = &materials[self.material as usize];
        let own: Vec3 = self.colours.iter().zip(weights).map(|(colour, weight)| *colour * weight).sum();
        let own = own.clamp(Vec3::ZERO, Vec3::ONE).extend(material.alpha);
        let Some(texture) = &material.texture else { return own };
        let [width, height] = texture.size().map(|size| size as f32);
        let [p, q, r] = self.places.map(|place| place * Vec2::new(width, height));
        let texels = (f64::from((q - p).perp_dot(r - p).abs()) / self.across().length()).sqrt();
        let place: Vec2 = self.places.iter().zip(weights).map(|(place, weight)| *place * weight).sum();
        own * texture.sample(place, (texels * metres) as f32)
    }

    /// West, south, east, north.
    pub fn bounds(&self) -> [f64; 4] {
        let [a, b, c] = self.corners.map(|corner| DVec2::new(corner.x, corner.y));
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        [low.x, low.y, high.x, high.y]
    }
}
