//! Decoding on one core: points a second, of bytes and of a driver's readings.

use asphera_keyence::wire::{Answer, Layout, NoHeight, Profile};
use asphera_keyence::{Profiler, Settings};
use asphera_link::{Command, Driver as _, Event, Input, Nanos, Output};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const PROFILES: u32 = 300;

const LAYOUT: Layout = Layout {
    start_code: 7,
    kind: 1,
    points: 3200,
    unit_10nm: 8,
    x_start_10nm: -1_600_000,
    x_pitch_10nm: 1000,
};

/// Bytes that a link reads at once.
const READ: usize = 16 * 1024;

fn main() {
    divan::main();
}

/// Profiles as long as those of a head, every tenth point without a height.
fn stream() -> Vec<u8> {
    let height = |n: u32| match n % 10 {
        0 => Err(NoHeight::NoPeak),
        _ => Ok((n.wrapping_mul(2_654_435_761) >> 13).cast_signed() - (1 << 18)),
    };
    let profile = |n: u32| {
        let heights = (0..LAYOUT.points).map(|index| height(u32::from(index) + 31 * n));
        Profile::encode(&LAYOUT, n, n.cast_signed(), heights)
    };
    (0..PROFILES).flat_map(profile).collect()
}

fn counted<'a, 'b>(bencher: Bencher<'a, 'b>, stream: &[u8]) -> Bencher<'a, 'b> {
    let points = PROFILES * u32::from(LAYOUT.points);
    bencher.counter(BytesCount::new(stream.len())).counter(ItemsCount::new(points))
}

#[divan::bench]
fn points(bencher: Bencher<'_, '_>) {
    let stream = stream();
    counted(bencher, &stream).bench_local(|| {
        let profiles = stream
            .chunks(Profile::len(&LAYOUT))
            .filter_map(|bytes| Profile::decode(bytes, &LAYOUT)?.ok());
        profiles.flat_map(|profile| profile.heights()).flatten().map(i64::from).sum::<i64>()
    });
}

/// A driver whose stream has begun.
fn streaming() -> Profiler {
    let mut driver = Profiler::new(Settings::default()).expect("settings of a benchmark are sound");
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    while let Some(Output::Bytes(request)) = driver.poll_transmit() {
        let layout = LAYOUT.encode();
        let content: &[u8] = if request[16] == 0x47 { &layout } else { &[] };
        let answer = Answer { command: request[16], error: 0, content }.encode();
        driver.receive(Nanos::ZERO, Input::Bytes(&answer));
    }
    while driver.poll_event().is_some() {}
    driver
}

#[divan::bench]
fn readings(bencher: Bencher<'_, '_>) {
    let stream = stream();
    counted(bencher, &stream).bench_local(|| {
        let mut driver = streaming();
        let mut readings = 0_u32;
        for read in stream.chunks(READ) {
            driver.receive(Nanos::ZERO, Input::Second(read));
            while let Some(event) = driver.poll_event() {
                readings += u32::from(matches!(event, Event::Reading(_)));
            }
        }
        assert_eq!(readings, PROFILES);
        readings
    });
}
