//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::time::Duration;

use asphera_link::{Carries, Channel, DeviceClock, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::{Chrocodile, Error, PacketChrocodile, PacketSettings, Settings, Trigger};

/// CHRocodile 2 and relatives: `driver = "chrocodile2"`, on a serial line or TCP. The key `protocol` chooses how the device
/// is spoken to.
pub const FAMILY: Family = Family {
    name: "chrocodile2",
    carries: Carries::Bytes,
    settings: |table| {
        let protocols = [("dollar", Protocol::Dollar), ("packets", Protocol::Packets)];
        Some(match table.word("protocol", Protocol::Dollar, &protocols) {
            Protocol::Dollar => Box::new(read(table)),
            Protocol::Packets => Box::new(read_packets(table)),
        })
    },
    propose: None,
};

#[derive(Clone, Copy)]
enum Protocol {
    /// Text and telegrams, on a serial line or TCP port 7890.
    Dollar,
    /// Packets, on TCP port 7891.
    Packets,
}

const TRIGGERS: [(&str, Trigger); 2] = [("each", Trigger::Each), ("free", Trigger::Free)];

fn read_packets(table: &Section<'_>) -> PacketSettings {
    let default = PacketSettings::default();
    PacketSettings {
        signals: table.or("signals", default.signals),
        sample_rate_hz: table.or("sample_rate_hz", default.sample_rate_hz),
        averaging: table.or("averaging", default.averaging),
        trigger: table.word("trigger", default.trigger, &TRIGGERS),
        scale_um: table.get("scale_um"),
        intensity_min: table.or("intensity_min", default.intensity_min),
        point: table.or("point", default.point),
        pitch_um: table.get("pitch_um"),
        ready_timeout_ms: table.or("ready_timeout_ms", default.ready_timeout_ms),
    }
}

fn read(table: &Section<'_>) -> Settings {
    let default = Settings::default();
    Settings {
        signals: table.or("signals", default.signals),
        sample_rate_hz: table.or("sample_rate_hz", default.sample_rate_hz),
        averaging: table.or("averaging", default.averaging),
        trigger: table.word("trigger", default.trigger, &TRIGGERS),
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
        count_cycle(&self.signals, self.averaging, self.trigger)
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

impl DeviceSettings for PacketSettings {
    fn problems(&self) -> Vec<Problem> {
        PacketSettings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        PacketSettings::channels(self)
    }

    fn measures_profiles(&self) -> bool {
        self.pitch_um.is_some()
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        count_cycle(&self.signals, self.averaging, self.trigger)
    }

    fn clock(&self) -> Option<DeviceClock> {
        // The time of packets has 32 bits of seconds.
        (self.signals.contains(&START_TIME) || self.times_samples()).then(DeviceClock::default)
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        match PacketChrocodile::new(self.clone()) {
            Ok(driver) => Ok(Box::new(driver)),
            Err(Error::Settings(problems)) => Err(problems),
        }
    }
}

/// How many numbers the exposure count has, where each trigger gives one.
fn count_cycle(signals: &[u16], averaging: u16, trigger: Trigger) -> Result<u32, &'static str> {
    if !signals.contains(&EXPOSURE_COUNT) {
        Err("signal 75, the exposure count, is not among its signals")
    } else if averaging > 1 {
        Err("it averages several exposures")
    } else if trigger == Trigger::Free {
        Err("it runs free of the trigger")
    } else {
        Ok(1 << 16)
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

    #[test]
    fn packets_are_chosen_by_a_word() {
        let packets = settings("protocol = \"packets\"").unwrap();
        assert_eq!((packets.count_cycle(), packets.clock()), (Ok(65_536), None));
        assert_eq!((packets.holds_back(), packets.measures_profiles()), (Duration::ZERO, false));
        assert_eq!(packets.driver().unwrap().channels(), packets.channels());
        let free = settings("protocol = \"packets\"\ntrigger = \"free\"").unwrap();
        assert_eq!(free.clock(), Some(DeviceClock::default()));
        let line = settings("protocol = \"packets\"\npitch_um = 5").unwrap();
        assert!(line.measures_profiles());
        assert_eq!(line.driver().unwrap().channels(), line.channels());
    }

    #[test]
    fn keys_belong_to_their_protocol() {
        let problems =
            settings("protocol = \"packets\"\nsilence_ms = 5\npoint = 0\nsignals = [79]");
        let problems = problems.unwrap_err();
        let named: Vec<_> =
            problems.0.iter().map(|found| (found.line, found.key.as_str())).collect();
        assert_eq!(named, [(2, "silence_ms"), (3, "point"), (4, "signals[0]"), (4, "signals")]);
        assert!(settings("pitch_um = 5").is_err() && settings("protocol = \"can\"").is_err());
    }
}
