//! What settings can be used.

use std::collections::BTreeSet;

use asphera_link::{MAX_CHANNELS, Problem, Unit, check_range};

use crate::field::{Field, Place, Role};
use crate::framing::{End, Framing};
use crate::number::Form;
use crate::settings::{Layout, Settings};

pub(crate) fn settings(settings: &Settings) -> Vec<Problem> {
    let mut problems = Vec::new();
    framing(&mut problems, settings);
    talk(&mut problems, settings);
    layout(&mut problems, settings);
    names(&mut problems, &settings.fields);
    for (index, field) in settings.fields.iter().enumerate() {
        self::field(&mut problems, &format!("field[{index}]"), field, settings);
    }
    numbers(&mut problems, &settings.fields, settings.profile.is_some());
    if let Some(profile) = &settings.profile {
        problems.extend(profile.problems(settings));
    }
    problems
}

/// How many fields of each role there may be.
pub(crate) fn numbers(problems: &mut Vec<Problem>, fields: &[Field], has_profile: bool) {
    let number = |is: fn(&Role) -> bool| fields.iter().filter(|field| is(&field.role)).count();
    let channels = number(|role| *role == Role::Channel);
    if channels == 0 && !has_profile {
        problems.push(Problem::new("field", "at least one with the role channel", "none"));
    }
    if channels > MAX_CHANNELS {
        problems.push(Problem::new("field", format!("at most {MAX_CHANNELS} channels"), channels));
    }
    if number(|role| matches!(role, Role::Count { .. })) > 1 {
        problems.push(Problem::new("field", "one with the role count", "several"));
    }
    if number(|role| *role == Role::DeviceTime) > 1 {
        problems.push(Problem::new("field", "one with the role device-time", "several"));
    }
}

fn framing(problems: &mut Vec<Problem>, settings: &Settings) {
    match &settings.framing {
        Framing::Lines { begin, end, longest } => {
            check_range(problems, "longest", *longest, 1, 65_536);
            if matches!(end, End::Bytes(bytes) if bytes.is_empty()) {
                problems.push(Problem::new(
                    "end",
                    "\"any\", or the bytes at the end of a line",
                    "none",
                ));
            }
            let is_end = |byte: &u8| matches!(byte, b'\r' | b'\n');
            let holds_end = match end {
                End::Any => begin.iter().any(is_end),
                End::Bytes(end) => {
                    !end.is_empty() && begin.windows(end.len()).any(|window| window == end)
                }
            };
            if holds_end {
                problems.push(Problem::new("begin", "bytes that do not end a line", "the end"));
            }
        }
        Framing::Records { begin, length } => {
            check_range(problems, "length", *length, 1, 65_536);
            let taken = begin.len() + settings.checksum.map_or(0, |check| check.bytes());
            if *length < taken {
                let expected = format!("at least the {taken} bytes of beginning and checksum");
                problems.push(Problem::new("length", expected, length));
            }
            if settings.holds_back() && begin.len() < 2 {
                let expected =
                    "two bytes or more, a checksum or a poll, to find the begin of a record";
                problems.push(Problem::new("begin", expected, format!("{} bytes", begin.len())));
            }
        }
    }
    if let Some(check) = settings.checksum {
        check_range(problems, "checksum.skip_first", check.skip_first, 0, 64);
        check_range(problems, "checksum.skip_last", check.skip_last, 0, 64);
    }
    if settings.begins_whole && (settings.poll.is_some() || settings.hello.is_some()) {
        let expected = "false with a poll or a hello: a frame is an answer there";
        problems.push(Problem::new("begins_whole", expected, "true"));
    }
    check_range(problems, "silence_ms", settings.silence_ms, 1, 10_000);
    if settings.gap_ms != 0 {
        check_range(problems, "gap_ms", settings.gap_ms, 10, 3_600_000);
        if settings.poll.is_some() {
            let expected = "none with a poll, whose timeout_ms finds a silence";
            problems.push(Problem::new("gap_ms", expected, settings.gap_ms));
        }
    }
}

fn talk(problems: &mut Vec<Problem>, settings: &Settings) {
    if let Some(poll) = &settings.poll {
        if poll.ask.is_empty() {
            problems.push(Problem::new("poll.ask", "the bytes of the question", "none"));
        }
        check_range(problems, "poll.interval_ms", poll.interval_ms, 1, 3_600_000);
        check_range(problems, "poll.timeout_ms", poll.timeout_ms, 1, 60_000);
        check_range(problems, "poll.late_limit_ms", poll.late_limit_ms, poll.timeout_ms, 600_000);
    }
    if let Some(hello) = &settings.hello {
        if hello.ask.is_empty() {
            problems.push(Problem::new("hello.ask", "the bytes of the question", "none"));
        }
        check_range(problems, "hello.timeout_ms", hello.timeout_ms, 1, 60_000);
    }
    if let Some(errors) = &settings.errors {
        if errors.ask.is_empty() {
            problems.push(Problem::new("errors.ask", "the bytes of the question", "none"));
        }
        check_range(problems, "errors.timeout_ms", errors.timeout_ms, 1, 60_000);
        check_range(problems, "errors.interval_ms", errors.interval_ms, 100, 3_600_000);
        // Without them nobody knows to which question an answer belongs.
        if settings.poll.is_none() || settings.hello.is_none() {
            problems.push(Problem::new(
                "errors",
                "the tables `poll` and `hello` beside it",
                "not both",
            ));
        }
    }
}

fn layout(problems: &mut Vec<Problem>, settings: &Settings) {
    let is_record = matches!(settings.framing, Framing::Records { .. });
    match &settings.layout {
        Layout::Columns { separator, columns } => {
            if is_record {
                let expected = "a pattern, or fields with `at`, for records";
                problems.push(Problem::new("separator", expected, "columns"));
            }
            if separator.is_some_and(|sign| sign.is_ascii_digit() || b"+-.\r\n".contains(&sign)) {
                let expected = "a sign that no number has";
                problems.push(Problem::new("separator", expected, "one that numbers have"));
            }
            if let Some(columns) = *columns {
                check_range(problems, "columns", columns, 1, 1000);
            }
            let comma = *separator == Some(b',')
                && settings.fields.iter().any(|field| field.form == Form::DecimalComma);
            if comma {
                problems.push(Problem::new("separator", "not the comma of its decimals", "`,`"));
            }
        }
        Layout::Pattern(_) => {}
        Layout::Bytes if !is_record => {
            problems.push(Problem::new("frame", "\"record\" for fields with `at`", "\"line\""));
        }
        Layout::Bytes => {}
    }
}

/// Each field has a name of its own.
pub(crate) fn names(problems: &mut Vec<Problem>, fields: &[Field]) {
    let mut known = BTreeSet::new();
    for (index, field) in fields.iter().enumerate() {
        let key = format!("field[{index}].name");
        if field.name.is_empty() {
            problems.push(Problem::new(key, "a name", "none"));
        } else if !known.insert(&field.name) {
            problems.push(Problem::new(
                key,
                "a name of its own",
                format!("{:?} again", field.name),
            ));
        }
    }
}

fn field(problems: &mut Vec<Problem>, key: &str, field: &Field, settings: &Settings) {
    let mut wrong = |name: &str, expected: &str, found: String| {
        problems.push(Problem::new(format!("{key}.{name}"), expected, found));
    };
    worth(&mut wrong, field);
    if field.role == Role::Bits && matches!(field.form, Form::Single(_) | Form::Double(_)) {
        wrong("form", "a whole number, for bits", "a float".to_owned());
    }
    place(&mut wrong, field, settings);
}

/// What a number is worth, wherever it stands.
pub(crate) fn worth(wrong: &mut impl FnMut(&str, &str, String), field: &Field) {
    if field.scale == 0.0 || !field.scale.is_finite() {
        wrong("scale", "a number, not 0", field.scale.to_string());
    }
    if !field.offset.is_finite() {
        wrong("offset", "a number", field.offset.to_string());
    }
    if field.no_value.is_some_and(|number| !number.is_finite()) {
        wrong("no_value", "a number", "none".to_owned());
    }
    if field.no_value.is_some() && field.role != Role::Channel {
        wrong("no_value", "nothing, for a field that is no channel", "a number".to_owned());
    }
    if let Role::Count { modulus: 0 | 1, .. } = field.role {
        wrong("modulus", "at least 2", "fewer".to_owned());
    }
    if field.role == Role::DeviceTime && field.unit != Unit::Second {
        wrong("unit", "s", field.unit.symbol().to_owned());
    }
    if let Role::Status { good } = &field.role
        && let Some(both) = good.iter().find(|text| !field.flags_of(text).is_empty())
    {
        wrong("good", "texts that no flag has", format!("{both:?}"));
    }
    if field.role == Role::Bits {
        let is_bit = |text: &String| text.parse::<u8>().is_ok_and(|bit| bit < 32);
        if let Some(text) = field.flagged.iter().flat_map(|f| &f.texts).find(|text| !is_bit(text)) {
            wrong("role", "flags of numbers of bits, 0 to 31", format!("{text:?}"));
        }
    }
}

fn place(wrong: &mut impl FnMut(&str, &str, String), field: &Field, settings: &Settings) {
    match (&settings.layout, &field.place) {
        (Layout::Columns { columns, .. }, Place::Column(column)) => {
            let most = columns.unwrap_or(1000);
            if !(1..=most).contains(column) {
                wrong("column", &format!("1 to {most}"), column.to_string());
            }
            text(wrong, field);
        }
        (Layout::Pattern(pattern), Place::Group(group)) => {
            if pattern.group(group).is_none() {
                let known: Vec<_> = pattern.groups().collect();
                let expected = format!("a group of the pattern: {}", known.join(", "));
                wrong("group", &expected, format!("{group:?}"));
            }
            text(wrong, field);
        }
        (Layout::Bytes, Place::At(at)) => {
            let Framing::Records { length, .. } = settings.framing else { return };
            let last = length.saturating_sub(settings.checksum.map_or(0, |check| check.bytes()));
            match field.form.width() {
                None => wrong("form", "a number in bytes: u8 to f64", "digits".to_owned()),
                Some(width) if at + width > last => {
                    let expected = format!("a place whose {width} bytes end within {last}");
                    wrong("at", &expected, at.to_string());
                }
                Some(_) => {}
            }
        }
        (layout, place) => {
            let wanted = match layout {
                Layout::Columns { .. } => "column",
                Layout::Pattern(_) => "group",
                Layout::Bytes => "at",
            };
            let found = match place {
                Place::Column(_) => "column",
                Place::Group(_) => "group",
                Place::At(_) => "at",
            };
            wrong(found, &format!("`{wanted}`, as the others"), format!("`{found}`"));
        }
    }
}

fn text(wrong: &mut impl FnMut(&str, &str, String), field: &Field) {
    if field.form.width().is_some() {
        wrong("form", "decimal, decimal-comma or hex, for text", "a number in bytes".to_owned());
    }
}
