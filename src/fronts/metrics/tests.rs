//! A snapshot as a monitor reads it.

use asphera_report::{
    Backlog, Check, Connection, Convergence, FigureName, LinkState, MeshFigures, Points, Progress,
    SNAPSHOT_FORMAT, SamplingFigures, Snapshot, State, Status, Verdict,
};

use super::text;

fn snapshot() -> Snapshot {
    let link = LinkState {
        name: "probe".to_owned(),
        kind: "tcp".to_owned(),
        address: "127.0.0.1:7891".to_owned(),
        devices: vec!["probe".to_owned()],
        state: Connection::Stale,
        rate_hz: 2000.0,
        readings: 10,
        received_bytes: 120,
        errors: 1,
        lost: 2,
        reconnects: 3,
        age_s: None,
        last_error: None,
    };
    Snapshot {
        format: SNAPSHOT_FORMAT,
        sequence: 7,
        station: "bench \"A\"".to_owned(),
        state: State::Measuring,
        elapsed_s: 1.5,
        session: None,
        progress: Progress {
            backlog: Some(Backlog { waiting_points: 1_600_000, behind_s: 3.25 }),
            ..Progress::default()
        },
        points: Points {
            received: 12,
            missing: 3,
            flagged: [("outlier".to_owned(), 4)].into(),
            ..Points::default()
        },
        mesh: MeshFigures::default(),
        sampling: SamplingFigures { gap_max_mm: Some(0.25), ..SamplingFigures::default() },
        features: Default::default(),
        form: None,
        verdict: Verdict::default(),
        map: None,
        maps: None,
        contour: None,
        parts: None,
        volume: None,
        scan: None,
        convergence: Convergence::default(),
        outputs: None,
        links: vec![LinkState { name: "axis".to_owned(), ..link.clone() }, link],
    }
}

fn has(text: &str, line: &str) {
    assert!(text.lines().any(|found| found == line), "no {line} in\n{text}");
}

#[test]
fn every_figure_has_its_unit_and_its_labels() {
    let mut snapshot = snapshot();
    snapshot.links[1].state = Connection::Connected;
    snapshot.links[1].age_s = Some(0.25);
    let text = text(&snapshot);
    for line in [
        "# TYPE asphera_station_state gauge",
        "asphera_station_state{station=\"bench \\\"A\\\"\",state=\"measuring\"} 1.0",
        "asphera_station_state{station=\"bench \\\"A\\\"\",state=\"idle\"} 0.0",
        "asphera_session_points 12.0",
        "asphera_session_points_missing 3.0",
        "asphera_session_behind_seconds 3.25",
        "asphera_session_points_flagged{reason=\"outlier\"} 4.0",
        "asphera_sampling_gap_meters 0.00025",
        "asphera_verdict{status=\"undecided\"} 1.0",
        "asphera_link_up{link=\"axis\",kind=\"tcp\"} 0.0",
        "asphera_link_up{link=\"probe\",kind=\"tcp\"} 1.0",
        "# TYPE asphera_link_readings_total counter",
        "asphera_link_readings_total{link=\"axis\"} 10.0",
        "asphera_link_reading_age_seconds{link=\"probe\"} 0.25",
    ] {
        has(&text, line);
    }
}

#[test]
fn unknown_figures_have_no_line() {
    let text = text(&snapshot());
    for name in ["pv", "coverage", "noise", "epsilon", "check", "age"] {
        assert!(!text.contains(name), "{name} in\n{text}");
    }
}

#[test]
fn limits_keep_their_unit() {
    let mut snapshot = snapshot();
    let figure =
        FigureName { name: "pv_nm".to_owned(), unit: "nm".to_owned(), ..FigureName::default() };
    snapshot.verdict.status = Status::Fail;
    snapshot.verdict.checks = vec![Check {
        figure,
        limit: 100.0,
        value: 123.5,
        ok: false,
        u: None,
        u_covers: None,
        interval_95: None,
        guard_band: None,
        rule: None,
        hidden: None,
        doubt: None,
    }];
    let text = text(&snapshot);
    has(&text, "asphera_check_value{limit=\"pv_nm\",unit=\"nm\"} 123.5");
    has(&text, "asphera_check_limit{limit=\"pv_nm\",unit=\"nm\"} 100.0");
    has(&text, "asphera_check_ok{limit=\"pv_nm\",unit=\"nm\"} 0.0");
    has(&text, "asphera_verdict{status=\"fail\"} 1.0");
}

/// Every sample has its family's help and kind before it, and no family comes twice.
#[test]
fn families_are_whole() {
    let text = text(&snapshot());
    let mut family = "";
    let mut seen = std::collections::BTreeSet::new();
    for line in text.lines() {
        if let Some(head) = line.strip_prefix("# HELP ") {
            family = head.split(' ').next().unwrap();
            assert!(seen.insert(family), "{family} twice");
        } else if let Some(kind) = line.strip_prefix("# TYPE ") {
            assert_eq!(kind.split(' ').next(), Some(family));
            assert_eq!(kind.ends_with("counter"), family.ends_with("_total"), "{kind}");
        } else {
            assert!(line.starts_with(family), "{line}");
        }
    }
}
