//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use asphera_described::Described;
use asphera_link::{Carries, Channel, DeviceSettings, Driver, Family, Problem};
use asphera_settings::Section;

use crate::settings::{Axis, Microstep, Settings};
use crate::stage::Stage;

/// Zaber stages: `driver = "zaber"`, on a serial line or a terminal server.
pub const FAMILY: Family = Family {
    name: "zaber",
    carries: Carries::Bytes,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let axes = table.array("axis");
    if axes.is_empty() {
        table.problem("axis", "a table [[axis]] for each position", "nothing");
    }
    let axes: Vec<Option<Axis>> = axes.iter().map(axis).collect();
    let axes: Option<Vec<Axis>> = axes.into_iter().collect();
    let timeout_ms: u32 = table.or("timeout_ms", 200);
    let settings = Settings {
        address: table.or("address", 1),
        axis: table.or("number", 0),
        axes: Vec::new(),
        checksum: table.or("checksum", false),
        interval_ms: table.or("interval_ms", 20),
        timeout_ms,
        late_limit_ms: table.or("late_limit_ms", timeout_ms.saturating_mul(2).min(600_000)),
    };
    let axes = axes.filter(|axes| !axes.is_empty())?;
    Some(Settings { axes, ..settings })
}

fn axis(table: &Section<'_>) -> Option<Axis> {
    let name = table.required("name");
    let (um, deg) = (table.get("microstep_um"), table.get("microstep_deg"));
    table.finish();
    let microstep = match (um, deg) {
        (Some(um), None) => Some(Microstep::Micrometres(um)),
        (None, Some(deg)) => Some(Microstep::Degrees(deg)),
        (um, _) => {
            let found = if um.is_some() { "both" } else { "nothing" };
            table.problem("microstep_um", "one of `microstep_um` and `microstep_deg`", found);
            None
        }
    };
    Some(Axis { name: name?, microstep: microstep? })
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        let problems = Settings::problems(self);
        let described = self.description().ok().filter(|_| problems.is_empty()).ok_or(problems)?;
        Ok(Box::new(Stage::new(Described::new(described)?, self)))
    }

    fn moves_axes(&self) -> bool {
        true
    }

    fn homes(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use asphera_link::Unit;
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("stage", text)
    }

    fn wrong(text: &str) -> Vec<(usize, String)> {
        let problems = settings(text).unwrap_err();
        problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
    }

    #[test]
    fn a_stage_gives_a_driver() {
        let text = "address = 2\nchecksum = true\n[[axis]]\nname = 'x'\nmicrostep_um = 0.15625\n\
                    [[axis]]\nname = 'phi'\nmicrostep_deg = 0.01";
        let stage = settings(text).unwrap();
        let channels = [Channel::new("x", Unit::Millimetre), Channel::new("phi", Unit::Radian)];
        assert_eq!(stage.channels(), channels);
        assert_eq!(stage.driver().unwrap().channels(), channels);
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let named = |line, key: &str| (line, key.to_owned());
        assert_eq!(wrong("adress = 1"), [named(1, "axis"), named(1, "adress")]);
        let text = "address = 100\nnumber = 1\n[[axis]]\nname = 'x'\nmicrostep_um = 0\n\
                    [[axis]]\nname = 'y'\nmicrostep_um = 1";
        let keys = [named(1, "address"), named(3, "axis"), named(5, "axis[0].microstep_um")];
        assert_eq!(wrong(text), keys);
        assert_eq!(wrong("[[axis]]\nname = 'x'"), [named(1, "axis[0].microstep_um")]);
        let text = "timeout_ms = 0\n[[axis]]\nname = 'x'\nmicrostep_um = 1\n[[axis]]\nname = 'x'\nmicrostep_um = 1";
        assert_eq!(wrong(text), [named(1, "timeout_ms"), named(6, "axis[1].name")]);
    }
}
