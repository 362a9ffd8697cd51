//! What is printed: results on stdout, everything else on stderr.

use std::error::Error;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use asphera_report::ResultFile;
use serde::Serialize;

use super::OutputArgs;
use super::progress::Progress;
use super::summary::summary;
use crate::results;
use crate::whole_file::write_bytes;
use asphera_measure::Measurement;
use asphera_report::error_chain;

/// Anything that stops a command, printed once, with its causes.
pub(super) type Failure = Box<dyn Error + Send + Sync>;

/// Prints why a command failed.
pub(super) fn complain(failure: &Failure) {
    say(&format!("error: {}", error_chain(&**failure)));
}

/// A line on stderr. Where nobody reads it any more, the work goes on: a daemon may outlive its log.
pub(super) fn say(line: &str) {
    let _nothing_is_drawn = cleared();
    let _ = io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// Text on stdout; waits for its reader. Of a reader that went away nothing is said, for nobody is left to tell. Any other failure is kept for
/// [`stdout_failure`].
pub(super) fn print(text: &str) {
    // A reader may take for ever: what is said on stderr does not wait for it.
    clear_progress();
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    if let Err(error) = written
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        *FAILED.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
    }
}

/// Why not all that was printed has arrived, if so.
pub(super) fn stdout_failure() -> Option<Failure> {
    let error = FAILED.lock().unwrap_or_else(PoisonError::into_inner).take()?;
    Some(format!("cannot write the results to stdout: {error}").into())
}

/// The last failure of stdout that is to be told.
static FAILED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Whether log lines may have colours: on a terminal, unless `NO_COLOR` (https://no-color.org) is set.
pub(super) fn has_colours() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Whether progress is drawn: on a terminal that can clear a line.
pub(super) fn draws_progress() -> bool {
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|kind| kind != "dumb")
}

/// Progress on a terminal, over the line before.
pub(super) fn progress(line: &str) {
    if draws_progress() {
        let mut is_drawn = IS_DRAWN.lock().unwrap_or_else(PoisonError::into_inner);
        *is_drawn = true;
        let _ = io::stderr().write_all(format!("\r{CLEAR_LINE}{line}").as_bytes());
    }
}

/// Clears the line of progress, if there is one.
pub(super) fn clear_progress() {
    drop(cleared());
}

/// Clears the line of progress; none is drawn while the guard is held.
fn cleared() -> MutexGuard<'static, bool> {
    let mut is_drawn = IS_DRAWN.lock().unwrap_or_else(PoisonError::into_inner);
    if std::mem::take(&mut *is_drawn) {
        let _ = io::stderr().write_all(format!("\r{CLEAR_LINE}").as_bytes());
    }
    is_drawn
}

/// Where log lines go: stderr, behind the line of progress.
pub(super) fn log_writer() -> io::Stderr {
    clear_progress();
    io::stderr()
}

/// Whether a line of progress stands on the terminal.
static IS_DRAWN: Mutex<bool> = Mutex::new(false);

/// Clears the line to its end (ECMA-48, EL).
const CLEAR_LINE: &str = "\x1b[K";

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

/// Writes and prints the figures as asked. Progress ends before anything is printed.
pub(super) fn deliver(
    measurement: &Measurement,
    args: &OutputArgs,
    progress: Option<Progress>,
) -> Result<(), Failure> {
    if let Some(folder) = &args.out {
        progress.iter().for_each(|progress| progress.stage("writing the results"));
        results::write(folder, measurement)?;
    }
    drop(progress);
    print(&figures(measurement, args)?);
    Ok(())
}

/// Figures as asked: a JSON object, or a summary.
pub(super) fn figures(measurement: &Measurement, args: &OutputArgs) -> Result<String, Failure> {
    if args.json {
        json(&measurement.report)
    } else {
        Ok(summary(&measurement.report, args.details))
    }
}

/// One JSON object on stdout.
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    print(&json(value)?);
    Ok(())
}

fn json(value: &impl Serialize) -> Result<String, Failure> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    Ok(text)
}

/// Names the file that an error kept from being written.
pub(super) fn cannot_write<E: Error>(path: &Path) -> impl FnOnce(E) -> Failure + use<E> {
    let name = path.display().to_string();
    move |error| {
        // What a format says of its destination is said by the name of the file.
        let cause = error.source().map_or_else(|| error.to_string(), ToString::to_string);
        format!("cannot write {name}: {cause}").into()
    }
}

/// Writes a value as JSON.
pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    Ok(write_bytes(path, json(value)?)?)
}
