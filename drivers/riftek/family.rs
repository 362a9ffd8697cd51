//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::time::Duration;

use asphera_link::{Carries, Channel, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::device::HELD_MS;
use crate::{Mode, Riftek, Settings};

/// RIFTEK RF60x: `driver = "riftek"`, on a serial line or a terminal server.
pub const FAMILY: Family = Family {
    name: "riftek",
    carries: Carries::Bytes,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let range_mm = table.required("range_mm");
    let is_poll = table.word("mode", false, &[("stream", false), ("poll", true)]);
    let (interval_ms, silence_ms) = (table.get("interval_ms"), table.get("silence_ms"));
    let mode = if is_poll {
        foreign(table, "silence_ms", silence_ms, "mode = \"stream\"");
        Mode::Poll { interval_ms: interval_ms.unwrap_or(20) }
    } else {
        foreign(table, "interval_ms", interval_ms, "mode = \"poll\"");
        Mode::Stream { silence_ms: silence_ms.unwrap_or(2000) }
    };
    let timeout_ms: u32 = table.or("timeout_ms", 200);
    let settings = Settings {
        address: table.or("address", 1),
        mode,
        range_mm: 0,
        serial: table.get("serial"),
        timeout_ms,
        late_limit_ms: table.or("late_limit_ms", timeout_ms.saturating_mul(2).min(600_000)),
    };
    Some(Settings { range_mm: range_mm?, ..settings })
}

/// A key that the other mode has.
fn foreign(table: &Section<'_>, key: &str, value: Option<u32>, mode: &str) {
    if let Some(value) = value {
        table.problem(key, format!("nothing: it belongs to {mode}"), value);
    }
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn holds_back(&self) -> Duration {
        Duration::from_millis(HELD_MS.into())
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Riftek::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("probe", text)
    }

    #[test]
    fn a_described_sensor_gives_a_driver() {
        let text = "range_mm = 50\nmode = \"poll\"\ninterval_ms = 5\naddress = 3\nserial = 17185";
        for text in ["range_mm = 50", "range_mm = 50\nsilence_ms = 0", text] {
            let sensor = settings(text).unwrap();
            assert_eq!(sensor.driver().unwrap().channels(), sensor.channels());
            assert!(sensor.count_cycle().is_err(), "two bits count nothing to join by");
        }
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let wrong = |text: &str| -> Vec<(usize, String)> {
            let problems = settings(text).unwrap_err();
            problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
        };
        let named = |line, key: &str| (line, key.to_owned());
        assert_eq!(wrong("mode = \"strem\""), [named(1, "range_mm"), named(1, "mode")]);
        let text = "range_mm = 0\naddress = 0\ninterval_ms = 5\ntimeout_ms = 0\nsilence_ms = 1";
        assert_eq!(
            wrong(text),
            [
                named(1, "range_mm"),
                named(2, "address"),
                named(3, "interval_ms"),
                named(4, "timeout_ms"),
                named(5, "silence_ms")
            ]
        );
        assert_eq!(
            wrong("range_mm = 5\nmode = \"poll\"\nsilence_ms = 0"),
            [named(3, "silence_ms")]
        );
    }
}
