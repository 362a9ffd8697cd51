//! Links over real sockets and pseudo terminals of this machine.

use super::*;
use crate::{FlowControl, Parity, SerialSettings};
use serialport::SerialPort as _;
use std::time::Duration;
use tokio::net::TcpListener;

pub(super) fn start(endpoint: Endpoint) -> (Link, mpsc::Receiver<LinkEvent>) {
    let (events, receiver) = mpsc::channel(16);
    let backoff = Backoff::try_new(Duration::from_millis(5), Duration::from_millis(20), 1).unwrap();
    (Link::spawn(LinkSettings { index: 3, endpoint, backoff }, events), receiver)
}

pub(super) async fn next(events: &mut mpsc::Receiver<LinkEvent>) -> What {
    let event = timeout(Duration::from_secs(10), events.recv()).await.unwrap().unwrap();
    assert_eq!(event.link, 3);
    event.what
}

fn serial(path: String, parity: Parity) -> Endpoint {
    Endpoint::Serial(SerialSettings {
        path,
        baud_bd: 115_200,
        parity,
        two_stop_bits: false,
        flow_control: FlowControl::None,
    })
}

#[tokio::test]
async fn tcp_link_comes_back_and_never_sends_to_the_wrong_connection() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (link, mut events) = start(Endpoint::Tcp { address });

    let (mut peer, _) = listener.accept().await.unwrap();
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    peer.write_all(b"one").await.unwrap();
    assert_eq!(next(&mut events).await, What::Received(b"one".to_vec()));
    drop(peer);
    assert!(matches!(next(&mut events).await, What::Closed(_)));

    let (mut peer, _) = listener.accept().await.unwrap();
    assert_eq!(next(&mut events).await, What::Opened { epoch: 2 });
    link.command(LinkCommand::Send { epoch: 1, bytes: b"old".to_vec() });
    link.command(LinkCommand::Reopen { epoch: 1 });
    link.command(LinkCommand::Send { epoch: 2, bytes: b"new".to_vec() });
    let mut got = [0; 3];
    peer.read_exact(&mut got).await.unwrap();
    assert_eq!(&got, b"new");

    link.command(LinkCommand::Reopen { epoch: 2 });
    assert!(matches!(next(&mut events).await, What::Closed(_)));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 3 });
}

/// A host that takes nothing of what was read still sends: a halt does not wait for it.
#[tokio::test]
async fn commands_go_out_while_nobody_takes_what_was_read() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (link, mut events) = start(Endpoint::Tcp { address });
    let remote = link.remote();
    let (mut peer, _) = listener.accept().await.unwrap();
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    // Until all buffers are full: then the link waits for its queue of events.
    let flood = vec![b'x'; 1 << 16];
    while timeout(Duration::from_millis(200), peer.write_all(&flood)).await.is_ok() {}
    remote.command(LinkCommand::Send { epoch: 1, bytes: b"stop".to_vec() });
    let mut got = [0; 4];
    timeout(Duration::from_millis(100), peer.read_exact(&mut got)).await.expect("in time").unwrap();
    assert_eq!(&got, b"stop");
    // Nothing was lost meanwhile.
    assert!(matches!(next(&mut events).await, What::Received(_)));
    drop(link);
    remote.command(LinkCommand::Send { epoch: 1, bytes: b"late".to_vec() });
}

#[tokio::test]
async fn closed_tcp_port_is_reported_and_tried_again() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    drop(listener);
    let (_link, mut events) = start(Endpoint::Tcp { address: address.clone() });
    for _ in 0..2 {
        let What::OpenFailed(words) = next(&mut events).await else { panic!("expected a failure") };
        assert!(words.contains(&address) && words.contains("refused"), "{words}");
    }
}

#[tokio::test]
async fn unplugged_serial_port_closes_and_opens_again_under_another_name() {
    let dir = tempfile::tempdir().unwrap();
    let stable = dir.path().join("probe");
    let plug = || {
        let (master, slave) = tokio_serial::SerialStream::pair().unwrap();
        let _ = std::fs::remove_file(&stable);
        std::os::unix::fs::symlink(slave.name().unwrap(), &stable).unwrap();
        // The link opens the port for itself alone, so nobody else may hold it that way.
        (master, slave)
    };
    let (mut master, slave) = plug();
    drop(slave);
    let (link, mut events) = start(serial(stable.display().to_string(), Parity::None));
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    master.write_all(&[0x00, 0x0D, 0xFF, 0x11]).await.unwrap();
    assert_eq!(next(&mut events).await, What::Received(vec![0x00, 0x0D, 0xFF, 0x11]));
    link.command(LinkCommand::Send { epoch: 1, bytes: b"$VER\r".to_vec() });
    let mut got = [0; 5];
    master.read_exact(&mut got).await.unwrap();
    assert_eq!(&got, b"$VER\r");

    let first = std::fs::read_link(&stable).unwrap();
    drop(master);
    assert!(matches!(next(&mut events).await, What::Closed(_)));
    // Another device takes the name that is free now: ttyUSB0 comes back as ttyUSB1.
    let _other = tokio_serial::SerialStream::pair().unwrap();
    let (mut master, slave) = plug();
    drop(slave);
    assert_ne!(std::fs::read_link(&stable).unwrap(), first);
    loop {
        match next(&mut events).await {
            What::OpenFailed(_) => {}
            what => {
                assert_eq!(what, What::Opened { epoch: 2 });
                break;
            }
        }
    }
    master.write_all(&[0x55]).await.unwrap();
    assert_eq!(next(&mut events).await, What::Received(vec![0x55]));
}

#[tokio::test]
async fn parity_on_a_pseudo_terminal_is_named_as_such() {
    let (_master, slave) = tokio_serial::SerialStream::pair().unwrap();
    let path = slave.name().unwrap();
    drop(slave);
    let (_link, mut events) = start(serial(path, Parity::Even));
    match next(&mut events).await {
        What::OpenFailed(words) => assert!(words.contains("parity"), "{words}"),
        // Some kernels take the flag and ignore it: then the port is simply open.
        what => assert_eq!(what, What::Opened { epoch: 1 }),
    }
}

#[tokio::test]
async fn missing_can_interface_is_named() {
    let (_link, mut events) =
        start(Endpoint::SocketCan { interface: "nocan9".to_owned(), timestamps: false });
    let What::OpenFailed(words) = next(&mut events).await else { panic!("expected a failure") };
    assert!(words.contains("nocan9"), "{words}");
}

/// The device's side of a link of two connections, once it has opened.
async fn accept_pair(listeners: &[TcpListener; 2]) -> [tokio::net::TcpStream; 2] {
    let [first, second] = listeners;
    [first.accept().await.unwrap().0, second.accept().await.unwrap().0]
}

#[tokio::test]
async fn two_connections_are_one_link() {
    let listeners = [
        TcpListener::bind("127.0.0.1:0").await.unwrap(),
        TcpListener::bind("127.0.0.1:0").await.unwrap(),
    ];
    let address = listeners[0].local_addr().unwrap().to_string();
    let second_port = listeners[1].local_addr().unwrap().port();
    let (link, mut events) = start(Endpoint::TcpPair { address, second_port });

    let [mut first, mut second] = accept_pair(&listeners).await;
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    first.write_all(b"answer").await.unwrap();
    assert_eq!(next(&mut events).await, What::Received(b"\x00answer".to_vec()));
    second.write_all(b"stream").await.unwrap();
    assert_eq!(next(&mut events).await, What::Received(b"\x01stream".to_vec()));
    link.command(LinkCommand::Send { epoch: 1, bytes: b"ask".to_vec() });
    let mut got = [0; 3];
    first.read_exact(&mut got).await.unwrap();
    assert_eq!(&got, b"ask", "what is sent goes to the first");

    // A loss of either is the loss of both.
    drop(second);
    let What::Closed(why) = next(&mut events).await else { panic!("it is open still") };
    assert!(why.contains("second"), "{why}");
    assert_eq!(first.read(&mut got).await.unwrap(), 0, "the first one is closed, too");
    let [first, mut second] = accept_pair(&listeners).await;
    assert_eq!(next(&mut events).await, What::Opened { epoch: 2 });
    drop(first);
    let What::Closed(why) = next(&mut events).await else { panic!("it is open still") };
    assert!(why.contains("first"), "{why}");
    assert_eq!(second.read(&mut got).await.unwrap(), 0, "the second one is closed, too");
}

#[tokio::test]
async fn one_port_of_two_is_no_open_link() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let free = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let second_port = free.local_addr().unwrap().port();
    drop(free);
    let address = listener.local_addr().unwrap().to_string();
    let (_link, mut events) = start(Endpoint::TcpPair { address, second_port });
    let What::OpenFailed(why) = next(&mut events).await else { panic!("it opened") };
    assert!(why.contains(&format!("127.0.0.1:{second_port}")), "{why}");
}

/// Lines 20 ms and 30 ms after the first one, and one that has no end.
const LOG: &str =
    "(100.000000) can0 123#11\n(100.020000) can0 123#22\nnoise\n(100.030000) can0 123#33";

#[tokio::test]
async fn a_log_is_played_once_at_its_own_pace() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bus.log");
    std::fs::write(&path, LOG).unwrap();
    let (link, mut events) = start(Endpoint::CanLog { path, speed: 1.0 });
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    link.command(LinkCommand::Send { epoch: 1, bytes: b"to nobody".to_vec() });
    let mut times = Vec::new();
    for line in LOG.lines() {
        let event = timeout(Duration::from_secs(10), events.recv()).await.unwrap().unwrap();
        assert_eq!(event.what, What::Received(format!("{line}\n").into_bytes()));
        assert!(event.at <= Instant::now(), "no line comes before its time");
        times.push(event.at);
    }
    let after: Vec<u128> = times.iter().map(|at| (*at - times[0]).as_micros()).collect();
    assert_eq!(after, [0, 20_000, 20_000, 30_000], "times are those of the log to the microsecond");
    let What::Closed(why) = next(&mut events).await else { panic!("it goes on") };
    assert!(why.contains("bus.log ended"), "{why}");
    // It is not opened again: the same frames would come twice.
    link.command(LinkCommand::Reopen { epoch: 1 });
    assert!(timeout(Duration::from_millis(100), events.recv()).await.is_err());
}

#[tokio::test]
async fn a_missing_log_is_named_and_a_file_without_lines_stays_small() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.log");
    let (_link, mut events) = start(Endpoint::CanLog { path: path.clone(), speed: 1.0 });
    let What::OpenFailed(why) = next(&mut events).await else { panic!("it opened") };
    assert!(why.contains("none.log") && why.contains("candump -l"), "{why}");
    drop(_link);
    std::fs::write(&path, vec![0; 100_000]).unwrap();
    let (_link, mut events) = start(Endpoint::CanLog { path, speed: 1.0 });
    assert_eq!(next(&mut events).await, What::Opened { epoch: 1 });
    let mut count = 0;
    loop {
        match next(&mut events).await {
            What::Received(bytes) => {
                assert!(bytes.len() < 10_000);
                count += bytes.len();
            }
            What::Closed(_) => break,
            what => panic!("{what:?}"),
        }
    }
    assert_eq!(count, 100_001, "every byte, and the end that the line lacks");
}
