//! The outcome of a play, beside what a bench expects.

use asphera_link::{Flags, Nanos};

use crate::Mark;
use crate::journal::Journal;

/// Outcome of a play.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The fault cannot occur: why.
    Absent(&'static str),
    /// Words of the cell, and the texts that a technician reads.
    Played(String, Vec<String>),
}

/// Compares what was seen with what must be seen.
pub(crate) fn judge(
    journal: &mut Journal,
    now: Nanos,
    marks: &[Mark],
) -> Result<Outcome, Vec<String>> {
    let expected = Expected::new(marks);
    if journal.flags != expected.flags {
        let (found, expected) = (names(journal.flags), names(expected.flags));
        journal.broken(now, format!("flagged [{found}], expected [{expected}]"));
    }
    if (journal.discarded_in_fault > 0) != expected.is_discarded {
        let (bytes, any) = (journal.discarded_in_fault, expected.is_discarded);
        journal.broken(now, format!("{bytes} bytes discarded, expected any: {any}"));
    }
    let faults: Vec<String> = journal.faults.iter().map(|(_, text)| text.clone()).collect();
    let reopened: Vec<String> = journal.reopened.iter().cloned().collect();
    let halted: Vec<String> = journal.halted.iter().cloned().collect();
    for (what, found, expected) in [
        ("faults", &faults, &expected.faults),
        ("reopened", &reopened, &expected.reopened),
        ("halted", &halted, &expected.halted),
    ] {
        let is_known = |text: &String| expected.iter().any(|words| text.contains(words));
        let is_there = |words: &&str| found.iter().any(|text| text.contains(*words));
        if !(found.iter().all(is_known) && expected.iter().all(is_there)) {
            journal.broken(now, format!("{what} {found:?}, expected {expected:?}"));
        }
    }
    if !journal.violations.is_empty() {
        return Err(std::mem::take(&mut journal.violations));
    }
    Ok(Outcome::Played(cell(journal), [faults, reopened, halted].concat()))
}

/// What was seen, in short words.
fn cell(journal: &Journal) -> String {
    let mut words = Vec::new();
    words.extend((!journal.flags.is_empty()).then(|| format!("flagged {}", names(journal.flags))));
    words.extend((journal.discarded_in_fault > 0).then(|| "discarded".to_owned()));
    // Sorted by kind already.
    let mut kinds: Vec<&str> = journal.faults.iter().map(|(kind, _)| *kind).collect();
    kinds.dedup();
    words.extend((!kinds.is_empty()).then(|| format!("fault: {}", kinds.join(" "))));
    words.extend((!journal.reopened.is_empty()).then(|| "reopened".to_owned()));
    words.extend((!journal.halted.is_empty()).then(|| "halted".to_owned()));
    if words.is_empty() { "goes on".to_owned() } else { words.join(", ") }
}

fn names(flags: Flags) -> String {
    flags.names().collect::<Vec<_>>().join(" ")
}

#[derive(Default)]
struct Expected {
    flags: Flags,
    is_discarded: bool,
    faults: Vec<&'static str>,
    reopened: Vec<&'static str>,
    halted: Vec<&'static str>,
}

impl Expected {
    fn new(marks: &[Mark]) -> Expected {
        let mut expected = Expected::default();
        for mark in marks {
            match mark {
                Mark::Flagged(flags) => expected.flags |= *flags,
                Mark::Discarded => expected.is_discarded = true,
                Mark::Fault(words) => expected.faults.push(words),
                Mark::Reopened(words) => expected.reopened.push(words),
                Mark::Halted(words) => expected.halted.push(words),
            }
        }
        expected
    }
}
