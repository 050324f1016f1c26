//! Free flat ellipses: silhouettes against the conic of their image, and flights through and past them.

use glam::{DVec2, DVec3};
use hedgehop_conic::{
    Ball, CellOverlap, Cull, Ellipsoid, FlatEllipse, ImageConic, ImagePoint, Raster, ViewFrame,
};

use super::{PLAIN, black, shares};
use crate::scene::View;
use hedgehop::objects::{Body, Shape};
use hedgehop::render::Engine;
use hedgehop::space::Attitude;

const RADII: DVec2 = DVec2::new(34.0, 13.0);
const PLACE: DVec3 = DVec3::new(530.0, 400.0, 60.0);
const VIEW: View =
    View { eye: DVec3::new(500.0, 200.0, 50.0), ypr: [8.0, 2.0, 0.0], hfov: 40.0, size: [200, 160] };

/// An ellipse so turned, as a body and in closed form.
fn ellipse(radii: DVec2, attitude: Attitude) -> (Body, FlatEllipse) {
    let axes = attitude.world_from_body();
    let body = Body { attitude, ..black(Shape::Ellipse { radii }, PLACE.to_array()) };
    (body, FlatEllipse { centre: PLACE, axes: [axes.x_axis * radii.x, axes.y_axis * radii.y] })
}

/// Axes of a view, which is not banked, and its lines.
fn frame_of(view: &View) -> (ViewFrame, Raster) {
    let [width, height] = view.size.map(f64::from);
    let tangent = (0.5 * view.hfov.to_radians()).tan();
    let raster = Raster {
        lines: height,
        elements: width,
        vertical_fov: 2.0 * (tangent * height / width).atan(),
        horizontal_fov: view.hfov.to_radians(),
    };
    let [yaw, pitch, _] = view.ypr.map(f64::to_radians);
    let boresight = DVec3::new(yaw.sin() * pitch.cos(), yaw.cos() * pitch.cos(), pitch.sin());
    (ViewFrame::looking(view.eye, boresight), raster)
}

/// Image of an ellipse; `None`: part of it is beside or behind the eye.
fn image(view: &View, ellipse: &FlatEllipse) -> Option<ImageConic> {
    let (frame, raster) = frame_of(view);
    let seen = ellipse.seen(&frame);
    (!matches!(seen.cull(), Some(Cull::Behind | Cull::CrossesViewPlane)))
        .then(|| ImageConic::of(&seen, &raster))
}

/// Exact share of each pixel.
fn exact_shares(view: &View, conic: &ImageConic) -> Vec<f64> {
    let overlap = CellOverlap::of(conic);
    let [width, height] = view.size;
    let pixels = (0..height).flat_map(|line| (0..width).map(move |element| (line, element)));
    let place = |(line, element): (u32, u32)| ImagePoint { line: line.into(), element: element.into() };
    pixels.map(|pixel| overlap.map_or(0.0, |overlap| overlap.pixel(place(pixel)))).collect()
}

/// How far outlines lie apart at most, pixels: in each line and each column, to either side of the centre, where the outline crosses it steeply.
fn apart(view: &View, seen: &[f64], exact: &[f64], centre: ImagePoint) -> (f64, u32) {
    let [width, height] = view.size.map(|size| size as usize);
    let (mut most, mut count) = (0.0_f64, 0);
    let mut side = |pixels: &mut dyn Iterator<Item = usize>| {
        let (mut sum, mut partial, mut whole) = (0.0, 0, 0);
        for pixel in pixels {
            sum += seen[pixel] - exact[pixel];
            whole += u32::from(exact[pixel] > 1.0 - 1e-9);
            partial += u32::from(exact[pixel] > 1e-9 && exact[pixel] <= 1.0 - 1e-9);
        }
        if whole > 0 && (1..=2).contains(&partial) {
            (most, count) = (most.max(f64::abs(sum)), count + 1);
        }
    };
    let (line, element) = (centre.line as usize, centre.element as usize);
    for row in 0..height {
        side(&mut (0..element).map(|column| row * width + column));
        side(&mut (element..width).map(|column| row * width + column));
    }
    for column in 0..width {
        side(&mut (0..line).map(|row| row * width + column));
        side(&mut (line..height).map(|row| row * width + column));
    }
    (most, count)
}

#[test]
fn silhouettes_are_the_conics_of_their_images() {
    for (yaw, pitch, roll) in [(0.0, 90.0, 0.0), (0.0, -30.0, 0.0), (30.0, 55.0, 0.0), (-70.0, 20.0, 65.0)] {
        let attitude = Attitude { yaw, pitch, roll };
        let (body, flat) = ellipse(RADII, attitude);
        let conic = image(&VIEW, &flat).unwrap();
        let exact = exact_shares(&VIEW, &conic);
        let (middle, _) = conic.ellipse().unwrap();
        let middle = ImagePoint { line: middle.x, element: middle.y };
        for engine in [Engine::Planes, Engine::Reference] {
            let seen = shares(engine, &PLAIN, &VIEW, std::slice::from_ref(&body));
            let (most, count) = apart(&VIEW, &seen, &exact, middle);
            assert!(count >= 16, "{attitude:?}: {count} crossings");
            assert!(most < 0.05, "{engine:?}, {attitude:?}: {most} px");
        }
    }
}

#[test]
fn spheres_are_the_conics_of_their_discs() {
    for radius in [4.0, 17.0, 45.0] {
        let (frame, raster) = frame_of(&VIEW);
        let disc = Ball { centre: PLACE, radius }.seen(&frame).disc().unwrap();
        let conic = ImageConic::of(&disc, &raster);
        let (middle, _) = conic.ellipse().unwrap();
        let middle = ImagePoint { line: middle.x, element: middle.y };
        let body = black(Shape::Ellipsoid { radii: DVec3::splat(radius) }, PLACE.to_array());
        let seen = shares(Engine::Planes, &PLAIN, &VIEW, &[body]);
        let (most, count) = apart(&VIEW, &seen, &exact_shares(&VIEW, &conic), middle);
        assert!(count >= 12 && most < 0.01, "radius {radius}: {most} px at {count} crossings");
    }
}

#[test]
fn ellipsoids_are_the_conics_of_their_outlines() {
    let radii = DVec3::new(34.0, 13.0, 6.0);
    for (yaw, pitch, roll) in [(0.0, 0.0, 0.0), (30.0, 55.0, 0.0), (-70.0, 20.0, 65.0)] {
        let attitude = Attitude { yaw, pitch, roll };
        let axes = attitude.world_from_body();
        let axes = [axes.x_axis * radii.x, axes.y_axis * radii.y, axes.z_axis * radii.z];
        let (frame, raster) = frame_of(&VIEW);
        let conic =
            ImageConic::of(&Ellipsoid { centre: PLACE, axes }.seen(&frame).outline().unwrap(), &raster);
        let (middle, _) = conic.ellipse().unwrap();
        let middle = ImagePoint { line: middle.x, element: middle.y };
        let body = Body { attitude, ..black(Shape::Ellipsoid { radii }, PLACE.to_array()) };
        for engine in [Engine::Planes, Engine::Reference] {
            let seen = shares(engine, &PLAIN, &VIEW, std::slice::from_ref(&body));
            let (most, count) = apart(&VIEW, &seen, &exact_shares(&VIEW, &conic), middle);
            assert!(count >= 16 && most < 0.1, "{engine:?}, {attitude:?}: {most} px at {count} crossings");
        }
    }
}

/// Whether a ray passes through it.
fn meets(ellipse: &FlatEllipse, eye: DVec3, direction: DVec3) -> bool {
    let [first, second] = ellipse.axes;
    let normal = first.cross(second);
    let at = normal.dot(ellipse.centre - eye) / normal.dot(direction);
    let offset = eye + direction * at - ellipse.centre;
    let part = |axis: DVec3| offset.dot(axis) / axis.length_squared();
    at > 0.0 && part(first).powi(2) + part(second).powi(2) < 1.0
}

/// The eye flies through the ellipse, which reaches behind it for half of the way: what is behind leaves no image, and nothing comes or goes at once.
#[test]
fn flights_through_show_what_rays_meet_and_nothing_of_what_is_behind() {
    const SIDE: u32 = 12;
    let (body, flat) = ellipse(RADII, Attitude { yaw: 25.0, pitch: 50.0, roll: 10.0 });
    let mut behind = 0;
    for step in -12..=12 {
        let eye = PLACE + DVec3::new(0.3, 1.1 * f64::from(step) + 0.05, 1.0);
        let view = View { eye, ypr: [0.0, 0.0, 0.0], hfov: 70.0, size: [72, 54] };
        behind += u32::from(image(&view, &flat).is_none());
        let focal = 36.0 / 35.0_f64.to_radians().tan();
        let seen = shares(Engine::Planes, &PLAIN, &view, std::slice::from_ref(&body));
        let (mut sum, mut edges) = (0.0, 0);

        for (pixel, seen) in (0..).zip(seen) {
            let hits = (0..SIDE * SIDE).filter(|ray| {
                let at = |first: u32, part: u32| f64::from(first) + (f64::from(part) + 0.5) / f64::from(SIDE);
                let (right, down) = (at(pixel % 72, ray % SIDE), at(pixel / 72, ray / SIDE));
                meets(&flat, eye, DVec3::new(right - 36.0, focal, 27.0 - down))
            });
            let exact = hits.count() as f64 / f64::from(SIDE * SIDE);
            let error = (seen - exact).abs();
            assert!(error < 0.12, "step {step}, pixel {pixel}: {seen}, not {exact}");
            if exact > 0.0 && exact < 1.0 {
                (sum, edges) = (sum + error, edges + 1);
            }
        }

        assert!(edges == 0 || sum / f64::from(edges) < 0.02, "step {step}: {sum} in {edges} pixels");
    }
    assert!(behind >= 8, "{behind}");
}

/// From one side over the edge to the other: no ellipse is ever dropped for being thin.
#[test]
fn ellipses_seen_end_on_fade_without_a_step() {
    let mut most = 0.0_f64;
    for step in -20..=20 {
        let view = View { ypr: [8.0, 2.8, 0.0], hfov: 8.0, ..VIEW };
        // Its plane passes through the eye at step 0.
        let tilt = (PLACE.z - view.eye.z).atan2((PLACE - view.eye).truncate().length()).to_degrees();
        let yaw = (PLACE.x - view.eye.x).atan2(PLACE.y - view.eye.y).to_degrees();
        let attitude = Attitude { yaw, pitch: tilt + 0.02 * f64::from(step) + 1e-4, roll: 0.0 };
        let (body, flat) = ellipse(DVec2::new(9.0, 20.0), attitude);
        let exact = exact_shares(&view, &image(&view, &flat).unwrap());
        let seen = shares(Engine::Planes, &PLAIN, &view, &[body]);
        most = seen.iter().zip(&exact).fold(most, |most, (seen, exact)| most.max((seen - exact).abs()));
    }
    assert!(most < 2.0 / 255.0, "{most}");
}
