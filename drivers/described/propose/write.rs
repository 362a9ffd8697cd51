//! Settings as TOML.

use std::fmt::Write as _;

use asphera_link::text_of;

use crate::checksum::{Checksum, Digits};
use crate::field::{FLAGS, Field, Place, Role};
use crate::framing::{End, Framing};
use crate::number::{ByteOrder, Form};
use crate::settings::{Layout, Settings};

/// Settings that were proposed, as the table `settings` of a device.
pub(super) fn toml(settings: &Settings) -> String {
    let mut text = String::new();
    framing(&mut text, &settings.framing);
    match &settings.layout {
        Layout::Columns { separator, columns } => {
            let separator = separator.map_or("blank".to_owned(), |sign| text_of(&[sign]));
            line(&mut text, "separator", &quoted(&separator));
            if let Some(columns) = columns {
                line(&mut text, "columns", &columns.to_string());
            }
        }
        Layout::Pattern(pattern) => line(&mut text, "pattern", &quoted(pattern.text())),
        Layout::Bytes => {}
    }
    if let Some(check) = &settings.checksum {
        line(&mut text, "checksum", &checksum(check));
    }
    if let Some(poll) = &settings.poll {
        text.push_str("\n[poll]\n");
        line(&mut text, "ask", &quoted(&text_of(&poll.ask)));
        line(&mut text, "interval_ms", &poll.interval_ms.to_string());
        line(&mut text, "timeout_ms", &poll.timeout_ms.to_string());
        line(&mut text, "late_limit_ms", &poll.late_limit_ms.to_string());
    }
    for one in &settings.fields {
        field(&mut text, one);
    }
    text
}

fn framing(text: &mut String, framing: &Framing) {
    let begin = framing.begin();
    match framing {
        Framing::Lines { end, .. } => {
            line(text, "frame", "\"line\"");
            if let End::Bytes(end) = end {
                line(text, "end", &quoted(&text_of(end)));
            }
        }
        Framing::Records { length, .. } => {
            line(text, "frame", "\"record\"");
            line(text, "length", &length.to_string());
        }
    }
    if !begin.is_empty() {
        line(text, "begin", &quoted(&text_of(begin)));
    }
}

fn checksum(check: &Checksum) -> String {
    let mut text = format!("{{ kind = \"{}\"", check.algorithm.word());
    text += match check.digits {
        Digits::Hex => ", form = \"hex\"",
        Digits::Binary(ByteOrder::Big) => ", form = \"binary\"",
        Digits::Binary(ByteOrder::Little) => ", form = \"binary\", order = \"little\"",
    };
    for (key, skip) in [("skip_first", check.skip_first), ("skip_last", check.skip_last)] {
        if skip > 0 {
            text += &format!(", {key} = {skip}");
        }
    }
    text + " }"
}

fn field(text: &mut String, field: &Field) {
    text.push_str("\n[[field]]\n");
    line(text, "name", &quoted(&field.name));
    match &field.place {
        Place::Column(column) => line(text, "column", &column.to_string()),
        Place::Group(group) => line(text, "group", &quoted(group)),
        Place::At(at) => line(text, "at", &at.to_string()),
    }
    form(text, field.form);
    match &field.role {
        Role::Channel => {
            line(text, "unit", &quoted(field.unit.symbol()));
            line(text, "scale", &format!("{:?}", field.scale));
        }
        Role::Status { good } => {
            line(text, "role", "\"status\"");
            line(text, "good", &list(good));
        }
        Role::Bits => line(text, "role", "\"bits\""),
        Role::Count { first, modulus } => {
            line(text, "role", "\"count\"");
            line(text, "first", &first.to_string());
            line(text, "modulus", &modulus.to_string());
        }
        Role::DeviceTime => line(text, "role", "\"device-time\""),
    }
    for flagged in &field.flagged {
        if let Some((key, _)) = FLAGS.iter().find(|(_, flag)| *flag == flagged.flag) {
            line(text, key, &list(&flagged.texts));
        }
    }
}

fn form(text: &mut String, form: Form) {
    let (word, order) = match form {
        Form::Decimal => return,
        Form::DecimalComma => ("decimal-comma".to_owned(), ByteOrder::Big),
        Form::Hex => ("hex".to_owned(), ByteOrder::Big),
        Form::Unsigned(width, order) => (format!("u{}", 8 * width), order),
        Form::Signed(width, order) => (format!("i{}", 8 * width), order),
        Form::Single(order) => ("f32".to_owned(), order),
        Form::Double(order) => ("f64".to_owned(), order),
    };
    line(text, "form", &quoted(&word));
    if order == ByteOrder::Little {
        line(text, "order", "\"little\"");
    }
}

fn line(text: &mut String, key: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{key} = {value}");
}

fn list(texts: &[String]) -> String {
    let texts: Vec<String> = texts.iter().map(|text| quoted(text)).collect();
    format!("[{}]", texts.join(", "))
}

/// A string of TOML: between single quotes where nothing is escaped.
fn quoted(text: &str) -> String {
    if text.contains('\\') && !text.contains(['\'', '\n', '\r']) && !text.contains(char::is_control)
    {
        return format!("'{text}'");
    }
    let mut quoted = String::from("\"");
    for sign in text.chars() {
        match sign {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            sign if sign.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(sign));
            }
            sign => quoted.push(sign),
        }
    }
    quoted + "\""
}
