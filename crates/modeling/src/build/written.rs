//! Fifth and sixth phase: all pages in a file, and the file under its name.

use std::sync::Arc;

use super::job::{BuildJob, BuildRecord};
use super::planned::PlannedBuild;
use super::raised::RaisedBuild;
use super::report::BuildReport;
use super::surveyed::SurveyedBuild;
use crate::counts::PageCounts;
use crate::page_keys::PageKeys;
use crate::writing::{Written, write_pages};
use crate::{build_cache, warnings};
use hedgehop::voxel::{HeightCode, HeightRange, PageWriter};
use hedgehop_base::error::{Error, Result};

/// Build whose pages are written, in a file without a name.
pub(super) struct WrittenBuild {
    writer: PageWriter,
    written: Written,
}

impl WrittenBuild {
    /// Makes and writes all pages, finest first.
    ///
    /// # Errors
    /// A source cannot be read, the disk is full, somebody stops the build, or no voxel gets a height.
    pub fn new(
        planned: &PlannedBuild,
        surveyed: &SurveyedBuild,
        raised: &RaisedBuild,
        job: &BuildJob<'_>,
    ) -> Result<Self> {
        let BuildJob { options, budget, observer } = *job;
        let RaisedBuild { shared, code, .. } = raised;
        let (grid, cache) = (planned.plan.grid, planned.cache.as_ref());

        let project = raised.project(planned, surveyed, job);
        let page_keys = planned.keys.as_ref().map(|keys| PageKeys::new(keys, &project).with_shared(shared));

        let mut writer = PageWriter::create(&options.output, grid, *code, options.overwrite)?
            .with_objects(Arc::clone(shared));
        writer.expect(planned.disk_space(options).most_bytes() + shared.to_bytes().len() as u64);
        let mut writer = build_cache::begin(cache, writer, budget.changes)?;

        let trace = cache.zip(page_keys.as_ref());
        let mut written = Written::default();
        if let Err(error) = write_pages(&project, budget.threads, trace, &mut writer, &mut written, observer)
        {
            return Err(build_cache::kept(cache, writer, written.pages, error));
        }

        if written.counts.empty == written.counts.voxels {
            return Err(Error::Configuration(format!(
                "no voxel of {} m gets a height: elevation data covers less than half of each; \
                 choose a smaller --spacing or look at --bbox",
                grid.spacing
            )));
        }
        Ok(Self { writer, written })
    }

    /// Completes the metadata and gives the file its name.
    ///
    /// # Errors
    /// The disk is full, or the name cannot be given.
    pub fn publish(
        self,
        planned: &PlannedBuild,
        surveyed: &SurveyedBuild,
        raised: &RaisedBuild,
        job: &BuildJob<'_>,
        mut record: BuildRecord<'_>,
    ) -> Result<BuildReport> {
        let Self { writer, written } = self;
        let (options, counts) = (job.options, written.counts);
        let is_dressed = surveyed.imagery.is_empty() || options.synthetic.has_colours();
        record.notes(warnings::bare(&counts, is_dressed, !surveyed.land_cover.is_empty()));
        record.notes(warnings::voids(&counts, options));

        let mut metadata = record.metadata;
        let share = |count: u64| count as f64 / counts.voxels.max(1) as f64;
        metadata.vertical_datum = planned.datum.label().to_owned();
        metadata.materials = options.materials.records(counts.classes.numbers());
        metadata.void_share = share(counts.voids);
        metadata.filled_share = Some(share(counts.filled)).filter(|share| *share > 0.0);
        metadata.empty_share = share(counts.empty);
        let range = decoded_range(&raised.code, &counts);
        let sealed = writer.seal(&metadata, range)?;
        let (content_hash, bytes) = build_cache::publish(planned.cache.as_ref(), sealed)?;

        Ok(BuildReport {
            grid: planned.plan.grid,
            content_hash,
            bytes,
            voxels: counts.made,
            void_share: metadata.void_share,
            pages: written.pages,
            reused: written.reused,
            seconds: 0.0,
        })
    }
}

fn decoded_range(code: &HeightCode, counts: &PageCounts) -> HeightRange {
    let (low, high) = counts.codes.unwrap_or((1, 1));
    let height = |stored: u16| code.offset + code.scale * f64::from(stored);
    HeightRange { low: height(low), high: height(high) }
}
