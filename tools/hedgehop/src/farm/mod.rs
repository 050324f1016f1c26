//! A flight on many machines: chunks of frames of equal predicted cost, which any scheduler hands out and `render` works off.
//!
//! ```text
//! farm submit   flags ──cost_samples──▶ CostModel ──cut──▶ chunks ──▶ FRAMES.job/job.json
//!                 └──▶ the scheduler's own commands, printed or run
//! worker        render FLAGS --skip-existing --farm FRAMES.job --chunk N
//!                 refuses what is not the job's; renders; a record of each frame goes to parts/N.*.jsonl
//! farm finish   parts ──▶ manifest.json and poses.csv, as of one process; film; contact sheet
//! ```
//!
//! Nothing but files says how far a job is: a worker, a machine or a scheduler that dies takes no knowledge along, and
//! whoever comes next goes on with the frames that are missing.

pub mod chunk_lock;
pub mod chunks;
pub mod cost;
pub mod job;
pub mod parts;
pub mod scheduler;
pub mod shell;
pub mod submissions;
pub mod work;
