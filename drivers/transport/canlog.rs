//! Logs of CAN frames, played line by line at their own pace.

use std::io;
use std::path::Path;
use std::time::Duration;

use asphera_cantext::candump::{MAX_LINE, time_of};
use tokio::fs::File;
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, BufReader};
use tokio::time::Instant;

use crate::OpenError;

/// A log that is being played.
pub(crate) struct CanLog {
    lines: BufReader<File>,
    pace: Pace,
    line: Vec<u8>,
    /// Whether the next bytes begin a line.
    at_begin: bool,
}

/// Moments at which lines are due.
struct Pace {
    begin: Instant,
    speed: f64,
    /// Time of the log from its first line on.
    elapsed: Duration,
    last_ns: Option<u64>,
}

impl CanLog {
    /// Opens a log, whose first line is due at once.
    pub(crate) async fn open(path: &Path, speed: f64) -> Result<CanLog, OpenError> {
        let failed = |source| OpenError::CanLog { path: path.display().to_string(), source };
        let file = File::open(path).await.map_err(failed)?;
        if file.metadata().await.map_err(failed)?.is_dir() {
            return Err(failed(io::ErrorKind::IsADirectory.into()));
        }
        let pace = Pace { begin: Instant::now(), speed, elapsed: Duration::ZERO, last_ns: None };
        Ok(CanLog {
            lines: BufReader::with_capacity(BUFFER_BYTES, file),
            pace,
            line: Vec::new(),
            at_begin: true,
        })
    }

    /// The next line and when it is due; `None` at the end. A longer line than any of a log comes in pieces. The last
    /// line gets the end that it may lack.
    pub(crate) async fn next(&mut self) -> io::Result<Option<(Vec<u8>, Instant)>> {
        self.line.clear();
        let mut piece = (&mut self.lines).take(MAX_LINE as u64);
        let count = piece.read_until(b'\n', &mut self.line).await?;
        if count == 0 && self.at_begin {
            return Ok(None);
        }
        let time_ns = if self.at_begin { time_of(&self.line) } else { None };
        if count < MAX_LINE && !self.line.ends_with(b"\n") {
            self.line.push(b'\n');
        }
        self.at_begin = self.line.ends_with(b"\n");
        Ok(Some((std::mem::take(&mut self.line), self.pace.due(time_ns))))
    }
}

impl Pace {
    /// When a line of that time is due. One without a time is due with the line above, and so is one whose time is
    /// earlier: another log begins there.
    fn due(&mut self, time_ns: Option<u64>) -> Instant {
        if let Some(time_ns) = time_ns {
            let last = self.last_ns.replace(time_ns).unwrap_or(time_ns);
            self.elapsed =
                self.elapsed.saturating_add(Duration::from_nanos(time_ns.saturating_sub(last)));
        }
        let wait = Duration::try_from_secs_f64(self.elapsed.as_secs_f64() / self.speed);
        // A log may say that nothing happened for longer than any clock goes.
        let wait = wait.unwrap_or(LONGEST_WAIT).min(LONGEST_WAIT);
        // Divided as a whole number at the speed of the log, so that its microseconds stay.
        let wait = if self.speed == 1.0 { self.elapsed.min(LONGEST_WAIT) } else { wait };
        self.begin + wait
    }
}

const BUFFER_BYTES: usize = 64 * 1024;
/// A century.
const LONGEST_WAIT: Duration = Duration::from_secs(100 * 365 * 86_400);

#[cfg(test)]
mod tests {
    use super::*;

    fn pace(speed: f64) -> Pace {
        Pace { begin: Instant::now(), speed, elapsed: Duration::ZERO, last_ns: None }
    }

    #[test]
    fn lines_are_due_as_the_log_has_them() {
        let mut pace = pace(1.0);
        let begin = pace.begin;
        let mut after = |time: Option<u64>| pace.due(time).duration_since(begin).as_nanos();
        let s = 1_436_509_052_249_713_000;
        assert_eq!(after(None), 0, "a line before the first time");
        assert_eq!(after(Some(s)), 0);
        assert_eq!(after(Some(s + 1_001_000)), 1_001_000);
        assert_eq!(after(None), 1_001_000);
        // A second log, of an earlier day.
        assert_eq!(after(Some(5)), 1_001_000);
        assert_eq!(after(Some(2_000_005)), 3_001_000);
    }

    #[test]
    fn speed_is_a_factor_and_nothing_overflows() {
        let mut fast = pace(4.0);
        let begin = fast.begin;
        fast.due(Some(0));
        assert_eq!(fast.due(Some(8_000_000_000)).duration_since(begin), Duration::from_secs(2));
        let mut slow = pace(0.01);
        slow.due(Some(0));
        assert_eq!(slow.due(Some(u64::MAX)).duration_since(slow.begin), LONGEST_WAIT);
    }
}
