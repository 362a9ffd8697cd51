//! From the bytes of a telegram or a sample to the parts of a reading.

use asphera_link::{Count, Flags, Nanos, Values};

use crate::wire::packet::NumberType;
use crate::wire::{Layout, Part, Quantity, Signal, ValueType};

/// Relative excess over the full scale that the rounding to single precision may cause.
const FULL_SCALE_ROUNDING: f64 = 1e-6;

/// Nanoseconds after which the device's start time wraps.
const WRAP_NS: u64 = 1 << 32;

/// Number format of a protocol.
pub(crate) trait Number: Copy {
    /// The number at the start of `bytes`, exactly as sent.
    fn read(self, bytes: &[u8]) -> f64;
}

impl Number for ValueType {
    #[inline]
    fn read(self, bytes: &[u8]) -> f64 {
        ValueType::read(self, bytes)
    }
}

impl Number for NumberType {
    #[inline]
    fn read(self, bytes: &[u8]) -> f64 {
        NumberType::read(self, bytes)
    }
}

/// How to read each number of a telegram or a sample, in the order of the channels.
#[derive(Debug)]
pub(crate) struct Plan<N = ValueType> {
    fields: Vec<Field<N>>,
    full_scale_um: f64,
    intensity_min: f64,
}

#[derive(Debug)]
struct Field<N> {
    offset: usize,
    number: N,
    role: Role,
}

#[derive(Debug)]
enum Role {
    Count,
    ExposureFlags,
    StartTime,
    /// `value = number * multiplier / divisor`, in the unit of the channel.
    Channel {
        multiplier: f64,
        divisor: f64,
        peak: Option<PeakRole>,
    },
}

#[derive(Clone, Copy, Debug)]
struct PeakRole {
    /// Whether this is the first of the selected peaks, which decides the flags of the reading.
    first: bool,
    kind: PeakKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PeakKind {
    Distance,
    Thickness,
    Intensity,
    Other,
}

/// What a telegram says.
#[derive(Debug)]
pub(crate) struct Decoded {
    /// The exposure count.
    pub(crate) count: Option<Count>,
    /// The start time in ns, 0 to 2³² - 1.
    pub(crate) start_ns: Option<u32>,
    /// One value per channel.
    pub(crate) values: Values,
    /// What the telegram says is wrong with it.
    pub(crate) flags: Flags,
}

impl Plan {
    /// For telegrams of this layout from a probe of this full scale.
    pub(crate) fn new(layout: &Layout, full_scale_um: f64, intensity_min: f64) -> Plan {
        let fields: Vec<_> = layout
            .fields()
            .iter()
            .map(|(offset, signal)| (*offset, signal.value_type, *signal))
            .collect();
        Plan::of_fields(&fields, full_scale_um, intensity_min)
    }
}

impl<N: Number> Plan<N> {
    /// For signals at these offsets, in the order of the channels.
    pub(crate) fn of_fields(
        fields: &[(usize, N, Signal)],
        full_scale_um: f64,
        intensity_min: f64,
    ) -> Plan<N> {
        let first_peak = fields.iter().filter_map(|(_, _, signal)| peak_number(signal)).min();
        let field = |&(offset, number, ref signal): &(usize, N, Signal)| Field {
            offset,
            number,
            role: role(signal, full_scale_um, first_peak),
        };
        Plan { fields: fields.iter().map(field).collect(), full_scale_um, intensity_min }
    }

    /// Reads one telegram or sample, which reaches over every field.
    ///
    /// 0 as the length or the intensity of a peak means that there was no peak ("CHRocodile C"
    /// operation manual p. 61, command THR): the value is missing, and if it was the first of the
    /// selected peaks, the reading has no signal. Further peaks may be missing without a flag.
    #[inline]
    pub(crate) fn decode(&self, telegram: &[u8]) -> Decoded {
        let mut decoded =
            Decoded { count: None, start_ns: None, values: Values::new(), flags: Flags::empty() };
        for field in &self.fields {
            let number = field.number.read(&telegram[field.offset..]);
            match field.role {
                Role::Count => decoded.count = Some(exposure_count(number as u16)),
                Role::StartTime => decoded.start_ns = Some(number as u32),
                Role::ExposureFlags => decoded.flags |= exposure_flags(number as u16),
                Role::Channel { multiplier, divisor, peak } => {
                    let value = number * multiplier / divisor;
                    if !value.is_finite() {
                        decoded.flags |= Flags::NOT_FINITE;
                    }
                    let missing = peak.is_some_and(|peak| peak.kind.is_missing(value));
                    if let Some(peak) = peak.filter(|peak| peak.first) {
                        decoded.flags |= self.peak_flags(peak.kind, value);
                    }
                    decoded.values.push((!missing).then_some(value));
                }
            }
        }
        if decoded.flags.contains(Flags::NO_SIGNAL) {
            self.blank_first_peak(&mut decoded);
        }
        decoded
    }

    fn peak_flags(&self, kind: PeakKind, value: f64) -> Flags {
        if kind.is_missing(value) {
            return Flags::NO_SIGNAL;
        }
        let highest_mm = self.full_scale_um * (1.0 + FULL_SCALE_ROUNDING) / 1000.0;
        match kind {
            PeakKind::Intensity if value < self.intensity_min => Flags::WEAK,
            PeakKind::Distance if value < 0.0 || value > highest_mm => Flags::OUT_OF_RANGE,
            _ => Flags::empty(),
        }
    }

    /// Without a signal no length of the first peak is to be believed, even one that is not 0.
    fn blank_first_peak(&self, decoded: &mut Decoded) {
        let peaks = self.fields.iter().filter_map(|field| match field.role {
            Role::Channel { peak, .. } => Some(peak),
            _ => None,
        });
        decoded.values = peaks
            .zip(decoded.values.iter())
            .map(|(peak, value)| value.filter(|_| !peak.is_some_and(PeakRole::is_first_length)))
            .collect();
    }
}

impl PeakKind {
    fn is_missing(self, value: f64) -> bool {
        self != PeakKind::Other && value == 0.0
    }
}

impl PeakRole {
    fn is_first_length(self) -> bool {
        self.first && matches!(self.kind, PeakKind::Distance | PeakKind::Thickness)
    }
}

fn peak_number(signal: &Signal) -> Option<u8> {
    match signal.quantity {
        Quantity::Peak { number, .. } => Some(number),
        _ => None,
    }
}

fn role(signal: &Signal, full_scale_um: f64, first_peak: Option<u8>) -> Role {
    use crate::wire::Mode;

    let peak = match signal.quantity {
        Quantity::ExposureCount => return Role::Count,
        Quantity::ExposureFlags => return Role::ExposureFlags,
        Quantity::StartTime => return Role::StartTime,
        Quantity::Peak { mode, number, part } => Some(PeakRole {
            first: Some(number) == first_peak,
            kind: match (mode, part) {
                (Mode::Distance, Part::Value) => PeakKind::Distance,
                (Mode::Thickness, Part::Value) => PeakKind::Thickness,
                (_, Part::Intensity) => PeakKind::Intensity,
                _ => PeakKind::Other,
            },
        }),
        _ => None,
    };
    let (multiplier, divisor) = signal.scale(full_scale_um);
    let um_per_unit = if signal.is_length() { 1000.0 } else { 1.0 };
    Role::Channel { multiplier, divisor: divisor * um_per_unit, peak }
}

/// Bit 0 saturation, bit 1 trigger lost, bit 2 delayed (Command Reference, signal 76).
fn exposure_flags(bits: u16) -> Flags {
    let mut flags = Flags::empty();
    flags.set(Flags::SATURATED, bits & 1 != 0);
    flags.set(Flags::TRIGGER_LOST, bits & 2 != 0);
    flags.set(Flags::DELAYED, bits & 4 != 0);
    flags
}

/// The device's 32-bit nanosecond clock, made monotonic.
///
/// It wraps every 4.29 s; the host's clock tells how often it did in a pause. Readings that reach
/// the host more than 2.1 s later or earlier than their neighbours would be taken for the wrong turn.
#[derive(Debug, Default)]
pub(crate) struct DeviceClock {
    last: Option<(u32, Nanos, u64)>,
}

impl DeviceClock {
    /// The time in ns since the first telegram's clock last wrapped.
    pub(crate) fn unwrap(&mut self, start_ns: u32, host: Nanos) -> u64 {
        let time = self.peek(start_ns, host);
        self.last = Some((start_ns, host, time));
        time
    }

    /// As [`DeviceClock::unwrap`], but for a telegram that is not to be believed later.
    pub(crate) fn peek(&self, start_ns: u32, host: Nanos) -> u64 {
        let Some((last_ns, last_host, last_time)) = self.last else { return start_ns.into() };
        let within = u64::from(start_ns.wrapping_sub(last_ns));
        let elapsed = host.as_nanos().saturating_sub(last_host.as_nanos());
        let turns = (elapsed.saturating_sub(within) + WRAP_NS / 2) / WRAP_NS;
        last_time + within + turns * WRAP_NS
    }
}

fn exposure_count(raw: u16) -> Count {
    Count { raw: raw.into(), first: 0, modulus: 1 << 16 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::SYNC;

    fn plan(ids: &[u16]) -> Plan {
        Plan::new(&Layout::new(SYNC, ids).unwrap(), 3320.0, 10.0)
    }

    fn telegram(floats: &[f32]) -> Vec<u8> {
        SYNC.into_iter().chain(floats.iter().flat_map(|float| float.to_le_bytes())).collect()
    }

    #[test]
    fn zero_is_a_gap() {
        let plan = plan(&[256, 257, 264]);
        let decoded = plan.decode(&telegram(&[0.0, 0.0, 0.0]));
        assert_eq!(decoded.flags, Flags::NO_SIGNAL);
        assert_eq!(decoded.values.iter().collect::<Vec<_>>(), [None; 3]);
        let decoded = plan.decode(&telegram(&[1500.0, 20.0, 0.0]));
        assert_eq!(decoded.flags, Flags::empty());
        assert_eq!(decoded.values.iter().collect::<Vec<_>>(), [Some(1.5), Some(20.0), None]);
        let decoded = plan.decode(&telegram(&[1500.0, 0.0, 1.0]));
        assert_eq!(decoded.flags, Flags::NO_SIGNAL);
        assert_eq!(decoded.values.iter().collect::<Vec<_>>(), [None, None, Some(0.001)]);
    }

    #[test]
    fn weak_out_of_range_and_not_finite() {
        let plan = plan(&[256, 257]);
        for (floats, flags) in [
            ([1.0, 9.5], Flags::WEAK),
            ([-1.0, 20.0], Flags::OUT_OF_RANGE),
            ([3320.0, 20.0], Flags::empty()),
            ([3321.0, 20.0], Flags::OUT_OF_RANGE),
            ([f32::NAN, 20.0], Flags::NOT_FINITE),
            ([f32::INFINITY, 20.0], Flags::NOT_FINITE | Flags::OUT_OF_RANGE),
        ] {
            assert_eq!(plan.decode(&telegram(&floats)).flags, flags, "{floats:?}");
        }
    }

    #[test]
    fn device_clock_wraps_and_follows_the_host_over_pauses() {
        let mut clock = DeviceClock::default();
        let host = Nanos::from_nanos;
        assert_eq!(clock.unwrap(4_000_000_000, host(0)), 4_000_000_000);
        assert_eq!(clock.unwrap(0, host(294_967_296)), WRAP_NS);
        assert_eq!(clock.unwrap(1, host(294_967_296)), WRAP_NS + 1, "same receipt");
        let pause = 3 * WRAP_NS + 5;
        assert_eq!(clock.peek(6, host(294_967_296 + pause)), 4 * WRAP_NS + 6);
        assert_eq!(clock.unwrap(6, host(294_967_296 + pause + 1_000_000_000)), 4 * WRAP_NS + 6);
    }
}
