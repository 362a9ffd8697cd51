//! The thermometer by Modbus TCP requests written by hand (MODBUS Messaging on TCP/IP V1.0b, 3.1.3;
//! Application Protocol V1.1b3, 6.4).

use std::time::Duration;

use asphera_rig::{Fault, Link, Scene};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout};

use crate::host::{PATIENCE, address, start};

/// Reads input registers 0 and 1 of unit 1; `None` when the connection is closed.
async fn temperatures_degc(stream: &mut TcpStream) -> Option<[f64; 2]> {
    stream.write_all(&[0, 7, 0, 0, 0, 6, 1, 4, 0, 0, 0, 2]).await.ok()?;
    let mut answer = [0; 13];
    stream.read_exact(&mut answer).await.ok()?;
    assert_eq!(answer[..9], [0, 7, 0, 0, 0, 7, 1, 4, 4]);
    Some([9, 11].map(|at| f64::from(i16::from_be_bytes([answer[at], answer[at + 1]])) * 0.01))
}

#[tokio::test]
async fn temperatures_are_those_of_a_room_and_the_port_can_be_unplugged() {
    let (_dir, rig) = start(Scene::built_in("asphere").unwrap().with_points(10)).await;
    let address = address(&rig, "thermal");
    let all = async {
        let mut stream = TcpStream::connect(&address).await.unwrap();
        let found = temperatures_degc(&mut stream).await.unwrap();
        assert!(found.iter().all(|t| (t - 20.0).abs() <= 0.15 + 0.005), "{found:?}");

        let duration = Duration::from_millis(300);
        rig.fault(Link::Thermal, Fault::Unplug { duration, restart: false }).unwrap();
        while temperatures_degc(&mut stream).await.is_some() {}
        assert!(TcpStream::connect(&address).await.is_err(), "nothing listens while it is out");
        let mut stream = loop {
            match TcpStream::connect(&address).await {
                Ok(stream) => break stream,
                Err(_) => sleep(Duration::from_millis(5)).await,
            }
        };
        assert!(temperatures_degc(&mut stream).await.is_some());

        rig.fault(Link::Thermal, Fault::Noise { bytes: 6 }).unwrap();
        stream.write_all(&[0, 8, 0, 0, 0, 6, 1, 4, 0, 0, 0, 2]).await.unwrap();
        let mut answer = [0; 19];
        stream.read_exact(&mut answer).await.unwrap();
        assert_eq!(answer[6..15], [0, 8, 0, 0, 0, 7, 1, 4, 4]);
    };
    timeout(PATIENCE, all).await.unwrap();
}
