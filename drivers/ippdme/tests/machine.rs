//! The driver in virtual time, with answers of logged sessions, and faults.

use asphera_ippdme::FAMILY;
use asphera_link::{
    Command, Driver, Event, Fault, FaultKind, Flags, Input, Motion, MotionEvent, MotionTrouble,
    Nanos, Output, Reading,
};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// A machine on a table: virtual time, no link.
struct Bench {
    driver: Box<dyn Driver>,
    now: Nanos,
    sent: Vec<String>,
    events: Vec<Event>,
}

impl Bench {
    fn new(settings: &str) -> Bench {
        let settings = FAMILY.parse("cmm", settings).expect("settings of a test are sound");
        let driver = settings.driver().expect("settings of a test are sound");
        let mut bench = Bench { driver, now: Nanos::ZERO, sent: Vec::new(), events: Vec::new() };
        bench.driver.connected(bench.now);
        bench.drain();
        bench
    }

    /// A machine whose session is set up.
    fn ready(settings: &str) -> Bench {
        let mut bench = Bench::new(settings);
        (0..4).for_each(|_| bench.complete());
        bench
    }

    /// A machine that runs its program, its errors cleared.
    fn running(settings: &str) -> Bench {
        let mut bench = Bench::ready(settings);
        bench.run();
        bench.complete();
        bench
    }

    fn run(&mut self) {
        self.driver.motion(self.now, &Motion::Run).expect("the machine is ready");
        self.drain();
    }

    fn halt(&mut self) {
        self.driver.motion(self.now, &Motion::Halt).expect("a halt");
        self.drain();
    }

    /// Tag of the newest command.
    fn tag(&self) -> String {
        self.sent.last().expect("a command was sent")[..5].to_owned()
    }

    /// Acknowledges the newest command and completes it.
    fn complete(&mut self) {
        let tag = self.tag();
        self.receive(format!("{tag} &\r\n{tag} %\r\n"));
    }

    /// Answers the newest command.
    fn answer(&mut self, answers: &[&str]) {
        let tag = self.tag();
        for answer in answers {
            self.receive(format!("{tag} {answer}\r\n"));
        }
    }

    fn receive(&mut self, bytes: impl AsRef<[u8]>) {
        self.driver.receive(self.now, Input::Bytes(bytes.as_ref()));
        self.drain();
    }

    fn next_timeout(&mut self) {
        self.now = self.driver.poll_timeout().expect("the driver waits for something");
        self.driver.timeout(self.now);
        self.drain();
    }

    fn drain(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            self.sent.push(String::from_utf8(bytes).expect("the protocol is ASCII"));
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    fn readings(&self) -> Vec<&Reading> {
        let reading = |event: &'_ Event| matches!(event, Event::Reading(_));
        let all = self.events.iter().filter(|event| reading(event));
        all.map(|event| match event {
            Event::Reading(reading) => reading,
            _ => unreachable!("only readings are left"),
        })
        .collect()
    }

    fn values(&self) -> Vec<Vec<Option<f64>>> {
        self.readings().iter().map(|reading| reading.values.iter().collect()).collect()
    }

    fn faults(&self) -> Vec<(FaultKind, String)> {
        let fault = |event: &Event| match event {
            Event::Fault(Fault { kind, detail }) => Some((*kind, detail.clone())),
            _ => None,
        };
        self.events.iter().filter_map(fault).collect()
    }

    fn reopened(&self) -> Vec<String> {
        let reopened = |event: &Event| match event {
            Event::Reopen(fault) => Some(fault.detail.clone()),
            _ => None,
        };
        self.events.iter().filter_map(reopened).collect()
    }

    fn motions(&self) -> Vec<&MotionEvent> {
        let motion = |event: &'_ Event| matches!(event, Event::Motion(_));
        let all = self.events.iter().filter(|event| motion(event));
        all.map(|event| match event {
            Event::Motion(motion) => motion,
            _ => unreachable!("only moves are left"),
        })
        .collect()
    }

    fn failure(&self) -> (MotionTrouble, &str) {
        match self.motions()[..] {
            [.., MotionEvent::Failed(failure)] => (failure.kind, &failure.detail),
            ref others => panic!("{others:?}"),
        }
    }

    fn discarded(&self) -> u64 {
        let bytes = |event: &Event| match event {
            Event::Discarded { bytes } => *bytes,
            _ => 0,
        };
        self.events.iter().map(bytes).sum()
    }
}

const POINT: &str = "commands = ['PtMeas(X(1.33), Y(-2.6E01), Z(30.998), IJK(2,2,2))']";
const LINE: &str = "commands = ['ScanOnLine(2,2,2,4,4,4,1,1,1,.1)']\nquality_limit = 50";
const PROGRAM: &str = "commands = ['Home()', 'ChangeTool(\"Probe1\")', 'PtMeas(X(1), Y(2), Z(3))', 'PtMeas(X(2), Y(2), Z(3))', \
                       'Get(X(), Y(), Z())']";

#[test]
fn nothing_moves_before_the_order() {
    let mut bench = Bench::new(PROGRAM);
    assert_eq!(bench.sent, ["00001 StartSession()\r\n"], "each waits for the one before");
    bench.receive("00001 &\r\n");
    assert_eq!(bench.events, [Event::Online]);
    bench.receive("00001 %\r\n");
    bench.driver.command(bench.now, Command::Start);
    bench.complete();
    assert_eq!(bench.events, [Event::Online], "not ready yet");
    bench.complete();
    bench.complete();
    assert_eq!(
        bench.sent,
        [
            "00001 StartSession()\r\n",
            "00002 ClearAllErrors()\r\n",
            "00003 OnPtMeasReport(X(), Y(), Z())\r\n",
            "00004 OnScanReport(X(), Y(), Z())\r\n",
        ]
    );
    assert_eq!(bench.events, [Event::Online, Event::Ready]);
    assert_eq!(bench.driver.poll_timeout(), None, "it waits for the order, however long");
}

/// `PtMeas_Client.log`, and `Home`, `ChangeTool` before it.
#[test]
fn a_program_runs_command_by_command() {
    let mut bench = Bench::ready(PROGRAM);
    bench.run();
    assert_eq!(bench.tag(), "00005");
    bench.complete();
    bench.answer(&["&"]);
    assert!(bench.sent.last().unwrap().ends_with(" Home()\r\n"), "nothing before it is complete");
    bench.answer(&["%"]);
    bench.complete();
    bench.answer(&[
        "&",
        "# IJK(0.00000,0.00000,1.00000), X(3.06205), Y(-24.26795), Z(32.73005)",
        "%",
    ]);
    bench.answer(&["&", "# X(1.33000), Y(-26.00000), Z(33.99800)", "%"]);
    assert_eq!(bench.motions(), [] as [&MotionEvent; 0]);
    bench.answer(&["&", "# X(0.00000), Y(0.00000), Z(0.00000)", "%"]);
    assert_eq!(bench.motions(), [&MotionEvent::Arrived]);
    let place = |x, y, z| vec![Some(x), Some(y), Some(z)];
    let expected = [place(3.06205, -24.26795, 32.73005), place(1.33, -26.0, 33.998)];
    assert_eq!(bench.values(), expected, "a position that was asked for is no point");
    let sent: Vec<&str> = bench.sent[4..].iter().map(|line| line[6..].trim_end()).collect();
    assert_eq!(
        sent,
        [
            "ClearAllErrors()",
            "Home()",
            "ChangeTool(\"Probe1\")",
            "PtMeas(X(1), Y(2), Z(3))",
            "PtMeas(X(2), Y(2), Z(3))",
            "Get(X(), Y(), Z())"
        ]
    );
    assert_eq!((bench.faults().len(), bench.discarded()), (0, 0));
    bench.driver.command(bench.now, Command::Stop);
    bench.drain();
    assert!(bench.sent.last().unwrap().ends_with(" EndSession()\r\n"));
}

/// `ScanOnLine_Client.log` with its four columns: here Q stands first.
#[test]
fn a_scan_gives_many_points_a_line() {
    let mut bench = Bench::running(LINE);
    assert_eq!(bench.sent[3], "00004 OnScanReport(Q(), X(), Y(), Z())\r\n");
    bench.answer(&[
        "&",
        "# 0.00000,2.00385,2.00385,2.00385,0.00000,2.03464,2.03464,2.03464,0.00000,2.13856,2.13856,2.13856",
        "# 50,3.95164,3.95164,3.95164,51,4.22650,4.22650,4.22650,101,4.00000,4.00000,4.00000,-1,4,4,4",
        "%",
    ]);
    assert_eq!(bench.values()[1], [Some(2.03464), Some(2.03464), Some(2.03464), Some(0.0)]);
    let flags: Vec<Flags> = bench.readings().iter().map(|reading| reading.flags).collect();
    let fine = Flags::empty();
    assert_eq!(flags, [fine, fine, fine, fine, Flags::WEAK, Flags::SUSPECT, Flags::SUSPECT]);
    assert_eq!(bench.motions(), [&MotionEvent::Arrived]);
}

#[test]
fn a_line_with_a_number_too_many_is_refused_as_a_whole() {
    let mut bench = Bench::running(LINE);
    bench.answer(&["&", "# 0,1,1,1,0,2,2", "# X(1), Y(2), Z(3)", "# 0,3,3,3", "%"]);
    assert_eq!(bench.values(), [[Some(3.0), Some(3.0), Some(3.0), Some(0.0)]]);
    let details: Vec<String> = bench.faults().into_iter().map(|(_, detail)| detail).collect();
    assert!(details[0].starts_with("7 numbers in a line of ScanOnLine, expected a multiple of 4"));
    assert!(details[1].contains("no bare numbers"));
    assert_eq!(bench.discarded(), 23 + 26);
    assert!(bench.reopened().is_empty(), "the scan goes on");
}

#[test]
fn a_point_without_a_coordinate_is_a_gap() {
    let mut bench = Bench::running(POINT);
    bench.answer(&[
        "&",
        "# X(1), Z(3)",
        "# X(1), X(2), Y(2), Z(3)",
        "# X(1,2), Y(2), Z(3)",
        "# 1,2,3",
        "%",
    ]);
    assert_eq!(bench.values(), [[Some(1.0), None, Some(3.0)]]);
    assert_eq!(bench.faults().len(), 3, "{:?}", bench.faults());
}

/// `errorResponses.res`: a probe that touched nothing is no reason to stop; errors are cleared, and the next point is measured.
#[test]
fn a_missed_point_is_passed_over() {
    let mut bench =
        Bench::running("commands = ['PtMeas(X(1), Y(2), Z(3))', 'PtMeas(X(2), Y(2), Z(3))']");
    bench.answer(&["&", "! Error(2, 1006, \"PtMeas\", \"Surface not found\")", "%"]);
    assert!(bench.sent.last().unwrap().ends_with(" ClearAllErrors()\r\n"));
    bench.complete();
    bench.answer(&["&", "# X(2), Y(2), Z(3)", "%"]);
    assert_eq!((bench.readings().len(), bench.motions()), (1, vec![&MotionEvent::Arrived]));
    let [(FaultKind::Device, detail)] = &bench.faults()[..] else { panic!("one fault") };
    assert_eq!(
        detail,
        "the machine reports error 1006 of severity 2 to `PtMeas(X(1), Y(2), Z(3))`, Surface not found: \
         check that the part is in its place, and the search long enough"
    );
}

#[test]
fn a_warning_changes_nothing() {
    let mut bench = Bench::running(
        "commands = ['SetProp(Tool.GoToPar.Speed(9000))', 'PtMeas(X(2), Y(2), Z(3))']",
    );
    bench.answer(&["&", "! Error(1, 0504, \"SetProp\", \"Argument out of range\")", "%"]);
    bench.answer(&["&", "# X(2), Y(2), Z(3)", "%"]);
    assert_eq!(bench.motions(), [&MotionEvent::Arrived]);
    assert_eq!(bench.faults().len(), 1);
}

/// `Error_Client.log`: severity 3 ends the program.
#[test]
fn a_critical_error_ends_the_program() {
    let mut bench = Bench::running("commands = ['GoTo(X(10000000))', 'PtMeas(X(2), Y(2), Z(3))']");
    bench.answer(&[
        "&",
        "! Error(3, 1008, \"00010 GoTo(X(10000000)) : GoTo: TARGET POINT OUT OF WORK VOLUME\", \"Target position out of machine volume\")",
        "%",
    ]);
    let (kind, detail) = bench.failure();
    assert_eq!(kind, MotionTrouble::Limit);
    assert!(detail.ends_with("keep the program within the machine's volume"), "{detail}");
    assert!(bench.sent.last().unwrap().contains("GoTo"), "nothing follows");
}

/// A server that leaves out `%` after an error is not waited for longer than for an acknowledgement.
#[test]
fn an_error_without_its_end_is_enough() {
    let mut bench = Bench::running("commands = ['PtMeas(X(2), Y(2), Z(3))']");
    bench.answer(&["! Error(3, 0501, \"PtMeas\", \"Unsupported command\")"]);
    let tag = bench.tag();
    assert!(bench.motions().is_empty());
    bench.next_timeout();
    assert_eq!(bench.failure().0, MotionTrouble::Refused);
    bench.receive(format!("{tag} %\r\n"));
    assert!(bench.reopened().is_empty(), "its end may still come");
}

/// `AbortE_TestWhileMoving_Client.log`.
#[test]
fn a_halt_goes_first_and_is_answered_last() {
    let mut bench =
        Bench::running("commands = ['GoTo(X(20), Y(40), Z(60))', 'PtMeas(X(2), Y(2), Z(3))']");
    bench.answer(&["&"]);
    let tag = bench.tag();
    bench.halt();
    assert_eq!(bench.sent.last().unwrap(), "E0001 AbortE()\r\n");
    bench.receive(format!(
        "E0001 &\r\n{tag} ! Error(2, 0006, \"{tag} GoTo(X(20.00000), Y(40.00000), Z(60.00000))\", \
         \"Transaction aborted (Use ClearAllErrors to Continue)\")\r\n{tag} %\r\nE0001 %\r\n"
    ));
    assert_eq!(bench.motions(), [&MotionEvent::Halted]);
    assert!(bench.faults().is_empty(), "a halt of ours is no fault");
    assert!(bench.sent.last().unwrap().contains("AbortE"), "the program does not go on");
    bench.driver.command(bench.now, Command::Stop);
    bench.drain();
    bench.complete();
    let end: Vec<&str> = bench.sent[7..].iter().map(|line| line[6..].trim_end()).collect();
    assert_eq!(end, ["ClearAllErrors()", "EndSession()"]);
}

#[test]
fn a_program_begins_anew() {
    let mut bench = Bench::running(POINT);
    bench.answer(&["&"]);
    bench.halt();
    let refused = bench.driver.motion(bench.now, &Motion::Run).unwrap_err();
    assert_eq!(refused.kind, MotionTrouble::Refused);
    bench.receive("E0001 &\r\nE0001 %\r\n");
    bench.run();
    bench.complete();
    bench.answer(&["&", "# X(1), Y(2), Z(3)", "%"]);
    assert_eq!(bench.motions(), [&MotionEvent::Halted, &MotionEvent::Arrived]);
}

#[test]
fn a_halt_without_an_answer_is_sent_five_times() {
    let mut bench = Bench::running(POINT);
    bench.halt();
    (0..5).for_each(|_| bench.next_timeout());
    let halts = bench.sent.iter().filter(|line| line.ends_with("AbortE()\r\n")).count();
    assert_eq!(halts, 5);
    let (kind, detail) = bench.failure();
    assert_eq!(kind, MotionTrouble::Unanswered);
    assert!(detail.ends_with("press the emergency stop"), "{detail}");
}

#[test]
fn a_silent_machine_is_halted() {
    let mut bench = Bench::running(POINT);
    bench.next_timeout();
    assert_eq!(bench.now, Nanos::from_nanos(5_000_000_000), "before the acknowledgement");
    assert_eq!(bench.sent.last().unwrap(), "E0001 AbortE()\r\n");
    bench.receive("E0001 &\r\nE0001 %\r\n");
    assert_eq!(bench.failure().0, MotionTrouble::Unanswered);
    let mut bench = Bench::running(POINT);
    bench.answer(&["&"]);
    bench.next_timeout();
    assert_eq!(bench.now, Nanos::from_nanos(300_000_000_000), "at work");
}

/// The emergency stop of a machine that nobody asked.
#[test]
fn an_error_that_nobody_asked_for_ends_the_program() {
    let mut bench = Bench::running(POINT);
    bench.answer(&["&"]);
    bench.receive("E0000 # KeyPress(\"F1\")\r\n");
    assert!(bench.motions().is_empty() && bench.faults().is_empty());
    bench.receive("E0000 ! Error(3, 0500, \"\", \"Emergency stop\")\r\n");
    assert_eq!(bench.failure().0, MotionTrouble::Interrupted);
}

#[test]
fn what_is_no_answer_of_ours_ends_the_connection() {
    for (bytes, lost) in [
        (&b"00077 &\r\n"[..], 9),
        (b"E0001 # X(1)\r\n", 14),
        (b"E0001 &\r\n", 9),
        (b"00006 # 1,2,3\t", 14),
        (b"00006 # 1,2,3\n", 14),
        (b"hello\r\n", 7),
        (b"00001 %\r\n", 9),
    ] {
        let mut bench = Bench::running(POINT);
        bench.receive([bytes, b"00006 &\r\n"].concat());
        let text = String::from_utf8_lossy(bytes);
        assert_eq!((bench.reopened().len(), bench.discarded()), (1, lost + 9), "{text}");
        bench.receive("00006 # X(1), Y(2), Z(3)\r\n");
        assert!(bench.readings().is_empty(), "nothing of it is used any more");
        bench.driver.disconnected(bench.now);
        bench.driver.connected(bench.now);
        bench.drain();
        assert!(bench.sent.last().unwrap().ends_with(" StartSession()\r\n"));
        (0..4).for_each(|_| bench.complete());
        assert_eq!(bench.events.last(), Some(&Event::Ready));
    }
    let mut bench = Bench::running(POINT);
    bench.receive(vec![b'1'; 65_540]);
    assert_eq!((bench.reopened().len(), bench.discarded()), (1, 65_540));
}

#[test]
fn the_halt_past_the_state_machine_has_a_tag_of_its_own() {
    let mut bench = Bench::running(POINT);
    assert_eq!(bench.driver.halt_bytes().as_deref(), Some(&b"E9999 AbortE()\r\n"[..]));
    bench.receive("E9999 &\r\nE9999 %\r\n");
    assert!(bench.reopened().is_empty());
}

#[test]
fn a_machine_that_refuses_the_columns_is_left() {
    let mut bench = Bench::new(LINE);
    (0..3).for_each(|_| bench.complete());
    bench.answer(&["&", "! Error(3, 0510, \"OnScanReport\", \"Bad property\")", "%"]);
    assert!(bench.reopened()[0].contains("error 0510"), "{:?}", bench.reopened());
    assert!(!bench.events.contains(&Event::Ready));
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_chunking_gives_the_same_events(cuts in prop::collection::vec(1usize..40, 1..40)) {
        let bytes = b"00006 &\r\n00006 # 0,1,2,3,60,4,5,6\r\n00006 # 7\r\n00006 # 0,-1.5,2E1,.5\r\n00006 %\r\n";
        let mut whole = Bench::running(LINE);
        whole.receive(bytes);
        let mut cut = Bench::running(LINE);
        let mut rest = &bytes[..];
        for size in cuts.iter().cycle() {
            if rest.is_empty() {
                break;
            }
            let (now, later) = rest.split_at((*size).min(rest.len()));
            cut.receive(now);
            rest = later;
        }
        prop_assert_eq!(whole.events, cut.events);
    }

    #[test]
    fn random_bytes_give_no_reading(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut bench = Bench::running(POINT);
        bench.receive(&bytes);
        bench.driver.disconnected(bench.now);
        bench.drain();
        prop_assert!(bench.readings().is_empty());
        prop_assert!(bench.discarded() <= bytes.len() as u64);
    }
}
