//! Records of all that a database was made of.
//!
//! ```text
//! elevation, clouds first │ imagery │ land cover │ features │ models │ scatters │ shapes of the ground
//! ```
//! A voxel knows its elevation by the place in this list. Where there is no elevation at all it says the first place: shapes come first then, and of these the plane below all others.

use std::path::Path;

use glam::DVec2;

use super::inputs::{FeatureInput, Inputs};
use super::materials::Materials;
use super::object::{BuiltIn, ScatterFile, ScatterForm};
use super::options::BuildOptions;
use super::synthetic::Terrain;
use crate::naming::{crs_label, file_name};
use crate::survey_result::Survey;
use hedgehop::voxel::{Grid, SourceRecord};

/// Kinds of shapes by their names in recipes; a plane lies below all others.
const KINDS: [&str; 8] = ["plane", "fractal", "ridge", "valley", "cone", "dome", "plateau", "pond"];

/// All sources of a build in order.
pub(super) fn records(inputs: &Inputs, options: &BuildOptions, grid: &Grid) -> Vec<SourceRecord> {
    let mut records: Vec<SourceRecord> =
        inputs.elevation.iter().map(|raster| raster.record("elevation")).collect();
    let shapes = shapes(&options.synthetic.terrain);
    let (first, last) = if records.is_empty() { (shapes, Vec::new()) } else { (Vec::new(), shapes) };
    records.extend(first);
    records.extend(inputs.imagery.iter().map(|raster| raster.record("imagery")));
    records.extend(inputs.land_cover.iter().map(|raster| raster.record("land cover")));
    records.extend(inputs.features.iter().map(|FeatureInput { layer, .. }| {
        let description = format!("{}, {}", counted(layer.rows.len(), "row"), crs_label(&layer.crs));
        record(file_name(&layer.path), "features", description)
    }));
    records.extend(models(options, grid));
    records.extend(options.scatters.iter().map(|scatter| scattered(scatter, &options.materials)));
    records.extend(last);
    records
}

fn record(file: String, role: &str, description: String) -> SourceRecord {
    SourceRecord { file, role: role.into(), description }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Files of models in the order of their first objects, each once, with how many of their places lie in the area.
fn models(options: &BuildOptions, grid: &Grid) -> Vec<SourceRecord> {
    let mut files: Vec<(&Path, usize)> = Vec::new();
    for object in &options.objects {
        let inside = object.places.iter().filter(|place| grid.contains(DVec2::from_array(**place))).count();
        for path in &object.paths {
            match files.iter_mut().find(|(known, _)| known == path) {
                Some((_, places)) => *places += inside,
                None => files.push((path.as_path(), inside)),
            }
        }
    }
    let told = files.into_iter().map(|(path, places)| {
        let description = format!("stands at {}", counted(places, "place"));
        record(file_name(path), "model", description)
    });
    told.collect()
}

/// A scatter by its forms.
fn scattered(scatter: &ScatterFile, materials: &Materials) -> SourceRecord {
    let form = |form: &ScatterForm| match form {
        ScatterForm::File(path) => file_name(path),
        ScatterForm::BuiltIn(form) => name(*form).to_owned(),
    };
    let forms: Vec<String> = scatter.forms.iter().map(form).collect();
    let mut description = format!("about {} m apart", (scatter.spacing_m * 10.0).round() / 10.0);

    match scatter.scale {
        [1.0, 1.0] => {}
        [least, greatest] if least == greatest => description += &format!(", scaled by {least}"),
        [least, greatest] => description += &format!(", scaled by {least} to {greatest}"),
    }

    if !scatter.grounds.is_empty() {
        let grounds = materials.records(scatter.grounds.iter().map(|ground| ground.code()));
        let names: Vec<String> = grounds.into_iter().map(|ground| ground.name).collect();
        description += &format!(", on {}", names.join(", "));
    }

    if let Some(area) = &scatter.area {
        description += &format!(", within {}", file_name(area));
    }

    record(forms.join(", "), "scatter", description)
}

/// Returns the name of a built-in form in recipes.
fn name(form: BuiltIn) -> &'static str {
    match form {
        BuiltIn::Broadleaf => "broadleaf",
        BuiltIn::Conifer => "conifer",
        BuiltIn::Shrub => "shrub",
        BuiltIn::Rock => "rock",
    }
}

/// Shapes of the ground by their kinds.
fn shapes(terrain: &[Terrain]) -> Vec<SourceRecord> {
    let count = |kind: &str| terrain.iter().filter(|shape| self::kind(shape) == kind).count();
    let counts = KINDS.into_iter().map(|kind| (kind, count(kind))).filter(|(_, count)| *count > 0);
    counts.map(|(kind, count)| record(kind.to_owned(), "terrain", counted(count, "shape"))).collect()
}

fn kind(shape: &Terrain) -> &'static str {
    match shape {
        Terrain::Plane { .. } => "plane",
        Terrain::Fractal { .. } => "fractal",
        Terrain::Ridge { height_m, .. } if *height_m < 0.0 => "valley",
        Terrain::Ridge { .. } => "ridge",
        Terrain::Cone { .. } => "cone",
        Terrain::Dome { .. } => "dome",
        Terrain::Plateau { .. } => "plateau",
        Terrain::Pond { .. } => "pond",
    }
}

/// Says which roughness detail takes from which elevation, a sentence for each that has heights; of so many clouds the first one stands for all.
pub(super) fn roughness(surveys: &[Survey], sources: &[SourceRecord], clouds: usize) -> Vec<String> {
    let told = surveys.iter().zip(sources).enumerate().filter(|(_, (survey, _))| survey.range.is_some());
    let sentence = |(index, (survey, source)): (usize, (&Survey, &SourceRecord))| {
        let others = if index == 0 && clouds > 1 { " and the other clouds" } else { "" };
        format!(
            "detail goes on with the roughness of {}{others}, {:.2}",
            source.file,
            survey.energies.roughness()
        )
    };
    told.map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::object::ObjectFile;
    use crate::synthetic::Circle;
    use hedgehop::voxel::Material;

    fn told(options: &BuildOptions) -> Vec<String> {
        let grid = Grid { nx: 10, ny: 10, spacing: 10.0, origin: DVec2::ZERO };
        let records = records(&Inputs::default(), options, &grid);
        records.iter().map(|own| format!("{} {}: {}", own.role, own.file, own.description)).collect()
    }

    #[test]
    fn what_no_raster_holds_is_told_by_kind() {
        let mut options = BuildOptions::new(Vec::new(), Vec::new(), "a.hop".into());
        let circle = Circle { centre: DVec2::ZERO, radius_m: 10.0 };
        let dome = Terrain::Dome { circle, height_m: 3.0 };

        let ridge = |height_m: f64| Terrain::Ridge {
            line: vec![DVec2::ZERO, DVec2::X],
            width_m: 9.0,
            crest_m: 1.0,
            height_m,
        };
        let plane = Terrain::Plane { height_m: 0.0, centre: DVec2::ZERO, slope: 0.0, upward_deg: 0.0 };
        options.synthetic.terrain = vec![ridge(-2.0), dome.clone(), plane, ridge(2.0), dome];

        let object = |paths: &[&str], count: usize| ObjectFile {
            paths: paths.iter().map(Into::into).collect(),
            // One more lies outside.
            places: std::iter::once([-5.0; 2]).chain(vec![[5.0; 2]; count]).collect(),
            ..ObjectFile::default()
        };
        options.objects = vec![
            object(&["m/barn.obj"], 1),
            object(&["m/tower.glb", "m/barn.obj"], 2),
            object(&["x.vox"], 1),
        ];
        let forms = vec![ScatterForm::BuiltIn(BuiltIn::Conifer), ScatterForm::File("m/bush.obj".into())];

        let scatter = ScatterFile {
            forms,
            spacing_m: 100.0 / 3.0,
            scale: [0.5, 1.5],
            grounds: vec![Material::Grass, Material::Rock],
            area: Some("maps/park.geojson".into()),
            ..ScatterFile::default()
        };

        options.scatters = vec![
            scatter,
            ScatterFile {
                forms: vec![ScatterForm::BuiltIn(BuiltIn::Rock)],
                scale: [2.0; 2],
                ..ScatterFile::default()
            },
        ];

        let wanted = [
            "terrain plane: 1 shape",
            "terrain ridge: 1 shape",
            "terrain valley: 1 shape",
            "terrain dome: 2 shapes",
            "model barn.obj: stands at 3 places",
            "model tower.glb: stands at 2 places",
            "model x.vox: stands at 1 place",
            "scatter conifer, bush.obj: about 33.3 m apart, scaled by 0.5 to 1.5, on grass, rock, within park.geojson",
            "scatter rock: about 10 m apart, scaled by 2",
        ];

        assert_eq!(told(&options), wanted);
    }

    #[test]
    fn names_are_those_of_recipes() {
        for form in [BuiltIn::Broadleaf, BuiltIn::Conifer, BuiltIn::Shrub, BuiltIn::Rock] {
            assert_eq!(BuiltIn::of(name(form)), Some(form));
        }
    }

    #[test]
    fn the_roughness_is_that_of_a_named_source() {
        let seen = Survey { range: Some((0.0, 1.0)), ..Survey::default() };
        let surveys = [seen.clone(), Survey::default(), seen.clone()];
        let sources = ["a.laz", "b.laz", "c.tif", "d.tif"].map(|file| record(file.into(), "", String::new()));
        let told = roughness(&surveys, &sources, 2);
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("of a.laz and the other clouds, 0."), "{told:?}");
        assert!(told[1].contains("of c.tif, 0."), "{told:?}");
        assert!(roughness(&surveys[..1], &sources, 1)[0].contains("of a.laz, 0."));
    }
}
