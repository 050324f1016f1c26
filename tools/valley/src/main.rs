//! Makes the sample in `data/`: ground, imagery, maps, a scan, models and a path of a synthetic valley.
//!
//! `cargo run --release -p hedgehop-valley -- data` writes the files there and prints their hashes.

mod airfield;
#[cfg(test)]
mod airfield_tests;
mod chapel;
mod farm;
mod features;
mod geopackage;
mod geotiff;
mod gravel;
mod grid;
mod land;
mod land_cover;
mod map;
#[cfg(test)]
mod map_tests;
mod mesh;
#[cfg(test)]
mod model_tests;
mod noise;
mod outline;
mod palette;
mod path;
mod roads;
mod sample;
mod scan;
mod shapefile;
mod sites;
mod terrain;
#[cfg(test)]
mod tests;
mod village;
mod vineyard;
mod voxels;
mod water;

use std::error::Error;
use std::path::PathBuf;

use crate::geopackage::FeatureTable;
use crate::sample::Sample;

/// The files' names and contents.
type Files = [(&'static str, Vec<u8>); 14];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: hedgehop-valley FOLDER")?);
    for (name, bytes) in files(&sample())? {
        std::fs::write(folder.join(name), &bytes)?;
        #[expect(clippy::print_stdout, reason = "a program's answer")]
        {
            println!("{}  {name}  {} bytes", blake3::hash(&bytes), bytes.len());
        }
    }
    Ok(())
}

/// The valley, as it is drawn.
fn sample() -> Sample {
    let mut terrain = terrain::build();
    let water = water::carve(&mut terrain);
    let roads = roads::lay_out();
    let natural = terrain.ground.clone();
    roads::grade(&mut terrain, &water, &roads);
    let mut bare = terrain.ground.clone();
    roads::open_bridges(&mut bare, &natural, &water, &roads);
    let valley = land::cover(&terrain, &bare, &water, &roads);
    Sample { water, roads, valley }
}

fn files(sample: &Sample) -> Result<Files, Box<dyn Error>> {
    let valley = &sample.valley;
    let places = path::fly(&valley.surface);
    let heights: Vec<f32> = valley.bare.iter().map(|&height| height as f32).collect();
    let classes: Vec<u8> = valley.classes.iter().map(|&class| class as u8).collect();
    let airfield = [
        FeatureTable { name: "buildings", features: airfield::buildings() },
        FeatureTable { name: "grounds", features: airfield::grounds() },
        FeatureTable { name: "ways", features: airfield::ways() },
    ];
    let vineyard = shapefile::encode(&vineyard::draw())?;

    Ok([
        ("valley-elevation.tif", geotiff::encode(&geotiff::Samples::Heights(&heights))?),
        ("valley-imagery.tif", geotiff::encode(&geotiff::Samples::Colours(&valley.colours))?),
        ("valley-land-cover.tif", geotiff::encode(&geotiff::Samples::Classes(&classes))?),
        ("valley-map.geojson", features::to_geojson(&map::draw(sample)).into_bytes()),
        ("valley-scan.laz", scan::encode(&scan::take(valley))?),
        ("valley-path.csv", path::to_csv(&places).into_bytes()),
        ("valley-chapel.glb", mesh::encode("chapel", &chapel::build())?),
        ("valley-gravel.vox", voxels::encode(&gravel::build(), &gravel::COLOURS)?),
        ("valley-vineyard.shp", vineyard.shp),
        ("valley-vineyard.shx", vineyard.shx),
        ("valley-vineyard.dbf", vineyard.dbf),
        ("valley-vineyard.prj", vineyard.prj),
        ("valley-vineyard.cpg", vineyard.cpg),
        ("valley-airfield.gpkg", geopackage::encode(&airfield)?),
    ])
}
