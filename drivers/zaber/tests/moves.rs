//! Moves in virtual time. Bytes are those of other programs, not of our encoder.
//!
//! Sources: `/1 1 move abs 10234`, `/1 0 stop` and their replies stand in the tests of `zaber-python`, `set maxspeed` and its
//! factor 1.6384 in programs of users, numbers of messages in `zproto`. README.md lists them.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use asphera_link::{
    AxisMove, Driver, Event, Input, Motion, MotionEvent, MotionFailure, MotionTrouble, Nanos,
    Output,
};
use asphera_zaber::FAMILY;

struct Bench {
    driver: Box<dyn Driver>,
    now: Nanos,
    sent: Vec<String>,
    events: Vec<Event>,
}

/// 0.2 µm: 5000 microsteps a mm.
const STAGE: &str = "interval_ms = 1000\naxis = [{ name = 'x', microstep_um = 0.2 }, { name = 'y', microstep_um = 0.2 }]";

impl Bench {
    /// A stage that answered with its first position, without a warning.
    fn new(settings: &str) -> Bench {
        let settings = FAMILY.parse("stage", settings).unwrap();
        let mut bench = Bench {
            driver: settings.driver().unwrap(),
            now: Nanos::ZERO,
            sent: vec![],
            events: vec![],
        };
        assert!(settings.moves_axes());
        bench.driver.connected(bench.now);
        bench.drain();
        bench
    }

    fn ready() -> Bench {
        let mut bench = Bench::new(STAGE);
        bench.receive("@01 0 OK IDLE -- 0 0\r\n");
        bench.receive("@01 0 OK IDLE -- 0 0\r\n");
        bench.sent.clear();
        bench
    }

    fn receive(&mut self, bytes: &str) {
        self.driver.receive(self.now, Input::Bytes(bytes.as_bytes()));
        self.drain();
    }

    fn next_timeout(&mut self) {
        self.now = self.driver.poll_timeout().expect("the driver waits for something");
        self.driver.timeout(self.now);
        self.drain();
    }

    fn drain(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            self.sent.push(String::from_utf8(bytes).unwrap());
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    fn order(&mut self, motion: &Motion) -> Result<(), MotionFailure> {
        let result = self.driver.motion(self.now, motion);
        self.drain();
        result
    }

    fn go(&mut self, axis: &str, to: f64, speed: f64) -> Result<(), MotionFailure> {
        self.order(&Motion::Move(vec![one(axis, to, speed)]))
    }

    /// A move whose stage answers that it has no warnings.
    fn begin(&mut self, moves: Vec<AxisMove>) {
        self.order(&Motion::Move(moves)).unwrap();
        let asked = self.sent.pop().unwrap();
        let number = asked
            .strip_prefix("/1 0 ")
            .and_then(|words| words.strip_suffix(" warnings\n"))
            .unwrap()
            .to_owned();
        self.receive(&format!("@01 0 {number} OK IDLE -- 00\r\n"));
    }

    /// The next question for the position, and its answer.
    fn position(&mut self, reply: &str) {
        let asked = self.sent.len();
        while !self.sent[asked..].iter().any(|sent| sent.ends_with("get pos\n")) {
            self.next_timeout();
        }
        self.receive(reply);
    }

    fn motions(&self) -> Vec<&MotionEvent> {
        let events = self.events.iter();
        events
            .filter_map(|event| match event {
                Event::Motion(motion) => Some(motion),
                _ => None,
            })
            .collect()
    }

    fn failure(&self) -> &MotionFailure {
        match self.motions()[..] {
            [MotionEvent::Failed(failure)] => failure,
            ref other => panic!("{other:?}"),
        }
    }

    fn readings(&self) -> usize {
        self.events.iter().filter(|event| matches!(event, Event::Reading(_))).count()
    }
}

fn one(axis: &str, to: f64, speed: f64) -> AxisMove {
    AxisMove { axis: axis.to_owned(), to, speed, acceleration: None }
}

#[test]
fn a_move_is_commanded_step_by_step_and_arrives() {
    let mut bench = Bench::ready();
    bench.go("x", 2.0468, 1.0).unwrap();
    assert_eq!(bench.sent, ["/1 0 0 warnings\n"]);
    bench.receive("@01 0 00 OK IDLE NI 01 NI\r\n");
    assert_eq!(bench.sent[1], "/1 1 1 set maxspeed 8192\n");
    bench.receive("@01 1 01 OK IDLE NI 0\r\n");
    assert_eq!(bench.sent[2], "/1 1 2 move abs 10234\n");
    bench.receive("@01 1 02 OK BUSY -- 0\r\n");
    let readings = bench.readings();
    bench.position("@01 0 OK BUSY -- 5000 0\r\n");
    assert!(bench.motions().is_empty());
    bench.position("@01 0 OK IDLE -- 10234 0\r\n");
    assert_eq!(bench.motions(), [&MotionEvent::Arrived]);
    assert_eq!(bench.readings(), readings + 2, "replies to commands are no positions");

    // The speed is that which was set.
    bench.sent.clear();
    bench.begin(vec![one("x", 0.0, 1.0)]);
    assert_eq!(bench.sent, ["/1 1 4 move abs 0\n"]);
}

#[test]
fn two_axes_get_their_speeds_first_and_start_together() {
    let mut bench = Bench::ready();
    let mut x = one("x", 1.0, 2.0);
    x.acceleration = Some(100.0);
    bench.begin(vec![x, one("y", -0.5, 1.0)]);
    for reply in ["@01 1 1", "@01 1 2", "@01 2 3", "@01 1 4"] {
        bench.receive(&format!("{reply} OK BUSY -- 0\r\n"));
    }
    assert_eq!(
        bench.sent,
        [
            "/1 1 1 set maxspeed 16384\n",
            "/1 1 2 set accel 82\n",
            "/1 2 3 set maxspeed 8192\n",
            "/1 1 4 move abs 5000\n",
            "/1 2 5 move abs -2500\n"
        ]
    );
}

/// zaber-python: the reply to a stop has NI, and so has the position when the axes stand.
#[test]
fn a_halt_goes_before_all_that_waits() {
    let mut bench = Bench::ready();
    bench.begin(vec![one("x", 1.0, 2.0), one("y", 1.0, 2.0)]);
    bench.sent.clear();
    bench.order(&Motion::Halt).unwrap();
    assert_eq!(bench.sent, ["/1 0 2 stop\n"]);
    // The late reply to what came before starts nothing.
    bench.receive("@01 1 01 OK IDLE -- 0\r\n");
    bench.receive("@01 0 02 OK BUSY NI 0\r\n");
    assert_eq!(bench.sent.len(), 1);
    bench.position("@01 0 OK BUSY NI 900 0\r\n");
    bench.position("@01 0 OK IDLE NI 1000 0\r\n");
    assert_eq!(bench.motions(), [&MotionEvent::Halted]);
    // The notice of the halt keeps no later move.
    bench.go("x", 0.0, 2.0).unwrap();
    assert_eq!(bench.driver.halt_bytes(), Some(b"/1 0 99 stop\n".to_vec()));
}

#[test]
fn a_halt_without_an_answer_is_repeated_then_said() {
    let mut bench = Bench::ready();
    bench.order(&Motion::Halt).unwrap();
    while bench.motions().is_empty() {
        bench.next_timeout();
    }
    let stops: Vec<&String> = bench.sent.iter().filter(|sent| sent.ends_with("stop\n")).collect();
    assert_eq!(
        stops,
        ["/1 0 0 stop\n", "/1 0 1 stop\n", "/1 0 2 stop\n", "/1 0 3 stop\n", "/1 0 4 stop\n"]
    );
    assert_eq!(bench.failure().kind, MotionTrouble::Unanswered);
    assert!(bench.failure().detail.contains("emergency stop"), "{:?}", bench.failure());
}

/// The word BADDATA: zproto, and tests of Zaber's Matlab toolbox.
#[test]
fn a_rejected_move_is_refused_with_its_cure_and_the_other_axis_is_halted() {
    let mut bench = Bench::ready();
    bench.begin(vec![one("x", 1.0, 2.0), one("y", 1.0, 2.0)]);
    for reply in [
        "@01 1 1 OK IDLE -- 0",
        "@01 2 2 OK IDLE -- 0",
        "@01 1 3 OK BUSY -- 0",
        "@01 2 4 RJ BUSY -- BADDATA",
    ] {
        bench.receive(&format!("{reply}\r\n"));
    }
    assert_eq!(bench.sent.last().unwrap(), "/1 0 5 stop\n");
    bench.receive("@01 0 5 OK BUSY NI 0\r\n");
    bench.position("@01 0 OK IDLE NI 12 0\r\n");
    let failure = bench.failure();
    assert_eq!(failure.kind, MotionTrouble::Refused);
    assert!(
        failure.detail.starts_with("the stage rejects `move abs 5000` with BADDATA: "),
        "{failure:?}"
    );
}

#[test]
fn warnings_end_a_move_with_their_names() {
    for (letters, kind) in [
        ("FS", MotionTrouble::Stalled),
        ("WL", MotionTrouble::Limit),
        ("FE", MotionTrouble::Limit),
        ("NC", MotionTrouble::Interrupted),
        ("WR", MotionTrouble::Unreferenced),
        ("FD", MotionTrouble::Device),
    ] {
        let mut bench = Bench::ready();
        bench.begin(vec![one("x", 1.0, 1.0)]);
        bench.receive("@01 1 1 OK IDLE -- 0\r\n@01 1 2 OK BUSY -- 0\r\n");
        bench.position(&format!("@01 0 OK IDLE {letters} 77 0\r\n"));
        assert_eq!(bench.sent.last().unwrap(), "/1 0 3 stop\n", "{letters}");
        bench.receive(&format!("@01 0 3 OK IDLE {letters} 0\r\n"));
        bench.position(&format!("@01 0 OK IDLE {letters} 77 0\r\n"));
        let failure = bench.failure();
        assert_eq!(failure.kind, kind, "{letters}");
        assert!(failure.detail.contains(letters) && failure.detail.contains(": "), "{failure:?}");
    }
}

#[test]
fn a_stage_that_was_not_homed_begins_no_move() {
    let mut bench = Bench::new(STAGE);
    bench.receive("@01 0 OK IDLE WR 0 0\r\n");
    bench.receive("@01 0 OK IDLE WR 0 0\r\n");
    bench.sent.clear();
    let failure = bench.go("x", 1.0, 1.0).unwrap_err();
    assert_eq!(failure.kind, MotionTrouble::Unreferenced);
    assert_eq!(
        failure.detail,
        "the stage reports WR, no reference position: home the stage, with home = true in [scan.plan] or with Zaber Launcher"
    );
    assert!(bench.sent.is_empty());
    // A warning that counts more hides it; all are asked for before the first move.
    let mut bench = Bench::new(STAGE);
    bench.receive("@01 0 OK IDLE WT 0 0\r\n");
    bench.receive("@01 0 OK IDLE WT 0 0\r\n");
    bench.go("x", 1.0, 1.0).unwrap();
    bench.receive("@01 0 0 OK IDLE WT 02 WT WR\r\n");
    assert_eq!(bench.failure().kind, MotionTrouble::Unreferenced);
    assert_eq!(bench.sent.last().unwrap(), "/1 0 0 warnings\n");
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_sent() {
    let mut bench = Bench::ready();
    for (axis, to, speed) in [
        ("z", 1.0, 1.0),
        ("x", f64::NAN, 1.0),
        ("x", 1e9, 1.0),
        ("x", 1.0, 0.0),
        ("x", 1.0, f64::INFINITY),
    ] {
        let failure = bench.go(axis, to, speed).unwrap_err();
        assert_eq!(failure.kind, MotionTrouble::Refused);
    }
    assert!(bench.sent.is_empty());
    bench.go("x", 1.0, 1.0).unwrap();
    let failure = bench.go("x", 2.0, 1.0).unwrap_err();
    assert!(failure.detail.contains("still moves"), "{failure:?}");
}

#[test]
fn a_command_without_an_answer_halts() {
    let mut bench = Bench::ready();
    bench.go("x", 1.0, 1.0).unwrap();
    while !bench.sent.last().unwrap().ends_with("stop\n") {
        bench.next_timeout();
    }
    let stop = bench.sent.last().unwrap().clone();
    let number = stop.split(' ').nth(2).unwrap().to_owned();
    bench.receive(&format!("@01 0 {number} OK IDLE NI 0\r\n"));
    bench.position("@01 0 OK IDLE NI 0 0\r\n");
    assert_eq!(bench.failure().kind, MotionTrouble::Unanswered);
}

#[test]
fn nothing_moves_before_the_stage_answered_and_nothing_goes_on_after_a_reconnect() {
    let mut bench = Bench::new(STAGE);
    assert_eq!(bench.go("x", 1.0, 1.0).unwrap_err().kind, MotionTrouble::Unanswered);
    let mut bench = Bench::ready();
    bench.begin(vec![one("x", 1.0, 2.0), one("y", 1.0, 2.0)]);
    bench.driver.disconnected(bench.now);
    bench.driver.connected(bench.now);
    bench.drain();
    bench.sent.clear();
    // The greeting, and a late reply to the speed of x.
    bench.receive("@01 0 OK IDLE -- 0 0\r\n@01 1 00 OK IDLE -- 0\r\n@01 0 OK IDLE -- 0 0\r\n");
    assert!(bench.sent.iter().all(|sent| sent.ends_with("get pos\n")), "{:?}", bench.sent);
    assert!(bench.motions().is_empty());
}

#[test]
fn commands_with_checks() {
    let mut bench = Bench::new(&format!("checksum = true\n{STAGE}"));
    // Sums by hand: each reply adds to 0 with its check.
    let check = |text: &str| {
        let sum: u32 = text.bytes().skip(1).map(u32::from).sum();
        format!("{text}:{:02X}\r\n", (256 - sum % 256) % 256)
    };
    let idle = check("@01 0 OK IDLE -- 0 0");
    bench.receive(&idle);
    bench.receive(&idle);
    bench.sent.clear();
    bench.go("x", 2.0468, 1.0).unwrap();
    bench.receive("@01 0 0 OK IDLE -- 00:00\r\n");
    assert_eq!(bench.sent.len(), 1, "a reply with a wrong check is none");
    bench.receive(&check("@01 0 0 OK IDLE -- 00"));
    bench.receive(&check("@01 1 1 OK IDLE -- 0"));
    assert_eq!(bench.sent[2], check("/1 1 2 move abs 10234").replace("\r\n", "\n"));
}

/// A stage without reference homes: its warning counts once it stands.
#[test]
fn a_stage_homes_on_order_and_moves_after_it() {
    let mut bench = Bench::new(STAGE);
    bench.receive("@01 0 OK IDLE WR 0 0\r\n");
    bench.receive("@01 0 OK IDLE WR 0 0\r\n");
    bench.sent.clear();
    bench.order(&Motion::Home).unwrap();
    assert_eq!(bench.sent, ["/1 0 0 home\n"], "all axes at once");
    let twice = bench.order(&Motion::Home).unwrap_err();
    assert!(twice.detail.contains("still moves"), "{twice:?}");
    bench.receive("@01 0 0 OK BUSY WR 0\r\n");
    bench.position("@01 0 OK BUSY WR -500 -20\r\n");
    assert!(bench.motions().is_empty());
    bench.position("@01 0 OK IDLE -- 0 0\r\n");
    assert_eq!(bench.motions(), [&MotionEvent::Arrived]);
    bench.events.clear();
    bench.begin(vec![one("x", 1.0, 1.0)]);
    assert!(bench.sent.iter().any(|sent| sent.contains("set maxspeed")));
}

#[test]
fn a_stage_that_stands_without_reference_has_not_homed() {
    for (warning, kind) in [("WR", MotionTrouble::Unreferenced), ("FS", MotionTrouble::Stalled)] {
        let mut bench = Bench::ready();
        bench.order(&Motion::Home).unwrap();
        bench.receive("@01 0 0 OK BUSY WR 0\r\n");
        bench.position(&format!("@01 0 OK IDLE {warning} 7 7\r\n"));
        assert_eq!(bench.sent.last().unwrap(), "/1 0 1 stop\n");
        bench.receive(&format!("@01 0 1 OK IDLE {warning} 0\r\n"));
        bench.position(&format!("@01 0 OK IDLE {warning} 7 7\r\n"));
        assert_eq!(bench.failure().kind, kind);
    }
    let mut bench = Bench::ready();
    bench.order(&Motion::Home).unwrap();
    bench.receive("@01 0 0 RJ IDLE -- STATUSBUSY\r\n");
    assert_eq!(bench.sent.last().unwrap(), "/1 0 1 stop\n");
}
