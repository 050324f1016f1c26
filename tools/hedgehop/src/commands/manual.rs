//! `hedgehop completions` and `hedgehop man`: what shells and readers of manuals want to know of all commands.

use std::path::{Path, PathBuf};

use clap::Command;
use clap_complete::Shell;

use crate::exit::{self, Outcome};
use hedgehop::encode::atomic::write_bytes;
use hedgehop::{Error, Result};

const COMPLETIONS: &str = "\
Examples:
  hedgehop completions bash > ~/.local/share/bash-completion/completions/hedgehop
  hedgehop completions zsh > ~/.zfunc/_hedgehop        (a folder of fpath)
  hedgehop completions fish > ~/.config/fish/completions/hedgehop.fish
  hedgehop completions powershell >> $PROFILE";

const MANUAL: &str = "\
Examples:
  hedgehop man | man -l -
  hedgehop man ~/.local/share/man/man1";

/// Name of the program in shells and manuals, whatever its file is called.
const NAME: &str = "hedgehop";

/// Print what makes a shell complete commands and flags.
#[derive(Debug, clap::Args)]
#[command(after_help = COMPLETIONS, after_long_help = format!("{COMPLETIONS}\n\n{}", exit::HELP))]
pub struct CompletionArgs {
    /// Shell that completes
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

/// Write manual pages, or print that of the program.
#[derive(Debug, clap::Args)]
#[command(after_help = MANUAL, after_long_help = format!("{MANUAL}\n\n{}", exit::HELP))]
pub struct ManArgs {
    /// Folder for a page of every command; it is made if it does not exist [default: the page of the program is printed]
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// Runs `hedgehop completions`.
pub fn completions(args: &CompletionArgs, mut command: Command) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, NAME, &mut script);
    Ok(exit::print(&String::from_utf8_lossy(&script))?)
}

/// Runs `hedgehop man`.
pub fn pages(args: &ManArgs, command: Command) -> Outcome {
    let Some(folder) = &args.folder else {
        return Ok(exit::print(&String::from_utf8_lossy(&page(&command, folder_of_none())?))?);
    };
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, "create the folder", error))?;

    let mut command = command;
    command.build();
    let count = write_pages(&command, NAME, folder)?;
    Ok(exit::print(&format!("{count} pages in {}\n", folder.display()))?)
}

/// Writes the pages of a command and of all below it; returns how many these are.
fn write_pages(command: &Command, name: &str, folder: &Path) -> Result<usize> {
    let file = folder.join(format!("{name}.1"));
    // A static name is what clap wants; there are some thirty, once.
    let titled = command.clone().name(name.to_owned().leak() as &'static str).display_name(name);
    write_bytes(&file, &page(&titled, &file)?)?;

    let mut count = 1;
    for below in command.get_subcommands().filter(|below| below.get_name() != "help" && !below.is_hide_set())
    {
        count += write_pages(below, &format!("{name}-{}", below.get_name()), folder)?;
    }
    Ok(count)
}

/// A manual page, as roff.
fn page(command: &Command, file: &Path) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    let man = clap_mangen::Man::new(command.clone());
    man.render(&mut text).map_err(|error| Error::io(file, "write", error))?;
    Ok(text)
}

/// Returns the folder that errors name of a page which goes to no file.
fn folder_of_none() -> &'static Path {
    Path::new("standard output")
}
