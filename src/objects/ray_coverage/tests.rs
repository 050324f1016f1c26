use super::*;
use crate::earth::Curvature;
use crate::objects::Body;
use crate::objects::body::SeenForm;
use crate::objects::view::nearest;
use crate::simd::Isa;
use crate::space::{Attitude, Camera, Pose};

#[test]
fn shares_of_half_planes_are_nearly_exact() {
    let offsets = || {
        (0..RAYS / LANES).flat_map(|batch| {
            let [x, y] = ALL[batch].map(|offsets| offsets.map(f64::from));
            (0..LANES).map(move |lane| DVec2::new(x[lane], y[lane]))
        })
    };
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);

    for turn in 0..360 {
        let (sin, cos) = f64::from(turn).to_radians().sin_cos();
        let (wide, high) = (cos.abs(), sin.abs());
        for place in -9..10 {
            let place = f64::from(place) * 0.07;
            let seen = offsets().filter(|offset| offset.dot(DVec2::new(cos, sin)) < place).count();

            // Area of a unit square on one side of a line: the convolution of two boxes.
            let ramp = |at: f64| at.max(0.0).powi(2) / 2.0;
            let exact = if wide.min(high) < 1e-9 {
                (place + 0.5).clamp(0.0, 1.0)
            } else {
                let (a, b) = (0.5 * (wide + high), 0.5 * (wide - high));
                (ramp(place + a) - ramp(place + b) - ramp(place - b) + ramp(place - a)) / (wide * high)
            };
            let error = (seen as f64 / RAYS as f64 - exact).abs();
            (sum, worst, count) = (sum + error, worst.max(error), count + 1);
        }
    }

    let mean = sum / f64::from(count);
    assert!(mean < 1.0 / 128.0 && worst < 0.06, "{mean} {worst}");
}

fn aim(pencil: &Pencil, body: &PlacedBody) -> Aim {
    let SeenForm::Shape(shape) = body.sight else { panic!("a shape") };
    pencil.aim(body, shape)
}

#[test]
fn counts_are_those_of_single_rays() {
    let pose = Pose {
        eye: DVec3::new(500_000.0, 4_000_000.0, 60.0),
        attitude: Attitude { yaw: 10.0, pitch: -5.0, roll: 25.0 },
        hfov: 50.0,
    };
    let camera = Camera::new(pose, 200, 160);
    let lens = Lens::new(&camera);

    let shapes = [
        Shape::Ellipsoid { radii: DVec3::new(9.0, 3.0, 5.0) },
        Shape::Box { size: DVec3::new(8.0, 3.0, 12.0) },
        Shape::Cylinder { radius: 4.0, height: 12.0 },
        Shape::Cone { radius: 5.0, height: 14.0 },
        Shape::disc(8.0),
        Shape::Ellipse { radii: DVec2::new(8.0, 3.0) },
    ];

    for (turn, isa) in (0..40).flat_map(|turn| Isa::available().into_iter().map(move |isa| (turn, isa))) {
        let part = |step: f64| (f64::from(turn) * step).fract();
        let attitude = Attitude { yaw: 360.0 * part(0.3), pitch: 60.0 * part(0.7), roll: 90.0 * part(0.9) };
        let middle = DVec2::new(200.0 * part(0.618), 160.0 * part(0.414));
        let ahead = camera.ray(middle.x, middle.y).unwrap();

        let bodies: Vec<PlacedBody> = (0..2)
            .map(|id| {
                let aside = DVec3::new(4.0 * part(0.11), 3.0 * part(0.23), 5.0 * part(0.37) - 4.0);
                let distance = [120.0, 3000.0, 12.0][turn as usize % 3] + 5.0 * f64::from(id);
                let position = ahead.origin + ahead.direction * distance + aside;
                let shape = shapes[(turn as usize + id as usize) % shapes.len()];
                let body =
                    Body { id, form: shape.into(), position, attitude, albedo: Vec3::ONE, priority: 0 };
                PlacedBody::parts(&body, pose.eye, camera.footprint(), Curvature::FLAT).remove(0)
            })
            .collect();

        let pencil = Pencil::new(&lens, middle).unwrap();
        let aims: Vec<_> = bodies.iter().map(|body| aim(&pencil, body)).collect();
        let mut faces = Vec::new();
        let ground = PixelGround::default();
        isa.run(Count { aims: &aims, pencil: &pencil, ground: &ground, faces: &mut faces });

        let hits: Vec<_> = (0..RAYS)
            .filter_map(|ray| {
                let [x, y] = ALL[ray / LANES].map(|offsets| f64::from(offsets[ray % LANES]));
                nearest(bodies.iter(), &lens.line(middle + DVec2::new(x, y))?, camera.footprint())
            })
            .collect();

        for body in &bodies {
            let own: Vec<_> = hits.iter().filter(|hit| hit.id == body.id).collect();
            let seen: Vec<_> = faces.iter().filter(|face| bodies[face.aim].id == body.id).collect();
            let rays: u32 = seen.iter().map(|face| face.rays).sum();
            assert!(rays.abs_diff(own.len() as u32) <= 1, "{isa}, {turn}: {rays} rays, not {}", own.len());
            let sum: Vec3 = own.iter().map(|hit| hit.normal).sum();
            let normals: Vec3 = seen.iter().map(|face| face.normal * face.rays as f32).sum();
            assert!(
                (sum - normals).length() < 1.5 + 1e-3 * rays as f32,
                "{isa}, {turn}: {normals} not {sum}"
            );
            let range: f64 = own.iter().map(|hit| hit.range).sum();
            let ranges: f64 = seen.iter().map(|face| f64::from(face.range) * f64::from(face.rays)).sum();
            let each = range / own.len().max(1) as f64;
            assert!(
                (range - ranges).abs() <= 1.1 * each + 1e-4 * range,
                "{isa}, {turn}: {ranges} not {range}"
            );
        }
    }
}
