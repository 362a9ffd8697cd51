//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::time::Duration;

use asphera_link::{Carries, Channel, DeviceClock, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::{Chrocodile, Error, Settings, Trigger};

/// CHRocodile 2 and relatives: `driver = "chrocodile2"`, on a serial line or TCP.
pub const FAMILY: Family = Family {
    name: "chrocodile2",
    carries: Carries::Bytes,
    settings: |table| Some(Box::new(read(table))),
    propose: None,
};

fn read(table: &Section<'_>) -> Settings {
    let default = Settings::default();
    let triggers = [("each", Trigger::Each), ("free", Trigger::Free)];
    Settings {
        signals: table.or("signals", default.signals),
        sample_rate_hz: table.or("sample_rate_hz", default.sample_rate_hz),
        averaging: table.or("averaging", default.averaging),
        trigger: table.word("trigger", default.trigger, &triggers),
        scale_um: table.get("scale_um"),
        intensity_min: table.or("intensity_min", default.intensity_min),
        sync: default.sync,
        ready_timeout_ms: table.or("ready_timeout_ms", default.ready_timeout_ms),
        silence_ms: table.or("silence_ms", default.silence_ms),
    }
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        if !self.signals.contains(&EXPOSURE_COUNT) {
            Err("signal 75, the exposure count, is not among its signals")
        } else if self.averaging > 1 {
            Err("it averages several exposures")
        } else if self.trigger == Trigger::Free {
            Err("it runs free of the trigger")
        } else {
            Ok(1 << 16)
        }
    }

    fn holds_back(&self) -> Duration {
        Duration::from_millis(self.silence_ms.into())
    }

    fn clock(&self) -> Option<DeviceClock> {
        // Nanoseconds; where they begin again the driver goes on.
        self.signals.contains(&START_TIME).then(DeviceClock::default)
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        match Chrocodile::new(self.clone()) {
            Ok(driver) => Ok(Box::new(driver)),
            Err(Error::Settings(problems)) => Err(problems),
        }
    }
}

/// Signal of the exposure count (`SODX`).
const EXPOSURE_COUNT: u16 = 75;
/// Signal that is the time at which the exposure began.
const START_TIME: u16 = 64;

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("probe", text)
    }

    #[test]
    fn an_empty_table_gives_a_driver_that_counts_and_holds_back() {
        let settings = settings("").unwrap();
        assert_eq!((settings.count_cycle(), settings.bus_number()), (Ok(65_536), None));
        assert_eq!(settings.holds_back(), Duration::from_millis(50));
        assert_eq!(settings.clock(), None);
        let timed = self::settings("signals = [64, 256]").unwrap();
        assert_eq!(timed.clock(), Some(DeviceClock::default()));
        assert_eq!(settings.driver().unwrap().channels(), settings.channels());
    }

    #[test]
    fn every_mistake_is_told_with_its_line() {
        let problems =
            settings("signals = [75, 79]\naveraging = 0\ntriger = \"free\"").unwrap_err();
        let told: Vec<_> =
            problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
        assert_eq!(told, [(1, "signals[1]"), (1, "signals"), (2, "averaging"), (3, "triger")]);
    }

    #[test]
    fn what_keeps_it_from_counting_every_trigger_is_said() {
        let why = |text| settings(text).unwrap().count_cycle().unwrap_err();
        assert!(why("signals = [256]").starts_with("signal 75"));
        assert!(why("averaging = 4").contains("averages"));
        assert!(why("trigger = \"free\"").contains("runs free"));
    }
}
