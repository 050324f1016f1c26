//! Façades of walls: what tells where storeys, windows and doors lie.

/// Use of a building, which its façades show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FacadeStyle {
    /// Houses of one or two families.
    House,
    /// Many alike storeys of windows.
    Apartments,
    /// Bands of glass.
    Office,
    /// Wide panes at the ground, windows above.
    Shop,
    /// High bands of light and gates.
    Hall,
    /// Few small windows, and a gate.
    Barn,
    /// High narrow windows.
    Church,
    /// Gates.
    Garage,
}

impl FacadeStyle {
    /// All of them, by number less 1.
    pub const ALL: [Self; 8] = [
        Self::House,
        Self::Apartments,
        Self::Office,
        Self::Shop,
        Self::Hall,
        Self::Barn,
        Self::Church,
        Self::Garage,
    ];
}

/// Bays of one wall: parts of equal width, each with a window or a door.
///
/// A place along the wall is its scalar product with the direction counter-clockwise of `facing`, metres in the database's system. Every eighth bay
/// has a door.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Bays {
    /// Direction that the wall looks in, 256ths of a turn counter-clockwise from east.
    pub facing: u8,
    /// Width of a bay in [`Self::STEPS`] steps of a metre; 0: the wall has neither windows nor doors.
    pub width: u8,
    /// Start of the bays with doors, 256ths of the width of eight bays.
    pub phase: u8,
}

/// Façade of the part of a building over a voxel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Facade {
    /// Height code of the lowest floor.
    pub floor: u16,
    /// Height code of the uppermost storey's ceiling, above that of the floor.
    pub eaves: u16,
    /// Storeys between these, at least 1.
    pub storeys: u8,
    /// Number of the [style](FacadeStyle) in the lower four bits, 0 = no façade; seed of what differs from building to building above them.
    pub look: u8,
    /// Bays of the walls of the voxel: of two, if walls meet there.
    pub bays: [Bays; 2],
}

impl Bays {
    /// Steps of widths per metre.
    pub const STEPS: f64 = 32.0;
    /// Bays of which one has a door.
    pub const PERIOD: f64 = 8.0;

    /// Bays `width` metres wide, at most 255/32 m, of which one with a door starts at `start`, metres along a wall that looks to `facing`.
    pub fn new(facing: u8, width: f64, start: f64) -> Self {
        // Casts saturate.
        let width = (width * Self::STEPS).round() as u8;
        if width == 0 {
            return Self { facing, ..Self::default() };
        }
        let period = Self::PERIOD * f64::from(width) / Self::STEPS;
        Self { facing, width, phase: ((start / period).rem_euclid(1.0) * 256.0).round() as u32 as u8 }
    }

    /// Turn between the line of the wall and that of one that looks to `facing`, 256ths, 0 to 64.
    pub fn turn_to(self, facing: u8) -> u8 {
        let turn = self.facing.wrapping_sub(facing) % 128;
        turn.min(128 - turn)
    }

    /// Width of a bay, metres.
    pub fn width_m(self) -> f64 {
        f64::from(self.width) / Self::STEPS
    }

    /// Distance of a place along the wall from the start of the last bay with a door before it, metres: 0 up to the width of eight bays.
    pub fn within(self, along: f64) -> f64 {
        let period = Self::PERIOD * self.width_m();
        (along - period * f64::from(self.phase) / 256.0).rem_euclid(period)
    }
}

impl Facade {
    /// No façade: plain walls.
    pub const NONE: Self =
        Self { floor: 0, eaves: 0, storeys: 0, look: 0, bays: [Bays { facing: 0, width: 0, phase: 0 }; 2] };

    /// Look of a style with one of sixteen seeds.
    pub fn look(style: FacadeStyle, seed: u64) -> u8 {
        style as u8 + 1 + 16 * (seed % 16) as u8
    }

    /// Whether walls are plain.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.look & 15 == 0
    }

    /// Style of the façade; `None`: walls are plain, or it is one that is not known here.
    pub fn style(&self) -> Option<FacadeStyle> {
        let number = usize::from(self.look & 15).checked_sub(1)?;
        FacadeStyle::ALL.get(number).copied().filter(|_| self.storeys > 0 && self.floor < self.eaves)
    }

    /// Seed of what differs from building to building, 0 to 15.
    pub fn seed(&self) -> u8 {
        self.look >> 4
    }

    /// Bays of the wall that looks to `facing` as nearly as one does; `None` where none does.
    pub fn bays_of(&self, facing: u8) -> Option<Bays> {
        // Walls of coarse cells look to where they do nearly.
        const NEAR: u8 = 40;

        let [one, other] = self.bays;
        let nearest = match (one.width, other.width) {
            (0, 0) => return None,
            (_, 0) => one,
            (0, _) => other,
            _ if other.turn_to(facing) < one.turn_to(facing) => other,
            _ => one,
        };
        (nearest.turn_to(facing) <= NEAR).then_some(nearest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bays_start_where_they_are_told_to() {
        for (facing, width, start) in [(0, 2.5, 3.0), (200, 3.71, -90.4), (64, 7.9, 4.3e6)] {
            let bays = Bays::new(facing, width, start);
            assert!((bays.width_m() - width).abs() <= 1.0 / 64.0);
            let period = 8.0 * bays.width_m();
            for along in [0.0, 1.3, 0.9 * period] {
                let off = (bays.within(start + along) - along).rem_euclid(period);
                assert!(off.min(period - off) <= period / 512.0 + 1e-9, "{facing}: {off}");
            }
        }
        assert_eq!(Bays::new(9, 0.0, 5.0), Bays { facing: 9, width: 0, phase: 0 });
    }

    #[test]
    fn walls_find_their_bays() {
        let of = |facing: u8| Bays { facing, width: 80, phase: 3 };
        let facade = Facade { bays: [of(10), of(74)], ..Facade::NONE };
        for (facing, found) in [(10, 10), (138, 10), (74, 74), (202, 74), (20, 10), (60, 74)] {
            assert_eq!(facade.bays_of(facing).map(|bays| bays.facing), Some(found), "{facing}");
        }
        let one = Facade { bays: [of(10), Bays::default()], ..facade };
        assert_eq!((one.bays_of(12), one.bays_of(74)), (Some(of(10)), None));
    }

    #[test]
    fn looks_hold_style_and_seed() {
        for style in FacadeStyle::ALL {
            let look = Facade::look(style, 21);
            let facade = Facade { look, storeys: 2, eaves: 9, ..Facade::NONE };
            assert_eq!((facade.style(), facade.seed(), facade.is_none()), (Some(style), 5, false));
        }
        assert_eq!(Facade { look: 15, storeys: 2, eaves: 9, ..Facade::NONE }.style(), None);
        assert!(Facade::NONE.is_none() && Facade::NONE.style().is_none());
    }
}
