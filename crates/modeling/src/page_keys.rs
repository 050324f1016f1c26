//! Keys of pages.

use crate::build_cache::{BuildCache, Key, Keyer};
use crate::feather::Sheets;
use crate::feature_solids::FeatureSolids;
use crate::footprint::Bounds;
use crate::inputs::Inputs;
use crate::object::Objects;
use crate::opened::Opened;
use crate::page::Project;
use crate::plan::Plan;
use crate::synthetic::Synthetic;
use crate::warp::{LevelGrid, RasterPlacement, Rect};
use crate::{BuildOptions, NodataFill, void_fill};
use hedgehop::voxel::{APRON, Grid, PAGE_SIDE, PageId, PageReadback, SharedObjects, finer_pages};
use hedgehop_base::Size;
use hedgehop_base::error::Result;
use hedgehop_geo::VerticalDatum;

/// Keys of the rasters of a build, in their order.
#[derive(Debug, Clone)]
pub(crate) struct SourceKeys {
    pub elevation: Vec<Key>,
    pub imagery: Vec<Key>,
    pub land_cover: Vec<Key>,
    /// Key of everything else that all pages are made of.
    settings: Key,
}

impl SourceKeys {
    /// Computes the keys of opened inputs.
    pub fn of(
        inputs: &Inputs,
        plan: &Plan,
        datum: VerticalDatum,
        options: &BuildOptions,
        cache: &BuildCache,
    ) -> Result<Self> {
        // Files count by what they hold, and where, how and by whom it is made does not.
        let settings = BuildOptions {
            synthetic: Synthetic { below_voxel: None, examples: None, ..options.synthetic.clone() },
            clouds: Vec::new(),
            elevation: Vec::new(),
            imagery: Vec::new(),
            land_cover: Vec::new(),
            features: Vec::new(),
            objects: Vec::new(),
            scatters: Vec::new(),
            corridors: Vec::new(),
            output: Default::default(),
            kept_for: None,
            overwrite: false,
            steps: false,
            memory: 0,
            threads: 0,
            ..options.clone()
        };

        let settings = Keyer::of("area").with(&settings).with(&plan.grid).with(&plan.stored.outside());
        let mut settings = settings.with(&plan.crs.name()).with(&plan.crs.proj()).with(&datum.label());
        let mut elevation = keys(&inputs.elevation, cache)?;
        if let Some(clouds) = elevation.get_mut(..inputs.clouds.len()).filter(|clouds| !clouds.is_empty()) {
            // One raster holds the points of all, and what stands on them may reach further than it does.
            let all = clouds.iter().fold(Keyer::of("clouds"), |keyer, key| keyer.with_key(*key)).key();
            clouds.fill(all);
            settings = settings.with_key(all);
        }

        let (imagery, land_cover) = (keys(&inputs.imagery, cache)?, keys(&inputs.land_cover, cache)?);
        Ok(Self { elevation, imagery, land_cover, settings: settings.key() })
    }

    /// Returns the key of all elevation, as it lies in the area.
    pub fn ground(&self) -> Key {
        let keyer = Keyer::of("ground").with_key(self.settings);
        self.elevation.iter().fold(keyer, |keyer, key| keyer.with_key(*key)).key()
    }
}

fn keys<T>(rasters: &[Opened<T>], cache: &BuildCache) -> Result<Vec<Key>> {
    let key = |(index, raster): (usize, &Opened<T>)| {
        let Opened { geo, crs, datum, block, facts, .. } = raster;
        // Voxels tell by number which raster they are of.
        let keyer = Keyer::of("raster").with(&index).with(geo).with(&crs.name()).with(&crs.proj());
        let keyer = keyer.with(&datum.label()).with(block).with(facts);
        Ok(keyer.with_key(cache.content(&raster.path)?).key())
    };
    rasters.iter().enumerate().map(key).collect()
}

/// Keys of rasters and what a change of them can reach: their ends count further inside others that fade there.
fn reaching<'r>(
    keys: &[Key],
    rasters: impl Iterator<Item = (&'r RasterPlacement, Size, Bounds, f64)> + Clone,
    grid: &Grid,
) -> Vec<(Key, Bounds)> {
    let sheets = Sheets::of(rasters.clone().map(|(placement, size, ..)| (placement, size)), grid);
    let reached = |(index, (key, (_, _, reach, pixel_side))): (usize, (&Key, _))| {
        // Tiles far away may widen its ramp.
        let key = Keyer::of("tile").with_key(*key).with(&sheets.width(index)).key();
        (key, sheets.reach(index, reach, pixel_side))
    };
    keys.iter().zip(rasters).enumerate().map(reached).collect()
}

/// Keys of a build's pages.
#[derive(Debug)]
pub(crate) struct PageKeys<'a> {
    settings: Key,
    /// Key and reach of each raster.
    sources: Vec<(Key, Bounds)>,
    /// All elevation counts everywhere.
    ground: Option<Key>,
    grid: Grid,
    feature_solids: Option<&'a FeatureSolids>,
    objects: Option<&'a Objects>,
}

impl<'a> PageKeys<'a> {
    /// Computes the keys of what pages are made from, but for shared objects.
    pub fn new(keys: &SourceKeys, project: &Project<'a>) -> Self {
        let Project { grid, fill, elevation, imagery, land_cover, feature_solids, objects, .. } = *project;
        let heights = elevation.iter().map(|s| (&s.placement, s.samples.size(), s.reach, s.pixel_side));
        let colours = imagery.iter().map(|s| (&s.placement, s.samples.size(), s.reach, s.pixel_side));
        let elevation = reaching(&keys.elevation, heights, &grid);
        let imagery = reaching(&keys.imagery, colours, &grid);
        let land_cover = keys.land_cover.iter().zip(land_cover).map(|(key, source)| (*key, source.reach));
        let settings =
            Keyer::of("pages").with_key(keys.settings).with(&project.code).with(&project.tint).key();
        // The broad shape of wide voids comes from the whole of a raster.
        let ground = (fill == NodataFill::Interpolate).then(|| keys.ground());
        let sources = elevation.into_iter().chain(imagery).chain(land_cover).collect();
        Self { settings, sources, ground, grid, feature_solids, objects }
    }

    /// Adds the objects that are placed. They count everywhere: pages know them by number.
    #[must_use]
    pub fn with_shared(self, objects: &SharedObjects) -> Self {
        if objects.is_empty() {
            return self;
        }
        let settings = Keyer::of("objects").with_key(self.settings).with_bytes(&objects.to_bytes()).key();
        Self { settings, ..self }
    }

    /// Returns the key of a page; all finer ones have been written.
    pub fn of(&self, id: PageId, finer: &PageReadback) -> Key {
        let mut keyer = Keyer::of("page").with_key(self.settings).with(&id);
        let mut is_whole = id.level > 0;
        for finer_id in finer_pages(&self.grid, id) {
            match finer.entry(finer_id) {
                Some(entry) => keyer = keyer.with_bytes(&entry.hash),
                None => {
                    is_whole = false;
                    keyer = keyer.with_bytes(&[]);
                }
            }
        }
        if is_whole { keyer.key() } else { self.with_sources(keyer, id).key() }
    }

    /// Adds what reaches a page and what lies around it.
    fn with_sources(&self, mut keyer: Keyer, id: PageId) -> Keyer {
        let level = LevelGrid::of(&self.grid, id.level);
        let Size { width, height } = self.grid.page_size(id).unwrap_or_default();
        let (x0, y0) = (id.px * PAGE_SIDE, id.py * PAGE_SIDE);
        let page = Rect { x0, y0, x1: x0 + width, y1: y0 + height };

        // Slopes in the apron ask for a voxel more.
        let around = page.grown(APRON + 1, &level.grid);
        if let Some(feature_solids) = self.feature_solids {
            keyer = feature_solids.keys_around(around, &level).into_iter().fold(keyer, Keyer::with_key);
        }

        // Scatters ask for ground, and keep away from what stands there.
        let around_objects = self.objects.and_then(|objects| objects.margin(around, &level)).unwrap_or(0);
        if let Some(objects) = self.objects {
            keyer = objects.keys_around(around, &level).into_iter().fold(keyer, Keyer::with_key);
            let wide = around.grown(around_objects, &level.grid);
            if let Some(feature_solids) = self.feature_solids.filter(|_| objects.avoid_features()) {
                keyer = feature_solids.keys_around(wide, &level).into_iter().fold(keyer, Keyer::with_key);
            }
        }

        if let Some(ground) = self.ground {
            keyer = keyer.with_key(ground);
        }
        // Features ask for ground further away.
        let margin =
            self.feature_solids.and_then(|feature_solids| feature_solids.margin(around, &level)).unwrap_or(0);
        let wide = around.grown(around_objects + margin + void_fill::REACH, &level.grid);
        let here = self.sources.iter().filter(|(_, reach)| wide.meets(reach, &level.grid));

        here.fold(keyer, |keyer, (key, _)| keyer.with_key(*key))
    }
}
