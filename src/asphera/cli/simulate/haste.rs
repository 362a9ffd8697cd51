//! A configuration for links that are played as fast as they are taken: when bytes arrive tells nothing, and one link may be far ahead.

use toml_edit::{DocumentMut, Item, value};

use super::super::Speed;
use super::super::output::Failure;
use super::super::usage::misused;
use crate::config::Config;

/// Refuses another speed than that of the recording for devices that are joined by time.
pub(super) fn refuse_haste(config: &Config, speed: Speed) -> Result<(), Failure> {
    if config.sync.time.is_none() || speed == Speed::Times(1.0) {
        return Ok(());
    }
    let found = match speed {
        Speed::Max => "max".to_owned(),
        Speed::Times(times) => times.to_string(),
    };
    Err(misused(format!(
        "--speed: expected 1, found {found}: devices are joined by time, so bytes must come when they came. Leave --speed out, or use asphera \
         replay"
    )))
}

/// Lets readings of one link wait for those of another however far it is ahead, and a silence pass. The keys that were changed.
pub(super) fn allow_haste(document: &mut DocumentMut) -> Vec<&'static str> {
    let mut changed = Vec::new();
    let sync = document.get_mut("sync").and_then(Item::as_table_like_mut);
    if let Some(sync) = sync {
        sync.insert("paced", value(false));
        sync.insert("wait_ms", value(WAIT_MS));
        sync.insert("capacity", value(CAPACITY));
        changed.extend(["sync.paced", "sync.wait_ms", "sync.capacity"]);
    }
    let scan = document.get_mut("scan").and_then(Item::as_table_like_mut);
    // A scan without a number of points ends by its silence.
    if let Some(scan) = scan.filter(|scan| scan.contains_key("points")) {
        let number = |item: &Item| item.as_float().or(item.as_integer().map(|whole| whole as f64));
        if scan.get("idle_s").and_then(number).is_none_or(|idle_s| idle_s < IDLE_S) {
            scan.insert("idle_s", value(IDLE_S));
            changed.push("scan.idle_s");
        }
    }
    changed
}

/// The most that a station takes.
const WAIT_MS: i64 = 600_000;
const CAPACITY: i64 = 10_000_000;
/// Longer than a busy computer lets a program wait.
const IDLE_S: f64 = 30.0;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn hasty(text: &str) -> (Vec<&'static str>, DocumentMut) {
        let mut document: DocumentMut = text.parse().expect("TOML");
        (allow_haste(&mut document), document)
    }

    #[test]
    fn readings_wait_for_a_slower_link() {
        let text =
            "[sync]\ndevices = [\"a\", \"b\"]\nwait_ms = 50\n[scan]\npoints = 9\nidle_s = 3\n";
        let (changed, document) = hasty(text);
        assert_eq!(changed, ["sync.paced", "sync.wait_ms", "sync.capacity", "scan.idle_s"]);
        assert_eq!(document["sync"]["paced"].as_bool(), Some(false));
        assert_eq!(document["sync"]["wait_ms"].as_integer(), Some(600_000));
        assert_eq!(document["sync"]["capacity"].as_integer(), Some(10_000_000));
        assert_eq!(document["scan"]["idle_s"].as_float(), Some(30.0));
    }

    #[test]
    fn a_scan_that_ends_by_silence_keeps_its_end() {
        let (changed, document) = hasty("[scan]\nidle_s = 3.0\n");
        assert!(changed.is_empty());
        assert_eq!(document["scan"]["idle_s"].as_float(), Some(3.0));
    }

    /// It never ended: devices missed their telegrams, and were played again and again.
    #[test]
    fn devices_that_are_joined_by_time_have_their_own_pace() {
        let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/examples");
        let load = |name: &str| Config::load(&examples.join(name)).expect("an example");
        let by_time = load("laser-sensor-by-time.toml");
        assert!(refuse_haste(&by_time, Speed::Times(1.0)).is_ok());
        for (speed, word) in [(Speed::Max, "max"), (Speed::Times(10.0), "10")] {
            let error = refuse_haste(&by_time, speed).expect_err("refused").to_string();
            assert!(
                error.contains(&format!("found {word}: devices are joined by time")),
                "{error}"
            );
            assert!(refuse_haste(&load("om30-line.toml"), speed).is_ok());
        }
    }
}
