//! What a word of a series is worth.

use asphera_link::Flags;

use crate::wire::Width;

/// Series of sensors that share a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Series {
    /// ILD1220, ILD1320, ILD1420, ILD2300 without a master value: (1.02 x / 65520 − 0.01) MR.
    Plain,
    /// ILD1420, ILD2300 with a master value: (1.02 x / 65520 − 0.51) MR.
    Mastered,
    /// ILD1750, ILD1900: (x − 98232) / 65536 MR.
    Wide,
    /// ILD1402, ILD1700 (14 bits): (1.02 x / 16368 − 0.01) MR.
    Legacy,
}

/// A distance word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Distance in mm, from the start of the measuring range; `None`: none.
    pub mm: Option<f64>,
    /// What the sensor says of it.
    pub flags: Flags,
    /// Trouble of the sensor itself, in words.
    pub trouble: Option<&'static str>,
}

impl Series {
    /// Words of the configuration.
    pub const ALL: [(&'static str, Series); 6] = [
        ("ild1220", Series::Plain),
        ("ild1320", Series::Plain),
        ("ild1420", Series::Plain),
        ("ild2300", Series::Plain),
        ("ild1900", Series::Wide),
        ("ild1700", Series::Legacy),
    ];

    /// Bytes of its words.
    pub fn width(self) -> Width {
        match self {
            Series::Legacy => Width::Two,
            Series::Plain | Series::Mastered | Series::Wide => Width::Three,
        }
    }

    /// Distance of a word, for a measuring range in mm.
    pub fn distance(self, word: u32, range_mm: f64) -> Distance {
        if let Some((flags, trouble)) = self.error(word) {
            return Distance { mm: None, flags, trouble };
        }
        let x = f64::from(word);
        let share = match self {
            Series::Plain => 1.02 * x / 65_520.0 - 0.01,
            Series::Mastered => 1.02 * x / 65_520.0 - 0.51,
            Series::Wide => (x - 98_232.0) / 65_536.0,
            Series::Legacy => 1.02 * x / 16_368.0 - 0.01,
        };
        if word > self.largest() {
            // Neither a value of the manual nor an error of it.
            return Distance { mm: None, flags: Flags::SUSPECT, trouble: None };
        }
        // Reserves before and behind the range have values, too; they are not specified.
        let (low, high) = self.specified();
        let outside = !(low..=high).contains(&word);
        let flags = if outside { Flags::OUT_OF_RANGE } else { Flags::empty() };
        Distance { mm: Some(share * range_mm), flags, trouble: None }
    }

    /// Word of a distance in mm from the start of the measuring range, as a sensor of that range in mm sends it: the nearest one. Without
    /// a peak, or where no word has such a value, it is the error for that; the manuals of the ILD1900 list none, and the word is one that
    /// has no value.
    pub fn word(self, mm: Option<f64>, range_mm: f64) -> u32 {
        let Some(mm) = mm else { return self.errors()[0] };
        let share = mm / range_mm;
        let word = match self {
            Series::Plain => (share + 0.01) * 65_520.0 / 1.02,
            Series::Mastered => (share + 0.51) * 65_520.0 / 1.02,
            Series::Wide => share * 65_536.0 + 98_232.0,
            Series::Legacy => (share + 0.01) * 16_368.0 / 1.02,
        };
        match word.round() {
            below if below < 0.0 => self.errors()[1],
            word if word <= f64::from(self.largest()) => word as u32,
            _ => self.errors()[2],
        }
    }

    /// Words for no peak, a peak before the range, and one behind it.
    fn errors(self) -> [u32; 3] {
        match self {
            Series::Plain | Series::Mastered => [262_076, 262_077, 262_078],
            Series::Legacy => [16_370, 16_372, 16_374],
            Series::Wide => [self.largest() + 1; 3],
        }
    }

    /// Largest word that is a value.
    fn largest(self) -> u32 {
        match self {
            Series::Plain => 65_520,
            // A master value moves the range within 18 bits.
            Series::Mastered => 262_074,
            Series::Wide => 230_604,
            Series::Legacy => 16_368,
        }
    }

    /// Words within the measuring range.
    fn specified(self) -> (u32, u32) {
        match self {
            Series::Plain => (643, 64_877),
            Series::Mastered | Series::Wide => (0, self.largest()),
            Series::Legacy => (161, 16_207),
        }
    }

    /// Errors in place of a distance: ILD1420 manual, page 66; ILD1700 manual, page 58.
    fn error(self, word: u32) -> Option<(Flags, Option<&'static str>)> {
        let flags = match (self, word) {
            (Series::Wide, _) => return None,
            (Series::Legacy, 16_370 | 16_376) => Flags::NO_SIGNAL,
            (Series::Legacy, 16_372 | 16_374) => Flags::OUT_OF_RANGE,
            (Series::Legacy, 16_378) => {
                return Some((Flags::NO_SIGNAL, Some(LASER_OFF)));
            }
            (Series::Legacy, 16_380) => {
                return Some((
                    Flags::TRIGGER_LOST,
                    Some(
                        "triggers come faster than it measures: move slower, or raise the measuring rate",
                    ),
                ));
            }
            (Series::Legacy, _) => return None,
            (_, 262_075) => {
                return Some((
                    Flags::DEVICE_ERROR,
                    Some(
                        "more data than the baud rate carries: increase it, or lower the measuring rate",
                    ),
                ));
            }
            (_, 262_076 | 262_080) => Flags::NO_SIGNAL,
            (_, 262_077 | 262_078) => Flags::OUT_OF_RANGE,
            (_, 262_081) => Flags::SATURATED,
            (_, 262_082) => return Some((Flags::NO_SIGNAL, Some(LASER_OFF))),
            _ => return None,
        };
        Some((flags, None))
    }
}

const LASER_OFF: &str = "the laser is off: check its key switch and its input";

#[cfg(test)]
mod tests {
    use super::*;

    fn mm(series: Series, word: u32, range_mm: f64) -> f64 {
        series.distance(word, range_mm).mm.unwrap()
    }

    /// Values that the manuals print.
    #[test]
    fn printed_values() {
        assert!((mm(Series::Plain, 32_760, 10.0) - 5.0).abs() < 1e-12);
        assert!((mm(Series::Legacy, 8184, 10.0) - 5.0).abs() < 1e-12);
        assert!((mm(Series::Legacy, 10_261, 10.0) - 6.294).abs() < 5e-4);
        assert!(mm(Series::Legacy, 161, 10.0).abs() < 5e-4);
        // Middle of the range with the master value in it: 0.
        assert!(mm(Series::Mastered, 32_760, 10.0).abs() < 1e-12);
    }

    /// Ends of the ranges of words are printed beside ends of the ranges of values.
    #[test]
    fn ends_of_the_ranges() {
        let near = |value: f64, expected: f64| (value - expected).abs() < 3e-4;
        assert!(
            near(mm(Series::Plain, 0, 1.0), -0.01) && near(mm(Series::Plain, 65_520, 1.0), 1.01)
        );
        assert!(
            near(mm(Series::Plain, 643, 1.0), 0.0) && near(mm(Series::Plain, 64_877, 1.0), 1.0)
        );
        assert!(near(mm(Series::Wide, 98_232 + 65_536, 1.0), 1.0));
        assert!(near(mm(Series::Wide, 98_232, 1.0), 0.0));
    }

    /// Printed values, the other way round, and errors where there is no value.
    #[test]
    fn words_of_distances() {
        assert_eq!(Series::Plain.word(Some(5.0), 10.0), 32_760);
        assert_eq!(Series::Legacy.word(Some(5.0), 10.0), 8184);
        // Printed with three decimals: 6.29434 mm, and a word is 0.6 µm.
        assert_eq!(Series::Legacy.word(Some(6.2943), 10.0), 10_261);
        assert_eq!(Series::Mastered.word(Some(0.0), 10.0), 32_760);
        assert_eq!(Series::Wide.word(Some(0.0), 10.0), 98_232);
        let places = [None, Some(-2.0), Some(12.0)];
        assert_eq!(places.map(|mm| Series::Plain.word(mm, 10.0)), [262_076, 262_077, 262_078]);
        assert_eq!(places.map(|mm| Series::Legacy.word(mm, 10.0)), [16_370, 16_372, 16_374]);
        assert!(Series::Wide.distance(Series::Wide.word(None, 10.0), 10.0).mm.is_none());
    }

    /// Each word that has a value is the word of that value.
    #[test]
    fn words_and_distances_agree() {
        for series in [Series::Plain, Series::Mastered, Series::Wide, Series::Legacy] {
            let words = (0..=series.largest()).filter(|word| series.error(*word).is_none());
            for word in words {
                assert_eq!(series.word(series.distance(word, 25.0).mm, 25.0), word, "{series:?}");
            }
        }
    }

    #[test]
    fn reserves_are_flagged_and_errors_have_no_value() {
        let flags = |series: Series, word| series.distance(word, 10.0).flags;
        assert_eq!(flags(Series::Plain, 642), Flags::OUT_OF_RANGE);
        assert_eq!(flags(Series::Plain, 643), Flags::empty());
        assert_eq!(flags(Series::Plain, 262_081), Flags::SATURATED);
        assert_eq!(flags(Series::Plain, 70_000), Flags::SUSPECT);
        assert_eq!(flags(Series::Mastered, 262_076), Flags::NO_SIGNAL);
        assert_eq!(flags(Series::Legacy, 16_374), Flags::OUT_OF_RANGE);
        let off = Series::Plain.distance(262_082, 10.0);
        assert_eq!((off.mm, off.trouble), (None, Some(LASER_OFF)));
        assert_eq!(flags(Series::Wide, 262_082), Flags::SUSPECT, "its manual lists no errors");
    }
}
