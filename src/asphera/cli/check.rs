//! `asphera check`.

use std::path::Path;

use asphera_report::words::counted;
use asphera_transport::Endpoint;
use toml_edit::DocumentMut;

use super::exit::Exit;
use super::files::part;
use super::nominal;
use super::output::{Failure, print};
use crate::clock::Clock;
use crate::config::{Config, LinkConfig};

pub(super) fn run(path: &Path) -> Result<Exit, Failure> {
    if is_nominal(path) {
        let told = nominal::told(&part(path)?)?;
        print(&format!("{}: a nominal file: fine\n{told}", path.display()));
        return Ok(Exit::Done);
    }
    let config = Config::load(path)?;
    let unix_s = Clock::start().started_wall_ns() / NS_PER_S;
    let problems = certificates(&config.links, unix_s);
    if !problems.is_empty() {
        return Err(format!("{}: {}", path.display(), problems.join("\n")).into());
    }
    print(&format!(
        "{}: station {:?}, {}, {}: fine\n",
        path.display(),
        config.name,
        counted(config.links.len() as u64, "link"),
        counted(config.devices.len() as u64, "device")
    ));
    for index in 0..config.links.len() {
        print(&clocks(&config, index));
    }
    Ok(Exit::Done)
}

/// Whether a file is a nominal, not the configuration of a station. What cannot be read is told by who reads it.
pub(super) fn is_nominal(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.parse::<DocumentMut>()
        .is_ok_and(|document| document.contains_key("surface") && !document.contains_key("station"))
}

/// What is wrong with the certificates and keys of links by TLS at this time. They are read anew when a link opens.
fn certificates(links: &[LinkConfig], unix_s: i64) -> Vec<String> {
    let of = |link: &LinkConfig| -> Vec<String> {
        let Endpoint::Tls { tls, .. } = &link.endpoint else { return Vec::new() };
        let problems = tls.file_problems(unix_s);
        problems.iter().map(|problem| format!("link.{}.tls: {problem}", link.name)).collect()
    };
    links.iter().flat_map(of).collect()
}

/// A line with the clocks by which readings of a link have their times: that of its receipts, and those of its devices.
fn clocks(config: &Config, index: usize) -> String {
    let link = &config.links[index];
    let receipts = match (link.framing.clock(), &link.endpoint) {
        (Some("kernel"), _) => "kernel, as it takes each frame",
        (Some("controller"), _) => "controller, which stamps each frame",
        (Some(_), _) => "adapter, which stamps each frame; host, if it refuses",
        (None, Endpoint::CanLog { .. }) => "host, as the log is played",
        (None, _) => "host, as bytes are read",
    };
    let devices = config.devices.iter().filter(|device| device.link == index);
    let own = devices.filter(|device| device.settings.clock().is_some());
    let own: String = own.map(|device| format!("; {}: its own", device.name)).collect();
    format!("{:<10} {:<14} clock: {receipts}{own}\n", link.name, link.kind)
}

const NS_PER_S: i64 = 1_000_000_000;
