//! The sensor in virtual time: golden bytes of manuals, and faults. Sources: README.md, "What was tested".

use asphera_link::{Driver as _, Event, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_riftek::wire::{Decoder, Identity, Request, encode_answer};
use asphera_riftek::{Mode, Riftek, Settings};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// RF602 manual, page 16: type 3Fh, firmware 90h, base 80 mm, range 50 mm.
const IDENTITY: [u8; 16] = [
    0x9F, 0x93, 0x90, 0x99, 0x91, 0x92, 0x93, 0x94, 0x90, 0x95, 0x90, 0x90, 0x92, 0x93, 0x90, 0x90,
];

/// RF602 manual, page 17: 02A5h, answer 3, a new result.
const RESULT_677: [u8; 4] = [0xF5, 0xFA, 0xF2, 0xF0];

const STREAM: Mode = Mode::Stream { silence_ms: 500 };
const POLL: Mode = Mode::Poll { interval_ms: 100 };

struct Bench {
    driver: Riftek,
    now: Nanos,
    sent: Vec<Vec<u8>>,
    events: Vec<Event>,
}

impl Bench {
    fn new(mode: Mode) -> Bench {
        let settings = Settings {
            address: 1,
            mode,
            range_mm: 50,
            serial: None,
            timeout_ms: 40,
            late_limit_ms: 60,
        };
        let driver = Riftek::new(settings).expect("settings of a test are sound");
        let mut bench = Bench { driver, now: Nanos::ZERO, sent: Vec::new(), events: Vec::new() };
        bench.driver.connected(bench.now);
        bench.drain();
        bench
    }

    /// A sensor that said who it is.
    fn identified(mode: Mode) -> Bench {
        let mut bench = Bench::new(mode);
        bench.next_timeout();
        bench.receive(&IDENTITY);
        bench
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.driver.receive(self.now, Input::Bytes(bytes));
        self.drain();
    }

    /// The line is silent for so long that what came is whole.
    fn be_silent(&mut self) {
        self.now = self.now + std::time::Duration::from_millis(20);
        self.driver.timeout(self.now);
        self.drain();
    }

    fn next_timeout(&mut self) {
        self.now = self.driver.poll_timeout().expect("the driver waits for something");
        self.driver.timeout(self.now);
        self.drain();
    }

    fn drain(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            self.sent.push(bytes);
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    fn readings(&self) -> Vec<Reading> {
        let reading = |event: &Event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        };
        self.events.iter().filter_map(reading).collect()
    }

    fn values(&self) -> Vec<Option<f64>> {
        self.readings().iter().map(|reading| reading.values.get(0)).collect()
    }

    fn faults(&self) -> Vec<(FaultKind, String)> {
        let fault = |event: &Event| match event {
            Event::Fault(fault) | Event::Reopen(fault) => Some((fault.kind, fault.detail.clone())),
            _ => None,
        };
        self.events.iter().filter_map(fault).collect()
    }

    fn discarded(&self) -> u64 {
        let bytes = |event: &Event| match event {
            Event::Discarded { bytes } => *bytes,
            _ => 0,
        };
        self.events.iter().map(bytes).sum()
    }

    fn is_abandoned(&self) -> bool {
        self.events.iter().any(|event| matches!(event, Event::Reopen(_)))
    }
}

#[test]
fn requests_of_the_manual() {
    assert_eq!(Request::Identify.encode(1), [0x01, 0x81]);
    assert_eq!(Request::Result.encode(1), [0x01, 0x86]);
    assert_eq!(Request::StartStream.code(), 7);
    assert_eq!(Request::StopStream.code(), 8);
}

#[test]
fn answers_of_the_manuals() {
    let read = |len: usize, bytes: &[u8]| {
        let mut decoder = Decoder::new(len);
        bytes.iter().filter_map(|byte| decoder.push(*byte)).next().expect("a whole answer")
    };
    let rf602 = read(8, &IDENTITY);
    let expected =
        Identity { device_type: 0x3F, firmware: 0x90, serial: 0x4321, base_mm: 80, range_mm: 50 };
    assert_eq!((rf602.identity(), rf602.count, rf602.is_new), (Some(expected), 1, false));
    // RF605 manual of 2011, page 17.
    let rf605 = [
        0x91, 0x96, 0x98, 0x95, 0x92, 0x96, 0x91, 0x90, 0x90, 0x95, 0x90, 0x90, 0x92, 0x93, 0x90,
        0x90,
    ];
    let expected =
        Identity { device_type: 0x61, firmware: 0x58, serial: 0x0162, base_mm: 80, range_mm: 50 };
    assert_eq!(read(8, &rf605).identity(), Some(expected));
    // RF602 manual, page 16: parameter 05h is 04h, answer 2.
    let parameter = read(1, &[0xA4, 0xA0]);
    assert_eq!((parameter.bytes(), parameter.count, parameter.is_new), (&[4][..], 2, false));
    let result = read(2, &RESULT_677);
    assert_eq!((result.result(), result.count, result.is_new), (Some(677), 3, true));
}

/// 677 of 16384 parts of 50 mm are 2.066 mm (RF602 manual, page 17).
#[test]
fn a_polled_result_becomes_a_reading() {
    let mut bench = Bench::identified(POLL);
    assert_eq!(bench.sent, [[0x01, 0x88], [0x01, 0x81], [0x01, 0x86]]);
    bench.receive(&RESULT_677);
    assert!(bench.readings().is_empty(), "a byte too many may follow");
    bench.be_silent();
    assert_eq!(bench.events[0], Event::Online);
    let [Some(mm)] = bench.values()[..] else { panic!("{:?}", bench.events) };
    assert!((mm - 2.066).abs() < 1e-3);
    bench.next_timeout();
    bench.receive(&encode_answer(false, 0, &677_u16.to_le_bytes()));
    assert_eq!((bench.readings().len(), bench.driver.tally().repeated), (1, 1), "nothing new");
    assert_eq!(bench.discarded(), 0);
}

#[test]
fn a_stream_is_started_and_read() {
    let mut bench = Bench::identified(STREAM);
    assert_eq!(bench.sent, [[0x01, 0x88], [0x01, 0x81], [0x01, 0x87]]);
    for (n, result) in [8192_u16, 1, 16_383].iter().enumerate() {
        bench.receive(&encode_answer(true, n as u8, &result.to_le_bytes()));
    }
    bench.be_silent();
    assert_eq!(
        bench.values(),
        [Some(25.0), Some(50.0 / 16_384.0), Some(16_383.0 * 50.0 / 16_384.0)]
    );
    assert!(bench.events.contains(&Event::Ready));
    assert!(bench.faults().is_empty());
}

#[test]
fn the_ends_of_the_range_are_gaps() {
    let mut bench = Bench::identified(STREAM);
    for (n, result) in [0_u16, 0x4000, 0x4001, 0xFFFF].iter().enumerate() {
        bench.receive(&encode_answer(true, n as u8, &result.to_le_bytes()));
    }
    bench.be_silent();
    assert_eq!(bench.values(), [None; 4]);
    let flags: Vec<Flags> = bench.readings().iter().map(|reading| reading.flags).collect();
    let (out, suspect) = (Flags::OUT_OF_RANGE, Flags::SUSPECT);
    assert_eq!(flags, [out, out, suspect, suspect]);
}

/// A stream that runs from before: its results are not taken for the identity, and the line is silent first.
#[test]
fn a_stream_from_before_is_stopped_first() {
    let mut bench = Bench::new(STREAM);
    for n in 0..5 {
        bench.now = Nanos::from_millis(10 * n);
        bench.receive(&encode_answer(true, n as u8, &[1, 2]));
    }
    assert_eq!(bench.sent.len(), 1);
    bench.next_timeout();
    assert_eq!((bench.now, bench.sent.len()), (Nanos::from_millis(90), 2));
    bench.receive(&IDENTITY);
    assert_eq!((bench.discarded(), bench.readings().len()), (20, 0));
    assert!(bench.events.contains(&Event::Online));
}

#[test]
fn a_stream_that_cannot_be_stopped_is_given_up() {
    let mut bench = Bench::new(STREAM);
    let mut n = 0;
    while !bench.is_abandoned() {
        n += 1;
        bench.now = Nanos::from_millis(10 * n);
        bench.receive(&encode_answer(true, n as u8, &[1, 2]));
        if bench.driver.poll_timeout().is_some_and(|due| due <= bench.now) {
            bench.driver.timeout(bench.now);
            bench.drain();
        }
        assert!(n < 1000, "it waits for ever");
    }
    assert!(bench.faults()[0].1.contains("goes on after it was stopped"));
}

#[test]
fn lost_results_are_counted_and_reported_once_a_run() {
    let mut bench = Bench::identified(STREAM);
    for count in [1, 2, 0, 2, 3] {
        bench.receive(&encode_answer(true, count, &[1, 2]));
    }
    bench.be_silent();
    assert_eq!((bench.readings().len(), bench.driver.tally().lost), (5, 2));
    let flagged: Vec<bool> = bench.readings().iter().map(|it| !it.flags.is_empty()).collect();
    assert_eq!(flagged, [false, false, true, true, false], "noise counts from anywhere");
    assert_eq!(
        bench.faults(),
        [(
            FaultKind::Protocol,
            "1 or more results of the stream were lost on the line: check cable and baud rate"
                .to_owned()
        )]
    );
}

/// Four bytes of noise look like an answer now and then. Beside other noise none of them is believed.
#[test]
fn answers_behind_noise_are_no_good_readings() {
    for mode in [STREAM, POLL] {
        let mut bench = Bench::identified(mode);
        bench.receive(b"\x7F");
        bench.receive(&encode_answer(true, 1, &[1, 2]));
        bench.be_silent();
        assert_eq!((bench.values(), bench.readings()[0].flags), (vec![None], Flags::SUSPECT));
        if mode == POLL {
            bench.next_timeout();
        }
        bench.receive(&encode_answer(true, 2, &[1, 2]));
        bench.be_silent();
        assert!(bench.values()[1].is_some() && bench.readings()[1].flags.is_empty());
    }
    let mut bench = Bench::identified(STREAM);
    bench.receive(b"\x7F");
    bench.receive(&encode_answer(false, 1, &[1, 2]));
    assert_eq!(
        (bench.readings().len(), bench.discarded()),
        (0, 5),
        "counted, since it is no answer"
    );
}

/// The commonest noise is a byte. One that looks like the begin of the answer behind it shifts it by half a byte.
#[test]
fn a_byte_of_noise_before_an_answer_never_shifts_a_value() {
    for mode in [STREAM, POLL] {
        for noise in 0..=255_u8 {
            let mut bench = Bench::identified(mode);
            bench.receive(
                &[&[noise][..], &encode_answer(true, 1, &8192_u16.to_le_bytes())].concat(),
            );
            bench.be_silent();
            let good = bench.readings().into_iter().filter(|reading| reading.flags.is_empty());
            assert_eq!(good.count(), 0, "{noise:02X}: {:?}", bench.events);
            bench.driver.disconnected(bench.now);
            bench.drain();
            let used = 4 * bench.readings().len() as u64;
            assert_eq!(used + bench.discarded(), 5, "{noise:02X}");
        }
    }
}

#[test]
fn another_sensor_is_found_out() {
    let mut bench = Bench::new(STREAM);
    bench.next_timeout();
    bench.receive(&encode_answer(false, 1, &[0x3F, 0x90, 0x21, 0x43, 80, 0, 100, 0]));
    assert!(bench.is_abandoned());
    assert!(bench.faults()[0].1.contains("range of 100 mm, expected 50 mm"));
    let settings = Settings {
        address: 1,
        mode: STREAM,
        range_mm: 50,
        serial: Some(7),
        timeout_ms: 40,
        late_limit_ms: 60,
    };
    bench.driver = Riftek::new(settings).expect("settings of a test are sound");
    bench.driver.connected(bench.now);
    bench.next_timeout();
    bench.receive(&IDENTITY);
    assert!(bench.faults()[1].1.contains("serial number 17185, expected 7"));
    assert!(!bench.events.contains(&Event::Online));
}

#[test]
fn a_device_that_speaks_otherwise_or_not_at_all_is_given_up() {
    for bytes in [&b""[..], b"+01.2345\r\n", &IDENTITY[..15]] {
        let mut bench = Bench::new(STREAM);
        bench.next_timeout();
        while !bench.is_abandoned() {
            bench.receive(bytes);
            bench.next_timeout();
        }
        assert_eq!(bench.sent, [[0x01, 0x88], [0x01, 0x81], [0x01, 0x81]]);
        let (kind, detail) = &bench.faults()[0];
        assert!(*kind == FaultKind::Timeout && detail.contains("even parity"), "{detail}");
        bench.driver.disconnected(bench.now);
        bench.drain();
        assert_eq!(bench.discarded(), 2 * bytes.len() as u64);
    }
}

/// Half an answer, then the other half late: neither is a reading, and the next question waits for silence.
#[test]
fn a_late_answer_is_never_taken_for_the_next() {
    let mut bench = Bench::identified(POLL);
    bench.receive(&RESULT_677[..2]);
    bench.next_timeout();
    bench.now = bench.now + std::time::Duration::from_millis(30);
    bench.receive(&RESULT_677[2..]);
    let asked = bench.sent.len();
    let heard = bench.now;
    while bench.sent.len() == asked {
        bench.next_timeout();
    }
    assert!(bench.now.since(heard).as_millis() >= 60);
    bench.receive(&encode_answer(true, 0, &8192_u16.to_le_bytes()));
    bench.be_silent();
    assert_eq!((bench.values(), bench.discarded()), (vec![Some(25.0)], 4));
}

#[test]
fn a_sensor_that_falls_silent_is_connected_anew() {
    let mut polled = Bench::identified(POLL);
    while !polled.is_abandoned() {
        polled.next_timeout();
    }
    assert_eq!(polled.driver.tally().timeouts, 5);
    // A restart ends the stream; the sensor does not start it by itself.
    let mut streamed = Bench::identified(STREAM);
    streamed.receive(&RESULT_677);
    let next = encode_answer(true, 0, &677_u16.to_le_bytes());
    streamed.receive(&next[..2]);
    streamed.next_timeout();
    assert!(streamed.faults()[0].1.contains("no result of the stream for 500 ms"));
    streamed.driver.disconnected(streamed.now);
    streamed.sent.clear();
    streamed.driver.connected(streamed.now);
    streamed.drain();
    streamed.next_timeout();
    streamed.receive(&IDENTITY);
    streamed.receive(&next[2..]);
    streamed.receive(&encode_answer(true, 1, &8192_u16.to_le_bytes()));
    streamed.be_silent();
    assert_eq!(streamed.sent, [[0x01, 0x88], [0x01, 0x81], [0x01, 0x87]]);
    assert_eq!(streamed.readings().len(), 2, "no half from before the restart");
}

/// Everything a stream of bytes gives, cut there.
fn run(bytes: &[u8], cut: usize) -> (Vec<Event>, u64) {
    let mut bench = Bench::identified(STREAM);
    let (first, second) = bytes.split_at(cut.min(bytes.len()));
    bench.receive(first);
    bench.receive(second);
    bench.driver.disconnected(bench.now);
    bench.drain();
    let discarded = bench.discarded();
    let events = bench.events.into_iter().filter(|event| !matches!(event, Event::Discarded { .. }));
    (events.collect(), discarded)
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Cut at any byte, with garbage between: the same events, and every byte is in a reading or counted.
    #[test]
    fn chunks_change_nothing(
        pieces in proptest::collection::vec((1u16..16_384, proptest::collection::vec(0u8..0x80, 0..8)), 0..12),
        cut in 0usize..120,
    ) {
        let mut bytes = Vec::new();
        for (n, (result, garbage)) in pieces.iter().enumerate() {
            bytes.extend(garbage);
            bytes.extend(encode_answer(true, n as u8, &result.to_le_bytes()));
        }
        let whole = run(&bytes, 0);
        prop_assert_eq!(&run(&bytes, cut), &whole);
        let readings = whole.0.iter().filter(|event| matches!(event, Event::Reading(_))).count();
        prop_assert_eq!(readings, pieces.len());
        prop_assert_eq!(readings as u64 * 4 + whole.1, bytes.len() as u64);
    }

    /// Before the sensor said who it is nothing is a reading.
    #[test]
    fn garbage_is_no_reading(bytes: Vec<u8>) {
        let mut bench = Bench::new(STREAM);
        bench.receive(&bytes);
        bench.next_timeout();
        bench.receive(&bytes);
        prop_assert!(bench.readings().is_empty() || bench.events.contains(&Event::Online));
        prop_assert!(bench.discarded() <= 2 * bytes.len() as u64);
    }
}
