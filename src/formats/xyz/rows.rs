//! Rows of numbers as points: of the lines of a text, or of an array.

use super::dialect::Field;
use super::head::Role;
use super::layout::{By, Layout};
use super::{Shown, malformed, too_large, unclear, unreadable};
use crate::{Cloud, Format, MAX_POINTS, ReadError, Source, Topography};

/// The rows read so far.
pub(super) struct Rows {
    cloud: Cloud,
    /// Whether the first column is 0, 1, 2, … or 1, 2, 3, …
    counts_lines: bool,
    /// Of slopes: which way x goes, by the last step.
    sense: f64,
}

impl Rows {
    pub(super) fn new(layout: &Layout, width: usize) -> Rows {
        let is_plain = layout.named_by == By::Default && width == 3;
        Rows { cloud: Cloud::default(), counts_lines: is_plain, sense: 0.0 }
    }

    /// How many points were taken, gaps left out.
    pub(super) fn points(&self) -> usize {
        self.cloud.points_mm.len()
    }

    /// Takes a row: `text` gives what stands in a column, and `number` what that means.
    pub(super) fn row<T: Shown + Copy>(
        &mut self,
        line: usize,
        layout: &Layout,
        text: impl Fn(usize) -> T,
        mut number: impl FnMut(T) -> Field,
    ) -> Result<(), ReadError> {
        let cloud = &mut self.cloud;
        let count = (cloud.points_mm.len() + cloud.missing) as u64;
        if count >= MAX_POINTS {
            return Err(too_large(line, count + 1));
        }
        let (mut place, mut z, mut gaps) = ([Some(0.0); 2], None, 0);
        for slot in &layout.slots {
            let text = text(slot.column);
            let value = match number(text) {
                Field::Number(value) => {
                    let scaled = Some(slot.unit.scaled(value)).filter(|scaled| scaled.is_finite());
                    Some(scaled.ok_or_else(|| unreadable(line, slot, &text))?)
                }
                Field::Missing => None,
                // The uncertainty of a height that nobody weighs by may be anything.
                Field::Unreadable if slot.role == Role::Uncertainty => None,
                Field::Unreadable => return Err(unreadable(line, slot, &text)),
            };
            match slot.role {
                Role::X => place[0] = value,
                Role::Y => place[1] = value,
                Role::Z | Role::Slope => z = value,
                Role::Uncertainty => cloud.uncertainties_mm.push(value.unwrap_or(f64::NAN)),
            }
            gaps += usize::from(value.is_none() && slot.role != Role::Uncertainty);
        }
        let has_uncertainty = layout.slots.iter().any(|slot| slot.role == Role::Uncertainty);
        let asked = layout.slots.len() - usize::from(has_uncertainty);
        let ([Some(x), Some(y)], Some(z)) = (place, z) else {
            // A place without a height is a gap, and so is a line without either.
            if z.is_none() && (gaps == 1 || gaps == asked) {
                if layout.has_slopes() {
                    let expected = "a slope, for heights are not integrated over a gap";
                    return Err(malformed(line, 0, expected, "none".into()));
                }
                cloud.missing += 1;
                if has_uncertainty {
                    cloud.uncertainties_mm.pop();
                }
                return Ok(());
            }
            let slot = layout.slots.iter().find(|slot| {
                slot.role != Role::Uncertainty
                    && matches!(number(text(slot.column)), Field::Missing)
            });
            let slot = slot.unwrap_or(&layout.slots[0]);
            return Err(unreadable(line, slot, &text(slot.column)));
        };
        let at = cloud.points_mm.len() as f64;
        self.counts_lines &=
            cloud.points_mm.first().map_or(x == 0.0 || x == 1.0, |first| x == first[0] + at);
        if !layout.has_slopes() {
            cloud.points_mm.push([x, y, z]);
            return Ok(());
        }
        if let Some([last_mm, ..]) = cloud.points_mm.last() {
            let step_mm = x - last_mm;
            if step_mm == 0.0 || step_mm * self.sense < 0.0 {
                let found = format!("x {x} after {last_mm}, mm");
                return Err(malformed(line, 0, "slopes in order of x, to be integrated", found));
            }
            self.sense = step_mm;
        }
        cloud.slopes.push(z);
        cloud.points_mm.push([x, y, 0.0]);
        Ok(())
    }

    /// All rows as a cloud; `first` is the line of the first one.
    pub(super) fn finish(
        self,
        first: usize,
        layout: &Layout,
        has_decimal_commas: bool,
    ) -> Result<Topography, ReadError> {
        let Rows { mut cloud, counts_lines, .. } = self;
        if counts_lines && cloud.points_mm.len() > 2 && cloud.missing == 0 {
            let found =
                "the first of three columns without names counts the lines, as an index does";
            return Err(unclear(
                first,
                found,
                "add `--columns` with the columns of x, y, z, or of a profile x, z",
            ));
        }
        if cloud.points_mm.is_empty() && cloud.missing > 1 {
            let found =
                format!("no line has all of x, y and z; {} lack one or more", cloud.missing);
            return Err(unclear(
                first,
                found,
                "add `--columns` with the columns that hold them, of a curve in the plane x and y",
            ));
        }
        integrate(&mut cloud);
        let taken = Some(layout.taken(has_decimal_commas));
        Ok(Topography::Cloud(cloud, Source { taken, ..Source::new(Format::Xyz) }))
    }
}

/// Heights of slopes by the trapezoidal rule, in the order of the lines, from 0 at the first.
fn integrate(Cloud { points_mm, slopes, .. }: &mut Cloud) {
    for index in 1..slopes.len() {
        let step_mm = points_mm[index][0] - points_mm[index - 1][0];
        let rise_mm = 0.5 * (slopes[index - 1] + slopes[index]) * step_mm;
        points_mm[index][2] = points_mm[index - 1][2] + rise_mm;
    }
}
