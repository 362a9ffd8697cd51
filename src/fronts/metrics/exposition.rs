//! Lines of the text format: families with their help and kind, samples with their labels.

use std::fmt::Write as _;

/// Kinds of families.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// A value that goes up and down.
    Gauge,
    /// A count that only grows until the process starts anew.
    Counter,
}

/// Text so far. A family without a sample leaves no line.
#[derive(Debug, Default)]
pub(crate) struct Exposition {
    text: String,
    name: &'static str,
    /// Help and kind of the family, until its first sample.
    head: String,
}

impl Exposition {
    /// Begins a family.
    pub(crate) fn family(&mut self, name: &'static str, kind: Kind, help: &str) {
        let kind = match kind {
            Kind::Gauge => "gauge",
            Kind::Counter => "counter",
        };
        self.name = name;
        self.head = format!("# HELP {name} {help}\n# TYPE {name} {kind}\n");
    }

    /// Adds a sample to the family.
    pub(crate) fn sample(&mut self, labels: &[(&str, &str)], value: f64) {
        self.text.push_str(&std::mem::take(&mut self.head));
        self.text.push_str(self.name);
        for (index, (name, label)) in labels.iter().enumerate() {
            let before = if index == 0 { '{' } else { ',' };
            // Writing to a string cannot fail.
            let _ = write!(self.text, "{before}{name}=\"{}\"", escaped(label));
        }
        let end = if labels.is_empty() { "" } else { "}" };
        let _ = writeln!(self.text, "{end} {}", number(value));
    }

    /// Adds a sample that is 1 or 0.
    pub(crate) fn flag(&mut self, labels: &[(&str, &str)], is_set: bool) {
        self.sample(labels, f64::from(u8::from(is_set)));
    }

    /// A gauge without labels.
    pub(crate) fn gauge(&mut self, name: &'static str, help: &str, value: f64) {
        self.known(name, help, Some(value));
    }

    /// A gauge without labels that may be unknown.
    pub(crate) fn known(&mut self, name: &'static str, help: &str, value: Option<f64>) {
        self.family(name, Kind::Gauge, help);
        if let Some(value) = value {
            self.sample(&[], value);
        }
    }

    pub(crate) fn finish(self) -> String {
        self.text
    }
}

/// A label as it stands between quotes.
fn escaped(label: &str) -> String {
    label.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

/// A value as Go parses it, in the fewest digits that give it back.
fn number(value: f64) -> String {
    if value.is_nan() {
        "NaN".to_owned()
    } else if value.is_infinite() {
        if value > 0.0 { "+Inf".to_owned() } else { "-Inf".to_owned() }
    } else {
        format!("{value:?}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_escaped_and_empty_families_leave_no_line() {
        let mut out = Exposition::default();
        out.family("a", Kind::Gauge, "None.");
        out.family("b_total", Kind::Counter, "Two.");
        out.sample(&[("x", "a\\b \"c\"\nd"), ("y", "µ")], 2.0);
        out.flag(&[], true);
        out.known("c", "Unknown.", None);
        let expected = "# HELP b_total Two.\n# TYPE b_total counter\n\
                        b_total{x=\"a\\\\b \\\"c\\\"\\nd\",y=\"µ\"} 2.0\nb_total 1.0\n";
        assert_eq!(out.finish(), expected);
    }

    #[test]
    fn numbers_keep_all_digits() {
        for value in [0.0, 1e-9, 0.1 + 0.2, 123_456_789.0, f64::MAX, 5e-324] {
            assert_eq!(number(value).parse(), Ok(value));
        }
        assert_eq!(
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(number),
            ["NaN", "+Inf", "-Inf"]
        );
    }
}
