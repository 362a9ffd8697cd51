//! A device that says yes to everything, and data whose truth is known.

use asphera_chrocodile::wire::Signal;
use asphera_chrocodile::wire::packet::{
    Argument, Data, Format, FormatSignal, HEADER_LEN, Message, NumberType,
};
use asphera_chrocodile::{PacketChrocodile, PacketSettings};
use asphera_link::{Command, Driver as _, Event, Input, Nanos, Output, Reading};

/// Full scale of the probe in µm.
pub(crate) const FULL_SCALE_UM: f64 = 2000.0;

/// The format of signals, all of them with the types of the dollar protocol.
pub(crate) fn format(signals: &[u16], counter: i32, points: u16) -> Format {
    let signal = |&id: &u16| {
        let code = usize::from(Signal::from_id(id).unwrap().value_type.dtf_code());
        let points = if id & 0x0100 == 0 { 1 } else { points };
        FormatSignal { number: NumberType::ALL[code], points, first_point: 0, id }
    };
    let signals = signals.iter().map(signal).collect();
    Format { stream: 1, counter, sample_rate_hz: 1000.0, signals }
}

pub(crate) fn bytes_of(format: &Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    format.encode(&mut bytes);
    bytes
}

/// The answer to a command; that to `SODX` is followed by the format.
pub(crate) fn answer(sent: &[u8], format: &Format) -> Vec<u8> {
    let message = Message::decode(&sent[HEADER_LEN..]).unwrap();
    let arguments = match message.name.to_string().as_str() {
        "SCA" => vec![Argument::Int(FULL_SCALE_UM as i32)],
        _ => message.arguments.clone(),
    };
    let mut bytes = Vec::new();
    Message { arguments, ..message.clone() }.encode(&mut bytes);
    if message.name.to_string() == "SODX" {
        format.encode(&mut bytes);
    }
    bytes
}

/// Answers all that the driver sends.
pub(crate) fn converse(driver: &mut PacketChrocodile, now: Nanos, format: &Format) {
    while let Some(Output::Bytes(sent)) = driver.poll_transmit() {
        driver.receive(now, Input::Bytes(&answer(&sent, format)));
    }
}

pub(crate) fn events(driver: &mut PacketChrocodile) -> Vec<Event> {
    std::iter::from_fn(|| driver.poll_event()).collect()
}

/// Readings, and bytes passed over.
pub(crate) fn outcome(driver: &mut PacketChrocodile) -> (Vec<Reading>, u64) {
    let (mut readings, mut discarded) = (Vec::new(), 0);
    for event in events(driver) {
        match event {
            Event::Reading(reading) => readings.push(reading),
            Event::Discarded { bytes } => discarded += bytes,
            _ => {}
        }
    }
    (readings, discarded)
}

/// A driver that streams since time 0, its events drained.
pub(crate) fn streaming(settings: PacketSettings, format: &Format) -> PacketChrocodile {
    let mut driver = PacketChrocodile::new(settings).unwrap();
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    converse(&mut driver, Nanos::ZERO, format);
    assert_eq!(events(&mut driver), [Event::Online, Event::Ready]);
    driver
}

/// A packet of samples whose signals have the values that `value` gives for sample, identifier and point, as sent.
pub(crate) fn data(
    format: &Format,
    samples: std::ops::Range<u32>,
    value: impl Fn(u32, u16, u16) -> f64,
) -> Vec<u8> {
    let rows = samples.len();
    let mut bytes = Vec::new();
    for sample in samples {
        for signal in format.signals.iter().filter(|signal| !signal.is_of_points()) {
            signal.number.write(value(sample, signal.id, 0), &mut bytes);
        }
        let of_points: Vec<_> =
            format.signals.iter().filter(|signal| signal.is_of_points()).collect();
        for point in 0..of_points.first().map_or(0, |signal| signal.points) {
            for signal in &of_points {
                signal.number.write(value(sample, signal.id, point), &mut bytes);
            }
        }
    }
    let mut packet = Vec::new();
    let Format { stream, counter, .. } = *format;
    Data { stream, counter, time: 5 << 32, rows, samples: &bytes }.encode(&mut packet);
    packet
}
