//! Points of files whose coordinates have no unit of their own: the unit that is taken, gaps, and how many there may be.

use crate::xyz::{By, Taken, TakenColumn, TextOptions, Unit};
use crate::{Cloud, Format, MAX_POINTS, Place, ReadError, Source, Topography};

/// The units of x, y and z of one file, and what stated them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lengths {
    format: Format,
    units: [Unit; 3],
    by: By,
}

impl Lengths {
    /// `stated` is the unit that the file names. Without it the options decide, and without these it is mm.
    pub(crate) fn of(
        format: Format,
        stated: Option<Unit>,
        options: &TextOptions,
    ) -> Result<Lengths, ReadError> {
        let unclear = |found: String, cure: &str| ReadError::Unclear {
            format,
            place: Place::Byte(0),
            found,
            cure: cure.into(),
        };
        let asked = match options.units[..] {
            [] => None,
            [unit] => Some([unit; 3]),
            [x, y, z] => Some([x, y, z]),
            _ => {
                let found = format!("{} units for x, y and z", options.units.len());
                return Err(unclear(found, "`--unit` takes one for all, or one for each"));
            }
        };
        if let Some(slope) = asked.iter().flatten().find(|unit| unit.is_slope()) {
            let found = format!("coordinates in {slope}");
            return Err(unclear(found, "add `--unit` with mm, um, nm, cm, m or in"));
        }
        let (units, by) = match (stated, asked) {
            (Some(stated), Some(asked)) if asked != [stated; 3] => {
                let other = asked.into_iter().find(|unit| *unit != stated).unwrap_or(stated);
                let found = format!(
                    "the file says that lengths are in {stated}, and `--unit` says {other}"
                );
                return Err(unclear(found, "leave `--unit` out, or mend the file"));
            }
            (Some(stated), _) => ([stated; 3], By::Head),
            (None, Some(asked)) => (asked, By::Options),
            (None, None) => ([Unit::Mm; 3], By::Default),
        };
        Ok(Lengths { format, units, by })
    }

    /// The format of the file.
    pub(crate) fn format(&self) -> Format {
        self.format
    }

    /// A point of the file in mm; `None` of one with a coordinate that is NaN.
    ///
    /// # Errors
    ///
    /// A coordinate that is infinite, in the file or in mm.
    pub(crate) fn scaled(
        &self,
        point: [f64; 3],
        place: impl Fn() -> Place,
    ) -> Result<Option<[f64; 3]>, ReadError> {
        if point.iter().any(|value| value.is_nan()) {
            return Ok(None);
        }
        let mut point_mm = [0.0; 3];
        for ((mm, value), unit) in point_mm.iter_mut().zip(point).zip(self.units) {
            *mm = unit.scaled(value);
        }
        if point_mm.iter().all(|value| value.is_finite()) {
            return Ok(Some(point_mm));
        }
        Err(ReadError::Malformed {
            format: self.format,
            place: place(),
            expected: "finite coordinates".into(),
            found: format!("{point:?}"),
        })
    }
}

/// Points as they are read, in the order of the file.
pub(crate) struct Points {
    lengths: Lengths,
    cloud: Cloud,
}

impl Points {
    pub(crate) fn new(lengths: Lengths) -> Points {
        Points { lengths, cloud: Cloud::default() }
    }

    /// Takes a point in the units of the file. One with a coordinate that is NaN is a gap.
    ///
    /// # Errors
    ///
    /// A coordinate that is infinite, in the file or in mm; more than [`MAX_POINTS`] points.
    pub(crate) fn push(
        &mut self,
        point: [f64; 3],
        place: impl Fn() -> Place,
    ) -> Result<(), ReadError> {
        let format = self.lengths.format;
        let count = (self.cloud.points_mm.len() + self.cloud.missing) as u64;
        check_count(format, count + 1, &place)?;
        match self.lengths.scaled(point, place)? {
            Some(point_mm) => self.cloud.points_mm.push(point_mm),
            None => self.cloud.missing += 1,
        }
        Ok(())
    }

    /// Counts a point that the file lists as not measured.
    pub(crate) fn skip(&mut self) {
        self.cloud.missing += 1;
    }

    /// All that was taken; `columns` are the places of x, y and z in the record of a point, from 1.
    ///
    /// # Errors
    ///
    /// A file that lists no point.
    pub(crate) fn finish(self, columns: [usize; 3], end: Place) -> Result<Topography, ReadError> {
        let Points { lengths: Lengths { format, units, by }, cloud } = self;
        if cloud.points_mm.is_empty() && cloud.missing == 0 {
            return Err(ReadError::Malformed {
                format,
                place: end,
                expected: "at least one point".into(),
                found: "none".into(),
            });
        }
        let named = ["x", "y", "z"].into_iter().zip(columns).zip(units);
        let columns = named.map(|((name, number), unit)| TakenColumn { name, number, unit });
        let taken = Taken {
            columns: columns.collect(),
            named_by: By::Head,
            units_by: by,
            has_decimal_commas: false,
            passed_over: 0,
            cautions: Vec::new(),
        };
        Ok(Topography::Cloud(cloud, Source { taken: Some(taken), ..Source::new(format) }))
    }
}

/// Refuses a file that says it has more than [`MAX_POINTS`] points, before anything is kept of them.
pub(crate) fn check_count(
    format: Format,
    count: u64,
    place: impl Fn() -> Place,
) -> Result<(), ReadError> {
    if count > MAX_POINTS {
        let (place, unit) = (place(), "points");
        return Err(ReadError::TooLarge { format, place, unit, limit: MAX_POINTS, found: count });
    }
    Ok(())
}

/// The three numbers after a keyword such as `vertex`, in the words of a line. NaN is read as such; infinities, too.
pub(crate) fn three_numbers<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Option<[f64; 3]> {
    let mut number = || number(words.next()?);
    Some([number()?, number()?, number()?])
}

/// A number of any kind, as these formats write it.
pub(crate) fn number(word: &[u8]) -> Option<f64> {
    if crate::scan::says_missing(word) {
        return Some(f64::NAN);
    }
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The words of a line.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_stated_asked_for_or_mm() {
        let of = |stated, units: &[Unit]| {
            let options = TextOptions { units: units.to_vec(), ..TextOptions::default() };
            Lengths::of(Format::Stl, stated, &options).map(|lengths| (lengths.units, lengths.by))
        };
        assert_eq!(of(None, &[]), Ok(([Unit::Mm; 3], By::Default)));
        assert_eq!(of(None, &[Unit::Um]), Ok(([Unit::Um; 3], By::Options)));
        assert_eq!(of(Some(Unit::Mm), &[Unit::Mm]), Ok(([Unit::Mm; 3], By::Head)));
        let each = [Unit::Mm, Unit::Mm, Unit::Nm];
        assert_eq!(of(None, &each), Ok((each, By::Options)));
        assert!(of(Some(Unit::Mm), &each).unwrap_err().to_string().contains("leave `--unit` out"));
        assert!(of(None, &[Unit::Mm, Unit::Urad]).unwrap_err().to_string().contains("2 units"));
        assert!(of(None, &[Unit::Urad]).unwrap_err().to_string().contains("coordinates in urad"));
    }

    #[test]
    fn gaps_are_counted_and_infinities_refused() {
        let lengths = Lengths::of(Format::Obj, None, &TextOptions::default()).unwrap();
        let place = || Place::Byte(7);
        let mut points = Points::new(lengths);
        points.push([0.0, f64::NAN, 1.0], place).unwrap();
        points.push([0.0, 2.0, 1.0], place).unwrap();
        let error = points.push([0.0, 2.0, f64::INFINITY], place).unwrap_err();
        assert_eq!(
            error.to_string(),
            "OBJ file, byte 7: expected finite coordinates, found [0.0, 2.0, inf]"
        );
        let topography = points.finish([1, 2, 3], place()).unwrap();
        assert_eq!((topography.points().count(), topography.missing()), (1, 1));
        assert!(Points::new(lengths).finish([1, 2, 3], place()).is_err());
        assert!(check_count(Format::Obj, MAX_POINTS + 1, place).is_err());
    }
}
