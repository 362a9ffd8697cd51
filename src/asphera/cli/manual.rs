//! `asphera completions` and `asphera man`: both are made from the definition of the command line.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use super::exit::Exit;
use super::files::{NO_FILES, refuse};
use super::output::{Failure, print};
use crate::whole_file::write_bytes;

#[derive(Args)]
pub(super) struct CompletionsArgs {
    /// The shell.
    shell: Shell,
}

#[derive(Args)]
pub(super) struct ManArgs {
    /// Where the pages go, asphera.1 and one for each command, as asphera-measure.1; without it the page of asphera goes
    /// to stdout.
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
    /// Overwrite pages that are there.
    #[arg(long)]
    force: bool,
}

/// Prints the completions of a shell.
pub(super) fn completions(args: &CompletionsArgs, mut command: Command) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "asphera", &mut script);
    print(&String::from_utf8(script)?);
    Ok(Exit::Done)
}

/// Prints the page of the manual, or writes all of them.
pub(super) fn pages(args: &ManArgs, command: Command) -> Result<Exit, Failure> {
    let pages = all_pages(command)?;
    let Some(folder) = &args.folder else {
        pages.first().into_iter().for_each(|(_, text)| print(text));
        return Ok(Exit::Done);
    };
    let failed = |path: &Path, error| format!("cannot write {}: {error}", path.display());
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    let paths: Vec<PathBuf> = pages.iter().map(|(name, _)| folder.join(name)).collect();
    // None is written where one must not be.
    paths.iter().try_for_each(|path| refuse(path, NO_FILES, args.force))?;
    for (path, (_, text)) in paths.iter().zip(&pages) {
        write_bytes(path, text)?;
    }
    print(&format!("{} pages written to {}\n", pages.len(), folder.display()));
    Ok(Exit::Done)
}

/// The pages with the names of their files, that of asphera first.
fn all_pages(mut command: Command) -> Result<Vec<(String, String)>, Failure> {
    command.build();
    let version = command.get_version().unwrap_or_default().to_owned();
    let commands = command.get_subcommands().filter(|verb| verb.get_name() != "help");
    // A page of its own each: the pages of a command's parts would have one name.
    let parts: Vec<Command> = commands.cloned().collect();
    let mut pages = Vec::new();
    for command in [command].into_iter().chain(parts) {
        let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned();
        let mut page = Vec::new();
        Man::new(command)
            .title(&name)
            .source(format!("asphera {version}"))
            .manual("asphera")
            .render(&mut page)?;
        pages.push((format!("{name}.1"), String::from_utf8(page)?));
    }
    Ok(pages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    use crate::cli::Cli;

    #[test]
    fn every_command_has_a_page_with_its_example() {
        let pages = all_pages(Cli::command()).unwrap();
        let mut names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names.remove(0), "asphera.1");
        let commands = Cli::command();
        let expected: Vec<String> = commands
            .get_subcommands()
            .map(|command| format!("asphera-{}.1", command.get_name()))
            .collect();
        assert_eq!(names, expected);
        for (name, text) in &pages {
            assert!(text.contains("Example") && text.contains(".SH SYNOPSIS"), "{name}: {text}");
            assert!(text.contains(concat!("asphera ", env!("CARGO_PKG_VERSION"))), "{name}");
        }
    }
}
