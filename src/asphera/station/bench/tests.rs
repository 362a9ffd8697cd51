//! Who is started when, and what deadlines mean to a host that was held up.

use super::super::framing::Framing;
use super::super::kinematics::{Axis, Source};
use super::super::synchronizer::SyncSettings;
use super::super::thermal::{Expansion, Temperature, ThermalSettings};
use super::*;
use asphera_link::{Channel, Driver, Event, Fault, FaultKind, Flags, Input, Output, Reading, Unit};

/// A device that is ready when it says `r`, reads 30 when it says `t`, starts at a word, and must say something every second.
struct Alive {
    channels: Vec<Channel>,
    name: u8,
    due: Option<Nanos>,
    sent: VecDeque<Output>,
    told: VecDeque<Event>,
}

impl Alive {
    fn boxed(name: u8) -> Box<dyn Driver> {
        let channels = vec![Channel::new("length", Unit::Millimetre)];
        let (sent, told) = Default::default();
        Box::new(Alive { channels, name, due: None, sent, told })
    }
}

impl Driver for Alive {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.due = Some(now + SECOND);
    }

    fn disconnected(&mut self, _: Nanos) {
        self.due = None;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        self.due = Some(now + SECOND);
        if matches!(input, Input::Bytes(b"r")) {
            self.told.push_back(Event::Ready);
        }
        if matches!(input, Input::Bytes(b"t")) {
            let values = [Some(30.0)].into_iter().collect();
            let (device_time_ns, count, flags) = (None, None, Flags::empty());
            let reading = Reading { host: now, device_time_ns, count, values, flags };
            self.told.push_back(Event::Reading(reading));
        }
    }

    fn timeout(&mut self, _: Nanos) {
        self.due = None;
        let detail = format!("no sign of life of {}", char::from(self.name));
        self.told.push_back(Event::Fault(Fault { kind: FaultKind::Timeout, detail }));
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        self.due
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.sent.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.told.pop_front()
    }

    fn command(&mut self, _: Nanos, command: Command) {
        let word = if command == Command::Start { b'S' } else { b'H' };
        self.sent.push_back(Output::Bytes(vec![self.name, word]));
    }
}

/// A primary `p` and a companion `c`, each on a link that is open.
fn bench() -> Bench {
    bench_of(EndSettings { points: None, idle: None, first: None, open: None }, None)
}

/// The same, with the temperature of the part from the companion.
fn thermal_bench() -> Bench {
    let temperature = Temperature::Channel { device: 1, channel: 0 };
    let part = Expansion { temperature, per_k: 1e-3, u_per_k: 0.0, u_k: 0.0 };
    let settings = ThermalSettings {
        part: Some(part),
        scales: None,
        stale: SECOND,
        range_degc: (10.0, 40.0),
        starts_with_angle: false,
    };
    let mut bench = bench();
    bench.thermal = Some(Thermal::new(settings, vec![(0, 0), (1, 0)]));
    bench
}

/// The same with an end, and perhaps a device whose program the station runs.
fn bench_of(end: EndSettings, program: Option<usize>) -> Bench {
    let line = |name: &str| {
        let device = (name.to_owned(), Alive::boxed(name.as_bytes()[0]));
        Line::new(name.to_owned(), Framing::Raw, vec![device])
    };
    let axis = Axis {
        source: Some(Source { stream: 0, channel: 0 }),
        scale: 1.0,
        offset: 0.0,
        errors: None,
    };
    let mut bench = Bench::new(BenchSettings {
        lines: vec![line("p"), line("c")],
        streams: vec![(0, 0), (1, 0)],
        join: JoinSettings::Count {
            settings: SyncSettings { wait: SECOND, capacity: 100, paced: true },
            clocks: Vec::new(),
        },
        kinematics: Kinematics::Cartesian { x: axis.clone(), y: axis.clone(), z: axis },
        calibration: None,
        thermal: None,
        tip: None,
        end,
        scan: None,
        program,
    });
    for line in 0..2 {
        bench.happened(Nanos::ZERO, line, Happening::Opened { epoch: 1 });
    }
    bench
}

/// What was sent since the last look, in order.
fn sent(bench: &mut Bench) -> String {
    std::iter::from_fn(|| bench.poll_action())
        .filter_map(|action| match action {
            Action::Send { bytes, .. } => Some(String::from_utf8(bytes).unwrap()),
            _ => None,
        })
        .collect()
}

fn faults(bench: &Bench) -> u64 {
    bench.lines().iter().map(Line::errors).sum()
}

const SECOND: Duration = Duration::from_secs(1);

fn ms(ms: u64) -> Nanos {
    Nanos::from_millis(ms)
}

#[test]
fn the_primary_is_started_when_its_companion_is_ready() {
    let mut bench = bench();
    bench.command(ms(1), Command::Start);
    assert_eq!(sent(&mut bench), "cS");
    bench.happened(ms(300), 1, Happening::Received(b"?"));
    assert_eq!(sent(&mut bench), "");
    bench.happened(ms(500), 1, Happening::Received(b"r"));
    assert_eq!(sent(&mut bench), "pS");
    bench.advance(ms(20_000));
    assert_eq!(sent(&mut bench), "");
    bench.command(ms(20_000), Command::Stop);
    assert_eq!(sent(&mut bench), "pHcH");
}

#[test]
fn a_companion_that_was_ready_before_holds_nothing_back() {
    let mut bench = bench();
    bench.happened(ms(1), 1, Happening::Received(b"r"));
    bench.command(ms(2), Command::Start);
    assert_eq!(sent(&mut bench), "pScS");
}

#[test]
fn a_companion_that_is_not_there_holds_the_primary_back_for_five_seconds() {
    let mut bench = bench();
    bench.command(ms(1), Command::Start);
    assert_eq!(sent(&mut bench), "cS");
    bench.advance(ms(5_000));
    assert_eq!(sent(&mut bench), "");
    bench.advance(ms(5_001));
    assert_eq!(sent(&mut bench), "pS");
}

#[test]
fn the_primary_is_started_when_the_temperature_is_known_too() {
    let mut bench = thermal_bench();
    bench.command(ms(1), Command::Start);
    bench.happened(ms(300), 1, Happening::Received(b"r"));
    assert_eq!(sent(&mut bench), "cS");
    bench.happened(ms(500), 1, Happening::Received(b"t"));
    assert_eq!(sent(&mut bench), "pS");
    let mut cold = thermal_bench();
    cold.command(ms(1), Command::Start);
    cold.happened(ms(300), 1, Happening::Received(b"r"));
    cold.advance(ms(5_001));
    assert_eq!(sent(&mut cold), "cSpS");
}

#[test]
fn a_scan_that_is_stopped_before_its_companion_came_is_not_started_any_more() {
    let mut bench = bench();
    bench.command(ms(1), Command::Start);
    bench.command(ms(2), Command::Stop);
    assert_eq!(sent(&mut bench), "cSpHcH");
    bench.happened(ms(3), 1, Happening::Received(b"r"));
    bench.advance(ms(20_000));
    assert_eq!(sent(&mut bench), "");
}

/// The signs of life lay in a buffer while the host did not run for two seconds.
#[test]
fn what_a_host_that_was_held_up_had_not_read_was_not_missed() {
    let mut bench = bench();
    bench.happened(ms(900), 0, Happening::Received(b"."));
    bench.held_up(ms(2_900), Duration::ZERO);
    for line in 0..2 {
        bench.happened(ms(2_950), line, Happening::Received(b"."));
    }
    bench.advance(ms(3_940));
    assert_eq!(faults(&bench), 0);
    // From then on deadlines are what they were.
    bench.advance(ms(3_950));
    assert_eq!(faults(&bench), 2);
}

#[test]
fn what_did_not_come_before_a_hold_up_or_after_was_missed() {
    let mut bench = bench();
    bench.held_up(ms(2_000), Duration::ZERO);
    bench.happened(ms(2_010), 0, Happening::Received(b"."));
    bench.advance(ms(2_249));
    assert_eq!((faults(&bench), bench.poll_timeout()), (0, Some(ms(2_250))));
    bench.advance(ms(2_250));
    assert_eq!(faults(&bench), 1);
    // Without a hold-up nothing is put off.
    let mut late = self::bench();
    late.happened(ms(2_010), 0, Happening::Received(b"."));
    assert_eq!(faults(&late), 2);
}

/// Timers stand still while a computer is suspended; the time that passed counts all the same.
#[test]
fn a_suspended_time_holds_deadlines_up_and_counts_from_the_first_reading_on() {
    let mut bench = bench();
    bench.held_up(ms(3_600_000), ms(3_599_000).since(Nanos::ZERO));
    assert_eq!(bench.suspended(), Duration::ZERO, "nothing was being measured");
    bench.advance(ms(3_600_249));
    assert_eq!(faults(&bench), 0);
    bench.last_primary = Some(ms(3_600_249));
    bench.held_up(ms(7_200_000), SECOND);
    bench.held_up(ms(7_300_000), SECOND);
    assert_eq!(bench.suspended(), 2 * SECOND);
}

/// However long nobody arms it. These devices refuse every order, so the program breaks off at once.
#[test]
fn silence_is_no_end_of_a_program_until_it_broke_off() {
    let second = Some(SECOND);
    let end = EndSettings { points: None, idle: second, first: second, open: None };
    let mut bench = bench_of(end, Some(0));
    bench.command(ms(1), Command::Start);
    assert!(bench.first_by().is_some(), "a device that does not answer is given up");
    for line in 0..2 {
        bench.happened(ms(10), line, Happening::Received(b"r"));
    }
    bench.advance(ms(3_600_000));
    assert_eq!((bench.first_by(), bench.idle_at()), (None, None));
    bench.scan(ms(3_600_000), &ScanOrder::Arm).unwrap();
    let figures = bench.scanner().unwrap().figures(ms(3_600_000));
    assert!(figures.text.contains("the driver of this device moves nothing"), "{figures:?}");
    assert!(bench.first_by().is_some_and(|due| due <= ms(3_600_000)));
    assert_eq!(bench.scan(ms(3_600_001), &ScanOrder::Arm), Err(ArmError::BrokenOff));
}
