//! Scenes on the command line: what a flight meets besides the ground.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use crossbeam::channel::{RecvTimeoutError, bounded};
use glam::DVec2;
use serde_json::{Value, json};

use crate::view::{FlightArgs, over_ground};
use hedgehop::flight::{Rig, Subject, Timeline};
use hedgehop::geo::Crs;
use hedgehop::progress::Observer;
use hedgehop::scene::{Cast, CastSubject, Scene, Scenery};
use hedgehop::voxel::PageSource;
use hedgehop::weather::{Clouds, Fog, Weather};
use hedgehop::{Error, Result};

/// Time between questions whether to go on.
const PATIENCE: Duration = Duration::from_millis(50);
/// Stack of the thread that reads, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// Flags of the scene: objects, weather and light besides the ground.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Look")]
pub struct SceneArgs {
    /// Scene file: objects and their tracks, sun, visibility (docs/scene.md); --sun and --visibility go before what it says
    #[arg(long, value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
}

/// A scene that goes on while a flight does.
#[derive(Debug)]
pub struct Playing {
    cast: Arc<Cast>,
    timeline: Timeline,
    /// Cameras, of which some are aboard; `None`: none is.
    rig: Option<Arc<Rig>>,
}

impl SceneArgs {
    /// Reads the scene, if one was asked for.
    pub fn read(&self, observer: &dyn Observer) -> Result<Option<Scene>> {
        self.scene.as_deref().map(|path| read(path, observer)).transpose()
    }
}

/// Reads a scene, and stops when the user wants to.
pub fn read(path: &Path, observer: &dyn Observer) -> Result<Scene> {
    let file = path.to_owned();
    answering(path, observer, move || Scene::read(&file))
}

/// Reads something from `path`. Large models take many seconds in libraries that ask nobody whether to go on, so that another thread reads them, which
/// is left to itself when the user wants to stop: reading leaves nothing behind.
fn answering<T: Send + 'static>(
    path: &Path,
    observer: &dyn Observer,
    read: impl FnOnce() -> Result<T> + Send + 'static,
) -> Result<T> {
    let (sender, receiver) = bounded(1);
    let reader = thread::Builder::new().name("scene".into()).stack_size(STACK);
    // Nobody listens any more once the user has stopped it.
    let reader = reader.spawn(move || drop(sender.send(read())));
    let reader = reader.map_err(|error| Error::io(path, "start a thread to read it", error))?;
    loop {
        match receiver.recv_timeout(PATIENCE) {
            Ok(outcome) => return outcome,
            Err(RecvTimeoutError::Timeout) if observer.cancelled() => {
                return Err(Error::Interrupted(format!("{} was not read to its end", path.display())));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match reader.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => return Err(Error::invalid(path, "could not be read")),
            },
        }
    }
}

/// Files that a scene is made of.
pub fn inputs(scene: Option<&Scene>) -> impl Iterator<Item = &Path> {
    scene.into_iter().flat_map(|scene| {
        let tracks = scene.objects.iter().filter(|object| object.track.path.exists());
        let models = scene.objects.iter().flat_map(|object| &object.files).map(PathBuf::as_path);
        let trails = scene.trails.iter().filter_map(|trail| Some(trail.track()?.path.as_path()));
        let fonts = scene.titling.fonts.iter().map(PathBuf::as_path);
        std::iter::once(scene.path.as_path())
            .filter(|path| !path.as_os_str().is_empty())
            .chain(tracks.map(|object| object.track.path.as_path()))
            .chain(models)
            .chain(trails)
            .chain(fonts)
    })
}

/// Whether there is anything in a scene that is merged by range: objects, trails, lights, stars, or clouds.
pub fn has_objects(scene: Option<&Scene>) -> bool {
    scene.is_some_and(|scene| {
        !scene.objects.is_empty()
            || !scene.lights.is_empty()
            || !scene.plumes.is_empty()
            || !scene.trails.is_empty()
            || scene.weather.clouds.is_some()
            || (scene.night.stars && scene.sun.is_some())
    })
}

/// Says what of a scene a map does not show, if there is such: it looks from no height, above which clouds could be.
pub fn left_out_of_map(scene: &Scene) -> Option<String> {
    let weather = &scene.weather;
    let left = [
        ("clouds", weather.clouds.is_some()),
        ("rain or snow", weather.precipitation.is_some()),
        ("lights", !scene.lights.is_empty()),
        ("plumes", !scene.plumes.is_empty()),
    ];
    let left: Vec<_> = left.into_iter().filter_map(|(name, is_there)| is_there.then_some(name)).collect();
    let all = left.join(", ");
    (!left.is_empty()).then(|| format!("orthographic pictures show nothing of the scene's {all}"))
}

/// Records what decides pictures of a scene, besides sun and visibility: the numbers of objects and their parts follow from the order of these names.
pub fn record(scene: Option<&Scene>, settings: &mut Value) {
    if let Some(scene) = scene {
        let names: Vec<_> = scene.names().collect();
        settings["scene"] = json!({ "blake3": scene.digest, "objects": names });
    }
}

/// Records the weather; clear air is not mentioned. What falls and covers the ground is in [`record`]'s digest of the scene alone.
pub fn record_weather(weather: &Weather, settings: &mut Value) {
    let Weather { glow, fog, clouds, precipitation: _, ground: _ } = *weather;
    if glow > 0.0 {
        settings["glow"] = json!(glow);
    }
    if let Some(Fog { top, visibility, soft }) = fog {
        settings["fog"] = json!({ "top_m": top, "visibility_m": visibility, "soft_m": soft });
    }
    if let Some(Clouds { base, top, coverage, visibility, scale, seed, wind }) = clouds {
        settings["clouds"] = json!({
            "base_m": base,
            "top_m": top,
            "coverage": coverage,
            "visibility_m": visibility,
            "scale_m": scale,
            "seed": seed,
            "wind_mps": wind,
        });
    }
}

/// Says of an object by how much it was raised.
pub fn raised(name: &str, metres: f64) -> String {
    format!(
        "object {name} is up to {metres:.1} m higher than its track says, to keep above hills between fixes; slope = true keeps it on the ground"
    )
}

impl Playing {
    /// Puts a scene's objects into the database of a flight.
    pub fn new(
        scene: &Scene,
        source: &dyn PageSource,
        flight: &FlightArgs,
        timeline: Timeline,
        observer: &dyn Observer,
    ) -> Result<Self> {
        for object in scene.objects.iter().filter(|object| !object.track.notes.is_empty()) {
            observer.note(&format!("object {}: {}", object.name, object.track.notes.join(" ")));
        }
        for object in scene.objects.iter().filter(|object| !object.notes.is_empty()) {
            observer.note(&format!("object {}: of its model {}", object.name, object.notes.join("; ")));
        }
        for trail in &scene.trails {
            let notes = trail.track().map(|track| track.notes.join(" ")).unwrap_or_default();
            if !notes.is_empty() {
                observer.note(&format!("trail {}: {notes}", trail.name));
            }
        }
        let own = flight.own_flight();
        let bind = |crs: &Crs, ground: &dyn Fn(DVec2) -> Option<f64>| {
            scene.bind_with_flight(crs, ground, own.as_ref())
        };
        let cast = over_ground(source, flight.world, bind)?;
        // A flight that was raised is told where it is bound, and its body not again.
        let is_own = |name: &str| {
            let mut objects = scene.objects.iter().filter(|object| object.name == name);
            objects.any(|object| own.as_ref().is_some_and(|own| own.has_body(object)))
        };
        let others = cast.raised().filter(|(name, _)| !is_own(name));
        others.for_each(|(name, metres)| observer.note(&raised(name, metres)));
        Ok(Self { cast: Arc::new(cast), timeline, rig: None })
    }

    /// Returns the scenery in a frame.
    pub fn scenery(&self, number: u64) -> Scenery {
        self.scenery_in_frame(number, self.seconds(number))
    }

    /// Returns the scenery so many seconds after the flight's first fix, as the camera of a frame sees it: a shutter does not see
    /// across a cut.
    pub fn scenery_in_frame(&self, number: u64, seconds: f64) -> Scenery {
        if self.rig.as_ref().is_some_and(|rig| rig.is_aboard_at(self.seconds(number))) {
            return self.cast.from_aboard(seconds);
        }
        self.cast.at(seconds)
    }

    /// Returns the scene as cameras along a flight see it.
    pub fn seen_by(self, rig: &Arc<Rig>) -> Self {
        Self { rig: Some(rig.clone()), ..self }
    }

    /// Returns an object, or a part of one, as what a camera looks at; `None`: there is none of that name.
    pub fn subject(&self, name: &str) -> Option<Arc<dyn Subject>> {
        CastSubject::new(&self.cast, name).map(|subject| Arc::new(subject) as Arc<dyn Subject>)
    }

    /// Names of the objects that bodies are or are parts of, by the ids of these.
    pub fn names(&self) -> Vec<String> {
        self.cast.owners().map(str::to_owned).collect()
    }

    /// Returns the time of a frame, seconds after the flight's first fix.
    pub fn seconds(&self, number: u64) -> f64 {
        self.timeline.seconds_at(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Stops;

    impl Observer for Stops {
        fn cancelled(&self) -> bool {
            true
        }
    }

    #[test]
    fn who_wants_to_stop_does_not_wait_for_what_is_read() {
        let (release, held) = bounded::<()>(0);
        let path = Path::new("scene.toml");
        // It would wait for ever.
        let stopped = answering(path, &Stops, move || Ok(held.recv().is_err()));
        assert!(matches!(stopped, Err(Error::Interrupted(what)) if what.contains("scene.toml")));
        drop(release);
        assert_eq!(answering(path, &hedgehop::progress::Silent, || Ok(3)).unwrap(), 3);
    }
}
