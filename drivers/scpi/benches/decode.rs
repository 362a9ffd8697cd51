//! Answers to readings on one core: bytes a second, each answer after its question.

use asphera_link::{Event, Input, Nanos};
use asphera_scpi::FAMILY;
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const ANSWERS: u32 = 20_000;

fn main() {
    divan::main();
}

#[divan::bench]
fn answers(bencher: Bencher<'_, '_>) {
    let settings = "identity = 'X'\nquery = 'READ?'\ninterval_ms = 1\nerrors = false\ncolumns = 2\n\
        field = [{ name = 'a' }, { name = 'b', column = 2 }]";
    let settings = FAMILY.parse("meter", settings).expect("settings of a benchmark are sound");
    let value = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 12) * 1e-3;
    let answers: Vec<String> =
        (0..ANSWERS).map(|i| format!("{:+.8E},{:+.8E}\n", value(i), value(i + 1))).collect();
    let bytes: usize = answers.iter().map(String::len).sum();
    bencher.counter(BytesCount::new(bytes)).counter(ItemsCount::new(ANSWERS)).bench_local(|| {
        let mut driver = settings.driver().expect("settings of a benchmark are sound");
        let mut now = Nanos::ZERO;
        let mut readings = 0_u32;
        driver.connected(now);
        driver.receive(now, Input::Bytes(b"X\n"));
        for answer in &answers {
            while driver.poll_transmit().is_some() {}
            driver.receive(now, Input::Bytes(answer.as_bytes()));
            while let Some(event) = driver.poll_event() {
                readings += u32::from(matches!(event, Event::Reading(_)));
            }
            now = driver.poll_timeout().expect("the next question is due");
            driver.timeout(now);
        }
        assert_eq!(readings, ANSWERS);
        readings
    });
}
