//! Patterns below the voxel that are matched from finer imagery.

use std::fs;
use std::path::Path;

use hedgehop::detail::MOST_DEVIATION;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::voxel::{DetailRecord, PageSource};
use hedgehop_base::chance;
use hedgehop_modeling::build;
use hedgehop_modeling::recipe::Recipe;
use image::{Rgb, RgbImage};
use tempfile::TempDir;

/// Side of the area, metres: voxels of 1 m, pixels of 0.25 m.
const SIDE: u32 = 160;

/// Picture with pixels of a side, whose western half is smooth and whose eastern half has stripes from south to north below the voxel.
fn picture(folder: &Path, name: &str, pixel: f64) {
    let pixels = (f64::from(SIDE) / pixel) as u32;
    let picture = RgbImage::from_fn(pixels, pixels, |x, y| {
        let number = u64::from(y) * u64::from(pixels) + u64::from(x);
        let voxel = ((f64::from(y) * pixel) as u64 * 1000) + (f64::from(x) * pixel) as u64;
        let grain = chance::unit(number) - 0.5;
        let patch = chance::unit(voxel + (1 << 40)) - 0.5;
        let level = match x < pixels / 2 {
            true => 120.0 + 4.0 * grain + 4.0 * patch,
            false => 120.0 + 40.0 * patch + if x / 2 % 2 == 0 { 30.0 } else { -30.0 },
        };
        Rgb([level as u8; 3])
    });
    picture.save(folder.join(format!("{name}.png"))).unwrap();
    let first = 0.5 * pixel;
    let world = format!("{pixel}\n0\n0\n-{pixel}\n{first}\n{}\n", f64::from(SIDE) - first);
    fs::write(folder.join(format!("{name}.pgw")), world).unwrap();
}

/// Recipe of flat ground under a picture.
fn recipe(folder: &Path, picture: &str, detail: &str) -> Recipe {
    let text = format!(
        "[place]\nlocal = true\nspacing_m = 1\nbbox = [0, 0, {SIDE}, {SIDE}]\noutput = \"a.hop\"\n\
         [[terrain]]\nkind = \"plane\"\nheight_m = 0\n[[imagery]]\nfile = \"{picture}.png\"\n{detail}"
    );
    let path = folder.join("place.toml");
    fs::write(&path, text).unwrap();
    Recipe::read(&path).unwrap()
}

fn record(folder: &Path, picture: &str, detail: &str) -> hedgehop::Result<DetailRecord> {
    let mut options = recipe(folder, picture, detail).options;
    options.overwrite = true;
    build(&options, &Silent)?;
    Ok(PageFile::open(&options.output).unwrap().header().metadata.detail.clone().unwrap())
}

#[test]
fn patterns_are_those_of_the_imagery_by_roughness() {
    let folder = TempDir::new().unwrap();
    picture(folder.path(), "fine", 0.25);
    let found = record(folder.path(), "fine", "[detail]\nimagery = \"match\"\n").unwrap();
    let matched = found.matched.unwrap();
    let classes = matched.classes();
    assert!(classes.len() > 1 && classes[0].least == 0.0, "{}", classes.len());

    // The roughest has the stripes: light changes across them, and hardly along them.
    let cells = classes.last().unwrap().cells();
    let change = |step: [i64; 2]| -> f64 {
        let places = (0..255).flat_map(|row| (0..255).map(move |column| [column, row]));
        places.map(|[x, y]| (cells.at(x + step[0], y + step[1]) - cells.at(x, y)).powi(2)).sum()
    };
    assert!(change([7, 0]) > 2.0 * change([0, 7]), "{} {}", change([7, 0]), change([0, 7]));

    // No ground becomes black, and it is of the next class from that one's bound on.
    for (number, class) in classes.iter().enumerate() {
        let most = classes.get(number + 1).map_or(MOST_DEVIATION, |next| next.least.min(MOST_DEVIATION));
        let darkest = class.cells().values().iter().fold(0.0_f64, |least, value| least.min(*value));
        assert!(darkest * f64::from(most) > -0.81, "{number}: {darkest} at {most}");
    }

    // Examples beside the place do as well, and the same build gives the same pattern.
    picture(folder.path(), "coarse", 1.0);
    let detail = "[detail.imagery]\npattern = \"match\"\nexamples = \"fine.png\"\n";
    let one = record(folder.path(), "coarse", detail).unwrap();
    assert_eq!(record(folder.path(), "coarse", detail).unwrap(), one);
    let bare = "[detail.imagery]\npattern = \"match\"\nexamples = \"fine.png\"\npixel_m = 0.25\n";
    assert_eq!(record(folder.path(), "coarse", bare).unwrap(), one);
}

#[test]
fn too_little_to_match_from_is_told() {
    let folder = TempDir::new().unwrap();
    picture(folder.path(), "coarse", 1.0);
    let refused = |detail: &str| record(folder.path(), "coarse", detail).unwrap_err().to_string();
    let told = refused("[detail]\nimagery = \"match\"\n");
    assert!(told.contains("twice as fine as the voxels of 1 m") && told.contains("pixels of 1 m"), "{told}");

    let small = RgbImage::from_pixel(40, 40, Rgb([90; 3]));
    small.save(folder.path().join("small.png")).unwrap();
    let told = refused("[detail.imagery]\npattern = \"match\"\nexamples = \"small.png\"\npixel_m = 0.25\n");
    assert!(told.contains("no area of 30 by 30 voxels"), "{told}");

    let even = RgbImage::from_pixel(400, 400, Rgb([90; 3]));
    even.save(folder.path().join("even.png")).unwrap();
    let told = refused("[detail.imagery]\npattern = \"match\"\nexamples = \"even.png\"\npixel_m = 0.25\n");
    assert!(told.contains("more than one brightness"), "{told}");
}
