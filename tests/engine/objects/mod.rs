//! Bodies whose pictures are known in closed form, among ground and sky, with both engines.

mod clouds;
mod ellipses;
mod exact;
mod matte;
mod merging;
mod meshes;
mod outlines;
mod parts;
mod priorities;
mod shadows;
mod thin;

use std::sync::LazyLock;

use glam::{DVec2, Vec3};
use hedgehop::frame::Frame;
use hedgehop::objects::{Body, Form};
use hedgehop::render::{Engine, RenderOptions, Renderer};
use hedgehop::space::{Attitude, Camera};
use hedgehop::subimage::Farm;
use hedgehop::voxel::MemPages;

use crate::scene::{Terrain, View, clear_air};

/// Two workers for all tests but the one that counts them.
static FARM: LazyLock<Farm> = LazyLock::new(|| Farm::new(2).unwrap());

/// A plain of one grey, 0 m high, 1 km each way.
static PLAIN: LazyLock<MemPages> =
    LazyLock::new(|| Terrain::new([500, 500], 2.0, |_| 0.0, |_| [120; 3]).in_memory());

/// A body that sends no light, `east`, `north` and `up` metres from the area's south-west corner.
fn black(form: impl Into<Form>, [east, north, up]: [f64; 3]) -> Body {
    let corner = PLAIN_ORIGIN.extend(0.0);
    let position = corner + glam::DVec3::new(east, north, up);
    let form = form.into();
    Body { id: 1, form, position, attitude: Attitude::default(), albedo: Vec3::ZERO, priority: 0 }
}

const PLAIN_ORIGIN: DVec2 = DVec2::new(500_000.0, 4_000_000.0);

fn options(engine: Engine) -> RenderOptions {
    RenderOptions { engine, ..clear_air() }
}

fn frame(engine: Engine, world: &MemPages, camera: &Camera, bodies: &[Body]) -> Frame {
    Renderer::new(world, &options(engine)).frame_with(camera, bodies, &FARM).unwrap().frame
}

/// Share of each pixel that black bodies cover: what is missing of the light without them.
fn shares(engine: Engine, world: &MemPages, view: &View, bodies: &[Body]) -> Vec<f64> {
    let camera = view.camera();
    let (with, without) = (frame(engine, world, &camera, bodies), frame(engine, world, &camera, &[]));
    with.colour.iter().zip(&without.colour).map(|(seen, all)| 1.0 - f64::from(seen[1] / all[1])).collect()
}
