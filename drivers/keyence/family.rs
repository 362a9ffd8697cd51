//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use asphera_link::{Carries, Channel, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::device::COUNTS;
use crate::wire::Series;
use crate::{Profiler, Settings};

/// Keyence LJ-X8000 and LJ-V7000: `driver = "keyence-lj"`, on a link of two TCP connections.
pub const FAMILY: Family = Family {
    name: "keyence-lj",
    carries: Carries::TwoStreams,
    settings: |table| Some(Box::new(read(table))),
    propose: None,
};

fn read(table: &Section<'_>) -> Settings {
    let default = Settings::default();
    let series = [("lj-x8000", Series::LjX8000), ("lj-v7000", Series::LjV7000)];
    Settings {
        series: table.word("series", default.series, &series),
        serial: table.get("serial"),
        batch: table.or("batch", default.batch),
        answer_ms: table.or("answer_ms", default.answer_ms),
        watch_ms: table.get("watch_ms"),
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

    fn measures_profiles(&self) -> bool {
        true
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        Ok(COUNTS)
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Profiler::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("profiler", text)
    }

    #[test]
    fn a_described_controller_gives_a_driver() {
        for text in [
            "",
            "serial = \"1A230004\"\nbatch = true\nwatch_ms = 0\nsilence_ms = 500",
            "series = \"lj-v7000\"\nanswer_ms = 100\nwatch_ms = 0",
        ] {
            let profiler = settings(text).unwrap();
            assert_eq!(profiler.driver().unwrap().channels(), profiler.channels());
            assert!(profiler.measures_profiles());
            assert_eq!(profiler.count_cycle(), Ok(1 << 31));
        }
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let named = |text: &str| {
            let problems = settings(text).unwrap_err();
            let lines = problems.0.iter().map(|problem| (problem.line, problem.key.clone()));
            lines.collect::<Vec<_>>()
        };
        let found =
            named("series = \"lj-x\"\nanswer_ms = 5\nwatch_ms = 9\nsilence_ms = 5\nport = 1");
        let keys = ["series", "answer_ms", "watch_ms", "silence_ms", "port"];
        assert_eq!(found, (1..).zip(keys.map(str::to_owned)).collect::<Vec<_>>());
        let found = named("series = \"lj-v7000\"\nbatch = true\nwatch_ms = 1000\nserial = \"1\"");
        let keys = ["batch", "watch_ms", "serial"];
        assert_eq!(found, (2..).zip(keys.map(str::to_owned)).collect::<Vec<_>>());
    }
}
