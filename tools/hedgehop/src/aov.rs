//! Further channels of EXR frames: mattes of objects, motion vectors, materials.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use crate::partner::Partner;
use crate::scene::Playing;
use crate::screen::Setup;
use hedgehop::earth::Curvature;
use hedgehop::encode::Target;
use hedgehop::frame::{Frame, MotionStep, motion};
use hedgehop::objects::Body;
use hedgehop::subimage::Farm;
use hedgehop::{Error, Result};

/// Bytes of a pixel that mattes take while they are written, and motion vectors.
const MATTE_BYTES: u64 = 48;
const MOTION_BYTES: u64 = 8;
const MATERIAL_BYTES: u64 = 12;

/// Channels that EXR files hold besides the usual.
#[derive(Debug, Clone, Default, Args)]
pub struct AovArgs {
    /// Further channels of EXR frames, with commas between: cryptomatte (who covers how much of each pixel), motion (pixels until the next frame), material (a colour for each)
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    pub aov: Vec<Aov>,
}

/// Arbitrary output variables, as the field calls them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Aov {
    /// Ids and shares of objects and ground, layers `CryptoObject`
    Cryptomatte,
    /// Motion vectors, `forward.u` and `forward.v`
    Motion,
    /// Material of the ground, a colour for each, `material.R`, `.G`, `.B`
    Material,
}

/// Data that frames need for their further channels.
#[derive(Debug)]
pub struct Further {
    /// Names of objects by their ids, if mattes are asked for.
    pub names: Option<Vec<String>>,
    /// Partners by frame, if motion is asked for.
    pub partners: Option<BTreeMap<u64, Partner>>,
    /// Whether materials are asked for.
    pub material: bool,
    /// Curvature by which far ground appears lower.
    pub curvature: Curvature,
}

impl AovArgs {
    /// Whether it was asked for.
    pub fn has(&self, aov: Aov) -> bool {
        self.aov.contains(&aov)
    }

    /// Refuses outputs that cannot hold it, and screens that cannot tell it.
    pub fn check(&self, target: Target, setup: &Setup) -> Result<()> {
        if !self.aov.is_empty() && target != Target::Exr {
            let what =
                "--aov adds channels to EXR frames; write these with -o frames/####.exr, or leave it out";
            return Err(Error::Configuration(what.into()));
        }
        if self.has(Aov::Motion) && setup.is_table() {
            let what = "--aov motion needs a screen with a formula, and --screen table has none; leave out one of the two";
            return Err(Error::Configuration(what.into()));
        }
        Ok(())
    }

    /// Adds to the settings that decide files; `path` is the flight's, of which motion in a frame needs more than its own pose.
    pub fn record(&self, path: Option<&Path>, settings: &mut Value) {
        let named = [(Aov::Cryptomatte, "cryptomatte"), (Aov::Motion, "motion"), (Aov::Material, "material")];
        let names: Vec<_> =
            named.into_iter().filter(|(aov, _)| self.has(*aov)).map(|(_, name)| name).collect();
        if !names.is_empty() {
            settings["aov"] = json!(names);
        }
        if let Some(path) = path.filter(|_| self.has(Aov::Motion)) {
            // It was read before, and is read again for the manifest, which says if it cannot be any more.
            let digest = fs::read(path).ok().map(|bytes| blake3::hash(&bytes).to_hex().to_string());
            settings["motion_path_blake3"] = json!(digest);
        }
    }

    /// Bytes of a pixel that it takes.
    pub fn pixel_bytes(&self) -> u64 {
        let bytes = |aov, bytes| if self.has(aov) { bytes } else { 0 };
        bytes(Aov::Cryptomatte, MATTE_BYTES)
            + bytes(Aov::Motion, MOTION_BYTES)
            + bytes(Aov::Material, MATERIAL_BYTES)
    }
}

impl Further {
    /// Puts into a frame what rendering leaves out.
    pub fn complete(
        &self,
        frame: &mut Frame,
        number: u64,
        (playing, bodies): (Option<&Playing>, &[Body]),
        farm: &Farm,
    ) -> Result<()> {
        frame.aov.material = self.material;
        if let (Some(names), Some(matte)) = (&self.names, &mut frame.aov.matte) {
            matte.names.clone_from(names);
        }
        let partner = self.partners.as_ref().and_then(|partners| partners.get(&number));
        if let Some(partner) = partner {
            let then = playing.map(|playing| playing.scenery(partner.number).bodies).unwrap_or_default();
            let step = MotionStep {
                camera: &partner.camera,
                bodies: [bodies, &then],
                curvature: self.curvature,
                is_backward: partner.number < number,
            };
            frame.aov.motion = Some(motion(frame, &step, farm)?);
        }
        Ok(())
    }
}
