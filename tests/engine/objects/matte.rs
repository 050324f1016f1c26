//! Mattes: shares of several bodies in a pixel, held to the light that they let through.

use super::*;
use hedgehop::frame::{Matte, MatteCoverage};
use hedgehop::objects::Shape;
use hedgehop::render::Engine;
use hedgehop::voxel::PageSource;

const VIEW: View =
    View { eye: glam::DVec3::new(500.0, 300.0, 20.0), ypr: [0.0, -3.0, 4.0], hfov: 40.0, size: [160, 90] };

/// Bodies that overlap, stand in the ground, and are smaller than a pixel.
fn crowd() -> Vec<Body> {
    let ball = |radius: f64| Shape::Ellipsoid { radii: glam::DVec3::splat(radius) };
    let bodies = [
        black(Shape::Box { size: glam::DVec3::new(6.0, 6.0, 12.0) }, [495.0, 380.0, 0.0]),
        black(ball(5.0), [500.0, 390.0, 14.0]),
        black(Shape::Cone { radius: 8.0, height: 30.0 }, [510.0, 420.0, -2.0]),
        black(ball(0.16), [488.0, 380.0, 25.0]),
        black(Shape::disc(4.0), [505.0, 360.0, 13.0]),
    ];
    (10..).zip(bodies).map(|(id, body)| Body { id, ..body }).collect()
}

fn matte(engine: Engine, bodies: &[Body], workers: usize) -> (Matte, Frame) {
    let options = RenderOptions { matte: true, ..options(engine) };
    let farm = Farm::new(workers).unwrap();
    let mut frame = Renderer::new(&*PLAIN, &options).frame_with(&VIEW.camera(), bodies, &farm).unwrap().frame;
    (frame.aov.matte.take().unwrap(), frame)
}

#[test]
fn shares_add_up_to_what_bodies_hide() {
    for engine in [Engine::Planes, Engine::Reference] {
        let bodies = crowd();
        let (matte, seen) = matte(engine, &bodies, 2);
        let hidden = shares(engine, &PLAIN, &VIEW, &bodies);
        let bare = frame(engine, &PLAIN, &VIEW.camera(), &[]);
        let (mut sums, mut grounds) = (vec![0.0; hidden.len()], vec![0.0; hidden.len()]);

        for cover in &matte.covers {
            let sum = if cover.id == MatteCoverage::GROUND { &mut grounds } else { &mut sums };
            assert!(cover.share > 0.0 && cover.share <= 1.0);
            sum[cover.pixel as usize] += f64::from(cover.share);
        }

        for (pixel, (sum, hidden)) in sums.iter().zip(&hidden).enumerate() {
            assert!((sum - hidden).abs() < 2e-3, "{engine:?}, pixel {pixel}: {sum} of {hidden}");
            // What hides half or more is what the other channels tell of.
            assert_eq!(*sum >= 0.5, seen.level[pixel] == Frame::BODY_LEVEL, "{engine:?}, pixel {pixel}");
            // Rows of the sky lie above; the skyline has its own test.
            let is_ground = |pixel: usize| bare.range.get(pixel).is_none_or(|range| range.is_finite());
            if *sum > 0.0 && [0, 1, 160, 161].into_iter().all(|up| is_ground(pixel.saturating_sub(up))) {
                assert!((sum + grounds[pixel] - 1.0).abs() < 1e-4, "{engine:?}, pixel {pixel}");
            }
        }

        let mixed =
            matte.covers.chunk_by(|a, b| a.pixel == b.pixel).filter(|covers| covers.len() > 2).count();
        assert!(mixed > 4, "{engine:?}: {mixed} pixels with two bodies and ground");
        for covers in matte.covers.chunk_by(|a, b| a.pixel == b.pixel) {
            assert!(covers.is_sorted_by(|a, b| a.share >= b.share), "{covers:?}");
        }

        assert!(matte.covers.is_sorted_by_key(|cover| cover.pixel));
        // The smallest is there, and less than a pixel.
        let small = matte.covers.iter().filter(|cover| cover.id == 13).map(|cover| cover.share);
        let area: f32 = small.sum();
        let metres_per_pixel = 80.0 / VIEW.camera().focal_px();
        let exact = std::f64::consts::PI * 0.16 * 0.16 / metres_per_pixel.powi(2);
        assert!((f64::from(area) / exact - 1.0).abs() < 0.1, "{engine:?}: {area} of {exact}");
    }
}

#[test]
fn neither_order_nor_workers_change_a_bit() {
    let bodies = crowd();
    let (first, _) = matte(Engine::Planes, &bodies, 1);
    let backwards: Vec<Body> = bodies.iter().rev().cloned().collect();
    assert_eq!(first, matte(Engine::Planes, &backwards, 3).0);
}

#[test]
fn other_channels_do_not_change_and_without_bodies_there_is_ground() {
    let bodies = crowd();
    let (_, with) = matte(Engine::Planes, &bodies, 2);
    let without = frame(Engine::Planes, &PLAIN, &VIEW.camera(), &bodies);
    assert!(without.aov.matte.is_none());
    assert!(with.colour == without.colour && with.id == without.id && with.range == without.range);
    let (ground, _) = matte(Engine::Planes, &[], 2);
    assert!(ground.covers.iter().all(|cover| cover.id == MatteCoverage::GROUND), "no bodies");
}

/// Black hills before the sky: what is missing of its light is ground.
#[test]
fn the_skyline_is_as_smooth_as_its_light() {
    let height = |post: DVec2| 60.0 + 40.0 * (post.x / 60.0).sin() * (post.y / 90.0).cos();
    let world = Terrain::new([500, 500], 2.0, height, |_| [0; 3]).in_memory();
    let options = RenderOptions { matte: true, ..options(Engine::Planes) };
    for roll in [0.0, 25.0] {
        let camera =
            View { ypr: [10.0, 4.0, roll], eye: glam::DVec3::new(500.0, 200.0, 90.0), ..VIEW }.camera();
        let frame = Renderer::new(&world, &options).frame(&camera, &FARM).unwrap().frame;
        let air = options.atmosphere(world.header());
        let covers = frame.aov.matte.unwrap().covers;
        let (mut wrong, mut wrong_by_pixels, mut partial) = (0.0, 0.0, 0);

        for cover in &covers {
            let (column, row) = (cover.pixel % camera.width, cover.pixel / camera.width);
            let ray = camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5).unwrap();
            let sky = air.sky(ray.origin.z, ray.direction.as_vec3()).y;
            let light = 1.0 - frame.colour[cover.pixel as usize][1] / sky;
            let whole = if frame.range[cover.pixel as usize].is_finite() { 1.0 } else { 0.0 };
            wrong += (cover.share - light).abs();
            wrong_by_pixels += (whole - light).abs();
            partial += u32::from(cover.share > 0.1 && cover.share < 0.9);
        }

        let count = covers.len() as f32;
        assert!(count > 150.0 && partial > 50, "{count} pixels of the skyline, {partial} in part");
        let [wrong, wrong_by_pixels] = [wrong, wrong_by_pixels].map(|sum: f32| sum / count);
        assert!(wrong < 0.08 && wrong < 0.4 * wrong_by_pixels, "roll {roll}: {wrong} {wrong_by_pixels}");
    }
}
