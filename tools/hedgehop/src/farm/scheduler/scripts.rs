//! Scripts in a job's folder that every scheduler runs: one chunk, and the end of the job.

use super::Tasks;
use crate::exit;
use crate::farm::job::FarmJob;
use crate::farm::shell::quoted;

/// Name of the script that renders a chunk.
pub const CHUNK: &str = "chunk.sh";
/// Name of the script that ends the job.
pub const FINISH: &str = "finish.sh";

/// Exit codes of what another try does not mend: wrong flags, wrong files, another job's.
pub const FINAL: [u8; 4] = [exit::USAGE, exit::INVALID, exit::UNSUPPORTED, exit::MISMATCH];

/// Returns the script of a chunk, whose number is its argument or that of the scheduler's task.
///
/// What a worker says goes to a log by the number of its chunk. A request to stop is passed on.
pub fn chunk(tasks: &Tasks, job: &FarmJob) -> String {
    let last: Vec<String> = FINAL.iter().map(u8::to_string).collect();
    let quote = |text: String| quoted(&[text]);
    format!(
        r#"#!/bin/sh
# Renders one chunk: sh chunk.sh [NUMBER]; the number is that of the scheduler's task otherwise.
cd {folder} || exit {io}
number=${{1:-${{HQ_TASK_ID:-$((SLURM_ARRAY_TASK_ID + ${{HEDGEHOP_CHUNK_OFFSET:-0}}))}}}}
exec >>{place}/logs/"$number".log 2>&1 </dev/null
stop() {{ trap '' INT TERM HUP; kill -TERM "$worker" 2>/dev/null; wait "$worker"; exit 143; }}
trap stop INT TERM HUP
tries=0
while :; do
    {command} --chunk "$number" &
    worker=$!
    wait "$worker"
    code=$?
    # Another try does not mend wrong flags, wrong files, or what is not the job's.
    case $code in 0 | {last}) exit $code ;; esac
    [ $tries -ge {retries} ] && exit $code
    tries=$((tries + 1))
done
"#,
        folder = quote(job.folder.display().to_string()),
        io = exit::IO,
        place = quote(job.place.display().to_string()),
        command = quoted(&tasks.worker(job)),
        last = last.join(" | "),
        retries = tasks.retries,
    )
}

/// Returns the script that ends the job.
pub fn finish(tasks: &Tasks, job: &FarmJob) -> String {
    let quote = |text: String| quoted(&[text]);
    format!(
        r#"#!/bin/sh
# Lists the frames, and makes film and contact sheet, once all chunks are done; says which frames are missing otherwise.
# Its arguments are jobs of HyperQueue that it is to wait for.
cd {folder} || exit {io}
[ $# -eq 0 ] || hq job wait "$@"
exec {program} farm finish --progress plain -- {place} >>{place}/logs/finish.log 2>&1 </dev/null
"#,
        folder = quote(job.folder.display().to_string()),
        io = exit::IO,
        program = quote(tasks.program.display().to_string()),
        place = quote(job.place.display().to_string()),
    )
}
