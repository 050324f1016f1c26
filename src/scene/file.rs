//! The file: its tables, and what they may hold.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::light::{LightTable, MOST_LAMPS, light};
use super::model::Models;
use super::object::object;
use super::picture::{HudTable, PictureTable};
use super::plume::{PlumeTable, plume};
use super::sun::{NightTable, SunTable};
use super::{Object, Scene};
use crate::scene::contents::BETWEEN;
use crate::scene::object_table::ObjectTable;
use crate::weather::{self, CloudsTable, FogTable, GroundTable, PrecipitationTable, Weather};
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
    #[serde(default)]
    object: Vec<Spanned<ObjectTable>>,
    #[serde(default)]
    light: Vec<Spanned<LightTable>>,
    #[serde(default)]
    plume: Vec<Spanned<PlumeTable>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "the table [air]")]
struct AirTable {
    visibility_m: Option<Spanned<f64>>,
    glow: Option<Spanned<f64>>,
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

pub(super) fn read(path: &Path) -> Result<Scene> {
    let mut hasher = blake3::Hasher::new();
    let (reading, table): (_, SceneTable) = Reading::open(path, SCENE, &mut hasher)?;
    let lines = table.sun.as_ref().map(|sun| sun.lines(&reading)).unwrap_or_default();
    let shadows = table.sun.as_ref().and_then(SunTable::shadows);
    let sun = table.sun.map_or(Ok(None), |sun| sun.read(&reading))?;
    let night = table.night.unwrap_or_default().read(&reading)?;
    let air = table.air.unwrap_or_default();
    let visibility = air.visibility_m.as_ref();
    let visibility = visibility
        .map(|metres| reading.number("visibility_m", metres, |metres| metres > 0.0, "must be more than 0 m"))
        .transpose()?;
    let precipitation = table.precipitation.map(|falls| falls.read(&reading)).transpose()?;

    let weather = Weather {
        precipitation,
        ground: table.ground.unwrap_or_default().read(&reading, precipitation.as_ref())?,
        glow: weather::glow(&reading, air.glow.as_ref(), sun.is_some())?,
        fog: table.fog.map(|fog| fog.read(&reading)).transpose()?,
        clouds: table.clouds.map(|clouds| clouds.read(&reading)).transpose()?,
    };

    let finish = table.picture.unwrap_or_default().read(&reading)?;
    let hud = table.hud.map(|hud| hud.read(&reading)).transpose()?.unwrap_or_default();
    let mut objects: BTreeMap<String, Object> = BTreeMap::new();
    let mut models = Models::default();

    for table in table.object {
        let span = table.span();
        let object = object(&reading, table, &mut models, &mut hasher)?;
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
                return Err(Error::invalid(path, format!("line {}: {}", part.line, plain(&what))));
            }
        }
    }

    let mut lights = Vec::new();
    let mut lamps = 0;
    for (index, table) in table.light.iter().enumerate() {
        let light = light(&reading, table, index + 1)?;
        lamps += light.lamp_count();
        if lamps > MOST_LAMPS {
            return Err(reading.wrong(table.span(), format!("a scene has at most {MOST_LAMPS} lamps")));
        }
        lights.push(light);
    }

    let plumes = table.plume.into_iter().enumerate();
    let plumes = plumes.map(|(index, table)| plume(&reading, table, index + 1)).collect::<Result<_>>()?;
    let objects = objects.into_values().collect();

    Ok(Scene {
        path: path.to_owned(),
        digest: hasher.finalize().to_hex().to_string(),
        sun,
        shadows,
        night,
        lines,
        visibility,
        weather,
        finish,
        hud,
        objects,
        lights,
        plumes,
    })
}
