//! A described device at work: what it answers, and what it sends by itself.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::mpsc;

use crate::connection::{QUEUE, Talker};
use crate::example::Example;
use crate::frame::{Frames, Moment};
use crate::showing::Showing;
use crate::sight::Sight;

/// A device that several tasks share.
pub(crate) struct Voice {
    device: usize,
    frames: Frames,
    /// Of a line scanner.
    sight: Option<Sight>,
    /// Whether it gives no more answers once the scan is over, as what measures by a trigger: else a scan that ends with silence
    /// would never end.
    falls_silent: bool,
    showing: Arc<Showing>,
    /// To the connection. While the host does not read, the scan waits.
    sent: mpsc::Sender<Vec<u8>>,
    host: Mutex<Host>,
}

/// What is known of the host.
#[derive(Debug, Default)]
struct Host {
    is_there: bool,
    /// It has said all that starts the device.
    has_started: bool,
    /// Bytes that are no command yet.
    heard: Vec<u8>,
    /// Frames sent to answer a question.
    answers: u64,
}

/// What the host said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Saying {
    Question,
    Greeting,
    Errors,
    Start,
    Stop,
    Setup,
}

impl Voice {
    /// A device, and what it sends by itself.
    pub(crate) fn new(
        device: usize,
        (frames, sight): (Frames, Option<Sight>),
        falls_silent: bool,
        showing: Arc<Showing>,
    ) -> (Arc<Voice>, mpsc::Receiver<Vec<u8>>) {
        let (sent, queue) = mpsc::channel(QUEUE);
        (
            {
                let falls_silent = falls_silent && showing.changes(device);
                Arc::new(Voice {
                    device,
                    frames,
                    sight,
                    falls_silent,
                    showing,
                    sent,
                    host: Mutex::default(),
                })
            },
            queue,
        )
    }

    /// Whether it sends by itself.
    pub(crate) fn is_triggered(&self) -> bool {
        self.frames.settings().poll.is_none()
    }

    /// Whether a host waits for its readings.
    pub(crate) fn is_armed(&self) -> bool {
        let host = self.host();
        let on_start = &self.frames.settings().on_start;
        host.is_there
            && (host.has_started || on_start.is_empty())
            && (self.is_triggered() || host.answers > 0)
    }

    /// Sends a frame, where a host wants it.
    pub(crate) async fn trigger(&self, trigger: u64) {
        if !self.is_triggered() || !self.is_armed() {
            return;
        }
        let values = self.showing.at(self.device, trigger);
        let frame = self.frame(trigger, &values);
        // The connection ends with the stand.
        drop(self.sent.send(frame).await);
    }

    fn frame(&self, trigger: u64, values: &[f64]) -> Vec<u8> {
        let clock_s = self.showing.clock_s();
        self.frames.bytes(&Moment { trigger, clock_s, values, sight: self.sight.as_ref() })
    }

    /// The longest saying with which these bytes begin.
    fn saying(&self, bytes: &[u8]) -> Option<(usize, Saying)> {
        let begins = |(words, _): &(&[u8], Saying)| !words.is_empty() && bytes.starts_with(words);
        let longest = self.sayings().filter(begins).max_by_key(|(words, _)| words.len());
        longest.map(|(words, saying)| (words.len(), saying))
    }

    fn may_begin(&self, bytes: &[u8]) -> bool {
        self.sayings().any(|(words, _)| words.len() > bytes.len() && words.starts_with(bytes))
    }

    fn sayings(&self) -> impl Iterator<Item = (&[u8], Saying)> {
        let settings = self.frames.settings();
        let question = settings.poll.iter().map(|poll| (&poll.ask[..], Saying::Question));
        let greeting = settings.hello.iter().map(|hello| (&hello.ask[..], Saying::Greeting));
        let errors = settings.errors.iter().map(|errors| (&errors.ask[..], Saying::Errors));
        let said = [
            (&settings.on_start, Saying::Start),
            (&settings.on_stop, Saying::Stop),
            (&settings.on_connect, Saying::Setup),
        ];
        let said = said
            .into_iter()
            .flat_map(|(words, saying)| words.iter().map(move |words| (&words[..], saying)));
        // Of two of one length the last counts: a question that greets too is one.
        said.chain(errors).chain(greeting).chain(question)
    }

    fn answer(&self, saying: Saying) -> Vec<u8> {
        let settings = self.frames.settings();
        let words = |pattern| Example::new(pattern).map(|example| example.text(&|_| None));
        match saying {
            Saying::Question if self.falls_silent && self.showing.is_over() => Vec::new(),
            Saying::Question => {
                self.host().answers += 1;
                self.frame(self.showing.trigger(), &self.showing.now(self.device))
            }
            Saying::Greeting => {
                let answer = settings.hello.as_ref().and_then(|hello| words(&hello.answer));
                answer.map_or_else(Vec::new, |words| self.frames.line(words))
            }
            Saying::Errors => {
                let answer = settings.errors.as_ref().and_then(|errors| words(&errors.none));
                answer.map_or_else(Vec::new, |words| self.frames.line(words))
            }
            Saying::Start | Saying::Stop => {
                self.host().has_started = saying == Saying::Start;
                Vec::new()
            }
            Saying::Setup => Vec::new(),
        }
    }

    fn host(&self) -> MutexGuard<'_, Host> {
        // Whoever panicked left whole values.
        self.host.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Talker for Voice {
    fn connected(&self) {
        *self.host() = Host { is_there: true, ..Host::default() };
    }

    fn hear(&self, bytes: &[u8]) -> Vec<u8> {
        let mut heard = std::mem::take(&mut self.host().heard);
        heard.extend_from_slice(bytes);
        let (mut at, mut answers) = (0, Vec::new());
        while at < heard.len() {
            match self.saying(&heard[at..]) {
                Some((len, saying)) => {
                    answers.extend(self.answer(saying));
                    at += len;
                }
                None if self.may_begin(&heard[at..]) => break,
                None => at += 1,
            }
        }
        self.host().heard = heard.split_off(at);
        answers
    }

    fn disconnected(&self) {
        *self.host() = Host::default();
    }
}
