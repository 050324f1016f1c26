//! Models of known form, over voxels.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, dvec2};

use super::shape::{Shape, laid};
use super::soup::{Face, Soup};
use crate::features::{Solid, Wall};
use hedgehop::voxel::Symmetry;
use hedgehop_assets::model::{Material, Texture, Wrap};

/// Triangles without a model.
fn soup(triangles: &[[DVec3; 3]], heading_deg: f64) -> Soup {
    textured(triangles, [Vec2::ZERO; 3], Material::of(None), heading_deg)
}

fn textured(triangles: &[[DVec3; 3]], places: [Vec2; 3], material: Material, heading_deg: f64) -> Soup {
    let colours = [Vec3::splat(0.5); 3];
    let turn = DMat3::from_rotation_z(-heading_deg.to_radians());
    let faces = triangles.iter().map(|corners| Face {
        corners: corners.map(|corner| turn * corner),
        places,
        colours,
        material: 0,
        piece: 0,
    });
    let mut soup = Soup::built_in(faces.collect());
    soup.materials = vec![material];
    soup
}

/// Quads of a box from west, south, 0 to east, north, top; faces outward.
fn cuboid(half: DVec3) -> Vec<[DVec3; 3]> {
    let corner = |index: usize| {
        let sign = |bit: usize| if index >> bit & 1 == 1 { 1.0 } else { -1.0 };
        DVec3::new(sign(0) * half.x, sign(1) * half.y, (sign(2) + 1.0) * half.z)
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    quads
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
        .map(|triangle| triangle.map(corner))
        .collect()
}

fn ball(radius: f64, rings: usize) -> Vec<[DVec3; 3]> {
    let at = |ring: usize, turn: usize| {
        let (polar, around) = (PI * ring as f64 / rings as f64, PI * turn as f64 / rings as f64);
        DVec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), 1.0 - polar.cos()) * radius
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for turn in 0..2 * rings {
            let next = (turn + 1) % (2 * rings);
            let [a, b, c, d] = [at(ring, turn), at(ring, next), at(ring + 1, next), at(ring + 1, turn)];
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    triangles
}

/// Height of a shape's matter at a place, metres from the foot, and how much of the column is filled.
fn column(shape: &Shape, spacing: f64, place: DVec2, phase: DVec2) -> f64 {
    let voxel = (place / spacing + phase).floor();
    let from = place + phase * spacing - (voxel + 0.5) * spacing;
    let solids = shape.over([voxel.x as i64, voxel.y as i64]);
    let of = |solid: &Solid| {
        let mut planes = solid.wall.planes();
        let is_there = planes.all(|(facing, distance_m)| DVec2::from_angle(facing).dot(from) <= distance_m);
        let rise = dvec2(solid.slope[0], solid.slope[1]).dot(from);
        let low = solid.low_m.map_or(0.0, |low| if solid.parallel { low + rise } else { low });
        if is_there { (solid.high_m + rise - low).max(0.0) * solid.opacity } else { 0.0 }
    };
    solids.iter().map(of).sum()
}

fn volume(shape: &Shape, spacing: f64, reach: f64, phase: DVec2) -> f64 {
    let step = 0.05;
    let count = (2.0 * reach / step) as i64;
    let at = |index: i64| (index as f64 + 0.5) * step - reach;
    let sum: f64 = (0..count)
        .flat_map(|row| (0..count).map(move |col| (col, row)))
        .map(|(col, row)| column(shape, spacing, dvec2(at(col), at(row)), phase))
        .sum();
    sum * step * step
}

#[test]
fn boxes_have_straight_walls_at_any_heading() {
    let half = DVec3::new(4.3, 2.7, 3.0);
    for (heading, spacing, phase) in [
        (0.0, 1.0, dvec2(0.5, 0.5)),
        (17.0, 1.0, dvec2(0.2, 0.9)),
        (45.0, 0.5, DVec2::ZERO),
        (120.0, 1.0, dvec2(0.7, 0.1)),
    ] {
        let shape = Shape::of(&soup(&cuboid(half), heading), spacing, phase, 0, true);
        let axes = [0.0_f64, 90.0].map(|turn| DVec2::from_angle((turn - heading).to_radians()));
        for (axis, far, along, wide) in
            [(axes[0], half.x, axes[1], half.y), (axes[1], half.y, axes[0], half.x)]
        {
            for sign in [-1.0, 1.0] {
                // Walls far from corners, and beside them.
                let mut worst = [0.0_f64; 2];
                for step in -20..=20 {
                    let at = f64::from(step) / 20.0 * (wide - 0.1);
                    let wall = (-200..=200)
                        .map(|step| far + f64::from(step) * 0.005)
                        .filter(|far| column(&shape, spacing, along * at + axis * (sign * far), phase) > 3.0)
                        .fold(0.0, f64::max);
                    let worst = &mut worst[usize::from(at.abs() > wide - 1.5 * spacing)];
                    *worst = worst.max((wall - far).abs());
                }

                let bounds = [0.05, 0.1].map(|bound| bound * spacing.max(1.0));
                assert!(worst[0] < bounds[0] && worst[1] < bounds[1], "{heading}: {worst:?}");
            }
        }

        let tops = (-3..=3).map(|at| column(&shape, spacing, axes[0] * f64::from(at), phase));
        tops.for_each(|top| assert!((top - 6.0).abs() < 1e-9, "{top}"));
    }
}

#[test]
fn balls_keep_their_volume() {
    for (spacing, phase) in [(1.0, dvec2(0.5, 0.5)), (0.5, dvec2(0.1, 0.8)), (2.0, DVec2::ZERO)] {
        let shape = Shape::of(&soup(&ball(6.0, 40), 0.0), spacing, phase, 0, true);
        let found = volume(&shape, spacing, 8.0, phase);
        let wanted = 4.0 / 3.0 * PI * 216.0;
        assert!((found / wanted - 1.0).abs() < 0.03, "{spacing}: {found} of {wanted}");
    }
}

#[test]
fn open_sheets_are_thin_and_slope() {
    // A plane of 8 by 8 m that rises eastward, from 4 m on.
    let corner = |x: f64, y: f64| DVec3::new(x, y, 6.0 + 0.5 * x);
    let [a, b, c, d] = [corner(-4.0, -4.0), corner(4.0, -4.0), corner(4.0, 4.0), corner(-4.0, 4.0)];
    let shape = Shape::of(&soup(&[[a, b, c], [a, c, d]], 0.0), 1.0, DVec2::ZERO, 0, true);

    for x in -4..4 {
        let [solid] = shape.over([x, 1]) else { panic!("{x}: {:?}", shape.over([x, 1])) };
        assert!((solid.high_m - (6.25 + 0.5 * x as f64)).abs() < 1e-9, "{solid:?}");
        assert!((solid.high_m - solid.low_m.unwrap() - 0.25).abs() < 1e-9 && solid.parallel);
        assert!((solid.slope[0] - 0.5).abs() < 1e-9 && solid.slope[1].abs() < 1e-9, "{solid:?}");
        assert_eq!((solid.wall, solid.opacity), (Wall::Whole, 1.0));
    }

    assert!(shape.over([4, 0]).is_empty() && shape.over([0, -5]).is_empty());
    // One that stands is a wall.
    let corner = |y: f64, z: f64| DVec3::new(0.3, y, z);
    let [a, b, c, d] = [corner(-4.0, 0.0), corner(4.0, 0.0), corner(4.0, 3.0), corner(-4.0, 3.0)];
    let shape = Shape::of(&soup(&[[a, b, c], [a, c, d]], 0.0), 1.0, DVec2::ZERO, 0, true);
    let [solid] = shape.over([0, 2]) else { panic!("{:?}", shape.over([0, 2])) };
    assert!(
        matches!(solid.wall, Wall::Plane { distance_m, .. } if (distance_m - 0.2).abs() < 1e-9),
        "{solid:?}"
    );
    assert_eq!((solid.low_m, solid.high_m, solid.opacity), (None, 3.0, 1.0));
}

#[test]
fn holes_do_not_leak() {
    let whole = ball(6.0, 40);
    let phase = dvec2(0.5, 0.5);
    let volume_of = |triangles: &[[DVec3; 3]]| {
        volume(&Shape::of(&soup(triangles, 0.0), 1.0, phase, 0, true), 1.0, 8.0, phase)
    };
    let all = volume_of(&whole);

    // Without some triangles of its top: no more is lost than lies below them.
    let pierced: Vec<_> =
        whole.iter().filter(|triangle| !triangle.iter().all(|corner| corner.z > 11.85)).copied().collect();
    assert!(pierced.len() < whole.len());
    let left = volume_of(&pierced);
    assert!((0.93..1.001).contains(&(left / all)), "{left} of {all}");

    // Turned inside out it is the same.
    let inverted: Vec<_> = whole.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    assert!((volume_of(&inverted) / all - 1.0).abs() < 1e-6);

    // A house without a floor is filled, as is one whose faces look either way.
    let cuboid = cuboid(DVec3::new(4.0, 3.0, 2.0));
    for triangles in [
        &cuboid[2..],
        &cuboid
            .iter()
            .enumerate()
            .map(|(index, [a, b, c])| if index % 3 == 0 { [*a, *c, *b] } else { [*a, *b, *c] })
            .collect::<Vec<_>>(),
    ] {
        assert!((volume_of(triangles) - 192.0).abs() < 1.0, "{}", volume_of(triangles));
    }
}

#[test]
fn textures_colour_tops_and_holes_in_them_let_light_through() {
    // One quad, red in its west and blue in its east, with holes in the northern half.
    let texels = vec![[255, 0, 0, 0], [0, 0, 255, 0], [255, 0, 0, 255], [0, 0, 255, 255]];
    let texture = Texture::new(2, 2, texels, [Wrap::Clamp; 2]).unwrap();
    let material =
        Material { texture: Some(Arc::new(texture)), cutoff: Some(0.5), ..Material::of(Some(Vec3::ONE)) };
    let triangle = [DVec3::new(-8.0, -8.0, 3.0), DVec3::new(8.0, -8.0, 3.0), DVec3::new(-8.0, 8.0, 3.0)];
    let places = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(0.0, 0.0)];
    let shape = Shape::of(&textured(&[triangle], places, material, 0.0), 1.0, DVec2::ZERO, 0, true);
    let [solid] = shape.over([-6, -6]) else { panic!() };
    assert!(solid.top[0] > 180 && solid.top[2] < 5, "{solid:?}");
    let [solid] = shape.over([4, -6]) else { panic!() };
    assert!(solid.top[2] > 180 && solid.top[0] < 60, "{solid:?}");
    assert!(shape.over([-6, 4]).is_empty());
}

#[test]
fn poles_that_rays_miss_are_there() {
    let pole = cuboid(DVec3::new(0.05, 0.05, 3.0));
    let shape = Shape::of(&soup(&pole, 0.0), 1.0, dvec2(0.5, 0.5), 0, true);
    let [solid] = shape.over([0, 0]) else { panic!("{:?}", shape.over([0, 0])) };
    assert!((0.06..0.2).contains(&solid.opacity) && (solid.high_m - 6.0).abs() < 1e-6, "{solid:?}");
    // A garden wall of 20 cm hides all behind it.
    let wall = cuboid(DVec3::new(5.0, 0.1, 1.0));
    let shape = Shape::of(&soup(&wall, 0.0), 1.0, dvec2(0.5, 0.5), 0, true);
    for x in -4..=4 {
        let [solid] = shape.over([x, 0]) else { panic!("{:?}", shape.over([x, 0])) };
        let Wall::Corner(sides) = solid.wall else { panic!("{solid:?}") };
        assert!(solid.opacity == 1.0 && sides.iter().all(|(_, distance_m)| (distance_m - 0.1).abs() < 1e-9));
    }
    // Nothing stands beside a wall that ends with its voxel.
    let shape = Shape::of(&soup(&cuboid(DVec3::new(3.0, 3.0, 1.0)), 0.0), 1.0, DVec2::ZERO, 0, true);
    assert!(shape.over([3, 0]).is_empty() && shape.over([-4, 0]).is_empty());
}

#[test]
fn eight_ways_to_lay_a_shape() {
    let triangles: Vec<_> = cuboid(DVec3::new(4.3, 2.2, 2.0))
        .into_iter()
        .chain(cuboid(DVec3::new(0.7, 3.3, 4.0)).into_iter().map(|t| t.map(|corner| corner + DVec3::X * 2.9)))
        .collect();
    let phase = dvec2(0.5, 0.5);
    let shape = Shape::of(&soup(&triangles, 20.0), 1.0, phase, 0, true);

    for number in 0..8 {
        let symmetry = Symmetry::new(number);
        let moved: Vec<_> = triangles
            .iter()
            .map(|triangle| {
                let turn = DMat3::from_rotation_z(-20.0_f64.to_radians());
                let quarters = DMat3::from_rotation_z(f64::from(symmetry.turns()) * 0.5 * PI);
                let mirror = DMat3::from_diagonal(DVec3::new(
                    if symmetry.is_mirrored() { -1.0 } else { 1.0 },
                    1.0,
                    1.0,
                ));
                let [a, b, c] = triangle.map(|corner| quarters * mirror * turn * corner);
                if symmetry.is_mirrored() { [a, c, b] } else { [a, b, c] }
            })
            .collect();

        let wanted = Shape::of(&soup(&moved, 0.0), 1.0, phase, 0, true);
        let (mut there, mut same) = (0, 0);
        for voxel in (-8..8).flat_map(|y| (-8..8).map(move |x| [x, y])) {
            let laid: Vec<Solid> =
                shape.over(symmetry.turn_back(voxel)).iter().map(|solid| laid(symmetry, solid)).collect();
            assert_eq!(symmetry.turn(symmetry.turn_back(voxel)), voxel);
            let wanted = wanted.over(voxel);
            there += wanted.len();

            same += wanted
                .iter()
                .zip(&laid)
                .filter(|(a, b)| {
                    let slopes = dvec2(a.slope[0], a.slope[1]).distance(dvec2(b.slope[0], b.slope[1]));
                    let walls = match (a.wall, b.wall) {
                        (
                            Wall::Plane { facing: a, distance_m: d },
                            Wall::Plane { facing: b, distance_m: e },
                        ) => (d - e).abs() < 0.04 && (a - b).cos() > 0.999,
                        (a, b) => std::mem::discriminant(&a) == std::mem::discriminant(&b),
                    };
                    slopes < 0.1 && walls && (a.high_m - b.high_m).abs() < 0.2
                })
                .count();
        }

        // At corners of walls one of two is chosen, which is not the same from every side.
        assert!(same as f64 > 0.75 * there as f64, "{number}: {same} of {there}");
    }
}

/// Slabs one above the other, whose walls lie in one plane, keep the air between them.
#[test]
fn parts_above_each_other_keep_their_air() {
    let half = DVec3::new(5.0, 5.0, 0.5);
    let slabs = |pitch: f64| -> Vec<[DVec3; 3]> {
        let raised = |level: usize| {
            let up = DVec3::Z * pitch * level as f64;
            cuboid(half).into_iter().map(move |triangle| triangle.map(|corner| corner + up))
        };
        (0..4).flat_map(raised).collect()
    };

    for (pitch, spacing, heading) in [
        (6.0, 0.25, 0.0),
        (6.0, 1.0, 0.0),
        (6.0, 2.0, 30.0),
        (1.5, 1.0, 0.0),
        (2.5, 0.5, 45.0),
        (9.0, 1.0, 17.0),
    ] {
        let context = format!("{pitch} m apart, voxels of {spacing} m, turned by {heading}");
        let phase = dvec2(0.3, 0.6);
        let shape = Shape::of(&soup(&slabs(pitch), heading), spacing, phase, 0, true);
        let mut solids = 0;

        for voxel in (-50..50).flat_map(|y| (-50..50).map(move |x| [x, y])) {
            for solid in shape.over(voxel) {
                let low = solid.low_m.unwrap_or(0.0);
                let level = (low / pitch).round() * pitch;
                let ends = [low - level, solid.high_m - level - 1.0];
                assert!(ends.iter().all(|end| end.abs() < 1e-6), "{context}: {voxel:?}: {solid:?}");
                solids += 1;
            }
        }

        let floor = (2.0 * half.x / spacing).powi(2);
        assert!(f64::from(solids) > 4.0 * floor, "{context}: {solids} solids");
    }

    // Without air between them they are one.
    let shape = Shape::of(&soup(&slabs(1.0), 0.0), 1.0, DVec2::ZERO, 0, true);
    let [solid] = shape.over([4, 2]) else { panic!("{:?}", shape.over([4, 2])) };
    assert_eq!((solid.low_m, solid.high_m), (None, 4.0));
}
