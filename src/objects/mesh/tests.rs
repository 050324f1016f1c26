use glam::{DVec3, Vec2, Vec3};

use super::*;

/// An uneven surface over a square of 40 m, of two triangles per metre.
fn surface() -> MeshPart {
    let height = |x: u32, y: u32| ((x * 7 + y * 13) % 5) as f32 * 0.3 + (x as f32 * 0.3).sin();
    let corners = (0..41).flat_map(|y| (0..41).map(move |x| (x, y)));
    let positions = corners.map(|(x, y)| Vec3::new(x as f32 - 20.0, y as f32 - 20.0, height(x, y)));
    let cells = (0..40).flat_map(|y| (0..40).map(move |x| 41 * y + x));
    MeshPart {
        positions: positions.collect(),
        normals: Vec::new(),
        places: Vec::new(),
        colours: Vec::new(),
        triangles: cells.flat_map(|at| [[at, at + 1, at + 42], [at, at + 42, at + 41]]).collect(),
        material: Material::of(None),
    }
}

/// The nearest triangle by trying all of them in double precision (Möller and Trumbore, 1997).
fn nearest(part: &MeshPart, origin: DVec3, direction: DVec3) -> Option<f64> {
    let ranges = part.triangles.iter().filter_map(|triangle| {
        let [a, b, c] = triangle.map(|corner| part.positions[corner as usize].as_dvec3());
        let (across, along) = (b - a, c - a);
        let turned = direction.cross(along);
        let inverse = 1.0 / across.dot(turned);
        let from = origin - a;
        let (u, side) = (from.dot(turned) * inverse, from.cross(across));
        let (v, range) = (direction.dot(side) * inverse, along.dot(side) * inverse);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && range >= 0.0).then_some(range)
    });
    ranges.min_by(f64::total_cmp)
}

/// Rays from all around towards the middle part, of several lengths.
fn rays() -> impl Iterator<Item = (DVec3, DVec3)> {
    (0..3000_u32).map(|index| {
        let part = |step: f64| (f64::from(index) * step).fract();
        let (sin, cos) = (std::f64::consts::TAU * part(0.618)).sin_cos();
        let distance = [25.0, 4.0, 30_000.0][index as usize % 3];
        let origin = DVec3::new(cos, sin, 0.1 + part(0.37)) * distance;
        let target = DVec3::new(30.0 * part(0.41) - 15.0, 30.0 * part(0.73) - 15.0, 1.0);
        (origin, (target - origin) * (0.1 + part(0.9)))
    })
}

#[test]
fn rays_meet_the_nearest_triangle() {
    let part = surface();
    let mesh = Mesh::new(vec![part.clone()]).unwrap();
    let (mut met, mut grazing) = (0, 0);
    for (origin, direction) in rays() {
        let exact = nearest(&part, origin, direction);
        let found = mesh.touch(origin, direction, 0.0).map(|point| point.range);
        match (exact, found) {
            (Some(exact), Some(found)) => {
                met += 1;
                let apart = (exact - found).abs() * direction.length();
                assert!(apart < 2e-4 * (1.0 + 0.3 / direction.normalize().z.abs()), "{exact} {found}");
                assert!(mesh.blocks(origin, direction, exact * 1.001));
                assert!(!mesh.blocks(origin, direction, exact * (1.0 - 1e-3) - 1e-3 / direction.length()));
            }
            // At the rim, and where a ray grazes a bump, rounding decides.
            (exact, found) => grazing += usize::from(exact.is_some() || found.is_some()),
        }
    }

    assert!(grazing < 6, "{grazing}");
    assert!(met > 1500, "{met}");
}

#[test]
fn facets_are_what_rays_meet() {
    let part = surface();
    let mesh = Mesh::new(vec![part.clone()]).unwrap();
    let middle = DVec3::ZERO;
    for (origin, direction) in rays().step_by(7) {
        let direction = direction.normalize();
        let (right, down) = direction.any_orthonormal_pair();
        let pixel = 1e-3;

        let basis = Basis::new(
            [origin, DVec3::ZERO, DVec3::ZERO],
            [direction, right * pixel, down * pixel],
            middle,
            29.0,
        );
        let basis = basis.unwrap();
        let bounds = PixelBounds { low: [-3.0; 2], high: [3.0; 2] };
        let mut facets = Vec::new();
        mesh.before(&basis, &bounds, &mut facets);

        for step in 0..9_i32 {
            let (x, y) = (f64::from(step % 3 * 2 - 2), f64::from(step / 3 * 2 - 2));
            let ray = direction + right * (pixel * x) + down * (pixel * y);
            let ways = facets.iter().filter_map(|facet| {
                let around = facet.around(x as f32, y as f32);
                let (way, weights) = around.middle()?;
                assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-4);
                let [near, far] = around.ways();
                assert!(!around.covers() || near <= way + 1e-3 && way <= far + 1e-3, "{near} {way} {far}");
                Some(f64::from(way + basis.begin))
            });

            let (found, exact) = (ways.min_by(f64::total_cmp), nearest(&part, origin, ray));
            match (found, exact) {
                (Some(found), Some(exact)) => {
                    let slant = 0.3 / ray.normalize().z.abs();
                    assert!((found - exact).abs() < 1e-6 * exact + 3e-4 * (1.0 + slant), "{found} {exact}");
                }
                (found, exact) => assert!(found.is_none() && exact.is_none(), "{found:?} {exact:?}"),
            }
        }
    }
}

#[test]
fn what_cannot_be_a_mesh_is_refused() {
    let with = |change: fn(&mut MeshPart)| {
        let mut part = surface();
        change(&mut part);
        Mesh::new(vec![part])
    };

    let refused: [fn(&mut MeshPart); 7] = [
        |part| part.positions[5].y = f32::NAN,
        |part| part.positions[5].y = 1.0e9,
        |part| part.triangles[3] = [0, 1, 5000],
        |part| part.normals.push(Vec3::Z),
        |part| part.places = vec![Vec2::INFINITY; part.positions.len()],
        |part| part.triangles.clear(),
        |part| part.positions.fill(Vec3::ONE),
    ];

    for change in refused {
        let message = with(change).unwrap_err();
        assert!(!message.is_empty() && !message.contains('\n'));
    }

    assert_eq!(with(|_| ()).unwrap().triangle_count(), 3200);
    assert_eq!(with(|part| part.triangles[0] = [7, 7, 8]).unwrap().triangle_count(), 3199);
}

#[test]
fn the_eye_may_be_anywhere() {
    let mesh = Mesh::new(vec![surface()]).unwrap();
    let place = mesh.places_of(mesh.triangle_at(5))[0].as_dvec3();
    for origin in [place, DVec3::ZERO, DVec3::splat(1e12), DVec3::splat(f64::MAX), DVec3::NAN] {
        for direction in [DVec3::X, DVec3::NEG_Z, DVec3::new(1e-30, 0.0, 1.0), DVec3::ZERO] {
            let _ = mesh.touch(origin, direction, 0.0);
            let _ = mesh.blocks(origin, direction, 1e9);
            if let Some(basis) = Basis::new(
                [origin, DVec3::ZERO, DVec3::ZERO],
                [direction, DVec3::Y, DVec3::Z],
                DVec3::ZERO,
                29.0,
            ) {
                let mut facets = Vec::new();
                mesh.before(&basis, &PixelBounds { low: [-0.5; 2], high: [0.5; 2] }, &mut facets);
            }
        }
    }
}
