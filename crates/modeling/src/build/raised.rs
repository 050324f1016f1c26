//! Fourth phase: features and objects stand on the ground.

use std::sync::Arc;

use super::job::{BuildJob, BuildRecord};
use super::planned::PlannedBuild;
use super::surveyed::SurveyedBuild;
use crate::feature_solids::{self, FeatureSolids};
use crate::inputs::{FeatureInput, Inputs};
use crate::object::{Objects, OpenObject, OpenScatter};
use crate::page::{PageMaker, Project};
use crate::placing::Collection;
use crate::warnings;
use hedgehop::voxel::{HeightCode, SharedObjects};
use hedgehop_base::error::Result;

/// Inputs that stand on the ground, before they are bound to it.
pub(super) struct StandingInputs {
    features: Vec<FeatureInput>,
    objects: Vec<OpenObject>,
    scatters: Vec<OpenScatter>,
}

impl StandingInputs {
    /// Takes them out of all inputs.
    pub fn take_from(inputs: &mut Inputs) -> Self {
        Self {
            features: std::mem::take(&mut inputs.features),
            objects: std::mem::take(&mut inputs.objects),
            scatters: std::mem::take(&mut inputs.scatters),
        }
    }
}

/// Build of which every height is known: the ground, and what stands on it.
pub(super) struct RaisedBuild {
    pub feature_solids: Option<FeatureSolids>,
    pub objects: Option<Objects>,
    /// Objects that stand in many places.
    pub shared: Arc<SharedObjects>,
    /// Code of all heights.
    pub code: HeightCode,
}

impl RaisedBuild {
    /// Binds features and objects to the natural ground.
    ///
    /// # Errors
    /// The ground below cannot be read, or a model cannot be placed.
    pub fn new(
        standing: StandingInputs,
        planned: &PlannedBuild,
        surveyed: &SurveyedBuild,
        job: &BuildJob<'_>,
        record: &mut BuildRecord<'_>,
    ) -> Result<Self> {
        let StandingInputs { features, objects, scatters } = standing;
        let BuildJob { options, budget, observer } = *job;
        let (plan, high) = (&planned.plan, surveyed.heights.high);
        let nothing = SharedObjects::default();
        let natural = surveyed.natural(planned, job, &nothing);

        let mut feature_solids = None;
        if !features.is_empty() {
            let (features, notes) = feature_solids::place(&features, plan)?;
            record.notes(notes);
            let cache = planned.traced().map(|(cache, keys)| (cache, keys.ground()));
            let ground = || PageMaker::new(&natural);
            let bound = FeatureSolids::new(features, ground, high, cache, budget.threads, observer)?;
            feature_solids = Some(bound);
        }

        let mut placed_objects = None;
        if !(objects.is_empty() && scatters.is_empty()) {
            let mut ground = PageMaker::new(&natural);
            let (placed, notes) =
                Objects::new(objects, scatters, plan, &mut ground, natural.materials, high)?;
            record.notes(notes);
            placed_objects = Some(placed);
        }

        // One code for the heights of all.
        let tops = placed_objects
            .as_ref()
            .map_or(high, |objects| feature_solids::with_room(high, objects.highest()));
        let high = feature_solids.as_ref().map_or(high, |feature_solids| feature_solids.highest(high));
        let high = surveyed.cloud_solids.as_ref().map_or(high, |cloud_solids| cloud_solids.highest(high));
        let low = surveyed.heights.low;
        let code = HeightCode::spanning(low, high.max(tops));
        record.notes(warnings::coarse_steps(HeightCode::spanning(low, high), code));

        // Shapes that stand more than once are stored once.
        let mut collection = Collection::new(plan.grid, code, &options.materials);
        if let Some(feature_solids) = &mut feature_solids {
            feature_solids.share(plan.grid.spacing, &mut collection);
        }
        if let Some(objects) = &mut placed_objects {
            objects.share(&plan.grid, &mut collection);
        }
        let shared = Arc::new(collection.into_shared());
        Ok(Self { feature_solids, objects: placed_objects, shared, code })
    }

    /// Returns the project that all pages are made from.
    pub fn project<'a>(
        &'a self,
        planned: &'a PlannedBuild,
        surveyed: &'a SurveyedBuild,
        job: &BuildJob<'a>,
    ) -> Project<'a> {
        Project {
            code: self.code,
            feature_solids: self.feature_solids.as_ref(),
            cloud_solids: surveyed.cloud_solids.as_ref(),
            objects: self.objects.as_ref(),
            ..surveyed.natural(planned, job, &self.shared)
        }
    }
}
