//! Subimages: how a frame is cut into independent tasks, and the farm that works on them.
//!
//! ```text
//! frame ──split──▶ march tasks ──┐         every worker, again and again:
//!                    (barrier)   ├─▶ queue   take the next task, of whichever frame; do it
//!                  image tasks ──┘
//! ```
//! A march task is a group of adjacent vertical scan lines (Hughes patent: NV lines a task), an image task a
//! block of screen rows or columns. A task owns what it writes, and tasks share nothing that they write, so a frame
//! has the same bits for any number of workers and any size of task. This is the only module that
//! knows rayon.
//!
//! [`Farm::each`] runs the tasks of a stage, [`Farm::fly`] frames that overlap; [`TaskSize`] says how large tasks
//! are, [`Trace`] remembers when each ran, [`chrome_trace`] draws that, [`makespan`] says from it what other
//! numbers of workers would take.

mod chrome;
mod farm;
mod overlap;
mod queue;
mod schedule;
mod task;
mod trace;

#[doc(hidden)]
pub use chrome::{NamedTrace, chrome_trace};
pub use farm::Farm;
#[doc(hidden)]
pub use overlap::{Batch, DEFAULT_IN_FLIGHT};
#[doc(hidden)]
pub use schedule::{FrameWork, makespan};
#[doc(hidden)]
pub use task::{Stage, Subimage, TaskSize, split};
#[doc(hidden)]
pub use trace::{FrameSpan, TaskSpan, Trace};
