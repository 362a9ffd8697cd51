//! The driver as a configuration knows it: its keys, and what a station asks of its settings.

use std::time::Duration;

use asphera_link::{
    Carries, Channel, DeviceClock, DeviceSettings, Driver, Family, Problem, Unit, bytes_of,
};
use asphera_settings::Section;

mod profile;

use crate::Described;
use crate::can;
use crate::checksum::{Algorithm, Checksum, Digits};
use crate::field::{FLAGS, Field, Flagged, Place, Role};
use crate::framing::{End, Framing};
use crate::number::{ByteOrder, Form};
use crate::pattern::Pattern;
use crate::propose::propose;
use crate::settings::{ErrorQueue, Hello, Layout, Poll, Refusal, Settings};

/// Devices described in the configuration: `driver = "described"`, on a serial line, TCP, UDP or a CAN bus.
pub const FAMILY: Family = Family {
    name: "described",
    carries: Carries::Bytes,
    settings: |table| match table.get::<String>("frame").as_deref() {
        Some("can") => can::read(table).map(|settings| Box::new(settings) as _),
        _ => read(table).map(|settings| Box::new(settings) as _),
    },
    propose: Some(propose),
};

fn read(table: &Section<'_>) -> Option<Settings> {
    let framing = framing(table);
    let layout = layout(table);
    let checksum = checksum(&table.section("checksum"));
    let fields: Vec<Option<Field>> = table.array("field").iter().map(field).collect();
    let fields: Option<Vec<Field>> = fields.into_iter().collect();
    let profile = optional(table, "profile", profile::read);
    let is_empty = fields.as_ref().is_some_and(Vec::is_empty) && matches!(profile, Some(None));
    if is_empty {
        table.problem("field", "a table [[field]] for each number", "nothing");
    }
    let begins_whole = table.or("begins_whole", false);
    let poll = optional(table, "poll", poll);
    let hello = optional(table, "hello", hello);
    let errors = optional(table, "errors", errors);
    let refusals: Vec<Option<Refusal>> = table.array("refusal").iter().map(refusal).collect();
    let refusals: Option<Vec<Refusal>> = refusals.into_iter().collect();
    let ignore: Vec<String> = table.or("ignore", Vec::new());
    let ignore: Vec<Option<Pattern>> =
        ignore.iter().map(|text| compiled(table, "ignore", text)).collect();
    let sayings = ["on_connect", "on_start", "on_stop"].map(|key| sayings(table, key));
    let silence_ms = table.or("silence_ms", Settings::default().silence_ms);
    let gap_ms = table.or("gap_ms", Settings::default().gap_ms);
    // All keys are read by now: a mistake in one must not make others unknown.
    let [on_connect, on_start, on_stop] = sayings;
    let settings = Settings {
        framing: framing?,
        checksum: checksum?,
        layout: layout?,
        fields: fields?,
        profile: profile?,
        begins_whole,
        poll: poll?,
        hello: hello?,
        errors: errors?,
        on_connect: on_connect?,
        on_start: on_start?,
        on_stop: on_stop?,
        refusals: refusals?,
        ignore: ignore.into_iter().collect::<Option<_>>()?,
        silence_ms,
        gap_ms,
    };
    (!is_empty).then_some(settings)
}

fn framing(table: &Section<'_>) -> Option<Framing> {
    // Tables with the word `can` are read elsewhere.
    let is_record =
        table.word("frame", false, &[("line", false), ("record", true), ("can", false)]);
    let begin = table.has("begin").then(|| bytes(table, "begin"));
    let begin = begin.map_or(Some(Vec::new()), |begin| begin);
    if is_record {
        let length = table.required("length");
        return Some(Framing::Records { begin: begin?, length: length? });
    }
    let longest = table.or("longest", 256);
    let any = !table.has("end") || table.get::<String>("end").is_some_and(|end| end == "any");
    let end = if any { Some(End::Any) } else { bytes(table, "end").map(End::Bytes) };
    Some(Framing::Lines { begin: begin?, end: end?, longest })
}

/// A pattern, columns, or fields by their place in a record.
fn layout(table: &Section<'_>) -> Option<Layout> {
    let pattern = table.get::<String>("pattern");
    if let Some(text) = pattern {
        for key in ["separator", "columns"] {
            if table.has(key) {
                table.problem(key, "either a pattern or columns", "both");
            }
        }
        return compiled(table, "pattern", &text).map(Layout::Pattern);
    }
    let in_bytes = table.get::<String>("frame").as_deref() == Some("record");
    if in_bytes && !table.has("separator") {
        return Some(Layout::Bytes);
    }
    let separator: String = table.or("separator", "blank".to_owned());
    let columns = table.get("columns");
    let separator = match (separator.as_str(), bytes_of(&separator).ok().as_deref()) {
        ("blank", _) => None,
        (_, Some([sign])) => Some(*sign),
        _ => {
            table.problem("separator", "\"blank\", or one sign", format!("{separator:?}"));
            return None;
        }
    };
    Some(Layout::Columns { separator, columns })
}

#[expect(clippy::option_option, reason = "outer: unusable; inner: none asked for")]
fn checksum(table: &Section<'_>) -> Option<Option<Checksum>> {
    if !table.is_present() {
        return Some(None);
    }
    let algorithm = table.required_word("kind", &Algorithm::ALL);
    let order = order(table);
    let is_hex = table.required_word("form", &[("hex", true), ("binary", false)]);
    let (skip_first, skip_last) = (table.or("skip_first", 0), table.or("skip_last", 0));
    table.finish();
    let digits = if is_hex? { Digits::Hex } else { Digits::Binary(order) };
    Some(Some(Checksum { algorithm: algorithm?, digits, skip_first, skip_last }))
}

fn order(table: &Section<'_>) -> ByteOrder {
    table.word("order", ByteOrder::Big, &[("big", ByteOrder::Big), ("little", ByteOrder::Little)])
}

/// How a number is written, by the keys `form` and `order`.
fn form(table: &Section<'_>) -> Form {
    let order = order(table);
    let binary = Form::BINARY.iter().filter_map(|word| Some((*word, Form::binary(word, order)?)));
    let forms: Vec<(&str, Form)> = Form::TEXT.into_iter().chain(binary).collect();
    table.word("form", Form::Decimal, &forms)
}

fn field(table: &Section<'_>) -> Option<Field> {
    let place = place(table);
    let form = form(table);
    let field = meaning(table, place, form);
    table.finish();
    field
}

/// What a number means, wherever it stands.
pub(crate) fn meaning(table: &Section<'_>, place: Option<Place>, form: Form) -> Option<Field> {
    let name = table.required("name");
    let units: Vec<(&str, Unit)> = Unit::ALL.iter().map(|unit| (unit.symbol(), *unit)).collect();
    let role = role(table);
    let ordinary = if matches!(role, Some(Role::DeviceTime)) { Unit::Second } else { Unit::One };
    let unit = table.word("unit", ordinary, &units);
    let valid_range = table.range("valid_range");
    let no_value = table.get("no_value");
    let flagged = FLAGS.iter().filter_map(|(key, flag)| {
        let texts: Vec<String> = table.get(key)?;
        Some(Flagged { flag: *flag, texts, means: String::new() })
    });
    let flagged = flagged.collect();
    let (scale, offset) = (table.or("scale", 1.0), table.or("offset", 0.0));
    Some(Field {
        name: name?,
        place: place?,
        form,
        scale,
        offset,
        unit,
        valid_range,
        no_value,
        role: role?,
        flagged,
    })
}

fn place(table: &Section<'_>) -> Option<Place> {
    let places = [
        table.get("column").map(Place::Column),
        table.get("group").map(Place::Group),
        table.get("at").map(Place::At),
    ];
    let mut places = places.into_iter().flatten();
    match (places.next(), places.next()) {
        (Some(place), None) => Some(place),
        (None, _) => {
            table.problem("column", "one of `column`, `group` and `at`", "nothing");
            None
        }
        (Some(_), Some(_)) => {
            table.problem("column", "one of `column`, `group` and `at`", "several");
            None
        }
    }
}

fn role(table: &Section<'_>) -> Option<Role> {
    let words = ["channel", "status", "bits", "count", "device-time"].map(|word| (word, word));
    Some(match table.word("role", "channel", &words) {
        "status" => Role::Status { good: table.required("good")? },
        "bits" => Role::Bits,
        "count" => Role::Count { first: table.or("first", 0), modulus: table.required("modulus")? },
        "device-time" => Role::DeviceTime,
        _ => Role::Channel,
    })
}

fn poll(table: &Section<'_>) -> Option<Poll> {
    let ask = bytes(table, "ask");
    let timeout_ms: u32 = table.or("timeout_ms", 500);
    let poll = Poll {
        ask: Vec::new(),
        interval_ms: table.or("interval_ms", 100),
        timeout_ms,
        late_limit_ms: table.or("late_limit_ms", timeout_ms.saturating_mul(2).min(600_000)),
    };
    Some(Poll { ask: ask?, ..poll })
}

fn hello(table: &Section<'_>) -> Option<Hello> {
    let ask = bytes(table, "ask");
    let answer: Option<String> = table.required("answer");
    let answer = answer.and_then(|text| compiled(table, "answer", &text));
    let timeout_ms = table.or("timeout_ms", 1000);
    Some(Hello { ask: ask?, answer: answer?, timeout_ms })
}

fn errors(table: &Section<'_>) -> Option<ErrorQueue> {
    let ask = bytes(table, "ask");
    let [none, entry] = ["none", "entry"].map(|key| {
        let text: Option<String> = table.required(key);
        text.and_then(|text| compiled(table, key, &text))
    });
    let timeout_ms = table.or("timeout_ms", 500);
    let interval_ms = table.or("interval_ms", 5000);
    Some(ErrorQueue { ask: ask?, none: none?, entry: entry?, timeout_ms, interval_ms })
}

fn refusal(table: &Section<'_>) -> Option<Refusal> {
    let pattern: Option<String> = table.required("pattern");
    let means = table.or("means", String::new());
    let pattern = pattern.and_then(|text| compiled(table, "pattern", &text));
    table.finish();
    Some(Refusal { pattern: pattern?, means })
}

#[expect(clippy::option_option, reason = "outer: unusable; inner: none asked for")]
pub(crate) fn optional<T>(
    table: &Section<'_>,
    key: &str,
    read: impl Fn(&Section<'_>) -> Option<T>,
) -> Option<Option<T>> {
    let section = table.section(key);
    if !section.is_present() {
        return Some(None);
    }
    let value = read(&section);
    section.finish();
    value.map(Some)
}

/// Bytes in the notation of [`bytes_of`].
pub(crate) fn bytes(table: &Section<'_>, key: &str) -> Option<Vec<u8>> {
    let text: String = table.required(key)?;
    let wrong = |error| table.problem(key, "bytes: text, \\r, \\n, \\t, \\\\ or \\xHH", error);
    bytes_of(&text).map_err(wrong).ok()
}

fn sayings(table: &Section<'_>, key: &str) -> Option<Vec<Vec<u8>>> {
    let texts: Vec<String> = table.or(key, Vec::new());
    let wrong = |error| table.problem(key, "bytes: text, \\r, \\n, \\t, \\\\ or \\xHH", error);
    texts.iter().map(|text| bytes_of(text).map_err(wrong).ok()).collect()
}

fn compiled(table: &Section<'_>, key: &str, text: &str) -> Option<Pattern> {
    let wrong = |error| table.problem(key, "a regular expression", error);
    Pattern::new(text).map_err(wrong).ok()
}

impl DeviceSettings for Settings {
    fn problems(&self) -> Vec<Problem> {
        Settings::problems(self)
    }

    fn channels(&self) -> Vec<Channel> {
        Settings::channels(self)
    }

    fn measures_profiles(&self) -> bool {
        self.profile.is_some()
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        self.count_modulus().ok_or("it has no field with the role count")
    }

    fn holds_back(&self) -> Duration {
        let holds_back = Settings::holds_back(self);
        Duration::from_millis(if holds_back { self.silence_ms.into() } else { 0 })
    }

    fn clock(&self) -> Option<DeviceClock> {
        let field = self.fields.iter().find(|field| field.role == Role::DeviceTime)?;
        // Of whole numbers the field says where they end; of digits nobody knows.
        let Form::Unsigned(bytes, _) = field.form else { return Some(DeviceClock::default()) };
        Some(DeviceClock::counter(field.scale, 8 * i32::from(bytes)))
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(Described::new(self.clone())?))
    }
}

#[cfg(test)]
mod tests {
    use asphera_settings::Problems;

    use super::*;

    fn settings(text: &str) -> Result<Box<dyn DeviceSettings>, Problems> {
        FAMILY.parse("gauge", text)
    }

    const GAUGE: &str = r#"
separator = ","
columns = 3
checksum = { kind = "xor8", form = "hex", skip_last = 1 }
ignore = ['#.*']
on_start = ['GO\r']

[poll]
ask = 'M\r'
interval_ms = 20

[hello]
ask = '*IDN?\n'
answer = 'ACME.*'

[[refusal]]
pattern = 'ER,\d+'
means = "cover the sensor head less"

[[field]]
name = "z"
column = 1
unit = "mm"
scale = 0.001
no_signal = ["-----"]
valid_range = [-5, 5]

[[field]]
name = "n"
column = 2
role = "count"
modulus = 100

[[field]]
name = "state"
column = 3
role = "status"
good = ["OK"]
weak = ["LO"]
"#;

    #[test]
    fn a_whole_description_gives_a_driver() {
        let gauge = settings(GAUGE).unwrap();
        assert_eq!(gauge.channels(), [Channel::new("z", Unit::Millimetre)]);
        assert_eq!((gauge.count_cycle(), gauge.holds_back()), (Ok(100), Duration::ZERO));
        assert_eq!(gauge.driver().unwrap().channels(), gauge.channels());
    }

    #[test]
    fn a_record_is_described_in_bytes() {
        let record = settings(
            "frame = \"record\"\nlength = 6\nbegin = '\\xAA\\x55'\nfield = [\
             { name = \"z\", at = 2, form = \"i32\", order = \"little\", unit = \"mm\" }]",
        );
        let record = record.unwrap();
        assert_eq!(record.holds_back(), Duration::from_millis(50));
        assert!(record.count_cycle().unwrap_err().contains("role count"));
    }

    #[test]
    fn a_counter_of_time_says_when_it_begins_again() {
        let clock = |form: &str| {
            let text = format!(
                "frame = \"record\"\nlength = 8\nbegin = '\\xAA\\x55'\nfield = [{{ name = \"z\", at = 2, form = \"i16\" }}, \
                 {{ name = \"t\", at = 4, form = \"{form}\", scale = 1e-3, unit = \"s\", role = \"device-time\" }}]"
            );
            settings(&text).unwrap().clock().unwrap()
        };
        assert_eq!(
            clock("u16"),
            DeviceClock { wraps_ns: Some(65_536_000_000), tick_ns: 1_000_000 }
        );
        assert_eq!(clock("u32").wraps_ns, Some(4_294_967_296_000_000));
        assert_eq!(clock("f32"), DeviceClock::default());
        assert_eq!(settings(GAUGE).unwrap().clock(), None);
    }

    fn told(text: &str) -> Vec<(usize, String)> {
        let problems = settings(text).unwrap_err();
        problems.0.into_iter().map(|problem| (problem.line, problem.key)).collect()
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let wrong = r#"separator = ", "
end = "\\q"
ignore = ['(']
colums = 2
[checksum]
kind = "sum7"
[poll]
ask = "µ"
[hello]
ask = 'I\r'
[[field]]
name = "z"
column = 0
at = 1
[[field]]
name = "s"
column = 1
role = "status"
saturatet = ["1"]
"#;
        let lines = [
            (1, "separator"),
            (2, "end"),
            (3, "ignore"),
            (4, "colums"),
            (5, "checksum.form"),
            (6, "checksum.kind"),
            (8, "poll.ask"),
            (9, "hello.answer"),
            (13, "field[0].column"),
            (15, "field[1].good"),
            (19, "field[1].saturatet"),
        ];
        assert_eq!(told(wrong), lines.map(|(line, key)| (line, key.to_owned())));
        assert_eq!(told(""), [(1, "field".to_owned())]);
        // A mistake makes no other key unknown.
        let known = "columns = 1\npattern = '('\non_start = ['GO']\nsilence_ms = 5\n[[field]]\nname = \"z\"\ngroup = \"z\"";
        assert_eq!(told(known), [(1, "columns".to_owned()), (2, "pattern".to_owned())]);
    }

    #[test]
    fn what_does_not_fit_together_is_named() {
        let keys = |text: &str| told(text).into_iter().map(|(_, key)| key).collect::<Vec<_>>();
        let field = |more: &str| format!("[[field]]\nname = \"z\"\n{more}\n");
        let record = "frame = \"record\"\nlength = 4\n";
        assert_eq!(keys(&format!("{record}{}", field("at = 0\nform = \"i16\""))), ["begin"]);
        let begun = format!("{record}begin = 'AB'\n");
        assert_eq!(keys(&format!("{begun}{}", field("at = 3\nform = \"i16\""))), ["field[0].at"]);
        assert_eq!(keys(&format!("{begun}{}", field("at = 2"))), ["field[0].form"]);
        assert_eq!(keys(&format!("{begun}{}", field("column = 2"))), ["field[0].column"]);
        assert_eq!(keys(&field("column = 1\nform = \"u8\"")), ["field[0].form"]);
        assert_eq!(keys(&field("at = 1\nform = \"u8\"")), ["field[0].at"]);
        assert_eq!(
            keys(&format!("pattern = '(?<a>.)'\n{}", field("group = \"z\""))),
            ["field[0].group"]
        );
        assert_eq!(keys(&format!("separator = '5'\n{}", field("column = 1"))), ["separator"]);
        assert_eq!(keys(&format!("end = ''\n{}", field("column = 1"))), ["end"]);
        assert_eq!(
            keys(&field("column = 1\nrole = \"count\"\nmodulus = 1")),
            ["field", "field[0].modulus"]
        );
        assert_eq!(keys(&field("column = 1\nscale = 0")), ["field[0].scale"]);
    }
}
