//! The adapter of the simulator: its answers, its lines, and its knobs.

use std::io;
use std::time::Duration;

use asphera_link::{CanFrame, CanId};
use asphera_sim_cia406::{Bus, Delivery, NodeConfig, Pty, Simulator, serve_tcp};
use asphera_slcan::{Decoder, Item};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinHandle;
use tokio_serial::SerialStream;

fn simulator() -> Simulator {
    let node = NodeConfig { node_id: 5, ..NodeConfig::default() };
    Simulator::new(Bus::new(vec![node]).expect("one node"))
}

/// A simulator with one host on a pipe of the given size.
fn served(size: usize) -> (Simulator, DuplexStream, JoinHandle<io::Result<()>>) {
    let simulator = simulator();
    let (host, adapter) = duplex(size);
    let server = simulator.clone();
    let task = tokio::spawn(async move { server.serve(adapter).await });
    (simulator, host, task)
}

/// Says something and reads as many bytes as the answer is expected to have.
async fn ask(host: &mut (impl AsyncReadExt + AsyncWriteExt + Unpin), said: &str, expected: &str) {
    host.write_all(said.as_bytes()).await.expect("the adapter listens");
    let mut answer = vec![0; expected.len()];
    host.read_exact(&mut answer).await.expect("the adapter answers");
    assert_eq!(String::from_utf8_lossy(&answer), expected, "after {said:?}");
}

/// Opens the channel and has node 5 answer each SYNC with its position alone.
async fn arm(host: &mut (impl AsyncReadExt + AsyncWriteExt + Unpin)) {
    ask(host, "S6\rO\r", "\r\r").await;
    for (asked, said) in [
        ("t60582300180185010080\r", None), // Without bit 30: allowed too.
        ("t60582F00180201000000\r", None),
        ("t60582F001A0000000000\r", None),
        ("t605823001A0120012060\r", None),
        ("t60582F001A0001000000\r", None),
        ("t60582300180185010000\r", Some("t58586000180100000000\r")),
    ] {
        let expected = format!("\r{}", said.unwrap_or(&ack(asked)));
        ask(host, asked, &expected).await;
    }
    ask(host, "t00020105\r", "\r").await;
}

/// The answer 60h to a download.
fn ack(asked: &str) -> String {
    format!("t585860{}00000000\r", &asked[7..13])
}

#[tokio::test]
async fn the_adapter_refuses_what_is_out_of_order() {
    let (_simulator, mut host, _task) = served(4096);
    ask(&mut host, "\r", "\r").await;
    ask(&mut host, "C\r", "\x07").await;
    ask(&mut host, "O\r", "\x07").await;
    ask(&mut host, "t00020105\r", "\x07").await;
    ask(&mut host, "S6\r", "\r").await;
    ask(&mut host, "V\rN\r", "V1013\rNS406\r").await;
    ask(&mut host, "O\r", "\r").await;
    ask(&mut host, "S5\r", "\x07").await;
    ask(&mut host, "F\r", "F00\r").await;
    ask(&mut host, "hello\r", "\x07").await;
    ask(&mut host, "C\r", "\r").await;
}

#[tokio::test]
async fn a_sync_is_answered_line_by_line() {
    let (simulator, mut host, _task) = served(4096);
    assert_eq!(simulator.sync(None, &[1]).await, Delivery::Unheard);
    arm(&mut host).await;
    simulator.wait_armed().await;
    assert_eq!(simulator.sync(None, &[123_456]).await, Delivery::Queued);
    ask(&mut host, "", "t0800\rt185440E20100\r").await;
    simulator.drop_next_tpdo(0);
    simulator.sync(None, &[0]).await;
    simulator.sync(None, &[-1]).await;
    ask(&mut host, "", "t0800\rt0800\rt1854FFFFFFFF\r").await;
    simulator.emergency(0, 0x5000, 1).await;
    ask(&mut host, "", "t08580050010000000000\r").await;
    simulator.reboot(0).await;
    ask(&mut host, "", "t705100\r").await;
    assert!(!simulator.armed());
}

#[tokio::test]
async fn frames_of_a_silence_are_lost() {
    let (simulator, mut host, _task) = served(4096);
    arm(&mut host).await;
    simulator.silence(Duration::from_secs(3600));
    assert_eq!(simulator.sync(None, &[1]).await, Delivery::Silenced);
    simulator.silence(Duration::ZERO);
    assert_eq!(simulator.sync(None, &[2]).await, Delivery::Queued);
    ask(&mut host, "", "t0800\rt185402000000\r").await;
}

#[tokio::test]
async fn noise_is_the_same_for_the_same_seed_and_damages_one_batch() {
    let mut heard = Vec::new();
    for _ in 0..2 {
        let (simulator, mut host, task) = served(4096);
        arm(&mut host).await;
        simulator.inject_noise(20, 7);
        simulator.sync(None, &[1]).await;
        simulator.sync(None, &[2]).await;
        let mut bytes = vec![0; 2 * "t0800\rt185401000000\r".len() + 20];
        host.read_exact(&mut bytes).await.expect("both cycles and the noise");
        simulator.close_connection();
        task.await.expect("no panic").expect("a good end");
        heard.push(bytes);
    }
    assert_eq!(heard[0], heard[1]);
    let mut decoder = Decoder::new();
    let mut rest = &heard[0][..];
    let mut frames = Vec::new();
    while !rest.is_empty() {
        if let Some(Item::Frame(frame, _)) = decoder.decode(&mut rest) {
            frames.push(frame);
        }
    }
    let last = CanFrame::data_frame(CanId::Standard(0x185), &[2, 0, 0, 0]).expect("four bytes");
    assert_eq!(frames.last(), Some(&last));
    assert_eq!(frames.len(), 3, "one line of four is damaged");
}

#[tokio::test]
async fn a_host_that_does_not_read_holds_the_trigger_back_and_loses_nothing() {
    let (simulator, mut host, _task) = served(256);
    arm(&mut host).await;
    let mut sent = 0_i32;
    while let Ok(delivery) =
        tokio::time::timeout(Duration::from_millis(50), simulator.sync(None, &[sent])).await
    {
        assert_eq!(delivery, Delivery::Queued);
        sent += 1;
        assert!(sent < 1000, "the queue has no bound");
    }
    for cycle in 0..sent {
        let position = cycle.to_le_bytes().map(|byte| format!("{byte:02X}")).concat();
        ask(&mut host, "", &format!("t0800\rt1854{position}\r")).await;
    }
}

#[tokio::test]
async fn heartbeats_come_by_themselves() {
    let (_simulator, mut host, _task) = served(4096);
    ask(&mut host, "S6\rO\r", "\r\r").await;
    ask(&mut host, "t60582B1710000A000000\r", "\rt58586017100000000000\rt70517F\rt70517F\r").await;
}

#[tokio::test]
async fn hosts_come_one_after_the_other_over_tcp() {
    let simulator = simulator();
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.expect("a free port");
    let address = listener.local_addr().expect("a bound port");
    let server = simulator.clone();
    let task = tokio::spawn(async move { serve_tcp(&server, &listener).await });
    for _ in 0..3 {
        let mut host = TcpStream::connect(address).await.expect("the simulator listens");
        ask(&mut host, "V\r", "V1013\r").await;
    }
    task.abort();
}

#[tokio::test]
async fn a_pseudo_terminal_is_a_serial_port() {
    let simulator = simulator();
    let mut pty = Pty::open().expect("a pseudo terminal");
    let path = pty.path().expect("a path");
    let server = simulator.clone();
    let task = tokio::spawn(async move { pty.serve(&server).await });
    for _ in 0..2 {
        let settings = tokio_serial::new(&path, 115_200);
        let mut host = SerialStream::open(&settings).expect("the port opens");
        ask(&mut host, "V\rS6\r", "V1013\r\r").await;
    }
    simulator.close_connection();
    task.await.expect("no panic").expect("a good end");
}
