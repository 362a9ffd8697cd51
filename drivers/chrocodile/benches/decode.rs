//! How fast telegrams become readings, from bytes to drained events.

use asphera_chrocodile::wire::{Layout, Quantity, SYNC};
use asphera_chrocodile::{Chrocodile, Settings};
use asphera_link::{Command, Driver, Event, Input, Nanos, Output};
use divan::counter::{BytesCount, ItemsCount};

const TELEGRAMS: usize = 100_000;

fn main() {
    divan::main();
}

/// `chunk` bytes at a time, as a serial port (64) or a socket (4096) delivers them.
#[divan::bench(args = [18, 64, 4096])]
fn decode(bencher: divan::Bencher<'_, '_>, chunk: usize) {
    let stream = stream();
    bencher
        .counter(ItemsCount::new(TELEGRAMS))
        .counter(BytesCount::new(stream.len()))
        .with_inputs(driver)
        .bench_values(|mut driver| {
            let mut readings = 0;
            for bytes in stream.chunks(chunk) {
                driver.receive(Nanos::from_millis(1), Input::Bytes(bytes));
                while let Some(event) = driver.poll_event() {
                    readings += usize::from(matches!(event, Event::Reading(_)));
                }
            }
            assert_eq!(readings, TELEGRAMS - 1, "the last waits for its confirmation");
        });
}

fn stream() -> Vec<u8> {
    let layout = Layout::new(SYNC, &Settings::default().signals).expect("supported signals");
    let mut stream = Vec::with_capacity(TELEGRAMS * layout.telegram_len());
    for index in 0..TELEGRAMS {
        let value = |quantity| match quantity {
            Quantity::ExposureCount => (index % 65536) as f64,
            Quantity::ExposureFlags => 0.0,
            Quantity::EncoderStart(_) => index as f64 - 1000.0,
            _ => 1000.0 + (index as f64 * 1e-3).sin(),
        };
        layout.encode(3000.0, |signal| value(signal.quantity), &mut stream);
    }
    stream
}

/// A driver that streams.
fn driver() -> Chrocodile {
    let settings = Settings { scale_um: Some(3000.0), ..Settings::default() };
    let mut driver = Chrocodile::new(settings).expect("usable settings");
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    while let Some(output) = driver.poll_transmit() {
        let Output::Bytes(mut answer) = output else { continue };
        answer.extend(b"ready\r\n");
        driver.receive(Nanos::ZERO, Input::Bytes(&answer));
    }
    while driver.poll_event().is_some() {}
    driver
}
