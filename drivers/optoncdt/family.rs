//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::time::Duration;

use asphera_link::{Carries, Channel, DeviceClock, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::device::HELD_MS;
use crate::wire::TICK_NS;
use crate::{Extra, Optoncdt, Series, Settings};

/// Micro-Epsilon optoNCDT: `driver = "optoncdt"`, on a serial line or a terminal server.
pub const FAMILY: Family = Family {
    name: "optoncdt",
    carries: Carries::Bytes,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let series = table.required_word("series", &Series::ALL);
    let is_mastered = table.or("mastered", false);
    let range_mm = table.required("range_mm");
    let words: Vec<String> = table.or("extras", Vec::new());
    let extras: Vec<Option<Extra>> = words.iter().map(|word| extra(table, word)).collect();
    let extras: Option<Vec<Extra>> = extras.into_iter().collect();
    let triggered = table.or("triggered", false);
    // Between triggers a sensor is silent for any time.
    let silence_ms = table.or("silence_ms", if triggered { 0 } else { 2000 });
    let series = match (series?, is_mastered) {
        (Series::Plain, true) => Series::Mastered,
        (Series::Legacy, true) => {
            table.problem("mastered", "false: the ILD1700 masters within its range", "true");
            Series::Legacy
        }
        // The formula of the ILD1900 is the same with a master value.
        (series, _) => series,
    };
    Some(Settings { series, range_mm: range_mm?, extras: extras?, triggered, silence_ms })
}

fn extra(table: &Section<'_>, word: &str) -> Option<Extra> {
    let found = Extra::ALL.iter().find(|(known, _)| *known == word).map(|(_, extra)| *extra);
    if found.is_none() {
        let known: Vec<&str> = Extra::ALL.iter().map(|(word, _)| *word).collect();
        table.problem("extras", format!("words among {}", known.join(", ")), format!("{word:?}"));
    }
    found
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        if !self.extras.contains(&Extra::Counter) {
            Err("the counter is not among its extras")
        } else if !self.triggered {
            Err("triggered is not set: its counter counts measurements, not triggers")
        } else {
            Ok(1 << 18)
        }
    }

    fn holds_back(&self) -> Duration {
        Duration::from_millis(HELD_MS.into())
    }

    fn clock(&self) -> Option<DeviceClock> {
        let has_time = self.extras.contains(&Extra::Timestamp);
        has_time.then_some(DeviceClock { wraps_ns: Some(TICK_NS << 32), tick_ns: TICK_NS })
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Optoncdt::new(self.clone())?))
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
        let plain = settings("series = \"ild1420\"\nrange_mm = 10").unwrap();
        assert_eq!(plain.driver().unwrap().channels(), plain.channels());
        assert!(plain.count_cycle().unwrap_err().contains("counter"));
        let counting = settings(
            "series = \"ild1420\"\nrange_mm = 10\nmastered = true\nextras = [\"shutter\", \"counter\"]\ntriggered = true",
        );
        let counting = counting.unwrap();
        assert_eq!(counting.count_cycle(), Ok(262_144));
        let timed =
            "series = \"ild1420\"\nrange_mm = 10\nmastered = true\nextras = [\"timestamp\"]";
        let clock = settings(timed).unwrap().clock().unwrap();
        assert_eq!((counting.clock(), clock.tick_ns), (None, 10_000));
        // 32 bits of 10 µs: 11.9 hours.
        assert_eq!(clock.wraps_ns, Some(42_949_672_960_000));
        let names: Vec<_> = counting.channels().into_iter().map(|channel| channel.name).collect();
        assert_eq!(names, ["distance", "exposure"]);
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let told = |text: &str| -> Vec<(usize, String)> {
            let problems = settings(text).unwrap_err();
            problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
        };
        let named = |line, key: &str| (line, key.to_owned());
        assert_eq!(told("series = \"ild9\""), [named(1, "series"), named(1, "range_mm")]);
        let wrong = "series = \"ild1700\"\nrange_mm = 0\nextras = [\"counter\", \"counter\"]\nmastered = true";
        assert_eq!(
            told(wrong),
            [named(2, "range_mm"), named(3, "extras"), named(3, "extras"), named(4, "mastered")]
        );
        assert_eq!(
            told("series = \"ild1420\"\nrange_mm = 10\ntriggered = true\nextras = [\"speed\"]"),
            [named(4, "extras")]
        );
    }
}
