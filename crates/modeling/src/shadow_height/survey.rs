//! All rows of a layer, on several threads.

use std::path::PathBuf;

use glam::{DVec2, dvec2};

use super::super::features::{Layer, foot_of};
use super::super::inputs::{Inputs, open_rasters};
use super::super::options::BuildOptions;
use super::super::workers::in_order;
use super::answer::{Answer, Origin, ShadowHeight};
use super::bounds::PlaceBounds;
use super::edge::FoundEdge;
use super::index::Index;
use super::notes;
use super::patch::{Cut, PlacedRaster, RasterPatch};
use super::row::{RowClaim, RowOutline};
use super::site::{Neighbour, Reason, Seen, Site};
use super::sunward::Sunward;
use crate::naming::file_name;
use crate::shadow_height::{ShadowOptions, ShadowReport};
use hedgehop::sunlight::{Sun, SunSetting};
use hedgehop_base::error::{Error, Result};
use hedgehop_base::progress::{Observer, Silent};
use hedgehop_geo::{Crs, GridNorth, Transform};

/// Bytes of decoded blocks of all rasters.
const CACHE: u64 = 256 << 20;
/// Side of the cells by which neighbours are found, metres.
const CELL: f64 = 200.0;
/// Lowest building that is looked for, metres.
const LOWEST: f64 = 2.0;
/// Highest that a stated shadow may say, metres.
const MOST_HEIGHT: f64 = 2000.0;
/// Elevations of suns whose shadows are measured, degrees.
const SUNS: std::ops::RangeInclusive<f64> = 0.5..=89.0;
/// Error at which a stated shadow is taken to be measured, metres.
const STATED_ERROR: f64 = 0.5;
/// Least contrast of a shadow as a share of the median of all, and how many are needed to tell.
const PALE: f64 = 0.45;
const LEAST_TO_COMPARE: usize = 5;

/// A row that can be measured.
struct ShadowBuilding {
    outline: RowOutline,
    sun: Sunward,
    /// The lowest ground along its outline, metres.
    base: f64,
}

/// Everything but the rows.
struct LayerSurvey<'o> {
    options: &'o ShadowOptions,
    elevation: Vec<PlacedRaster<f64>>,
    imagery: Vec<PlacedRaster<[u8; 4]>>,
    /// The system in which metres are measured.
    metres: Crs,
    to_metres: Transform,
    norths: [GridNorth; 2],
}

/// Measures all rows of a layer.
pub(super) fn survey(layer: Layer, options: &ShadowOptions, observer: &dyn Observer) -> Result<ShadowReport> {
    let mut notes = layer.notes.clone();
    let file = file_name(&layer.path);
    let bounds = layer.rows.iter().filter_map(|row| row.geometry.bounds());
    let all = bounds.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);
    let Some([west, south, east, north]) = all else {
        return Err(Error::invalid(&layer.path, "has no buildings: no row of it has a form"));
    };

    let middle = dvec2(0.5 * (west + east), 0.5 * (south + north));
    let (survey, said) = LayerSurvey::open(&layer, middle, options)?;
    notes.extend(said);
    let sun = survey.sun(middle)?;
    if !SUNS.contains(&sun.elevation) {
        let what = format!(
            "the sun stands {:.1}° above the horizon, and shadows are measured from {}° to {}°; give the time at which the picture was taken, with its offset from UTC",
            sun.elevation,
            SUNS.start(),
            SUNS.end()
        );
        return Err(Error::Configuration(what));
    }

    let sites = survey.sites(&layer, observer)?;
    let answers = survey.answers(&sites, observer)?;
    survey.imagery.iter().for_each(|raster| notes.extend(raster.samples.notes()));
    survey.elevation.iter().for_each(|raster| notes.extend(raster.samples.notes()));
    notes.extend(notes::notes(&file, &layer, &answers));

    Ok(ShadowReport { layer, answers, sun, notes })
}

/// A site as far as it is known, or why there is none.
type KnownHeight = std::result::Result<ShadowBuilding, String>;

impl<'o> LayerSurvey<'o> {
    /// Opens the rasters. Metres are measured around the layer's middle, so that they are true there and north is up.
    fn open(layer: &Layer, middle: DVec2, options: &'o ShadowOptions) -> Result<(Self, Vec<String>)> {
        let metres = metres_around(&layer.crs, middle)?;
        let build = BuildOptions {
            elevation: options.elevation.clone(),
            imagery: options.imagery.clone(),
            local: options.local,
            raw_spacing: options.raw_spacing,
            ..BuildOptions::new(Vec::new(), Vec::new(), PathBuf::new())
        };

        let Inputs { elevation, imagery, notes: mut said, .. } = open_rasters(&build, CACHE, &Silent)?;
        if elevation.is_empty() {
            said.push("no elevation is given: the ground is taken as level".to_owned());
        }

        let to_metres = Transform::new(&layer.crs, &metres)?;
        let norths = [GridNorth::new(&layer.crs)?, GridNorth::new(&metres)?];
        let elevation =
            elevation.into_iter().map(|raster| PlacedRaster::new(raster, &metres)).collect::<Result<_>>()?;
        let imagery =
            imagery.into_iter().map(|raster| PlacedRaster::new(raster, &metres)).collect::<Result<_>>()?;

        Ok((Self { options, elevation, imagery, metres, to_metres, norths }, said))
    }

    /// The sun over a place of the layer, its azimuth from the north of `metres`.
    fn sun(&self, place: DVec2) -> Result<Sun> {
        let nowhere = || Error::Configuration(format!("{}, {} is no place on Earth", place.x, place.y));
        let there: DVec2 = self.to_metres.apply(place.x, place.y).ok_or_else(nowhere)?.into();
        let turn =
            self.norths[1].convergence(there.x, there.y) - self.norths[0].convergence(place.x, place.y);
        match self.options.sun {
            SunSetting::At(sun) => Ok(Sun { azimuth: (sun.azimuth + turn).rem_euclid(360.0), ..sun }),
            by_time => Ok(by_time.over(&self.metres, there)?.sun),
        }
    }

    /// Outlines, suns and feet of all rows.
    fn sites(&self, layer: &Layer, observer: &dyn Observer) -> Result<Vec<KnownHeight>> {
        let count = layer.rows.len() as u64;
        let mut sites = Vec::with_capacity(layer.rows.len());
        observer.begin("ground", count, "buildings");
        let work = |(): &mut (), index: u64| self.building(layer, index as usize);
        in_order(
            count,
            self.options.threads,
            observer,
            || (),
            work,
            |_, known| {
                observer.advance(1);
                sites.push(known);
                Ok(())
            },
        )?;
        observer.end();
        Ok(sites)
    }

    fn building(&self, layer: &Layer, index: usize) -> Result<KnownHeight> {
        let row = &layer.rows[index];
        let outline = match RowOutline::of(row, &self.to_metres, self.options.all) {
            Ok(outline) => outline,
            Err(reason) => return Ok(Err(reason)),
        };
        let place = row.geometry.areas[0].outer.places[0];
        let sun = self.sun(place)?;
        if !SUNS.contains(&sun.elevation) {
            return Ok(Err(format!("the sun stands {:.0}° above the horizon there", sun.elevation)));
        }

        let sun = Sunward::new(sun.azimuth, sun.elevation);
        let rings = turned(&outline, &sun);
        let bounds = PlaceBounds::around(rings.iter().flatten().copied());
        let Some(ground) = self.ground(&sun, bounds)? else {
            return Ok(Err(Reason::TooLarge.text().to_owned()));
        };
        let Some(geometry) = row.geometry.transformed(&self.to_metres) else {
            return Ok(Err("it has no place in metres".to_owned()));
        };

        let height = |place: DVec2| ground.height(sun.turned(place));
        let bases: Vec<f64> = geometry.areas.iter().filter_map(|area| foot_of(area, &height)).collect();
        Ok(match bases.into_iter().reduce(f64::min) {
            Some(base) => Ok(ShadowBuilding { outline, sun, base }),
            None => Err("there is no elevation under it, or it encloses nothing".to_owned()),
        })
    }

    /// The ground of a rectangle turned to the sun; `None` if it has too many samples.
    fn ground(&self, sun: &Sunward, rectangle: PlaceBounds) -> Result<Option<Relief>> {
        let mut patches = Vec::new();
        for raster in &self.elevation {
            match raster.cut(sun, rectangle)? {
                Cut::Part(patch) => patches.push(patch),
                Cut::Nothing => {}
                Cut::TooMany => return Ok(None),
            }
        }
        Ok(Some(Relief { patches, is_level: self.elevation.is_empty() }))
    }

    fn answers(&self, sites: &[KnownHeight], observer: &dyn Observer) -> Result<Vec<Answer>> {
        let boxes = (0..)
            .zip(sites)
            .filter_map(|(number, known)| Some((number, known.as_ref().ok()?.outline.bounds())));
        let index = Index::new(boxes, CELL);
        let stated = |known: &KnownHeight| match known {
            Ok(ShadowBuilding { outline: RowOutline { claim: RowClaim::Height(height), .. }, .. }) => {
                Some(*height)
            }
            _ => None,
        };
        let mut heights: Vec<Option<f64>> = sites.iter().map(stated).collect();
        let mut answers = Vec::new();
        let passes = if self.imagery.is_empty() { 1 } else { 2 };

        for _ in 0..passes {
            observer.begin("shadows", sites.len() as u64, "buildings");
            let mut found = Vec::with_capacity(sites.len());
            let work = |(): &mut (), number: u64| self.measure(sites, number as u32, &index, &heights);

            in_order(
                sites.len() as u64,
                self.options.threads,
                observer,
                || (),
                work,
                |_, outcome| {
                    observer.advance(1);
                    found.push(outcome);
                    Ok(())
                },
            )?;

            observer.end();
            without_pale(&mut found);
            let height = |(known, outcome): (&KnownHeight, &Outcome)| stated(known).or(outcome.height());
            heights = sites.iter().zip(&found).map(height).collect();
            answers = found.into_iter().map(Outcome::into_answer).collect();
        }

        Ok(answers)
    }

    /// One row, with what is known of the heights of all.
    fn measure(
        &self,
        sites: &[KnownHeight],
        number: u32,
        index: &Index,
        heights: &[Option<f64>],
    ) -> Result<Outcome> {
        let building = match &sites[number as usize] {
            Ok(building) => building,
            Err(reason) => return Ok(Outcome::Nothing(reason.clone())),
        };
        let ShadowBuilding { outline, sun, base } = building;
        let rings = turned(outline, sun);

        let highest = match outline.claim {
            RowClaim::Height(_) => return Ok(Outcome::Kept),
            RowClaim::Length(length) => length * sun.rise,
            RowClaim::Tip(tip) => (outline.middle().distance(tip) + 1.0) * sun.rise,
            RowClaim::None if self.imagery.is_empty() => {
                return Ok(Outcome::Nothing(
                    "it states no shadow_length and no shadow_tip, and there is no picture".to_owned(),
                ));
            }
            RowClaim::None => self.options.highest_m,
        };

        let level = |_: DVec2| Some(0.0);
        let mut site = Site {
            sun: *sun,
            base: *base,
            rings: &rings,
            others: &[],
            neighbours: &[],
            ground: &level,
            range: (LOWEST, highest),
        };

        let Some(relief) = self.ground(sun, site.surroundings())? else {
            return Ok(Outcome::Nothing(Reason::TooLarge.text().to_owned()));
        };

        let height = |place: DVec2| relief.height(place);
        site.ground = &height;
        if outline.claim != RowClaim::None {
            return Ok(stated(&site, outline.claim));
        }

        let (others, neighbours) = near(sites, number, &site, index, heights);
        (site.others, site.neighbours) = (&others, &neighbours);
        Ok(match site.look(&self.imagery)? {
            Seen::Height(found) => Outcome::Seen(found, site.length_of_height(found.height)),
            Seen::Nothing(reason) => Outcome::Nothing(reason.text().to_owned()),
        })
    }
}

/// True metres around a place, with north upward; of a local system it itself.
fn metres_around(crs: &Crs, place: DVec2) -> Result<Crs> {
    if crs.is_local() {
        return Ok(crs.clone());
    }
    let nowhere =
        || Error::Configuration(format!("{}, {} of {} is no place on Earth", place.x, place.y, crs.name()));
    let (longitude, latitude) =
        Transform::new(crs, &Crs::wgs84())?.apply(place.x, place.y).ok_or_else(nowhere)?;
    let definition = format!(
        "+proj=tmerc +lat_0={latitude:.6} +lon_0={longitude:.6} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"
    );
    Crs::from_proj(&definition, "metres around the buildings")
}

fn turned(outline: &RowOutline, sun: &Sunward) -> Vec<Vec<DVec2>> {
    outline.rings.iter().map(|ring| ring.iter().map(|place| sun.turned(*place)).collect()).collect()
}

/// Heights of a site's ground, by places turned to the sun.
struct Relief {
    patches: Vec<RasterPatch<f64>>,
    is_level: bool,
}

impl Relief {
    fn height(&self, place: DVec2) -> Option<f64> {
        if self.is_level { Some(0.0) } else { self.patches.iter().find_map(|patch| patch.height(place)) }
    }
}

/// Buildings that may hide or shade a site's ground: their rings turned to the sun, and what is known of them.
fn near(
    sites: &[KnownHeight],
    number: u32,
    site: &Site<'_>,
    index: &Index,
    heights: &[Option<f64>],
) -> (Vec<(u32, Vec<DVec2>)>, Vec<Neighbour>) {
    let PlaceBounds { low, high } = site.surroundings();
    let high = high + dvec2(site.range.1 / site.sun.rise, 0.0);
    let corners =
        [low, dvec2(low.x, high.y), high, dvec2(high.x, low.y)].map(|corner| site.sun.place(corner));
    let square = PlaceBounds::around(corners);
    let (mut rings, mut neighbours) = (Vec::new(), Vec::new());
    let own = sites[number as usize].as_ref().ok().map(|building| &building.outline);

    for other in index.near(square).into_iter().filter(|other| *other != number) {
        let Ok(building) = &sites[other as usize] else { continue };
        // Outlines of a building and of its parts lie on each other, and are no neighbours.
        let is_same = own
            .is_some_and(|own| own.holds(building.outline.middle()) || building.outline.holds(own.middle()));
        let turned = turned(&building.outline, &site.sun);
        let bounds = PlaceBounds::around(turned.iter().flatten().copied());

        if !is_same && bounds.low.cmple(high).all() && bounds.high.cmpge(low).all() {
            let owner = neighbours.len() as u32;
            rings.extend(turned.into_iter().map(|ring| (owner, ring)));
            neighbours.push(Neighbour { base: building.base, height: heights[other as usize] });
        }
    }

    (rings, neighbours)
}

/// Outcome of one pass over a row.
enum Outcome {
    Kept,
    Stated(ShadowHeight),
    /// And the shadow's length, metres.
    Seen(FoundEdge, f64),
    Nothing(String),
}

impl Outcome {
    fn height(&self) -> Option<f64> {
        match self {
            Self::Stated(stated) => Some(stated.height_m),
            Self::Seen(found, _) => Some(found.height),
            Self::Kept | Self::Nothing(_) => None,
        }
    }

    fn into_answer(self) -> Answer {
        match self {
            Self::Kept => Answer::Kept,
            Self::Stated(stated) => Answer::Height(stated),
            Self::Seen(found, length_m) => Answer::Height(ShadowHeight {
                height_m: found.height,
                error_m: found.error,
                length_m,
                origin: Origin::Photograph,
            }),
            Self::Nothing(reason) => Answer::Nothing(reason),
        }
    }
}

/// The height that a row's own statement gives.
fn stated(site: &Site<'_>, claim: RowClaim) -> Outcome {
    let nothing = |reason: &str| Outcome::Nothing(reason.to_owned());
    let found = match claim {
        RowClaim::Length(length) => site
            .height_of_length(length)
            .map(|height| (height, length))
            .ok_or("there is no elevation where its shadow ends"),
        RowClaim::Tip(tip) => site.height_of_tip(site.sun.turned(tip)),
        RowClaim::Height(_) | RowClaim::None => Err("it states no shadow"),
    };

    match found {
        Err(reason) => nothing(reason),
        Ok((height, _)) if height <= 0.0 => {
            nothing("the ground falls away faster than the sun's rays to where its shadow ends")
        }
        Ok((height, _)) if height > MOST_HEIGHT => {
            nothing("its shadow would be that of something higher than 2000 m")
        }
        Ok((height_m, length_m)) => Outcome::Stated(ShadowHeight {
            height_m,
            error_m: STATED_ERROR * site.sun.rise,
            length_m,
            origin: Origin::Stated,
        }),
    }
}

/// One sun throws shadows of much the same depth: takes back what is much paler than the median.
fn without_pale(found: &mut [Outcome]) {
    let contrast = |outcome: &Outcome| match outcome {
        Outcome::Seen(found, _) => Some(found.contrast()),
        _ => None,
    };
    let mut contrasts: Vec<f64> = found.iter().filter_map(contrast).collect();
    if contrasts.len() < LEAST_TO_COMPARE {
        return;
    }
    contrasts.sort_unstable_by(f64::total_cmp);
    let least = PALE * contrasts[contrasts.len() / 2];
    for outcome in found {
        if contrast(outcome).is_some_and(|contrast| contrast < least) {
            *outcome = Outcome::Nothing(Reason::Pale.text().to_owned());
        }
    }
}
