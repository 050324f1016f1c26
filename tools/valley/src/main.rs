//! Makes the sample in `data/`: elevation, imagery and a path of a synthetic valley.
//!
//! `cargo run --release -p hedgehop-valley -- data` writes the three files there and prints their hashes.

mod geotiff;
mod grid;
mod land;
mod noise;
mod palette;
mod path;
mod roads;
mod terrain;
#[cfg(test)]
mod tests;
mod village;
mod water;

use std::error::Error;
use std::path::PathBuf;

/// The files' names and contents.
type Files = [(&'static str, Vec<u8>); 3];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: hedgehop-valley FOLDER")?);
    for (name, bytes) in files(&valley())? {
        std::fs::write(folder.join(name), &bytes)?;
        #[expect(clippy::print_stdout, reason = "a program's answer")]
        {
            println!("{}  {name}  {} bytes", blake3::hash(&bytes), bytes.len());
        }
    }
    Ok(())
}

/// The valley, as it is drawn.
fn valley() -> land::Valley {
    let mut terrain = terrain::build();
    let water = water::carve(&mut terrain);
    let roads = roads::lay_out();
    roads::grade(&mut terrain, &water, &roads);
    land::cover(&terrain, &water, &roads)
}

fn files(valley: &land::Valley) -> Result<Files, Box<dyn Error>> {
    let places = path::fly(&valley.surface);
    let heights: Vec<f32> = valley.surface.iter().map(|&height| height as f32).collect();
    Ok([
        ("valley-elevation.tif", geotiff::encode(&geotiff::Samples::Heights(&heights))?),
        ("valley-imagery.tif", geotiff::encode(&geotiff::Samples::Colours(&valley.colours))?),
        ("valley-path.csv", path::to_csv(&places).into_bytes()),
    ])
}
