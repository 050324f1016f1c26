//! `hedgehop sight`: whether one point sees another.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::args;
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::places::Places;
use crate::world::WorldArgs;
use hedgehop::Error;
use hedgehop::render::RenderOptions;
use hedgehop::voxel::{Header, PageSource};
use hedgehop_query::{Matter, Sight, sight};

const EXAMPLE: &str = "\
Examples:
  hedgehop sight area.hop --from -105.54,40.38,2 --to -105.60,40.33,30
  hedgehop sight area.hop --from 455120,4470300,2900 --to 458120,4471300,3100 --xy --msl";

/// Say whether one point sees another over the ground of a database, and past what stands on it.
///
/// As a picture from near by would show it, under bridges and crowns, over the Earth's curvature. Where something hides the far point, it says where, and how much higher that would have to be. Points that lie below ground or within something opaque are told.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct SightArgs {
    /// Database to ask
    #[arg(value_name = "AREA.hop")]
    file: DatabaseName,

    /// Longitude, latitude (degrees, WGS 84; of local databases x and y) and height above the ground or the roof there, metres
    #[arg(long, value_name = "LON,LAT,HEIGHT", value_parser = args::position, allow_hyphen_values = true)]
    from: [f64; 3],

    /// The same of the other point
    #[arg(long, value_name = "LON,LAT,HEIGHT", value_parser = args::position, allow_hyphen_values = true)]
    to: [f64; 3],

    /// Places are x and y, metres of the database's reference system
    #[arg(long)]
    xy: bool,

    /// Heights are above the database's datum, not above ground
    #[arg(long)]
    msl: bool,

    /// Earth's curvature with refraction: auto (on for a place on Earth, off for local metres), on, off, or a
    /// refraction coefficient from -1 to 1; on is 1/7, and 0 is no refraction
    #[arg(long, value_name = "auto|on|off|K", default_value = "auto", value_parser = crate::world::bend, allow_hyphen_values = true)]
    curvature: crate::world::Bend,

    #[command(flatten)]
    cache: CacheArgs,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &SightArgs) -> Outcome {
    let source = args.cache.open(&args.file)?;
    let places = Places::new(&source, args.xy)?;
    let [from, to] = [args.from, args.to].map(|point| places.point(point, args.msl));
    let (from, to) = (from?, to?);
    if from == to {
        let what = format!(
            "--from and --to are the same point, {} at {:.1} m above {}; a line of sight needs two",
            places.name(from.truncate()),
            from.z,
            source.header().metadata.vertical_datum
        );
        return Err(Error::Configuration(what).into());
    }

    let world = WorldArgs { curvature: args.curvature, tile_world: false };
    let curvature = world.apply(source.header(), RenderOptions::default()).curvature;
    let found = sight(&source, from, to, curvature)?;
    let Sight { distance, blocked, material, nearest, missing, within } = &found;
    let standing = material.map(|number| source.header().metadata.material_name(number));

    if args.json {
        let json = json!({
            "sees": blocked.is_none(),
            "distance_m": distance,
            "blocked_at": blocked.map(|sample| places.json(&sample)),
            "standing": standing,
            "nearest": nearest.map(|(sample, above)| json!({ "above_ground_m": above, "at": places.json(&sample) })),
            // No height that would do is no number.
            "missing_m": missing,
            "within": { "from": holder(source.header(), within[0]), "to": holder(source.header(), within[1]) },
        });
        return Ok(exit::print(&format!("{json:#}\n"))?);
    }

    let mut text = lead(source.header(), within);
    text += &match blocked {
        None if *distance == 0.0 => {
            format!("they see each other over {:.1} m of height", (to.z - from.z).abs())
        }
        None => format!("they see each other over {distance:.0} m"),
        Some(sample) => format!(
            "{} hides the far point, {:.0} m of {distance:.0} m on the way, at {} (the line of sight is {:.1} m high there)",
            standing.map_or("the ground".into(), |name| format!("what stands on the ground ({name})")),
            sample.distance,
            places.name(sample.place),
            sample.ground.unwrap_or(f64::NAN)
        ),
    };

    // Writing to a string does not fail.
    let _ = match (blocked, nearest) {
        (Some(_), _) if missing.is_infinite() => write!(text, "; no height of it would do"),
        (Some(_), _) if *missing > 0.0 => write!(text, "; it would have to be {} higher", rise(*missing)),
        (None, Some((sample, above))) => write!(
            text,
            "; the line comes nearest to what lies below it at {}, {:.0} m on the way: {above:.1} m",
            places.name(sample.place),
            sample.distance
        ),
        (None, None) if *distance > 0.0 => write!(text, "; there is no ground between them"),
        _ => Ok(()),
    };

    Ok(exit::print(&(text + "\n"))?)
}

/// A rise, however small: along level ground or up a slope a hair may be enough.
fn rise(metres: f64) -> String {
    match metres {
        0.05.. => format!("{metres:.1} m"),
        0.0005.. => format!("{metres:.3} m"),
        _ => "less than a millimetre".to_owned(),
    }
}

/// Returns what a point lies within, as JSON: nothing, ground, or a material.
fn holder(header: &Header, within: Option<Matter>) -> Value {
    match within {
        None => Value::Null,
        Some(Matter::Ground) => json!({ "standing": null }),
        Some(Matter::Standing(number)) => json!({ "standing": header.metadata.material_name(number) }),
    }
}

/// The beginning of the answer: what the points lie within, if they do.
fn lead(header: &Header, within: &[Option<Matter>; 2]) -> String {
    let told = ["near", "far"].iter().zip(within).filter_map(|(which, within)| {
        let holder = match (*within)? {
            Matter::Ground => "below the ground".to_owned(),
            Matter::Standing(number) => {
                format!("within what stands on the ground ({})", header.metadata.material_name(number))
            }
        };
        Some(format!("the {which} point lies {holder}; "))
    });
    told.collect()
}
