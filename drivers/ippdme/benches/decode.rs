//! Lines of a scan to readings on one core: bytes a second, 100 points a line.

use asphera_ippdme::FAMILY;
use asphera_link::{Event, Input, Motion, Nanos};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const LINES: u32 = 500;
const POINTS_A_LINE: u32 = 100;

fn main() {
    divan::main();
}

#[divan::bench]
fn scan(bencher: Bencher<'_, '_>) {
    let settings = FAMILY
        .parse("cmm", "commands = ['ScanOnLine(0,0,0,100,0,0,0,0,1,0.002)']")
        .expect("settings of a benchmark are sound");
    let line = |line: u32| {
        let point = |k: u32| {
            let x = f64::from(line * POINTS_A_LINE + k) * 0.002;
            format!("{x:.5},{:.5},{:.5}", 10.0 - x, 0.001 * (x * 7.0).sin())
        };
        let points: Vec<String> = (0..POINTS_A_LINE).map(point).collect();
        format!("00006 # {}\r\n", points.join(","))
    };
    let text: Vec<u8> = (0..LINES).flat_map(|index| line(index).into_bytes()).collect();
    let points = LINES * POINTS_A_LINE;
    bencher.counter(BytesCount::new(text.len())).counter(ItemsCount::new(points)).bench_local(
        || {
            let mut driver = settings.driver().expect("settings of a benchmark are sound");
            let now = Nanos::ZERO;
            driver.connected(now);
            for tag in 1..=4 {
                let answer = format!("{tag:05} &\r\n{tag:05} %\r\n");
                driver.receive(now, Input::Bytes(answer.as_bytes()));
            }
            driver.motion(now, &Motion::Run).expect("a program");
            driver.receive(now, Input::Bytes(b"00005 &\r\n00005 %\r\n00006 &\r\n"));
            let mut readings = 0_u32;
            for chunk in text.chunks(4096) {
                driver.receive(now, Input::Bytes(chunk));
                while let Some(event) = driver.poll_event() {
                    readings += u32::from(matches!(event, Event::Reading(_)));
                }
            }
            assert_eq!(readings, points);
            readings
        },
    );
}
