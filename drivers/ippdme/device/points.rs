//! Points in the data of a command.

use asphera_link::{Flags, Nanos, Reading, Values};

use crate::settings::{Settings, is_scan};
use crate::wire::{Call, Data};

/// Reads points.
#[derive(Clone, Debug)]
pub(super) struct Points {
    columns: &'static [&'static str],
    quality_limit: Option<f64>,
}

impl Points {
    pub(super) fn new(settings: &Settings) -> Points {
        Points { columns: settings.columns(), quality_limit: settings.quality_limit }
    }

    /// Readings in data of a measuring command.
    ///
    /// # Errors
    ///
    /// Why the line as a whole is none.
    pub(super) fn readings(
        &self,
        now: Nanos,
        method: &str,
        data: &Data,
    ) -> Result<Vec<Reading>, String> {
        match (is_scan(method), data) {
            (true, Data::Numbers(numbers)) => {
                let (count, columns) = (numbers.len(), self.columns.len());
                if count % columns != 0 {
                    return Err(format!(
                        "{count} numbers in a line of {method}, expected a multiple of {columns}"
                    ));
                }
                let point = |numbers: &[f64]| {
                    let value = |name: &str| {
                        let column = self.columns.iter().position(|column| *column == name)?;
                        numbers.get(column).copied()
                    };
                    self.reading(now, value)
                };
                Ok(numbers.chunks_exact(columns).map(point).collect())
            }
            (false, Data::Items(items)) => Ok(vec![self.item_point(now, method, items)?]),
            (true, _) => Err(format!("data of {method} that are no bare numbers")),
            (false, _) => Err(format!("data of {method} that are no values with names")),
        }
    }

    fn item_point(&self, now: Nanos, method: &str, items: &[Call]) -> Result<Reading, String> {
        for name in self.columns {
            let same = items.iter().filter(|item| item.name == *name);
            let numbers: Option<Vec<Vec<f64>>> = same.map(Call::numbers).collect();
            match numbers.as_deref() {
                Some([]) => {}
                Some([one]) if one.len() == 1 => {}
                _ => return Err(format!("data of {method} without one number for {name}()")),
            }
        }
        let value = |name: &str| {
            let item = items.iter().find(|item| item.name == name)?;
            item.numbers()?.first().copied()
        };
        Ok(self.reading(now, value))
    }

    fn reading(&self, now: Nanos, value: impl Fn(&str) -> Option<f64>) -> Reading {
        let quality = self.quality_limit.map(|limit| (value("Q"), limit));
        let flags = match quality {
            None => Flags::empty(),
            Some((Some(q), limit)) if (0.0..=100.0).contains(&q) => {
                if q > limit {
                    Flags::WEAK
                } else {
                    Flags::empty()
                }
            }
            // A quality that is none says nothing of the point.
            Some(_) => Flags::SUSPECT,
        };
        let places = ["X", "Y", "Z"].map(&value).into_iter();
        let values: Values = places.chain(quality.map(|(q, _)| q)).collect();
        Reading { host: now, device_time_ns: None, count: None, values, flags }
    }
}
