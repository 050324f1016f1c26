//! Cues of motion: how many features of a picture can be followed to the next, with and without scattered things.
//!
//! After Bunker and Ferris, AFHRL-TR-77-66 (1977), §2.7, who judge scatter by eye on tape. Features are corners by the lesser
//! eigenvalue of their gradients (Shi and Tomasi 1994, *Good features to track*); they count if a patch about them comes again.

use glam::{DVec2, DVec3, Vec3};

use crate::scene::{ORIGIN, Terrain, View, clear_air};
use hedgehop::objects::{Body, Shape};
use hedgehop::render::Renderer;
use hedgehop::space::Attitude;
use hedgehop::subimage::Farm;
use hedgehop::voxel::MemPages;

const SIZE: [u32; 2] = [160, 120];

/// Least eigenvalue of gradients summed over a patch, codes².
const STRONG: f32 = 150.0;

/// Pixels to either side of a patch, and of the search for it.
const PATCH: i32 = 2;
const SEARCH: i32 = 6;

/// Greatest mean square of what a patch that comes again differs by, as a share of its own variance.
const ALIKE: f32 = 0.15;

/// Codes of a picture.
struct Codes(Vec<f32>);

impl Codes {
    fn at(&self, x: i32, y: i32) -> f32 {
        self.0[y as usize * SIZE[0] as usize + x as usize]
    }

    /// Lesser eigenvalue of the gradients about a pixel.
    fn strength(&self, x: i32, y: i32) -> f32 {
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (i, j) in patch(x, y) {
            let right = 0.5 * (self.at(i + 1, j) - self.at(i - 1, j));
            let down = 0.5 * (self.at(i, j + 1) - self.at(i, j - 1));
            (xx, xy, yy) = (xx + right * right, xy + right * down, yy + down * down);
        }
        0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt()
    }

    fn features(&self) -> Vec<(i32, i32)> {
        let [width, height] = SIZE.map(|size| size as i32);
        let edge = SEARCH + 2 * PATCH + 1;
        let inner = (edge..height - edge).flat_map(|y| (edge..width - edge).map(move |x| (x, y)));
        let is_peak = |x: i32, y: i32| {
            let own = self.strength(x, y);
            own > STRONG && patch(x, y).all(|(i, j)| self.strength(i, j) <= own)
        };
        inner.filter(|&(x, y)| is_peak(x, y)).collect()
    }

    /// Whether the patch about a pixel comes again near it in another picture.
    fn comes_again(&self, other: &Self, (x, y): (i32, i32)) -> bool {
        let count = patch(x, y).count() as f32;
        let mean = patch(x, y).map(|(i, j)| self.at(i, j)).sum::<f32>() / count;
        let variance = patch(x, y).map(|(i, j)| (self.at(i, j) - mean).powi(2)).sum::<f32>();
        let moves = (-SEARCH..=SEARCH).flat_map(|right| (-SEARCH..=SEARCH).map(move |down| (right, down)));
        let difference = |(right, down): (i32, i32)| {
            let parts = patch(x, y).map(|(i, j)| (self.at(i, j) - other.at(i + right, j + down)).powi(2));
            parts.sum::<f32>()
        };
        moves.map(difference).fold(f32::INFINITY, f32::min) < ALIKE * variance
    }
}

fn patch(x: i32, y: i32) -> impl Iterator<Item = (i32, i32)> {
    (-PATCH..=PATCH).flat_map(move |down| (-PATCH..=PATCH).map(move |right| (x + right, y + down)))
}

/// Sparse ground: low hills and large fields.
fn ground() -> MemPages {
    let height = |at: DVec2| 3.0 * (at.x / 70.0).sin() + 2.0 * (at.y / 90.0).cos();
    let colour = |at: DVec2| {
        let field = ((at.x / 170.0).floor() * 7.0 + (at.y / 230.0).floor() * 3.0).rem_euclid(4.0);
        [90 + 20 * field as u8, 90 + 25 * field as u8, 70]
    };
    Terrain::new([400, 400], 2.0, height, colour).in_memory()
}

/// Clumps of bushes and trees, small ones most.
fn scatter() -> Vec<Body> {
    let part = |index: u32, step: f64| (f64::from(index) * step).fract();
    let body = |index: u32| {
        let clump = DVec2::new(part(index / 6, 0.618_034), part(index / 6, 0.754_878)) * 560.0 + 120.0;
        let at = clump + DVec2::new(part(index, 0.569_84), part(index, 0.819_17)) * 40.0 - 20.0;
        let size = 0.8 + 3.0 * part(index, 0.414_214).powi(3);
        let ground = 3.0 * (at.x / 70.0).sin() + 2.0 * (at.y / 90.0).cos();
        Body {
            id: 1 + index,
            form: Shape::Ellipsoid { radii: DVec3::new(size, size, 1.4 * size) }.into(),
            position: (ORIGIN + at).extend(ground + size),
            attitude: Attitude::default(),
            albedo: Vec3::new(0.012, 0.02, 0.008) * (1.0 + part(index, 0.236_068) as f32),
            priority: 0,
        }
    };
    (0..1500).map(body).collect()
}

/// Features that are followed over three metres of flight.
fn followed(ground: &MemPages, bodies: &[Body]) -> usize {
    let farm = Farm::new(2).unwrap();
    let renderer = Renderer::new(ground, &clear_air());
    let [first, second] = [0.0, 3.0].map(|flown| {
        let view = View {
            eye: DVec3::new(400.0, 60.0 + flown, 35.0),
            ypr: [0.0, -9.0, 0.0],
            hfov: 60.0,
            size: SIZE,
        };
        let frame = renderer.frame_with(&view.camera(), bodies, &farm).unwrap().frame;
        Codes(frame.colour.iter().map(|light| 255.0 * light[1].max(0.0).sqrt()).collect())
    });
    first.features().into_iter().filter(|at| first.comes_again(&second, *at)).count()
}

#[test]
fn scatter_gives_five_times_as_many_features_to_follow() {
    let ground = ground();
    let (bare, scattered) = (followed(&ground, &[]), followed(&ground, &scatter()));
    assert!(bare >= 1 && scattered >= 5 * bare, "{bare} without, {scattered} with");
}
