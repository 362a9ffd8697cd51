//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::time::Duration;

use asphera_link::{Carries, Channel, DeviceClock, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::device::COUNTS;
use crate::{Rf627, Settings};

/// RIFTEK RF627: `driver = "rf627"`, on a UDP link.
pub const FAMILY: Family = Family {
    name: "rf627",
    carries: Carries::Datagrams,
    settings: |table| Some(Box::new(read(table))),
    propose: None,
};

fn read(table: &Section<'_>) -> Settings {
    let default = Settings::default();
    Settings {
        serial: table.get("serial"),
        silence_ms: table.or("silence_ms", default.silence_ms),
        reorder_ms: table.or("reorder_ms", default.reorder_ms),
    }
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn measures_profiles(&self) -> bool {
        true
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        Ok(COUNTS)
    }

    fn holds_back(&self) -> Duration {
        Duration::from_millis(self.reorder_ms.into())
    }

    fn clock(&self) -> Option<DeviceClock> {
        // 64 bits of nanoseconds.
        Some(DeviceClock::default())
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Rf627::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("scanner", text)
    }

    #[test]
    fn a_described_scanner_gives_a_driver() {
        for text in ["", "serial = 180000\nsilence_ms = 500\nreorder_ms = 0"] {
            let scanner = settings(text).unwrap();
            assert_eq!(scanner.driver().unwrap().channels(), scanner.channels());
            assert!(scanner.measures_profiles());
            assert_eq!(scanner.count_cycle(), Ok(1 << 31));
        }
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let problems =
            settings("serial = -1\nsilence_ms = 5\nreorder_ms = 1001\nport = 1").unwrap_err();
        let named: Vec<_> =
            problems.0.iter().map(|problem| (problem.line, problem.key.as_str())).collect();
        assert_eq!(named, [(1, "serial"), (2, "silence_ms"), (3, "reorder_ms"), (4, "port")]);
    }
}
