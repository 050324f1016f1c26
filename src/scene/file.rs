//! The file: its tables, and what they may hold.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::camera::{CameraTable, read_cameras};
use super::light::{LightTable, MOST_LAMPS, light};
use super::model::Models;
use super::object::object;
use super::picture::{HudTable, PictureTable};
use super::plume::{PlumeTable, plume};
use super::sun::{NightTable, SunTable};
use super::titling::{CaptionTable, OverlayTable, read_captions};
use super::trail::{TrailTable, trail};
use super::weather_tables::{
    AirTable, CloudsTable, FogTable, GroundTable, PrecipitationTable, WeatherTables,
};
use super::{Light, Object, Plume, Scene};
use crate::scene::contents::BETWEEN;
use crate::scene::object_table::ObjectTable;
use hedgehop_base::document::{Kind, Reading, plain};
use hedgehop_base::error::{Error, Result};

const SCENE: Kind = Kind { name: "scene", manual: "docs/scene.md" };

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a scene")]
struct SceneTable {
    sun: Option<SunTable>,
    night: Option<NightTable>,
    air: Option<AirTable>,
    fog: Option<FogTable>,
    clouds: Option<CloudsTable>,
    precipitation: Option<PrecipitationTable>,
    ground: Option<GroundTable>,
    picture: Option<PictureTable>,
    hud: Option<HudTable>,
    overlay: Option<OverlayTable>,
    #[serde(default)]
    caption: Vec<Spanned<CaptionTable>>,
    #[serde(default)]
    object: Vec<Spanned<ObjectTable>>,
    #[serde(default)]
    light: Vec<Spanned<LightTable>>,
    #[serde(default)]
    plume: Vec<Spanned<PlumeTable>>,
    #[serde(default)]
    camera: Vec<Spanned<CameraTable>>,
    #[serde(default)]
    trail: Vec<Spanned<TrailTable>>,
}

impl Scene {
    /// Reads a scene file, and the tracks and models that it names.
    ///
    /// # Errors
    /// [`Error::Io`] if a file cannot be read; [`Error::Invalid`] with line and key if the scene holds something
    /// wrong; what [`crate::flight::read_track`] says of a track;
    /// what is wrong with a model, with its file and place.
    pub fn read(path: &Path) -> Result<Self> {
        read(path)
    }
}

/// Reads a scene file, table by table.
fn read(path: &Path) -> Result<Scene> {
    let mut hasher = blake3::Hasher::new();
    let (reading, table): (_, SceneTable) = Reading::open(path, SCENE, &mut hasher)?;
    let lines = table.sun.as_ref().map(|sun| sun.lines(&reading)).unwrap_or_default();
    let shadows = table.sun.as_ref().and_then(SunTable::shadows);
    let sun = table.sun.map_or(Ok(None), |sun| sun.read(&reading))?;
    let night = table.night.unwrap_or_default().read(&reading)?;

    let weather = WeatherTables {
        air: table.air.unwrap_or_default(),
        fog: table.fog,
        clouds: table.clouds,
        precipitation: table.precipitation,
        ground: table.ground.unwrap_or_default(),
    };
    let visibility = weather.air.read_visibility(&reading)?;
    let weather = weather.read(&reading, sun.is_some())?;

    let finish = table.picture.unwrap_or_default().read(&reading)?;
    let hud = table.hud.map(|hud| hud.read(&reading)).transpose()?;
    let mut titling = table.overlay.unwrap_or_default().read(&reading, hud, &mut hasher)?;
    titling.captions = read_captions(&reading, &table.caption)?;

    let objects = read_objects(&reading, table.object, &mut hasher)?;
    let lights = read_lights(&reading, &table.light)?;
    let plumes = read_plumes(&reading, table.plume)?;
    let numbered = table.trail.iter().zip(1..);
    let fixes = |name: &str| {
        let object = objects.iter().find(|object| object.name == name)?;
        Some(object.track.fixes.len())
    };
    let trails = numbered.map(|(table, number)| trail(&reading, table, number, &fixes, &mut hasher));
    let trails = trails.collect::<Result<_>>()?;

    let mut scene = Scene {
        path: path.to_owned(),
        digest: hasher.finalize().to_hex().to_string(),
        sun,
        shadows,
        night,
        lines,
        visibility,
        weather,
        finish,
        titling,
        objects,
        lights,
        plumes,
        trails,
        cameras: Vec::new(),
    };
    let names: BTreeSet<String> = scene.names().collect();
    scene.cameras = read_cameras(&reading, &table.camera, &names)?;
    Ok(scene)
}

/// Reads all objects with their models and tracks, and sorts them by name; `hasher` takes all files that they name.
fn read_objects(
    reading: &Reading<'_>,
    tables: Vec<Spanned<ObjectTable>>,
    hasher: &mut blake3::Hasher,
) -> Result<Vec<Object>> {
    let mut objects: BTreeMap<String, Object> = BTreeMap::new();
    let mut models = Models::default();
    for table in tables {
        let span = table.span();
        let object = object(reading, table, &mut models, hasher)?;
        if objects.contains_key(&object.name) {
            let what = format!("there is an object `{}` already; names tell objects apart", object.name);
            return Err(reading.wrong(span, what));
        }
        objects.insert(object.name.clone(), object);
    }

    for object in objects.values() {
        for part in &object.parts {
            let name = format!("{}{BETWEEN}{}", object.name, part.name);
            if objects.contains_key(&name) {
                let what = format!("there is an object `{name}`, too; names tell objects and parts apart");
                return Err(Error::invalid(reading.path, format!("line {}: {}", part.line, plain(&what))));
            }
        }
    }

    Ok(objects.into_values().collect())
}

/// Reads all lights; together they have [`MOST_LAMPS`] at most.
fn read_lights(reading: &Reading<'_>, tables: &[Spanned<LightTable>]) -> Result<Vec<Light>> {
    let mut lights = Vec::new();
    let mut lamps = 0;
    for (index, table) in tables.iter().enumerate() {
        let light = light(reading, table, index + 1)?;
        lamps += light.lamp_count();
        if lamps > MOST_LAMPS {
            return Err(reading.wrong(table.span(), format!("a scene has at most {MOST_LAMPS} lamps")));
        }
        lights.push(light);
    }

    Ok(lights)
}

/// Reads all plumes.
fn read_plumes(reading: &Reading<'_>, tables: Vec<Spanned<PlumeTable>>) -> Result<Vec<Plume>> {
    let numbered = tables.into_iter().enumerate();
    numbered.map(|(index, table)| plume(reading, table, index + 1)).collect()
}
