//! Replies to readings on one core: bytes a second, each reply after its question.

use asphera_link::{Event, Input, Nanos};
use asphera_zaber::FAMILY;
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const REPLIES: u32 = 20_000;

fn main() {
    divan::main();
}

#[divan::bench]
fn replies(bencher: Bencher<'_, '_>) {
    let settings = "interval_ms = 1\naxis = [{ name = 'x', microstep_um = 0.1 }, { name = 'y', microstep_um = 0.1 }]";
    let settings = FAMILY.parse("stage", settings).expect("settings of a benchmark are sound");
    let steps = |i: u32| i.wrapping_mul(2_654_435_761) >> 12;
    let replies: Vec<String> = (0..REPLIES)
        .map(|i| format!("@01 0 OK BUSY -- {} {}\r\n", steps(i), steps(i + 1)))
        .collect();
    let bytes: usize = replies.iter().map(String::len).sum();
    bencher.counter(BytesCount::new(bytes)).counter(ItemsCount::new(REPLIES)).bench_local(|| {
        let mut driver = settings.driver().expect("settings of a benchmark are sound");
        let mut now = Nanos::ZERO;
        let mut readings = 0_u32;
        driver.connected(now);
        driver.receive(now, Input::Bytes(b"@01 0 OK IDLE -- 0 0\r\n"));
        for reply in &replies {
            while driver.poll_transmit().is_some() {}
            driver.receive(now, Input::Bytes(reply.as_bytes()));
            while let Some(event) = driver.poll_event() {
                readings += u32::from(matches!(event, Event::Reading(_)));
            }
            now = driver.poll_timeout().expect("the next question is due");
            driver.timeout(now);
        }
        assert_eq!(readings, REPLIES);
        readings
    });
}
