//! From the bytes of a sample to the parts of a reading.

use asphera_link::{Flags, Profile};
use thiserror::Error;

use crate::decode::{Decoded, Plan};
use crate::packets::PacketSettings;
use crate::packets::settings::distance_of;
use crate::wire::packet::{Format, FormatError, NumberType, SampleLayout};
use crate::wire::{Encoding, Part, Quantity, Signal};

/// Relative excess over the full scale that the rounding to single precision may cause.
const FULL_SCALE_ROUNDING: f64 = 1e-6;

/// Why samples of a format give no readings.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub(super) enum UnusableFormat {
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error("it has no signal {0}: this device may not measure it, so leave it out of signals")]
    Absent(u16),
    #[error("signal {id} comes as {found:?}, which its identifier does not say")]
    NumberType { id: u16, found: NumberType },
    #[error("it has {found} points, and point is {point}")]
    Point { point: u16, found: usize },
}

/// How to read the samples of a format.
#[derive(Debug)]
pub(super) struct SamplePlan {
    /// Bytes of a sample.
    pub(super) sample_len: usize,
    plan: Plan<NumberType>,
    line: Option<LinePlan>,
}

/// How to read the points of a sample: number types with offsets in a point, and the factor from number to mm.
#[derive(Debug)]
struct LinePlan {
    start: usize,
    stride: usize,
    first_point: usize,
    pitch_mm: f64,
    distance: (usize, NumberType),
    mm: f64,
    most_mm: f64,
    intensity: Option<(usize, NumberType)>,
    intensity_min: f64,
}

impl SamplePlan {
    /// For samples of this format from a probe of this full scale.
    pub(super) fn new(
        format: &Format,
        settings: &PacketSettings,
        full_scale_um: f64,
    ) -> Result<SamplePlan, UnusableFormat> {
        let layout = format.layout()?;
        let mut fields = Vec::new();
        for signal in settings.signals.iter().filter_map(|&id| Signal::from_id(id).ok()) {
            let (offset, number) = place(&layout, signal, settings)?;
            let is_of_line = matches!(signal.quantity, Quantity::Peak { .. });
            if settings.pitch_um.is_none() || !is_of_line {
                fields.push((offset, number, signal));
            }
        }
        let line = match settings.pitch_um {
            Some(pitch_um) => Some(LinePlan::new(&layout, settings, pitch_um, full_scale_um)?),
            None => None,
        };
        let plan = Plan::of_fields(&fields, full_scale_um, settings.intensity_min);
        Ok(SamplePlan { sample_len: layout.sample_len(), plan, line })
    }

    /// Reads one sample, which has the length of the plan.
    #[inline]
    pub(super) fn decode(&self, sample: &[u8]) -> Decoded {
        let mut decoded = self.plan.decode(sample);
        if let Some(line) = &self.line {
            let profile = line.profile(&sample[line.start..]);
            if profile.valid() == 0 {
                decoded.flags |= Flags::NO_SIGNAL;
            }
            decoded.values.push(Some(profile.valid() as f64));
            decoded.values = std::mem::take(&mut decoded.values).with_profile(profile);
        }
        decoded
    }
}

impl LinePlan {
    fn new(
        layout: &SampleLayout,
        settings: &PacketSettings,
        pitch_um: f64,
        full_scale_um: f64,
    ) -> Result<LinePlan, UnusableFormat> {
        let signals = || settings.signals.iter().filter_map(|&id| Signal::from_id(id).ok());
        let is_intensity = |signal: &Signal| {
            matches!(signal.quantity, Quantity::Peak { part: Part::Intensity, .. })
        };
        let distance = signals().find(|signal| distance_of(*signal).is_some());
        // Settings without problems have one; 256 names what is absent.
        let distance = distance.ok_or(UnusableFormat::Absent(256))?;
        let in_point = |signal: Signal| {
            let (offset, number) = place(layout, signal, settings)?;
            Ok::<_, UnusableFormat>((offset - layout.globals_len, number))
        };
        let (multiplier, divisor) = distance.scale(full_scale_um);
        Ok(LinePlan {
            start: layout.globals_len,
            stride: layout.stride,
            first_point: layout.first_point,
            pitch_mm: pitch_um * 1e-3,
            distance: in_point(distance)?,
            mm: multiplier / divisor / 1000.0,
            most_mm: full_scale_um * (1.0 + FULL_SCALE_ROUNDING) / 1000.0,
            intensity: signals().find(is_intensity).map(in_point).transpose()?,
            intensity_min: settings.intensity_min,
        })
    }

    /// The profile of the points, one after the other. A point is missing without a peak, with a weak one, and beyond the
    /// full scale.
    fn profile(&self, points: &[u8]) -> Profile {
        let (at, number) = self.distance;
        let points = (self.first_point..).zip(points.chunks_exact(self.stride));
        points
            .map(|(index, point)| {
                let z_mm = number.read(&point[at..]) * self.mm;
                let is_measured = z_mm > 0.0 && z_mm <= self.most_mm;
                let is_strong = self.intensity.is_none_or(|(at, number)| {
                    let intensity = number.read(&point[at..]);
                    intensity != 0.0 && intensity >= self.intensity_min
                });
                (is_measured && is_strong).then_some([index as f64 * self.pitch_mm, z_mm])
            })
            .collect()
    }
}

/// Offset in a sample and number type of a signal; of a signal of points that at the point of the settings.
fn place(
    layout: &SampleLayout,
    signal: Signal,
    settings: &PacketSettings,
) -> Result<(usize, NumberType), UnusableFormat> {
    let Some(first) = layout.place(signal.id, 0) else {
        return Err(UnusableFormat::Absent(signal.id));
    };
    let point = usize::from(settings.point.saturating_sub(1));
    let found = layout.points;
    let (offset, number) = match signal.quantity {
        Quantity::Peak { .. } => layout
            .place(signal.id, point)
            .ok_or(UnusableFormat::Point { point: settings.point, found })?,
        _ => first,
    };
    let fits = match (signal.is_length(), signal.encoding) {
        // A length is scaled by the encoding that the identifier says.
        (true, Encoding::Float) => number == NumberType::F32,
        (true, Encoding::Int16) => matches!(number, NumberType::S16 | NumberType::U16),
        (true, Encoding::Int32 | Encoding::Int32Nm) => {
            matches!(number, NumberType::S32 | NumberType::U32)
        }
        // Counts are cyclic: their type says where they begin anew.
        (false, _) if signal.channel().is_none() => number.size() == signal.value_type.size(),
        (false, _) => true,
    };
    if fits {
        Ok((offset, number))
    } else {
        Err(UnusableFormat::NumberType { id: signal.id, found: number })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::packet::FormatSignal;

    fn format(signals: &[(u16, NumberType)], points: u16, first_point: u16) -> Format {
        let signals = signals
            .iter()
            .map(|&(id, number)| {
                let points = if id & 0x0100 == 0 { 1 } else { points };
                FormatSignal { number, points, first_point, id }
            })
            .collect();
        Format { stream: 1, counter: 1, sample_rate_hz: 1000.0, signals }
    }

    fn settings(signals: &[u16]) -> PacketSettings {
        PacketSettings { signals: signals.to_vec(), ..PacketSettings::default() }
    }

    fn floats(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    const FLOATS: [(u16, NumberType); 2] = [(257, NumberType::F32), (256, NumberType::F32)];

    /// The device's order is not that of the channels.
    #[test]
    fn a_reading_is_of_the_point_asked_for() {
        let settings = PacketSettings { point: 2, ..settings(&[256, 257]) };
        let plan = SamplePlan::new(&format(&FLOATS, 2, 0), &settings, 2000.0).unwrap();
        let decoded = plan.decode(&floats(&[10.0, 100.0, 20.0, 200.0]));
        assert_eq!(decoded.values.iter().collect::<Vec<_>>(), [Some(0.2), Some(20.0)]);
        let settings = PacketSettings { point: 3, ..settings };
        let error = SamplePlan::new(&format(&FLOATS, 2, 0), &settings, 2000.0).unwrap_err();
        assert_eq!(error.to_string(), "it has 2 points, and point is 3");
    }

    #[test]
    fn a_line_has_its_points_at_their_places_and_gaps_where_nothing_is() {
        let settings =
            PacketSettings { pitch_um: Some(10.0), intensity_min: 5.0, ..settings(&[256, 257]) };
        let plan = SamplePlan::new(&format(&FLOATS, 6, 4), &settings, 2000.0).unwrap();
        assert_eq!(plan.sample_len, 48);
        let sample = floats(&[
            10.0,
            1000.0,
            10.0,
            0.0,
            4.9,
            900.0,
            0.0,
            900.0,
            10.0,
            2001.0,
            10.0,
            f32::NAN,
        ]);
        let decoded = plan.decode(&sample);
        let profile = decoded.values.profile().unwrap();
        assert_eq!(profile.points_mm(), [Some([0.04, 1.0]), None, None, None, None, None]);
        assert_eq!((decoded.values.get(0), decoded.flags), (Some(1.0), Flags::empty()));
        let decoded = plan.decode(&floats(&[0.0; 12]));
        assert_eq!((decoded.values.get(0), decoded.flags), (Some(0.0), Flags::NO_SIGNAL));
    }

    /// D = d / 2¹⁵ · full scale, and d / 2³¹ · full scale; nm as nm.
    #[test]
    fn integers_are_scaled_by_their_encoding() {
        for (id, number, code, expected_mm) in [
            (0x4100, NumberType::S16, 8192, 0.5),
            (0x4100, NumberType::U16, 8192, 0.5),
            (0xC100, NumberType::S32, 1 << 29, 0.5),
            (0x8100, NumberType::S32, 1_500_000, 1.5),
        ] {
            let mut bytes = Vec::new();
            number.write(f64::from(code), &mut bytes);
            for pitch_um in [None, Some(1.0)] {
                let settings = PacketSettings { pitch_um, ..settings(&[id]) };
                let plan = SamplePlan::new(&format(&[(id, number)], 1, 0), &settings, 2000.0);
                let decoded = plan.unwrap().decode(&bytes);
                let found = match decoded.values.profile() {
                    Some(profile) => profile.points_mm()[0].map(|[_, z_mm]| z_mm),
                    None => decoded.values.get(0),
                };
                assert!((found.unwrap() - expected_mm).abs() < 1e-12, "{id} {found:?}");
            }
        }
    }

    #[test]
    fn formats_without_what_was_asked_for_are_named() {
        let why = |signals: &[(u16, NumberType)], asked: &[u16]| {
            let plan = SamplePlan::new(&format(signals, 1, 0), &settings(asked), 1.0);
            plan.unwrap_err()
        };
        assert_eq!(why(&FLOATS, &[65, 256]), UnusableFormat::Absent(65));
        let found = NumberType::F32;
        let wrong = UnusableFormat::NumberType { id: 16640, found };
        assert_eq!(why(&[(16640, found)], &[16640]), wrong);
        let found = NumberType::U32;
        let wrong = UnusableFormat::NumberType { id: 75, found };
        assert_eq!(why(&[(75, found), FLOATS[0], FLOATS[1]], &[75, 256]), wrong);
    }
}
