//! `[output]`: what is left beside a recording when a session ends.

use std::time::Duration;

use asphera_report::ResultFile;
use asphera_settings::Section;

/// Files written into the folder of a session when it ended, and what runs then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputConfig {
    /// The files, in the order they are written.
    pub files: Vec<ResultFile>,
    /// A program and its arguments, run with the folder as one more; empty: none.
    pub command: Vec<String>,
    /// How long it may take before it is ended.
    pub command_timeout: Duration,
}

/// What is written without a word in the configuration: what the list of sessions shows.
const DEFAULT: [ResultFile; 2] = [ResultFile::Report, ResultFile::Html];

pub(super) fn read(section: &Section<'_>) -> OutputConfig {
    let names: Vec<String> =
        section.or("files", DEFAULT.iter().map(|file| file.name().to_owned()).collect());
    let mut files = Vec::new();
    for name in names {
        match ResultFile::named(&name) {
            Some(file) if !files.contains(&file) => files.push(file),
            Some(_) => {}
            None => {
                let known: Vec<_> = ResultFile::ALL.iter().map(|file| file.name()).collect();
                section.problem("files", format!("names out of {}", known.join(", ")), name);
            }
        }
    }
    let command: Vec<String> = section.or("command", Vec::new());
    if command.first().is_some_and(String::is_empty) {
        section.problem("command", "a program and its arguments", "an empty name");
    }
    let timeout_s = section.within("command_timeout_s", 60.0, 0.1..=3600.0);
    section.finish();
    OutputConfig { files, command, command_timeout: Duration::from_secs_f64(timeout_s) }
}
