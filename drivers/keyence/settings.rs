//! Settings of the driver.

use asphera_link::{Channel, Problem, Unit, check_range};

use crate::wire::Series;

/// A controller as its active program sets it up: range, trigger, encoder, X pitch.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Series of the controller.
    pub series: Series,
    /// Serial number of the controller; another one is refused. `None`: any.
    pub serial: Option<String>,
    /// Whether the driver starts a batch, and ends it: for programs with batch measurement.
    pub batch: bool,
    /// Time within which an answer must come, 10 to 60 000 ms.
    pub answer_ms: u32,
    /// Time from one question for errors to the next, 100 to 600 000 ms; 0: never. `None`: 1000 for LJ-X8000, never for
    /// LJ-V7000.
    pub watch_ms: Option<u32>,
    /// Silence of the stream after which the link is opened anew, 10 to 3 600 000 ms; 0: never.
    pub silence_ms: u32,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            series: Series::LjX8000,
            serial: None,
            batch: false,
            answer_ms: 1000,
            watch_ms: None,
            silence_ms: 0,
        }
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`crate::Profiler::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_range(&mut problems, "answer_ms", self.answer_ms, 10, 60_000);
        if let Some(watch_ms @ 1..) = self.watch_ms {
            check_range(&mut problems, "watch_ms", watch_ms, 100, 600_000);
        }
        if self.silence_ms != 0 {
            check_range(&mut problems, "silence_ms", self.silence_ms, 10, 3_600_000);
        }
        if self.series == Series::LjV7000 {
            let unknown = |key, expected: &str, found: &str| {
                let expected = format!(
                    "{expected} with series = \"lj-v7000\", whose command for it is not known"
                );
                Problem::new(key, expected, found)
            };
            if self.batch {
                problems.push(unknown("batch", "false", "true"));
            }
            if let Some(watch_ms @ 1..) = self.watch_ms {
                problems.push(unknown("watch_ms", "0", &watch_ms.to_string()));
            }
            if let Some(serial) = &self.serial {
                problems.push(unknown("serial", "no key", serial));
            }
        }
        problems
    }

    /// Channels beside the profile: `encoder`, the count of the encoder; `valid`, how many points have a height; then how
    /// many have none, by its reason.
    pub fn channels(&self) -> Vec<Channel> {
        let mut channels = vec![Channel::new("encoder", Unit::Count)];
        let counts = ["valid", "no_peak", "masked", "dead_zone", "unprocessed"];
        channels.extend(counts.map(|name| Channel::new(name, Unit::One)));
        channels
    }

    /// Time from one question for errors to the next, ms; 0: never.
    pub(crate) fn watch(&self) -> u32 {
        self.watch_ms.unwrap_or(match self.series {
            Series::LjX8000 => 1000,
            Series::LjV7000 => 0,
        })
    }
}
