//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use asphera_link::{Carries, Channel, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::device::Ippdme;
use crate::settings::Settings;

/// Coordinate measuring machines: `driver = "ippdme"`, on a TCP link.
pub const FAMILY: Family = Family {
    name: "ippdme",
    carries: Carries::Bytes,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let commands = table.required("commands");
    let settings = Settings {
        commands: Vec::new(),
        quality_limit: table.get("quality_limit"),
        timeout_ms: table.or("timeout_ms", 5000),
        silence_s: table.or("silence_s", 300),
    };
    Some(Settings { commands: commands?, ..settings })
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Ippdme::new(self.clone())?))
    }

    fn runs_program(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(text: &str) -> Vec<String> {
        let problems = FAMILY.parse("cmm", text).unwrap_err();
        problems.0.into_iter().map(|problem| format!("{}: {}", problem.line, problem.key)).collect()
    }

    #[test]
    fn a_program_gives_a_driver() {
        let text =
            "commands = ['Home()', 'PtMeas(X(1), Y(2), Z(3), IJK(0,0,1))']\nquality_limit = 20";
        let settings = FAMILY.parse("cmm", text).unwrap();
        let names: Vec<_> = settings.channels().into_iter().map(|channel| channel.name).collect();
        assert_eq!(names, ["x", "y", "z", "q"]);
        assert_eq!(settings.driver().unwrap().channels(), settings.channels());
        assert!(settings.runs_program() && !settings.moves_axes());
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        assert_eq!(wrong("timeout_ms = 1"), ["1: commands",]);
        assert_eq!(wrong("commands = []"), ["1: commands"]);
        assert_eq!(wrong("commands = ['Home()', 'ScanOnLineHint(1, 2)']"), ["1: commands"]);
        let text = "commands = ['PtMeas(X(1))', 'GoTo(X(1)', 'AbortE()', 'OnScanReport(X())', 'EndSession()', 'A(\"µ\")']\n\
                    quality_limit = 101\ntimeout_ms = 1\nsilence_s = 0\nradius = 1";
        let keys = [
            "1: commands[1]",
            "1: commands[2]",
            "1: commands[3]",
            "1: commands[4]",
            "1: commands[5]",
            "2: quality_limit",
            "3: timeout_ms",
            "4: silence_s",
            "5: radius",
        ];
        let mut found = wrong(text);
        found.sort();
        assert_eq!(found, keys);
    }
}
