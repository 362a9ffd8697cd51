//! Start and stop: only with the token, and with the station's own answer.

use std::sync::atomic::Ordering;

use asphera_report::ControlError;

use super::client::{Running, Station, TOKEN};

const START: &str = "/api/v1/session/start";
const STOP: &str = "/api/v1/session/stop";

#[tokio::test]
async fn the_token_opens_both_controls() {
    let station = Station::new();
    let server = Running::start(&station).await;
    for (path, scheme) in [(START, "Bearer"), (STOP, "bearer")] {
        let token = format!("{scheme} {TOKEN}");
        let headers =
            [("Host", &*server.host()), ("Authorization", &token), ("Content-Length", "0")];
        assert_eq!(server.ask("POST", path, &headers).await.status, 204);
    }
    assert_eq!(station.started.load(Ordering::SeqCst), 1);
    assert_eq!(station.stopped.load(Ordering::SeqCst), 1);
    server.end().await;
}

/// This station drives no scan: whoever may asks gets its words, others get nothing.
#[tokio::test]
async fn a_scan_is_armed_and_stopped_with_the_token_alone() {
    let server = Running::start(&Station::new()).await;
    for path in ["/api/v1/scan/arm", "/api/v1/scan/stop"] {
        let host = server.host();
        let bare = [("Host", &*host), ("Content-Length", "0")];
        assert_eq!(server.ask("POST", path, &bare).await.status, 401);
        let token = format!("Bearer {TOKEN}");
        let headers = [("Host", &*host), ("Authorization", &token), ("Content-Length", "0")];
        let problem = server.ask("POST", path, &headers).await.problem(409);
        assert!(problem.contains("[scan.plan]"), "{problem}");
    }
    server.end().await;
}

#[tokio::test]
async fn a_start_may_name_the_part() {
    let station = Station::new();
    let server = Running::start(&station).await;
    let token = format!("Bearer {TOKEN}");
    let start = async |body: &str| {
        let length = body.len().to_string();
        let headers =
            [("Host", &*server.host()), ("Authorization", &token), ("Content-Length", &length)];
        server.send("POST", START, &headers, body).await
    };
    let said = r#"{"part": " lens 7 ", "serial": "0815", "operator": ""}"#;
    assert_eq!(start(said).await.status, 204);
    let label = station.label.lock().unwrap().clone();
    assert_eq!(label.title().as_deref(), Some("lens 7, no. 0815"));
    assert_eq!(label.operator, None);
    for (body, status) in [
        ("lens", 400),
        (r#"{"prat": "lens"}"#, 400),
        (&*format!(r#"{{"part": "{}"}}"#, "x".repeat(121)), 400),
    ] {
        let problem = start(body).await.problem(status);
        assert!(problem.contains("label") && problem.contains("part, serial"), "{problem}");
    }
    assert_eq!(start(&"x".repeat(5000)).await.status, 413);
    assert_eq!(station.started.load(Ordering::SeqCst), 1);
    server.end().await;
}

#[tokio::test]
async fn no_token_or_a_wrong_one_reaches_nothing() {
    let station = Station::new();
    let server = Running::start(&station).await;
    let host = server.host();
    let near = format!("Bearer {}X", &TOKEN[..TOKEN.len() - 1]);
    for path in [START, STOP] {
        let none = server.ask("POST", path, &[("Host", &host)]).await;
        none.problem(401);
        assert_eq!(none.header("www-authenticate"), Some("Bearer realm=\"asphera\""));
        let basic = format!("Basic {TOKEN}");
        server.ask("POST", path, &[("Host", &host), ("Authorization", &basic)]).await.problem(401);
        for wrong in ["Bearer ", "Bearer wrong", &*near] {
            let headers = [("Host", &*host), ("Authorization", wrong)];
            let answer = server.ask("POST", path, &headers).await;
            assert!(matches!(answer.status, 401 | 403), "{wrong}: {}", answer.status);
            let text = answer.problem(answer.status);
            assert!(!text.contains(TOKEN) && !text.contains(&near[7..]), "{text}");
        }
        let right = format!("Bearer {TOKEN}");
        let twice = [("Host", &*host), ("Authorization", &*near), ("Authorization", &*right)];
        server.ask("POST", path, &twice).await.problem(401);
        let in_query = format!("{path}?token={TOKEN}");
        server.ask("POST", &in_query, &[("Host", &host)]).await.problem(401);
    }
    assert_eq!(station.started.load(Ordering::SeqCst), 0);
    assert_eq!(station.stopped.load(Ordering::SeqCst), 0);
    server.end().await;
}

#[tokio::test]
async fn the_station_may_refuse_or_fail() {
    for (conflict, status) in [(true, 409), (false, 500)] {
        let mut station = Station::new();
        let message = "a session already runs".to_owned();
        station.answer = Err(ControlError { conflict, message });
        let server = Running::start(&station).await;
        let token = format!("Bearer {TOKEN}");
        let headers = [("Host", &*server.host()), ("Authorization", &token)];
        let problem = server.ask("POST", START, &headers).await.problem(status);
        assert!(problem.contains("a session already runs"));
        server.end().await;
    }
}
