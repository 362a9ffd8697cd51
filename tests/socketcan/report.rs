//! What was checked, one line each.

use std::io::{Write as _, stdout};
use std::process::ExitCode;

/// Counts and tells what passed and what failed.
#[derive(Default)]
pub(crate) struct Report {
    passed: u32,
    failed: u32,
    skipped: u32,
}

impl Report {
    /// Tells one result: what was seen, or what is wrong.
    pub(crate) fn check(&mut self, name: &str, result: Result<String, String>) {
        match result {
            Ok(seen) => {
                self.passed += 1;
                line(&format!("PASS {name}: {seen}"));
            }
            Err(wrong) => {
                self.failed += 1;
                line(&format!("FAIL {name}: {wrong}"));
            }
        }
    }

    /// Tells why something could not be checked here.
    pub(crate) fn skip(&mut self, name: &str, why: &str) {
        self.skipped += 1;
        line(&format!("SKIP {name}: {why}"));
    }

    /// Tells the totals.
    pub(crate) fn finish(self) -> ExitCode {
        let Report { passed, failed, skipped } = self;
        line(&format!("DONE {passed} passed, {failed} failed, {skipped} skipped"));
        if failed == 0 && passed > 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

/// A figure worth knowing that nothing hangs on.
pub(crate) fn note(text: &str) {
    line(&format!("NOTE {text}"));
}

fn line(text: &str) {
    // Whoever started the program may be gone; the exit status stands all the same.
    let _ = writeln!(stdout(), "{text}");
}
