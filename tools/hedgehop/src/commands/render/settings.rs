//! Record of what decides the pictures of a render.

use serde_json::{Value, json};

use super::flags::RenderArgs;
use crate::output::WRITER;
use crate::scene;
use crate::screen::Setup;
use hedgehop::render::RenderOptions;
use hedgehop::scene::Scene;

/// Everything that decides the pictures besides database and path.
pub fn settings(args: &RenderArgs, scene: Option<&Scene>, setup: &Setup, options: &RenderOptions) -> Value {
    let (flight, look) = (&args.flight, &args.look);
    let mut settings = json!({
        "renderer": WRITER,
        "fps": args.fps.to_string(),
        "size_px": [setup.size.width, setup.size.height],
        "screen": setup.record(),
        "level": flight.level,
        "clearance_m": flight.clearance,
        "alt_mode": flight.alt_mode.map(|mode| format!("{mode:?}").to_lowercase()),
        "surface": format!("{:?}", look.surface).to_lowercase(),
        "visibility_m": options.visibility,
        "sun_azimuth_elevation_deg": [options.sun.azimuth, options.sun.elevation],
        "shadows": options.shadows,
        "detail": options.detail,
        "detail_synthesis": options.detail_synthesis,
        "far_spans_px": options.far_spans,
        "effective_earth_radius_m": options.curvature.radius(),
        "tile_world": options.tile_world,

        "engine": format!("{:?}", options.engine).to_lowercase(),
    });

    flight.camera.record(&mut settings);
    flight.views.record(&mut settings);
    flight.smoothing.record(&mut settings);
    flight.playback.record(&mut settings);
    args.trust.record(&mut settings);
    args.late.record(&mut settings);
    args.trails.record(&mut settings);
    args.labels.record(&mut settings);
    scene::record(scene, &mut settings);
    scene::record_weather(&options.weather, &mut settings);

    settings
}
