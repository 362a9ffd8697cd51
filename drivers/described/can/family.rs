//! The settings of a device on a bus, as a configuration has them: `frame = "can"`.

use asphera_link::{
    CanFrame, CanId, Carries, Channel, DeviceClock, DeviceSettings, Driver, FdFlags, Problem,
};
use asphera_settings::Section;

use super::{BitOrder, CanField, CanGauge, CanPoll, CanSettings, Signal, SignalForm};
use crate::family::{bytes, meaning, optional};
use crate::field::{Place, Role};
use crate::number::Form;

/// Reads the table `settings`; `None`: too little is there to go on, and the table says so.
pub(crate) fn read(table: &Section<'_>) -> Option<CanSettings> {
    // The word that led here.
    table.has("frame");
    let id = identifier(table);
    let mask = table.or("mask", u32::MAX);
    let has_mask = table.has("mask");
    let fd = table.or("fd", false);
    let length = table.get("length");
    let fields: Vec<Option<CanField>> = table.array("field").iter().map(field).collect();
    let fields: Option<Vec<CanField>> = fields.into_iter().collect();
    if fields.as_ref().is_some_and(Vec::is_empty) {
        table.problem("field", "a table [[field]] for each number", "nothing");
    }
    let poll = optional(table, "poll", poll);
    let [on_connect, on_start, on_stop] = ["on_connect", "on_start", "on_stop"].map(|key| {
        let frames: Vec<Option<CanFrame>> = table.array(key).iter().map(whole_frame).collect();
        frames.into_iter().collect::<Option<Vec<CanFrame>>>()
    });
    let gap_ms = table.or("gap_ms", 0);
    let (id, fields) = (id?, fields?);
    let every = match id {
        CanId::Standard(_) => 0x7FF,
        CanId::Extended(_) => 0x1FFF_FFFF,
    };
    (!fields.is_empty()).then_some(CanSettings {
        id,
        mask: if has_mask { mask } else { every },
        fd,
        length,
        fields,
        poll: poll?,
        on_connect: on_connect?,
        on_start: on_start?,
        on_stop: on_stop?,
        gap_ms,
    })
}

/// Keys `id` and `extended`.
fn identifier(table: &Section<'_>) -> Option<CanId> {
    let extended = table.or("extended", false);
    let id: u32 = table.required("id")?;
    let found = match extended {
        true if id <= 0x1FFF_FFFF => Some(CanId::Extended(id)),
        true => None,
        false => u16::try_from(id).ok().filter(|id| *id <= 0x7FF).map(CanId::Standard),
    };
    if found.is_none() {
        let expected = match extended {
            true => "an identifier of 29 bits, 0 to 0x1FFFFFFF",
            false => "an identifier of 11 bits, 0 to 0x7FF; or extended = true",
        };
        table.problem("id", expected, format!("{id:#X}"));
    }
    found
}

fn field(table: &Section<'_>) -> Option<CanField> {
    let start_bit: Option<u16> = table.required("start_bit");
    let bits: Option<u8> = table.required("bits");
    let order =
        table.required_word("order", &[("little", BitOrder::Little), ("big", BitOrder::Big)]);
    let forms = [
        ("unsigned", SignalForm::Unsigned),
        ("signed", SignalForm::Signed),
        ("f32", SignalForm::Single),
        ("f64", SignalForm::Double),
    ];
    let form = table.word("form", SignalForm::Unsigned, &forms);
    let meaning = meaning(table, Some(Place::At(0)), Form::Decimal);
    table.finish();
    let signal = Signal { start_bit: start_bit?, bits: bits?, order: order?, form };
    Some(CanField { signal, meaning: meaning? })
}

fn poll(table: &Section<'_>) -> Option<CanPoll> {
    let ask = frame(table);
    let timeout_ms: u32 = table.or("timeout_ms", 500);
    let interval_ms = table.or("interval_ms", 100);
    let late_limit_ms = table.or("late_limit_ms", timeout_ms.saturating_mul(2).min(600_000));
    Some(CanPoll { ask: ask?, interval_ms, timeout_ms, late_limit_ms })
}

fn whole_frame(table: &Section<'_>) -> Option<CanFrame> {
    let frame = frame(table);
    table.finish();
    frame
}

/// A frame to send: `id`, `extended`, and `data` or `remote`; of CAN FD `fd`, `bit_rate_switch`.
fn frame(table: &Section<'_>) -> Option<CanFrame> {
    let id = identifier(table);
    let fd = table.or("fd", false);
    let bit_rate_switch = table.or("bit_rate_switch", false);
    if bit_rate_switch && !fd {
        table.problem("bit_rate_switch", "fd = true beside it", "a classic frame");
        return None;
    }
    if table.has("remote") {
        let length: usize = table.required("remote")?;
        if table.has("data") || fd {
            let found = "data, or fd = true";
            table.problem("remote", "neither data nor fd: a remote frame is classic", found);
            table.get::<String>("data");
            return None;
        }
        let wrong = |error| table.problem("remote", "a length of 0 to 8", error);
        return CanFrame::remote_frame(id?, length).map_err(wrong).ok();
    }
    let data = if table.has("data") { bytes(table, "data")? } else { Vec::new() };
    let frame = match fd {
        true => {
            let flags = FdFlags { bit_rate_switch, error_passive: false };
            CanFrame::fd_frame(id?, &data, flags)
        }
        false => CanFrame::data_frame(id?, &data),
    };
    let wrong = |error| table.problem("data", "at most 8 bytes, or a length of CAN FD", error);
    frame.map_err(wrong).ok()
}

impl DeviceSettings for CanSettings {
    fn problems(&self) -> Vec<Problem> {
        CanSettings::problems(self)
    }

    fn carries(&self) -> Option<Carries> {
        Some(Carries::CanFrames)
    }

    fn channels(&self) -> Vec<Channel> {
        CanSettings::channels(self)
    }

    fn count_cycle(&self) -> Result<u32, &'static str> {
        let modulus = self.fields.iter().find_map(|field| match field.meaning.role {
            Role::Count { modulus, .. } => Some(modulus),
            _ => None,
        });
        modulus.ok_or("it has no field with the role count")
    }

    fn clock(&self) -> Option<DeviceClock> {
        let field = self.fields.iter().find(|field| field.meaning.role == Role::DeviceTime)?;
        if field.signal.form != SignalForm::Unsigned {
            return Some(DeviceClock::default());
        }
        Some(DeviceClock::counter(field.meaning.scale, field.signal.bits.into()))
    }

    fn needs_fd(&self) -> bool {
        let frames = self.on_connect.iter().chain(&self.on_start).chain(&self.on_stop);
        let sent = frames.copied().chain(self.poll.map(|poll| poll.ask));
        self.fd || sent.into_iter().any(|frame| frame.fd().is_some())
    }

    fn driver(&self) -> Result<Box<dyn Driver>, Vec<Problem>> {
        Ok(Box::new(CanGauge::new(self.clone())?))
    }
}
