//! What a session leaves beside its recording: result files, then a command.

use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::time::Duration;

use asphera_report::{Outputs, Report};
use tokio::sync::watch;
use tracing::{error, info};

use super::Finished;
use crate::config::OutputConfig;
use crate::results::{command_line, write_files};
use asphera_paper::{Provenance, SourceFile};
use asphera_report::error_chain;

/// Writes the files of a session that ended into its folder. Blocks for as long as the disk takes.
pub(super) fn write(config: &OutputConfig, finished: &Finished, folder: &Path) -> Outputs {
    let told = |why: String| {
        error!(folder = %folder.display(), %why, "results could not be written");
        why
    };
    let measurement = &finished.measurement;
    // Checksums cost a reading of the whole recording: only papers hold them.
    let files = match config.files.iter().any(|file| file.is_paper()) {
        true => SourceFile::read_session(folder),
        false => Ok(Vec::new()),
    };
    let files = match files {
        Ok(files) => files,
        Err(error) => {
            return Outputs { problem: Some(told(error_chain(&error))), ..Outputs::default() };
        }
    };
    let provenance = Provenance { files, command: command_line(), ..Provenance::default() };
    let written = write_files(folder, &config.files, measurement, &provenance);
    let problem = written.err().map(|error| told(error_chain(&error)));
    let there = |name: &&str| folder.join(name).is_file();
    let names = config.files.iter().map(|file| file.name()).filter(there);
    Outputs { files: names.map(str::to_owned).collect(), problem }
}

/// Runs the command of a session that ended, in a thread of its own. `running` counts those that run.
pub(super) fn run_command(
    config: &OutputConfig,
    finished: &Arc<Finished>,
    folder: PathBuf,
    running: &watch::Sender<usize>,
) {
    let Some((program, arguments)) = config.command.split_first() else { return };
    let mut command = Command::new(program);
    command.args(arguments).arg(&folder).stdin(Stdio::null());
    for (name, value) in environment(&finished.measurement.report) {
        command.env(name, value);
    }
    // What is on stdout is the daemon's own.
    if let Ok(stderr) = std::io::stderr().as_fd().try_clone_to_owned() {
        command.stdout(Stdio::from(stderr));
    }
    let (program, timeout) = (program.clone(), config.command_timeout);
    running.send_modify(|running| *running += 1);
    let running = running.clone();
    tokio::task::spawn_blocking(move || {
        match command.spawn() {
            Ok(child) => tell(&program, wait(child, timeout), timeout),
            Err(error) => error!(%program, %error, "the command of [output] cannot be run"),
        }
        running.send_modify(|running| *running -= 1);
    });
}

fn environment(report: &Report) -> [(&'static str, String); 2] {
    let session = report.session.as_ref().map_or_else(String::new, |session| session.id.clone());
    [("ASPHERA_VERDICT", report.verdict.status.to_string()), ("ASPHERA_SESSION", session)]
}

/// `None` where it had to be ended.
fn wait(mut child: Child, timeout: Duration) -> std::io::Result<Option<ExitStatus>> {
    let mut waited = Duration::ZERO;
    while waited < timeout {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        // Nothing else happens on this thread.
        std::thread::park_timeout(POLL);
        waited += POLL;
    }
    child.kill()?;
    child.wait()?;
    Ok(None)
}

fn tell(program: &str, ended: std::io::Result<Option<ExitStatus>>, timeout: Duration) {
    match ended {
        Ok(Some(status)) if status.success() => info!(program, "the command of [output] is done"),
        Ok(Some(status)) => error!(program, %status, "the command of [output] failed"),
        Ok(None) => {
            error!(program, ?timeout, "the command of [output] took too long and was ended");
        }
        Err(error) => error!(program, %error, "the command of [output] was lost"),
    }
}

/// How soon it is seen that a command has ended.
const POLL: Duration = Duration::from_millis(20);
