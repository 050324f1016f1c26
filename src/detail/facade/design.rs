//! Proportions and colours of façades by the use of a building.

use crate::voxel::FacadeStyle;

/// Colour of a part: so many times that of the wall, and more; linear reflectances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tone {
    pub of_wall: f32,
    pub more: [f32; 3],
}

/// Proportions of one style.
#[derive(Debug, Clone, Copy)]
pub(super) struct Design {
    /// Window in its bay, shares of the bay's width.
    pub window: [f32; 2],
    /// Window in its storey, shares of the storey's height.
    pub window_up: [f32; 2],
    /// Frame about the glass, metres, and shutters beside it, shares of the bay's width, where the seed has some.
    pub frame_m: f32,
    pub shutter: f32,
    /// Door in its bay, shares of the bay's width, and its height, metres.
    pub door: [f32; 2],
    pub door_m: f32,
    /// Heights of the plinth, of the course below each floor but the lowest, and of that below the eaves, metres.
    pub plinth_m: f32,
    pub course_m: f32,
    pub eaves_m: f32,
    pub pane: Tone,
}

/// Door height as a share of its storey, at most.
pub(super) const MOST_DOOR: f32 = 0.92;
/// Plinth height as a share of the lowest storey, at most.
pub(super) const MOST_PLINTH: f32 = 0.2;

const GLASS: Tone = Tone { of_wall: 0.06, more: [0.045, 0.055, 0.07] };
const GATE: Tone = Tone { of_wall: 0.3, more: [0.09, 0.1, 0.1] };

const HOUSE: Design = Design {
    window: [0.3, 0.7],
    window_up: [0.32, 0.78],
    frame_m: 0.08,
    shutter: 0.16,
    door: [0.31, 0.69],
    door_m: 2.1,
    plinth_m: 0.45,
    course_m: 0.0,
    eaves_m: 0.2,
    pane: GLASS,
};

pub(super) const PLINTH: Tone = Tone { of_wall: 0.55, more: [0.02, 0.02, 0.02] };
pub(super) const COURSE: Tone = Tone { of_wall: 0.95, more: [0.09, 0.085, 0.08] };

impl Design {
    /// Proportions of a style.
    pub fn of(style: FacadeStyle) -> Self {
        match style {
            FacadeStyle::House => HOUSE,
            FacadeStyle::Apartments => Self {
                window: [0.25, 0.75],
                window_up: [0.3, 0.82],
                shutter: 0.0,
                door: [0.28, 0.72],
                door_m: 2.4,
                course_m: 0.14,
                eaves_m: 0.35,
                ..HOUSE
            },

            FacadeStyle::Office => Self {
                window: [0.05, 0.95],
                window_up: [0.3, 0.86],
                shutter: 0.0,
                door: [0.12, 0.88],
                door_m: 2.7,
                plinth_m: 0.25,
                eaves_m: 0.5,
                ..HOUSE
            },
            FacadeStyle::Shop => Self {
                window: [0.12, 0.88],
                window_up: [0.2, 0.78],
                shutter: 0.0,
                door: [0.25, 0.75],
                door_m: 2.5,
                plinth_m: 0.3,
                course_m: 0.25,
                eaves_m: 0.35,
                ..HOUSE
            },

            FacadeStyle::Hall => Self {
                window: [0.05, 0.95],
                window_up: [0.64, 0.86],
                shutter: 0.0,
                door: [0.12, 0.88],
                door_m: 4.0,
                plinth_m: 0.6,
                eaves_m: 0.3,
                ..HOUSE
            },
            FacadeStyle::Barn => Self {
                window: [0.4, 0.6],
                window_up: [0.48, 0.68],
                shutter: 0.0,
                door: [0.1, 0.9],
                door_m: 3.2,
                plinth_m: 0.35,
                ..HOUSE
            },

            FacadeStyle::Church => Self {
                window: [0.36, 0.64],
                window_up: [0.26, 0.86],
                shutter: 0.0,
                door: [0.3, 0.7],
                door_m: 3.0,
                plinth_m: 0.8,
                eaves_m: 0.3,
                ..HOUSE
            },

            FacadeStyle::Garage => Self {
                window: [0.08, 0.92],
                window_up: [0.0, 0.84],
                frame_m: 0.06,
                shutter: 0.0,
                door: [0.0, 0.0],
                door_m: 0.0,
                plinth_m: 0.0,
                pane: GATE,
                ..HOUSE
            },
        }
    }
}

/// Colours of frames or shutters by seed, and whether there are shutters.
pub(super) fn frame(seed: u8) -> (Tone, bool) {
    let is_white = seed & 1 == 0;
    let more = match (is_white, seed >> 1 & 1) {
        (true, _) => [0.7, 0.69, 0.66],
        (false, 0) => [0.03, 0.08, 0.05],
        (false, _) => [0.14, 0.07, 0.035],
    };
    (Tone { of_wall: 0.05, more }, !is_white)
}

/// Colours of doors by seed.
pub(super) fn door(seed: u8) -> Tone {
    let more = match seed >> 2 & 3 {
        0 => [0.1, 0.05, 0.03],
        1 => [0.03, 0.06, 0.04],
        2 => [0.13, 0.12, 0.11],
        _ => [0.04, 0.045, 0.07],
    };
    Tone { of_wall: 0.1, more }
}
