//! The driver against the simulator over a real pseudo-terminal and over TCP.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_chrocodile::{Chrocodile, Settings};
use asphera_link::{Command, Driver, Event, Input, Nanos, Output, Reading};
use asphera_sim_chrocodile::{Device, Ended, Fault, Sample, Simulator, pty, tcp};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::time::{Instant, sleep_until, timeout};
use tokio_serial::SerialStream;

/// Far longer than any of these tests takes.
const PATIENCE: Duration = Duration::from_secs(30);

fn simulator() -> Simulator {
    Simulator::new(Device::new(3000.0), 16)
}

fn sample(exposure: u64) -> Sample {
    Sample { exposure_count: exposure, encoder: [exposure as i32; 5], ..Sample::default() }
}

/// What a host reads until it has as many readings as wanted, or the stream ends.
async fn measure<S>(mut stream: S, wanted: usize) -> (Vec<Reading>, Vec<Event>)
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let start = Instant::now();
    let now = || Nanos::from_nanos(start.elapsed().as_nanos() as u64);
    let mut driver = Chrocodile::new(Settings::default()).unwrap();
    driver.connected(now());
    driver.command(now(), Command::Start);
    let (mut readings, mut others) = (Vec::new(), Vec::new());
    let mut bytes = [0; 4096];
    loop {
        while let Some(Output::Bytes(bytes)) = driver.poll_transmit() {
            stream.write_all(&bytes).await.unwrap();
        }
        while let Some(event) = driver.poll_event() {
            match event {
                Event::Reading(reading) => readings.push(reading),
                other => others.push(other),
            }
        }
        if readings.len() >= wanted {
            return (readings, others);
        }
        let due = driver.poll_timeout().map(|due| start + Duration::from_nanos(due.as_nanos()));
        tokio::select! {
            read = stream.read(&mut bytes) => match read {
                Ok(0) | Err(_) => return (readings, others),
                Ok(len) => driver.receive(now(), Input::Bytes(&bytes[..len])),
            },
            () = sleep_until(due.unwrap_or_else(|| Instant::now() + PATIENCE)), if due.is_some() => {
                driver.timeout(now());
            }
        }
    }
}

async fn expose(simulator: &Simulator, exposures: std::ops::Range<u64>) {
    simulator.wait_armed(true).await;
    for exposure in exposures {
        simulator.trigger(sample(exposure)).await.unwrap();
    }
}

fn assert_whole(readings: &[Reading], exposures: std::ops::Range<u64>) {
    let counts: Vec<u64> =
        readings.iter().map(|reading| reading.count.unwrap().raw.into()).collect();
    assert_eq!(counts, exposures.collect::<Vec<_>>());
    for reading in readings {
        let encoder = f64::from(reading.count.unwrap().raw);
        assert!(reading.values.iter().eq([Some(encoder), Some(1.0), Some(100.0)]), "{reading:?}");
        assert!(reading.flags.is_empty(), "{reading:?}");
    }
}

#[tokio::test]
async fn pseudo_terminal() {
    let simulator = simulator();
    let pty = pty(simulator.clone()).unwrap();
    let builder = tokio_serial::new(pty.path().to_str().unwrap(), 115_200);
    let serving = tokio::spawn(pty.run());
    let all_bytes = async {
        // The encoder runs through 0x0D, 0x0A, 0x11, 0x13 and 0xFF: a line that is not raw shows.
        let host = SerialStream::open(&builder).unwrap();
        let (measured, ()) = tokio::join!(measure(host, 600), expose(&simulator, 0..600));
        assert_whole(&measured.0, 0..600);
        // A second host meets the same device; the first has closed the port.
        let host = SerialStream::open(&builder).unwrap();
        simulator.fault(Fault::Restart);
        simulator.wait_armed(false).await;
        let (measured, ()) = tokio::join!(measure(host, 20), expose(&simulator, 600..620));
        assert_whole(&measured.0, 600..620);
        simulator.fault(Fault::Close);
        assert_eq!(serving.await.unwrap().unwrap(), Ended::ByFault);
    };
    timeout(PATIENCE, all_bytes).await.unwrap();
}

#[tokio::test]
async fn tcp_again_and_again() {
    let simulator = simulator();
    let (address, serving) = tcp(simulator.clone(), "127.0.0.1:0".parse().unwrap()).await.unwrap();
    let serving = tokio::spawn(serving);
    let hosts = async {
        for first in [0, 1000] {
            let host = tokio::net::TcpStream::connect(address).await.unwrap();
            let exposures = first..first + 500;
            let (measured, ()) =
                tokio::join!(measure(host, 500), expose(&simulator, exposures.clone()));
            assert_whole(&measured.0, exposures);
            simulator.wait_armed(false).await;
        }
        // A connection the device closes ends the stream for the host.
        let host = tokio::net::TcpStream::connect(address).await.unwrap();
        let ((readings, others), ()) = tokio::join!(measure(host, 1), async {
            simulator.wait_armed(true).await;
            simulator.fault(Fault::Close);
        });
        assert_eq!((readings, others), (vec![], vec![Event::Online, Event::Ready]));
    };
    timeout(PATIENCE, hosts).await.unwrap();
    serving.abort();
}

#[tokio::test]
async fn silence_loses_what_was_sent_meanwhile_and_nothing_else() {
    let simulator = simulator();
    let (host, device) = tokio::io::duplex(64 * 1024);
    let server = simulator.clone();
    let serving = tokio::spawn(async move { server.serve(device).await });
    let driving = async {
        expose(&simulator, 0..10).await;
        // The queue is empty once the host has what was sent; only then is the cable pulled.
        tokio::time::sleep(Duration::from_millis(100)).await;
        simulator.fault(Fault::Silent(Duration::from_millis(200)));
        expose(&simulator, 10..20).await;
        tokio::time::sleep(Duration::from_millis(300)).await;
        expose(&simulator, 20..30).await;
    };
    let ((readings, _), ()) =
        timeout(PATIENCE, async { tokio::join!(measure(host, 20), driving) }).await.unwrap();
    let counts: Vec<u32> = readings.iter().map(|reading| reading.count.unwrap().raw).collect();
    assert_eq!(counts, (0..10).chain(20..30).collect::<Vec<_>>());
    assert_eq!(serving.await.unwrap().unwrap(), Ended::ByHost);
}

#[tokio::test]
async fn exposures_wait_for_a_host_that_does_not_read() {
    let simulator = Simulator::new(Device::new(3000.0), 4);
    let (mut host, device) = tokio::io::duplex(256);
    let server = simulator.clone();
    let serving = tokio::spawn(async move { server.serve(device).await });
    let flooding = simulator.clone();
    let mut flood = tokio::spawn(async move {
        for exposure in 0..1000 {
            flooding.trigger(sample(exposure)).await.unwrap();
        }
    });
    let waited = timeout(Duration::from_millis(200), &mut flood).await;
    assert!(waited.is_err(), "a thousand exposures fit nowhere");
    let reading = async {
        // In ASCII each of the default telegrams is " 1000 100" CR LF.
        let mut bytes = vec![0; 1000 * 11];
        host.read_exact(&mut bytes).await.unwrap();
        flood.await.unwrap();
        bytes
    };
    let bytes = timeout(PATIENCE, reading).await.unwrap();
    assert_eq!(bytes, b" 1000 100\r\n".repeat(1000));
    drop(host);
    assert_eq!(serving.await.unwrap().unwrap(), Ended::ByHost);
}
