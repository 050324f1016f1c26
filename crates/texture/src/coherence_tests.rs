//! Texture of the ground is the same from any eye, thread and order of tiles.

use std::thread;

use crate::{
    CellBox, CyclicCode, Eye, EyeAttitude, Generator, GroundView, Projection, Screen, SixMaps, Subterrain,
    SubterrainCode, Tile,
};

/// Patterns of which each place has one value.
struct Patterns {
    code: SubterrainCode,
    tile: Tile,
    maps: SixMaps,
}

impl Patterns {
    fn new() -> Self {
        let subterrains =
            (-20..20).map(|number| Subterrain { first_line: 9 * number, start: number * number });
        Self {
            code: SubterrainCode::new(CyclicCode::default(), subterrains.collect()).unwrap(),
            tile: Generator::White.tile(3).unwrap(),
            maps: SixMaps::new(8.0, 8, 3),
        }
    }

    /// Bits of all values about a cell.
    fn bits(&self, [column, row]: [i64; 2]) -> [u64; 4] {
        let [x, y] = [column, row].map(|place| place as f64);
        let over = CellBox { x0: x - 0.3, x1: x + 17.9, y0: y, y1: y + 2.6 };
        let values = [self.code.tone(column, row).into(), self.code.mean(over), self.tile.mean(over)];
        let [tone, mean, tile] = values.map(f64::to_bits);
        [tone, mean, tile, self.maps.tone(x, y, 2).to_bits()]
    }
}

/// Cells about the origin and far from it, in rows.
fn cells() -> Vec<[i64; 2]> {
    (0..96 * 96).map(|number| [number % 96 * 7 - 300, number / 96 * 5 - 900_000]).collect()
}

#[test]
fn values_do_not_depend_on_threads_and_the_order_of_tiles() {
    let (patterns, cells) = (Patterns::new(), cells());
    let expected: Vec<_> = cells.iter().map(|&cell| patterns.bits(cell)).collect();

    // Backwards, with patterns made anew.
    let again = Patterns::new();
    let mut backwards: Vec<_> = cells.iter().rev().map(|&cell| again.bits(cell)).collect();
    backwards.reverse();
    assert!(backwards == expected);

    // In tiles of 16 × 16 cells, each fifth one first, on four threads.
    let tiles: Vec<usize> = (0..36).map(|number| number * 5 % 36).collect();
    let of_tile =
        |tile: usize| (0..256).map(move |cell| (tile / 6 * 16 + cell / 16) * 96 + tile % 6 * 16 + cell % 16);
    let (patterns, cells, tiles) = (&patterns, &cells, &tiles);
    let mut found = vec![[0; 4]; expected.len()];
    thread::scope(|scope| {
        let worker = |number: usize| {
            scope.spawn(move || {
                let own = tiles.iter().skip(number).step_by(4);
                own.flat_map(|&tile| of_tile(tile))
                    .map(|at| (at, patterns.bits(cells[at])))
                    .collect::<Vec<_>>()
            })
        };
        for worker in (0..4).map(worker).collect::<Vec<_>>() {
            worker.join().unwrap().into_iter().for_each(|(at, bits)| found[at] = bits);
        }
    });
    assert!(found == expected);
}

#[test]
fn two_eyes_see_one_tone_at_a_place() {
    let patterns = Patterns::new();
    let screen = Screen { projection: Projection::OF_THE_STUDY, lines: 480 };
    let eye = |place, altitude, heading_deg, roll_deg| {
        let attitude = EyeAttitude { heading_deg, pitch_deg: -12.0, roll_deg };
        GroundView::new(Eye { place, altitude, attitude }, screen)
    };
    let [ahead, beside] = [eye([0.0, 0.0], 900.0, 0.0, 0.0), eye([4000.0, 3000.0], 700.0, -90.0, 25.0)];

    let mut both = 0;
    for [column, row] in (0..200 * 200).map(|number| [number % 200 * 5 + 350, number / 200 * 2 - 200]) {
        // Middle of a cell of 6 feet, as each eye finds it through its screen.
        let ground = [column, row].map(|place| 6.0 * place as f64 + 3.0);
        let tone = |view: &GroundView| {
            let seen = view.seen(ground);
            let at = view.projected(seen);
            let is_on_screen = seen[0] > 0.0 && at.line.abs() < 240.0 && at.column.abs() < 320.0;
            let cell = view.ground(at).filter(|_| is_on_screen)?.map(|feet| (feet / 6.0).floor() as i64);
            Some(patterns.bits(cell))
        };
        if let (Some(first), Some(second)) = (tone(&ahead), tone(&beside)) {
            assert_eq!(first, second);
            both += 1;
        }
    }
    assert!(both > 500, "{both}");
}
