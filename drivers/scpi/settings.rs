//! Settings of the driver, and the description they stand for.

use asphera_described::{End, Settings as Description};
use asphera_described::{
    ErrorQueue, Field, Form, Framing, Hello, Layout, Pattern, PatternError, Place, Poll, Role,
};
use asphera_link::{Channel, Problem, Unit};

use crate::answers;

/// An instrument, and what is asked of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Pattern that the whole answer to `*IDN?` must match.
    pub identity: Pattern,
    /// Query whose answer is a reading, without its end.
    pub query: String,
    /// Numbers of the answer that are channels; at least one.
    pub values: Vec<Value>,
    /// Numbers and words that the answer must have, between commas; `None`: enough for the values.
    pub columns: Option<usize>,
    /// Commands sent when the link opens, without their ends.
    pub setup: Vec<String>,
    /// Bytes at the end of all that is sent.
    pub terminator: Terminator,
    /// Whether the error queue is read.
    pub reads_errors: bool,
    /// Time from one query to the next, 1 to 3 600 000 ms.
    pub interval_ms: u32,
    /// Time an answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// Silence after which no late answer is expected any more, `timeout_ms` to 600 000 ms.
    pub late_limit_ms: u32,
}

/// A number of the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Name of its channel.
    pub name: String,
    /// Its place among the commas, from 1.
    pub column: usize,
    /// Worth of one: the value is number × scale + offset. Not zero.
    pub scale: f64,
    /// Value of the number 0.
    pub offset: f64,
    /// Unit of the value.
    pub unit: Unit,
    /// Smallest and largest value that can be measured. Outside, the value is missing and the reading flagged.
    pub valid_range: Option<(f64, f64)>,
}

/// Bytes at the end of a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Terminator {
    /// LF, as IEEE 488.2 has it.
    #[default]
    LineFeed,
    /// CR.
    CarriageReturn,
    /// CR, then LF.
    Both,
}

impl Terminator {
    /// Words of the configuration.
    pub const ALL: [(&'static str, Terminator); 3] = [
        ("lf", Terminator::LineFeed),
        ("cr", Terminator::CarriageReturn),
        ("crlf", Terminator::Both),
    ];

    fn end(self, command: &str) -> Vec<u8> {
        let end = match self {
            Terminator::LineFeed => "\n",
            Terminator::CarriageReturn => "\r",
            Terminator::Both => "\r\n",
        };
        [command, end].concat().into_bytes()
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`Settings::description`] makes a driver.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        if !is_message(&self.query) || !self.query.contains('?') {
            let expected = "a query of printable ASCII signs with a `?`, without its end";
            problems.push(Problem::new("query", expected, format!("{:?}", self.query)));
        }
        if let Some(wrong) = self.setup.iter().find(|command| !is_message(command)) {
            let expected = "commands of printable ASCII signs, without their ends";
            problems.push(Problem::new("setup", expected, format!("{wrong:?}")));
        }
        if let Some(asks) = self.setup.iter().find(|command| command.contains('?')) {
            let expected = "commands without `?`: nobody waits for an answer";
            problems.push(Problem::new("setup", expected, format!("{asks:?}")));
        }
        let described = self.description().map(|described| described.problems());
        problems.extend(described.unwrap_or_default().into_iter().filter_map(own_key));
        problems
    }

    /// Channels of the readings, in the order of the values.
    pub fn channels(&self) -> Vec<Channel> {
        self.values.iter().map(|value| Channel::new(value.name.clone(), value.unit)).collect()
    }

    /// Description of the instrument for the state machine of described devices.
    ///
    /// # Errors
    ///
    /// None in practice: the patterns of SCPI itself are sound.
    pub fn description(&self) -> Result<Description, PatternError> {
        let errors = ErrorQueue {
            ask: self.terminator.end(answers::ERROR),
            none: answers::no_error()?,
            entry: answers::error()?,
            timeout_ms: self.timeout_ms,
            interval_ms: ERRORS_EVERY_MS,
        };
        Ok(Description {
            framing: Framing::Lines { begin: Vec::new(), end: End::Any, longest: LONGEST },
            layout: Layout::Columns { separator: Some(b','), columns: self.columns },
            fields: self.values.iter().map(Value::field).collect(),
            poll: Some(Poll {
                ask: self.terminator.end(&self.query),
                interval_ms: self.interval_ms,
                timeout_ms: self.timeout_ms,
                late_limit_ms: self.late_limit_ms,
            }),
            hello: Some(Hello {
                ask: self.terminator.end(answers::IDENTITY),
                answer: self.identity.clone(),
                timeout_ms: self.timeout_ms,
            }),
            errors: self.reads_errors.then_some(errors),
            on_connect: self.setup.iter().map(|command| self.terminator.end(command)).collect(),
            ..Description::default()
        })
    }
}

impl Value {
    fn field(&self) -> Field {
        // Infinity is sent as a number: without a range of one's own it is out of every range.
        let largest = (answers::ENDLESS * self.scale).abs() * (1.0 - 1e-6);
        Field {
            form: Form::Decimal,
            scale: self.scale,
            offset: self.offset,
            valid_range: self.valid_range.or(Some((-largest, largest))),
            no_value: Some(answers::NOT_A_NUMBER),
            role: Role::Channel,
            ..Field::channel(&self.name, Place::Column(self.column), self.unit)
        }
    }
}

fn is_message(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| (b' '..0x7F).contains(&byte))
}

/// A problem of the description under the key of this driver.
fn own_key(problem: Problem) -> Option<Problem> {
    let key = problem.key.strip_prefix("poll.").unwrap_or(&problem.key);
    // What follows from the time-out is said of the time-out.
    if ["hello", "errors"].iter().any(|table| key.starts_with(table)) {
        return None;
    }
    Some(Problem { key: key.to_owned(), ..problem })
}

/// Most bytes of an answer.
const LONGEST: usize = 4096;

/// Time from an empty error queue to the next question for it, in ms.
const ERRORS_EVERY_MS: u32 = 5000;
