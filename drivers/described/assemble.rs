//! A frame as a reading.

use std::borrow::Cow;
use std::ops::Range;

use asphera_link::{Count, Flags, Nanos, Reading, Values};

use crate::field::{Field, Place, Role};
use crate::pattern::Pattern;
use crate::profile::{ProfileRow, Read};
use crate::settings::{Layout, Settings};

/// Knows what stands where in a frame.
#[derive(Debug)]
pub(crate) struct Assembler {
    cut: Cut,
    slots: Vec<Slot>,
    profile: Option<ProfileRow>,
    /// First byte of the profile in a record without its beginning.
    profile_at: usize,
}

/// How a frame is taken apart.
#[derive(Debug)]
enum Cut {
    Columns { separator: Option<u8>, columns: Option<usize> },
    Pattern(Pattern),
    Bytes,
}

#[derive(Debug)]
struct Slot {
    field: Field,
    /// Index of its piece.
    piece: usize,
    /// Its bytes, in a record.
    range: Range<usize>,
}

/// Why a frame is no reading, in words that follow the frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NoReading {
    /// It has another number of columns: found and expected.
    Columns(usize, Cow<'static, str>),
    /// It does not match.
    Pattern,
    /// No channel holds a number or a word that is known.
    NoNumber,
}

/// A reading, and the state that is worth a message.
pub(crate) struct Assembled {
    pub(crate) reading: Reading,
    /// The first field that says the device is in trouble, in words that follow "the device reports".
    pub(crate) trouble: Option<String>,
}

impl Assembler {
    /// For settings without problems.
    pub(crate) fn new(settings: &Settings) -> Assembler {
        let begin = settings.framing.begin().len();
        let cut = match &settings.layout {
            Layout::Columns { separator, columns } => {
                Cut::Columns { separator: *separator, columns: *columns }
            }
            Layout::Pattern(pattern) => Cut::Pattern(pattern.clone()),
            Layout::Bytes => Cut::Bytes,
        };
        let slot = |field: &Field| {
            let (piece, range) = match (&field.place, &cut) {
                (Place::Column(column), _) => (column - 1, 0..0),
                (Place::Group(group), Cut::Pattern(pattern)) => {
                    (pattern.group(group).unwrap_or_default(), 0..0)
                }
                (Place::Group(_), _) => (0, 0..0),
                (Place::At(at), _) => {
                    // Places count from the beginning of the frame, which the body has no more.
                    let from = at.saturating_sub(begin);
                    (0, from..from + field.form.width().unwrap_or_default())
                }
            };
            Slot { field: field.clone(), piece, range }
        };
        let profile_at = settings.profile.as_ref().and_then(ProfileRow::range);
        Assembler {
            slots: settings.fields.iter().map(slot).collect(),
            cut,
            profile: settings.profile.clone(),
            profile_at: profile_at.map_or(0, |range| range.start.saturating_sub(begin)),
        }
    }

    /// The reading of a frame without its beginning and its check.
    pub(crate) fn reading(&self, host: Nanos, body: &[u8]) -> Result<Assembled, NoReading> {
        let pieces = self.pieces(body)?;
        let text = |slot: &Slot| -> &[u8] {
            match &self.cut {
                Cut::Bytes => body.get(slot.range.clone()).unwrap_or_default(),
                _ => pieces
                    .get(slot.piece)
                    .and_then(|range| body.get(range.clone()))
                    .unwrap_or_default(),
            }
        };
        let mut assembled = Assembled {
            reading: Reading {
                host,
                device_time_ns: None,
                count: None,
                values: Values::new(),
                flags: Flags::empty(),
            },
            trouble: None,
        };
        let mut known = false;
        for slot in &self.slots {
            known |= slot.enter(text(slot), &mut assembled);
        }
        if let Some(row) = &self.profile {
            let read = self.profile(row, body, &pieces);
            known |= read.is_known;
            if read.is_doubtful {
                assembled.reading.flags |= Flags::SUSPECT;
            }
            let values = std::mem::take(&mut assembled.reading.values);
            assembled.reading.values = values.with_profile(read.profile);
        }
        if known { Ok(assembled) } else { Err(NoReading::NoNumber) }
    }

    fn profile(&self, row: &ProfileRow, body: &[u8], pieces: &[Range<usize>]) -> Read {
        match row.form.width() {
            Some(width) => row.read(body.get(self.profile_at..).unwrap_or_default().chunks(width)),
            None => {
                let heights = pieces.get(row.first_column()..).unwrap_or_default();
                row.read(heights.iter().map(|range| body.get(range.clone()).unwrap_or_default()))
            }
        }
    }

    fn pieces(&self, body: &[u8]) -> Result<Vec<Range<usize>>, NoReading> {
        match &self.cut {
            Cut::Bytes => Ok(Vec::new()),
            Cut::Pattern(pattern) => {
                let places = pattern.places(body).ok_or(NoReading::Pattern)?;
                Ok(places.into_iter().map(Option::unwrap_or_default).collect())
            }
            Cut::Columns { separator, columns } => {
                let pieces = split(body, *separator);
                let row = self.profile.as_ref();
                let row = row.map(|row| row.first_column() + row.abscissae.points());
                let ends = self.slots.iter().map(|slot| slot.piece + 1);
                let needed = ends.chain(row).max().unwrap_or(1);
                // A row that lost or gained a separator has other heights at its places.
                let (fits, expected) = match columns.or(row.map(|_| needed)) {
                    Some(columns) => (pieces.len() == columns, columns.to_string().into()),
                    None => (pieces.len() >= needed, format!("at least {needed}").into()),
                };
                if fits { Ok(pieces) } else { Err(NoReading::Columns(pieces.len(), expected)) }
            }
        }
    }
}

/// Columns between single separators, or between runs of blanks.
fn split(body: &[u8], separator: Option<u8>) -> Vec<Range<usize>> {
    let is_blank = |byte: u8| matches!(byte, b' ' | b'\t');
    let mut pieces = Vec::new();
    let mut from = 0;
    let ends = body.iter().enumerate().filter(|(_, byte)| match separator {
        Some(separator) => **byte == separator,
        None => is_blank(**byte),
    });
    for at in ends.map(|(at, _)| at).chain([body.len()]) {
        if separator.is_some() || at > from {
            pieces.push(from..at);
        }
        from = at + 1;
    }
    pieces
}

impl Slot {
    /// Enters the field into the reading. Whether it is a channel that says something.
    fn enter(&self, bytes: &[u8], into: &mut Assembled) -> bool {
        let reading = &mut into.reading;
        match &self.field.role {
            Role::Channel => {
                let (value, flags, known) = self.channel(bytes);
                reading.values.push(value);
                reading.flags |= flags;
                return known;
            }
            Role::Status { good } => {
                let text = self.text(bytes);
                if good.contains(&text) {
                    return false;
                }
                let flags = self.field.flags_of(&text);
                reading.flags |= if flags.is_empty() { Flags::SUSPECT } else { flags };
                if flags.contains(Flags::DEVICE_ERROR) && into.trouble.is_none() {
                    let means = self.field.meaning_of(&text);
                    let means = if means.is_empty() { "see its manual" } else { means };
                    into.trouble = Some(format!("{} `{text}`: {means}", self.field.name));
                }
            }
            Role::Bits => match self.whole(bytes) {
                Some(bits) => self.bits(bits, into),
                None => reading.flags |= Flags::SUSPECT,
            },
            Role::Count { first, modulus } => {
                let raw = self.whole(bytes);
                let fits =
                    |raw: &u32| raw.checked_sub(*first).is_some_and(|above| above < *modulus);
                match raw.filter(fits) {
                    Some(raw) => {
                        reading.count = Some(Count { raw, first: *first, modulus: *modulus });
                    }
                    None => reading.flags |= Flags::SUSPECT,
                }
            }
            Role::DeviceTime => match self.scaled(bytes).map(|seconds| (seconds * 1e9).round()) {
                Some(ns) if (0.0..1.8e19).contains(&ns) => reading.device_time_ns = Some(ns as u64),
                _ => reading.flags |= Flags::SUSPECT,
            },
        }
        false
    }

    /// Value and flags of a channel, and whether it says anything at all.
    fn channel(&self, bytes: &[u8]) -> (Option<f64>, Flags, bool) {
        let said = self.field.flags_of(&self.text(bytes));
        if !said.is_empty() {
            return (None, said, true);
        }
        let Some(raw) = self.field.form.read(bytes) else { return (None, Flags::SUSPECT, false) };
        if self.field.no_value == Some(raw) {
            return (None, Flags::NO_SIGNAL, true);
        }
        match self.field.scaled(raw) {
            value if !value.is_finite() => (None, Flags::NOT_FINITE, true),
            value => match self.field.valid_range {
                Some((low, high)) if !(low..=high).contains(&value) => {
                    (None, Flags::OUT_OF_RANGE, true)
                }
                _ => (Some(value), Flags::empty(), true),
            },
        }
    }

    fn bits(&self, bits: u32, into: &mut Assembled) {
        for flagged in &self.field.flagged {
            for bit in &flagged.texts {
                let is_set = bit.parse().is_ok_and(|bit: u32| bit < 32 && bits >> bit & 1 == 1);
                if !is_set {
                    continue;
                }
                into.reading.flags |= flagged.flag;
                if flagged.flag == Flags::DEVICE_ERROR && into.trouble.is_none() {
                    into.trouble = Some(format!("{} `bit {bit}`: see its manual", self.field.name));
                }
            }
        }
    }

    fn scaled(&self, bytes: &[u8]) -> Option<f64> {
        self.field.form.read(bytes).map(|raw| self.field.scaled(raw))
    }

    fn whole(&self, bytes: &[u8]) -> Option<u32> {
        let raw = self.field.form.read(bytes)?;
        let is_whole = raw.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&raw);
        is_whole.then_some(raw as u32)
    }

    /// The text that flags are compared with: that of a number in bytes is its decimal digits.
    fn text(&self, bytes: &[u8]) -> String {
        match self.field.form.width() {
            None => String::from_utf8_lossy(bytes.trim_ascii()).into_owned(),
            Some(_) => self.field.form.read(bytes).map_or(String::new(), |raw| raw.to_string()),
        }
    }
}

impl std::fmt::Display for NoReading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoReading::Columns(found, expected) => {
                write!(f, "has {found} columns, expected {expected}")
            }
            NoReading::Pattern => f.write_str("does not match the pattern"),
            NoReading::NoNumber => f.write_str("has no number where a channel stands"),
        }
    }
}

#[cfg(test)]
mod tests {
    use asphera_link::Unit;

    use super::*;
    use crate::field::Flagged;
    use crate::framing::Framing;
    use crate::number::{ByteOrder, Form};

    fn columns(separator: Option<u8>, columns: Option<usize>, fields: Vec<Field>) -> Assembler {
        let layout = Layout::Columns { separator, columns };
        let settings = Settings { layout, fields, ..Settings::default() };
        assert_eq!(settings.problems(), []);
        Assembler::new(&settings)
    }

    fn values(assembled: &Assembled) -> Vec<Option<f64>> {
        assembled.reading.values.iter().collect()
    }

    fn z(column: usize) -> Field {
        Field::channel("z", Place::Column(column), Unit::Millimetre)
    }

    #[test]
    fn columns_count_with_empty_ones_between_separators() {
        let assembler = columns(Some(b','), None, vec![z(3)]);
        let read = |line: &str| assembler.reading(Nanos::ZERO, line.as_bytes());
        assert_eq!(values(&read("a,,1.5").unwrap()), [Some(1.5)]);
        assert_eq!(values(&read("a,b, 2.5 ,c").unwrap()), [Some(2.5)]);
        let short = read("a,b").err().unwrap();
        assert_eq!(short.to_string(), "has 2 columns, expected at least 3");
        let assembler = columns(None, Some(2), vec![z(2)]);
        let read = |line: &str| assembler.reading(Nanos::ZERO, line.as_bytes());
        assert_eq!(values(&read(" x \t 3 ").unwrap()), [Some(3.0)]);
        assert_eq!(read("1").err(), Some(NoReading::Columns(1, "2".into())));
        assert_eq!(read("").err(), Some(NoReading::Columns(0, "2".into())));
    }

    #[test]
    fn a_head_is_no_reading_and_a_gap_is_no_zero() {
        let assembler =
            columns(Some(b';'), Some(2), vec![z(1), Field { name: "t".into(), ..z(2) }]);
        let read = |line: &str| assembler.reading(Nanos::ZERO, line.as_bytes());
        assert_eq!(read("distance;temperature").err(), Some(NoReading::NoNumber));
        let gap = read(";21.5").unwrap();
        assert_eq!(values(&gap), [None, Some(21.5)]);
        assert_eq!(gap.reading.flags, Flags::SUSPECT);
    }

    /// Keyence LK-G: XXXXXXX without a target, FFFFFFF outside the range (manual, pages 5-5 and 5-6).
    #[test]
    fn words_in_place_of_numbers() {
        let flagged = |flag, texts: &[&str]| Flagged {
            flag,
            texts: texts.iter().map(|text| (*text).to_owned()).collect(),
            means: String::new(),
        };
        let field = Field {
            flagged: vec![
                flagged(Flags::NO_SIGNAL, &["XXXXXXX", "-------"]),
                flagged(Flags::OUT_OF_RANGE, &["+FFFFFFF", "-FFFFFFF"]),
            ],
            ..z(1)
        };
        let assembler = columns(Some(b','), Some(1), vec![field]);
        let read = |line: &str| {
            let found = assembler.reading(Nanos::ZERO, line.as_bytes()).unwrap();
            (found.reading.values.get(0), found.reading.flags)
        };
        assert_eq!(read("+01.2345"), (Some(1.2345), Flags::empty()));
        assert_eq!(read("XXXXXXX"), (None, Flags::NO_SIGNAL));
        assert_eq!(read("-FFFFFFF"), (None, Flags::OUT_OF_RANGE));
    }

    #[test]
    fn states_counts_and_times() {
        let field = |name: &str, column, unit, role| Field {
            role,
            ..Field::channel(name, Place::Column(column), unit)
        };
        let trouble =
            Flagged { flag: Flags::DEVICE_ERROR, texts: vec!["E".into()], means: "broken".into() };
        let fields = vec![
            z(1),
            Field {
                flagged: vec![trouble],
                ..field("state", 2, Unit::One, Role::Status { good: vec!["0".into()] })
            },
            field("n", 3, Unit::Count, Role::Count { first: 1, modulus: 100 }),
            Field { scale: 1e-3, ..field("ms", 4, Unit::Second, Role::DeviceTime) },
            Field {
                form: Form::Hex,
                flagged: vec![Flagged {
                    flag: Flags::SATURATED,
                    texts: vec!["4".into()],
                    means: String::new(),
                }],
                ..field("bits", 5, Unit::One, Role::Bits)
            },
        ];
        let assembler = columns(Some(b','), Some(5), fields);
        let read = |line: &str| assembler.reading(Nanos::ZERO, line.as_bytes()).unwrap();
        let good = read("1.5,0,100,250.5,0F");
        assert_eq!(good.reading.flags, Flags::empty());
        assert_eq!(good.reading.count, Some(Count { raw: 100, first: 1, modulus: 100 }));
        assert_eq!(good.reading.device_time_ns, Some(250_500_000));
        let bad = read("1.5,E,101,-1,10");
        assert_eq!(bad.reading.flags, Flags::DEVICE_ERROR | Flags::SUSPECT | Flags::SATURATED);
        assert_eq!((bad.reading.count, bad.reading.device_time_ns), (None, None));
        assert_eq!(bad.trouble, Some("state `E`: broken".into()));
        assert_eq!(read("1.5,7,1,0,0").reading.flags, Flags::SUSPECT, "a state nobody described");
        assert_eq!(read("1.5,0,2.5,0,0").reading.count, None, "half a count is none");
    }

    #[test]
    fn bytes_by_their_place_in_the_record() {
        let at = |name: &str, at, form, role| Field {
            form,
            role,
            ..Field::channel(name, Place::At(at), Unit::Millimetre)
        };
        let settings = Settings {
            framing: Framing::Records { begin: vec![0xAA, 0x55], length: 7 },
            layout: Layout::Bytes,
            fields: vec![
                Field {
                    scale: 1e-4,
                    ..at("z", 2, Form::Signed(3, ByteOrder::Little), Role::Channel)
                },
                Field {
                    flagged: vec![Flagged {
                        flag: Flags::WEAK,
                        texts: vec!["3".into()],
                        means: String::new(),
                    }],
                    ..at(
                        "state",
                        5,
                        Form::Unsigned(2, ByteOrder::Big),
                        Role::Status { good: vec!["0".into()] },
                    )
                },
            ],
            ..Settings::default()
        };
        assert_eq!(settings.problems(), []);
        let assembler = Assembler::new(&settings);
        let read = assembler.reading(Nanos::ZERO, &[0x18, 0xFC, 0xFF, 0, 3]).unwrap();
        assert_eq!((values(&read), read.reading.flags), (vec![Some(-0.1)], Flags::WEAK));
    }
}
