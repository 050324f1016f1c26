//! `hedgehop height`: how high the ground is.

use std::ffi::OsString;
use std::fmt::Write;

use crate::args;
use crate::database::{CacheArgs, DatabaseName};
use crate::exit::{self, Outcome};
use crate::places::Places;
use hedgehop::Error;
use hedgehop::voxel::PageSource;
use hedgehop_query::{Ground, Sample};

const EXAMPLE: &str = "\
Examples:
  hedgehop height area.hop -105.54 40.38
  hedgehop height area.hop -105.54,40.38 -105.60,40.33
  hedgehop height area.hop 455120 4470300 455180 4470300 --xy
  hedgehop height area.hop -105.54 40.38 --bare";

/// Say how high the ground is, and what it is made of, at places of a database.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLE, after_long_help = format!("{EXAMPLE}\n\n{}", exit::HELP))]
pub struct HeightArgs {
    /// Database to ask
    #[arg(value_name = "AREA.hop")]
    file: DatabaseName,

    /// Longitude and latitude of each place, degrees (WGS 84), with a blank or a comma between; of local databases x and y
    #[arg(value_name = "LON LAT", value_parser = args::number, required = true, allow_negative_numbers = true, num_args = 2..)]
    places: Vec<f64>,

    /// Places are x and y, metres of the database's reference system
    #[arg(long)]
    xy: bool,

    /// Tell bare ground, below roofs, crowns and bridges
    #[arg(long)]
    bare: bool,

    #[command(flatten)]
    cache: CacheArgs,

    /// Print one JSON array
    #[arg(long)]
    json: bool,
}

/// The program's arguments, with the numbers of a place of this command apart if there is a comma between: clap would take those that begin with a minus for a flag.
pub fn apart(args: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let args: Vec<OsString> = args.into_iter().collect();
    if args.get(1).is_none_or(|command| command != "height") {
        return args;
    }
    let split = |arg: OsString| match arg.to_str().and_then(numbers) {
        Some(numbers) => numbers.into_iter().map(OsString::from).collect(),
        None => vec![arg],
    };
    args.into_iter().flat_map(split).collect()
}

/// Numbers with commas between, the last of which may be before a blank; `None`: it is something else.
fn numbers(text: &str) -> Option<Vec<String>> {
    let (first, rest) = text.split_once(',')?;
    let all = std::iter::once(first).chain(rest.split(',').filter(|_| !rest.is_empty()));
    all.map(|one| args::number(one).ok().map(|_| one.trim().to_owned())).collect()
}

/// Runs the command.
pub fn run(args: &HeightArgs) -> Outcome {
    let (pairs, rest) = args.places.as_chunks::<2>();
    if !rest.is_empty() {
        let what = format!(
            "places are pairs of numbers, not {} of them: longitude and latitude of each",
            args.places.len()
        );
        return Err(Error::Configuration(what).into());
    }

    let source = args.cache.open(&args.file)?;
    let places = Places::new(&source, args.xy)?;
    let ground = if args.bare { Ground::Bare } else { Ground::Highest };
    let metadata = &source.header().metadata;
    let (mut samples, mut materials) = (Vec::with_capacity(pairs.len()), Vec::with_capacity(pairs.len()));

    for pair in pairs {
        let place = places.find(*pair)?;
        samples.push(Sample { distance: 0.0, place, ground: ground.height_at(&source, place)? });
        let material = ground.attributes_at(&source, place)?.map(|found| found.material);
        let material = material.filter(|number| *number > 0);
        materials.push(material.map(|number| metadata.material_name(number)));
    }

    if args.json {
        let all: Vec<_> = samples
            .iter()
            .zip(&materials)
            .map(|(sample, material)| {
                let mut json = places.json(sample);
                json.as_object_mut().map(|json| json.remove("distance_m"));
                json["material"] = serde_json::json!(material);
                json
            })
            .collect();
        return Ok(exit::print(&format!("{:#}\n", serde_json::Value::from(all)))?);
    }

    let datum = &metadata.vertical_datum;
    let mut text = String::new();
    for (sample, material) in samples.iter().zip(&materials) {
        let material = material.as_ref().map(|name| format!(", {name}")).unwrap_or_default();
        let name = places.name(sample.place);
        // Writing to a string does not fail.
        let _ = match sample.ground {
            Some(height) => writeln!(text, "{name}  {height:.2} m above {datum}{material}"),
            None => writeln!(text, "{name}  no ground: a gap of the data"),
        };
    }

    Ok(exit::print(&text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_come_apart_at_their_commas_and_nothing_else_does() {
        let given = |text: &str| -> Vec<String> {
            let apart = apart(text.split_whitespace().map(OsString::from));
            apart.into_iter().map(|arg| arg.into_string().expect("it was text")).collect()
        };
        let wanted = "hedgehop height a,b.hop -105.54 40.38 1e3 -2 5 6 --xy";
        let wanted: Vec<_> = wanted.split_whitespace().collect();
        assert_eq!(given("hedgehop height a,b.hop -105.54,40.38 1e3,-2 5, 6 --xy"), wanted);
        for whole in ["hedgehop sight a.hop --from 1,2,3", "hedgehop height 1,x ,2 1,,2 --", "hedgehop"] {
            assert_eq!(given(whole), whole.split_whitespace().collect::<Vec<_>>());
        }
    }
}
