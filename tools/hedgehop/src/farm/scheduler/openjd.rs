//! Open Job Description: a template of the job, which farms take and `openjd run` works off here.

use std::path::Path;

use serde_json::json;

use super::{Call, Tasks, scripts};
use crate::frame_ranges::ranges;

/// Name of the template in the job's folder.
pub const TEMPLATE: &str = "openjd.json";
const MIB: u64 = 1 << 20;
/// Time that a chunk may take, seconds.
const DAY: u32 = 86_400;

/// Returns the template: a task for each chunk, and the end of the job behind them.
pub fn template(tasks: &Tasks, place: &Path) -> String {
    let name = place.file_name().unwrap_or(place.as_os_str()).to_string_lossy().into_owned();
    let script = |name: &str| place.join(name).display().to_string();
    let mut amounts = vec![json!({ "name": "amount.worker.vcpu", "min": tasks.cores })];
    amounts.extend(
        tasks
            .memory_asked()
            .map(|bytes| json!({ "name": "amount.worker.memory", "min": bytes.div_ceil(MIB) })),
    );

    // A list may have 1024 numbers at most; as text there may be more. Braces in a name would be taken for an expression;
    // parameters' values are not.
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": "{{Param.Name}}",
        "parameterDefinitions": [
            { "name": "Name", "type": "STRING", "default": name },
            { "name": "ChunkScript", "type": "STRING", "default": script(scripts::CHUNK) },
            { "name": "FinishScript", "type": "STRING", "default": script(scripts::FINISH) },
        ],
        "steps": [
            {
                "name": "Render",
                "parameterSpace": {
                    "taskParameterDefinitions": [{ "name": "Chunk", "type": "INT", "range": ranges(&tasks.chunks) }],
                },
                "hostRequirements": { "amounts": amounts },
                "script": { "actions": { "onRun": {
                    "command": "sh",
                    "args": ["{{Param.ChunkScript}}", "{{Task.Param.Chunk}}"],
                    "timeout": DAY,
                    "cancelation": { "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 30 },
                } } },
            },
            {
                "name": "Finish",
                "dependencies": [{ "dependsOn": "Render" }],
                "script": { "actions": { "onRun": {
                    "command": "sh", "args": ["{{Param.FinishScript}}"],
                } } },
            },
        ],
    });
    format!("{template:#}\n")
}

/// Returns the command that works off the chunks on this machine; whoever runs it ends the job.
pub fn run(tasks: &Tasks, place: &Path) -> Call {
    let mut words: Vec<String> = ["openjd", "run"].map(String::from).to_vec();
    words.push(place.join(TEMPLATE).display().to_string());
    words.extend(["--step", "Render"].map(String::from));
    words.extend(tasks.pass.iter().cloned());
    Call::Wait(words)
}
