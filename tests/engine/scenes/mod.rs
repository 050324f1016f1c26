//! Scene files, and what they cast.

mod night;
mod parts;
mod picture;
mod trails;
mod whole;

use std::fs;

use glam::DVec2;

use hedgehop::Result;
use hedgehop::scene::Scene;

/// A track of 20 s to the east at 10 m/s, on the ground.
const CAR: (&str, &[u8]) = ("car.csv", b"time,x,y,alt_agl_m\n0,10,20,0\n10,110,20,0\n20,210,20,0\n");

/// Reads a scene from text, with files of these names and contents beside it.
fn read_beside(text: &str, files: &[(&str, &[u8])]) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }

    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    Scene::read(&path)
}

/// Ground that rises by a tenth to the east, metres.
fn slope(place: DVec2) -> Option<f64> {
    Some(100.0 + 0.1 * place.x)
}
