//! Foreign hosts and foreign pages are refused everywhere.

use std::sync::atomic::Ordering;

use tokio_tungstenite::tungstenite::Error;

use super::client::{Running, Station, TOKEN};
use crate::Limits;

#[tokio::test]
async fn a_foreign_host_name_gets_nothing() {
    let server = Running::start(&Station::new()).await;
    let port = server.addr.port();
    for path in ["/", "/assets/main.js", "/api/v1/health", "/api/v1/snapshot", "/api/v1/stream"] {
        let evil = format!("evil.example:{port}");
        let problem = server.ask("GET", path, &[("Host", &evil)]).await.problem(403);
        assert!(problem.contains("evil.example"), "{path}: {problem}");
        server.ask("GET", path, &[]).await.problem(403);
        let twice = [("Host", "localhost"), ("Host", &*evil)];
        assert!(matches!(server.ask("GET", path, &twice).await.status, 400 | 403));
    }
    for host in ["localhost", "127.0.0.1", "[::1]"] {
        let host = format!("{host}:{port}");
        assert_eq!(server.ask("GET", "/api/v1/health", &[("Host", &host)]).await.status, 200);
    }
    let absolute = format!("http://evil.example:{port}/api/v1/health");
    server.ask("GET", &absolute, &[("Host", &server.host())]).await.problem(403);
    server.end().await;
}

#[tokio::test]
async fn an_allowed_name_is_served_and_matches_its_own_origin() {
    let names = vec!["bench.lab.example".to_owned()];
    let server = Running::with(&Station::new(), Limits::default(), names).await;
    let host = ("Host", "bench.lab.example");
    assert_eq!(server.ask("GET", "/", &[host]).await.status, 200);
    let own = ("Origin", "https://bench.lab.example");
    assert_eq!(server.ask("GET", "/api/v1/links", &[host, own]).await.status, 200);
    let foreign = ("Origin", "https://other.lab.example");
    server.ask("GET", "/api/v1/links", &[host, foreign]).await.problem(403);
    server.end().await;
}

#[tokio::test]
async fn a_foreign_page_reaches_neither_reads_nor_controls() {
    let station = Station::new();
    let server = Running::start(&station).await;
    let host = server.host();
    let token = format!("Bearer {TOKEN}");
    let own = format!("http://{host}");
    for origin in ["http://evil.example", "null", "http://127.0.0.1:1", "", "http://"] {
        let headers = [("Host", &*host), ("Origin", origin), ("Authorization", &token)];
        server.ask("GET", "/api/v1/snapshot", &headers).await.problem(403);
        server.ask("POST", "/api/v1/session/start", &headers).await.problem(403);
    }
    let two = [("Host", &*host), ("Origin", &*own), ("Origin", "http://evil.example")];
    server.ask("GET", "/api/v1/snapshot", &two).await.problem(403);
    assert_eq!(station.started.load(Ordering::SeqCst), 0);
    let headers = [("Host", &*host), ("Origin", &own), ("Authorization", &token)];
    assert_eq!(server.ask("POST", "/api/v1/session/start", &headers).await.status, 204);
    server.end().await;
}

#[tokio::test]
async fn a_foreign_page_opens_no_stream() {
    let server = Running::start(&Station::new()).await;
    for headers in [("Origin", "http://evil.example"), ("Host", "evil.example")] {
        match server.stream_with(&[headers]).await {
            Err(Error::Http(answer)) => assert_eq!(answer.status(), 403, "{headers:?}"),
            other => panic!("{headers:?}: {other:?}"),
        }
    }
    let own = format!("http://{}", server.host());
    server.stream_with(&[("Origin", &own)]).await.unwrap();
    server.end().await;
}
