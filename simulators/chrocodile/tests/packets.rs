//! The driver on the packet protocol against the device: in virtual time, and over TCP.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_chrocodile::{PacketChrocodile, PacketSettings};
use asphera_link::{Command, Driver, Event, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_sim_chrocodile::{
    Ended, Exposure, Fault, PacketDevice, Sample, Simulator, TriggerMode, tcp,
};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

const FULL_SCALE_UM: f64 = 3000.0;
/// Longer than any of these tests takes.
const PATIENCE: Duration = Duration::from_secs(30);

/// Driver and device with a wire between them that takes no time.
struct Pair {
    driver: PacketChrocodile,
    device: PacketDevice,
    now: Nanos,
    /// Bytes that reach the driver at once.
    piece: usize,
    events: Vec<Event>,
}

impl Pair {
    fn measuring(settings: PacketSettings, points: u16) -> Pair {
        let mut pair = Pair {
            driver: PacketChrocodile::new(settings).unwrap(),
            device: PacketDevice::new(FULL_SCALE_UM, points),
            now: Nanos::ZERO,
            piece: usize::MAX,
            events: Vec::new(),
        };
        pair.driver.connected(pair.now);
        pair.driver.command(pair.now, Command::Start);
        pair.settle();
        assert_eq!(std::mem::take(&mut pair.events), [Event::Online, Event::Ready]);
        assert!(pair.device.armed());
        pair
    }

    /// Carries bytes both ways until nobody has anything to say.
    fn settle(&mut self) {
        loop {
            let mut is_quiet = true;
            while let Some(output) = self.driver.poll_transmit() {
                let Output::Bytes(bytes) = output else { panic!("{output:?}") };
                is_quiet = false;
                self.device.receive(&bytes);
            }
            for piece in self.device.transmit().chunks(self.piece) {
                is_quiet = false;
                self.driver.receive(self.now, Input::Bytes(piece));
            }
            self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
            if is_quiet {
                return;
            }
        }
    }

    /// Exposures of these numbers, so many in a packet.
    fn expose(&mut self, exposures: std::ops::Range<u64>, at_once: usize) {
        for exposure in exposures {
            self.device.expose(&sample(exposure).into());
            if (exposure + 1).is_multiple_of(at_once as u64) {
                self.settle();
            }
        }
        self.settle();
    }

    fn counts(&mut self) -> Vec<u32> {
        self.readings().iter().map(|reading| reading.count.unwrap().raw).collect()
    }

    fn readings(&mut self) -> Vec<Reading> {
        let events = std::mem::take(&mut self.events);
        let readings = events.into_iter().filter_map(|event| match event {
            Event::Reading(reading) => Some(reading),
            _ => None,
        });
        readings.collect()
    }
}

fn sample(exposure: u64) -> Sample {
    Sample {
        exposure_count: exposure,
        start_ns: exposure * 1_000_000,
        encoder: [exposure as i32 - 5; 5],
        distance_um: Some(1000.0 + exposure as f64),
        ..Sample::default()
    }
}

#[test]
fn every_exposure_is_a_reading_however_packets_are_filled_and_cut() {
    let signals = vec![256, 64, 257, 76, 75, 66];
    for (at_once, piece) in [(1, usize::MAX), (7, 11), (1000, 1), (1000, 1460)] {
        let settings = PacketSettings { signals: signals.clone(), ..PacketSettings::default() };
        let mut pair = Pair::measuring(settings, 1);
        pair.piece = piece;
        pair.expose(0..1000, at_once);
        let readings = pair.readings();
        assert_eq!(readings.len(), 1000);
        for (exposure, reading) in (0_u64..).zip(&readings) {
            assert_eq!(u64::from(reading.count.unwrap().raw), exposure);
            assert_eq!(reading.device_time_ns, Some(exposure * 1_000_000));
            let distance_mm = (1000.0 + exposure as f64) / 1000.0;
            let expected = [distance_mm, 100.0, exposure as f64 - 5.0].map(Some);
            assert!(reading.values.iter().eq(expected), "{reading:?}");
            assert_eq!(reading.flags, Flags::empty());
        }
        assert_eq!(pair.device.trigger_mode(), TriggerMode::Each);
    }
}

#[test]
fn flags_and_gaps_come_through() {
    let mut pair = Pair::measuring(PacketSettings::default(), 1);
    pair.device.expose(&Sample { flags: 3, ..sample(0) }.into());
    pair.device.expose(&Sample { distance_um: None, ..sample(1) }.into());
    pair.settle();
    let readings = pair.readings();
    assert_eq!(readings[0].flags, Flags::SATURATED | Flags::TRIGGER_LOST);
    assert_eq!((readings[1].flags, readings[1].values.get(1)), (Flags::NO_SIGNAL, None));
}

#[test]
fn faults_of_the_line_cost_what_they_hit_and_nothing_else() {
    let mut pair = Pair::measuring(PacketSettings::default(), 1);
    pair.device.inject(500, 7);
    pair.expose(0..10, 5);
    assert_eq!(pair.counts(), (0..10).collect::<Vec<_>>());
    pair.device.corrupt_next();
    pair.expose(10..20, 5);
    assert_eq!(pair.counts(), (15..20).collect::<Vec<_>>());
    pair.device.drop_next();
    pair.expose(20..25, 5);
    assert_eq!(pair.counts(), [21, 22, 23, 24]);
    assert_eq!(pair.device.dropped(), 1);
}

#[test]
fn a_lost_format_is_asked_for() {
    let mut pair = Pair::measuring(PacketSettings::default(), 1);
    pair.expose(0..3, 1);
    pair.device.lose_format();
    pair.expose(3..6, 1);
    let events = std::mem::take(&mut pair.events);
    let faults: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::Fault(fault) => Some((fault.kind, fault.detail.as_str())),
            _ => None,
        })
        .collect();
    assert_eq!(
        faults,
        [(FaultKind::Protocol, "data of the format 2: it did not come, and is asked for")]
    );
    pair.events = events;
    // One packet is lost: the format follows the answer to the question it raised.
    assert_eq!(pair.counts(), [0, 1, 2, 4, 5]);
}

#[test]
fn another_probe_scales_the_data_behind_its_update() {
    let settings = PacketSettings { signals: vec![75, 16640], ..PacketSettings::default() };
    let mut pair = Pair::measuring(settings, 1);
    pair.expose(500..501, 1);
    pair.device.change_probe(6000.0);
    pair.expose(501..502, 1);
    let readings = pair.readings();
    for (reading, expected_mm) in readings.iter().zip([1.5, 1.501]) {
        // Half a step of 16 bits over 6 mm.
        assert!((reading.values.get(0).unwrap() - expected_mm).abs() <= 6.0 / 65_536.0);
    }
    assert_eq!(readings.len(), 2);
}

#[test]
fn a_line_is_a_profile_an_exposure() {
    let settings = PacketSettings {
        signals: vec![75, 65, 256, 257],
        pitch_um: Some(20.0),
        ..PacketSettings::default()
    };
    let mut pair = Pair::measuring(settings, 100);
    for exposure in 0..12 {
        let distance = |point: u64| (point % 9 != 4).then(|| 100.0 + (exposure + 3 * point) as f64);
        let line_um = Some((0..100).map(distance).collect());
        pair.device.expose(&Exposure { sample: sample(exposure), line_um });
    }
    pair.settle();
    let readings = pair.readings();
    assert_eq!(readings.len(), 12);
    for (exposure, reading) in (0_u64..).zip(&readings) {
        let profile = reading.values.profile().unwrap();
        assert_eq!((profile.points_mm().len(), profile.valid()), (100, 89));
        assert_eq!(reading.values.get(1), Some(89.0));
        for (point, place) in (0_u64..).zip(profile.points_mm()) {
            let Some([x_mm, z_mm]) = place else {
                assert_eq!(point % 9, 4);
                continue;
            };
            let expected_mm = (100 + exposure + 3 * point) as f64 / 1000.0;
            assert!((x_mm - point as f64 * 0.02).abs() < 1e-12);
            assert!((z_mm - expected_mm).abs() < 1e-7, "{z_mm}, expected {expected_mm}");
        }
    }
}

/// What a host reads until it has as many readings as wanted, or the stream ends.
async fn host(address: std::net::SocketAddr, wanted: usize) -> (Vec<Reading>, Vec<Event>) {
    let mut stream = tokio::net::TcpStream::connect(address).await.unwrap();
    let mut driver = PacketChrocodile::new(PacketSettings::default()).unwrap();
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    let (mut readings, mut others, mut bytes) = (Vec::new(), Vec::new(), [0; 4096]);
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
        match stream.read(&mut bytes).await {
            Ok(0) | Err(_) => return (readings, others),
            Ok(len) => driver.receive(Nanos::ZERO, Input::Bytes(&bytes[..len])),
        }
    }
}

#[tokio::test]
async fn over_tcp_each_connection_is_a_new_one() {
    let simulator = Simulator::new(PacketDevice::new(FULL_SCALE_UM, 1), 16);
    let (address, serving) = tcp(simulator.clone(), "127.0.0.1:0".parse().unwrap()).await.unwrap();
    let serving = tokio::spawn(serving);
    let hosts = async {
        for first in [0, 1000] {
            let expose = async {
                simulator.wait_armed(true).await;
                for exposure in first..first + 500 {
                    simulator.trigger(sample(exposure)).await.unwrap();
                }
            };
            let ((readings, others), ()) = tokio::join!(host(address, 500), expose);
            assert_eq!(others, [Event::Online, Event::Ready]);
            let counts: Vec<u64> =
                readings.iter().map(|reading| reading.count.unwrap().raw.into()).collect();
            assert_eq!(counts, (first..first + 500).collect::<Vec<_>>());
            simulator.wait_armed(false).await;
        }
        // A device that loses its supply ends the connection.
        let restart = async {
            simulator.wait_armed(true).await;
            simulator.fault(Fault::Restart);
        };
        let ((readings, others), ()) = tokio::join!(host(address, 1), restart);
        assert_eq!((readings, others), (vec![], vec![Event::Online, Event::Ready]));
    };
    tokio::time::timeout(PATIENCE, hosts).await.unwrap();
    serving.abort();
}

#[tokio::test]
async fn a_connection_that_is_closed_by_a_fault_says_so() {
    let simulator = Simulator::new(PacketDevice::new(FULL_SCALE_UM, 1), 4);
    let (near, far) = tokio::io::duplex(4096);
    let serving = tokio::spawn({
        let simulator = simulator.clone();
        async move { simulator.serve(far).await }
    });
    tokio::task::yield_now().await;
    simulator.fault(Fault::Close);
    let ended = tokio::time::timeout(PATIENCE, serving).await.unwrap().unwrap();
    assert_eq!(ended.unwrap(), Ended::ByFault);
    drop(near);
}
