//! `hedgehop scene`: what a scene file holds.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Subcommand;

use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::{Mode, Reporter};
use crate::view::over_ground;
use crate::world::WorldArgs;
use crate::{area, finish, scene, titling};
use hedgehop::objects::{Form, Shape};
use hedgehop::scene::{Anchor, LampLayout, Object, Part, PlumeKind, Scene, TrailColour, TrailSource};
use hedgehop::sunlight::{FilmSun, Sun, SunSetting};
use hedgehop::voxel::PageSource;
use hedgehop::weather::{GroundCover, PrecipitationKind, Weather};

const EXAMPLE: &str = "\
Examples:
  hedgehop scene check scene.toml
  hedgehop scene check scene.toml area.hop";

/// Look into scene files.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct SceneCheckArgs {
    #[command(subcommand)]
    command: SceneCommand,
}

#[derive(Debug, Subcommand)]
enum SceneCommand {
    /// Read a scene and its tracks, and say what is in it
    ///
    /// With a database, also whether all objects have a place in it, and where they begin.
    Check {
        /// Scene to read
        #[arg(value_name = "SCENE.toml")]
        scene: PathBuf,

        /// Database that it is to be seen in
        #[arg(value_name = "AREA.hop")]
        area: Option<DatabaseName>,

        #[command(flatten)]
        cache: CacheArgs,
    },
}

/// Runs the command.
pub fn run(args: &SceneCheckArgs, interrupt: &Interrupt) -> Outcome {
    let SceneCommand::Check { scene, area, cache } = &args.command;
    let reporter = Reporter::new(Mode::Auto, interrupt);
    let scene = scene::read(scene, &reporter)?;
    let mut text = description(&scene);

    if let Some(file) = area {
        let source = cache.open(file)?;
        if let (Some(FilmSun::Still(SunSetting::Time(_))), Some(sky)) =
            (scene.sun, area::sky_of(&scene, source.header())?)
        {
            let Sun { azimuth, elevation } = sky.sun;
            let _ = writeln!(text, "  the sun is then {azimuth:.1}° from grid north, {elevation:.1}° high");
        }

        let cast = over_ground(&source, WorldArgs::default(), |crs, ground| scene.bind(crs, ground))?;
        let names: Vec<&str> = cast.names().collect();
        let lamps = cast.lights_at(0.0).len();
        if lamps > 0 {
            let _ = writeln!(text, "  {lamps} lamps shine when it begins");
        }

        // Parts are where their objects are.
        for body in cast.bodies_at(0.0).iter().filter(|body| (body.id as usize) < scene.objects.len()) {
            let ([x, y, z], name) = (body.position.to_array(), names[body.id as usize]);
            // Writing to a string does not fail.
            let _ = writeln!(text, "  {name} begins at x {x:.1}, y {y:.1}, {z:.1} m above the datum");
        }

        for (name, metres) in cast.raised() {
            let _ = writeln!(text, "  {}", scene::raised(name, metres));
        }
    }

    Ok(exit::print(&text)?)
}

fn description(scene: &Scene) -> String {
    let count = scene.objects.len();
    let mut text =
        format!("{}: scene of {count} object{}\n", scene.path.display(), if count == 1 { "" } else { "s" });
    match scene.sun {
        Some(FilmSun::Still(SunSetting::At(Sun { azimuth, elevation }))) => {
            let _ = writeln!(text, "  sun {azimuth}° from grid north, {elevation}° high");
        }
        Some(FilmSun::Still(SunSetting::Time(time))) => {
            let _ = writeln!(text, "  sun of {time}");
        }
        Some(FilmSun::Track) => text.push_str("  sun that runs with the flight, by its clock\n"),
        Some(FilmSun::From(time)) => {
            let _ = writeln!(text, "  sun that runs with the flight, from {time} on");
        }
        None => {}
    }

    match scene.cameras.len() {
        0 => {}
        1 => text.push_str("  1 camera\n"),
        count => {
            let _ = writeln!(text, "  {count} cameras");
        }
    }

    if scene.shadows == Some(true) {
        let _ = writeln!(text, "  shadows of the ground");
    }
    if let Some(visibility) = scene.visibility {
        let _ = writeln!(text, "  visibility {visibility} m");
    }

    let Weather { glow, fog, clouds, precipitation, ground } = &scene.weather;
    if *glow > 0.0 {
        let _ = writeln!(text, "  glow {glow}");
    }

    if let Some(fog) = fog {
        let _ = writeln!(
            text,
            "  fog up to {} m above the datum, visibility {} m inside",
            fog.top, fog.visibility
        );
    }

    if let Some(clouds) = clouds {
        let _ = writeln!(
            text,
            "  clouds from {} to {} m above the datum, over {} of the sky",
            clouds.base, clouds.top, clouds.coverage
        );
    }

    if let Some(falls) = precipitation {
        let kind = match falls.kind {
            PrecipitationKind::Rain => "rain",
            PrecipitationKind::Snow => "snow",
        };
        let _ = writeln!(text, "  {kind}, {} mm of water an hour", falls.rate);
    }

    let GroundCover { wet, snow } = *ground;
    for (share, what) in
        [(wet, "wet"), (snow, "white with snow")].into_iter().filter(|(share, _)| *share > 0.0)
    {
        let _ = writeln!(text, "  ground {what}, {share} of 1");
    }

    for light in &scene.lights {
        let _ = writeln!(text, "  {}: {}", light.name, lamps(&light.layout));
    }
    let over_pictures = [
        ("picture", finish::sentence(&scene.finish)),
        ("over the picture", titling::sentence(&scene.titling)),
    ];
    for (what, said) in over_pictures {
        if let Some(said) = said {
            let _ = writeln!(text, "  {what}: {said}");
        }
    }

    for object in &scene.objects {
        let _ = writeln!(text, "  {}: {}, {}", object.name, of_object(object), place(object));
        if !object.notes.is_empty() {
            let _ = writeln!(text, "    of its model {}", object.notes.join("; "));
        }
        for part in &object.parts {
            let _ = writeln!(text, "    {}: {}{}", part.name, form(&part.form), movement(object, part));
        }
    }

    for plume in &scene.plumes {
        let kind = match plume.kind {
            PlumeKind::Smoke => "smoke",
            PlumeKind::Steam => "steam",
            PlumeKind::Dust => "dust",
        };
        let from = match &plume.anchor {
            Anchor::On(object) => format!("from {object}"),
            Anchor::At(_) => "from a place".to_owned(),
        };
        let _ = writeln!(text, "  {}: {kind} {from}", plume.name);
    }

    for trail in &scene.trails {
        let of = match &trail.source {
            TrailSource::Object(name) => name.clone(),
            TrailSource::Track { track, .. } => format!("{} ({})", track.path.display(), track.format),
        };
        let by = match trail.colour {
            TrailColour::Plain(_) => String::new(),
            TrailColour::By(quantity, _) => format!(", by {}", format!("{quantity:?}").to_lowercase()),
        };
        let _ = writeln!(text, "  {}: trail of {of}{by}", trail.name);
    }

    text
}

fn lamps(layout: &LampLayout) -> String {
    match layout {
        LampLayout::Lamps(lamps) if lamps.len() == 1 => "a lamp".to_owned(),
        LampLayout::Lamps(lamps) => format!("{} lamps", lamps.len()),
        LampLayout::String(_, _, spacing, _) => format!("a string of lamps, {spacing} m apart"),
    }
}

/// Describes an object's form; how long a line is that ends at another place is known over a database only.
fn of_object(object: &Object) -> String {
    match &object.form {
        Form::Line { width, pixels, .. } if object.to.is_some() => {
            format!("line to another place, {width} m wide{}", at_least(*pixels))
        }
        other => form(other),
    }
}

fn form(form: &Form) -> String {
    let model = match form {
        Form::Shape(shape) => return self::shape(shape),
        Form::Model(model) => model,
        Form::Line { length, width, pixels } => {
            return format!("line {length} m long, {width} m wide{}", at_least(*pixels));
        }
        Form::Point { width, pixels } => {
            return format!("point of radius {} m{}", 0.5 * width, at_least(*pixels));
        }
    };

    let levels = model.levels().iter().map(|level| {
        let [low, high] = level.mesh.corners();
        let size = high - low;
        let triangles = level.mesh.triangle_count();
        let below =
            if level.below.is_finite() { format!("below {} pixels ", level.below) } else { String::new() };
        format!("{below}{triangles} triangles, {:.2} × {:.2} × {:.2} m", size.x, size.y, size.z)
    });

    format!("model of {}", levels.collect::<Vec<_>>().join("; "))
}

fn at_least(pixels: f64) -> String {
    if pixels > 0.0 { format!(", {pixels} pixels at least") } else { String::new() }
}

fn shape(shape: &Shape) -> String {
    match shape {
        Shape::Ellipsoid { radii } if radii.min_element() == radii.max_element() => {
            format!("sphere of radius {} m", radii.x)
        }
        Shape::Ellipsoid { radii } => format!("ellipsoid of radii {} × {} × {} m", radii.x, radii.y, radii.z),
        Shape::Box { size } => format!("box of {} × {} × {} m", size.x, size.y, size.z),
        Shape::Cylinder { radius, height } => format!("cylinder of radius {radius} m, {height} m high"),
        Shape::Cone { radius, height } => format!("cone of radius {radius} m, {height} m high"),
        Shape::Ellipse { radii } if radii.x == radii.y => format!("disc of radius {} m", radii.x),
        Shape::Ellipse { radii } => format!("ellipse of radii {} × {} m", radii.x, radii.y),
    }
}

/// Describes what a part goes with, and how it moves there.
fn movement(object: &Object, part: &Part) -> String {
    let mut text =
        part.parent.map(|parent| format!(", on {}", object.parts[parent].name)).unwrap_or_default();
    if part.turn_rpm != 0.0 {
        let _ = write!(text, ", turns {} times a minute", part.turn_rpm);
    }
    if let Some(table) = &part.table {
        let _ = write!(text, ", moves as {} says", table.display());
    }
    text
}

fn place(object: &Object) -> String {
    let leans = if object.leans { ", leans with the ground" } else { "" };
    match object.track.fixes.as_slice() {
        [_] => format!("stands{leans}"),
        [.., last] => format!(
            "moves for {:.1} s from {:.1} s on along {} ({}){leans}",
            last.time,
            object.start,
            object.track.path.display(),
            object.track.format
        ),
        [] => String::new(),
    }
}
