//! Geometry of the voxel grid: levels, pages, and the code of heights.

use glam::DVec2;

use hedgehop_base::Size;

/// Side ratio between a level and the next coarser one (the patent's 1, 4, 16, 64).
pub const RADIX: u32 = 4;
/// Levels 1, 4, 16 and 64 are in every database.
pub const MIN_LEVELS: u8 = 4;
/// Voxels along the side of a whole page; pages at the east and north edge are clipped.
pub const PAGE_SIDE: u32 = 256;
/// Level index that names pages of bare ground: what lies under that which stands on pages of level index 0, see FORMAT.md. It has the voxels
/// of level index 0, and is none of [`Grid::level_count`] levels.
pub const BARE: u8 = 128;
/// A further level is added while the coarsest one is wider than this, in voxels.
const COARSEST_SIDE: u32 = 512;

/// Names a page: `level` index (0 = level 1, 1 = level 4, …) and page column and row, counted from
/// the south-west.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PageId {
    /// Level index: side of its voxels is `4^level` units. Or [`BARE`].
    pub level: u8,
    /// Page column, counted eastward.
    pub px: u32,
    /// Page row, counted northward.
    pub py: u32,
}

impl std::fmt::Display for PageId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.level == BARE {
            return write!(f, "page ({}, {}) of bare ground", self.px, self.py);
        }
        write!(f, "page ({}, {}) of level {}", self.px, self.py, Grid::side_units(self.level))
    }
}

impl PageId {
    /// The page of bare ground under a page of level index 0.
    pub fn bare(self) -> Self {
        Self { level: BARE, ..self }
    }

    /// The page of level index 0 over a page of bare ground; of others itself.
    pub fn surface(self) -> Self {
        if self.is_bare() { Self { level: 0, ..self } } else { self }
    }

    /// Whether this is bare ground.
    pub fn is_bare(self) -> bool {
        self.level == BARE
    }
}

/// The grid of the gaming area. Voxel (i, j) of level index `l` covers
/// `origin + spacing·4^l·[i, i+1) × [j, j+1)`, i eastward, j northward; its post is its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Voxels of level 1 eastward, ≥ 1.
    pub nx: u32,
    /// Voxels of level 1 northward, ≥ 1.
    pub ny: u32,
    /// Side of a level-1 voxel (the unit), metres, finite, > 0.
    pub spacing: f64,
    /// South-west corner of the area, metres in the database's CRS.
    pub origin: DVec2,
}

impl Grid {
    /// Returns the number of levels of a grid of this size.
    pub fn level_count(&self) -> u8 {
        let mut levels = MIN_LEVELS;
        while self.dims(levels - 1).0.max(self.dims(levels - 1).1) > COARSEST_SIDE {
            levels += 1;
        }
        levels
    }

    /// Side of a voxel of level index `level`, in units (1, 4, 16, …; no grid has a level of 16 or more).
    pub fn side_units(level: u8) -> u32 {
        1_u32.checked_shl(side_bits(level)).unwrap_or(u32::MAX)
    }

    /// Side of a voxel of level index `level`, metres.
    pub fn side(&self, level: u8) -> f64 {
        self.spacing * f64::from(Self::side_units(level))
    }

    /// Voxels (eastward, northward) of level index `level`.
    pub fn dims(&self, level: u8) -> (u32, u32) {
        // Shifts: the march asks for every block, and divisions took longer than all the rest.
        let bits = side_bits(level).min(63);
        let voxels = |units: u32| ((u64::from(units) + (1 << bits) - 1) >> bits) as u32;
        (voxels(self.nx), voxels(self.ny))
    }

    /// Pages (eastward, northward) of level index `level`.
    pub fn page_dims(&self, level: u8) -> (u32, u32) {
        let (nx, ny) = self.dims(level);
        (nx.div_ceil(PAGE_SIDE), ny.div_ceil(PAGE_SIDE))
    }

    /// Voxels (eastward, northward) of a page, without its apron; `None` if there is no such page.
    pub fn page_size(&self, id: PageId) -> Option<Size> {
        if id.level >= self.level_count() && id.level != BARE {
            return None;
        }
        let (pages_x, pages_y) = self.page_dims(id.level);
        let (nx, ny) = self.dims(id.level);
        (id.px < pages_x && id.py < pages_y).then(|| Size {
            width: (nx - id.px * PAGE_SIDE).min(PAGE_SIDE),
            height: (ny - id.py * PAGE_SIDE).min(PAGE_SIDE),
        })
    }

    /// South-west and north-east corner of the ground under a page, cut to the area, metres in the database's CRS; of a page beyond
    /// the area they may be in any order.
    pub fn page_square(&self, id: PageId) -> [DVec2; 2] {
        let side = self.side(id.level) * f64::from(PAGE_SIDE);
        let low = self.origin + DVec2::new(f64::from(id.px), f64::from(id.py)) * side;
        [low, (low + side).min(self.far_corner())]
    }

    /// North-east corner of the area, metres in the database's CRS.
    pub fn far_corner(&self) -> DVec2 {
        self.origin + DVec2::new(f64::from(self.nx), f64::from(self.ny)) * self.spacing
    }

    /// Whether a horizontal position lies in the area.
    pub fn contains(&self, position: DVec2) -> bool {
        let far = self.far_corner();
        position.cmpge(self.origin).all() && position.cmple(far).all()
    }
}

/// Coding of heights in 16 bits: `height = offset + scale · code`; code 0 says that there is
/// no surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightCode {
    /// Metres per step, finite, > 0.
    pub scale: f64,
    /// Height of code 0, metres, finite.
    pub offset: f64,
}

impl HeightCode {
    /// The code that says: no surface here, rays pass.
    pub const EMPTY: u16 = 0;

    /// The finest code that holds `low..=high` metres (both finite, `low <= high`).
    pub fn spanning(low: f64, high: f64) -> Self {
        let scale = ((high - low) / 65534.0).max(1.0e-4);
        Self { scale, offset: low - scale }
    }

    /// Nearest code of a height in metres; NaN is [`Self::EMPTY`], heights outside are clamped.
    pub fn encode(&self, height: f64) -> u16 {
        if height.is_nan() {
            return Self::EMPTY;
        }
        // Casts cut off and saturate: rounded without a call.
        ((((height - self.offset) / self.scale) + 0.5) as u16).max(1)
    }

    /// Least and greatest of codes, those without a surface left out; `None`: there are no others.
    pub fn range<'a>(codes: impl IntoIterator<Item = &'a u16>) -> Option<(u16, u16)> {
        // Less one, the empty code is the greatest, and loses against every other.
        let meet = |(low, high): (u16, u16), code: &u16| (low.min(code.wrapping_sub(1)), high.max(*code));
        let (low, high) = codes.into_iter().fold((u16::MAX, Self::EMPTY), meet);
        (high != Self::EMPTY).then_some((low.wrapping_add(1), high))
    }

    /// The range of two ranges.
    pub fn joined(one: Option<(u16, u16)>, other: Option<(u16, u16)>) -> Option<(u16, u16)> {
        match (one, other) {
            (Some(one), Some(other)) => Some((one.0.min(other.0), one.1.max(other.1))),
            (one, other) => one.or(other),
        }
    }

    /// Height in metres, or `None` where there is no surface.
    pub fn decode(&self, code: u16) -> Option<f64> {
        (code != Self::EMPTY).then(|| self.offset + self.scale * f64::from(code))
    }
}

/// Returns the logarithm to the base 2 of a voxel's side in units.
fn side_bits(level: u8) -> u32 {
    if level == BARE { 0 } else { RADIX.ilog2() * u32::from(level) }
}
