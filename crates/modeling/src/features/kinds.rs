//! Kinds of features, in SI units.

use glam::DVec2;

use hedgehop::voxel::{FacadeStyle, Material};

/// Class of a whole layer, where its rows do not say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeatureClass {
    /// Houses, halls, sheds.
    Building,
    /// Ways for wheels and feet.
    Road,
    /// Tracks.
    Railway,
    /// Runways, taxiways, aprons.
    Runway,
    /// Paved areas.
    Pavement,
    /// Flowing water.
    River,
    /// Standing water.
    Lake,
    /// Walls.
    Wall,
    /// Fences.
    Fence,
    /// Hedges.
    Hedge,
    /// Masts, towers, chimneys.
    Mast,
    /// Tanks.
    Tank,
    /// Silos.
    Silo,
    /// Overhead wires.
    PowerLine,
    /// Carriers of wires.
    Pylon,
    /// Single trees, and rows of them.
    Tree,
    /// Areas of trees.
    Wood,
    /// Decks of bridges.
    Bridge,
    /// Natural or farmed ground.
    Ground,
}

impl FeatureClass {
    const NAMES: [(&'static str, Self); 19] = [
        ("building", Self::Building),
        ("road", Self::Road),
        ("railway", Self::Railway),
        ("runway", Self::Runway),
        ("pavement", Self::Pavement),
        ("river", Self::River),
        ("lake", Self::Lake),
        ("wall", Self::Wall),
        ("fence", Self::Fence),
        ("hedge", Self::Hedge),
        ("mast", Self::Mast),
        ("tank", Self::Tank),
        ("silo", Self::Silo),
        ("power-line", Self::PowerLine),
        ("pylon", Self::Pylon),
        ("tree", Self::Tree),
        ("wood", Self::Wood),
        ("bridge", Self::Bridge),
        ("ground", Self::Ground),
    ];

    /// Finds a class by its name in recipes; an error tells all names.
    pub fn of(name: &str) -> Result<Self, String> {
        let found = Self::NAMES.iter().find(|(known, _)| *known == name);
        found.map(|(_, class)| *class).ok_or_else(|| {
            let names: Vec<&str> = Self::NAMES.iter().map(|(name, _)| *name).collect();
            format!("'{name}' is no kind of feature; there are {}", names.join(", "))
        })
    }
}

/// Colour and material of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Paint {
    /// sRGB.
    pub colour: [u8; 3],
    /// Material for correlated sensors.
    pub material: Material,
}

/// Form of a roof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoofShape {
    /// Level.
    Flat,
    /// Two planes that meet in a ridge.
    Gabled,
    /// A plane from each wall.
    Hipped,
    /// Planes that meet in one point.
    Pyramidal,
    /// One plane.
    Skillion,
    /// Round.
    Dome,
}

/// Height of a roof.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rise {
    /// Height from eaves to ridge, metres, ≥ 0.
    Height(f64),
    /// Angle of its planes from the level, degrees, 0…80.
    Angle(f64),
}

/// A roof.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roof {
    /// Form of the roof.
    pub shape: RoofShape,
    /// Height of the roof.
    pub rise: Rise,
    /// Direction in which its (lower) side looks, degrees clockwise from north; `None`: as the footprint suggests.
    pub direction: Option<f64>,
    /// The ridge runs across the longer side.
    pub across: bool,
    /// Nothing is said of its shape: large and crooked buildings may have another one.
    pub is_guess: bool,
}

impl Roof {
    /// Whether its ridge lies above its eaves.
    pub fn rises(&self) -> bool {
        let (Rise::Height(size) | Rise::Angle(size)) = self.rise;
        self.shape != RoofShape::Flat && size > 0.0
    }
}

/// Up to where a building is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Top {
    /// Height of the ridge above the ground, metres.
    Ridge(f64),
    /// Height of the eaves above the ground, metres.
    Eaves(f64),
}

/// Use and levels of a building, which its façades show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacadeKind {
    /// Use of the building.
    pub style: FacadeStyle,
    /// Levels below the roof, where they are stated.
    pub levels: Option<f64>,
}

/// A building, or a part of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Building {
    /// Height of the building.
    pub top: Top,
    /// Height of its lower end above the ground, metres, ≥ 0.
    pub min_height_m: f64,
    /// Roof of the building.
    pub roof: Roof,
    /// Paint of the façades.
    pub walls: Paint,
    /// The roof's surface.
    pub cover: Paint,
    /// A part of a building that may be there as a whole, too.
    pub is_part: bool,
    /// Façades; `None`: walls are plain.
    pub facade: Option<FacadeKind>,
}

/// Kind of thing that runs along a line with a width.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WayKind {
    /// Way for wheels and feet.
    Road,
    /// Tracks.
    Railway,
    /// Runways and taxiways.
    Runway,
}

/// Dashes of a broken line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dashes {
    /// Length of a dash, metres, > 0.
    pub dash_m: f64,
    /// Length of a gap, metres, > 0.
    pub gap_m: f64,
}

/// Lines painted on a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneLines {
    /// Lanes, 1 and more: between them are broken lines.
    pub lanes: u32,
    /// Whether all lanes run in the direction of the road's line.
    pub is_one_way: bool,
    /// Greatest width of a lane, metres, > 0.
    pub lane_m: f64,
    /// Dashes of lines between lanes.
    pub dashes: Dashes,
    /// Width of lines between lanes, metres, > 0.
    pub width_m: f64,
    /// Width of lines along the edges, metres, > 0; `None`: there are none.
    pub edge_m: Option<f64>,
    /// Distance of the middle of edge lines from the edge, metres, ≥ 0.
    pub inset_m: f64,
}

/// Rows on farmed ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldRows {
    /// Tracks of wheels through a crop.
    Tramlines,
    /// Vines.
    Vines,
    /// Fruit trees.
    Fruit,
}

/// A way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// Kind of way.
    pub kind: WayKind,
    /// Width, metres, > 0.
    pub width_m: f64,
    /// Paint of the surface.
    pub paint: Paint,
    /// Steepest that it is built, rise over run, > 0.
    pub most_grade: f64,
    /// Whether it runs over a bridge.
    pub is_bridge: bool,
    /// Layer of the way: of several, the one with the greatest number lies above the others.
    pub layer: i32,
    /// Lines painted on it; `None`: there are none.
    pub lines: Option<LaneLines>,
}

/// Wall, fence or hedge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Barrier {
    /// Height, metres, > 0.
    pub height_m: f64,
    /// Thickness, metres, > 0.
    pub thickness_m: f64,
    /// Share of the light that it hides, 0…1.
    pub opacity: f64,
    /// Paint of the surface.
    pub paint: Paint,
    /// Whether it fills its areas, and does not run along their outlines.
    pub is_filled: bool,
}

/// Top of something round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cap {
    /// Level.
    Flat,
    /// A flattened half of a ball.
    Dome,
    /// A cone.
    Cone,
    /// Level, and waisted below: a cooling tower.
    Waisted,
}

/// Something round that stands upright: masts, towers, chimneys, tanks, silos, pylons.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Upright {
    /// Height, metres, > 0.
    pub height_m: f64,
    /// Diameter at the ground, metres, > 0; `None`: that of its area.
    pub diameter_m: Option<f64>,
    /// Diameter at its top as a share of that at the ground, 0…1.
    pub taper: f64,
    /// Form of its top.
    pub cap: Cap,
    /// Share of the light that it hides, 0…1: lattices are not dense.
    pub opacity: f64,
    /// Paint of the surface.
    pub paint: Paint,
}

/// A tower, tank or silo that has an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure {
    /// Form over an outline that is a circle.
    pub round: Upright,
    /// Form over any other outline, which is that of its walls.
    pub walled: Building,
}

/// A wire of a power line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wire {
    /// Distance to the right of the line, metres.
    pub offset_m: f64,
    /// Height of its ends above the ground, metres.
    pub height_m: f64,
}

/// A power line.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerLine {
    /// Wires of the line.
    pub wires: Vec<Wire>,
    /// Sag per square of a span's length, 1/m: with one tension and one weight the sag grows with the square of the span.
    pub sag_per_m: f64,
    /// Pylon at its vertices; it has arms as long as wires need.
    pub pylon: Upright,
    /// Pylons at single vertices, by rows of their own.
    pub stated: Vec<(DVec2, Upright)>,
}

/// Kind of trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leaf {
    /// Oaks, beeches: round crowns.
    Broad,
    /// Spruces, pines: pointed crowns.
    Needle,
    /// Either.
    Mixed,
}

/// A tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tree {
    /// Height, metres, > 0.
    pub height_m: f64,
    /// Diameter of its crown, metres, > 0.
    pub crown_m: f64,
    /// Kind of its leaves; not [`Leaf::Mixed`].
    pub leaf: Leaf,
    /// Paint of its crown.
    pub paint: Paint,
}

/// An area of trees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wood {
    /// Mean height, metres, > 0.
    pub height_m: f64,
    /// Trees per hectare, > 0.
    pub density: f64,
    /// Trees that grow there.
    pub leaf: Leaf,
    /// Rows in which they stand; `None`: by chance.
    pub rows: Option<FieldRows>,
}

/// Meaning of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Meaning {
    /// A building.
    Building(Building),
    /// A road, railway, runway.
    Way(Way),
    /// An area with a surface of its own, level with the ground.
    Pavement(Paint),
    /// Natural or farmed ground: its material, and its colour where no imagery shows it.
    Ground(Paint),
    /// The same with rows on it.
    Field(Paint, FieldRows),
    /// Flowing water of this width, metres; areas of it are lakes here if they stand still, and rivers if not.
    River(f64),
    /// Standing water.
    Lake,
    /// A wall, fence or hedge.
    Barrier(Barrier),
    /// A mast, tank, tower.
    Upright(Upright),
    /// One that has an outline.
    Structure(Structure),
    /// Carrier of wires, and whether its height is stated.
    Pylon(Upright, bool),
    /// Overhead wires.
    PowerLine(PowerLine),
    /// Trees: at its points, or in a row along its lines, this many metres apart.
    Trees(Tree, f64),
    /// A wood.
    Wood(Wood),
    /// The deck of a bridge, as an area.
    Bridge(Paint),
    /// Nothing that is known here.
    Unknown,
    /// Known, but not to be seen, and why.
    Hidden(&'static str),
}
