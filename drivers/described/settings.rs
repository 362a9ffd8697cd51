//! Settings of the driver.

use asphera_link::{Channel, Pace, Problem};

use crate::check;
use crate::checksum::Checksum;
use crate::field::{Field, Role};
use crate::framing::{End, Framing};
use crate::pattern::Pattern;
use crate::profile::ProfileRow;

/// A device: its frames, what stands in them, and what is said to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How frames are told apart.
    pub framing: Framing,
    /// What guards each frame.
    pub checksum: Option<Checksum>,
    /// How a frame is taken apart.
    pub layout: Layout,
    /// What stands in it; at least one channel, or a profile.
    pub fields: Vec<Field>,
    /// The heights of a line profile in it.
    pub profile: Option<ProfileRow>,
    /// Whether a connection begins with a whole frame, as files and pipes do. Else what comes before the first end of a line
    /// may be half of one.
    pub begins_whole: bool,
    /// The question each reading answers; `None`: the device sends by itself.
    pub poll: Option<Poll>,
    /// The question that proves that the right device is there.
    pub hello: Option<Hello>,
    /// The queue in which the device holds its errors; needs `poll` and `hello`.
    pub errors: Option<ErrorQueue>,
    /// Sent when the link opens, one after the other.
    pub on_connect: Vec<Vec<u8>>,
    /// Sent when measuring starts.
    pub on_start: Vec<Vec<u8>>,
    /// Sent when measuring stops.
    pub on_stop: Vec<Vec<u8>>,
    /// Frames that say no.
    pub refusals: Vec<Refusal>,
    /// Frames that are neither readings nor wrong: echoes, prompts, heads.
    pub ignore: Vec<Pattern>,
    /// Silence after which a record that nothing guards counts as whole, and which interrupts a line that nothing guards:
    /// 1 to 10 000 ms.
    pub silence_ms: u32,
    /// Longest time between two frames of a device that sends by itself, after which the link is opened anew: 10 to
    /// 3 600 000 ms; 0: any.
    pub gap_ms: u32,
}

/// How a frame is taken apart.
#[derive(Clone, Debug, PartialEq)]
pub enum Layout {
    /// Into columns. Blanks about a column are none of it.
    Columns {
        /// Sign between two columns; `None`: any number of blanks or tabulators.
        separator: Option<u8>,
        /// Columns that a line must have; `None`: enough for the fields.
        columns: Option<usize>,
    },
    /// By a pattern with named groups. A frame that does not match is no reading.
    Pattern(Pattern),
    /// By place, in bytes.
    Bytes,
}

/// A question asked again and again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Poll {
    /// Its bytes.
    pub ask: Vec<u8>,
    /// Time from one to the next, 1 to 3 600 000 ms.
    pub interval_ms: u32,
    /// Time the answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// Silence after which no late answer is expected any more, `timeout_ms` to 600 000 ms.
    pub late_limit_ms: u32,
}

impl Poll {
    pub(crate) fn pace(&self) -> Pace {
        let Poll { interval_ms, timeout_ms, late_limit_ms, .. } = *self;
        Pace { interval_ms, timeout_ms, late_limit_ms }
    }
}

/// A question asked once a connection.
#[derive(Clone, Debug, PartialEq)]
pub struct Hello {
    /// Its bytes.
    pub ask: Vec<u8>,
    /// Pattern of the answer.
    pub answer: Pattern,
    /// Time the answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
}

/// A queue of errors that must be asked for, as instruments with SCPI have it.
///
/// It is read to its end after the greeting, after each question without an answer, and in between.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorQueue {
    /// Bytes of the question for the oldest error.
    pub ask: Vec<u8>,
    /// Pattern of the answer of an empty queue.
    pub none: Pattern,
    /// Pattern of the answer with an error, tried after [`ErrorQueue::none`].
    pub entry: Pattern,
    /// Time an answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// Time from an empty queue to the next question for it, 100 to 3 600 000 ms.
    pub interval_ms: u32,
}

/// A frame by which the device says no.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Its pattern.
    pub pattern: Pattern,
    /// What it means, in words for a technician; may be empty.
    pub means: String,
}

impl Default for Settings {
    /// Lines of columns between blanks, and no field: a device with fields of one's own is to be made of it.
    fn default() -> Settings {
        Settings {
            framing: Framing::Lines { begin: Vec::new(), end: End::Any, longest: 256 },
            checksum: None,
            layout: Layout::Columns { separator: None, columns: None },
            fields: Vec::new(),
            profile: None,
            begins_whole: false,
            poll: None,
            hello: None,
            errors: None,
            on_connect: Vec::new(),
            on_start: Vec::new(),
            on_stop: Vec::new(),
            refusals: Vec::new(),
            ignore: Vec::new(),
            silence_ms: 50,
            gap_ms: 0,
        }
    }
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`crate::Described::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        check::settings(self)
    }

    /// Channels of the readings, in the order of the fields.
    pub fn channels(&self) -> Vec<Channel> {
        let channels = self.fields.iter().filter(|field| field.role == Role::Channel);
        channels.map(|field| Channel::new(field.name.clone(), field.unit)).collect()
    }

    /// Numbers of the trigger count, if there is one.
    pub fn count_modulus(&self) -> Option<u32> {
        self.fields.iter().find_map(|field| match field.role {
            Role::Count { modulus, .. } => Some(modulus),
            _ => None,
        })
    }

    /// Whether a record is held back until the next one begins.
    pub fn holds_back(&self) -> bool {
        matches!(self.framing, Framing::Records { .. })
            && self.checksum.is_none()
            && self.poll.is_none()
    }
}
