use super::*;
use crate::cell_box::brute_force;
use crate::octaves::broad_band;
use crate::pattern::XorPattern;
use crate::spectrum::Spectrum;
use hedgehop_base::chance::Random;

fn white() -> Tile {
    Tile::new(&XorPattern::default().cells()).unwrap()
}

fn broad(seed: u64) -> Tile {
    let patterns: Vec<Cells> = (0..4).map(|octave| XorPattern::seeded(seed + octave).cells()).collect();
    Tile::new(&broad_band(&patterns)).unwrap()
}

#[test]
fn voxels_rows_and_columns_sum_to_zero_exactly() {
    for tile in [white(), broad(0), broad(10)] {
        let sum = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
            rows.flat_map(|row| columns.clone().map(move |column| row * SIDE + column))
                .map(|cell| i64::from(tile.steps()[cell]))
                .sum::<i64>()
        };
        for (x, y) in (0..17).flat_map(|y| (0..17).map(move |x| (x * 15, y * 15))) {
            assert_eq!(sum(x..x + 15, y..y + 15), 0, "voxel at {x}, {y}");
        }
        for line in 0..SIDE {
            assert_eq!((sum(0..SIDE, line..line + 1), sum(line..line + 1, 0..SIDE)), (0, 0), "line {line}");
        }
        assert_eq!(tile.largest_voxel_mean(), 0.0);

        // The sums' rim is zero, so that they repeat.
        for entry in 0..=SIDE {
            assert_eq!((tile.sums()[entry * 256 + 255], tile.sums()[255 * 256 + entry]), (0, 0));
        }
    }
}

#[test]
fn tile_keeps_its_contrast_and_its_values() {
    for (tile, least) in [(white(), 0.993), (broad(0), 0.96), (broad(100), 0.96)] {
        assert!(tile.contrast_kept() > least, "{} kept", tile.contrast_kept());
    }

    for cells in [XorPattern::default().cells(), XorPattern::seeded(4).cells().averaged(2)] {
        let tile = Tile::new(&cells).unwrap();
        let exact = without_means(&cells);
        let deviation = exact.deviation();
        let mut worst = 0.0_f64;
        for (step, value) in tile.steps().iter().zip(exact.values()) {
            worst = worst.max((f64::from(*step) * tile.scale() - value / deviation).abs());
        }
        let squares: f64 = tile.steps().iter().map(|&step| (f64::from(step) * tile.scale()).powi(2)).sum();
        assert!((squares / (SIDE * SIDE) as f64 - 1.0).abs() < 1e-12);
        assert!(worst < 1e-3, "rounding moved a cell by {worst} deviations");
    }
}

#[test]
fn tile_of_a_white_pattern_is_white_and_isotropic() {
    let tile = white();
    let spectrum = Spectrum::of(&Cells::of(|column, row| tile.value(column, row)));
    assert!(spectrum.worst_correlation_beyond(8.0) <= 0.05);

    // The fourth octave is longer than a voxel, whose mean is taken out.
    let spreads = spectrum.sector_spreads_db();
    assert!(spreads[..3].iter().all(|&spread| spread <= 1.5), "{spreads:?} dB");
}

#[test]
fn means_equal_brute_force() {
    let tile = broad(3);
    let mut random = Random(8);
    let mut worst = 0.0_f64;
    for _ in 0..2000 {
        let (x0, y0) = (random.unit() * 1200.0 - 600.0, random.unit() * 1200.0 - 600.0);
        let (width, height) = (0.05 + random.unit().powi(4) * 300.0, 0.05 + random.unit().powi(4) * 300.0);
        let over = CellBox { x0, x1: x0 + width, y0, y1: y0 + height };
        worst = worst.max((tile.mean(over) - brute_force(|column, row| tile.value(column, row), over)).abs());
    }
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn means_are_exact_a_billion_cells_away() {
    let tile = white();
    let mut random = Random(9);
    for far in [1e9, -1e9] {
        for _ in 0..500 {
            // Corners in eighths of a cell are exact out there.
            let corner = |unit: f64| far + (unit * 4000.0).floor() / 8.0;
            let (x0, y0) = (corner(random.unit()), corner(random.unit()));
            let over = CellBox { x0, x1: x0 + 3.625, y0, y1: y0 + 41.25 };
            let error = (tile.mean(over) - brute_force(|column, row| tile.value(column, row), over)).abs();
            assert!(error < 1e-9, "{error} at {over:?}");
        }
    }
}

#[test]
fn means_of_small_turned_and_boundless_boxes_are_defined() {
    let tile = white();
    let point = CellBox { x0: 7.5, x1: 7.5, y0: -3.5, y1: -3.5 };
    assert!((tile.mean(point) - tile.value(7, -4)).abs() < 1e-9);

    let ordered = CellBox { x0: 1.25, x1: 9.5, y0: 2.0, y1: 3.75 };
    let turned = CellBox { x0: ordered.x1, x1: ordered.x0, y0: ordered.y1, y1: ordered.y0 };
    assert_eq!(tile.mean(ordered), tile.mean(turned));

    for wrong in [f64::NAN, f64::INFINITY] {
        assert!(tile.mean(CellBox { x1: wrong, ..ordered }).is_nan());
    }
    let vast = CellBox { x0: -1e12, x1: 1e12, y0: 0.0, y1: 1.0 };
    assert!(tile.mean(vast).abs() < 1e-6);
}

#[test]
fn patterns_without_detail_are_refused() {
    let error = |cells: Cells| Tile::new(&cells).unwrap_err().to_string();
    assert!(error(Cells::of(|_, _| 3.0)).contains("nothing is left"));
    assert!(error(Cells::of(|column, _| column as f64)).contains("nothing is left"));
    assert!(
        error(Cells::of(|column, row| (column / 15 * row / 15) as f64 * 0.0)).contains("nothing is left")
    );
    assert!(error(Cells::of(|column, _| 1.0 / column as f64)).contains("no finite number"));
}

#[test]
fn peaks_fit_into_steps() {
    let tile = Tile::new(&Cells::of(|column, row| f64::from(u8::from(column == 100 && row == 100)))).unwrap();
    assert!(tile.value(100, 100) > 200.0);
    assert!(tile.steps()[100 * SIDE + 100] > 32_000);
}
