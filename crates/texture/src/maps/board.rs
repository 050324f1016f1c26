//! Test board: seven faces on a ground of six maps, each with a texture of its own.
//!
//! ```text
//! 9  quantities of X alone, 60 ft apart        12, 13  two maps each, not the same
//! 10 quantities of X and Y, 25 ft apart        14      six maps, in another colour
//! 11 six maps in one primary alone             15      as 14, a level coarser
//! ```
//!
//! Source: Bunker and Ferris 1977 (AFHRL-TR-77-66), texture trials; which two maps, and colours, are ours.

use super::material::MapMaterial;
use super::quantity::{LinearFunction, QuantityMode, QuantityTexture};
use super::six::SixMaps;

/// Strength of maps, and of quantities from dark to light, to a face's own tone.
const STRENGTH: f64 = 0.25;

/// Range of a triangle, there and back.
const TRIANGLE_RANGE: f64 = 1024.0;

/// Face of the board, or the ground about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardFace {
    /// Ground about the faces: six maps.
    Background,
    /// 9: quantities of X.
    QuantityX,
    /// 10: quantities of X and Y.
    QuantityXy,
    /// 11: six maps in red alone.
    OnePrimary,
    /// 12: two maps.
    TwoMaps,
    /// 13: two other maps.
    OtherTwoMaps,
    /// 14: six maps.
    SixMaps,
    /// 15: six maps, a level coarser.
    Coarser,
}

/// Textures of the board. Lengths are in feet.
#[derive(Debug, Clone)]
pub struct TestBoard {
    maps: SixMaps,
    /// Spacing of quantities on faces 9 and 10.
    spacings: [f64; 2],
}

impl BoardFace {
    /// Faces by their numbers, from 9.
    pub const NUMBERED: [Self; 7] = [
        Self::QuantityX,
        Self::QuantityXy,
        Self::OnePrimary,
        Self::TwoMaps,
        Self::OtherTwoMaps,
        Self::SixMaps,
        Self::Coarser,
    ];

    /// Tone without texture in each primary, 0 to 1.
    fn colour(self) -> [f64; 3] {
        match self {
            Self::Background => [0.4, 0.5, 0.3],
            Self::OnePrimary => [0.5, 0.4, 0.4],
            _ => [0.6, 0.5, 0.4],
        }
    }

    fn material(self) -> MapMaterial {
        let plain = MapMaterial::PLAIN;
        let two = |first: usize, second: usize| MapMaterial {
            strengths: std::array::from_fn(|map| f64::from(u8::from(map == first || map == second))),
            ..plain
        };
        match self {
            Self::OnePrimary => MapMaterial { primaries: [1.0, 0.0, 0.0], ..plain },
            Self::TwoMaps => two(0, 3),
            Self::OtherTwoMaps => two(1, 4),
            Self::Coarser => MapMaterial { level_bias: 1, ..plain },
            Self::Background | Self::SixMaps | Self::QuantityX | Self::QuantityXy => plain,
        }
    }
}

impl TestBoard {
    /// Board with zones so wide, and quantities on face 10 so far apart: 8 and 25 feet at first, 16 and 50
    /// later.
    pub fn new(zone_width: f64, spacing_of_10: f64) -> Self {
        Self { maps: SixMaps::new(zone_width, 7, 54), spacings: [60.0, spacing_of_10] }
    }

    /// Maps of the board.
    pub fn maps(&self) -> &SixMaps {
        &self.maps
    }

    /// Tones of the primaries on a face, at a place on the ground and the level that the view asks for.
    pub fn tones(&self, face: BoardFace, x: f64, y: f64, level: u32) -> [f64; 3] {
        let colour = face.colour();
        let change = match face {
            BoardFace::QuantityX => self.quantity(QuantityMode::Triangle, self.spacings[0], x, y),
            BoardFace::QuantityXy => self.quantity(QuantityMode::TriangleSum, self.spacings[1], x, y),
            _ => self.maps.tones(&face.material(), x, y, level),
        };
        [0, 1, 2].map(|primary| colour[primary] * (1.0 + STRENGTH * change[primary]))
    }

    /// Quantities of X and Y with a spacing, −1 to 1.
    fn quantity(&self, mode: QuantityMode, spacing: f64, x: f64, y: f64) -> [f64; 3] {
        let slope = TRIANGLE_RANGE / spacing;
        let along = |x: f64, y: f64| LinearFunction { x, y, offset: 0.0 };
        let functions = [along(slope, 0.0), along(0.0, slope), along(0.0, 0.0)];
        let texture = QuantityTexture { functions, threshold: 255, memory: [0.0; 16] };
        texture.tones(mode, x, y).map(|tone| 2.0 * tone - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places on the ground without order.
    fn places() -> impl Iterator<Item = [f64; 2]> {
        (0..400).map(|number| [f64::from(number) * 13.37 - 900.0, f64::from(number * 7 % 400) * 9.71])
    }

    /// Change of a face's own tone in each primary.
    fn change(board: &TestBoard, face: BoardFace, [x, y]: [f64; 2], level: u32) -> [f64; 3] {
        let (tones, colour) = (board.tones(face, x, y, level), face.colour());
        [0, 1, 2].map(|primary| (tones[primary] / colour[primary] - 1.0) / STRENGTH)
    }

    fn alike(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn faces_9_to_15_differ_as_the_board_says() {
        let board = TestBoard::new(8.0, 25.0);
        assert_eq!(BoardFace::NUMBERED.len(), 15 - 9 + 1);
        for at in places() {
            for level in [1, 2, 4] {
                let of = |face, level| change(&board, face, at, level);
                let ground = of(BoardFace::Background, level);
                assert!((ground[0] - board.maps().tone(at[0], at[1], level)).abs() < 1e-9);

                // The ground's texture on another colour, the same a level coarser, and in red alone.
                assert!(alike(of(BoardFace::SixMaps, level), ground));
                assert!(alike(of(BoardFace::Coarser, level), of(BoardFace::Background, level + 1)));
                assert!(alike(of(BoardFace::OnePrimary, level), [ground[0], 0.0, 0.0]));
                assert_ne!(
                    board.tones(BoardFace::SixMaps, at[0], at[1], level),
                    board.tones(BoardFace::Background, at[0], at[1], level)
                );
            }
        }
    }

    #[test]
    fn faces_of_two_maps_are_constant_square_to_none_but_vary_along_their_own_axes() {
        let board = TestBoard::new(8.0, 25.0);
        let deviation = |face: BoardFace| {
            let tones: Vec<f64> = places().map(|at| change(&board, face, at, 1)[0]).collect();
            (tones.iter().map(|tone| tone * tone).sum::<f64>() / tones.len() as f64).sqrt()
        };
        // A third of the variance of six.
        for face in [BoardFace::TwoMaps, BoardFace::OtherTwoMaps] {
            assert!((deviation(face) / deviation(BoardFace::SixMaps) - 3.0_f64.sqrt().recip()).abs() < 0.06);
        }

        // Six maps less both are the two others.
        for at in places() {
            let of = |face| change(&board, face, at, 1)[0];
            let [two, other, six] = [BoardFace::TwoMaps, BoardFace::OtherTwoMaps, BoardFace::SixMaps].map(of);
            let rest = MapMaterial { strengths: [0.0, 0.0, 1.0, 0.0, 0.0, 1.0], ..MapMaterial::PLAIN };
            assert!((six - two - other - board.maps().tones(&rest, at[0], at[1], 1)[0]).abs() < 1e-9);
            assert_ne!(two, other);
        }
    }

    #[test]
    fn quantities_repeat_after_60_feet_and_25_and_do_not_change_with_levels() {
        for (zone_width, spacing) in [(8.0, 25.0), (16.0, 50.0)] {
            let board = TestBoard::new(zone_width, spacing);
            for [x, y] in places() {
                let of = |face, x, y, level| change(&board, face, [x, y], level);
                let nine = of(BoardFace::QuantityX, x, y, 1);
                assert!(alike(nine, of(BoardFace::QuantityX, x + 60.0, y - 17.3, 5)));
                // Light and dark change places half a spacing on, up to a step of the triangle.
                let half = of(BoardFace::QuantityX, x + 30.0, y, 1);
                assert!((nine[0] + half[0]).abs() < 0.01, "{nine:?} {half:?}");

                let ten = of(BoardFace::QuantityXy, x, y, 1);
                let again = of(BoardFace::QuantityXy, x + spacing, y - 3.0 * spacing, 3);
                assert!((ten[0] - again[0]).abs() < 0.01 && (ten[0] - ten[2]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn faces_show_the_same_place_from_any_eye() {
        // A moved eye changes the level alone.
        let board = TestBoard::new(16.0, 50.0);
        for face in BoardFace::NUMBERED {
            for [x, y] in places() {
                let levels = [900.0, 1400.0].map(|away: f64| board.maps().level_for(1800.0 / away));
                let [near, far] = levels.map(|level| board.tones(face, x, y, level));
                assert!(levels[0] != levels[1] || near == far);
                assert_eq!(near, board.clone().tones(face, x, y, levels[0]));
            }
        }
    }
}
