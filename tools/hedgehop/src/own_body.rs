//! A body for what flies, in films that look at it, where the scene has none.

use std::sync::Arc;

use glam::Vec3;

use crate::trails;
use crate::view::FlightArgs;
use hedgehop::colour::linear_from_srgb8;
use hedgehop::flight::{Chase, Mount, Orbit, Shot, Track, camera_shots};
use hedgehop::objects::{Form, Material, Mesh, MeshPart, Model};
use hedgehop::progress::Observer;
use hedgehop::scene::{Beyond, Object, Scene};
use hedgehop::{Error, Result};

/// Length of the body in distances of the eye: some 10° of a view along the ground, and less of one from above, which shows all of it.
const LENGTH: f64 = 0.17;
const LENGTH_FROM_ABOVE: f64 = 0.06;
/// Greatest length, metres, and distance of the eye up to which it is within what flies.
const MOST_LENGTH: f64 = 2000.0;
const WITHIN: f64 = 1.0;

/// Colour of the body, sRGB.
const COLOUR: [u8; 3] = [255, 80, 32];

/// Adds a body to a scene, which is made if there is none, if cameras follow the flight and the scene has no object on its path.
///
/// # Errors
/// A path that cannot be read; a camera that looks at an object that is not there.
pub fn add_to(scene: Option<Scene>, flight: &FlightArgs, observer: &dyn Observer) -> Result<Option<Scene>> {
    let Some(own) = flight.own_flight() else { return Ok(scene) };
    let has_body = |scene: &Scene| scene.objects.iter().any(|object| own.has_body(object));
    if scene.as_ref().is_some_and(has_body) {
        return Ok(scene);
    }

    let track = flight.track()?;
    let shots =
        flight.camera.shots(&camera_shots(&track), scene.as_ref(), flight.alt_mode.map(Into::into))?;
    let Some(length) = shots.iter().filter_map(length).min_by(f64::total_cmp) else { return Ok(scene) };

    let mut scene = scene.unwrap_or_default();
    observer.note(&format!(
        "an aeroplane of {length:.1} m stands for what flies; a scene gives it another body: an [[object]] with the path file as its track"
    ));
    let name = trails::free_name(&scene, &track.path);
    // Notes of the path file are told where the flight is bound.
    scene.objects.push(aeroplane(name, length, Track { notes: Vec::new(), ..track })?);
    let mut hasher = blake3::Hasher::new();
    hasher.update(scene.digest.as_bytes()).update(&length.to_le_bytes());
    scene.digest = hasher.finalize().to_hex().to_string();
    Ok(Some(scene))
}

/// Length of a body that is seen well, metres; `None`: the shot does not follow what flies.
fn length(shot: &Shot) -> Option<f64> {
    let (along, up) = match shot.mount {
        Mount::Chase(Chase { back, up, side }) => (back.hypot(side), up),
        Mount::Orbit(Orbit { radius, up, .. }) if shot.look.is_none() => (radius, up),
        _ => return None,
    };
    let share = if up.abs() > along { LENGTH_FROM_ABOVE } else { LENGTH };
    let distance = along.hypot(up);
    (distance > WITHIN).then_some((share * distance).min(MOST_LENGTH))
}

/// An aeroplane on a track.
fn aeroplane(name: String, length: f64, track: Track) -> Result<Object> {
    let mesh = Mesh::new(vec![airframe(length as f32)])
        .map_err(|what| Error::Configuration(format!("a body of {length} m: {what}")))?;
    Ok(Object {
        name,
        line: 0,
        form: Form::Model(Arc::new(Model::new(Arc::new(mesh), []))),
        files: Vec::new(),
        notes: Vec::new(),
        albedo: linear_from_srgb8(COLOUR),
        priority: 0,
        track,
        to: None,
        start: 0.0,
        beyond: Beyond::Hold,
        banks: true,
        leans: false,
        from_aboard: false,
        parts: Vec::new(),
    })
}

/// Fuselage, wings and tail; x right, y forward, z up.
fn airframe(length: f32) -> MeshPart {
    // In lengths. Plates have four corners each, and those of the left side are mirrored.
    const WING: [[f32; 3]; 4] = [[0.0, 0.22, 0.02], [0.6, 0.12, 0.1], [0.6, -0.06, 0.1], [0.0, -0.12, 0.02]];
    const TAILPLANE: [[f32; 3]; 4] =
        [[0.0, -0.36, 0.02], [0.24, -0.42, 0.03], [0.24, -0.5, 0.03], [0.0, -0.5, 0.02]];
    const FIN: [[f32; 3]; 4] = [[0.0, -0.34, 0.02], [0.0, -0.46, 0.2], [0.0, -0.53, 0.2], [0.0, -0.5, 0.02]];
    /// Stations of the fuselage, along it, and half its width there.
    const FUSELAGE: [[f32; 2]; 4] = [[0.5, 0.02], [0.34, 0.075], [-0.1, 0.075], [-0.5, 0.025]];

    let mirrored = |plate: [[f32; 3]; 4]| plate.map(|[x, y, z]| [-x, y, z]);
    let plates = [WING, mirrored(WING), TAILPLANE, mirrored(TAILPLANE), FIN];
    let ring = |[along, half]: [f32; 2]| {
        [[half, along, half], [half, along, -half], [-half, along, -half], [-half, along, half]]
    };
    let sides = FUSELAGE.windows(2).flat_map(|pair| {
        let [front, back] = [ring(pair[0]), ring(pair[1])];
        (0..4).map(move |side| [front[side], front[(side + 1) % 4], back[(side + 1) % 4], back[side]])
    });

    let quads: Vec<[[f32; 3]; 4]> = plates.into_iter().chain(sides).collect();
    let corner = |index: usize| index as u32;
    MeshPart {
        positions: quads.iter().flatten().map(|place| length * Vec3::from_array(*place)).collect(),
        normals: Vec::new(),
        places: Vec::new(),
        colours: Vec::new(),
        triangles: (0..quads.len())
            .flat_map(|quad| {
                [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|index| corner(4 * quad + index)))
            })
            .collect(),
        material: Material::of(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_cameras_outside_need_a_body() {
        let shot = |mount| Shot { mount, ..Shot::default() };
        let chase = |back, up| Mount::Chase(Chase { back, up, side: 0.0 });
        assert_eq!(length(&shot(Mount::Aboard)), None);
        assert_eq!(length(&shot(chase(40.0, 30.0))), Some(50.0 * LENGTH));
        assert_eq!(length(&shot(chase(0.0, 1000.0))), Some(1000.0 * LENGTH_FROM_ABOVE));
        assert_eq!(length(&shot(chase(0.0, 0.5))), None);
        let orbit = Mount::Orbit(Orbit { radius: 400.0, up: 300.0, period: 60.0 });
        assert_eq!(length(&shot(orbit.clone())), Some(500.0 * LENGTH));
        let around_a_place = Shot { look: Some(hedgehop::flight::Look::Down), ..shot(orbit) };
        assert_eq!(length(&around_a_place), None);
    }

    #[test]
    fn the_airframe_is_as_long_as_it_is_told_and_symmetric() {
        let corners = Mesh::new(vec![airframe(10.0)]).unwrap().corners();
        assert!((corners[1].y - corners[0].y - 10.3).abs() < 1e-4, "{corners:?}");
        assert!((corners[1].x + corners[0].x).abs() < 1e-5 && corners[1].z > -corners[0].z, "{corners:?}");
    }
}
