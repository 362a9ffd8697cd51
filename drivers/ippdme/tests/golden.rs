//! Sessions of the NIST test suite, line for line: what its client sent and what its server answered.
//!
//! Source: NIST I++ DME test suite 3.0, `I++test_files/ClientServerLogs`, `errorResponses.res`. Tags of commands are ours where
//! a session is played; all else stands as it was logged.

use asphera_ippdme::wire::{Answer, Call, Data, Kind, ServerError, Severity, Tag};

fn answer(line: &str) -> Answer {
    Answer::parse(line.as_bytes()).unwrap_or_else(|| panic!("{line} is an answer"))
}

fn numbers(line: &str) -> Vec<f64> {
    match answer(line).kind {
        Kind::Data(Data::Numbers(numbers)) => numbers,
        other => panic!("{other:?}"),
    }
}

/// `StartSession_Client.log`, `AbortE_Client.log`: `&` acknowledges, `%` completes, `E` begins tags of events.
#[test]
fn acknowledged_and_complete() {
    assert_eq!(answer("00001 &"), Answer { tag: Tag::Number(1), kind: Kind::Acknowledged });
    assert_eq!(answer("09999 %"), Answer { tag: Tag::Number(9999), kind: Kind::Complete });
    assert_eq!(answer("E0090 &"), Answer { tag: Tag::Event(90), kind: Kind::Acknowledged });
}

/// `ScanOnLine_Client.log`: 11 points of four columns.
#[test]
fn a_scan_has_bare_numbers() {
    let line = "00010 # 0.00000,2.00385,2.00385,2.00385,0.00000,2.03464,2.03464,2.03464,0.00000,2.13856,2.13856,2.13856,\
                0.00000,2.38490,2.38490,2.38490,0.00000,2.86603,2.86603,2.86603,0.00000,2.98534,2.98534,2.98534,\
                0.00000,3.24352,3.24352,3.24352,0.00000,3.59319,3.59319,3.59319,0.00000,3.95164,3.95164,3.95164,\
                0.00000,4.22650,4.22650,4.22650,0.00000,4.00000,4.00000,4.00000";
    let numbers = numbers(line);
    assert_eq!(numbers.len(), 44);
    assert_eq!(numbers[36..], [0.0, 4.2265, 4.2265, 4.2265, 0.0, 4.0, 4.0, 4.0]);
}

/// `PtMeas_Client.log`: values with names, in an order of the server's own.
#[test]
fn a_point_has_values_with_names() {
    let line = "00130 # ER(3.00000), X(-25.73258), Y(1.18105), Z(3.15575), Tool.A(0.00000), Tool.B(0.00000), Tool.C(0.00000)";
    let Kind::Data(Data::Items(items)) = answer(line).kind else { panic!("values with names") };
    let names: Vec<&str> = items.iter().map(|item| item.name.as_str()).collect();
    assert_eq!(names, ["ER", "X", "Y", "Z", "Tool.A", "Tool.B", "Tool.C"]);
    assert_eq!(items[1].numbers(), Some(vec![-25.73258]));
    let line = "00080 # IJK(0.00000,0.00000,1.00000), X(3.06205), Y(-24.26795), Z(32.73005)";
    let Kind::Data(Data::Items(items)) = answer(line).kind else { panic!("values with names") };
    assert_eq!(items[0].numbers(), Some(vec![0.0, 0.0, 1.0]));
}

/// `allResOK.res`, `DCXPart_Client.log`: data of other commands.
#[test]
fn other_data_stand_as_they_are() {
    let other = |line| match answer(line).kind {
        Kind::Data(Data::Other(text)) => text,
        other => panic!("{other:?}"),
    };
    assert_eq!(other("00301 # \"Speed\", \"Number\""), "\"Speed\", \"Number\"");
    assert_eq!(other("00101 # (1.00000, 0.00000, 0.00000)"), "(1.00000, 0.00000, 0.00000)");
    let line = "E0000 # PtMeas ( X(1.33), Y(-2.6E01), Z(30.998), IJK(2,2,2))";
    assert_eq!(answer(line).tag, Tag::UNASKED);
    assert!(matches!(answer(line).kind, Kind::Data(Data::Items(_))));
    let line = "00801 # DMEVersion(\"1.4\")";
    assert!(matches!(answer(line).kind, Kind::Data(Data::Items(_))));
}

/// `Error_Client.log`, `AbortE_TestWhileMoving_Client.log`.
#[test]
fn errors_have_severity_and_number() {
    let line = "00010 ! Error(3, 1008, \"00010 GoTo(X(10000000)) : GoTo: TARGET POINT OUT OF WORK VOLUME\", \
                \"Target position out of machine volume\")";
    let Kind::Error(error) = answer(line).kind else { panic!("an error") };
    assert_eq!((error.severity, error.number), (Severity::Critical, 1008));
    assert_eq!(error.text, "Target position out of machine volume");
    let line = "00070 ! Error(2, 0006, \"00070 GoTo(X(20.00000), Y(40.00000), Z(60.00000))\", \
                \"Transaction aborted (Use ClearAllErrors to Continue)\")";
    let Kind::Error(error) = answer(line).kind else { panic!("an error") };
    assert!(error.is_abort() && !error.is_missed_point());
}

/// `errorResponses.res`: severity and number of predefined errors. Of severity 2 only a probe that touched nothing lets a program go on.
#[test]
fn predefined_errors() {
    let lines = [
        (0, 0, "Buffer full"),
        (2, 1, "Illegal tag"),
        (3, 7, "Illegal character"),
        (3, 500, "Emergency stop"),
        (9, 503, "Controller communications failure"),
        (1, 504, "Argument out of range"),
        (2, 1001, "Illegal touch"),
        (2, 1003, "No touch"),
        (2, 1006, "Surface not found"),
        (9, 2503, "Scale read head failure"),
        (3, 2504, "Collision"),
    ];
    for (severity, number, text) in lines {
        let line = format!("00010 ! Error({severity}, {number:04}, \"cause\", \"{text}\")");
        let Kind::Error(error) = answer(&line).kind else { panic!("an error") };
        let ServerError { text: read, .. } = &error;
        assert_eq!((error.severity.digit(), error.number, read.as_str()), (severity, number, text));
        assert_eq!(error.is_missed_point(), [1003, 1006].contains(&number), "{text}");
        assert_eq!(line[8..], error.to_string());
    }
}

/// `allCmdOK.prg`: every command of the suite is read, and what is read is written.
#[test]
fn commands_of_the_suite() {
    for text in [
        "StartSession()",
        "AlignPart(0, -1, 0, 0.6, 0, 0.8, 1)",
        "ChangeTool(\"Probe1\")",
        "EnumProp(Tool.GoToPar())",
        "Get(Z(), R(), Y(), Tool.C(), X())",
        "GetCsyTransformation(PartCsy)",
        "GoTo(X(10), Y(11), Z(12))",
        "OnMoveReportE(Time(1), Dis(10), X(), Y(), Z())",
        "StopDaemon(E0490)",
        "OnScanReport(X(), Y(), Tool.A(), R(), Tool.B(), Z(), Tool.C())",
        "PtMeas(X(1), Y(2), Z(3), IJK(2, 2, 2))",
        "ScanOnCircle(0, 0, 0, 4, 5, 6, 6, 0, -4, 10, 1, 2)",
        "ScanOnLine(0, 1, 2, 14, 15, 2, 0, 0, 1, 0.5)",
        "SetProp(Tool.GoToPar.Speed(400), Tool.PtMeasPar.Speed.Act(400))",
    ] {
        assert_eq!(Call::parse(text).unwrap().to_string(), text);
    }
}

#[test]
fn lines_that_are_no_answers() {
    for line in [
        "",
        "00001",
        "00001&",
        "00001  &",
        "0001 &",
        "00001 ?",
        "00001 & x",
        "00001 #",
        "00000 &",
        "00001 ! Error(3, 1008)",
        "00001 ! Fault(3, 1008, \"a\", \"b\")",
        "00001 ! Error(10, 1008, \"a\", \"b\")",
        "00001 ! Error(3, 10080, \"a\", \"b\")",
        "00001 ! Error(-1, 1008, \"a\", \"b\")",
        "00001 ! Error(1.5, 1008, \"a\", \"b\")",
    ] {
        assert_eq!(Answer::parse(line.as_bytes()), None, "{line}");
    }
}
