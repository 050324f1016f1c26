//! Heights of the ground along a line, and whether one of its ends sees the other.
//!
//!     cargo run --release -- demo
//!     cargo run --release --example 2_ask_the_ground
//!     cargo run --release --example 2_ask_the_ground -- AREA.hop

#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::path::PathBuf;

use hedgehop::memory::PageFile;
use hedgehop::raymarch::{GridRay, LevelBands, Marcher, Surface, ground_height};
use hedgehop::voxel::{HeightRange, PageSource};

const POINTS: u32 = 24;
/// Height of a mast at each end, metres.
const MAST: f64 = 30.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let database = std::env::args_os().nth(1).map_or("hedgehop-demo/valley.hop".into(), PathBuf::from);
    let area = PageFile::open(&database)?;
    let header = area.header();
    let HeightRange { low, high } = header.height_range;

    // From west to east through the middle of the area, a tenth away from its edges.
    let (near, far) = (header.grid.origin, header.grid.far_corner());
    let middle = 0.5 * (near.y + far.y);
    let (west, east) = (near.lerp(far, 0.1).with_y(middle), near.lerp(far, 0.9).with_y(middle));

    // The finest surface, bilinear between posts. `None`: outside the area, or no surface there.
    for point in 0..POINTS {
        let place = west.lerp(east, f64::from(point) / f64::from(POINTS - 1));
        match ground_height(&area, place)? {
            Some(height) => {
                let bar = "#".repeat((60.0 * (height - low) / (high - low).max(1.0)) as usize);
                println!("{:10.1} {height:8.1} m  {bar}", place.x);
            }
            None => println!("{:10.1}  no surface", place.x),
        }
    }

    // Line of sight: march one ray on the finest level and see where it ends.
    let (Some(here), Some(there)) = (ground_height(&area, west)?, ground_height(&area, east)?) else {
        return Ok(());
    };

    let (eye, target) = (west.extend(here + MAST), east.extend(there + MAST));
    let ray = GridRay::new(&header.grid, eye, (target - eye).normalize());
    let mut marcher = Marcher::new(&area, LevelBands::finest_only(), Surface::Smooth);
    let distance = eye.distance(target);
    match marcher.first_contact(&ray, 0.0)?.filter(|contact| contact.range < distance) {
        Some(contact) => println!("the ground hides the other mast, {:.0} m from here", contact.range),
        None => println!("the masts see each other over {distance:.0} m"),
    }

    Ok(())
}
