//! Steps from light to a picture: exposure, curves, rays per pixel, shutter, lens.

use serde_json::{Value, json};

use crate::args;
use crate::bound_flight::FilmMotion;
use crate::scene::Playing;
use crate::screen::Setup;
use crate::titling::FilmTitles;
use hedgehop::frame::Picture;
use hedgehop::render::{Account, Exposure, Moment, NumberedCamera, Rendered, Renderer};
use hedgehop::scene::{Dither, Finish, Scene, Tone};
use hedgehop::space::{Camera, Pose};
use hedgehop::subimage::Farm;
use hedgehop::{Error, Result};

/// Flags of the steps from light to a picture; they go before what the scene says.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Picture")]
pub struct FinishArgs {
    /// Exposure, stops: 1 doubles light [default: 0]
    #[arg(long, value_name = "EV", value_parser = args::number, allow_negative_numbers = true)]
    pub exposure: Option<f64>,

    /// Tone mapping of bright light: none cuts it off at white, filmic rolls it off [default: none]
    #[arg(long, value_name = "CURVE", value_parser = word::<Tone>)]
    pub tone: Option<Tone>,

    /// Codes are the 1/GAMMA-th power of light, 1 to 4 [default: the curve of sRGB]
    #[arg(long, value_name = "GAMMA", value_parser = args::number, allow_negative_numbers = true)]
    pub gamma: Option<f64>,

    /// Rounding of codes: none to the nearest, ordered by a pattern that hides bands [default: none]
    #[arg(long, value_name = "HOW", value_parser = word::<Dither>)]
    pub dither: Option<Dither>,

    /// Share of their light that the corners lose, 0 to 0.95 [default: 0]
    #[arg(long, value_name = "SHARE", value_parser = args::number, allow_negative_numbers = true)]
    pub vignette: Option<f64>,

    /// Radial distortion of a planar screen, radii in focal lengths: -0.2,0 is a barrel [default: 0,0]
    #[arg(long, value_name = "K1,K2", value_parser = args::pair, allow_hyphen_values = true)]
    pub distortion: Option<[f64; 2]>,

    /// Rays per pixel along each side: 1, 2 or 4; takes about 10 or 33 times as long [default: 1]
    #[arg(long, value_name = "N")]
    pub antialias: Option<u32>,

    /// Motion blur: degrees of 360 from frame to frame that the shutter is open; film has 180 [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = args::number, allow_negative_numbers = true)]
    pub shutter: Option<f64>,
}

fn word<T: std::str::FromStr<Err = &'static str>>(text: &str) -> std::result::Result<T, String> {
    text.parse().map_err(str::to_owned)
}

impl FinishArgs {
    /// Returns what the flags say, and the scene where they are silent.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn finish(&self, scene: Option<&Scene>) -> Result<Finish> {
        let said = scene.map(|scene| scene.finish).unwrap_or_default();
        let finish = Finish {
            exposure: self.exposure.unwrap_or(said.exposure),
            tone: self.tone.unwrap_or(said.tone),
            gamma: self.gamma.or(said.gamma),
            dither: self.dither.unwrap_or(said.dither),
            vignette: self.vignette.unwrap_or(said.vignette),
            distortion: self.distortion.unwrap_or(said.distortion),
            antialias: self.antialias.unwrap_or(said.antialias),
            shutter: self.shutter.unwrap_or(said.shutter),
        };
        finish.check().map(|()| finish)
    }
}

/// Records what decides pictures; defaults are not mentioned. Frames in linear light (`is_linear`) know nothing of exposure and codes.
pub fn record(finish: &Finish, is_linear: bool, settings: &mut Value) {
    let plain = Finish::default();
    let mut says = |key: &str, differs: bool, value: Value| {
        if differs {
            settings[key] = value;
        }
    };
    says("distortion_k1_k2", finish.distortion != plain.distortion, json!(finish.distortion));
    says("antialias", finish.antialias != plain.antialias, json!(finish.antialias));
    says("shutter_deg", finish.shutter != plain.shutter, json!(finish.shutter));
    if is_linear {
        return;
    }
    says("exposure_ev", finish.exposure != plain.exposure, json!(finish.exposure));
    says("tone", finish.tone != plain.tone, json!(format!("{:?}", finish.tone).to_lowercase()));
    says("gamma", finish.gamma.is_some(), json!(finish.gamma));
    says("dither", finish.dither != plain.dither, json!(format!("{:?}", finish.dither).to_lowercase()));
    says("vignette", finish.vignette != plain.vignette, json!(finish.vignette));
}

/// Says what a scene says of pictures, if it says anything.
pub fn sentence(finish: &Finish) -> Option<String> {
    let mut said = json!({});
    record(finish, false, &mut said);
    let parts: Vec<_> = said.as_object()?.iter().map(|(key, value)| format!("{key} {value}")).collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// All that finishing a flight's frames needs.
#[derive(Debug)]
pub struct Finishing<'f> {
    /// Steps from light to a picture.
    pub finish: Finish,
    /// The flight.
    pub motion: &'f FilmMotion,
    /// Screen of the pictures.
    pub setup: &'f Setup,
    /// Text and figures over the pictures, if there are any.
    pub titles: Option<FilmTitles<'f>>,
}

impl Finishing<'_> {
    /// Whether light takes another way than it does without finishing.
    fn is_exposed(&self) -> bool {
        self.finish.is_developed() || self.finish.gathers()
    }

    /// Returns the moment about the time of a frame.
    fn moment(&self, number: u64, camera: &Camera, playing: Option<&Playing>, offset: f64) -> Moment {
        let frame = self.motion.timeline.seconds_at(number);
        let seconds = frame + offset;
        let scenery = playing.map(|playing| playing.scenery_in_frame(number, seconds)).unwrap_or_default();
        if offset == 0.0 {
            return Moment { camera: camera.clone(), scenery, seconds };
        }
        let pose = self.motion.rig.pose_in_frame(frame, seconds);
        let camera = if self.setup.is_map() {
            // A map follows its aircraft without turning, above all ground.
            let eye = pose.eye.with_z(camera.pose.eye.z);
            camera.moved_to(Pose { eye, ..camera.pose })
        } else {
            self.setup.camera(pose)
        };
        Moment { camera, scenery, seconds }
    }

    /// A frame in linear light; `None`: it is as it is without finishing.
    pub fn frame(
        &self,
        renderer: &Renderer<'_>,
        number: u64,
        camera: &Camera,
        playing: Option<&Playing>,
        farm: &Farm,
    ) -> Result<Option<Rendered>> {
        if !self.finish.gathers() {
            return Ok(None);
        }
        let moment = |offset: f64| self.moment(number, camera, playing, offset);
        let exposure =
            Exposure { finish: &self.finish, interval: self.motion.timeline.interval(), moment: &moment };
        renderer.exposed(&exposure, farm).map(Some)
    }

    /// A picture without text and figures; `None`: it is as it is without finishing.
    pub fn picture(
        &self,
        renderer: &Renderer<'_>,
        number: u64,
        camera: &Camera,
        playing: Option<&Playing>,
        farm: &Farm,
    ) -> Result<Option<(Picture, Account)>> {
        if !self.is_exposed() {
            return Ok(None);
        }
        let moment = |offset: f64| self.moment(number, camera, playing, offset);
        let exposure =
            Exposure { finish: &self.finish, interval: self.motion.timeline.interval(), moment: &moment };
        renderer.developed(&exposure, farm).map(Some)
    }
}

/// Refuses a lens that folds some picture before its corners.
pub fn check_lens(cameras: &[NumberedCamera], finish: &Finish) -> Result<()> {
    let [k1, k2] = finish.distortion;
    let folds = |camera: &Camera| camera.ray(0.0, 0.0).is_none();
    match cameras.iter().find(|frame| (k1, k2) != (0.0, 0.0) && folds(&frame.camera)) {
        Some(NumberedCamera { number, camera, .. }) => Err(Error::Configuration(format!(
            "--distortion {k1},{k2} folds the picture of frame {number} before its corners, which {}° across reach; take coefficients \
             nearer to 0, or a narrower --hfov",
            camera.pose.hfov
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_go_before_the_default_and_are_checked() {
        let args = FinishArgs { exposure: Some(1.5), antialias: Some(2), ..FinishArgs::default() };
        let finish = args.finish(None).unwrap();
        assert_eq!(finish, Finish { exposure: 1.5, antialias: 2, ..Finish::default() });
        let wrong = FinishArgs { antialias: Some(3), ..FinishArgs::default() };
        assert!(wrong.finish(None).unwrap_err().to_string().contains("--antialias"));
    }

    #[test]
    fn frames_in_linear_light_are_told_apart_from_pictures() {
        let finish = Finish { exposure: 1.0, antialias: 2, ..Finish::default() };
        let (mut picture, mut linear, mut plain) = (json!({}), json!({}), json!({}));
        record(&finish, false, &mut picture);
        record(&finish, true, &mut linear);
        record(&Finish::default(), false, &mut plain);
        assert_eq!(linear, json!({ "antialias": 2 }));
        assert_eq!(picture["exposure_ev"], json!(1.0));
        assert_eq!(plain, json!({}));
        assert_eq!(sentence(&finish).as_deref(), Some("antialias 2, exposure_ev 1.0"));
        assert_eq!(sentence(&Finish::default()), None);
    }
}
