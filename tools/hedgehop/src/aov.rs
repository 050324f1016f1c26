//! Further channels of EXR frames: mattes of objects, motion vectors, positions, materials, what is made up.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use clap::{Args, ValueEnum};
use glam::DVec3;
use serde_json::{Value, json};

use crate::partner::Partner;
use crate::scene::Playing;
use crate::screen::Setup;
use hedgehop::earth::Curvature;
use hedgehop::encode::Target;
use hedgehop::frame::{Frame, MotionStep, PositionInputs, map_positions, motion};
use hedgehop::objects::Body;
use hedgehop::subimage::Farm;
use hedgehop::{Error, Result};

/// Bytes of memory that mattes take per pixel while they are written.
const MATTE_BYTES: u64 = 48;
/// Bytes of memory that motion vectors take per pixel.
const MOTION_BYTES: u64 = 8;
/// Bytes of memory that positions take per pixel.
const POSITION_BYTES: u64 = 12;
/// Bytes of memory that colours of materials take per pixel.
const MATERIAL_BYTES: u64 = 12;

/// Bytes of memory that changes by detail take per pixel.
const SYNTHESIS_BYTES: u64 = 8;

/// Flags of the channels that EXR frames have besides the usual ones.
#[derive(Debug, Clone, Default, Args)]
pub struct AovArgs {
    /// Further channels of EXR frames, with commas between: cryptomatte (who covers how much of each pixel), motion (pixels until the next frame), position (metres on the map), material (a colour for each), synthesis (how much of the light is made up)
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    pub aov: Vec<AovKind>,
}

/// Kinds of further channels: arbitrary output variables, as the field calls them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AovKind {
    /// Ids and shares of objects and ground, layers `CryptoObject`
    Cryptomatte,
    /// Motion vectors, `forward.u` and `forward.v`
    Motion,
    /// Position on the map, `P.X`, `P.Y`, `P.Z`
    Position,
    /// Material of the ground, a colour for each, `material.R`, `.G`, `.B`
    Material,
    /// Change of light by detail below the voxel, `synthesis`
    Synthesis,
}

/// Properties of a kind of further channels.
struct AovFacts {
    /// Name of the kind in manifests.
    name: &'static str,
    /// Bytes of memory that the channels take per pixel.
    pixel_bytes: u64,
}

impl AovKind {
    /// Returns the properties of a kind.
    fn facts(self) -> AovFacts {
        match self {
            Self::Cryptomatte => AovFacts { name: "cryptomatte", pixel_bytes: MATTE_BYTES },
            Self::Motion => AovFacts { name: "motion", pixel_bytes: MOTION_BYTES },
            Self::Position => AovFacts { name: "position", pixel_bytes: POSITION_BYTES },
            Self::Material => AovFacts { name: "material", pixel_bytes: MATERIAL_BYTES },
            Self::Synthesis => AovFacts { name: "synthesis", pixel_bytes: SYNTHESIS_BYTES },
        }
    }
}

/// Data that frames need for their further channels.
#[derive(Debug)]
pub struct AovInputs {
    /// Names of objects by their ids, if mattes are asked for.
    pub names: Option<Vec<String>>,
    /// Partners by frame, if motion is asked for.
    pub partners: Option<BTreeMap<u64, Partner>>,
    /// Point that positions count from, if they are asked for.
    pub position_offset: Option<DVec3>,
    /// Rays of each pixel along a side.
    pub antialias: u32,
    /// Whether materials are asked for.
    pub material: bool,
    /// Curvature by which far ground appears lower.
    pub curvature: Curvature,
}

impl AovArgs {
    /// Whether channels of a kind were asked for.
    pub fn has(&self, kind: AovKind) -> bool {
        self.aov.contains(&kind)
    }

    /// Returns the kinds that were asked for, each once, in the order of their declaration.
    fn kinds(&self) -> impl Iterator<Item = AovKind> {
        AovKind::value_variants().iter().copied().filter(|kind| self.has(*kind))
    }

    /// Refuses outputs that cannot hold further channels, and screens on which motion cannot be told.
    pub fn check(&self, target: Option<Target>, setup: &Setup) -> Result<()> {
        if !self.aov.is_empty() && target != Some(Target::Exr) {
            let what =
                "--aov adds channels to EXR frames; write these with -o frames/####.exr, or leave it out";
            return Err(Error::Configuration(what.into()));
        }
        if self.has(AovKind::Motion) && setup.is_table() {
            let what = "--aov motion needs a screen with a formula, and --screen table has none; leave out one of the two";
            return Err(Error::Configuration(what.into()));
        }
        Ok(())
    }

    /// Adds the kinds to the settings that decide files; `path` is the flight's, of which motion in a frame needs more than its own pose, `offset` what
    /// positions count from.
    pub fn record(&self, path: Option<&Path>, offset: DVec3, settings: &mut Value) {
        let names: Vec<_> = self.kinds().map(|kind| kind.facts().name).collect();
        if !names.is_empty() {
            settings["aov"] = json!(names);
        }
        if self.has(AovKind::Position) {
            settings["position_offset_m"] = json!(offset.to_array());
        }
        if let Some(path) = path.filter(|_| self.has(AovKind::Motion)) {
            // It was read before, and is read again for the manifest, which says if it cannot be any more.
            let digest = fs::read(path).ok().map(|bytes| blake3::hash(&bytes).to_hex().to_string());
            settings["motion_path_blake3"] = json!(digest);
        }
    }

    /// Returns the bytes of memory that all channels asked for take per pixel.
    pub fn pixel_bytes(&self) -> u64 {
        self.kinds().map(|kind| kind.facts().pixel_bytes).sum()
    }
}

impl AovInputs {
    /// Adds to a frame the parts of its further channels that rendering leaves out: names in the matte, motion vectors, positions, and that materials
    /// are written. `bodies` are the objects in the frame itself, as they were rendered.
    pub fn complete(
        &self,
        frame: &mut Frame,
        number: u64,
        playing: Option<&Playing>,
        bodies: &[Body],
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
        if let Some(offset) = self.position_offset {
            let (curvature, antialias) = (self.curvature, self.antialias);
            let inputs = PositionInputs { offset, curvature, bodies, antialias };
            frame.aov.position = Some(map_positions(frame, &inputs, farm));
        }
        Ok(())
    }
}
