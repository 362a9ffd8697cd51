//! The heights of a profile in a frame of a described line scanner.

use asphera_described::{Abscissae, Form, Framing, Place, ProfileRow, Settings};

use crate::number::{in_bytes, in_digits};
use crate::sight::Sight;

/// Row of heights, as it is written.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    row: ProfileRow,
    /// Decimals of a height in text, so that a line has room for all.
    decimals: usize,
}

impl Row {
    /// The row of these settings, where they have one.
    pub(crate) fn new(settings: &Settings) -> Option<Row> {
        let row = settings.profile.clone()?;
        let longest = match settings.framing {
            Framing::Lines { longest, .. } => longest,
            Framing::Records { .. } => 0,
        };
        // A height takes its sign, the digits before its point, the point, and the separator.
        let room = (longest / (row.abscissae.points() + settings.fields.len()).max(1)).max(1);
        let decimals = room.saturating_sub(OTHER_SIGNS).clamp(1, MOST_DECIMALS);
        Some(Row { row, decimals })
    }

    /// Index of the column of the first height, from 0.
    pub(crate) fn first_column(&self) -> usize {
        match self.row.place {
            Place::Column(column) => column - 1,
            Place::Group(_) | Place::At(_) => 0,
        }
    }

    /// Place of the first height in a record.
    pub(crate) fn first_byte(&self) -> Option<usize> {
        match self.row.place {
            Place::At(at) => Some(at),
            Place::Column(_) | Place::Group(_) => None,
        }
    }

    /// Points of the line.
    pub(crate) fn points(&self) -> usize {
        self.row.abscissae.points()
    }

    /// Distance of its points, mm: the mean one, where they are given one by one.
    pub(crate) fn pitch_mm(&self) -> f64 {
        match &self.row.abscissae {
            Abscissae::Even { pitch_mm, .. } => pitch_mm.abs(),
            Abscissae::Given(places_mm) => {
                let (low, high) =
                    places_mm.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                        (low.min(*at), high.max(*at))
                    });
                (high - low) / (places_mm.len().max(2) - 1) as f64
            }
        }
    }

    /// Smallest and largest height, mm.
    pub(crate) fn range_mm(&self) -> (f64, f64) {
        self.row.valid_range_mm.unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
    }

    /// Each height as it is written; nothing is seen without a sight.
    pub(crate) fn texts(&self, trigger: u64, sight: Option<&Sight>) -> Vec<Vec<u8>> {
        let text = |point: usize| {
            let place_mm = self.row.abscissae.place_mm(point);
            match sight.and_then(|sight| sight.height_mm(trigger, point, place_mm)) {
                Some(height_mm) => self.number((height_mm - self.row.offset_mm) / self.row.scale),
                None => self.nothing(),
            }
        };
        (0..self.points()).map(text).collect()
    }

    fn number(&self, raw: f64) -> Vec<u8> {
        let decimals = self.decimals;
        match self.row.form {
            Form::Decimal => format!("{raw:.decimals$}").into_bytes(),
            Form::DecimalComma => format!("{raw:.decimals$}").replace('.', ",").into_bytes(),
            Form::Hex => in_digits(Form::Hex, raw).into_bytes(),
            form => in_bytes(form, raw),
        }
    }

    /// What stands for no height: its marker, or a height out of range.
    fn nothing(&self) -> Vec<u8> {
        if let Some(marker) = self.row.no_signal.first() {
            return marker.clone().into_bytes();
        }
        let beyond = self
            .row
            .valid_range_mm
            .map(|(low, high)| (2.0 * high - low - self.row.offset_mm) / self.row.scale);
        match self.row.no_value.or(beyond) {
            Some(raw) => self.number(raw),
            None if self.row.form.width().is_some() => self.number(0.0),
            None => b"nan".to_vec(),
        }
    }
}

/// Of a height in text beside its decimals.
const OTHER_SIGNS: usize = 7;
const MOST_DECIMALS: usize = 9;
