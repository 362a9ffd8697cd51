//! The laws of the fuzz targets `can`, `drivers`, `toml` and `http` over all inputs that are kept, and over changes of them: they stay alive
//! without a fuzzer.

use std::fs;
use std::panic::{RefUnwindSafe, catch_unwind};
use std::path::Path;

#[path = "../../fuzz/src/can.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod can;
#[path = "../../fuzz/src/drivers.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod drivers;
#[path = "../../fuzz/src/http.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod http;
#[path = "../../fuzz/src/toml.rs"]
#[expect(unreachable_pub, reason = "public in the crate of the fuzz targets")]
mod toml;

/// Holds a law over the seeds of a target with `changes` changes of each, and over its corpus, if there is one, with a tenth
/// as many.
fn hold(target: &str, changes: u64, law: impl Fn(&[u8]) + RefUnwindSafe) {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let mut held = 0;
    for (kind, changes) in [("seeds", changes), ("corpus", changes / 10)] {
        let Ok(inputs) = fs::read_dir(fuzz.join(kind).join(target)) else { continue };
        for input in inputs {
            let path = input.expect("a folder that can be listed").path();
            let bytes = fs::read(&path).expect("an input can be read");
            for change in 0..=changes {
                let changed = changed(&bytes, change);
                // A law that breaks says what it found; the input is told by a panic of its own.
                let outcome = catch_unwind(|| law(&changed));
                assert!(
                    outcome.is_ok(),
                    "{}, change {change}: {}",
                    path.display(),
                    changed.escape_ascii()
                );
            }
            held += 1;
        }
    }
    assert!(held >= 20, "{held} inputs of {target}");
}

/// An input with some bytes replaced, taken out, doubled or cut off; as it is for change 0.
fn changed(bytes: &[u8], change: u64) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mut state = change;
    // Knuth's MMIX generator.
    let mut draw = |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below.max(1)
    };
    for _ in 0..change.min(1) * (1 + change % 3) {
        let at = draw(bytes.len());
        match draw(5) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..bytes.len().min(at + 1 + draw(8)))),
            2 => {
                let piece = bytes[at..bytes.len().min(at + 1 + draw(40))].to_vec();
                drop(bytes.splice(at..at, piece));
            }
            3 => drop(bytes.splice(at..at, WORDS[draw(WORDS.len())].bytes())),
            _ => {
                let byte = draw(256) as u8;
                bytes.iter_mut().skip(at).take(1).for_each(|there| *there = byte);
            }
        }
    }
    bytes
}

/// What breaks readers of numbers, of TOML and of HTTP.
const WORDS: [&str; 12] = [
    "1e308",
    "-1e308",
    "5e-324",
    "nan",
    "18446744073709551616",
    "-",
    "\u{1b}[2J",
    "\r\n",
    "\n[[",
    "%00",
    "\0",
    "..%2f",
];

#[test]
fn frames_that_are_kept_and_changes_of_them_hold_the_laws() {
    hold("can", 500, can::hold);
}

#[test]
fn devices_that_are_kept_and_changes_of_them_hold_the_laws() {
    hold("drivers", 1000, drivers::hold);
}

#[test]
fn files_that_are_kept_and_changes_of_them_hold_the_laws() {
    hold("toml", 200, toml::hold);
}

#[test]
fn requests_that_are_kept_and_changes_of_them_hold_the_laws() {
    hold("http", 200, http::hold);
}
