//! The driver with a controller that answers, refuses, stops and falls silent, in virtual time.

use crate::bench::{Bench, LAYOUT, content, profile};
use asphera_keyence::Settings;
use asphera_keyence::wire::{
    Answer, ErrorCodes, Layout, NoHeight, Notice, Profile, Request, Series,
};
use asphera_link::{Command, Driver as _, Event, FaultKind, Flags};

const STOPPED: Notice = Notice(2);

#[test]
fn an_lj_x8000_is_asked_who_it_is_then_started() {
    let mut bench = Bench::new(Settings::default());
    assert!(bench.events.is_empty(), "an open port proves nothing");
    bench.answer(0x21, &[]);
    assert!(bench.events.is_empty(), "that nothing streamed is no fault");
    bench.answer_all();
    assert_eq!(bench.events, [Event::Online], "it is known now");
    assert_eq!(bench.asked, [Request::Stop, Request::Units, Request::Errors]);
    bench.command(Command::Start);
    bench.answer_all();
    let code = LAYOUT.start_code;
    assert_eq!(bench.asked[3..], [Request::Prepare, Request::Start { code }]);
    assert_eq!(bench.events, [Event::Online, Event::Ready]);
    bench.command(Command::Stop);
    bench.answer_all();
    assert_eq!(bench.asked[5..], [Request::Stop]);
    assert_eq!(bench.driver.poll_timeout(), None);
}

#[test]
fn a_batch_is_started_and_ended() {
    let mut bench = Bench::streaming(Settings { batch: true, ..Settings::default() });
    bench.command(Command::Stop);
    bench.answer_all();
    assert_eq!(bench.asked, [Request::StopMeasure, Request::Stop]);
    bench.command(Command::Start);
    bench.answer_all();
    assert_eq!(bench.asked[4..], [Request::StartMeasure]);
    bench.events.clear();
    bench.stream(&profile(0, Ok(1)));
    bench.stream(&Notice(0x1_0000).encode());
    assert_eq!((bench.events.len(), bench.driver.tally().batches), (1, 1), "its end is no fault");
}

/// After a stop the batch may be running still: then the controller may refuse to start another.
#[test]
fn a_batch_that_cannot_be_started_is_reported_and_the_stream_is_read() {
    let mut bench = Bench::new(Settings { batch: true, ..Settings::default() });
    bench.command(Command::Start);
    while bench.asked.last() != Some(&Request::StartMeasure) {
        let request = *bench.asked.last().unwrap();
        bench.answer(0, &content(request));
    }
    bench.answer(0x44, &[]);
    assert!(bench.faults()[0].detail.contains("(22h) refused with error 44h"));
    assert!(bench.events.contains(&Event::Ready));
    bench.stream(&profile(3, Ok(1)));
    assert_eq!(bench.triggers(), [3]);
}

#[test]
fn an_lj_v7000_is_asked_only_what_is_known_of_it() {
    let settings = Settings { series: Series::LjV7000, ..Settings::default() };
    let mut bench = Bench::new(settings);
    bench.command(Command::Start);
    bench.answer_all();
    let code = LAYOUT.start_code;
    assert_eq!(bench.asked, [Request::Stop, Request::Prepare, Request::Start { code }]);
    bench.wait_ms(10_000);
    assert_eq!(bench.asked.len(), 3, "and not for errors");
}

#[test]
fn a_reading_has_places_counts_and_reasons() {
    let mut bench = Bench::streaming(Settings::default());
    let heights = [
        Ok(-3),
        Ok(125_000),
        Err(NoHeight::NoPeak),
        Err(NoHeight::NoPeak),
        Err(NoHeight::Masked),
        Err(NoHeight::DeadZone),
        Err(NoHeight::Unprocessed),
        Ok(0),
    ];
    bench.stream(&Profile::encode(&LAYOUT, 41, -9, heights));
    let readings = bench.readings();
    let [reading] = readings[..] else { panic!("{readings:?}") };
    let points = reading.values.profile().unwrap().points_mm();
    // -0.35 mm + 0.1 mm each; 80 nm a unit.
    assert_eq!(points[0], Some([-0.35, -0.000_24]));
    assert_eq!(points[1], Some([-0.25, 10.0]));
    assert_eq!(points[2..7], [None; 5]);
    assert_eq!(points[7], Some([0.35, 0.0]), "a height of 0 is a height");
    let values: Vec<f64> = reading.values.iter().flatten().collect();
    assert_eq!(values, [-9.0, 3.0, 2.0, 1.0, 1.0, 1.0]);
    assert_eq!((reading.count.unwrap().raw, reading.flags), (41, Flags::empty()));
    bench.stream(&profile(42, Err(NoHeight::DeadZone)));
    assert_eq!(bench.readings()[1].flags, Flags::NO_SIGNAL);
}

/// Some controllers give 0 for the unit; then it stands with a profile of the memory.
#[test]
fn a_unit_of_zero_is_asked_for_once_more() {
    let mut bench = Bench::new(Settings::default());
    bench.command(Command::Start);
    let answers = [Request::Stop, Request::Units, Request::Errors];
    answers.into_iter().for_each(|request| bench.answer(0, &content(request)));
    bench.answer(0, &Layout { unit_10nm: 0, ..LAYOUT }.encode());
    assert_eq!(bench.asked.last(), Some(&Request::Profile));
    bench.answer_all();
    bench.stream(&profile(1, Ok(10)));
    let reading = bench.readings()[0].clone();
    assert_eq!(reading.values.profile().unwrap().points_mm()[0], Some([-0.35, 0.0016]));
}

#[test]
fn a_damaged_profile_is_counted_and_gives_no_value() {
    let mut bench = Bench::streaming(Settings::default());
    let mut damaged = profile(2, Ok(7));
    damaged[30] ^= 1;
    let bytes = [profile(1, Ok(5)), damaged.clone(), profile(3, Ok(9))].concat();
    bench.stream(&bytes);
    assert_eq!(bench.triggers(), [1, 3]);
    assert_eq!(bench.discarded(), damaged.len() as u64);
    let tally = bench.driver.tally();
    assert_eq!((tally.damaged, tally.missing, tally.readings), (1, 1, 2));
    assert!(bench.reopens().is_none());
}

#[test]
fn a_stream_that_lost_its_place_is_opened_anew() {
    let mut bench = Bench::streaming(Settings::default());
    let mut bytes =
        [profile(1, Ok(5)), profile(2, Ok(5)), profile(3, Ok(5)), profile(4, Ok(5))].concat();
    bytes.drain(60..71);
    let len = bytes.len() as u64;
    bench.stream(&bytes);
    assert_eq!(bench.triggers(), [1]);
    let why = bench.reopens().unwrap();
    assert!(why.detail.contains("8 points that were announced"), "{}", why.detail);
    assert_eq!(bench.discarded(), len - profile(1, Ok(5)).len() as u64, "the rest, too");
    bench.stream(&profile(5, Ok(5)));
    assert_eq!(bench.triggers(), [1], "nothing more of this connection");
}

#[test]
fn nothing_from_before_a_reconnect_comes_after_it() {
    let mut bench = Bench::streaming(Settings::default());
    let one = profile(1, Ok(5));
    bench.stream(&profile(0, Ok(4)));
    bench.stream(&one[..40]);
    bench.commands(&[9, 0]);
    bench.driver.disconnected(bench.now);
    bench.drain();
    assert_eq!(bench.discarded(), 42);
    bench.driver.connected(bench.now);
    bench.asked.clear();
    bench.drain();
    bench.stream(&one[40..]);
    bench.answer_all();
    assert_eq!(bench.discarded(), 42 + one.len() as u64 - 40);
    bench.stream(&profile(9, Ok(6)));
    assert_eq!(bench.triggers(), [0, 9], "started again by itself");
    // Who counts on from before does not know whether the controller was restarted meanwhile.
    assert!(bench.faults().is_empty(), "{:?}", bench.faults());
}

#[test]
fn profiles_before_the_start_are_passed_over() {
    let mut bench = Bench::new(Settings::default());
    bench.stream(&[STOPPED.encode().to_vec(), profile(1, Ok(5))].concat());
    assert_eq!((bench.discarded(), bench.readings().len()), (48, 0));
    bench.command(Command::Start);
    bench.answer_all();
    bench.stream(&profile(2, Ok(5)));
    assert_eq!(bench.triggers(), [2]);
}

/// Two sockets have no order between them: profiles may be read before the answer to the start.
#[test]
fn profiles_may_come_before_the_answer_that_they_start() {
    let mut bench = Bench::new(Settings::default());
    bench.command(Command::Start);
    while bench.asked.last() != Some(&Request::Start { code: LAYOUT.start_code }) {
        let request = *bench.asked.last().unwrap();
        bench.answer(0, &content(request));
    }
    bench.stream(&profile(1, Ok(5)));
    bench.answer(0, &[]);
    bench.stream(&profile(2, Ok(5)));
    assert_eq!(bench.triggers(), [1, 2]);
}

#[test]
fn a_stream_that_the_controller_stops_is_started_again() {
    let mut bench = Bench::streaming(Settings::default());
    bench.stream(&profile(1, Ok(5)));
    bench.stream(&STOPPED.encode());
    bench.stream(&profile(2, Ok(5)));
    assert_eq!(bench.triggers(), [1], "the rest of a stream that stopped");
    assert!(bench.faults()[0].detail.contains("notice 0002h"), "{:?}", bench.faults());
    bench.wait_ms(249);
    assert!(bench.asked.is_empty());
    bench.wait_ms(1);
    bench.answer_all();
    assert_eq!(bench.asked, [Request::Prepare, Request::Start { code: LAYOUT.start_code }]);
    bench.stream(&profile(5, Ok(5)));
    assert_eq!(bench.triggers(), [1, 5]);
    assert_eq!((bench.driver.tally().stops, bench.driver.tally().missing), (1, 3));
}

#[test]
fn the_stop_that_was_asked_for_is_no_fault_however_late_its_notice() {
    let mut bench = Bench::streaming(Settings::default());
    bench.command(Command::Stop);
    bench.answer_all();
    bench.command(Command::Start);
    bench.answer_all();
    bench.stream(&[STOPPED.encode().to_vec(), profile(1, Ok(5))].concat());
    assert_eq!((bench.triggers(), bench.faults().len()), (vec![1], 0));
    bench.stream(&STOPPED.encode());
    assert_eq!(bench.faults().len(), 1, "the next one is");
}

#[test]
fn a_refusal_is_reported_and_asked_again() {
    let mut bench = Bench::new(Settings::default());
    bench.answer_all();
    bench.command(Command::Start);
    bench.answer(0x33, &[]);
    assert_eq!(bench.faults()[0].kind, FaultKind::Refused);
    assert!(bench.faults()[0].detail.contains("(47h) refused with error 33h"));
    bench.wait_ms(250);
    bench.answer(0, &LAYOUT.encode());
    bench.answer(0x33, &[]);
    assert!(bench.faults()[1].detail.contains("(A0h) refused"));
    bench.wait_ms(250);
    bench.answer_all();
    assert!(bench.events.contains(&Event::Ready));
}

#[test]
fn lost_triggers_and_new_counts_are_reported() {
    let mut bench = Bench::streaming(Settings::default());
    for trigger in [u32::MAX - 1, u32::MAX, 0, 4, 1] {
        bench.stream(&profile(trigger, Ok(5)));
    }
    let found: Vec<_> = bench.faults().iter().map(|fault| fault.detail.as_str()).collect();
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with("3 profiles are missing before trigger 4"), "{}", found[0]);
    assert!(found[1].starts_with("the controller counts triggers from 1 again"), "{}", found[1]);
    assert_eq!((bench.driver.tally().missing, bench.driver.tally().restarts), (3, 1));
}

#[test]
fn errors_of_the_controller_are_asked_for_and_told_once() {
    let mut bench = Bench::streaming(Settings::default());
    bench.wait_ms(1000);
    bench.answer(0, &ErrorCodes(vec![0x21]).encode());
    bench.wait_ms(1000);
    bench.answer(0, &ErrorCodes(vec![0x21, 0x22]).encode());
    assert_eq!(bench.asked, [Request::Errors, Request::Errors]);
    let told: Vec<_> = bench.faults().iter().map(|fault| fault.detail.clone()).collect();
    assert!(told[0].contains("error 0021h:") && told[1].contains("error 0022h:"), "{told:?}");
    bench.wait_ms(2000);
    assert!(bench.reopens().unwrap().detail.contains("errors (04h) within 1000 ms"));
}

#[test]
fn silence_ends_the_connection_where_it_must_not_be() {
    let settings = Settings { silence_ms: 300, watch_ms: Some(0), ..Settings::default() };
    let mut bench = Bench::streaming(settings);
    bench.wait_ms(200);
    bench.stream(&profile(1, Ok(5)));
    bench.wait_ms(299);
    assert!(bench.reopens().is_none());
    bench.wait_ms(1);
    assert!(bench.reopens().unwrap().detail.starts_with("no profile for 300 ms"));
    let mut patient = Bench::streaming(Settings { watch_ms: Some(0), ..Settings::default() });
    patient.wait_ms(3_600_000);
    assert!(patient.reopens().is_none());
}

#[test]
fn answers_that_nobody_asked_for_end_the_connection() {
    let mut bench = Bench::new(Settings::default());
    bench.commands(&Answer { command: 0x47, error: 0, content: &[] }.encode());
    let why = bench.reopens().unwrap();
    assert!(why.detail.contains("command 47h") && why.detail.contains("(48h)"), "{}", why.detail);
    assert!(!bench.events.contains(&Event::Online));
    let mut bench = Bench::new(Settings::default());
    bench.commands(b"HTTP/1.1 400 Bad Request\r\n");
    assert!(bench.reopens().unwrap().detail.contains("an answer of"));
}

#[test]
fn another_controller_is_refused() {
    let settings = Settings { serial: Some("1A230005".to_owned()), ..Settings::default() };
    let mut bench = Bench::new(settings);
    bench.answer_all();
    let detail = &bench.reopens().unwrap().detail;
    assert!(detail.contains("\"1A230004\", expected \"1A230005\""), "{detail}");
}
