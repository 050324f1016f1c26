//! Shadows that are baked again.

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::AtomicU64;

use super::{CORNER, Impatient, PAGES, TOWN, bytes, houses, options, site, updated};
use hedgehop::Error;
use hedgehop::memory::PageFile;
use hedgehop::progress::Silent;
use hedgehop::sunlight::Sun;
use hedgehop_modeling::{
    Baked, Baking, BuildOptions, Corridor, Place, Route, bake_shadows, build, is_own_work,
};

/// Bakes shadows again into what was built, and holds the result against all of them baked beside it.
fn shaded(options: &BuildOptions, sun: Sun) -> Baked {
    updated(options);
    let source = PageFile::open(&options.output).unwrap();
    let [output, clean] = ["shaded", "clean"].map(|name| options.output.with_extension(name));
    let (directory, threads) = (source.directory(), options.threads);
    let baking =
        Baking { source: &source, directory, sun, output: &output, overwrite: true, steps: true, threads };
    let baked = bake_shadows(&baking, &Silent).unwrap();
    let whole = bake_shadows(&Baking { output: &clean, steps: false, ..baking }, &Silent).unwrap();
    assert_eq!((whole.reused, whole.pages, whole.bytes), (0, baked.pages, baked.bytes));
    assert!(bytes(&output) == bytes(&clean), "the same bytes");
    assert!(
        is_own_work(&output) && PageFile::open(&output).unwrap().verify(&Silent).unwrap().problems.is_empty()
    );
    baked
}

#[test]
fn shadows_are_baked_again_where_they_fall_otherwise() {
    let folder = site();
    let mut options = options(folder.path(), "a.hop");
    let sun = Sun { azimuth: 180.0, elevation: 40.0 };
    let first = shaded(&options, sun);
    assert_eq!(first.reused, 0);
    assert_eq!(shaded(&options, sun).reused, first.pages);

    // A house in the easternmost pages: its own with bare ground, those about it and the coarser ones, whose aprons may have it. Rays to others pass over it,
    // and nothing comes of that.
    let mut town = TOWN;
    town[2].2 = 7.5;
    houses(folder.path(), &town);
    let edited = shaded(&options, sun);
    let baked = edited.pages - edited.reused;
    assert!((1..=11).contains(&baked) && edited.pages > PAGES, "{baked} of {}", edited.pages);

    // It lies in the light of all that is north of it.
    let low = Sun { azimuth: 180.0, elevation: 1.0 };
    assert_eq!(shaded(&options, low).reused, 0, "another sun");
    town[2].2 = 8.5;
    houses(folder.path(), &town);
    let long = shaded(&options, low);
    assert!(long.pages - long.reused > baked && long.reused > 0, "{} of {}", long.reused, long.pages);

    // Where coarse pages have no finer ones.
    let place = |x: f64, y: f64| Place::Xy(CORNER.0 + x, CORNER.1 + y);
    let route =
        Route { file: PathBuf::from("route.csv"), places: vec![place(0.0, 300.0), place(1280.0, 300.0)] };
    options.corridors = vec![Corridor { route, width: 200.0, spacing: 1.0 }];
    let strip = shaded(&options, sun);
    assert!(strip.reused < strip.pages);
    town[2].2 = 6.5;
    houses(folder.path(), &town);
    let strip = shaded(&options, sun);
    assert!(strip.reused > 0 && strip.reused < strip.pages, "{} of {}", strip.reused, strip.pages);
}

#[test]
fn interrupted_shadows_go_on() {
    let folder = site();
    let options = options(folder.path(), "a.hop");
    build(&options, &Silent).unwrap();
    let source = PageFile::open(&options.output).unwrap();
    let output = options.output.with_extension("shaded");

    let baking = Baking {
        source: &source,
        directory: source.directory(),
        sun: Sun { azimuth: 100.0, elevation: 20.0 },
        output: &output,
        overwrite: false,
        steps: true,
        threads: 2,
    };

    let stopped = bake_shadows(&baking, &Impatient { left: AtomicU64::new(12) });
    assert!(matches!(stopped, Err(Error::Interrupted(_))) && !output.exists());
    let baked = bake_shadows(&baking, &Silent).unwrap();
    assert!(baked.reused > 0 && baked.reused < baked.pages, "{} of {}", baked.reused, baked.pages);
    let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(names.into_iter().all(|name| !name.to_string_lossy().contains("part-")), "nothing is left");
}
