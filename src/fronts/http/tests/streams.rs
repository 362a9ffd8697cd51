//! The WebSocket: newest wins, bounded, and one slow client is nobody else's trouble.

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Error, Message};

use super::client::{Running, Station, Stream, TOKEN, snapshot, within};
use crate::Limits;

/// The next text message, and its sequence where it is a snapshot.
async fn next(stream: &mut Stream) -> (serde_json::Value, u64) {
    loop {
        match within(stream.next()).await.unwrap().unwrap() {
            Message::Text(text) => {
                let json: serde_json::Value = serde_json::from_str(&text).unwrap();
                let sequence = json["sequence"].as_u64().unwrap();
                return (json, sequence);
            }
            Message::Ping(_) => stream.flush().await.unwrap(),
            other => panic!("neither text nor ping: {other:?}"),
        }
    }
}

async fn closed_with(stream: &mut Stream) -> CloseCode {
    loop {
        match within(stream.next()).await {
            Some(Ok(Message::Close(Some(frame)))) => return frame.code,
            Some(Ok(_)) => {}
            other => panic!("no close frame: {other:?}"),
        }
    }
}

#[tokio::test]
async fn the_newest_snapshot_comes_first_then_every_new_one() {
    let station = Station::new();
    station.publish(snapshot(41, 0));
    let server = Running::start(&station).await;
    let mut stream = server.stream().await;
    let (first, sequence) = next(&mut stream).await;
    assert_eq!((first["format"].as_str(), sequence), (Some("asphera.snapshot/1"), 41));
    for sequence in 42..60 {
        station.publish(snapshot(sequence, 100));
        assert_eq!(next(&mut stream).await.1, sequence);
    }
    server.end().await;
}

#[tokio::test]
async fn a_client_that_pauses_gets_one_old_snapshot_and_then_the_newest() {
    let station = Station::new();
    let server = Running::start(&station).await;
    let (mut paused, mut watching) = (server.stream().await, server.stream().await);
    assert_eq!(next(&mut paused).await.1, 1);
    assert_eq!(next(&mut watching).await.1, 1);
    // The other client paces the publication: each snapshot was sent before the next is made.
    for sequence in 2..=300 {
        station.publish(snapshot(sequence, 10));
        assert_eq!(next(&mut watching).await.1, sequence);
    }
    let mut seen = vec![next(&mut paused).await.1];
    while seen[seen.len() - 1] < 300 {
        seen.push(next(&mut paused).await.1);
    }
    assert!(seen.is_sorted() && seen.len() <= 3, "{seen:?}");
    server.end().await;
}

#[tokio::test]
async fn a_quiet_station_says_that_it_is_alive() {
    let station = Station::new();
    let limits = Limits { alive_ms: 20, ..Limits::default() };
    let server = Running::with(&station, limits, Vec::new()).await;
    let mut stream = server.stream().await;
    assert_eq!(next(&mut stream).await.0["format"], "asphera.snapshot/1");
    for _ in 0..3 {
        let (alive, sequence) = next(&mut stream).await;
        assert_eq!((alive["format"].as_str(), sequence), (Some("asphera.alive/1"), 1));
    }
    server.end().await;
}

/// A client on a bare socket that sends the handshake and then reads nothing more.
async fn deaf_client(server: &Running) -> TcpStream {
    let mut socket = TcpStream::connect(server.addr).await.unwrap();
    let request = format!(
        "GET /api/v1/stream HTTP/1.1\r\nHost: {}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        server.host()
    );
    socket.write_all(request.as_bytes()).await.unwrap();
    let mut head = [0; 12];
    socket.read_exact(&mut head).await.unwrap();
    assert_eq!(&head, b"HTTP/1.1 101");
    socket
}

#[tokio::test]
async fn a_client_that_reads_nothing_is_cut_off_and_others_go_on() {
    let station = Station::new();
    let limits = Limits { streams: 2, answer_ms: 1000, ..Limits::default() };
    let server = Running::with(&station, limits, Vec::new()).await;
    let mut deaf = deaf_client(&server).await;
    let mut stream = server.stream().await;
    // 2.2 MB a snapshot: many times what the system buffers, were they sent to the deaf client.
    let bytes = 220_000 * 10;
    let mut received = 0;
    let mut sequence = 1;
    assert_eq!(next(&mut stream).await.1, 1);
    // Goes on until the deaf client's place is free again.
    let freed = loop {
        sequence += 1;
        station.publish(snapshot(sequence, 220_000));
        let (json, seen) = next(&mut stream).await;
        assert_eq!(seen, sequence, "the other client lost nothing");
        received += json["map"]["values_nm"].as_array().unwrap().len() * 10;
        if let Ok(third) = server.stream_with(&[]).await {
            break third;
        }
    };
    drop(freed);
    assert!(received >= bytes);
    // What the deaf client was sent before it was cut off: at most the first two snapshots.
    let mut sent = Vec::new();
    let _ = within(deaf.read_to_end(&mut sent)).await;
    assert!(sent.len() < 2 * bytes + 10_000, "{} bytes were queued for it", sent.len());
    server.end().await;
}

#[tokio::test]
async fn a_client_that_never_answers_the_ping_is_told_why_it_is_closed() {
    let limits = Limits { answer_ms: 100, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    let mut deaf = deaf_client(&server).await;
    let mut sent = Vec::new();
    within(deaf.read_to_end(&mut sent)).await.unwrap();
    // RFC 6455 section 7.4.1: 1008, policy violation, is 0x03F0.
    let at = sent.windows(4).rposition(|w| w[0] == 0x88 && w[2..] == [0x03, 0xf0]);
    assert!(at.is_some_and(|at| sent[at..].ends_with(b"too slow to read the snapshots")));
    server.end().await;
}

#[tokio::test]
async fn one_stream_too_many_is_refused_and_a_closed_one_makes_room() {
    let limits = Limits { streams: 1, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    let mut first = server.stream().await;
    assert_eq!(next(&mut first).await.1, 1);
    match server.stream_with(&[]).await {
        Err(Error::Http(answer)) => assert_eq!(answer.status(), 503),
        other => panic!("{other:?}"),
    }
    first.close(None).await.unwrap();
    while within(first.next()).await.is_some() {}
    let second = within(async {
        loop {
            if let Ok(stream) = server.stream_with(&[]).await {
                return stream;
            }
        }
    });
    assert_eq!(next(&mut second.await).await.1, 1);
    server.end().await;
}

#[tokio::test]
async fn shutdown_closes_streams_as_going_away() {
    let server = Running::start(&Station::new()).await;
    let mut stream = server.stream().await;
    assert_eq!(next(&mut stream).await.1, 1);
    let ((), code) = tokio::join!(server.end(), closed_with(&mut stream));
    assert_eq!(code, CloseCode::Away);
}

#[tokio::test]
async fn shutdown_waits_for_nobody_for_ever() {
    let limits = Limits { shutdown_ms: 100, ..Limits::default() };
    let server = Running::with(&Station::new(), limits, Vec::new()).await;
    // A request that never ends keeps its connection open.
    let mut half = TcpStream::connect(server.addr).await.unwrap();
    half.write_all(b"GET / HTTP/1.1\r\nHost: ").await.unwrap();
    let _deaf = deaf_client(&server).await;
    tokio::time::timeout(Duration::from_secs(10), server.end()).await.unwrap();
}

#[tokio::test]
async fn what_clients_say_is_ignored_and_bounded() {
    let station = Station::new();
    let server = Running::start(&station).await;
    let mut chatty = server.stream().await;
    assert_eq!(next(&mut chatty).await.1, 1);
    chatty.send(Message::text("start")).await.unwrap();
    station.publish(snapshot(2, 0));
    assert_eq!(next(&mut chatty).await.1, 2);
    let _ = chatty.send(Message::text("x".repeat(100_000))).await;
    let ended = within(async {
        loop {
            match chatty.next().await {
                None | Some(Err(_) | Ok(Message::Close(_))) => return true,
                Some(Ok(_)) => {}
            }
        }
    });
    assert!(ended.await);
    server.end().await;
}

#[tokio::test]
async fn the_token_may_come_as_subprotocol_and_is_not_repeated() {
    let server = Running::start(&Station::new()).await;
    let protocols = format!("asphera.token.{TOKEN}, asphera.snapshot.v1");
    let headers = [("Sec-WebSocket-Protocol", &*protocols)];
    let (mut stream, answer) = server.handshake(&headers).await.unwrap();
    assert_eq!(next(&mut stream).await.1, 1);
    assert_eq!(answer.headers()["sec-websocket-protocol"], "asphera.snapshot.v1");
    assert!(!format!("{answer:?}").contains(TOKEN));
    server.end().await;
}
