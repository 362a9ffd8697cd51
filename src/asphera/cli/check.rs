//! `asphera check`.

use std::path::Path;

use super::exit::Exit;
use super::output::{Failure, print};
use crate::config::Config;

pub(super) fn run(path: &Path) -> Result<Exit, Failure> {
    let config = Config::load(path)?;
    print(&format!(
        "{}: station {:?}, {} links, {} devices: fine\n",
        path.display(),
        config.name,
        config.links.len(),
        config.devices.len()
    ));
    Ok(Exit::Done)
}
