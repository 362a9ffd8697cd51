//! Driver and machine in virtual time.

use asphera_ippdme::FAMILY;
use asphera_link::{
    Command, Driver, Event, Flags, Input, Motion, MotionEvent, Nanos, Output, Reading,
};
use asphera_sim_ippdme::{Fault, Machine, MachineSettings, Probe, Surface};

struct Pair {
    driver: Box<dyn Driver>,
    machine: Machine,
    now: Nanos,
    events: Vec<Event>,
    sent: Vec<String>,
}

const PROGRAM: &str = "commands = ['Home()', 'ChangeTool(\"Probe1\")', 'PtMeas(X(1), Y(2), Z(0), IJK(0,0,1))', \
                       'GoTo(Z(10))', 'ScanOnLine(-5,0,0,5,0,0,0,0,1,0.1)', \
                       'ScanOnCircle(0,0,0,4,0,0,0,0,1,360,90,3)']";

impl Pair {
    fn new(settings: &str, machine: MachineSettings) -> Pair {
        let settings = FAMILY.parse("cmm", settings).expect("settings of a test are sound");
        let driver = settings.driver().expect("settings of a test are sound");
        let mut pair = Pair {
            driver,
            machine: Machine::new(machine),
            now: Nanos::ZERO,
            events: Vec::new(),
            sent: Vec::new(),
        };
        pair.machine.connected(0.0);
        pair.driver.connected(pair.now);
        pair.driver.command(pair.now, Command::Start);
        pair.talk();
        pair
    }

    /// A program under way.
    fn running(settings: &str, machine: MachineSettings) -> Pair {
        let mut pair = Pair::new(settings, machine);
        assert_eq!(pair.events, [Event::Online, Event::Ready]);
        pair.driver.motion(pair.now, &Motion::Run).expect("the machine is ready");
        pair.talk();
        pair
    }

    fn now_s(&self) -> f64 {
        self.now.as_nanos() as f64 * 1e-9
    }

    fn talk(&mut self) {
        loop {
            let before = self.sent.len();
            while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
                self.sent.push(String::from_utf8(bytes.clone()).expect("ASCII"));
                self.machine.receive(self.now_s(), &bytes);
            }
            let answers = self.machine.poll_transmit(self.now_s());
            if answers.is_empty() && before == self.sent.len() {
                break;
            }
            self.driver.receive(self.now, Input::Bytes(&answers));
            self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    /// Goes on until something became of the order, and 1000 s at most.
    fn finish(&mut self) -> MotionEvent {
        let is_over = |event: &Event| match event {
            Event::Motion(motion) => Some(motion.clone()),
            _ => None,
        };
        for _ in 0..1_000_000 {
            if let Some(motion) = self.events.iter().find_map(is_over) {
                return motion;
            }
            self.now = self.now + std::time::Duration::from_millis(1);
            if self.driver.poll_timeout().is_some_and(|due| due <= self.now) {
                self.driver.timeout(self.now);
            }
            self.talk();
        }
        panic!("{:?}", self.events);
    }

    fn readings(&self) -> Vec<Reading> {
        let reading = |event: &Event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        };
        self.events.iter().filter_map(reading).collect()
    }

    fn faults(&self) -> Vec<String> {
        let fault = |event: &Event| match event {
            Event::Fault(fault) | Event::Reopen(fault) => Some(fault.detail.clone()),
            _ => None,
        };
        self.events.iter().filter_map(fault).collect()
    }
}

fn bowl() -> MachineSettings {
    let surface = Surface::new(|[x, y]| {
        let square = 1600.0 - x * x - y * y;
        (x.hypot(y) < 20.0).then(|| 40.0 - square.sqrt())
    });
    MachineSettings { probe: Probe { surface, radius_mm: 1.0 }, ..MachineSettings::usual() }
}

/// All points lie on the sphere of the centres, R 39 mm about (0, 0, 40), to the digits of the protocol.
#[test]
fn a_program_measures_centres_of_the_ball() {
    let mut pair = Pair::running(PROGRAM, bowl());
    assert_eq!(pair.finish(), MotionEvent::Arrived);
    let readings = pair.readings();
    assert_eq!(readings.len(), 1 + 101 + 121);
    for reading in &readings {
        let at = |channel| reading.values.get(channel).expect("a coordinate");
        let radius = (at(0).powi(2) + at(1).powi(2) + (at(2) - 40.0).powi(2)).sqrt();
        assert!((radius - 39.0).abs() < 1.5e-5, "{radius}");
        assert!(reading.flags.is_empty());
    }
    let [first, second] = [101, 102].map(|at| readings[at].host);
    assert!(first < second, "points come while they are measured");
    assert!(pair.faults().is_empty(), "{:?}", pair.faults());
    pair.driver.command(pair.now, Command::Stop);
    pair.talk();
    assert!(pair.sent.last().unwrap().ends_with("EndSession()\r\n"));
}

#[test]
fn a_halt_stops_the_machine_where_it_is() {
    let mut pair = Pair::running(PROGRAM, bowl());
    while pair.readings().len() < 30 {
        pair.now = pair.now + std::time::Duration::from_millis(1);
        pair.talk();
    }
    let measured = pair.readings().len();
    assert!(pair.machine.is_moving());
    pair.driver.motion(pair.now, &Motion::Halt).unwrap();
    pair.talk();
    assert!(!pair.machine.is_moving());
    assert_eq!(pair.finish(), MotionEvent::Halted);
    let place = pair.machine.place_mm(pair.now_s());
    assert_eq!(pair.machine.place_mm(pair.now_s() + 100.0), place);
    assert_eq!((pair.readings().len(), pair.faults().len()), (measured, 0));
    pair.events.clear();
    pair.driver.motion(pair.now, &Motion::Run).expect("it may begin anew");
    pair.talk();
    assert_eq!(pair.finish(), MotionEvent::Arrived);
}

#[test]
fn the_halt_past_the_state_machine_stops_it_too() {
    let mut pair = Pair::running(PROGRAM, bowl());
    assert!(pair.machine.is_moving());
    let halt = pair.driver.halt_bytes().expect("a machine that moves");
    pair.machine.receive(pair.now_s(), &halt);
    pair.talk();
    assert!(!pair.machine.is_moving());
    assert!(
        matches!(pair.finish(), MotionEvent::Failed(failure) if failure.detail.contains("aborted"))
    );
}

#[test]
fn errors_of_the_machine_end_the_program_or_a_point() {
    let mut pair = Pair::running(PROGRAM, bowl());
    pair.machine.fault(0.0, Fault::NoTouch);
    assert_eq!(pair.finish(), MotionEvent::Arrived);
    assert_eq!(pair.readings().len(), 101 + 121);
    assert!(pair.faults()[0].contains("error 1006"), "{:?}", pair.faults());
    for (fault, words) in [
        (Fault::Collision, "take away what the probe ran into"),
        (Fault::EmergencyStop, "release the emergency stop"),
    ] {
        let mut pair = Pair::running(PROGRAM, bowl());
        pair.machine.fault(0.0, fault);
        pair.talk();
        let MotionEvent::Failed(failure) = pair.finish() else { panic!("a failure") };
        assert!(failure.detail.contains(words), "{}", failure.detail);
        assert!(!pair.machine.is_moving());
    }
    let mut pair = Pair::running("commands = ['PtMeas(X(0), Y(0), Z(0))']", bowl());
    assert!(
        matches!(pair.finish(), MotionEvent::Failed(failure) if failure.detail.contains("2501"))
    );
    let far = "commands = ['Home()', 'GoTo(X(10000000))', 'PtMeas(X(0), Y(0), Z(0))']";
    let mut pair = Pair::running(far, bowl());
    assert!(
        matches!(pair.finish(), MotionEvent::Failed(failure) if failure.detail.contains("1008"))
    );
}

#[test]
fn damaged_lines_cost_their_points_alone_or_the_connection() {
    let mut pair = Pair::running(PROGRAM, bowl());
    pair.machine.fault(0.0, Fault::OddLine);
    assert_eq!(pair.finish(), MotionEvent::Arrived);
    assert_eq!(pair.readings().len(), 1 + 101 + 121 - 50);
    assert!(
        pair.faults()[0].contains("151 numbers in a line of ScanOnLine"),
        "{:?}",
        pair.faults()
    );
    for fault in [Fault::ForeignTag, Fault::Noise] {
        let mut pair = Pair::running(PROGRAM, bowl());
        pair.machine.fault(0.0, fault);
        pair.talk();
        let is_reopened = pair.events.iter().any(|event| matches!(event, Event::Reopen(_)));
        assert!(is_reopened && pair.readings().is_empty(), "{fault:?}");
    }
}

#[test]
fn poor_points_are_flagged() {
    let program = format!("{PROGRAM}\nquality_limit = 50");
    let mut pair = Pair::running(&program, bowl());
    pair.machine.fault(0.0, Fault::PoorPoints(7));
    assert_eq!(pair.finish(), MotionEvent::Arrived);
    let weak = pair.readings().iter().filter(|reading| reading.flags == Flags::WEAK).count();
    assert_eq!((weak, pair.readings().len()), (7, 223));
}

#[test]
fn a_silent_machine_is_given_up() {
    let mut pair = Pair::running(&format!("{PROGRAM}\ntimeout_ms = 100\nsilence_s = 1"), bowl());
    pair.machine.fault(0.0, Fault::Silent(true));
    let MotionEvent::Failed(failure) = pair.finish() else { panic!("a failure") };
    assert!(failure.detail.contains("press the emergency stop"), "{}", failure.detail);
    assert!(!pair.machine.is_moving(), "it was halted although it did not say so");
}
