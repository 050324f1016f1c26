//! Features and models that stand on level ground.

use super::replay::Replay;

pub fn squares_of_man_made(inputs: &Replay) {
    let table: [(&str, &str, &[f64]); 3] = [
        ("tower_parts.geojson", "676080 5228080 676065 5228065", &[160.0, 115.0]),
        ("square_tower.geojson", "676060.7 5228060.7 676065 5228065", &[134.0, 140.0]),
        ("square_silo.geojson", "676061 5228061", &[120.0]),
    ];
    for (file, places, expected) in table {
        inputs.built(&format!("--elevation ground100.tif --features {file}"));
        inputs.heights(&format!("--xy {places}"), expected, 1.0);
    }
}

pub fn small_faults_of_features(inputs: &Replay) {
    inputs.borrow("man_made_area", "ground100.tif");
    let build =
        |file: &str| format!("build --elevation ground100.tif --features {file} -o built.hop --overwrite");
    for (file, middle) in
        [("levels0.geojson", 103.0), ("levels0_roof5.geojson", 105.0), ("hedge_area.geojson", 102.0)]
    {
        inputs.done(&build(file));
        inputs.heights("--xy 676080 5228070", &[middle], 0.5);
    }

    // 150 m wide: to both sides of its middle line.
    inputs.done(&build("road_wide.geojson"));
    let told =
        inputs.done("height built.hop --xy 676080 5228070 676080 5228082 676080 5228150 676080 5228218");
    let of_road: Vec<bool> = told.lines().map(|line| line.ends_with("asphalt")).collect();
    assert_eq!(of_road, [false, true, true, true], "{told}");

    // The ridge goes across the length of 40 m: eaves at 106 m at the ends of it, 108 m between, 110 m in the middle.
    inputs.done(&build("hipped_across.geojson"));
    inputs.heights("--xy 676080 5228070 676080 5228075 676090 5228070", &[110.0, 110.0, 108.0], 0.2);
    inputs.done(&build("pylon45.geojson"));
    inputs.heights("11.324332698 47.18325742", &[145.0], 0.2);
}

pub fn air_between_parts(inputs: &Replay) {
    inputs.done("build st.toml -o built.hop");
    let told = inputs.done("sight built.hop --xy --from 70.4,50,3 --to 70.4,80,3");
    assert!(!told.contains("hides"), "{told}");
}
