//! Clients that are slow, silent or many.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout};

use super::client::{Running, Station, within};
use crate::Limits;

/// Until the other side has closed; how many bytes came.
async fn rest(socket: &mut TcpStream) -> usize {
    let mut bytes = Vec::new();
    // A reset is an end, too.
    let _ = within(socket.read_to_end(&mut bytes)).await;
    bytes.len()
}

#[tokio::test]
async fn a_client_that_says_nothing_or_half_a_head_is_cut_off() {
    let limits = Limits { head_ms: 200, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    for said in ["", "GET /api/v1/hea", "GET /api/v1/health HTTP/1.1\r\nHost: x"] {
        let begun = Instant::now();
        let mut socket = TcpStream::connect(server.addr).await.unwrap();
        socket.write_all(said.as_bytes()).await.unwrap();
        rest(&mut socket).await;
        assert!(begun.elapsed() >= Duration::from_millis(150), "{said:?}");
    }
    // Between two requests of one connection as well.
    let mut socket = TcpStream::connect(server.addr).await.unwrap();
    let request = format!("GET /api/v1/health HTTP/1.1\r\nHost: {}\r\n\r\n", server.host());
    socket.write_all(request.as_bytes()).await.unwrap();
    assert!(rest(&mut socket).await > 100);
    server.end().await;
}

#[tokio::test]
async fn an_answer_that_nobody_takes_is_given_up() {
    const LENGTH: usize = 64 << 20;
    let limits = Limits { answer_ms: 300, ..Limits::default() };
    let station = Station { mesh: Some(vec![7; LENGTH]), ..Station::new() };
    let server = Running::with(&station, limits, Vec::new()).await;
    let mut socket = TcpStream::connect(server.addr).await.unwrap();
    let request = format!("GET /api/v1/mesh.ply HTTP/1.1\r\nHost: {}\r\n\r\n", server.host());
    socket.write_all(request.as_bytes()).await.unwrap();
    tokio::time::sleep(Duration::from_millis(1500)).await;
    let taken = rest(&mut socket).await;
    assert!(taken < LENGTH, "{taken} bytes came although nobody read for longer than allowed");
    // One that reads gets it whole.
    assert_eq!(server.get("/api/v1/mesh.ply").await.body.len(), LENGTH);
    server.end().await;
}

#[tokio::test]
async fn one_connection_too_many_is_closed_and_another_comes_in_afterwards() {
    let limits = Limits { connections: 3, head_ms: 1500, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    let mut silent = Vec::new();
    for _ in 0..3 {
        silent.push(TcpStream::connect(server.addr).await.unwrap());
    }
    let mut turned_away = TcpStream::connect(server.addr).await.unwrap();
    let mut byte = [0];
    let closed = timeout(Duration::from_millis(1000), turned_away.read(&mut byte)).await;
    assert!(matches!(closed, Ok(Ok(0) | Err(_))), "{closed:?}");
    for mut socket in silent {
        rest(&mut socket).await;
    }
    assert_eq!(server.get("/api/v1/health").await.status, 200);
    server.end().await;
}

#[tokio::test]
async fn two_hundred_silent_clients_hinder_nobody() {
    let server = Running::start(&Station::new()).await;
    let mut silent = Vec::new();
    for _ in 0..200 {
        silent.push(TcpStream::connect(server.addr).await.unwrap());
    }
    for _ in 0..20 {
        assert_eq!(server.get("/api/v1/health").await.status, 200);
    }
    drop(silent);
    server.end().await;
}

/// Heads of all answers to what a client sends in pieces, until the other side has closed.
async fn heads(server: &Running, pieces: &[&[u8]]) -> Vec<String> {
    let mut socket = TcpStream::connect(server.addr).await.unwrap();
    for piece in pieces {
        // A server that has closed takes no more.
        let _ = socket.write_all(piece).await;
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let mut bytes = Vec::new();
    let _ = within(socket.read_to_end(&mut bytes)).await;
    let text = String::from_utf8_lossy(&bytes);
    let answers = text.split("HTTP/1.1 ").skip(1);
    answers.map(|answer| answer.split("\r\n\r\n").next().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn what_is_no_http_is_refused_with_all_headers() {
    let limits = Limits { head_ms: 5_000, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    let host = server.host();
    let good = format!("GET /api/v1/health HTTP/1.1\r\nHost: {host}\r\n\r\n");
    let long_path = format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(65_600));
    let long_head = format!("GET / HTTP/1.1\r\nCookie: {}\r\n", "x".repeat(70_000));
    let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(101));
    let bad: Vec<(&str, &str)> = vec![
        ("nonsense\r\n\r\n", "400"),
        ("GET / HTTP/1.1\r\nno header\r\n\r\n", "400"),
        ("GET / HTTP/3.7\r\n\r\n", "400"),
        ("G\u{7f}T / HTTP/1.1\r\n\r\n", "400"),
        ("\u{16}\u{3}\u{1}\u{2}\u{0}\u{1}\u{0}\u{1}", "400"),
        ("GET / HTTP/1.1\r\nContent-Length: two\r\n\r\n", "400"),
        ("GET /ab c HTTP/1.1\r\n\r\n", "400"),
        (&long_path, "414 or 431"),
        (&long_head, "431"),
        (&many, "431"),
    ];
    for (bad, status) in bad {
        for before in 0..3 {
            // At once, and byte for byte where that does not take long.
            let text = good.repeat(before) + bad;
            let pieces: Vec<&[u8]> = text.as_bytes().chunks(text.len().div_ceil(40)).collect();
            for pieces in [&[text.as_bytes()][..], &pieces] {
                let heads = heads(&server, pieces).await;
                let words = &bad[..bad.len().min(60)];
                // A client that still sends while the connection closes may not see the refusal.
                let is_cut = bad.len() > 1000 && heads.len() == before;
                assert!(is_cut || heads.len() == before + 1, "{words:?} after {before}: {heads:?}");
                for (index, head) in heads.iter().enumerate() {
                    let expected = if index < before { "200" } else { status };
                    assert!(expected.contains(&head[..3]), "{words:?} after {before}: {head}");
                    for name in
                        ["content-security-policy", "x-content-type-options", "x-frame-options"]
                    {
                        assert!(
                            head.contains(name),
                            "{words:?} after {before}: no {name}:\n{head}"
                        );
                    }
                }
            }
        }
    }
    server.end().await;
}

#[tokio::test]
async fn requests_in_a_row_share_a_connection_and_one_with_a_body_ends_it() {
    let limits = Limits { head_ms: 400, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    let host = server.host();
    let get = |path: &str| format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
    let post = format!(
        "POST /api/v1/session/stop HTTP/1.1\r\nHost: {host}\r\nContent-Length: 5\r\n\r\nGET /"
    );
    let text = get("/") + &get("/api/v1/health") + &get("/none") + &post + &get("/api/v1/health");
    let statuses = |heads: Vec<String>| heads.iter().map(|head| head[..3].to_owned()).collect();
    let at_once: Vec<String> = statuses(heads(&server, &[text.as_bytes()]).await);
    assert_eq!(at_once, ["200", "200", "404", "401"]);
    let pieces: Vec<&[u8]> = text.as_bytes().chunks(7).collect();
    let in_pieces: Vec<String> = statuses(heads(&server, &pieces).await);
    assert_eq!(in_pieces, at_once);
    let connections: Vec<bool> = heads(&server, &[text.as_bytes()])
        .await
        .iter()
        .map(|head| head.contains("connection: close"))
        .collect();
    assert_eq!(connections, [false, false, false, true]);
    server.end().await;
}
