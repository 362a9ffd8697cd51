//! The laws of a play find drivers that break them.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_faults::{Bench, Device, Expectation, Fault, Mark, Model, Outcome, Sent, play};
use asphera_link::{
    AxisMove, Channel, Command, Driver, Event, FaultKind, Flags, Input, Motion, MotionFailure,
    Nanos, Output, Reading, Unit, Values,
};

/// Ways to be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cheat {
    /// None; but it knows no strangers, and no axes.
    Honest,
    /// Noise becomes readings.
    Believes,
    /// Bytes that it passes over are not counted.
    Swallows,
    /// Its time-out never passes.
    Spins,
    /// It wakes each millisecond.
    Hurries,
    /// All that came is held.
    Hoards,
    /// It moves as soon as it is connected.
    Moves,
    /// It says nothing of a silence, and reads nothing after it.
    Sulks,
    /// Its texts name no cure.
    Grumbles,
    /// It goes on talking on a link that is closed.
    Babbles,
}

/// Bytes of a frame: `#f`, the value twice, twice with all bits turned, `e!`.
const FRAME: usize = 8;

fn frame(value: u8) -> [u8; FRAME] {
    [b'#', b'f', value, value, !value, !value, b'e', b'!']
}

/// The value of a frame that begins here; inside `None` where more bytes must come, outside where none begins.
fn frame_value(bytes: &[u8], believes: bool) -> Option<Option<u8>> {
    let Some(bytes) = bytes.first_chunk::<FRAME>() else {
        let head = &bytes[..bytes.len().min(2)];
        return b"#f".starts_with(head).then_some(None);
    };
    let is_whole = *bytes == frame(bytes[2]);
    (is_whole || (believes && bytes.starts_with(b"#f"))).then_some(Some(bytes[2]))
}

struct Toy {
    cheat: Cheat,
    channels: Vec<Channel>,
    waiting: Vec<u8>,
    hoard: Vec<u8>,
    now: Nanos,
    last: Nanos,
    is_open: bool,
    events: VecDeque<Event>,
    outputs: VecDeque<Output>,
}

impl Toy {
    fn new(cheat: Cheat) -> Toy {
        Toy {
            cheat,
            channels: vec![Channel::new("z", Unit::Millimetre)],
            waiting: Vec::new(),
            hoard: Vec::new(),
            now: Nanos::ZERO,
            last: Nanos::ZERO,
            is_open: false,
            events: VecDeque::new(),
            outputs: VecDeque::new(),
        }
    }

    fn discard(&mut self, bytes: u64) {
        if bytes > 0 && self.cheat != Cheat::Swallows {
            self.events.push_back(Event::Discarded { bytes });
        }
    }

    fn reopen(&mut self) {
        let cure = if self.cheat == Cheat::Grumbles { "" } else { ": check the cable" };
        let detail = format!("no frame{cure}");
        let fault = asphera_link::Fault { kind: FaultKind::Timeout, detail };
        self.events.push_back(Event::Reopen(fault));
    }
}

impl Driver for Toy {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.waiting.clear();
        (self.is_open, self.now, self.last) = (true, now, now);
        if self.cheat == Cheat::Moves {
            self.outputs.push_back(Output::Bytes(b"move".to_vec()));
        }
    }

    fn disconnected(&mut self, _: Nanos) {
        self.discard(self.waiting.len() as u64);
        self.waiting.clear();
        self.is_open = false;
        if self.cheat == Cheat::Babbles {
            self.outputs.push_back(Output::Bytes(b"hello".to_vec()));
        }
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        if self.cheat == Cheat::Hoards {
            self.hoard.extend(bytes);
        }
        if self.cheat == Cheat::Sulks && now.since(self.last) > Duration::from_secs(1) {
            return self.discard(bytes.len() as u64);
        }
        (self.now, self.last) = (now, now);
        self.waiting.extend(bytes);
        let mut passed = 0;
        while !self.waiting.is_empty() {
            let len = match frame_value(&self.waiting, self.cheat == Cheat::Believes) {
                Some(Some(value)) => {
                    let values: Values = [Some(f64::from(value))].into_iter().collect();
                    let flags = Flags::empty();
                    let reading =
                        Reading { host: now, device_time_ns: None, count: None, values, flags };
                    self.events.push_back(Event::Reading(reading));
                    FRAME
                }
                Some(None) => break,
                None => {
                    passed += 1;
                    1
                }
            };
            self.waiting.drain(..len);
        }
        self.discard(passed);
    }

    fn timeout(&mut self, now: Nanos) {
        self.now = now;
        let is_silent = now.since(self.last) >= Duration::from_secs(1);
        if is_silent && ![Cheat::Sulks, Cheat::Hurries].contains(&self.cheat) {
            self.last = now;
            self.reopen();
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        match self.cheat {
            Cheat::Spins => Some(self.last + Duration::from_millis(500)),
            Cheat::Hurries => Some(self.now + Duration::from_millis(1)),
            _ => Some(self.last + Duration::from_secs(1)).filter(|_| self.cheat != Cheat::Sulks),
        }
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn command(&mut self, _: Nanos, _: Command) {}

    fn motion(&mut self, _: Nanos, _: &Motion) -> Result<(), MotionFailure> {
        Err(MotionFailure::without_axes())
    }
}

/// A device that counts, a frame each 10 ms.
struct Counter {
    model: Model,
    value: u8,
}

impl Device for Counter {
    fn receive(&mut self, _: Nanos, _: &Output) -> Vec<Sent> {
        Vec::new()
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        self.value = self.value % 200 + 1;
        match self.model {
            Model::Right => {
                vec![Sent::good(frame(self.value), vec![Some(f64::from(self.value))])]
            }
            Model::Stranger => vec![Sent::answer(frame(self.value))],
        }
    }

    fn is_motion(&self, parcel: &Output) -> bool {
        *parcel == Output::Bytes(b"move".to_vec())
    }
}

struct Table(Cheat);

impl Bench for Table {
    fn name(&self) -> &'static str {
        "toy"
    }

    fn driver(&self) -> Box<dyn Driver> {
        Box::new(Toy::new(self.0))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Counter { model, value: 0 })
    }

    fn movement(&self) -> Option<Motion> {
        let axis = "z".to_owned();
        Some(Motion::Move(vec![AxisMove { axis, to: 1.0, speed: 1.0, acceleration: None }]))
    }

    fn expects(&self, fault: Fault) -> Expectation {
        match fault {
            Fault::Silent => Expectation::Marks(&[Mark::Reopened("no frame: check the cable")]),
            Fault::HalfFrame | Fault::BadChecksum | Fault::Unplugged => {
                Expectation::Marks(&[Mark::Discarded])
            }
            Fault::BusOff => Expectation::Absent("it is on no bus"),
            _ => Expectation::Marks(&[]),
        }
    }
}

/// One test, since the memory of the process is measured in it.
#[test]
fn a_driver_that_breaks_a_law_is_found() {
    for (cheat, fault, words) in [
        (Cheat::Believes, Fault::BadChecksum, "that was not sent"),
        (Cheat::Swallows, Fault::HalfFrame, "accounted for"),
        (Cheat::Spins, Fault::Silent, "it spins: its time-out does not pass"),
        (Cheat::Hurries, Fault::Silent, "wakes in 60s"),
        (Cheat::Hoards, Fault::Garbage, "bytes more in memory after the flood"),
        (Cheat::Moves, Fault::Slow, "it moves unarmed"),
        (Cheat::Sulks, Fault::Silent, "no good readings after the fault"),
        (Cheat::Grumbles, Fault::Silent, "a text that helps nobody: no frame"),
        (Cheat::Babbles, Fault::Unplugged, "to be sent on a closed link"),
        (Cheat::Honest, Fault::Stall, "a move is refused"),
        (Cheat::Honest, Fault::WrongDevice, "a good reading"),
        (Cheat::Honest, Fault::Garbage, "bytes discarded, expected any: false"),
    ] {
        let laws = match play(&Table(cheat), fault) {
            Err(laws) => laws.join("\n"),
            Ok(outcome) => format!("{outcome:?}"),
        };
        assert!(laws.contains(words), "{cheat:?}: {laws}");
    }
    let cell = |fault| play(&Table(Cheat::Honest), fault);
    let played = |words: &str| Outcome::Played(words.to_owned(), Vec::new());
    assert_eq!(cell(Fault::HalfFrame), Ok(played("discarded")));
    assert_eq!(cell(Fault::Slow), Ok(played("goes on")));
    assert_eq!(cell(Fault::BusOff), Ok(Outcome::Absent("it is on no bus")));
    let text = vec!["no frame: check the cable".to_owned()];
    assert_eq!(cell(Fault::Silent), Ok(Outcome::Played("reopened".to_owned(), text)));
}
