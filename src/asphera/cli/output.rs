//! What is printed: results on stdout, everything else on stderr.

use std::error::Error;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;

use serde::Serialize;

use super::{OutputArgs, summary};
use crate::error_chain;
use crate::pipeline::Measurement;
use crate::results::{self, ResultFile};

/// Anything that stops a command, printed once, with its causes.
pub(super) type Failure = Box<dyn Error + Send + Sync>;

/// Prints why a command failed.
pub(super) fn complain(failure: &Failure) {
    say(&format!("error: {}", error_chain(&**failure)));
}

/// A line on stderr.
#[expect(clippy::print_stderr, reason = "the place where stderr is written")]
pub(super) fn say(line: &str) {
    eprintln!("{line}");
}

/// Text on stdout. A reader that went away ends the command quietly: there is nobody left to tell.
pub(super) fn print(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Whether progress may be drawn.
pub(super) fn is_terminal() -> bool {
    io::stderr().is_terminal()
}

/// Progress on a terminal, over the line before.
#[expect(clippy::print_stderr, reason = "the place where stderr is written")]
pub(super) fn progress(line: &str) {
    if is_terminal() {
        eprint!("\r\x1b[K{line}");
        let _ = io::stderr().flush();
    }
}

/// Fails where results of another measurement lie in the folder asked for, and are not to be overwritten.
pub(super) fn refuse_results(args: &OutputArgs) -> Result<(), Failure> {
    let Some(folder) = args.out.as_deref().filter(|_| !args.force) else { return Ok(()) };
    match ResultFile::OUT.iter().map(|file| folder.join(file.name())).find(|path| path.exists()) {
        Some(path) => {
            Err(format!("{} is there already; --force overwrites it", path.display()).into())
        }
        None => Ok(()),
    }
}

/// Prints and writes the figures as asked.
pub(super) fn deliver(measurement: &Measurement, args: &OutputArgs) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        results::write(folder, measurement)?;
    }
    if args.json {
        print_json(&measurement.report)?;
    } else {
        print(&summary::of(&measurement.report));
    }
    Ok(())
}

/// One JSON object on stdout.
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    print(&text);
    Ok(())
}

/// Writes a value as JSON.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    std::fs::write(path, text)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    Ok(())
}
