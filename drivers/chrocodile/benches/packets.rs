//! How fast packets become readings, from bytes to drained events.

use asphera_chrocodile::wire::Signal;
use asphera_chrocodile::wire::packet::{
    Argument, Data, Format, FormatSignal, HEADER_LEN, MAX_LEN, Message, NumberType,
};
use asphera_chrocodile::{PacketChrocodile, PacketSettings};
use asphera_link::{Command, Driver, Event, Input, Nanos, Output};
use divan::counter::{BytesCount, ItemsCount};

/// Samples of a point, and points of a line, about as many.
const SAMPLES: u32 = 200_000;
const LINE: u16 = 192;

fn main() {
    divan::main();
}

/// Samples of one point, so many bytes at a time, with the default signals: 18 bytes each.
#[divan::bench(args = [1460, 65_536])]
fn points(bencher: divan::Bencher<'_, '_>, chunk: usize) {
    run(bencher, &PacketSettings::default(), 1, SAMPLES, chunk);
}

/// Distances of a line of 192 points, 16 bits each; items are points.
#[divan::bench(args = [1460, 65_536])]
fn line(bencher: divan::Bencher<'_, '_>, chunk: usize) {
    let settings = PacketSettings {
        signals: vec![75, 65, 16640],
        pitch_um: Some(5.0),
        ..PacketSettings::default()
    };
    run(bencher, &settings, LINE, SAMPLES / u32::from(LINE), chunk);
}

fn run(
    bencher: divan::Bencher<'_, '_>,
    settings: &PacketSettings,
    points: u16,
    samples: u32,
    chunk: usize,
) {
    let format = format(&settings.signals, points);
    let stream = stream(&format, samples);
    bencher
        .counter(ItemsCount::new(samples * u32::from(points)))
        .counter(BytesCount::new(stream.len()))
        .with_inputs(|| driver(settings.clone(), &format))
        .bench_values(|mut driver| {
            let mut readings = 0;
            for bytes in stream.chunks(chunk) {
                driver.receive(Nanos::from_millis(1), Input::Bytes(bytes));
                while let Some(event) = driver.poll_event() {
                    readings += u32::from(matches!(event, Event::Reading(_)));
                }
            }
            assert_eq!(readings, samples);
        });
}

fn format(signals: &[u16], points: u16) -> Format {
    let signal = |&id: &u16| {
        let code = Signal::from_id(id).expect("supported signals").value_type.dtf_code();
        let points = if id & 0x0100 == 0 { 1 } else { points };
        FormatSignal { number: NumberType::ALL[usize::from(code)], points, first_point: 0, id }
    };
    let signals = signals.iter().map(signal).collect();
    Format { stream: 1, counter: 1, sample_rate_hz: 1000.0, signals }
}

/// Packets as long as the protocol lets them be.
fn stream(format: &Format, samples: u32) -> Vec<u8> {
    let layout = format.layout().expect("a format as devices send it");
    let rows = (MAX_LEN - 2 * HEADER_LEN) / layout.sample_len();
    let (mut stream, mut packet) = (Vec::new(), Vec::new());
    for sample in 0..samples {
        for (_, signal) in &layout.globals {
            let value = if signal.id == 76 { 0.0 } else { f64::from(sample % 65_536) };
            signal.number.write(value, &mut packet);
        }
        for point in 0..layout.points {
            for (_, signal) in &layout.of_points {
                let value = 1000.0 + 10.0 * (f64::from(sample) + point as f64 * 1e-3).sin();
                signal.number.write(value, &mut packet);
            }
        }
        let waiting = packet.len() / layout.sample_len();
        if waiting == rows || sample + 1 == samples {
            let data = Data { stream: 1, counter: 1, time: 0, rows: waiting, samples: &packet };
            data.encode(&mut stream);
            packet.clear();
        }
    }
    stream
}

/// A driver that streams.
fn driver(settings: PacketSettings, format: &Format) -> PacketChrocodile {
    let settings = PacketSettings { scale_um: Some(3000.0), ..settings };
    let mut driver = PacketChrocodile::new(settings).expect("usable settings");
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    while let Some(output) = driver.poll_transmit() {
        let Output::Bytes(mut answer) = output else { continue };
        let sent = Message::decode(&answer[HEADER_LEN..]).expect("a command");
        if matches!(sent.arguments[..], [Argument::Int(_), _, ..]) {
            format.encode(&mut answer);
        }
        driver.receive(Nanos::ZERO, Input::Bytes(&answer));
    }
    while driver.poll_event().is_some() {}
    driver
}
