//! Objects and scatters on the ground of a database: what of them stands over a block of voxels.
//!
//! ```text
//! once:     each object's height, by the natural ground at its place; areas of scatters in the database's system
//! a shape:  made of its model for voxels of a level, as soon as a block needs it
//! a block:  placements of objects that reach it, and of scatters around it → solids                  [`super::placement`]
//! ```
//! What a voxel gets depends on the natural ground and on what stands about it, never on the block that is made.

use std::sync::OnceLock;

use glam::{DVec2, dvec2};

use super::built_in::BuiltIn;
use super::open::{OpenObject, OpenScatter, Scaled};
use super::options::ScatterFile;
use super::placement::{Placement, raise};
use super::scatter::{Scatter, ScatterSite};
use super::shape::Shape;
use super::soup::Soup;
use crate::Materials;
use crate::build_cache::{Key, Keyer};
use crate::features::Square;
use crate::naming::file_name;
use crate::natural::{NaturalBlock, NaturalGround};
use crate::placing::{self, Collection, Raised};
use crate::plan::Plan;
use crate::warp::{LevelGrid, Rect};
use hedgehop::voxel::{self, Grid, HeightCode, Material, Symmetry};
use hedgehop_base::error::Result;

/// Places of one object up to which each has a shape of its own; of more all stand in the middle of their voxels.
const MOST_EXACT: usize = 64;

/// Levels that a database may have.
const LEVELS: usize = 16;

/// Distance from objects within which nothing is scattered, metres.
const CLEAR_M: f64 = 1.5;

/// Part of a voxel that a form must fill to be seen as a surface from afar.
const SEEN: f64 = 0.5;

/// A model, and its shapes for voxels of each level.
#[derive(Debug)]
struct Stock {
    soup: usize,
    material: u8,
    /// Whether its foot is on the ground.
    stands: bool,
    /// Built-in form, with its scale, if no file says.
    built_in: Option<(BuiltIn, f64)>,
    /// Place on which it stands; `None`: in the middle of voxels.
    place: Option<DVec2>,
    shapes: Vec<OnceLock<Shape>>,
    /// Number among the objects that the database places.
    shared: Option<u16>,
}

/// An object at one of its places.
#[derive(Debug)]
struct PlacedStock {
    stock: u32,
    place: DVec2,
    foot_m: f64,
    /// West, south, east, north of its model.
    reach: [f64; 4],
    key: Key,
}

/// Ground around a block that objects may stand on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ObjectGround<'a> {
    /// Natural ground of the block with its margin.
    pub natural: NaturalBlock<'a>,
    /// Numbers of its voxels' materials, if scatters [ask](Objects::ask_for_materials) for them; else none.
    pub materials: &'a [u8],
    /// Voxels that features change.
    pub features: &'a [bool],
}

/// All objects and scatters of a database.
#[derive(Debug)]
pub(crate) struct Objects {
    soups: Vec<Soup>,
    stocks: Vec<Stock>,
    placed: Vec<PlacedStock>,
    scatters: Vec<(Scatter, Key)>,
    origin: DVec2,
    /// Farthest that a scattered form reaches, metres.
    reach: f64,
    /// Height of the highest top, metres.
    highest: f64,
}

impl Objects {
    /// Builds the objects of opened files on ground that `ground` makes, up to `highest` metres high, and notes on what is left out.
    ///
    /// # Errors
    /// A model that is too large for the database's voxels, an area that has no place in its system, ground that cannot be read.
    pub fn new(
        objects: Vec<OpenObject>,
        scatters: Vec<OpenScatter>,
        plan: &Plan,
        ground: &mut dyn NaturalGround,
        materials: &Materials,
        highest: f64,
    ) -> Result<(Self, Vec<String>)> {
        let mut all = Self {
            soups: Vec::new(),
            stocks: Vec::new(),
            placed: Vec::new(),
            scatters: Vec::new(),
            origin: plan.grid.origin,
            reach: 0.0,
            highest: f64::NEG_INFINITY,
        };
        let mut notes = Vec::new();
        for object in objects {
            all.place(object, plan, ground, &mut notes)?;
        }
        for scatter in scatters {
            all.scatter(scatter, plan, materials, highest)?;
        }
        Ok((all, notes))
    }

    fn stock(&mut self, soup: usize, material: Material, stands: bool, place: Option<DVec2>) -> u32 {
        let shapes = (0..LEVELS).map(|_| OnceLock::new()).collect();
        self.stocks.push(Stock {
            soup,
            material: material.code(),
            stands,
            built_in: None,
            place,
            shapes,
            shared: None,
        });
        self.stocks.len() as u32 - 1
    }

    /// Height of the highest point over ground of a height, slopes that go on over the voxel's centre included.
    fn top(&self, soup: usize, foot_m: f64, spacing: f64) -> f64 {
        foot_m + self.soups[soup].corners[1].z + 2.0 * spacing
    }

    fn place(
        &mut self,
        object: OpenObject,
        plan: &Plan,
        maker: &mut dyn NaturalGround,
        notes: &mut Vec<String>,
    ) -> Result<()> {
        let (grid, file) = (&plan.grid, &object.file);
        object.fits(grid)?;
        let name = file_name(&file.paths[0]);
        let [low, high] = object.soup.corners;
        self.soups.push(object.soup);
        let soup = self.soups.len() - 1;
        let stands = file.up_m <= 0.0;
        let is_exact = file.places.len() <= MOST_EXACT;
        let shared = (!is_exact).then(|| self.stock(soup, file.material, stands, None));

        for place in file.places.iter().map(|place| DVec2::from_array(*place)) {
            let Some(ground) = ground_at(grid, place, maker)? else {
                notes.push(format!(
                    "{name}: is left out at {:.1}, {:.1}, where the area has no ground",
                    place.x, place.y
                ));
                continue;
            };

            let foot_m = ground + file.up_m;
            let stock = shared.unwrap_or_else(|| self.stock(soup, file.material, stands, Some(place)));
            let keyer = Keyer::of("object").with_bytes(&object.content).with(&file.stance).with(&stands);
            let key = keyer.with(&file.material).with(&is_exact).with(&place).with(&foot_m).key();
            let reach = [place.x + low.x, place.y + low.y, place.x + high.x, place.y + high.y];
            self.highest = self.highest.max(self.top(soup, foot_m, grid.spacing));
            self.placed.push(PlacedStock { stock, place, foot_m, reach, key });
        }

        Ok(())
    }

    fn scatter(
        &mut self,
        scatter: OpenScatter,
        plan: &Plan,
        materials: &Materials,
        highest: f64,
    ) -> Result<()> {
        scatter.fits(&plan.grid)?;
        let areas = scatter.areas(&plan.crs)?;
        let file = &scatter.file;
        let mut shapes = Vec::with_capacity(scatter.forms.len());

        for of_form in scatter.forms {
            let mut of_scales = Vec::with_capacity(of_form.len());
            for Scaled { soup, material, built_in } in of_form {
                let [low, high] = soup.corners;
                let far = low.abs().max(high.abs());
                self.reach = self.reach.max(far.x.max(far.y));
                self.soups.push(soup);
                self.highest = self.highest.max(self.top(self.soups.len() - 1, highest, plan.grid.spacing));
                let number = self.stock(self.soups.len() - 1, material, true, None);
                self.stocks[number as usize].built_in = built_in;
                of_scales.push(number);
            }

            shapes.push(of_scales);
        }

        let settings = ScatterFile { forms: Vec::new(), area: None, ..file.clone() };
        let key = Keyer::of("scatter").with(&settings).with_bytes(&scatter.content).key();
        let scatter = Scatter {
            cell: file.spacing_m.max(plan.grid.spacing),
            seed: file.seed,
            shapes,
            areas,
            bbox: file.bbox,
            heights_m: file.heights_m,
            slopes: file.slopes_deg.map(|slopes| slopes.map(|slope| slope.to_radians().tan())),
            grounds: (!file.grounds.is_empty()).then(|| materials.numbers_of(&file.grounds)),
            avoids: file.avoid,
        };

        self.scatters.push((scatter, key));
        Ok(())
    }

    /// Greatest height that they may bring about, metres; `None`: there are none.
    pub fn highest(&self) -> f64 {
        self.highest
    }

    /// Whether scatters need to know what the ground is made of.
    pub fn ask_for_materials(&self) -> bool {
        self.scatters.iter().any(|(scatter, _)| scatter.grounds.is_some())
    }

    /// Whether scatters need to know what features change.
    pub fn avoid_features(&self) -> bool {
        self.scatters.iter().any(|(scatter, _)| scatter.avoids)
    }

    /// Returns how many voxels of a level around a block count for what stands on it; `None`: nothing does.
    pub fn margin(&self, rect: Rect, level: &LevelGrid) -> Option<u32> {
        // Slopes, voxels that are cut, and the middle of voxels that places are moved to.
        const ROOM: u32 = 4;
        let is_near = |reach: [f64; 4]| reaches(reach, rect, ROOM, level);
        let scattered = self.scatters.iter().any(|(scatter, _)| {
            let [west, south, east, north] = scatter.bounds();
            let grown = [west - self.reach, south - self.reach, east + self.reach, north + self.reach];
            is_near(grown)
        });
        if scattered {
            return Some(((self.reach + CLEAR_M) / level.grid.spacing).ceil() as u32 + ROOM);
        }
        self.placed.iter().any(|placed| is_near(placed.reach)).then_some(ROOM)
    }

    /// Keys of all that may stand on a block of a level, or keep other things from it.
    pub fn keys_around(&self, rect: Rect, level: &LevelGrid) -> Vec<Key> {
        let Some(margin) = self.margin(rect, level) else { return Vec::new() };
        let placed = self.placed.iter().filter(|placed| reaches(placed.reach, rect, 2 * margin, level));
        let scatters = self.scatters.iter().filter(|(scatter, _)| {
            let [west, south, east, north] = scatter.bounds();
            reaches([west, south, east, north], rect, 2 * margin, level)
        });
        placed.map(|placed| placed.key).chain(scatters.map(|(_, key)| *key)).collect()
    }

    /// Adds those that stand in the middle of voxels to the objects that the database places.
    pub fn share(&mut self, grid: &Grid, objects: &mut Collection<'_>) {
        let level = LevelGrid::of(grid, 0);
        for number in 0..self.stocks.len() {
            if self.stocks[number].place.is_none() {
                self.stocks[number].shared = objects.take(self.shape(number as u32, &level));
            }
        }
    }

    /// A placement as the database has it, if it places the shape as an object.
    fn shared(&self, placement: &Placement, level: &LevelGrid, code: &HeightCode) -> Option<placing::Placed> {
        let number = self.stocks[placement.shape as usize].shared.filter(|_| level.level == 0)?;
        let (first, _) = placement.bounds(self.shape(placement.shape, level));
        Some((
            first,
            voxel::Placement::new(number, placement.symmetry, [0, 0], code.encode(placement.foot_m)),
        ))
    }

    /// Raises their solids over a block, with their index in it, and what is placed there as objects of the database. `ground` is that of the
    /// block with its margin.
    pub fn solids(
        &self,
        rect: Rect,
        ground: ObjectGround<'_>,
        level: &LevelGrid,
        code: &HeightCode,
    ) -> Raised {
        let placements = self.placements(ground, level);
        let (mut own, mut placed) = (Vec::new(), Vec::new());
        for placement in placements {
            match self.shared(&placement, level, code) {
                Some(found) => placed.push(found),
                None => own.push(placement),
            }
        }
        let mut solids = Vec::new();
        raise(&own, |number| self.shape(number, level), rect, &mut solids);
        (solids, placed)
    }

    /// All that may stand on a block, objects first.
    fn placements(&self, ground: ObjectGround<'_>, level: &LevelGrid) -> Vec<Placement> {
        let ObjectGround { natural: NaturalBlock { rect: wide, heights }, materials, features } = ground;
        let spacing = level.grid.spacing;
        let near = self.placed.iter().filter(|placed| reaches(placed.reach, wide, 2, level));
        let mut placements: Vec<Placement> = near
            .map(|placed| {
                let voxel = ((placed.place - self.origin) / spacing).floor();
                let voxel = [voxel.x as i64, voxel.y as i64];
                Placement { shape: placed.stock, voxel, symmetry: Symmetry::default(), foot_m: placed.foot_m }
            })
            .collect();

        let mut objects = vec![false; wide.len()];
        let mut covered = Vec::new();
        if !self.scatters.is_empty() {
            raise(&placements, |number| self.shape(number, level), wide, &mut covered);
            let clear = (CLEAR_M / spacing).round() as u32;
            for (x, y) in covered.iter().map(|placed| wide.voxel(placed.voxel)) {
                let around = Rect { x0: x, y0: y, x1: x + 1, y1: y + 1 }.grown(clear, &level.grid);
                for (x, y) in (0..around.len()).map(|index| around.voxel(index)) {
                    if (wide.x0..wide.x1).contains(&x) && (wide.y0..wide.y1).contains(&y) {
                        objects[wide.index(x, y)] = true;
                    }
                }
            }
        }

        let square = Square {
            origin: self.origin,
            first: [i64::from(wide.x0), i64::from(wide.y0)],
            spacing,
            columns: wide.width(),
            rows: wide.height(),
        };

        let site = ScatterSite { square, heights, materials, features, objects: &objects };
        for (scatter, _) in &self.scatters {
            let is_seen = |number: &u32| {
                let [low, high] = self.soups[self.stocks[*number as usize].soup].corners;
                level.level == 0 || (high - low).truncate().max_element() > SEEN * spacing
            };
            if scatter.shapes.iter().flatten().any(is_seen) {
                scatter.placements(&site, &mut placements);
            }
        }

        placements
    }

    /// A shape for voxels of a level.
    fn shape(&self, number: u32, level: &LevelGrid) -> &Shape {
        let stock = &self.stocks[number as usize];
        let make = || {
            let spacing = level.grid.spacing;
            if let Some(tree) = stock.built_in.and_then(|(form, scale)| form.tree(scale, spacing)) {
                return Shape::planted(tree, spacing);
            }
            let phase = stock.place.map_or(dvec2(0.5, 0.5), |place| {
                let local = (place - self.origin) / spacing;
                local - local.floor()
            });
            Shape::of(&self.soups[stock.soup], spacing, phase, stock.material, stock.stands)
        };
        stock.shapes[usize::from(level.level).min(LEVELS - 1)].get_or_init(make)
    }
}

/// Whether an area reaches a block grown by some voxels.
fn reaches(reach: [f64; 4], rect: Rect, margin: u32, level: &LevelGrid) -> bool {
    rect.grown(margin, &level.grid).meets(&reach, &level.grid)
}

/// Natural ground at a place, between the posts around it; `None`: there is none.
fn ground_at(grid: &Grid, place: DVec2, maker: &mut dyn NaturalGround) -> Result<Option<f64>> {
    let far = grid.far_corner();
    if !(place.cmpge(grid.origin).all() && place.cmple(far).all()) {
        return Ok(None);
    }
    let last = dvec2(f64::from(grid.nx), f64::from(grid.ny)) - 1.0;
    let at = ((place - grid.origin) / grid.spacing - 0.5).clamp(DVec2::ZERO, last);
    let (x, y, share) = (at.x as u32, at.y as u32, at.fract());
    let rect = Rect { x0: x, y0: y, x1: (x + 2).min(grid.nx), y1: (y + 2).min(grid.ny) };
    let heights = maker.natural(rect)?;
    let post = |east: u32, north: u32| {
        heights[rect.index((x + east).min(rect.x1 - 1), (y + north).min(rect.y1 - 1))]
    };
    let line = |north: u32| post(0, north) * (1.0 - share.x) + post(1, north) * share.x;
    let height = line(0) * (1.0 - share.y) + line(1) * share.y;
    Ok((!height.is_nan()).then_some(height))
}
