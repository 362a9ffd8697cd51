//! The driver and the simulated device, face to face in virtual time.

use std::time::Duration;

use asphera_link::{Driver as _, Event, FaultKind, Input, Nanos, Output, Reading};
use asphera_modbus::{Modbus, Settings, Transport};
use asphera_sim_modbus::{Device, Fault, Session};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

const INTERVAL: Duration = Duration::from_millis(100);
const TIMEOUT: Duration = Duration::from_millis(40);
const LATE_LIMIT: Duration = Duration::from_millis(160);
/// How long the link takes to open anew.
const REOPEN: Duration = Duration::from_millis(10);

/// A driver, a device and the link between them.
struct Pair {
    driver: Modbus,
    device: Device,
    transport: Transport,
    session: Session,
    now: Nanos,
    events: Vec<Event>,
}

impl Pair {
    fn new(transport: Transport) -> Pair {
        let settings = Settings {
            transport,
            poll_interval_ms: 100,
            timeout_ms: 40,
            pause_between_requests_ms: 2,
            ..Settings::default()
        };
        let device = Device::om20(1, distance_mm);
        device.set_delay(Duration::from_millis(3));
        let mut pair = Pair {
            driver: Modbus::new(settings).expect("settings of a test are sound"),
            session: Session::new(device.clone(), transport),
            device,
            transport,
            now: Nanos::ZERO,
            events: Vec::new(),
        };
        pair.driver.connected(pair.now);
        pair
    }

    /// Goes on until `end`.
    fn run_until(&mut self, end: Nanos) {
        loop {
            self.exchange();
            let next = [self.driver.poll_timeout(), self.session.poll_timeout()];
            match next.into_iter().flatten().min() {
                Some(next) if next <= end => self.now = next,
                _ => break,
            }
            while let Some(bytes) = self.session.poll_transmit(self.now) {
                // A serial line gives a few bytes at a time.
                for chunk in bytes.chunks(7) {
                    self.driver.receive(self.now, Input::Bytes(chunk));
                }
            }
            self.driver.timeout(self.now);
        }
        self.now = end;
    }

    fn run_for(&mut self, time: Duration) {
        self.run_until(self.now + time);
    }

    /// Carries what the driver sends, and opens the link anew where it is lost.
    fn exchange(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            self.session.receive(self.now, &bytes);
        }
        let mut lost = self.session.is_closed();
        while let Some(event) = self.driver.poll_event() {
            lost |= matches!(event, Event::Reopen(_));
            self.events.push(event);
        }
        if lost {
            self.driver.disconnected(self.now);
            self.session = Session::new(self.device.clone(), self.transport);
            self.now = self.now + REOPEN;
            self.driver.connected(self.now);
            self.exchange();
        }
    }

    fn readings(&self) -> Vec<Reading> {
        let reading = |event: &Event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        };
        self.events.iter().filter_map(reading).collect()
    }

    fn count(&self, kind: FaultKind) -> usize {
        let is_kind = |event: &&Event| match event {
            Event::Fault(fault) | Event::Reopen(fault) => fault.kind == kind,
            _ => false,
        };
        self.events.iter().filter(is_kind).count()
    }

    /// Every reading must be what the device saw during the request it answers, not during an
    /// earlier one.
    fn assert_no_wrong_value(&self) {
        for reading in self.readings() {
            let measured = Nanos::from_nanos(reading.device_time_ns.expect("the OM20 has a clock"));
            let expected = f64::from(distance_mm(measured) as f32);
            let value = reading.values.get(0).expect("the signal is good");
            assert!((value - expected).abs() < 1e-5, "{value} is not {expected}");
            assert!(reading.host.since(measured) <= TIMEOUT, "{measured} is stale at {reading:?}");
        }
    }
}

/// A ramp: each time has its own distance.
fn distance_mm(now: Nanos) -> f64 {
    // The device's clock counts whole microseconds.
    10.0 + (now.as_nanos() / 1000) as f64 * 1e-6
}

#[test]
fn every_poll_is_a_reading() {
    for (transport, lost) in [(Transport::Tcp, 0), (Transport::Rtu, 2)] {
        let mut pair = Pair::new(transport);
        pair.run_until(Nanos::from_millis(9950));
        pair.assert_no_wrong_value();
        // The first answer of a serial line is a proof; the silence after it costs another poll.
        assert_eq!(pair.readings().len(), 100 - lost);
        let online = pair.events.iter().filter(|event| **event == Event::Online).count();
        let ready = pair.events.iter().filter(|event| **event == Event::Ready).count();
        assert_eq!((online, ready), (1, 1));
        let tally = pair.driver.tally();
        assert_eq!((tally.timeouts, tally.refused, tally.discarded_bytes), (0, 0, 0));
    }
}

#[test]
fn late_by_exactly_one_poll_on_a_serial_line() {
    let mut pair = Pair::new(Transport::Rtu);
    pair.run_until(Nanos::from_millis(1050));
    let before = pair.readings().len();
    pair.device.fail_next(Fault::Late(INTERVAL));
    // Asked at 1100 ms, given up at 1140, answered at 1203 and dropped: 1300 is right again.
    pair.run_until(Nanos::from_millis(1290));
    assert_eq!(pair.readings().len(), before);
    assert_eq!(pair.driver.tally().late, 1);
    pair.run_until(Nanos::from_millis(1950));
    assert_eq!(pair.readings().len(), before + 7);
    assert_eq!(pair.count(FaultKind::Timeout), 1);
    pair.assert_no_wrong_value();
}

#[test]
fn late_by_exactly_one_poll_on_tcp() {
    let mut pair = Pair::new(Transport::Tcp);
    pair.run_until(Nanos::from_millis(1050));
    let before = pair.readings().len();
    pair.device.fail_next(Fault::Late(INTERVAL));
    // Asked at 1100 ms, given up at 1140, a new connection at 1150 asks at once.
    pair.run_until(Nanos::from_millis(1160));
    assert_eq!(pair.readings().len(), before + 1);
    assert_eq!(pair.count(FaultKind::Timeout), 1);
    pair.run_until(Nanos::from_millis(1950));
    pair.assert_no_wrong_value();
}

#[test]
fn an_answer_kept_back_until_the_next_request() {
    for transport in [Transport::Tcp, Transport::Rtu] {
        let mut pair = Pair::new(transport);
        pair.run_until(Nanos::from_millis(1050));
        let before = pair.readings().len();
        pair.device.fail_next(Fault::KeptBack);
        pair.run_until(Nanos::from_millis(2950));
        pair.assert_no_wrong_value();
        assert_eq!(pair.count(FaultKind::Timeout), 1);
        assert!(pair.readings().len() > before + 10);
    }
}

#[test]
fn exceptions_do_not_poison() {
    for transport in [Transport::Tcp, Transport::Rtu] {
        let mut pair = Pair::new(transport);
        pair.run_until(Nanos::from_millis(1050));
        let before = pair.readings().len();
        for code in [1, 2, 3, 4, 6, 99] {
            pair.device.fail_next(Fault::Exception(code));
        }
        pair.run_until(Nanos::from_millis(1950));
        assert_eq!(pair.readings().len(), before + 9 - 6);
        assert_eq!(pair.count(FaultKind::Refused), 6);
        pair.assert_no_wrong_value();
    }
}

#[test]
fn a_wrong_unit_and_a_wrong_crc_are_time_outs() {
    for fault in [Fault::WrongUnit(9), Fault::Corrupt] {
        let mut pair = Pair::new(Transport::Rtu);
        pair.run_until(Nanos::from_millis(1050));
        pair.device.fail_next(fault);
        pair.run_until(Nanos::from_millis(2950));
        assert_eq!(pair.count(FaultKind::Timeout), 1);
        assert_eq!(pair.driver.tally().discarded_bytes, 31);
        pair.assert_no_wrong_value();
    }
}

#[test]
fn a_corrupt_tcp_header_opens_the_link_anew() {
    let mut pair = Pair::new(Transport::Tcp);
    pair.device.fail_next(Fault::Corrupt);
    pair.run_until(Nanos::from_millis(950));
    assert_eq!(pair.count(FaultKind::Protocol), 1);
    assert!(pair.readings().len() >= 9);
    pair.assert_no_wrong_value();
}

#[test]
fn a_device_that_restarts_is_found_again() {
    for transport in [Transport::Tcp, Transport::Rtu] {
        let mut pair = Pair::new(transport);
        pair.run_until(Nanos::from_millis(1050));
        pair.device.fail_next(Fault::Close);
        pair.run_for(Duration::from_millis(60));
        pair.device.fall_silent(Duration::from_secs(3));
        pair.run_for(Duration::from_secs(3));
        let before = pair.readings().len();
        pair.run_for(Duration::from_secs(2));
        assert!(pair.readings().len() >= before + 12, "{}", pair.readings().len() - before);
        pair.assert_no_wrong_value();
        let online = pair.events.iter().filter(|event| **event == Event::Online).count();
        assert!(online >= 2, "once per connection");
    }
}

/// Faults of which each leaves the line clean after [`LATE_LIMIT`].
fn any_fault() -> impl Strategy<Value = Option<Fault>> {
    prop_oneof![
        3 => Just(None),
        2 => (0_u64..150).prop_map(|ms| Some(Fault::Late(Duration::from_millis(ms)))),
        1 => Just(Some(Fault::Silent)),
        1 => any::<u8>().prop_map(|code| Some(Fault::Exception(code))),
        1 => (2_u8..=247).prop_map(|unit| Some(Fault::WrongUnit(unit))),
        1 => Just(Some(Fault::Corrupt)),
        1 => Just(Some(Fault::Close)),
        1 => prop::collection::vec(any::<u8>(), 0..40).prop_map(|noise| Some(Fault::Noise(noise))),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_the_device_does_no_value_is_wrong_and_polling_goes_on(
        faults in prop::collection::vec(any_fault(), 1..40), tcp in any::<bool>(),
    ) {
        let transport = if tcp { Transport::Tcp } else { Transport::Rtu };
        let mut pair = Pair::new(transport);
        for fault in faults.into_iter().flatten() {
            pair.device.fail_next(fault);
            pair.run_for(INTERVAL * 2);
        }
        pair.run_for(LATE_LIMIT * 4);
        pair.assert_no_wrong_value();
        // Whatever faults are left are met within forty polls.
        pair.run_for(Duration::from_secs(30));
        let before = pair.readings().len();
        pair.run_for(Duration::from_secs(1));
        pair.assert_no_wrong_value();
        prop_assert_eq!(pair.readings().len(), before + 10);
    }
}
