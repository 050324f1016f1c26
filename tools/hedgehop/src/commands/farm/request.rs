//! Flags of `render` that a farm is to work off: from the command line, or from a file.
//!
//! ```toml
//! area = "valley.hop"          # the file of the database
//! path = "flight.csv"          # --path; every other key is a flag of render, too
//! size = "1920x1080"
//! aov = ["cryptomatte", "motion"]
//! output = "frames/####.exr"
//! level = true
//! ```

use std::path::Path;

use clap::Parser;
use toml::Value;

use crate::commands::render::RenderArgs;
use crate::farm::job::FarmJob;
use hedgehop::encode::FramePattern;
use hedgehop::{Error, Result};

/// The command line of `render` alone.
#[derive(Debug, Parser)]
#[command(name = "hedgehop render", no_binary_name = true, args_override_self = true)]
struct RenderCommand {
    #[command(flatten)]
    args: RenderArgs,
}

/// Understands flags as `render` does; `origin` names where they stand.
///
/// # Errors
/// Flags that `render` would refuse.
pub fn parse(flags: &[String], origin: &str) -> Result<RenderArgs> {
    RenderCommand::try_parse_from(flags).map(|command| command.args).map_err(|error| {
        let text = error.to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        // Behind a blank line clap repeats how the command is used.
        let said: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
        Error::Configuration(format!(
            "{origin}: {}; they are those of `hedgehop render --help`, and flags of the farm stand before --",
            said.join(" ")
        ))
    })
}

/// Understands the flags of a job's workers, whose frames must go where the job says.
///
/// # Errors
/// They do not.
pub fn of_job(job: &FarmJob) -> Result<RenderArgs> {
    let args = parse(&job.worker_flags(), "the flags of the job")?;
    let folder = args.output.as_ref().and_then(FramePattern::folder);
    if folder != Some(job.frames_folder.as_path()) {
        return Err(Error::Configuration(format!(
            "{}: its flags and its frames_folder, {}, name different folders; submit it anew",
            job.place.display(),
            job.frames_folder.display()
        )));
    }
    Ok(args)
}

/// Reads the flags that a file holds.
///
/// # Errors
/// No TOML; a value that is no flag's.
pub fn read(path: &Path) -> Result<Vec<String>> {
    if path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("hop")) {
        let what = "is a database, and a file with flags of render is wanted here; \
                    the database stands with these flags behind --";
        return Err(Error::Configuration(format!("{} {what}", path.display())));
    }
    let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, "read it", error))?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        Error::invalid(path, format!("line {line}: {}", error.message().replace('\n', " ")))
    })?;

    let mut flags = Vec::new();
    for (key, value) in &table {
        let name = key.replace('_', "-");
        let text = match value {
            Value::Boolean(false) => continue,
            Value::Boolean(true) => {
                flags.push(format!("--{name}"));
                continue;
            }
            Value::Array(items) => {
                items.iter().map(scalar).collect::<Option<Vec<_>>>().map(|all| all.join(","))
            }
            other => scalar(other),
        };

        let text = text.ok_or_else(|| {
            Error::invalid(
                path,
                format!("`{key}` is no value of a flag; write text, a number, true, or a list of these"),
            )
        })?;
        if key == "area" {
            flags.insert(0, text);
        } else {
            flags.push(format!("--{name}={text}"));
        }
    }

    Ok(flags)
}

fn scalar(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_flags() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.toml");
        std::fs::write(
            &path,
            "path = \"f.csv\"\narea = \"a.hop\"\nskip_existing = true\nlevel = false\nfps = 29.97\naov = [\"cryptomatte\", \"motion\"]\noutput = \"f/####.exr\"\n",
        )
        .unwrap();
        let flags = read(&path).unwrap();
        assert_eq!(flags[0], "a.hop");
        for flag in [
            "--path=f.csv",
            "--skip-existing",
            "--fps=29.97",
            "--aov=cryptomatte,motion",
            "--output=f/####.exr",
        ] {
            assert!(flags.iter().any(|found| found == flag), "{flag}: {flags:?}");
        }
        assert!(!flags.iter().any(|flag| flag.starts_with("--level")));
        assert_eq!(&*parse(&flags, "night.toml").unwrap().area, Path::new("a.hop"));
    }

    #[test]
    fn what_is_wrong_names_file_and_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("night.toml");
        for (text, words) in [("area = \n", "line 1"), ("area = \"a\"\npath = { x = 1 }\n", "`path`")] {
            std::fs::write(&path, text).unwrap();
            let message = read(&path).unwrap_err().to_string();
            assert!(message.contains("night.toml") && message.contains(words), "{message}");
        }
        let message = parse(&["a.hop".into(), "--pth=x".into()], "night.toml").unwrap_err().to_string();
        assert!(message.starts_with("night.toml") && message.contains("--pth"), "{message}");
    }
}
