//! The scanner in virtual time: what a network and a scanner do to its profiles.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use std::time::Duration;

use asphera_link::{Driver as _, Event, FaultKind, Flags, Input, Nanos, Reading};
use asphera_rf627::wire::{Format, Header, RawPoint, encode};
use asphera_rf627::{Rf627, Settings};

struct Bench {
    driver: Rf627,
    now: Nanos,
    events: Vec<Event>,
}

impl Bench {
    fn new(settings: Settings) -> Bench {
        let driver = Rf627::new(settings).unwrap();
        let mut bench = Bench { driver, now: Nanos::ZERO, events: Vec::new() };
        bench.driver.connected(bench.now);
        bench
    }

    fn pass(&mut self, ms: u64) {
        let until = self.now + Duration::from_millis(ms);
        while let Some(due) = self.driver.poll_timeout().filter(|due| *due <= until) {
            self.driver.timeout(due);
            self.drain();
        }
        self.now = until;
    }

    /// A datagram 2 ms after what came before.
    fn receive(&mut self, datagram: &[u8]) {
        self.pass(2);
        self.driver.receive(self.now, Input::Bytes(datagram));
        self.drain();
    }

    fn drain(&mut self) {
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    fn readings(&self) -> Vec<&Reading> {
        let reading = |event: &'_ Event| matches!(event, Event::Reading(_));
        let found = self.events.iter().filter(|event| reading(event));
        found
            .map(|event| if let Event::Reading(it) = event { it } else { unreachable!() })
            .collect()
    }

    fn counts(&self) -> Vec<Option<u32>> {
        self.readings().iter().map(|reading| reading.count.map(|count| count.raw)).collect()
    }

    fn faults(&self) -> Vec<(FaultKind, &str)> {
        let fault = |event: &'_ Event| match event {
            Event::Fault(fault) | Event::Reopen(fault) => Some(fault.clone()),
            _ => None,
        };
        let kinds = self.events.iter().filter_map(fault).map(|fault| fault.kind);
        let words = self.events.iter().filter_map(|event| match event {
            Event::Fault(fault) | Event::Reopen(fault) => Some(fault.detail.as_str()),
            _ => None,
        });
        kinds.zip(words).collect()
    }
}

fn header(measure: u32) -> Header {
    Header {
        format: Format::Profile,
        serial: 180_000,
        time_ns: 50_000_000_000 + 2_000_000 * u64::from(measure),
        version: (1, 0),
        packet_count: 4_000 + measure,
        measure_count: measure,
        z_range_mm: 200,
        x_range_mm: 166,
        range_steps: 16_384,
        licence_hash: 0,
        exposure_ns: 100_000,
        laser: 42,
        step_count: 10 * measure,
        direction: 0,
    }
}

fn datagram(header: &Header) -> Vec<u8> {
    let points =
        [RawPoint { x: -16_384, z: 8192 }, RawPoint { x: 0, z: 5 }, RawPoint { x: 1, z: 0 }];
    let mut bytes = Vec::new();
    encode(header, &points, None, &mut bytes).unwrap();
    bytes
}

fn profile(measure: u32) -> Vec<u8> {
    datagram(&header(measure))
}

#[test]
fn a_profile_is_a_reading_with_points_step_and_time() {
    let mut bench = Bench::new(Settings::default());
    bench.receive(&profile(3));
    assert_eq!(bench.events[..2], [Event::Online, Event::Ready]);
    let reading = bench.readings()[0];
    assert_eq!(reading.device_time_ns, Some(50_006_000_000));
    assert_eq!(reading.values.iter().collect::<Vec<_>>(), [Some(30.0), Some(1e-4), Some(1.0)]);
    let points = reading.values.profile().unwrap().points_mm();
    assert_eq!(points, [Some([-166.0, 100.0]), None, None], "no value where x or z is 0");
    let tally = bench.driver.tally();
    assert_eq!((tally.points, tally.empty_points), (3, 2));
    assert_eq!(bench.driver.channels().len(), reading.values.len());
}

#[test]
fn an_encoder_below_its_zero_counts_down() {
    let mut bench = Bench::new(Settings::default());
    bench.receive(&datagram(&Header { step_count: u32::MAX - 4, ..header(0) }));
    assert_eq!(bench.readings()[0].values.get(0), Some(-5.0));
}

#[test]
fn lost_repeated_and_overtaking_datagrams_are_reported() {
    let mut bench = Bench::new(Settings::default());
    for measure in [0, 1, 3, 4, 4, 6, 5, 7] {
        bench.receive(&profile(measure));
    }
    bench.pass(30);
    let sent: Vec<Option<u32>> = [0, 1, 3, 4, 5, 6, 7].into_iter().map(Some).collect();
    assert_eq!(bench.counts(), sent);
    let tally = bench.driver.tally();
    assert_eq!((tally.missing, tally.repeated, tally.overtaken), (1, 1, 1));
    assert!(bench.events.contains(&Event::Discarded { bytes: profile(4).len() as u64 }));
    let words: Vec<&str> = bench.faults().iter().map(|(_, words)| *words).collect();
    let expected = [
        "profile 4 came twice",
        "profile 5 came after later ones",
        "1 profiles are missing before 3: datagrams were lost",
    ];
    for words_of in expected {
        assert!(words.iter().any(|words| words.starts_with(words_of)), "{words:?}");
    }
}

#[test]
fn a_profile_after_it_was_given_up_is_used_without_its_number() {
    let mut bench = Bench::new(Settings { reorder_ms: 3, ..Settings::default() });
    for measure in [0, 2, 3, 4, 1, 5] {
        bench.receive(&profile(measure));
    }
    assert_eq!(bench.counts(), [Some(0), Some(2), Some(3), Some(4), None, Some(5)]);
    assert_eq!(bench.readings()[4].flags, Flags::DELAYED);
    assert_eq!(bench.driver.tally().late, 1);
}

#[test]
fn measurements_that_were_not_sent_are_not_waited_for() {
    let mut bench = Bench::new(Settings::default());
    bench.receive(&profile(0));
    bench.receive(&datagram(&Header { packet_count: 4001, ..header(5) }));
    assert_eq!(bench.counts(), [Some(0), Some(5)]);
    assert!(
        bench.faults()[0].1.contains("4 profiles are missing before 5: the scanner did not send")
    );
}

#[test]
fn a_restart_of_the_scanner_is_reported() {
    let mut bench = Bench::new(Settings::default());
    for measure in 0..4 {
        bench.receive(&profile(measure));
    }
    bench.receive(&datagram(&Header { time_ns: 1_000, packet_count: 0, ..header(0) }));
    let (kind, words) = *bench.faults().last().unwrap();
    assert_eq!(kind, FaultKind::Device);
    assert!(words.contains("the scanner counts from 0 again") && words.contains("anew"), "{words}");
}

#[test]
fn two_profiles_of_one_number_are_both_there_and_one_is_flagged() {
    let mut bench = Bench::new(Settings::default());
    bench.receive(&profile(0));
    bench.receive(&datagram(&Header { packet_count: 4001, ..header(0) }));
    assert_eq!(bench.counts(), [Some(0), None]);
    assert_eq!(bench.readings()[1].flags, Flags::AMBIGUOUS_COUNT);
}

#[test]
fn another_scanner_and_other_words_are_discarded() {
    let mut bench = Bench::new(Settings::default());
    bench.receive(b"GET / HTTP/1.1\r\n");
    assert!(bench.readings().is_empty() && !bench.events.contains(&Event::Online));
    bench.receive(&profile(0));
    bench.receive(&datagram(&Header { serial: 5, ..header(1) }));
    bench.receive(&profile(1));
    assert_eq!(bench.counts(), [Some(0), Some(1)]);
    assert_eq!(bench.driver.tally().refused, 2);
    assert!(bench.faults()[1].1.contains("scanner 5, expected 180000"), "{:?}", bench.faults());
    let mut named = Bench::new(Settings { serial: Some(5), ..Settings::default() });
    named.receive(&profile(0));
    assert!(named.readings().is_empty() && !named.events.contains(&Event::Online));
}

#[test]
fn silence_opens_the_link_anew_and_nothing_from_before_is_left() {
    let mut bench =
        Bench::new(Settings { silence_ms: 100, reorder_ms: 500, ..Settings::default() });
    bench.pass(1000);
    assert!(bench.faults().is_empty(), "a scanner that never spoke is no fault");
    bench.receive(&profile(0));
    bench.receive(&profile(2));
    bench.pass(200);
    assert_eq!(bench.counts(), [Some(0), Some(2)], "the one that waited is given first");
    assert!(
        matches!(bench.events.last(), Some(Event::Reopen(fault)) if fault.kind == FaultKind::Timeout)
    );
    bench.driver.disconnected(bench.now);
    bench.events.clear();
    bench.driver.connected(bench.now);
    bench.receive(&datagram(&Header { serial: 9, ..header(0) }));
    assert_eq!(bench.counts(), [Some(0)]);
    assert_eq!(bench.events[0], Event::Online);
}
