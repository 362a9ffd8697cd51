//! Waiting for real programs: one rule of time, and an error that says what was seen last.

use std::fmt::Display;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::http;

/// Time between two questions.
const PAUSE: Duration = Duration::from_millis(20);

/// Parts of a snapshot that an error shows.
const SHOWN: [&str; 9] =
    ["state", "session", "points", "progress", "scan", "links", "mesh", "verdict", "outputs"];

/// The time, for tests that wait for real programs.
#[expect(clippy::disallowed_methods, reason = "tests wait for real programs")]
pub fn now() -> Instant {
    Instant::now()
}

pub(crate) fn deadline(limit: Duration) -> Instant {
    now() + limit
}

/// Asks again and again until there is an answer; else what was found in its place. Fails with the last of these once `limit` has
/// passed, and asks once more then.
pub fn wait_for<T, E: Display>(
    what: &str,
    limit: Duration,
    mut ask: impl FnMut() -> Result<T, E>,
) -> T {
    let until = deadline(limit);
    loop {
        let is_last = now() >= until;
        match ask() {
            Ok(found) => return found,
            Err(seen) if is_last => panic!("no {what} within {limit:?}; seen last: {seen:#}"),
            Err(_) => std::thread::park_timeout(PAUSE),
        }
    }
}

/// The snapshot of the station at an address.
pub fn snapshot(address: &str) -> Value {
    let (status, body) = http(address, "GET", "/api/v1/snapshot", &[]);
    assert_eq!(status, 200, "{}", String::from_utf8_lossy(&body));
    serde_json::from_slice(&body).expect("a snapshot is JSON")
}

/// The first snapshot of the station at an address of which something holds.
pub fn until(
    address: &str,
    what: &str,
    limit: Duration,
    mut holds: impl FnMut(&Value) -> bool,
) -> Value {
    wait_for(what, limit, || {
        let snapshot = snapshot(address);
        if holds(&snapshot) { Ok(snapshot) } else { Err(shown(&snapshot)) }
    })
}

fn shown(snapshot: &Value) -> Value {
    SHOWN.iter().map(|&key| (key.to_owned(), snapshot[key].clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_ends_the_waiting() {
        let mut asked = 0;
        let third = wait_for("third answer", Duration::from_secs(60), || {
            asked += 1;
            if asked == 3 { Ok(asked) } else { Err(asked) }
        });
        assert_eq!(third, 3);
    }

    #[test]
    #[should_panic(expected = "no end within 30ms; seen last: still at work")]
    fn what_was_seen_last_is_in_the_error() {
        wait_for("end", Duration::from_millis(30), || Err::<(), _>("still at work"));
    }
}
