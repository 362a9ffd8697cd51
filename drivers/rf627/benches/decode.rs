//! Decoding on one core: points a second, of datagrams and of a driver's readings.

use asphera_link::{Driver as _, Event, Input, Nanos};
use asphera_rf627::wire::{Format, Header, Packet, RawPoint, encode};
use asphera_rf627::{Rf627, Settings};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const PROFILES: u32 = 1000;
const POINTS: u32 = 648;

fn main() {
    divan::main();
}

/// Profiles as long as those of the scanner, every tenth point without a value.
fn datagrams() -> Vec<Vec<u8>> {
    let point = |n: u32| RawPoint {
        x: (n * 25) as i16 - 8100,
        z: if n.is_multiple_of(10) { 0 } else { (n.wrapping_mul(2_654_435_761) >> 18) as u16 },
    };
    let points: Vec<RawPoint> = (0..POINTS).map(point).collect();
    let datagram = |measure: u32| {
        let header = Header {
            format: Format::Profile,
            serial: 180_000,
            time_ns: u64::from(measure) * 2_000_000,
            version: (1, 0),
            packet_count: measure,
            measure_count: measure,
            z_range_mm: 200,
            x_range_mm: 166,
            range_steps: 16_384,
            licence_hash: 0,
            exposure_ns: 100_000,
            laser: 42,
            step_count: measure,
            direction: 0,
        };
        let mut bytes = Vec::new();
        encode(&header, &points, None, &mut bytes).expect("648 points fit into a datagram");
        bytes
    };
    (0..PROFILES).map(datagram).collect()
}

fn counted<'a, 'b>(bencher: Bencher<'a, 'b>, datagrams: &[Vec<u8>]) -> Bencher<'a, 'b> {
    let bytes: usize = datagrams.iter().map(Vec::len).sum();
    bencher.counter(BytesCount::new(bytes)).counter(ItemsCount::new(PROFILES * POINTS))
}

#[divan::bench]
fn points(bencher: Bencher<'_, '_>) {
    let datagrams = datagrams();
    counted(bencher, &datagrams).bench_local(|| {
        let packets = datagrams.iter().filter_map(|bytes| Packet::decode(bytes).ok());
        packets.flat_map(|packet| packet.points_mm()).flatten().map(|[x, z]| x + z).sum::<f64>()
    });
}

#[divan::bench]
fn readings(bencher: Bencher<'_, '_>) {
    let datagrams = datagrams();
    counted(bencher, &datagrams).bench_local(|| {
        let mut driver =
            Rf627::new(Settings::default()).expect("settings of a benchmark are sound");
        driver.connected(Nanos::ZERO);
        let mut readings = 0_u32;
        for datagram in &datagrams {
            driver.receive(Nanos::ZERO, Input::Bytes(datagram));
            while let Some(event) = driver.poll_event() {
                readings += u32::from(matches!(event, Event::Reading(_)));
            }
        }
        assert_eq!(readings, PROFILES);
        readings
    });
}
