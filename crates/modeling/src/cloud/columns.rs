//! Columns of solids over the voxels of a tile.

use super::super::features::Solid;
use super::class::PointKind;
use super::hard::Hard;
use super::runs::Plants;
use super::scene::TileScene;
use super::store::TILE;
use super::stored::StoredSolid;
use super::window::TileVoxel;
use super::wires;

/// Voxels about a tile whose points are asked for: what is known of roofs around a voxel follows from points around these.
pub(super) const HALO: i64 = 5;
/// Voxels at the rim of a window of which too little is known.
const RIM: usize = 2;

/// The solids over a tile, voxel by voxel.
pub(super) fn solids(scene: &TileScene<'_>) -> Vec<StoredSolid> {
    let has = |kind: PointKind| {
        scene.voxels().any(|voxel| scene.window.at(voxel).iter().any(|mark| mark.kind() == kind))
    };
    let mut roofs = vec![f64::NAN; scene.ground.len()];
    let mut hard: Vec<Vec<Solid>> = vec![Vec::new(); scene.ground.len()];
    let kinds = [Hard::roofs(scene), Hard::decks(scene)];
    let inner = RIM..scene.window.side - RIM;
    let is_inner = |voxel: &TileVoxel| inner.contains(&voxel.column) && inner.contains(&voxel.row);

    for voxel in scene.voxels().filter(is_inner) {
        let index = scene.index(voxel);
        for solid in kinds.iter().filter_map(|kind| kind.solid(scene, voxel)) {
            roofs[index] = roofs[index].max(solid.high_m);
            hard[index].push(solid);
        }
    }

    let plants = Plants { scene, roofs: &roofs };
    let (has_towers, has_wires) = (has(PointKind::Tower), has(PointKind::Wire));
    let mut out = Vec::new();
    let mut over = Vec::new();

    for (column, row) in (0..TILE).flat_map(|row| (0..TILE).map(move |column| (column, row))) {
        let voxel = TileVoxel { column: (column + HALO) as usize, row: (row + HALO) as usize };
        over.append(&mut hard[scene.index(voxel)]);
        plants.solids(voxel, &mut over);
        if has_towers {
            plants.towers(voxel, &mut over);
        }
        if has_wires && !scene.ground[scene.index(voxel)].is_nan() {
            wires::strips(scene, voxel, &mut over);
        }
        out.extend(over.drain(..).map(|solid| StoredSolid::of([column as u8, row as u8], &solid)));
    }

    out
}
