//! Frames of manuals: the words of the state machine, and how a drive is homed.

use asphera_cia402::wire::{
    MappedObject, NodeId, PowerState, SdoRequest, SdoResponse, Statusword, control, decode_tpdo,
    encode_tpdo, object,
};
use asphera_cia402::{Cia402, Homing, Settings, Step};
use asphera_link::{
    CanFrame, CanId, Command, Driver, Event, Input, Motion, MotionEvent, Nanos, Output,
};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn node() -> NodeId {
    NodeId::new(3).expect("1 to 127")
}

fn bytes(text: &str) -> Vec<u8> {
    text.split(' ').map(|byte| u8::from_str_radix(byte, 16).expect("hex")).collect()
}

/// Kollmorgen AKD CANopen, November 2012, page 145: homing of node 3 by SDO. Requests on 603h, answers on 583h.
const HOMING: [(&str, &str); 5] = [
    ("2F 60 60 00 06 00 00 00", "60 60 60 00 00 00 00 00"),
    ("2B 40 60 00 06 00 00 00", "60 40 60 00 00 00 00 00"),
    ("2B 40 60 00 07 00 00 00", "60 40 60 00 00 00 00 00"),
    ("2B 40 60 00 0F 00 00 00", "60 40 60 00 00 00 00 00"),
    ("2B 40 60 00 1F 00 00 00", "60 40 60 00 00 00 00 00"),
];

#[test]
fn requests_and_answers_of_the_manual() {
    for (request, answer) in HOMING {
        let decoded = SdoRequest::decode(node(), &bytes(request)).expect("a request");
        assert_eq!(decoded.encode(node()).data(), bytes(request), "{request}");
        assert_eq!(decoded.encode(node()).id(), CanId::Standard(0x603));
        let answered = SdoResponse::decode(node(), &bytes(answer)).expect("an answer");
        assert_eq!(answered.address(), decoded.address());
        assert_eq!(answered.encode(node()).id(), CanId::Standard(0x583));
    }
    let words = [control::SHUTDOWN, control::SWITCH_ON, control::ENABLE_OPERATION];
    assert_eq!(words, [0x06, 0x07, 0x0F]);
    assert_eq!(control::ENABLE_OPERATION | control::START, 0x1F);
}

/// Statuswords of the same page: 0240h, 0237h while homing, 1637h with home found.
#[test]
fn statuswords_of_the_manual() {
    let [off, homing, found] = [0x0240, 0x0237, 0x1637].map(Statusword);
    assert_eq!(off.state(), Some(PowerState::SwitchOnDisabled));
    assert_eq!(homing.state(), Some(PowerState::OperationEnabled));
    assert!(!homing.is_acknowledged() && !homing.is_target_reached());
    assert!(found.is_acknowledged() && found.is_target_reached() && !found.has_mode_error());
}

/// The table of Toshiba's VF-S15 CANopen manual, object 6041h: x marks bits that do not matter.
#[test]
fn states_of_the_table() {
    let table = [
        ("xxxx xxxx x0xx 0000", PowerState::NotReady),
        ("xxxx xxxx x1xx 0000", PowerState::SwitchOnDisabled),
        ("xxxx xxxx x01x 0001", PowerState::ReadyToSwitchOn),
        ("xxxx xxxx x01x 0011", PowerState::SwitchedOn),
        ("xxxx xxxx x01x 0111", PowerState::OperationEnabled),
        ("xxxx xxxx x00x 0111", PowerState::QuickStopActive),
        ("xxxx xxxx x0xx 1111", PowerState::FaultReactionActive),
        ("xxxx xxxx x0xx 1000", PowerState::Fault),
    ];
    for word in 0..=u16::MAX {
        let fits = |pattern: &str| {
            let bits = pattern.bytes().filter(|byte| *byte != b' ').rev().enumerate();
            bits.into_iter().all(|(at, bit)| bit == b'x' || (bit == b'1') == (word >> at & 1 == 1))
        };
        let expected = table.iter().find(|(pattern, _)| fits(pattern)).map(|(_, state)| *state);
        assert_eq!(Statusword(word).state(), expected, "{word:04X}h");
    }
}

#[test]
fn a_tpdo_has_statusword_and_position() {
    let data = bytes("37 16 C0 1D FE FF");
    assert_eq!(decode_tpdo(&data), Some((Statusword(0x1637), -123_456)));
    assert_eq!(encode_tpdo(Statusword(0x1637), -123_456), data[..]);
    assert_eq!(decode_tpdo(&data[..5]), None);
    let entries = object::TPDO1.map(MappedObject::entry);
    assert_eq!(entries, [0x6041_0010, 0x6064_0020]);
}

/// A drive that answers each request as AKD's manual shows it: statusword by its last controlword.
struct Answers {
    control: u16,
    mode: u32,
}

impl Answers {
    fn answer(&mut self, frame: &CanFrame) -> Option<CanFrame> {
        let request = SdoRequest::decode(node(), frame.data())
            .ok()
            .filter(|_| frame.id() == CanId::Standard(0x603))?;
        let response = match request {
            SdoRequest::Download(address, value) => {
                match address {
                    object::CONTROLWORD => self.control = value.number() as u16,
                    object::MODE => self.mode = value.number(),
                    _ => {}
                }
                SdoResponse::Downloaded(address)
            }
            SdoRequest::Upload(address) => {
                let value = match address {
                    object::DEVICE_TYPE => 0x0002_0192,
                    object::MODE_DISPLAY => self.mode,
                    object::SUPPORTED_MODES => 0x21,
                    object::STATUSWORD => self.status().0.into(),
                    _ => 0,
                };
                SdoResponse::Uploaded(address, asphera_cia402::wire::Expedited::u32(value))
            }
            SdoRequest::Abort(..) => return None,
        };
        Some(response.encode(node()))
    }

    fn status(&self) -> Statusword {
        Statusword(match self.control {
            0x06 => 0x0231,
            0x07 => 0x0233,
            0x0F => 0x0237,
            0x1F => 0x1637,
            _ => 0x0240,
        })
    }
}

#[test]
fn the_driver_homes_as_the_manual_shows() {
    let homing = Homing { method: 17, speeds: [10.0, 1.0], acceleration: None, offset: 0.0 };
    let settings = Settings {
        node_id: 3,
        homing: Some(homing),
        step: Step::Nanometres(1000.0),
        ..Settings::default()
    };
    let mut driver = Cia402::new(settings).expect("good settings");
    let mut drive = Answers { control: 0, mode: 0 };
    let mut sent = Vec::new();
    let mut now = Nanos::from_millis(1000);
    driver.command(now, Command::Start);
    driver.connected(now);
    let mut run = |driver: &mut Cia402, drive: &mut Answers, sent: &mut Vec<Vec<u8>>| {
        for _ in 0..300 {
            now = now + std::time::Duration::from_millis(10);
            while let Some(Output::Frame(frame)) = driver.poll_transmit() {
                if let Some(answer) = drive.answer(&frame) {
                    sent.push(frame.data().to_vec());
                    driver.receive(now, Input::Frame(&answer));
                }
            }
            let tpdo =
                CanFrame::data_frame(CanId::Standard(0x183), &encode_tpdo(drive.status(), 0))
                    .expect("six bytes");
            driver.receive(now, Input::Frame(&tpdo));
            if driver.poll_timeout().is_some_and(|due| due <= now) {
                driver.timeout(now);
            }
        }
        now
    };
    let at = run(&mut driver, &mut drive, &mut sent);
    assert!(std::iter::from_fn(|| driver.poll_event()).any(|event| event == Event::Ready));
    sent.clear();
    driver.motion(at, &Motion::Home).expect("it is free");
    run(&mut driver, &mut drive, &mut sent);
    let mut events = std::iter::from_fn(|| driver.poll_event());
    assert!(events.any(|event| event == Event::Motion(MotionEvent::Arrived)));
    // Every request of the manual, in its order; settings and questions between them.
    let mut from = 0;
    for (request, _) in HOMING {
        let place = sent[from..].iter().position(|data| *data == bytes(request));
        from += place.unwrap_or_else(|| panic!("{request} is missing in {sent:02X?}")) + 1;
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Frames of any content, also between orders, never panic, and never move anything by themselves.
    #[test]
    fn any_frames_are_borne(frames in proptest::collection::vec((0_u16..8, proptest::collection::vec(any::<u8>(), 0..=8)), 0..60)) {
        let mut driver = Cia402::new(Settings { node_id: 3, ..Settings::default() }).expect("good settings");
        driver.command(Nanos::ZERO, Command::Start);
        driver.connected(Nanos::ZERO);
        for (step, (kind, data)) in (1..).zip(frames) {
            let now = Nanos::from_millis(step * 37);
            let id = [0x000, 0x080, 0x083, 0x183, 0x583, 0x583, 0x603, 0x703][usize::from(kind)];
            let frame = CanFrame::data_frame(CanId::Standard(id), &data).expect("eight bytes at most");
            driver.receive(now, Input::Frame(&frame));
            if driver.poll_timeout().is_some_and(|due| due <= now) {
                driver.timeout(now);
            }
            while let Some(Output::Frame(frame)) = driver.poll_transmit() {
                let moves = matches!(
                    SdoRequest::decode(node(), frame.data()),
                    Ok(SdoRequest::Download(object::CONTROLWORD, _)) if frame.id() == CanId::Standard(0x603)
                );
                prop_assert!(!moves, "a controlword without an order");
            }
            while driver.poll_event().is_some() {}
        }
    }
}
