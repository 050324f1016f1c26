//! The renderer under test. This is the only place that names it.

use hedgehop::Result;
use hedgehop::frame::Frame;
use hedgehop::render::{Engine, RenderOptions, Renderer, render_frame};
use hedgehop::space::Camera;
use hedgehop::subimage::Farm;
use hedgehop::voxel::PageSource;

/// The frame that is judged.
pub fn render(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Frame> {
    let options = RenderOptions { engine: Engine::Planes, ..*options };
    render_frame(source, camera, &options, farm).map(|rendered| rendered.frame)
}

/// The 8-bit picture that is judged, as files get it.
pub fn picture(
    source: &dyn PageSource,
    camera: &Camera,
    options: &RenderOptions,
    farm: &Farm,
) -> Result<Vec<u8>> {
    let options = RenderOptions { engine: Engine::Planes, ..*options };
    Renderer::new(source, &options).picture(camera, farm).map(|(picture, _)| picture.rgb)
}
