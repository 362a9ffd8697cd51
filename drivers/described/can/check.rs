//! What settings of a device on a bus can be used.

use asphera_link::{CanId, FD_LENGTHS, Problem, check_range};

use super::{CanSettings, SignalForm};
use crate::check::{names, numbers, worth};
use crate::field::{Field, Role};

pub(super) fn settings(settings: &CanSettings) -> Vec<Problem> {
    let mut problems = Vec::new();
    let most = match settings.id {
        CanId::Standard(_) => 0x7FF,
        CanId::Extended(_) => 0x1FFF_FFFF,
    };
    if settings.mask > most {
        let expected = format!("at most {most:#X}, all bits of the identifier");
        problems.push(Problem::new("mask", expected, format!("{:#X}", settings.mask)));
    }
    if let Some(length) = settings.length {
        let fits = if settings.fd { FD_LENGTHS.contains(&length) } else { length <= 8 };
        if !fits {
            let expected = match settings.fd {
                true => "0 to 8, 12, 16, 20, 24, 32, 48 or 64",
                false => "0 to 8; more needs fd = true",
            };
            problems.push(Problem::new("length", expected, length));
        }
    }
    if let Some(poll) = &settings.poll {
        check_range(&mut problems, "poll.interval_ms", poll.interval_ms, 1, 3_600_000);
        check_range(&mut problems, "poll.timeout_ms", poll.timeout_ms, 1, 60_000);
        let (low, high) = (poll.timeout_ms, 600_000);
        check_range(&mut problems, "poll.late_limit_ms", poll.late_limit_ms, low, high);
    }
    if settings.gap_ms != 0 {
        check_range(&mut problems, "gap_ms", settings.gap_ms, 10, 3_600_000);
        if settings.poll.is_some() {
            let expected = "none with a poll, whose timeout_ms finds a silence";
            problems.push(Problem::new("gap_ms", expected, settings.gap_ms));
        }
    }
    let meanings: Vec<Field> = settings.fields.iter().map(|field| field.meaning.clone()).collect();
    names(&mut problems, &meanings);
    numbers(&mut problems, &meanings, false);
    for index in 0..settings.fields.len() {
        field(&mut problems, index, settings);
    }
    problems
}

fn field(problems: &mut Vec<Problem>, index: usize, settings: &CanSettings) {
    let field = &settings.fields[index];
    let mut wrong = |name: &str, expected: &str, found: String| {
        problems.push(Problem::new(format!("field[{index}].{name}"), expected, found));
    };
    worth(&mut wrong, &field.meaning);
    let signal = field.signal;
    let width = match signal.form {
        SignalForm::Single => Some(32),
        SignalForm::Double => Some(64),
        SignalForm::Unsigned | SignalForm::Signed => None,
    };
    match width {
        Some(width) if signal.bits != width => {
            wrong("bits", &format!("{width}, those of the float"), signal.bits.to_string());
        }
        None if !(1..=64).contains(&signal.bits) => {
            wrong("bits", "1 to 64", signal.bits.to_string());
        }
        _ => {}
    }
    if width.is_some() && field.meaning.role == Role::Bits {
        wrong("form", "a whole number, for bits", "a float".to_owned());
    }
    let last = settings.length.unwrap_or(if settings.fd { 64 } else { 8 });
    if signal.bits <= 64 && signal.end_byte() > last {
        let expected = format!("a place whose {} bits end within {last} bytes", signal.bits);
        wrong("start_bit", &expected, signal.start_bit.to_string());
    }
}
