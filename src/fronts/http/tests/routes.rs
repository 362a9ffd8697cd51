//! What each address answers.

use std::sync::Arc;

use asphera_report::contour::{CONTOUR_FORMAT, ContourReport, SessionContour};
use asphera_report::{
    CellKind, CellView, Cut, FORM_VIEW_FORMAT, FormView, GridView, HistogramFigures, Label,
    MAPS_FORMAT, Map, MapLayer, PathFigures, Refusal, RemovedTerm, ResultFile, SECTION_FORMAT,
    SamplingMaps, SectionReport, SectionRequest, SessionEntry, SessionFigures, SessionFile, Source,
    Status, VOLUME_VIEW_FORMAT, VolumeView, Waypoints,
};

use super::client::{Running, Station, TOKEN, report, within};
use crate::{Server, Token};

#[tokio::test]
async fn reads_answer_as_json() {
    let mut station = Station::new();
    station.report = Some(Arc::new(report()));
    let server = Running::start(&station).await;
    let snapshot = server.get("/api/v1/snapshot").await;
    assert_eq!(snapshot.status, 200);
    assert_eq!(snapshot.json()["format"], "asphera.snapshot/1");
    assert_eq!(snapshot.json()["state"], "measuring");
    let links = server.get("/api/v1/links").await.json();
    assert_eq!(links["sequence"], 1);
    assert_eq!(links["links"][0]["state"], "connected");
    assert!(links["links"][0]["age_s"].is_null());
    assert_eq!(server.get("/api/v1/report").await.json()["format"], "asphera.report/1");
    let health = server.get("/api/v1/health").await.json();
    assert_eq!(health["status"], "ok");
    assert_eq!(health["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(health["sequence"], 1);
    let mut next = super::client::snapshot(2, 0);
    next.elapsed_s = f64::NAN;
    station.publish(next);
    let next = server.get("/api/v1/snapshot").await.json();
    assert_eq!(next["sequence"], 2);
    assert!(next["elapsed_s"].is_null(), "a number that is none is null");
    server.end().await;
}

/// docs/api.md is the contract: it names every route, and every key of a report and a snapshot that a program may want.
#[test]
fn the_documentation_names_every_route_and_key() {
    let docs = include_str!("../../../../docs/api.md");
    let routes = include_str!("../api.rs").split(".route(\"/api/v1/").skip(1);
    let routes: Vec<_> = routes.filter_map(|rest| rest.split_once('"')).collect();
    assert!(routes.len() > 10, "{routes:?}");
    for (route, rest) in routes {
        let method = if rest.starts_with(", post") { "POST" } else { "GET" };
        assert!(docs.contains(&format!("| `{method} /api/v1/{route}` |")), "{method} {route}");
    }
    let keys = serde_json::to_value(report()).unwrap();
    for key in keys.as_object().unwrap().keys() {
        assert!(docs.contains(&format!("`{key}`")), "key {key} of a report");
    }
    for file in ResultFile::ALL {
        assert!(docs.contains(&format!("`{}`", file.name())), "{}", file.name());
    }
}

#[tokio::test]
async fn mesh_and_report_say_why_there_is_none() {
    let server = Running::start(&Station::new()).await;
    assert!(server.get("/api/v1/mesh.ply").await.problem(404).contains("no mesh yet"));
    assert!(server.get("/api/v1/report").await.problem(404).contains("no report yet"));
    let problem = server.get("/api/v1/waypoints.csv").await.problem(404);
    assert!(problem.contains("sampling"), "{problem}");
    server.end().await;
}

#[tokio::test]
async fn mesh_is_a_file_byte_for_byte() {
    let mut station = Station::new();
    let ply: Vec<u8> = (0..300_000_u32).map(|i| (i % 251) as u8).collect();
    station.mesh = Some(ply.clone());
    let server = Running::start(&station).await;
    let answer = server.get("/api/v1/mesh.ply").await;
    assert_eq!(answer.status, 200);
    assert_eq!(answer.header("content-disposition"), Some("attachment; filename=\"mesh.ply\""));
    assert_eq!(answer.body, ply);
    server.end().await;
}

#[tokio::test]
async fn sessions_are_listed_and_their_reports_open_under_a_policy_of_their_own() {
    let id = "session-20260504T030201Z-0badcafe";
    let session = SessionFigures {
        id: id.to_owned(),
        started: "2026-05-04T03:02:01.5Z".to_owned(),
        label: Label { serial: Some("0815".to_owned()), ..Label::default() },
        ..SessionFigures::default()
    };
    let mut station = Station::new();
    station.sessions = vec![SessionEntry {
        id: id.to_owned(),
        started: Some(session.started.clone()),
        label: session.label.clone(),
        ended: None,
        verdict: Some(Status::Undecided),
        points: None,
        pv_nm: None,
        rms_nm: None,
        files: vec!["report.json", "report.html"],
    }];
    let file = SessionFile { bytes: b"<html></html>".to_vec(), session: Some(session) };
    station.file = Some((id.to_owned(), ResultFile::Html, file));
    let server = Running::start(&station).await;
    let listed = server.get("/api/v1/sessions").await.json();
    assert_eq!(listed["sessions"][0]["id"], id);
    assert_eq!(listed["sessions"][0]["label"]["serial"], "0815");
    assert_eq!(listed["sessions"][0]["verdict"], "undecided");
    assert_eq!(listed["sessions"][0]["files"], serde_json::json!(["report.json", "report.html"]));

    let page = server.get(&format!("/api/v1/sessions/{id}/report.html")).await;
    assert_eq!((page.status, &page.body[..]), (200, &b"<html></html>"[..]));
    let policy = page.header("content-security-policy").unwrap();
    assert!(policy.contains("default-src 'none'") && policy.contains("style-src 'unsafe-inline'"));
    assert_eq!(page.header("x-content-type-options"), Some("nosniff"));
    assert_eq!(
        page.header("content-disposition"),
        Some("inline; filename=\"0815_20260504T030201_report.html\"")
    );
    for path in [
        "session-1/report.html",
        "../report.json",
        "%2e%2e/report.json",
        &*format!("{id}/session.json"),
    ] {
        server.get(&format!("/api/v1/sessions/{path}")).await.problem(404);
    }
    server.end().await;
}

#[tokio::test]
async fn waypoints_are_columns_of_text() {
    let mut station = Station::new();
    let csv = "region,x_mm,y_mm,z_mm\n1,0.5,-2.000000,0.1\n".to_owned();
    station.waypoints = Some(Waypoints { csv: csv.clone(), places: 1, regions: 1, left_out: 0 });
    let server = Running::start(&station).await;
    let answer = server.get("/api/v1/waypoints.csv").await;
    assert_eq!(answer.status, 200);
    assert_eq!(answer.header("content-type"), Some("text/csv; charset=utf-8"));
    assert_eq!(answer.body, csv.into_bytes());
    server.end().await;
}

#[tokio::test]
async fn unknown_addresses_and_methods_are_told() {
    let server = Running::start(&Station::new()).await;
    for path in ["/api", "/api/v2/snapshot", "/api/v1/nothing", "/nothing", "/assets/../main.js"] {
        let problem = server.get(path).await.problem(404);
        assert!(problem.contains("no such"), "{path}: {problem}");
    }
    for (method, path, allowed) in [
        ("POST", "/api/v1/snapshot", "GET, HEAD"),
        ("DELETE", "/api/v1/report", "GET, HEAD"),
        ("POST", "/", "GET, HEAD"),
        ("PUT", "/api/v1/session/start", "POST"),
        ("GET", "/api/v1/session/stop", "POST"),
        ("GET", "/api/v1/scan/stop", "POST"),
    ] {
        let headers = [("Host", &*server.host()), ("Authorization", &format!("Bearer {TOKEN}"))];
        let answer = server.ask(method, path, &headers).await;
        let problem = answer.problem(405);
        assert!(problem.contains(method), "{method} {path}: {problem}");
        assert_eq!(answer.header("allow"), Some(allowed), "{method} {path}");
    }
    let head = server.ask("HEAD", "/api/v1/snapshot", &[("Host", &server.host())]).await;
    assert_eq!((head.status, head.body.len()), (200, 0));
    server.end().await;
}

#[tokio::test]
async fn a_stream_without_upgrade_is_explained() {
    let server = Running::start(&Station::new()).await;
    let answer = server.get("/api/v1/stream").await;
    assert!((400..500).contains(&answer.status));
    assert!(answer.problem(answer.status).contains("WebSocket"));
    server.end().await;
}

#[tokio::test]
async fn every_answer_carries_the_security_headers() {
    let server = Running::start(&Station::new()).await;
    for (path, cache) in [
        ("/", "no-cache"),
        ("/assets/main.js", "no-cache"),
        ("/nothing", "no-cache"),
        ("/api/v1/snapshot", "no-store"),
        ("/api/v1/nothing", "no-store"),
        ("/api/v1/report", "no-store"),
    ] {
        let answer = server.get(path).await;
        let policy = answer.header("content-security-policy").unwrap();
        assert!(policy.starts_with("default-src 'self';"), "{path}");
        assert!(!policy.contains("unsafe"), "{path}");
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"), "{path}");
        assert_eq!(answer.header("referrer-policy"), Some("no-referrer"), "{path}");
        assert_eq!(answer.header("cache-control"), Some(cache), "{path}");
        assert_eq!(answer.header("access-control-allow-origin"), None, "{path}");
    }
    server.end().await;
}

#[tokio::test]
async fn a_taken_port_is_an_error_with_its_cause() {
    let server = Running::start(&Station::new()).await;
    let token = Token::parse(TOKEN).unwrap();
    let second = Server::bind(server.addr, token, Station::new()).await;
    let Err(error) = second else { panic!("two servers on one port") };
    assert_eq!(error.to_string(), format!("cannot listen on {}", server.addr));
    assert_eq!((error.addr, error.source.kind()), (server.addr, std::io::ErrorKind::AddrInUse));
    server.end().await;
}

#[tokio::test]
async fn urls_lead_to_the_page() {
    let token = Token::parse(TOKEN).unwrap();
    let any = "0.0.0.0:0".parse().unwrap();
    let server = within(Server::bind(any, token, Station::new())).await.unwrap();
    let port = server.local_addr().port();
    assert_ne!(port, 0);
    assert_eq!(server.url(), format!("http://127.0.0.1:{port}/"));
    assert_eq!(server.url_with_token(), format!("http://127.0.0.1:{port}/#token={TOKEN}"));
}

#[tokio::test]
async fn maps_come_once_for_each_content() {
    let mut station = Station::new();
    let server = Running::start(&station).await;
    assert!(server.get("/api/v1/maps").await.problem(404).contains("no maps"));
    server.end().await;
    let layer = MapLayer { limit: Some(0.1), values: vec![Some(0.25), None] };
    let maps = |version| SamplingMaps {
        format: MAPS_FORMAT,
        version,
        as_of_points: 2000,
        nx: 2,
        ny: 1,
        x0_mm: 0.0,
        y0_mm: 0.0,
        dx_mm: 1.0,
        dy_mm: 1.0,
        gap_mm: layer.clone(),
        epsilon: layer.clone(),
        tilt_mrad: layer.clone(),
        undersampled: layer.clone(),
        noise_sigma_nm: None,
        noise_unknown: Some("too few".to_owned()),
    };
    station.maps = Some(Arc::new(maps(1)));
    let server = Running::start(&station).await;
    let answer = server.get("/api/v1/maps").await;
    assert_eq!(answer.status, 200);
    assert_eq!(answer.json()["gap_mm"]["values"], serde_json::json!([0.25, null]));
    let tag = answer.header("etag").unwrap().to_owned();
    let host = server.host();
    let known = [("Host", host.as_str()), ("If-None-Match", tag.as_str())];
    let again = server.ask("GET", "/api/v1/maps", &known).await;
    assert_eq!((again.status, again.body.len()), (304, 0));
    server.end().await;
    station.maps = Some(Arc::new(maps(2)));
    let server = Running::start(&station).await;
    let host = server.host();
    let known = [("Host", host.as_str()), ("If-None-Match", tag.as_str())];
    assert_eq!(server.ask("GET", "/api/v1/maps", &known).await.status, 200);
    server.end().await;
}

#[tokio::test]
async fn parts_are_listed() {
    let mut station = Station::new();
    let server = Running::start(&station).await;
    let none = server.get("/api/v1/parts").await.problem(404);
    assert!(none.contains("no parts yet") && none.contains("[parts]"), "{none}");
    server.end().await;
    let parts = serde_json::json!({
        "as_of_points": 7, "axis": "y", "tau_mm": 0.5, "strip_mm": 1.0, "open": 0, "waiting": 0, "islands": 1,
        "island_points": 3, "crumbs": 0, "late": 0, "outside": 0, "earlier_events": 0,
        "events": [{"part": 0, "event": "ended", "at_mm": [0.0, 0.0, 0.0]}],
        "parts": [{
            "scanned": 0, "is_open": false, "points": 4, "box_mm": [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
            "centre_mm": [0.5, 0.5, 0.0], "loops": 0,
        }],
    });
    station.parts = Some(Arc::new(serde_json::from_value(parts.clone()).unwrap()));
    let server = Running::start(&station).await;
    let answer = server.get("/api/v1/parts").await;
    assert_eq!((answer.status, answer.json()), (200, parts));
    server.end().await;
}

#[tokio::test]
async fn a_volume_is_looked_at_slice_by_slice() {
    let mut station = Station::new();
    let server = Running::start(&station).await;
    for path in ["/api/v1/volume", "/api/v1/volume/slice?axis=z&index=0"] {
        let none = server.get(path).await.problem(404);
        assert!(none.contains("no volume") && none.contains("--listen"), "{none}");
    }
    server.end().await;
    station.volume = Some(Arc::new(VolumeView {
        format: VOLUME_VIEW_FORMAT,
        size: [5, 4, 3],
        origin_mm: [0.0; 3],
        steps_mm: [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
        smoothing_mm: 0.1,
        shown_range: [0.0, 255.0],
        threshold: 127.5,
        grid: GridView {
            contradicted: true,
            why: "too coarse".to_owned(),
            forbidden: 1,
            case8_unpaired: 0,
            c1: 0,
            c2: 0,
            near_missing: 3,
            cells: vec![CellView {
                kind: CellKind::Forbidden,
                at: [0.5; 3],
                at_mm: [0.05; 3],
                code: Some(0b0110_1001),
            }],
            left_out: 0,
        },
        faces: Vec::new(),
    }));
    let server = Running::start(&station).await;
    let view = server.get("/api/v1/volume").await.json();
    assert_eq!(view["format"], "asphera.volume-view/1");
    assert_eq!(view["grid"]["cells"][0]["kind"], "forbidden");
    let slice = server.get("/api/v1/volume/slice?axis=x&index=4").await.json();
    assert_eq!((&slice["axis"], &slice["index"]), (&"x".into(), &4.into()));
    // One byte, 128, as base64.
    assert_eq!(slice["pixels"], "gA==");
    let beyond = server.get("/api/v1/volume/slice?axis=x&index=5").await.problem(400);
    assert!(beyond.contains("no slice 5 across x"), "{beyond}");
    server.get("/api/v1/volume/slice?axis=x").await.problem(400);
    server.end().await;
}

#[tokio::test]
async fn a_contour_says_of_how_many_points_it_is() {
    let mut station = Station::new();
    let server = Running::start(&station).await;
    let none = server.get("/api/v1/contour").await.problem(404);
    assert!(none.contains("no contour yet") && none.contains("[contour]"), "{none}");
    server.end().await;
    let contour: ContourReport = serde_json::from_value(serde_json::json!({
        "format": CONTOUR_FORMAT,
        "input": {"points": 2, "distinct": 1},
        "method": "crust",
        "parameters": {},
        "guarantee": "none",
        "edges": [],
        "chains": [],
        "ends": [],
        "junctions": [],
        "left_out": [],
        "unknown": ["contour: too few points"],
    }))
    .unwrap();
    station.contour = Some(Arc::new(SessionContour { as_of_points: 7, in_xy: true, contour }));
    let server = Running::start(&station).await;
    let answer = server.get("/api/v1/contour").await;
    let found = answer.json();
    assert_eq!((answer.status, &found["as_of_points"]), (200, &serde_json::json!(7)));
    assert_eq!(found["contour"]["unknown"], serde_json::json!(["contour: too few points"]));
    assert!(found["contour"]["input"].get("spacing_median_mm").is_none());
    server.end().await;
}

#[tokio::test]
async fn the_form_comes_without_the_terms_that_are_named() {
    let mut station = Station::new();
    let server = Running::start(&station).await;
    assert!(server.get("/api/v1/form?remove=tilt").await.problem(404).contains("no deviation yet"));
    let unknown = server.get("/api/v1/form?remove=tilt,piton").await.problem(400);
    assert!(unknown.contains("piston, tilt, power") && unknown.contains("piton"), "{unknown}");
    server.end().await;
    station.view = Some(Err(Refusal("3 points; 5 or more are needed".to_owned())));
    let server = Running::start(&station).await;
    let few = server.get("/api/v1/form?remove=tilt").await.problem(409);
    assert!(few.contains('3') && few.contains('5'), "{few}");
    server.end().await;
    let map = Map {
        nx: 2,
        ny: 1,
        x0_mm: 0.0,
        y0_mm: 0.0,
        dx_mm: 1.0,
        dy_mm: 1.0,
        values_nm: vec![Some(1.5), None],
    };
    station.view = Some(Ok(FormView {
        format: FORM_VIEW_FORMAT,
        source: Source::Cells,
        as_of_points: 9,
        provisional: true,
        removed: Vec::new(),
        terms: vec![RemovedTerm { index: 2, value_nm: None }],
        pv_nm: 3.0,
        rms_nm: 1.0,
        map,
        histogram: HistogramFigures {
            low_nm: -1.0,
            width_nm: 0.5,
            counts: vec![9],
            pv_limit_nm: None,
            source: Source::Cells,
        },
    }));
    let server = Running::start(&station).await;
    let found = server.get("/api/v1/form?remove=tilt,power").await.json();
    assert_eq!(found["format"], "asphera.form-view/1");
    assert_eq!(found["removed"], serde_json::json!(["tilt", "power"]));
    assert_eq!(found["source"], "map of cells");
    assert_eq!(found["map"]["values_nm"], serde_json::json!([1.5, null]));
    assert!(found["terms"][0]["value_nm"].is_null());
    server.end().await;
}

/// Cuts along lines alone.
fn cut(request: &SectionRequest) -> Cut {
    let SectionRequest::Line { from_mm, to_mm } = *request else {
        return Some(Err(Refusal("no circle today".to_owned())));
    };
    Some(Ok(SectionReport {
        format: SECTION_FORMAT,
        path: PathFigures::Line { from_mm, to_mm },
        gap_limit_mm: None,
        length_mm: 0.0,
        pieces: Vec::new(),
        height: None,
        deviation: None,
        reasons: Vec::new(),
        points: None,
    }))
}

#[tokio::test]
async fn sections_are_cut_or_told_why_not() {
    let mut station = Station::new();
    let server = Running::start(&station).await;
    assert!(server.get("/api/v1/section?radius=0").await.problem(404).contains("no mesh yet"));
    server.end().await;
    station.cut = cut;
    let server = Running::start(&station).await;
    let found = server.get("/api/v1/section?line=0.5,0.5,5,0.5").await.json();
    assert_eq!(found["format"], "asphera.section/1");
    let path = serde_json::json!({"kind": "line", "from_mm": [0.5, 0.5], "to_mm": [5.0, 0.5]});
    assert_eq!(found["path"], path);
    for (query, what) in [
        ("", "one of line=X1,Y1,X2,Y2"),
        ("?line=1,2,3", "line=X1,Y1,X2,Y2"),
        ("?circle=0,0,-1", "no circle today"),
    ] {
        let problem = server.get(&format!("/api/v1/section{query}")).await.problem(400);
        assert!(problem.contains(what), "{query}: {problem}");
    }
    server.end().await;
}
