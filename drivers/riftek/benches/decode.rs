//! Decoding on one core: bytes of answers a second, and of a stream to readings.

use asphera_link::{Driver as _, Event, Input, Nanos};
use asphera_riftek::wire::{Decoder, encode_answer};
use asphera_riftek::{Mode, Riftek, Settings};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const RESULTS: u32 = 50_000;

fn main() {
    divan::main();
}

fn stream() -> Vec<u8> {
    let result = |i: u32| (i.wrapping_mul(2_654_435_761) >> 18) as u16;
    (0..RESULTS).flat_map(|i| encode_answer(true, i as u8, &result(i).to_le_bytes())).collect()
}

#[divan::bench]
fn answers(bencher: Bencher<'_, '_>) {
    let bytes = stream();
    bencher.counter(BytesCount::new(bytes.len())).counter(ItemsCount::new(RESULTS)).bench_local(
        || {
            let mut decoder = Decoder::new(2);
            let answers = bytes.iter().filter_map(|byte| decoder.push(*byte));
            answers.filter_map(|answer| answer.result()).map(u64::from).sum::<u64>()
        },
    );
}

#[divan::bench]
fn readings(bencher: Bencher<'_, '_>) {
    let bytes = stream();
    let settings = Settings {
        address: 1,
        mode: Mode::Stream { silence_ms: 0 },
        range_mm: 50,
        serial: None,
        timeout_ms: 200,
        late_limit_ms: 400,
    };
    bencher.counter(BytesCount::new(bytes.len())).counter(ItemsCount::new(RESULTS)).bench_local(
        || {
            let mut driver =
                Riftek::new(settings.clone()).expect("settings of a benchmark are sound");
            let now = Nanos::from_millis(100);
            driver.connected(Nanos::ZERO);
            driver.timeout(now);
            let identity = encode_answer(false, 3, &[0x3F, 0x90, 0x21, 0x43, 80, 0, 50, 0]);
            driver.receive(now, Input::Bytes(&identity));
            let mut readings = 0_u32;
            for chunk in bytes.chunks(4096) {
                driver.receive(now, Input::Bytes(chunk));
                while let Some(event) = driver.poll_event() {
                    readings += u32::from(matches!(event, Event::Reading(_)));
                }
            }
            // The newest result is held back until another follows it.
            assert_eq!(readings, RESULTS - 1);
            readings
        },
    );
}
