//! Frames of a described device, made of the settings by which they are read.

use asphera_described::{Field, Form, Framing, Layout, Place, Role, Settings};

use crate::example::{Example, Group};
use crate::number::{in_bytes, in_digits};
use crate::row::Row;
use crate::sight::Sight;

/// What one frame is to say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment<'a> {
    /// Number of the trigger, from 0.
    pub(crate) trigger: u64,
    /// Time of the device's clock, s.
    pub(crate) clock_s: f64,
    /// Values of the channels, in their units and their order.
    pub(crate) values: &'a [f64],
    /// What a line scanner sees.
    pub(crate) sight: Option<&'a Sight>,
}

/// Makes the frames of one device.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    settings: Settings,
    pattern: Option<Example>,
    /// Of each field the expression of its group, where it has one.
    groups: Vec<Option<Group>>,
    /// The heights of a profile.
    row: Option<Row>,
}

impl Frames {
    /// Frames by these settings, which have no problems.
    ///
    /// # Errors
    ///
    /// What no frame can be made of, and why.
    pub(crate) fn new(settings: Settings) -> Result<Frames, String> {
        let is_record = matches!(settings.framing, Framing::Records { .. });
        match &settings.layout {
            Layout::Columns { .. } | Layout::Pattern(_) if is_record => {
                return Err("records in text have no length of their own".to_owned());
            }
            Layout::Bytes => {
                let text = settings.fields.iter().find(|field| field.form.width().is_none());
                if let Some(Field { name, .. }) = text {
                    return Err(format!("field {name} is text in a record, of unknown length"));
                }
            }
            Layout::Columns { .. } | Layout::Pattern(_) => {}
        }
        let pattern = match &settings.layout {
            Layout::Pattern(pattern) => {
                Some(Example::new(pattern).ok_or("its pattern is none of bytes")?)
            }
            Layout::Columns { .. } | Layout::Bytes => None,
        };
        let group = |field: &Field| match &field.place {
            Place::Group(name) => pattern.as_ref()?.group(name),
            Place::Column(_) | Place::At(_) => None,
        };
        let groups = settings.fields.iter().map(group).collect();
        let row = Row::new(&settings);
        Ok(Frames { settings, pattern, groups, row })
    }

    /// The settings they are made of.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The value that is read where this one is sent: some prints and forms have few digits.
    pub(crate) fn shown(&self, channel: usize, value: f64) -> f64 {
        let mut channels =
            (0..).zip(&self.settings.fields).filter(|(_, f)| f.role == Role::Channel);
        let Some((index, field)) = channels.nth(channel) else { return value };
        let raw = (value - field.offset) / field.scale;
        let read = field.form.read(&self.written(index, raw));
        read.map_or(value, |raw| raw * field.scale + field.offset)
    }

    /// The range that the device says it measures in.
    pub(crate) fn range(&self, channel: usize) -> Option<(f64, f64)> {
        let mut channels = self.settings.fields.iter().filter(|field| field.role == Role::Channel);
        channels.nth(channel)?.valid_range
    }

    /// The heights of a profile, where it has some.
    pub(crate) fn row(&self) -> Option<&Row> {
        self.row.as_ref()
    }

    /// One frame with its check and its end.
    pub(crate) fn bytes(&self, moment: &Moment<'_>) -> Vec<u8> {
        let texts: Vec<Vec<u8>> = self.texts(moment);
        let heights = self.row.as_ref().map(|row| row.texts(moment.trigger, moment.sight));
        let mut frame = self.settings.framing.begin().to_vec();
        match &self.settings.layout {
            Layout::Pattern(_) => {
                let chosen = |name: &str| {
                    let is_named = |field: &Field| field.place == Place::Group(name.to_owned());
                    let index = self.settings.fields.iter().position(is_named)?;
                    Some(texts[index].clone())
                };
                frame.extend(self.pattern.iter().flat_map(|pattern| pattern.text(&chosen)));
            }
            Layout::Columns { separator, columns } => {
                let line = self.columns(*columns, &texts, heights.as_deref());
                frame.extend(line.join(&separator.unwrap_or(b' ')));
            }
            Layout::Bytes => self.fill_record(&mut frame, &texts, heights.as_deref()),
        }
        self.close(frame)
    }

    /// What stands in each field.
    fn texts(&self, moment: &Moment<'_>) -> Vec<Vec<u8>> {
        let mut channel = 0;
        let of = |(index, field): (usize, &Field)| match &field.role {
            Role::Channel => {
                let value = moment.values.get(channel).copied().unwrap_or(0.0);
                channel += 1;
                self.written(index, (value - field.offset) / field.scale)
            }
            Role::Status { good } => match (good.first(), field.form.width()) {
                (Some(good), None) => good.clone().into_bytes(),
                (Some(good), Some(_)) => in_bytes(field.form, good.parse().unwrap_or(0.0)),
                (None, _) => Vec::new(),
            },
            Role::Bits => self.written(index, 0.0),
            Role::Count { first, modulus } => {
                let count = u64::from(*first) + moment.trigger % u64::from((*modulus).max(1));
                self.written(index, count as f64)
            }
            Role::DeviceTime => self.written(index, clock_steps(field, moment.clock_s)),
        };
        self.settings.fields.iter().enumerate().map(of).collect()
    }

    fn written(&self, field: usize, raw: f64) -> Vec<u8> {
        let form = self.settings.fields[field].form;
        if form.width().is_some() {
            return in_bytes(form, raw);
        }
        let fitting = self.groups[field].as_ref().and_then(|group| group.number(form, raw));
        fitting.unwrap_or_else(|| in_digits(form, raw)).into_bytes()
    }

    /// Texts of the columns of a line.
    fn columns(
        &self,
        columns: Option<usize>,
        texts: &[Vec<u8>],
        heights: Option<&[Vec<u8>]>,
    ) -> Vec<Vec<u8>> {
        let place = |field: &Field| match field.place {
            Place::Column(column) => column - 1,
            Place::Group(_) | Place::At(_) => 0,
        };
        let places: Vec<usize> = self.settings.fields.iter().map(place).collect();
        let first = self.row.as_ref().map_or(0, Row::first_column);
        let heights = heights.unwrap_or_default();
        let ends = places.iter().map(|place| place + 1).chain([first + heights.len()]);
        let width = ends.max().unwrap_or(0).max(columns.unwrap_or(0));
        let mut line = vec![b"0".to_vec(); width];
        for (place, text) in (first..).zip(heights).chain(places.into_iter().zip(texts)) {
            line[place].clone_from(text);
        }
        line
    }

    /// Puts numbers in their places. The check and what stands before it are added later.
    fn fill_record(&self, frame: &mut Vec<u8>, texts: &[Vec<u8>], heights: Option<&[Vec<u8>]>) {
        let Framing::Records { length, .. } = self.settings.framing else { return };
        let guard = self.settings.checksum.map_or(0, |check| check.bytes() + check.skip_last);
        frame.resize(length.saturating_sub(guard), 0);
        let mut put = |at: usize, text: &[u8]| {
            if let Some(place) = frame.get_mut(at..at + text.len()) {
                place.copy_from_slice(text);
            }
        };
        for (field, text) in self.settings.fields.iter().zip(texts) {
            let Place::At(at) = field.place else { continue };
            put(at, text);
        }
        if let (Some(at), Some(heights)) = (self.row.as_ref().and_then(Row::first_byte), heights) {
            put(at, &heights.concat());
        }
    }

    /// Adds check and end.
    fn close(&self, mut frame: Vec<u8>) -> Vec<u8> {
        if let Some(check) = self.settings.checksum {
            frame.extend(std::iter::repeat_n(b'*', check.skip_last));
            frame.extend(check.compute(&frame).unwrap_or_default());
        }
        if let Framing::Lines { end, .. } = &self.settings.framing {
            frame.extend(line_end(end));
        }
        frame
    }

    /// An answer in words, such as that to a greeting, with its end.
    pub(crate) fn line(&self, words: Vec<u8>) -> Vec<u8> {
        match &self.settings.framing {
            Framing::Lines { .. } => {
                self.close([self.settings.framing.begin().to_vec(), words].concat())
            }
            Framing::Records { .. } => words,
        }
    }
}

fn line_end(end: &asphera_described::End) -> &[u8] {
    match end {
        asphera_described::End::Any => b"\r\n",
        asphera_described::End::Bytes(bytes) => bytes,
    }
}

/// The clock in its own steps. Fine steps are whole; a number of few bytes begins again.
fn clock_steps(field: &Field, clock_s: f64) -> f64 {
    let steps = (clock_s - field.offset) / field.scale;
    match field.form {
        Form::Unsigned(width, _) => steps.rem_euclid(256_f64.powi(width.into())).floor(),
        _ if field.scale.abs() < WHOLE_BELOW_S => steps.round(),
        _ => steps,
    }
}

/// A clock with steps below this sends whole steps.
const WHOLE_BELOW_S: f64 = 0.01;
