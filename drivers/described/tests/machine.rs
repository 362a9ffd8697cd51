//! The state machine in virtual time: half lines, late answers, wrong devices, damaged streams.

mod common;

use asphera_link::{Command, Event, FaultKind, Flags, Input, Nanos};
use common::{Bench, driver};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

const STREAM: &str = "columns = 1\nfield = [{ name = 'z', column = 1, unit = 'mm' }]\n\
    on_connect = ['C\\r']\non_start = ['GO\\r']\non_stop = ['STOP\\r']";

const ASKED: &str = "columns = 1\npoll = { ask = 'M\\r', interval_ms = 100, timeout_ms = 40, late_limit_ms = 150 }\n\
    field = [{ name = 'z', column = 1, unit = 'mm' }]\nrefusal = [{ pattern = 'E\\d', means = 'cover open' }]\n\
    ignore = ['M']";

const ECHOED: &str = "columns = 1\npoll = { ask = 'MEAS?\\r\\n' }\nhello = { ask = 'I\\r', answer = 'ACME.*' }\n\
    field = [{ name = 'z', column = 1 }]";

const GREETED: &str = "columns = 1\npoll = { ask = 'M\\r' }\nhello = { ask = 'I\\r', answer = 'ACME.*', timeout_ms = 300 }\n\
    field = [{ name = 'z', column = 1, unit = 'mm' }]";

const GUARDED: &str = "columns = 2\nseparator = ','\nchecksum = { kind = 'xor8', form = 'hex', skip_last = 1 }\n\
    field = [{ name = 'n', column = 1 }, { name = 'z', column = 2, unit = 'mm' }]";

/// A device that is asked and has proved to be there.
fn asked() -> Bench {
    let mut bench = Bench::new(ASKED);
    bench.receive("1\r");
    bench.next_question();
    bench
}

#[test]
fn a_device_that_sends_is_online_with_its_first_whole_line() {
    let mut bench = Bench::new(STREAM);
    assert_eq!((&bench.sent[..], bench.driver.poll_timeout()), (&["C\\r".to_owned()][..], None));
    bench.receive("345\r\n");
    assert_eq!((bench.events.len(), bench.discarded()), (1, 4), "it may be half of 12.345");
    bench.now = Nanos::from_millis(7);
    bench.receive("12.5\r\n12.25\r\n");
    assert_eq!(bench.values(), [Some(12.5), Some(12.25)]);
    assert_eq!((bench.count(&Event::Online), bench.count(&Event::Ready)), (1, 1));
    assert_eq!(bench.events[1], Event::Online);
    assert_eq!(bench.readings()[0].host, Nanos::from_millis(7));
}

#[test]
fn starting_and_stopping_is_said_to_the_device() {
    let mut bench = Bench::new(STREAM);
    bench.driver.command(bench.now, Command::Start);
    bench.driver.command(bench.now, Command::Stop);
    bench.drain();
    assert_eq!(bench.sent, ["C\\r", "GO\\r", "STOP\\r"]);
    bench.driver.command(bench.now, Command::Start);
    bench.driver.disconnected(bench.now);
    bench.driver.connected(bench.now);
    bench.drain();
    assert_eq!(
        bench.sent[3..],
        ["C\\r", "GO\\r"],
        "it is wanted still, and said once to each connection"
    );
}

#[test]
fn nothing_from_before_a_reconnect_is_decoded() {
    let mut bench = Bench::new(STREAM);
    bench.receive("1\r\n2\r\n3");
    bench.driver.disconnected(bench.now);
    bench.driver.connected(bench.now);
    bench.receive("4\r\n5\r\n");
    assert_eq!(bench.values(), [Some(2.0), Some(5.0)]);
    assert_eq!(
        bench.discarded(),
        2 + 1 + 2,
        "first, last of the first connection, first of the second"
    );
}

#[test]
fn what_is_no_reading_is_counted_and_said_once_a_run() {
    let mut bench = Bench::new(STREAM);
    bench.receive("\rdistance\r1 2\r3\r???\r4\r");
    assert_eq!(bench.values(), [Some(3.0), Some(4.0)]);
    let told: Vec<_> = bench.faults().into_iter().map(|(_, detail)| detail).collect();
    assert_eq!(
        told,
        [
            "`distance` has no number where a channel stands: check baud rate and settings",
            "`???` has no number where a channel stands: check baud rate and settings"
        ]
    );
    assert_eq!(bench.discarded(), 8 + 3 + 3);
}

#[test]
fn the_first_answer_only_proves_that_the_device_is_there() {
    let mut bench = Bench::new(ASKED);
    assert_eq!(bench.sent, ["M\\r"]);
    bench.receive("7\r");
    assert_eq!((bench.readings().len(), bench.count(&Event::Online)), (0, 1));
    // The line must be silent: an answer to a question of before comes now.
    bench.now = Nanos::from_millis(100);
    bench.receive("8\r");
    assert_eq!(bench.driver.poll_timeout(), Some(Nanos::from_millis(250)));
    bench.next_question();
    bench.receive("9\r");
    assert_eq!(bench.values(), [Some(9.0)]);
    assert_eq!(bench.count(&Event::Ready), 1);
}

#[test]
fn questions_are_due_at_fixed_times_and_never_pile_up() {
    let mut bench = asked();
    let asked_at = bench.now;
    bench.receive("1\r");
    assert_eq!(bench.driver.poll_timeout(), Some(asked_at + std::time::Duration::from_millis(100)));
    // The host slept.
    bench.now = asked_at + std::time::Duration::from_millis(350);
    bench.driver.timeout(bench.now);
    bench.drain();
    bench.receive("2\r");
    assert_eq!(bench.driver.poll_timeout(), Some(asked_at + std::time::Duration::from_millis(400)));
}

#[test]
fn a_late_answer_is_never_taken_for_the_next() {
    let mut bench = asked();
    bench.next_timeout();
    assert_eq!(
        bench.faults(),
        [(
            FaultKind::Timeout,
            "no answer to `M\\r` within 40 ms: check cable and power, or increase timeout_ms"
                .to_owned()
        )]
    );
    // It comes after all, and the settling begins anew.
    bench.receive("99\r");
    let settled = bench.now + std::time::Duration::from_millis(150);
    assert_eq!(bench.driver.poll_timeout(), Some(settled));
    bench.next_question();
    bench.receive("3\r");
    assert_eq!(bench.values(), [Some(3.0)]);
    assert_eq!(bench.discarded(), 3);
}

#[test]
fn what_came_instead_of_an_answer_is_named() {
    let mut bench = asked();
    bench.receive("M\r");
    bench.receive("what?\r");
    bench.next_timeout();
    let told: Vec<_> = bench.faults().into_iter().map(|(_, detail)| detail).collect();
    let unreadable = "`what?` has no number where a channel stands: check baud rate and settings";
    assert_eq!(
        told,
        [
            unreadable,
            "no answer to `M\\r` within 40 ms; `what?` came: check cable and power, or increase timeout_ms"
        ]
    );
}

/// A number among noise may be part of the noise, where nothing guards it.
#[test]
fn an_answer_among_noise_is_flagged() {
    let mut bench = asked();
    bench.receive(b"\xFF\x12\r7\r");
    bench.next_question();
    bench.receive("8\r");
    let flags: Vec<_> = bench.readings().iter().map(|reading| reading.flags).collect();
    assert_eq!(
        (bench.values(), flags),
        (vec![Some(7.0), Some(8.0)], vec![Flags::SUSPECT, Flags::empty()])
    );
    // An echo is no noise, described or not.
    bench.next_question();
    bench.receive("M\r9\r");
    assert_eq!(bench.readings()[2].flags, Flags::empty());
}

#[test]
fn an_echo_of_the_question_is_no_noise() {
    let mut bench = Bench::new(ECHOED);
    bench.receive("ACME\r\n");
    bench.receive("MEAS?\r\n1.5\r\n");
    assert_eq!((bench.values(), bench.readings()[0].flags), (vec![Some(1.5)], Flags::empty()));
    assert_eq!((bench.faults().len(), bench.discarded()), (0, 0));
}

#[test]
fn a_device_that_never_answers_is_connected_anew() {
    let mut bench = asked();
    for _ in 0..5 {
        bench.next_timeout();
        if bench.driver.poll_timeout().is_some() {
            bench.next_question();
        }
    }
    assert!(
        matches!(bench.events.last(), Some(Event::Reopen(fault)) if fault.kind == FaultKind::Timeout)
    );
    assert_eq!(bench.driver.poll_timeout(), None);
}

#[test]
fn a_refusal_is_told_in_the_words_of_the_description() {
    let mut bench = asked();
    bench.receive("E4\r");
    assert_eq!(
        bench.faults(),
        [(FaultKind::Refused, "the device answers `E4`: cover open".to_owned())]
    );
    bench.next_question();
    bench.receive("3\r");
    assert_eq!(bench.values(), [Some(3.0)]);
}

#[test]
fn another_device_is_found_out() {
    let mut bench = Bench::new(GREETED);
    assert_eq!(bench.sent, ["I\\r"]);
    bench.receive("OTHER 5\r");
    bench.next_timeout();
    bench.receive("OTHER 5\r");
    bench.next_timeout();
    let (kind, detail) = &bench.faults()[0];
    assert_eq!(*kind, FaultKind::Protocol);
    assert_eq!(
        detail,
        "`I\\r` is answered by `OTHER 5`, expected `ACME.*`: check the baud rate, or connect the right device"
    );
    assert_eq!((bench.sent.len(), bench.count(&Event::Online)), (2, 0));
    let mut silent = Bench::new(GREETED);
    silent.next_timeout();
    silent.next_timeout();
    let words = "no answer to `I\\r` within 300 ms, asked 2 times: check cable";
    assert!(silent.faults()[0].1.starts_with(words));
}

#[test]
fn a_device_that_greets_is_believed_from_its_first_answer_on() {
    let mut bench = Bench::new(GREETED);
    bench.receive("ACME 7\r");
    assert_eq!((bench.count(&Event::Online), bench.count(&Event::Ready)), (1, 1));
    assert_eq!(bench.sent, ["I\\r", "M\\r"]);
    bench.receive("1.5\r");
    assert_eq!(bench.values(), [Some(1.5)]);
}

#[test]
fn a_damaged_line_is_no_reading() {
    let mut bench = Bench::new(GUARDED);
    // 1 ^ , ^ 5 is 31h ^ 2Ch ^ 35h = 28h.
    bench.receive("\n1,5*28\n1,6*28\n1,5*28\n");
    assert_eq!(bench.values(), [Some(1.0), Some(1.0)]);
    assert_eq!(bench.faults()[0].1, "checksum of `1,6*28` is wrong: check cable and baud rate");
    assert_eq!(bench.discarded(), 6);
}

#[test]
fn trouble_of_the_device_is_told_once_and_flags_every_reading() {
    let mut bench = Bench::new(
        "columns = 2\n[[field]]\nname = 'z'\ncolumn = 1\n[[field]]\nname = 'lamp'\ncolumn = 2\nrole = 'status'\n\
         good = ['0']\ndevice_error = ['9']",
    );
    bench.receive("\n1 9\n2 9\n3 0\n4 9\n");
    let fault = (FaultKind::Device, "the device reports lamp `9`: see its manual".to_owned());
    assert_eq!(bench.faults(), [fault.clone(), fault]);
    let flags: Vec<_> = bench.readings().iter().map(|reading| reading.flags).collect();
    let bad = Flags::DEVICE_ERROR;
    assert_eq!(flags, [bad, bad, Flags::empty(), bad]);
}

/// 1 of 15.5, a silence, and 12.5: none is 112.5.
#[test]
fn half_a_line_and_the_next_are_no_good_reading() {
    let mut bench = Bench::new(STREAM);
    bench.receive("\r3\r1");
    bench.now = Nanos::from_millis(50);
    bench.receive("12.5\r4\r");
    // A line in two pieces is one line.
    bench.receive("1");
    bench.now = Nanos::from_millis(99);
    bench.receive("5.5\r");
    let flags: Vec<_> = bench.readings().iter().map(|reading| reading.flags).collect();
    let good = Flags::empty();
    assert_eq!(bench.values(), [Some(3.0), Some(112.5), Some(4.0), Some(15.5)]);
    assert_eq!(flags, [good, Flags::SUSPECT, good, good]);
}

#[test]
fn a_line_after_noise_is_flagged_unless_a_check_guards_it() {
    let mut bench = Bench::new(STREAM);
    bench.receive("\r3\r\u{1}?\r5\r4\r");
    let flags: Vec<_> = bench.readings().iter().map(|reading| reading.flags).collect();
    assert_eq!(flags, [Flags::empty(), Flags::SUSPECT, Flags::empty()]);
    let mut bench = Bench::new(GUARDED);
    bench.receive("\n?\n1,5*28\n");
    assert_eq!(bench.readings()[0].flags, Flags::empty());
}

#[test]
fn a_device_that_falls_silent_is_connected_anew_where_its_gap_is_known() {
    let mut bench = Bench::new(&format!("gap_ms = 200\n{STREAM}"));
    assert_eq!(bench.driver.poll_timeout(), None, "one that never spoke is told by its link");
    bench.receive("\r3\r");
    bench.now = Nanos::from_millis(100);
    // Half a line is no sign of life.
    bench.receive("4");
    bench.next_timeout();
    let (kind, detail) = &bench.faults()[0];
    assert_eq!((bench.now, *kind), (Nanos::from_millis(200), FaultKind::Timeout));
    assert!(detail.starts_with("no frame for 200 ms: check cable"), "{detail}");
    assert_eq!((bench.driver.poll_timeout(), bench.discarded()), (None, 1));
    let wrong = driver("gap_ms = 5\npoll = { ask = 'M' }\nfield = [{ name = 'z', column = 1 }]");
    let problems = wrong.err().expect("it cannot be used");
    assert!(problems.0.iter().all(|problem| problem.key == "gap_ms") && problems.0.len() == 2);
}

#[test]
fn the_last_record_is_given_after_a_silence() {
    let mut bench = Bench::new(
        "frame = 'record'\nlength = 4\nbegin = 'AB'\nsilence_ms = 30\n\
         field = [{ name = 'z', at = 2, form = 'i16' }]",
    );
    bench.receive(b"AB\x00\x01");
    assert_eq!(bench.readings().len(), 0);
    bench.next_timeout();
    assert_eq!((bench.now, bench.values()), (Nanos::from_millis(30), vec![Some(1.0)]));
    bench.receive(b"AB\x00");
    bench.next_timeout();
    assert_eq!((bench.readings().len(), bench.discarded()), (1, 3), "a record that lost a byte");
}

#[test]
fn a_flood_without_an_end_is_dropped_not_kept() {
    let mut bench = Bench::new(STREAM);
    for _ in 0..100 {
        bench.receive(vec![b'7'; 10_000]);
    }
    assert_eq!((bench.discarded(), bench.readings().len()), (1_000_000, 0));
    bench.receive("\r1\r");
    assert_eq!(bench.values(), [Some(1.0)]);
}

fn persisted(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    }
}

fn run(settings: &str, bytes: &[u8], cuts: &[usize]) -> Bench {
    let mut bench = Bench::new(settings);
    let mut from = 0;
    for to in cuts.iter().copied().chain([bytes.len()]) {
        let to = to.clamp(from, bytes.len());
        bench.receive(&bytes[from..to]);
        from = to;
    }
    bench
}

proptest! {
    #![proptest_config(persisted(256))]

    /// However the bytes are cut, the readings, faults and bytes passed over are the same.
    #[test]
    fn chunks_change_nothing(
        lines in proptest::collection::vec("[0-9+., *A-F-]{0,12}", 0..12),
        mut cuts in proptest::collection::vec(0usize..160, 0..10),
    ) {
        cuts.sort_unstable();
        let bytes = lines.join("\r\n").into_bytes();
        for settings in [STREAM, GUARDED] {
            let (whole, cut) = (run(settings, &bytes, &[]), run(settings, &bytes, &cuts));
            prop_assert_eq!(whole.readings(), cut.readings());
            prop_assert_eq!(whole.faults(), cut.faults());
            prop_assert_eq!(whole.discarded(), cut.discarded());
        }
    }

    /// Random bytes and times: no panic, nothing believed of a guarded device, no growing answer.
    #[test]
    fn garbage_is_no_reading(
        chunks in proptest::collection::vec((proptest::collection::vec(any::<u8>(), 0..60), 0u64..400), 0..30),
    ) {
        for settings in [ASKED, GREETED, GUARDED] {
            let mut driver = driver(settings).unwrap();
            let mut now = Nanos::ZERO;
            driver.connected(now);
            for (bytes, wait_ms) in &chunks {
                let bytes: Vec<u8> = bytes.iter().map(|byte| byte | 0x80).collect();
                driver.receive(now, Input::Bytes(&bytes));
                let until = now + std::time::Duration::from_millis(*wait_ms);
                let mut steps = 0;
                while let Some(due) = driver.poll_timeout().filter(|due| *due <= until) {
                    now = now.max(due);
                    driver.timeout(now);
                    steps += 1;
                    prop_assert!(steps < 50, "it spins");
                }
                now = until;
                while let Some(event) = driver.poll_event() {
                    prop_assert!(!matches!(event, Event::Reading(_) | Event::Online));
                }
                while driver.poll_transmit().is_some() {}
            }
        }
    }
}
