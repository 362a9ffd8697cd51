//! Decoding on one core: bytes a second of columns, patterns and records, and readings a second beside them.
//!
//! Made anew each time: 20,000 frames, received by 4096 bytes.

use asphera_described::{
    Algorithm, ByteOrder, Checksum, Described, Digits, Field, Form, Framing, Layout, Pattern,
    Place, Settings,
};
use asphera_link::{Driver as _, Event, Input, Nanos, Unit};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

const FRAMES: u32 = 20_000;

fn main() {
    divan::main();
}

fn run(bencher: Bencher<'_, '_>, settings: Settings, bytes: Vec<u8>) {
    let driver = || Described::new(settings.clone()).expect("settings of a benchmark are sound");
    bencher
        .counter(BytesCount::new(bytes.len()))
        .counter(ItemsCount::new(FRAMES))
        .with_inputs(driver)
        .bench_local_values(|mut driver| {
            driver.connected(Nanos::ZERO);
            let mut readings = 0_u32;
            for chunk in bytes.chunks(4096) {
                driver.receive(Nanos::ZERO, Input::Bytes(chunk));
                while let Some(event) = driver.poll_event() {
                    readings += u32::from(matches!(event, Event::Reading(_)));
                }
            }
            assert!(readings >= FRAMES - 1, "{readings}");
            readings
        });
}

fn height_nm(index: u32) -> i32 {
    (index.wrapping_mul(2_654_435_761) >> 12) as i32 - (1 << 19)
}

/// `17,-0.123456,0` and CR LF.
#[divan::bench]
fn columns(bencher: Bencher<'_, '_>) {
    let line = |i: u32| format!("{i},{:.6},0\r\n", f64::from(height_nm(i)) * 1e-6);
    let settings = Settings {
        layout: Layout::Columns { separator: Some(b','), columns: Some(3) },
        fields: vec![Field::channel("z", Place::Column(2), Unit::Millimetre)],
        ..Settings::default()
    };
    run(bencher, settings, (0..FRAMES).map(line).collect::<String>().into_bytes());
}

/// `00NMG-09.9999` and CR LF.
#[divan::bench]
fn pattern(bencher: Bencher<'_, '_>) {
    let line = |i: u32| format!("00NMG{:+08.4}\r\n", f64::from(height_nm(i)) * 1e-5);
    let pattern = Pattern::new(r"00[A-Z]{3}(?<mm>[+-]\d\d\.\d{4})").expect("it is a pattern");
    let settings = Settings {
        layout: Layout::Pattern(pattern),
        fields: vec![Field::channel("z", Place::Group("mm".to_owned()), Unit::Millimetre)],
        ..Settings::default()
    };
    run(bencher, settings, (0..FRAMES).map(line).collect::<String>().into_bytes());
}

/// Two bytes of beginning, four of value, two of CRC.
#[divan::bench]
fn records(bencher: Bencher<'_, '_>) {
    let checksum = Checksum {
        algorithm: Algorithm::Crc16Modbus,
        digits: Digits::Binary(ByteOrder::Little),
        skip_first: 0,
        skip_last: 0,
    };
    let record = |i: u32| {
        let mut record = vec![0xAA, 0x55];
        record.extend(height_nm(i).to_be_bytes());
        record.extend(checksum.compute(&record).unwrap_or_default());
        record
    };
    let settings = Settings {
        framing: Framing::Records { begin: vec![0xAA, 0x55], length: 8 },
        checksum: Some(checksum),
        layout: Layout::Bytes,
        fields: vec![Field {
            form: Form::Signed(4, ByteOrder::Big),
            scale: 1e-6,
            ..Field::channel("z", Place::At(2), Unit::Millimetre)
        }],
        ..Settings::default()
    };
    run(bencher, settings, (0..FRAMES).flat_map(record).collect());
}
