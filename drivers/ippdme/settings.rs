//! Settings of the driver: the program, and what its points need.

use asphera_link::{Channel, Problem, Unit, check_range};

use crate::wire::Call;

/// A coordinate measuring machine and the program it runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Commands of the program in their order, without tags.
    pub commands: Vec<String>,
    /// Largest `Q` of a good point, 0 (good) to 100 (bad). `None`: `Q` is not asked for.
    pub quality_limit: Option<f64>,
    /// Time until a command is acknowledged, 10 to 60 000 ms.
    pub timeout_ms: u32,
    /// Time without any answer in which a command may be at work, 1 to 86 400 s.
    pub silence_s: u32,
}

impl Settings {
    /// Everything that cannot be used.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        if self.commands.is_empty() {
            let expected = "the commands of the program, as \"PtMeas(X(1), Y(2), Z(3))\"";
            problems.push(Problem::new("commands", expected, "nothing"));
        }
        let mut measures = false;
        for (index, command) in self.commands.iter().enumerate() {
            match check(command) {
                Ok(call) => measures |= is_measuring(&call.name),
                Err(expected) => {
                    let found = format!("{command:?}");
                    problems.push(Problem::new(format!("commands[{index}]"), expected, found));
                }
            }
        }
        if problems.is_empty() && !measures {
            let expected = "a command that measures: PtMeas or a scan";
            problems.push(Problem::new("commands", expected, "none"));
        }
        if let Some(limit) = self.quality_limit {
            check_range(&mut problems, "quality_limit", limit, 0.0, 100.0);
        }
        check_range(&mut problems, "timeout_ms", self.timeout_ms, 10, 60_000);
        check_range(&mut problems, "silence_s", self.silence_s, 1, 86_400);
        problems
    }

    /// Channels of the readings: x, y and z in mm, and q where there is a limit for it.
    pub fn channels(&self) -> Vec<Channel> {
        let place = |name| Channel::new(name, Unit::Millimetre);
        let quality = self.quality_limit.map(|_| Channel::new("q", Unit::One));
        ["x", "y", "z"].into_iter().map(place).chain(quality).collect()
    }

    /// Columns of a point, in the order in which they are asked for: that of the alphabet. Some servers sort them, whatever was asked.
    pub(crate) fn columns(&self) -> &'static [&'static str] {
        if self.quality_limit.is_some() { &["Q", "X", "Y", "Z"] } else { &["X", "Y", "Z"] }
    }
}

/// The command, or what would do.
fn check(command: &str) -> Result<Call, String> {
    if !command.bytes().all(|byte| (32..=126).contains(&byte)) || command.len() > LONGEST {
        return Err(format!("at most {LONGEST} characters of plain ASCII"));
    }
    let call = Call::parse(command).map_err(|error| error.to_string())?;
    match call.name.as_str() {
        "StartSession" | "EndSession" | "ClearAllErrors" => {
            Err("no such command: the driver begins and ends the session".to_owned())
        }
        "OnPtMeasReport" | "OnScanReport" => {
            Err("no such command: the driver asks for the columns it reads".to_owned())
        }
        "AbortE" | "GetErrStatusE" | "GetPropE" | "OnMoveReportE" => {
            Err("a command that waits for its turn, none whose name ends with E".to_owned())
        }
        _ => Ok(call),
    }
}

/// Whether data of a command are measured points.
pub(crate) fn is_measuring(name: &str) -> bool {
    name == "PtMeas" || is_scan(name)
}

/// Whether a command is a scan, whose data are bare numbers.
pub(crate) fn is_scan(name: &str) -> bool {
    name.starts_with("Scan") && !name.ends_with("Hint") && !name.ends_with("Density")
}

/// Most characters of a command: with its tag it is a line.
const LONGEST: usize = 65_530;
