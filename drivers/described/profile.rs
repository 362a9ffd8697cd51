//! Rows of heights: a whole line profile in a frame.

use std::ops::Range;

use asphera_link::{Problem, Profile, check_range};

use crate::field::Place;
use crate::framing::Framing;
use crate::number::Form;
use crate::settings::{Layout, Settings};

/// Heights of a line profile, which stand in a row in each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileRow {
    /// Where the first height stands: a column of a line, or a byte of a record. The others follow it without a gap.
    pub place: Place,
    /// How each height is written.
    pub form: Form,
    /// Places of the heights along the line.
    pub abscissae: Abscissae,
    /// Worth of one, mm: the height is number × scale + offset. Not zero.
    pub scale: f64,
    /// Height of the number 0, mm.
    pub offset_mm: f64,
    /// Smallest and largest height, mm. A height outside is missing.
    pub valid_range_mm: Option<(f64, f64)>,
    /// Number that stands for no height, before scale and offset.
    pub no_value: Option<f64>,
    /// Texts that stand for no height, without blanks about them.
    pub no_signal: Vec<String>,
}

/// Places of the points of a profile along its line, mm.
#[derive(Clone, Debug, PartialEq)]
pub enum Abscissae {
    /// The first, then one each pitch.
    Even {
        /// How many.
        points: usize,
        /// Place of the first, mm.
        first_mm: f64,
        /// From one to the next, mm; negative where the line runs towards -x. Not zero.
        pitch_mm: f64,
    },
    /// One for each.
    Given(Vec<f64>),
}

/// Profile of a frame.
pub(crate) struct Read {
    /// Its points.
    pub(crate) profile: Profile,
    /// Whether any of them has a height or a marker that is known.
    pub(crate) is_known: bool,
    /// Whether one is neither a number nor a marker: the frame may be damaged.
    pub(crate) is_doubtful: bool,
}

impl Abscissae {
    /// How many points a profile has.
    pub fn points(&self) -> usize {
        match self {
            Abscissae::Even { points, .. } => *points,
            Abscissae::Given(places_mm) => places_mm.len(),
        }
    }

    /// Place of a point, mm. `index` from 0, below [`Abscissae::points`].
    pub fn place_mm(&self, index: usize) -> f64 {
        match self {
            Abscissae::Even { first_mm, pitch_mm, .. } => first_mm + pitch_mm * index as f64,
            Abscissae::Given(places_mm) => places_mm.get(index).copied().unwrap_or(f64::NAN),
        }
    }
}

impl ProfileRow {
    /// Index of the column of its first height, from 0, where it stands in columns.
    pub(crate) fn first_column(&self) -> usize {
        match self.place {
            Place::Column(column) => column - 1,
            Place::Group(_) | Place::At(_) => 0,
        }
    }

    /// Bytes of a record that its heights take, the beginning of the record counted.
    pub(crate) fn range(&self) -> Option<Range<usize>> {
        let Place::At(at) = self.place else { return None };
        let width = self.form.width()?;
        Some(at..at.saturating_add(width.saturating_mul(self.abscissae.points())))
    }

    /// The profile of these texts or numbers in bytes, one for each point; those that lack are missing.
    pub(crate) fn read<'a>(&self, heights: impl IntoIterator<Item = &'a [u8]>) -> Read {
        let (mut is_known, mut is_doubtful) = (false, false);
        let mut heights = heights.into_iter();
        let point = |index: usize| {
            let bytes = heights.next().unwrap_or_default();
            let is_marker = self.is_marker(bytes);
            let raw = if is_marker { None } else { self.form.read(bytes) };
            is_known |= is_marker || raw.is_some();
            is_doubtful |= !is_marker && raw.is_none();
            let height_mm = self.height_mm(raw?)?;
            Some([self.abscissae.place_mm(index), height_mm])
        };
        let profile = (0..self.abscissae.points()).map(point).collect();
        Read { profile, is_known, is_doubtful }
    }

    fn is_marker(&self, bytes: &[u8]) -> bool {
        let text = bytes.trim_ascii();
        self.no_signal.iter().any(|marker| marker.as_bytes() == text)
    }

    fn height_mm(&self, raw: f64) -> Option<f64> {
        if self.no_value == Some(raw) {
            return None;
        }
        let height_mm = raw * self.scale + self.offset_mm;
        let is_valid = |(low, high)| (low..=high).contains(&height_mm);
        self.valid_range_mm.is_none_or(is_valid).then_some(height_mm)
    }

    /// Everything of it that cannot be used.
    pub(crate) fn problems(&self, settings: &Settings) -> Vec<Problem> {
        let mut problems = Vec::new();
        let mut wrong = |name: &str, expected: &str, found: String| {
            problems.push(Problem::new(format!("profile.{name}"), expected, found));
        };
        if self.scale == 0.0 || !self.scale.is_finite() {
            wrong("scale", "a number, not 0", self.scale.to_string());
        }
        if !self.offset_mm.is_finite() {
            wrong("offset_mm", "a number", self.offset_mm.to_string());
        }
        if self.no_value.is_some_and(|number| !number.is_finite()) {
            wrong("no_value", "a number", "none".to_owned());
        }
        match &self.abscissae {
            Abscissae::Even { first_mm, pitch_mm, .. } => {
                if !first_mm.is_finite() {
                    wrong("x_first_mm", "a number", first_mm.to_string());
                }
                if *pitch_mm == 0.0 || !pitch_mm.is_finite() {
                    wrong("pitch_mm", "a number, not 0", pitch_mm.to_string());
                }
            }
            Abscissae::Given(places_mm) => {
                if let Some(place_mm) = places_mm.iter().find(|place_mm| !place_mm.is_finite()) {
                    wrong("x_mm", "numbers", place_mm.to_string());
                }
            }
        }
        self.check_place(&mut wrong, settings);
        let key = if matches!(self.abscissae, Abscissae::Given(_)) { "x_mm" } else { "points" };
        let points = self.abscissae.points();
        check_range(&mut problems, &format!("profile.{key}"), points, 2, MAX_POINTS);
        problems
    }

    fn check_place(&self, wrong: &mut impl FnMut(&str, &str, String), settings: &Settings) {
        let points = self.abscissae.points();
        match (&settings.layout, &self.place, &settings.framing) {
            (
                Layout::Columns { columns, .. },
                Place::Column(column),
                Framing::Lines { longest, .. },
            ) => {
                let last = column.saturating_add(points).saturating_sub(1);
                if *column == 0 || columns.is_some_and(|columns| last > columns) {
                    let most = columns
                        .map_or(String::new(), |columns| format!(", {columns} columns in all"));
                    wrong("column", &format!("1 or more{most}"), format!("{column} to {last}"));
                }
                // Each height has a digit and a separator.
                let least = points.saturating_mul(2).saturating_sub(1);
                if *longest < least {
                    let expected = format!(
                        "a line with room for {points} heights: longest = {}",
                        points.saturating_mul(12).min(65_536)
                    );
                    wrong("points", &expected, format!("longest = {longest}"));
                }
                if self.form.width().is_some() {
                    wrong(
                        "form",
                        "decimal, decimal-comma or hex, for text",
                        "a number in bytes".to_owned(),
                    );
                }
            }
            (Layout::Bytes, Place::At(at), Framing::Records { length, .. }) => {
                let check = settings.checksum.map_or(0, |check| check.bytes());
                let last = length.saturating_sub(check);
                match self.range() {
                    None => wrong("form", "a number in bytes: u8 to f64", "digits".to_owned()),
                    Some(range) if range.end > last => {
                        let expected =
                            format!("a place from which {points} heights end within {last} bytes");
                        wrong("at", &expected, at.to_string());
                    }
                    Some(_) => {}
                }
                if !self.no_signal.is_empty() {
                    wrong("no_signal", "no_value, for numbers in bytes", "texts".to_owned());
                }
            }
            (Layout::Bytes, ..) => wrong("column", "`at`, as the fields", "`column`".to_owned()),
            (Layout::Columns { .. }, ..) => {
                wrong("at", "`column`, as the fields", "`at`".to_owned());
            }
            (Layout::Pattern(_), ..) => {
                wrong(
                    "column",
                    "columns instead of a pattern, for a row of heights",
                    "a pattern".to_owned(),
                );
            }
        }
    }
}

/// Most points of a profile: as many as a frame of the most bytes can have.
const MAX_POINTS: usize = 32_768;

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> ProfileRow {
        ProfileRow {
            place: Place::Column(1),
            form: Form::Decimal,
            abscissae: Abscissae::Even { points: 4, first_mm: -1.0, pitch_mm: 0.5 },
            scale: 1e-3,
            offset_mm: 2.0,
            valid_range_mm: Some((0.0, 5.0)),
            no_value: Some(-9999.0),
            no_signal: vec!["---".to_owned()],
        }
    }

    fn read(row: &ProfileRow, texts: &[&str]) -> (Vec<Option<[f64; 2]>>, bool, bool) {
        let read = row.read(texts.iter().map(|text| text.as_bytes()));
        (read.profile.points_mm().to_vec(), read.is_known, read.is_doubtful)
    }

    #[test]
    fn heights_stand_at_their_places_and_markers_are_gaps() {
        let (points, known, doubtful) = read(&row(), &["1000", " --- ", "-9999", "-500"]);
        assert_eq!(points, [Some([-1.0, 3.0]), None, None, Some([0.5, 1.5])]);
        assert!(known && !doubtful);
        let (points, known, doubtful) = read(&row(), &["9000", "", "x", "-2000"]);
        assert_eq!(points, [None, None, None, Some([0.5, 0.0])]);
        assert!(known && doubtful, "an empty column is no marker");
        assert_eq!(read(&row(), &["---"; 4]), (vec![None; 4], true, false));
        assert_eq!(read(&row(), &["a", "b", "c", "d"]), (vec![None; 4], false, true));
        assert_eq!(read(&row(), &["0"]).0.len(), 4);
    }

    #[test]
    fn places_are_given_or_even() {
        let given = Abscissae::Given(vec![0.0, 0.5, 2.0, 4.5]);
        let row = ProfileRow { abscissae: given, scale: 1.0, offset_mm: 0.0, ..row() };
        let (points, ..) = read(&row, &["1", "2", "3", "4"]);
        let places: Vec<f64> = points.iter().flatten().map(|point| point[0]).collect();
        assert_eq!(places, [0.0, 0.5, 2.0, 4.5]);
        let even = Abscissae::Even { points: 3, first_mm: 1.0, pitch_mm: -0.25 };
        assert_eq!([0, 1, 2].map(|index| even.place_mm(index)), [1.0, 0.75, 0.5]);
    }
}
