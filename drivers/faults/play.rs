//! A play: a driver and its device in virtual time, and one fault.

use std::time::Duration;

use asphera_link::{Command, Connection, Driver, Event, Input, Motion, MotionEvent, Nanos, Output};

use crate::journal::Journal;
use crate::line::{Delivery, Line, Meddling};
use crate::{Bench, Condition, Device, Expectation, Fault, Model, Outcome, verdict};

/// Plays a fault on a bench.
///
/// # Errors
///
/// The laws that were broken, and what differs from the expectation.
pub fn play(bench: &dyn Bench, fault: Fault) -> Result<Outcome, Vec<String>> {
    let marks = match bench.expects(fault) {
        Expectation::Absent(why) => return Ok(Outcome::Absent(why)),
        Expectation::Marks(marks) => marks,
    };
    let model = if fault == Fault::WrongDevice { Model::Stranger } else { Model::Right };
    let mut play = Play::new(bench, model);
    if fault != Fault::WrongDevice {
        play.measure(Duration::from_secs(10), "it never measures");
    }
    play.journal.begin_fault();
    play.happen(fault);
    play.line.meddling = Meddling::Nothing;
    play.measure(bench.recovery(), "no good readings after the fault");
    play.journal.end_fault();
    play.end();
    verdict::judge(&mut play.journal, play.now, marks)
}

/// Good readings in a row that show that all is well.
const PROOF: u64 = 3;
/// Wakes in a minute of silence that are no spin: one each 3 ms.
const MOST_WAKES: u64 = 20_000;
/// Wakes at one instant that are no spin.
const MOST_AT_ONCE: u32 = 50;
/// Time until a link that was given up is opened again.
const BACKOFF: Duration = Duration::from_millis(100);
/// Bytes of the flood.
const FLOOD_BYTES: usize = 10_000_000;
/// Bytes of the flood that come at once: as many as the transport reads.
const FLOOD_PIECE: usize = 4096;
/// Memory that may be in use after the flood and was not before, in bytes.
const MOST_GROWTH: u64 = 4_000_000;

struct Play<'a> {
    bench: &'a dyn Bench,
    driver: Box<dyn Driver>,
    device: Box<dyn Device>,
    line: Line,
    journal: Journal,
    now: Nanos,
    is_open: bool,
    /// The device neither hears nor speaks.
    is_muted: bool,
    is_burst: bool,
    next_tick: Option<Nanos>,
    reopen_at: Option<Nanos>,
    order_at: Option<Nanos>,
    /// An order was given, and has not ended.
    is_armed: bool,
    wakes: u64,
    at_once: u32,
    is_stuck: bool,
}

impl<'a> Play<'a> {
    fn new(bench: &'a dyn Bench, model: Model) -> Play<'a> {
        let device = bench.device(model);
        let mut play = Play {
            bench,
            driver: bench.driver(),
            line: Line::new(bench.has_datagrams()),
            journal: Journal::default(),
            now: Nanos::from_millis(1),
            is_open: false,
            is_muted: false,
            is_burst: false,
            next_tick: device.period().map(|period| Nanos::from_millis(1) + period),
            device,
            reopen_at: None,
            order_at: None,
            is_armed: false,
            wakes: 0,
            at_once: 0,
            is_stuck: false,
        };
        play.driver.command(play.now, Command::Start);
        play.open();
        play
    }

    fn open(&mut self) {
        self.is_open = true;
        self.reopen_at = None;
        self.journal.proofs += 1;
        self.device.opened();
        self.driver.connected(self.now);
        self.pump();
    }

    /// The link closes; what was on its way is lost.
    fn close(&mut self) {
        self.line.clear(self.now);
        if std::mem::take(&mut self.is_open) {
            self.driver.disconnected(self.now);
            (self.order_at, self.is_armed) = (None, false);
            self.drain_events();
            while self.driver.poll_transmit().is_some() {
                self.journal.broken(self.now, "something is to be sent on a closed link");
            }
        }
    }

    fn end(&mut self) {
        self.close();
        let (ends, proof) = (self.bench.has_line_ends(), self.bench.proof_bytes());
        self.journal.audit(self.now, ends, proof);
    }

    /// Takes all that the driver wants sent, and all that it has to say.
    fn pump(&mut self) {
        while let Some(parcel) = self.driver.poll_transmit() {
            if self.device.is_motion(&parcel) && !self.is_armed {
                self.journal.broken(self.now, format!("it moves unarmed: {parcel:?}"));
            }
            if !self.is_muted {
                for sent in self.device.receive(self.now, &parcel) {
                    self.line.send(self.now, sent);
                }
            }
        }
        if self.drain_events() {
            self.close();
            self.reopen_at = Some(self.now + BACKOFF);
        }
    }

    /// Whether a new connection is asked for.
    fn drain_events(&mut self) -> bool {
        let mut is_lost = false;
        while let Some(event) = self.driver.poll_event() {
            match &event {
                Event::Ready => self.order_at = Some(self.now + BACKOFF),
                Event::Motion(end) => {
                    self.is_armed = false;
                    let again = if *end == MotionEvent::Arrived { 1 } else { 5 };
                    self.order_at = Some(self.now + again * BACKOFF);
                }
                _ => {}
            }
            is_lost |= self.journal.take(self.now, event);
        }
        is_lost
    }

    fn order(&mut self, motion: &Motion) -> bool {
        self.is_armed = true;
        let is_taken = self.driver.motion(self.now, motion).is_ok();
        self.pump();
        self.is_armed &= is_taken;
        is_taken
    }

    /// Goes on until that time, or until `done`.
    fn run_until(&mut self, end: Nanos, done: impl Fn(&Play<'_>) -> bool) {
        while !done(self) && !self.is_stuck {
            let wake = if self.is_open { self.driver.poll_timeout() } else { None };
            let order_at = self.order_at.filter(|_| self.bench.order().is_some());
            let times = [self.line.next_at(), self.reopen_at, self.next_tick, order_at, wake];
            let Some(next) = times.into_iter().flatten().min().filter(|next| *next <= end) else {
                self.now = self.now.max(end);
                return;
            };
            if next > self.now {
                (self.now, self.at_once) = (next, 0);
            }
            let is_due = |time: Option<Nanos>| time.is_some_and(|time| time <= self.now);
            if is_due(self.line.next_at()) {
                if let Some(delivery) = self.line.pop() {
                    self.deliver(delivery);
                }
            } else if is_due(self.reopen_at) {
                self.open();
            } else if is_due(self.next_tick) {
                self.tick();
            } else if is_due(order_at) {
                self.order_at = None;
                if let Some(order) = self.bench.order().filter(|_| self.is_open && !self.is_armed)
                    && !self.order(&order)
                {
                    self.order_at = Some(self.now + 5 * BACKOFF);
                }
            } else {
                self.wake();
            }
        }
    }

    fn run(&mut self, time: Duration) {
        self.run_until(self.now + time, |_| false);
    }

    fn deliver(&mut self, delivery: Delivery) {
        if !self.is_open {
            return;
        }
        if let Some(sent) = &delivery.whole {
            self.journal.whole_frame(&sent.parcel, sent.is_measurement);
            if let Some(values) = &sent.values {
                self.journal.measured(values);
            }
        }
        if !delivery.is_foreign {
            self.journal.deliver(&delivery.parcel);
        }
        match &delivery.parcel {
            Output::Bytes(bytes) => {
                let input = match delivery.connection {
                    Connection::First => Input::Bytes(bytes),
                    Connection::Second => Input::Second(bytes),
                };
                self.driver.receive(self.now, input);
            }
            Output::Frame(frame) => self.driver.receive(self.now, Input::Frame(frame)),
        }
        self.pump();
    }

    fn tick(&mut self) {
        let period = self.device.period().unwrap_or(Duration::from_secs(1));
        self.next_tick = Some(self.now + if self.is_burst { period / 10 } else { period });
        if self.is_muted || self.line.is_busy(self.now) {
            return;
        }
        for sent in self.device.tick(self.now) {
            self.line.send(self.now, sent);
        }
    }

    fn wake(&mut self) {
        self.wakes += 1;
        self.at_once += 1;
        if self.at_once > MOST_AT_ONCE {
            self.journal.broken(self.now, "it spins: its time-out does not pass");
            self.is_stuck = true;
            return;
        }
        self.driver.timeout(self.now);
        self.pump();
    }

    /// Waits until good readings come.
    fn measure(&mut self, time: Duration, otherwise: &str) {
        let enough = self.journal.good + PROOF;
        self.run_until(self.now + time, |play| play.journal.good >= enough);
        if self.journal.good < enough {
            let found = PROOF - (enough - self.journal.good);
            self.journal.broken(self.now, format!("{otherwise}: {found} within {time:?}"));
        }
    }

    fn happen(&mut self, fault: Fault) {
        match fault {
            Fault::Unplugged => self.unplug(),
            Fault::Silent => {
                self.set_moving();
                self.mute(Duration::from_secs(60));
            }
            Fault::BusOff => self.mute(Duration::from_secs(3)),
            Fault::Slow => self.meddle(Meddling::Slow, 2),
            Fault::HalfFrame => self.meddle(Meddling::Half, 2),
            Fault::Repeated => self.meddle(Meddling::Twice, 2),
            Fault::BadChecksum => self.meddle(Meddling::Damaged, 2),
            Fault::LateAnswer => self.meddle(Meddling::Late(self.bench.lateness()), 2),
            Fault::Garbage => {
                self.meddle(Meddling::Noisy, 1);
                self.line.meddling = Meddling::Nothing;
                self.flood();
            }
            Fault::Restart => self.restart(),
            Fault::WrongDevice => {
                self.run(Duration::from_secs(10));
                if self.journal.is_online {
                    self.journal.broken(self.now, "another device is taken for the right one");
                }
                self.close();
                self.device = self.bench.device(Model::Right);
                self.open();
            }
            Fault::OutOfRange => self.be(Condition::OutOfRange, 1),
            Fault::Saturated => self.be(Condition::Saturated, 1),
            Fault::Stall => self.be(Condition::Stalled, 3),
            Fault::Limit => self.be(Condition::Limit, 3),
            Fault::ClockJump => {
                self.now = self.now + Duration::from_secs(3600);
                self.at_once = 0;
                self.run(Duration::from_secs(1));
            }
            Fault::Burst => {
                self.is_burst = true;
                self.run(Duration::from_secs(1));
                self.is_burst = false;
            }
        }
    }

    fn meddle(&mut self, meddling: Meddling, seconds: u64) {
        self.line.meddling = meddling;
        self.run(Duration::from_secs(seconds));
    }

    fn mute(&mut self, time: Duration) {
        self.is_muted = true;
        self.line.clear(self.now);
        let before = self.wakes;
        self.run(time);
        let wakes = self.wakes - before;
        if wakes > MOST_WAKES {
            self.journal.broken(self.now, format!("it spins: {wakes} wakes in {time:?}"));
        }
        self.is_muted = false;
    }

    fn be(&mut self, condition: Condition, seconds: u64) {
        self.device.condition(condition);
        let is_move = matches!(condition, Condition::Stalled | Condition::Limit);
        if let Some(movement) = self.bench.movement().filter(|_| is_move)
            && !self.order(&movement)
        {
            self.journal.broken(self.now, "a move is refused");
        }
        self.run(Duration::from_secs(seconds));
        self.device.condition(Condition::Good);
    }

    /// A stage is on its way when the fault comes.
    fn set_moving(&mut self) {
        if let Some(movement) = self.bench.movement() {
            self.order(&movement);
            self.run(Duration::from_millis(300));
        }
    }

    /// The cable is pulled in a measurement; the other half of it comes after the cable is back.
    fn unplug(&mut self) {
        self.set_moving();
        self.line.meddling = Meddling::Half;
        let limit = self.now + Duration::from_secs(5);
        self.run_until(limit, |play| {
            play.line.meddling == Meddling::Nothing && play.line.next_at().is_none()
        });
        self.close();
        self.run(Duration::from_secs(3));
        if let Some(half) = self.line.lost_half.take() {
            let at = self.now + Duration::from_millis(1);
            self.line.raw(at, Output::Bytes(half));
        }
        self.open();
    }

    fn restart(&mut self) {
        self.line.clear(self.now);
        let said = self.device.restart();
        if self.bench.restart_closes() {
            self.close();
            self.reopen_at = Some(self.now + Duration::from_millis(600));
        }
        self.is_muted = true;
        self.run(Duration::from_millis(500));
        self.is_muted = false;
        for sent in said {
            self.line.send(self.now, sent);
        }
        self.run(Duration::from_millis(100));
    }

    /// 10 MB of random bytes, and what is in memory after them.
    fn flood(&mut self) {
        let before = resident_bytes();
        let is_can = self.bench.is_can();
        let piece = if is_can { 8 } else { FLOOD_PIECE };
        // A frame takes a call each; so many take a second at 1 Mbit/s.
        let pieces = if is_can { 100_000 } else { FLOOD_BYTES / piece };
        let step = if is_can { Duration::from_micros(10) } else { Duration::from_millis(1) };
        for _ in 0..pieces {
            let at = self.now + step;
            let parcel = self.line.flood(is_can, piece);
            self.line.noise(at, parcel);
            self.run_until(at, |_| false);
        }
        if let Some((before, after)) = before.zip(resident_bytes())
            && after > before + MOST_GROWTH
        {
            let grown = after - before;
            self.journal.broken(self.now, format!("{grown} bytes more in memory after the flood"));
        }
    }
}

/// Memory in use by this process, in bytes; `None` where the system does not tell.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: u64 = line.trim().strip_suffix(" kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
