//! Settings of the driver.

use asphera_link::{Channel, Problem, Unit, check_range};

/// A scanner as it was set up and saved.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Serial number; another scanner is found out by it. `None`: the first one heard on a connection.
    pub serial: Option<u32>,
    /// Silence after which the link is opened anew, 10 to 3 600 000 ms; 0: never.
    pub silence_ms: u32,
    /// Time a profile waits for those before it that are on their way still, 0 to 1000 ms.
    pub reorder_ms: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { serial: None, silence_ms: 0, reorder_ms: 20 }
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`crate::Rf627::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        if self.silence_ms != 0 {
            check_range(&mut problems, "silence_ms", self.silence_ms, 10, 3_600_000);
        }
        check_range(&mut problems, "reorder_ms", self.reorder_ms, 0, 1000);
        problems
    }

    /// Channels beside the profile: `step`, the count of encoder or steps; `exposure`; `valid`, how many points of the
    /// profile have a value.
    pub fn channels(&self) -> Vec<Channel> {
        vec![
            Channel::new("step", Unit::Count),
            Channel::new("exposure", Unit::Second),
            Channel::new("valid", Unit::One),
        ]
    }
}
