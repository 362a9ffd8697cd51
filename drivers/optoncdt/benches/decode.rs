//! Decoding on one core: bytes of words a second, and of blocks to readings.

use asphera_link::{Driver as _, Event, Input, Nanos};
use asphera_optoncdt::wire::{Decoder, Width, Word, encode_three};
use asphera_optoncdt::{Extra, Optoncdt, Series, Settings};
use divan::Bencher;
use divan::counter::BytesCount;

fn main() {
    divan::main();
}

/// 100,000 words; every second is a further one.
fn stream() -> Vec<u8> {
    let word =
        |i: u32| Word { value: i.wrapping_mul(2_654_435_761) >> 16, is_first: i.is_multiple_of(2) };
    (0..100_000).flat_map(|i| encode_three(word(i))).collect()
}

#[divan::bench]
fn words(bencher: Bencher<'_, '_>) {
    let bytes = stream();
    bencher.counter(BytesCount::new(bytes.len())).bench_local(|| {
        let mut decoder = Decoder::new(Width::Three);
        let sum: u64 =
            bytes.iter().filter_map(|byte| decoder.push(*byte)).map(|w| u64::from(w.value)).sum();
        sum
    });
}

#[divan::bench]
fn readings(bencher: Bencher<'_, '_>) {
    let bytes = stream();
    let settings = Settings {
        series: Series::Plain,
        range_mm: 10.0,
        extras: vec![Extra::Counter],
        triggered: true,
        silence_ms: 0,
    };
    bencher.counter(BytesCount::new(bytes.len())).bench_local(|| {
        let mut driver =
            Optoncdt::new(settings.clone()).expect("settings of a benchmark are sound");
        driver.connected(Nanos::ZERO);
        let mut readings = 0_u32;
        for chunk in bytes.chunks(4096) {
            driver.receive(Nanos::ZERO, Input::Bytes(chunk));
            while let Some(event) = driver.poll_event() {
                readings += u32::from(matches!(event, Event::Reading(_)));
            }
        }
        // The newest block is held back until another follows it.
        assert_eq!(readings, 50_000 - 1);
        readings
    });
}
