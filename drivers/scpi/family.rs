//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use asphera_described::{Described, Pattern};
use asphera_link::{Carries, Channel, DeviceSettings, Driver, Family, Problem, Unit};
use asphera_settings::Section;

use crate::settings::{Settings, Terminator, Value};

/// Instruments with SCPI: `driver = "scpi"`, on a serial line or TCP.
pub const FAMILY: Family = Family {
    name: "scpi",
    carries: Carries::Bytes,
    settings: |table| read(table).map(|settings| Box::new(settings) as _),
    propose: None,
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let identity: Option<String> = table.required("identity");
    let identity = identity.and_then(|text| {
        let wrong = |error| table.problem("identity", "a regular expression", error);
        Pattern::new(&text).map_err(wrong).ok()
    });
    let query = table.required("query");
    let values = table.array("field");
    if values.is_empty() {
        table.problem("field", "a table [[field]] for each number", "nothing");
    }
    let values: Vec<Option<Value>> = values.iter().map(value).collect();
    let values: Option<Vec<Value>> = values.into_iter().collect();
    let timeout_ms: u32 = table.or("timeout_ms", 2000);
    let settings = Settings {
        identity: identity.clone().unwrap_or(Pattern::new("").ok()?),
        query: String::new(),
        values: Vec::new(),
        columns: table.get("columns"),
        setup: table.or("setup", Vec::new()),
        terminator: table.word("terminator", Terminator::default(), &Terminator::ALL),
        reads_errors: table.or("errors", true),
        interval_ms: table.or("interval_ms", 200),
        timeout_ms,
        late_limit_ms: table.or("late_limit_ms", timeout_ms.saturating_mul(2).min(600_000)),
    };
    let (identity, query, values) = (identity?, query?, values?);
    (!values.is_empty()).then_some(Settings { identity, query, values, ..settings })
}

fn value(table: &Section<'_>) -> Option<Value> {
    let units: Vec<(&str, Unit)> = Unit::ALL.iter().map(|unit| (unit.symbol(), *unit)).collect();
    let name = table.required("name");
    let value = Value {
        name: String::new(),
        column: table.or("column", 1),
        scale: table.or("scale", 1.0),
        offset: table.or("offset", 0.0),
        unit: table.word("unit", Unit::One, &units),
        valid_range: table.range("valid_range"),
    };
    table.finish();
    Some(Value { name: name?, ..value })
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
        Ok(Box::new(Described::new(described)?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("meter", text)
    }

    fn wrong(text: &str) -> Vec<(usize, String)> {
        let problems = settings(text).unwrap_err();
        problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
    }

    #[test]
    fn a_meter_gives_a_driver() {
        let text = "identity = 'FLUKE,.*'\nquery = 'FETC? 1'\nsetup = ['UNIT:TEMP C']\nterminator = 'cr'\n\
                    [[field]]\nname = 't'\nunit = 'degC'\nvalid_range = [-100, 500]";
        let meter = settings(text).unwrap();
        assert_eq!(meter.channels(), [Channel::new("t", Unit::DegreeCelsius)]);
        assert_eq!(meter.driver().unwrap().channels(), meter.channels());
        assert!(meter.count_cycle().is_err());
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let named = |line, key: &str| (line, key.to_owned());
        assert_eq!(wrong(""), ["identity", "query", "field"].map(|key| named(1, key)));
        let text = "identity = 'FLUKE,('\nquery = \"FETC? 1\\n\"\nsetup = ['*TST?']\ntimeout_ms = 0\ninterval = 3\n\
                    [[field]]\nname = 't'\nscale = 0";
        assert_eq!(wrong(text), [named(1, "identity"), named(5, "interval")]);
        let text = text.replace("FLUKE,(", "FLUKE,.*").replace("\ninterval = 3", "");
        let keys = ["query", "setup", "timeout_ms", "field[0].scale"];
        let lines = [2, 3, 4, 7];
        assert_eq!(
            wrong(&text),
            lines.into_iter().zip(keys).map(|(l, k)| named(l, k)).collect::<Vec<_>>()
        );
    }
}
