//! The driver against the simulated drive, in virtual time.

use std::time::Duration;

use asphera_cia402::wire::{Cob, Expedited, NodeId, SdoRequest, SdoResponse, control, object};
use asphera_cia402::{Cia402, Homing, Reference, Settings, Step};
use asphera_link::{
    AxisMove, CanFrame, Command, Driver, Event, FaultKind, Flags, Input, Motion, MotionEvent,
    MotionTrouble, Nanos, Output, Reading,
};
use asphera_sim_cia402::{Drive, DriveSettings, Fault};

/// A driver and a drive on one wire.
struct Pair {
    drive: Drive,
    driver: Cia402,
    events: Vec<Event>,
    now: Nanos,
    /// Whether the bus carries anything.
    is_cut: bool,
    /// Controlwords that the drive was sent.
    controls: Vec<u16>,
}

const NODE: u8 = 5;

fn node() -> NodeId {
    NodeId::new(NODE).expect("1 to 127")
}

fn settings() -> Settings {
    Settings {
        node_id: NODE,
        axis: "x".to_owned(),
        step: Step::Nanometres(1000.0),
        homing: Some(Homing { method: 17, speeds: [20.0, 2.0], acceleration: None, offset: 0.0 }),
        ..Settings::default()
    }
}

/// 50 mm of travel, 20 mm from the switch, 200 mm/s².
fn drive() -> DriveSettings {
    DriveSettings { node_id: NODE, travel: 50_000, at: 20_000, acceleration: 200_000 }
}

fn mm(place: f64) -> Motion {
    let order =
        AxisMove { axis: "x".to_owned(), to: place, speed: 10.0, acceleration: Some(100.0) };
    Motion::Move(vec![order])
}

impl Pair {
    fn new(settings: Settings, drive: DriveSettings) -> Pair {
        Pair {
            drive: Drive::new(drive).expect("a node"),
            driver: Cia402::new(settings).expect("good settings"),
            events: Vec::new(),
            now: Nanos::from_millis(1000),
            is_cut: false,
            controls: Vec::new(),
        }
    }

    fn started(settings: Settings) -> Pair {
        let mut pair = Pair::new(settings, drive());
        pair.driver.command(pair.now, Command::Start);
        pair.connect();
        pair.advance(500);
        pair
    }

    fn connect(&mut self) {
        self.driver.connected(self.now);
        self.settle(Vec::new());
    }

    /// A pair whose drive is homed.
    fn homed() -> Pair {
        let mut pair = Pair::started(settings());
        pair.order(&Motion::Home).expect("it is free");
        pair.advance(5000);
        assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
        pair
    }

    fn order(&mut self, motion: &Motion) -> Result<(), asphera_link::MotionFailure> {
        let result = self.driver.motion(self.now, motion);
        self.settle(Vec::new());
        result
    }

    fn settle(&mut self, mut from_bus: Vec<CanFrame>) {
        loop {
            for frame in std::mem::take(&mut from_bus) {
                if !self.is_cut {
                    self.driver.receive(self.now, Input::Frame(&frame));
                }
            }
            while let Some(Output::Frame(frame)) = self.driver.poll_transmit() {
                if self.is_cut {
                    continue;
                }
                if let Some(Cob::SdoRequest(node)) = Cob::from_frame(&frame)
                    && let Ok(SdoRequest::Download(object::CONTROLWORD, value)) =
                        SdoRequest::decode(node, frame.data())
                {
                    self.controls.push(value.number() as u16);
                }
                from_bus.extend(self.drive.receive(self.now, &frame));
            }
            self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
            if from_bus.is_empty() {
                return;
            }
        }
    }

    fn advance(&mut self, ms: u64) {
        let end = self.now + Duration::from_millis(ms);
        loop {
            let due = self.drive.poll_timeout().into_iter().chain(self.driver.poll_timeout()).min();
            let Some(due) = due.filter(|due| *due <= end) else { break };
            self.now = self.now.max(due);
            let frames = match self.drive.poll_timeout() {
                Some(due) if due <= self.now => self.drive.timeout(self.now),
                _ => Vec::new(),
            };
            if self.driver.poll_timeout().is_some_and(|due| due <= self.now) {
                self.driver.timeout(self.now);
            }
            self.settle(frames);
        }
        self.now = end;
    }

    fn harm(&mut self, fault: Fault) {
        let frames = self.drive.fault(self.now, fault);
        self.settle(frames);
    }

    /// Outcomes of orders since the last time.
    fn outcomes(&mut self) -> Vec<MotionEvent> {
        let mut outcomes = Vec::new();
        self.events.retain(|event| match event {
            Event::Motion(event) => {
                outcomes.push(event.clone());
                false
            }
            _ => true,
        });
        outcomes
    }

    fn failure(&mut self) -> (MotionTrouble, String) {
        match self.outcomes().as_slice() {
            [MotionEvent::Failed(failure)] => (failure.kind, failure.detail.clone()),
            other => panic!("{other:?}"),
        }
    }

    fn last(&self) -> &Reading {
        let reading = |event: &Event| matches!(event, Event::Reading(_));
        match self.events.iter().rev().find(|event| reading(event)) {
            Some(Event::Reading(reading)) => reading,
            _ => panic!("no reading"),
        }
    }

    fn faults(&self) -> Vec<FaultKind> {
        let kind = |event: &Event| match event {
            Event::Fault(fault) => Some(fault.kind),
            _ => None,
        };
        self.events.iter().filter_map(kind).collect()
    }
}

#[test]
fn nothing_moves_and_nothing_is_switched_on_without_an_order() {
    let mut pair = Pair::started(settings());
    pair.advance(10_000);
    assert_eq!(pair.events[..2], [Event::Online, Event::Ready]);
    assert_eq!((pair.drive.moves(), &pair.controls[..]), (0, &[][..]));
    assert_eq!(pair.faults(), []);
    // A position every 10 ms, which counts from anywhere.
    let readings = pair.events.iter().filter(|event| matches!(event, Event::Reading(_))).count();
    assert!((1000..1060).contains(&readings), "{readings}");
    assert_eq!(pair.last().values.get(0), Some(0.0));
    assert_eq!(pair.last().flags, Flags::DEVICE_ERROR);
}

#[test]
fn a_drive_that_is_not_homed_refuses_to_move_with_the_cure() {
    let mut pair = Pair::started(settings());
    let refused = pair.order(&mm(10.0)).unwrap_err();
    assert_eq!(refused.kind, MotionTrouble::Unreferenced);
    assert!(refused.detail.contains("home = true"), "{}", refused.detail);
    assert_eq!(pair.controls, []);
    let without = Settings { homing: None, ..settings() };
    let refused = Pair::started(without).order(&Motion::Home).unwrap_err();
    assert!(refused.detail.contains("set homing"), "{}", refused.detail);
    let mut absolute = Pair::started(Settings { reference: Reference::Absolute, ..settings() });
    assert_eq!(absolute.last().flags, Flags::empty());
    assert!(absolute.order(&mm(1.0)).is_ok());
}

#[test]
fn homing_finds_the_switch_and_moves_reach_their_places() {
    let mut pair = Pair::homed();
    assert_eq!(pair.drive.place(pair.now), 0.0, "it stands at the switch");
    assert_eq!(pair.last().flags, Flags::empty());
    assert_eq!(
        pair.controls,
        [0x06, 0x07, 0x0F, 0x0F, 0x1F, 0x0F],
        "as the manual of a drive has it"
    );
    pair.controls.clear();
    for place in [12.345, 40.0, 0.5] {
        pair.order(&mm(place)).unwrap();
        assert!(pair.order(&mm(1.0)).unwrap_err().detail.contains("still moves"));
        pair.advance(6000);
        assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
        assert_eq!(pair.drive.place(pair.now), place * 1000.0);
        assert_eq!(pair.last().values.get(0), Some(place));
        assert_eq!(pair.controls, [0x0F, 0x3F, 0x0F], "one set-point");
        pair.controls.clear();
    }
    assert_eq!(pair.drive.moves(), 4);
    assert_eq!(pair.faults(), []);
}

#[test]
fn a_move_takes_the_time_of_its_trapezoid() {
    let mut pair = Pair::homed();
    let begin = pair.now;
    pair.order(&mm(10.0)).unwrap();
    while pair.outcomes().is_empty() {
        pair.advance(1);
    }
    // 10 mm at 10 mm/s with 100 mm/s²: 1.1 s, then a position within 10 ms; two questions before.
    let took_ms = pair.now.since(begin).as_millis();
    assert!((1100..1140).contains(&took_ms), "{took_ms} ms");
}

#[test]
fn home_has_a_place() {
    let homing =
        Homing { method: 17, speeds: [20.0, 2.0], acceleration: Some(500.0), offset: -3.0 };
    let mut pair = Pair::started(Settings { homing: Some(homing), ..settings() });
    pair.order(&Motion::Home).unwrap();
    pair.advance(5000);
    assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
    assert_eq!(pair.last().values.get(0), Some(-3.0));
    pair.order(&mm(0.0)).unwrap();
    pair.advance(5000);
    assert_eq!(pair.drive.place(pair.now), 3000.0);
}

#[test]
fn a_rotary_axis_counts_in_radians() {
    let homing = Homing { method: 35, speeds: [1.0, 1.0], acceleration: None, offset: 0.0 };
    let settings =
        Settings { step: Step::CountsPerTurn(36_000.0), homing: Some(homing), ..settings() };
    let mut pair = Pair::started(settings);
    pair.order(&Motion::Home).unwrap();
    pair.advance(500);
    assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
    let turn = std::f64::consts::TAU;
    let order = AxisMove { axis: "x".to_owned(), to: turn / 4.0, speed: turn, acceleration: None };
    pair.order(&Motion::Move(vec![order])).unwrap();
    pair.advance(2000);
    assert_eq!(pair.drive.place(pair.now), 29_000.0);
    assert!((pair.last().values.get(0).unwrap() - turn / 4.0).abs() < 1e-12);
}

#[test]
fn a_halt_brakes_at_once_and_the_drive_moves_again_after_it() {
    let mut pair = Pair::homed();
    pair.order(&mm(40.0)).unwrap();
    pair.advance(2000);
    let speed_um_s = 10_000.0;
    let at = pair.drive.place(pair.now);
    pair.controls.clear();
    pair.order(&Motion::Halt).unwrap();
    assert_eq!(pair.controls[0], control::QUICK_STOP);
    pair.advance(500);
    assert_eq!(pair.outcomes(), [MotionEvent::Halted]);
    let way = pair.drive.place(pair.now) - at;
    // v²/2a on the quick stop ramp of 2 m/s².
    assert!((way - speed_um_s * speed_um_s / 4e6).abs() < 1.0, "{way} µm");
    assert!(!pair.drive.is_moving(pair.now));
    pair.order(&mm(1.0)).unwrap();
    pair.advance(6000);
    assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
    assert_eq!(pair.drive.place(pair.now), 1000.0);
}

#[test]
fn frames_past_the_state_machine_halt_too() {
    let mut pair = Pair::homed();
    pair.order(&mm(40.0)).unwrap();
    pair.advance(2000);
    for frame in pair.driver.halt_frames() {
        let answers = pair.drive.receive(pair.now, &frame);
        pair.settle(answers);
    }
    pair.advance(1000);
    assert!(!pair.drive.is_moving(pair.now));
    let (kind, words) = pair.failure();
    assert_eq!(kind, MotionTrouble::Interrupted);
    assert!(words.contains("quick stop active"), "{words}");
}

#[test]
fn every_trouble_of_a_move_has_its_kind_and_its_cure() {
    type Harm = fn(&mut Pair);
    let cases: [(Harm, MotionTrouble, &str); 4] = [
        (|pair| pair.harm(Fault::Blocked), MotionTrouble::Device, "see its manual"),
        (|pair| pair.harm(Fault::Disabled), MotionTrouble::Interrupted, "enable input"),
        (|pair| pair.harm(Fault::Restart), MotionTrouble::Device, "home it again"),
        (|pair| pair.harm(Fault::Silent), MotionTrouble::Unanswered, "emergency stop"),
    ];
    for (harm, kind, cure) in cases {
        let mut pair = Pair::homed();
        pair.order(&mm(40.0)).unwrap();
        pair.advance(1000);
        harm(&mut pair);
        pair.advance(20_000);
        let (found, words) = pair.failure();
        assert_eq!(found, kind, "{words}");
        assert!(words.contains(cure), "expected {cure:?} in {words}");
        assert_eq!(pair.controls.last(), Some(&control::QUICK_STOP), "{words}");
    }
}

#[test]
fn a_place_beyond_the_limits_is_no_arrival() {
    let mut pair = Pair::homed();
    pair.order(&mm(60.0)).unwrap();
    pair.advance(10_000);
    let (kind, words) = pair.failure();
    assert_eq!(kind, MotionTrouble::Limit, "{words}");
    assert_eq!(pair.drive.place(pair.now), 50_000.0);
}

#[test]
fn a_homing_that_fails_leaves_the_drive_unreferenced() {
    let mut pair = Pair::started(settings());
    pair.harm(Fault::HomingFails);
    pair.order(&Motion::Home).unwrap();
    pair.advance(3000);
    let (kind, words) = pair.failure();
    assert!(kind == MotionTrouble::Device && words.contains("homing error"), "{words}");
    assert_eq!(pair.order(&mm(1.0)).unwrap_err().kind, MotionTrouble::Unreferenced);
    pair.order(&Motion::Home).unwrap();
    pair.advance(5000);
    assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
}

#[test]
fn a_fault_is_reset_by_the_next_order_alone() {
    let mut pair = Pair::homed();
    pair.harm(Fault::Blocked);
    pair.advance(2000);
    assert_eq!(pair.last().flags, Flags::DEVICE_ERROR);
    assert_eq!(pair.controls.iter().filter(|word| **word == control::FAULT_RESET).count(), 0);
    pair.order(&mm(5.0)).unwrap();
    pair.advance(3000);
    assert_eq!(pair.outcomes(), [MotionEvent::Arrived]);
    assert_eq!(pair.last().flags, Flags::empty());
}

#[test]
fn homed_survives_a_reconnect_but_no_restart() {
    let mut pair = Pair::homed();
    // Another connection: the drive says itself that it was homed, once its power is off.
    pair.order(&Motion::Halt).unwrap();
    pair.advance(500);
    let off = SdoRequest::Download(object::CONTROLWORD, Expedited::u16(control::DISABLE_VOLTAGE));
    pair.drive.receive(pair.now, &off.encode(node()));
    pair.driver.disconnected(pair.now);
    pair.events.clear();
    pair.connect();
    pair.advance(1000);
    assert_eq!(pair.last().flags, Flags::empty());
    assert!(pair.order(&mm(1.0)).is_ok());
    pair.advance(3000);
    pair.outcomes();
    pair.harm(Fault::Restart);
    pair.advance(2000);
    assert_eq!(pair.order(&mm(1.0)).unwrap_err().kind, MotionTrouble::Unreferenced);
    assert_eq!(pair.last().flags, Flags::DEVICE_ERROR);
}

#[test]
fn a_cut_bus_is_said_and_the_drive_is_set_up_again() {
    let mut pair = Pair::homed();
    pair.is_cut = true;
    pair.advance(5000);
    assert!(pair.faults().contains(&FaultKind::Timeout));
    assert_eq!(pair.order(&mm(1.0)).unwrap_err().kind, MotionTrouble::Unanswered);
    pair.is_cut = false;
    pair.events.clear();
    pair.advance(10_000);
    assert!(pair.events.contains(&Event::Ready));
}

#[test]
fn another_profile_is_refused() {
    let mut driver = Cia402::new(settings()).expect("good settings");
    driver.connected(Nanos::ZERO);
    // Node 5 answers as an encoder would.
    let encoder = SdoResponse::Uploaded(object::DEVICE_TYPE, Expedited::u32(0x0008_0196));
    driver.receive(Nanos::ZERO, Input::Frame(&encoder.encode(node())));
    let event = driver.poll_event();
    let Some(Event::Fault(fault)) = event else { panic!("{event:?}") };
    let words = &fault.detail;
    assert!(words.contains("profile 406") && words.contains("node_id"), "{words}");
}
