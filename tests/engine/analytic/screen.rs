//! What a view shows where, derived otherwise than in the library.

use std::sync::LazyLock;

use glam::{DMat3, DQuat, DVec3};
use hedgehop::frame::Frame;
use hedgehop::render::{Engine, RenderOptions, render_frame};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::MemPages;

use super::ENGINE;
use super::scene::View;

/// Two workers for all tests; that their number does not matter is another test's concern.
pub static FARM: LazyLock<Farm> = LazyLock::new(|| Farm::new(2).unwrap());

/// What a camera sees of a world with the engine of these tests.
pub fn render(world: &MemPages, camera: &Camera, options: &RenderOptions) -> Frame {
    let options = RenderOptions { engine: ENGINE, ..*options };
    render_frame(world, camera, &options, &FARM).unwrap().frame
}

impl View {
    pub fn frame(&self, world: &MemPages, options: &RenderOptions) -> Frame {
        render(world, &self.camera(), options)
    }

    /// Distance of the screen, pixels.
    pub fn focal(&self) -> f64 {
        0.5 * f64::from(self.size[0]) / (0.5 * self.hfov.to_radians()).tan()
    }

    /// Right, forward, up in the world: a level view to the north, banked, raised and turned, one after
    /// the other. Deliberately another derivation than the library's.
    pub fn axes(&self) -> DMat3 {
        let [yaw, pitch, roll] = self.ypr.map(f64::to_radians);
        let turn =
            DQuat::from_rotation_z(-yaw) * DQuat::from_rotation_x(pitch) * DQuat::from_rotation_y(roll);
        DMat3::from_quat(turn)
    }

    /// Unit direction through the centre of a pixel.
    pub fn direction(&self, [column, row]: [u32; 2]) -> DVec3 {
        (self.axes() * self.screen([column, row])).normalize()
    }

    /// Right, forward, up of a pixel's centre in the view, pixels.
    pub fn screen(&self, [column, row]: [u32; 2]) -> DVec3 {
        let right = f64::from(column) + 0.5 - 0.5 * f64::from(self.size[0]);
        let up = 0.5 * f64::from(self.size[1]) - f64::from(row) - 0.5;
        DVec3::new(right, self.focal(), up)
    }

    /// Distance of a pixel's centre, in pixels, from the screen line in which a plane through the eye with this
    /// `normal` (world) is seen; positive on the side to which the normal points.
    pub fn distance(&self, normal: DVec3, pixel: [u32; 2]) -> f64 {
        let normal = self.axes().transpose() * normal;
        normal.dot(self.screen(pixel)) / normal.x.hypot(normal.z)
    }

    /// All pixels with their index in a frame's planes.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, [u32; 2])> + use<> {
        let [width, height] = self.size;
        (0..height).flat_map(move |row| (0..width).map(move |column| [column, row])).enumerate()
    }
}

/// Whether a pixel's light is that of the surface that its range is of. The reference sees with one ray; planes mix what a
/// pixel covers and more, so that all pixels around it must see the same surface.
pub fn is_of_one_surface(frame: &Frame, index: usize) -> bool {
    let (width, height) = (frame.camera.width as usize, frame.camera.height as usize);
    let (column, row) = (index % width, index / width);
    let own = frame.range[index];
    let is_near = |index: usize| frame.range[index] == own || (frame.range[index] / own - 1.0).abs() < 0.1;
    let is_inside = (1..width - 1).contains(&column) && (1..height - 1).contains(&row);
    let mut around = (0..9).map(|place| index + place % 3 + place / 3 * width - width - 1);
    ENGINE == Engine::Reference || is_inside && around.all(is_near)
}
