//! The tables `device.NAME`: which driver, on which link, with which settings.

use std::sync::Arc;

use asphera_link::{Capture, Carries, Channel, Command, DeviceSettings, Family, Nanos, Proposal};
use asphera_settings::Section;

/// The drivers there are, a line each.
#[rustfmt::skip]
const DRIVERS: &[Family] = &[
    asphera_chrocodile::FAMILY,
    asphera_cia402::FAMILY,
    asphera_cia406::FAMILY,
    asphera_ippdme::FAMILY,
    asphera_keyence::FAMILY,
    asphera_modbus::FAMILY,
    asphera_optoncdt::FAMILY,
    asphera_rf627::FAMILY,
    asphera_riftek::FAMILY,
    asphera_scpi::FAMILY,
    asphera_zaber::FAMILY,
    asphera_described::FAMILY,
];

/// What each driver that can proposes for a device that was listened to.
pub(crate) fn proposals(capture: &Capture) -> Vec<(Family, Proposal)> {
    let propose = |family: &Family| Some((*family, family.propose?(capture)));
    DRIVERS.iter().filter_map(propose).collect()
}

/// One device.
#[derive(Clone, Debug)]
pub struct DeviceConfig {
    /// Name of its table.
    pub name: String,
    /// Index of its link in the order of the file.
    pub link: usize,
    /// Kind of data its link must carry.
    pub carries: Carries,
    /// Its driver's settings.
    pub settings: Arc<dyn DeviceSettings>,
    /// Channels that it measures.
    pub channels: Vec<Channel>,
}

impl DeviceConfig {
    /// Whether anything is sent to the device, from its start to its end: questions, commands, settings.
    pub(super) fn is_sent_to(&self) -> bool {
        // Settings that cannot be used are a problem of their own.
        let Ok(mut driver) = self.settings.driver() else { return false };
        let mut now = Nanos::ZERO;
        driver.connected(now);
        driver.command(now, Command::Start);
        for _ in 0..TIMERS {
            if driver.poll_transmit().is_some() {
                return true;
            }
            let Some(due) = driver.poll_timeout() else { break };
            now = now.max(due);
            driver.timeout(now);
        }
        driver.command(now, Command::Stop);
        driver.poll_transmit().is_some()
    }
}

/// Reads one device; `links` are the names of the links there are.
pub(super) fn read(name: String, table: &Section<'_>, links: &[String]) -> Option<DeviceConfig> {
    let drivers: Vec<(&str, Family)> =
        DRIVERS.iter().map(|family| (family.name, *family)).collect();
    let family = table.required_word("driver", &drivers);
    let link: Option<String> = table.required("link");
    let link = link.and_then(|link| {
        let index = links.iter().position(|known| *known == link);
        if index.is_none() {
            let expected = format!("one of the links {}", listed(links));
            table.problem("link", expected, format!("{link:?}"));
        }
        index
    });
    let settings = table.section("settings");
    table.finish();
    let family = family?;
    let settings = family.read(&settings)?;
    let carries = settings.carries().unwrap_or(family.carries);
    let channels = settings.channels();
    Some(DeviceConfig { name, link: link?, carries, settings: settings.into(), channels })
}

/// Names with commas between; of many the first, for every device may be told them.
fn listed(names: &[String]) -> String {
    let rest = if names.len() > LISTED { ", …" } else { "" };
    names[..names.len().min(LISTED)].join(", ") + rest
}

/// Timers of a driver that run out before it has sent what it sends by itself: a delay after the start, and a question's.
const TIMERS: usize = 8;

/// Most names that a problem lists.
const LISTED: usize = 20;
