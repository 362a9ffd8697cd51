//! The state machine in virtual time: schedule, late and wrong answers, damaged streams.

mod bench;

use std::time::Duration;

use asphera_link::{Driver as _, Event, FaultKind, Flags, Nanos, Unit};
use asphera_modbus::{Field, Function, Kind, Map, Settings, Transport};
use bench::Bench;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

const OM20_REQUEST: [u8; 5] = [4, 0, 200, 0, 13];

/// An OM20 answer: distance 69.743 mm (202 = 7C37h, 203 = 428Bh), device time `time_s`.
fn om20_pdu(quality: u8, outputs: u8, time_s: u8) -> Vec<u8> {
    let words: [[u8; 2]; 13] = [
        [0, quality],
        [0, outputs],
        [0x7C, 0x37],
        [0x42, 0x8B],
        [0, 0],
        [0x43, 0xFA],
        [0, 87],
        [0x07, 0xD0],
        [0, 0],
        [0, time_s],
        [0, 0],
        [0, 0],
        [0, 0],
    ];
    [&[4, 26], words.as_flattened()].concat()
}

fn tcp(transaction: u16, unit_id: u8, pdu: &[u8]) -> Vec<u8> {
    let mut frame = transaction.to_be_bytes().to_vec();
    frame.extend([0, 0, 0, pdu.len() as u8 + 1, unit_id]);
    frame.extend(pdu);
    frame
}

fn rtu(unit_id: u8, pdu: &[u8]) -> Vec<u8> {
    let mut frame = vec![unit_id];
    frame.extend(pdu);
    let mut crc = 0xFFFF_u16;
    for byte in &frame {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { (crc >> 1) ^ 0xA001 } else { crc >> 1 };
        }
    }
    frame.extend(crc.to_le_bytes());
    frame
}

fn settings(transport: Transport) -> Settings {
    Settings { transport, timeout_ms: 40, late_limit_ms: Some(150), ..Settings::default() }
}

/// A device on a serial line that has proved to be there.
fn confirmed_rtu() -> Bench {
    let mut bench = Bench::new(settings(Transport::Rtu));
    bench.receive(&rtu(1, &om20_pdu(0, 0, 1)));
    assert_eq!(bench.next_request(), rtu(1, &OM20_REQUEST));
    bench
}

fn distance(bench: &Bench) -> Vec<Option<f64>> {
    let rounded = |mm: f64| (mm * 1e4).round() / 1e4;
    bench.readings().iter().map(|reading| reading.values.get(0).map(rounded)).collect()
}

#[test]
fn polls_are_due_at_fixed_times_and_never_pile_up() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.now = Nanos::from_millis(10);
    bench.receive(&tcp(0, 1, &om20_pdu(0, 0, 1)));
    assert_eq!(bench.driver.poll_timeout(), Some(Nanos::from_millis(100)));
    // The host slept: the polls due at 200 and 300 ms are gone.
    bench.now = Nanos::from_millis(310);
    bench.driver.timeout(bench.now);
    bench.drain();
    assert_eq!(bench.sent.len(), 2);
    bench.receive(&tcp(1, 1, &om20_pdu(0, 0, 2)));
    assert_eq!(bench.driver.poll_timeout(), Some(Nanos::from_millis(400)));
    assert_eq!(bench.driver.tally().missed, 2);
    assert_eq!(bench.readings().len(), 2);
}

#[test]
fn a_timeout_called_too_early_does_nothing() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.driver.timeout(Nanos::from_millis(39));
    bench.drain();
    assert_eq!((bench.events.len(), bench.sent.len()), (0, 1));
}

#[test]
fn unchanged_device_time_is_no_second_reading() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    for (transaction, time_s) in [1, 1, 2].into_iter().enumerate() {
        bench.receive(&tcp(transaction as u16, 1, &om20_pdu(0, 0, time_s)));
        bench.next_request();
    }
    assert_eq!(bench.readings().len(), 2);
    assert_eq!(bench.driver.tally().repeated, 1);

    let all = Settings { skip_repeated: false, ..settings(Transport::Tcp) };
    let mut bench = Bench::new(all);
    bench.receive(&tcp(0, 1, &om20_pdu(0, 0, 1)));
    bench.next_request();
    bench.receive(&tcp(1, 1, &om20_pdu(0, 0, 1)));
    assert_eq!(bench.readings().len(), 2);
}

#[test]
fn an_alarm_is_told_once_and_flags_every_reading() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    for (transaction, outputs) in [2, 2, 0, 2].into_iter().enumerate() {
        bench.receive(&tcp(transaction as u16, 1, &om20_pdu(0, outputs, transaction as u8)));
        bench.next_request();
    }
    let fault = (FaultKind::Device, "unit 1 reports `alarm`: see its manual".to_owned());
    assert_eq!(bench.faults(), [fault.clone(), fault]);
    let flags: Vec<_> = bench.readings().iter().map(|reading| reading.flags).collect();
    let alarm = Flags::DEVICE_ERROR;
    assert_eq!(flags, [alarm, alarm, Flags::empty(), alarm]);
}

/// tokio-modbus issue 324: after a time-out each later call failed on the answer to the one before.
#[test]
fn stale_transactions_are_passed_over_issue_324() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.receive(&tcp(0, 1, &om20_pdu(0, 0, 1)));
    bench.receive(&tcp(0, 1, &om20_pdu(2, 0, 9)));
    bench.next_request();
    bench.receive(&tcp(0, 1, &om20_pdu(2, 0, 9)));
    bench.receive(&tcp(1, 1, &om20_pdu(0, 0, 2)));
    assert_eq!(distance(&bench), [Some(69.7426), Some(69.7426)]);
    assert_eq!(bench.faults(), []);
    assert_eq!(bench.driver.tally().discarded_bytes, 2 * 35);
}

#[test]
fn tcp_timeout_ends_the_connection_and_its_answer_is_never_used() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.next_timeout();
    let text = "no answer of unit 1 to read input registers 200 to 212 within 40 ms: check unit_id, cable and power";
    assert_eq!(bench.faults(), [(FaultKind::Timeout, text.to_owned())]);
    assert!(matches!(bench.events[..], [Event::Reopen(_)]));
    assert_eq!(bench.driver.poll_timeout(), None);
    bench.receive(&tcp(0, 1, &om20_pdu(0, 0, 1)));

    bench.driver.disconnected(bench.now);
    bench.driver.connected(bench.now);
    bench.drain();
    assert_eq!(bench.sent[1], tcp(1, 1, &OM20_REQUEST), "transactions go on over reconnects");
    bench.receive(&tcp(0, 1, &om20_pdu(0, 0, 1)));
    assert_eq!(bench.readings(), []);
    bench.receive(&tcp(1, 1, &om20_pdu(0, 0, 2)));
    assert_eq!(bench.readings().len(), 1);
    assert_eq!(bench.driver.tally().discarded_bytes, 2 * 35);
}

#[test]
fn reconnect_forgets_half_a_frame() {
    for transport in [Transport::Tcp, Transport::Rtu] {
        let mut bench = Bench::new(settings(transport));
        let frame = |transaction| match transport {
            Transport::Tcp => tcp(transaction, 1, &om20_pdu(0, 0, 1)),
            Transport::Rtu => rtu(1, &om20_pdu(0, 0, 1)),
        };
        bench.receive(&frame(0)[..20]);
        bench.driver.disconnected(bench.now);
        bench.driver.connected(bench.now);
        bench.drain();
        assert_eq!(bench.events, [Event::Discarded { bytes: 20 }]);
        bench.receive(&frame(0)[20..]);
        assert!(!bench.events.contains(&Event::Online));
    }
}

#[test]
fn a_stream_out_of_step_is_given_up() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.receive(b"HTTP/1.1 400 Bad Request");
    let text = "no Modbus TCP frame where one must begin, protocol 21584, length 12081: check framing, and address and port of the link";
    assert_eq!(bench.faults(), [(FaultKind::Protocol, text.to_owned())]);
    assert_eq!(bench.events[1], Event::Discarded { bytes: 24 });
}

#[test]
fn an_answer_of_the_wrong_shape_is_a_fault_and_the_next_poll_goes_on() {
    let wrong: [&[u8]; 4] = [&[3, 2, 0, 1], &[4, 2, 0, 1], &[4, 3, 0, 1, 2], &[4, 200, 1]];
    for pdu in wrong {
        let mut bench = Bench::new(settings(Transport::Tcp));
        bench.receive(&tcp(0, 1, pdu));
        assert_eq!(bench.faults().len(), 1, "{pdu:?}");
        assert_eq!(bench.faults()[0].0, FaultKind::Protocol);
        assert_eq!(bench.events.len(), 1, "neither online nor a reading");
        bench.next_request();
        bench.receive(&tcp(1, 1, &om20_pdu(0, 0, 2)));
        assert_eq!(distance(&bench), [Some(69.7426)]);
    }
}

#[test]
fn another_unit_is_not_believed_but_named() {
    let text = "no answer of unit 1 to read input registers 200 to 212 within 40 ms; unit 7 answered: check unit_id, cable and power";
    let expected = [(FaultKind::Timeout, text.to_owned())];
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.receive(&tcp(0, 7, &om20_pdu(0, 0, 1)));
    bench.next_timeout();
    assert_eq!(bench.faults(), expected);

    let mut bench = Bench::new(settings(Transport::Rtu));
    for byte in rtu(7, &om20_pdu(0, 0, 1)) {
        bench.receive(&[byte]);
    }
    bench.next_timeout();
    assert_eq!(bench.faults(), expected);
    assert!(!bench.events.contains(&Event::Online));
}

#[test]
fn a_gateway_that_cannot_reach_the_device_proves_nothing() {
    let mut bench = Bench::new(settings(Transport::Tcp));
    bench.receive(&tcp(0, 1, &[0x84, 11]));
    assert_eq!(bench.faults()[0].0, FaultKind::Refused);
    assert!(!bench.events.contains(&Event::Online));
    bench.next_request();
    bench.receive(&tcp(1, 1, &om20_pdu(0, 0, 1)));
    assert_eq!(distance(&bench), [Some(69.7426)]);
}

#[test]
fn rtu_answer_is_found_behind_echo_and_noise() {
    let mut bench = confirmed_rtu();
    let mut line = rtu(1, &OM20_REQUEST);
    line.extend([0, 1, 4, 26, 0xFF]);
    line.extend(rtu(1, &om20_pdu(0, 0, 2)));
    bench.receive(&line);
    assert_eq!(distance(&bench), [Some(69.7426)]);
    assert_eq!(bench.driver.tally().discarded_bytes, 8 + 5);
}

#[test]
fn rtu_late_answer_is_dropped_and_the_next_poll_is_right() {
    let mut bench = confirmed_rtu();
    bench.next_timeout();
    assert_eq!(bench.faults().len(), 1);
    bench.now = bench.now + Duration::from_millis(70);
    let mut late = om20_pdu(0, 0, 2);
    late[6] = 0x43;
    bench.receive(&rtu(1, &late));
    assert_eq!(bench.driver.tally().late, 1);
    assert_eq!(bench.readings(), []);
    // The first answer was a proof and cost the poll at 100 ms; asked at 200 ms, given up at 240, the
    // answer came at 310: the next poll is due at 400.
    bench.next_request();
    assert_eq!(bench.now, Nanos::from_millis(400));
    bench.receive(&rtu(1, &om20_pdu(0, 0, 4)));
    assert_eq!(distance(&bench), [Some(69.7426)]);
}

#[test]
fn rtu_silence_settles_the_line_and_the_first_answer_is_only_a_proof() {
    let mut bench = confirmed_rtu();
    bench.next_timeout();
    let given_up = bench.now;
    bench.next_timeout();
    assert_eq!(bench.now, given_up + Duration::from_millis(150));
    bench.next_request();
    // The answer kept back until now, and the true one, come together: none is used.
    bench.receive(&rtu(1, &om20_pdu(2, 0, 2)));
    bench.receive(&rtu(1, &om20_pdu(0, 0, 5)));
    bench.next_request();
    bench.receive(&rtu(1, &om20_pdu(0, 0, 6)));
    let times: Vec<_> = bench.readings().iter().map(|reading| reading.device_time_ns).collect();
    assert_eq!(times, [Some(6_000_000_000)]);
}

#[test]
fn rtu_noise_keeps_the_line_from_settling() {
    let mut bench = confirmed_rtu();
    bench.next_timeout();
    for _ in 0..50 {
        bench.now = bench.now + Duration::from_millis(100);
        bench.receive(&[0x55; 40]);
        let silence = Duration::from_millis(150);
        assert_eq!(bench.driver.poll_timeout(), Some(bench.now + silence));
    }
    bench.next_timeout();
    assert_eq!(bench.driver.tally().discarded_bytes, 2000);
}

#[test]
fn rtu_damaged_answer_is_a_timeout() {
    let mut bench = confirmed_rtu();
    let mut damaged = rtu(1, &om20_pdu(0, 0, 2));
    damaged[7] ^= 1;
    bench.receive(&damaged);
    bench.next_timeout();
    assert_eq!(bench.faults()[0].0, FaultKind::Timeout);
    assert_eq!(bench.readings(), []);
}

/// Two channels far apart: two requests a poll.
fn two_blocks() -> Map {
    let field = |name: &str, address| {
        Field::channel(name, Function::ReadHolding, address, Kind::U16, Unit::Millimetre)
    };
    Map {
        name: "two blocks".to_owned(),
        fields: vec![field("b", 100), field("a", 5)],
        blocks: Vec::new(),
    }
}

#[test]
fn blocks_of_a_poll_are_asked_one_after_the_other() {
    for pause_ms in [0, 7] {
        let settings = Settings {
            map: two_blocks().into(),
            pause_between_requests_ms: pause_ms,
            ..settings(Transport::Tcp)
        };
        let mut bench = Bench::new(settings);
        bench.receive(&tcp(0, 1, &[3, 2, 0, 11]));
        if pause_ms > 0 {
            assert_eq!(bench.sent.len(), 1);
            bench.next_timeout();
            assert_eq!(bench.now, Nanos::from_millis(pause_ms.into()));
        }
        assert_eq!(bench.sent[1], tcp(1, 1, &[3, 0, 100, 0, 1]));
        bench.receive(&tcp(1, 1, &[3, 2, 0, 22]));
        assert_eq!(bench.values(), [Some(22.0), Some(11.0)]);
    }
}

#[test]
fn a_refused_block_leaves_a_gap() {
    let mut bench = Bench::new(Settings { map: two_blocks().into(), ..settings(Transport::Tcp) });
    bench.receive(&tcp(0, 1, &[0x83, 2]));
    bench.next_timeout();
    bench.receive(&tcp(1, 1, &[3, 2, 0, 22]));
    assert_eq!(bench.values(), [Some(22.0), None]);
    assert_eq!(bench.readings()[0].flags, Flags::DEVICE_ERROR);
}

/// What a run comes to, however its bytes were cut.
fn outcome(bench: &Bench) -> (Vec<Event>, u64, Vec<Vec<u8>>) {
    let is_discarded = |event: &&Event| matches!(event, Event::Discarded { .. });
    let told = bench.events.iter().filter(|event| !is_discarded(event)).cloned().collect();
    (told, bench.driver.tally().discarded_bytes, bench.sent.clone())
}

/// One stretch of bytes that arrives while the driver waits, and whether a time-out follows.
fn any_stretch(transport: Transport) -> impl Strategy<Value = (Vec<u8>, bool)> {
    let piece = (0_u8..7, 0_u16..4, prop::collection::vec(any::<u8>(), 0..12));
    let bytes = move |(what, transaction, noise): (u8, u16, Vec<u8>)| match (what, transport) {
        (0, Transport::Rtu) => noise,
        (1, Transport::Rtu) => rtu(7, &om20_pdu(0, 0, 3)),
        (2, Transport::Rtu) => rtu(1, &[0x84, 6]),
        (_, Transport::Rtu) => rtu(1, &om20_pdu(what % 3, 0, transaction as u8)),
        (0 | 1, Transport::Tcp) => tcp(transaction, 7, &om20_pdu(0, 0, 3)),
        (2, Transport::Tcp) => tcp(transaction, 1, &[0x84, 6]),
        (_, Transport::Tcp) => tcp(transaction, 1, &om20_pdu(what % 3, 0, transaction as u8)),
    };
    let stretch = prop::collection::vec(piece.prop_map(bytes), 0..4);
    (stretch.prop_map(|pieces| pieces.concat()), any::<bool>())
}

fn run(settings: &Settings, stretches: &[(Vec<u8>, bool)], cut: usize) -> Bench {
    let mut bench = Bench::new(settings.clone());
    for (bytes, then_timeout) in stretches {
        bytes.chunks(cut).for_each(|chunk| bench.receive(chunk));
        if *then_timeout && bench.driver.poll_timeout().is_some() {
            bench.next_timeout();
        }
    }
    bench.driver.disconnected(bench.now);
    bench.drain();
    bench
}

proptest! {
    #![proptest_config(ProptestConfig::with_failure_persistence(FileFailurePersistence::WithSource(
        "regressions"
    )))]

    #[test]
    fn tcp_does_not_depend_on_how_bytes_are_cut(
        stretches in prop::collection::vec(any_stretch(Transport::Tcp), 1..8),
        cut in 1_usize..40,
        pause_ms in 0_u32..2,
    ) {
        let settings =
            Settings { pause_between_requests_ms: pause_ms, ..settings(Transport::Tcp) };
        let whole = run(&settings, &stretches, usize::MAX);
        prop_assert_eq!(outcome(&run(&settings, &stretches, cut)), outcome(&whole));
    }

    #[test]
    fn rtu_does_not_depend_on_how_bytes_are_cut(
        stretches in prop::collection::vec(any_stretch(Transport::Rtu), 1..8),
        cut in 1_usize..40,
    ) {
        let settings = settings(Transport::Rtu);
        let whole = run(&settings, &stretches, usize::MAX);
        prop_assert_eq!(outcome(&run(&settings, &stretches, cut)), outcome(&whole));
    }

    #[test]
    fn every_byte_is_used_or_counted(
        stretches in prop::collection::vec(any_stretch(Transport::Rtu), 1..8),
    ) {
        let bench = run(&settings(Transport::Rtu), &stretches, 11);
        let received: usize = stretches.iter().map(|(bytes, _)| bytes.len()).sum();
        let tally = bench.driver.tally();
        let refused = tally.refused * 5;
        let used = (tally.answers - tally.refused) * 31 + refused;
        prop_assert_eq!(used + tally.discarded_bytes, received as u64);
    }

    #[test]
    fn random_bytes_never_panic_and_never_make_a_reading(
        bytes in prop::collection::vec(any::<u8>(), 0..600), cut in 1_usize..50, tcp in any::<bool>(),
    ) {
        let transport = if tcp { Transport::Tcp } else { Transport::Rtu };
        let bench = run(&settings(transport), &[(bytes, true)], cut);
        prop_assert_eq!(bench.readings(), []);
        prop_assert!(!bench.events.contains(&Event::Online));
    }
}
