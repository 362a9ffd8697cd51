//! `asphera check`.

use std::path::Path;

use toml_edit::DocumentMut;

use super::exit::Exit;
use super::files::part;
use super::nominal;
use super::output::{Failure, print};
use crate::config::Config;
use asphera_report::words::counted;

pub(super) fn run(path: &Path) -> Result<Exit, Failure> {
    if is_nominal(path) {
        let told = nominal::told(&part(path)?)?;
        print(&format!("{}: a nominal file: fine\n{told}", path.display()));
        return Ok(Exit::Done);
    }
    let config = Config::load(path)?;
    print(&format!(
        "{}: station {:?}, {}, {}: fine\n",
        path.display(),
        config.name,
        counted(config.links.len() as u64, "link"),
        counted(config.devices.len() as u64, "device")
    ));
    Ok(Exit::Done)
}

/// Whether a file is a nominal, not the configuration of a station. What cannot be read is told by who reads it.
pub(super) fn is_nominal(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.parse::<DocumentMut>()
        .is_ok_and(|document| document.contains_key("surface") && !document.contains_key("station"))
}
