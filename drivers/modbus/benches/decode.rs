//! How many answers a second the driver takes: request out, answer in, reading given.

use asphera_link::{Driver as _, Event, Input, Nanos, Output};
use asphera_modbus::{Modbus, Settings, Transport};
use divan::{Bencher, counter::ItemsCount};

fn main() {
    divan::main();
}

/// Polls of one benchmark round.
const POLLS: u64 = 1000;

/// Input registers 200 to 212 of an OM20 in one answer of 35 bytes, one reading of five channels each.
#[divan::bench]
fn om20_tcp(bencher: Bencher<'_, '_>) {
    let mut answer = vec![0, 0, 0, 0, 0, 29, 1, 4, 26];
    let words: [u16; 13] = [0, 1, 0x7C37, 0x428B, 0, 0x43FA, 87, 2000, 0, 12, 0, 0x464E, 5];
    answer.extend(words.into_iter().flat_map(u16::to_be_bytes));
    let settings = Settings {
        transport: Transport::Tcp,
        pause_between_requests_ms: 0,
        skip_repeated: false,
        ..Settings::default()
    };
    bencher.counter(ItemsCount::new(POLLS)).bench_local(|| {
        let mut driver = Modbus::new(settings.clone()).expect("settings of the bench are sound");
        let mut readings = 0;
        driver.connected(Nanos::ZERO);
        for _ in 0..POLLS {
            let Some(Output::Bytes(request)) = driver.poll_transmit() else { break };
            answer[..2].copy_from_slice(&request[..2]);
            let due = driver.poll_timeout().unwrap_or_default();
            driver.receive(due, Input::Bytes(&answer));
            while let Some(event) = driver.poll_event() {
                readings += u64::from(matches!(event, Event::Reading(_)));
            }
            driver.timeout(driver.poll_timeout().unwrap_or_default());
        }
        assert_eq!(readings, POLLS);
    });
}
