//! A configuration whose simulated devices may be silent: after its last trigger a scan is over, and nothing is sent any more.

use toml_edit::{DocumentMut, Item, TableLike, value};

/// Drivers that watch by `silence_ms` whether a device still sends by itself.
const WATCH_SILENCE: [&str; 3] = ["keyence-lj", "optoncdt", "rf627"];

/// Lets every device be silent for any time. The keys that were changed, each with its device.
pub(super) fn allow_silence(document: &mut DocumentMut) -> Vec<String> {
    let mut changed = Vec::new();
    let devices = document.get_mut("device").and_then(Item::as_table_like_mut);
    for (name, device) in devices.into_iter().flat_map(TableLike::iter_mut) {
        let Some(device) = device.as_table_like_mut() else { continue };
        let driver = device.get("driver").and_then(Item::as_str).unwrap_or_default().to_owned();
        let Some(settings) = device.get_mut("settings").and_then(Item::as_table_like_mut) else {
            continue;
        };
        if driver == "described" && settings.remove("gap_ms").is_some() {
            changed.push(format!("gap_ms of {name}"));
        }
        if WATCH_SILENCE.contains(&&*driver) && watches(settings, &driver) {
            settings.insert("silence_ms", value(0));
            changed.push(format!("silence_ms of {name}"));
        }
    }
    changed
}

/// Whether settings watch for silence, as they are or by default: a sensor that runs free does.
fn watches(settings: &dyn TableLike, driver: &str) -> bool {
    let is_triggered = settings.get("triggered").and_then(Item::as_bool).unwrap_or(false);
    match settings.get("silence_ms").and_then(Item::as_integer) {
        Some(silence_ms) => silence_ms != 0,
        None => driver == "optoncdt" && !is_triggered,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_watches_is_changed() {
        let text = "[device.a]\ndriver = \"described\"\n[device.a.settings]\ngap_ms = 500\nsilence_ms = 20\n\
                    [device.b]\ndriver = \"optoncdt\"\n[device.b.settings]\nrange_mm = 10\n\
                    [device.c]\ndriver = \"optoncdt\"\n[device.c.settings]\ntriggered = true\n\
                    [device.d]\ndriver = \"rf627\"\nsettings = { silence_ms = 300 }\n\
                    [device.e]\ndriver = \"rf627\"\n";
        let mut document: DocumentMut = text.parse().expect("TOML");
        let changed = allow_silence(&mut document);
        assert_eq!(changed, ["gap_ms of a", "silence_ms of b", "silence_ms of d"]);
        let device = |name: &str| document["device"][name]["settings"].clone();
        assert!(device("a").get("gap_ms").is_none());
        assert_eq!(device("a")["silence_ms"].as_integer(), Some(20), "another thing there");
        assert_eq!(device("b")["silence_ms"].as_integer(), Some(0));
        assert!(device("c").get("silence_ms").is_none());
        assert_eq!(device("d")["silence_ms"].as_integer(), Some(0));
    }
}
