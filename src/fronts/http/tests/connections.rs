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
