//! Frames of a described device on a CAN bus, made of the signals by which they are read.

use asphera_described::{CanField, CanSettings, Role, SignalForm};
use asphera_link::{CanFrame, FD_LENGTHS, FdFlags};

use crate::frame::Moment;

/// Makes the frames of one device.
#[derive(Clone, Debug)]
pub(crate) struct Signals {
    settings: CanSettings,
    /// Bytes of a frame.
    length: usize,
}

impl Signals {
    /// Frames by these settings, which have no problems.
    pub(crate) fn new(settings: CanSettings) -> Signals {
        let ends = settings.fields.iter().map(|field| field.signal.end_byte());
        let needed = ends.max().unwrap_or(0);
        let fitting = FD_LENGTHS.into_iter().find(|length| *length >= needed);
        let length = settings.length.or(fitting).unwrap_or(needed);
        Signals { settings, length }
    }

    /// The settings they are made of.
    pub(crate) fn settings(&self) -> &CanSettings {
        &self.settings
    }

    /// The value that is read where this one is sent: whole numbers are rounded, and no number has more than its bits.
    pub(crate) fn shown(&self, channel: usize, value: f64) -> f64 {
        let Some(CanField { signal, meaning }) = self.channel(channel) else { return value };
        let mut data = [0; 64];
        signal.write(signal.raw_of((value - meaning.offset) / meaning.scale), &mut data);
        signal.read(&data).map_or(value, |number| number * meaning.scale + meaning.offset)
    }

    /// The range that the device says it measures in.
    pub(crate) fn range(&self, channel: usize) -> Option<(f64, f64)> {
        self.channel(channel)?.meaning.valid_range
    }

    fn channel(&self, channel: usize) -> Option<&CanField> {
        self.settings.fields.iter().filter(|field| field.meaning.role == Role::Channel).nth(channel)
    }

    /// One frame; `None` where no frame has its length. Bits that no signal has are 0.
    pub(crate) fn frame(&self, moment: &Moment<'_>) -> Option<CanFrame> {
        let mut data = [0; 64];
        let mut values = moment.values.iter().copied();
        for CanField { signal, meaning } in &self.settings.fields {
            let number = match &meaning.role {
                Role::Channel => (values.next().unwrap_or(0.0) - meaning.offset) / meaning.scale,
                Role::Status { good } => {
                    good.first().and_then(|good| good.parse().ok()).unwrap_or(0.0)
                }
                Role::Bits => 0.0,
                Role::Count { first, modulus } => {
                    (u64::from(*first) + moment.trigger % u64::from((*modulus).max(1))) as f64
                }
                Role::DeviceTime => {
                    let steps = (moment.clock_s - meaning.offset) / meaning.scale;
                    match signal.form {
                        // A clock of few bits begins again.
                        SignalForm::Unsigned => {
                            steps.floor().rem_euclid(2_f64.powi(i32::from(signal.bits)))
                        }
                        SignalForm::Signed => steps.floor(),
                        SignalForm::Single | SignalForm::Double => steps,
                    }
                }
            };
            signal.write(signal.raw_of(number), &mut data);
        }
        let data = data.get(..self.length)?;
        let flags = FdFlags { bit_rate_switch: true, error_passive: false };
        match self.settings.fd {
            true => CanFrame::fd_frame(self.settings.id, data, flags).ok(),
            false => CanFrame::data_frame(self.settings.id, data).ok(),
        }
    }
}
