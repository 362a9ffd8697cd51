//! The sensor without a port.

use asphera_optoncdt::wire::{MAX_18, TICK_NS, Width, Word, encode_three, encode_two};
use asphera_optoncdt::{Extra, Series, Settings};

/// A sensor as it was set up: series, measuring range and further words of each block.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    series: Series,
    range_mm: f64,
    extras: Vec<Extra>,
}

/// One measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Distance in mm from the start of the measuring range; `None`: no peak.
    pub distance_mm: Option<f64>,
    /// Its number. The counter of the sensor has 18 bits.
    pub count: u64,
    /// Time of the sensor's clock, ns.
    pub clock_ns: u64,
}

impl Sensor {
    /// A sensor whose blocks a driver with these settings reads.
    pub fn new(settings: &Settings) -> Sensor {
        let Settings { series, range_mm, extras, .. } = settings.clone();
        Sensor { series, range_mm, extras }
    }

    /// The distance in mm that is read where this one is measured: words are whole. `None` beyond what a word can say.
    pub fn shown_mm(&self, distance_mm: f64) -> Option<f64> {
        self.series.distance(self.word(Some(distance_mm)), self.range_mm).mm
    }

    /// Bytes of the block of one measurement.
    pub fn block(&self, measurement: Measurement) -> Vec<u8> {
        let distance = self.word(measurement.distance_mm);
        let further = self.extras.iter().flat_map(|extra| self.further(*extra, measurement));
        let words = std::iter::once(distance).chain(further);
        match self.series.width() {
            Width::Two => words.flat_map(encode_two).collect(),
            Width::Three => {
                let word = |(index, value)| encode_three(Word { value, is_first: index == 0 });
                words.enumerate().flat_map(word).collect()
            }
        }
    }

    fn word(&self, distance_mm: Option<f64>) -> u32 {
        self.series.word(distance_mm, self.range_mm)
    }

    /// Words of one extra: ILD1420 manual, pages 65 and 66.
    fn further(&self, extra: Extra, measurement: Measurement) -> Vec<u32> {
        let Measurement { distance_mm, count, clock_ns } = measurement;
        let has_peak = distance_mm.is_some();
        let seen = |word: u32| if has_peak { word } else { 0 };
        match extra {
            Extra::Shutter => vec![seen(EXPOSURE)],
            Extra::Intensity => vec![seen(INTENSITY)],
            Extra::Counter => vec![(count & u64::from(MAX_18)) as u32],
            Extra::Timestamp => {
                let ticks = (clock_ns / TICK_NS) as u32;
                vec![ticks & 0xFFFF, ticks >> 16]
            }
            Extra::State => vec![self.state(distance_mm)],
            Extra::RawDistance => vec![self.word(distance_mm)],
        }
    }

    /// Bits of the state: 2 no peak, 5 before the measuring range, 6 behind it.
    fn state(&self, distance_mm: Option<f64>) -> u32 {
        match distance_mm {
            None => 1 << 2,
            Some(mm) if mm < 0.0 => 1 << 5,
            Some(mm) if mm > self.range_mm => 1 << 6,
            Some(_) => 0,
        }
    }
}

/// 100 µs in steps of 0.1 µs.
const EXPOSURE: u32 = 1000;
/// 60 %, where 65472 is 100 %.
const INTENSITY: u32 = 39_283;
