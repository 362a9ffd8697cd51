//! What the sensor sees in one exposure.

use asphera_chrocodile::wire::{Axis, Mode, Part, Quantity};

/// What the sensor sees in one exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Number of the exposure; sent modulo 65536.
    pub exposure_count: u64,
    /// Start of the exposure on the device's clock in ns; sent modulo 2³².
    pub start_ns: u64,
    /// Encoders X, Y, Z, U, V, the same at the start and at the end of the exposure.
    pub encoder: [i32; 5],
    /// Distance in µm, or `None` where there is no peak: distance and intensity are then sent as 0.
    pub distance_um: Option<f64>,
    /// Height of the peak.
    pub intensity: f64,
    /// Temperature of the device in °C.
    pub temperature_c: f64,
    /// Exposure flags as the device sends them: bit 0 saturation, 1 trigger lost, 2 delayed.
    pub flags: u16,
}

impl Sample {
    /// The value a telegram holds for a quantity, in the manual's unit. There is one peak; the
    /// numbers of any other, every thickness, and what is not modelled are 0.
    pub fn value(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::StartTime => (self.start_ns % (1 << 32)) as f64,
            Quantity::EncoderStart(axis) | Quantity::EncoderStop(axis) => {
                self.encoder[Axis::ALL.iter().take_while(|&&other| other != axis).count()].into()
            }
            Quantity::ExposureCount | Quantity::SampleCounter => {
                (self.exposure_count % (1 << 16)) as f64
            }
            Quantity::ExposureFlags => self.flags.into(),
            Quantity::Temperature => self.temperature_c,
            Quantity::GlobalIntensity => self.intensity,
            Quantity::Peak { mode: Mode::Distance, number: 0, part } => match part {
                Part::Value => self.distance_um.unwrap_or(0.0),
                Part::Intensity => self.distance_um.map_or(0.0, |_| self.intensity),
                Part::Saturation | Part::Position | Part::Median | Part::Width => 0.0,
            },
            Quantity::Peak { .. } => 0.0,
        }
    }
}

impl Default for Sample {
    fn default() -> Sample {
        Sample {
            exposure_count: 0,
            start_ns: 0,
            encoder: [0; 5],
            distance_um: Some(1000.0),
            intensity: 100.0,
            temperature_c: 25.0,
            flags: 0,
        }
    }
}
