//! CHRocodile on the packet protocol, running free.

use std::time::Duration;

use asphera_chrocodile::wire::packet::{
    Argument, Data, Format, FormatSignal, HEADER_LEN, Message, NumberType,
};
use asphera_chrocodile::{PacketChrocodile, PacketSettings, Trigger};
use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};

use crate::chrocodile::FULL_SCALE_UM;

pub(crate) struct Packets;

impl Bench for Packets {
    fn name(&self) -> &'static str {
        "chrocodile, packets"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = PacketSettings {
            signals: vec![75, 76, 256],
            sample_rate_hz: 100.0,
            trigger: Trigger::Free,
            ready_timeout_ms: 200,
            ..PacketSettings::default()
        };
        Box::new(PacketChrocodile::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Server { model, is_streaming: false, exposures: 0, condition: Condition::Good })
    }

    fn restart_closes(&self) -> bool {
        true
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        match fault {
            Fault::BadChecksum => Absent("the protocol has no checksum"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::LateAnswer => Absent("it sends by itself"),
            Fault::Repeated => Absent("TCP delivers no byte twice"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Saturated => Marks(&[Mark::Flagged(Flags::SATURATED)]),
            Fault::Unplugged => Marks(&[
                Mark::Discarded,
                Mark::Fault("check that the port is that of packets, 7891"),
            ]),
            // The rest of the packet is taken from the next one.
            Fault::HalfFrame => Marks(&[
                Mark::Discarded,
                Mark::Fault("bytes that are no packet"),
                Mark::Fault("it did not come, and is asked for"),
            ]),
            Fault::Silent => Marks(&[
                Mark::Reopened("no data for 200 ms though free-running: check cable and power"),
                Mark::Reopened("no answer to STO within 200 ms, asked 2 times: check cable"),
            ]),
            Fault::Garbage => Marks(&[Mark::Discarded, Mark::Fault("bytes that are no packet")]),
            Fault::WrongDevice => Marks(&[
                Mark::Discarded,
                Mark::Fault("bytes that are no packet, 50545448h where a packet begins"),
                Mark::Reopened("no answer to STO within 200 ms, asked 2 times: check cable"),
            ]),
            Fault::ClockJump => Marks(&[Mark::Reopened("no data for 3600000 ms")]),
            Fault::Slow | Fault::Burst | Fault::Restart => Marks(&[]),
        }
    }
}

struct Server {
    model: Model,
    is_streaming: bool,
    exposures: u32,
    condition: Condition,
}

fn format() -> Format {
    let signal = |id, number| FormatSignal { number, points: 1, first_point: 0, id };
    let signals = vec![
        signal(75, NumberType::U16),
        signal(76, NumberType::U16),
        signal(256, NumberType::F32),
    ];
    Format { stream: 1, counter: 1, sample_rate_hz: 100.0, signals }
}

impl Device for Server {
    fn opened(&mut self) {
        self.is_streaming = false;
    }

    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        let Output::Bytes(sent) = parcel else { return Vec::new() };
        if self.model == Model::Stranger {
            return vec![Sent::answer("HTTP/1.1 400 Bad Request\r\n\r\n")];
        }
        let Some(message) = Message::decode(&sent[HEADER_LEN..]) else { return Vec::new() };
        let name = message.name.to_string();
        match name.as_str() {
            "STA" => self.is_streaming = true,
            "STO" => self.is_streaming = false,
            _ => {}
        }
        let arguments = match name.as_str() {
            "SCA" => vec![Argument::Int(FULL_SCALE_UM as i32)],
            _ => message.arguments.clone(),
        };
        let mut bytes = Vec::new();
        Message { arguments, ..message }.encode(&mut bytes);
        if name == "SODX" {
            format().encode(&mut bytes);
        }
        vec![Sent::answer(bytes)]
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, now: Nanos) -> Vec<Sent> {
        if !self.is_streaming {
            return Vec::new();
        }
        self.exposures += 1;
        let um = match self.condition {
            Condition::OutOfRange => 5000.0,
            // Steps that single precision holds.
            _ => 1000.0 + f64::from(self.exposures % 4000) * 0.25,
        };
        let flags = if self.condition == Condition::Saturated { 1.0 } else { 0.0 };
        let Format { stream, counter, signals, .. } = format();
        let mut sample = Vec::new();
        for (signal, value) in signals.iter().zip([f64::from(self.exposures % 65_536), flags, um]) {
            signal.number.write(value, &mut sample);
        }
        let time = u64::from(now.as_nanos() as u32);
        let mut bytes = Vec::new();
        Data { stream, counter, time, rows: 1, samples: &sample }.encode(&mut bytes);
        match self.condition {
            Condition::Good => vec![Sent::good(bytes, vec![Some(um / 1000.0)])],
            _ => vec![Sent::bad(bytes)],
        }
    }

    fn restart(&mut self) -> Vec<Sent> {
        (self.is_streaming, self.exposures) = (false, 0);
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
