//! The driver and the simulated stage, in virtual time.

use std::time::Duration;

use asphera_link::{
    AxisMove, Driver, Event, Input, Motion, MotionEvent, MotionTrouble, Nanos, Output,
};
use asphera_sim_zaber::{AxisSettings, Fault, Stage};
use asphera_zaber::FAMILY;

/// Driver and stage on a line without delay.
struct Pair {
    driver: Box<dyn Driver>,
    stage: Stage,
    now: Nanos,
    events: Vec<Event>,
}

impl Pair {
    fn new() -> Pair {
        let settings =
            "axis = [{ name = 'x', microstep_um = 0.2 }, { name = 'y', microstep_um = 0.5 }]";
        let driver = FAMILY.parse("stage", settings).expect("settings").driver().expect("a driver");
        let axis = AxisSettings { microstep_um: 0.2, travel_mm: 50.0, at_mm: 10.0 };
        let stage = Stage::new(1, &[axis, AxisSettings { microstep_um: 0.5, ..axis }]);
        let mut pair = Pair { driver, stage, now: Nanos::ZERO, events: Vec::new() };
        pair.driver.connected(pair.now);
        pair.pump();
        pair.run(200);
        pair
    }

    fn pump(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            let reply = self.stage.receive(self.now.as_secs_f64(), &bytes);
            self.driver.receive(self.now, Input::Bytes(&reply));
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    fn run(&mut self, ms: u64) {
        let end = self.now + Duration::from_millis(ms);
        while let Some(due) = self.driver.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            self.driver.timeout(self.now);
            self.pump();
        }
        self.now = end;
    }

    fn go(&mut self, x_mm: f64, y_mm: f64, speed_mm_s: f64) {
        let one = |axis: &str, to| AxisMove {
            axis: axis.to_owned(),
            to,
            speed: speed_mm_s,
            acceleration: Some(100.0),
        };
        self.driver
            .motion(self.now, &Motion::Move(vec![one("x", x_mm), one("y", y_mm)]))
            .expect("a move");
        self.pump();
    }

    fn motions(&mut self) -> Vec<MotionEvent> {
        let events = std::mem::take(&mut self.events).into_iter();
        events
            .filter_map(|event| if let Event::Motion(motion) = event { Some(motion) } else { None })
            .collect()
    }

    fn places_mm(&self) -> Vec<f64> {
        self.stage.places_mm(self.now.as_secs_f64())
    }
}

/// 10 mm at 5 mm/s with 100 mm/s²: 2.05 s.
#[test]
fn axes_arrive_where_they_are_sent_in_the_time_of_their_trapezoid() {
    let mut pair = Pair::new();
    pair.go(20.0, 15.0, 5.0);
    pair.run(2000);
    assert!(pair.motions().is_empty() && pair.stage.is_moving(pair.now.as_secs_f64()));
    pair.run(100);
    assert_eq!(pair.motions(), [MotionEvent::Arrived]);
    assert_eq!(pair.places_mm(), [20.0, 15.0]);
}

#[test]
fn a_halt_stops_both_axes_on_their_way() {
    let mut pair = Pair::new();
    pair.go(40.0, 40.0, 5.0);
    pair.run(1000);
    let from = pair.places_mm();
    pair.driver.motion(pair.now, &Motion::Halt).expect("a halt");
    pair.pump();
    pair.run(500);
    assert_eq!(pair.motions(), [MotionEvent::Halted]);
    let at = pair.places_mm();
    // v²/2a = 0.125 mm, to the rounding of `accel`.
    for (at, from) in at.iter().zip(&from) {
        assert!((at - from - 0.125).abs() < 0.01, "{at} {from}");
    }
    pair.go(10.0, 10.0, 20.0);
    pair.run(5000);
    assert_eq!(pair.motions(), [MotionEvent::Arrived]);
}

#[test]
fn faults_of_the_stage_end_moves() {
    for (fault, kind) in
        [(Fault::Limit(0), MotionTrouble::Limit), (Fault::Stall(1), MotionTrouble::Stalled)]
    {
        let mut pair = Pair::new();
        pair.go(40.0, 40.0, 5.0);
        pair.run(1000);
        pair.stage.fault(pair.now.as_secs_f64(), fault);
        pair.run(1000);
        let motions = pair.motions();
        let [MotionEvent::Failed(failure)] = &motions[..] else { panic!("{motions:?}") };
        assert_eq!(failure.kind, kind);
        assert!(!pair.stage.is_moving(pair.now.as_secs_f64()), "the other axis is halted, too");
    }
}

#[test]
fn a_place_beyond_the_travel_is_rejected_by_the_stage() {
    let mut pair = Pair::new();
    pair.go(60.0, 20.0, 5.0);
    pair.run(1000);
    let motions = pair.motions();
    let [MotionEvent::Failed(failure)] = &motions[..] else { panic!("{motions:?}") };
    assert_eq!(failure.kind, MotionTrouble::Refused);
    assert!(failure.detail.contains("BADDATA"), "{failure:?}");
}

#[test]
fn a_stage_that_was_not_homed_moves_nowhere() {
    let mut pair = Pair::new();
    pair.stage.fault(0.0, Fault::NotHomed);
    pair.run(100);
    let one = AxisMove { axis: "x".to_owned(), to: 1.0, speed: 1.0, acceleration: None };
    let failure = pair.driver.motion(pair.now, &Motion::Move(vec![one])).expect_err("no reference");
    assert_eq!((failure.kind, pair.stage.moves()), (MotionTrouble::Unreferenced, 0));
}

#[test]
fn a_stage_that_lost_its_reference_homes() {
    let mut pair = Pair::new();
    pair.stage.fault(pair.now.as_secs_f64(), Fault::NotHomed);
    pair.run(100);
    pair.driver.motion(pair.now, &Motion::Home).expect("it is free");
    pair.pump();
    pair.run(30_000);
    assert_eq!(pair.motions(), [MotionEvent::Arrived]);
    assert_eq!(pair.places_mm(), [0.0, 0.0]);
    pair.go(1.0, 2.0, 5.0);
    pair.run(5000);
    assert_eq!(pair.motions(), [MotionEvent::Arrived]);
    assert_eq!(pair.places_mm(), [1.0, 2.0]);
}
